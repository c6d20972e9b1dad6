//! Measurements from which forces are hard to sense.

use super::{Case, Outcome, middle, worst};
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::{
    Contact, ContactQuestion, Estimate, ForcePrior, LinearEstimator, NonlinearEstimator, SensingError,
};
use finray_model::{Kinematics, Mesh, NodeId, Vector};
use finray_tests::{CAMERA_NOISE_MM, at_node, noisy, paper, random_stream, seen};

/// Tolerance of the relative error without noise: rounding times the condition number (363 for twelve forces).
const EXACT: f64 = 1e-7;
/// Tolerance of each error among a few hundred draws, in standard deviations. A single error exceeds it with a probability of 6e-7.
const SIGMAS: f64 = 5.0;
/// Tolerance of the ratio scatter / sigma, whose reference is 1: more than four standard errors of the draws, and geometric nonlinearity at 1 mm
/// noise.
const SCATTER: f64 = 0.25;
/// Noise of a good camera, mm, for twelve forces at once; the paper's camera is too noisy to sense twelve forces.
const GOOD_NOISE_MM: f64 = 0.0067;
const WITHIN: &str = "exact without noise; with noise, within five stated sigma of the true force";

/// Number of draws; the same in every run, so that the recorded figures can be compared.
const DRAWS: usize = 60;

/// Forces on a finger, and their noise-free measurements under linear and co-rotational kinematics.
struct Task {
    mesh: Mesh,
    contacts: Vec<Contact>,
    forces_n: Vec<f64>,
    exact: [(Kinematics, Measurement); 2],
}

impl Task {
    fn new(contacts: Vec<Contact>, forces_n: Vec<f64>) -> Task {
        let mesh = Mesh::key_nodes(&paper());
        let exact = [Kinematics::Linear, Kinematics::Corotational]
            .map(|kinematics| (kinematics, seen(&mesh, &contacts, &forces_n, kinematics).expect("carried")));
        Task { mesh, contacts, forces_n, exact }
    }

    /// Senses with the estimator of the same kinematics as the measured finger.
    fn sense(&self, kinematics: Kinematics, seen: &Measurement, noise_mm: f64) -> Result<Estimate, SensingError> {
        if kinematics == Kinematics::Linear {
            let estimator = LinearEstimator::new(self.mesh.finger(), &self.contacts, seen)?;
            return Ok(estimator.estimate(seen, Some(noise_mm), ForcePrior::None));
        }
        let questions: Vec<ContactQuestion> = self.contacts.iter().copied().map(ContactQuestion::from).collect();
        Ok(NonlinearEstimator::new(&self.mesh, &questions)?.estimate(seen, Some(noise_mm))?.forces)
    }

    /// Errors of the forces, each divided by `by` of its index.
    fn errors(&self, found: &Estimate, by: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.forces_n.len()).map(|i| (found.forces_n[i] - self.forces_n[i]).abs() / by(i)).collect()
    }

    fn largest_error(&self, found: &Estimate) -> f64 {
        worst(self.errors(found, |_| worst(self.forces_n.iter().map(|force| force.abs()))))
    }

    /// Checks the estimates without noise, and the scatter of estimates under each noise against their stated standard deviations.
    fn checked(&self, noises_mm: &[f64], draws: usize, case: &mut Case) -> Result<(), SensingError> {
        let mut exact = Vec::new();
        for (kinematics, seen) in &self.exact {
            exact.push(self.largest_error(&self.sense(*kinematics, seen, 0.0)?));
        }
        case.vanishes("no noise", "largest error / largest force", worst(exact), EXACT);
        for &noise_mm in noises_mm {
            // Each noise level has independent draws, because equal draws would give equal ratios on a linear finger.
            let mut rng = random_stream(1, noise_mm.to_bits());
            let mut off = Vec::new();
            for _ in 0..draws {
                for (kinematics, seen) in &self.exact {
                    let found = self.sense(*kinematics, &noisy(seen, noise_mm, &mut rng), noise_mm)?;
                    off.extend(self.errors(&found, |i| found.sigmas_n[i]));
                }
            }
            let scatter = (off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt();
            let source = format!("{noise_mm} mm noise");
            case.vanishes(&source, "largest error / sigma", worst(off), SIGMAS);
            case.is(&source, "scatter / sigma", 1.0, scatter, SCATTER);
        }
        Ok(())
    }
}

#[test]
fn neighbours() -> Outcome {
    let mut case =
        Case::new("contacts on neighbouring nodes", "two forces that deform the finger in nearly the same way", WITHIN);
    let node = middle(&paper()).0;
    let task = Task::new(vec![at_node(node, 0.0), at_node(node + 1, 0.0)], vec![1.0, 2.0]);
    task.checked(&[CAMERA_NOISE_MM], DRAWS, &mut case)?;
    case.holds()
}

#[test]
fn twice_on_one_node() -> Outcome {
    let mut case = Case::new(
        "two contacts on one node",
        "two components of one force; at equal angles, the two contacts are identical",
        "at two angles, as for neighbours; at equal angles, refused",
    );
    let node = middle(&paper()).0;
    let task = Task::new(vec![at_node(node, 0.0), at_node(node, 60.0)], vec![1.0, 1.0]);
    task.checked(&[CAMERA_NOISE_MM], DRAWS, &mut case)?;
    let same = Task { contacts: vec![at_node(node, 10.0); 2], ..task };
    let refused = same.exact.iter().filter(|(kinematics, seen)| {
        matches!(same.sense(*kinematics, seen, CAMERA_NOISE_MM), Err(SensingError::SameContact { .. }))
    });
    case.counts("both estimators", "refusals of the same angle twice", 2, refused.count());
    case.holds()
}

#[test]
fn everywhere() -> Outcome {
    let mut case = Case::new(
        "all contact nodes at once",
        "as many forces as the front plate has nodes: the worst-conditioned of all cases",
        WITHIN,
    );
    let contacts: Vec<Contact> = paper().contact_nodes().map(|node| at_node(node.0, 0.0)).collect();
    let forces_n = vec![3.0 / contacts.len() as f64; contacts.len()];
    Task::new(contacts, forces_n).checked(&[GOOD_NOISE_MM], DRAWS / 4, &mut case)?;
    case.holds()
}

#[test]
fn any_noise() -> Outcome {
    let mut case = Case::new("noise from 0 to 1 mm", "noise as large as the displacements of many nodes", WITHIN);
    let task = Task::new(vec![at_node(middle(&paper()).0, 0.0)], vec![2.0]);
    task.checked(&[0.01, CAMERA_NOISE_MM, 0.3, 1.0], DRAWS, &mut case)?;
    case.holds()
}

#[test]
fn hidden_markers() -> Outcome {
    let mut case = Case::new(
        "1 to 20 hidden markers",
        "few markers may remain visible",
        "within five stated sigma of the true force; sigma grows with every hidden marker; refused without markers",
    );
    let task = Task::new(vec![at_node(middle(&paper()).0, 10.0)], vec![2.0]);
    let nodes: Vec<NodeId> = paper().marked_nodes().collect();
    // Markers are removed from both plates in turn.
    let order: Vec<NodeId> = (0..nodes.len()).map(|i| nodes[(i * 10) % nodes.len()]).collect();
    let mut rng = random_stream(2, 0);
    let (mut off, mut shrinks, mut refused) = (Vec::new(), 0, 0);
    for (kinematics, seen) in &task.exact {
        let noisy = noisy(seen, CAMERA_NOISE_MM, &mut rng);
        let mut before = 0.0;
        for count in 0..=20 {
            let found = task.sense(*kinematics, &noisy.clone().without(&order[..count]), CAMERA_NOISE_MM)?;
            off.extend(task.errors(&found, |i| found.sigmas_n[i]));
            // The standard deviation stated by the nonlinear estimator also changes with the estimate, by less than 2 %.
            shrinks += usize::from(found.sigmas_n[0] < 0.98 * before);
            before = found.sigmas_n[0];
        }
        let none = task.sense(*kinematics, &noisy.without(&order), CAMERA_NOISE_MM);
        refused += usize::from(matches!(none, Err(SensingError::TooFewMarkers { .. })));
    }
    case.vanishes("0.067 mm noise", "largest error / sigma", worst(off), SIGMAS);
    case.counts("information only shrinks", "markers whose loss made sigma smaller", 0, shrinks);
    case.counts("both estimators", "refusals without any marker", 2, refused);
    case.holds()
}

#[test]
fn a_wild_marker() -> Outcome {
    let mut case = Case::new(
        "one marker off by 20 mm",
        "in least squares, a misidentified marker outweighs all other markers",
        "co-rotational: the sensed force changes by less than 2 %; linear: the residual shows that something is wrong",
    );
    let task = Task::new(vec![at_node(middle(&paper()).0, 10.0)], vec![2.0]);
    let mut rng = random_stream(3, 0);
    let (mut changes, mut residuals) = (Vec::new(), Vec::new());
    for (kinematics, seen) in &task.exact {
        let noisy = noisy(seen, CAMERA_NOISE_MM, &mut rng);
        for spoiled in paper().marked_nodes() {
            let moved = noisy.markers().iter().map(|marker| {
                let wild = if marker.node == spoiled { Vector::new(12.0, 16.0) } else { Vector::zeros() };
                Marker { displacement: marker.displacement + wild, ..*marker }
            });
            let found = task.sense(*kinematics, &Measurement::new(&paper(), moved)?, CAMERA_NOISE_MM)?;
            match kinematics {
                Kinematics::Linear => residuals.push(found.residual_rms_mm / CAMERA_NOISE_MM),
                _ => changes.push(task.largest_error(&found)),
            }
        }
    }
    case.vanishes("true force", "largest error / force", worst(changes), 0.02);
    let least = residuals.into_iter().fold(f64::INFINITY, f64::min);
    case.counts("the noise", "linear residual always over ten times the noise", 1, usize::from(least >= 10.0));
    case.holds()
}
