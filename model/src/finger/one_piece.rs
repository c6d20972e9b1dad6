//! Rigid arms of a finger of one piece: plates, ribs and fillets stiffen each other's ends.
//!
//! A member carries its force in its own section. Where it meets another member or a fillet, the section that carries the force widens, at most at a
//! slope that depends on the kind of member. The arm is the length that bending loses by this: the integral of 1 - (t / w)^3 along the member, with
//! its thickness t and the width w that carries. Stretching loses less: the elastic part between the arms is softer in tension than its section, by
//! the ratio of both remaining lengths.
//!
//! A rib widens a plate on its inner face only. The middle of the section that carries then lies beside the middle of the plate, by e: an axial force
//! N bends the plate, by the integral of 12 N e / (E' w^3), and stretching loses the integral of 1 - t / w - 12 t e^2 / w^3. At the base, a plate ends
//! at a line that is not square to it. Fibres on one side are longer there, so that N bends the plate by N / (E t) times the tangent of the angle. The
//! elastic axis between the arms lies beside the middle of the plate by the distances that bend it by both amounts. `fixtures/solids` contains the
//! solids that determine the constants, single junctions that confirm the bending (`junction.py`), and fingers that judge them.

use super::placement::require;
use super::{Fillets, Finger, FingerKind, ImpossibleFinger, NodeId, Part, Plate};
use crate::keys::FINGER;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Slope at which the carrying section of a rib, or of a plate at the base, widens, dimensionless. Solids hardly depend on a slope from 2 to 10.
const RIB_SLOPE: f64 = 2.0;
/// Slope at which the carrying section of a plate widens, dimensionless: little, because ribs hold only one face of a plate.
const PLATE_SLOPE: f64 = 0.4;
/// Length that a rib loses less, because the plate yields under the end of the rib; relative to the plate's thickness.
const YIELD_OF_PLATE: f64 = 0.1;
/// Arm of a plate at a clamp that holds its whole section, relative to the plate's thickness: the arm at Poisson's ratio 0.4, and its slope in
/// Poisson's ratio. A clamp also prevents the change of thickness, which stiffens a plate the more the larger Poisson's ratio is.
const CLAMP: [f64; 2] = [0.021, 0.29];
/// What a clamp that is not square adds to this arm, relative to the thickness and to the square of the tangent of the angle.
const SLANTED_CLAMP: f64 = 0.26;
/// A finger is one of [`FingerKind::RibNearBase`] if a plate's first member is shorter than this, in thicknesses, or, with inclined ribs, if the part
/// of this member between its corners and fillets is shorter than `FREE_AT_BASE` thicknesses.
const NEAR_BASE: f64 = 3.0;
const FREE_AT_BASE: f64 = 2.0;
/// Largest angle between two members that form a corner, rad. Beyond, as between the two sides of a plate, the outer faces are in line.
const LARGEST_CORNER: f64 = 3.05;
/// Panels of the quadrature between two kinks of fillets.
const PANELS: usize = 4;
/// Positive half of the points, and weights, of Gauss's quadrature with six points on -1 to 1.
const QUADRATURE: [[f64; 2]; 3] = [
    [0.238_619_186_083_196_9, 0.467_913_934_572_691],
    [0.661_209_386_466_264_5, 0.360_761_573_048_138_6],
    [0.932_469_514_203_152, 0.171_324_492_379_170_36],
];

/// A finger whose plates and ribs are one piece.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OnePiece {
    /// Members of the front and of the back plate, from base to tip.
    plates: [Vec<OnePieceMember>; 2],
    /// The ribs.
    ribs: Vec<OnePieceMember>,
    pub(super) kind: FingerKind,
}

/// A plate's member or a rib between junctions of one piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OnePieceMember {
    /// Arms at both ends, mm: for a plate's member from the base, for a rib at the front and the back end.
    pub arms_mm: [f64; 2],
    /// Ratio of the axial rigidity between the arms to that of the section, dimensionless.
    pub stretching: f64,
    /// Distances of the elastic axis from the middle of a plate at the ends of both arms, mm; positive to the left of the direction to the tip.
    pub axis_mm: [f64; 2],
}

/// The corner between a face of a member and the next member, with its fillet.
#[derive(Debug, Clone, Copy)]
struct Corner {
    /// Distance of the corner from the node, along the member, mm.
    distance_mm: f64,
    /// Angle between the members, rad.
    angle: f64,
    radius_mm: f64,
    /// Height of the next member's outer face over this face at the node, mm. In an acute corner, the section cannot be wider.
    outer_mm: f64,
    /// Share of the material in the corner that carries for this member, dimensionless: half between two ribs and, if ribs share junctions,
    /// for a plate in an acute corner: there the moments of plate and rib turn the material in the same sense. Otherwise all.
    share: f64,
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
        let flow_mm = if within_mm < flat_mm {
            within_mm * within_mm / (self.radius_mm + (self.radius_mm.powi(2) - within_mm.powi(2)).sqrt())
        } else {
            at_flat_mm + slope * (within_mm - flat_mm)
        };
        let bounded_mm = if self.angle < FRAC_PI_2 {
            flow_mm.min((self.outer_mm + x_mm * self.angle.tan()).max(0.0))
        } else {
            flow_mm
        };
        self.share * bounded_mm
    }
}

/// An end of a member: its corners, and what determines the lengths that the member loses there.
#[derive(Debug, Clone, Default)]
struct End {
    corners: [Option<Corner>; 2],
    /// Slope at which the carrying section widens, dimensionless.
    flow: f64,
    /// Length that is lost less because the neighbour yields, mm.
    yield_mm: f64,
    /// Least loss in bending, mm.
    least_mm: f64,
    /// Length that a fibre gains per distance from the middle, counter-clockwise of the direction from the end into the member, dimensionless.
    slant: f64,
}

impl End {
    fn corners(&self) -> impl Iterator<Item = &Corner> {
        self.corners.iter().flatten()
    }

    /// Distance from the node at which the last fillet ends, mm.
    fn reach_mm(&self) -> f64 {
        self.corners().map(Corner::end_mm).fold(0.0, f64::max)
    }

    /// Heights of the carrying section over both faces: counter-clockwise and clockwise of the direction from the end into the member, mm.
    fn heights_mm(&self, x_mm: f64) -> [f64; 2] {
        self.corners.map(|corner| corner.map_or(0.0, |corner| corner.height_mm(self.flow, x_mm)))
    }

    /// Distances from the node at which the height has a kink, mm: where a fillet ends, and where force flow leaves it.
    fn kinks_mm(&self) -> impl Iterator<Item = f64> + '_ {
        self.corners().flat_map(|c| [c.end_mm(), c.end_mm() - c.flat_mm(c.slope(self.flow))[0]])
    }
}

/// What an end changes in the compliance of a member between its nodes.
#[derive(Debug, Clone, Copy)]
struct Losses {
    /// Lengths that bending and tension lose, mm.
    bending_mm: f64,
    tension_mm: f64,
    /// Rotation by an axial force N, relative to N / E' of a depth of 1, because the section that carries lies beside the middle, and because the end is not
    /// square, 1/mm; counter-clockwise of the direction into the member.
    eccentric: f64,
    slanted: f64,
}

/// Integral of a function of the heights of the carrying section over both faces, mm, from an end to the distance `to_mm` from its node. Fillets of the
/// `other` end, whose node is `length_mm` away, also widen the section.
fn integral(of: impl Fn([f64; 2]) -> f64, [end, other]: [&End; 2], to_mm: f64, length_mm: f64) -> f64 {
    let kinks = end.kinks_mm().chain(other.kinks_mm().map(|x_mm| length_mm - x_mm));
    let mut cuts_mm: Vec<f64> = kinks.map(|x_mm| x_mm.clamp(0.0, to_mm)).chain([0.0, to_mm]).collect();
    cuts_mm.sort_by(f64::total_cmp);
    let of = |x_mm: f64| {
        let ([left_mm, right_mm], [from_right_mm, from_left_mm]) =
            (end.heights_mm(x_mm), other.heights_mm(length_mm - x_mm));
        of([left_mm + from_left_mm, right_mm + from_right_mm])
    };
    let panel = |cuts_mm: &[f64]| {
        let [middle_mm, half_mm] = [0.5 * (cuts_mm[0] + cuts_mm[1]), 0.5 * (cuts_mm[1] - cuts_mm[0])];
        let pair = |[at, weight]: [f64; 2]| weight * (of(middle_mm - at * half_mm) + of(middle_mm + at * half_mm));
        half_mm * QUADRATURE.into_iter().map(pair).sum::<f64>()
    };
    // Outer faces add kinks within these panels.
    let parts = |cuts_mm: &[f64]| {
        let step_mm = (cuts_mm[1] - cuts_mm[0]) / PANELS as f64;
        let start_mm = cuts_mm[0];
        (0..PANELS).map(|i| panel(&[0.0, 1.0].map(|end| start_mm + step_mm * (i as f64 + end)))).sum::<f64>()
    };
    cuts_mm.windows(2).map(parts).sum()
}

/// A plate member or a rib. The first end of a plate member is nearer to the base, that of a rib on the front plate.
struct Piece {
    plate: Option<Plate>,
    nodes: [NodeId; 2],
    length_mm: f64,
    /// Thickness at both ends, mm.
    thickness_mm: [f64; 2],
    /// Radius of the fillets in the corners of a rib, mm; `None` for those of the plates.
    fillet_mm: Option<f64>,
    /// Corners at both ends: counter-clockwise and clockwise of the direction from the end into the member.
    corners: [[Option<Corner>; 2]; 2],
}

fn pieces(finger: &Finger) -> Vec<Piece> {
    let piece = |plate, nodes: [NodeId; 2], thickness_mm, fillet_mm| {
        let length_mm = (finger.position(nodes[1]) - finger.position(nodes[0])).norm();
        Piece { plate, nodes, length_mm, thickness_mm, fillet_mm, corners: Default::default() }
    };
    let mut pieces = Vec::new();
    for plate in [Plate::Front, Plate::Back] {
        let (nodes, at_mm) = (finger.plate_nodes(plate), finger.plate_positions_mm(plate));
        let thickness_mm = |level: usize| finger.thickness_mm(plate, at_mm[level]);
        pieces.extend((0..=finger.rib_count()).map(|member| {
            let levels = [member, member + 1];
            piece(Some(plate), levels.map(|level| nodes[level]), levels.map(thickness_mm), None)
        }));
    }
    let fillets_mm = finger.description().ribs.fillets_mm.as_ref();
    pieces.extend((0..finger.rib_count()).map(|rib| {
        let thickness_mm = [finger.rib_thickness_mm(rib); 2];
        piece(None, finger.rib_nodes(rib), thickness_mm, fillets_mm.map(|fillets_mm| fillets_mm.of(rib)))
    }));
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
    let is_truss = finger.has_shared_junctions();
    for (node, members) in around.iter_mut().enumerate() {
        members.sort_by(|a, b| a.0.total_cmp(&b.0));
        let of_plate_mm = fillets.plates_mm[plate_of(finger, NodeId(node)).index()];
        for (i, &(direction, index, end)) in members.iter().enumerate() {
            let neighbours = [members[(i + 1) % members.len()], members[(i + members.len() - 1) % members.len()]];
            for (side, (other, other_index, other_end)) in neighbours.into_iter().enumerate() {
                let turn = if side == 0 { other - direction } else { direction - other };
                let angle = turn.rem_euclid(TAU);
                if angle > 0.0 && angle < LARGEST_CORNER {
                    let both = [&pieces[index], &pieces[other_index]];
                    let [own_mm, other_mm] = [both[0].thickness_mm[end], both[1].thickness_mm[other_end]];
                    let distance_mm = 0.5 * (other_mm + own_mm * angle.cos()) / angle.sin();
                    // Between two ribs, the smaller fillet fits.
                    let radius_mm =
                        both.iter().filter_map(|piece| piece.fillet_mm).reduce(f64::min).unwrap_or(of_plate_mm);
                    let outer_mm = 0.5 * (other_mm / angle.cos() - own_mm);
                    let is_between_ribs = both.iter().all(|piece| piece.plate.is_none());
                    let is_plate_of_truss = is_truss && both[0].plate.is_some() && angle < FRAC_PI_2;
                    let share = if is_between_ribs || is_plate_of_truss { 0.5 } else { 1.0 };
                    pieces[index].corners[end][side] = Some(Corner { distance_mm, angle, radius_mm, outer_mm, share });
                }
            }
        }
    }
}

/// Lets fillets between the last rib and the plates merge: if the rib is so short that both fillets meet, a circle between the plates bounds the
/// material before the rib, as a fillet in the corner of the plates would.
fn merge_before_tip(finger: &Finger, pieces: &mut [Piece]) {
    let Some(before_last) = finger.rib_count().checked_sub(1) else { return };
    let angle = finger.tangent(Plate::Front).dot(&finger.tangent(Plate::Back)).clamp(-1.0, 1.0).acos();
    let members = finger.rib_count() + 1;
    let last_of = |plate: Plate| plate.index() * members + before_last + 1;
    let half_mm = [Plate::Front, Plate::Back].map(|plate| 0.5 * pieces[last_of(plate)].thickness_mm[0]);
    for plate in [Plate::Front, Plate::Back] {
        let (own_mm, other_mm) = (half_mm[plate.index()], half_mm[1 - plate.index()]);
        let distance_mm = (other_mm + own_mm * angle.cos()) / angle.sin() - pieces[last_of(plate)].length_mm;
        for corner in pieces[last_of(plate) - 1].corners[1].iter_mut().flatten() {
            let merged = Corner { distance_mm, angle, outer_mm: f64::INFINITY, ..*corner };
            if merged.end_mm() > corner.end_mm() {
                *corner = merged;
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
            let outer_mm = f64::INFINITY;
            self.corners[0][side].get_or_insert(Corner { distance_mm, angle, radius_mm, outer_mm, share: 1.0 });
        }
    }

    fn end(&self, finger: &Finger, base_fillet_mm: f64, end: usize) -> End {
        let (node, t_mm) = (self.nodes[end], self.thickness_mm[end]);
        let mut corners = self.corners[end];
        match self.plate {
            None => {
                // The slanted end of a rib starts, on average, where its middle line does.
                let both = corners.iter().flatten();
                let mean_mm = both.clone().map(|c| c.distance_mm).sum::<f64>() / both.count().max(1) as f64;
                corners.iter_mut().flatten().for_each(|corner| corner.distance_mm = mean_mm);
                let plate_mm = finger.thickness_mm(plate_of(finger, node), finger.plate_position(node).s_mm);
                End { corners, flow: RIB_SLOPE, yield_mm: YIELD_OF_PLATE * plate_mm, ..End::default() }
            }
            Some(_) if finger.is_clamped(node) => {
                // As for a rib, the slanted end starts, on average, at the node.
                let at_base = |angle| Corner {
                    distance_mm: 0.0,
                    angle,
                    radius_mm: base_fillet_mm,
                    outer_mm: f64::INFINITY,
                    share: 1.0,
                };
                let clamped = CLAMP[0] + CLAMP[1] * (finger.description().poissons_ratio - 0.4);
                let angles = self.angles_at_base(finger);
                let slant = -angles[0].tan().recip();
                End {
                    corners: angles.map(|angle| Some(at_base(angle))),
                    flow: RIB_SLOPE,
                    yield_mm: 0.0,
                    least_mm: (clamped.max(0.0) + SLANTED_CLAMP * slant * slant) * t_mm,
                    slant,
                }
            }
            Some(_) => End { corners, flow: PLATE_SLOPE, ..End::default() },
        }
    }

    /// Arms and softer part of this piece.
    fn member(&self, finger: &Finger, base_fillet_mm: f64) -> OnePieceMember {
        let length_mm = self.length_mm;
        if length_mm == 0.0 {
            return OnePieceMember { arms_mm: [0.0; 2], stretching: 1.0, axis_mm: [0.0; 2] };
        }
        let ends = [0, 1].map(|end| self.end(finger, base_fillet_mm, end));
        let reach_mm = ends.each_ref().map(End::reach_mm);
        // Fillets of both ends may meet, as on a short rib before the tip. Each end then loses length up to the middle of their overlap.
        let until_mm = if reach_mm[0] + reach_mm[1] > length_mm {
            let split_mm = (0.5 * (reach_mm[0] + length_mm - reach_mm[1])).clamp(0.0, length_mm);
            [split_mm, length_mm - split_mm]
        } else {
            reach_mm
        };
        let ends = [0, 1].map(|i: usize| {
            let losses = self.losses([&ends[i], &ends[1 - i]], i, until_mm[i]);
            (losses, losses.bending_mm.max(ends[i].least_mm).max(0.0))
        });
        let arms_mm = ends.map(|(_, arm_mm)| arm_mm);
        let free_mm = length_mm - arms_mm[0] - arms_mm[1];
        let compliance = (length_mm - ends[0].0.tension_mm - ends[1].0.tension_mm) / free_mm;
        if self.plate.is_none() {
            return OnePieceMember { arms_mm, stretching: compliance.recip(), axis_mm: [0.0; 2] };
        }
        let poissons_ratio = finger.description().poissons_ratio;
        let turned = ends.map(|(losses, _)| losses.eccentric - losses.slanted / (1.0 - poissons_ratio.powi(2)));
        // Distances, to the left, whose linear course bends the member as much under the moment at either end. At the second end, the direction into
        // the member is the opposite one.
        let section = |i: usize| self.thickness_mm[i].powi(3) / 12.0;
        let by_end = [turned[0] * section(0), -turned[1] * section(1)];
        let axis_mm = [0, 1].map(|i: usize| (4.0 * by_end[i] - 2.0 * by_end[1 - i]) / free_mm);
        // An axis beside the middle is itself softer in tension.
        let thickness_mm = 0.5 * (self.thickness_mm[0] + self.thickness_mm[1]);
        let mean_square_mm2 = (axis_mm[0].powi(2) + axis_mm[0] * axis_mm[1] + axis_mm[1].powi(2)) / 3.0;
        let stretching = (compliance - 12.0 * mean_square_mm2 / thickness_mm.powi(2)).recip();
        OnePieceMember { arms_mm, stretching, axis_mm }
    }

    /// What one end, with the index `i`, changes in the compliance of this piece up to the distance `until_mm` from its node.
    fn losses(&self, both: [&End; 2], i: usize, until_mm: f64) -> Losses {
        let (end, t_mm) = (both[0], self.thickness_mm[i]);
        let over = |of: &dyn Fn([f64; 2], f64) -> f64| {
            let of = |heights_mm: [f64; 2]| of(heights_mm, t_mm + heights_mm[0] + heights_mm[1]);
            integral(of, both, until_mm, self.length_mm)
        };
        // A rib reaches the plate on both faces; its ends are taken as square.
        let beside_mm = |[left_mm, right_mm]: [f64; 2]| {
            if self.plate.is_some() { 0.5 * (left_mm - right_mm) } else { 0.0 }
        };
        Losses {
            bending_mm: over(&|_, width_mm| 1.0 - (t_mm / width_mm).powi(3)) - end.yield_mm,
            tension_mm: over(&|heights_mm, width_mm| {
                1.0 - t_mm / width_mm - 12.0 * t_mm * beside_mm(heights_mm).powi(2) / width_mm.powi(3)
            }) - end.yield_mm,
            eccentric: over(&|heights_mm, width_mm| 12.0 * beside_mm(heights_mm) / width_mm.powi(3)),
            slanted: end.slant / (t_mm + end.heights_mm(0.0).iter().sum::<f64>()),
        }
    }

    /// Length that corners take on the face where they take most, mm, with all radii multiplied by a factor.
    fn taken_mm(&self, factor: f64) -> f64 {
        let end_mm = |end: usize, side: usize| {
            let scaled = self.corners[end][side].map(|c| Corner { radius_mm: factor * c.radius_mm, ..c });
            scaled.map_or(0.0, |corner| corner.end_mm().max(0.0))
        };
        [0, 1].map(|side| end_mm(0, side) + end_mm(1, 1 - side)).into_iter().fold(0.0, f64::max)
    }
}

/// Steps of the bisection for the largest fillets: as many as give six digits.
const BISECTIONS: usize = 20;

/// Checks that corners and fillets leave a free length of each plate between two ribs. Fillets may meet in the last cell and on ribs.
fn check_room(finger: &Finger, fillets: Fillets, pieces: &[Piece]) -> Result<(), ImpossibleFinger> {
    let between_ribs =
        |piece: &&Piece| piece.plate.is_some() && piece.length_mm > 0.0 && piece.nodes[1] != finger.tip();
    let has_room = |factor: f64| move |piece: &&Piece| piece.taken_mm(factor) < piece.length_mm;
    let Some(crowded) = pieces.iter().filter(between_ribs).find(|piece| !has_room(1.0)(piece)) else { return Ok(()) };
    let all_have_room = |factor: f64| pieces.iter().filter(between_ribs).all(|piece| has_room(factor)(&piece));
    let mut fits = [0.0, 1.0];
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (fits[0] + fits[1]);
        fits[usize::from(!all_have_room(middle))] = middle;
    }
    let Fillets { plates_mm, base_mm } = fillets;
    let radii_mm = || pieces.iter().filter_map(|piece| piece.fillet_mm).chain(plates_mm).chain([base_mm]);
    let largest_mm = radii_mm().fold(0.0, f64::max);
    // Rounded down, so that the stated radius fits.
    let fitting_mm = (fits[0] * largest_mm * 1e3).floor() / 1e3;
    let expected = match radii_mm().all(|radius_mm| radius_mm == largest_mm) {
        _ if fitting_mm <= 0.0 => "no fillets: corners alone leave no room".to_owned(),
        true => format!("at most {fitting_mm:?} mm, found {largest_mm:?}"),
        false => format!(
            "smaller fillets, the largest at most {fitting_mm:?} mm instead of {largest_mm:?} and others in proportion"
        ),
    };
    let ([from, to], length_mm, taken_mm) = (crowded.nodes, crowded.length_mm, crowded.taken_mm(1.0));
    require(false, &FINGER.fillet_mm.path(), || {
        format!(
            "expected {expected}: corners and fillets take {taken_mm:.3} mm of the plate between nodes {from} and {to}, which is {length_mm:.3} mm long"
        )
    })
}

impl OnePiece {
    /// Members of a finger whose plates and ribs are one piece.
    ///
    /// # Errors
    /// [`ImpossibleFinger`] if corners and fillets leave no free length of a plate between two ribs.
    pub(super) fn new(finger: &Finger, fillets: Fillets) -> Result<OnePiece, ImpossibleFinger> {
        let mut pieces = pieces(finger);
        find_corners(finger, fillets, &mut pieces);
        let corners = || pieces.iter().flat_map(|piece| piece.corners.iter().flatten().flatten());
        let largest_mm = corners().map(|corner| corner.radius_mm).fold(0.0, f64::max);
        let fillets_meet =
            |piece: &Piece| largest_mm > 0.0 && piece.plate.is_none() && piece.taken_mm(1.0) >= piece.length_mm;
        for piece in pieces.iter_mut().filter(|piece| piece.plate.is_some() && finger.is_clamped(piece.nodes[0])) {
            piece.add_corners_of_base(finger, fillets.base_mm);
        }
        let has_single_inclined_ribs = finger.has_inclined_ribs() && !finger.has_shared_junctions();
        let is_near_base = |piece: &Piece| {
            let from_base = piece.plate.is_some() && piece.length_mm > 0.0 && finger.is_clamped(piece.nodes[0]);
            let is_shorter = |length_mm: f64, thicknesses: f64| length_mm < thicknesses * piece.thickness_mm[0];
            let free_mm = piece.length_mm - piece.taken_mm(1.0);
            let is_hardly_free = has_single_inclined_ribs && is_shorter(free_mm, FREE_AT_BASE);
            from_base && (is_shorter(piece.length_mm, NEAR_BASE) || is_hardly_free)
        };
        let kind = match (finger.has_shared_junctions(), finger.has_inclined_ribs()) {
            _ if pieces.iter().any(is_near_base) => FingerKind::RibNearBase,
            (true, _) if largest_mm > 0.0 => FingerKind::FilletedZigzag,
            (true, _) => FingerKind::ZigzagRibs,
            (_, true) => FingerKind::InclinedRibs,
            _ if pieces.iter().any(fillets_meet) => FingerKind::MeetingFillets,
            _ if fillets.base_mm > 0.0 => FingerKind::FilletedBase,
            _ => FingerKind::OnePiece,
        };
        check_room(finger, fillets, &pieces)?;
        merge_before_tip(finger, &mut pieces);
        let members = |plate| {
            let of_plate = pieces.iter().filter(move |piece| piece.plate == plate);
            of_plate.map(|piece| piece.member(finger, fillets.base_mm)).collect()
        };
        Ok(OnePiece { plates: [members(Some(Plate::Front)), members(Some(Plate::Back))], ribs: members(None), kind })
    }
}

impl Finger {
    /// A plate's member, numbered from 0 at the base, or a rib, by the rule for a finger of one piece; `None` without stated fillets.
    pub(super) fn one_piece_member(&self, part: Part, member: usize) -> Option<OnePieceMember> {
        let one_piece = self.one_piece.as_ref()?;
        Some(match part {
            Part::Front => one_piece.plates[0][member],
            Part::Back => one_piece.plates[1][member],
            Part::Ribs => one_piece.ribs[member],
        })
    }
}
