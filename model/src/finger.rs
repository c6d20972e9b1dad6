//! A fin-ray finger: two plates in a V and ribs across it, as geometry with material.

use crate::Vector;
use crate::frame::Section;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Number of a key node, counted as in the paper from 1 at the back base over the tip to the front base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NodeId(pub usize);

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A plate or a rib as a material strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// Thickness in the plane, mm.
    pub thickness_mm: f64,
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
}

/// How ribs meet the plates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joints {
    /// Clamped to both plates.
    Rigid,
    /// Pinned at both ends.
    Hinged,
}

/// Where the ribs are.
#[derive(Debug, Clone, PartialEq)]
pub enum RibPositions {
    /// This number of ribs, rib i at i / (count + 1) of both plates.
    Count(usize),
    /// Distances from the base along the front and the back plate, mm, from base to tip.
    Positions(Vec<[f64; 2]>),
}

/// The ribs as the user describes them.
#[derive(Debug, Clone, PartialEq)]
pub struct RibDescription {
    /// Their positions.
    pub positions: RibPositions,
    /// Their joints with the plates.
    pub joints: Joints,
    /// Their material; `None` for ribs that do not deform (or if there are none).
    pub strip: Option<Strip>,
}

/// Which part of the finger a zone belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The front plate.
    Front,
    /// The back plate.
    Back,
    /// The ribs whose front end lies in the zone.
    Ribs,
}

/// A section of other modulus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zone {
    /// The part it belongs to.
    pub part: Part,
    /// Where it begins, mm from the base along the plate (for ribs: the front plate).
    pub from_mm: f64,
    /// Where it ends, mm.
    pub to_mm: f64,
    /// Factor on Young's modulus.
    pub modulus_factor: f64,
}

/// A finger as the user describes it; [`Finger::new`] checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerDescription {
    /// Distance between the two plates at the base, mm.
    pub base_width_mm: f64,
    /// Length of the front plate, mm.
    pub front_length_mm: f64,
    /// Length of the back plate, mm.
    pub back_length_mm: f64,
    /// Out of plane, mm.
    pub depth_mm: f64,
    /// Length of the rigid arms at both ends of every member, mm.
    pub rod_arm_mm: f64,
    /// Poisson's ratio of the strips, wide against their thickness: they have the modulus E / (1 - nu^2).
    pub poissons_ratio: f64,
    /// The front plate.
    pub front: Strip,
    /// The back plate.
    pub back: Strip,
    /// The ribs.
    pub ribs: RibDescription,
    /// Sections of other modulus; overlapping ones multiply.
    pub zones: Vec<Zone>,
}

/// A finger that cannot be: which key of the scene is wrong, and why.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key}: {reason}")]
pub struct ImpossibleFinger {
    /// Key as in the scene file, for instance `finger.ribs.positions_mm`.
    pub key: String,
    /// What was expected and what was found.
    pub reason: String,
}

/// A finger that can be built, with its key nodes in place.
#[derive(Debug, Clone, PartialEq)]
pub struct Finger {
    description: FingerDescription,
    tip: Vector,
    /// Rib ends along the front and the back plate, mm from the base.
    ribs: Vec<[f64; 2]>,
}

/// Neighbouring nodes and the plates' ends must be this share of a plate apart.
const SMALLEST_SPACING: f64 = 1e-9;
/// Most ribs that a finger may have.
const MAX_RIBS: usize = 1000;

impl Finger {
    /// Checks a description and places the key nodes.
    ///
    /// # Errors
    /// [`ImpossibleFinger`] with the offending key: sizes that are not positive finite numbers, lengths that make no
    /// triangle, ribs that cross, touch or lie off the plates, arms longer than the members, zones off the plates.
    pub fn new(description: FingerDescription) -> Result<Finger, ImpossibleFinger> {
        let d = &description;
        require_positive("finger.base_width_mm", d.base_width_mm, "length in mm")?;
        require_positive("finger.front_length_mm", d.front_length_mm, "length in mm")?;
        require_positive("finger.back_length_mm", d.back_length_mm, "length in mm")?;
        require_positive("finger.depth_mm", d.depth_mm, "length in mm")?;
        require(d.rod_arm_mm.is_finite() && d.rod_arm_mm >= 0.0, "finger.rod_arm_mm", || {
            format!("expected a length in mm, zero or more, found {:?}", d.rod_arm_mm)
        })?;
        require(d.poissons_ratio > -1.0 && d.poissons_ratio <= 0.5, "finger.poissons_ratio", || {
            format!("expected a ratio above -1 and up to 0.5, found {:?}", d.poissons_ratio)
        })?;
        check_strip("finger.front", &d.front)?;
        check_strip("finger.back", &d.back)?;
        if let Some(strip) = &d.ribs.strip {
            check_strip("finger.ribs", strip)?;
        }
        let tip = place_tip(d)?;
        let ribs = place_ribs(d)?;
        check_zones(d)?;
        let finger = Finger { tip, ribs, description };
        finger.check_arms()?;
        Ok(finger)
    }

    /// The description that this finger was made from.
    pub fn description(&self) -> &FingerDescription {
        &self.description
    }

    /// Number of ribs.
    pub fn rib_count(&self) -> usize {
        self.ribs.len()
    }

    /// Number of key nodes: 2 r + 3.
    pub fn key_node_count(&self) -> usize {
        2 * self.ribs.len() + 3
    }

    /// The tip, where the plates meet.
    pub fn tip(&self) -> NodeId {
        NodeId(self.ribs.len() + 2)
    }

    /// The two clamped nodes: back base and front base.
    pub fn clamped_nodes(&self) -> [NodeId; 2] {
        [NodeId(1), NodeId(self.key_node_count())]
    }

    /// The nodes that can touch an object: from the tip to the last one before the front base.
    pub fn contact_nodes(&self) -> impl DoubleEndedIterator<Item = NodeId> + ExactSizeIterator + Clone + use<> {
        (self.tip().0..self.key_node_count()).map(NodeId)
    }

    /// The nodes that move, in order: those a camera measures.
    pub fn free_nodes(&self) -> impl DoubleEndedIterator<Item = NodeId> + ExactSizeIterator + Clone + use<> {
        (2..self.key_node_count()).map(NodeId)
    }

    /// Front and back node of rib `index`, counted from the base from 0.
    pub fn rib_nodes(&self, index: usize) -> [NodeId; 2] {
        [NodeId(self.key_node_count() - 1 - index), NodeId(index + 2)]
    }

    /// The key nodes of a plate from its base to the tip.
    pub fn plate_nodes(&self, part: Plate) -> Vec<NodeId> {
        match part {
            Plate::Back => (1..=self.tip().0).map(NodeId).collect(),
            Plate::Front => (self.tip().0..=self.key_node_count()).rev().map(NodeId).collect(),
        }
    }

    /// Positions of the [`plate_nodes`](Finger::plate_nodes), mm along the plate from the base.
    pub fn plate_positions_mm(&self, part: Plate) -> Vec<f64> {
        let column = usize::from(part == Plate::Back);
        std::iter::once(0.0)
            .chain(self.ribs.iter().map(|rib| rib[column]))
            .chain(std::iter::once(self.plate_length_mm(part)))
            .collect()
    }

    /// Length of a plate, mm.
    pub fn plate_length_mm(&self, part: Plate) -> f64 {
        match part {
            Plate::Front => self.description.front_length_mm,
            Plate::Back => self.description.back_length_mm,
        }
    }

    /// Clamped end of a plate, mm.
    pub fn base(&self, part: Plate) -> Vector {
        let half = 0.5 * self.description.base_width_mm;
        match part {
            Plate::Front => Vector::new(0.0, half),
            Plate::Back => Vector::new(0.0, -half),
        }
    }

    /// A point of a plate, mm, at a distance from its base.
    pub fn plate_point(&self, part: Plate, s_mm: f64) -> Vector {
        let base = self.base(part);
        base + (self.tip - base) * (s_mm / self.plate_length_mm(part))
    }

    /// Position of a key node, mm.
    pub fn position(&self, node: NodeId) -> Vector {
        let count = self.ribs.len();
        let last = self.key_node_count();
        match node.0 {
            n if n == count + 2 => self.tip,
            1 => self.base(Plate::Back),
            n if n == last => self.base(Plate::Front),
            n if n < count + 2 => self.plate_point(Plate::Back, self.ribs[n - 2][1]),
            n => self.plate_point(Plate::Front, self.ribs[last - 1 - n][0]),
        }
    }

    /// Position of a node of the front plate, mm from the front base; `None` for other nodes.
    pub fn front_position_mm(&self, node: NodeId) -> Option<f64> {
        let from_base = self.key_node_count().checked_sub(node.0)?;
        self.plate_positions_mm(Plate::Front).get(from_base).copied()
    }

    /// Unit vector along the front plate towards the tip.
    pub fn front_tangent(&self) -> Vector {
        (self.tip - self.base(Plate::Front)).normalize()
    }

    /// Unit vector at an angle, in degrees, from the front plate's undeformed inward normal, positive towards the tip.
    pub fn direction(&self, angle_deg: f64) -> Vector {
        let tangent = self.front_tangent();
        let inward = Vector::new(tangent.y, -tangent.x);
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        inward * cos + tangent * sin
    }

    /// Section of a part without zones: plane-strain modulus E / (1 - nu^2); `None` for ribs that do not deform.
    pub fn section(&self, part: Part) -> Option<Section> {
        let d = &self.description;
        let strip = match part {
            Part::Front => Some(d.front),
            Part::Back => Some(d.back),
            Part::Ribs => d.ribs.strip,
        }?;
        let modulus = strip.youngs_modulus_mpa / (1.0 - d.poissons_ratio * d.poissons_ratio);
        Some(Section::rectangle(strip.thickness_mm, d.depth_mm, modulus))
    }

    /// The same finger with all moduli multiplied by a factor.
    ///
    /// # Errors
    /// [`ImpossibleFinger`] if a modulus is no longer a positive number.
    pub fn with_modulus_factor(&self, factor: f64) -> Result<Finger, ImpossibleFinger> {
        let mut description = self.description.clone();
        description.front.youngs_modulus_mpa *= factor;
        description.back.youngs_modulus_mpa *= factor;
        if let Some(strip) = &mut description.ribs.strip {
            strip.youngs_modulus_mpa *= factor;
        }
        Finger::new(description)
    }

    fn check_arms(&self) -> Result<(), ImpossibleFinger> {
        let arm = self.description.rod_arm_mm;
        let plates = [Plate::Front, Plate::Back]
            .into_iter()
            .flat_map(|plate| self.plate_positions_mm(plate).windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>());
        let ribs = (0..self.rib_count()).map(|rib| {
            let [front, back] = self.rib_nodes(rib).map(|node| self.position(node));
            (front - back).norm()
        });
        let shortest = plates.chain(ribs).fold(f64::INFINITY, f64::min);
        require(2.0 * arm < shortest * (1.0 - SMALLEST_SPACING), "finger.rod_arm_mm", || {
            format!("expected less than half of the shortest member, {shortest:?} mm, found {arm:?}")
        })
    }
}

/// One of the two side plates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Plate {
    /// The contact side, +y.
    Front,
    /// The other side, -y.
    Back,
}

impl From<Plate> for Part {
    fn from(plate: Plate) -> Part {
        match plate {
            Plate::Front => Part::Front,
            Plate::Back => Part::Back,
        }
    }
}

fn require(holds: bool, key: &str, reason: impl FnOnce() -> String) -> Result<(), ImpossibleFinger> {
    if holds { Ok(()) } else { Err(ImpossibleFinger { key: key.to_owned(), reason: reason() }) }
}

/// Denormal numbers count as zero: nothing can be computed with them in double precision. Messages write numbers with
/// `{:?}`, which gives such ones a power of ten.
fn require_positive(key: &str, value: f64, unit: &str) -> Result<(), ImpossibleFinger> {
    require(value.is_normal() && value > 0.0, key, || format!("expected a positive {unit}, found {value:?}"))
}

fn check_strip(key: &str, strip: &Strip) -> Result<(), ImpossibleFinger> {
    require_positive(&format!("{key}.thickness_mm"), strip.thickness_mm, "length in mm")?;
    require_positive(&format!("{key}.youngs_modulus_mpa"), strip.youngs_modulus_mpa, "modulus in MPa")
}

/// The tip from the three sides of the triangle; its height by Kahan's form of Heron's formula, which keeps its digits
/// for needle-thin and very obtuse triangles.
fn place_tip(d: &FingerDescription) -> Result<Vector, ImpossibleFinger> {
    let mut sides = [
        (d.base_width_mm, "finger.base_width_mm"),
        (d.front_length_mm, "finger.front_length_mm"),
        (d.back_length_mm, "finger.back_length_mm"),
    ];
    sides.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [(a, longest), (b, _), (c, _)] = sides;
    require(c - (a - b) > a * SMALLEST_SPACING, longest, || {
        format!(
            "expected less than {:?} mm, the other two sides together: base width {:?}, front plate {:?} and back plate \
             {:?} make no triangle",
            b + c,
            d.base_width_mm,
            d.front_length_mm,
            d.back_length_mm
        )
    })?;
    let area = 0.25 * ((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))).sqrt();
    let (front, back) = (d.front_length_mm, d.back_length_mm);
    let tip = Vector::new(2.0 * area / d.base_width_mm, (back - front) * (back + front) / (2.0 * d.base_width_mm));
    require(tip.iter().all(|x| x.is_finite()), longest, || "expected lengths of a finger in mm".to_owned())?;
    Ok(tip)
}

fn place_ribs(d: &FingerDescription) -> Result<Vec<[f64; 2]>, ImpossibleFinger> {
    let (ribs, key) = match &d.ribs.positions {
        RibPositions::Count(count) => {
            require(*count <= MAX_RIBS, "finger.ribs.count", || {
                format!("expected 0 to {MAX_RIBS} ribs, found {count}")
            })?;
            let spaced = |length: f64, i: usize| length * i as f64 / (*count + 1) as f64;
            let ribs =
                (1..=*count).map(|i| [spaced(d.front_length_mm, i), spaced(d.back_length_mm, i)]).collect::<Vec<_>>();
            (ribs, "finger.ribs.count")
        }
        RibPositions::Positions(positions) => {
            require(positions.len() <= MAX_RIBS, "finger.ribs.positions_mm", || {
                format!("expected at most {MAX_RIBS} ribs, found {}", positions.len())
            })?;
            (positions.clone(), "finger.ribs.positions_mm")
        }
    };
    for (column, plate, length) in [(0, "front", d.front_length_mm), (1, "back", d.back_length_mm)] {
        let gap = length * SMALLEST_SPACING;
        let mut before = 0.0;
        for (i, rib) in ribs.iter().enumerate() {
            let position = rib[column];
            require(position.is_finite() && position > gap && position < length - gap, key, || {
                format!("expected rib {} on the {plate} plate, between 0 and {length:?} mm, found {position:?}", i + 1)
            })?;
            require(position > before + gap, key, || {
                format!(
                    "expected ribs from base to tip that neither cross nor touch: on the {plate} plate rib {} at \
                     {position:?} mm does not follow the rib before it at {before:?} mm",
                    i + 1
                )
            })?;
            before = position;
        }
    }
    Ok(ribs)
}

fn check_zones(d: &FingerDescription) -> Result<(), ImpossibleFinger> {
    for (i, zone) in d.zones.iter().enumerate() {
        let key = |name: &str| format!("finger.zone[{}].{name}", i + 1);
        let length = if zone.part == Part::Back { d.back_length_mm } else { d.front_length_mm };
        require(zone.from_mm >= 0.0 && zone.from_mm < length, &key("from_mm"), || {
            format!("expected a position on the plate, 0 to {length:?} mm, found {:?}", zone.from_mm)
        })?;
        require(zone.to_mm > zone.from_mm && zone.to_mm <= length, &key("to_mm"), || {
            format!(
                "expected a position after from_mm = {:?} and up to {length:?} mm, found {:?}",
                zone.from_mm, zone.to_mm
            )
        })?;
        require_positive(&key("modulus_factor"), zone.modulus_factor, "factor")?;
    }
    Ok(())
}
