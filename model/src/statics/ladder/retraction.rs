//! How the nodes inside a member take Newton's correction: so that chords and nodes turn together.
//!
//! Newton adds displacements and rotations. Where a plate member is to turn by `a`, that turns its nodes by `a` but
//! the chords of its elements by atan(a) = a - a^3 / 3 (and by `a e` less if they are to stretch by `e` as well). So
//! both ends of an element of length h turn by phi = a^3 / 3 against its chord, which is a shear force of
//! 12 EI phi / h^2: nothing between key nodes, but the finer the mesh the smaller the turns that leave the tangent
//! positive definite, as h^(2/3), and the more load steps. The end of a rigid arm or link is worse: it swings on a circle,
//! away from neighbours that move straight.
//!
//! Any update that agrees with Newton's to first order converges as fast: a *retraction*. This one leaves the key nodes
//! where Newton has them, takes the nodes between them along with arms and links on a smooth curve, and turns them as
//! their chords have turned. Then a fine mesh needs the load steps and the iterations of a coarse one, if the curve meets
//! the key nodes without a kink: to second order is not enough, as the stiffness of elements grows without bound.
//!
//! Reference: Absil, Mahony, Sepulchre, Optimization Algorithms on Matrix Manifolds (2008), sec. 4.1 and 6.3.

use crate::Vector;
use crate::element::quarter_turn;
use crate::frame::{BeamEnd, FrameMotion, Member, PlaneFrame};
use crate::mesh::Line;

/// A correction that turns no node by more than this, rad, has second-order terms below rounding.
const NO_TURN: f64 = 1e-8;

/// The motion before a correction, and room for what one line needs.
#[derive(Debug, Clone)]
pub(super) struct Retraction {
    before: FrameMotion,
    /// Each element's chord before the correction, mm, and its turn by the correction, rad.
    chords: Vec<(Vector, f64)>,
}

impl Retraction {
    pub(super) fn new(frame: &PlaneFrame) -> Retraction {
        Retraction { before: FrameMotion::at_rest(frame), chords: Vec::new() }
    }

    /// Keeps the motion that is about to be corrected.
    pub(super) fn remember(&mut self, motion: &FrameMotion) {
        self.before.clone_from(motion);
    }

    /// Mends the nodes inside a line to which the correction was added. `key_nodes` are the corrections of its first and
    /// last node, mm; a node at a rigid link has moved otherwise.
    pub(super) fn mend(&mut self, frame: &PlaneFrame, line: &Line, motion: &mut FrameMotion, key_nodes: [Vector; 2]) {
        let members = &frame.members()[line.members.clone()];
        let [first, .., last] = members else { return };
        let turns = |node: &usize| {
            let slot = frame.rotation_of(*node);
            (motion.rotations[slot] - self.before.rotations[slot]).abs() > NO_TURN
        };
        if !line.nodes.iter().any(turns) {
            return;
        }
        let ends = [first.ends[0], last.ends[1]];
        let off = self.measure(frame, line, motion, ends, key_nodes);

        // The inner nodes follow the ends in proportion.
        let count = members.len();
        let inner = || line.nodes[1..count].iter().enumerate().map(|(i, &node)| (node, (i + 1) as f64 / count as f64));
        for (node, xi) in inner() {
            motion.displacements[node] += off[0] * (1.0 - xi) + off[1] * xi;
        }
        // At the ends the chords must turn back to what Newton has for the key nodes; a cubic across the member does it.
        let [from, to] = displacements(frame, motion, ends);
        let whole = first.beam.direction * (first.beam.length_mm * count as f64) + (to - from);
        let leaning = |index: usize, slopes: [f64; 2]| {
            let (chord, surplus) = self.turned(frame, motion, &members[index], index);
            let [before, after] = [index, index + 1].map(|node| cubic(slopes, node as f64 / count as f64));
            let lifted = chord + quarter_turn(whole) * (after - before);
            (lifted, surplus + chord.perp(&lifted).atan2(chord.dot(&lifted)))
        };
        // The slope with which the cubic turns this chord by so much.
        let slope = |chord: Vector, turn: f64| {
            let turned = chord * turn.cos() + quarter_turn(chord) * turn.sin();
            let share = whole.dot(&turned) / (count as f64 * chord.norm_squared());
            if share > 0.5 { turn.sin() / share } else { turn }
        };
        let mut slopes = end_slopes(
            [0, count - 1].map(|end| {
                let (chord, surplus) = leaning(end, [0.0; 2]);
                slope(chord, -surplus)
            }),
            count,
        );
        // That turns the end chords exactly, but it is at the end nodes that the turn is Newton's. Half an element off is a
        // shear force that grows as 1 / h, and with it what an axial force does to the tangent: it loses its sign.
        if count > 2 {
            let ends = [(0, 1), (count - 1, count - 2)].map(|(end, next)| {
                let (chord, surplus) = leaning(end, slopes);
                slope(chord, 0.5 * (leaning(next, slopes).1 - 3.0 * surplus))
            });
            let more = end_slopes(ends, count);
            slopes = [slopes[0] + more[0], slopes[1] + more[1]];
        }
        for (node, xi) in inner() {
            motion.displacements[node] += quarter_turn(whole) * cubic(slopes, xi);
        }
        // A node between two chords turns as these have.
        let (_, mut below) = self.turned(frame, motion, first, 0);
        for (index, member) in members.iter().enumerate().skip(1) {
            let (_, above) = self.turned(frame, motion, member, index);
            motion.rotations[member.ends[0].rotation] += 0.5 * (below + above);
            below = above;
        }
    }

    /// Notes each chord before the correction and its turn by it; returns how far the two ends of the elastic part are
    /// from where the correction has them, mm.
    fn measure(
        &mut self,
        frame: &PlaneFrame,
        line: &Line,
        motion: &FrameMotion,
        ends: [BeamEnd; 2],
        key_nodes: [Vector; 2],
    ) -> [Vector; 2] {
        let Retraction { before, chords } = self;
        let (old, new) = (displacements(frame, before, ends), displacements(frame, motion, ends));
        let corrections = [0, 1].map(|i| {
            let BeamEnd { node, rotation, arm } = ends[i];
            let arm = arm + (old[i] - before.displacements[node]);
            key_nodes[i] + quarter_turn(arm) * (motion.rotations[rotation] - before.rotations[rotation])
        });
        chords.clear();
        let members = &frame.members()[line.members.clone()];
        let (mut position, mut correction) = (old[0], corrections[0]);
        for (member, &node) in members.iter().zip(&line.nodes[1..]) {
            let is_last = chords.len() + 1 == members.len();
            let (next, next_correction) = if is_last {
                (old[1], corrections[1])
            } else {
                (before.displacements[node], motion.displacements[node] - before.displacements[node])
            };
            let chord = member.beam.direction * member.beam.length_mm + (next - position);
            chords.push((chord, chord.perp(&(next_correction - correction)) / chord.norm_squared()));
            (position, correction) = (next, next_correction);
        }
        [0, 1].map(|i| new[i] - old[i] - corrections[i])
    }

    /// An element's chord, mm, and how much further than by the correction it has turned, rad.
    fn turned(&self, frame: &PlaneFrame, motion: &FrameMotion, member: &Member, index: usize) -> (Vector, f64) {
        let (before, turn) = self.chords[index];
        let [from, to] = displacements(frame, motion, member.ends);
        let chord = member.beam.direction * member.beam.length_mm + (to - from);
        (chord, before.perp(&chord).atan2(before.dot(&chord)) - turn)
    }
}

/// s_0 xi (1 - xi)^2 - s_1 xi^2 (1 - xi): the cubic with these slopes at its two ends, of which the second counts back.
fn cubic(slopes: [f64; 2], xi: f64) -> f64 {
    let rest = 1.0 - xi;
    xi * rest * (slopes[0] * rest - slopes[1] * xi)
}

/// Slopes of the [`cubic`] of which the first and the last of `count` chords have these slopes; one node alone cannot turn
/// two chords.
fn end_slopes(chords: [f64; 2], count: usize) -> [f64; 2] {
    if count < 3 {
        return chords;
    }
    let xi = 1.0 / count as f64;
    let rest = 1.0 - xi;
    let [first, last] = chords;
    [(first, last), (last, first)].map(|(near, far)| (rest * near + xi * far) / (rest * (rest - xi)))
}

/// Displacements of the two ends of an elastic part, mm.
fn displacements(frame: &PlaneFrame, motion: &FrameMotion, ends: [BeamEnd; 2]) -> [Vector; 2] {
    frame.end_motions(motion, &ends, false).map(|end| end.displacement)
}
