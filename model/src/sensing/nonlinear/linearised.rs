//! The problem linearised at a state: the residual, and its derivatives by the unknowns.

use super::least_squares::LeastSquares;
use super::unknowns::Unknown;
use super::{NonlinearEstimator, State};
use crate::Vector;
use crate::finger::NodeId;
use crate::frame::{FrameMotion, NodeIndex};
use crate::measurement::{Marker, Measurement};
use crate::mesh::Mesh;
use crate::sensing::{Contact, LARGEST_SPAN, SensingError};
use nalgebra::DMatrix;

/// Markers off by more than this many standard deviations count less (Cauchy's weight beyond it).
const OUTLIER_SIGMAS: f64 = 4.5;
/// Ratio of the median of a Rayleigh distribution to the standard deviation of one coordinate.
const RAYLEIGH_MEDIAN: f64 = 1.177_410_022_515_474_6;

/// Dampings between which one is looked for, and the factor between two that are tried.
const DAMPINGS: [f64; 2] = [1e-10, 1e12];
const DAMPING_FACTOR: f64 = 4.0;

const ALL_ALIKE: SensingError = SensingError::IllConditioned { span: f64::INFINITY, limit: LARGEST_SPAN, weakest: 1 };

/// Derivatives of the shape and the weights of the markers; by key node, so that they serve whatever is seen next.
#[derive(Debug, Clone)]
pub(super) struct Linearised {
    /// The frame node that each marker moves with.
    marker_nodes: Vec<NodeIndex>,
    /// Displacements of all key nodes per unit of the first unknown, of the second and so on.
    rates: Vec<Vector>,
    /// Robust weight of a marker, beside its own: 1, and less for an outlier.
    weights: Vec<f64>,
    /// Scale of each unknown.
    pub scales: Vec<f64>,
    /// The last step, in the unknowns' units.
    pub step: Vec<f64>,
    /// Room for the distances whose median is sought, and for the problem that a step solves.
    distances: Vec<f64>,
    problem: LeastSquares,
    /// Length of each column of the derivatives by the scaled unknowns, mm.
    lengths_mm: Vec<f64>,
}

/// What a step does to the linearised finger.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prediction {
    /// Decrease of the misfit, mm^2.
    pub decrease_mm2: f64,
    /// How far it moves the markers, mm: root of the sum over unknowns and markers, each unknown's move counted alone.
    pub reach_mm: f64,
}

/// Distance of a marker from where a motion has it, times its own weight.
fn distance(marker_nodes: &[NodeIndex], marker: &Marker, motion: &FrameMotion) -> Vector {
    (marker.displacement - motion.displacements[marker_nodes[marker.node.0 - 1]]) * marker.weight
}

impl Linearised {
    pub(super) fn new(mesh: &Mesh, unknowns: usize) -> Linearised {
        let key_nodes = mesh.finger().key_node_count();
        Linearised {
            marker_nodes: (1..=key_nodes).map(|node| mesh.marker_node(NodeId(node))).collect(),
            rates: vec![Vector::zeros(); key_nodes * unknowns],
            weights: vec![1.0; key_nodes],
            scales: vec![1.0; unknowns],
            step: Vec::with_capacity(unknowns),
            distances: Vec::with_capacity(key_nodes),
            problem: LeastSquares::default(),
            lengths_mm: Vec::with_capacity(unknowns),
        }
    }

    /// Displacement of a key node per unit of an unknown.
    pub(super) fn rate(&self, unknown: usize, key_node: usize) -> Vector {
        // As many weights as key nodes.
        self.rates[unknown * self.weights.len() + key_node]
    }

    /// Weights of the markers by how far they are off: 1, beyond a limit the square root of Cauchy's weight.
    pub(super) fn weigh(&mut self, motion: &FrameMotion, measurement: &Measurement, noise_mm: Option<f64>) {
        let markers = measurement.markers();
        self.distances.clear();
        self.distances.extend(markers.iter().map(|marker| distance(&self.marker_nodes, marker, motion).norm()));
        let middle = self.distances.len() / 2;
        let median = *self.distances.select_nth_unstable_by(middle, f64::total_cmp).1;
        // The median also stands for what the model itself cannot explain.
        let limit = OUTLIER_SIGMAS * noise_mm.unwrap_or(0.0).max(median / RAYLEIGH_MEDIAN);
        for marker in markers {
            let off = distance(&self.marker_nodes, marker, motion).norm();
            self.weights[marker.node.0 - 1] = if off > limit && limit > 0.0 { limit / off } else { 1.0 };
        }
    }

    /// Sum of the squared weighted differences between what was measured and a motion, mm^2.
    pub(super) fn misfit(&self, motion: &FrameMotion, measurement: &Measurement) -> f64 {
        let weighted = |marker: &Marker| distance(&self.marker_nodes, marker, motion) * self.weights[marker.node.0 - 1];
        measurement.markers().iter().map(|marker| weighted(marker).norm_squared()).sum()
    }

    /// The same without loads: the misfit of the finger at rest.
    pub(super) fn misfit_at_rest(&self, measurement: &Measurement) -> f64 {
        let weighted = |m: &Marker| m.displacement * (m.weight * self.weights[m.node.0 - 1]);
        measurement.markers().iter().map(|marker| weighted(marker).norm_squared()).sum()
    }

    /// Finds the Levenberg-Marquardt step for a damping.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    pub(super) fn solve(
        &mut self,
        motion: &FrameMotion,
        measurement: &Measurement,
        damping: f64,
    ) -> Result<Prediction, SensingError> {
        let (unknowns, coordinates) = (self.scales.len(), measurement.coordinate_count());
        self.pose(measurement, if damping > 0.0 { unknowns } else { 0 });
        self.lengths_mm.clear();
        for j in 0..unknowns {
            let column = self.problem.column_mut(j);
            let length_mm = column.iter().map(|x| x * x).sum::<f64>().sqrt();
            self.lengths_mm.push(length_mm);
            if damping > 0.0 {
                column[coordinates + j] = damping.sqrt() * length_mm;
            }
        }
        let right = self.problem.column_mut(unknowns);
        for (marker, row) in measurement.markers().iter().zip(right.chunks_exact_mut(2)) {
            let difference = distance(&self.marker_nodes, marker, motion) * self.weights[marker.node.0 - 1];
            row.copy_from_slice(difference.as_slice());
        }
        let solution = self.problem.solve().ok_or(ALL_ALIKE)?;
        self.step.clear();
        self.step.extend(solution.iter().zip(&self.scales).map(|(x, scale)| x * scale));
        let reach_mm2: f64 = solution.iter().zip(&self.lengths_mm).map(|(x, length_mm)| (x * length_mm).powi(2)).sum();
        // |b|^2 - |b - A x|^2, from the problem with the damping's rows below.
        let decrease_mm2 = self.problem.explained() + damping * reach_mm2;
        Ok(Prediction { decrease_mm2, reach_mm: reach_mm2.sqrt() })
    }

    /// Finds the step that reaches no further than `longest_mm`, with the smallest damping for that, to a factor of
    /// [`DAMPING_FACTOR`]; the search for it begins with the damping of another step. Returns the damping.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    pub(super) fn shorten(
        &mut self,
        motion: &FrameMotion,
        measurement: &Measurement,
        longest_mm: f64,
        mut damping: f64,
    ) -> Result<(f64, Prediction), SensingError> {
        let [least, most] = DAMPINGS;
        let mut prediction = self.solve(motion, measurement, damping)?;
        while prediction.reach_mm <= longest_mm && damping > least {
            damping /= DAMPING_FACTOR;
            prediction = self.solve(motion, measurement, damping)?;
        }
        while prediction.reach_mm > longest_mm && damping < most {
            damping *= DAMPING_FACTOR;
            prediction = self.solve(motion, measurement, damping)?;
        }
        Ok((damping, prediction))
    }

    /// Changes of the unknowns, in their units, that explain a further displacement of the key nodes best.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    pub(super) fn explained(
        &mut self,
        measurement: &Measurement,
        further: impl Fn(usize) -> Vector,
    ) -> Result<Vec<f64>, SensingError> {
        self.pose(measurement, 0);
        let right = self.problem.column_mut(self.scales.len());
        for (marker, row) in measurement.markers().iter().zip(right.chunks_exact_mut(2)) {
            let node = marker.node.0 - 1;
            row.copy_from_slice((further(node) * (marker.weight * self.weights[node])).as_slice());
        }
        let solution = self.problem.solve().ok_or(ALL_ALIKE)?;
        Ok(solution.iter().zip(&self.scales).map(|(x, scale)| x * scale).collect())
    }

    /// R of the weighted derivatives A = Q R by the scaled unknowns.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    pub(super) fn triangle(&mut self, measurement: &Measurement) -> Result<DMatrix<f64>, SensingError> {
        self.pose(measurement, 0);
        self.problem.solve().ok_or(ALL_ALIKE)?;
        Ok(DMatrix::from_column_slice(self.scales.len(), self.scales.len(), self.problem.triangle()))
    }

    /// Sets up the columns of the derivatives, with zero rows below them.
    fn pose(&mut self, measurement: &Measurement, rows_below: usize) {
        let markers = measurement.markers();
        self.problem.reset(measurement.coordinate_count() + rows_below, self.scales.len());
        for ((j, scale), rates) in self.scales.iter().enumerate().zip(self.rates.chunks_exact(self.weights.len())) {
            let column = self.problem.column_mut(j);
            for (marker, row) in markers.iter().zip(column.chunks_exact_mut(2)) {
                let node = marker.node.0 - 1;
                row.copy_from_slice((rates[node] * (scale * marker.weight * self.weights[node])).as_slice());
            }
        }
    }
}

impl NonlinearEstimator<'_> {
    /// Derivatives of the shape by the unknowns, from the tangent that is factored.
    pub(super) fn differentiate(&mut self, state: &mut State) -> Result<(), SensingError> {
        let finger = self.finger();
        self.rescale(state);
        let State { contacts, loads, motion, linearised, .. } = state;
        let ladder = self.statics.equations_mut();
        for (unknown, rates) in self.unknowns.iter().zip(linearised.rates.chunks_exact_mut(finger.key_node_count())) {
            let turned_deg = match *unknown {
                Unknown::Position(i) => {
                    ladder.moved_load(motion, &loads[i], rates);
                    continue;
                }
                Unknown::Force(_) => 0.0,
                Unknown::Across(_) => 90.0,
            };
            let contact = contacts[unknown.contact()];
            let along = Contact { angle_deg: contact.angle_deg + turned_deg, ..contact };
            ladder.added_load(motion, &self.mesh.frame_load(&along.unit_load(finger))?, rates);
        }
        Ok(())
    }
}
