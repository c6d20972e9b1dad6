//! The sections of the report, and what follows from them: the page, the CSV files and the arrays of the summary.

use super::dataset::Dataset;
use super::page::{Page, Question, Section};
use super::{
    ReportError, Results, causes, checks, claims, contact_scenes, convergence, coverage, directions,
    displacement_noise, finger, hard_cases, lattice, maps, networks, pairs, scatter, shapes, speed_error, table_one,
    table_two, twin, verdict,
};

/// A section: the question that it answers, its part of the page (`None` where a scene has no such study), and its data.
struct Entry(Asked, fn(Results) -> Result<Option<Section>, ReportError>, for<'s> fn(Results<'s>) -> Vec<Dataset<'s>>);

/// The questions of the reader, in the order of the page.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Asked {
    Where,
    Why,
    Cost,
    Physics,
}

impl Asked {
    const ALL: [Asked; 4] = [Asked::Where, Asked::Why, Asked::Cost, Asked::Physics];

    /// Anchor and heading.
    fn names(self) -> [&'static str; 2] {
        match self {
            Asked::Where => ["where", "Where"],
            Asked::Why => ["why", "Why"],
            Asked::Cost => ["cost", "What it costs"],
            Asked::Physics => ["physics", "Is the physics right"],
        }
    }
}

/// Every section, in the order of the page. To add one: its experiment, its file in this folder, a row here.
const SECTIONS: &[Entry] = &[
    Entry(Asked::Where, maps::section, maps::datasets),
    Entry(Asked::Where, coverage::section, coverage::datasets),
    Entry(Asked::Where, scatter::section, scatter::datasets),
    Entry(Asked::Where, displacement_noise::section, displacement_noise::datasets),
    Entry(Asked::Where, pairs::section, pairs::datasets),
    Entry(Asked::Where, directions::section, directions::datasets),
    Entry(Asked::Where, table_two::section, table_two::datasets),
    Entry(Asked::Where, contact_scenes::section, contact_scenes::datasets),
    Entry(Asked::Why, causes::section, causes::datasets),
    Entry(Asked::Why, shapes::section, shapes::datasets),
    Entry(Asked::Why, table_one::section, table_one::datasets),
    Entry(Asked::Why, twin::section, twin::datasets),
    Entry(Asked::Cost, speed_error::section, speed_error::datasets),
    Entry(Asked::Cost, convergence::section, convergence::datasets),
    Entry(Asked::Cost, networks::section, networks::datasets),
    Entry(Asked::Physics, checks::section, checks::datasets),
    Entry(Asked::Physics, lattice::section, lattice::datasets),
    Entry(Asked::Physics, hard_cases::section, hard_cases::datasets),
    Entry(Asked::Physics, claims::section, claims::datasets),
    Entry(Asked::Physics, finger::section, finger::datasets),
];

/// The data of all sections.
pub(super) fn datasets(results: Results) -> Vec<Dataset> {
    SECTIONS.iter().flat_map(|Entry(.., datasets)| datasets(results)).collect()
}

/// The whole page.
pub(super) fn page(results: Results) -> Result<Page, ReportError> {
    let study = results.study;
    let mut questions = Vec::new();
    for asked in Asked::ALL {
        let [id, heading] = asked.names().map(str::to_owned);
        let of_question = SECTIONS.iter().filter(|Entry(of, ..)| *of == asked);
        let sections = of_question.filter_map(|Entry(_, section, _)| section(results).transpose());
        questions.push(Question { id, heading, sections: sections.collect::<Result<_, _>>()? });
    }
    Ok(Page {
        title: format!("Where the finger \"{}\" can feel", study.scene),
        subtitle: format!(
            "Force sensing through the finger's own deformation: where it can be trusted, why not elsewhere, at which cost. {}",
            checks::in_short(study)
        ),
        verdict: verdict::sentences(study),
        lead: verdict::lead(study)?,
        questions,
        footer: format!(
            "Made by finray {}. Every figure names its data; summary.json beside this page has all numbers.",
            super::VERSION
        ),
    })
}
