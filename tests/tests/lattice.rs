//! The finger as rigid bodies and springs: its energy, its settling, and that beams agree with it.

use finray_model::finger::{Joints, Plate};
use finray_model::frame::Section;
use finray_model::mesh::{Load, LoadError};
use finray_model::sensing::{Contact, ContactPlace};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Scene, Vector, statics};
use finray_tests::{cases, contact_node, finger, paper};
use finray_verify::check::Check;
use finray_verify::lattice::accuracy::{LoadGrid, difference, study};
use finray_verify::lattice::bodies::{Anchor, Assembly, Body, BodyLoad};
use finray_verify::lattice::energy::{BodyMotion, Energy};
use finray_verify::lattice::settling::{Precision, Settling};
use finray_verify::lattice::springs::{AxialSprings, Segment};
use finray_verify::lattice::{Lattice, LatticeError, causes, settling};
use finray_verify::problems::lattice;
use finray_verify::truths::{LatticeTruth, MeshTruth, Truth, fine_mesh};
use proptest::prelude::*;

/// Central differences over a step of 1e-5 err by its square times the third derivative, and by rounding over the step.
const DIFFERENCE_STEP: f64 = 1e-5;
const DIFFERENCE_TOLERANCE: f64 = 1e-7;
/// A finger whose nodes move by this share of its length is linear, even if they hardly move where it bends between them.
const LINEAR_SHARE: f64 = 1e-15;
const LINEAR_TOLERANCE: f64 = 1e-6;
/// With stiff bars for undeformable ribs: they stretch a tenth as much as plates do, which shows where little but stretching
/// moves the nodes.
const BAR_TOLERANCE: f64 = 2e-3;
/// Settling against the lattice's own equilibrium, as a share of the largest displacement.
const SETTLING_TOLERANCE: f64 = 5e-4;
/// Segments of the cantilever. Its chain of springs bends as an arc does but for the fourth power of their turns.
const CANTILEVER_SEGMENTS: usize = 16;
const ELASTICA_TOLERANCE: f64 = 2e-4;
/// EA L^2 / EI of the cantilever: the reference does not stretch; this one does by 1e-5 at the largest load.
const CANTILEVER_AXIAL_RIGIDITY: f64 = 1e6;

fn scene(text: &str) -> Finger {
    Scene::from_toml(text).expect("fixture scene").finger
}

fn all_pass(checks: &[Check]) {
    assert!(!checks.is_empty());
    for check in checks {
        assert!(check.passes(), "{check:?}");
    }
}

/// A lattice whose bodies all stand somewhere else, in no order.
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

/// Gradient and second derivatives of the energy are its differences, with arms, hinges, rigid ribs and a load between bodies.
#[test]
fn energy_has_its_derivatives() {
    for text in [finray_fixtures::ARMS_SCENE, finray_fixtures::HINGED_SCENE, finray_fixtures::RIGID_RIBS_SCENE] {
        let finger = scene(text);
        let assembly = Assembly::new(&finger, 2, AxialSprings::default()).expect("a lattice");
        let mut loads = Vec::new();
        let place = 0.37 * finger.plate_length_mm(Plate::Front);
        let moment = Load::Node { node: finger.tip(), force: Vector::new(0.3, -1.0), moment_nmm: 7.0 };
        for load in [Load::at_place(place, Vector::new(-0.4, 2.0)), moment] {
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

/// A clamped chain of springs under a dead force at its end, with L = EI = 1.
fn cantilever(angle_deg: f64, load: f64) -> (Assembly, Vec<BodyLoad>) {
    let mut assembly = Assembly::default();
    let length = 1.0 / CANTILEVER_SEGMENTS as f64;
    let section = Section { axial_rigidity_n: CANTILEVER_AXIAL_RIGIDITY, bending_rigidity_nmm2: 1.0 };
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

/// Against the elastica up to P L^2 / EI = 10, where the end has turned by 82 degrees.
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

/// Beams, linear theory, settling and repetition, as in the report.
#[test]
fn paper_finger_is_that_of_beams() {
    let checks = lattice::checks(&paper()).expect("every load has an equilibrium");
    // Six forces, linear theory, settling, two forces settled, bits.
    assert_eq!(checks.len(), 11);
    all_pass(&checks);
}

/// Beyond small forces linear theory must part from the lattice: by more than a tenth at 5 N.
#[test]
fn linear_beams_part_from_the_lattice() {
    let comparisons = lattice::comparisons(&paper()).expect("every load has an equilibrium");
    assert!(comparisons.windows(2).all(|pair| pair[0].ours < pair[1].ours), "{comparisons:?}");
    assert!(comparisons.last().is_some_and(|last| last.ours > 0.1), "{comparisons:?}");
}

/// The error falls with the fourth power of the segments' length: by more than ten when they are halved.
#[test]
fn finer_lattices_are_nearer_to_beams() {
    let finger = paper();
    let grid = LoadGrid { nodes: vec![NodeId(22)], angles_deg: vec![-30.0], forces_n: vec![3.0] };
    let rows = study(&finger, &[2, 4], &grid, |_| None).expect("equilibria");
    assert!(rows[1].bodies > rows[0].bodies && rows[1].springs > rows[0].springs);
    assert!(rows[1].errors[0] * 10.0 < rows[0].errors[0], "{rows:?}");
}

/// What the lattice rests on is what a segment of beam asks for: other axial springs are farther off, and none hold nothing.
#[test]
fn axial_springs_must_be_those_of_a_beam() {
    let finger = paper();
    let nodes = vec![NodeId(14), NodeId(23)];
    let grid = LoadGrid { nodes, angles_deg: vec![-60.0, 60.0], forces_n: vec![0.1, 3.0] };
    let rows = causes::axial(&finger, 2, &grid).expect("equilibria");
    let [beams, at_ends, rigid, none] = &rows[..] else { panic!("{rows:?}") };
    let error = |row: &causes::AxialRow| row.errors.as_ref().expect("an equilibrium")[1];
    assert!(error(beams) * 3.0 < error(at_ends), "{rows:?}");
    // Stretching is no matter of large rotations: without it even the smallest displacement is far off.
    assert!(error(rigid) > 0.2 && rigid.errors.as_ref().expect("an equilibrium")[0] > 0.2, "{rows:?}");
    assert_eq!(none.errors, None);
}

/// More sweeps rest nearer to the equilibrium, until only the end of the settling is left; single precision is farther off.
#[test]
fn few_sweeps_and_single_precision_rest_elsewhere() {
    let finger = paper();
    let lattice = Lattice::new(&finger, 2).expect("a lattice");
    let grid = LoadGrid { nodes: vec![NodeId(14)], angles_deg: vec![-50.0], forces_n: vec![5.0] };
    let rows = causes::settling(&lattice, &grid).expect("an equilibrium");
    let error = |sweeps: usize, positions: Precision| {
        let row = rows.iter().find(|row| row.sweeps == sweeps && row.positions == positions).expect("a row");
        row.error.expect("it settles")
    };
    let [few, more, usual] = [8, 16, settling::SWEEPS].map(|sweeps| error(sweeps, Precision::Double));
    assert!(few > 5.0 * more && more > 2.0 * usual && usual < SETTLING_TOLERANCE, "{rows:?}");
    assert!(error(settling::SWEEPS, Precision::Single) > 3.0 * usual, "{rows:?}");
    let [double, single] = [Precision::Double, Precision::Single]
        .map(|positions| causes::out_of_balance(&lattice, &grid, positions).expect("an equilibrium"));
    assert!(double < 1e-9 && single > 1e-5, "{double} {single}");
}

/// Arms, zones, hinges and ribs that do not deform: settled, the lattice rests where its energy is least, and beams agree.
#[test]
fn other_fingers_settle_where_beams_are() {
    for (text, force_n, tolerance) in [
        (finray_fixtures::SPRING_STEEL_SCENE, 1.0, 2e-4),
        (finray_fixtures::ARMS_SCENE, 1.0, 1e-3),
        (finray_fixtures::ASYMMETRIC_SCENE, 0.3, 3e-3),
        (finray_fixtures::HINGED_SCENE, 1.0, 1e-3),
        (finray_fixtures::HINGED_RIGID_SCENE, 1.0, 1e-3),
        (finray_fixtures::RIGID_RIBS_SCENE, 0.5, 2e-3),
    ] {
        let finger = scene(text);
        let lattice = Lattice::new(&finger, 2).expect("a lattice");
        let load = Load::at_node(contact_node(&finger, 0.5), finger.direction(20.0) * force_n);
        let settled = lattice.settle(&[load]).expect("it settles");
        let equilibrium = lattice.equilibrium(&[load]).expect("an equilibrium");
        assert!(settled.residual <= settling::AT_REST);
        assert!(difference(&equilibrium, &settled.shape) < SETTLING_TOLERANCE);
        let beams = Mesh::with_elements_per_member(&finger, 16);
        let beams = statics::solve(&beams, &[load], Kinematics::Corotational).expect("an equilibrium");
        let error = difference(&beams, &settled.shape);
        assert!(error < tolerance, "{error}: {text}");
    }
}

proptest! {
    #![proptest_config(cases(60))]

    /// For small displacements the lattice is a frame of slender beams, exactly: any finger, at nodes and between them.
    #[test]
    fn small_displacements_are_those_of_linear_beams(
        finger in finger(), at in 0.0..1.0_f64, angle_deg in -80.0..80.0_f64, place in 0.1..1.0_f64,
    ) {
        let lattice = Lattice::new(&finger, 1).expect("a lattice");
        let beams = |load| statics::solve(&Mesh::key_nodes(&finger), &[load], Kinematics::Linear).expect("a solution");
        let at_node = |force_n: f64| Load::at_node(contact_node(&finger, at), finger.direction(angle_deg) * force_n);
        // Across the plate: along it, a place between two bodies is shared as across.
        let place_mm = place * finger.plate_length_mm(Plate::Front);
        let at_place = |force_n: f64| Load::at_place(place_mm, finger.direction(0.0) * force_n);
        for load in [&at_node as &dyn Fn(f64) -> Load, &at_place] {
            let force_n = LINEAR_SHARE * finger.plate_length_mm(Plate::Front) / beams(load(1.0)).largest_displacement_mm();
            let ours = lattice.equilibrium(&[load(force_n)]).expect("an equilibrium");
            let error = difference(&beams(load(force_n)), &ours);
            let ribs = &finger.description().ribs;
            let bars = ribs.strip.is_none() && ribs.joints == Joints::Hinged;
            prop_assert!(error < if bars { BAR_TOLERANCE } else { LINEAR_TOLERANCE }, "{} {:?}", error, load(force_n));
        }
    }
}

/// Unlike loads at once, a moment and a force between nodes among them.
#[test]
fn several_loads_settle_together() {
    let finger = paper();
    let lattice = Lattice::new(&finger, 2).expect("a lattice");
    let loads = [
        Load::at_node(NodeId(16), finger.direction(-20.0) * 1.5),
        Load::at_place(55.0, finger.direction(30.0) * 1.0),
        Load::Node { node: NodeId(6), force: Vector::zeros(), moment_nmm: 12.0 },
    ];
    let settled = lattice.settle(&loads).expect("it settles").shape;
    let beams = statics::solve(&Mesh::with_elements_per_member(&finger, 16), &loads, Kinematics::Corotational);
    let error = difference(&beams.expect("an equilibrium"), &settled);
    assert!(error < 3e-3, "{error}");
}

#[test]
fn what_does_not_settle_is_an_error() {
    let lattice = Lattice::new(&paper(), 2).expect("a lattice");
    let load = Load::at_node(NodeId(19), Vector::new(0.0, -2.0));
    let within = |most_steps| Settling { most_steps, ..Settling::default() };
    match lattice.settle_as(&[load], within(900)) {
        Err(LatticeError::NotSettled { steps, residual }) => {
            assert!(steps <= 900 && residual > settling::AT_REST && residual.is_finite());
        }
        other => panic!("{other:?}"),
    }
    // Not even the first peak.
    assert!(matches!(
        lattice.settle_as(&[load], within(3)),
        Err(LatticeError::NotSettled { residual, .. }) if residual.is_infinite()
    ));
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
    assert!(matches!(refused(Load::at_place(153.1, Vector::x())), LatticeError::Load(LoadError::PlaceOffPlate { .. })));
    assert!(matches!(refused(Load::at_place(0.0, Vector::x())), LatticeError::Load(LoadError::PlaceOffPlate { .. })));
    assert_eq!(refused(Load::at_node(NodeId(19), Vector::new(f64::NAN, 0.0))), LatticeError::LoadNotFinite);
}

/// Without loads it rests at once, where it was.
#[test]
fn an_unloaded_finger_stays() {
    let settled = Lattice::new(&paper(), 2).expect("a lattice").settle(&[]).expect("it rests");
    assert!(settled.shape.largest_displacement_mm() < 1e-9 && settled.steps < 100);
}

/// The third finger of the maps, at places between nodes as well, is that of beams.
#[test]
fn lattice_truth_is_that_of_beams() {
    let finger = paper();
    let truth = LatticeTruth::new(&finger).expect("a lattice");
    assert_eq!(truth.name(), "lattice");
    let mesh = fine_mesh(&finger).expect("a mesh");
    let beams = MeshTruth::new("corotational", &mesh, Kinematics::Corotational).expect("prepared");
    for (s_mm, angle_deg) in [(40.0, -60.0), (101.0, 0.0), (130.3, 45.0), (153.0, 10.0)] {
        let contact = Contact { place: ContactPlace::Place(s_mm), angle_deg };
        let (ours, theirs) = (truth.shapes(&contact, &[0.5, 3.0]), beams.shapes(&contact, &[0.5, 3.0]));
        assert_eq!(ours.len(), 2);
        for (a, b) in theirs.iter().zip(&ours) {
            assert!(difference(a, b) < 5e-4, "{s_mm} {angle_deg} {}", difference(a, b));
        }
    }
}

/// No finer or coarser lattice settles elsewhere than its equilibrium, and a small force is no exception.
#[test]
fn every_fineness_settles_where_its_energy_is_least() {
    let finger = paper();
    for (fineness, force_n) in [(1, 4.0), (3, 0.02)] {
        let lattice = Lattice::new(&finger, fineness).expect("a lattice");
        let load = Load::at_node(NodeId(17), finger.direction(-60.0) * force_n);
        let settled = lattice.settle(&[load]).expect("it settles").shape;
        let error = difference(&lattice.equilibrium(&[load]).expect("an equilibrium"), &settled);
        assert!(error < SETTLING_TOLERANCE, "{error}");
    }
}
