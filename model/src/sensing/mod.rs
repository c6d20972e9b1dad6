//! From measured displacements back to contact forces.

mod linear;
mod linearisation;
pub mod network;
mod nonlinear;
mod residual_test;

pub use linear::{LinearEstimator, Prior};
pub use linearisation::Linearisation;
pub use nonlinear::{Discretisation, NonlinearEstimate, NonlinearEstimator, sense_refining};
pub use residual_test::{ResidualTest, SIGNIFICANCE};

use crate::Vector;
use crate::finger::{Finger, NodeId, Plate};
use crate::mesh::{Load, LoadError};
use serde::{Deserialize, Serialize};

/// Where a force acts on the front plate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ContactPosition {
    /// At a contact node: from the tip to the last node before the front base.
    #[serde(rename = "node")]
    Node(NodeId),
    /// At a distance from the front base along the plate, mm.
    #[serde(rename = "s_mm")]
    At(f64),
}

/// A contact whose force is sought: its position and direction are known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Where it acts.
    #[serde(flatten)]
    pub position: ContactPosition,
    /// Direction of the force, degrees from the undeformed inward normal, positive towards the tip.
    pub angle_deg: f64,
}

/// As on the command line: `19@0`, `80 mm@-20`.
impl std::fmt::Display for Contact {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.position {
            ContactPosition::Node(node) => write!(f, "{node}@{}", self.angle_deg),
            ContactPosition::At(s_mm) => write!(f, "{s_mm} mm@{}", self.angle_deg),
        }
    }
}

impl Contact {
    /// At a node, along the undeformed normal.
    pub fn at_node(node: NodeId) -> Contact {
        Contact { position: ContactPosition::Node(node), angle_deg: 0.0 }
    }

    /// The contact's force of 1 N as a load.
    pub fn unit_load(&self, finger: &Finger) -> Load {
        self.load(finger, 1.0)
    }

    /// The contact's force as a load.
    pub fn load(&self, finger: &Finger, force_n: f64) -> Load {
        let force: Vector = finger.direction(self.angle_deg) * force_n;
        match self.position {
            ContactPosition::Node(node) => Load::at_node(node, force),
            ContactPosition::At(s_mm) => Load::at_position(s_mm, force),
        }
    }

    /// Position along the front plate, mm from the base; `None` for a node that is not on it.
    pub fn position_mm(&self, finger: &Finger) -> Option<f64> {
        match self.position {
            ContactPosition::Node(node) => finger.front_position_mm(node),
            ContactPosition::At(s_mm) => Some(s_mm),
        }
    }
}

/// Direction of a force that is asked about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Direction {
    /// Known, degrees from the undeformed inward normal, positive towards the tip; of a base that is not known exactly, from where the
    /// measurement has it.
    Angle(f64),
    /// The plate's inward normal, and what friction turns it by.
    Leaning(Lean),
    /// Unknown.
    Auto,
}

impl Direction {
    /// Along the inward normal of the deformed plate.
    pub const NORMAL: Direction = Direction::Leaning(Lean::NONE);
}

/// By how much friction turns a contact force away from the inward normal, as far as that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lean {
    /// Its mean, degrees, positive towards the tip: the arctangent of the coefficient of friction where the object slides.
    pub angle_deg: f64,
    /// Its standard deviation, degrees; where that is zero the lean is no unknown.
    pub sd_deg: f64,
    /// Force over which friction builds up, N: at a force f the mean is angle (1 - exp(-f / build_up)). Zero: at once.
    pub build_up_n: f64,
    /// From which normal it leans.
    pub from: Normal,
}

/// The inward normal of a plate that bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normal {
    /// Of the deformed plate: the mean over a length of it about the contact, mm, such as the object covers; zero for the contact alone.
    Deformed {
        /// The length, mm.
        over_mm: f64,
    },
    /// Of the undeformed plate: the face of an object that stays where it is, against a finger that bends round it.
    Undeformed,
}

impl Lean {
    /// No friction.
    pub const NONE: Lean =
        Lean { angle_deg: 0.0, sd_deg: 0.0, build_up_n: 0.0, from: Normal::Deformed { over_mm: 0.0 } };

    /// A coefficient of friction, positive where the force leans towards the tip, with its standard deviation.
    pub fn of_friction(coefficient: f64, sd: f64) -> Lean {
        let sd_deg = (sd / (1.0 + coefficient * coefficient)).to_degrees();
        Lean { angle_deg: coefficient.atan().to_degrees(), sd_deg, ..Lean::NONE }
    }

    /// A force anywhere in a friction cone: coefficients between two limits, each as likely as the others.
    pub fn within(coefficients: [f64; 2]) -> Lean {
        let [from, to] = coefficients.map(|coefficient| coefficient.atan().to_degrees());
        Lean { angle_deg: 0.5 * (from + to), sd_deg: (to - from).abs() / 12.0_f64.sqrt(), ..Lean::NONE }
    }

    /// Mean lean of a force, degrees.
    pub fn mean_deg(&self, force_n: f64) -> f64 {
        match self.build_up_n > 0.0 {
            true => -self.angle_deg * (-force_n.abs() / self.build_up_n).exp_m1(),
            false => self.angle_deg,
        }
    }
}

/// A contact whose force is sought, and perhaps its position and direction too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactQuestion {
    /// Where it acts; `None` if unknown.
    pub position: Option<ContactPosition>,
    /// In which direction.
    pub direction: Direction,
}

impl ContactQuestion {
    /// The contact, if position and direction are known before measuring.
    pub fn known(&self) -> Option<Contact> {
        match (self.position, self.direction) {
            (Some(position), Direction::Angle(angle_deg)) => Some(Contact { position, angle_deg }),
            _ => None,
        }
    }
}

impl From<Contact> for ContactQuestion {
    fn from(contact: Contact) -> ContactQuestion {
        ContactQuestion { position: Some(contact.position), direction: Direction::Angle(contact.angle_deg) }
    }
}

/// Why forces cannot be sensed from a measurement.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SensingError {
    /// A contact is not on the free front plate.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A contact node that is not on the front plate.
    #[error("node {node} is not a contact node: contacts lie on the front plate, nodes {first} (tip) to {last}")]
    NotAContactNode {
        /// The node asked for.
        node: NodeId,
        /// The tip.
        first: NodeId,
        /// The last node before the front base.
        last: NodeId,
    },
    /// The direction is not a finite number.
    #[error("the direction of contact {contact} is not a finite angle")]
    AngleNotFinite {
        /// Position of the contact in the list, from 1.
        contact: usize,
    },
    /// No contacts were asked for.
    #[error("no contact was given: nothing to estimate")]
    NoContact,
    /// The same unknown twice.
    #[error("contacts {first} and {second} have the same position and direction: their forces are not identifiable")]
    SameContact {
        /// Position in the list, from 1.
        first: usize,
        /// Position in the list, from 1.
        second: usize,
    },
    /// More unknowns than numbers measured.
    #[error("not identifiable: {unknowns} unknown forces, but only {coordinates} measured coordinates")]
    TooFewMarkers {
        /// Number of forces.
        unknowns: usize,
        /// Number of measured coordinates.
        coordinates: usize,
    },
    /// The data hardly change with some combination of the forces.
    #[error(
        "not identifiable: the scaled singular values span {span:.1e}, more than {limit:.0e}: the measured nodes do \
         not determine the forces (contact {weakest} least)"
    )]
    IllConditioned {
        /// Ratio of largest to smallest scaled singular value.
        span: f64,
        /// Largest ratio that is accepted.
        limit: f64,
        /// Contact that takes part most in the combination that cannot be seen, from 1.
        weakest: usize,
    },
    /// A position or direction is asked for that is not identifiable.
    #[error(
        "not identifiable: {what} of contact {contact} is only known to {sigma:.2} {unit} (one standard deviation)"
    )]
    Undetermined {
        /// "the position", "the direction" or "the force".
        what: &'static str,
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Its standard deviation.
        sigma: f64,
        /// The unit of the standard deviation.
        unit: &'static str,
    },
    /// Two different answers explain the data equally well.
    #[error(
        "not identifiable: {force_n:.3} N and {other_n:.3} N at contact {contact} explain the measurement equally well"
    )]
    Ambiguous {
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Its force in the one answer, N.
        force_n: f64,
        /// Its force in the other, N.
        other_n: f64,
    },
    /// An answer from few markers, far from the linear one, that the search finds from one start only.
    #[error(
        "not identifiable: forces that explain the measurement are far from those of the linear finger, and other starts of \
         the search do not lead to them"
    )]
    Unconfirmed,
    /// No forces were found that explain the data.
    #[error(
        "the co-rotational model does not explain the measurement: the residual is {residual_rms_mm:.3} mm of \
         {moved_rms_mm:.3} mm (root mean squares)"
    )]
    Unexplained {
        /// Root mean square of the weighted residual, mm.
        residual_rms_mm: f64,
        /// Root mean square of the measured displacements' coordinates, mm.
        moved_rms_mm: f64,
    },
    /// The search for forces that explain the measurement did not end.
    #[error(
        "the co-rotational model cannot explain the measurement: after {iterations} steps forces still change by \
         {change_n:.2e} N"
    )]
    NotConverged {
        /// Steps taken.
        iterations: usize,
        /// Last change of a force, N.
        change_n: f64,
    },
    /// The measurement contradicts the linear finger, and the error of linearisation cannot be found.
    #[error(
        "the measurement contradicts the linear model, and the co-rotational finger carries no forces that the linear model \
         would answer so: its error is not known (the nonlinear estimator does without linearisation)"
    )]
    NotLinearised,
    /// What is known beforehand cannot be weighed against the measurement.
    #[error(
        "a base or a friction that is known to a standard deviation has to be weighed against the noise of the measurement, \
         which was not stated"
    )]
    NoiseNotStated,
    /// The finger itself could not be solved.
    #[error(transparent)]
    Statics(#[from] crate::statics::StaticsError),
}

/// Largest span of the scaled singular values at which forces are still identifiable.
pub const LARGEST_SPAN: f64 = 1e8;

/// A residual of more than this many standard deviations of the noise that is also more than this share of the
/// displacements is no explanation. A real finger differs from its model by many times the camera's noise, but not by that.
const UNEXPLAINED_SIGMAS: f64 = 10.0;
const UNEXPLAINED_SHARE: f64 = 0.3;

/// Checks that contacts lie on the free front plate, have finite angles and differ from each other.
///
/// # Errors
/// [`SensingError`] naming the first contact that is wrong.
pub fn check_contacts(finger: &Finger, contacts: &[Contact]) -> Result<(), SensingError> {
    if contacts.is_empty() {
        return Err(SensingError::NoContact);
    }
    let [_, front_base] = finger.clamped_nodes();
    let (first, last) = (finger.tip(), NodeId(front_base.0 - 1));
    for (i, contact) in contacts.iter().enumerate() {
        match contact.position {
            ContactPosition::Node(node) => {
                if !(1..=front_base.0).contains(&node.0) {
                    return Err(LoadError::NodeMissing { node, key_nodes: front_base.0 }.into());
                }
                if finger.clamped_nodes().contains(&node) {
                    return Err(LoadError::NodeClamped { node }.into());
                }
                if !(first..=last).contains(&node) {
                    return Err(SensingError::NotAContactNode { node, first, last });
                }
            }
            ContactPosition::At(s_mm) => {
                let length_mm = finger.plate_length_mm(Plate::Front);
                if !(s_mm > 0.0 && s_mm <= length_mm) {
                    return Err(LoadError::PositionOffPlate { s_mm, length_mm }.into());
                }
            }
        }
        if !contact.angle_deg.is_finite() {
            return Err(SensingError::AngleNotFinite { contact: i + 1 });
        }
        let same = |other: &Contact| {
            other.angle_deg == contact.angle_deg && other.position_mm(finger) == contact.position_mm(finger)
        };
        if let Some(j) = contacts[..i].iter().position(same) {
            return Err(SensingError::SameContact { first: j + 1, second: i + 1 });
        }
    }
    Ok(())
}

/// Share of the largest force below which an error of the model is part of the standard deviations but no reason to warn: the
/// noise of the paper's camera leaves 0.13 % of 3 N at best (node 19).
const NEGLIGIBLE: f64 = 1e-3;

/// Why an estimate is worth less than noise alone would leave it. Its standard deviations are widened by what is known of the
/// model's error; what else may be wrong (a contact elsewhere, another finger) is in none of them.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Warning {
    /// The residual is larger than the stated noise leaves.
    #[error(
        "the measurement contradicts the model: a residual standard deviation of {:.3} mm, where noise of {:.3} mm was \
         stated (chi-squared test, {} degrees of freedom, {})",
        .0.residual_sd_mm, .0.noise_mm, .0.degrees_of_freedom, .0.p_in_words()
    )]
    Residual(ResidualTest),
    /// The linear finger's own error is larger than the noise's.
    #[error(
        "the linear model errs by about {:.3} N at contact {}, as a co-rotational finger under the sensed forces shows; noise \
         alone would be {:.3} N (one standard deviation)",
        .0.error_n, .0.contact, .0.sigma_n
    )]
    Linearisation(ModelError),
    /// The mesh's own error is larger than the noise's.
    #[error(
        "the mesh errs by about {:.3} N at contact {}, as one twice as fine shows; noise alone would be {:.3} N (one standard \
         deviation): use more nodes",
        .0.error_n, .0.contact, .0.sigma_n
    )]
    Discretisation(ModelError),
}

/// The error of a model where it is largest against that of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelError {
    /// Position of the contact in the list, from 1.
    pub contact: usize,
    /// The model's error, N.
    pub error_n: f64,
    /// Standard deviation that the noise gives the force, N.
    pub sigma_n: f64,
}

/// Sensed forces with what is known of their error.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Force of each contact along its direction, N, in the order of the contacts; may be negative.
    pub forces_n: Vec<f64>,
    /// Standard deviation of each force, N, with the model's own error as far as it is known. Infinite where the noise is
    /// unknown and no residual is there to estimate it from.
    pub sigmas_n: Vec<f64>,
    /// The model's own error of each force that is part of its standard deviation (linearisation, mesh, training), N; signed
    /// where its sign is known.
    pub model_error_n: Vec<f64>,
    /// Standard deviation of one measured coordinate that the sigmas rest on, mm: as stated, or the residual's (wider for few degrees of
    /// freedom where nothing was stated).
    pub noise_mm: f64,
    /// Why the estimate is worth less than noise alone would leave it, if so.
    pub warning: Option<Warning>,
    /// Root mean square of the weighted residual, mm.
    pub residual_rms_mm: f64,
    /// Singular values of the weighted compliance, mm/N, in falling order.
    pub singular_values: Vec<f64>,
}

impl Estimate {
    /// Adds to the standard deviations an error that is a share of each force, as a calibration leaves it.
    pub fn add_force_error(&mut self, share: f64) {
        for (sigma_n, force_n) in self.sigmas_n.iter_mut().zip(&self.forces_n) {
            *sigma_n = sigma_n.hypot(share * force_n);
        }
    }

    /// Adds an error of the model, N, to the standard deviations, which hold the noise's until then; warns where it is the
    /// larger of the two and not negligible.
    pub(super) fn add_model_error(&mut self, error_n: Vec<f64>, warning: fn(ModelError) -> Warning) {
        let largest_n = self.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let over = |i: usize| error_n[i].abs() / self.sigmas_n[i];
        let counts = |i: &usize| over(*i) > 1.0 && error_n[*i].abs() > NEGLIGIBLE * largest_n;
        let worst = (0..error_n.len()).filter(counts).max_by(|&i, &j| over(i).total_cmp(&over(j)));
        let of = |i: usize| ModelError { contact: i + 1, error_n: error_n[i], sigma_n: self.sigmas_n[i] };
        self.warning = self.warning.or(worst.map(|i| warning(of(i))));
        for (sigma, error) in self.sigmas_n.iter_mut().zip(&error_n) {
            *sigma = sigma.hypot(*error);
        }
        self.model_error_n = error_n;
    }
}

/// The largest power of one half below the share of some forces that a finger carries: what halving them comes to, without
/// trying those that are known to be too large.
fn halved_below(carried: f64) -> f64 {
    let mut share = 0.5;
    while share >= carried && carried > 0.0 {
        share *= 0.5;
    }
    share
}
