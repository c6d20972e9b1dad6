//! The paper's observations of grasps (sec. V-D, Figs. 14 and 16): equal forces of both fingers, no force without contact, equal forces while opening
//! and closing.

use finray_model::estimators::EstimatorId;
use finray_model::finger::Plate;
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::sensor::{PreparedScene, Sensor, SensorContacts, SensorOptions};
use finray_model::{Finger, NodeId, Scene};
use finray_studies::experiments::grasp::modules::{ModuleStudy, Untouched};
use finray_studies::experiments::grasp::study::GraspStudy;
use finray_studies::experiments::grasp::{Eyes, FingerStep, GraspScene, GraspStep, Phase};
use finray_studies::sampling::noise::Noise;
use finray_studies::study::Study;
use std::collections::{BTreeMap, BTreeSet};

/// Nodes at which the paper senses forces simultaneously.
const NODES: std::ops::RangeInclusive<usize> = 16..=20;
/// Up to this value (N), the paper calls a force sensed at a node without contact a small error.
const SMALL_N: f64 = 0.3;
/// Relative differences are computed only for totals above this share of the largest total.
const COUNTS: f64 = 0.1;
const SEED: u64 = 1;

/// Comparison of grasps with the paper's observations.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    /// Objects grasped by the paper's fingers: name of the object, and comparison of its total forces.
    pub objects: Vec<(String, Totals)>,
    /// For each estimator: forces at nodes 16 to 20, sensed simultaneously. Counts only nodes at least one node spacing away from every contact.
    pub untouched: Vec<(EstimatorId, Untouched)>,
    /// Forces sensed at a sensor module's node that has no contact, while the module's other node has contact.
    pub beside_sensor: Untouched,
}

/// Comparison of the total forces of a grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Totals {
    /// Mean and largest difference of the two fingers' sensed totals in a step, relative to the true total.
    pub left_right: [f64; 2],
    /// Largest difference of the true total between opening and closing at the same motor angle, relative to the largest total. `None` if the gripper
    /// does not open.
    pub opening: Option<f64>,
    /// Largest difference of the true force at a node between opening and closing, relative to the largest force at a node. The force of each contact
    /// is attributed to the nearest node. `None` if the gripper does not open.
    pub opening_at_nodes: Option<f64>,
    /// Largest difference of the sensed total between opening and closing, relative to the largest true total. `None` if the gripper does not open.
    pub opening_sensed: Option<f64>,
}

/// Compares the totals of a grasp; `None` if nothing was sensed.
fn totals(finger: &Finger, steps: &[GraspStep]) -> Option<Totals> {
    let true_n = |step: &GraspStep| mean(step.fingers.each_ref().map(|finger| finger.total_n));
    let sensed_n = |step: &GraspStep| match step.fingers.each_ref().map(FingerStep::sensed_total_n) {
        [Some(left_n), Some(right_n)] => Some([left_n, right_n]),
        _ => None,
    };
    let largest_n = steps.iter().map(true_n).fold(0.0, f64::max);
    let counted = steps.iter().filter(|step| true_n(step) > COUNTS * largest_n);
    let differences: Vec<f64> = counted
        .filter_map(|step| sensed_n(step).map(|[left_n, right_n]| (left_n - right_n).abs() / true_n(step)))
        .collect();
    if differences.is_empty() {
        return None;
    }
    let closing = |at_deg: f64| {
        let there =
            |step: &&GraspStep| matches!(step.phase, Phase::Approach | Phase::Close) && step.motor_deg == at_deg;
        steps.iter().find(there)
    };
    let opening = steps.iter().filter(|step| step.phase == Phase::Open);
    let pairs: Vec<_> = opening.filter_map(|open| Some((open, closing(open.motor_deg)?))).collect();
    let of_pairs = |of: &dyn Fn(&GraspStep) -> Option<f64>| {
        let shares = pairs.iter().filter_map(|(open, close)| Some((of(open)? - of(close)?).abs() / largest_n));
        shares.reduce(f64::max)
    };
    let at_nodes = |step: &GraspStep| step.fingers.each_ref().map(|of| node_forces(finger, of));
    let largest_at_node_n = steps.iter().flat_map(at_nodes).flat_map(BTreeMap::into_values).fold(0.0, f64::max);
    let of_nodes = pairs.iter().flat_map(|(open, close)| {
        let both = at_nodes(open).into_iter().zip(at_nodes(close));
        both.flat_map(|(open, close)| {
            let at = |of: &BTreeMap<NodeId, f64>, node: &NodeId| of.get(node).copied().unwrap_or(0.0);
            let nodes: BTreeSet<NodeId> = open.keys().chain(close.keys()).copied().collect();
            nodes.into_iter().map(move |node| (at(&open, &node) - at(&close, &node)).abs()).collect::<Vec<f64>>()
        })
    });
    let opening_at_nodes = of_nodes.reduce(f64::max).map(|largest_n| largest_n / largest_at_node_n);
    Some(Totals {
        left_right: [
            differences.iter().sum::<f64>() / differences.len() as f64,
            differences.iter().copied().fold(0.0, f64::max),
        ],
        opening: of_pairs(&|step| Some(true_n(step))),
        opening_at_nodes,
        opening_sensed: of_pairs(&|step| sensed_n(step).map(mean)),
    })
}

/// True normal forces, N, by the front-plate node nearest to the contact.
fn node_forces(finger: &Finger, step: &FingerStep) -> BTreeMap<NodeId, f64> {
    let nodes: Vec<(NodeId, f64)> =
        finger.plate_nodes(Plate::Front).into_iter().zip(finger.plate_positions_mm(Plate::Front)).collect();
    let mut forces = BTreeMap::new();
    for contact in &step.contacts {
        let Some(at_mm) = contact.contact.position_mm(finger) else { continue };
        let off_mm = |(_, node_mm): &&(NodeId, f64)| (node_mm - at_mm).abs();
        if let Some((node, _)) = nodes.iter().min_by(|a, b| off_mm(a).total_cmp(&off_mm(b))) {
            *forces.entry(*node).or_insert(0.0) += contact.normal_n;
        }
    }
    forces
}

fn mean([a, b]: [f64; 2]) -> f64 {
    0.5 * (a + b)
}

/// Observations of the grasps of a study with the paper's fingers, and of its sensor modules.
pub fn observations(study: &Study, modules: &ModuleStudy) -> Observations {
    let finger = &study.finger;
    let of_paper = || study.grasps.iter().filter(|grasp| GraspStudy::is_paper(grasp));
    let objects = of_paper().filter_map(|grasp| Some((grasp.name.clone(), totals(finger, &grasp.steps)?))).collect();
    let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
    let mut untouched =
        [EstimatorId::LeastSquares, EstimatorId::Nonlinear].map(|estimator| (estimator, Untouched::default()));
    let mut noise = Noise::new(SEED);
    for step in of_paper().flat_map(|grasp| &grasp.steps).flat_map(|step| &step.fingers) {
        let Some(free) = free_nodes(finger, step) else { continue };
        let seen = noise.on(&Measurement::of_shape(finger, &step.shape), study.noise_mm);
        let contacts: Vec<Contact> = NODES.map(|node| along_normal(step, NodeId(node))).collect();
        for (estimator, found) in &mut untouched {
            let sensor = Sensor::new(scene.clone(), SensorContacts::known(&contacts), SensorOptions::of(*estimator));
            let sensed = sensor.expect("contact nodes").sense_displacements(&seen, Some(study.noise_mm), None);
            let Ok(sensed) = sensed else { continue };
            let at_free = NODES.zip(&sensed.forces).filter(|(node, _)| free.contains(node));
            at_free.for_each(|(_, sensed)| found.add(sensed.force_n, SMALL_N));
        }
    }
    let mut beside_sensor = Untouched::default();
    modules.tests.iter().for_each(|test| test.untouched(EstimatorId::Nonlinear, SMALL_N, &mut beside_sensor));
    Observations { objects, untouched: untouched.to_vec(), beside_sensor }
}

/// Nodes at least one node spacing away from every contact. `None` without contact, or if a contact is outside the range of nodes 16 to 20.
fn free_nodes(finger: &Finger, step: &FingerStep) -> Option<Vec<usize>> {
    let at_mm = |node: usize| finger.front_position_mm(NodeId(node)).unwrap_or(f64::NAN);
    let pitch_mm = at_mm(*NODES.start()) - at_mm(NODES.start() + 1);
    let touched: Vec<f64> = step.contacts.iter().filter_map(|seen| seen.contact.position_mm(finger)).collect();
    let (least_mm, most_mm) = (at_mm(*NODES.end()) - 0.5 * pitch_mm, at_mm(*NODES.start()) + 0.5 * pitch_mm);
    let is_among = |touched_mm: &f64| (least_mm..=most_mm).contains(touched_mm);
    if touched.is_empty() || !touched.iter().all(is_among) {
        return None;
    }
    let is_free = |node: &usize| touched.iter().all(|touched_mm| (touched_mm - at_mm(*node)).abs() >= pitch_mm);
    Some(NODES.filter(is_free).collect())
}

/// A contact at a node, with a force along the deformed plate's normal; the camera sees this normal.
fn along_normal(step: &FingerStep, node: NodeId) -> Contact {
    // A positive rotation of the plate (from x to y) turns the inward normal towards the tip.
    let angle_deg = step.shape.motion(node).rotation.to_degrees();
    Contact { position: ContactPosition::Node(node), angle_deg }
}

/// Totals of a grasp in which the fingers close on the disc on its support, and open again.
fn observed(friction: &str, noise_mm: f64) -> Totals {
    let changes = [
        ("friction = 0.4", friction),
        ("motor_deg = [0.0, -495.0]", "motor_deg = [0.0, -382.5]"),
        ("path_mm = [[0.0, -40.0], [60.0, -40.0], [60.0, 0.0]]\npath_steps = 12", "open = true"),
    ];
    let text = changes.iter().fold(finray_fixtures::GRASPED_DISC_SCENE.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    let grasp = GraspScene::new(&Scene::from_toml(&text).unwrap(), &[]).unwrap().with_fineness(1);
    let mut steps: Vec<GraspStep> = Vec::new();
    grasp.run(&Eyes::Noise(noise_mm), 1, |step| steps.push(step.clone())).unwrap();
    totals(grasp.finger(), &steps).expect("something is sensed")
}

/// Only friction causes a difference between opening and closing, and only noise causes a difference between the two fingers.
#[test]
fn friction_and_noise_make_the_differences() {
    let [smooth, rough, noisy] = [("friction = 0.0", 0.0), ("friction = 0.4", 0.0), ("friction = 0.0", 0.067)]
        .map(|(friction, noise_mm)| observed(friction, noise_mm));
    assert!(smooth.opening.unwrap() < 1e-3, "{smooth:?}");
    assert!(smooth.opening_at_nodes.unwrap() < 1e-3, "{smooth:?}");
    assert!(rough.opening_at_nodes.unwrap() > rough.opening.unwrap(), "contacts slide, {rough:?}");
    assert!(rough.opening.unwrap() > 10.0 * smooth.opening.unwrap(), "{rough:?}");
    assert!(smooth.opening_sensed.unwrap() < 0.01, "{smooth:?}");
    // Without friction, the disc slides to the middle. Without friction and noise, the sensed totals of the two fingers differ only by rounding.
    assert!(noisy.left_right[0] > 3.0 * smooth.left_right[0], "{noisy:?} {smooth:?}");
    assert!(noisy.left_right[0] < noisy.left_right[1] && noisy.left_right[1] < 1.0, "{noisy:?}");
}

#[test]
fn nothing_sensed_is_nothing_observed() {
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).unwrap().finger;
    assert_eq!(totals(&finger, &[]), None);
}
