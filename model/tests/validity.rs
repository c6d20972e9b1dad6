//! Largest strain and share of shear, compared with closed forms, finer meshes and beams with shear.

use finray_model::finger::{Part, Plate};
use finray_model::frame::{FrameLoad, FrameMotion};
use finray_model::sensing::Contact;
use finray_model::statics::Statics;
use finray_model::validity::{
    LARGEST_SHEAR_SHARE, LARGEST_STRAIN, SHEAR_CORRECTION, StrainLimits, Validity, ValidityWarning,
};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, Vector};
use finray_tests::{at_position, paper, paper_scene_with};
use nalgebra::{DMatrix, DVector, SMatrix};

/// Rounding error; linear solutions of the paper's finger have at least twelve correct digits.
const ROUNDING: f64 = 1e-9;

fn solved(mesh: &Mesh, kinematics: Kinematics, loads: &[Load]) -> (Vec<FrameLoad>, FrameMotion) {
    let loads: Vec<_> = loads.iter().map(|load| mesh.frame_load(load).expect("on the finger")).collect();
    let motion = Statics::ladder(mesh, kinematics).equilibrium(&loads).expect("carried").motion;
    (loads, motion)
}

fn examined(mesh: &Mesh, kinematics: Kinematics, loads: &[Load]) -> Validity {
    let (loads, motion) = solved(mesh, kinematics, loads);
    Validity::of(mesh, &motion, kinematics, &loads)
}

fn strain_of(validity: &Validity, part: Part) -> f64 {
    validity.strains.iter().find(|strain| strain.member.part == part).expect("the part deforms").strain
}

/// A finger with a very soft front plate, so that the back plate acts as a cantilever of length 100 mm, depth 10 mm and thickness `thickness_mm`.
fn cantilever(thickness_mm: f64, poissons_ratio: f64) -> Finger {
    let text = format!(
        "name = \"cantilever\"\n[finger]\nbase_width_mm = 100\nfront_length_mm = 141.4213562373095\nback_length_mm = 100\n\
         depth_mm = 10\npoissons_ratio = {poissons_ratio}\n[finger.front]\nthickness_mm = 1e-3\nyoungs_modulus_mpa = 1e-6\n\
         [finger.back]\nthickness_mm = {thickness_mm}\nyoungs_modulus_mpa = 1000\n[finger.ribs]\ncount = 0\njoints = \"rigid\"\n"
    );
    Scene::from_toml(&text).expect("a scene").finger
}

/// Largest share of the load that the soft front plate carries. The ratio of its EA to the back plate's 3 EI / L^2 is below 1e-8.
const SOFT_PLATE: f64 = 1e-6;

/// Cantilever with a load F at its end and E' = E / (1 - nu^2). The strain at the clamp is 6 F L / (b t^2 E'). Shear energy F^2 L / (2 kappa G A)
/// divided by bending energy F^2 L^3 / (6 E' I) is 3 E' I / (kappa G A L^2).
#[test]
fn a_cantilever_has_its_closed_forms() {
    for (thickness, nu) in [(2.0, 0.0), (8.0, 0.45)] {
        let finger = cantilever(thickness, nu);
        let along = (finger.position(finger.tip()) - finger.base(Plate::Back)).normalize();
        let across = Vector::new(-along.y, along.x);
        let (force, length, depth, modulus) = (0.01, 100.0, 10.0, 1000.0);
        for mesh in [Mesh::key_nodes(&finger), Mesh::with_elements_per_member(&finger, 7)] {
            let found = examined(&mesh, Kinematics::Linear, &[Load::at_node(finger.tip(), across * force)]);
            let plane_strain = modulus / (1.0 - nu * nu);
            let strain = 6.0 * force * length / (depth * thickness * thickness * plane_strain);
            assert!((strain_of(&found, Part::Back) / strain - 1.0).abs() < SOFT_PLATE, "{found:?}");
            let (area, inertia) = (depth * thickness, depth * thickness.powi(3) / 12.0);
            let shear_modulus = modulus / (2.0 * (1.0 + nu));
            let share = 3.0 * plane_strain * inertia / (5.0 / 6.0 * shear_modulus * area * length * length);
            assert!((found.shear_share / share - 1.0).abs() < SOFT_PLATE, "{found:?}, expected {share}");
            let at = found.strains.iter().find(|strain| strain.member.part == Part::Back).expect("it strains");
            assert!(at.at_mm.abs() < ROUNDING, "at the clamp: {at:?}");
            assert!((at.member.slenderness - length / thickness).abs() < ROUNDING);
        }
    }
}

/// A plate under a force along its axis has the strain F / (E b t) and no shear.
#[test]
fn a_bar_in_tension_has_its_closed_form() {
    let finger = cantilever(2.0, 0.0);
    let along = (finger.position(finger.tip()) - finger.base(Plate::Back)).normalize();
    let found = examined(&Mesh::key_nodes(&finger), Kinematics::Linear, &[Load::at_node(finger.tip(), along * 5.0)]);
    let back = found.strains.iter().find(|strain| strain.member.part == Part::Back).expect("it strains");
    let strain = 5.0 / (1000.0 * 10.0 * 2.0);
    assert!((back.strain / strain - 1.0).abs() < SOFT_PLATE && (back.axial_strain / strain - 1.0).abs() < SOFT_PLATE);
    assert!(found.shear_share < SOFT_PLATE, "{found:?}");
}

/// Linear frames are exact on any mesh, also with loads inside elements. The strains and energies of linear frames are therefore exact on any mesh.
#[test]
fn linear_strains_do_not_depend_on_the_mesh() {
    let finger = paper_scene_with(&[("depth_mm = 20.0", "depth_mm = 20.0\nrod_arm_mm = 1.0")]).finger;
    let loads = [
        Load::at_position(40.0, finger.direction(-30.0) * 2.0),
        Load::at_position(43.0, finger.direction(10.0) * 1.0),
        Load::at_node(NodeId(16), finger.direction(20.0) * 0.5),
    ];
    let of = |mesh: &Mesh| examined(mesh, Kinematics::Linear, &loads);
    let coarse = of(&Mesh::key_nodes(&finger));
    for fine in [Mesh::with_elements_per_member(&finger, 3), Mesh::with_nodes(&finger, 684).expect("a mesh")] {
        let fine = of(&fine);
        for (a, b) in coarse.strains.iter().zip(&fine.strains) {
            assert!((a.strain / b.strain - 1.0).abs() < ROUNDING, "{a:?} against {b:?}");
            assert!((a.at_mm - b.at_mm).abs() < ROUNDING, "{a:?} against {b:?}");
        }
        assert!((coarse.shear_share / fine.shear_share - 1.0).abs() < ROUNDING);
        assert_eq!(coarse.shear_at.map(|at| at.nodes), fine.shear_at.map(|at| at.nodes));
    }
}

/// Largest relative error of a strain due to the mesh: 5 % on the key nodes, which is a strain of 0.25 % at the limit of 5 %. With the four elements
/// per member that an examination uses, the error is a tenth of the error on the key nodes. The mesh therefore does not decide whether a limit is
/// exceeded.
const ON_KEY_NODES: f64 = 0.05;
const ON_FOUR_ELEMENTS: f64 = 0.005;

#[test]
fn corotational_strains_converge() {
    let finger = paper();
    for node in [14, 19, 24] {
        let load = [Load::at_node(NodeId(node), finger.direction(0.0) * 3.0)];
        let of =
            |elements| examined(&Mesh::with_elements_per_member(&finger, elements), Kinematics::Corotational, &load);
        let fine = of(32);
        let largest = |found: &Validity| found.largest_strain(&StrainLimits::default()).expect("it strains").strain;
        let error = |elements| (largest(&of(elements)) / largest(&fine) - 1.0).abs();
        assert!(error(1) < ON_KEY_NODES && error(4) < ON_FOUR_ELEMENTS, "node {node}: {} and {}", error(1), error(4));
        assert!((of(1).shear_share / fine.shear_share - 1.0).abs() < ON_KEY_NODES);
    }
}

/// Stiffness of a plane beam with shear, exact at its ends, along its own axis: Przemieniecki, Theory of Matrix Structural Analysis (1968),
/// eq. (5.116), with phi = 12 EI / (kappa G A L^2).
fn beam_with_shear(axial: f64, bending: f64, shear: f64, length: f64) -> SMatrix<f64, 6, 6> {
    let phi = 12.0 * bending / (shear * length * length);
    let (a, k) = (axial / length, bending / ((1.0 + phi) * length.powi(3)));
    let (l, near, far) = (length, (4.0 + phi) * length * length, (2.0 - phi) * length * length);
    #[rustfmt::skip]
    let matrix = SMatrix::<f64, 6, 6>::new(
        a, 0.0, 0.0, -a, 0.0, 0.0,
        0.0, 12.0 * k, 6.0 * l * k, 0.0, -12.0 * k, 6.0 * l * k,
        0.0, 6.0 * l * k, near * k, 0.0, -6.0 * l * k, far * k,
        -a, 0.0, 0.0, a, 0.0, 0.0,
        0.0, -12.0 * k, -6.0 * l * k, 0.0, 12.0 * k, -6.0 * l * k,
        0.0, 6.0 * l * k, far * k, 0.0, -6.0 * l * k, near * k,
    );
    matrix
}

/// Work of a force of 1 N on the linear finger made of beams with shear; `shear` multiplies their shear rigidity.
fn work_with_shear(finger: &Finger, node: NodeId, shear: f64) -> f64 {
    let mesh = Mesh::key_nodes(finger);
    let nodes = finger.key_node_count();
    let mut stiffness = DMatrix::<f64>::zeros(3 * nodes, 3 * nodes);
    for member in mesh.frame().members() {
        let beam = &member.beam;
        let shear_rigidity =
            shear * SHEAR_CORRECTION * beam.axial_rigidity_n * (1.0 - finger.description().poissons_ratio) / 2.0;
        let own = beam_with_shear(beam.axial_rigidity_n, beam.bending_rigidity_nmm2, shear_rigidity, beam.length_mm);
        let (c, s) = (beam.direction.x, beam.direction.y);
        let mut turn = SMatrix::<f64, 6, 6>::identity();
        for at in [0, 3] {
            turn.fixed_view_mut::<2, 2>(at, at).copy_from_slice(&[c, -s, s, c]);
        }
        let matrix = turn.transpose() * own * turn;
        let at = |k: usize| 3 * member.ends[k / 3].node + k % 3;
        for row in 0..6 {
            for column in 0..6 {
                stiffness[(at(row), at(column))] += matrix[(row, column)];
            }
        }
    }
    let free = 3..3 * nodes - 3;
    let mut load = DVector::zeros(3 * nodes);
    let force = finger.direction(0.0);
    load.rows_mut(3 * (node.0 - 1), 2).copy_from(&force);
    let load = load.rows(free.start, free.len()).into_owned();
    let stiffness = stiffness.view((free.start, free.start), (free.len(), free.len())).into_owned();
    load.dot(&stiffness.cholesky().expect("held").solve(&load))
}

/// If shear deformation is added to the beams, the compliance of the finger grows by at most the stated share of shear. A small share of shear nearly
/// equals the growth of the compliance, because the section forces hardly change.
#[test]
fn the_share_of_shear_bounds_what_beams_with_shear_add() {
    // If the plates are twice as thick, the share of shear is four times as large, and the bound is less tight.
    for (thickness, tightness) in [("1.5", 0.25), ("0.5", 0.05)] {
        let finger = paper_scene_with(&[("thickness_mm = 1.5", &format!("thickness_mm = {thickness}"))]).finger;
        for node in [13, 14, 17, 19, 21, 24].map(NodeId) {
            let load = [Contact::at_node(node).unit_load(&finger)];
            let stated = examined(&Mesh::key_nodes(&finger), Kinematics::Linear, &load).shear_share;
            let without = work_with_shear(&finger, node, 1e9);
            let added = work_with_shear(&finger, node, 1.0) / without - 1.0;
            assert!(added <= stated * (1.0 + ROUNDING), "node {node}: {added} above {stated}");
            assert!(added >= stated * (1.0 - tightness), "node {node}: {added} far below {stated}");
        }
    }
}

/// The key `shear_correction` gives the finger the stiffness of beams with shear. A force does the same work on this finger as on a finger assembled
/// from `beam_with_shear`.
#[test]
fn a_finger_with_shear_has_the_stiffness_of_beams_with_shear() {
    let keys = "depth_mm = 20.0\npoissons_ratio = 0.45\nshear_correction = 0.8333333333333334";
    let finger = paper_scene_with(&[("depth_mm = 20.0", keys)]).finger;
    for node in [13, 14, 19, 24].map(NodeId) {
        let mesh = Mesh::key_nodes(&finger);
        let (_, motion) = solved(&mesh, Kinematics::Linear, &[Contact::at_node(node).unit_load(&finger)]);
        let work = motion.displacements[mesh.frame_node(node)].dot(&finger.direction(0.0));
        let expected = work_with_shear(&finger, node, 1.0);
        assert!((work / expected - 1.0).abs() < ROUNDING, "node {node}: {work}, expected {expected}");
    }
}

/// Small forces on the paper's finger violate no assumption. If a single assumption fails, exactly this assumption is reported.
#[test]
fn warnings_name_what_fails() {
    let warnings = |scene: &Scene, force_n: f64| {
        let mesh = Mesh::key_nodes(&scene.finger);
        let load = [Load::at_node(NodeId(19), scene.finger.direction(0.0) * force_n)];
        examined(&mesh, Kinematics::Corotational, &load).warnings(&scene.strain_limits)
    };
    assert_eq!(warnings(&paper_scene_with(&[]), 3.0), []);
    assert_eq!(warnings(&paper_scene_with(&[]), 0.0), [], "nothing strains at rest");
    let flat = paper_scene_with(&[("depth_mm = 20.0", "depth_mm = 1.4")]);
    assert!(matches!(warnings(&flat, 0.1)[..], [ValidityWarning::OutOfPlane { .. }]));
    let thick = paper_scene_with(&[("thickness_mm = 1.5", "thickness_mm = 6.0")]);
    assert!(matches!(warnings(&thick, 0.1)[..], [ValidityWarning::Shear { share, .. }] if share > LARGEST_SHEAR_SHARE));
    let soft = paper_scene_with(&[("youngs_modulus_mpa = 47.976", "youngs_modulus_mpa = 25.0")]);
    assert!(matches!(
        warnings(&soft, 3.0)[..],
        [ValidityWarning::Strain { strain, limit: LARGEST_STRAIN, stated: false }] if strain.strain > LARGEST_STRAIN
    ));
    // The paper's finger, with a part made of a material whose strain limit is below or above the strain at 3 N.
    for (name, part) in [("front", Part::Front), ("back", Part::Back), ("ribs", Part::Ribs)] {
        let table = format!("[finger.{name}]");
        let with = |limit| paper_scene_with(&[(&table, &format!("{table}\nlargest_strain = {limit}"))]);
        let found = warnings(&with("1e-4"), 3.0);
        assert!(
            matches!(found[..], [ValidityWarning::Strain { strain, limit: 1e-4, stated: true }] if strain.member.part == part)
        );
        let said = found[0].to_string();
        assert!(said.contains(&format!("finger.{name}.largest_strain of the scene")), "{said}");
        assert_eq!(warnings(&with("0.2"), 3.0), []);
    }
}

/// Undeformable ribs have neither strain nor shear.
#[test]
fn undeformable_ribs_take_no_part() {
    let rigid = paper_scene_with(&[(
        "joints = \"rigid\"\nthickness_mm = 1.5\nyoungs_modulus_mpa = 47.976",
        "joints = \"rigid\"\nrigid = true",
    )])
    .finger;
    let load = [Load::at_node(NodeId(19), rigid.direction(0.0))];
    let found = examined(&Mesh::key_nodes(&rigid), Kinematics::Linear, &load);
    let parts: Vec<Part> = found.strains.iter().map(|strain| strain.member.part).collect();
    assert_eq!(parts, [Part::Front, Part::Back]);
    assert!(found.shear_share > 0.0 && found.shear_at.is_some_and(|at| at.part != Part::Ribs));
}

/// The forces of the paper's gripper experiments (up to 3 N, sec. V-C) satisfy the limits at every contact node except the tip, which the paper does
/// not load. Directions are 20 degrees apart. A force of 5 N along the normal, the largest in the paper's training, exceeds the limits. Within 6 mm
/// of the clamp, the loaded segment of the plate is so short that shear exceeds its limit under any force. `-- --nocapture papers` prints the
/// figures.
#[test]
fn the_papers_finger_keeps_within_the_limits_up_to_three_newtons() {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    let mut warned = Vec::new();
    for force_n in [3.0, 5.0] {
        for node in finger.contact_nodes().skip(1) {
            for angle_deg in [-80.0, -60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0, 80.0] {
                let contact = Contact { angle_deg, ..Contact::at_node(node) };
                let found = examined(&mesh, Kinematics::Corotational, &[contact.load(&finger, force_n)]);
                let most = found.largest_strain(&StrainLimits::default()).expect("it strains");
                println!("{force_n} N at node {node}, {angle_deg} deg: {most}; shear {}", found.shear_share);
                if !found.warnings(&StrainLimits::default()).is_empty() {
                    warned.push((force_n, node.0, angle_deg));
                }
            }
        }
    }
    assert!(warned.iter().all(|(force_n, ..)| *force_n == 5.0), "{warned:?}");
    let along_the_normal: Vec<usize> =
        warned.iter().filter(|(_, _, angle_deg)| *angle_deg == 0.0).map(|(_, node, _)| *node).collect();
    assert_eq!(along_the_normal, (15..=24).collect::<Vec<_>>());
    let shear = |s_mm: f64| {
        let contact = at_position(s_mm, 0.0);
        examined(&mesh, Kinematics::Corotational, &[contact.load(&finger, 0.01)]).shear_share
    };
    assert!(
        shear(4.0) > 0.05 && shear(6.4) > 0.05 && shear(7.5) < 0.05,
        "{} {} {}",
        shear(4.0),
        shear(6.4),
        shear(7.5)
    );
}
