//! Nonlinear sensing: forces, positions and directions are recovered from displacements of the co-rotational finger.

mod hard_measurements;
mod nuisances;
mod rivals;

use finray_model::finger::Plate;
use finray_model::frame::FrameLoad;
use finray_model::measurement::Measurement;
use finray_model::sensing::{
    Contact, ContactPosition, ContactQuestion, Direction, NearForces, NonlinearEstimator, SensingError, sense_refining,
};
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{
    CAMERA_NOISE_MM, at_node, at_position, built_finger_with_zones, cases, contact_node, force_for_deflection, largest,
    paper, seen,
};
use proptest::prelude::*;

/// For each true force, the largest relative error of the sensed force over all contact nodes and over directions from -60 to 60 degrees. The true
/// shapes are computed on the mesh `truth`.
fn errors_over_the_finger(truth: &Mesh, forces_n: &[f64], sense: impl Fn(Contact, &Measurement) -> f64) -> Vec<f64> {
    let mut worst = vec![0.0_f64; forces_n.len()];
    for node in 13..=24 {
        for angle in [-60.0, -30.0, 0.0, 30.0, 60.0] {
            let contact = at_node(node, angle);
            for (worst, &force) in worst.iter_mut().zip(forces_n) {
                match seen(truth, &[contact], &[force], Kinematics::Corotational) {
                    Ok(measurement) => *worst = largest(&[*worst, sense(contact, &measurement) / force - 1.0]),
                    Err(StaticsError::NoEquilibrium { .. }) => (),
                    Err(error) => panic!("{contact:?}, {force} N: {error}"),
                }
            }
        }
    }
    worst
}

/// On noise-free data of the same model, the force is recovered to rounding. The force is also recovered if the linear starting point is far from it.
/// For 5 N along the plate at the tip, the search once ended in another minimum.
#[test]
fn forces_come_back_from_the_own_model() {
    let mesh = Mesh::key_nodes(&paper());
    let worst = errors_over_the_finger(&mesh, &[0.01, 1.0, 5.0], |contact, measurement| {
        let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("a contact node");
        estimator.estimate(measurement, None).expect("identifiable").forces.forces_n[0]
    });
    assert!(worst.iter().all(|e| *e <= 1e-9), "{worst:?}");
}

/// For true shapes on 684 nodes, the error of the 25-node model is at most 0.8 % up to 3 N. The error of a refined model is at most 0.3 % up to 5 N.
#[test]
fn forces_come_back_from_the_fine_mesh() {
    let finger = paper();
    let (coarse, fine) = (Mesh::key_nodes(&finger), Mesh::with_nodes(&finger, 684).expect("fine mesh"));
    let worst = errors_over_the_finger(&fine, &[0.5, 1.0, 2.0, 3.0], |contact, measurement| {
        let mut estimator = NonlinearEstimator::new(&coarse, &[contact.into()]).expect("a contact node");
        estimator.estimate(measurement, None).expect("identifiable").forces.forces_n[0]
    });
    assert!(worst.iter().all(|e| *e <= 0.008), "25 nodes: {worst:?}");
    let worst = errors_over_the_finger(&fine, &[3.0, 5.0], |contact, measurement| {
        sense_refining(&finger, &[contact.into()], None, measurement, None, None).expect("identifiable").forces.forces_n
            [0]
    });
    assert!(worst.iter().all(|e| *e <= 0.003), "refined: {worst:?}");
}

/// An unknown position, an unknown direction, and both together are found.
#[test]
fn positions_and_directions_are_found() {
    let finger = paper();
    let fine = Mesh::with_nodes(&finger, 684).expect("fine mesh");
    for (s_mm, angle, force) in
        [(20.0, 10.0, 1.5), (55.0, -25.0, 2.0), (76.5, 0.0, 3.0), (101.0, 30.0, 2.5), (140.0, -15.0, 1.0)]
    {
        let contact = at_position(s_mm, angle);
        let measurement = seen(&fine, &[contact], &[force], Kinematics::Corotational).expect("carried");
        let known = (Some(contact.position), Direction::Angle(angle));
        for (position, direction) in [(None, known.1), (known.0, Direction::Auto), (None, Direction::Auto)] {
            let question = ContactQuestion::new(position, direction);
            let found = sense_refining(&finger, &[question], None, &measurement, None, None).expect("identifiable");
            let position = found.contacts[0].position_mm(&finger).expect("on the plate");
            assert!((found.forces.forces_n[0] / force - 1.0).abs() < 2e-3, "{contact:?} {question:?}: {found:?}");
            assert!((position - s_mm).abs() < 0.05, "{contact:?}: {position}");
            assert!((found.contacts[0].angle_deg - angle).abs() < 0.05, "{contact:?}: {found:?}");
        }
    }
}

/// The force acts along the normal of the deformed plate. The direction of a force along the normal of the deformed plate follows from the rotation
/// of the plate at the contact.
#[test]
fn normals_turn_with_the_plate() {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    // Finds a follower force by iteration: a dead force is rotated until it acts along the normal of the plate that it deforms.
    let mut contact = at_node(16, 0.0);
    for _ in 0..40 {
        let load = mesh.frame_load(&contact.load(&finger, 3.0)).expect("a contact node");
        let motion = Statics::ladder(&mesh, Kinematics::Corotational).equilibrium(&[load]).expect("carried").motion;
        contact.angle_deg = mesh.shape(&motion).motion(NodeId(16)).rotation.to_degrees();
    }
    let measurement = seen(&mesh, &[contact], &[3.0], Kinematics::Corotational).expect("carried");
    let question = ContactQuestion::new(Some(contact.position), Direction::NORMAL);
    let mut estimator = NonlinearEstimator::new(&mesh, &[question]).expect("a contact node");
    let found = estimator.estimate(&measurement, None).expect("identifiable");
    assert!(contact.angle_deg.abs() > 2.0, "the plate turns: {}", contact.angle_deg);
    assert!((found.contacts[0].angle_deg - contact.angle_deg).abs() < 1e-3, "{found:?}");
    assert!((found.forces.forces_n[0] / 3.0 - 1.0).abs() < 1e-5, "{found:?}");
}

/// A residual that the stated noise does not explain widens the stated interval. In this test, the true contact is one node away from the stated
/// contact.
#[test]
fn what_noise_does_not_explain_is_uncertainty() {
    let mesh = Mesh::key_nodes(&paper());
    let measurement = seen(&mesh, &[at_node(20, 0.0)], &[2.0], Kinematics::Corotational).expect("carried");
    let ask = |node: usize, noise_mm: f64| {
        let mut estimator = NonlinearEstimator::new(&mesh, &[at_node(node, 0.0).into()]).expect("a contact node");
        estimator.estimate(&measurement, Some(noise_mm)).expect("identifiable").forces
    };
    let (right, wrong) = (ask(20, CAMERA_NOISE_MM), ask(19, CAMERA_NOISE_MM));
    assert_eq!(right.trusted_noise_mm, CAMERA_NOISE_MM);
    assert!(wrong.trusted_noise_mm > 3.0 * CAMERA_NOISE_MM && wrong.sigmas_n[0] > 3.0 * right.sigmas_n[0], "{wrong:?}");
    // A stated noise that is large enough to explain the residual is kept.
    assert_eq!(ask(19, 1.0).trusted_noise_mm, 1.0);
}

/// Unknowns that are not identifiable are refused.
#[test]
fn what_is_not_identifiable_is_refused() {
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let faint = seen(&mesh, &[at_node(24, 0.0)], &[0.02], Kinematics::Corotational).expect("carried");
    let ask = |questions: &[ContactQuestion], measurement: &Measurement| {
        NonlinearEstimator::new(&mesh, questions)?
            .estimate(measurement, Some(CAMERA_NOISE_MM))
            .map(|found| found.forces.forces_n)
    };
    let auto = ContactQuestion::new(Some(ContactPosition::Node(NodeId(24))), Direction::Auto);
    assert!(matches!(ask(&[auto], &faint), Err(SensingError::Undetermined { .. })));
    assert!(matches!(ask(&[], &faint), Err(SensingError::NoContact)));
    let elsewhere = ContactQuestion::from(at_node(5, 0.0));
    assert!(matches!(ask(&[elsewhere], &faint), Err(SensingError::NotAContactNode { .. })));
    let few = faint.clone().without(&finger.free_nodes().filter(|n| n.0 != 19).collect::<Vec<_>>());
    let three: Vec<ContactQuestion> = [16, 18, 20].map(|n| at_node(n, 0.0).into()).to_vec();
    assert!(matches!(ask(&three, &few), Err(SensingError::TooFewMarkers { unknowns: 3, coordinates: 2 })));
}

proptest! {
    #![proptest_config(cases(96))]

    /// On any finger, the ladder solver's sensitivities to an added load and to a moved load equal differences of equilibria.
    #[test]
    fn sensitivities_are_differences_of_equilibria(
        finger in built_finger_with_zones(),
        elements in 1..4_usize,
        at in [0.0..1.0, 0.1..0.95],
        angle in -60.0..60.0,
        share in 0.002..0.01,
    ) {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        let node = contact_node(&finger, at[0]);
        let length = finger.description().front_length_mm;
        let force = force_for_deflection(&finger, node, angle, share);
        let position = |s_mm: f64| mesh.frame_load(&Load::at_position(s_mm, force * 0.5)).expect("on the plate");
        let bent = mesh.frame_load(&Load::at_node(node, force)).expect("a contact node");
        let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
        let mut displacements = |loads: &[FrameLoad]| {
            statics.equilibrium(loads).ok().map(|found| mesh.shape(&found.motion).motions().iter().map(|m| m.marker_displacement(&finger)).collect::<Vec<_>>())
        };
        let (step, shift) = (1e-4, 1e-4 * length);
        let s_mm = at[1] * length;
        let all = [
            displacements(&[bent, position(s_mm)]),
            displacements(&[bent.scaled(1.0 + step), position(s_mm)]),
            displacements(&[bent.scaled(1.0 - step), position(s_mm)]),
            displacements(&[bent, position(s_mm + shift)]),
            displacements(&[bent, position(s_mm - shift)]),
        ];
        let [Some(_), Some(more), Some(less), Some(further), Some(nearer)] = all else {
            return Err(TestCaseError::reject("no equilibrium"));
        };
        let loads = [bent, position(s_mm)];
        let found = statics.equilibrium(&loads).expect("found before");
        prop_assert!(statics.linearise(&found.motion, &loads));
        let mut rates = vec![Vector::zeros(); finger.key_node_count()];
        statics.equations_mut().added_load(&found.motion, &bent, &mut rates);
        let largest = rates.iter().map(|u| u.norm()).fold(0.0, f64::max);
        for (node, rate) in rates.iter().enumerate() {
            let difference: Vector = (more[node] - less[node]) / (2.0 * step);
            prop_assert!((difference - rate).norm() <= 1e-4 * largest, "added, node {node}: {difference} against {rate}");
        }
        // Only loads that stay on one element are compared, because displacements have a kink at an arm and at a node between two elements.
        let [FrameLoad::Interior { member: a, .. }, FrameLoad::Interior { member: b, .. }] =
            [position(s_mm + shift), position(s_mm - shift)] else { return Err(TestCaseError::reject("a kink")) };
        prop_assume!(a == b);
        statics.equations_mut().moved_load(&found.motion, &loads[1], Plate::Front, &mut rates);
        let largest = rates.iter().map(|u| u.norm()).fold(0.0, f64::max);
        for (node, rate) in rates.iter().enumerate() {
            let difference: Vector = (further[node] - nearer[node]) / (2.0 * shift);
            prop_assert!((difference - rate).norm() <= 1e-4 * largest, "moved, node {node}: {difference} against {rate}");
        }
    }
}

/// An estimate that starts from known forces returns the same result as any other estimate, in at most three steps, as for a frame of a stream.
#[test]
fn an_estimate_starts_from_forces_that_are_known() -> Result<(), Box<dyn std::error::Error>> {
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
    let contacts = [16, 21].map(|node| Contact::at_node(NodeId(node)));
    let mut estimator = NonlinearEstimator::new(&mesh, &contacts.map(ContactQuestion::from))?;
    for forces_n in [[0.8, 0.4], [2.0, 2.5], [0.3, 3.0]] {
        let pairs = contacts.iter().zip(forces_n);
        let loads: Vec<_> = pairs.map(|(c, f)| mesh.frame_load(&c.load(&finger, f))).collect::<Result<_, _>>()?;
        let seen = Measurement::of_shape(&finger, &mesh.shape(&statics.equilibrium(&loads)?.motion));
        estimator.forget();
        let cold = estimator.estimate(&seen, Some(CAMERA_NOISE_MM))?;
        let near = NearForces { contacts: &contacts, forces_n: &forces_n, shape: None };
        let held = estimator.estimate_near(near, false, &seen, Some(CAMERA_NOISE_MM))?;
        assert!(held.steps <= 3 && held.steps < cold.steps, "{} steps, {} from nothing", held.steps, cold.steps);
        for i in 0..2 {
            assert!((held.forces.forces_n[i] / cold.forces.forces_n[i] - 1.0).abs() < 1e-6, "{held:?}, {cold:?}");
            assert!((held.forces.sigmas_n[i] / cold.forces.sigmas_n[i] - 1.0).abs() < 1e-6, "{held:?}, {cold:?}");
        }
    }
    Ok(())
}
