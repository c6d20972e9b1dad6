//! Hard cases: fingers that are hard to solve.

use super::soundness::{AGREEMENT, DIFFERENCE, Soundness, difference};
use super::{Findings, Question, Unexpected, middle};
use crate::prelude::*;
use crate::truths::FINE_MESH_NODES;
use finray_model::finger::{FingerDescription, Part, RibPositions, Zone};
use finray_model::statics::solve;

pub(super) const QUESTIONS: &[Question] = &[
    Question {
        case: "plates and ribs of 0.01 mm",
        difficulty: "bending is 1e6 times softer than stretching",
        expectation: "sound equilibrium; without axial strain the shape depends on load / thickness^3 alone",
        answer: thin,
    },
    Question {
        case: "plates and ribs of 10 mm",
        difficulty: "members about as thick as long: stretching counts as much as bending",
        expectation: "sound equilibrium",
        answer: thick,
    },
    Question {
        case: "modulus 1e-3 to 1e6 MPa",
        difficulty: "energies differ by eighteen powers of ten, so no tolerance may be an absolute value",
        expectation: "the shape depends on load / modulus alone",
        answer: modulus,
    },
    Question {
        case: "modulus ratio 1e6 between zones",
        difficulty: "stiffness of neighbours differs by six powers of ten, also within one element",
        expectation: "sound equilibrium; a zone that is 1e6 times stiffer acts as rigid, so a zone that is 1e7 times stiffer \
            gives the same shape",
        answer: zones,
    },
    Question {
        case: "200 ribs",
        difficulty: "403 key nodes; near the tip, ribs are shorter than they are thick",
        expectation: "sound equilibrium; two elements per member do not change the linear solution",
        answer: many_ribs,
    },
    Question {
        case: "ribs 0.01 mm and 1e-6 mm apart",
        difficulty: "a plate member is 1e10 times stiffer than its neighbours (1e22 times for 1e-6 mm)",
        expectation: "for 0.01 mm, a sound equilibrium; for 1e-6 mm, a refusal because the solution is beyond double precision",
        answer: close_ribs,
    },
    Question {
        case: "needle-thin and very obtuse triangles",
        difficulty: "rounding by cancellation in the tip's position; plates nearly in line with each other",
        expectation: "plates have the given lengths; sound equilibrium, or a clear refusal that states a carried load",
        answer: triangles,
    },
    Question {
        case: "100 000 nodes",
        difficulty: "rounding grows about as the fourth power of the node count: a plain sparse solution is 10 % off",
        expectation: "linear: the 25 key nodes move as on the coarsest mesh, which is exact at nodes; co-rotational: they move \
            as on 684 nodes",
        answer: large_mesh,
    },
];

/// Force of most cases, N: it rotates parts of the paper's finger by tenths of a radian.
const FORCE_N: f64 = 2.0;
/// Two thicknesses, mm. The next constant is the relative tolerance of the effect of axial strain on the shapes. The effect grows as thickness^2.
const THIN_MM: [f64; 2] = [0.01, 0.005];
const INEXTENSIBLE: f64 = 1e-4;
const THICK_MM: f64 = 10.0;
const MODULI_MPA: [f64; 4] = [1e-3, 1.0, 1e3, 1e6];
/// Tolerance of scaling laws, relative; Newton's method stops at 1e-11 of the energy norm.
const SCALING: f64 = 1e-9;
const ZONE_FACTORS: [f64; 2] = [1e6, 1e-6];
/// Relative tolerance of the displacements that the strain of a zone causes if the zone is 1e6 times stiffer. The tolerance allows for the zone's
/// lever arm.
const RIGID: f64 = 1e-5;
const LARGE_MESH_NODES: usize = 100_000;
/// Tolerance of an accepted solution, relative: four correct digits.
const FOUR_DIGITS: f64 = 1e-4;
/// Load for stiff or delicate fingers, N.
const SMALL_FORCE_N: f64 = 0.1;

fn variant(finger: &Finger, change: impl FnOnce(&mut FingerDescription)) -> Result<Finger, Unexpected> {
    let mut description = finger.description().clone();
    change(&mut description);
    Ok(Finger::new(description)?)
}

fn with_thickness(finger: &Finger, thickness_mm: f64) -> Result<Finger, Unexpected> {
    variant(finger, |d| {
        d.ribs.thicknesses_mm = None;
        for strip in [Some(&mut d.front), Some(&mut d.back), d.ribs.strip.as_mut()].into_iter().flatten() {
            (strip.thickness_mm, strip.tip_thickness_mm) = (thickness_mm, None);
        }
    })
}

/// Force along the normal, N, that deforms a finger of another thickness about as much as `FORCE_N` deforms the given finger.
fn bending_force(finger: &Finger, thickness_mm: f64) -> Vector {
    let ratio = thickness_mm / finger.description().front.thickness_mm;
    finger.direction(0.0) * (FORCE_N * ratio.powi(3))
}

fn thin(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mut sound = Soundness::default();
    let mut shapes = Vec::new();
    for thickness_mm in THIN_MM {
        let mesh = Mesh::key_nodes(&with_thickness(finger, thickness_mm)?);
        shapes.push(sound.add(&mesh, middle(finger), bending_force(finger, thickness_mm))?);
    }
    sound.report(findings);
    let changes = (0..2).map(|kind| difference(&shapes[0][kind], &shapes[1][kind]));
    findings.vanishes("0.005 mm", DIFFERENCE, worst(changes), INEXTENSIBLE);
    Ok(())
}

fn thick(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mut sound = Soundness::default();
    let mesh = Mesh::key_nodes(&with_thickness(finger, THICK_MM)?);
    sound.add(&mesh, middle(finger), bending_force(finger, THICK_MM))?;
    sound.report(findings);
    Ok(())
}

fn modulus(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let force = finger.direction(0.0) * FORCE_N;
    let shapes = |finger: &Finger, force: Vector| -> Result<[FrameMotion; 2], Unexpected> {
        Soundness::default().add(&Mesh::key_nodes(finger), middle(finger), force)
    };
    let reference = shapes(finger, force)?;
    let mut changes = Vec::new();
    for modulus_mpa in MODULI_MPA {
        let factor = modulus_mpa / finger.description().front.youngs_modulus_mpa;
        let scaled = shapes(&finger.with_modulus_factor(factor)?, force * factor)?;
        changes.extend((0..2).map(|kind| difference(&scaled[kind], &reference[kind])));
    }
    findings.vanishes("47.976 MPa", DIFFERENCE, worst(changes), SCALING);
    Ok(())
}

fn zones(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let length = finger.plate_length_mm(Plate::Front);
    let with_zone = |modulus_factor: f64| {
        // The ends of the zone lie inside elements.
        let zone = Zone { part: Part::Front, from_mm: 0.41 * length, to_mm: 0.62 * length, modulus_factor };
        variant(finger, |d| d.zones = vec![zone])
    };
    let mut sound = Soundness::default();
    for (factor, elements) in ZONE_FACTORS.into_iter().flat_map(|factor| [(factor, 1), (factor, 4)]) {
        let mesh = Mesh::with_elements_per_member(&with_zone(factor)?, elements);
        // Under the full force at the tip, a soft zone would deform by more than its length.
        let force = finger.direction(0.0) * if factor < 1.0 { 0.1 * FORCE_N } else { FORCE_N };
        sound.add(&mesh, finger.tip(), force)?;
    }
    sound.report(findings);
    let stiff = |factor: f64| -> Result<[FrameMotion; 2], Unexpected> {
        let mesh = Mesh::key_nodes(&with_zone(factor)?);
        Soundness::default().add(&mesh, finger.tip(), finger.direction(0.0) * FORCE_N)
    };
    let (stiff, stiffer) = (stiff(1e6)?, stiff(1e7)?);
    let changes = (0..2).map(|kind| difference(&stiff[kind], &stiffer[kind]));
    findings.vanishes("1e7 times stiffer", DIFFERENCE, worst(changes), RIGID);
    Ok(())
}

fn many_ribs(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let finger = variant(finger, |d| d.ribs.positions = RibPositions::Count(200))?;
    let mut sound = Soundness::default();
    let [coarse, fine] = [1, 2].map(|elements| Mesh::with_elements_per_member(&finger, elements));
    let force = finger.direction(0.0) * FORCE_N;
    let [linear, _] = sound.add(&coarse, middle(&finger), force)?;
    let [refined, _] = sound.add(&fine, middle(&finger), force)?;
    sound.report(findings);
    let change = difference(&linear, &refined);
    findings.vanishes("two elements per member, linear", DIFFERENCE, change, AGREEMENT);
    Ok(())
}

fn close_ribs(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let [front, back] = [Plate::Front, Plate::Back].map(|plate| finger.plate_length_mm(plate));
    let with_gap = |gap_mm: f64| {
        let positions = [[0.3, 0.0], [0.5, 0.0], [0.5, gap_mm], [0.8, 0.0]];
        let positions = positions.map(|[share, gap]| [share * front + gap, share * back + gap]).to_vec();
        variant(finger, |d| d.ribs.positions = RibPositions::Positions(positions))
    };
    let mut sound = Soundness::default();
    let close = with_gap(0.01)?;
    sound.add(&Mesh::key_nodes(&close), middle(&close), finger.direction(0.0) * SMALL_FORCE_N)?;
    sound.report(findings);
    let closer = with_gap(1e-6)?;
    let mesh = Mesh::key_nodes(&closer);
    let load = Load::at_node(middle(&closer), finger.direction(0.0) * SMALL_FORCE_N);
    let refused = [Kinematics::Linear, Kinematics::Corotational].into_iter().filter(|&kinematics| {
        // The error must not report buckling, because the finger has an equilibrium.
        solve(&mesh, &[load], kinematics).is_err_and(|error| !matches!(error, StaticsError::NoEquilibrium { .. }))
    });
    findings.counts("double precision", "refusals, linear and co-rotational", 2, refused.count());
    Ok(())
}

fn triangles(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mut sound = Soundness::default();
    let mut sides = Vec::new();
    // Lengths of base, front and back, mm, of four triangles: two needles, a flat roof, and a front plate that leans outwards over its base.
    for [base, front, back] in [[0.5, 153.0, 153.0], [1e-3, 153.0, 153.0], [305.9, 153.0, 153.0], [100.0, 54.0, 153.0]]
    {
        let finger = variant(finger, |d| {
            (d.base_width_mm, d.front_length_mm, d.back_length_mm) = (base, front, back);
        })?;
        let tip = finger.position(finger.tip());
        for (plate, length) in [(Plate::Front, front), (Plate::Back, back)] {
            sides.push(((tip - finger.base(plate)).norm() / length - 1.0).abs());
        }
        let mesh = Mesh::key_nodes(&finger);
        let share = sound.add_or_refused(&mesh, middle(&finger), finger.direction(0.0) * SMALL_FORCE_N)?;
        if share < 1.0 {
            findings.note(format!(
                "The finger with a base of {base} mm carries {:.2e} N of {SMALL_FORCE_N} N.",
                share * SMALL_FORCE_N
            ));
        }
    }
    sound.report(findings);
    findings.vanishes("base to tip", "length of a plate / given length - 1", worst(sides), 1e-12);
    let impossible = [[306.1, 153.0, 153.0], [0.0, 153.0, 153.0], [58.0, 153.0, 300.0], [1e-12, 153.0, 153.0]];
    let refused = impossible.iter().filter(|[base, front, back]| {
        let impossible = |d: &mut FingerDescription| {
            (d.base_width_mm, d.front_length_mm, d.back_length_mm) = (*base, *front, *back);
        };
        variant(finger, impossible).is_err()
    });
    findings.counts("triangle inequality", "impossible triangles refused", impossible.len(), refused.count());
    Ok(())
}

fn large_mesh(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::with_nodes(finger, LARGE_MESH_NODES)?;
    let node = middle(finger);
    let moved = |mesh: &Mesh, force_n: f64, kinematics: Kinematics| -> Result<FrameMotion, Unexpected> {
        let load = mesh.frame_load(&Load::at_node(node, finger.direction(0.0) * force_n))?;
        let mut motion = Statics::ladder(mesh, kinematics).equilibrium(&[load])?.motion;
        motion.displacements.truncate(finger.key_node_count());
        Ok(motion)
    };
    let exact = moved(&Mesh::key_nodes(finger), FORCE_N, Kinematics::Linear)?;
    let linear = difference(&moved(&mesh, FORCE_N, Kinematics::Linear)?, &exact);
    let fine = Mesh::with_nodes(finger, FINE_MESH_NODES)?;
    let fine = moved(&fine, FORCE_N, Kinematics::Corotational)?;
    let large = difference(&moved(&mesh, FORCE_N, Kinematics::Corotational)?, &fine);
    findings.vanishes("25 nodes, linear", DIFFERENCE, linear, FOUR_DIGITS);
    findings.vanishes("684 nodes, co-rotational, 2 N", DIFFERENCE, large, FOUR_DIGITS);
    Ok(())
}
