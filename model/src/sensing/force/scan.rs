//! Scans all equilibria of the finger under forces at the contacts, to start a search near every minimum of the misfit (sum of squared residuals).
//!
//! One force of known position and direction has one curve of equilibria, which passes through the unloaded finger. Two forces have a surface of
//! equilibria. The surface of equilibria under two forces is covered by curves along which the second force varies. A curve along which the second
//! force varies starts at each point of the first force's curve. For one force of unknown position or direction, curves at several positions and
//! directions pass near every minimum. Between two points of a curve, misfits follow from the displacements and the derivatives of the displacements
//! at both points (cubic Hermite interpolation).

use super::problem::{ForceProblem, State};
use super::states::state_under;
use crate::Vector;
use crate::finger::Plate;
use crate::frame::FrameMotion;
use crate::measurement::{Marker, Measurement};
use crate::sensing::{Contact, ContactPosition, ContactQuestion, Direction};

/// Intended largest changes between neighbouring points of a curve. Each row contains the change of a displacement (share of the front plate's
/// length) and of a rotation (rad). The first row applies to a scan of a single curve, the second row to a scan of several curves.
const STEPS: [[f64; 2]; 2] = [[0.02, 0.15], [0.1, 0.6]];
/// A step is repeated with half its length if its change exceeds the intended largest change by more than this factor.
const TOO_LONG: f64 = 1.5;
/// A curve ends beyond this displacement (share of the front plate's length) or this rotation (rad). The limits of displacement and rotation exceed
/// the displacements and rotations of a grasping finger.
const ENDS: [f64; 2] = [0.5, 1.5];
/// A step without equilibrium is repeated with this share of its length, because [`Statics::tried`](crate::statics::Statics) has already tried larger
/// shares.
const SHORTER: f64 = 0.125;
/// A curve ends after this number of successive steps without equilibrium.
const MOST_FAILED: usize = 2;
/// A curve that starts at the unloaded finger ends after this number of first steps without equilibrium. The first step may be far too long: a plate pushed
/// along its axis moves little until it buckles.
const MOST_FAILED_AT_REST: usize = 5;
/// A curve ends after this number of points on either side of its start.
const MOST_POINTS: usize = 200;
/// Number of intervals between neighbouring points of a curve. The misfit (sum of squared residuals) is evaluated at the ends of the intervals
/// between neighbouring points.
const BETWEEN: usize = 8;
/// Positions, as shares of the front plate, and directions (`ANGLES_DEG`, degrees) that are scanned for contacts whose position or direction is
/// unknown.
const POSITIONS: [f64; 6] = [0.15, 0.35, 0.5, 0.65, 0.8, 0.95];
const ANGLES_DEG: [f64; 3] = [0.0, -40.0, 40.0];

/// Equilibria under one varying force, in the order from the most negative to the most positive value of the force.
#[derive(Debug, Clone)]
struct Curve {
    /// Index of the varying force.
    varying: usize,
    points: Vec<State>,
}

/// Curves that together cover all equilibria of the finger under forces at its contacts.
#[derive(Debug, Clone)]
pub(super) struct Scan {
    curves: Vec<Curve>,
}

/// A point of a curve with its misfit (sum of squared weighted residuals) for a measurement.
#[derive(Debug, Clone)]
pub(super) struct ScannedPoint {
    /// Misfit at the point, mm^2.
    pub misfit_mm2: f64,
    /// Forces at the point, N.
    pub forces_n: Vec<f64>,
    curve: usize,
    /// Index of the preceding point of the curve.
    before: usize,
}

/// Change between two motions, as a multiple of `step`, the intended largest change between points of a curve (displacement as a share of
/// `length_mm`, rotation in rad).
fn change(from: &FrameMotion, to: &FrameMotion, length_mm: f64, step: [f64; 2]) -> f64 {
    let moved = from.displacements.iter().zip(&to.displacements).map(|(a, b)| (b - a).norm_squared());
    let turned = from.rotations.iter().zip(&to.rotations).map(|(a, b)| (b - a).abs());
    let moved_mm = moved.fold(0.0, f64::max).sqrt();
    (moved_mm / (step[0] * length_mm)).max(turned.fold(0.0, f64::max) / step[1])
}

/// Scans the equilibria under all forces at the contacts. `None` for more than two forces, for two forces of unknown position or direction, and for
/// contacts with an object.
pub(super) fn scan(problem: &mut ForceProblem) -> Option<Scan> {
    if problem.object.is_some() {
        return None;
    }
    let curves = match problem.questions.clone()[..] {
        [question] => {
            let contacts = scanned_contacts(problem, &question);
            let step = STEPS[usize::from(contacts.len() > 1)];
            let of_contact = |contact: Contact| {
                let rest = state_under(problem, &[contact], &[0.0], None)?;
                Some(curve(problem, rest, 0, step))
            };
            contacts.into_iter().filter_map(of_contact).collect()
        }
        [first, second] => {
            let contacts = [first, second].map(|question| scanned_contacts(problem, &question));
            let [[first], [second]] = [&contacts[0][..], &contacts[1][..]] else { return None };
            let rest = state_under(problem, &[*first, *second], &[0.0; 2], None)?;
            let of_first = curve(problem, rest, 0, STEPS[1]);
            of_first.points.into_iter().map(|point| curve(problem, point, 1, STEPS[1])).collect()
        }
        _ => return None,
    };
    Some(Scan { curves })
}

/// Contacts at which equilibria are scanned. A direction that follows the plate is replaced by the undeformed normal, and an unknown position or
/// direction by several values.
fn scanned_contacts(problem: &ForceProblem, question: &ContactQuestion) -> Vec<Contact> {
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let positions = match question.position {
        Some(position) => vec![position],
        None => POSITIONS.map(|share| ContactPosition::at(share * length_mm)).to_vec(),
    };
    let angles_deg = match question.direction {
        Direction::Angle(angle_deg) => vec![angle_deg],
        Direction::Leaning(lean) => vec![lean.angle_deg],
        Direction::Measured(normal) => vec![normal.angle_deg],
        Direction::Auto => ANGLES_DEG.to_vec(),
    };
    let at = |position: ContactPosition| angles_deg.iter().map(move |&angle_deg| Contact { position, angle_deg });
    positions.into_iter().flat_map(at).collect()
}

/// Curve of equilibria through `start`, along which the force with index `varying` changes.
fn curve(problem: &mut ForceProblem, start: State, varying: usize, step: [f64; 2]) -> Curve {
    let [mut less, more] = [-1.0, 1.0].map(|sign| half_curve(problem, &start, varying, sign, step));
    less.reverse();
    less.push(start);
    less.extend(more);
    Curve { varying, points: less }
}

/// Points of a curve on one side of its start.
fn half_curve(problem: &mut ForceProblem, start: &State, varying: usize, sign: f64, step: [f64; 2]) -> Vec<State> {
    let length_mm = problem.finger().plate_length_mm(Plate::Front);
    let ends = |motion: &FrameMotion| {
        motion.largest_displacement() > ENDS[0] * length_mm || motion.largest_rotation() > ENDS[1]
    };
    let mut points: Vec<State> = Vec::new();
    let Some(mut by_n) = first_step_n(problem, start, varying, length_mm * step[0]).map(|by_n| sign * by_n) else {
        return points;
    };
    let mut failed = 0;
    while points.len() < MOST_POINTS {
        let last = points.last().unwrap_or(start);
        let mut forces_n = last.forces_n.clone();
        forces_n[varying] += by_n;
        let contacts = last.contacts.clone();
        let next = state_under(problem, &contacts, &forces_n, Some(last));
        let size = next.as_ref().map(|next| change(&last.motion, &next.motion, length_mm, step));
        match (next, size) {
            (Some(next), Some(size)) if size <= TOO_LONG => {
                let is_last = ends(&next.motion);
                points.push(next);
                if is_last {
                    break;
                }
                by_n *= (1.0 / size.max(f64::MIN_POSITIVE)).clamp(0.5, 2.0);
                failed = 0;
            }
            (Some(_), _) => by_n *= 0.5,
            (None, _) => {
                by_n *= SHORTER;
                failed += 1;
                let is_first = points.is_empty() && start.motion.is_at_rest();
                if failed >= if is_first { MOST_FAILED_AT_REST } else { MOST_FAILED } {
                    break;
                }
            }
        }
    }
    points
}

/// Change of a force, N, that moves the fastest key node by `by_mm`, according to the tangent at the start.
fn first_step_n(problem: &ForceProblem, start: &State, varying: usize, by_mm: f64) -> Option<f64> {
    let rate = |key_node| start.linearised.rate(varying, key_node).norm();
    let fastest = (0..problem.finger().key_node_count()).map(rate).fold(0.0, f64::max);
    Some(by_mm / fastest).filter(|by_n| by_n.is_finite())
}

impl Curve {
    /// Misfits at all points of the curve except the last point, and at positions between neighbouring points.
    fn misfits(&self, measurement: &Measurement, curve: usize) -> Vec<ScannedPoint> {
        let mut scanned = Vec::with_capacity(BETWEEN * self.points.len());
        let at =
            |point: &State| ScannedPoint { misfit_mm2: f64::NAN, forces_n: point.forces_n.clone(), curve, before: 0 };
        for (before, ends) in self.points.windows(2).enumerate() {
            let by_n = ends[1].forces_n[self.varying] - ends[0].forces_n[self.varying];
            for i in 0..BETWEEN {
                let share = i as f64 / BETWEEN as f64;
                let misfit = |marker: &Marker| {
                    let off = marker.displacement - interpolated(ends, self.varying, marker.node.0 - 1, by_n, share);
                    (off * marker.weight).norm_squared()
                };
                let misfit_mm2 = measurement.markers().iter().map(misfit).sum();
                let mut point = ScannedPoint { misfit_mm2, before, ..at(&ends[0]) };
                point.forces_n[self.varying] += share * by_n;
                scanned.push(point);
            }
        }
        scanned
    }
}

/// Displacement of a key node between two points of a curve, mm.
fn interpolated(ends: &[State], varying: usize, key_node: usize, by_n: f64, share: f64) -> Vector {
    let [from, to] = [&ends[0], &ends[1]].map(|end| end.linearised.seen_displacement(key_node, end.posed()));
    let [from_rate, to_rate] = [&ends[0], &ends[1]].map(|end| end.linearised.rate(varying, key_node) * by_n);
    let (t, u) = (share, 1.0 - share);
    from * (u * u * (1.0 + 2.0 * t)) + to * (t * t * (1.0 + 2.0 * u)) + from_rate * (t * u * u) - to_rate * (t * t * u)
}

impl Scan {
    /// All points with their misfits, one list per curve.
    pub fn misfits(&self, measurement: &Measurement) -> Vec<Vec<ScannedPoint>> {
        self.curves.iter().enumerate().map(|(i, curve)| curve.misfits(measurement, i)).collect()
    }

    /// Equilibrium that precedes a point on its curve.
    pub fn state_before(&self, point: &ScannedPoint) -> &State {
        &self.curves[point.curve].points[point.before]
    }
}

/// Points with a smaller misfit (sum of squared residuals) than their neighbours on the same curve and on adjacent curves, in order of misfit.
pub(super) fn least(scanned: &[Vec<ScannedPoint>]) -> Vec<&ScannedPoint> {
    let of_curves: Vec<Vec<&ScannedPoint>> = scanned.iter().map(|points| least_of_curve(points)).collect();
    let varying_n = |point: &ScannedPoint| point.forces_n.last().copied().unwrap_or_default();
    let nearest = |curve: Option<&Vec<ScannedPoint>>, point: &ScannedPoint| {
        let off = |other: &ScannedPoint| (varying_n(other) - varying_n(point)).abs();
        let near = curve.and_then(|curve| curve.iter().min_by(|a, b| off(a).total_cmp(&off(b))));
        near.map_or(f64::INFINITY, |near| near.misfit_mm2)
    };
    let mut all = Vec::new();
    for (i, points) in of_curves.iter().enumerate() {
        let beside = [i.checked_sub(1), Some(i + 1)].map(|j| j.and_then(|j| scanned.get(j)));
        for point in points {
            if beside.iter().all(|curve| nearest(*curve, point) >= point.misfit_mm2) {
                all.push(*point);
            }
        }
    }
    all.sort_by(|a, b| a.misfit_mm2.total_cmp(&b.misfit_mm2));
    all
}

fn least_of_curve(points: &[ScannedPoint]) -> Vec<&ScannedPoint> {
    let misfit = |i: Option<usize>| i.and_then(|i| points.get(i)).map_or(f64::INFINITY, |point| point.misfit_mm2);
    (0..points.len())
        .filter(|&i| points[i].misfit_mm2 <= misfit(i.checked_sub(1)) && points[i].misfit_mm2 < misfit(Some(i + 1)))
        .map(|i| &points[i])
        .collect()
}
