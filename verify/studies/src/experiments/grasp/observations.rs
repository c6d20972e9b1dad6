//! The paper's observations of grasps (sec. V-D, Figs. 14 and 16): equal forces of both fingers, no force without contact, equal forces while opening
//! and closing.

use super::modules::{ModuleStudy, Untouched};
use super::study::GraspStudy;
use super::{FingerStep, GraspStep, Phase};
use crate::experiments::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::noise::Noise;
use std::collections::{BTreeMap, BTreeSet};

/// Nodes at which the paper senses forces simultaneously.
const NODES: std::ops::RangeInclusive<usize> = 16..=20;
/// Up to this value (N), the paper calls a force sensed at a node without contact a small error.
pub const SMALL_N: f64 = 0.3;
/// Relative differences are computed only for totals above this share of the largest total.
const COUNTS: f64 = 0.1;
const SEED: u64 = 1;

/// Comparison of grasps with the paper's observations.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
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

impl Evidence for Observations {}

/// Compares the totals of a grasp; `None` if nothing was sensed.
pub fn totals(finger: &Finger, steps: &[GraspStep]) -> Option<Totals> {
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

/// Observations of the grasps with the paper's fingers; `None` without tests of sensor modules.
pub(crate) fn run(
    context: &Context,
    grasps: &[GraspStudy],
    modules: Option<&ModuleStudy>,
) -> Result<Option<Observations>, Refusal> {
    let Some(modules) = modules else { return Ok(None) };
    context.progress.part("observations", 1);
    let of_paper = || grasps.iter().filter(|grasp| grasp.is_paper());
    let objects =
        of_paper().filter_map(|grasp| Some((grasp.name.clone(), totals(context.finger, &grasp.steps)?))).collect();
    let scene = PreparedScene::from(Scene::of_finger(context.finger.clone()));
    let mut untouched =
        [EstimatorId::LeastSquares, EstimatorId::Nonlinear].map(|estimator| (estimator, Untouched::default()));
    let mut noise = Noise::new(SEED);
    for finger in of_paper().flat_map(|grasp| &grasp.steps).flat_map(|step| &step.fingers) {
        let Some(free) = free_nodes(context.finger, finger) else { continue };
        let exact = Measurement::of_shape(context.finger, &finger.shape);
        let seen = noise.on(&exact, context.noise_mm);
        let contacts: Vec<Contact> = NODES.map(|node| along_normal(finger, NodeId(node))).collect();
        for (estimator, found) in &mut untouched {
            let sensor = Sensor::new(scene.clone(), SensorContacts::known(&contacts), SensorOptions::of(*estimator))?;
            let Ok(sensed) = sensor.sense_displacements(&seen, Some(context.noise_mm), None) else { continue };
            let at_free = NODES.zip(&sensed.forces).filter(|(node, _)| free.contains(node));
            at_free.for_each(|(_, sensed)| found.add(sensed.force_n, SMALL_N));
        }
    }
    let mut beside_sensor = Untouched::default();
    modules.tests.iter().for_each(|test| test.untouched(EstimatorId::Nonlinear, SMALL_N, &mut beside_sensor));
    context.progress.step();
    Ok(Some(Observations { noise_mm: context.noise_mm, objects, untouched: untouched.to_vec(), beside_sensor }))
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
