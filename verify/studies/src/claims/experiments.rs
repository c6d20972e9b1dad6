//! Small computations that support a single claim of the paper.

use crate::lattice::accuracy::difference;
use crate::prelude::*;
use finray_model::scene::ROD_RADIUS_MM;

/// Elements per member for shapes with large rotations.
const ELEMENTS: usize = 8;

/// `[smallest, largest]` of some figures, in their unit.
pub type Range = [f64; 2];

/// Contact nodes without the tip, because the paper does not load the tip.
fn loaded(finger: &Finger) -> impl Iterator<Item = NodeId> {
    finger.contact_nodes().skip(1)
}

fn by_node(finger: &Finger, figure: impl Fn(NodeId) -> Result<f64, SensingError>) -> Result<Vec<f64>, SensingError> {
    loaded(finger).map(figure).collect()
}

/// `[smallest, largest]` of some figures, in their unit; NaN without figures.
pub fn range_of(figures: &[f64]) -> Range {
    Span::of(figures.iter().copied()).map_or([f64::NAN; 2], Span::ends)
}

/// Force estimated by linear least squares along the normal at a node, N, for a finger under `load`.
pub fn sensed_n(finger: &Finger, node: NodeId, load: Load) -> Result<f64, SensingError> {
    let shape = statics::solve(&Mesh::key_nodes(finger), &[load], Kinematics::Linear)?;
    let seen = Measurement::of_shape(finger, &shape);
    let estimator = LinearEstimator::new(finger, &[Contact::at_node(node)], &seen)?;
    Ok(estimator.estimate(&seen, Some(0.0), Prior::None).forces_n[0])
}

/// Relative error by node on the linear finger if a force is sensed along the normal but acts at `off_deg` (degrees) from the normal, towards the tip.
///
/// # Errors
/// [`SensingError`] if the force at a node cannot be sensed.
pub fn wrong_direction(finger: &Finger, off_deg: f64) -> Result<Vec<f64>, SensingError> {
    by_node(finger, |node| Ok(sensed_n(finger, node, Load::at_node(node, finger.direction(off_deg)))? - 1.0))
}

/// Relative error by node if a normal force is sensed and the friction moment on the node's rod is neglected. `friction` is the coefficient,
/// dimensionless. The friction force itself is omitted.
///
/// # Errors
/// [`SensingError`] if the force at a node cannot be sensed.
pub fn neglected_torque(finger: &Finger, friction: f64) -> Result<Vec<f64>, SensingError> {
    by_node(finger, |node| {
        let load = Load::Node { node, force: finger.direction(0.0), moment_nmm: friction * ROD_RADIUS_MM };
        Ok((sensed_n(finger, node, load)? - 1.0).abs())
    })
}

/// Largest difference between linear and co-rotational shape under `force_n` (N), relative to the largest displacement, by node. Nodes without
/// equilibrium are omitted.
///
/// # Errors
/// [`SensingError`] if the linear finger cannot be solved.
pub fn linearisation(finger: &Finger, force_n: f64) -> Result<Vec<f64>, SensingError> {
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let mut differences = Vec::new();
    for node in loaded(finger) {
        let load = [Load::at_node(node, finger.direction(0.0) * force_n)];
        let linear = statics::solve(&mesh, &load, Kinematics::Linear)?;
        if let Ok(curved) = statics::solve(&mesh, &load, Kinematics::Corotational) {
            differences.push(difference(&curved, &linear));
        }
    }
    Ok(differences)
}

/// Result of linear least squares for forces at all contact nodes together.
#[derive(Debug, Clone, PartialEq)]
pub struct AllForces {
    /// Condition number: ratio of largest to smallest singular value, dimensionless.
    pub span: f64,
    /// Standard deviations of the forces under the camera's noise, N, by node.
    pub sigmas_n: Vec<f64>,
}

/// Estimates forces at all contact nodes together from markers with noise of `noise_mm` (standard deviation of a coordinate, mm).
///
/// # Errors
/// [`SensingError`] if the linear estimator cannot be built.
pub fn all_forces(finger: &Finger, noise_mm: f64) -> Result<AllForces, SensingError> {
    let contacts: Vec<Contact> = finger.contact_nodes().map(Contact::at_node).collect();
    let estimator = LinearEstimator::new(finger, &contacts, &Measurement::at_rest(finger))?;
    let values = estimator.singular_values();
    Ok(AllForces {
        span: values[0] / values[values.len() - 1],
        sigmas_n: estimator.inverse().sigmas_per_noise.iter().map(|sigma| sigma * noise_mm).collect(),
    })
}

/// Standard deviation of the force component perpendicular to the normal, N, by node, on the linear finger, if magnitude and direction are unknown.
pub(crate) fn unknown_direction(finger: &Finger, noise_mm: f64) -> Result<Vec<f64>, SensingError> {
    let markers = Measurement::at_rest(finger);
    by_node(finger, |node| {
        let component = |angle_deg| Contact { position: ContactPosition::Node(node), angle_deg };
        let estimator = LinearEstimator::new(finger, &[component(0.0), component(90.0)], &markers)?;
        Ok(estimator.inverse().sigmas_per_noise[1] * noise_mm)
    })
}

/// Effect on the co-rotational shape of exchanging the forces at two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exchanged {
    /// Largest difference of a displacement, relative to the largest displacement, dimensionless.
    pub share: f64,
    /// Euclidean norm of the difference over all markers, divided by the noise of one coordinate: the Mahalanobis distance, dimensionless.
    pub distance: f64,
}

/// Exchanges forces of 1 N and 4 N at two nodes. `noise_mm` is the standard deviation of a coordinate, mm.
///
/// # Errors
/// [`SensingError`] if the finger has no equilibrium under these forces.
pub fn redistributed(finger: &Finger, nodes: [NodeId; 2], noise_mm: f64) -> Result<Exchanged, SensingError> {
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let shape = |forces_n: [f64; 2]| -> Result<FingerShape, SensingError> {
        let load = |i: usize| Load::at_node(nodes[i], finger.direction(0.0) * forces_n[i]);
        Ok(statics::solve(&mesh, &[load(0), load(1)], Kinematics::Corotational)?)
    };
    let (one, other) = (shape([1.0, 4.0])?, shape([4.0, 1.0])?);
    let seen = [&one, &other].map(|shape| Measurement::of_shape(finger, shape));
    let pairs = seen[0].markers().iter().zip(seen[1].markers());
    let squares: f64 = pairs.map(|(a, b)| (a.displacement - b.displacement).norm_squared()).sum();
    Ok(Exchanged { share: difference(&one, &other), distance: squares.sqrt() / noise_mm })
}

/// Largest root mean square force sensed at an unloaded node, N. Each of nodes 16 to 20 is unloaded in turn; the others carry `force_n` (N) along the
/// normal. Linear least squares senses the forces at all five nodes of the co-rotational finger, under noise of `noise_mm` (mm).
///
/// # Errors
/// [`SensingError`] if the finger has no equilibrium, or its forces cannot be sensed.
pub fn zero_force(finger: &Finger, force_n: f64, noise_mm: f64) -> Result<f64, SensingError> {
    let nodes: Vec<NodeId> = (16..=20).map(NodeId).collect();
    let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let mut errors = Vec::new();
    for (i, untouched) in nodes.iter().enumerate() {
        let touched = nodes.iter().filter(|node| *node != untouched);
        let loads: Vec<Load> = touched.map(|&node| Load::at_node(node, finger.direction(0.0) * force_n)).collect();
        let seen = Measurement::of_shape(finger, &statics::solve(&mesh, &loads, Kinematics::Corotational)?);
        let estimator = LinearEstimator::new(finger, &contacts, &seen)?;
        let estimate = estimator.estimate(&seen, Some(noise_mm), Prior::None);
        errors.push(estimate.forces_n[i].hypot(estimator.inverse().sigmas_per_noise[i] * noise_mm));
    }
    Ok(worst(errors))
}

/// Largest absolute value of some figures.
pub fn largest(figures: &[f64]) -> f64 {
    worst(figures.iter().map(|figure| figure.abs()))
}
