//! Records of networks whose training takes too long for a report: errors of three recipes, and error against number of samples and network size.
//!
//! `fixtures/networks` contains the records; the example `shipped_networks` computes them.

use crate::truths::TruthId;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Errors of one quantity for a network with one recipe and seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecipeRow {
    /// Name of the recipe. `a` is the paper's recipe: the linear finger without noise, and inputs scaled by the largest displacement. `a, by spread`
    /// is `a` with inputs scaled by their spread; `b` is `a` with noise. `c` uses the co-rotational finger with noise, principal directions and a
    /// linear branch.
    pub recipe: String,
    /// Seed of the training.
    pub seed: u64,
    /// Type of the true finger: linear or co-rotational.
    pub truth: TruthId,
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// Contact nodes, separated by spaces.
    pub nodes: String,
    /// Quantity: `each force` or `sum`.
    pub quantity: String,
    /// Number of answered cases.
    pub cases: usize,
    /// Number of cases that the network refused.
    pub refused: usize,
    /// Mean of |sensed / true - 1|; `None` if no case was answered.
    pub mean_error: Option<f64>,
}

/// Error of one network, as a point of a curve of error against training cases or network size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveRow {
    /// Name of the curve: `samples` or `size`.
    pub curve: String,
    /// Contact nodes, separated by spaces.
    pub nodes: String,
    /// Number of training cases.
    pub samples: usize,
    /// Widths of the hidden layers, such as `32-32`; `none` for linear regression alone.
    pub hidden_layers: String,
    /// Number of trained parameters.
    pub weights: usize,
    /// Seed of the training.
    pub seed: u64,
    /// Number of answered cases.
    pub cases: usize,
    /// Mean relative error of each force; `None` if no case was answered.
    pub mean_error: Option<f64>,
    /// Mean relative error of each force for an estimator that reaches the Cramer-Rao bound.
    pub mean_error_bound: Option<f64>,
}

/// All records of trainings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Records {
    /// Errors of the three recipes.
    pub recipes: Vec<RecipeRow>,
    /// Errors against number of samples and network size.
    pub curves: Vec<CurveRow>,
}

impl Records {
    /// The records that are embedded in the binary.
    ///
    /// # Errors
    /// [`csv::Error`] if a record cannot be read.
    pub fn shipped() -> Result<Records, csv::Error> {
        Ok(Records { recipes: rows(finray_fixtures::RECIPES)?, curves: rows(finray_fixtures::CURVES)? })
    }
}

fn rows<T: DeserializeOwned>(text: &str) -> Result<Vec<T>, csv::Error> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().collect()
}
