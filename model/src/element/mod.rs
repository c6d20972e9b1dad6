//! One plane beam element: its elastic energy, nodal forces and tangent stiffness.
//!
//! An element does not depend on the structure around it. An element maps the motion of its two ends to a [`Response`]. [`crate::frame`] connects the
//! ends to nodes through arms, pins and rigid links.

mod chord;
mod diagram;
mod interior;
mod natural;
mod previous;

pub use chord::Chord;
pub(crate) use chord::quarter_turn;
pub use diagram::Station;
pub(crate) use natural::Elastic;
pub(crate) use previous::Previous;

use crate::number::Number;
use nalgebra::{SMatrix, SVector, Vector2};
use serde::{Deserialize, Serialize};

/// Kinematic relation between displacements and strains of a beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kinematics {
    /// Small displacements, as in Xu et al. (2021), eqs (1) to (5).
    Linear,
    /// Co-rotational with the axial strain of a shallow arch: bending shortens the chord.
    Corotational,
    /// Co-rotational with the axial strain of the chord alone, as in OpenSees' `Corotational` transformation.
    CorotationalChord,
}

/// Vector with one entry per coordinate of an element: x, y (mm) and rotation (rad) of the first end, then of the second.
pub type ElementVector = SVector<f64, 6>;
/// Second derivatives by the six coordinates of an [`ElementVector`].
pub type ElementMatrix = SMatrix<f64, 6, 6>;

/// Motion of one beam end, finger frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndMotion<R = f64> {
    /// Displacement from the undeformed position, mm.
    pub displacement: Vector2<R>,
    /// Rotation from the undeformed direction, rad.
    pub rotation: R,
}

/// A scalar of the element (energy or work), with its first and second derivatives by the motions of the two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response<R = f64> {
    /// Elastic energy of the element, or work of a load on it, N mm.
    pub energy: R,
    /// First derivatives: forces (N) and moments (N mm) at the two ends.
    pub gradient: SVector<R, 6>,
    /// Second derivatives: the consistent tangent stiffness, symmetric; N/mm, N and N mm.
    pub tangent: SMatrix<R, 6, 6>,
}

/// A straight beam with constant cross-section, whose elastic axis may lie beside the line between its ends.
///
/// A beam without shear deformation is an Euler-Bernoulli beam. With shear deformation it is a Timoshenko beam: sections rotate by the shear angle
/// relative to the axis. The shear angle is constant between loads, so the axis remains a cubic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam<R = f64> {
    /// Unit vector from the first to the second end of the undeformed beam.
    pub direction: Vector2<R>,
    /// Undeformed length, mm.
    pub length_mm: R,
    /// Axial rigidity EA, N.
    pub axial_rigidity_n: R,
    /// Bending rigidity EI, N mm^2.
    pub bending_rigidity_nmm2: R,
    /// Factor 1 / (1 + Phi) by which shear reduces the stiffness against sway, with Phi = 12 EI / (kappa G A L^2); 1 without shear deformation.
    pub sway_factor: R,
    /// Distances of the elastic axis from the chord of the undeformed beam at both ends, positive to the left of `direction`, mm. An axial force
    /// bends a beam whose axis is beside its chord.
    pub axis_mm: [R; 2],
}

impl Beam {
    /// The beam in the number type of `like`.
    #[inline(always)]
    pub(crate) fn in_numbers<R: Number>(&self, like: R) -> Beam<R> {
        Beam {
            direction: Vector2::new(like.constant(self.direction.x), like.constant(self.direction.y)),
            length_mm: like.constant(self.length_mm),
            axial_rigidity_n: like.constant(self.axial_rigidity_n),
            bending_rigidity_nmm2: like.constant(self.bending_rigidity_nmm2),
            sway_factor: like.constant(self.sway_factor),
            axis_mm: [like.constant(self.axis_mm[0]), like.constant(self.axis_mm[1])],
        }
    }
}

impl<R: Number> Beam<R> {
    /// Energy, nodal forces and tangent stiffness for given motions of the two ends.
    ///
    /// All kinematics share one formulation. The end motions determine three natural deformations: the elongation e of the chord, and the rotations
    /// phi_a and phi_b of the two ends relative to the chord (Argyris' natural modes). U(e, phi_a, phi_b) is the energy of a beam fixed to its chord.
    /// The chain rule transforms the derivatives of U to the end motions. Let `d` be the 3 x 6 matrix of derivatives of the natural deformations by
    /// the end motions.
    ///
    /// gradient = d^T U',   tangent = d^T U'' d + sum_i U'_i (second derivative of deformation i).
    ///
    /// Source: Crisfield, Non-linear Finite Element Analysis of Solids and Structures, vol. 1, sec. 7.3; shear: Przemieniecki, Theory of Matrix
    /// Structural Analysis, sec. 5.6.
    #[inline(always)]
    pub fn response(&self, kinematics: Kinematics, motion: &[EndMotion<R>; 2]) -> Response<R> {
        self.elastic(kinematics, motion, &mut Previous::at_rest(self), (false, false)).response
    }

    /// Same as [`response`](Beam::response). Stores the shape in `previous`. If the first of the two flags is true, the force that turns with the chord
    /// is [extrapolated](Previous) from the previous shape; the second flag says whether the ends moved along straight lines since.
    #[inline(always)]
    pub(crate) fn elastic(
        &self,
        kinematics: Kinematics,
        motion: &[EndMotion<R>; 2],
        previous: &mut Previous<R>,
        (extrapolates, straight): (bool, bool),
    ) -> Elastic<R> {
        if kinematics == Kinematics::Linear {
            let chord = Chord::at_rest(self);
            return self.response_on(&chord, &chord.linear_deformation(motion), (false, false), None);
        }
        let chord = Chord::deformed(self, motion);
        let bowing = kinematics == Kinematics::Corotational;
        let shape = Previous { deformation: chord.deformation(motion), along: chord.along };
        let forces =
            if extrapolates { Some(previous.extrapolated_forces(self, bowing, &shape, straight)) } else { None };
        *previous = shape;
        self.response_on(&chord, &shape.deformation, (bowing, true), forces)
    }
}
