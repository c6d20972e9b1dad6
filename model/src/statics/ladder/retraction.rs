//! How the nodes inside a member take Newton's correction: so that chords and nodes turn together.
//!
//! Newton adds displacements and rotations. Where a plate member is to turn by `a`, that turns its nodes by `a` but the chords of its elements by
//! atan(a) = a - a^3 / 3 (and by `a e` less if they are to stretch by `e` as well). So both ends of an element of length h turn by phi = a^3 / 3
//! against its chord, which is a shear force of 12 EI phi / h^2: nothing between key nodes, but the finer the mesh the smaller the turns that leave
//! the tangent positive definite, as h^(2/3), and the more load steps. The end of a rigid arm or link is worse: it swings on a circle, away from
//! neighbours that move straight.
//!
//! Any update that agrees with Newton's to first order converges as fast: a *retraction*. This one leaves the key nodes
//! where Newton has them, takes the nodes between them along with arms and links on a smooth curve, and turns them as
//! their chords have turned. Then a fine mesh needs the load steps and the iterations of a coarse one, if the curve meets
//! the key nodes without a kink: to second order is not enough, as the stiffness of elements grows without bound.
//!
//! Reference: Absil, Mahony, Sepulchre, Optimization Algorithms on Matrix Manifolds (2008), sec. 4.1 and 6.3.

use super::elements::{Elements, ParallelLines};
use crate::element::quarter_turn;
use crate::frame::{BeamEnd, FrameMotion, Member, PlaneFrame, end_motions};
use crate::number::{Number, arctangent, sine_and_versine};
use nalgebra::Vector2;

/// A correction that turns no node by more than this, rad, has second-order terms below rounding.
const NO_TURN: f64 = 1e-8;

/// The motion before a correction, and room for what one line needs.
#[derive(Debug, Clone)]
pub(super) struct Retraction<R> {
    before: FrameMotion<R>,
    /// Each element's chord before the correction, mm, and its turn by the correction, rad.
    chords: Vec<(Vector2<R>, R)>,
}

impl<R: Number> Retraction<R> {
    /// Room for a frame, in numbers like the one given.
    pub(super) fn new(frame: &PlaneFrame, like: R) -> Retraction<R> {
        Retraction { before: FrameMotion::of_zeros(frame, like), chords: Vec::new() }
    }

    /// Without room.
    pub(super) fn empty() -> Retraction<R> {
        Retraction { before: FrameMotion::empty(), chords: Vec::new() }
    }

    /// Takes what is kept of some lines out of what is kept of their frame.
    #[inline(always)]
    pub(super) fn take(&mut self, of_frame: &Retraction<f64>, lines: &ParallelLines<R>) {
        lines.take_motion(&of_frame.before, &mut self.before);
    }

    /// Keeps the motion that is about to be corrected.
    pub(super) fn remember(&mut self, motion: &FrameMotion<R>) {
        self.before.clone_from(motion);
    }

    /// Mends the nodes inside a line to which the correction was added, in the lanes in which any of them turns.
    /// `end_nodes` are the corrections of its first and last node, mm; a node at a rigid link has moved otherwise.
    #[inline(always)]
    pub(super) fn mend(&mut self, elements: impl Elements<R>, motion: &mut FrameMotion<R>, end_nodes: [Vector2<R>; 2]) {
        let count = elements.count();
        let no_turn = end_nodes[0].x.constant(NO_TURN);
        let mut turns = no_turn.exceeds(no_turn);
        for i in 0..=count {
            let slot = elements.rotation(i);
            let turn = (motion.rotations[slot] - self.before.rotations[slot]).abs();
            turns = no_turn.either(turns, turn.exceeds(no_turn));
        }
        if !no_turn.anywhere(turns) {
            return;
        }
        let (first, last) = (elements.member(0), elements.member(count - 1));
        let ends = [first.ends[0], last.ends[1]];
        let off = self.measure(elements, motion, ends, end_nodes);

        // The inner nodes follow the ends in proportion.
        for i in 1..count {
            let xi = i as f64 / count as f64;
            let u = &mut motion.displacements[elements.node(i)];
            advance(&mut u.x, turns, off[0].x * (1.0 - xi) + off[1].x * xi);
            advance(&mut u.y, turns, off[0].y * (1.0 - xi) + off[1].y * xi);
        }
        // At the ends the chords must turn back to what Newton has for the key nodes; a cubic across the member does it.
        let [from, to] = displacements(motion, ends);
        let whole = chord(&first, count as f64, from, to);
        // Closures would not be inlined here, and lanes computed by calls of single instructions.
        let end_chord = chord_in(motion, &first);
        let first_slope = slope(whole, count, end_chord, -self.surplus(0, end_chord));
        let end_chord = chord_in(motion, &last);
        let last_slope = slope(whole, count, end_chord, -self.surplus(count - 1, end_chord));
        let mut slopes = end_slopes([first_slope, last_slope], count);
        // That turns the end chords exactly, but it is at the end nodes that the turn is Newton's. Half an element off is a
        // shear force that grows as 1 / h, and with it what an axial force does to the tangent: it loses its sign.
        if count > 2 {
            let mut more = slopes;
            for (end, (at, next)) in [(0, 1), (count - 1, count - 2)].into_iter().enumerate() {
                let (chord, surplus) = self.leaning(motion, &elements.member(at), (at, count), whole, slopes);
                let (_, beside) = self.leaning(motion, &elements.member(next), (next, count), whole, slopes);
                more[end] = slope(whole, count, chord, (beside - surplus * 3.0) * 0.5);
            }
            let more = end_slopes(more, count);
            slopes = [slopes[0] + more[0], slopes[1] + more[1]];
        }
        let across = quarter_turn(whole);
        for i in 1..count {
            let lift = cubic(slopes, i as f64 / count as f64);
            let u = &mut motion.displacements[elements.node(i)];
            advance(&mut u.x, turns, across.x * lift);
            advance(&mut u.y, turns, across.y * lift);
        }
        // A node between two chords turns as these have.
        let mut below = self.surplus(0, chord_in(motion, &first));
        for index in 1..count {
            let member = elements.member(index);
            let above = self.surplus(index, chord_in(motion, &member));
            advance(&mut motion.rotations[member.ends[0].rotation], turns, (below + above) * 0.5);
            below = above;
        }
    }

    /// An element's chord, mm, and how much further than by the correction it has turned, rad, once the [`cubic`] with these
    /// slopes is put across the member; the element is the `index`-th of `count`.
    #[inline(always)]
    fn leaning(
        &self,
        motion: &FrameMotion<R>,
        member: &Member<R>,
        (index, count): (usize, usize),
        whole: Vector2<R>,
        slopes: [R; 2],
    ) -> (Vector2<R>, R) {
        let chord = chord_in(motion, member);
        let before = cubic(slopes, index as f64 / count as f64);
        let after = cubic(slopes, (index + 1) as f64 / count as f64);
        let (across, lift) = (quarter_turn(whole), after - before);
        let lifted = Vector2::new(chord.x + across.x * lift, chord.y + across.y * lift);
        (lifted, self.surplus(index, lifted))
    }

    /// Notes each chord and its turn by the correction; returns how far the elastic part's ends are off it, mm.
    #[inline(always)]
    fn measure(
        &mut self,
        elements: impl Elements<R>,
        motion: &FrameMotion<R>,
        ends: [BeamEnd<R>; 2],
        end_nodes: [Vector2<R>; 2],
    ) -> [Vector2<R>; 2] {
        let Retraction { before, chords } = self;
        let (old, new) = (displacements(before, ends), displacements(motion, ends));
        let mut corrections = end_nodes;
        for i in 0..2 {
            let BeamEnd { node, rotation, arm } = ends[i];
            let swung = difference(old[i], before.displacements[node]);
            let turn = motion.rotations[rotation] - before.rotations[rotation];
            corrections[i].x -= (swung.y + arm.y) * turn;
            corrections[i].y += (swung.x + arm.x) * turn;
        }
        chords.clear();
        let (mut position, mut correction) = (old[0], corrections[0]);
        for i in 0..elements.count() {
            let (member, node) = (elements.member(i), elements.node(i + 1));
            let is_last = i + 1 == elements.count();
            let (next, next_correction) = if is_last {
                (old[1], corrections[1])
            } else {
                (before.displacements[node], difference(motion.displacements[node], before.displacements[node]))
            };
            let chord = chord(&member, 1.0, position, next);
            chords.push((chord, cross(chord, difference(next_correction, correction)) / dot(chord, chord)));
            (position, correction) = (next, next_correction);
        }
        [difference(difference(new[0], old[0]), corrections[0]), difference(difference(new[1], old[1]), corrections[1])]
    }

    /// How much further than by the correction an element has turned that has this chord now, rad.
    #[inline(always)]
    fn surplus(&self, index: usize, chord: Vector2<R>) -> R {
        let (before, turn) = self.chords[index];
        arctangent(cross(before, chord), dot(before, chord)) - turn
    }
}

/// An element's chord, mm.
#[inline(always)]
fn chord_in<R: Number>(motion: &FrameMotion<R>, member: &Member<R>) -> Vector2<R> {
    let [from, to] = displacements(motion, member.ends);
    chord(member, 1.0, from, to)
}

/// The chord of `count` members like this one in a row, between two displaced ends, mm.
#[inline(always)]
fn chord<R: Number>(member: &Member<R>, count: f64, from: Vector2<R>, to: Vector2<R>) -> Vector2<R> {
    let (direction, length_mm) = (member.beam.direction, member.beam.length_mm * count);
    Vector2::new(to.x - from.x + direction.x * length_mm, to.y - from.y + direction.y * length_mm)
}

#[inline(always)]
fn difference<R: Number>(a: Vector2<R>, b: Vector2<R>) -> Vector2<R> {
    Vector2::new(a.x - b.x, a.y - b.y)
}

#[inline(always)]
fn dot<R: Number>(a: Vector2<R>, b: Vector2<R>) -> R {
    a.x * b.x + a.y * b.y
}

/// Positive where b lies to the left of a.
#[inline(always)]
fn cross<R: Number>(a: Vector2<R>, b: Vector2<R>) -> R {
    a.x * b.y - a.y * b.x
}

/// The slope with which the [`cubic`] across `whole` turns a chord of `count` by so much.
#[inline(always)]
fn slope<R: Number>(whole: Vector2<R>, count: usize, chord: Vector2<R>, turn: R) -> R {
    let ((sine, versine), across) = (sine_and_versine(turn), quarter_turn(chord));
    let turned =
        Vector2::new(chord.x + (across.x * sine - chord.x * versine), chord.y + (across.y * sine - chord.y * versine));
    let share = dot(whole, turned) / (dot(chord, chord) * count as f64);
    R::select(share.exceeds(share.constant(0.5)), sine / share, turn)
}

/// s_0 xi (1 - xi)^2 - s_1 xi^2 (1 - xi): the cubic with these slopes at its two ends, of which the second counts back.
#[inline(always)]
fn cubic<R: Number>(slopes: [R; 2], xi: f64) -> R {
    let rest = 1.0 - xi;
    (slopes[0] * rest - slopes[1] * xi) * (xi * rest)
}

/// Slopes of the [`cubic`] whose first and last of `count` chords have these; one node alone cannot turn two chords.
#[inline(always)]
fn end_slopes<R: Number>(chords: [R; 2], count: usize) -> [R; 2] {
    if count < 3 {
        return chords;
    }
    let xi = 1.0 / count as f64;
    let rest = 1.0 - xi;
    let [first, last] = chords;
    let divisor = first.constant(rest * (rest - xi));
    [(first * rest + last * xi) / divisor, (last * rest + first * xi) / divisor]
}

/// Adds to a value where a mask holds.
#[inline(always)]
fn advance<R: Number>(value: &mut R, mask: R::Mask, by: R) {
    *value = R::select(mask, *value + by, *value);
}

/// Displacements of the two ends of an elastic part, mm.
#[inline(always)]
fn displacements<R: Number>(motion: &FrameMotion<R>, ends: [BeamEnd<R>; 2]) -> [Vector2<R>; 2] {
    let [first, second] = end_motions(motion, &ends, false);
    [first.displacement, second.displacement]
}
