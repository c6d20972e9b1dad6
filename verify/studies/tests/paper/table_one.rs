//! The protocol of Table I: weights on a single finger, with the force sensed by the linear model.

use super::{WEIGHTS_N, ends, joined, percent, same};
use finray_model::calibration::{CalibrationCase, youngs_modulus};
use finray_model::measurement::Measurement;
use finray_model::sensing::{ForcePrior, LinearEstimator};
use finray_model::{Finger, Kinematics};
use finray_studies::exports::calculix;
use finray_studies::truths::{ExportedTruth, MeshTruth, Truth, TruthId, fine_mesh};
use finray_tests::{assert_recorded, assert_said, at_node, paper};
use serde::{Deserialize, Serialize};

/// Loaded nodes, with the paper's mean relative error at each (Table I, as in the text of sec. V-B).
pub const NODES: [(usize, f64); 6] = [(14, 0.563), (16, 0.121), (18, 0.014), (20, 0.015), (22, 0.024), (24, 0.200)];
/// The paper's error is large at nodes where it exceeds this value, at which the paper's shading begins.
pub const LARGE: f64 = 0.1;
/// Nodes at which Young's modulus is calibrated (sec. V-A).
pub const CALIBRATION_NODES: [usize; 3] = [17, 19, 21];
/// Directions assumed for the paper's "vertical" weights, degrees from the inward normal. A horizontal axis of the finger gives 10.9 degrees.
pub const ANGLES_DEG: [f64; 5] = [0.0, 10.9, -20.0, 20.0, 40.0];

/// Table I for one direction of the weights.
#[derive(Debug, Clone)]
pub struct TableOne {
    pub angle_deg: f64,
    /// Ratio of calibrated to true Young's modulus, by eq. (11) of the paper.
    pub modulus_factor: f64,
    /// Sensed / true - 1 for each weight, at each of [`NODES`].
    pub errors: Vec<Vec<f64>>,
}

impl TableOne {
    pub fn mean_error(&self, row: usize) -> f64 {
        self.errors[row].iter().map(|error| error.abs()).sum::<f64>() / self.errors[row].len() as f64
    }
}

/// Shapes of the true finger under each force (N) at a node.
pub fn cases(
    finger: &Finger,
    truth: &dyn Truth,
    node: usize,
    angle_deg: f64,
    forces_n: &[f64],
) -> Vec<CalibrationCase> {
    let contact = at_node(node, angle_deg);
    let shapes = truth.shapes(&contact, forces_n);
    assert_eq!(shapes.len(), forces_n.len(), "node {node} carries every weight");
    let case = |(shape, &force_n): (&_, &f64)| CalibrationCase {
        load: contact.load(finger, force_n),
        measurement: Measurement::of_shape(finger, shape),
    };
    shapes.iter().zip(forces_n).map(case).collect()
}

/// Ratio of calibrated to assumed Young's modulus, from shapes of the true finger under forces (N) at some nodes.
pub fn modulus_factor(finger: &Finger, truth: &dyn Truth, angle_deg: f64, forces_n: &[f64], nodes: &[usize]) -> f64 {
    let cases: Vec<_> = nodes.iter().flat_map(|&node| cases(finger, truth, node, angle_deg, forces_n)).collect();
    youngs_modulus(finger, &cases).expect("a modulus").factor
}

/// Calibrates the modulus on the true finger, then senses each force (N) at each node without noise.
pub fn table_one(finger: &Finger, truth: &dyn Truth, angle_deg: f64, forces_n: &[f64]) -> TableOne {
    let modulus_factor = modulus_factor(finger, truth, angle_deg, forces_n, &CALIBRATION_NODES);
    let calibrated = finger.with_modulus_factor(modulus_factor).expect("a finger");
    let errors = NODES.map(|(node, _)| {
        let sense = |(case, force_n): (CalibrationCase, &f64)| {
            let seen = Measurement::new(&calibrated, case.measurement.markers().iter().copied()).expect("markers");
            let estimator = LinearEstimator::new(&calibrated, &[at_node(node, angle_deg)], &seen).expect("a contact");
            estimator.estimate(&seen, Some(0.0), ForcePrior::None).forces_n[0] / force_n - 1.0
        };
        cases(finger, truth, node, angle_deg, forces_n).into_iter().zip(forces_n).map(sense).collect()
    });
    TableOne { angle_deg, modulus_factor, errors: errors.into() }
}

/// Table I on the uniform co-rotational finger, for each assumed direction of the weights.
pub fn uniform() -> Vec<TableOne> {
    let finger = paper();
    let mesh = fine_mesh(&finger).expect("a mesh");
    let truth = MeshTruth::new(TruthId::Corotational, &mesh, Kinematics::Corotational).expect("a finger");
    ANGLES_DEG.map(|angle_deg| table_one(&finger, &truth, angle_deg, &WEIGHTS_N)).into()
}

#[derive(Debug, Serialize, Deserialize)]
struct Row {
    angle_deg: f64,
    node: usize,
    weight_g: f64,
    error: f64,
    mean_error: f64,
    paper_mean_error: f64,
    modulus_factor: f64,
}

#[test]
fn table_one_is_recorded() {
    let tables = uniform();
    let mut rows = Vec::new();
    for table in &tables {
        for (i, (node, paper_mean_error)) in NODES.into_iter().enumerate() {
            rows.extend(table.errors[i].iter().enumerate().map(|(weight, &error)| Row {
                angle_deg: table.angle_deg,
                node,
                weight_g: 50.0 * (weight + 1) as f64,
                error,
                mean_error: table.mean_error(i),
                paper_mean_error,
                modulus_factor: table.modulus_factor,
            }));
        }
    }
    let agree = |a: &Row, b: &Row| {
        (a.angle_deg, a.node, a.weight_g, a.paper_mean_error) == (b.angle_deg, b.node, b.weight_g, b.paper_mean_error)
            && same(a.error, b.error)
            && same(a.mean_error, b.mean_error)
            && same(a.modulus_factor, b.modulus_factor)
    };
    assert_recorded("table_one.csv", |_| true, rows, agree);
    let large = NODES.into_iter().enumerate().filter(|(_, (_, paper))| *paper > LARGE);
    let explained = large.map(|(i, (node, paper))| {
        let errors = tables.iter().map(|table| table.mean_error(i));
        assert!(errors.clone().all(|error| error < 0.5 * paper), "less than half at node {node}");
        let [least, most] = ends(errors).map(percent);
        format!("node {node} (paper {}, ours {least} to {most})", percent(paper))
    });
    let sentence = format!(
        "In simulation, over the assumed directions, geometric nonlinearity alone accounts for less than half of the paper's error at {}. The causes \
         of the remaining errors are not determined here.",
        joined(explained, ", ")
    );
    assert_said("table-one", "says", sentence);
}

/// On a plane continuum with rods, the paper's protocol finds a wrong modulus. Its errors of the sensed force stay below half of the paper's error
/// wherever the paper's error is large, and are negative at node 14.
#[test]
fn the_continuum_does_not_explain_the_papers_errors_at_tip_and_base() {
    let truth = ExportedTruth::of(TruthId::Continuum, &calculix::PROGRAM, &calculix::PAPER).expect("an export");
    let tables = [-20.0, 0.0, 20.0].map(|angle_deg| table_one(&paper(), &truth, angle_deg, &[0.5, 1.0, 3.0]));
    let [least, most] = ends(tables.iter().map(|table| table.modulus_factor));
    let at_node = NODES.into_iter().enumerate().map(|(i, (node, paper))| {
        assert!(paper < LARGE || tables.iter().all(|table| table.mean_error(i) < 0.5 * paper), "node {node}");
        let [least, most] = ends(tables.iter().flat_map(|table| table.errors[i].clone())).map(|it| 100.0 * it);
        assert!(node != 14 || most < 0.0, "{most}");
        format!("{least:+.0} to {most:+.0} % at node {node} (paper {})", percent(paper))
    });
    let sentence = format!(
        "The paper's protocol on a plane continuum with rods, under 0.5, 1, 3 N at -20, 0, 20 deg, yields {least:.2} to {most:.2} times the true \
         modulus; forces err by {}. These errors exceed half of the paper's error at 0 of the 3 nodes at which the paper's error is large.",
        joined(at_node, ", ")
    );
    assert_said("table-one", "text", sentence);
    // `finray calibrate --kinematics linear` with the table's cases at nodes 17, 19 and 21 finds a modulus of 74.197 MPa instead of 47.976 MPa.
    assert!((tables[1].modulus_factor - 74.197 / 47.976).abs() < 1e-4, "{}", tables[1].modulus_factor);
}
