//! Calibrates moduli from measured shapes under known loads, by eq. (11) of Xu et al. (2021). One function fits [one modulus of the co-rotational
//! finger](corotational_modulus), another fits [several moduli at once](robust_factors). [`calibrate_rig`] calibrates finger, camera and friction from
//! images.

mod factors;
mod modulus;
mod robust;
mod scene_values;
mod views;

pub use factors::{FactorEstimate, FactorModel, UnknownFactor, factors};
pub use modulus::{ModulusEstimate, corotational_modulus};
pub use robust::{OutlyingMarker, RobustFactors, robust_factors};
pub use scene_values::{SceneValues, modulus_values};
pub use views::*;

use crate::Kinematics;
use crate::finger::Finger;
use crate::measurement::Measurement;
use crate::mesh::{Load, Mesh};
use crate::statics::{self, StaticsError};

/// A finger under a known load, and its measured displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationCase {
    /// The load.
    pub load: Load,
    /// The measured displacements.
    pub measurement: Measurement,
}

/// Reason for which a calibration fails.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// The statics of the finger under a load cannot be solved.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// No load moves any measured node.
    #[error(
        "not identifiable: no load of the measurements moves a measured node; measure nodes that the load displaces"
    )]
    NothingMoves,
    /// The measured nodes move against the loads.
    #[error(
        "the measured nodes do not move with the loads: the ratio of measured to computed displacement is {compliance_factor:.3e}, expected above \
         zero; check signs, units and node numbers"
    )]
    WrongWay {
        /// Ratio of measured to computed displacement, dimensionless.
        compliance_factor: f64,
    },
    /// There are too few measured coordinates for the unknowns.
    #[error(
        "not identifiable: {coordinates} measured coordinates are too few for {unknowns} unknowns; measure more nodes"
    )]
    TooFewMarkers {
        /// Number of unknowns.
        unknowns: usize,
        /// Number of measured coordinates.
        coordinates: usize,
    },
    /// There are too few views (images) with a measured force for the unknowns.
    #[error(
        "not identifiable: {views} images with a measured force are too few for {unknowns} unknowns; measure more forces"
    )]
    TooFewViews {
        /// Number of views.
        views: usize,
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The measurements do not determine some parameters.
    #[error(
        "not identifiable: the measurements do not determine {parameters}; leave these parameters out of the fit, or add measurements that depend on them"
    )]
    NotIdentifiable {
        /// Names of the parameters, separated by commas.
        parameters: String,
    },
    /// The measurements determine only a combination of some parameters.
    #[error(
        "not identifiable: the measurements do not separate {parameters}; keep the scene's value of one of them, or load other nodes"
    )]
    NotSeparable {
        /// Names of the parameters, separated by commas.
        parameters: String,
    },
    /// The measured forces imply a friction angle of at least 90 degrees, or a build-up force of friction above the largest measured force.
    #[error(
        "friction is not identifiable: its build-up force would be {build_up_n:.3} N (expected at most the largest \
            measured force, {largest_n:.3} N) and its angle from the normal {angle_deg:.1} degrees (expected less than \
            90 degrees); check signs, measure larger forces, or fit friction without its build-up"
    )]
    FrictionLimit {
        /// Angle between a sliding force and the normal (lean), degrees.
        angle_deg: f64,
        /// Build-up force of friction, N; see [`Lean::build_up_n`](crate::sensing::Lean).
        build_up_n: f64,
        /// Largest measured force, N.
        largest_n: f64,
    },
    /// The search finds no minimum.
    #[error("the fit does not converge: check that loads, units and node numbers match the finger of the scene")]
    NoMinimum,
    /// A view cannot be used, or contradicts the other views.
    #[error("{name}: {error}")]
    View {
        /// Name of the view.
        name: String,
        /// Reason for which the view is refused.
        error: ViewError,
    },
    /// All measured forces differ by one large factor from the forces that would bend the scene's finger as in the images.
    #[error(
        "the median ratio of measured forces to the forces that the markers show is {times:.3}, expected about 1. \
            A negative ratio means a wrong sign or frame; any other ratio means a wrong unit (N) or wrong moduli in \
            the scene"
    )]
    ForceScale {
        /// Median ratio of measured forces to forces estimated from markers, dimensionless.
        times: f64,
    },
    /// Measured forces and forces estimated from the views point to opposite sides of the normal.
    #[error(
        "measured forces scatter by {:.1} % about the forces that the images show, but only by {:.1} % if the \
            measured forces are mirrored about the plate's normal: check the sign of fx_n and fy_n, and that fx_n and \
            fy_n refer to the frame in which the scene states the camera's pose",
        100.0 * scatter,
        100.0 * mirrored
    )]
    MirroredForces {
        /// Relative standard deviation of the measured forces about the estimated ones, dimensionless.
        scatter: f64,
        /// Relative standard deviation of the measured forces after mirroring about the plate's normal, dimensionless.
        mirrored: f64,
    },
    /// The calibrated finger is impossible: a parameter is outside its range.
    #[error(transparent)]
    Finger(#[from] crate::finger::ImpossibleFinger),
}

fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = numbers.collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(0.5 * (sorted[last / 2] + sorted[last.div_ceil(2)]))
}

/// Number of bisections of the bracket. This number suffices for double precision, even if the bracket is as wide as the largest floating-point
/// number.
const BISECTIONS: usize = 1200;

/// Young's modulus of the linear finger by eq. (11) of Xu et al. (2021). Finds the factor on all moduli that minimises the weighted sum, over all nodes and
/// cases, of the distance between measured and computed position.
///
/// The computed displacements are c v, with c = 1 / factor and the displacements v for a factor of 1. The weighted sum of |m - c v| over measured
/// displacements m is convex in c. Bisection finds the value of c at which the derivative of the weighted sum is zero. A sum of distances (not of
/// squares) is robust to single bad markers. The standard deviation of c is the sandwich estimate of an M-estimator (Huber 1967): sqrt(n / (n - 1)
/// sum g^2) / sum h for n nodes. In the formula for the standard deviation, g and h are the first and second derivatives of each node's weighted
/// distance with respect to c.
///
/// # Errors
/// [`CalibrationError`] if the statics fail, no load moves a measured node, or the nodes move against the loads.
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
    // For each node alone, one value of c fits best. The minimum of the sum lies between the smallest and the largest value of c that fits a single
    // node best.
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
        // A residual within rounding errors has no meaningful direction and counts as zero.
        if distance > 1e-14 * m.norm() {
            let gradient = weight * v.dot(&away) / distance;
            scatter += gradient * gradient;
            curvature += weight * (v.norm_squared() - (v.dot(&away) / distance).powi(2)) / distance;
        }
    }
    let sigma_c = match nodes.len() {
        // A single node has no scatter.
        1 => f64::INFINITY,
        count if curvature > 0.0 => (scatter * count as f64 / (count as f64 - 1.0)).sqrt() / curvature,
        _ => 0.0,
    };
    Ok(ModulusEstimate {
        factor: 1.0 / c,
        sigma: sigma_c / (c * c),
        mean_distance_mm: distances / nodes.len() as f64,
        contradiction: None,
        outliers: Vec::new(),
    })
}
