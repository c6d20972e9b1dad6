//! The table formats of a sweep.

use super::{Cell, MapCell};
use crate::prelude::*;
use crate::truths::TruthId;
use finray_files::csv_text;

/// Table format, which determines the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Table {
    /// One accuracy map. True finger, estimator and noise level are constant and have no column.
    Map,
    /// All results of each cell.
    Sweep,
}

#[derive(Serialize)]
struct Row {
    truth: TruthId,
    estimator: EstimatorId,
    noise_mm: f64,
    s_mm: f64,
    angle_deg: f64,
    force_n: f64,
    samples: usize,
    answered: usize,
    mean_error: Option<f64>,
    bias: Option<f64>,
    spread: Option<f64>,
    sigma_n: Option<f64>,
    refusal: Option<String>,
    warned: Option<usize>,
    covered: Option<usize>,
    covered_warned: Option<usize>,
}

impl Table {
    /// Line of column names, with its line end.
    pub fn header(self) -> &'static str {
        match self {
            Table::Map => {
                "s_mm,angle_deg,force_n,mean_error,bias,spread,samples,answered,warned,covered,covered_warned\n"
            }
            Table::Sweep => {
                "truth,estimator,noise_mm,s_mm,angle_deg,force_n,samples,answered,mean_error,bias,spread,sigma_n,refusal,\
                 warned,covered,covered_warned\n"
            }
        }
    }

    /// Rows of the cells as CSV without header, one line each.
    pub(super) fn rows(self, cells: &[Cell]) -> Result<String, csv::Error> {
        let text = match self {
            Table::Map => csv_text(cells.iter().map(MapCell::from))?,
            Table::Sweep => csv_text(cells.iter().map(Row::of))?,
        };
        debug_assert!(text.starts_with(self.header()));
        Ok(text[self.header().len()..].to_owned())
    }
}

impl Row {
    fn of(cell: &Cell) -> Row {
        let outcome = &cell.outcome;
        Row {
            truth: cell.truth,
            estimator: cell.estimator,
            noise_mm: cell.noise_mm,
            s_mm: cell.s_mm,
            angle_deg: cell.angle_deg,
            force_n: cell.force_n,
            samples: outcome.samples,
            answered: outcome.answered,
            mean_error: outcome.errors.map(|errors| errors.mean_error),
            bias: outcome.errors.map(|errors| errors.bias),
            spread: cell.spread(),
            sigma_n: outcome.errors.and_then(|errors| errors.sigma_n),
            // Rows are counted by line ends, so a text must not contain one.
            refusal: outcome.refusal.as_ref().map(|text| text.split_whitespace().collect::<Vec<_>>().join(" ")),
            warned: outcome.covered.map(|covered| covered.warned),
            covered: outcome.covered.map(|covered| covered.covered),
            covered_warned: outcome.covered.map(|covered| covered.covered_warned),
        }
    }
}
