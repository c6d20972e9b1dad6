//! Retraction of Newton's correction at the nodes inside a member, so that chords and nodes rotate by the same angle.
//!
//! Newton's method adds displacements and rotations linearly. A correction that rotates a plate member by `a` rotates its nodes by `a`. The chords of
//! the member's elements rotate only by atan(a) = a - a^3 / 3 (by `a e` less if the chords also elongate by the strain `e`). Both ends of an element
//! of length h then rotate by phi = a^3 / 3 relative to the element's chord. A rotation phi of both ends relative to the chord causes a shear force
//! of 12 EI phi / h^2. The shear force is negligible for an element that spans a whole member. On finer meshes, however, the tangent stays positive
//! definite only up to a rotation that shrinks as h^(2/3). Without a retraction, finer meshes would therefore need more load steps. The shear force
//! is larger at the end of a rigid arm or link, which moves on a circle while its neighbours move along straight lines.
//!
//! A *retraction* is an update that agrees with Newton's update to first order. Newton's method converges as fast with a retraction as without it.
//! Here, the retraction keeps Newton's update at the key nodes. The retraction moves the nodes between key nodes along a smooth curve that follows
//! arms and links, and rotates these nodes with their chords. With the retraction, a fine mesh needs no more load steps and iterations than a coarse
//! mesh. The curve through the inner nodes must meet the key nodes without a kink. A curve that is correct only to second order does not suffice,
//! because the stiffness of elements grows without bound as they become shorter.
//!
//! Reference: Absil, Mahony, Sepulchre, Optimization Algorithms on Matrix Manifolds (2008), sec. 4.1 and 6.3.

use super::elements::Elements;
use crate::element::quarter_turn;
use crate::frame::{BeamEnd, FrameMotion, Member, PlaneFrame, end_motions};
use crate::number::{Number, arctangent, sine_and_versine};
use nalgebra::Vector2;

/// For rotations below this angle, rad, second-order terms are smaller than rounding errors.
const NO_TURN: f64 = 1e-8;

/// The motion before a correction, and buffers for one line.
#[derive(Debug, Clone)]
pub(super) struct Retraction<R> {
    pub(super) before: FrameMotion<R>,
    /// Chord of each element before the correction, mm, and rotation of the chord by the linear correction, rad.
    chords: Vec<(Vector2<R>, R)>,
}

impl<R: Number> Retraction<R> {
    /// Allocates the buffers for a frame, in the number type of `like`.
    pub(super) fn new(frame: &PlaneFrame, like: R) -> Retraction<R> {
        Retraction { before: FrameMotion::of_zeros(frame, like), chords: Vec::new() }
    }

    /// A retraction without buffers.
    pub(super) fn empty() -> Retraction<R> {
        Retraction { before: FrameMotion::empty(), chords: Vec::new() }
    }

    /// Updates the inner nodes of a line after a correction was added, in the lanes in which at least one of the line's nodes rotates. `end_nodes`
    /// are the linear corrections of the line's first and last node, mm. If the first or last node follows a rigid link, its motion differs from its
    /// linear correction.
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

        // First, the inner nodes follow the ends linearly.
        for i in 1..count {
            let xi = i as f64 / count as f64;
            let u = &mut motion.displacements[elements.node(i)];
            advance(&mut u.x, turns, off[0].x * (1.0 - xi) + off[1].x * xi);
            advance(&mut u.y, turns, off[0].y * (1.0 - xi) + off[1].y * xi);
        }
        // Then, a cubic deflection across the member rotates the end chords back to Newton's rotations of the key nodes.
        let [from, to] = displacements(motion, ends);
        let whole = chord(&first, count as f64, from, to);
        // Closures would not be inlined here, and each lane operation would become a function call.
        let end_chord = chord_in(motion, &first);
        let first_slope = slope(whole, count, end_chord, -self.surplus(0, end_chord));
        let end_chord = chord_in(motion, &last);
        let last_slope = slope(whole, count, end_chord, -self.surplus(count - 1, end_chord));
        let mut slopes = end_slopes([first_slope, last_slope], count);
        // The slopes so far rotate the end chords by exactly Newton's rotations. These rotations, however, apply at the end nodes, half an element
        // away from the middle of the end chords. This offset of half an element would cause a shear force that grows as 1 / h with the element
        // length h. A larger shear force would increase the effect of axial forces, so the tangent might lose positive definiteness.
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
        // An inner node rotates with the mean rotation of the two adjacent chords.
        let mut below = self.surplus(0, chord_in(motion, &first));
        for index in 1..count {
            let member = elements.member(index);
            let above = self.surplus(index, chord_in(motion, &member));
            advance(&mut motion.rotations[member.ends[0].rotation], turns, (below + above) * 0.5);
            below = above;
        }
    }

    /// Chord of an element (mm), and its rotation beyond the linear correction (rad), after the [`cubic`] with the given slopes is added across the
    /// member. The element is number `index` of `count` elements.
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

    /// Stores each chord and the chord's rotation by the linear correction. Returns the offset of each end of the elastic part from its linear
    /// correction, mm.
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

    /// Rotation of an element beyond the linear correction, rad, given the element's current chord, mm.
    #[inline(always)]
    fn surplus(&self, index: usize, chord: Vector2<R>) -> R {
        let (before, turn) = self.chords[index];
        arctangent(cross(before, chord), dot(before, chord)) - turn
    }
}

/// Current chord vector of an element, mm.
#[inline(always)]
fn chord_in<R: Number>(motion: &FrameMotion<R>, member: &Member<R>) -> Vector2<R> {
    let [from, to] = displacements(motion, member.ends);
    chord(member, 1.0, from, to)
}

/// Chord vector of `count` equal members in a row between two displaced ends, mm.
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

/// Cross product a x b; positive if b lies to the left of a.
#[inline(always)]
fn cross<R: Number>(a: Vector2<R>, b: Vector2<R>) -> R {
    a.x * b.y - a.y * b.x
}

/// End slope of the [`cubic`] across `whole` that rotates `chord`, the chord of one of `count` elements, by `turn`, rad.
#[inline(always)]
fn slope<R: Number>(whole: Vector2<R>, count: usize, chord: Vector2<R>, turn: R) -> R {
    let ((sine, versine), across) = (sine_and_versine(turn), quarter_turn(chord));
    let turned =
        Vector2::new(chord.x + (across.x * sine - chord.x * versine), chord.y + (across.y * sine - chord.y * versine));
    let share = dot(whole, turned) / (dot(chord, chord) * count as f64);
    R::select(share.exceeds(share.constant(0.5)), sine / share, turn)
}

/// Cubic s_0 xi (1 - xi)^2 - s_1 xi^2 (1 - xi) with the slopes s_0 and s_1 at its two ends; dimensionless.
#[inline(always)]
fn cubic<R: Number>(slopes: [R; 2], xi: f64) -> R {
    let rest = 1.0 - xi;
    (slopes[0] * rest - slopes[1] * xi) * (xi * rest)
}

/// End slopes of the [`cubic`], computed from the slopes of the first and the last of `count` chords. With fewer than three chords, the slopes are
/// returned unchanged.
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

/// Adds `by` to a value in the lanes that `mask` selects.
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
