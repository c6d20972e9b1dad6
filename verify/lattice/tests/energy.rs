//! Tests of the lattice's energy and of its minimum.

use finray_lattice::bodies::{Assembly, Body, BodyLoad};
use finray_lattice::energy::{BodyMotion, Energy};
use finray_lattice::springs::{Anchor, AxialSprings, Segment};
use finray_lattice::{Lattice, LatticeError};
use finray_model::finger::{Joints, Plate, RibPositions};
use finray_model::frame::Section;
use finray_model::mesh::{Load, LoadError};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Vector, statics};
use finray_tests::{built_finger, cases, contact_node, finger_of, paper, shapes_apart};
use proptest::prelude::*;

/// Step of central differences. The error of a central difference is the square of the step times the third derivative, plus rounding divided by the
/// step.
const DIFFERENCE_STEP: f64 = 1e-5;
const DIFFERENCE_TOLERANCE: f64 = 1e-7;
/// Displacement of the key nodes, as a share of the finger's length, that is so small that the finger is linear. Between the nodes, the displacement
/// may be larger.
const LINEAR_SHARE: f64 = 1e-15;
const LINEAR_TOLERANCE: f64 = 1e-6;
/// Tolerance for fingers whose undeformable ribs are stiff bars. Each bar stretches a tenth as much as a plate, which is visible if stretching causes
/// most of the nodes' displacement.
const BAR_TOLERANCE: f64 = 2e-3;
/// Number of segments of the cantilever. The chain of springs bends like an arc, up to an error that grows with the fourth power of the segments'
/// rotations.
const CANTILEVER_SEGMENTS: usize = 16;
const ELASTICA_TOLERANCE: f64 = 2e-4;
/// Axial rigidity EA L^2 / EI of the cantilever, dimensionless. The reference solution is inextensible; the cantilever of springs stretches by 1e-5
/// at the largest load.
const CANTILEVER_AXIAL_RIGIDITY: f64 = 1e6;

/// Irregular motions of all free bodies of a lattice.
fn disordered(assembly: &Assembly) -> Vec<BodyMotion> {
    let wave = |i: usize, phase: f64| (1.7 * i as f64 + phase).sin();
    let motion = |(i, body): (usize, &Body)| match body.fixed {
        true => BodyMotion::default(),
        false => BodyMotion { displacement: Vector::new(wave(i, 0.0), wave(i, 1.0)), rotation: 0.4 * wave(i, 2.0) },
    };
    assembly.bodies.iter().enumerate().map(motion).collect()
}

fn moved(motions: &[BodyMotion], body: usize, coordinate: usize, by: f64) -> Vec<BodyMotion> {
    let mut motions = motions.to_vec();
    match coordinate {
        2 => motions[body].rotation += by,
        i => motions[body].displacement[i] += by,
    }
    motions
}

/// Gradient and second derivatives of the energy agree with finite differences, for arms, hinges, rigid ribs and a load between bodies.
#[test]
fn energy_has_its_derivatives() {
    for text in [finray_fixtures::ARMS_SCENE, finray_fixtures::HINGED_SCENE, finray_fixtures::RIGID_RIBS_SCENE] {
        let finger = finger_of(text);
        let assembly = Assembly::new(&finger, 2, AxialSprings::default()).expect("a lattice");
        let mut loads = Vec::new();
        let position = 0.37 * finger.plate_length_mm(Plate::Front);
        let moment = Load::Node { node: finger.tip(), force: Vector::new(0.3, -1.0), moment_nmm: 7.0 };
        for load in [Load::at_position(position, Vector::new(-0.4, 2.0)), moment] {
            loads.extend(assembly.body_loads(&finger, &load).expect("a load on the finger"));
        }
        let energy = Energy::new(&assembly);
        let motions = disordered(&assembly);
        let here = energy.expand(&motions, &loads, 1.3);
        let mut curvature = nalgebra::DMatrix::<f64>::zeros(energy.unknown_count(), energy.unknown_count());
        for entry in &here.curvature {
            curvature[(entry.row, entry.col)] += entry.val;
            if entry.row != entry.col {
                curvature[(entry.col, entry.row)] += entry.val;
            }
        }
        let scale = curvature.amax();
        for body in 0..assembly.bodies.len() {
            let Some(first) = energy.first_unknown(body) else { continue };
            for coordinate in 0..3 {
                let [above, below] = [DIFFERENCE_STEP, -DIFFERENCE_STEP]
                    .map(|by| energy.expand(&moved(&motions, body, coordinate, by), &loads, 1.3));
                let slope = (above.energy - below.energy) / (2.0 * DIFFERENCE_STEP);
                let gradient = here.gradient[first + coordinate];
                assert!((slope - gradient).abs() < DIFFERENCE_TOLERANCE * scale, "{slope} {gradient}");
                for other in 0..energy.unknown_count() {
                    let slope = (above.gradient[other] - below.gradient[other]) / (2.0 * DIFFERENCE_STEP);
                    let second = curvature[(other, first + coordinate)];
                    assert!((slope - second).abs() < DIFFERENCE_TOLERANCE * scale, "{slope} {second}");
                }
            }
        }
    }
}

/// A clamped chain of springs with L = EI = 1, under a dead force at its end.
fn cantilever(angle_deg: f64, load: f64) -> (Assembly, Vec<BodyLoad>) {
    let mut assembly = Assembly::default();
    let length = 1.0 / CANTILEVER_SEGMENTS as f64;
    let section = Section {
        axial_rigidity_n: CANTILEVER_AXIAL_RIGIDITY,
        bending_rigidity_nmm2: 1.0,
        shear_flexibility: 0.0,
        axis_mm: [0.0; 2],
    };
    let at = |body: usize| Anchor { body, arm: Vector::zeros() };
    for i in 0..=CANTILEVER_SEGMENTS {
        assembly.bodies.push(Body { position: Vector::new(i as f64 * length, 0.0), fixed: i == 0 });
        if i > 0 {
            let ends = [at(i - 1), at(i)];
            let segment = Segment { ends, pinned: [false; 2], direction: Vector::x(), length_mm: length, section };
            assembly.springs.extend(segment.springs(AxialSprings::default()));
        }
    }
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let force = Vector::new(cos, sin) * load;
    let load = BodyLoad { body: CANTILEVER_SEGMENTS, force, share: 1.0, lever: Vector::zeros(), moment_nmm: 0.0 };
    (assembly, vec![load])
}

/// The cantilever agrees with the elastica up to P L^2 / EI = 10, at which the end has rotated by 82 degrees.
#[test]
fn cantilever_is_the_elastica() {
    let rows: Vec<Vec<f64>> = finray_fixtures::ELASTICA
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), 11);
    for row in rows {
        let (assembly, loads) = cantilever(row[1], row[0]);
        let mut motions = vec![BodyMotion::default(); assembly.bodies.len()];
        Energy::new(&assembly).follow(&mut motions, &loads, 0.0, 1.0).expect("an equilibrium");
        let end = motions[CANTILEVER_SEGMENTS];
        let ours = [end.displacement.y, -end.displacement.x, end.rotation];
        for (ours, reference) in ours.into_iter().zip(&row[2..]) {
            assert!((ours - reference).abs() < ELASTICA_TOLERANCE, "{row:?}: {ours} for {reference}");
        }
    }
}

proptest! {
    #![proptest_config(cases(60))]

    /// For small displacements, the lattice of any finger equals a frame of slender beams exactly, under loads at nodes and between nodes.
    #[test]
    fn small_displacements_are_those_of_linear_beams(
        finger in built_finger(), at in 0.0..1.0_f64, angle_deg in -80.0..80.0_f64, position in 0.1..1.0_f64,
    ) {
        let lattice = Lattice::new(&finger, 1).expect("a lattice");
        let beams = |load| statics::solve(&Mesh::key_nodes(&finger), &[load], Kinematics::Linear).expect("a solution");
        let at_node = |force_n: f64| Load::at_node(contact_node(&finger, at), finger.direction(angle_deg) * force_n);
        // The force between nodes is normal to the plate. A force along the plate is not tested between nodes, because its division between two
        // bodies is not exact.
        let position_mm = position * finger.plate_length_mm(Plate::Front);
        let at_position = |force_n: f64| Load::at_position(position_mm, finger.direction(0.0) * force_n);
        for load in [&at_node as &dyn Fn(f64) -> Load, &at_position] {
            let force_n = LINEAR_SHARE * finger.plate_length_mm(Plate::Front) / beams(load(1.0)).largest_displacement_mm();
            let ours = lattice.equilibrium(&[load(force_n)]).expect("an equilibrium");
            let error = shapes_apart(&ours, &beams(load(force_n)));
            let ribs = &finger.description().ribs;
            let bars = ribs.strip.is_none() && ribs.joints == Joints::Hinged;
            prop_assert!(error < if bars { BAR_TOLERANCE } else { LINEAR_TOLERANCE }, "{} {:?}", error, load(force_n));
        }
    }
}

#[test]
fn what_has_no_equilibrium_is_an_error() {
    let lattice = Lattice::new(&paper(), 1).expect("a lattice");
    let load = Load::at_node(NodeId(13), Vector::new(-3000.0, 0.0));
    match lattice.equilibrium(&[load]) {
        Err(LatticeError::NoEquilibrium { converged_fraction }) => assert!((0.0..1.0).contains(&converged_fraction)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn impossible_questions_are_refused() {
    let finger = paper();
    assert_eq!(Lattice::new(&finger, 0), Err(LatticeError::NoSegments));
    assert!(matches!(Lattice::new(&finger, 1_000_000), Err(LatticeError::TooFine { .. })));
    let lattice = Lattice::new(&finger, 1).expect("a lattice");
    let refused = |load| lattice.equilibrium(&[load]).expect_err("no such load");
    assert!(matches!(
        refused(Load::at_node(NodeId(25), Vector::x())),
        LatticeError::Load(LoadError::NodeClamped { .. })
    ));
    assert!(matches!(
        refused(Load::at_node(NodeId(26), Vector::x())),
        LatticeError::Load(LoadError::NodeMissing { .. })
    ));
    assert!(matches!(
        refused(Load::at_position(153.1, Vector::x())),
        LatticeError::Load(LoadError::PositionOffPlate { .. })
    ));
    assert!(matches!(
        refused(Load::at_position(0.0, Vector::x())),
        LatticeError::Load(LoadError::PositionOffPlate { .. })
    ));
    assert_eq!(refused(Load::at_node(NodeId(19), Vector::new(f64::NAN, 0.0))), LatticeError::LoadNotFinite);
}

/// A rib is `near_mm` from the clamps. A physics engine stores positions in the finger's frame, with rounding errors of 1e-14 mm. The springs of
/// segments as short as `near_mm` have a stiffness of 1e9 N/mm or more. In springs of this stiffness, rounding causes forces of up to a hundredth of
/// the load, and residual motion causes larger forces.
#[test]
fn a_rib_next_to_the_clamp_leaves_the_base_its_reaction() {
    for near_mm in [0.05, 0.007, 0.001] {
        let mut description = paper().description().clone();
        description.ribs.positions = RibPositions::Positions(vec![[near_mm; 2], [50.0; 2], [100.0; 2]]);
        let finger = Finger::new(description).expect("a possible finger");
        let lattice = Lattice::new(&finger, 2).expect("a lattice");
        let energy = Energy::new(lattice.assembly());
        let (force, at_mm) = (finger.direction(10.0) * 0.2, 120.0);
        let loads = lattice.body_loads(&[Load::at_position(at_mm, force)]).expect("a load on the finger");
        let mut motions = vec![BodyMotion::default(); lattice.assembly().bodies.len()];
        energy.follow(&mut motions, &loads, 0.0, 1.0).expect("an equilibrium");
        let moment_nmm: f64 = loads.iter().map(|load| moment_of(load, lattice.assembly(), &motions)).sum();
        let kept = |motion: &BodyMotion, rest: Vector| BodyMotion {
            displacement: (rest + motion.displacement) - rest,
            ..*motion
        };
        let rests = lattice.assembly().bodies.iter().map(|body| body.position);
        let rounded: Vec<BodyMotion> = motions.iter().zip(rests).map(|(motion, rest)| kept(motion, rest)).collect();
        let base = energy.stiff_base();
        assert!(base.iter().filter(|is_held| **is_held).count() == 4, "the clamps and the rods next to them");
        let off = |(on_base, on_base_nmm): (Vector, f64)| {
            let arm_nmm = force.norm() * finger.plate_length_mm(Plate::Front);
            ((on_base - force).norm() / force.norm()).max((on_base_nmm - moment_nmm).abs() / arm_nmm)
        };
        let [exact, ours, theirs] =
            [energy.on_bodies(&motions, &base), energy.on_bodies(&rounded, &base), energy.on_clamps(&rounded)].map(off);
        println!(
            "{near_mm} mm: {exact:.1e}, rounded {ours:.1e}, by the clamps alone {theirs:.1e}; clamps exact {:.1e}",
            off(energy.on_clamps(&motions))
        );
        assert!(exact < 1e-6 && ours < 1e-6, "{near_mm} mm: {exact:e}, rounded {ours:e}");
        assert!(theirs > 1e4 * ours, "{near_mm} mm: {theirs:e}");
    }
    // Ordinary fingers have no springs that count as rigid.
    let lattice = Lattice::new(&paper(), 4).expect("a lattice");
    let base = Energy::new(lattice.assembly()).stiff_base();
    assert!(base.iter().zip(&lattice.assembly().bodies).all(|(is_held, body)| *is_held == body.fixed));
}

/// Moment of a load about the origin, at the displaced position of its body, N mm.
fn moment_of(load: &BodyLoad, assembly: &Assembly, motions: &[BodyMotion]) -> f64 {
    let motion = motions[load.body];
    let position = assembly.bodies[load.body].position + motion.displacement;
    position.perp(&load.force) * load.share + motion.carried(load.lever).perp(&load.force) + load.moment_nmm
}
