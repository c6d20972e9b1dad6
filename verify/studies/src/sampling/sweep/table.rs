//! The table formats of a sweep.

use super::{Cell, MapCell};
use crate::prelude::*;
use finray_files::csv_text;

/// Table format, which determines the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Table {
    /// One accuracy map. In a map, true finger, estimator and noise level are constant and have no column.
    Map,
    /// All results of each cell.
    Sweep,
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
            Table::Sweep => csv_text(cells)?,
        };
        debug_assert!(text.starts_with(self.header()));
        Ok(text[self.header().len()..].to_owned())
    }
}
