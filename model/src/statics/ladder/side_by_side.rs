//! Condensation and retraction of several lines at once, one line per SIMD lane.

use super::balance::Balance;
use super::brackets::Brackets;
use super::cantilever::Joint;
use super::chain::{Chain, ChainForces, joints_of};
use super::elements::{OneLine, ParallelLines};
use super::factor::Factor;
use super::lines::Condensed;
use super::retraction::Retraction;
use crate::element::{Previous, Response};
use crate::frame::FrameMotion;
use crate::number::Number;
use finray_numerics::linear::copy_lane;
use nalgebra::{SMatrix, Vector2};

/// Whether there are so few lines that scalar computation is faster. One pass in lanes takes about as long as 1.5 scalar passes.
fn are_few<L: Number>(lines: &[usize]) -> bool {
    lines.len() == 1 || L::LANES == 1
}

/// Buffers for the inner unknowns of several lines in SIMD lanes.
struct Room<L: Number> {
    motion: FrameMotion<L>,
    chain: Option<Chain<L>>,
    joints: Vec<Joint<L>>,
    ys: Vec<[L; 3]>,
    previous: Vec<Previous<L>>,
}

impl Balance<'_> {
    /// Same as [`condense_lines`](Balance::condense_lines), but for several lines at once in the number type of `like`.
    #[inline(always)]
    pub(super) fn condense_abreast<L: Number>(&mut self, stiffness: &mut Factor, motion: &FrameMotion, like: L) {
        let mut room = Room {
            motion: FrameMotion::empty(),
            chain: None,
            joints: Vec::new(),
            ys: Vec::new(),
            previous: Vec::new(),
        };
        for alike in self.mesh.alike_lines() {
            room.chain = None;
            for lines in alike.chunks(L::LANES) {
                if are_few::<L>(lines) {
                    for &index in lines {
                        self.condense_line(index, stiffness, motion);
                    }
                } else if !self.mesh.lines()[lines[0]].members.is_empty() {
                    self.condense_some(lines, stiffness, motion, &mut room, like);
                }
            }
        }
        self.sum_energy();
    }

    #[inline(always)]
    fn condense_some<L: Number>(
        &mut self,
        indices: &[usize],
        stiffness: &mut Factor,
        motion: &FrameMotion,
        room: &mut Room<L>,
        like: L,
    ) {
        let (frame, lines, linear) = (self.mesh.frame(), self.mesh.lines(), self.linear());
        let elements = ParallelLines::new(frame, lines, indices, like);
        elements.take_motion(motion, &mut room.motion);
        let joints = lines[indices[0]].members.len() - 1;
        room.joints.resize(joints, Joint::empty(like));
        room.ys.resize(joints, [like; 3]);
        room.previous.resize(joints + 1, Previous::none(like));
        if self.extrapolates {
            for (lane, &line) in indices.iter().enumerate() {
                for (lanes, one) in room.previous.iter_mut().zip(&self.previous[lines[line].members.clone()]) {
                    lanes.set_lane(lane, one);
                }
            }
        }
        let mut loads: Vec<(usize, Response<L>)> = Vec::new();
        if indices.iter().any(|&line| self.applied.on_any_member(&lines[line].members)) {
            let is_loaded = |element: &usize| {
                indices.iter().any(|&line| self.applied.on_member(lines[line].members.start + element).is_some())
            };
            loads.extend((0..=joints).filter(is_loaded).map(|i| (i, self.loads_abreast(indices, i, like))));
        }
        // All ribs of a finger have brackets, or none has.
        let has_brackets = Brackets::of(frame, &lines[indices[0]], motion, linear).is_some();
        let brackets = has_brackets.then(|| {
            let of_line = |&line: &usize| Brackets::of(frame, &lines[line], motion, linear);
            Brackets::of_lanes(&indices.iter().filter_map(of_line).collect::<Vec<_>>(), like)
        });
        let chain = room.chain.get_or_insert_with(|| Chain::new(frame, &lines[indices[0]], like));
        let mut forces = ChainForces::none(like);
        let Room { joints, ys, previous, .. } = room;
        let made = Condensed { chain, joints, forces: &mut forces, ys, previous };
        let load_on = |element: usize| loads.iter().find(|(loaded, _)| *loaded == element).map(|(_, load)| load);
        made.condense(elements, &room.motion, (self.kinematics, self.extrapolates), load_on, brackets);
        for (lane, &line) in indices.iter().enumerate() {
            chain.copy_lane(lane, &mut stiffness.chains[line]);
            forces.copy_lane(lane, &mut self.forces[line]);
            let inner = joints_of(&lines[line]);
            for (one, joint) in stiffness.joints[inner.clone()].iter_mut().zip(&room.joints) {
                joint.copy_lane(lane, one);
            }
            for (one, y) in self.ys[inner].iter_mut().zip(&room.ys) {
                copy_lane(y, lane, one);
            }
            for (one, lanes) in self.previous[lines[line].members.clone()].iter_mut().zip(&room.previous) {
                lanes.copy_lane(lane, one);
            }
        }
    }

    /// The loads on the elements with the index `element` of several lines, one line per lane; zero in lanes without load.
    fn loads_abreast<L: Number>(&self, indices: &[usize], element: usize, like: L) -> Response<L> {
        let load = |lane: usize| {
            let line = &self.mesh.lines()[indices[lane.min(indices.len() - 1)]];
            self.applied.on_member(line.members.start + element)
        };
        let number = |of: &dyn Fn(&Response) -> f64| like.of_lanes(|lane| load(lane).map_or(0.0, of));
        Response {
            energy: number(&|load| load.energy),
            gradient: SMatrix::from_fn(|i, _| number(&|load| load.gradient[i])),
            tangent: SMatrix::from_fn(|i, j| number(&|load| load.tangent[(i, j)])),
        }
    }

    /// Same as [`mend_lines`](Balance::mend_lines), but for several lines at once in the number type of `like`.
    #[inline(always)]
    pub(super) fn mend_abreast<L: Number>(&mut self, stiffness: &Factor, motion: &mut FrameMotion, like: L) {
        let (frame, all) = (self.mesh.frame(), self.mesh.lines());
        let Some(mut retraction) = self.retraction.take() else { return };
        let (mut several, mut of_lines) = (Retraction::empty(), FrameMotion::empty());
        for alike in self.mesh.alike_lines().iter().filter(|alike| all[alike[0]].members.len() > 1) {
            for lines in alike.chunks(L::LANES) {
                if are_few::<L>(lines) {
                    for &index in lines {
                        let elements = OneLine { frame, line: &all[index], like: 0.0 };
                        retraction.mend(elements, motion, self.end_nodes(stiffness, index));
                    }
                    continue;
                }
                let elements = ParallelLines::new(frame, all, lines, like);
                elements.take_motion(&retraction.before, &mut several.before);
                elements.take_motion(motion, &mut of_lines);
                let mut end_nodes = [Vector2::new(like, like); 2];
                for lane in 0..L::LANES {
                    let of_line = self.end_nodes(stiffness, lines[lane.min(lines.len() - 1)]);
                    for (end, one) in end_nodes.iter_mut().zip(of_line) {
                        end.x.set_lane(lane, one.x);
                        end.y.set_lane(lane, one.y);
                    }
                }
                several.mend(elements, &mut of_lines, end_nodes);
                for lane in 0..lines.len() {
                    elements.put_inner_motion(&of_lines, lane, motion);
                }
            }
        }
        self.retraction = Some(retraction);
    }
}
