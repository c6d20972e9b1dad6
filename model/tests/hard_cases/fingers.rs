//! Fingers that are hard to solve.

use super::soundness::{AGREEMENT, DIFFERENCE, Soundness};
use super::{Case, Outcome, middle, worst};
use finray_model::finger::{FingerDescription, Part, Plate, RibPositions, Zone};
use finray_model::frame::FrameMotion;
use finray_model::statics::{Statics, StaticsError, solve};
use finray_model::{Finger, Kinematics, Load, Mesh, Vector};
use finray_tests::{motions_apart, paper};
use std::error::Error;

/// Force of most cases, N: it rotates parts of the paper's finger by tenths of a radian.
const FORCE_N: f64 = 2.0;
/// Load for stiff or delicate fingers, N.
const SMALL_FORCE_N: f64 = 0.1;
/// Tolerance of the effect of axial strain on the shapes of plates of 0.01 and 0.005 mm, relative. The effect grows as thickness^2.
const INEXTENSIBLE: f64 = 1e-4;
/// Tolerance of scaling laws, relative; Newton's method stops at 1e-11 of the energy norm.
const SCALING: f64 = 1e-9;
/// Tolerance of the displacements that the strain of a zone causes if the zone is 1e6 times stiffer, relative. It allows for the zone's lever arm.
const RIGID: f64 = 1e-5;
/// Tolerance of the co-rotational shape on 684 nodes, relative: the second error term of the elements (angle squared times strain).
const FINE_MESH: f64 = 1e-5;

fn variant(change: impl FnOnce(&mut FingerDescription)) -> Result<Finger, Box<dyn Error>> {
    let mut description = paper().description().clone();
    change(&mut description);
    Ok(Finger::new(description)?)
}

/// The mesh of key nodes of a finger with plates and ribs of one thickness, and a force that deforms it about as much as `FORCE_N` the paper's.
fn of_thickness(thickness_mm: f64) -> Result<(Mesh, Vector), Box<dyn Error>> {
    let finger = variant(|d| {
        for strip in [Some(&mut d.front), Some(&mut d.back), d.ribs.strip.as_mut()].into_iter().flatten() {
            strip.thickness_mm = thickness_mm;
        }
    })?;
    let ratio = thickness_mm / paper().description().front.thickness_mm;
    Ok((Mesh::key_nodes(&finger), finger.direction(0.0) * (FORCE_N * ratio.powi(3))))
}

/// Larger difference between two fields of displacements, linear and co-rotational.
fn apart(ours: &[FrameMotion; 2], reference: &[FrameMotion; 2]) -> f64 {
    worst((0..2).map(|kind| motions_apart(&ours[kind], &reference[kind])))
}

#[test]
fn thin_plates() -> Outcome {
    let mut case = Case::new(
        "plates and ribs of 0.01 mm",
        "bending is 1e6 times softer than stretching",
        "sound equilibrium; without axial strain the shape depends on load / thickness^3 alone",
    );
    let mut sound = Soundness::default();
    let mut shape = |thickness_mm| {
        let (mesh, force) = of_thickness(thickness_mm)?;
        sound.add(&mesh, middle(&paper()), force)
    };
    let (thin, thinner) = (shape(0.01)?, shape(0.005)?);
    sound.report(&mut case);
    case.vanishes("0.005 mm", DIFFERENCE, apart(&thin, &thinner), INEXTENSIBLE);
    case.holds()
}

#[test]
fn thick_plates() -> Outcome {
    let mut case = Case::new(
        "plates and ribs of 10 mm",
        "members about as thick as long: stretching counts as much as bending",
        "sound equilibrium",
    );
    let mut sound = Soundness::default();
    let (mesh, force) = of_thickness(10.0)?;
    sound.add(&mesh, middle(&paper()), force)?;
    sound.report(&mut case);
    case.holds()
}

#[test]
fn moduli() -> Outcome {
    let mut case = Case::new(
        "modulus 1e-3 to 1e6 MPa",
        "energies differ by eighteen powers of ten, so no tolerance may be an absolute value",
        "the shape depends on load / modulus alone",
    );
    let finger = paper();
    let force = finger.direction(0.0) * FORCE_N;
    let shapes = |finger: &Finger, force| Soundness::default().add(&Mesh::key_nodes(finger), middle(finger), force);
    let reference = shapes(&finger, force)?;
    let mut changes = Vec::new();
    for modulus_mpa in [1e-3, 1.0, 1e3, 1e6] {
        let factor = modulus_mpa / finger.description().front.youngs_modulus_mpa;
        changes.push(apart(&shapes(&finger.with_modulus_factor(factor)?, force * factor)?, &reference));
    }
    case.vanishes("47.976 MPa", DIFFERENCE, worst(changes), SCALING);
    case.holds()
}

#[test]
fn stiff_and_soft_zones() -> Outcome {
    let mut case = Case::new(
        "modulus ratio 1e6 between zones",
        "stiffness of neighbours differs by six powers of ten, also within one element",
        "sound equilibrium; a zone that is 1e6 times stiffer acts as rigid, so a zone that is 1e7 times stiffer gives the same shape",
    );
    let finger = paper();
    let length = finger.plate_length_mm(Plate::Front);
    let bend = |sound: &mut Soundness, modulus_factor: f64, elements| {
        // The ends of the zone lie inside elements.
        let zone = Zone { part: Part::Front, from_mm: 0.41 * length, to_mm: 0.62 * length, modulus_factor };
        let mesh = Mesh::with_elements_per_member(&variant(|d| d.zones = vec![zone])?, elements);
        // Under the full force at the tip, a soft zone would deform by more than its length.
        let force_n = if modulus_factor < 1.0 { 0.1 * FORCE_N } else { FORCE_N };
        sound.add(&mesh, finger.tip(), finger.direction(0.0) * force_n)
    };
    let mut sound = Soundness::default();
    let stiff = bend(&mut sound, 1e6, 1)?;
    for (factor, elements) in [(1e6, 4), (1e-6, 1), (1e-6, 4)] {
        bend(&mut sound, factor, elements)?;
    }
    sound.report(&mut case);
    let stiffer = bend(&mut Soundness::default(), 1e7, 1)?;
    case.vanishes("1e7 times stiffer", DIFFERENCE, apart(&stiff, &stiffer), RIGID);
    case.holds()
}

#[test]
fn many_ribs() -> Outcome {
    let mut case = Case::new(
        "200 ribs",
        "403 key nodes; near the tip, ribs are shorter than they are thick",
        "sound equilibrium; two elements per member do not change the linear solution",
    );
    let finger = variant(|d| d.ribs.positions = RibPositions::Count(200))?;
    let mut sound = Soundness::default();
    let mut linear = |elements| {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        sound.add(&mesh, middle(&finger), finger.direction(0.0) * FORCE_N).map(|[linear, _]| linear)
    };
    let change = motions_apart(&linear(1)?, &linear(2)?);
    sound.report(&mut case);
    case.vanishes("two elements per member, linear", DIFFERENCE, change, AGREEMENT);
    case.holds()
}

#[test]
fn close_ribs() -> Outcome {
    let mut case = Case::new(
        "ribs 0.01 mm and 1e-6 mm apart",
        "a plate member is 1e10 times stiffer than its neighbours (1e22 times for 1e-6 mm)",
        "for 0.01 mm, a sound equilibrium; for 1e-6 mm, a refusal because the solution is beyond double precision",
    );
    let length = paper().plate_length_mm(Plate::Front);
    let with_gap = |gap_mm: f64| {
        let positions = [(0.3, 0.0), (0.5, 0.0), (0.5, gap_mm), (0.8, 0.0)];
        let positions = positions.map(|(share, gap)| [share * length + gap; 2]).to_vec();
        variant(|d| d.ribs.positions = RibPositions::Positions(positions))
    };
    let mut sound = Soundness::default();
    let close = with_gap(0.01)?;
    let force = close.direction(0.0) * SMALL_FORCE_N;
    sound.add(&Mesh::key_nodes(&close), middle(&close), force)?;
    sound.report(&mut case);
    let closer = with_gap(1e-6)?;
    let refused = [Kinematics::Linear, Kinematics::Corotational].into_iter().filter(|&kinematics| {
        // The error must not report buckling, because the finger has an equilibrium.
        solve(&Mesh::key_nodes(&closer), &[Load::at_node(middle(&closer), force)], kinematics)
            .is_err_and(|error| !matches!(error, StaticsError::NoEquilibrium { .. }))
    });
    case.counts("double precision", "refusals, linear and co-rotational", 2, refused.count());
    case.holds()
}

#[test]
fn triangles() -> Outcome {
    let mut case = Case::new(
        "needle-thin and very obtuse triangles",
        "rounding by cancellation in the tip's position; plates nearly in line with each other",
        "plates have the given lengths; sound equilibrium, or a clear refusal that states a carried load",
    );
    let triangle = |[base, front, back]: [f64; 3]| {
        variant(|d| (d.base_width_mm, d.front_length_mm, d.back_length_mm) = (base, front, back))
    };
    let mut sound = Soundness::default();
    let mut sides = Vec::new();
    // Base, front and back, mm: two needles, a flat roof, and a front plate that leans outwards over its base.
    for lengths in [[0.5, 153.0, 153.0], [1e-3, 153.0, 153.0], [305.9, 153.0, 153.0], [100.0, 54.0, 153.0]] {
        let finger = triangle(lengths)?;
        let tip = finger.position(finger.tip());
        for (plate, length) in [(Plate::Front, lengths[1]), (Plate::Back, lengths[2])] {
            sides.push(((tip - finger.base(plate)).norm() / length - 1.0).abs());
        }
        sound.add_or_refused(&Mesh::key_nodes(&finger), middle(&finger), finger.direction(0.0) * SMALL_FORCE_N)?;
    }
    sound.report(&mut case);
    case.vanishes("base to tip", "length of a plate / given length - 1", worst(sides), 1e-12);
    let impossible = [[306.1, 153.0, 153.0], [0.0, 153.0, 153.0], [58.0, 153.0, 300.0], [1e-12, 153.0, 153.0]];
    let refused = impossible.into_iter().filter(|lengths| triangle(*lengths).is_err()).count();
    case.counts("triangle inequality", "impossible triangles refused", impossible.len(), refused);
    case.holds()
}

#[test]
fn a_hundred_thousand_nodes() -> Outcome {
    let mut case = Case::new(
        "100 000 nodes",
        "rounding grows about as the fourth power of the node count: a plain sparse solution is 10 % off",
        "linear: the 25 key nodes move as on the coarsest mesh, which is exact at nodes; co-rotational: they move as on 684 nodes",
    );
    let finger = paper();
    let moved = |mesh: &Mesh, kinematics| -> Result<FrameMotion, Box<dyn Error>> {
        let load = mesh.frame_load(&Load::at_node(middle(&finger), finger.direction(0.0) * FORCE_N))?;
        let mut motion = Statics::ladder(mesh, kinematics).equilibrium(&[load])?.motion;
        motion.displacements.truncate(finger.key_node_count());
        Ok(motion)
    };
    let large = Mesh::with_nodes(&finger, 100_000)?;
    for (source, mesh, kinematics, tolerance) in [
        ("25 nodes, linear", Mesh::key_nodes(&finger), Kinematics::Linear, AGREEMENT),
        ("684 nodes, co-rotational, 2 N", Mesh::with_nodes(&finger, 684)?, Kinematics::Corotational, FINE_MESH),
    ] {
        let off = motions_apart(&moved(&large, kinematics)?, &moved(&mesh, kinematics)?);
        case.vanishes(source, DIFFERENCE, off, tolerance);
    }
    case.holds()
}
