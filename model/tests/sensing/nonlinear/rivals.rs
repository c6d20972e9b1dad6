//! Measurements that contacts at several positions explain: the best explanation is found, or the measurement is refused as ambiguous.

use finray_model::measurement::Measurement;
use finray_model::sensing::{ContactQuestion, Direction, NonlinearEstimate, NonlinearEstimator, SensingError};
use finray_model::{Kinematics, Mesh};
use finray_tests::{CAMERA_NOISE_MM, at_position, noisy, paper, paper_scene_with, random_stream, seen};
use rand::RngExt;

/// Estimates the forces of contacts at unknown positions with known angles, degrees.
fn sensed<const N: usize>(
    mesh: &Mesh,
    angles_deg: [f64; N],
    measurement: &Measurement,
    noise_mm: f64,
) -> Result<NonlinearEstimate, SensingError> {
    let question = |angle_deg: f64| ContactQuestion::new(None, Direction::Angle(angle_deg));
    NonlinearEstimator::new(mesh, &angles_deg.map(question))?.estimate(measurement, Some(noise_mm))
}

/// Largest error of a force, in standard deviations. `None` if the measurement is refused as ambiguous.
fn largest_error(found: &Result<NonlinearEstimate, SensingError>, forces_n: &[f64]) -> Option<f64> {
    match found {
        Err(SensingError::Ambiguous { .. } | SensingError::TwoRanges { .. }) => None,
        found => {
            let forces = &found.as_ref().expect("identifiable").forces;
            let off = forces.forces_n.iter().zip(&forces.sigmas_n).zip(forces_n).map(|((f, s), truth)| (f - truth) / s);
            Some(off.fold(0.0_f64, |m, off| m.max(off.abs())))
        }
    }
}

/// Two forces along different angles. With the angles exchanged, similar forces at similar positions explain the markers nearly as well. The search once
/// ended at the exchange that the order of the contacts favours: 0.885 N with a standard deviation of 0.030 N instead of 1 N.
#[test]
fn exchanged_angles_are_right_or_refused() {
    let mesh = Mesh::key_nodes(&paper());
    for (s_mm, angles_deg, forces_n) in [
        ([55.0, 140.0], [-10.0, -25.0], [1.8, 1.0]),
        ([50.0, 120.0], [35.0, -35.0], [2.0, 2.5]),
        ([40.0, 100.0], [-40.0, 20.0], [1.0, 3.0]),
    ] {
        let contacts = [0, 1].map(|i| at_position(s_mm[i], angles_deg[i]));
        let clean = seen(&mesh, &contacts, &forces_n, Kinematics::Corotational).expect("carried");
        let [a, b] = angles_deg;
        for noise_mm in [CAMERA_NOISE_MM, 0.005] {
            let in_order = largest_error(&sensed(&mesh, [a, b], &clean, noise_mm), &forces_n);
            let exchanged = largest_error(&sensed(&mesh, [b, a], &clean, noise_mm), &[forces_n[1], forces_n[0]]);
            assert_eq!(in_order.is_some(), exchanged.is_some(), "{contacts:?}, {noise_mm} mm");
            let largest = [in_order, exchanged].into_iter().flatten().fold(0.0, f64::max);
            assert!(largest < 0.1, "{contacts:?}: {in_order:?}, {exchanged:?}");
            // A small noise distinguishes the angles.
            assert!(noise_mm == CAMERA_NOISE_MM || in_order.is_some(), "{contacts:?}: refused");
        }
    }
}

/// Forces at two unknown positions do not depend on the order of the contacts.
#[test]
fn the_order_of_contacts_does_not_change_their_forces() {
    let mesh = Mesh::key_nodes(&paper());
    let mut rng = random_stream(7, 0);
    let mut answered = 0;
    for case in 0..30 {
        let s_mm = [rng.random_range(20.0..75.0), rng.random_range(115.0..153.0)];
        let angles_deg = [0, 1].map(|_| rng.random_range(-40.0..40.0));
        let forces_n = [0, 1].map(|_| rng.random_range(0.2..2.0));
        let contacts = [0, 1].map(|i| at_position(s_mm[i], angles_deg[i]));
        let Ok(clean) = seen(&mesh, &contacts, &forces_n, Kinematics::Corotational) else { continue };
        let noise_mm = 0.02;
        let noisy = noisy(&clean, noise_mm, &mut rng);
        let one = sensed(&mesh, angles_deg, &noisy, noise_mm);
        let other = sensed(&mesh, [angles_deg[1], angles_deg[0]], &noisy, noise_mm);
        assert_eq!(one.is_ok(), other.is_ok(), "case {case}: {one:?}, {other:?}");
        let (Ok(one), Ok(other)) = (one, other) else { continue };
        for i in 0..2 {
            let off = (one.forces.forces_n[i] - other.forces.forces_n[1 - i]) / one.forces.sigmas_n[i];
            assert!(off.abs() < 0.01, "case {case}: {one:?}, {other:?}");
            let error = (one.forces.forces_n[i] - forces_n[i]) / one.forces.sigmas_n[i];
            assert!(error.abs() < 4.5, "case {case}: {forces_n:?}, {one:?}");
        }
        answered += 1;
    }
    assert!(answered >= 5, "{answered} answered");
}

/// Between unequally spaced ribs, the misfit has minima at several positions. The search once kept the minimum at 41.7 mm, with 0.373 N instead of
/// 0.525 N, because it explains all coordinates although another minimum explains them better.
#[test]
fn a_position_between_unequal_ribs_is_found() {
    let ribs =
        "positions_mm = [[29.2, 30.1], [90.5, 33.3], [92.3, 40.4], [118.8, 70.8], [123.9, 80.9], [130.0, 111.7]]";
    let finger = paper_scene_with(&[("count = 11", ribs)]).finger;
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    let force_n = 0.5253;
    let clean = seen(&mesh, &[at_position(77.05, 0.0)], &[force_n], Kinematics::Corotational).expect("carried");
    let mut rng = random_stream(8, 0);
    for (noise_mm, least_answered) in [(CAMERA_NOISE_MM, 10), (0.03, 20)] {
        let mut answered = 0;
        for case in 0..20 {
            let found = sensed(&mesh, [0.0], &noisy(&clean, noise_mm, &mut rng), noise_mm);
            let Some(error) = largest_error(&found, &[force_n]) else { continue };
            assert!(error < 4.5, "{noise_mm} mm, case {case}: {error} sigma, {found:?}");
            answered += 1;
        }
        assert!(answered >= least_answered, "{noise_mm} mm: {answered} answered");
    }
}
