//! The protocol of Table I of Xu et al. (2021): weights on a single finger, with the force sensed by the linear model.

use super::{Context, Evidence, ExperimentError};
use crate::prelude::*;
use crate::settings::TABLE_ONE_ANGLES_DEG;
use crate::truths::{Truth, TruthId};
use finray_model::calibration::{self, CalibrationCase};

/// Standard gravity, m/s^2 (CGPM 1901).
pub const STANDARD_GRAVITY: f64 = 9.80665;
/// Masses of the weights, g (sec. V-A and V-B).
pub const WEIGHTS_G: [f64; 6] = [50.0, 100.0, 150.0, 200.0, 250.0, 300.0];
/// Nodes at which Young's modulus is calibrated (sec. V-A).
pub const CALIBRATION_NODES: [NodeId; 3] = [NodeId(17), NodeId(19), NodeId(21)];
/// Loaded nodes, with the paper's mean relative error at each (Table I, as in the text of sec. V-B).
pub const PAPER_MEAN_ERRORS: [(NodeId, f64); 6] = [
    (NodeId(14), 0.563),
    (NodeId(16), 0.121),
    (NodeId(18), 0.014),
    (NodeId(20), 0.015),
    (NodeId(22), 0.024),
    (NodeId(24), 0.200),
];

/// The paper's largest relative error at nodes 16 and 24 (sec. V-B).
pub const PAPER_LARGEST_ERRORS: [(NodeId, f64); 2] = [(NodeId(16), 0.18), (NodeId(24), 0.242)];
/// The paper's smallest and largest relative error at node 14 (sec. V-B).
pub const PAPER_RANGE_AT_14: [f64; 2] = [0.496, 0.637];
/// Bounds of the mean and of the largest relative error at nodes 18, 20 and 22, as stated by the paper (sec. V-B).
pub const PAPER_MIDDLE_BOUNDS: [f64; 2] = [0.03, 0.05];

/// Force of a weight with mass `weight_g` (g), N.
pub fn weight_n(weight_g: f64) -> f64 {
    weight_g * 1e-3 * STANDARD_GRAVITY
}

/// Results at one loaded node.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableOneRow {
    /// Direction of the weight, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// The loaded node.
    pub node: usize,
    /// Sensed / true - 1 for each weight, dimensionless.
    pub errors: Vec<f64>,
    /// Mean of |sensed / true - 1| over the weights.
    pub mean_error: f64,
    /// Mean relative error that the paper states for this node, dimensionless.
    pub paper_mean_error: f64,
}

impl TableOneRow {
    /// Smallest and largest value of sensed / true - 1 over the weights.
    pub fn range(&self) -> [f64; 2] {
        Span::of(self.errors.iter().copied()).map_or([f64::NAN; 2], Span::ends)
    }
}

/// Table I for one direction of the weights.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableOne {
    /// Type of the true finger.
    pub truth: TruthId,
    /// Direction of the weights, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Ratio of calibrated to true Young's modulus. The modulus is calibrated by eq. (11) of the paper, from the shapes under weights at nodes 17, 19
    /// and 21.
    pub modulus_factor: f64,
    /// One row for each loaded node, from tip to base.
    pub rows: Vec<TableOneRow>,
}

impl Evidence for TableOne {}

/// Results for Table I on the co-rotational finger, one for each assumed direction of the weights; empty unless the finger is the paper's.
pub(crate) fn run(context: &Context) -> Result<Vec<TableOne>, ExperimentError> {
    if !context.is_paper {
        return Ok(Vec::new());
    }
    context.progress.part("Table I", TABLE_ONE_ANGLES_DEG.len());
    let table = |angle_deg| {
        let table = table_one(context.finger, context.corotational, angle_deg, &WEIGHTS_G.map(weight_n));
        context.progress.step();
        table
    };
    TABLE_ONE_ANGLES_DEG.into_iter().map(table).collect()
}

/// Runs the protocol: calibrates the modulus on the true finger, then senses each force at each node without noise. `angle_deg` is the direction of
/// the forces `forces_n` (N, ascending), degrees from the inward normal.
///
/// # Errors
/// [`ExperimentError`] if the true finger has no equilibrium under a force, or a force cannot be sensed.
pub fn table_one(
    finger: &Finger,
    truth: &dyn Truth,
    angle_deg: f64,
    forces_n: &[f64],
) -> Result<TableOne, ExperimentError> {
    let modulus_factor = modulus_factor(finger, truth, angle_deg, forces_n, &CALIBRATION_NODES)?;
    let calibrated = finger.with_modulus_factor(modulus_factor)?;
    let row = |&(node, paper_mean_error): &(NodeId, f64)| -> Result<TableOneRow, ExperimentError> {
        let (contact, shapes) = shapes(truth, node, angle_deg, forces_n)?;
        let mut errors = Vec::new();
        for (shape, force_n) in shapes.iter().zip(forces_n) {
            let measurement = Measurement::of_shape(&calibrated, shape);
            let estimate = LinearEstimator::new(&calibrated, &[contact], &measurement)?.estimate(
                &measurement,
                Some(0.0),
                Prior::None,
            );
            errors.push(estimate.forces_n[0] / force_n - 1.0);
        }
        let mean_error = mean(errors.iter().map(|error| error.abs())).unwrap_or(f64::NAN);
        Ok(TableOneRow { angle_deg, node: node.0, errors, mean_error, paper_mean_error })
    };
    let rows = PAPER_MEAN_ERRORS.par_iter().map(row).collect::<Result<_, _>>()?;
    Ok(TableOne { truth: truth.id(), angle_deg, modulus_factor, rows })
}

/// Ratio of calibrated to assumed Young's modulus, by eq. (11) of the paper, from shapes of the true finger under forces (N) at some nodes.
pub(crate) fn modulus_factor(
    finger: &Finger,
    truth: &dyn Truth,
    angle_deg: f64,
    forces_n: &[f64],
    nodes: &[NodeId],
) -> Result<f64, ExperimentError> {
    let mut cases = Vec::new();
    for &node in nodes {
        let (contact, shapes) = shapes(truth, node, angle_deg, forces_n)?;
        for (shape, &force_n) in shapes.iter().zip(forces_n) {
            let load = contact.load(finger, force_n);
            cases.push(CalibrationCase { load, measurement: Measurement::of_shape(finger, shape) });
        }
    }
    Ok(calibration::youngs_modulus(finger, &cases)?.factor)
}

/// Shapes under ascending weights (N) along the normal at some nodes. At each node the shapes end before the first weight without equilibrium.
pub fn weighed(finger: &Finger, truth: &dyn Truth, nodes: &[NodeId], weights_n: &[f64]) -> Vec<CalibrationCase> {
    let under = |&node: &NodeId| {
        let contact = Contact::at_node(node);
        let shapes = truth.shapes(&contact, weights_n);
        let case = move |(shape, weight_n): (FingerShape, &f64)| CalibrationCase {
            load: contact.load(finger, *weight_n),
            measurement: Measurement::of_shape(finger, &shape),
        };
        shapes.into_iter().zip(weights_n).map(case).collect::<Vec<_>>()
    };
    nodes.iter().flat_map(under).collect()
}

/// Shapes of the true finger under all forces (N) at a node and direction (degrees).
fn shapes(
    truth: &dyn Truth,
    node: NodeId,
    angle_deg: f64,
    forces_n: &[f64],
) -> Result<(Contact, Vec<FingerShape>), ExperimentError> {
    let contact = Contact { position: ContactPosition::Node(node), angle_deg };
    let shapes = truth.shapes(&contact, forces_n);
    match forces_n.get(shapes.len()) {
        Some(&force_n) => Err(ExperimentError::NotCarried { node, force_n }),
        None => Ok((contact, shapes)),
    }
}
