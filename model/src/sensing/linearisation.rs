//! Error of estimated forces due to linearisation, computed at these forces.

use super::{Contact, SensingError, halved_below};
use crate::frame::{FrameLoad, FrameMotion};
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::statics::{Ladder, Statics, StaticsError};
use crate::{Kinematics, Vector};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Grid spacing of the tabulated forces, as a share of a reference force. The reference force is the largest force, rounded down to a power of two.
/// Extrapolation from a grid point causes an error of some thousandths of the error of linearisation.
const GRID: f64 = 0.05;
/// The table is cleared when it has this number of grid points. A stream of frames needs only a few grid points.
const MOST_POINTS: usize = 256;
/// Newton's method fails after this number of steps; two or three steps are usual.
const MAX_STEPS: usize = 30;
/// A Newton step makes progress if at most this share of the distance from the target remains. After a step without progress, the next step is halved.
const CLOSER: f64 = 0.9;
/// Newton's method fails after more than this number of steps without progress.
const MOST_ASTRAY: usize = 4;
/// Newton's method has converged if a step changes no force by more than this share of the largest force.
const STEP_TOLERANCE: f64 = 1e-6;
/// Newton's method fails after this number of refused steps: the first limit is for a single force, the second for several forces. A step is refused
/// if it leads to forces without equilibrium. For a single force, the smallest and the largest value with an equilibrium are stored, so refused steps
/// are cheap. A refused step is shortened: if equilibria exist up to some share of the step, the new step is between half of this share and the full
/// share.
const MOST_REFUSED: [usize; 2] = [30, 8];

/// Error that a linear estimator makes on the co-rotational finger.
///
/// # Requirements
/// The position and direction of each contact must be known. The gain and compliance of the linear estimator at the markers must be known as well.
///
/// # Reference
/// Under forces f, the co-rotational finger has displacements u(f), and the linear estimator returns f + G (u(f) - C f). Here G is the gain and C the
/// compliance of the estimator (weighted, at the markers). The error of estimated forces f' is f' - f, where f solves f + G (u(f) - C f) = f'.
/// Newton's method finds f with derivatives from the tangent stiffness.
#[derive(Debug, Clone)]
pub struct Linearisation {
    mesh: Arc<Mesh>,
    contacts: Vec<Contact>,
    /// Smallest and largest value of a single force for which an equilibrium exists, N. A limit is infinite until the limit is known.
    ends_n: [f64; 2],
    /// Gains of the points. Other markers have another gain, and so has a prior with another noise.
    gains: Vec<DMatrix<f64>>,
    points: Vec<Point>,
}

/// Gain and compliance of a linear estimator.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearModel<'e> {
    /// Gain G, N/mm: one row per force, two columns per marker.
    pub(super) gain: &'e DMatrix<f64>,
    /// Weighted compliance C, mm/N: two rows per marker, one column per force.
    pub(super) compliance: &'e DMatrix<f64>,
}

/// Error of linearisation of estimated forces.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinearisationError {
    /// Estimated minus true force of each contact, N.
    pub(super) error_n: Vec<f64>,
    /// Sum of squared weighted residuals of the co-rotational finger under the corrected forces, mm^2.
    pub(super) sum_of_squares_mm2: f64,
}

/// Solution at one point of the grid of forces.
#[derive(Debug, Clone)]
struct Point {
    /// Index of the gain.
    gain: usize,
    key: Vec<i64>,
    step_n: f64,
    /// `None` if no forces on the co-rotational finger make the linear estimator return the forces of this grid point.
    solution: Option<Solution>,
}

/// Forces on the co-rotational finger, N, with the finger's motion and its derivatives.
#[derive(Debug, Clone)]
struct Solution {
    forces_n: DVector<f64>,
    motion: FrameMotion,
    /// Derivative of the forces on the co-rotational finger with respect to the forces that the linear estimator returns, dimensionless.
    slope: DMatrix<f64>,
    /// Weighted displacements of the markers, mm. `rates` contains the derivatives of the weighted displacements with respect to the forces, mm/N.
    displacements: DVector<f64>,
    rates: DMatrix<f64>,
}

impl Linearisation {
    /// Prepares the co-rotational finger on a mesh.
    pub fn new(mesh: Arc<Mesh>, contacts: &[Contact]) -> Linearisation {
        let ends_n = [f64::NEG_INFINITY, f64::INFINITY];
        Linearisation { mesh, contacts: contacts.to_vec(), ends_n, gains: Vec::new(), points: Vec::new() }
    }

    /// Error of linearisation of the estimated forces `sensed_n`, N.
    ///
    /// # Errors
    /// [`SensingError::NotLinearised`] if no forces on the co-rotational finger make the linear estimator return `sensed_n`.
    pub(super) fn error(
        &mut self,
        model: LinearModel,
        measurement: &Measurement,
        sensed_n: &[f64],
    ) -> Result<LinearisationError, SensingError> {
        let solution = self.point(model, measurement, sensed_n)?;
        let (grid_n, solution) = solution.ok_or(SensingError::NotLinearised)?;
        let change = &solution.slope * DVector::from_fn(sensed_n.len(), |i, _| sensed_n[i] - grid_n[i]);
        let displacements = &solution.displacements + &solution.rates * &change;
        let forces_n = &solution.forces_n + change;
        let measured = weighted(measurement, |marker| marker.displacement);
        Ok(LinearisationError {
            error_n: sensed_n.iter().zip(forces_n.iter()).map(|(sensed, force)| sensed - force).collect(),
            sum_of_squares_mm2: (measured - displacements).norm_squared(),
        })
    }

    /// Grid point nearest to the forces `sensed_n`, N, with its solution. `None` if the search for the solution fails.
    fn point(
        &mut self,
        model: LinearModel,
        measurement: &Measurement,
        sensed_n: &[f64],
    ) -> Result<Option<(Vec<f64>, &Solution)>, SensingError> {
        let largest_n = sensed_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        if !largest_n.is_finite() {
            return Ok(None);
        }
        let step_n = if largest_n > 0.0 { GRID * largest_n.log2().floor().exp2() } else { 1.0 };
        let key: Vec<i64> = sensed_n.iter().map(|f| (f / step_n).round() as i64).collect();
        let grid_n: Vec<f64> = key.iter().map(|&k| k as f64 * step_n).collect();
        let gain = self.gains.iter().position(|gain| gain == model.gain);
        let is_point = |point: &Point| Some(point.gain) == gain && point.step_n == step_n && point.key == key;
        let index = match self.points.iter().position(is_point) {
            Some(index) => index,
            None => {
                if self.points.len() == MOST_POINTS {
                    self.points.clear();
                    self.gains.clear();
                }
                let solution = self.solve(model, measurement, &grid_n)?;
                let gain = gain.filter(|gain| *gain < self.gains.len()).unwrap_or_else(|| {
                    self.gains.push(model.gain.clone());
                    self.gains.len() - 1
                });
                self.points.push(Point { gain, key, step_n, solution });
                self.points.len() - 1
            }
        };
        Ok(self.points[index].solution.as_ref().map(|solution| (grid_n, solution)))
    }

    /// Forces on the co-rotational finger for which the linear estimator returns `target_n`, N, by Newton's method. `None` if the search for these forces
    /// fails.
    fn solve(
        &mut self,
        LinearModel { gain, compliance }: LinearModel,
        measurement: &Measurement,
        target_n: &[f64],
    ) -> Result<Option<Solution>, SensingError> {
        let mesh = self.mesh.clone();
        let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
        let target = DVector::from_column_slice(target_n);
        let (mut forces_n, mut motion) = self.start(target_n);
        let most_refused = MOST_REFUSED[usize::from(target.len() > 1)];
        let (mut refused, mut astray, mut missing_before_n) = (0, 0, f64::INFINITY);
        for _ in 0..MAX_STEPS {
            if !statics.linearise(&motion, &self.loads(&forces_n)?) {
                return Ok(None);
            }
            let rates = self.rates(&mut statics, &motion, measurement)?;
            let displacements =
                weighted(measurement, |marker| motion.displacements[self.mesh.marker_node(marker.node)]);
            let sensed = &forces_n + gain * (&displacements - compliance * &forces_n);
            let derivative = DMatrix::identity(target.len(), target.len()) + gain * (&rates - compliance);
            let Some(slope) = derivative.try_inverse() else { return Ok(None) };
            let missing = &target - sensed;
            let step = &slope * &missing;
            if !step.iter().all(|x| x.is_finite()) {
                return Ok(None);
            }
            if step.amax() <= STEP_TOLERANCE * target.amax() {
                return Ok(Some(Solution { forces_n, motion, slope, displacements, rates }));
            }
            let closer = missing.amax() <= CLOSER * missing_before_n;
            missing_before_n = missing.amax();
            astray += usize::from(!closer);
            if astray > MOST_ASTRAY {
                return Ok(None);
            }
            let mut part = if closer { 1.0 } else { 0.5 };
            loop {
                let next = &forces_n + &step * part;
                match self.followed(&mut statics, &motion, &forces_n, &next)? {
                    Ok(followed) => {
                        (forces_n, motion) = (next, followed);
                        break;
                    }
                    Err(_) if refused == most_refused => return Ok(None),
                    Err(carried) => {
                        refused += 1;
                        part *= halved_below(carried);
                    }
                }
            }
        }
        Ok(None)
    }

    /// Forces, N, and shape from which Newton's method starts: the unloaded finger or, for a single force, a nearer known solution. Only a single
    /// force starts from a known solution, because the equilibria under all values of a single force form one path.
    fn start(&self, target_n: &[f64]) -> (DVector<f64>, FrameMotion) {
        if let [target_n] = target_n {
            let away = |solution: &&Solution| (solution.forces_n[0] - target_n).abs();
            let known = self.points.iter().filter_map(|point| point.solution.as_ref());
            let nearest = known.min_by(|a, b| away(a).total_cmp(&away(b)));
            if let Some(nearest) = nearest.filter(|nearest| away(nearest) < target_n.abs()) {
                return (nearest.forces_n.clone(), nearest.motion.clone());
            }
        }
        (DVector::zeros(target_n.len()), FrameMotion::at_rest(self.mesh.frame()))
    }

    /// Follows the equilibrium from the shape `motion` under `forces_n` to the shape under `next_n`, both N. Returns the shape under `next_n`, or the
    /// share of the change of the forces (0 to 1) up to which equilibria exist.
    ///
    /// Equilibria under all values of a single force form one path, so the search for the ends of this path is done only once.
    fn followed(
        &mut self,
        statics: &mut Statics<Ladder>,
        motion: &FrameMotion,
        forces_n: &DVector<f64>,
        next_n: &DVector<f64>,
    ) -> Result<Result<FrameMotion, f64>, SensingError> {
        let (from_n, to_n) = (forces_n[0], next_n[0]);
        // Whether a single force grows in magnitude without a change of sign.
        let single = self.contacts.len() == 1 && to_n.abs() > from_n.abs() && to_n * from_n >= 0.0;
        let side = usize::from(to_n > 0.0);
        if single && to_n.abs() > self.ends_n[side].abs() {
            return Ok(Err(f64::max((self.ends_n[side] - from_n) / (to_n - from_n), 0.0)));
        }
        match statics.shifted(motion, &self.loads(forces_n)?, &self.loads(next_n)?) {
            Ok(equilibrium) => Ok(Ok(equilibrium.motion)),
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                if single {
                    self.ends_n[side] = from_n + converged_fraction * (to_n - from_n);
                }
                Ok(Err(converged_fraction))
            }
            Err(other) => Err(other.into()),
        }
    }

    fn loads(&self, forces_n: &DVector<f64>) -> Result<Vec<FrameLoad>, SensingError> {
        let finger = self.mesh.finger();
        let loads = self.contacts.iter().zip(forces_n.iter());
        Ok(loads.map(|(c, f)| self.mesh.frame_load(&c.load(finger, *f))).collect::<Result<_, _>>()?)
    }

    /// Derivatives of the weighted marker displacements with respect to the forces, mm/N, at `motion`. The last linearisation of `statics` must be at `motion`.
    fn rates(
        &self,
        statics: &mut Statics<Ladder>,
        motion: &FrameMotion,
        measurement: &Measurement,
    ) -> Result<DMatrix<f64>, SensingError> {
        let finger = self.mesh.finger();
        let mut rates = DMatrix::zeros(measurement.coordinate_count(), self.contacts.len());
        let mut of_nodes = vec![Vector::zeros(); finger.key_node_count()];
        for (contact, mut column) in self.contacts.iter().zip(rates.column_iter_mut()) {
            let load = self.mesh.frame_load(&contact.unit_load(finger))?;
            statics.equations_mut().added_load(motion, &load, &mut of_nodes);
            column.copy_from(&weighted(measurement, |marker| of_nodes[marker.node.0 - 1]));
        }
        Ok(rates)
    }
}

/// Multiplies the vector that `of` returns for each marker by the marker's weight, and stacks the products in the order of the markers.
pub(super) fn weighted(measurement: &Measurement, of: impl Fn(&crate::measurement::Marker) -> Vector) -> DVector<f64> {
    let coordinates = measurement.markers().iter().flat_map(|marker| {
        let vector = of(marker) * marker.weight;
        [vector.x, vector.y]
    });
    DVector::from_iterator(measurement.coordinate_count(), coordinates)
}
