//! Springs that replace a short beam segment between two rigid bodies.

use finray_model::Vector;
use finray_model::frame::Section;

/// Index of a body in [`Assembly::bodies`](crate::bodies::Assembly::bodies), from 0.
pub type BodyIndex = usize;

/// A point fixed to a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor {
    /// Body that carries the point.
    pub body: BodyIndex,
    /// Vector from the body's centre to the point, undeformed, mm.
    pub arm: Vector,
}

impl Anchor {
    /// The point on the same body, shifted by `by` (mm, in the undeformed finger frame).
    pub fn moved(self, by: Vector) -> Anchor {
        Anchor { arm: self.arm + by, ..self }
    }
}

/// Kind of deformation that a spring resists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deformation {
    /// Change of the distance between the spring's two points, mm.
    Distance {
        /// Vector from the first point to the second, undeformed, mm.
        rest: Vector,
    },
    /// Displacement of the second point relative to the first point, mm. The displacement is measured normal to a direction that rotates with the
    /// first body. Undeformed, the two points coincide.
    Across {
        /// Unit vector of the direction, undeformed.
        direction: Vector,
    },
    /// Rotation of the second body relative to the first, rad.
    Turn,
}

/// A linear spring between two bodies. The energy of the spring is stiffness / 2 * deformation^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Point of attachment on each of the two bodies.
    pub ends: [Anchor; 2],
    /// Deformation that the spring resists.
    pub deformation: Deformation,
    /// Stiffness, N/mm; for a rotation in N mm per rad.
    pub stiffness: f64,
}

/// A straight piece of slender beam between two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// The two ends of the segment, as points fixed to their bodies.
    pub ends: [Anchor; 2],
    /// Whether each end is hinged, so that it transmits no moment.
    pub pinned: [bool; 2],
    /// Unit vector from the first end to the second, undeformed.
    pub direction: Vector,
    /// Length, mm.
    pub length_mm: f64,
    /// Axial rigidity EA (N), bending rigidity EI (N mm^2) and shear flexibility.
    pub section: Section,
}

/// Distance of the axial spring's points from the unpinned ends of a segment, as a share of the segment length.
///
/// Bending brings the ends of a beam closer together without axial strain. If the ends rotate by -phi and phi against the chord, an arc of length l
/// has the chord l (1 - phi^2 / 6). Consider two points, each fixed to one end and at the distance c l from that end. The distance of the two points
/// is l (1 - 2 c) + l (c - 1 / 6) phi^2, which is constant for c = 1 / 6. The share 1 / 6 also applies to a segment with one pinned end.
pub const AXIAL_INSET: f64 = 1.0 / 6.0;

/// Properties of the segments' axial springs. The default has the values of a slender beam; studies use other values to show the effect of inset and
/// stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxialSprings {
    /// Distance of the spring's points from the segment ends, as a share of the segment length; see [`AXIAL_INSET`].
    pub inset: f64,
    /// Stiffness in units of EA / l, dimensionless; 0 means that segments resist no extension.
    pub stiffness: f64,
}

impl AxialSprings {
    /// Axial springs of a slender beam.
    pub const OF_A_BEAM: AxialSprings = AxialSprings { inset: AXIAL_INSET, stiffness: 1.0 };
}

impl Default for AxialSprings {
    fn default() -> AxialSprings {
        AxialSprings::OF_A_BEAM
    }
}

impl Segment {
    /// Springs that replace the segment: one axial spring and the bending springs. A segment without pinned ends has three bending springs, a segment
    /// with one pinned end has one, and a segment with two pinned ends has none.
    ///
    /// Between two unpinned ends the elastic energy of a slender beam is EI / (2 l) turn^2 + 12 EI / (2 l^3) across^2. Here `turn` is the relative
    /// rotation of the ends, and `across` the gap at the middle if both halves stayed straight. For symmetry, two springs of half the stiffness
    /// resist the gap `across`: one normal to the direction of the first end, one normal to the direction of the second end. A segment with one pin
    /// is a cantilever, clamped at the unpinned end, with the stiffness 3 EI / l^3. A segment with two pins has only the axial spring. With shear
    /// deformation, the stiffness 12 EI / l^3 is divided by 1 + Phi, and 3 EI / l^3 by 1 + Phi / 4, with the shear parameter Phi.
    pub fn springs(&self, axial: AxialSprings) -> Vec<Spring> {
        let length = self.length_mm;
        let bending = self.section.bending_rigidity_nmm2;
        let shear = self.section.shear_parameter(length);
        let inset = self.direction * (length * axial.inset);
        let [first, second] = self.ends;
        let insets = self.pinned.map(|pinned| if pinned { Vector::zeros() } else { inset });
        let rest = self.direction * length - insets[0] - insets[1];
        let mut springs = vec![Spring {
            ends: [first.moved(insets[0]), second.moved(-insets[1])],
            deformation: Deformation::Distance { rest },
            stiffness: axial.stiffness * self.section.axial_rigidity_n / length,
        }];
        let across = |ends: [Anchor; 2], stiffness: f64| Spring {
            ends,
            deformation: Deformation::Across { direction: self.direction },
            stiffness,
        };
        let cantilever = 3.0 * bending / length.powi(3) / (1.0 + 0.25 * shear);
        match self.pinned {
            [false, false] => {
                let half = self.direction * (0.5 * length);
                let middle = [first.moved(half), second.moved(-half)];
                let stiffness = 6.0 * bending / length.powi(3) / (1.0 + shear);
                springs.push(across(middle, stiffness));
                springs.push(across([middle[1], middle[0]], stiffness));
                springs.push(Spring { ends: middle, deformation: Deformation::Turn, stiffness: bending / length });
            }
            [false, true] => {
                let reach = self.direction * length;
                springs.push(across([first.moved(reach), second], cantilever));
            }
            [true, false] => {
                let reach = self.direction * length;
                springs.push(across([second.moved(-reach), first], cantilever));
            }
            [true, true] => {}
        }
        springs
    }
}
