//! A finger that closes on force sensors, as in the paper's gripper tests.

use finray_model::estimators::EstimatorId;
use finray_model::finger::Plate;
use finray_model::gripper::Gripper;
use finray_model::mesh::Load;
use finray_model::{Finger, Kinematics, Mesh, NodeId, Scene, statics};
use finray_studies::experiments::grasp::modules::{
    ClosedStep, ModuleStep, ModuleStudy, ModuleTest, Untouched, closing,
};
use finray_studies::experiments::table_two::CONTACT_GROUPS;

fn gripper() -> (Finger, Gripper) {
    let scene = Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE).unwrap();
    (scene.finger, scene.gripper.unwrap())
}

fn close_on(nodes: &[usize]) -> Vec<ClosedStep> {
    let (finger, gripper) = gripper();
    closing(&Mesh::with_elements_per_member(&finger, 2), &gripper, nodes).unwrap()
}

/// No rod penetrates the cap of its force sensor, no rod without contact carries a force, and no rod is pulled. If one of two neighbouring rods is
/// pressed, it lifts the plate off the cap of the other rod again, within a Newton step.
#[test]
fn sensors_push_what_they_touch_and_nothing_else() {
    for nodes in [[16, 20], [16, 17]] {
        let steps = close_on(&nodes);
        assert!(steps.len() > 10, "{nodes:?}: {}", steps.len());
        let mut untouched = 0;
        for step in &steps {
            for (force_n, gap_mm) in step.true_n.iter().zip(&step.gaps_mm) {
                assert!(*force_n >= 0.0 && *gap_mm >= -1e-8, "{step:?}");
                assert!(*force_n == 0.0 || gap_mm.abs() <= 1e-8, "{step:?}");
            }
            untouched += usize::from(step.true_n[0] == 0.0);
        }
        assert!(untouched > 0 && untouched < steps.len(), "{nodes:?}: {untouched} of {}", steps.len());
    }
}

/// The force in the first step is the travel of the base since contact, divided by the node's compliance. The displacements in the step equal those
/// of a finger under the computed force.
#[test]
fn a_force_is_way_over_compliance() {
    let (finger, gripper) = gripper();
    let node = NodeId(19);
    let step = &close_on(&[node.0])[0];
    // The rod meets its cap 45 degrees after the start, at a motor angle of 315 degrees.
    let right = |motor_deg: f64| gripper.fingers(&gripper.pose(motor_deg).unwrap())[1];
    let reached_mm = |motor_deg: f64| right(motor_deg).outwards(finger.position(node)).x;
    let way_mm = reached_mm(315.0) - reached_mm(360.0 - step.turned_deg);
    let along = finger.direction(step.axis_deg);
    let bends = |load: Load, kinematics| {
        statics::solve(&Mesh::with_elements_per_member(&finger, 2), &[load], kinematics).unwrap()
    };
    let gives_mm = bends(Load::at_node(node, along), Kinematics::Linear).motion(node).displacement.dot(&along);
    // The tolerance covers geometric nonlinearity, which has an effect of some per cent at a tenth of a newton.
    assert!((step.true_n[0] * gives_mm / way_mm - 1.0).abs() < 0.05, "{} N, {way_mm} mm", step.true_n[0]);
    let shape = bends(Load::at_node(node, along * step.true_n[0]), Kinematics::Corotational);
    for marker in step.displacements.markers() {
        assert!((marker.displacement - shape.motion(marker.node).displacement).norm() < 1e-6, "{marker:?}");
    }
    assert!(finger.plate_nodes(Plate::Front).contains(&node));
}

/// As in the paper's figure, the node nearer to the base is pressed first; later, the force at the other node is larger.
#[test]
fn forces_at_two_nodes_cross() {
    let steps = close_on(&[18, 20]);
    let [first, last] = [&steps[0], &steps[steps.len() - 1]];
    assert!(first.true_n[0] == 0.0 && first.true_n[1] > 0.0, "{:?}", first.true_n);
    assert!(last.true_n[0] > last.true_n[1] && last.true_n[0] > 1.0, "{:?}", last.true_n);
}

fn step(turned_deg: f64, true_n: [f64; 2], samples: Vec<Option<[f64; 2]>>) -> ModuleStep {
    let samples = samples.into_iter().map(|sample| sample.map(|sensed| sensed.to_vec())).collect();
    ModuleStep { turned_deg, axis_deg: 0.0, true_n: true_n.to_vec(), sensed_n: vec![(EstimatorId::Nonlinear, samples)] }
}

/// Errors are averaged over the forces in the paper's range, then over the tests of a row; refused samples are counted.
#[test]
fn errors_are_means_over_forces_in_range() {
    let small = step(1.0, [0.0, 0.2], vec![Some([9.0, 9.0])]);
    let half = step(2.0, [0.0, 1.0], vec![Some([0.1, 0.8]), None]);
    let full = step(3.0, [1.0, 3.0], vec![Some([1.4, 2.7])]);
    let test =
        |nodes, steps: &[&ModuleStep]| ModuleTest { nodes, steps: steps.iter().map(|step| (*step).clone()).collect() };
    let tests = vec![test(&[19, 20], &[&small, &half, &full]), test(&[16, 17], &[&full])];
    let study = ModuleStudy { noise_mm: 0.0, tests };
    let errors = study.group(&CONTACT_GROUPS[1], EstimatorId::Nonlinear).unwrap();
    let [first, second] = [(0.2 + 0.4 + 0.1) / 3.0, (0.4 + 0.1) / 2.0];
    assert!((errors.force - 0.5 * (first + second)).abs() < 1e-12, "{errors:?}");
    let [first_n, second_n] = [(0.2 + 0.4 + 0.3) / 3.0, (0.4 + 0.3) / 2.0];
    assert!((errors.force_n - 0.5 * (first_n + second_n)).abs() < 1e-12, "{errors:?}");
    let [first_sum, second_sum] = [(0.1 + 0.1 / 4.0) / 2.0, 0.1 / 4.0];
    assert!((errors.sum.unwrap() - 0.5 * (first_sum + second_sum)).abs() < 1e-12, "{errors:?}");
    assert_eq!([errors.answered, errors.refused], [3, 1]);
    assert!(study.group(&CONTACT_GROUPS[2], EstimatorId::Nonlinear).is_none(), "no such tests");
    let mut untouched = Untouched::default();
    study.tests[0].untouched(EstimatorId::Nonlinear, 0.3, &mut untouched);
    assert_eq!(untouched, Untouched { count: 2, within: 1, largest_n: 9.0 });
}
