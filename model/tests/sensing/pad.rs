//! Sensing through a pad, which distributes a force along the plate. The distributed forces are sensed as one force, within the stated interval.

use finray_model::measurement::Measurement;
use finray_model::sensing::{
    Contact, ContactQuestion, Direction, Lean, NonlinearEstimate, NonlinearEstimator, Normal, Pad,
};
use finray_model::{Finger, Kinematics, Mesh, statics};
use finray_tests::{ELEMENTS, assert_standardised, at_position, case_count, finger_of, noisy, under_pad};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const PAD: Pad = Pad { length_mm: 8.0, thickness_mm: 3.0 };
/// Number of forces that represent a uniform pressure.
const PARTS: usize = 101;
/// Largest error, as a share of the force, from two approximations: two forces instead of a uniform pressure, and a chord instead of the mean
/// direction of the plate.
const MADE_OF_PARTS: f64 = 3e-4;

fn bracketed() -> Finger {
    finger_of(finray_fixtures::BRACKETED_SCENE)
}

/// Displacements under an object that presses on the pad.
fn pressed(mesh: &Mesh, contact: Contact, force_n: f64) -> Measurement {
    let loads = under_pad(mesh, contact, force_n, PAD, PARTS).expect("carried");
    let loads: Vec<_> = loads.iter().map(|(contact, force_n)| contact.load(mesh.finger(), *force_n)).collect();
    let shape = statics::solve(mesh, &loads, Kinematics::Corotational).expect("carried");
    Measurement::of_shape(mesh.finger(), &shape)
}

/// Force, position and lean are recovered from the displacements under a pressure with shear. If the estimator assumed a force at a point instead,
/// the error would be far larger.
#[test]
fn what_a_pad_does_is_sensed() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, 32);
    for (s_mm, force_n, angle_deg) in [(72.0, 3.0, 20.0), (55.0, 6.0, 5.0), (93.0, 2.0, -15.0), (81.0, 7.0, 25.0)] {
        let contact = at_position(s_mm, angle_deg);
        let seen = pressed(&mesh, contact, force_n);
        let sensed = |question: ContactQuestion| {
            let mut estimator = NonlinearEstimator::new(&mesh, &[question]).expect("on the plate");
            estimator.estimate(&seen, None).expect("identifiable")
        };
        let at_point = ContactQuestion::from(contact);
        let off = |found: &NonlinearEstimate| (found.forces.forces_n[0] / force_n - 1.0).abs();
        let with_pad = sensed(ContactQuestion { pad: Some(PAD), ..at_point });
        assert!(off(&with_pad) < MADE_OF_PARTS, "{s_mm} mm: {with_pad:?}");
        assert!(off(&sensed(at_point)) > 5.0 * MADE_OF_PARTS, "{s_mm} mm");
        let open = ContactQuestion::new(None, Direction::Angle(angle_deg));
        let found = sensed(ContactQuestion { pad: Some(PAD), ..open });
        assert!(off(&found) < MADE_OF_PARTS, "{s_mm} mm: {found:?}");
        let found_mm = found.contacts[0].position_mm(&finger).expect("on the plate");
        assert!((found_mm - s_mm).abs() < 0.05, "{s_mm} mm: found at {found_mm} mm");
    }
}

/// With noise, and with unknown position and lean, errors are as large as stated.
#[test]
fn stated_sigmas_hold_with_a_pad() {
    const NOISE_MM: f64 = 0.02;
    let cases = case_count(30, 300);
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let lean = Lean { from: Normal::Undeformed, ..Lean::of_friction(0.3, 0.05) };
    let question = ContactQuestion { pad: Some(PAD), ..ContactQuestion::new(None, Direction::Leaning(lean)) };
    let prepared = NonlinearEstimator::new(&mesh, &[question]).expect("one contact");
    let mut rng = ChaCha8Rng::seed_from_u64(19);
    let presses: Vec<(f64, Measurement)> = (0..cases)
        .map(|_| {
            let further: f64 = StandardNormal.sample(&mut rng);
            let (s_mm, force_n) = (rng.random_range(50.0..95.0), rng.random_range(1.0..7.0));
            let seen = pressed(&mesh, at_position(s_mm, lean.angle_deg + lean.sd_deg * further), force_n);
            (force_n, noisy(&seen, NOISE_MM, &mut rng))
        })
        .collect();
    let found = presses.iter().filter_map(|(force_n, seen)| {
        let found = prepared.clone().estimate(seen, Some(NOISE_MM)).ok()?.forces;
        Some((found.forces_n[0] - force_n) / found.sigmas_n[0])
    });
    let errors: Vec<f64> = found.collect();
    assert!(errors.len() * 60 >= cases * 59, "{} of {cases} answered", errors.len());
    assert_standardised("sensing::pad", &errors);
}
