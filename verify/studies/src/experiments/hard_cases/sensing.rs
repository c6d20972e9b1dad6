//! Hard cases: measurements from which forces are hard to sense.

use super::{Findings, Question, Unexpected, middle};
use crate::prelude::*;
use crate::sampling::noise::Noise;
use finray_model::sensing::Estimate;

pub(super) const QUESTIONS: &[Question] = &[
    Question {
        case: "contacts on neighbouring nodes",
        difficulty: "two forces that deform the finger in nearly the same way",
        expectation: "exact without noise; with noise, within five stated sigma of the true force",
        answer: neighbours,
    },
    Question {
        case: "two contacts on one node",
        difficulty: "two components of one force; at equal angles, the two contacts are identical",
        expectation: "at two angles, as for neighbours; at equal angles, refused",
        answer: twice_on_one_node,
    },
    Question {
        case: "all contact nodes at once",
        difficulty: "as many forces as the front plate has nodes: the worst-conditioned of all cases",
        expectation: "exact without noise; with noise, within five stated sigma of the true force",
        answer: everywhere,
    },
    Question {
        case: "1 to 20 hidden markers",
        difficulty: "few markers may remain visible",
        expectation: "within five stated sigma of the true force; sigma grows with every hidden marker; refused without markers",
        answer: hidden,
    },
    Question {
        case: "noise from 0 to 1 mm",
        difficulty: "noise as large as the displacements of many nodes",
        expectation: "exact without noise; with noise, within five stated sigma of the true force",
        answer: noise,
    },
    Question {
        case: "one marker off by 20 mm",
        difficulty: "in least squares, a misidentified marker outweighs all other markers",
        expectation: "co-rotational: the sensed force changes by less than 2 %; linear: the residual shows that something is \
            wrong",
        answer: wild_marker,
    },
];

/// Tolerance of the relative error without noise: rounding times the condition number (363 for twelve forces).
const EXACT: f64 = 1e-7;
/// Tolerance of each error among a few hundred draws, in standard deviations. The error of a single draw exceeds five standard deviations with a
/// probability of 6e-7.
const SIGMAS: f64 = 5.0;
/// Tolerance of the ratio scatter / sigma, whose reference is 1. The tolerance covers more than four standard errors of the draws, and geometric
/// nonlinearity at 1 mm noise.
const SCATTER: f64 = 0.25;
/// Noise of a good camera, mm, for twelve forces at once; the paper's camera is too noisy to sense twelve forces.
const GOOD_NOISE_MM: f64 = 0.0067;
const NOISES_MM: [f64; 4] = [0.01, CAMERA_NOISE_MM, 0.3, 1.0];
/// Displacement error of the outlier, mm. The next constants are the tolerance of the relative change of a force, and the smallest required ratio of
/// the linear fit's residual to the noise.
const WILD_MM: Vector = Vector::new(12.0, 16.0);
const WILD_CHANGE: f64 = 0.02;
const CONSPICUOUS: f64 = 10.0;

impl Effort {
    fn draws(self) -> usize {
        self.choose(60, 300)
    }
}

fn at_node(node: NodeId, angle_deg: f64) -> Contact {
    Contact { position: ContactPosition::Node(node), angle_deg }
}

/// Forces on a finger, and their noise-free measurements under linear and co-rotational kinematics.
struct Task<'m> {
    mesh: &'m Mesh,
    contacts: Vec<Contact>,
    forces_n: Vec<f64>,
    seen: [(Kinematics, Measurement); 2],
}

impl<'m> Task<'m> {
    fn new(mesh: &'m Mesh, contacts: Vec<Contact>, forces_n: Vec<f64>) -> Result<Task<'m>, Unexpected> {
        let loads: Vec<FrameLoad> = contacts
            .iter()
            .zip(&forces_n)
            .map(|(contact, force)| mesh.frame_load(&contact.load(mesh.finger(), *force)))
            .collect::<Result<_, _>>()?;
        let seen = |kinematics| -> Result<_, Unexpected> {
            let motion = Statics::ladder(mesh, kinematics).equilibrium(&loads)?.motion;
            Ok((kinematics, Measurement::of_shape(mesh.finger(), &mesh.shape(&motion))))
        };
        let seen = [seen(Kinematics::Linear)?, seen(Kinematics::Corotational)?];
        Ok(Task { mesh, contacts, forces_n, seen })
    }

    /// Senses with the estimator of the same kinematics as the measured finger.
    fn sense(
        &self,
        kinematics: Kinematics,
        measurement: &Measurement,
        noise_mm: f64,
    ) -> Result<Estimate, SensingError> {
        if kinematics == Kinematics::Linear {
            let estimator = LinearEstimator::new(self.mesh.finger(), &self.contacts, measurement)?;
            return Ok(estimator.estimate(measurement, Some(noise_mm), Prior::None));
        }
        let questions: Vec<ContactQuestion> = self.contacts.iter().copied().map(ContactQuestion::from).collect();
        Ok(NonlinearEstimator::new(self.mesh, &questions)?.estimate(measurement, Some(noise_mm))?.forces)
    }

    /// Largest error of a force, relative to the largest force.
    fn error(&self, found: &Estimate) -> f64 {
        let largest = worst(self.forces_n.iter().copied());
        worst(found.forces_n.iter().zip(&self.forces_n).map(|(found, force)| (found - force).abs())) / largest
    }

    /// Error of each force divided by its stated standard deviation.
    fn sigmas_off<'e>(&'e self, found: &'e Estimate) -> impl Iterator<Item = f64> + 'e {
        let errors = found.forces_n.iter().zip(&self.forces_n).map(|(found, force)| (found - force).abs());
        errors.zip(&found.sigmas_n).map(|(error, sigma)| error / sigma)
    }

    fn exact_without_noise(&self, findings: &mut Findings) -> Result<(), Unexpected> {
        let mut errors = Vec::new();
        for (kinematics, seen) in &self.seen {
            errors.push(self.error(&self.sense(*kinematics, seen, 0.0)?));
        }
        findings.vanishes("no noise", "largest error / largest force", worst(errors), EXACT);
        Ok(())
    }

    /// Checks the scatter of noisy estimates against their stated standard deviations.
    fn true_within_sigma(&self, noise_mm: f64, draws: usize, findings: &mut Findings) -> Result<(), Unexpected> {
        // Each noise level has independent draws, because equal draws would give equal ratios on a linear finger.
        let mut noise = Noise::of_stream(1, noise_mm.to_bits());
        let mut off = Vec::new();
        for _ in 0..draws {
            for (kinematics, seen) in &self.seen {
                let noisy = noise.on(seen, noise_mm);
                off.extend(self.sigmas_off(&self.sense(*kinematics, &noisy, noise_mm)?).collect::<Vec<_>>());
            }
        }
        let scatter = rms(off.iter().copied()).unwrap_or(f64::NAN);
        let source = format!("{noise_mm} mm noise");
        findings.vanishes(&source, "largest error / sigma", worst(off), SIGMAS);
        findings.check(&source, "scatter / sigma", 1.0, scatter, SCATTER);
        Ok(())
    }
}

fn neighbours(finger: &Finger, effort: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let node = middle(finger);
    let contacts = vec![at_node(node, 0.0), at_node(NodeId(node.0 + 1), 0.0)];
    let task = Task::new(&mesh, contacts, vec![1.0, 2.0])?;
    task.exact_without_noise(findings)?;
    task.true_within_sigma(CAMERA_NOISE_MM, effort.draws(), findings)
}

fn twice_on_one_node(finger: &Finger, effort: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let node = middle(finger);
    let task = Task::new(&mesh, vec![at_node(node, 0.0), at_node(node, 60.0)], vec![1.0, 1.0])?;
    task.exact_without_noise(findings)?;
    task.true_within_sigma(CAMERA_NOISE_MM, effort.draws(), findings)?;
    let same = Task { contacts: vec![at_node(node, 10.0); 2], ..task };
    let refused = same.seen.iter().filter(|(kinematics, seen)| {
        matches!(same.sense(*kinematics, seen, CAMERA_NOISE_MM), Err(SensingError::SameContact { .. }))
    });
    findings.counts("both estimators", "refusals of the same angle twice", 2, refused.count());
    Ok(())
}

fn everywhere(finger: &Finger, effort: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let contacts: Vec<Contact> = finger.contact_nodes().map(|node| at_node(node, 0.0)).collect();
    let forces_n = vec![3.0 / contacts.len() as f64; contacts.len()];
    let task = Task::new(&mesh, contacts, forces_n)?;
    task.exact_without_noise(findings)?;
    task.true_within_sigma(GOOD_NOISE_MM, effort.draws() / 4, findings)
}

fn hidden(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let task = Task::new(&mesh, vec![at_node(middle(finger), 10.0)], vec![2.0])?;
    let mut noise = Noise::new(2);
    let nodes: Vec<NodeId> = finger.marked_nodes().collect();
    // Markers are removed from both plates in turn.
    let order: Vec<NodeId> = (0..nodes.len()).map(|i| nodes[(i * 10) % nodes.len()]).collect();
    let (mut off, mut shrinks, mut refused) = (Vec::new(), 0, 0);
    for (kinematics, seen) in &task.seen {
        let noisy = noise.on(seen, CAMERA_NOISE_MM);
        let mut before = 0.0;
        for count in 0..=20 {
            let found = task.sense(*kinematics, &noisy.clone().without(&order[..count]), CAMERA_NOISE_MM)?;
            off.extend(task.sigmas_off(&found).collect::<Vec<_>>());
            // The standard deviation stated by the nonlinear estimator also changes with the estimate, by less than 2 %.
            shrinks += usize::from(found.sigmas_n[0] < 0.98 * before);
            before = found.sigmas_n[0];
        }
        let none = task.sense(*kinematics, &noisy.without(&order), CAMERA_NOISE_MM);
        refused += usize::from(matches!(none, Err(SensingError::TooFewMarkers { .. })));
    }
    findings.vanishes("0.067 mm noise", "largest error / sigma", worst(off), SIGMAS);
    findings.counts("information only shrinks", "markers whose loss made sigma smaller", 0, shrinks);
    findings.counts("both estimators", "refusals without any marker", 2, refused);
    Ok(())
}

fn noise(finger: &Finger, effort: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let task = Task::new(&mesh, vec![at_node(middle(finger), 0.0)], vec![2.0])?;
    task.exact_without_noise(findings)?;
    for noise_mm in NOISES_MM {
        task.true_within_sigma(noise_mm, effort.draws(), findings)?;
    }
    Ok(())
}

fn wild_marker(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let task = Task::new(&mesh, vec![at_node(middle(finger), 10.0)], vec![2.0])?;
    let mut noise = Noise::new(3);
    let (mut changes, mut residuals) = (Vec::new(), Vec::new());
    for (kinematics, seen) in &task.seen {
        let noisy = noise.on(seen, CAMERA_NOISE_MM);
        for spoiled in finger.marked_nodes() {
            let moved = noisy.markers().iter().map(|marker| {
                let wild = if marker.node == spoiled { WILD_MM } else { Vector::zeros() };
                Marker { displacement: marker.displacement + wild, ..*marker }
            });
            let found = task.sense(*kinematics, &Measurement::new(finger, moved)?, CAMERA_NOISE_MM)?;
            match kinematics {
                Kinematics::Linear => residuals.push(found.residual_rms_mm / CAMERA_NOISE_MM),
                _ => changes.push(task.error(&found)),
            }
        }
    }
    findings.vanishes("true force", "largest error / force", worst(changes), WILD_CHANGE);
    let least = residuals.into_iter().fold(f64::INFINITY, f64::min);
    findings.note(format!("With linear kinematics, the residual is at least {least:.0} times the noise."));
    let seen = usize::from(least >= CONSPICUOUS);
    findings.counts("the noise", "linear residual always over ten times the noise", 1, seen);
    Ok(())
}
