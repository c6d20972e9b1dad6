//! Free side faces, against solids: 150 random fingers of `fixtures/depth`, none of which determined a constant of the model.

use finray_model::finger::{Part, Plate, SideFaces};
use finray_model::validity::Validity;
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, Vector, statics};
use finray_tests::paper;

/// Rounding errors of a rigidity.
const ROUNDING: f64 = 1e-12;

/// Compliance of a finger at a load, as a solid in plane strain and with free side faces, and the finger as a scene without `side_faces`.
struct Solid {
    scene: String,
    load: Load,
    direction: Vector,
    free_to_fixed: f64,
}

/// The rows of `fixtures/depth/fingers.csv`, with arms by the guide's rule.
fn solids() -> Vec<Solid> {
    let rows = include_str!("../../fixtures/depth/fingers.csv").lines().skip(1);
    rows.map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        let number = |cell: usize| -> f64 { cells[cell].parse().expect("a number") };
        let [front_mm, back_mm, ribs_mm, rod_mm] = [4, 5, 6, 7].map(number);
        let mean_mm = 0.5 * (front_mm + back_mm);
        let arms_mm = if rod_mm > 0.0 {
            [(0.06, mean_mm), (0.12, ribs_mm), (0.15, mean_mm)].map(|(c, t): (f64, f64)| (rod_mm * rod_mm - c * t * t).sqrt())
        } else {
            [0.075 * ribs_mm, 0.33 * mean_mm, 0.02 * mean_mm]
        };
        let positions: Vec<String> = cells[10].split(';').map(|rib| format!("[{}]", rib.trim().replace(' ', ", "))).collect();
        let scene = format!(
            "name = \"{}\"\n[finger]\nbase_width_mm = {}\nfront_length_mm = {}\nback_length_mm = {}\ndepth_mm = {}\npoissons_ratio = {}\n\
             shear_correction = 0.8333\nrod_arm_mm = {:?}\nrib_arm_mm = {:?}\nclamp_arm_mm = {:?}\n[finger.front]\nthickness_mm = {front_mm:?}\n\
             youngs_modulus_mpa = 1.0\n[finger.back]\nthickness_mm = {back_mm:?}\nyoungs_modulus_mpa = 1.0\n[finger.ribs]\n\
             positions_mm = [{}]\njoints = \"rigid\"\nthickness_mm = {ribs_mm:?}\nyoungs_modulus_mpa = 1.0\n",
            cells[0], cells[1], cells[2], cells[3], cells[8], cells[9], arms_mm[0], arms_mm[1], arms_mm[2], positions.join(", ")
        );
        let direction = Vector::new(number(12), number(13));
        let load = Load::at_node(NodeId(cells[11].parse().expect("a node")), direction);
        Solid { scene, load, direction, free_to_fixed: number(15) / number(14) }
    })
    .collect()
}

fn finger(scene: &str) -> Finger {
    Scene::from_toml(scene).expect("a scene").finger
}

fn with_free_faces(scene: &str) -> String {
    scene.replace("[finger]\n", "[finger]\nside_faces = \"free\"\n")
}

/// Displacement of the load along its direction, mm, on linear beams.
fn displacement_mm(finger: &Finger, solid: &Solid) -> f64 {
    let mesh = Mesh::key_nodes(finger);
    let shape = statics::solve(&mesh, std::slice::from_ref(&solid.load), Kinematics::Linear).expect("it is linear");
    let Load::Node { node, .. } = solid.load else { panic!("loads act on nodes") };
    shape.motion(node).displacement.dot(&solid.direction)
}

/// The ratio of the compliances with free and with fixed faces is that of the solids within the stated error. Without the key, beams are 9 % too stiff.
#[test]
fn free_faces_agree_with_solids() {
    let mut squares = [Vec::new(), Vec::new()];
    let mut largest = 0.0_f64;
    let mut stated = 0.0;
    for solid in solids() {
        let [fixed, free] = [finger(&solid.scene), finger(&with_free_faces(&solid.scene))];
        stated = free.side_face_error();
        let ratio = displacement_mm(&free, &solid) / displacement_mm(&fixed, &solid);
        let error = ratio / solid.free_to_fixed - 1.0;
        let kind = usize::from(free.description().rod_arm_mm > 0.5);
        squares[kind].push(error * error);
        largest = largest.max(error.abs());
        assert!(solid.free_to_fixed > 1.01, "plane strain alone must not pass: {}", solid.scene);
    }
    let rms = squares.each_ref().map(|squares| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt());
    println!("root mean square error without and with rods {rms:?}, largest {largest}");
    assert_eq!(squares.each_ref().map(Vec::len), [252, 198]);
    // The stated error is that of fingers without rods; with rods, the error is smaller.
    assert!(0.8 * stated < rms[0] && rms[0] <= stated && rms[1] <= rms[0], "{rms:?}");
    assert!(largest < 4.0 * stated, "{largest}");
}

/// A thin finger is in plane stress, a deep one in plane strain; the shear rigidity does not depend on the faces.
#[test]
fn free_faces_lie_between_plane_stress_and_plane_strain() {
    let nu = 0.45;
    let of = |depth_mm: f64, side_faces| {
        let mut description = paper().description().clone();
        (description.depth_mm, description.poissons_ratio, description.side_faces) = (depth_mm, nu, Some(side_faces));
        description.shear_correction = 0.8;
        Finger::new(description).expect("a finger")
    };
    let sections = |depth_mm: f64, side_faces| {
        let finger = of(depth_mm, side_faces);
        let plates = [Plate::Front, Plate::Back].map(|plate| finger.member_section(plate, 3));
        plates.into_iter().chain(finger.rib_section(5)).collect::<Vec<_>>()
    };
    for (depth_mm, factor) in [(1e-6, 1.0 - nu * nu), (1e12, 1.0)] {
        for (free, fixed) in sections(depth_mm, SideFaces::Free).iter().zip(sections(depth_mm, SideFaces::Fixed)) {
            assert!((free.axial_rigidity_n / fixed.axial_rigidity_n / factor - 1.0).abs() < 1e-9);
            assert!((free.bending_rigidity_nmm2 / fixed.bending_rigidity_nmm2 / factor - 1.0).abs() < 1e-9);
            let [sheared, fixed] = [*free, fixed].map(|section| section.axial_rigidity_n / section.shear_flexibility);
            assert!((sheared / fixed - 1.0).abs() < ROUNDING);
        }
    }
    // Rigidities per depth grow with the depth.
    let per_depth = |depth_mm: f64| sections(depth_mm, SideFaces::Free)[0].bending_rigidity_nmm2 / depth_mm;
    let grown: Vec<f64> = [0.1, 1.0, 5.0, 20.0, 60.0, 200.0].into_iter().map(per_depth).collect();
    assert!(grown.is_sorted_by(|a, b| a < b), "{grown:?}");
    assert_eq!(of(20.0, SideFaces::Fixed).section(Part::Front), of(20.0, SideFaces::Free).section(Part::Front));
}

/// Side faces change rigidities, not thicknesses: strains are curvatures times the plates' thickness.
#[test]
fn examined_thicknesses_are_those_of_the_finger() {
    let solid = &solids()[0];
    for scene in [solid.scene.clone(), with_free_faces(&solid.scene)] {
        let finger = finger(&scene);
        let found = Validity::under(&finger, std::iter::empty()).expect("it is at rest");
        let d = finger.description();
        let thickest_mm =
            d.ribs.strip.expect("elastic ribs").thickness_mm.max(d.front.thickness_mm.max(d.back.thickness_mm));
        assert!((found.depth_ratio * thickest_mm / d.depth_mm - 1.0).abs() < ROUNDING, "{}", found.depth_ratio);
    }
}

/// "fixed" is the default, free faces need Poisson's ratio, and their error is a part of the model error.
#[test]
fn the_key_states_its_error_and_its_need() {
    let solid = &solids()[0].scene;
    let scene = |text: &str| Scene::from_toml(text).expect("a scene");
    let fixed = solid.replace("[finger]\n", "[finger]\nside_faces = \"fixed\"\n");
    let sections = |scene: &Scene| [0, 3].map(|member| scene.finger.member_section(Plate::Front, member));
    assert_eq!(sections(&scene(&fixed)), sections(&scene(solid)));
    let share = |scene: &Scene| scene.model_error.share();
    let free = scene(&with_free_faces(solid));
    assert!((share(&free) - share(&scene(solid)).hypot(free.finger.side_face_error())).abs() < ROUNDING);
    let both = scene(&with_free_faces(solid).replace("[finger]\n", "[finger]\nmodel_error = 0.004\n"));
    assert!((share(&both) - 0.004_f64.hypot(free.finger.side_face_error())).abs() < ROUNDING);
    let without: String = with_free_faces(solid)
        .lines()
        .filter(|line| !line.starts_with("poissons_ratio"))
        .map(|line| format!("{line}\n"))
        .collect();
    let refused = Scene::from_toml(&without).expect_err("Poisson's ratio is missing").to_string();
    assert!(
        refused.starts_with("line 3: finger.side_faces: expected poissons_ratio beside free side faces"),
        "{refused}"
    );
}
