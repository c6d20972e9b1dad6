//! Causes of sensing errors: how much error disappears when one cause is eliminated, and how much remains when several causes are eliminated.
//!
//! A true finger, co-rotational on a fine mesh, is pushed at a position in a direction. Sensing follows a user's practice. The user ignores softer
//! zones of the finger, calibrates the modulus by shapes under weights, assumes a direction and a position with errors, and has a noisy camera. Each
//! [`Cause`] can be eliminated separately. The share of a cause is the part of the mean square error that disappears when the cause is eliminated.
//! Shares need not add up to one. Errors of equal sign reinforce each other when squared, and a cause that compensates another cause has a negative
//! share.

mod cell;
mod models;
pub mod network;
mod run;

pub use models::WEIGHTS_N;
pub use run::run;

use super::ExperimentError;
use crate::prelude::*;
use crate::truths::{MeshTruth, TruthId, fine_mesh};
use cell::Sensor;
use models::{End, Models};

/// The assumed direction is wrong by this angle to either side, degrees. The normal of the deformed plate turns by up to 12.5 degrees (paper, sec.
/// V-C).
pub const DIRECTION_OFF_DEG: f64 = 12.5;
/// The assumed position is wrong by this distance to either side, mm. An object may touch anywhere around a rod, so the distance is the radius of the
/// paper's rods (sec. V-C).
pub const POSITION_OFF_MM: f64 = 1.5;

/// Cause of a sensing error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// Noise of the camera. Eliminated by measurements without noise.
    Noise,
    /// Assumption of small rotations. Eliminated by the nonlinear estimator. (The mesh causes no error, because the linear model is exact at the key
    /// nodes on any mesh.)
    Linearisation,
    /// Error of Young's modulus, which the user's model calibrates on shapes under weights (paper, eq. (11)). Eliminated by the true modulus.
    Modulus,
    /// Assumed direction, wrong by [`DIRECTION_OFF_DEG`] to either side. Eliminated by the true direction.
    Direction,
    /// Assumed position, wrong by [`POSITION_OFF_MM`] to either side. Eliminated by the true position.
    #[serde(rename = "position")]
    Position,
    /// Zones of other stiffness that the user does not know, nearer to the base than to the tip. Eliminated by knowledge of these zones.
    BaseCompliance,
    /// Zones of other stiffness that the user does not know, nearer to the tip than to the base. Eliminated by knowledge of these zones.
    TipCompliance,
    /// Use of a network instead of the model that it was trained on. Eliminated by the nonlinear estimator on the model with which the network was
    /// trained.
    NetworkFit,
}

impl Cause {
    /// Name in tables, legends and files.
    pub fn name(self) -> &'static str {
        match self {
            Cause::Noise => "noise",
            Cause::Linearisation => "linearisation",
            Cause::Modulus => "wrong modulus",
            Cause::Direction => "wrong direction",
            Cause::Position => "wrong position",
            Cause::BaseCompliance => "base compliance",
            Cause::TipCompliance => "tip compliance",
            Cause::NetworkFit => "network fit",
        }
    }
}

/// Estimator with which a user senses a force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Practice {
    /// Linear least squares.
    LeastSquares,
    /// The nonlinear estimator on its default mesh.
    Nonlinear,
    /// A network trained on the co-rotational finger; it senses a force along the normal at a contact node.
    Network,
}

/// Prior knowledge of the contact's position and direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactKnowledge {
    /// Position and direction are assumed, with errors.
    Assumed,
    /// Position and direction are known.
    Known,
}

impl Practice {
    /// Identifier of the estimator.
    pub fn estimator(self) -> EstimatorId {
        match self {
            Practice::LeastSquares => EstimatorId::LeastSquares,
            Practice::Nonlinear => EstimatorId::Nonlinear,
            Practice::Network => EstimatorId::Network,
        }
    }

    /// The cause of error that this estimator adds to the causes common to all estimators.
    fn own_cause(self) -> Option<Cause> {
        match self {
            Practice::LeastSquares => Some(Cause::Linearisation),
            Practice::Nonlinear => None,
            Practice::Network => Some(Cause::NetworkFit),
        }
    }
}

impl ContactKnowledge {
    /// Causes of error that this knowledge of the contact rules out.
    fn leaves_out(self) -> &'static [Cause] {
        match self {
            ContactKnowledge::Assumed => &[],
            ContactKnowledge::Known => &[Cause::Direction, Cause::Position],
        }
    }

    /// Name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            ContactKnowledge::Assumed => "assumed",
            ContactKnowledge::Known => "known",
        }
    }
}

/// Parameters of a study of the causes of sensing errors.
#[derive(Debug, Clone, PartialEq)]
pub struct CauseRequest {
    /// Practices (estimators), each paired with a knowledge of the contact. Each pair gives one map. Networks have a [separate study](network).
    pub practices: Vec<(Practice, ContactKnowledge)>,
    /// Positions on the front plate, mm from the base.
    pub positions_mm: Vec<f64>,
    /// Directions, degrees from the inward normal, positive towards the tip.
    pub angles_deg: Vec<f64>,
    /// Forces, N, ascending.
    pub forces_n: Vec<f64>,
    /// Standard deviation of the noise of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Whether sensing knows the finger's zones of other stiffness; otherwise these zones are a cause of error.
    pub zones_known: bool,
    /// Weights under which the modulus is calibrated, N, ascending.
    pub weights_n: [f64; 6],
}

/// Causes of the error of one sensed force at one position and direction.
#[derive(Debug, Clone, PartialEq)]
pub struct CauseCell {
    /// Position on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Root mean square of sensed / true - 1 with every cause present; `None` if the finger has no equilibrium or the estimator refuses.
    pub rms_error: Option<f64>,
    /// Part of the mean square error that disappears when a cause is eliminated, one value per cause in the map's order; `None` if the estimator then
    /// refuses.
    pub shares: Vec<Option<f64>>,
    /// Root mean square of sensed / true - 1 after each of [`REMEDIES`], applied cumulatively.
    pub remedied: Vec<Option<f64>>,
}

impl CauseCell {
    /// Index of the cause with the largest share, and that share; `None` if no cause has a positive share.
    pub fn largest(&self) -> Option<(usize, f64)> {
        let known = self.shares.iter().enumerate().filter_map(|(i, share)| Some((i, (*share)?)));
        known.filter(|(_, share)| *share > 0.0).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Remedies by which a user reduces errors, in the order of application, each with the causes that it eliminates. They are knowledge of zones and
/// modulus, knowledge of the contact, and the nonlinear estimator.
pub const REMEDIES: [(&str, &[Cause]); 3] = [
    ("zones known", &[Cause::BaseCompliance, Cause::TipCompliance, Cause::Modulus]),
    ("contact known", &[Cause::Direction, Cause::Position]),
    ("nonlinear", &[Cause::Linearisation]),
];

/// Causes of sensing errors for one true finger and one practice (estimator), on a grid of positions, directions and forces.
#[derive(Debug, Clone, PartialEq)]
pub struct CauseMap {
    /// Parameters of the study.
    pub request: CauseRequest,
    /// Type of the true finger.
    pub truth: TruthId,
    /// Estimator of the user.
    pub practice: Practice,
    /// Knowledge of the contact.
    pub contact: ContactKnowledge,
    /// Causes that apply, in the order of `shares` in each cell.
    pub causes: Vec<Cause>,
    /// Cells by position, then direction, then force.
    pub cells: Vec<CauseCell>,
}

/// Maps of the causes of sensing errors on a true finger, one map for each practice. The result does not depend on the number of threads. `progress`
/// is called after each position and direction.
///
/// # Errors
/// [`ExperimentError`] if the equations of the finger at rest cannot be solved, or its modulus cannot be calibrated.
pub fn causes(
    truth: TruthId,
    finger: &Finger,
    request: &CauseRequest,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<CauseMap>, ExperimentError> {
    let mesh = fine_mesh(finger)?;
    let pushed = MeshTruth::new(truth, &mesh, Kinematics::Corotational)?;
    let models = Models::of(finger, &pushed, &request.weights_n)?;
    let sensor = |&(practice, contact): &(Practice, ContactKnowledge)| Sensor {
        practice,
        contact,
        models: &models,
        noise_mm: request.noise_mm,
        zones_known: request.zones_known,
        causes: present(practice, contact, finger, request),
    };
    let sensors: Vec<Sensor> = request.practices.iter().map(sensor).collect();
    let contacts: Vec<_> = request
        .positions_mm
        .iter()
        .flat_map(|&s_mm| request.angles_deg.iter().map(move |&angle| (s_mm, angle)))
        .collect();
    let at = |&(s_mm, angle_deg): &(f64, f64)| {
        let cells = cell::cells(&pushed, &sensors, s_mm, angle_deg, &request.forces_n);
        progress();
        cells
    };
    let cells: Vec<Vec<Vec<CauseCell>>> = contacts.par_iter().with_max_len(1).map(at).collect();
    let of_sensor = |(i, sensor): (usize, &Sensor)| CauseMap {
        request: request.clone(),
        truth,
        practice: sensor.practice,
        contact: sensor.contact,
        causes: sensor.causes.clone(),
        cells: cells.iter().flat_map(|by_sensor| by_sensor[i].iter().cloned()).collect(),
    };
    Ok(sensors.iter().enumerate().map(of_sensor).collect())
}

/// Causes of error that apply to an estimator, a knowledge of the contact, a finger and a request.
fn present(practice: Practice, contact: ContactKnowledge, finger: &Finger, request: &CauseRequest) -> Vec<Cause> {
    let exists = |cause: &Cause| match cause {
        Cause::Noise => request.noise_mm > 0.0,
        Cause::BaseCompliance => !request.zones_known && models::has_zones(finger, End::Base),
        Cause::TipCompliance => !request.zones_known && models::has_zones(finger, End::Tip),
        cause => !contact.leaves_out().contains(cause),
    };
    let common = [Cause::Modulus, Cause::Direction, Cause::Position, Cause::BaseCompliance, Cause::TipCompliance];
    std::iter::once(Cause::Noise).chain(practice.own_cause()).chain(common).filter(exists).collect()
}
