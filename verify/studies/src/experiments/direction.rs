//! Forces of unknown direction at a known position: finds the positions and directions at which direction and magnitude are identifiable.
//!
//! The paper excludes unknown directions ("will not work", Fig. 13), because forces of other directions give nearly equal shapes. Camera noise
//! decides whether the shapes under forces of different directions can be distinguished. Each position of the front plate is pushed in many
//! directions. The nonlinear estimator knows only the position, and answers or refuses each noise sample. A contact without friction pushes along the
//! deformed normal. Assuming the deformed normal as direction removes one unknown ([`without_friction`](DirectionStudy::without_friction)).

mod frictionless;

pub use frictionless::{Assumption, FrictionlessPush};

use super::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::noise::{Noise, with_sample};
use crate::sampling::sweep::Grid;
use crate::truths::Truth;
use finray_model::sensing::NonlinearEstimate;

/// Forces on the paper's finger, N.
pub const FORCES_N: [f64; 3] = [0.5, 1.0, 3.0];
/// A direction counts as identified up to this root mean square error, degrees.
pub const IDENTIFIED_DEG: f64 = 10.0;
/// A force counts as identified up to this relative root mean square error.
pub const IDENTIFIED_FORCE: f64 = 0.10;
/// A cell counts as identified if at least this share of its samples is answered.
pub const IDENTIFIED_ANSWERED: f64 = 0.9;
/// Approximate number of positions in a report; the next two constants are the step of the directions (degrees) and the number of noise samples per
/// cell. Refused samples take most of the computation time.
const POSITIONS: usize = 12;
const STEP_DEG: f64 = 20.0;
const SAMPLES: usize = 8;

/// Parameters of a study of unknown directions.
#[derive(Debug, Clone, Copy)]
pub struct DirectionRequest<'m> {
    /// Mesh of the estimator.
    pub model: &'m Mesh,
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// Approximate number of positions along the front plate.
    pub positions: usize,
    /// Step of the directions, degrees.
    pub step_deg: f64,
    /// Number of noise samples, shared by all cells.
    pub samples: usize,
    /// Forces, N, ascending.
    pub forces_n: [f64; 3],
    /// Seed of the noise.
    pub seed: u64,
}

/// Results for each position and direction, and for pushes without friction.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionStudy {
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// Number of noise samples per cell.
    pub samples: usize,
    /// Forces, N, ascending.
    pub forces_n: [f64; 3],
    /// Cells by position, then direction, then force.
    pub cells: Vec<DirectionCell>,
    /// Results for pushes along the deformed normal, by node, force and assumption of the estimator.
    pub without_friction: Vec<FrictionlessPush>,
}

/// Results for one force at one position and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionCell {
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// True direction, degrees from the undeformed inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Answers of the estimator to the noise samples.
    pub answers: Answers,
    /// Cramer-Rao bound: smallest standard deviation of the direction for an unbiased estimator, degrees.
    pub angle_bound_deg: Option<f64>,
    /// Cramer-Rao bound: smallest standard deviation of the force for an unbiased estimator, relative to the force.
    pub force_bound: Option<f64>,
}

/// Answers of the estimator to the noise samples of one push. Errors are root mean squares over the answered samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Answers {
    /// Number of noise samples; 0 if the finger has no equilibrium.
    pub samples: usize,
    /// Number of answered samples.
    pub answered: usize,
    /// Root mean square error of the force, relative to the true force.
    pub force_error: Option<f64>,
    /// Root mean square of the stated standard deviation of the force, relative to the true force.
    pub force_sigma: Option<f64>,
    /// Root mean square error of the direction, degrees.
    pub angle_error_deg: Option<f64>,
}

impl Answers {
    /// Whether direction and force are identified: see [`IDENTIFIED_DEG`], [`IDENTIFIED_FORCE`] and [`IDENTIFIED_ANSWERED`].
    pub fn is_identified(&self) -> bool {
        self.answered as f64 >= IDENTIFIED_ANSWERED * self.samples as f64
            && self.angle_error_deg.is_some_and(|error| error <= IDENTIFIED_DEG)
            && self.force_error.is_some_and(|error| error <= IDENTIFIED_FORCE)
    }

    fn of(
        estimator: &mut NonlinearEstimator,
        seen: &Measurement,
        samples: &[Vec<f64>],
        noise_mm: f64,
        truth: &Contact,
        force_n: f64,
    ) -> Answers {
        let mut answers = Answers { samples: samples.len(), ..Answers::default() };
        let (mut force, mut sigma, mut angle) = (0.0, 0.0, 0.0);
        for sample in samples {
            let noisy = with_sample(seen, sample, noise_mm);
            estimator.reset();
            let Ok(NonlinearEstimate { forces, contacts, .. }) = estimator.estimate(&noisy, Some(noise_mm)) else {
                continue;
            };
            answers.answered += 1;
            force += (forces.forces_n[0] / force_n - 1.0).powi(2);
            sigma += (forces.sigmas_n[0] / force_n).powi(2);
            angle += turn_deg(contacts[0].angle_deg, truth.angle_deg).powi(2);
        }
        let mean = |sum: f64| (answers.answered > 0).then(|| (sum / answers.answered as f64).sqrt());
        (answers.force_error, answers.force_sigma, answers.angle_error_deg) = (mean(force), mean(sigma), mean(angle));
        answers
    }
}

impl Evidence for DirectionStudy {}

/// Runs the study for a report; `None` in a quick report, and `None` without noise, when every direction is identifiable.
pub(crate) fn run(context: &Context) -> Result<Option<DirectionStudy>, SensingError> {
    if context.effort == Effort::Quick || context.noise_mm == 0.0 {
        return Ok(None);
    }
    let model = Mesh::with_elements_per_member(context.finger, ELEMENTS);
    let request = DirectionRequest {
        model: &model,
        noise_mm: context.noise_mm,
        positions: POSITIONS,
        step_deg: STEP_DEG,
        samples: SAMPLES,
        forces_n: context.checked_forces().scaled(FORCES_N),
        seed: 1,
    };
    context.progress.part("unknown directions", DirectionStudy::steps(&request));
    DirectionStudy::run(context.corotational, &request, &|| context.progress.step()).map(Some)
}

impl DirectionStudy {
    /// Computes the study in parallel; the result does not depend on the number of threads. `progress` is called
    /// [`steps`](DirectionStudy::steps) times.
    ///
    /// # Errors
    /// [`SensingError`] for a finger without contact.
    pub fn run(
        truth: &dyn Truth,
        request: &DirectionRequest,
        progress: &(dyn Fn() + Sync),
    ) -> Result<DirectionStudy, SensingError> {
        let finger = request.model.finger();
        let samples = samples(finger, request);
        let contacts = contacts(finger, request);
        let cells = contacts.par_iter().map(|contact| {
            let cells = cells(truth, request, &samples, contact);
            progress();
            cells
        });
        let cells: Vec<Vec<DirectionCell>> = cells.collect::<Result<_, SensingError>>()?;
        Ok(DirectionStudy {
            noise_mm: request.noise_mm,
            samples: request.samples,
            forces_n: request.forces_n,
            cells: cells.into_iter().flatten().collect(),
            without_friction: frictionless::rows(truth, request, &samples, progress)?,
        })
    }

    /// Number of times that [`run`](DirectionStudy::run) calls `progress`.
    pub fn steps(request: &DirectionRequest) -> usize {
        let finger = request.model.finger();
        contacts(finger, request).len() + frictionless::nodes(finger).len()
    }

    /// Number of identified cells, and number of all cells with equilibrium, for one force (N).
    pub fn identified(&self, force_n: f64) -> [usize; 2] {
        let carried = self.cells.iter().filter(|cell| cell.force_n == force_n && cell.answers.samples > 0);
        carried
            .fold([0, 0], |[identified, all], cell| [identified + usize::from(cell.answers.is_identified()), all + 1])
    }

    /// Whether the mean force error under the assumption of the deformed normal is smaller than with unknown direction. Considers only pushes without
    /// friction under the smallest force.
    pub fn is_normal_better(&self) -> bool {
        let mean_error = |assumed: Assumption| {
            let is_asked = |push: &&FrictionlessPush| push.assumed == assumed && push.force_n == self.forces_n[0];
            mean(self.without_friction.iter().filter(is_asked).filter_map(|push| push.answers.force_error))
        };
        mean_error(Assumption::Normal)
            .zip(mean_error(Assumption::Unknown))
            .is_some_and(|(normal, unknown)| normal < unknown)
    }
}

fn contacts(finger: &Finger, request: &DirectionRequest) -> Vec<Contact> {
    let (positions, angles) = Grid::grid(finger, request.positions, request.step_deg);
    let at = |s_mm| {
        angles
            .iter()
            .map(move |&angle_deg| Contact { position: ContactPosition::at(s_mm), angle_deg })
            .collect::<Vec<_>>()
    };
    positions.iter().flat_map(|&s_mm| at(s_mm)).collect()
}

/// Noise of every marker coordinate, in standard deviations, one list for each sample.
fn samples(finger: &Finger, request: &DirectionRequest) -> Vec<Vec<f64>> {
    let mut noise = Noise::new(request.seed);
    let mut sample = |number: usize| {
        noise.go_to(number as u64);
        noise.standard_normals(2 * finger.marked_nodes().len()).collect()
    };
    (0..request.samples).map(&mut sample).collect()
}

/// Cells of one position and direction, one for each force.
fn cells(
    truth: &dyn Truth,
    request: &DirectionRequest,
    samples: &[Vec<f64>],
    contact: &Contact,
) -> Result<Vec<DirectionCell>, SensingError> {
    let finger = request.model.finger();
    let question = ContactQuestion::new(Some(contact.position), Direction::Auto);
    let mut estimator = NonlinearEstimator::new(request.model, &[question])?;
    let across = Contact { angle_deg: contact.angle_deg + 90.0, ..*contact };
    let mut components = NonlinearEstimator::new(request.model, &[(*contact).into(), across.into()])?;
    let shapes = truth.shapes(contact, &request.forces_n);
    let cell = |(n, &force_n): (usize, &f64)| {
        let seen = shapes.get(n).map(|shape| Measurement::of_shape(finger, shape));
        let answers = seen.as_ref().map_or_else(Answers::default, |seen| {
            Answers::of(&mut estimator, seen, samples, request.noise_mm, contact, force_n)
        });
        // For the Cramer-Rao bound, the unknowns are the force components along and across the direction; for small angles, the angle is their ratio.
        components.reset();
        let bound = seen.and_then(|seen| components.estimate(&seen, Some(request.noise_mm)).ok());
        let sigma = |k: usize| bound.as_ref().map(|bound| bound.forces.covariance_n2[(k, k)].sqrt() / force_n);
        DirectionCell {
            s_mm: contact.position_mm(finger).unwrap_or(f64::NAN),
            angle_deg: contact.angle_deg,
            force_n,
            answers,
            angle_bound_deg: sigma(1).map(f64::to_degrees),
            force_bound: sigma(0),
        }
    };
    Ok(request.forces_n.iter().enumerate().map(cell).collect())
}

/// Angle from one direction to another, degrees, in -180 to 180.
fn turn_deg(from: f64, to: f64) -> f64 {
    let turn = (to - from).rem_euclid(360.0);
    if turn > 180.0 { turn - 360.0 } else { turn }
}
