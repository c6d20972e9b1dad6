//! Reasons why forces cannot be estimated.

use crate::finger::NodeId;
use crate::mesh::LoadError;
use crate::sensing::Alternative;

/// Reason why forces cannot be estimated from a measurement.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SensingError {
    /// A contact is not on the free front plate.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A contact node is not on the front plate.
    #[error("node {node} is not a contact node: contacts lie on the front plate, nodes {first} (tip) to {last}")]
    NotAContactNode {
        /// The requested node.
        node: NodeId,
        /// Node of the tip.
        first: NodeId,
        /// The last node before the front base.
        last: NodeId,
    },
    /// The direction of a contact is not a finite number.
    #[error("the direction of contact {contact} is not a finite angle")]
    AngleNotFinite {
        /// Position of the contact in the list, from 1.
        contact: usize,
    },
    /// No finger within the errors of the scene's table `assembly` explains the measurement.
    #[error(
        "no finger within the errors of the scene's table [assembly] explains the measurement: reduce these \
            errors, or correct the finger in the scene"
    )]
    NoSuchFinger,
    /// No contact is given.
    #[error("expected at least one contact, found none")]
    NoContact,
    /// Two contacts have the same position and direction.
    #[error("contacts {first} and {second} have the same position and direction: their forces are not identifiable")]
    SameContact {
        /// Position of the first of the two contacts in the list, from 1.
        first: usize,
        /// Position of the second of the two contacts in the list, from 1.
        second: usize,
    },
    /// There are more unknowns than measured coordinates.
    #[error(
        "not identifiable: too few measured coordinates ({coordinates}) for the unknowns ({unknowns}); measure more nodes, or state fewer contacts"
    )]
    TooFewMarkers {
        /// Number of unknowns: forces, and unknown positions and directions.
        unknowns: usize,
        /// Number of measured coordinates.
        coordinates: usize,
    },
    /// Some combination of the unknown forces hardly changes the measured displacements.
    #[error(
        "not identifiable: the measured nodes do not determine the forces, least of all at contact {weakest}; the \
            ratio of the largest to the smallest scaled singular value is {span:.1e}, expected at most {limit:.0e}; \
            treat neighbouring contacts as one"
    )]
    IllConditioned {
        /// Ratio of the largest to the smallest scaled singular value, dimensionless.
        span: f64,
        /// Largest accepted ratio, dimensionless.
        limit: f64,
        /// Number, from 1, of the contact with the largest share in the combination of forces that hardly changes the displacements.
        weakest: usize,
    },
    /// A requested position, direction or force has too large a standard deviation.
    #[error(
        "not identifiable: {what} of contact {contact} is only known to {sigma:.2} {unit} (one standard deviation); reduce the noise, \
         measure more nodes, state position and direction, or ask for fewer contacts"
    )]
    Undetermined {
        /// Name of the quantity: "the position", "the direction" or "the force".
        what: &'static str,
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Standard deviation of the quantity, in `unit`.
        sigma: f64,
        /// Unit of the standard deviation: "mm", "deg" or "N".
        unit: &'static str,
    },
    /// Two different sets of forces explain the measurement equally well.
    #[error(
        "not identifiable: {force_n:.3} N and {other_n:.3} N at contact {contact} explain the measurement equally well; state the position or \
         direction, or measure more nodes"
    )]
    Ambiguous {
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Force of the contact in one of the two sets of forces that explain the measurement, N.
        force_n: f64,
        /// Force of the contact in the other of the two sets of forces that explain the measurement, N.
        other_n: f64,
    },
    /// Two ranges of positions with different forces explain the measurement equally well.
    #[error(
        "not identifiable: contact {contact} may lie between {:.0} and {:.0} mm with {:.3} to {:.3} N, or between {:.0} and {:.0} mm with {:.3} to \
         {:.3} N; state the position or direction, or measure more nodes",
        .positions_mm[0][0], .positions_mm[0][1], .forces_n[0][0], .forces_n[0][1],
        .positions_mm[1][0], .positions_mm[1][1], .forces_n[1][0], .forces_n[1][1]
    )]
    TwoRanges {
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Smallest and largest force in each range, N.
        forces_n: [[f64; 2]; 2],
        /// Ends of each range, mm from the base. In a box, so that results that may hold this error stay small.
        positions_mm: Box<[[f64; 2]; 2]>,
        /// The answer in every range, the best first.
        alternatives: Vec<Alternative>,
    },
    /// A force is hardly known, because the position of its contact is.
    #[error(
        "not identifiable: the markers confine contact {contact} to {:.0} to {:.0} mm from the base, and its force to {:.3} to {:.3} N (95 % \
         intervals); state the position, measure more nodes, or reduce the noise",
        .position_mm[0], .position_mm[1], .force_n[0], .force_n[1]
    )]
    WideRange {
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// 95 % interval of the force, N.
        force_n: [f64; 2],
        /// 95 % interval of the position, mm from the base.
        position_mm: [f64; 2],
    },
    /// With few markers, the estimated forces are far from the linear finger's forces, and only one starting point of the search leads to the
    /// estimated forces.
    #[error(
        "not identifiable: the forces found are far from the linear finger's forces, and searches from other starting points do not find the same \
         forces; measure more nodes"
    )]
    Unconfirmed,
    /// No forces on the co-rotational finger explain the measurement.
    #[error(
        "the co-rotational model does not explain the measurement: the residual is {residual_rms_mm:.3} mm rms, the displacement {moved_rms_mm:.3} \
         mm rms; check the contacts, the node numbers and the unit (mm)"
    )]
    Unexplained {
        /// Root mean square of the weighted residual, mm.
        residual_rms_mm: f64,
        /// Root mean square of the measured displacement coordinates, mm.
        moved_rms_mm: f64,
    },
    /// The search for forces does not converge.
    #[error(
        "the co-rotational model does not explain the measurement: after {iterations} steps of the search the forces still change by {change_n:.2e} \
         N; check the contacts, the node numbers and the unit (mm)"
    )]
    NotConverged {
        /// Number of steps of the search.
        iterations: usize,
        /// Largest change of a force in the last step, N.
        change_n: f64,
    },
    /// The measurement contradicts the linear finger, and the error of linearisation cannot be computed.
    #[error(
        "the measurement contradicts the linear model, and the error of linearisation is unknown, because no \
            forces on the co-rotational finger reproduce the linear estimate: use the nonlinear estimator"
    )]
    NotLinearised,
    /// The base, the friction, a contact or the assembly has a standard deviation, but the noise of the displacements is not stated. To use the
    /// standard deviation of base, friction, contact or assembly, the estimator also needs the noise of the displacements.
    #[error(
        "base, friction, contact or [assembly] has a standard deviation, so the noise of the displacements must be known as \
            well: state the noise (noise_mm)"
    )]
    NoiseNotStated,
    /// A direction refers to the normal of an object, but no object is known.
    #[error(
        "the direction of contact {contact} is the normal of an object's outline: expected a table \
            [contact.object] with pose_mm in the scene"
    )]
    NoObject {
        /// Position of the contact in the list, from 1.
        contact: usize,
    },
    /// The object cannot touch the plate.
    #[error(
        "the object cannot touch the plate at contact {contact}: the gap between outline and pad is {gap_mm:.2} mm \
            (standard deviation {sd_mm:.2} mm), so the outline lies {}; check pose_mm, frame and pad_mm",
        if *gap_mm > 0.0 { "outside the finger" } else { "inside the finger" }
    )]
    NotTouching {
        /// Position of the contact in the list, from 1.
        contact: usize,
        /// Gap between the object's outline and the pad, mm. Negative if the object reaches into the finger.
        gap_mm: f64,
        /// Standard deviation of the gap, mm.
        sd_mm: f64,
    },
    /// The statics of the finger cannot be solved.
    #[error(transparent)]
    Statics(#[from] crate::statics::StaticsError),
}
