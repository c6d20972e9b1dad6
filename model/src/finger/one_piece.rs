//! Rigid arms of a finger of one piece: plates, ribs and fillets stiffen each other's ends.
//!
//! A member carries its force in its own section. Where it meets another member or a fillet, the section that carries the force widens, at most at a
//! slope that depends on the kind of member. The arm is the length that bending loses by this: the integral of 1 - (t / w)^3 along the member, with
//! its thickness t and the width w that carries. `fixtures/solids` contains the solids that determine the constants, and others that judge them.

use super::placement::require;
use super::{Fillets, Finger, ImpossibleFinger, NodeId, Plate};
use crate::keys::FINGER;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Slope at which the carrying section of a rib, or of a plate at the base, widens, dimensionless. Solids hardly depend on a slope from 2 to 10.
const RIB_SLOPE: f64 = 2.0;
/// Slope at which the carrying section of a plate widens, dimensionless: little, because ribs hold only one face of a plate.
const PLATE_SLOPE: f64 = 0.37;
/// Length by which a rib's arm is shorter, because the plate yields under the end of the rib; relative to the plate's thickness.
const YIELD_OF_PLATE: f64 = 0.1;
/// Length by which the arm of a plate with fillets at the base is shorter, relative to the plate's thickness.
const YIELD_OF_BASE: f64 = 0.05;
/// Arm of a plate at a clamp that holds its whole section, relative to the plate's thickness: the arm at Poisson's ratio 0.4, and its slope in
/// Poisson's ratio. A clamp also prevents the change of thickness, which stiffens a plate the more the larger Poisson's ratio is.
const CLAMP: [f64; 2] = [0.021, 0.29];
/// Share of the arms that remains if ribs share junctions. Such ribs carry loads along their length; a junction stiffens this less than bending.
const SHARE_IN_ZIGZAG: f64 = 0.62;
/// Angle between rib and plate, rad, below which the model error is that of [`OBLIQUE_ERROR`]: 35 degrees.
const OBLIQUE: f64 = 0.611;
/// Relative standard deviations of a sensed force, chosen from the errors on solids that the other constants were not fitted to: 93 to 97 % of these
/// forces err by at most 1.96 of the deviation of their kind. Fingers with sharp corners at the base, and with fillets there.
const STEEP_ERRORS: [f64; 2] = [0.0065, 0.011];
/// Same, with ribs at less than [`OBLIQUE`] from a plate.
const OBLIQUE_ERROR: f64 = 0.02;
/// Same, with ribs that share junctions.
const ZIGZAG_ERROR: f64 = 0.03;
/// Largest angle between two members that form a corner, rad. Beyond, as between the two sides of a plate, the outer faces are in line.
const LARGEST_CORNER: f64 = 3.05;
/// Positive half of the points, and weights, of Gauss's quadrature with six points on -1 to 1.
const QUADRATURE: [[f64; 2]; 3] = [
    [0.238_619_186_083_196_9, 0.467_913_934_572_691],
    [0.661_209_386_466_264_5, 0.360_761_573_048_138_6],
    [0.932_469_514_203_152, 0.171_324_492_379_170_36],
];

/// Arms of all members, mm.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Arms {
    /// Arms at both ends of each member of the front and of the back plate, from base to tip.
    pub plates: [Vec<[f64; 2]>; 2],
    /// Arms at the front and the back end of each rib.
    pub ribs: Vec<[f64; 2]>,
    /// Relative standard deviation of a sensed force due to the errors of beam theory, dimensionless.
    pub model_error: f64,
}

/// The corner between a face of a member and the next member, with its fillet.
#[derive(Debug, Clone, Copy)]
struct Corner {
    /// Distance of the corner from the node, along the member, mm.
    distance_mm: f64,
    /// Angle between the members, rad.
    angle: f64,
    radius_mm: f64,
}

impl Corner {
    /// Distance from the node at which the fillet ends, mm.
    fn end_mm(&self) -> f64 {
        self.distance_mm + self.radius_mm / (0.5 * self.angle).tan()
    }

    /// Steepest slope of the carrying section: that of the force flow, or of the next member's face if this face is flatter.
    fn slope(&self, flow: f64) -> f64 {
        if self.angle > FRAC_PI_2 { flow.min(-self.angle.tan()) } else { flow }
    }

    /// Height, from the fillet's end, up to which the fillet is flatter than `slope`: the distance along the member and the height itself, mm.
    fn flat_mm(&self, slope: f64) -> [f64; 2] {
        let hypotenuse = slope.hypot(1.0);
        [self.radius_mm * slope / hypotenuse, self.radius_mm * (1.0 - hypotenuse.recip())]
    }

    /// Height of the carrying section over the member's face at the distance `x_mm` from the node, mm.
    fn height_mm(&self, flow: f64, x_mm: f64) -> f64 {
        let slope = self.slope(flow);
        let [flat_mm, at_flat_mm] = self.flat_mm(slope);
        let within_mm = (self.end_mm() - x_mm).max(0.0);
        if within_mm < flat_mm {
            within_mm * within_mm / (self.radius_mm + (self.radius_mm.powi(2) - within_mm.powi(2)).sqrt())
        } else {
            at_flat_mm + slope * (within_mm - flat_mm)
        }
    }
}

/// Length of a member of thickness `t_mm` that bending loses at one end, mm: the integral of 1 - (t / w)^3.
fn stiff_length_mm(t_mm: f64, corners: &[Corner], flow: f64) -> f64 {
    let end_mm = corners.iter().map(Corner::end_mm).fold(0.0, f64::max);
    // The width has kinks where a fillet ends and where force flow leaves it.
    let kinks = corners.iter().flat_map(|c| [c.end_mm(), c.end_mm() - c.flat_mm(c.slope(flow))[0]]);
    let mut cuts_mm: Vec<f64> = kinks.map(|x_mm| x_mm.clamp(0.0, end_mm)).chain([0.0, end_mm]).collect();
    cuts_mm.sort_by(f64::total_cmp);
    let lost = |x_mm: f64| {
        let width_mm = t_mm + corners.iter().map(|c| c.height_mm(flow, x_mm)).sum::<f64>();
        1.0 - (t_mm / width_mm).powi(3)
    };
    let panel = |cuts_mm: &[f64]| {
        let [middle_mm, half_mm] = [0.5 * (cuts_mm[0] + cuts_mm[1]), 0.5 * (cuts_mm[1] - cuts_mm[0])];
        let pair = |[at, weight]: [f64; 2]| weight * (lost(middle_mm - at * half_mm) + lost(middle_mm + at * half_mm));
        half_mm * QUADRATURE.into_iter().map(pair).sum::<f64>()
    };
    cuts_mm.windows(2).map(panel).sum()
}

/// A plate member or a rib. The first end of a plate member is nearer to the base, that of a rib on the front plate.
struct Piece {
    plate: Option<Plate>,
    nodes: [NodeId; 2],
    length_mm: f64,
    /// Thickness at both ends, mm.
    thickness_mm: [f64; 2],
    /// Corners at both ends: counter-clockwise and clockwise of the direction from the end into the member.
    corners: [[Option<Corner>; 2]; 2],
}

fn pieces(finger: &Finger) -> Vec<Piece> {
    let piece = |plate, nodes: [NodeId; 2], thickness_mm| {
        let length_mm = (finger.position(nodes[1]) - finger.position(nodes[0])).norm();
        Piece { plate, nodes, length_mm, thickness_mm, corners: Default::default() }
    };
    let mut pieces = Vec::new();
    for plate in [Plate::Front, Plate::Back] {
        let (nodes, at_mm) = (finger.plate_nodes(plate), finger.plate_positions_mm(plate));
        let thickness_mm = |level: usize| finger.thickness_mm(plate, at_mm[level]);
        pieces.extend((0..=finger.rib_count()).map(|member| {
            let levels = [member, member + 1];
            piece(Some(plate), levels.map(|level| nodes[level]), levels.map(thickness_mm))
        }));
    }
    pieces.extend(
        (0..finger.rib_count()).map(|rib| piece(None, finger.rib_nodes(rib), [finger.rib_thickness_mm(rib); 2])),
    );
    pieces
}

/// Plate of a node; the tip belongs to the front plate.
fn plate_of(finger: &Finger, node: NodeId) -> Plate {
    if node < finger.tip() { Plate::Back } else { Plate::Front }
}

/// Finds the corners at all nodes but the tip. The corner at the tip hardly affects a finger: no load acts between the last rib and the tip.
fn find_corners(finger: &Finger, fillets: Fillets, pieces: &mut [Piece]) {
    let mut around: Vec<Vec<(f64, usize, usize)>> = vec![Vec::new(); finger.key_node_count() + 1];
    for (index, piece) in pieces.iter().enumerate().filter(|(_, piece)| piece.length_mm > 0.0) {
        for end in [0, 1] {
            let into = finger.position(piece.nodes[1 - end]) - finger.position(piece.nodes[end]);
            around[finger.junction(piece.nodes[end]).0].push((into.y.atan2(into.x), index, end));
        }
    }
    around[finger.tip().0].clear();
    for (node, members) in around.iter_mut().enumerate() {
        members.sort_by(|a, b| a.0.total_cmp(&b.0));
        let radius_mm = fillets.plates_mm[plate_of(finger, NodeId(node)).index()];
        for (i, &(direction, index, end)) in members.iter().enumerate() {
            let neighbours = [members[(i + 1) % members.len()], members[(i + members.len() - 1) % members.len()]];
            for (side, (other, other_index, other_end)) in neighbours.into_iter().enumerate() {
                let turn = if side == 0 { other - direction } else { direction - other };
                let angle = turn.rem_euclid(TAU);
                if angle > 0.0 && angle < LARGEST_CORNER {
                    let halves_mm = [&pieces[index], &pieces[other_index]];
                    let [own_mm, other_mm] = [halves_mm[0].thickness_mm[end], halves_mm[1].thickness_mm[other_end]];
                    let distance_mm = 0.5 * (other_mm + own_mm * angle.cos()) / angle.sin();
                    pieces[index].corners[end][side] = Some(Corner { distance_mm, angle, radius_mm });
                }
            }
        }
    }
}

impl Piece {
    /// Angles between a plate and the base line, counter-clockwise and clockwise of the plate, rad.
    fn angles_at_base(&self, finger: &Finger) -> [f64; 2] {
        let into = finger.position(self.nodes[1]) - finger.position(self.nodes[0]);
        let direction = into.y.atan2(into.x);
        [FRAC_PI_2 - direction, FRAC_PI_2 + direction]
    }

    /// Adds the corners between a plate and the base, unless a rib lies between them.
    fn add_corners_of_base(&mut self, finger: &Finger, radius_mm: f64) {
        for (side, angle) in self.angles_at_base(finger).into_iter().enumerate() {
            let distance_mm = 0.5 * self.thickness_mm[0] / angle.tan();
            self.corners[0][side].get_or_insert(Corner { distance_mm, angle, radius_mm });
        }
    }

    fn arm_mm(&self, finger: &Finger, base_fillet_mm: f64, end: usize) -> f64 {
        let (node, t_mm) = (self.nodes[end], self.thickness_mm[end]);
        let mut corners: Vec<Corner> = self.corners[end].iter().flatten().copied().collect();
        match self.plate {
            None => {
                // The slanted end of a rib starts, on average, where its middle line does.
                let mean_mm = corners.iter().map(|c| c.distance_mm).sum::<f64>() / corners.len().max(1) as f64;
                corners.iter_mut().for_each(|corner| corner.distance_mm = mean_mm);
                let plate_mm = finger.thickness_mm(plate_of(finger, node), finger.plate_position(node).s_mm);
                (stiff_length_mm(t_mm, &corners, RIB_SLOPE) - YIELD_OF_PLATE * plate_mm).max(0.0)
            }
            Some(_) if finger.is_clamped(node) => {
                // As for a rib, the slanted end starts, on average, at the node.
                let at_base = |angle| Corner { distance_mm: 0.0, angle, radius_mm: base_fillet_mm };
                let filled_mm = stiff_length_mm(t_mm, &self.angles_at_base(finger).map(at_base), RIB_SLOPE);
                let clamped = CLAMP[0] + CLAMP[1] * (finger.description().poissons_ratio - 0.4);
                (filled_mm - YIELD_OF_BASE * t_mm).max(clamped * t_mm).max(0.0)
            }
            Some(_) => stiff_length_mm(t_mm, &corners, PLATE_SLOPE),
        }
    }

    /// Length that corners and fillets take on the face where they take most, mm.
    fn taken_mm(&self) -> f64 {
        let end_mm = |end: usize, side: usize| self.corners[end][side].map_or(0.0, |corner| corner.end_mm().max(0.0));
        [0, 1].map(|side| end_mm(0, side) + end_mm(1, 1 - side)).into_iter().fold(0.0, f64::max)
    }
}

/// Arms of a finger whose plates and ribs are one piece.
///
/// # Errors
/// [`ImpossibleFinger`] if corners and fillets leave no free length of a plate between two ribs, or of a rib.
pub(super) fn arms(finger: &Finger, fillets: Fillets) -> Result<Arms, ImpossibleFinger> {
    let mut pieces = pieces(finger);
    find_corners(finger, fillets, &mut pieces);
    let in_zigzag = finger.has_shared_junctions();
    let share = if in_zigzag { SHARE_IN_ZIGZAG } else { 1.0 };
    let corners = pieces.iter().flat_map(|piece| piece.corners.iter().flatten().flatten());
    let sharpest = corners.map(|corner| corner.angle).fold(PI, f64::min);
    let model_error = match (in_zigzag, sharpest < OBLIQUE) {
        (true, _) => ZIGZAG_ERROR,
        (_, true) => OBLIQUE_ERROR,
        _ => STEEP_ERRORS[usize::from(fillets.base_mm > 0.0)],
    };
    for piece in pieces.iter_mut().filter(|piece| piece.plate.is_some() && finger.is_clamped(piece.nodes[0])) {
        piece.add_corners_of_base(finger, fillets.base_mm);
    }
    let mut arms = Arms { model_error, ..Arms::default() };
    for piece in &pieces {
        let arms_mm = if piece.length_mm > 0.0 {
            [0, 1].map(|end| share * piece.arm_mm(finger, fillets.base_mm, end))
        } else {
            [0.0; 2]
        };
        // Fillets may meet on the face of a short rib, as they fill the last cell before the tip. The arms still leave a free length.
        let of_plate_mm = if piece.plate.is_some() { piece.taken_mm() } else { 0.0 };
        let taken_mm = of_plate_mm.max(arms_mm[0] + arms_mm[1]);
        require(piece.length_mm == 0.0 || taken_mm < piece.length_mm, &FINGER.fillet_mm.path(), || {
            let ([from, to], Fillets { plates_mm: [front_mm, back_mm], base_mm }) = (piece.nodes, fillets);
            let (name, length_mm) = (if piece.plate.is_some() { "plate" } else { "rib" }, piece.length_mm);
            format!(
                "expected smaller fillets: corners and fillets (front plate, back plate, base: {front_mm:?}, {back_mm:?}, {base_mm:?} mm) take {taken_mm:.3} mm of the {name} between nodes {from} and {to}, which is {length_mm:.3} mm long"
            )
        })?;
        match piece.plate {
            Some(plate) => arms.plates[plate.index()].push(arms_mm),
            None => arms.ribs.push(arms_mm),
        }
    }
    Ok(arms)
}

impl Finger {
    /// Relative standard deviation of a sensed force due to the errors of beam theory, for a finger with stated fillets; dimensionless. It follows
    /// from the errors on solids of the same kind that the rule for the arms was not fitted to (`fixtures/solids`). Zero without stated fillets.
    pub fn one_piece_model_error(&self) -> f64 {
        self.arms.as_ref().map_or(0.0, |arms| arms.model_error)
    }
}
