//! Nonlinear sensing of random forces under camera noise.

use super::{Effort, Progress};
use crate::estimators::{BeamEstimator, ELEMENTS, Estimator, EstimatorError, EstimatorKind};
use crate::scatter::{self, ONE_FORCE_N, ScatterRequest, ScatterRow, TWO_FORCES_N};
use finray_model::{Finger, Kinematics, Mesh};

/// Random forces sensed by the nonlinear estimator from noisy pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseStudy {
    /// Standard deviation of one coordinate, mm.
    pub noise_mm: f64,
    /// Random cases for each set of contacts.
    pub cases: usize,
    /// One contact node each, forces of [`ONE_FORCE_N`].
    pub single: Vec<ScatterRow>,
    /// Two contact nodes each, forces of [`TWO_FORCES_N`]; none in a quick study.
    pub pairs: Vec<ScatterRow>,
}

impl NoiseStudy {
    pub(super) fn run(
        finger: &Finger,
        truth: &Mesh,
        noise_mm: f64,
        effort: Effort,
        progress: &dyn Progress,
    ) -> Result<NoiseStudy, EstimatorError> {
        let cases = match effort {
            Effort::Quick => 20,
            Effort::Full => 200,
        };
        let nodes = scatter::sampled_nodes(finger);
        let singles = scatter::singles(&nodes);
        let pairs = if effort == Effort::Full { scatter::pairs(&nodes) } else { Vec::new() };
        progress.part("noise", singles.len() + pairs.len());
        let model = Mesh::with_elements_per_member(finger, ELEMENTS);
        let nonlinear = BeamEstimator { kind: EstimatorKind::Nonlinear, mesh: &model };
        let estimators: [&dyn Estimator; 1] = [&nonlinear];
        let request = ScatterRequest {
            truth,
            kinematics: Kinematics::Corotational,
            model: &model,
            noise_levels_mm: &[noise_mm],
            cases,
            seed: 1,
        };
        let step = || progress.step();
        Ok(NoiseStudy {
            noise_mm,
            cases,
            single: scatter::scatter(&request, &estimators, &singles, ONE_FORCE_N, &step)?,
            pairs: scatter::scatter(&request, &estimators, &pairs, TWO_FORCES_N, &step)?,
        })
    }
}
