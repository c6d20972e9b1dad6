//! From a [`Study`] to what a person looks at: page, pictures, tables and the summary for machines. Nothing is computed
//! here.

pub mod page;

mod causes;
mod claims;
mod contact_scenes;
mod convergence;
mod coverage;
mod curves;
mod directions;
mod displacement_noise;
mod drawings;
mod hard_cases;
mod lattice;
mod maps;
mod networks;
mod pairs;
mod recipes;
mod scatter;
mod sections;
mod speed_error;
mod summary;
mod table_two;
mod tables;
mod twin;
mod verdict;
mod words;

pub use causes::{CauseRow, CauseSummary};
pub use directions::{DirectionRow, FrictionlessRow};
pub use drawings::{map_picture, standalone};
pub use lattice::{AxialSpringsRow, LatticeRow, SettlingRow};
pub use maps::ExplanationRow;
pub use networks::NetworkRow;
pub use pairs::PairRow;
pub use summary::Summary;
pub use table_two::TableTwoRow;
pub use twin::{CalibrationRow, TwinRow, ZoneSetRow};

use crate::claims::Claim;
use crate::figures::FigureError;
use crate::study::Study;
use std::path::PathBuf;

/// Why a report could not be put together.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A figure could not be drawn.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The page could not be filled in.
    #[error("page: {0}")]
    Page(#[from] minijinja::Error),
    /// A table could not be written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The summary could not be written.
    #[error("summary: {0}")]
    Summary(#[from] serde_json::Error),
}

/// The files of a report, by name within its folder: `index.html`, `summary.json` and a CSV behind every figure.
///
/// # Errors
/// [`ReportError`] if a figure has nothing to draw.
pub fn files(study: &Study, claims: &[Claim]) -> Result<Vec<(PathBuf, String)>, ReportError> {
    let mut files = tables::csv_files(study, claims)?;
    let summary = Summary::of(study, claims);
    files.push(("summary.json".into(), serde_json::to_string_pretty(&summary)? + "\n"));
    let page = sections::page(study, claims, &summary)?;
    files.push(("index.html".into(), page::render(&page)?));
    Ok(files)
}
