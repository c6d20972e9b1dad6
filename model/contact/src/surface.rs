//! Parts of a finger that can touch an object: discs of the rods, and pieces of the surfaces of walls.

use crate::carrier::{Carrier, Mount};
use crate::outline::{ContactOutline, Feature, PoseInFinger};
use crate::pair::Pair;
use crate::part::{Part, Touches};
use crate::region::{Boundary, Region};
use crate::{ContactError, TouchedPart, Wall};
use finray_model::finger::Plate;
use finray_model::frame::FrameMotion;
use finray_model::{Mesh, NodeId, Vector};
use std::ops::Range;

/// Number of pieces into which the surface of one plate element is divided. Each piece meets a corner or a disc of the object at one point at most.
const PIECES: usize = 4;
/// Straight sides of an object meet the plate at the start of every second piece. Closer points would share a force between a corner and the side beside
/// it in an ill-conditioned way.
const PIECES_A_POINT: usize = 2;

/// Surface of a finger that faces a region: discs of the rods and of the ends of the plates, then pieces of the walls.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    /// Parts of the surface.
    pub parts: Vec<Part>,
    /// Consecutive parts on the same line.
    pub runs: Vec<Run>,
    /// The region that contains the object.
    pub region: Region,
    /// Members that bound the region, but on which contact is not modelled.
    pub unmodelled: Vec<Boundary>,
}

/// Consecutive parts of a surface that one line carries.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// The line.
    pub carrier: Carrier,
    /// Indices of the parts.
    pub parts: Range<usize>,
    /// Largest distance of a point of the undeformed surface from the first node, mm.
    reach_mm: f64,
}

/// A deformed part lies within this multiple of its undeformed reach.
const STRETCHED: f64 = 1.2;

impl Run {
    fn new(parts: &[Part], first: usize) -> Run {
        let carrier = parts[0].carrier;
        let line_mm = match carrier {
            Carrier::Rigid { from, along, .. } => from.norm() + along.norm(),
            Carrier::Beam { arms, beam, .. } => arms[0].norm() + beam.length_mm,
        };
        let radius_mm = parts.iter().map(|part| part.radius_mm).fold(0.0, f64::max);
        Run { carrier, parts: first..first + parts.len(), reach_mm: STRETCHED * line_mm + radius_mm }
    }

    /// A lower bound of the distance of the deformed parts from a point (mm, finger frame), mm.
    pub(crate) fn away_mm(&self, nodes: &[f64; 6], point: Vector) -> f64 {
        let position = self.carrier.mounts()[0].map_or(Vector::zeros(), |mount| mount.position);
        (position + Vector::new(nodes[0], nodes[1]) - point).norm() - self.reach_mm
    }
}

/// The mount of a key node.
fn key_mount(mesh: &Mesh, node: NodeId) -> Mount {
    mount(mesh, mesh.frame_node(node))
}

fn mount(mesh: &Mesh, node: usize) -> Mount {
    let (frame, finger) = (mesh.frame(), mesh.finger());
    Mount {
        node,
        rotation: frame.rotation_of(node),
        position: frame.position(node),
        clamped: node < finger.key_node_count() && finger.is_clamped(NodeId(node + 1)),
    }
}

impl Surface {
    /// Passes all pairs of a part of the surface and a feature of the object that are closer than `within_mm` to `add`: index of the part, feature,
    /// geometry of the contact, and gap, mm. `is_relevant` selects the lines that are searched.
    pub(crate) fn near(
        &self,
        motion: &FrameMotion,
        (shape, pose): (&ContactOutline, &PoseInFinger),
        within_mm: f64,
        is_relevant: impl Fn(&Carrier) -> bool,
        mut add: impl FnMut(usize, Feature, Pair, f64),
    ) {
        let corners: Vec<Vector> = shape.corners().0.iter().map(|corner| pose.point(*corner)).collect();
        for run in self.runs.iter().filter(|run| is_relevant(&run.carrier)) {
            let nodes = run.carrier.coordinates(motion);
            if run.away_mm(&nodes, pose.origin) > shape.size_mm() + within_mm {
                continue;
            }
            let line = run.carrier.deformed(&nodes);
            let mut from = line.axis(self.parts[run.parts.start].xi[0]);
            for index in run.parts.clone() {
                let part = &self.parts[index];
                // A point between two pieces precedes the piece that begins there.
                let to = if part.xi[0] < part.xi[1] { line.axis(part.xi[1]) } else { from };
                shape.near(part, &line, [&from, &to], (pose, &corners), within_mm, |feature, pair, gap_mm| {
                    add(index, feature, pair, gap_mm);
                });
                from = to;
            }
        }
    }

    /// Index of the part that begins where the part `index` of the same finger's surface on another mesh begins.
    pub(crate) fn counterpart(&self, other: &Surface, index: usize) -> usize {
        let of = &other.parts[index];
        let away_mm = |part: &Part| match (part.touched, of.touched) {
            (TouchedPart::On(a, a_mm), TouchedPart::On(b, b_mm)) if a == b && part.touches == of.touches => {
                (a_mm - b_mm).abs()
            }
            (a, b) if a == b => 0.0,
            _ => f64::INFINITY,
        };
        let parts = self.parts.iter().map(away_mm).enumerate();
        parts.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(index, |(index, _)| index)
    }

    /// The sides of a finger's walls that face a region, on a finger whose rods have the given radius, mm (0: no rods). A wall on which contact is not
    /// modelled has no part.
    ///
    /// # Errors
    /// [`ContactError::Tapered`] if the front plate tapers, because its surface is then not parallel to its middle line.
    pub(crate) fn new(mesh: &Mesh, rod_radius_mm: f64, region: Region) -> Result<Surface, ContactError> {
        let finger = mesh.finger();
        if finger.tapers(Plate::Front) {
            return Err(ContactError::Tapered);
        }
        let boundaries = region.boundaries(mesh);
        let mut parts = discs(mesh, rod_radius_mm, region);
        for boundary in boundaries.iter().filter(|boundary| boundary.is_modelled(finger)) {
            add_member(mesh, boundary, &mut parts);
        }
        if region.meets_base() {
            parts.push(base(mesh, region));
        }
        let mut runs: Vec<Run> = Vec::new();
        for run in parts.chunk_by(|a, b| a.carrier == b.carrier) {
            runs.push(Run::new(run, runs.last().map_or(0, |last| last.parts.end)));
        }
        let unmodelled = boundaries.into_iter().filter(|boundary| !boundary.is_modelled(finger)).collect();
        Ok(Surface { parts, runs, region, unmodelled })
    }
}

/// Rods, or the rounded ends of the plates without rods.
fn discs(mesh: &Mesh, rod_radius_mm: f64, region: Region) -> Vec<Part> {
    let finger = mesh.finger();
    let half_mm = |plate: Plate| 0.5 * finger.thickness_mm(plate, 0.0);
    let disc = |node: NodeId, radius_mm: f64, touched: TouchedPart| {
        let mount = Some(key_mount(mesh, node));
        let carrier = Carrier::Rigid { mount, from: Vector::zeros(), along: Vector::zeros() };
        Part { carrier, xi: [0.0; 2], radius_mm, side: 1.0, touches: Touches::All, touched, length_mm: 0.0 }
    };
    let nodes = finger.plate_nodes(Plate::Front);
    let levels = match region {
        Region::Outside => &nodes[..],
        Region::Cell(cell) => &nodes[cell..=cell + 1],
    };
    let mut parts = Vec::new();
    if rod_radius_mm > half_mm(Plate::Front) {
        let rods = levels.iter().filter(|node| finger.junction(**node) == **node);
        parts.extend(rods.map(|node| disc(*node, rod_radius_mm, TouchedPart::Rod(*node))));
    }
    if region == Region::Outside {
        let end =
            |wall: Wall, plate: Plate, s_mm: f64, node: NodeId| disc(node, half_mm(plate), TouchedPart::On(wall, s_mm));
        if parts.is_empty() {
            let length_mm = finger.plate_length_mm(Plate::Front);
            parts.push(end(Wall::Front, Plate::Front, 0.0, finger.clamped_nodes()[1]));
            parts.push(end(Wall::Front, Plate::Front, length_mm, finger.tip()));
        }
        parts.push(end(Wall::Back, Plate::Back, 0.0, finger.clamped_nodes()[0]));
    }
    parts
}

/// The base: the straight line between the clamped ends of the plates.
fn base(mesh: &Mesh, region: Region) -> Part {
    let finger = mesh.finger();
    let radius_mm = 0.5 * finger.thickness_mm(Plate::Front, 0.0);
    let [back, front] = [Plate::Back, Plate::Front].map(|plate| finger.base(plate));
    let side = if region == Region::Outside { 1.0 } else { -1.0 };
    let node = finger.clamped_nodes()[0];
    // The surface, not the middle line, is between the clamped ends.
    let from = Vector::new(side * radius_mm, 0.0);
    let carrier = Carrier::Rigid { mount: Some(key_mount(mesh, node)), from, along: front - back };
    let (touched, length_mm) = (TouchedPart::On(Wall::Base, 0.0), (front - back).norm());
    Part { carrier, xi: [0.0, 1.0], radius_mm, side, touches: Touches::Corners, touched, length_mm }
}

/// Adds the pieces of one member: of its arms and of its elements, in the order of its nodes.
fn add_member(mesh: &Mesh, boundary: &Boundary, parts: &mut Vec<Part>) {
    let frame = mesh.frame();
    let (mut from_mm, side) = (boundary.from_mm, boundary.side);
    let radius_mm = boundary.half_mm(mesh.finger(), from_mm);
    let mut add = |carrier: Carrier, length_mm: f64, pieces: usize| {
        for piece in 0..pieces {
            let xi = [piece, piece + 1].map(|i| i as f64 / pieces as f64);
            let touched = TouchedPart::On(boundary.wall, from_mm);
            let length_mm = length_mm / pieces as f64;
            let flat = Part { carrier, xi, radius_mm, side, touches: Touches::Corners, touched, length_mm };
            if piece % PIECES_A_POINT == 0 {
                parts.push(Part { xi: [xi[0]; 2], touches: Touches::Sides, length_mm: 0.0, ..flat });
            }
            parts.push(flat);
            from_mm += length_mm;
        }
    };
    let arm = |node: usize, from: Vector, to: Vector| Carrier::Rigid {
        mount: Some(mount(mesh, node)),
        from,
        along: to - from,
    };
    let elements = &frame.members()[boundary.line(mesh).members.clone()];
    let (Some(first), Some(last)) = (elements.first(), elements.last()) else { return };
    let [start, end] = [first.ends[0], last.ends[1]];
    if start.arm != Vector::zeros() {
        add(arm(start.node, Vector::zeros(), start.arm), start.arm.norm(), 1);
    }
    for element in elements {
        let [a, b] = element.ends;
        let beam = Carrier::Beam {
            mounts: [mount(mesh, a.node), mount(mesh, b.node)],
            arms: [a.arm, b.arm],
            beam: element.beam,
        };
        add(beam, element.beam.length_mm, PIECES);
    }
    if end.arm != Vector::zeros() {
        add(arm(end.node, end.arm, Vector::zeros()), end.arm.norm(), 1);
    }
}
