//! Equilibrium paths through limit points, by the arc-length method.

use super::{Assembly, StaticsError};
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};
use crate::{Kinematics, Vector};
use finray_numerics::linear::{Bordered, Direction, IndefiniteFactor};

/// Length of the first step in the norm of [`ArcLength`], dimensionless. This length corresponds to about one degree of rotation.
const FIRST_STEP: f64 = 0.02;
/// Longest step in the norm of [`ArcLength`], dimensionless. With steps up to this length, the points of a path are close enough to draw the path.
const LONGEST_STEP: f64 = 0.1;
/// Shortest step in the norm of [`ArcLength`], dimensionless. If a path needs a shorter step, the search ends with an error.
const SHORTEST_STEP: f64 = 1e-10;
/// Intended angle between the tangents at both ends of a step, rad. The step length is chosen for this angle.
const INTENDED_TURN: f64 = 0.15;
/// Largest angle between the tangents at both ends of a step, rad. A step with a larger angle may have reached another branch, so it is repeated with a shorter
/// length.
const LARGEST_TURN: f64 = 0.5;
/// Newton's method has converged when the predicted norm of its next correction is below this value. The prediction uses the last two corrections.
const CORRECTION_TOLERANCE: f64 = 1e-12;
/// The next correction is predicted only from corrections with a norm up to this value.
const QUADRATIC_RANGE: f64 = 1e-3;
/// A correction counts as rounding noise if its norm is at most this value and at most [`STAGNATION_SHARE`] times the step length, but above a
/// quarter of the previous correction's norm.
const STAGNATION_TOLERANCE: f64 = 1e-8;
/// Largest correction that may count as rounding noise, as a share of the step length; see [`STAGNATION_TOLERANCE`].
const STAGNATION_SHARE: f64 = 1e-2;
/// Largest number of Newton iterations in a step. A step that needs more iterations is repeated with a shorter length.
const MAX_ITERATIONS: usize = 10;
/// A limit point is accepted when the load component of the unit tangent is below this value. The error of the limit load is of the order of the
/// square of this component.
const LIMIT_TOLERANCE: f64 = 1e-7;
/// Largest number of iterations that locate a limit point between two points of the path. After this number of iterations, the search for a limit
/// point ends and returns the best point found.
const MAX_LIMIT_TRIALS: usize = 40;
/// Limit of the sum of the norms of Newton's corrections in a step, as a share of the step length. A larger sum may lead to another branch, so the
/// step is repeated with a shorter length.
const LARGEST_DEPARTURE: f64 = 0.5;
/// A bifurcation is accepted when the load multiple changes by at most this share in the step. If the number of negative pivots disagrees with the
/// sign of the load's slope, the path has met a bifurcation or left its branch. Steps are shortened until it is clear whether the path has met a
/// bifurcation or left its branch.
const BIFURCATION_SHARE: f64 = 1e-3;
/// Several bifurcations in one step are accepted when the load multiple changes by at most this share in the step.
const MULTIPLE_BIFURCATION_SHARE: f64 = 1e-6;

/// A stable or unstable equilibrium on a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathPoint {
    /// Load multiple: common factor on all loads, dimensionless.
    pub multiple: f64,
    /// Displacements (mm) and rotations (rad) of the frame.
    pub motion: FrameMotion,
    /// Number of negative eigenvalues of the tangent stiffness; 0 for a stable equilibrium. The number of negative eigenvalues changes by one at a
    /// simple limit point and at a simple bifurcation.
    pub negative_pivots: usize,
}

impl PathPoint {
    /// Whether the equilibrium is stable under dead loads.
    pub fn is_stable(&self) -> bool {
        self.negative_pivots == 0
    }
}

/// A limit point, at which the load multiple is a local maximum or minimum along the path.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitPoint {
    /// Load multiple: common factor on all loads, dimensionless.
    pub multiple: f64,
    /// Displacements (mm) and rotations (rad) of the frame.
    pub motion: FrameMotion,
    /// Index of the last point of the path before this limit point.
    pub after: usize,
}

/// An equilibrium path that starts at the unloaded frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EquilibriumPath {
    /// Points in the order of the path; the first is the frame at rest.
    pub points: Vec<PathPoint>,
    /// Limit points in the order of the path.
    pub limits: Vec<LimitPoint>,
}

/// Follows the equilibria of any plane frame from rest, both stable and unstable. The path may pass limit points, at which the load starts to fall or
/// to rise (snap-through). The displacement of the loaded point may also reverse its direction along the path (snap-back).
///
/// A step starts along the tangent of the path. Newton's method then returns to the path within the plane normal to the starting tangent. The
/// unknowns of Newton's method include the load multiple, so limit points need no special treatment. The change of the tangent's direction sets the
/// step length. At a limit point the tangent has no load component. Between two points of the path, the regula falsi (Illinois) finds the step length
/// at which the load component vanishes.
///
/// The length of a step does not depend on units or mesh. The length of a step is the root mean square over all unknowns: displacements divided by
/// the frame's size (half the diagonal of the frame's outline), and rotations in rad. The load multiple is scaled by the motion that it causes at
/// rest. An energy norm would also be independent of units. However, for a slender beam that only rotates, the stiffness at rest predicts a large
/// elongation. In an energy norm, the energy of the predicted elongation would dominate the energy of bending beams.
///
/// # Requirements
/// The stiffness at rest is positive definite. The loads keep their directions. Limit points are simple. At a bifurcation the path keeps its branch,
/// and [`PathPoint::negative_pivots`] shows the change of stability. No element bends by much more than a radian, because an element's energy has a
/// kink where an end is rotated by half a turn relative to the element's chord.
///
/// # Reference
/// E. Riks, Int. J. Solids Struct. 15 (1979) 529-551; H. B. Keller, Numerical solution of bifurcation and nonlinear
/// eigenvalue problems, in: Applications of Bifurcation Theory (1977) 359-384, pseudo-arclength; M. A. Crisfield,
/// Non-linear Finite Element Analysis of Solids and Structures, vol. 1, ch. 9.
///
/// ```
/// use finray_model::frame::{FrameLoad, PlaneFrame, Section};
/// use finray_model::statics::ArcLength;
/// use finray_model::{Kinematics, Vector};
///
/// // A shallow toggle frame snaps through under a load at its apex.
/// let mut frame = PlaneFrame::default();
/// let nodes = [(-100.0, 0.0), (0.0, 5.0), (100.0, 0.0)].map(|(x, y)| frame.add_node(Vector::new(x, y)));
/// let section = Section { axial_rigidity_n: 1e5, bending_rigidity_nmm2: 1e3, shear_flexibility: 0.0, axis_mm: [0.0; 2] };
/// frame.add_beam(nodes[0], nodes[1], section);
/// frame.add_beam(nodes[1], nodes[2], section);
/// frame.support(nodes[0], [true, true, false]);
/// frame.support(nodes[2], [true, true, false]);
/// let load = FrameLoad::Node { node: nodes[1], force: Vector::new(0.0, -1.0), moment_nmm: 0.0 };
/// let path = ArcLength::new(&frame, Kinematics::Corotational)
///     .follow(&[load], 500, |point| point.motion.displacements[nodes[1]].y < -10.0)?;
/// assert_eq!(path.limits.len(), 2);
/// assert!(path.limits[0].multiple > path.limits[1].multiple);
/// # Ok::<(), finray_model::statics::StaticsError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ArcLength<'f> {
    assembly: Assembly<'f>,
    factor: IndefiniteFactor,
    measure: Measure,
}

/// Weights of the squared components in the norm of a [`Direction`].
#[derive(Debug, Clone)]
struct Measure {
    /// Weight of each unknown.
    unknowns: Vec<f64>,
    /// Weight of the load multiple.
    multiple: f64,
}

/// A point of the path with its tangent of unit norm.
#[derive(Debug, Clone)]
struct Station {
    point: PathPoint,
    /// Tangent of the path, of unit norm, in the direction in which the path is followed.
    tangent: Direction,
}

impl<'f> ArcLength<'f> {
    /// Prepares the equations of a frame for a path with the given kinematics.
    pub fn new(frame: &'f PlaneFrame, kinematics: Kinematics) -> ArcLength<'f> {
        let assembly = Assembly::new(frame, kinematics);
        let size = half_diagonal(frame);
        let count = assembly.equations().count() as f64;
        let unknowns = assembly.equations().by_kind(1.0 / (count * size * size), 1.0 / count);
        ArcLength { assembly, factor: IndefiniteFactor::default(), measure: Measure { unknowns, multiple: 1.0 } }
    }

    /// Follows the path from rest, initially with a growing load multiple. Stops at the first point that `until` accepts, or after `most_points`
    /// points.
    ///
    /// # Errors
    /// [`StaticsError::NotHeld`] if the frame can move without deforming; [`StaticsError::LoadNotFinite`] for a load that is not finite;
    /// [`StaticsError::NoEquilibrium`] with the last multiple if the solver loses the path, for instance at a point at which several branches meet.
    pub fn follow(
        &mut self,
        loads: &[FrameLoad],
        most_points: usize,
        mut until: impl FnMut(&PathPoint) -> bool,
    ) -> Result<EquilibriumPath, StaticsError> {
        if !loads.iter().all(FrameLoad::is_finite) {
            return Err(StaticsError::LoadNotFinite);
        }
        let mut station = self.at_rest(loads).ok_or(StaticsError::NotHeld)?;
        let mut path = EquilibriumPath { points: vec![station.point.clone()], limits: Vec::new() };
        let mut length = FIRST_STEP;
        while path.points.len() < most_points {
            let next = self.step(&station, loads, length).filter(|next| {
                self.turn(&station, next) <= LARGEST_TURN
                    && (is_regular(&station, next) || is_bifurcation(&station, next))
            });
            let Some(next) = next else {
                length *= 0.5;
                if length < SHORTEST_STEP {
                    return Err(StaticsError::NoEquilibrium { converged_fraction: station.point.multiple });
                }
                continue;
            };
            if is_regular(&station, &next) && turns_back(&station, &next) {
                let limit = self.limit_between(&station, &next, loads, length).point;
                let after = path.points.len() - 1;
                path.limits.push(LimitPoint { multiple: limit.multiple, motion: limit.motion, after });
            }
            let growth = INTENDED_TURN / self.turn(&station, &next).max(0.5 * INTENDED_TURN);
            length = f64::min(length * growth.clamp(0.5, 2.0), LONGEST_STEP);
            path.points.push(next.point.clone());
            station = next;
            if until(&station.point) {
                break;
            }
        }
        Ok(path)
    }

    /// Returns the frame at rest, and sets the weight of the load multiple according to the linear motion under the loads. `None` if the stiffness is
    /// not positive definite.
    fn at_rest(&mut self, loads: &[FrameLoad]) -> Option<Station> {
        let motion = FrameMotion::at_rest(self.assembly.frame());
        self.assembly.evaluate(&motion, loads, 0.0);
        if self.factor.factorise(self.assembly.stiffness())? > 0 {
            return None;
        }
        let mut unknowns = self.assembly.load_vector().to_vec();
        self.factor.solve_in_place(&mut unknowns)?;
        self.measure.multiple = 0.0;
        let mut tangent = Direction { unknowns, multiple: 1.0 };
        let moved = self.measure.product(&tangent, &tangent);
        // If the loads cause no motion, the load multiple alone measures the length of the path.
        self.measure.multiple = if moved > 0.0 { moved } else { 1.0 };
        tangent = tangent.scaled(1.0 / self.measure.length(&tangent));
        Some(Station { point: PathPoint { multiple: 0.0, motion, negative_pivots: 0 }, tangent })
    }

    /// Finds the point at which the path crosses the plane normal to the tangent at the distance `length` from `from`. `None` if Newton's method does
    /// not converge.
    fn step(&mut self, from: &Station, loads: &[FrameLoad], length: f64) -> Option<Station> {
        let constraint = self.measure.dual(&from.tangent);
        let mut point = from.point.clone();
        let mut correction = from.tangent.scaled(length);
        let mut previous = f64::INFINITY;
        let mut departure = 0.0;
        let mut converged = false;
        for _ in 0..MAX_ITERATIONS {
            self.advance(&mut point, &correction);
            self.assembly.evaluate(&point.motion, loads, point.multiple);
            point.negative_pivots = self.factor.factorise(self.assembly.stiffness())?;
            let equations = Bordered::new(&self.factor, self.assembly.load_vector(), &constraint)?;
            let forces: Vec<f64> = self.assembly.residual().iter().map(|r| -r).collect();
            correction = equations.solve(&forces, 0.0)?;
            if converged {
                let tangent = equations.solve(&vec![0.0; forces.len()], 1.0)?;
                let tangent = tangent.scaled(1.0 / self.measure.length(&tangent));
                // The equations are already factored, so one more correction is cheap.
                self.advance(&mut point, &correction);
                return Some(Station { point, tangent });
            }
            let size = self.measure.length(&correction);
            departure += size;
            if departure > LARGEST_DEPARTURE * length {
                return None;
            }
            let next = size.powi(3) / (previous * previous);
            let converges = size <= QUADRATIC_RANGE && previous <= 1.0 && next <= CORRECTION_TOLERANCE;
            let noise = f64::min(STAGNATION_TOLERANCE, STAGNATION_SHARE * length);
            let stagnates = size <= noise && size > 0.25 * previous;
            converged = size == 0.0 || converges || stagnates;
            previous = size;
        }
        None
    }

    /// Adds a change of the unknowns and of the load multiple to a point.
    fn advance(&self, point: &mut PathPoint, by: &Direction) {
        let linear = self.assembly.kinematics() == Kinematics::Linear;
        self.assembly.equations().advance(self.assembly.frame(), &mut point.motion, &by.unknowns, linear);
        point.multiple += by.multiple;
    }

    /// Angle between two tangents, rad.
    fn turn(&self, from: &Station, to: &Station) -> f64 {
        let mut difference = to.tangent.clone();
        difference.add(&from.tangent.scaled(-1.0));
        2.0 * (0.5 * self.measure.length(&difference)).min(1.0).asin()
    }

    /// Finds the limit point between two neighbouring points by the regula falsi with Illinois' modification.
    fn limit_between(&mut self, from: &Station, to: &Station, loads: &[FrameLoad], length: f64) -> Station {
        let load_share = self.measure.multiple.sqrt();
        let slope = |station: &Station| load_share * station.tangent.multiple;
        let mut ends = [(0.0, slope(from)), (length, slope(to))];
        let mut best = if ends[0].1.abs() < ends[1].1.abs() { from.clone() } else { to.clone() };
        let mut last_side = None;
        for _ in 0..MAX_LIMIT_TRIALS {
            let [(a, at_a), (b, at_b)] = ends;
            let trial = (a * at_b - b * at_a) / (at_b - at_a);
            let Some(station) = self.step(from, loads, trial) else { break };
            let at_trial = slope(&station);
            if at_trial.abs() < slope(&best).abs() {
                best = station;
            }
            if at_trial.abs() <= LIMIT_TOLERANCE {
                break;
            }
            let side = usize::from(at_trial * at_a <= 0.0);
            if last_side == Some(side) {
                ends[1 - side].1 *= 0.5;
            }
            ends[side] = (trial, at_trial);
            last_side = Some(side);
        }
        best
    }
}

impl Measure {
    /// Weighted inner product of two directions.
    fn product(&self, a: &Direction, b: &Direction) -> f64 {
        let unknowns = self.unknowns.iter().zip(&a.unknowns).zip(&b.unknowns);
        unknowns.map(|((w, a), b)| w * a * b).sum::<f64>() + self.multiple * a.multiple * b.multiple
    }

    fn length(&self, direction: &Direction) -> f64 {
        self.product(direction, direction).sqrt()
    }

    /// Returns a direction whose unweighted product with any direction d equals the weighted inner product of `of` and d.
    fn dual(&self, of: &Direction) -> Direction {
        let unknowns = self.unknowns.iter().zip(&of.unknowns).map(|(w, u)| w * u).collect();
        Direction { unknowns, multiple: self.multiple * of.multiple }
    }
}

/// Whether the load grows at one point and falls at the other. A limit point then lies between the two points.
fn turns_back(from: &Station, to: &Station) -> bool {
    from.tangent.multiple * to.tangent.multiple < 0.0
}

/// Whether the stability of two neighbouring points agrees with a path without bifurcation between them. On a path without bifurcation, the bordered
/// matrix keeps the sign of its determinant. On a path without bifurcation, one eigenvalue of the tangent stiffness changes sign at a limit point,
/// and no eigenvalue changes sign elsewhere.
fn is_regular(from: &Station, to: &Station) -> bool {
    let changed = from.point.negative_pivots.abs_diff(to.point.negative_pivots);
    changed == usize::from(turns_back(from, to))
}

/// Whether two points are so close that only a bifurcation explains their difference in stability.
fn is_bifurcation(from: &Station, to: &Station) -> bool {
    let share = ((to.point.multiple - from.point.multiple) / to.point.multiple).abs();
    let changed = from.point.negative_pivots.abs_diff(to.point.negative_pivots);
    share <= if changed <= 1 { BIFURCATION_SHARE } else { MULTIPLE_BIFURCATION_SHARE }
}

/// Half the diagonal of the bounding box of the undeformed nodes, mm; 1 for a frame without extent.
fn half_diagonal(frame: &PlaneFrame) -> f64 {
    let positions = (0..frame.node_count()).map(|node| frame.position(node));
    let (low, high) = positions
        .fold((Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)), |(low, high), p| {
            (low.inf(&p), high.sup(&p))
        });
    let size = 0.5 * (high - low).norm();
    if size > 0.0 && size.is_finite() { size } else { 1.0 }
}
