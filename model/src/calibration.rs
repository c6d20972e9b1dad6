//! Moduli from measured shapes under known loads: eq. (11) of Xu et al. (2021), the same of the [co-rotational finger](corotational_modulus), and
//! [several at once](factors).

mod factors;
mod modulus;
mod views;

pub use factors::{FactorEstimate, FactorModel, Unknown, factors};
pub use modulus::{CorotationalModulus, OutlyingMarker, corotational_modulus};
pub use views::{
    BaseCompliance, ForceError, ForceInView, FoundQuantity, FoundView, FrictionEstimate, FrictionQuestion,
    LeftOutObject, LocatedView, MeasuredLean, OneView, Outlier, OutlierKind, Quantity, RigEstimate, RigQuestion,
    SceneValue, SensedBefore, Sought, UNSTATED_BASE, View, ViewError, ViewEstimate, ViewModel, calibrate_rig,
    compliance_of, force_in_view, friction_of, views,
};

use crate::Kinematics;
use crate::finger::Finger;
use crate::measurement::Measurement;
use crate::mesh::{Load, Mesh};
use crate::statics::{self, StaticsError};

/// A finger under a known load, and what was measured of it.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationCase {
    /// The load.
    pub load: Load,
    /// The measured displacements.
    pub measurement: Measurement,
}

/// Modulus of the finger as a factor on what its description says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModulusEstimate {
    /// Factor on all moduli of the finger.
    pub factor: f64,
    /// Its standard deviation, from the scatter of the residuals.
    pub sigma: f64,
    /// Mean distance between measured and computed nodes, mm.
    pub mean_distance_mm: f64,
    /// Number of measured nodes, over all cases.
    pub node_count: usize,
}

/// Why a modulus is not identifiable.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// The finger under a load could not be solved.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// No load moves any measured node.
    #[error("not identifiable: no load of the measurements moves a measured node")]
    NothingMoves,
    /// The nodes move against the loads.
    #[error(
        "the measured nodes do not move with the loads (best compliance factor {compliance_factor:.3e}): are signs and units right?"
    )]
    WrongWay {
        /// Measured over computed displacement.
        compliance_factor: f64,
    },
    /// Fewer measured numbers than are needed.
    #[error("not identifiable: {coordinates} measured coordinates are too few for {unknowns} unknown factors")]
    TooFewMarkers {
        /// Unknown factors.
        unknowns: usize,
        /// Measured coordinates.
        coordinates: usize,
    },
    /// Fewer views with a measured force than are needed.
    #[error("not identifiable: {views} images with a measured force are too few for {unknowns} unknowns")]
    TooFewViews {
        /// Views.
        views: usize,
        /// Unknowns.
        unknowns: usize,
    },
    /// The data say nothing of some factors.
    #[error("not identifiable: the measurements do not determine {parameters}")]
    NotIdentifiable {
        /// Their names.
        parameters: String,
    },
    /// The data determine a combination of some factors alone.
    #[error(
        "not identifiable: the measurements do not separate {parameters}: leave one of them as the scene has it, or load \
         other nodes"
    )]
    NotSeparable {
        /// Their names.
        parameters: String,
    },
    /// Measured forces do not lean as friction would have it, or not far enough to show it in full.
    #[error(
        "friction is not identifiable: it would build up over {build_up_n:.3} N to a lean of {angle_deg:.1} degrees from the normal; expected less than 90 \
         degrees, and no more than the largest force that was measured, {largest_n:.3} N: measure larger forces, check signs, or seek one coefficient (friction)"
    )]
    FrictionLimit {
        /// The lean of a force that slides, degrees.
        angle_deg: f64,
        /// The force over which friction builds up, N.
        build_up_n: f64,
        /// The largest measured force, N.
        largest_n: f64,
    },
    /// The search for factors does not settle.
    #[error(
        "no factors were found for which measured and computed nodes are closest: do loads and units fit the finger?"
    )]
    NoMinimum,
    /// A view cannot be used, or contradicts the others.
    #[error("{name}: {error}")]
    View {
        /// Its name.
        name: String,
        /// What is wrong with it.
        error: ViewError,
    },
    /// Measured forces are of another size than those under which the scene's finger bends as the views show.
    #[error(
        "measured forces are {times:.3} times (median) those under which the finger of the scene bends as the images show: check their unit (N), sign \
         and frame; if these are right, begin from a scene whose moduli are nearer to the finger's"
    )]
    ForceScale {
        /// Measured forces over those that are shown.
        times: f64,
    },
    /// Measured forces lean to the other side than the views show.
    #[error(
        "measured forces scatter by {:.1} % about those that the images show, and by {:.1} % if each leans as much to the other side of the plate's normal: \
         check the sign of fx_n and fy_n and their frame, that of the camera's pose",
        100.0 * scatter,
        100.0 * mirrored
    )]
    MirroredForces {
        /// Relative standard deviation of the forces as measured.
        scatter: f64,
        /// Of the mirrored ones.
        mirrored: f64,
    },
    /// A factor is beyond what a finger may have.
    #[error(transparent)]
    Finger(#[from] crate::finger::ImpossibleFinger),
}

fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = numbers.collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(0.5 * (sorted[last / 2] + sorted[last.div_ceil(2)]))
}

/// Halvings of the bracket: enough to exhaust double precision, from the largest number down.
const BISECTIONS: usize = 1200;

/// Young's modulus of the linear finger by eq. (11): the factor on all moduli for which the sum of the distances
/// between measured and computed nodes, over all nodes and cases, is smallest.
///
/// Computed displacements v are proportional to c = 1 / factor, so the sum of |m - c v| is convex in c alone, and its derivative, which grows with c,
/// is bisected. Sums of distances (not of their squares) forgive single bad markers. The standard deviation is the sandwich estimate of an
/// M-estimator, sqrt(sum g^2) / sum h with g and h the first and second derivative of each node's distance (Huber 1967).
///
/// # Errors
/// [`CalibrationError`] when no factor follows from the measurements.
pub fn youngs_modulus(finger: &Finger, cases: &[CalibrationCase]) -> Result<ModulusEstimate, CalibrationError> {
    let mesh = Mesh::key_nodes(finger);
    let mut nodes = Vec::new();
    for case in cases {
        let shape = statics::solve(&mesh, &[case.load], Kinematics::Linear)?;
        for marker in case.measurement.markers() {
            let computed = shape.motion(marker.node).marker_displacement(finger);
            nodes.push((marker.displacement, computed, marker.weight));
        }
    }
    // Each node alone would choose its own c; the best for all lies between the extremes.
    let alone = nodes.iter().filter(|(_, v, _)| v.norm_squared() > 0.0).map(|(m, v, _)| m.dot(v) / v.norm_squared());
    let (mut low, mut high) = alone.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
    if !(low.is_finite() && high.is_finite()) {
        return Err(CalibrationError::NothingMoves);
    }
    let slope = |c: f64| -> f64 {
        nodes
            .iter()
            .map(|(m, v, weight)| {
                let away = v * c - m;
                let distance = away.norm();
                if distance > 0.0 { weight * v.dot(&away) / distance } else { 0.0 }
            })
            .sum()
    };
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if slope(middle) < 0.0 { low = middle } else { high = middle }
    }
    let c = 0.5 * (low + high);
    if c.is_nan() || c <= 0.0 {
        return Err(CalibrationError::WrongWay { compliance_factor: c });
    }
    let (mut scatter, mut curvature, mut distances) = (0.0, 0.0, 0.0);
    for (m, v, weight) in &nodes {
        let away = v * c - m;
        let distance = away.norm();
        distances += distance;
        // Below rounding of the displacements a residual has no direction: such data fit perfectly.
        if distance > 1e-14 * m.norm() {
            let gradient = weight * v.dot(&away) / distance;
            scatter += gradient * gradient;
            curvature += weight * (v.norm_squared() - (v.dot(&away) / distance).powi(2)) / distance;
        }
    }
    let sigma_c = match nodes.len() {
        // One node leaves no scatter to judge by.
        1 => f64::INFINITY,
        count if curvature > 0.0 => (scatter * count as f64 / (count as f64 - 1.0)).sqrt() / curvature,
        _ => 0.0,
    };
    Ok(ModulusEstimate {
        factor: 1.0 / c,
        sigma: sigma_c / (c * c),
        mean_distance_mm: distances / nodes.len() as f64,
        node_count: nodes.len(),
    })
}
