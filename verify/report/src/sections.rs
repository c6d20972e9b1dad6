//! All sections of the report. Each contributes to the page, the CSV files and the summary.

use super::dataset::Dataset;
use super::page::{Page, Question, Section};
use super::{
    ReportError, Results, answers, camera, causes, checks, claims, contact_scenes, convergence, directions,
    displacement_noise, estimators, explore, finger, grasp, hard_cases, lattice, maps, measured, networks, pairs,
    scatter, shapes, speed_error, table_one, table_two, times, trust, twin,
};

/// A section: its question, its part of the page (`None` if the scene has no such study), and its data.
struct Entry(Asked, fn(Results) -> Result<Option<Section>, ReportError>, for<'s> fn(Results<'s>) -> Vec<Dataset<'s>>);

/// Questions of the reader, in the order in which the page answers them.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Asked {
    Where,
    Fix,
    Which,
    Physics,
    Paper,
}

impl Asked {
    const ALL: [Asked; 5] = [Asked::Where, Asked::Fix, Asked::Which, Asked::Physics, Asked::Paper];

    /// Anchor of the question for links, and its heading.
    fn names(self) -> [&'static str; 2] {
        match self {
            Asked::Where => ["where", "Where"],
            Asked::Fix => ["fix", "What to fix first"],
            Asked::Which => ["which", "Which estimator"],
            Asked::Physics => ["physics", "Is it right"],
            Asked::Paper => ["paper", "The paper"],
        }
    }
}

/// Every section, in the order of the page. A new section needs its experiment, its file in this folder, and a row here.
const SECTIONS: &[Entry] = &[
    Entry(Asked::Where, maps::section, maps::datasets),
    Entry(Asked::Where, pairs::section, pairs::datasets),
    Entry(Asked::Where, directions::section, directions::datasets),
    Entry(Asked::Where, contact_scenes::section, contact_scenes::datasets),
    Entry(Asked::Where, grasp::section, grasp::datasets),
    Entry(Asked::Where, measured::section, measured::datasets),
    Entry(Asked::Fix, causes::section, causes::datasets),
    Entry(Asked::Fix, camera::section, camera::datasets),
    Entry(Asked::Fix, displacement_noise::section, displacement_noise::datasets),
    Entry(Asked::Which, estimators::section, estimators::datasets),
    Entry(Asked::Which, scatter::section, scatter::datasets),
    Entry(Asked::Which, speed_error::section, speed_error::datasets),
    Entry(Asked::Which, convergence::section, convergence::datasets),
    Entry(Asked::Which, networks::section, networks::datasets),
    Entry(Asked::Physics, checks::section, checks::datasets),
    Entry(Asked::Physics, claims::section, claims::datasets),
    Entry(Asked::Physics, lattice::section, lattice::datasets),
    Entry(Asked::Physics, hard_cases::section, hard_cases::datasets),
    Entry(Asked::Physics, shapes::section, shapes::datasets),
    Entry(Asked::Physics, finger::section, finger::datasets),
    Entry(Asked::Physics, times::section, times::datasets),
    Entry(Asked::Paper, table_two::section, table_two::datasets),
    Entry(Asked::Paper, table_one::section, table_one::datasets),
    Entry(Asked::Paper, twin::section, twin::datasets),
];

/// Datasets of all sections.
pub(super) fn datasets(results: Results) -> Vec<Dataset> {
    let first = trust::datasets(results.study);
    first.into_iter().chain(SECTIONS.iter().flat_map(|Entry(.., datasets)| datasets(results))).collect()
}

/// The page with all its sections.
pub(super) fn page(results: Results) -> Result<Page, ReportError> {
    let study = results.study;
    let mut questions = Vec::new();
    for asked in Asked::ALL {
        let [id, heading] = asked.names().map(str::to_owned);
        let of_question = SECTIONS.iter().filter(|Entry(of, ..)| *of == asked);
        let sections = of_question.filter_map(|Entry(_, section, _)| section(results).transpose());
        let sections = sections.collect::<Result<Vec<_>, _>>()?;
        // A question is left out if the scene has no study that answers it.
        if !sections.is_empty() {
            questions.push(Question { id, heading, sections });
        }
    }
    Ok(Page {
        title: format!("Where the finger \"{}\" senses forces", study.scene),
        subtitle: "Contact forces sensed through the finger's own deformation, in simulation.".to_owned(),
        answers: answers::answers(study)?,
        caveat: answers::caveat(study)?,
        lead: trust::figures(results)?,
        lead_caption: trust::caption(study)?,
        explore: Some(explore::data(results)),
        questions,
        footer: format!(
            "Made by finray {}. Every figure names its data; they and summary.json lie beside this page.",
            super::VERSION
        ),
    })
}
