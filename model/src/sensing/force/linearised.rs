//! The problem linearised at a state: residuals and derivatives of the residuals with respect to the unknowns.

use super::marker_motion::{MarkerPoint, Posed};
use super::priors::PriorRow;
use super::unknowns::Unknown;
use crate::Vector;
use crate::measurement::{Marker, Measurement};
use crate::mesh::Mesh;
use crate::optimise::{GramSchmidt, Prediction, SingularParts};
use crate::sensing::{LARGEST_SPAN, SensingError};
use nalgebra::DMatrix;
use std::sync::Arc;

/// A marker is down-weighted if its residual exceeds this many standard deviations.
const OUTLIER_SIGMAS: f64 = 4.5;
/// Ratio of the median of a Rayleigh distribution to the standard deviation of one coordinate.
const RAYLEIGH_MEDIAN: f64 = 1.177_410_022_515_474_6;

const ALL_ALIKE: SensingError = SensingError::IllConditioned { span: f64::INFINITY, limit: LARGEST_SPAN, weakest: 1 };

/// A measurement, and the standard deviation of one coordinate, mm. `None` if the noise is to be estimated from the residual.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen<'m> {
    pub measurement: &'m Measurement,
    pub marker_noise_mm: Option<f64>,
}

/// Derivatives of the shape, and weights of the markers. Derivatives and weights are stored by key node, so they are valid for any set of markers.
#[derive(Debug, Clone)]
pub(super) struct Linearised {
    /// The unknowns.
    pub unknowns: Arc<[Unknown]>,
    /// Point of the mesh to which each marker belongs.
    pub marker_points: Vec<MarkerPoint>,
    /// Displacements of all key nodes, mm per unit of each unknown, one unknown after the other.
    pub rates: Vec<Vector>,
    /// Buffer for displacements of all key nodes.
    pub room: Vec<Vector>,
    /// Displacements of all key nodes by a correction of the shape that follows, mm. Zero if the shape is in equilibrium.
    pub ahead: Vec<Vector>,
    /// Robust factor on the weight of each marker: 1, or less for an outlier.
    weights: Vec<f64>,
    /// Rows of the priors at the linearised state.
    pub prior_rows: Vec<PriorRow>,
    /// Violations, at the linearised state, of the conditions for contact with an object, mm. Each violation is divided by its standard deviation and
    /// multiplied by the noise.
    misses_mm: Vec<f64>,
    /// Derivatives of the violations of the contact conditions, conditions x unknowns, mm per unit of the unknown.
    touch_rates: DMatrix<f64>,
    /// Scale of each unknown, in the unit of the unknown.
    pub scales: Vec<f64>,
    /// Sign with which each force turns the base. The forces are the first unknowns.
    pub turn_signs: Vec<f64>,
    /// The last step, in the units of the unknowns.
    pub step: Vec<f64>,
    /// Buffer for the markers' distances, whose median is computed. `problem` is the least-squares problem of a step.
    distances: Vec<f64>,
    problem: GramSchmidt,
    /// Length of each column of the derivatives with respect to the scaled unknowns, mm.
    lengths_mm: Vec<f64>,
}

/// Measured minus computed displacement of a marker, times the marker's weight, mm.
fn distance(points: &[MarkerPoint], marker: &Marker, shape: Posed) -> Vector {
    (marker.displacement - points[marker.node.0 - 1].displacement(shape)) * marker.weight
}

impl Linearised {
    pub(super) fn new(mesh: &Mesh, unknowns: &Arc<[Unknown]>) -> Linearised {
        let of = unknowns.clone();
        let unknowns = unknowns.len();
        let key_nodes = mesh.finger().key_node_count();
        Linearised {
            unknowns: of,
            marker_points: MarkerPoint::of_key_nodes(mesh),
            rates: vec![Vector::zeros(); key_nodes * unknowns],
            room: vec![Vector::zeros(); key_nodes],
            ahead: vec![Vector::zeros(); key_nodes],
            weights: vec![1.0; key_nodes],
            prior_rows: Vec::new(),
            misses_mm: Vec::new(),
            touch_rates: DMatrix::zeros(0, unknowns),
            scales: vec![1.0; unknowns],
            turn_signs: Vec::new(),
            step: Vec::with_capacity(unknowns),
            distances: Vec::with_capacity(key_nodes),
            problem: GramSchmidt::default(),
            lengths_mm: Vec::with_capacity(unknowns),
        }
    }

    /// Sets the derivatives of the displacements and of the violated contact conditions with respect to one unknown, from their differences between
    /// two states. `by` is the change of the unknown.
    pub(super) fn take_differences(&mut self, unknown: usize, [before, after]: [(Posed, &[f64]); 2], by: f64) {
        let key_nodes = self.marker_points.len();
        for (rate, point) in self.rates[unknown * key_nodes..].iter_mut().zip(&self.marker_points) {
            *rate = (point.displacement(after.0) - point.displacement(before.0)) / by;
        }
        for (rate, (after, before)) in self.touch_rates.column_mut(unknown).iter_mut().zip(after.1.iter().zip(before.1))
        {
            *rate = (after - before) / by;
        }
    }

    /// Sets the violations of the contact conditions at a state, mm.
    pub(super) fn take_misses(&mut self, misses_mm: Vec<f64>) {
        self.touch_rates = DMatrix::zeros(misses_mm.len(), self.scales.len());
        self.misses_mm = misses_mm;
    }

    /// Derivatives of the violated contact conditions with respect to an unknown, mm per unit of the unknown.
    pub(super) fn touch_rates(&self, unknown: usize) -> &[f64] {
        let conditions = self.touch_rates.nrows();
        &self.touch_rates.as_slice()[unknown * conditions..(unknown + 1) * conditions]
    }

    /// Displacement of a key node's marker in a shape, mm, relative to the expected pose of the base.
    pub(super) fn seen_displacement(&self, key_node: usize, shape: Posed) -> Vector {
        self.marker_points[key_node].displacement(shape)
    }

    /// Displacement of a key node, mm per unit of an unknown.
    pub(super) fn rate(&self, unknown: usize, key_node: usize) -> Vector {
        // `weights` has one entry per key node, so its length is the number of key nodes.
        self.rates[unknown * self.weights.len() + key_node]
    }

    /// Weight of a marker: its own weight times its robust factor.
    pub(super) fn weight(&self, marker: &Marker) -> f64 {
        marker.weight * self.weights[marker.node.0 - 1]
    }

    /// Measured minus computed displacement of a marker, times its weight, mm.
    pub(super) fn distance(&self, marker: &Marker, shape: Posed) -> Vector {
        distance(&self.marker_points, marker, shape) * self.weights[marker.node.0 - 1]
    }

    /// Sets the robust factor of each marker from the distance between its measured and computed positions. The factor is 1 up to a limit of the
    /// distance, and limit / distance beyond the limit. For large distances, the factor limit / distance is the square root of Cauchy's weight.
    pub(super) fn weigh(&mut self, shape: Posed, Seen { measurement, marker_noise_mm }: Seen) {
        // Errors that all markers share leave so few degrees of freedom that the residual of a marker does not show whether it is an outlier.
        if !measurement.shared_errors().is_empty() {
            return;
        }
        let markers = measurement.markers();
        self.distances.clear();
        let distance = |marker: &Marker| {
            distance(&self.marker_points, marker, shape) - self.ahead[marker.node.0 - 1] * marker.weight
        };
        self.distances.extend(markers.iter().map(|marker| distance(marker).norm()));
        let middle = self.distances.len() / 2;
        let median = *self.distances.select_nth_unstable_by(middle, f64::total_cmp).1;
        // Unlike the noise, the median includes the error of the model.
        let limit = OUTLIER_SIGMAS * marker_noise_mm.unwrap_or(0.0).max(median / RAYLEIGH_MEDIAN);
        for marker in markers {
            let off = distance(marker).norm();
            self.weights[marker.node.0 - 1] = if off > limit && limit > 0.0 { limit / off } else { 1.0 };
        }
    }

    /// States that the shape is in equilibrium.
    pub(super) fn is_in_equilibrium(&mut self) {
        self.ahead.fill(Vector::zeros());
    }

    /// Misfit of a shape to the markers, mm^2: sum of the squared weighted differences.
    pub(super) fn misfit(&self, shape: Posed, measurement: &Measurement) -> f64 {
        measurement.markers().iter().map(|marker| self.distance(marker, shape).norm_squared()).sum()
    }

    /// Misfit of the unloaded finger to the markers, mm^2.
    pub(super) fn misfit_at_rest(&self, measurement: &Measurement) -> f64 {
        let weighted = |m: &Marker| m.displacement * (m.weight * self.weights[m.node.0 - 1]);
        measurement.markers().iter().map(|marker| weighted(marker).norm_squared()).sum()
    }

    /// Largest first-order decrease of the markers' misfit, mm^2, by changes of the forces in proportion to `shares`.
    pub(super) fn explained_along(
        &self,
        shares: impl Iterator<Item = f64> + Clone,
        shape: Posed,
        measurement: &Measurement,
    ) -> f64 {
        let (mut along, mut squares) = (0.0, 0.0);
        for marker in measurement.markers() {
            let key_node = marker.node.0 - 1;
            let weight = self.weights[key_node];
            let rates = shares.clone().enumerate().map(|(i, share)| self.rate(i, key_node) * share);
            let rate = rates.sum::<Vector>() * (marker.weight * weight);
            along += rate.dot(&(distance(&self.marker_points, marker, shape) * weight));
            squares += rate.norm_squared();
        }
        if squares > 0.0 { along * along / squares } else { 0.0 }
    }

    /// Computes the Levenberg-Marquardt step for a damping. Returns the predicted decrease of the misfit, mm^2, and the predicted motion of the
    /// markers, mm.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    pub(super) fn solve(
        &mut self,
        shape: Posed,
        measurement: &Measurement,
        damping: f64,
    ) -> Result<Prediction, SensingError> {
        let (unknowns, coordinates) = (self.scales.len(), measurement.coordinate_count());
        let damped_from = coordinates + self.prior_rows.len() + self.misses_mm.len();
        self.pose(measurement, if damping > 0.0 { unknowns } else { 0 });
        self.lengths_mm.clear();
        for j in 0..unknowns {
            let column = self.problem.column_mut(j);
            let length_mm = column.iter().map(|x| x * x).sum::<f64>().sqrt();
            self.lengths_mm.push(length_mm);
            if damping > 0.0 {
                column[damped_from + j] = damping.sqrt() * length_mm;
            }
        }
        let right = self.problem.column_mut(unknowns);
        for (marker, row) in measurement.markers().iter().zip(right.chunks_exact_mut(2)) {
            let node = marker.node.0 - 1;
            let difference = distance(&self.marker_points, marker, shape) - self.ahead[node] * marker.weight;
            row.copy_from_slice((difference * self.weights[node]).as_slice());
        }
        for (value, row) in right[coordinates..].iter_mut().zip(&self.prior_rows) {
            *value = row.left_mm;
        }
        for (value, misses_mm) in right[coordinates + self.prior_rows.len()..].iter_mut().zip(&self.misses_mm) {
            *value = -misses_mm;
        }
        let solution = self.problem.solve().ok_or(ALL_ALIKE)?;
        self.step.clear();
        self.step.extend(solution.iter().zip(&self.scales).map(|(x, scale)| x * scale));
        let reach_mm2: f64 = solution.iter().zip(&self.lengths_mm).map(|(x, length_mm)| (x * length_mm).powi(2)).sum();
        // |b|^2 - |b - A x|^2 without the damping, whose rows are the last rows of the problem.
        let decrease_mm2 = self.problem.explained() + damping * reach_mm2;
        Ok(Prediction { decrease: decrease_mm2, reach: reach_mm2.sqrt() })
    }

    /// Changes of the unknowns, in the units of the unknowns, that best explain the additional displacement `further` of each key node, mm.
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

    /// Singular values and vectors of the weighted derivatives with respect to the scaled unknowns.
    ///
    /// # Errors
    /// [`SensingError::IllConditioned`] if the unknowns are not identifiable.
    pub(super) fn singular_parts(&mut self, measurement: &Measurement) -> Result<SingularParts, SensingError> {
        self.pose(measurement, 0);
        self.problem.solve().ok_or(ALL_ALIKE)?;
        let triangle = DMatrix::from_column_slice(self.scales.len(), self.scales.len(), self.problem.triangle());
        Ok(SingularParts::of(triangle))
    }

    /// Derivatives of the weighted displacements of the markers, and of the priors, rows x unknowns, mm per unit of the unknown.
    pub(super) fn derivatives(&mut self, measurement: &Measurement) -> DMatrix<f64> {
        self.pose(measurement, 0);
        let rows = measurement.coordinate_count() + self.prior_rows.len() + self.misses_mm.len();
        let mut derivatives = DMatrix::zeros(rows, self.scales.len());
        for (j, mut column) in derivatives.column_iter_mut().enumerate() {
            column.copy_from_slice(self.problem.column_mut(j));
            column /= self.scales[j];
        }
        derivatives
    }

    /// Fills the matrix of the derivatives with the rows of markers, priors and contact conditions, and `rows_below` zero rows.
    fn pose(&mut self, measurement: &Measurement, rows_below: usize) {
        let markers = measurement.markers();
        let coordinates = measurement.coordinate_count();
        let below_priors = coordinates + self.prior_rows.len();
        self.problem.reset(below_priors + self.misses_mm.len() + rows_below, self.scales.len());
        for ((j, scale), rates) in self.scales.iter().enumerate().zip(self.rates.chunks_exact(self.weights.len())) {
            let column = self.problem.column_mut(j);
            for (marker, row) in markers.iter().zip(column.chunks_exact_mut(2)) {
                let node = marker.node.0 - 1;
                row.copy_from_slice((rates[node] * (scale * marker.weight * self.weights[node])).as_slice());
            }
        }
        for (i, row) in self.prior_rows.iter().enumerate() {
            self.problem.column_mut(row.index)[coordinates + i] = row.by_unknown * self.scales[row.index];
            if row.by_force != 0.0 {
                for (force, sign) in self.turn_signs.iter().enumerate() {
                    self.problem.column_mut(force)[coordinates + i] = sign * row.by_force * self.scales[force];
                }
            }
        }
        for (j, scale) in self.scales.iter().enumerate() {
            let rows = &mut self.problem.column_mut(j)[below_priors..];
            for (value, by_unknown) in rows.iter_mut().zip(&self.touch_rates.column(j)) {
                *value = by_unknown * scale;
            }
        }
    }
}
