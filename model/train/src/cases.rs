//! Converts load cases to inputs and targets of a network. Targets are forces in units of the residual of a linear fit.

use super::TrainError;
use super::any_of::RidgeForces;
use super::descent::Table;
use super::recipe::TrainingRecipe;
use super::regression::{Normalisation, Regression};
use crate::samples::{Samples, SamplesError};
use finray_model::compliance::Compliance;
use finray_model::finger::Finger;
use finray_model::sensing::network::Inputs;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// The unit of a force target is at least this share of the largest force. Smaller units would be finer than single precision resolves.
const LEAST_UNIT: f64 = 1e-4;

/// Conversion of samples to tables of inputs and targets.
pub(super) struct Cases {
    normalisation: Normalisation,
    noise_mm: f64,
    regression: Option<Regression>,
    /// Forces by ridge regression, present only if the samples load subsets of the contacts.
    ridge: Option<RidgeForces>,
    /// Unit of each force target, N.
    pub(super) units_n: Vec<f64>,
}

impl Cases {
    pub(super) fn new(finger: &Finger, recipe: &TrainingRecipe, training: &Samples) -> Result<Cases, TrainError> {
        let normalisation = Normalisation::new(training, recipe.scaling, recipe.noise_mm);
        let least_n = LEAST_UNIT * recipe.samples.largest_force_n;
        if recipe.samples.any_of {
            let loads: Vec<_> = recipe.samples.contacts.iter().map(|contact| contact.unit_load(finger)).collect();
            let compliance = Compliance::new(finger, &loads).map_err(|error| SamplesError::Contacts(error.into()))?;
            let ridge = RidgeForces::new(&compliance, training, recipe.noise_mm, recipe.prior_n());
            let units_n = ridge.left_over_n(training).iter().map(|left_n| left_n.max(least_n)).collect();
            return Ok(Cases {
                normalisation,
                noise_mm: recipe.noise_mm,
                regression: None,
                ridge: Some(ridge),
                units_n,
            });
        }
        let inputs = normalisation.inputs_of(training);
        let regression = Regression::new(&inputs, &training.forces, &normalisation.noise);
        let regression = regression.filter(|_| recipe.linear_branch);
        let spread_n = |row: usize| training.forces.row(row).variance().sqrt();
        let unit_n = |row: usize| regression.as_ref().map_or_else(|| spread_n(row), |fit| fit.left_over_n[row]);
        let units_n = (0..training.forces.nrows()).map(|row| unit_n(row).max(least_n)).collect();
        Ok(Cases { normalisation, noise_mm: recipe.noise_mm, regression, ridge: None, units_n })
    }

    /// Number of inputs of the first layer.
    pub(super) fn input_count(&self) -> usize {
        self.normalisation.noise.len() + self.ridge.as_ref().map_or(0, |ridge| 2 * ridge.compliance.ncols())
    }

    /// The normalisation of displacements to inputs, in the form in which a network stores it.
    pub(super) fn inputs(&self, training: &Samples) -> Inputs {
        self.normalisation.stored(&self.normalisation.inputs_of(training))
    }

    /// Displacements of the linear finger under unit forces, n x contacts, mm/N; present if forces by ridge regression are among the inputs.
    pub(super) fn compliance(&self) -> Option<&DMatrix<f64>> {
        self.ridge.as_ref().map(|ridge| &ridge.compliance)
    }

    /// Whether a linear estimate is added to the output of the layers. With a linear estimate, the weights of the last layer start at zero.
    pub(super) fn starts_from_least_squares(&self) -> bool {
        self.regression.is_some() || self.ridge.is_some()
    }

    /// Initial weights of the linear branch, inputs x contacts, in units of force.
    pub(super) fn first_skip(&self) -> Option<Vec<f32>> {
        let fit = self.regression.as_ref()?;
        // The transpose is stored by columns, so its numbers are ordered by input, then by contact.
        let gains = fit.gain.transpose();
        Some(gains.iter().zip(self.units_n.iter().cycle()).map(|(gain, unit_n)| (gain / unit_n) as f32).collect())
    }

    /// Initial bias of the last layer, in units of force: the mean forces if a linear regression exists, otherwise zero.
    pub(super) fn first_bias(&self, training: &Samples) -> Vec<f32> {
        match &self.regression {
            Some(fit) => self.in_units(fit.mean_n.iter()).collect(),
            None => vec![0.0; training.forces.nrows()],
        }
    }

    fn in_units<'a>(&'a self, forces_n: impl Iterator<Item = &'a f64>) -> impl Iterator<Item = f32> {
        forces_n.zip(&self.units_n).map(|(force_n, unit_n)| (force_n / unit_n) as f32)
    }

    /// Inputs and targets of every case. The inputs contain camera noise if `rng` is given.
    pub(super) fn table(&self, samples: &Samples, mut rng: Option<ChaCha8Rng>) -> Table {
        let widths = [self.input_count(), self.units_n.len()];
        let mut table = Table { widths, ..Table::default() };
        let clean = self.normalisation.inputs_of(samples);
        let mut coordinates = DVector::zeros(samples.displacements.nrows());
        let mut inputs = DVector::zeros(clean.nrows());
        for case in 0..samples.count() {
            let forces_n = samples.forces.column(case);
            inputs.copy_from(&clean.column(case));
            let Some(ridge) = &self.ridge else {
                if let Some(rng) = &mut rng {
                    let noise = self.normalisation.noise.iter();
                    inputs
                        .iter_mut()
                        .zip(noise)
                        .for_each(|(z, noise)| *z += noise * rng.sample::<f64, _>(StandardNormal));
                }
                table.inputs.extend(inputs.iter().map(|z| *z as f32));
                table.targets.extend(self.in_units(forces_n.iter()));
                continue;
            };
            // The forces of ridge regression follow from the same noisy displacements as the inputs.
            coordinates.copy_from(&samples.displacements.column(case));
            if let Some(rng) = &mut rng {
                let noise: DVector<f64> =
                    DVector::from_fn(coordinates.len(), |_, _| self.noise_mm * rng.sample::<f64, _>(StandardNormal));
                inputs += &self.normalisation.projection * &noise;
                coordinates += noise;
            }
            let touching = &samples.touching[case];
            let ridge_n = ridge.forces_n(touching, &coordinates);
            table.inputs.extend(inputs.iter().map(|z| *z as f32));
            table.inputs.extend(touching.iter().map(|touches| f32::from(u8::from(*touches))));
            table.inputs.extend(ridge_n.iter().map(|force_n| (force_n / ridge.prior_n) as f32));
            table.targets.extend(self.in_units((forces_n - ridge_n).iter()));
            table.counts.extend(touching.iter().map(|touches| f32::from(u8::from(*touches))));
        }
        table
    }
}
