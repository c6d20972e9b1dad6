//! Sensed forces in a grasp: errors without noise, and coverage of the intervals with noise.

use super::world::{disc, steps_of};
use finray_contact::press::{HalfSpan, SensedStep};
use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::{Scene, Vector};
use finray_studies::experiments::grasp::{GraspScene, GraspStep, NotSensed};
use finray_studies::settings::{CAMERA_NOISE_MM, TWO_SIDED_95};
use finray_tests::repetitions;

/// Sensed forces of all fingers in steps with contact.
fn sensed(steps: &[GraspStep]) -> impl Iterator<Item = &SensedStep> {
    let fingers = steps.iter().flat_map(|step| &step.fingers);
    fingers.filter_map(|finger| finger.sensed.as_ref().expect("an answer").as_ref())
}

/// The shipped disc scene, without friction.
fn smooth_disc() -> GraspScene {
    let text = disc(&[("friction = 0.4", "friction = 0.0")]);
    GraspScene::new(&Scene::from_toml(&text).unwrap(), &[]).unwrap()
}

/// The shipped wedge without a path of the gripper. The wedge presses on the plate between two rods, and on a rod together with the plate beside this
/// rod.
fn wedge(friction: f64) -> GraspScene {
    let text = disc(&[
        ("shape = \"disc\"\nradius_mm = 15.0", "shape = \"polygon\"\npoints_csv = \"unused\""),
        ("fixed_joint_mm = 30.0", "fixed_joint_mm = 34.0"),
        ("friction = 0.4", &format!("friction = {friction:?}")),
        ("centre_mm = [3.0, 110.0]", "centre_mm = [0.0, 108.0]"),
        ("motor_deg = [0.0, -495.0]", "motor_deg = [225.0, -540.0]"),
        ("path_mm = [[0.0, -40.0], [60.0, -40.0], [60.0, 0.0]]\npath_steps = 12\n", ""),
    ]);
    let corners = [[-8.0, -25.0], [8.0, -25.0], [20.0, 25.0], [-20.0, 25.0]].map(|[x, y]| Vector::new(x, y));
    GraspScene::new(&Scene::from_toml(&text).unwrap(), &corners).unwrap()
}

/// Without noise and friction, totals are accurate to 1 % and contact forces to 10 %, also for contacts with several touches.
#[test]
fn forces_of_a_grasp_are_sensed() {
    for scene in [smooth_disc(), wedge(0.0)] {
        let (steps, _) = steps_of(&scene.with_fineness(4), 0.0, 1);
        let largest_n = steps.iter().map(|step| step.fingers[0].total_n).fold(0.0, f64::max);
        let (mut totals, mut contacts) = (0, 0);
        for sensed in sensed(&steps) {
            if sensed.total.true_n > 0.1 * largest_n {
                totals += 1;
                assert!(sensed.total.relative_error().abs() < 0.01, "{:?}", sensed.total);
            }
            for contact in sensed.contacts.iter().filter(|contact| contact.force.true_n > 0.1 * largest_n) {
                contacts += 1;
                assert!(contact.force.relative_error().abs() < 0.1, "{:?}", contact.force);
            }
        }
        assert!(totals >= 20 && contacts >= totals, "{totals} and {contacts}");
    }
}

/// Several estimators can sense a grasp. Without friction and noise, totals that the nonlinear estimator senses are accurate to 1 %. The linear
/// estimator has its linearisation error, and a network refuses contacts for which it was not trained.
#[test]
fn other_estimators_sense_a_grasp() {
    let networks = Networks::read(&finray_fixtures::NETWORKS).unwrap();
    let scene_by = |estimator| smooth_disc().with_fineness(4).with_estimator(estimator, networks.clone());
    let worst_of = |estimator| {
        let (steps, _) = steps_of(&scene_by(estimator), 0.0, 1);
        let largest_n = steps.iter().map(|step| step.fingers[0].total_n).fold(0.0, f64::max);
        let totals = sensed(&steps).map(|sensed| sensed.total).filter(|total| total.true_n > 0.1 * largest_n);
        totals.map(|total| total.relative_error().abs()).fold(0.0, f64::max)
    };
    let [nonlinear, linear] = [EstimatorId::Nonlinear, EstimatorId::LeastSquares].map(worst_of);
    assert!(nonlinear < 0.01 && linear > 2.0 * nonlinear && linear < 0.2, "{nonlinear} and {linear}");
    let (steps, _) = steps_of(&scene_by(EstimatorId::Network), 0.0, 1);
    let fingers = || steps.iter().flat_map(|step| &step.fingers);
    let [refused, answered] = [
        fingers().filter(|finger| matches!(finger.sensed, Err(NotSensed::Refused(_)))).count(),
        fingers().filter(|finger| matches!(finger.sensed, Ok(Some(_)))).count(),
    ];
    assert!(refused > 0 && answered > 0, "{refused} and {answered}");
}

/// Friction on the plate acts at half the plate's thickness in front of the middle line. A contact between two rods is sensed equally well with and
/// without friction. Friction was once applied at the middle line, and normal forces had errors of 2 %.
#[test]
fn friction_is_not_put_on_the_middle_line_of_the_plate() {
    let (steps, _) = steps_of(&wedge(0.3), 0.0, 1);
    // Selects steps with one contact that has one touch, where friction is at least a tenth of the normal force.
    let dragged = |step: &&GraspStep| {
        let contacts = &step.fingers[0].contacts;
        contacts.len() == 1
            && contacts[0].half_span == HalfSpan::default()
            && contacts[0].friction_n.abs() > 0.1 * contacts[0].normal_n
            && contacts[0].normal_n > 1.5
    };
    let mut count = 0;
    for step in steps.iter().filter(dragged) {
        let (_, contact) = step.fingers[0].contacts_sensed().next().expect("a contact");
        let error = contact.expect("an answer").force.relative_error();
        assert!(error.abs() < 3e-3, "step {}: {error}", step.step);
        count += 1;
    }
    assert!(count >= 5, "{count}");
}

/// For the shipped disc and the wedge under the camera's noise, the 95 % intervals have their nominal coverage.
#[test]
fn intervals_of_a_grasp_hold_the_true_forces() {
    let grasped = GraspScene::new(&Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE).unwrap(), &[]).unwrap();
    for (scene, seeds) in [(grasped, repetitions(1, 4)), (wedge(0.3), repetitions(1, 3))] {
        let (mut totals, mut contacts) = ([0, 0], [0, 0]);
        for seed in 1..=seeds {
            let (steps, _) = steps_of(&scene, CAMERA_NOISE_MM, seed);
            for sensed in sensed(&steps) {
                let count = |[held, all]: &mut [usize; 2], standardised: f64| {
                    *held += usize::from(standardised.abs() <= TWO_SIDED_95);
                    *all += 1;
                };
                count(&mut totals, sensed.total.standardised_error());
                sensed.contacts.iter().for_each(|contact| count(&mut contacts, contact.force.standardised_error()));
            }
        }
        for [held, all] in [totals, contacts] {
            // The limit is three standard deviations below 95 %.
            let least = 0.95 - 3.0 * (0.95 * 0.05 / all as f64).sqrt();
            assert!(all > 30 * seeds as usize && held as f64 >= least * all as f64, "{held} of {all}");
        }
    }
}
