//! Study of the digital twin: Table I on the uniform finger and on the twin, calibration of zones from noisy shapes, and sensing with the calibrated
//! zones.

use super::fit::{ANGLE_DEG, TwinFit, fit};
use super::{OTHERS, TWIN};
use crate::experiments::table_one::{TableOne, TableOneRow, WEIGHTS_G, modulus_factor, table_one, weighed, weight_n};
use crate::experiments::{Context, Evidence, ExperimentError};
use crate::prelude::*;
use crate::sampling::noise::Noise;
use crate::sampling::scatter::{Counts, ScatterRequest, ScatterRow, scatter};
use crate::settings::ONE_FORCE_N;
use crate::truths::{MeshTruth, TruthId, fine_mesh, twin_of};
use finray_model::calibration::{CalibrationCase, CalibrationError, FactorEstimate, FactorModel, Unknown, factors};

/// Pairs of zones that share a factor, one zone on the front plate and one on the back plate, as indices in the twin's scene.
pub const GROUPS: [[usize; 2]; 3] = [[0, 1], [2, 3], [4, 5]];
/// Nodes loaded by weights for the calibration of the zones: the nodes of Table I and of the paper's calibration.
pub const LOADED: [usize; 9] = [14, 16, 17, 18, 19, 20, 21, 22, 24];
/// Nodes at which sensing is tested on the twin: the contact nodes except the tip.
const SENSED_NODES: std::ops::RangeInclusive<usize> = 14..=24;
/// Elements per member for the calibration of zones. Averaged over 54 shapes, noise is smaller than the error of a coarse mesh.
const CALIBRATION_ELEMENTS: usize = 12;
/// Tolerance of the mean relative error at a node with known zones: 10 % above the Cramer-Rao bound at the worst node (24).
const SENSED: f64 = 0.013;
/// Tolerance of the difference of (rms error / sigma) from 1. By chance alone, one in thousands of studies with 10 repetitions and 4 parameters
/// exceeds the tolerance (standard error 0.11).
const COVERED: f64 = 0.45;

/// Results of the study of the digital twin.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinStudy {
    /// The twin's finger.
    pub finger: Finger,
    /// Table I on the uniform finger.
    pub before: TableOne,
    /// Table I on the twin.
    pub after: TableOne,
    /// Modulus of the twin by eq. (11) of the paper, from the weights at all nodes of [`LOADED`], relative to the modulus from the paper's three
    /// calibration nodes.
    pub recalibrated: f64,
    /// Fits of the twin's zones, then of alternative sets.
    pub fits: Vec<TwinFit>,
    /// Standard deviation of a coordinate's noise in calibrations and sensing, mm.
    pub noise_mm: f64,
    /// The twin's factors calibrated from noisy shapes, one estimate per repetition.
    pub calibrations: Vec<FactorEstimate>,
    /// Results of sensing at each node.
    pub sensing: Vec<TwinSensing>,
}

/// Results of sensing random forces at one node of the twin, with noise.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinSensing {
    /// Loaded node.
    pub node: usize,
    /// Linear least squares with the paper's uniform model.
    pub uniform: ScatterRow,
    /// Linear least squares with the calibrated zones in the model.
    pub linear: ScatterRow,
    /// The nonlinear estimator with the calibrated zones in the model.
    pub nonlinear: ScatterRow,
}

impl Evidence for TwinStudy {
    fn checks(&self, _: &Context) -> Vec<Check> {
        self.checks()
    }

    fn comparisons(&self) -> Vec<Comparison> {
        self.comparisons()
    }
}

/// Study of the twin; `None` if the finger is not the paper's, or if there is no noise. `before` is Table I of the uniform finger.
pub(crate) fn run(context: &Context, before: Option<&TableOne>) -> Result<Option<TwinStudy>, ExperimentError> {
    let Some(before) = before.filter(|_| context.noise_mm > 0.0) else { return Ok(None) };
    context.progress.part("digital twin", TwinStudy::STEPS);
    let step = || context.progress.step();
    let counts = context.effort.choose([3, 40, 1], [10, 400, usize::MAX]);
    TwinStudy::run(context.finger, before, context.noise_mm, counts, &step).map(Some)
}

impl TwinStudy {
    /// Number of times that the study reports progress.
    pub const STEPS: usize = 3;

    /// Runs the study: `repeats` calibrations, `cases` forces at each node, and a fit of each of the first `sets` zone sets, beginning with the
    /// twin's.
    pub(crate) fn run(
        paper: &Finger,
        before: &TableOne,
        noise_mm: f64,
        [repeats, cases, sets]: [usize; 3],
        progress: &dyn Fn(),
    ) -> Result<TwinStudy, ExperimentError> {
        let finger = twin_of(paper)?;
        let mesh = fine_mesh(&finger)?;
        let truth = MeshTruth::new(TruthId::Twin, &mesh, Kinematics::Corotational)?;
        let forces_n = &WEIGHTS_G.map(weight_n);
        let (after, recalibrated) = rayon::join(
            || table_one(paper, &truth, ANGLE_DEG, forces_n),
            || modulus_factor(paper, &truth, ANGLE_DEG, forces_n, &LOADED.map(NodeId)),
        );
        let after = after?;
        let recalibrated = recalibrated? / after.modulus_factor;
        let all: Vec<_> = std::iter::once(TWIN).chain(OTHERS).take(sets).collect();
        let fits = all.par_iter().map(|set| fit(paper, set)).collect::<Result<_, _>>()?;
        progress();
        let clean = weighed(&finger, &truth, &LOADED.map(NodeId), forces_n);
        let calibrations = (0..repeats as u64)
            .into_par_iter()
            .map(|seed| calibrate(&finger, &clean, noise_mm, seed))
            .collect::<Result<Vec<_>, _>>()?;
        progress();
        let known = calibrations.first().map_or(&finger, |first| &first.finger);
        let sensing = sense(&mesh, paper, known, noise_mm, cases)?;
        progress();
        Ok(TwinStudy { finger, before: before.clone(), after, recalibrated, fits, noise_mm, calibrations, sensing })
    }

    /// Residuals of the fit: the twin's errors beside the errors of Table I, to which the zones were fitted.
    pub fn comparisons(&self) -> Vec<Comparison> {
        let comparison = |row: &TableOneRow| Comparison {
            problem: "digital twin of Table I: residual of its fit".to_owned(),
            source: "paper, Table I".to_owned(),
            quantity: format!("mean error of forces sensed with the uniform model, node {}", row.node),
            reference: row.paper_mean_error,
            ours: row.mean_error,
        };
        self.after.rows.iter().map(comparison).collect()
    }

    /// Root mean square of the errors of all calibrated factors, divided by their stated standard deviations.
    pub fn rms_over_sigma(&self) -> f64 {
        let factors = self.calibrations.iter().flat_map(|found| found.factors.iter().zip(&found.relative_sigmas));
        rms(factors.map(|(factor, sigma)| factor.ln() / sigma)).unwrap_or(f64::NAN)
    }

    /// Checks of results on the twin. The twin's agreement with Table I is not checked, because three factors were fitted to the six errors of that
    /// table. [`comparisons`](TwinStudy::comparisons) show the residuals of the fit.
    pub fn checks(&self) -> Vec<Check> {
        let problem = "digital twin of Table I";
        let nonlinear = || self.sensing.iter().map(|sensing| &sensing.nonlinear);
        let worst = worst(nonlinear().map(|row| row.mean_error().unwrap_or(f64::NAN)));
        let counts = Counts::of(nonlinear());
        let quantity = "worst mean error of the nonlinear estimator with calibrated zones, nodes 14 to 24";
        let sensed = Kind::Internal.on(problem, "true forces").vanishes(quantity, worst, SENSED);
        let quantity = "root mean square of error / stated sigma, over the calibrated factors";
        let covered = Kind::Internal.on(problem, "true factors").is(quantity, 1.0, self.rms_over_sigma(), COVERED);
        vec![sensed.with_refused(counts.refused, counts.drawn), covered]
    }
}

/// Calibrates the twin's modulus and zones from noisy shapes; front and back share factors. Factors are relative to the true factors.
fn calibrate(
    finger: &Finger,
    clean: &[CalibrationCase],
    noise_mm: f64,
    seed: u64,
) -> Result<FactorEstimate, CalibrationError> {
    let mut noise = Noise::new(seed);
    let mut cases = clean.to_vec();
    for case in &mut cases {
        case.measurement = noise.on(&case.measurement, noise_mm);
    }
    let unknowns: Vec<_> =
        std::iter::once(Unknown::Modulus).chain(GROUPS.map(|zones| Unknown::Zones(zones.to_vec()))).collect();
    let model =
        FactorModel { kinematics: Kinematics::Corotational, elements: CALIBRATION_ELEMENTS, noise_mm: Some(noise_mm) };
    factors(finger, &cases, &unknowns, &model)
}

fn sense(
    twin: &Mesh,
    paper: &Finger,
    known: &Finger,
    noise_mm: f64,
    cases: usize,
) -> Result<Vec<TwinSensing>, EstimatorError> {
    let [uniform, linear] = [paper, known].map(Mesh::key_nodes);
    let nonlinear = Mesh::with_elements_per_member(known, ELEMENTS);
    let bound = Mesh::with_elements_per_member(twin.finger(), ELEMENTS);
    let estimators = [
        BeamEstimator::least_squares(&uniform),
        BeamEstimator::least_squares(&linear),
        BeamEstimator::nonlinear(&nonlinear),
    ];
    let request = ScatterRequest {
        truth: twin,
        kinematics: Kinematics::Corotational,
        model: &bound,
        noise_levels_mm: &[noise_mm],
        cases,
        seed: 1,
    };
    let sets: Vec<_> = SENSED_NODES.map(|node| vec![NodeId(node)]).collect();
    let rows = scatter(&request, &estimators.each_ref().map(|e| e as &dyn Estimator), &sets, ONE_FORCE_N, &|| ())?;
    let by_node = rows.chunks_exact(estimators.len()).zip(SENSED_NODES);
    Ok(by_node
        .map(|(rows, node)| TwinSensing {
            node,
            uniform: rows[0].clone(),
            linear: rows[1].clone(),
            nonlinear: rows[2].clone(),
        })
        .collect())
}
