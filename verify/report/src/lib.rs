//! Turns a [`Study`] into pages, figures, tables and a machine-readable summary. Nothing is simulated here.
#![forbid(unsafe_code)]

mod answers;
mod camera;
mod causes;
mod changes;
mod checks;
mod contact_scenes;
pub mod dataset;
pub mod drawings;
mod estimators;
pub mod explore;
mod finger;
pub mod format;
mod grasp;
mod gripper_tests;
pub mod maps;
pub mod measured;
mod networks;
pub mod page;
mod pairs;
mod places;
mod prelude;
mod push;
mod recorded;
mod scatter;
mod sections;
mod shapes;
mod times;
pub mod trainings;
mod trust;

pub use contact_scenes::{DrawnPress, press_svg};
pub use drawings::{map_figure_svg, standalone};
pub use grasp::{grasp_animation_svg, grasp_svg};

use dataset::Dataset;
use finray_figures::FigureError;
use finray_studies::study::Study;
use std::path::PathBuf;

/// Version of finray that makes the report.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Reason why a report cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A figure could not be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The page could not be rendered.
    #[error("cannot render the page: {0}")]
    Page(#[from] minijinja::Error),
    /// A table could not be written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The WebAssembly program of the finger that the reader can push could not be compressed.
    #[error("cannot compress a program: {0}")]
    Program(#[from] std::io::Error),
    /// The summary could not be written.
    #[error("cannot write the summary: {0}")]
    Summary(#[from] serde_json::Error),
}

/// The study from which a report is made.
#[derive(Clone, Copy)]
struct Results<'s> {
    study: &'s Study,
}

/// The files of a report, not yet written to disk.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Relative path and text of each file: `index.html` and the other pages, `summary.json`, the drawing `finger.svg`, and the CSV files with the numbers of the figures.
    pub files: Vec<(PathBuf, String)>,
    /// Conclusions: the answers on the first page, the conclusions of all sections, and the assumptions of the answers.
    pub verdict: Vec<String>,
    /// The short verdict of the first page, a line each: the unknown contact first.
    pub short: Vec<String>,
}

/// Makes the report of a study.
///
/// # Errors
/// [`ReportError`] if a figure has nothing to draw, or a page or table cannot be written.
pub fn report(study: &Study) -> Result<Report, ReportError> {
    let results = Results { study };
    let pages = sections::pages(results)?;
    let data = sections::datasets(results)?;
    let first = pages.iter().find_map(|(_, page)| page.first.as_ref());
    let rows = first.iter().flat_map(|first| &first.verdict).map(|row| row.join(": "));
    let short: Vec<String> = first.iter().map(|first| first.headline.join(" ")).chain(rows).collect();
    let answers = first.iter().flat_map(|first| &first.answers).map(|it| it.join(" "));
    let says = pages.iter().flat_map(|(_, page)| &page.sections).flat_map(|section| &section.says);
    let caveat = first.map(|first| first.caveat.clone());
    let verdict: Vec<String> = answers.chain(says.cloned()).chain(caveat).collect();
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    for dataset in &data {
        files.extend(dataset.csv()?.map(|(name, text)| (name.into(), text)));
    }
    files.push(("finger.svg".into(), standalone(&drawings::finger(study)?)));
    files.push(("summary.json".into(), summary(&study.scene, [&short[..], &verdict[..]], &data)?));
    for (file, page) in &pages {
        files.push((file.into(), page::render(page)?));
    }
    Ok(Report { files, verdict, short })
}

/// Text of `summary.json`, which has the scene, the version, the short and the full verdict, and the arrays of the datasets. Each dataset writes its array.
fn summary(scene: &str, [short, verdict]: [&[String]; 2], data: &[Dataset]) -> Result<String, ReportError> {
    let mut fields = vec![
        ("scene", serde_json::to_string(scene)?),
        ("version", serde_json::to_string(VERSION)?),
        ("short", serde_json::to_string_pretty(short)?),
        ("verdict", serde_json::to_string_pretty(verdict)?),
    ];
    for dataset in data {
        fields.extend(dataset.json()?);
    }
    // A line break in JSON text is never part of a value, so lines can be indented.
    let fields = fields.into_iter().map(|(key, text)| format!("  \"{key}\": {}", text.replace('\n', "\n  ")));
    Ok(format!("{{\n{}\n}}\n", fields.collect::<Vec<_>>().join(",\n")))
}
