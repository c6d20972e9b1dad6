//! The springs that stand for a short segment of beam between two rigid bodies.

use finray_model::Vector;
use finray_model::frame::Section;

/// Index of a body of a lattice, from 0.
pub type BodyIndex = usize;

/// A point that a body carries along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor {
    /// The body.
    pub body: BodyIndex,
    /// From the centre of the body to the point, undeformed, mm.
    pub arm: Vector,
}

impl Anchor {
    /// The point farther along by `by`, mm, on the same body.
    pub fn moved(self, by: Vector) -> Anchor {
        Anchor { arm: self.arm + by, ..self }
    }
}

/// Deformation that a spring resists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deformation {
    /// Change of the distance between its two points.
    Distance {
        /// From the first point to the second, undeformed, mm.
        rest: Vector,
    },
    /// Displacement of the second point against the first, which it rests on, across a direction that the first body
    /// carries along.
    Across {
        /// The direction, undeformed; a unit vector.
        direction: Vector,
    },
    /// Rotation of the second body against the first.
    Turn,
}

/// A linear spring between two bodies: energy stiffness / 2 x deformation^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Its points on the two bodies.
    pub ends: [Anchor; 2],
    /// Deformation that it resists.
    pub deformation: Deformation,
    /// N / mm; for a rotation N mm.
    pub stiffness: f64,
}

/// A straight segment of slender beam between two anchors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Where it begins and ends.
    pub ends: [Anchor; 2],
    /// Whether it is free to turn at its ends.
    pub pinned: [bool; 2],
    /// Unit vector from the first end to the second, undeformed.
    pub direction: Vector,
    /// Length, mm.
    pub length_mm: f64,
    /// EA and EI.
    pub section: Section,
}

/// Share of the length by which the axial spring's points lie inside the segment, at ends that are not pinned.
///
/// A beam that bends comes nearer with its ends although it is not stretched. With the ends turned by -phi and phi
/// against the chord, a circular arc of length l has the chord l (1 - phi^2 / 6), and two points carried by the ends, c l
/// inside, have the distance l (1 - 2 c) + l (c - 1 / 6) phi^2: unstretched for c = 1 / 6. The same share is right
/// for a segment with one pinned end.
pub const AXIAL_INSET: f64 = 1.0 / 6.0;

/// Axial springs of the segments. The default is that of a beam; all else is there to see what it matters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxialSprings {
    /// Share of the length by which their points lie inside the segment; see [`AXIAL_INSET`].
    pub inset: f64,
    /// Their stiffness in units of EA / l; nought leaves them out.
    pub stiffness: f64,
}

impl AxialSprings {
    /// Those of a slender beam.
    pub const OF_A_BEAM: AxialSprings = AxialSprings { inset: AXIAL_INSET, stiffness: 1.0 };
}

impl Default for AxialSprings {
    fn default() -> AxialSprings {
        AxialSprings::OF_A_BEAM
    }
}

impl Segment {
    /// The springs of the segment, by its pins.
    ///
    /// Between two clamped ends the elastic energy of a slender beam is EI / (2 l) turn^2 + 12 EI / (2 l^3) across^2, with
    /// the turn of one end against the other, and the gap that opens across the beam at its middle if both halves stay straight.
    /// The gap is measured half by the one end's direction and half by the other's, so that neither is preferred. A
    /// segment with a pin is a cantilever, 3 EI / l^3, carried by the end that is not pinned; with two pins, a bar.
    pub fn springs(&self, axial: AxialSprings) -> Vec<Spring> {
        let length = self.length_mm;
        let bending = self.section.bending_rigidity_nmm2;
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
        match self.pinned {
            [false, false] => {
                let half = self.direction * (0.5 * length);
                let middle = [first.moved(half), second.moved(-half)];
                let stiffness = 6.0 * bending / length.powi(3);
                springs.push(across(middle, stiffness));
                springs.push(across([middle[1], middle[0]], stiffness));
                springs.push(Spring { ends: middle, deformation: Deformation::Turn, stiffness: bending / length });
            }
            [false, true] => {
                let reach = self.direction * length;
                springs.push(across([first.moved(reach), second], 3.0 * bending / length.powi(3)));
            }
            [true, false] => {
                let reach = self.direction * length;
                springs.push(across([second.moved(-reach), first], 3.0 * bending / length.powi(3)));
            }
            [true, true] => {}
        }
        springs
    }
}
