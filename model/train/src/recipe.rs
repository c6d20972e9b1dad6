//! Recipe of a network: training samples, architecture and schedule.

use crate::samples::{SampleRecipe, SamplesError, require};
use finray_model::Kinematics;
use finray_model::finger::Finger;
use finray_model::sensing::Contact;
use finray_model::sensing::network::Scaling;

/// One validation case and one test case are drawn for this number of training cases, up to `MOST_HELD_OUT` cases of each kind.
const HELD_OUT_SHARE: usize = 5;
const MOST_HELD_OUT: usize = 4000;

/// Samples, architecture and training schedule of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingRecipe {
    /// Distribution of the load cases.
    pub samples: SampleRecipe,
    /// Number of training cases.
    pub count: usize,
    /// Standard deviation of the noise of one measured coordinate in training, mm; each epoch draws new noise.
    pub noise_mm: f64,
    /// Normalisation of displacements to inputs.
    pub scaling: Scaling,
    /// Widths of the hidden layers.
    pub hidden_layers: Vec<usize>,
    /// Whether a linear branch is added to the layers. The branch starts from least squares.
    pub linear_branch: bool,
    /// Largest number of passes through the training cases.
    pub epochs: usize,
    /// Number of training cases per step of Adam.
    pub batch: usize,
    /// Initial learning rate of Adam, dimensionless. The rate falls along half a period of a cosine.
    pub learning_rate: f64,
    /// Training stops after this number of consecutive epochs without a lower validation loss.
    pub patience: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl TrainingRecipe {
    /// The network of Xu et al. (2021, sec. IV-A): hidden layers of 150, 200 and 150 neurons, trained on 20 000 noise-free cases of the linear
    /// finger. The paper states neither the scaling of the inputs nor the training schedule. Here the largest displacement is scaled to 1, and the
    /// schedule is an assumption of this project.
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

    /// The network of [`TrainingRecipe::paper`] with camera noise on its inputs. `noise_mm` is the standard deviation of the noise of one coordinate,
    /// mm.
    pub fn paper_with_noise(contacts: Vec<Contact>, noise_mm: f64) -> TrainingRecipe {
        TrainingRecipe { noise_mm, ..TrainingRecipe::paper(contacts) }
    }

    /// Network for the nonlinear finger, trained on co-rotational cases with noise; it has principal directions as inputs and a linear branch. With
    /// two layers of 32 neurons, the error is the same as with the paper's three layers (see the report's curve of error against size).
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

    /// Same as [`TrainingRecipe::nonlinear`], for forces at any subset of the contacts. More cases and wider layers cover all subsets.
    pub fn any_of(contacts: Vec<Contact>, noise_mm: f64) -> TrainingRecipe {
        TrainingRecipe {
            samples: SampleRecipe { any_of: true, ..SampleRecipe::paper(contacts, Kinematics::Corotational) },
            count: 100_000,
            hidden_layers: vec![128, 128],
            epochs: 60,
            ..TrainingRecipe::nonlinear(Vec::new(), noise_mm)
        }
    }

    /// Standard deviation that ridge regression assumes for the forces, N: the root mean square of a uniform distribution from zero to the largest
    /// force.
    pub(super) fn prior_n(&self) -> f64 {
        self.samples.largest_force_n / f64::sqrt(3.0)
    }

    /// Number of validation cases; the number of test cases is equal.
    pub(super) fn held_out(&self) -> usize {
        (self.count / HELD_OUT_SHARE).clamp(1, MOST_HELD_OUT)
    }

    pub(super) fn check(&self, finger: &Finger) -> Result<(), SamplesError> {
        self.samples.check()?;
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let not_negative = |x: f64| x.is_finite() && x >= 0.0;
        require(not_negative(self.noise_mm), "noise_mm", "a length in mm, zero or more", &self.noise_mm)?;
        // A single case has no spread, which the scaling of the inputs needs.
        require(self.count > 1, "count", "at least two cases", &self.count)?;
        require(!self.hidden_layers.contains(&0), "hidden_layers", "widths above zero", &self.hidden_layers)?;
        require(self.epochs > 0 && self.batch > 0, "epochs, batch", "at least one", &(self.epochs, self.batch))?;
        require(positive(self.learning_rate), "learning_rate", "a positive number", &self.learning_rate)?;
        let seen = self.samples.markers(finger).len();
        require(2 * seen >= self.samples.contacts.len() && seen > 0, "hidden", "enough visible markers", &seen)
    }
}
