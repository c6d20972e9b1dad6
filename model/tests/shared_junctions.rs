//! Ribs that share a junction or end in a corner of the base: two key nodes at one point have the same motion.

use finray_model::estimators::EstimatorId;
use finray_model::finger::{BracketLengths, FingerPoint, Plate, RibPositions};
use finray_model::frame::{FrameLoad, PlaneFrame};
use finray_model::measurement::{Marker, Measurement, MeasurementError};
use finray_model::mesh::{FingerShape, LoadError};
use finray_model::sensing::{Contact, ContactPosition, NonlinearEstimator, SensingError};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use finray_model::statics::{Statics, equilibria, reaction, solve, solve_frame};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, Vector};
use finray_tests::{KINEMATICS, motions_apart, shapes_apart};

/// Ribs 1 to 6 meet end to end, from the back corner of the base upwards. The fifteen key nodes lie at nine points: two corners, six junctions and
/// the tip.
const ZIGZAG: &[[f64; 2]] = &[[25.0, 0.0], [25.0, 42.0], [55.0, 42.0], [55.0, 80.0], [84.0, 80.0], [84.0, 116.0]];
/// Three ribs meet at one point of each plate, and two ribs meet in the front corner.
const FANS: &[[f64; 2]] = &[[0.0, 30.0], [0.0, 55.0], [40.0, 55.0], [60.0, 55.0], [60.0, 90.0], [60.0, 115.0]];

fn finger_with(ribs: &[[f64; 2]], joints: &str, plates_mm: f64) -> Finger {
    let plate = |name: &str| format!("[finger.{name}]\nthickness_mm = {plates_mm}\nyoungs_modulus_mpa = 50.0\n");
    let scene = format!(
        "name = \"zigzag\"\n[finger]\nbase_width_mm = 60.0\nfront_length_mm = 120.0\nback_length_mm = 150.0\n\
         depth_mm = 20.0\n{}{}[finger.ribs]\npositions_mm = {ribs:?}\njoints = \"{joints}\"\nthickness_mm = 1.25\n\
         youngs_modulus_mpa = 50.0\n",
        plate("front"),
        plate("back")
    );
    Scene::from_toml(&scene).expect("a sound scene").finger
}

fn zigzag(joints: &str) -> Finger {
    finger_with(ZIGZAG, joints, 1.0)
}

/// The same finger built by hand: one frame node per point, beams between the nodes, and no ties. Also returns the frame node of each key node.
fn by_hand(finger: &Finger, joints: &str) -> (PlaneFrame, Vec<usize>) {
    let mut frame = PlaneFrame::default();
    let mut points: Vec<Vector> = Vec::new();
    let nodes: Vec<usize> = (1..=finger.key_node_count())
        .map(|node| {
            let at = finger.position(NodeId(node));
            points.iter().position(|other| *other == at).unwrap_or_else(|| {
                points.push(at);
                frame.add_node(at)
            })
        })
        .collect();
    for node in finger.clamped_nodes() {
        frame.support(nodes[node.0 - 1], [true; 3]);
    }
    for plate in [Plate::Front, Plate::Back] {
        let section = finger.section(plate.into()).expect("plates deform");
        for pair in finger.plate_nodes(plate).windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|node| nodes[node.0 - 1]);
            if from != to {
                frame.add_beam(from, to, section);
            }
        }
    }
    for rib in 0..finger.rib_count() {
        let ends = finger.rib_nodes(rib).map(|node| nodes[node.0 - 1]);
        let mut ends = ends.map(|node| frame.clamped_end(node));
        if joints == "hinged" {
            ends.iter_mut().for_each(|end| end.rotation = frame.add_rotation());
        }
        frame.add_member(ends, finger.rib_section(rib).expect("ribs deform"));
    }
    (frame, nodes)
}

/// The ladder solver, the sparse solver and the solution of a frame built by hand without ties agree. Results of a batch equal those of the ladder
/// solver bit for bit.
#[test]
fn tied_nodes_are_one_node_of_a_frame_by_hand() {
    for (ribs, joints) in [(ZIGZAG, "rigid"), (ZIGZAG, "hinged"), (FANS, "rigid"), (FANS, "hinged")] {
        let finger = finger_with(ribs, joints, 1.0);
        let (hand, nodes) = by_hand(&finger, joints);
        let mesh = Mesh::key_nodes(&finger);
        for (kinematics, tolerance) in KINEMATICS.into_iter().zip([1e-9, 1e-7, 1e-7]) {
            for node in [finger.tip(), finger.rib_nodes(3)[0], finger.rib_nodes(4)[1], finger.rib_nodes(2)[1]] {
                let force = finger.direction(15.0) * 0.2;
                let case = format!("{ribs:?} {joints} {kinematics:?} {node}");
                let load = FrameLoad::Node { node: nodes[node.0 - 1], force, moment_nmm: 2.0 };
                let expected = solve_frame(&hand, &[load], kinematics).expect("by hand");
                let load = mesh.frame_load(&Load::Node { node, force, moment_nmm: 2.0 }).expect("a free node");
                let ladder = Statics::ladder(&mesh, kinematics).equilibrium(&[load]).expect("ladder");
                let sparse = Statics::sparse(mesh.frame(), kinematics).equilibrium(&[load]).expect("sparse");
                assert!(motions_apart(&ladder.motion, &sparse.motion) < tolerance, "{case}");
                let expected = FingerShape::new(&finger, false, |node| {
                    let at = nodes[node.0 - 1];
                    (expected.displacements[at], expected.rotations[hand.rotation_of(at)])
                });
                let apart = shapes_apart(&mesh.shape(&ladder.motion), &expected);
                assert!(apart < tolerance, "{case}: {apart:e}");
                let loads = vec![vec![load]; 3];
                for batch in equilibria(&mesh, kinematics, &loads) {
                    assert_eq!(batch.as_ref().map(|found| &found.motion), Ok(&ladder.motion), "{case}");
                }
            }
        }
    }
}

/// On refined meshes with clips and rods, the ladder solver agrees with the sparse solver, and the supports carry the load. Supports include the ends
/// of ribs in the corners.
#[test]
fn refined_zigzags_are_in_equilibrium_with_their_supports() {
    let force = Vector::new(-0.02, -0.1);
    for ribs in [ZIGZAG, FANS] {
        for joints in ["rigid", "hinged"] {
            let mut description = finger_with(ribs, joints, 1.0).description().clone();
            (description.rod_arm_mm, description.ribs.clip_mm) = (0.5, [2.0, 1.0]);
            (description.rib_arm_mm, description.clamp_arm_mm) = (Some(0.8), Some(0.2));
            let finger = Finger::new(description).expect("room for clips");
            let mesh = Mesh::with_elements_per_member(&finger, 3);
            assert_eq!(mesh.node_count() - 2, mesh.frame().node_count(), "the base line has two inner nodes");
            let (node, at_mm) = (finger.rib_nodes(3)[0], 0.7 * finger.plate_length_mm(Plate::Front));
            let loads = [Load::at_node(node, force), Load::at_position(at_mm, force)];
            let loads = loads.map(|load| mesh.frame_load(&load).expect("on the finger"));
            let ladder = Statics::ladder(&mesh, Kinematics::Corotational).equilibrium(&loads).expect("ladder");
            let sparse = Statics::sparse(mesh.frame(), Kinematics::Corotational).equilibrium(&loads).expect("sparse");
            assert!(motions_apart(&ladder.motion, &sparse.motion) < 1e-7);
            let held = finger.clamped_nodes().map(|clamp| {
                reaction(mesh.frame(), &ladder.motion, Kinematics::Corotational, &loads, mesh.frame_node(clamp)).force
            });
            assert!((held[0] + held[1] + force * 2.0).norm() < 1e-6, "{ribs:?} {joints}: {held:?}");
        }
    }
}

/// If ribs end at a small distance from each other instead of at one junction, the displacements change in proportion to this distance.
#[test]
fn near_junctions_converge_to_the_shared_one() {
    let shared = zigzag("rigid");
    let load = |finger: &Finger| Load::at_position(70.0, finger.direction(-10.0) * 0.15);
    for kinematics in [Kinematics::Linear, Kinematics::Corotational] {
        let found = solve(&Mesh::key_nodes(&shared), &[load(&shared)], kinematics).expect("carried");
        let off = [1e-1, 1e-2, 1e-3, 1e-4].map(|gap_mm| {
            let mut description = shared.description().clone();
            let apart = ZIGZAG.iter().enumerate().map(|(rib, [front, back])| match rib % 2 {
                0 => [*front, *back + if rib == 0 { 0.0 } else { gap_mm }],
                _ => [*front + gap_mm, *back],
            });
            description.ribs.positions = RibPositions::Positions(apart.collect());
            let near = Finger::new(description).expect("ribs apart");
            let near = solve(&Mesh::key_nodes(&near), &[load(&near)], kinematics).expect("carried");
            shapes_apart(&near, &found)
        });
        println!("{kinematics:?}: {off:?}");
        for pair in off[..3].windows(2) {
            assert!((8.0..12.5).contains(&(pair[0] / pair[1])), "{kinematics:?}: {off:?}");
        }
        assert!(off[3] < 3e-5, "{kinematics:?}: {off:?}");
    }
}

/// If the plates hardly resist bending, a hinged zigzag is a truss, and the method of joints applies. The plates are straight. At the loaded
/// junction, one rib carries the component of the force across the plate: the rib that leads towards the base. The ribs above carry no force.
#[test]
fn ribs_of_a_hinged_zigzag_carry_what_statics_says() {
    let finger = finger_with(ZIGZAG, "hinged", 1e-3);
    let mesh = Mesh::key_nodes(&finger);
    // The highest junction, on the back plate, belongs to rib 6 alone. The next junction, on the front plate, belongs to ribs 5 and 6, and so on to
    // rib 1.
    for (loaded, plate) in [(5, Plate::Back), (4, Plate::Front), (3, Plate::Back), (0, Plate::Front)] {
        let node = finger.rib_nodes(loaded)[usize::from(plate == Plate::Back)];
        let force = Vector::new(0.3, -0.2);
        let shape = solve(&mesh, &[Load::at_node(node, force)], Kinematics::Linear).expect("a truss");
        let pull_n = |rib: usize| {
            let [front, back] = finger.rib_nodes(rib).map(|node| shape.motion(node));
            let along = (front.position - back.position).normalize();
            let rigidity_n = finger.rib_section(rib).expect("it deforms").axial_rigidity_n;
            (front.displacement - back.displacement).dot(&along) / finger.rib_length_mm(rib) * rigidity_n
        };
        // From the loaded junction towards the base, each rib transfers the component across the plate to the next rib.
        let mut across_n = force.dot(&finger.inward(plate));
        let mut side = plate;
        for rib in (0..finger.rib_count()).rev() {
            let [front, back] = finger.rib_nodes(rib).map(|node| finger.position(node));
            let towards_back = (back - front).normalize();
            let away = if side == Plate::Front { towards_back } else { -towards_back };
            let expected_n = if rib > loaded {
                0.0
            } else {
                // The pull of the rib follows from equilibrium across the plate at the rib's upper end.
                let pull_n = -across_n / away.dot(&finger.inward(side));
                side = if side == Plate::Front { Plate::Back } else { Plate::Front };
                across_n = pull_n * -away.dot(&finger.inward(side));
                pull_n
            };
            let off = (pull_n(rib) - expected_n).abs();
            assert!(off < 1e-5, "load at {node}, rib {}: {} N, expected {expected_n} N", rib + 1, pull_n(rib));
        }
    }
}

/// If two key nodes lie at one point, a force at either node is recovered exactly. Contacts at two key nodes of one point are refused as the same
/// contact.
#[test]
fn forces_come_back_at_shared_junctions() {
    let finger = zigzag("rigid");
    let mesh = Mesh::key_nodes(&finger);
    let [lower, upper] = [finger.rib_nodes(2)[0], finger.rib_nodes(3)[0]];
    let force_n = 0.2;
    for (pressed, asked) in [(lower, upper), (upper, lower), (finger.tip(), finger.tip())] {
        let load = Contact::at_node(pressed).load(&finger, force_n);
        let shape = solve(&mesh, &[load], Kinematics::Corotational).expect("carried");
        // The measurement has one row for every key node, as in a complete table.
        let rows = shape.motions().iter().map(|m| Marker { node: m.node, displacement: m.displacement, weight: 1.0 });
        let measurement = Measurement::new(&finger, rows).expect("every key node");
        assert_eq!(measurement.coordinate_count(), 2 * 7, "each point once");
        assert_eq!(measurement, Measurement::of_shape(&finger, &shape));
        let mut estimator = NonlinearEstimator::new(&mesh, &[Contact::at_node(asked).into()]).expect("a contact");
        let found = estimator.estimate(&measurement, None).expect("identifiable").forces.forces_n[0];
        assert!((found / force_n - 1.0).abs() < 1e-8, "{pressed} as {asked}: {found}");
    }
    let both = [lower, upper].map(|node| Contact::at_node(node).into());
    assert!(matches!(NonlinearEstimator::new(&mesh, &both), Err(SensingError::SameContact { first: 1, second: 2 })));
}

/// The end of a rib in a corner is clamped: it accepts no load, contact or marker. A moving marker at a clamped end of a rib is refused, because it
/// must belong to another node.
#[test]
fn ends_in_a_corner_are_clamped() {
    let finger = finger_with(FANS, "rigid", 1.0);
    let [corner, _] = finger.rib_nodes(1);
    let mesh = Mesh::key_nodes(&finger);
    assert_eq!(finger.junction(corner), finger.clamped_nodes()[1]);
    let load = Load::at_node(corner, Vector::x());
    assert_eq!(mesh.frame_load(&load), Err(LoadError::NodeClamped { node: corner }));
    let contact = NonlinearEstimator::new(&mesh, &[Contact::at_node(corner).into()]);
    assert!(matches!(contact, Err(SensingError::Load(LoadError::NodeClamped { node })) if node == corner));
    assert!(finger.contact_nodes().chain(finger.free_nodes()).all(|node| node != corner) && !finger.has_marker(corner));
    let marker = |ux: f64| Marker { node: corner, displacement: Vector::new(ux, 0.0), weight: 1.0 };
    assert_eq!(Measurement::new(&finger, [marker(0.0)]), Ok(Measurement::empty()));
    let moved = Measurement::new(&finger, [marker(0.5)]);
    assert_eq!(moved, Err(MeasurementError::ClampedMoves { node: corner }));
    let shape = solve(&mesh, &[Load::at_node(finger.tip(), Vector::new(0.0, -0.3))], Kinematics::Corotational);
    assert_eq!(shape.expect("carried").point(FingerPoint::Node(corner)), finger.base(Plate::Front));
}

/// One point has one displacement. If two nodes lie at one point, equal rows of these nodes count once, and rows that contradict each other are
/// refused.
#[test]
fn contradicting_rows_of_one_point_are_refused() {
    let finger = zigzag("rigid");
    let [lower, upper] = [finger.rib_nodes(2)[0], finger.rib_nodes(3)[0]];
    let row = |node: NodeId, ux: f64| Marker { node, displacement: Vector::new(ux, 1.0), weight: 1.0 };
    for nodes in [[lower, upper], [upper, lower]] {
        let one = Measurement::new(&finger, [row(nodes[0], 0.2), row(nodes[1], 0.2)]).expect("one point");
        assert_eq!(one.markers(), [row(lower, 0.2)]);
        let two = Measurement::new(&finger, [row(nodes[0], 0.2), row(nodes[1], 0.3)]);
        assert_eq!(two, Err(MeasurementError::SharedMoves { node: nodes[1] }));
    }
    let twice = Measurement::new(&finger, [row(finger.tip(), 0.2), row(finger.tip(), 0.2)]);
    assert_eq!(twice, Err(MeasurementError::Repeated { node: finger.tip() }));
}

/// Ribs that cross, coincide or lie on the base line are refused with their keys. Brackets and rigid ribs at shared junctions are also refused.
#[test]
fn what_cannot_share_a_junction_is_refused_by_its_key() {
    let refused = |change: &dyn Fn(&mut finray_model::finger::FingerDescription)| {
        let mut description = zigzag("rigid").description().clone();
        change(&mut description);
        Finger::new(description).expect_err("no finger").to_string()
    };
    let positions = |ribs: &[[f64; 2]]| {
        let ribs = ribs.to_vec();
        refused(&|d| d.ribs.positions = RibPositions::Positions(ribs.clone()))
    };
    for (ribs, words) in [
        (&[[30.0, 40.0], [20.0, 60.0]][..], "do not cross"),
        (&[[30.0, 40.0], [30.0, 40.0]], "rib 2 at [30.0, 40.0] mm lies on the previous rib"),
        (&[[0.0, 0.0], [30.0, 40.0]], "lies on the base line"),
        (&[[30.0, 40.0], [30.0 + 1e-9, 60.0]], "or exactly at the same position"),
        (&[[-1.0, 40.0]], "from 0 to below 120.0 mm"),
        (&[[120.0, 40.0]], "from 0 to below 120.0 mm"),
    ] {
        let error = positions(ribs);
        assert!(error.starts_with("finger.ribs.positions_mm: ") && error.contains(words), "{error}");
    }
    let brackets = refused(&|d| d.ribs.bracket_mm = BracketLengths::Alike([2.0, 2.0]));
    assert!(brackets.starts_with("finger.ribs.bracket_mm: expected no brackets where"), "{brackets}");
    let rigid = refused(&|d| d.ribs.strip = None);
    assert!(rigid.starts_with("finger.ribs.rigid: expected false where"), "{rigid}");
}

/// The measurement of a buckled finger contradicts the linear finger and the computed error of linearisation. When the interval followed from the
/// residual alone, 2 N were once sensed as 49.8 +- 7.5 N.
#[test]
fn intervals_of_linear_estimates_hold_on_a_buckled_finger() {
    let finger = zigzag("rigid");
    let fine = Mesh::with_elements_per_member(&finger, 8);
    let contact = Contact { position: ContactPosition::at(14.5833), angle_deg: -40.0 };
    let force_n = 2.0;
    let shape = solve(&fine, &[contact.load(&finger, force_n)], Kinematics::Corotational).expect("an equilibrium");
    let seen = Measurement::of_shape(&finger, &shape);
    let options = SensorOptions::of(EstimatorId::LeastSquares);
    let sensor = Sensor::new(Scene::of_finger(finger.clone()), SensorContacts::known(&[contact]), options);
    let sensed = sensor.expect("one contact").sense_displacements(&seen, Some(0.067), None).expect("an estimate");
    let sigma_n = sensed.forces[0].sigma_n;
    let error_n = sensed.forces[0].force_n - force_n;
    assert!(!sensed.warnings.is_empty() && error_n.abs() > 10.0, "the linear finger is far off: {error_n} N");
    assert!(error_n.abs() < 1.96 * sigma_n, "{error_n} +- {sigma_n} N");
}
