//! Rigid links. A rigid link makes a node follow another node through rigid levers, which rotate.

use super::equations::MOST_LEVERS;
use super::members::{swing, turned, vector_of};
use super::{FrameMotion, NodeIndex, PlaneFrame, RotationSlot};
use crate::Vector;
use crate::number::Number;
use nalgebra::Vector2;

/// A rigid bar, stored as the undeformed vector from its first to its second node, mm. The bar rotates with a rotation slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lever {
    /// Rotation slot with which the bar rotates.
    pub rotation: RotationSlot,
    /// Undeformed vector along the bar, mm.
    pub along: Vector,
}

/// Makes a node follow a master through rigid levers in series: u = u_master + sum over levers of (R(rotation) - 1) lever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RigidLink {
    /// The first node of the series, which follows no other node.
    pub master: NodeIndex,
    pub levers: [Option<Lever>; MOST_LEVERS],
}

impl RigidLink {
    /// The levers in order from the master.
    #[inline(always)]
    pub fn levers(&self) -> impl Iterator<Item = Lever> + use<> {
        self.levers.into_iter().flatten()
    }
}

impl PlaneFrame {
    /// Joins two free nodes by an undeformable bar. If `hinged`, the bar is pinned at both nodes; otherwise nodes and bar rotate together.
    ///
    /// The second node follows the first node and the bar's rotation. The first node may itself follow another node.
    ///
    /// # Panics
    /// Panics if the second node would follow its master through more than three bars in series.
    pub fn link_rigidly(&mut self, first: NodeIndex, second: NodeIndex, hinged: bool) {
        let along = self.position(second) - self.position(first);
        let rotation = if hinged {
            self.add_rotation()
        } else {
            self.nodes[second].rotation = self.nodes[first].rotation;
            self.nodes[first].rotation
        };
        let row = self.nodes[first].link;
        let mut link = row.unwrap_or(RigidLink { master: first, levers: [None; MOST_LEVERS] });
        let free = link.levers.iter_mut().find(|lever| lever.is_none());
        *free.expect("at most three bars in a row") = Some(Lever { rotation, along });
        self.nodes[second].link = Some(link);
    }

    /// Ties the second node to the first node at the same point. The second node then moves and rotates with the first node.
    pub fn tie(&mut self, first: NodeIndex, second: NodeIndex) {
        self.nodes[second].rotation = self.nodes[first].rotation;
        let row = self.nodes[first].link;
        self.nodes[second].link = Some(row.unwrap_or(RigidLink { master: first, levers: [None; MOST_LEVERS] }));
    }

    /// The node to which `node` is tied, or `node` if it is not tied.
    pub fn tied_to(&self, node: NodeIndex) -> NodeIndex {
        let tied = self.nodes[node].link.filter(|link| link.levers().next().is_none());
        tied.map_or(node, |link| link.master)
    }

    /// Computes the displacements of linked nodes from their masters and levers.
    #[inline(always)]
    pub(crate) fn follow_links<R: Number>(&self, motion: &mut FrameMotion<R>, linear: bool) {
        for (n, node) in self.nodes.iter().enumerate() {
            if let Some(link) = &node.link {
                let mut u = motion.displacements[link.master];
                for Lever { rotation, along } in link.levers() {
                    let turn = motion.rotations[rotation];
                    let swung = swing(vector_of(along, turn), turn, linear);
                    u = Vector2::new(u.x + swung.x, u.y + swung.y);
                }
                motion.displacements[n] = u;
            }
        }
    }

    /// The levers between a linked node and its master, each with its rotation slot and its current vector, mm; none for a node without a link.
    #[inline(always)]
    pub(crate) fn turned_levers<'a, R: Number>(
        &'a self,
        node: NodeIndex,
        motion: &'a FrameMotion<R>,
        linear: bool,
    ) -> impl Iterator<Item = (RotationSlot, Vector2<R>)> + 'a {
        let levers = self.nodes[node].link.iter().flat_map(RigidLink::levers);
        levers.map(move |lever| {
            let turn = motion.rotations[lever.rotation];
            (lever.rotation, turned(vector_of(lever.along, turn), turn, linear))
        })
    }

    /// The rotation slots of the levers between a linked node and its master; none for a node without a link.
    pub(crate) fn lever_rotations(&self, node: NodeIndex) -> impl Iterator<Item = RotationSlot> {
        self.nodes[node].link.iter().flat_map(RigidLink::levers).map(|lever| lever.rotation)
    }

    /// Whether a node follows another node through at least one lever.
    pub(crate) fn is_linked(&self, node: NodeIndex) -> bool {
        self.nodes[node].link.as_ref().is_some_and(|link| link.levers[0].is_some())
    }
}
