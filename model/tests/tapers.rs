//! Plates of linearly varying thickness, compared with closed forms.

use finray_model::finger::{Part, Plate};
use finray_model::frame::{FrameLoad, PlaneFrame, Section};
use finray_model::measurement::Measurement;
use finray_model::sensing::network::Fingerprint;
use finray_model::sensing::{Contact, sense_refining};
use finray_model::statics::{solve, solve_frame};
use finray_model::{Finger, Kinematics, Load, Mesh, Scene, Vector};
use finray_tests::shapes_apart;

const ROUNDING: f64 = 1e-12;
const MODULUS_MPA: f64 = 47.976;
const DEPTH_MM: f64 = 20.0;

/// The paper's finger with another front plate, other ribs, and further tables at the end. `front` contains the thickness at the base and may contain
/// the thickness at the tip.
fn scene(front: &str, ribs: &str, more: &str) -> Result<Scene, finray_model::scene::SceneError> {
    let plate = "thickness_mm = 1.5\n";
    let text =
        finray_fixtures::PAPER_SCENE.replacen(plate, &format!("{front}\n"), 1).replace("count = 11", ribs) + more;
    Scene::from_toml(&text)
}

fn finger(front: &str, ribs: &str, more: &str) -> Finger {
    scene(front, ribs, more).expect("a sound scene").finger
}

/// Length, mm, and section of each element of the front plate, in order.
fn front_elements(mesh: &Mesh) -> Vec<(f64, Section)> {
    let front = mesh.lines().iter().filter(|line| line.part == Part::Front);
    let beams = front.flat_map(|line| &mesh.frame().members()[line.members.clone()]).map(|member| member.beam);
    let of = |beam: finray_model::element::Beam| Section {
        axial_rigidity_n: beam.axial_rigidity_n,
        bending_rigidity_nmm2: beam.bending_rigidity_nmm2,
        shear_flexibility: 0.0,
        axis_mm: [0.0; 2],
    };
    beams.map(|beam| (beam.length_mm, of(beam))).collect()
}

/// Displacement and rotation of the free end under a force and a moment on this end. The front plate is a cantilever along x, clamped at its base.
fn cantilever(finger: &Finger, elements: usize, force: Vector, moment_nmm: f64) -> (Vector, f64) {
    let mut frame = PlaneFrame::default();
    let mut node = frame.add_node(Vector::zeros());
    frame.support(node, [true; 3]);
    let mut x_mm = 0.0;
    for (length_mm, section) in front_elements(&Mesh::with_elements_per_member(finger, elements)) {
        x_mm += length_mm;
        let next = frame.add_node(Vector::new(x_mm, 0.0));
        frame.add_beam(node, next, section);
        node = next;
    }
    let load = FrameLoad::Node { node, force, moment_nmm };
    let motion = solve_frame(&frame, &[load], Kinematics::Linear).expect("a cantilever");
    (motion.displacements[node], motion.rotations[frame.rotation_of(node)])
}

/// Stretching, and bending by a moment, are exact on any mesh, because each element has the mean compliance of its length. The closed forms are P
/// ln(t_1 / t_0) / (E d k) and 6 M (t_0 + t_1) L / (E d t_0^2 t_1^2). Under a transverse force P, the closed form is 12 P / (E d k^3) (ln(t_1 / t_0)
/// + 2 (1 - t_1 / t_0) - (1 - t_1^2 / t_0^2) / 2), with k = (t_1 - t_0) / L. The error falls with the square of the elements' length.
#[test]
fn a_tapered_cantilever_bends_as_its_closed_form() {
    for (base_mm, tip_mm) in [(2.0_f64, 1.0_f64), (1.0, 2.5), (1.5, 1.5 + 1e-7)] {
        let finger = finger(&format!("thickness_mm = {base_mm}\ntip_thickness_mm = {tip_mm}"), "count = 0", "");
        let (length_mm, rigidity) = (finger.plate_length_mm(Plate::Front), MODULUS_MPA * DEPTH_MM);
        let slope = (tip_mm - base_mm) / length_mm;
        let (ratio, log) = (tip_mm / base_mm, ((tip_mm - base_mm) / base_mm).ln_1p());
        let (stretched, _) = cantilever(&finger, 3, Vector::new(1.0, 0.0), 0.0);
        assert!((stretched.x / (log / (rigidity * slope)) - 1.0).abs() < 1e-9, "{stretched}");
        let (_, turned) = cantilever(&finger, 3, Vector::zeros(), 1.0);
        let expected = 6.0 * (base_mm + tip_mm) * length_mm / (rigidity * (base_mm * tip_mm).powi(2));
        assert!((turned / expected - 1.0).abs() < 1e-9, "{turned} {expected}");
        if ratio - 1.0 < 1e-3 && ratio > 1.0 {
            continue;
        }
        let by_parts = log + 2.0 * (1.0 - ratio) - 0.5 * (1.0 - ratio * ratio);
        let expected = 12.0 / (rigidity * slope.powi(3)) * by_parts;
        let errors = [4, 8, 16, 32].map(|elements| {
            let (moved, _) = cantilever(&finger, elements, Vector::new(0.0, 1.0), 0.0);
            moved.y / expected - 1.0
        });
        println!("{base_mm} to {tip_mm} mm: {errors:?}");
        for pair in errors.windows(2) {
            assert!((3.6..4.4).contains(&(pair[0] / pair[1])), "{errors:?}");
        }
        assert!(errors[3].abs() < 2e-3, "{errors:?}");
    }
}

/// Zones and a taper multiply. An element within a zone has the zone's factor. An element that contains the border of a zone has the sum of the
/// compliances of both parts.
#[test]
fn zones_of_a_tapered_plate_are_weighted_by_its_compliance() {
    let front = "thickness_mm = 2.0\ntip_thickness_mm = 1.0";
    let zone = |to_mm: f64| {
        format!("\n[[finger.zone]]\nplate = \"front\"\nfrom_mm = 0.0\nto_mm = {to_mm}\nmodulus_factor = 0.25\n")
    };
    let compliances = |more: &str| -> [f64; 2] {
        let (_, section) = front_elements(&Mesh::key_nodes(&finger(front, "count = 0", more)))[0];
        [1.0 / section.axial_rigidity_n, 1.0 / section.bending_rigidity_nmm2]
    };
    let (plain, whole, half) = (compliances(""), compliances(&zone(153.0)), compliances(&zone(76.5)));
    // Integrals of 1 / t and 1 / t^3 from 2 to 1.5 mm, as shares of the integrals from 2 to 1 mm.
    let shares = [(2.0_f64 / 1.5).ln() / 2.0_f64.ln(), (1.0 / 2.25 - 0.25) / (1.0 - 0.25)];
    for i in 0..2 {
        assert!((whole[i] / plain[i] - 4.0).abs() < ROUNDING);
        assert!((half[i] / plain[i] - (1.0 + 3.0 * shares[i])).abs() < 1e-9, "{half:?} {plain:?}");
    }
}

/// A taper to the same thickness changes no bit of the result. For a network, a finger with a taper to another thickness is another finger.
#[test]
fn a_taper_without_slope_is_none() {
    let [plain, level, tapered] = ["", "\ntip_thickness_mm = 1.5", "\ntip_thickness_mm = 1.4"]
        .map(|tip| finger(&format!("thickness_mm = 1.5{tip}"), "count = 11", ""));
    let load = Load::at_position(90.0, plain.direction(10.0) * 1.5);
    let shape = |finger: &Finger| solve(&Mesh::key_nodes(finger), &[load], Kinematics::Corotational).expect("carried");
    assert_eq!(shape(&plain), shape(&level));
    assert!(shapes_apart(&shape(&plain), &shape(&tapered)) > 1e-3);
    assert_eq!(Fingerprint::of(&plain), Fingerprint::of(&level));
    assert_ne!(Fingerprint::of(&plain), Fingerprint::of(&tapered));
    assert!(!level.tapers(Plate::Front) && tapered.tapers(Plate::Front) && !tapered.tapers(Plate::Back));
    assert!((tapered.thickness_mm(Plate::Front, 76.5) - 1.45).abs() < ROUNDING);
}

/// A tapered finger converges as its mesh is refined, and a force is recovered from the fine mesh.
#[test]
fn a_tapered_finger_converges_and_senses() {
    let finger = finger("thickness_mm = 1.5\ntip_thickness_mm = 0.75", "count = 11", "");
    let contact = Contact { angle_deg: 10.0, ..Contact::at_node(finger.rib_nodes(6)[0]) };
    let under = |elements: usize, kinematics| {
        let mesh = Mesh::with_elements_per_member(&finger, elements);
        solve(&mesh, &[contact.load(&finger, 1.5)], kinematics).expect("carried")
    };
    let fine = under(32, Kinematics::Linear);
    let errors = [1, 2, 4].map(|elements| shapes_apart(&under(elements, Kinematics::Linear), &fine));
    println!("one, two, four elements a member: {errors:?}");
    assert!(errors.windows(2).all(|pair| (3.5..4.5).contains(&(pair[0] / pair[1]))), "{errors:?}");
    assert!(errors[0] < 5e-3, "{errors:?}");
    let seen = Measurement::of_shape(&finger, &under(16, Kinematics::Corotational));
    let found = sense_refining(&finger, &[contact.into()], None, &seen, Some(0.01), None).expect("identifiable");
    assert!((found.forces.forces_n[0] / 1.5 - 1.0).abs() < 1e-3, "{}", found.forces.forces_n[0]);
}

/// The outline of a tapered plate is not parallel to its middle line. A scene with an object and a tapered front plate is therefore refused, with key
/// and line.
#[test]
fn objects_on_a_tapered_front_plate_are_refused() {
    let object =
        "\n[object]\nshape = \"box\"\nwidth_mm = 40.0\nheight_mm = 20.0\nat_mm = 76.5\ntravel_mm = 12.0\nsteps = 6\n";
    scene("thickness_mm = 1.5", "count = 11", object).expect("one thickness");
    let refused = scene("thickness_mm = 1.5\ntip_thickness_mm = 1.0", "count = 11", object).expect_err("a taper");
    assert!(
        refused.message.starts_with("finger.front.tip_thickness_mm: expected a front plate of constant"),
        "{refused}"
    );
    assert!(scene("thickness_mm = 1.5\ntip_thickness_mm = 0.0", "count = 11", "").is_err());
}
