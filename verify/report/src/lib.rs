//! From a [`Study`] to page, figures, tables and the summary for machines. Nothing is computed here.
#![forbid(unsafe_code)]

mod answers;
mod camera;
mod causes;
mod checks;
pub mod claims;
mod contact_scenes;
mod convergence;
pub mod dataset;
mod directions;
mod displacement_noise;
pub mod drawings;
mod estimators;
pub mod explore;
mod finger;
pub mod format;
mod grasp;
mod hard_cases;
pub mod lattice;
pub mod maps;
pub mod measured;
mod networks;
pub mod page;
mod pairs;
mod prelude;
mod scatter;
mod sections;
mod shapes;
pub mod speed_error;
mod table_one;
pub mod table_two;
mod times;
pub mod trainings;
mod trust;
pub mod twin;
mod words;

pub use contact_scenes::{DrawnPress, press_svg};
pub use drawings::{map_figure_svg, standalone};
pub use grasp::{grasp_animation_svg, grasp_svg};

use dataset::Dataset;
use finray_figures::FigureError;
use finray_studies::claims::Claim;
use finray_studies::study::Study;
use std::path::PathBuf;

/// Version of finray that makes the report.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Why a report could not be put together.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A figure could not be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The page could not be filled in.
    #[error("page: {0}")]
    Page(#[from] minijinja::Error),
    /// The sentences of the page are no templates.
    #[error("words of the page: {0}")]
    Words(String),
    /// A table could not be written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The summary could not be written.
    #[error("summary: {0}")]
    Summary(#[from] serde_json::Error),
}

/// What a report is made from.
#[derive(Clone, Copy)]
struct Results<'s> {
    study: &'s Study,
    claims: &'s [Claim],
}

/// A report, ready to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Name within the folder and text: `index.html`, `summary.json` and a CSV behind every figure.
    pub files: Vec<(PathBuf, String)>,
    /// What the numbers say: the head of the page, then what its sections say.
    pub verdict: Vec<String>,
}

/// Puts the report on a study together.
///
/// # Errors
/// [`ReportError`] if a figure has nothing to draw.
pub fn report(study: &Study, claims: &[Claim]) -> Result<Report, ReportError> {
    let results = Results { study, claims };
    let page = sections::page(results)?;
    let data = sections::datasets(results);
    let says = page.questions.iter().flat_map(|question| &question.sections).flat_map(|section| &section.says);
    let answers = page.answers.iter().map(|it| format!("{} {}", it.question, it.answer));
    let verdict: Vec<String> = answers.chain(says.cloned()).chain([page.caveat.clone()]).collect();
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    for dataset in &data {
        files.extend(dataset.csv()?.map(|(name, text)| (name.into(), text)));
    }
    files.push(("summary.json".into(), summary(&study.scene, &verdict, &data)?));
    files.push(("index.html".into(), page::render(&page)?));
    Ok(Report { files, verdict })
}

/// `summary.json`: every figure that the page shows, for machines. Arrays come as their datasets write them.
fn summary(scene: &str, verdict: &[String], data: &[Dataset]) -> Result<String, ReportError> {
    let mut fields = vec![
        ("scene", serde_json::to_string(scene)?),
        ("version", serde_json::to_string(VERSION)?),
        ("verdict", serde_json::to_string_pretty(verdict)?),
    ];
    for dataset in data {
        fields.extend(dataset.json()?);
    }
    // No JSON text holds a line break that is not its layout.
    let fields = fields.into_iter().map(|(key, text)| format!("  \"{key}\": {}", text.replace('\n', "\n  ")));
    Ok(format!("{{\n{}\n}}\n", fields.collect::<Vec<_>>().join(",\n")))
}
