//! Construction of the frame of a finger: plates, ribs and rigid links, line by line.

use super::prepared::Prepared;
use super::zones::element_start;
use super::{Line, Mesh, PlateSpan};
use crate::finger::{Finger, Joints, NodeId, Part, Plate};
use crate::frame::{BeamEnd, NodeIndex, PlaneFrame, Section};

impl Mesh {
    pub(super) fn build(finger: &Finger, elements: &[usize]) -> Mesh {
        let mut frame = PlaneFrame::default();
        for node in (1..=finger.key_node_count()).map(NodeId) {
            frame.add_node(finger.position(node));
        }
        for node in finger.clamped_nodes() {
            frame.support(node.0 - 1, [true; 3]);
        }
        for node in (1..=finger.key_node_count()).map(NodeId).filter(|node| finger.junction(*node) != *node) {
            frame.tie(finger.junction(node).0 - 1, node.0 - 1);
        }
        if finger.has_brackets() {
            for node in (0..finger.rib_count()).flat_map(|rib| finger.rib_nodes(rib)) {
                frame.add_node(finger.hinge(node));
            }
        }
        // Rigid links must be added before the members, because the links determine the rotation slot of each node.
        for rib in 0..finger.rib_count() {
            link_rib(&mut frame, finger, rib);
        }
        // A plate member between two ribs that share a junction has zero length, so its number of elements is set to 1.
        let one_of_none = |(elements, length_mm)| if length_mm > 0.0 { elements } else { 1 };
        let elements: Vec<usize> = elements.iter().copied().zip(line_lengths(finger)).map(one_of_none).collect();
        let mut mesh = Mesh {
            finger: finger.clone(),
            frame,
            lines: Vec::new(),
            alike: Vec::new(),
            plates: [Vec::new(), Vec::new()],
            node_count: finger.key_node_count() + elements.iter().map(|n| n - 1).sum::<usize>(),
            elements: elements.clone(),
            prepared: Prepared::default(),
        };
        let mut elements = elements.into_iter();
        let mut next = || elements.next().unwrap_or(1);
        for plate in [Plate::Back, Plate::Front] {
            for member in 0..=finger.rib_count() {
                mesh.add_plate_member(plate, member, next());
            }
        }
        for rib in 0..finger.rib_count() {
            mesh.add_rib(rib, next());
        }
        mesh.alike = alike(&mesh.lines);
        mesh
    }

    fn add_plate_member(&mut self, plate: Plate, member: usize, elements: usize) {
        let arms_mm = self.finger.member_arms_mm(plate, member);
        let (nodes, positions) = (self.finger.plate_nodes(plate), self.finger.plate_positions_mm(plate));
        let (nodes, positions) = ([nodes[member], nodes[member + 1]], [positions[member], positions[member + 1]]);
        let along = self.finger.tangent(plate);
        let [from, to] = nodes.map(|node| self.frame_node(node));
        if positions[0] == positions[1] {
            let at = self.frame.members().len();
            self.lines.push(Line { part: plate.into(), nodes: vec![from, to], members: at..at });
            return;
        }
        let ends = [
            BeamEnd { arm: along * arms_mm[0], ..self.frame.clamped_end(from) },
            BeamEnd { arm: along * -arms_mm[1], ..self.frame.clamped_end(to) },
        ];
        let free = [positions[0] + arms_mm[0], positions[1] - arms_mm[1]];
        let position = |i: usize| element_start(free, elements, i);
        let sections: Vec<Section> = (0..elements)
            .map(|i| {
                let section = self.finger.plate_section(plate, member, position(i), position(i + 1));
                let [first_mm, second_mm] = section.axis_mm;
                let axis_mm = |i: usize| first_mm + (second_mm - first_mm) * i as f64 / elements as f64;
                Section { axis_mm: [axis_mm(i), axis_mm(i + 1)], ..section }
            })
            .collect();
        let first_member = self.frame.members().len();
        self.add_line(plate.into(), ends, &sections);
        let spans = &mut self.plates[plate.index()];
        if arms_mm[0] > 0.0 {
            spans.push((free[0], PlateSpan::Arm { end: ends[0], node_mm: positions[0] }));
        }
        spans.extend((0..elements).map(|i| {
            let (member, from_mm, to_mm) = (first_member + i, position(i), position(i + 1));
            (to_mm, PlateSpan::Element { member, from_mm, to_mm })
        }));
        if arms_mm[1] > 0.0 {
            spans.push((positions[1], PlateSpan::Arm { end: ends[1], node_mm: positions[1] }));
        }
    }

    fn add_rib(&mut self, rib: usize, elements: usize) {
        let [front, back] = self.finger.rib_nodes(rib).map(|node| self.hinge_node(node));
        let Some(section) = self.finger.rib_section(rib) else {
            let at = self.frame.members().len();
            self.lines.push(Line { part: Part::Ribs, nodes: vec![back, front], members: at..at });
            return;
        };
        let along = (self.frame.position(front) - self.frame.position(back)).normalize();
        let [front_mm, back_mm] = self.finger.rib_arms_mm(rib);
        let hinged = self.finger.description().ribs.joints == Joints::Hinged;
        let ends = [(back, along * back_mm), (front, along * -front_mm)].map(|(node, arm)| {
            let rotation = if hinged { self.frame.add_rotation() } else { self.frame.rotation_of(node) };
            BeamEnd { node, rotation, arm }
        });
        self.add_line(Part::Ribs, ends, &vec![section; elements]);
    }

    /// Adds a straight chain of elements of equal length between two ends, one element per section.
    fn add_line(&mut self, part: Part, ends: [BeamEnd; 2], sections: &[Section]) {
        let [from, to] = ends.map(|end| self.frame.position(end.node) + end.arm);
        let first_member = self.frame.members().len();
        let mut nodes = vec![ends[0].node];
        let mut before = ends[0];
        for (i, section) in sections.iter().enumerate() {
            let after = if i + 1 == sections.len() {
                ends[1]
            } else {
                let node = self.frame.add_node(from + (to - from) * ((i + 1) as f64 / sections.len() as f64));
                self.frame.clamped_end(node)
            };
            self.frame.add_member([before, after], *section);
            nodes.push(after.node);
            before = after;
        }
        self.lines.push(Line { part, nodes, members: first_member..self.frame.members().len() });
    }
}

/// Groups the lines; see [`Mesh::alike_lines`].
fn alike(lines: &[Line]) -> Vec<Vec<usize>> {
    let mut alike: Vec<Vec<usize>> = Vec::new();
    let is_rib = |line: &Line| line.part == Part::Ribs;
    for (index, line) in lines.iter().enumerate() {
        let same = |other: &Line| is_rib(other) == is_rib(line) && other.members.len() == line.members.len();
        match alike.iter_mut().find(|found| same(&lines[found[0]])) {
            Some(found) => found.push(index),
            None => alike.push(vec![index]),
        }
    }
    alike
}

/// Frame node of a joint between bracket and rib; see [`Mesh::hinge_node`].
pub(super) fn hinge_node(finger: &Finger, node: NodeId) -> NodeIndex {
    let key_nodes = finger.key_node_count();
    let has_rib = node.0 > 1 && node.0 < key_nodes && node != finger.tip();
    match finger.has_brackets() && has_rib {
        // Joints are numbered in the order in which [`Mesh::build`] adds them: rib by rib from base to tip, for each rib first the front joint, then
        // the back joint.
        true if node < finger.tip() => key_nodes + 2 * (node.0 - 2) + 1,
        true => key_nodes + 2 * (key_nodes - 1 - node.0),
        false => node.0 - 1,
    }
}

/// Adds the rigid links of a rib: its brackets, if it has any, and the rib itself, if it does not deform.
fn link_rib(frame: &mut PlaneFrame, finger: &Finger, rib: usize) {
    let [front, back] = finger.rib_nodes(rib).map(|node| node.0 - 1);
    let [front_hinge, back_hinge] = finger.rib_nodes(rib).map(|node| hinge_node(finger, node));
    let hinged = finger.description().ribs.joints == Joints::Hinged;
    let deforms = finger.description().ribs.strip.is_some();
    match (finger.has_brackets(), deforms, hinged) {
        (false, true, _) => {}
        (false, false, _) => frame.link_rigidly(back, front, hinged),
        (true, false, true) => {
            frame.link_rigidly(back, back_hinge, false);
            frame.link_rigidly(back_hinge, front_hinge, true);
            frame.link_rigidly(front_hinge, front, false);
        }
        (true, _, _) => {
            if !deforms {
                frame.link_rigidly(back, front, false);
            }
            frame.link_rigidly(back, back_hinge, false);
            frame.link_rigidly(front, front_hinge, false);
        }
    }
}

/// Lengths of the lines, mm: members of the back plate, members of the front plate, ribs, then the base line. The members of each plate and the ribs
/// are listed from base to tip.
pub(super) fn line_lengths(finger: &Finger) -> Vec<f64> {
    let plates = [Plate::Back, Plate::Front].into_iter().flat_map(|plate| {
        let positions = finger.plate_positions_mm(plate);
        positions.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>()
    });
    let ribs = (0..finger.rib_count()).map(|rib| finger.rib_length_mm(rib));
    plates.chain(ribs).chain(std::iter::once(finger.description().base_width_mm)).collect()
}
