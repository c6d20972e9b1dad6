//! Records of trainings that take too long for a report: three recipes, and error against samples and size.
//!
//! `fixtures/networks` holds them with the command that makes them again.

use crate::experiments::{Context, Evidence};
use crate::truths::TruthId;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Errors of one quantity by the network of one recipe and one seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecipeRow {
    /// `a`, the paper's: linear, without noise, inputs by the largest displacement; `a, by spread`; `b`: `a` with noise; `c`:
    /// co-rotational with noise, principal directions and a linear branch.
    pub recipe: String,
    /// Seed of the training.
    pub seed: u64,
    /// The true finger, linear or co-rotational.
    pub truth: TruthId,
    /// Standard deviation of one coordinate, mm.
    pub noise_mm: f64,
    /// Contact nodes, by spaces.
    pub nodes: String,
    /// `each force` or `sum`.
    pub quantity: String,
    /// Cases that were sensed.
    pub cases: usize,
    /// Cases that the network refused.
    pub refused: usize,
    /// Mean of |sensed / true - 1|; `None` if no case was sensed.
    pub mean_error: Option<f64>,
}

/// One network of a curve of error against samples, or against size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveRow {
    /// `samples` or `size`.
    pub curve: String,
    /// Contact nodes, by spaces.
    pub nodes: String,
    /// Training cases.
    pub samples: usize,
    /// Widths of the hidden layers, `32-32`; `none` for linear regression alone.
    pub hidden_layers: String,
    /// Trained numbers.
    pub weights: usize,
    /// Seed of the training.
    pub seed: u64,
    /// Cases that were sensed.
    pub cases: usize,
    /// Mean error of each force; `None` if no case was sensed.
    pub mean_error: Option<f64>,
    /// Mean error of an estimator that reaches the Cramer-Rao bound.
    pub mean_error_bound: Option<f64>,
}

/// All records.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Records {
    /// Three recipes side by side.
    pub recipes: Vec<RecipeRow>,
    /// Error against samples and size.
    pub curves: Vec<CurveRow>,
}

impl Evidence for Records {}

/// The records, for the paper's finger.
pub(crate) fn run(context: &Context) -> Result<Records, csv::Error> {
    if context.is_paper { Records::shipped() } else { Ok(Records::default()) }
}

impl Records {
    /// The records that travel inside the binary.
    ///
    /// # Errors
    /// [`csv::Error`] if one does not read: a fault of the build.
    pub fn shipped() -> Result<Records, csv::Error> {
        Ok(Records { recipes: rows(finray_fixtures::RECIPES)?, curves: rows(finray_fixtures::CURVES)? })
    }
}

fn rows<T: DeserializeOwned>(text: &str) -> Result<Vec<T>, csv::Error> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().collect()
}
