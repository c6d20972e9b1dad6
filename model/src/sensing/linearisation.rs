//! Linearisation error of a sensed force, from the estimated force itself.

use super::{Contact, SensingError, halved_below};
use crate::frame::{FrameLoad, FrameMotion};
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::statics::{Ladder, Statics, StaticsError};
use crate::{Kinematics, Vector};
use nalgebra::{DMatrix, DVector};

/// Forces are looked up on a grid of about this share of the largest: extrapolation leaves thousandths of the error.
const GRID: f64 = 0.05;
/// Grid points that are kept; a stream of frames moves about a few.
const MOST_POINTS: usize = 256;
/// Newton steps; two or three are usual.
const MAX_STEPS: usize = 30;
/// A Newton step comes closer if at most this share is still missing; otherwise the next one is halved.
const CLOSER: f64 = 0.9;
/// Newton steps that may bring it no closer.
const MOST_ASTRAY: usize = 4;
/// Forces have converged when a step changes none by more than this share of the largest.
const STEP_TOLERANCE: f64 = 1e-6;
/// Newton steps that the finger may refuse to carry: of a single force, where a refusal costs nothing once the ends of its
/// way are known, and of several. A step that is refused comes back to within half of what is left to the end.
const MOST_REFUSED: [usize; 2] = [30, 8];

/// The error that a linear estimator makes on the co-rotational finger.
///
/// # Requirements
/// Contacts whose position and direction are known, and the gain and compliance of the linear estimator at the markers.
///
/// # Reference
/// With gain G and compliance C (weighted, at the markers), the linear estimator senses f + G (u(f) - C f) where the
/// co-rotational finger bends to u(f) under the forces f. The error of forces f' is f' - f with f the solution of
/// f + G (u(f) - C f) = f', found by Newton's method with derivatives from the tangent stiffness.
#[derive(Debug, Clone)]
pub struct Linearisation<'m> {
    mesh: &'m Mesh,
    contacts: Vec<Contact>,
    statics: Statics<Ladder<'m>>,
    /// The smallest and the largest size of a single force that the finger carries, N, as far as known.
    ends_n: [f64; 2],
    /// The gain that the points belong to.
    gain: DMatrix<f64>,
    points: Vec<Point>,
}

/// The linear estimator, as far as its error of linearisation depends on it.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearModel<'e> {
    /// G, N/mm: a row a force, 2 columns a marker.
    pub(super) gain: &'e DMatrix<f64>,
    /// Weighted C, mm/N.
    pub(super) compliance: &'e DMatrix<f64>,
}

/// Known part of the error.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinearisationError {
    /// Sensed less true, by contact, N.
    pub(super) error_n: Vec<f64>,
    /// Sum of the squared weighted residuals of the co-rotational finger under the forces without that error, mm^2.
    pub(super) sum_of_squares_mm2: f64,
}

/// The error at one point of the grid of forces.
#[derive(Debug, Clone)]
struct Point {
    key: Vec<i64>,
    step_n: f64,
    /// `None` where the co-rotational finger carries no forces that would be sensed so.
    solution: Option<Solution>,
}

/// Forces of the co-rotational finger, and what depends on them.
#[derive(Debug, Clone)]
struct Solution {
    forces_n: DVector<f64>,
    motion: FrameMotion,
    /// Derivative of the forces by those that are sensed.
    slope: DMatrix<f64>,
    /// Weighted displacements of the markers, mm, and their derivative by the forces, mm/N.
    displacements: DVector<f64>,
    rates: DMatrix<f64>,
}

impl<'m> Linearisation<'m> {
    /// Prepares the co-rotational finger of a mesh.
    pub fn new(mesh: &'m Mesh, contacts: &[Contact]) -> Linearisation<'m> {
        let statics = Statics::ladder(mesh, Kinematics::Corotational);
        let ends_n = [f64::NEG_INFINITY, f64::INFINITY];
        Linearisation {
            mesh,
            contacts: contacts.to_vec(),
            statics,
            ends_n,
            gain: DMatrix::zeros(0, 0),
            points: Vec::new(),
        }
    }

    /// The error of sensed forces, N.
    ///
    /// # Errors
    /// [`SensingError::NotLinearised`] where no forces on the co-rotational finger would be sensed so.
    pub(super) fn error(
        &mut self,
        model: LinearModel,
        measurement: &Measurement,
        sensed_n: &[f64],
    ) -> Result<LinearisationError, SensingError> {
        // What was found with another gain, as that of a prior under other noise, or for other markers does not serve.
        if self.gain != *model.gain {
            self.points.clear();
            self.gain.clone_from(model.gain);
        }
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

    /// The grid point of some forces and the solution there.
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
        let known = self.points.iter().position(|point| point.step_n == step_n && point.key == key);
        let index = match known {
            Some(index) => index,
            None => {
                if self.points.len() == MOST_POINTS {
                    self.points.clear();
                }
                let solution = self.solve(model, measurement, &grid_n)?;
                self.points.push(Point { key, step_n, solution });
                self.points.len() - 1
            }
        };
        Ok(self.points[index].solution.as_ref().map(|solution| (grid_n, solution)))
    }

    /// The forces that are sensed as `target_n`, found by Newton's method; `None` if the finger carries none.
    fn solve(
        &mut self,
        LinearModel { gain, compliance }: LinearModel,
        measurement: &Measurement,
        target_n: &[f64],
    ) -> Result<Option<Solution>, SensingError> {
        let target = DVector::from_column_slice(target_n);
        let (mut forces_n, mut motion) = self.start(target_n);
        let most_refused = MOST_REFUSED[usize::from(target.len() > 1)];
        let (mut refused, mut astray, mut missing_before_n) = (0, 0, f64::INFINITY);
        for _ in 0..MAX_STEPS {
            if !self.statics.linearise(&motion, &self.loads(&forces_n)?) {
                return Ok(None);
            }
            let rates = self.rates(&motion, measurement)?;
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
                match self.followed(&motion, &forces_n, &next)? {
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

    /// Forces to begin with, and the shape under them: none, where Newton's first step goes to forces of the size that is sensed. All
    /// sizes of a single force lie on one way, which may be entered at a known solution that is nearer.
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

    /// The shape under other forces, followed from the one under these, or the share of the way that the finger carries.
    ///
    /// All sizes of a single force lie on one way, whose ends are sought once.
    fn followed(
        &mut self,
        motion: &FrameMotion,
        forces_n: &DVector<f64>,
        next_n: &DVector<f64>,
    ) -> Result<Result<FrameMotion, f64>, SensingError> {
        let (from_n, to_n) = (forces_n[0], next_n[0]);
        // A single force that goes on in the direction in which it has left rest.
        let single = self.contacts.len() == 1 && to_n.abs() > from_n.abs() && to_n * from_n >= 0.0;
        let side = usize::from(to_n > 0.0);
        if single && to_n.abs() > self.ends_n[side].abs() {
            return Ok(Err(f64::max((self.ends_n[side] - from_n) / (to_n - from_n), 0.0)));
        }
        match self.statics.shifted(motion, &self.loads(forces_n)?, &self.loads(next_n)?) {
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

    /// Weighted displacements of the markers by the forces, mm/N, at the motion that was linearised last.
    fn rates(&mut self, motion: &FrameMotion, measurement: &Measurement) -> Result<DMatrix<f64>, SensingError> {
        let finger = self.mesh.finger();
        let mut rates = DMatrix::zeros(measurement.coordinate_count(), self.contacts.len());
        let mut of_nodes = vec![Vector::zeros(); finger.key_node_count()];
        for (contact, mut column) in self.contacts.iter().zip(rates.column_iter_mut()) {
            let load = self.mesh.frame_load(&contact.unit_load(finger))?;
            self.statics.equations_mut().added_load(motion, &load, &mut of_nodes);
            column.copy_from(&weighted(measurement, |marker| of_nodes[marker.node.0 - 1]));
        }
        Ok(rates)
    }
}

/// A vector of each marker times its weight, one after the other.
pub(super) fn weighted(measurement: &Measurement, of: impl Fn(&crate::measurement::Marker) -> Vector) -> DVector<f64> {
    let coordinates = measurement.markers().iter().flat_map(|marker| {
        let vector = of(marker) * marker.weight;
        [vector.x, vector.y]
    });
    DVector::from_iterator(measurement.coordinate_count(), coordinates)
}
