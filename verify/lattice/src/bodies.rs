//! Divides a finger into rigid bodies: one at every rod (junction), and others between the short segments of plates and ribs.

use super::LatticeError;
use super::springs::{Anchor, AxialSprings, BodyIndex, Segment, Spring};
use finray_model::finger::{Joints, Part, Plate, PlatePosition, Zone};
use finray_model::frame::Section;
use finray_model::mesh::{Load, LoadError};
use finray_model::{Finger, NodeId, Vector};

/// A rigid body. In the undeformed finger, the axes of the body are parallel to the axes of the finger frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Undeformed position of the centre, mm, finger frame.
    pub position: Vector,
    /// Whether the body is clamped and never moves.
    pub fixed: bool,
}

/// The part of a dead load that acts on one body. With the body's displacement u and rotation theta, the work of this part is share * (F . u) + F .
/// (R(theta) lever - lever) + M theta.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyLoad {
    /// Body that carries this part of the load.
    pub body: BodyIndex,
    /// Force F of the whole load, N, finger frame; the body carries a share of F.
    pub force: Vector,
    /// Share of the force that acts on this body, dimensionless.
    pub share: f64,
    /// Lever arm about the body's centre, undeformed, mm. The moment of this part of the load is the cross product of lever arm and whole force F.
    pub lever: Vector,
    /// Moment M on the body, N mm.
    pub moment_nmm: f64,
}

/// A piece of a plate that can carry a load.
#[derive(Debug, Clone, Copy, PartialEq)]
enum PlateSpan {
    /// A rigid arm that is fixed to a rod. The arm's anchor is at the position `at_mm` along the plate.
    Arm { anchor: Anchor, at_mm: f64 },
    /// A segment between two bodies, from `from_mm` to `to_mm` along the plate.
    Segment { ends: [Anchor; 2], from_mm: f64, to_mm: f64 },
}

/// A straight piece of a plate's middle line that moves with one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlatePiece {
    /// Body that carries the piece.
    pub body: BodyIndex,
    /// Vectors from the body's centre to the two ends of the piece, undeformed, mm; the end nearer to the base comes first.
    pub ends: [Vector; 2],
    /// Position along the plate at which the piece starts, mm from the base.
    pub from_mm: f64,
}

/// Bodies and springs of a finger; see the [module](super).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Assembly {
    /// Bodies of the key nodes, followed by the bodies between segments.
    pub bodies: Vec<Body>,
    /// Springs between the bodies.
    pub springs: Vec<Spring>,
    /// Body and arm of each key node, in the order of the nodes.
    pub key_nodes: Vec<Anchor>,
    /// Pieces of front and back plate from base to tip, each with the position along the plate at which the piece ends, mm.
    plates: [Vec<(f64, PlateSpan)>; 2],
    /// Properties of the segments' axial springs.
    axial: AxialSprings,
}

impl Assembly {
    /// Divides a finger into segments of nearly equal length; a plate member of mean length has `fineness` segments.
    ///
    /// # Errors
    /// [`LatticeError::NoSegments`] if `fineness` is 0, [`LatticeError::TooFine`] if the lattice would have too many bodies.
    pub fn new(finger: &Finger, fineness: usize, axial: AxialSprings) -> Result<Assembly, LatticeError> {
        if fineness == 0 {
            return Err(LatticeError::NoSegments);
        }
        let target_mm = mean_plate_member_mm(finger) / fineness as f64;
        let segments = members_mm(finger).map(|length_mm| segments_of(length_mm, target_mm) as f64).sum::<f64>();
        if segments > MOST_SEGMENTS {
            return Err(LatticeError::TooFine { fineness });
        }
        let mut assembly = Assembly { axial, ..Assembly::default() };
        assembly.add_rods(finger);
        for plate in [Plate::Back, Plate::Front] {
            assembly.add_plate(finger, plate, target_mm);
        }
        for rib in 0..finger.rib_count() {
            assembly.add_rib(finger, rib, target_mm);
        }
        Ok(assembly)
    }

    /// Adds a body at every key node. Key nodes at the same point share a body, and so do the two rods of an undeformable rib.
    fn add_rods(&mut self, finger: &Finger) {
        let ribs = &finger.description().ribs;
        let welded = ribs.strip.is_none() && ribs.joints == Joints::Rigid;
        for node in (1..=finger.key_node_count()).map(NodeId) {
            let position = finger.position(node);
            let back = finger.key_node_count() + 1 - node.0;
            let before = self.key_nodes.last().filter(|_| finger.junction(NodeId(node.0 - 1)) == finger.junction(node));
            let anchor = if let Some(shared) = before {
                *shared
            } else if welded && node > finger.tip() && !finger.is_clamped(node) {
                Anchor { body: back - 1, arm: position - finger.position(NodeId(back)) }
            } else {
                self.bodies.push(Body { position, fixed: finger.is_clamped(node) });
                Anchor { body: self.bodies.len() - 1, arm: Vector::zeros() }
            };
            self.key_nodes.push(anchor);
        }
    }

    fn add_plate(&mut self, finger: &Finger, plate: Plate, target_mm: f64) {
        let zones: Vec<&Zone> =
            finger.description().zones.iter().filter(|zone| zone.part == Part::from(plate)).collect();
        let along = finger.tangent(plate);
        let positions = finger.plate_positions_mm(plate);
        for (member, (nodes, positions)) in finger.plate_nodes(plate).windows(2).zip(positions.windows(2)).enumerate() {
            if positions[0] == positions[1] {
                continue;
            }
            let arms_mm = finger.member_arms_mm(plate, member);
            let [from, to] = [
                self.key_nodes[nodes[0].0 - 1].moved(along * arms_mm[0]),
                self.key_nodes[nodes[1].0 - 1].moved(along * -arms_mm[1]),
            ];
            let free_mm = [positions[0] + arms_mm[0], positions[1] - arms_mm[1]];
            let borders = borders_mm(free_mm, &zones, target_mm);
            let of_base = finger.member_section(plate, member);
            let anchors = self.divide([from, to], &borders);
            let spans = &mut self.plates[usize::from(plate == Plate::Back)];
            spans.push((free_mm[0], PlateSpan::Arm { anchor: from, at_mm: free_mm[0] }));
            for (&ends, border) in anchors.iter().zip(borders.windows(2)) {
                let (from_mm, to_mm) = (border[0], border[1]);
                let section = tapered(finger, plate, of_base, 0.5 * (from_mm + to_mm));
                let section = section.scaled(1.0 / mean_compliance(&zones, from_mm, to_mm));
                let segment =
                    Segment { ends, pinned: [false; 2], direction: along, length_mm: to_mm - from_mm, section };
                self.springs.extend(segment.springs(self.axial));
                spans.push((to_mm, PlateSpan::Segment { ends, from_mm, to_mm }));
            }
            spans.push((positions[1], PlateSpan::Arm { anchor: to, at_mm: free_mm[1] }));
        }
    }

    fn add_rib(&mut self, finger: &Finger, rib: usize, target_mm: f64) {
        let [front, back] = finger.rib_nodes(rib);
        let between = finger.hinge(front) - finger.hinge(back);
        let direction = between.normalize();
        let joint = |node: NodeId| self.key_nodes[node.0 - 1].moved(finger.bracket(node));
        let [back, front] = [back, front].map(joint);
        let hinged = finger.description().ribs.joints == Joints::Hinged;
        let Some(section) = finger.rib_section(rib) else {
            if hinged {
                let ends = [back, front];
                let section = undeformable_bar(finger);
                let bar = Segment { ends, pinned: [true; 2], direction, length_mm: between.norm(), section };
                self.springs.extend(bar.springs(self.axial));
            }
            // An undeformable rib with rigid joints is part of its rods' common body.
            return;
        };
        let [front_mm, back_mm] = finger.rib_arms_mm(rib);
        let ends = [back.moved(direction * back_mm), front.moved(direction * -front_mm)];
        let borders = borders_mm([0.0, between.norm() - front_mm - back_mm], &[], target_mm);
        let segments = borders.len() - 1;
        let length_mm = borders[1];
        for (i, ends) in self.divide(ends, &borders).into_iter().enumerate() {
            let pinned = [hinged && i == 0, hinged && i + 1 == segments];
            let segment = Segment { ends, pinned, direction, length_mm, section };
            self.springs.extend(segment.springs(self.axial));
        }
    }

    /// Adds bodies on the straight line between two anchors, at the inner `borders` (mm from the first anchor). Returns the end anchors of each segment.
    fn divide(&mut self, ends: [Anchor; 2], borders: &[f64]) -> Vec<[Anchor; 2]> {
        let [from, to] = ends.map(|end| self.bodies[end.body].position + end.arm);
        let (first, last) = (borders[0], borders[borders.len() - 1]);
        let mut chain = vec![ends[0]];
        for border in &borders[1..borders.len() - 1] {
            let position = from + (to - from) * ((border - first) / (last - first));
            self.bodies.push(Body { position, fixed: false });
            chain.push(Anchor { body: self.bodies.len() - 1, arm: Vector::zeros() });
        }
        chain.push(ends[1]);
        chain.windows(2).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// Pieces of a plate's middle line from base to tip, one per body. Two pieces meet at the middle of a segment.
    pub fn plate_pieces(&self, plate: Plate) -> Vec<PlatePiece> {
        let mut pieces: Vec<PlatePiece> = Vec::new();
        let mut add = |from: Anchor, by: Vector, from_mm: f64| match pieces.last_mut() {
            Some(last) if last.body == from.body => last.ends[1] = from.arm + by,
            _ => pieces.push(PlatePiece { body: from.body, ends: [from.arm, from.arm + by], from_mm }),
        };
        for &(_, piece) in &self.plates[usize::from(plate == Plate::Back)] {
            match piece {
                PlateSpan::Arm { anchor, at_mm } => add(anchor, Vector::zeros(), at_mm),
                PlateSpan::Segment { ends: [from, to], from_mm, to_mm } => {
                    let at = |anchor: Anchor| self.bodies[anchor.body].position + anchor.arm;
                    let half = 0.5 * (at(to) - at(from));
                    add(from, half, from_mm);
                    add(to.moved(-half), half, 0.5 * (from_mm + to_mm));
                }
            }
        }
        pieces
    }

    /// Distributes a load over the bodies that carry it, one entry per body.
    ///
    /// Between two bodies the deflection of the plate is a cubic polynomial. Each of the two bodies at the ends of a loaded segment therefore carries
    /// the share of the force given by its cubic (Hermite) shape function. The share has a lever arm along the plate. The force component along the
    /// plate has the same shares, although linear shares would be exact. With cubic instead of linear shares, up to a tenth of the force component
    /// along the plate acts on the wrong end of one segment. The error of the shares changes only the axial strain of the loaded segment.
    ///
    /// # Errors
    /// [`LoadError`] if a node does not exist or is clamped, or if a position is not on its plate.
    pub fn body_loads(&self, finger: &Finger, load: &Load) -> Result<Vec<BodyLoad>, LoadError> {
        match *load {
            Load::Node { node, force, moment_nmm } => {
                let key_nodes = finger.key_node_count();
                if !(1..=key_nodes).contains(&node.0) {
                    return Err(LoadError::NodeMissing { node, key_nodes });
                }
                if finger.is_clamped(node) {
                    return Err(LoadError::NodeClamped { node });
                }
                let Anchor { body, arm } = self.key_nodes[node.0 - 1];
                Ok(vec![BodyLoad { body, force, share: 1.0, lever: arm, moment_nmm }])
            }
            Load::Plate { at: at @ PlatePosition { plate, s_mm }, force } => {
                let length_mm = finger.plate_length_mm(plate);
                let spans = &self.plates[usize::from(plate == Plate::Back)];
                let piece = (s_mm > 0.0).then(|| spans.iter().find(|(end, _)| s_mm <= *end)).flatten();
                let Some((_, piece)) = piece else { return Err(LoadError::PositionOffPlate { at, length_mm }) };
                let along = finger.tangent(plate);
                let on_body = |anchor: Anchor, share: f64, lever_mm: f64| BodyLoad {
                    body: anchor.body,
                    force,
                    share,
                    lever: anchor.arm * share + along * lever_mm,
                    moment_nmm: 0.0,
                };
                Ok(match *piece {
                    PlateSpan::Arm { anchor, at_mm } => vec![on_body(anchor, 1.0, s_mm - at_mm)],
                    PlateSpan::Segment { ends, from_mm, to_mm } => {
                        let length = to_mm - from_mm;
                        let x = (s_mm - from_mm) / length;
                        let second = x * x * (3.0 - 2.0 * x);
                        vec![
                            on_body(ends[0], 1.0 - second, length * x * (1.0 - x) * (1.0 - x)),
                            on_body(ends[1], second, -length * x * x * (1.0 - x)),
                        ]
                    }
                })
            }
        }
    }
}

/// Largest accepted number of segments in a lattice, far above any useful number.
const MOST_SEGMENTS: f64 = 20_000.0;
/// Axial rigidity of an undeformable hinged rib, relative to that of the stiffer plate. Plates are much softer in bending than the rib is in tension,
/// so the strain of the rib is negligible. With a much stiffer rib, the lattice would settle more slowly.
const UNDEFORMABLE: f64 = 10.0;

fn undeformable_bar(finger: &Finger) -> Section {
    let rigidity = |part| finger.section(part).map_or(0.0, |section| section.axial_rigidity_n);
    let axial_rigidity_n = UNDEFORMABLE * rigidity(Part::Front).max(rigidity(Part::Back));
    Section { axial_rigidity_n, bending_rigidity_nmm2: 0.0, shear_flexibility: 0.0, axis_mm: [0.0; 2] }
}

/// Free lengths of all members, mm: of the back plate, then of the front plate, then of the ribs.
fn members_mm(finger: &Finger) -> impl Iterator<Item = f64> {
    let plates = [Plate::Back, Plate::Front].into_iter().flat_map(|plate| {
        let positions = finger.plate_positions_mm(plate);
        let free = |(member, ends): (usize, &[f64])| {
            let arms_mm = finger.member_arms_mm(plate, member);
            ends[1] - ends[0] - arms_mm[0] - arms_mm[1]
        };
        positions.windows(2).enumerate().map(free).collect::<Vec<_>>()
    });
    let ribs =
        (0..finger.rib_count()).map(|rib| finger.rib_length_mm(rib) - finger.rib_arms_mm(rib).iter().sum::<f64>());
    plates.chain(ribs)
}

/// Mean free length of the plate members, mm.
fn mean_plate_member_mm(finger: &Finger) -> f64 {
    let count = 2 * (finger.rib_count() + 1);
    members_mm(finger).take(count).sum::<f64>() / count as f64
}

/// Number of segments, about `target_mm` long each, in a member of length `length_mm`; at least one.
fn segments_of(length_mm: f64, target_mm: f64) -> usize {
    ((length_mm / target_mm).round() as usize).max(1)
}

/// A segment border is placed at the end of a zone only if the pieces on both sides are at least this share of the target segment length. A shorter
/// piece would be stiffer, and the lattice would not settle. If no border is placed at the end of a zone, the modulus is averaged over the segment.
const SHORTEST_CUT: f64 = 0.25;

/// Positions of the segment ends of a member, mm: at the ends of zones and, between these ends, at distances of about `target_mm`.
fn borders_mm([from, to]: [f64; 2], zones: &[&Zone], target_mm: f64) -> Vec<f64> {
    let mut ends: Vec<f64> = zones.iter().flat_map(|zone| [zone.from_mm, zone.to_mm]).collect();
    ends.sort_by(f64::total_cmp);
    let shortest = SHORTEST_CUT * target_mm;
    let mut cuts = vec![from];
    for end in ends {
        if end - cuts[cuts.len() - 1] >= shortest && to - end >= shortest {
            cuts.push(end);
        }
    }
    cuts.push(to);
    let mut borders = vec![from];
    for cut in cuts.windows(2) {
        let segments = segments_of(cut[1] - cut[0], target_mm);
        // The last position equals the member's end exactly, so that a load at the tip finds a segment.
        let within = (1..segments).map(|i| cut[0] + (cut[1] - cut[0]) * i as f64 / segments as f64);
        borders.extend(within.chain([cut[1]]));
    }
    borders
}

/// Section of a plate at the position `s_mm` (mm from the base), given the section at the base.
fn tapered(finger: &Finger, plate: Plate, of_base: Section, s_mm: f64) -> Section {
    let share = finger.thickness_mm(plate, s_mm) / finger.thickness_mm(plate, 0.0);
    Section {
        axial_rigidity_n: of_base.axial_rigidity_n * share,
        bending_rigidity_nmm2: of_base.bending_rigidity_nmm2 * share.powi(3),
        ..of_base
    }
}

/// Length-weighted mean of 1 / modulus factor between two positions of a plate, dimensionless. The factors of overlapping zones are multiplied.
fn mean_compliance(zones: &[&Zone], from_mm: f64, to_mm: f64) -> f64 {
    let mut cuts = vec![from_mm, to_mm];
    cuts.extend(zones.iter().flat_map(|zone| [zone.from_mm, zone.to_mm]).filter(|cut| (from_mm..to_mm).contains(cut)));
    cuts.sort_by(f64::total_cmp);
    let compliance = |from: f64, to: f64| {
        let middle = 0.5 * (from + to);
        let here = zones.iter().filter(|zone| (zone.from_mm..=zone.to_mm).contains(&middle));
        (to - from) / here.map(|zone| zone.modulus_factor).product::<f64>()
    };
    cuts.windows(2).map(|cut| compliance(cut[0], cut[1])).sum::<f64>() / (to_mm - from_mm)
}
