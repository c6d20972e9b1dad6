//! Small computations that a single claim of the paper rests on.

use crate::check::worst;
use crate::lattice::accuracy::difference;
use finray_model::finger::FingerDescription;
use finray_model::measurement::Measurement;
use finray_model::mesh::{FingerShape, Load};
use finray_model::scene::ROD_RADIUS_MM;
use finray_model::sensing::{Contact, ContactPlace, LinearEstimator, Prior, SensingError};
use finray_model::{Finger, Kinematics, Mesh, NodeId, statics};

/// Elements a member where rotations are large.
const ELEMENTS: usize = 8;

/// The smallest and the largest of some figures.
pub type Range = [f64; 2];

fn range(figures: impl IntoIterator<Item = f64>) -> Range {
    figures.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// Contact nodes but the tip, which the paper does not load.
fn loaded(finger: &Finger) -> impl Iterator<Item = NodeId> {
    finger.contact_nodes().skip(1)
}

/// What linear least squares, told of the normal at a node, makes of a load there, N.
fn sensed_n(finger: &Finger, node: NodeId, load: Load) -> Result<f64, SensingError> {
    let shape = statics::solve(&Mesh::key_nodes(finger), &[load], Kinematics::Linear)?;
    let seen = Measurement::of_shape(finger, &shape);
    let estimator = LinearEstimator::new(finger, &[Contact::at_node(node)], &seen)?;
    Ok(estimator.estimate(&seen, Some(0.0), Prior::None).forces_n[0])
}

/// Relative error of a force sensed along the normal that truly acts `off_deg` towards the tip, over the nodes; of any force on the
/// linear finger.
///
/// # Errors
/// [`SensingError`] if a node cannot be sensed.
pub fn wrong_direction(finger: &Finger, off_deg: f64) -> Result<Range, SensingError> {
    let error = |node| Ok(sensed_n(finger, node, Load::at_node(node, finger.direction(off_deg)))? - 1.0);
    Ok(range(loaded(finger).map(error).collect::<Result<Vec<_>, SensingError>>()?))
}

/// Relative error of a normal force because friction of this coefficient turns the rod, at nodes: the moment alone, its force left
/// out.
///
/// # Errors
/// [`SensingError`] if a node cannot be sensed.
pub fn neglected_torque(finger: &Finger, friction: f64) -> Result<Range, SensingError> {
    let error = |node| {
        let load = Load::Node { node, force: finger.direction(0.0), moment_nmm: friction * ROD_RADIUS_MM };
        Ok((sensed_n(finger, node, load)? - 1.0).abs())
    };
    Ok(range(loaded(finger).map(error).collect::<Result<Vec<_>, SensingError>>()?))
}

/// Least squares for a force at every contact node at once, linear.
#[derive(Debug, Clone, PartialEq)]
pub struct AllForces {
    /// How many there are.
    pub forces: usize,
    /// Largest over smallest singular value.
    pub span: f64,
    /// Standard deviations of the forces under the camera's noise, N.
    pub sigmas_n: Range,
}

/// Senses all contact nodes at once, under noise of one coordinate.
///
/// # Errors
/// [`SensingError`] if that cannot be done.
pub fn all_forces(finger: &Finger, noise_mm: f64) -> Result<AllForces, SensingError> {
    let contacts: Vec<Contact> = finger.contact_nodes().map(Contact::at_node).collect();
    let estimator = LinearEstimator::new(finger, &contacts, &at_rest(finger)?)?;
    let values = estimator.singular_values();
    Ok(AllForces {
        forces: contacts.len(),
        span: values[0] / values[values.len() - 1],
        sigmas_n: range(estimator.inverse().sigmas_per_noise.iter().map(|sigma| sigma * noise_mm)),
    })
}

/// Standard deviation of the force across the normal where size and direction are both sought, N, over the nodes; linear.
///
/// # Errors
/// [`SensingError`] if a node cannot be sensed.
pub fn unknown_direction(finger: &Finger, noise_mm: f64) -> Result<Range, SensingError> {
    let markers = at_rest(finger)?;
    let sigma = |node| {
        let component = |angle_deg| Contact { place: ContactPlace::Node(node), angle_deg };
        let estimator = LinearEstimator::new(finger, &[component(0.0), component(90.0)], &markers)?;
        Ok(estimator.inverse().sigmas_per_noise[1] * noise_mm)
    };
    Ok(range(loaded(finger).map(sigma).collect::<Result<Vec<_>, SensingError>>()?))
}

fn at_rest(finger: &Finger) -> Result<Measurement, SensingError> {
    Ok(Measurement::of_shape(finger, &statics::solve(&Mesh::key_nodes(finger), &[], Kinematics::Linear)?))
}

/// How much the shape under 1 N and 4 N at two nodes changes if they are exchanged, as a share of the largest displacement.
///
/// # Errors
/// [`SensingError`] if the finger does not carry them.
pub fn redistributed(finger: &Finger, nodes: [NodeId; 2]) -> Result<f64, SensingError> {
    let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
    let shape = |forces_n: [f64; 2]| -> Result<FingerShape, SensingError> {
        let load = |i: usize| Load::at_node(nodes[i], finger.direction(0.0) * forces_n[i]);
        Ok(statics::solve(&mesh, &[load(0), load(1)], Kinematics::Corotational)?)
    };
    Ok(difference(&shape([1.0, 4.0])?, &shape([4.0, 1.0])?))
}

/// How much stiffer the finger is against a force along the normal if its plates bend as plates in plane strain (Poisson's ratio) and
/// rods shorten them by arms (mm), over the nodes; linear.
///
/// # Errors
/// [`SensingError`] if the finger is impossible or not solved.
pub fn stiffened(finger: &Finger, poissons_ratio: f64, rod_arm_mm: f64) -> Result<Range, SensingError> {
    let description = FingerDescription { poissons_ratio, rod_arm_mm, ..finger.description().clone() };
    let Ok(stiff) = Finger::new(description) else { return Ok([f64::NAN; 2]) };
    let gives_way = |finger: &Finger, node| -> Result<f64, SensingError> {
        let load = Load::at_node(node, finger.direction(0.0));
        let shape = statics::solve(&Mesh::key_nodes(finger), &[load], Kinematics::Linear)?;
        Ok(shape.motion(node).displacement.dot(&finger.direction(0.0)))
    };
    let factor = |node| Ok(gives_way(finger, node)? / gives_way(&stiff, node)?);
    Ok(range(loaded(finger).map(factor).collect::<Result<Vec<_>, SensingError>>()?))
}

/// The largest size in a range.
pub fn largest(range: Range) -> f64 {
    worst(range.map(f64::abs))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;
    use finray_model::Scene;

    /// Rounding of a solution and of a least-squares problem after it.
    const ROUNDING: f64 = 1e-9;

    fn paper() -> Finger {
        Scene::from_toml(fixtures::PAPER_SCENE).expect("the paper's scene").finger
    }

    #[test]
    fn what_is_not_wrong_costs_nothing() {
        let finger = paper();
        assert!(largest(wrong_direction(&finger, 0.0).unwrap()) < ROUNDING);
        assert!(largest(neglected_torque(&finger, 0.0).unwrap()) < ROUNDING);
        assert_eq!(stiffened(&finger, 0.0, 0.0).unwrap(), [1.0; 2]);
    }

    /// The linear finger: twice the torque, twice the error; a direction off by so much to either side errs by
    /// cos - 1 plus or minus the same.
    #[test]
    fn errors_are_those_of_a_linear_finger() {
        let finger = paper();
        let [once, twice] = [0.2, 0.4].map(|friction| neglected_torque(&finger, friction).unwrap()[1]);
        assert!((twice / once - 2.0).abs() < 1e-6, "{once} and {twice}");
        let node = NodeId(19);
        let error = |off_deg| sensed_n(&finger, node, Load::at_node(node, finger.direction(off_deg))).unwrap() - 1.0;
        let mean = 0.5 * (error(12.5) + error(-12.5));
        assert!((mean - (12.5_f64.to_radians().cos() - 1.0)).abs() < ROUNDING, "{mean}");
    }

    /// Plane strain alone stiffens every part alike.
    #[test]
    fn plane_strain_stiffens_by_its_factor() {
        let [low, high] = stiffened(&paper(), 0.45, 0.0).unwrap();
        let factor = 1.0 / (1.0 - 0.45 * 0.45);
        assert!((low / factor - 1.0).abs() < ROUNDING && (high / factor - 1.0).abs() < ROUNDING, "{low} {high}");
    }

    /// Twelve normal forces on the paper's finger: the span that the interface states.
    #[test]
    fn all_forces_span_what_is_known() {
        let all = all_forces(&paper(), 0.067).unwrap();
        assert_eq!(all.forces, 12);
        assert!((all.span - 363.0).abs() < 0.5, "{}", all.span);
    }
}
