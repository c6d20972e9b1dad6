//! Stated intervals cover the true forces on random fingers whose contact position is unknown while some markers are hidden.

use super::random_fingers::random_finger;
use finray_model::finger::Plate;
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactQuestion, Direction, NonlinearEstimate, SensingError, sense_refining};
use finray_model::{Finger, Kinematics, Mesh, NodeId};
use finray_tests::{TWO_SIDED_95, at_position, case_count, noisy, random_stream, seen};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const ELEMENTS: usize = 600;

/// A random finger under one force at a position that the estimator does not know. Some markers are hidden.
struct Hidden {
    finger: Finger,
    contact: Contact,
    force_n: f64,
    question: ContactQuestion,
    measurement: Measurement,
    noise_mm: f64,
}

impl Hidden {
    /// Draws until a finger has an equilibrium under its force. Every second case also asks for the direction.
    fn drawn(rng: &mut ChaCha8Rng) -> Hidden {
        loop {
            let finger = random_finger(rng);
            let length_mm = finger.plate_length_mm(Plate::Front);
            let contact = at_position(length_mm * rng.random_range(0.05..1.0), rng.random_range(-40.0..40.0));
            let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS / (3 * finger.rib_count() + 2));
            let unit = seen(&mesh, &[contact], &[1.0], Kinematics::Linear).expect("linear");
            let moved = unit.markers().iter().map(|m| m.displacement.norm()).fold(0.0, f64::max);
            let force_n = length_mm * 10.0_f64.powf(rng.random_range(-2.5..-0.8)) / moved;
            let Ok(clean) = seen(&mesh, &[contact], &[force_n], Kinematics::Corotational) else { continue };
            let nodes: Vec<NodeId> = clean.markers().iter().map(|m| m.node).collect();
            if nodes.len() < 4 {
                continue;
            }
            let most = nodes.len().min(25) as f64;
            let count = (4.0 * (most / 4.0).powf(rng.random_range(0.0..1.0))).round() as usize;
            // Hands and objects hide neighbours, glare hides single markers.
            let hidden: Vec<NodeId> = if rng.random_bool(0.5) {
                let first = rng.random_range(0..=nodes.len() - count);
                nodes.iter().enumerate().filter(|(i, _)| !(first..first + count).contains(i)).map(|(_, n)| *n).collect()
            } else {
                let mut nodes = nodes;
                nodes.shuffle(rng);
                nodes.split_off(count)
            };
            let noise_mm = 10.0_f64.powf(rng.random_range(-1.7..-1.0));
            let measurement = noisy(&clean.without(&hidden), noise_mm, rng);
            let direction = if rng.random_bool(0.5) { Direction::Auto } else { Direction::Angle(contact.angle_deg) };
            let question = ContactQuestion::new(None, direction);
            return Hidden { finger, contact, force_n, question, measurement, noise_mm };
        }
    }

    fn sensed(&self) -> Result<NonlinearEstimate, SensingError> {
        sense_refining(&self.finger, &[self.question], None, &self.measurement, Some(self.noise_mm), None)
    }
}

#[test]
fn forces_in_valleys_are_covered_or_refused() {
    let cases = case_count(100, 2000);
    let start: u64 = std::env::var("VALLEYS_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1);
    let outcomes: Vec<(Hidden, Result<NonlinearEstimate, SensingError>)> = (0..cases)
        .into_par_iter()
        .map(|i| {
            let case = Hidden::drawn(&mut random_stream(6500 + start, i as u64));
            let sensed = case.sensed();
            (case, sensed)
        })
        .collect();
    for auto in [false, true] {
        let of: Vec<_> = outcomes.iter().enumerate().filter(|(_, (c, _))| (c.question.direction == Direction::Auto) == auto).collect();
        let mut z = Vec::new();
        let (mut held, mut placed) = (0, 0);
        let (mut refused, mut warned) = (0, 0);
        for (i, (case, sensed)) in &of {
            let seen = case.measurement.markers().len();
            let Ok(found) = sensed else {
                refused += 1;
                if std::env::var("VALLEYS_VERBOSE").is_ok() {
                    println!("#{i} markers {seen} refused {}", sensed.as_ref().expect_err("refused"));
                }
                continue;
            };
            if found.forces.warning.is_some() {
                warned += 1;
                continue;
            }
            let (f, s) = (found.forces.forces_n[0], found.forces.sigmas_n[0]);
            let off = (f - case.force_n) / s;
            z.push(off.abs());
            let [low, high] = found.forces.interval_n(0);
            held += usize::from((low..=high).contains(&case.force_n));
            let [from, to] = found.uncertainties[0].position_interval_mm.unwrap();
            placed += usize::from((from..=to).contains(&case.contact.position_mm(&case.finger).unwrap()));
            if !(low..=high).contains(&case.force_n) {
                let at = found.contacts[0].position_mm(&case.finger).unwrap();
                let truth = case.contact.position_mm(&case.finger).unwrap();
                println!("#{i} auto {auto} markers {seen} ribs {} L {:.0} noise {:.3}: F {f:.4} +- {s:.4} truth {:.4} ({off:.1} sigma) {:.4?} at {at:.1} sd {:.2} truth {truth:.1} angle {:.1} truth {:.1}", case.finger.rib_count(), case.finger.plate_length_mm(Plate::Front), case.noise_mm, case.force_n, found.forces.interval_n(0), found.uncertainties[0].position_sd_mm.unwrap(), found.contacts[0].angle_deg, case.contact.angle_deg);
            }
        }
        let within = z.iter().filter(|z| **z <= TWO_SIDED_95).count();
        println!("auto {auto}: {} cases, {refused} refused, {warned} warned, {} silent, sigma covers {within} = {:.4}, intervals hold {:.4}, positions {:.4}, beyond 4 sigma {}", of.len(), z.len(), within as f64 / z.len() as f64, held as f64 / z.len() as f64, placed as f64 / z.len() as f64, z.iter().filter(|z| **z > 4.0).count());
    }
}
