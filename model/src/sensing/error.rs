//! Why forces cannot be sensed.

use crate::finger::NodeId;
use crate::mesh::LoadError;

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
    /// No finger that differs from the scene as its table `assembly` states explains the measurement.
    #[error(
        "no finger that differs from the scene's by the errors of its table assembly explains the measurement: expected smaller errors, or another scene"
    )]
    NoSuchFinger,
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
    /// A normal is that of an object, and there is none.
    #[error("the direction of contact {contact} is that of an object's outline, and no object is known")]
    NoObject {
        /// Position of the contact in the list, from 1.
        contact: usize,
    },
    /// The object is elsewhere.
    #[error(
        "the object cannot touch the plate at contact {contact}: where the markers have the plate, its outline with what lies between is \
         {gap_mm:.2} mm {} (where it is, is known to {sd_mm:.2} mm, one standard deviation)",
        if *gap_mm > 0.0 { "away from it" } else { "off, inside the finger" }
    )]
    NotTouching {
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Gap between object and plate, mm; negative where the object reaches into the finger.
        gap_mm: f64,
        /// Standard deviation of the gap, mm.
        sd_mm: f64,
    },
    /// The finger itself could not be solved.
    #[error(transparent)]
    Statics(#[from] crate::statics::StaticsError),
}
