//! Equilibrium paths past limit points, by arc length.

use super::{Assembly, StaticsError};
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};
use crate::{Kinematics, Vector};
use finray_numerics::linear::{Bordered, Direction, IndefiniteFactor};

/// First step along the path, in the measure of [`ArcLength`]: about a degree.
const FIRST_STEP: f64 = 0.02;
/// Longest step: the points of a path are close enough to draw it.
const LONGEST_STEP: f64 = 0.1;
/// A path that cannot be followed by this much is lost.
const SHORTEST_STEP: f64 = 1e-10;
/// Turn of the tangent in one step, rad, that steps are adapted to.
const INTENDED_TURN: f64 = 0.15;
/// Larger turns, rad, are taken in smaller steps: another branch might have been met.
const LARGEST_TURN: f64 = 0.5;
/// Newton's method has converged when its next correction, known from the last two, will be below this.
const CORRECTION_TOLERANCE: f64 = 1e-12;
/// Corrections above this are too large to conclude the next one from.
const QUADRATIC_RANGE: f64 = 1e-3;
/// A correction this small, and small against the step, that no longer shrinks is rounding noise.
const STAGNATION_TOLERANCE: f64 = 1e-8;
/// See [`STAGNATION_TOLERANCE`].
const STAGNATION_SHARE: f64 = 1e-2;
/// More iterations than this mean that the step was too long.
const MAX_ITERATIONS: usize = 10;
/// A limit point is found when the load changes along the path by less than this per unit of the measure. The error of
/// the limit load is of the order of its square.
const LIMIT_TOLERANCE: f64 = 1e-7;
/// Trials to find a limit point between two points of the path.
const MAX_LIMIT_TRIALS: usize = 40;
/// Corrections may leave the tangent by this share of the step; further away another branch might be met.
const LARGEST_DEPARTURE: f64 = 0.5;
/// Where the number of negative pivots and the slope of the load disagree, the path has either met a bifurcation or
/// been left: a bifurcation is believed when steps have shrunk until the multiple changes by no more than this share.
const BIFURCATION_SHARE: f64 = 1e-3;
/// Several bifurcations between two points are believed when the multiple changes by no more than this share.
const MULTIPLE_BIFURCATION_SHARE: f64 = 1e-6;

/// An equilibrium on a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathPoint {
    /// The loads act this many times.
    pub multiple: f64,
    /// Displacements and rotations.
    pub motion: FrameMotion,
    /// Number of negative eigenvalues of the tangent stiffness: ways in which the frame can leave this shape while it
    /// releases energy. It changes by one at a limit point, and at a bifurcation without one.
    pub negative_pivots: usize,
}

impl PathPoint {
    /// Whether the equilibrium is stable under dead loads.
    pub fn is_stable(&self) -> bool {
        self.negative_pivots == 0
    }
}

/// A point of the path at which the load is larger or smaller than at all points nearby.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitPoint {
    /// The loads act this many times.
    pub multiple: f64,
    /// Displacements and rotations.
    pub motion: FrameMotion,
    /// Index of the last point of the path before it.
    pub after: usize,
}

/// An equilibrium path from rest.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EquilibriumPath {
    /// Points in the order of the path, the first one at rest.
    pub points: Vec<PathPoint>,
    /// Limit points in the order of the path.
    pub limits: Vec<LimitPoint>,
}

/// Follows equilibria of any plane frame from rest through limit points, where the load must fall (snap-through) or the
/// loaded point turn back (snap-back), on stable and unstable branches alike.
///
/// A step leaves along the tangent of the path; Newton's method then returns to the path within the plane across that
/// tangent, unknowns and load multiple together. So nothing special happens where the load turns. Steps adapt to how
/// fast the tangent turns. Limit points, where the load's share of the tangent is zero, are found between two points
/// by the regula falsi (Illinois) on the length of the step.
///
/// Lengths along the path are the same in any unit and for any mesh. Displacements count as shares of the frame's size
/// (half the diagonal of its outline), rotations in rad, and the mean square over all unknowns is taken; the multiple
/// counts as the motion that it causes at rest. Energy would be a measure free of units too, but against the stiffness
/// at rest a slender beam that merely turns counts as stretched, thousands of times more than one that bends.
///
/// # Requirements
/// The stiffness at rest is positive definite. The loads keep their directions. Limit points are simple; at a bifurcation
/// the path goes straight on, and [`PathPoint::negative_pivots`] shows it. No element bends by much more than a radian: at
/// half a turn of an end against its chord their energy has a kink.
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
/// // A shallow toggle under a load at its apex snaps through.
/// let mut frame = PlaneFrame::new();
/// let nodes = [(-100.0, 0.0), (0.0, 5.0), (100.0, 0.0)].map(|(x, y)| frame.add_node(Vector::new(x, y)));
/// let section = Section { axial_rigidity_n: 1e5, bending_rigidity_nmm2: 1e3 };
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

/// Weights of the squares in the length of a [`Direction`].
#[derive(Debug, Clone)]
struct Measure {
    unknowns: Vec<f64>,
    multiple: f64,
}

/// A point of the path with its tangent, of length one.
#[derive(Debug, Clone)]
struct Station {
    point: PathPoint,
    tangent: Direction,
}

impl<'f> ArcLength<'f> {
    /// Prepares the equations of a frame.
    pub fn new(frame: &'f PlaneFrame, kinematics: Kinematics) -> ArcLength<'f> {
        let assembly = Assembly::new(frame, kinematics);
        let size = half_diagonal(frame);
        let count = assembly.equations().count() as f64;
        let unknowns = assembly.equations().by_kind(1.0 / (count * size * size), 1.0 / count);
        ArcLength { assembly, factor: IndefiniteFactor::default(), measure: Measure { unknowns, multiple: 1.0 } }
    }

    /// Follows the path of the loads from rest, where their multiple begins to grow, to the first point that `until`
    /// accepts or until there are `most_points`.
    ///
    /// # Errors
    /// [`StaticsError::NotHeld`] if the frame can move without deforming; [`StaticsError::NoEquilibrium`] with the last
    /// multiple if the path is lost, as where several branches meet.
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

    /// The frame at rest; fixes the weight of the multiple by the linear motion.
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
        // Loads that move nothing: the multiple alone is followed.
        self.measure.multiple = if moved > 0.0 { moved } else { 1.0 };
        tangent = tangent.scaled(1.0 / self.measure.length(&tangent));
        Some(Station { point: PathPoint { multiple: 0.0, motion, negative_pivots: 0 }, tangent })
    }

    /// The point of the path where it crosses the plane that lies `length` away along the tangent.
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
                // The equations are there anyway: the last correction costs nothing.
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

    /// Moves a point by a change of unknowns and multiple.
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

    /// The point between two neighbours at which the load turns, by the regula falsi with Illinois' modification.
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
    /// Inner product of two directions.
    fn product(&self, a: &Direction, b: &Direction) -> f64 {
        let unknowns = self.unknowns.iter().zip(&a.unknowns).zip(&b.unknowns);
        unknowns.map(|((w, a), b)| w * a * b).sum::<f64>() + self.multiple * a.multiple * b.multiple
    }

    fn length(&self, direction: &Direction) -> f64 {
        self.product(direction, direction).sqrt()
    }

    /// The row whose plain product with a direction is the inner product with `of`.
    fn dual(&self, of: &Direction) -> Direction {
        let unknowns = self.unknowns.iter().zip(&of.unknowns).map(|(w, u)| w * u).collect();
        Direction { unknowns, multiple: self.multiple * of.multiple }
    }
}

/// Whether the load grows at one point and falls at the other.
fn turns_back(from: &Station, to: &Station) -> bool {
    from.tangent.multiple * to.tangent.multiple < 0.0
}

/// Whether two points can be neighbours without a bifurcation between them: there the bordered matrix keeps the sign of
/// its determinant, so one eigenvalue of the tangent stiffness changes sign where the load turns; no other does.
fn is_regular(from: &Station, to: &Station) -> bool {
    let changed = from.point.negative_pivots.abs_diff(to.point.negative_pivots);
    changed == usize::from(turns_back(from, to))
}

/// Whether two points are so near to each other that only a bifurcation can explain their stability.
fn is_bifurcation(from: &Station, to: &Station) -> bool {
    let share = ((to.point.multiple - from.point.multiple) / to.point.multiple).abs();
    let changed = from.point.negative_pivots.abs_diff(to.point.negative_pivots);
    share <= if changed <= 1 { BIFURCATION_SHARE } else { MULTIPLE_BIFURCATION_SHARE }
}

/// Half the diagonal of the outline of the undeformed nodes, mm; one for a frame without extent.
fn half_diagonal(frame: &PlaneFrame) -> f64 {
    let positions = (0..frame.node_count()).map(|node| frame.position(node));
    let (low, high) = positions
        .fold((Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)), |(low, high), p| {
            (low.inf(&p), high.sup(&p))
        });
    let size = 0.5 * (high - low).norm();
    if size > 0.0 && size.is_finite() { size } else { 1.0 }
}
