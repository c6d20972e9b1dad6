//! Validity of the beam model in an equilibrium: strains must be small, shear must be negligible or part of the model, and bending must stay in the
//! plane.
//!
//! Euler-Bernoulli beams with stress = E times strain give a smooth solution under any load, even an unrealistic one. [`Validity`] computes how large
//! the neglected effects are in an equilibrium. [`Validity::warnings`] compares strains with the material's limits ([`StrainLimits`], by default
//! [`LARGEST_STRAIN`]) and shear with [`LARGEST_SHEAR_SHARE`]. Undeformable ribs are not examined.

mod warning;

pub use warning::ValidityWarning;

use crate::element::{Beam, Station};
use crate::finger::{Finger, Part, Plate, SectionFactors};
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::{Load, Mesh};
use crate::statics::{Statics, StaticsError};
use crate::{Kinematics, NodeId, Vector};

/// Default limit of the fibre strain, dimensionless, for a material without a stated limit. Up to this strain, stress is assumed to be E times strain.
///
/// An incompressible rubber in tension has the stress E / 3 (l - 1 / l^2) at the stretch ratio l (neo-Hookean; Treloar, The Physics of Rubber
/// Elasticity, 1975, ch. 5). At the strain eps = l - 1, this stress is E eps (1 - eps + ...). At 5 % strain, the stress is 5 % below E eps, and
/// engineering and logarithmic strain differ by 2.5 %. Flexural tests of plastics that use beam formulas also end at 5 % strain of the outer fibre
/// (ASTM D790).
pub const LARGEST_STRAIN: f64 = 0.05;

/// Number of elements per member when an equilibrium is solved only for examination. With four elements per member, shapes are accurate to 0.04 %
/// under a force of 3 N.
const ELEMENTS: usize = 4;

/// Euler-Bernoulli beams count as invalid if the share of shear in the strain energy exceeds this dimensionless limit.
///
/// At this limit, the loads move the finger by up to 5 % more than computed without shear (see [`Validity::shear_share`]). If shear and largest
/// strain are both at their limits, the error of a force stays within 10 %. Table I of the paper shades cells with errors of at least 10 % (Xu et al.
/// 2021, sec. V-A). A cantilever with a load at its end reaches this share of shear at a length of 3.5 thicknesses for Poisson's ratio 0 (4.7 for
/// 0.45). A member that is clamped at both ends and sways reaches this share of shear at a length of 7 thicknesses for Poisson's ratio 0 (9.3 for
/// 0.45).
pub const LARGEST_SHEAR_SHARE: f64 = 0.05;

/// Shear correction factor of a rectangular section, dimensionless, from the energy of the parabolic shear stress (Timoshenko and Goodier, Theory of
/// Elasticity; Gere and Timoshenko, Mechanics of Materials, form factor 6/5).
pub const SHEAR_CORRECTION: f64 = 5.0 / 6.0;

/// Largest strain at which the material of each part is linear, dimensionless. `None` if the scene does not state the limit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StrainLimits {
    /// Limit of the strain of the front plate, dimensionless.
    pub front: Option<f64>,
    /// Limit of the strain of the back plate, dimensionless.
    pub back: Option<f64>,
    /// Limit of the strain of the ribs, dimensionless.
    pub ribs: Option<f64>,
}

impl StrainLimits {
    /// Strain limit of a part as stated in the scene, dimensionless; `None` if the scene states no limit.
    pub fn stated(&self, part: Part) -> Option<f64> {
        match part {
            Part::Front => self.front,
            Part::Back => self.back,
            Part::Ribs => self.ribs,
        }
    }

    /// Strain limit of a part, dimensionless: the limit that the scene states, otherwise [`LARGEST_STRAIN`].
    pub fn of(&self, part: Part) -> f64 {
        self.stated(part).unwrap_or(LARGEST_STRAIN)
    }
}

/// A member of the finger: a segment of a plate between two key nodes, or a rib.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FingerMember {
    /// Part of the finger that the member belongs to.
    pub part: Part,
    /// Key nodes at the member's ends.
    pub nodes: [NodeId; 2],
    /// Free length (without rigid arms) divided by thickness, dimensionless. For a tapered plate, the thickness of the member's thickest element is
    /// used.
    pub slenderness: f64,
}

/// Largest fibre strain in one part of the finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FibreStrain {
    /// Fibre strain, dimensionless: |axial strain| + |curvature| thickness / 2. The magnitudes add, because axial and bending strain have the same
    /// sign in one of the two outer fibres.
    pub strain: f64,
    /// Axial strain at the position of the largest fibre strain, dimensionless; positive in tension.
    pub axial_strain: f64,
    /// Member that contains the position of the largest fibre strain.
    pub member: FingerMember,
    /// Position of the largest strain, mm: along a plate from its base, along a rib from the back plate.
    pub at_mm: f64,
}

/// Measures of an equilibrium that show whether it satisfies the assumptions of the beam model.
#[derive(Debug, Clone, PartialEq)]
pub struct Validity {
    /// Largest fibre strain of each deformable part, in the order front plate, back plate, ribs.
    pub strains: Vec<FibreStrain>,
    /// Shear energy divided by the strain energy of elongation and bending, dimensionless; zero at rest. The shear energy is the sum of V^2 l / (2
    /// kappa G A) over the members. V is the shear force, l the length, kappa = [`SHEAR_CORRECTION`] and G = E / (2 (1 + nu)). Zero if the model of
    /// the finger includes shear, because no shear is neglected then.
    ///
    /// If the model included shear, the work of the loads on a linear finger would grow by at most this share. This bound holds because the section
    /// forces of beams with shear minimise the complementary energy, and the section forces of Euler-Bernoulli beams are admissible in this
    /// minimisation.
    pub shear_share: f64,
    /// Member with the largest shear energy; `None` without shear.
    pub shear_at: Option<FingerMember>,
    /// Out-of-plane depth divided by the thickness of the thickest element, dimensionless.
    pub depth_ratio: f64,
}

impl Validity {
    /// Examines the motion of a mesh that is in equilibrium under loads. `kinematics` must be the kinematics with which the motion was solved.
    pub fn of(mesh: &Mesh, motion: &FrameMotion, kinematics: Kinematics, loads: &[FrameLoad]) -> Validity {
        let finger = mesh.finger();
        let examined = |index| examine(mesh, index, motion, kinematics, loads);
        let members: Vec<Examined> = (0..mesh.lines().len()).filter_map(examined).collect();
        let largest = |part| {
            let strains =
                members.iter().filter(|examined| examined.member.part == part).map(|examined| examined.strain);
            strains.max_by(|a, b| a.strain.total_cmp(&b.strain))
        };
        let strained: f64 = members.iter().map(|member| member.strain_energy).sum();
        let sheared: f64 = members.iter().map(|member| member.shear_energy).sum();
        let most = members.iter().max_by(|a, b| a.shear_energy.total_cmp(&b.shear_energy));
        let thickest = members.iter().map(|examined| examined.thickest_mm).fold(0.0, f64::max);
        Validity {
            strains: PARTS.into_iter().filter_map(largest).collect(),
            shear_share: if sheared > 0.0 { sheared / strained } else { 0.0 },
            shear_at: most.filter(|member| member.shear_energy > 0.0).map(|most| most.member),
            depth_ratio: finger.description().depth_mm / thickest,
        }
    }

    /// Computes the co-rotational equilibrium of a finger under loads and examines it.
    ///
    /// # Errors
    /// [`StaticsError`] if a load is invalid or no equilibrium exists.
    pub fn under(finger: &Finger, loads: impl Iterator<Item = Load>) -> Result<Validity, StaticsError> {
        let mesh = Mesh::with_elements_per_member(finger, ELEMENTS);
        let loads = loads.map(|load| mesh.frame_load(&load)).collect::<Result<Vec<_>, _>>()?;
        let found = Statics::ladder(&mesh, Kinematics::Corotational).equilibrium(&loads)?;
        Ok(Validity::of(&mesh, &found.motion, Kinematics::Corotational, &loads))
    }

    /// Largest fibre strain of the part that has the largest ratio of strain to limit.
    pub fn largest_strain(&self, limits: &StrainLimits) -> Option<&FibreStrain> {
        let share = |strain: &FibreStrain| strain.strain / limits.of(strain.member.part);
        self.strains.iter().max_by(|a, b| share(a).total_cmp(&share(b)))
    }
}

const PARTS: [Part; 3] = [Part::Front, Part::Back, Part::Ribs];

/// Thickness of a beam with rectangular section, mm, from the ratio of its rigidities in plane strain. A zone with a different modulus does not change
/// this ratio. For an element of a tapered plate, the result lies between the thicknesses at the element's ends.
fn thickness_mm(beam: &Beam, factors: SectionFactors) -> f64 {
    let bending_nmm2 = beam.bending_rigidity_nmm2 / factors.bending;
    (12.0 * bending_nmm2 * factors.stretching / beam.axial_rigidity_n).sqrt()
}

/// Largest fibre strain and energies (N mm) of one member.
struct Examined {
    member: FingerMember,
    /// Largest thickness of an element, mm.
    thickest_mm: f64,
    strain: FibreStrain,
    /// Strain energy of elongation and bending, N mm.
    strain_energy: f64,
    /// Shear energy, N mm.
    shear_energy: f64,
}

/// Examines the member with index `line`. Returns `None` for an undeformable rib.
fn examine(
    mesh: &Mesh,
    line: usize,
    motion: &FrameMotion,
    kinematics: Kinematics,
    loads: &[FrameLoad],
) -> Option<Examined> {
    let finger = mesh.finger();
    // Lines are the members of the back plate, then of the front plate, then the ribs.
    let of_plate = finger.rib_count() + 1;
    let nth = if line < 2 * of_plate { line % of_plate } else { line - 2 * of_plate };
    let line = &mesh.lines()[line];
    let factors = finger.section_factors(line.part, nth);
    let members = &mesh.frame().members()[line.members.clone()];
    let (first, last) = (line.nodes.first()?, line.nodes.last()?);
    let free_mm: f64 = members.iter().map(|member| member.beam.length_mm).sum();
    let thickest_mm = members.iter().map(|member| thickness_mm(&member.beam, factors)).fold(0.0, f64::max);
    let examined = FingerMember {
        part: line.part,
        nodes: [NodeId(first + 1), NodeId(last + 1)],
        slenderness: free_mm / thickest_mm,
    };
    // Position of the member's first node along its part, mm, as in [`FibreStrain::at_mm`].
    let origin_mm = match line.part {
        Part::Front => (mesh.frame().position(*first) - finger.base(Plate::Front)).norm(),
        Part::Back => (mesh.frame().position(*first) - finger.base(Plate::Back)).norm(),
        Part::Ribs => 0.0,
    };
    let mut start_mm = origin_mm + members.first()?.ends[0].arm.norm();
    let shear_rigidity = SHEAR_CORRECTION * (1.0 - finger.description().poissons_ratio) / (2.0 * factors.stretching);
    let mut strain = FibreStrain { strain: 0.0, axial_strain: 0.0, member: examined, at_mm: start_mm };
    let (mut strain_energy, mut shear_energy) = (0.0, 0.0);
    for (index, member) in line.members.clone().zip(members) {
        let beam = &member.beam;
        let thickness_mm = thickness_mm(beam, factors);
        let forces: Vec<(f64, Vector)> = loads.iter().filter_map(|load| inside(load, index)).collect();
        for ends in mesh.frame().stations(motion, index, kinematics, &forces).chunks_exact(2) {
            let [from, to] = [ends[0], ends[1]];
            for station in [from, to] {
                let fibre = station.axial_strain.abs() + 0.5 * thickness_mm * station.curvature_per_mm.abs();
                if fibre > strain.strain {
                    let at_mm = start_mm + station.xi * beam.length_mm;
                    strain = FibreStrain { strain: fibre, axial_strain: station.axial_strain, at_mm, ..strain };
                }
            }
            let length_mm = (to.xi - from.xi) * beam.length_mm;
            let (axial, bending) = (beam.axial_rigidity_n, beam.bending_rigidity_nmm2);
            strain_energy += 0.5 * length_mm * (axial * from.axial_strain.powi(2) + bending * mean_square(&from, &to));
            if length_mm > 0.0 && finger.description().shear_correction == 0.0 {
                let shear_n = bending * (to.curvature_per_mm - from.curvature_per_mm) / length_mm;
                // The axial rigidity in plane strain is E A / (1 - nu^2), so G A is (1 - nu) / 2 times that.
                shear_energy += 0.5 * length_mm * shear_n.powi(2) / (shear_rigidity * axial);
            }
        }
        start_mm += beam.length_mm;
    }
    Some(Examined { member: examined, thickest_mm, strain, strain_energy, shear_energy })
}

/// Position (fraction of the length) and force (N) of a load between the ends of member `index`; `None` for any other load.
fn inside(load: &FrameLoad, index: usize) -> Option<(f64, Vector)> {
    match *load {
        FrameLoad::Interior { member, xi, force } if member == index => Some((xi, force)),
        _ => None,
    }
}

/// Mean square of the curvature between two stations, 1/mm^2, for a curvature that varies linearly between them.
fn mean_square(from: &Station, to: &Station) -> f64 {
    let (a, b) = (from.curvature_per_mm, to.curvature_per_mm);
    (a * a + a * b + b * b) / 3.0
}
