//! Numbering of the unknowns of a frame.

use super::{BeamEnd, FrameMotion, PlaneFrame};

/// Largest number of rigid levers in series between a master node and a node that follows it: the three levers are a bracket, a rib, and another
/// bracket.
pub(super) const MOST_LEVERS: usize = 3;
/// Number of coordinates that may move a node: x and y of the node or of its master, the node's rotation, and the rotations of its levers.
pub(super) const NODE_COORDINATES: usize = 3 + MOST_LEVERS;
/// Number of coordinates that may move the two nodes of a member.
pub(crate) const MEMBER_COORDINATES: usize = 2 * NODE_COORDINATES;

/// Equation numbers of the free translations and rotations of a frame; `None` for fixed coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Equations {
    /// Equation numbers of x and y of each node.
    translations: Vec<[Option<usize>; 2]>,
    /// Equation number of each rotation slot.
    rotations: Vec<Option<usize>>,
    /// Number of unknowns.
    count: usize,
}

impl Equations {
    /// Assigns equation numbers to x, y and rotation of each node in the order of the nodes, then to the remaining rotations.
    pub fn of(frame: &PlaneFrame) -> Equations {
        let mut count = 0;
        let mut next = || {
            count += 1;
            Some(count - 1)
        };
        let mut translations = vec![[None; 2]; frame.nodes.len()];
        let mut rotations = vec![None; frame.rotation_fixed.len()];
        // Rotation slots that no beam or link uses get no equation: they would be unknowns without stiffness.
        let mut used = vec![false; rotations.len()];
        for end in frame.members.iter().flat_map(|m| m.ends) {
            used[end.rotation] = true;
        }
        for lever in frame.nodes.iter().filter_map(|node| node.link).flat_map(|link| link.levers()) {
            used[lever.rotation] = true;
        }
        for (node, equation) in frame.nodes.iter().zip(&mut translations) {
            if node.link.is_none() {
                *equation = node.fixed.map(|fixed| if fixed { None } else { next() });
            }
            let slot = node.rotation;
            if used[slot] && !frame.rotation_fixed[slot] && rotations[slot].is_none() {
                rotations[slot] = next();
            }
        }
        for slot in 0..rotations.len() {
            if used[slot] && !frame.rotation_fixed[slot] && rotations[slot].is_none() {
                rotations[slot] = next();
            }
        }
        Equations { translations, rotations, count }
    }

    /// Number of unknowns.
    pub fn count(&self) -> usize {
        self.count
    }

    /// A vector with one entry per unknown. The entry is `translation` if the unknown is a displacement, and `rotation` if it is a rotation.
    pub(crate) fn by_kind(&self, translation: f64, rotation: f64) -> Vec<f64> {
        let mut figures = vec![translation; self.count];
        for &equation in self.rotations.iter().flatten() {
            figures[equation] = rotation;
        }
        figures
    }

    /// Adds a correction of all unknowns (mm, rad) to a motion, and moves linked nodes with their masters. If `linear`, the rotations of levers are
    /// linearised.
    pub fn advance(&self, frame: &PlaneFrame, motion: &mut FrameMotion, correction: &[f64], linear: bool) {
        for (u, equations) in motion.displacements.iter_mut().zip(&self.translations) {
            for (value, equation) in u.iter_mut().zip(equations) {
                *value += equation.map_or(0.0, |e| correction[e]);
            }
        }
        for (value, equation) in motion.rotations.iter_mut().zip(&self.rotations) {
            *value += equation.map_or(0.0, |e| correction[e]);
        }
        frame.follow_links(motion, linear);
    }

    /// Equation numbers of the coordinates that move a beam end.
    fn of_end(&self, frame: &PlaneFrame, end: &BeamEnd) -> [Option<usize>; NODE_COORDINATES] {
        let node = &frame.nodes[end.node];
        let carrier = node.link.map_or(end.node, |link| link.master);
        let [x, y] = self.translations[carrier];
        let levers = node.link.map_or([None; MOST_LEVERS], |link| link.levers);
        let [first, second, third] = levers.map(|lever| self.rotations[lever?.rotation]);
        [x, y, self.rotations[end.rotation], first, second, third]
    }

    /// Equation numbers of the coordinates that move two beam ends, first end first.
    pub(crate) fn of_ends(&self, frame: &PlaneFrame, ends: &[BeamEnd; 2]) -> [Option<usize>; MEMBER_COORDINATES] {
        let [a, b] = ends.map(|end| self.of_end(frame, &end));
        std::array::from_fn(|i| if i < NODE_COORDINATES { a[i] } else { b[i - NODE_COORDINATES] })
    }
}
