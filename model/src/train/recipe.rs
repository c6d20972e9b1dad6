//! Recipe of a network: training samples and schedule.

use super::TrainError;
use crate::Kinematics;
use crate::finger::Finger;
use crate::samples::{SampleRecipe, SamplesError};
use crate::sensing::Contact;
use crate::sensing::network::Scaling;

/// Cases that are held out for validation, and again for the test, as a share of the training cases, and how many at most.
const HELD_OUT_SHARE: usize = 5;
const MOST_HELD_OUT: usize = 4000;

/// Samples, network and schedule.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingRecipe {
    /// How load cases are drawn.
    pub samples: SampleRecipe,
    /// Number of training cases.
    pub count: usize,
    /// Standard deviation of one measured coordinate in training, mm; drawn anew in every epoch.
    pub noise_mm: f64,
    /// How displacements become inputs.
    pub scaling: Scaling,
    /// Widths of the hidden layers.
    pub hidden_layers: Vec<usize>,
    /// Whether a linear branch stands beside the layers, started from least squares.
    pub linear_branch: bool,
    /// Most passes through the training cases.
    pub epochs: usize,
    /// Cases a step.
    pub batch: usize,
    /// Adam's first step length; it falls to zero along half a cosine.
    pub learning_rate: f64,
    /// Training stops when this many epochs in a row have not lowered the validation loss.
    pub patience: usize,
    /// Seed of everything random.
    pub seed: u64,
}

impl TrainingRecipe {
    /// The paper's network, 150-200-150 on 20 000 noise-free cases of the linear finger (sec. IV-A of Xu et al. 2021).
    /// The paper names neither scaling nor schedule: here the largest displacement becomes 1, and the schedule is ours.
    pub fn paper(contacts: Vec<Contact>) -> TrainingRecipe {
        TrainingRecipe {
            samples: SampleRecipe::paper(contacts, Kinematics::Linear),
            count: 20_000,
            noise_mm: 0.0,
            scaling: Scaling::Largest,
            hidden_layers: vec![150, 200, 150],
            linear_branch: false,
            epochs: 60,
            batch: 256,
            learning_rate: 1e-3,
            patience: 20,
            seed: 1,
        }
    }

    /// The paper's network with the camera's noise on its inputs.
    pub fn paper_with_noise(contacts: Vec<Contact>, noise_mm: f64) -> TrainingRecipe {
        TrainingRecipe { noise_mm, ..TrainingRecipe::paper(contacts) }
    }

    /// The inverse of the nonlinear finger: co-rotational cases with noise, principal directions as inputs, a linear
    /// branch. Two layers of 32 keep the error of the paper's three (see the report's curve of error against size).
    pub fn nonlinear(contacts: Vec<Contact>, noise_mm: f64) -> TrainingRecipe {
        TrainingRecipe {
            samples: SampleRecipe::paper(contacts, Kinematics::Corotational),
            noise_mm,
            scaling: Scaling::Principal,
            hidden_layers: vec![32, 32],
            linear_branch: true,
            epochs: 100,
            learning_rate: 2e-3,
            ..TrainingRecipe::paper(Vec::new())
        }
    }

    /// As [`TrainingRecipe::nonlinear`], for any of the contacts: every subset is a question, so more cases, wider layers.
    pub fn any_of(contacts: Vec<Contact>, noise_mm: f64) -> TrainingRecipe {
        TrainingRecipe {
            samples: SampleRecipe { any_of: true, ..SampleRecipe::paper(contacts, Kinematics::Corotational) },
            count: 100_000,
            hidden_layers: vec![128, 128],
            epochs: 60,
            ..TrainingRecipe::nonlinear(Vec::new(), noise_mm)
        }
    }

    /// Standard deviation of the forces that a subset's ridge forces assume, N: of forces spread evenly from zero.
    pub(super) fn prior_n(&self) -> f64 {
        self.samples.largest_force_n / f64::sqrt(3.0)
    }

    /// Number of cases for validation, and again for the test.
    pub(super) fn held_out(&self) -> usize {
        (self.count / HELD_OUT_SHARE).clamp(1, MOST_HELD_OUT)
    }

    pub(super) fn check(&self, finger: &Finger) -> Result<(), TrainError> {
        let require = |holds: bool, key: &'static str, expected: &'static str, found: &dyn std::fmt::Debug| match holds
        {
            true => Ok(()),
            false => Err(TrainError::Recipe { key, expected, found: format!("{found:?}") }),
        };
        self.samples.check().map_err(|error| match error {
            SamplesError::Recipe { key, expected, found } => TrainError::Recipe { key, expected, found },
            other => other.into(),
        })?;
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let not_negative = |x: f64| x.is_finite() && x >= 0.0;
        require(not_negative(self.noise_mm), "noise_mm", "mm, zero or more", &self.noise_mm)?;
        // One case has no spread to scale by.
        require(self.count > 1, "count", "at least two cases", &self.count)?;
        require(!self.hidden_layers.contains(&0), "hidden_layers", "widths above zero", &self.hidden_layers)?;
        require(self.epochs > 0 && self.batch > 0, "epochs, batch", "at least one", &(self.epochs, self.batch))?;
        require(positive(self.learning_rate), "learning_rate", "a positive number", &self.learning_rate)?;
        let seen = self.samples.markers(finger).len();
        require(2 * seen >= self.samples.contacts.len() && seen > 0, "hidden", "as many coordinates as contacts", &seen)
    }
}
