//! Arms of fingers of one piece, compared with solids in plane strain that the rule was not fitted to (`fixtures/solids`).

use finray_model::finger::{FingerKind, Part, Plate};
use finray_model::frame::Section;
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::{ContactPosition, ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use finray_model::statics::solve;
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, Vector};
use std::collections::BTreeMap;

/// A unit force on a solid, and the displacements of its nodes, mm.
struct Case {
    load: NodeId,
    angle_deg: f64,
    moved: Vec<(NodeId, Vector)>,
}

/// Rows of a table of `fixtures/solids`, without its head.
fn rows(name: &str) -> Vec<Vec<String>> {
    let path = format!("{}/../fixtures/solids/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a table");
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Scene of a solid, with depth and modulus 1. Without arms, it has neither fillets nor rods.
fn scene_of(row: &[String], with_arms: bool) -> Scene {
    let [_, _, base, front, back, front_t, back_t, rib_t, nu, radius, base_radius, rod, ribs] = row else {
        panic!("{row:?}")
    };
    let ends: Vec<&str> = ribs.split(' ').collect();
    let pairs: Vec<String> = ends.chunks(2).map(|pair| format!("[{}, {}]", pair[0], pair[1])).collect();
    let number = |text: &String| text.parse::<f64>().expect("a number");
    let rod_mm = number(rod);
    let half_chord_mm = |c: f64, t_mm: f64| (rod_mm * rod_mm - c * t_mm * t_mm).sqrt();
    let mean_mm = 0.5 * (number(front_t) + number(back_t));
    let shear = "shear_correction = 0.8333333333333334";
    let keys = match (with_arms, rod_mm > 0.0) {
        (false, _) => shear.to_owned(),
        (true, false) => format!("fillet_mm = {radius}\nbase_fillet_mm = {base_radius}"),
        (true, true) => format!(
            "{shear}\nrod_arm_mm = {:?}\nrib_arm_mm = {:?}\nclamp_arm_mm = {:?}",
            half_chord_mm(0.06, mean_mm),
            half_chord_mm(0.12, number(rib_t)),
            half_chord_mm(0.15, mean_mm)
        ),
    };
    Scene::from_toml(&format!(
        "name = \"solid\"\n[finger]\nbase_width_mm = {base}\nfront_length_mm = {front}\nback_length_mm = {back}\ndepth_mm = 1.0\n\
         youngs_modulus_sigma = 0.0\npoissons_ratio = {nu}\nside_faces = \"fixed\"\n{keys}\n[finger.front]\nthickness_mm = {front_t}\nyoungs_modulus_mpa = 1.0\n\
         [finger.back]\nthickness_mm = {back_t}\nyoungs_modulus_mpa = 1.0\n[finger.ribs]\npositions_mm = [{}]\njoints = \"rigid\"\n\
         thickness_mm = {rib_t}\nyoungs_modulus_mpa = 1.0\n[contact]\n{}\n",
        pairs.join(", "),
        if rod_mm > 0.0 { format!("rod_radius_mm = {rod}") } else { "pad_mm = 0.0".to_owned() }
    ))
    .expect("a scene")
}

/// Cases of each solid, by its number.
fn cases() -> BTreeMap<String, Vec<Case>> {
    let mut solids: BTreeMap<String, Vec<Case>> = BTreeMap::new();
    for row in rows("shapes.csv") {
        let number = |column: usize| row[column].parse::<f64>().expect("a number");
        let (load, angle_deg) = (NodeId(number(1) as usize), number(2));
        let cases = solids.entry(row[0].clone()).or_default();
        if cases.last().is_none_or(|case| (case.load, case.angle_deg) != (load, angle_deg)) {
            cases.push(Case { load, angle_deg, moved: Vec::new() });
        }
        let case = cases.last_mut().expect("a case");
        case.moved.push((NodeId(number(3) as usize), Vector::new(number(4), number(5))));
    }
    solids
}

/// Relative error of the force that fits the shape of the solid best by least squares. Forces act on rods, otherwise on the plate's outer face.
fn force_error(finger: &Finger, case: &Case, has_rods: bool) -> f64 {
    let force = finger.direction(case.angle_deg);
    let half_mm = if has_rods { 0.0 } else { 0.5 * finger.description().front.thickness_mm };
    let moment_nmm = (-half_mm * finger.inward(Plate::Front)).perp(&force);
    let load = Load::Node { node: case.load, force, moment_nmm };
    let shape = solve(&Mesh::key_nodes(finger), &[load], Kinematics::Linear).expect("a shape");
    let beams = case.moved.iter().map(|(node, _)| shape.motion(*node).displacement);
    let sums = beams.zip(&case.moved).fold([0.0; 2], |sums, (u, (_, v))| [sums[0] + u.dot(v), sums[1] + u.dot(&u)]);
    sums[0] / sums[1] - 1.0
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Largest root mean square error of a kind of finger, in stated deviations. Forces of one finger err alike, and a kind has ten fingers: for ten
/// degrees of freedom, a chi-square exceeds 10 x 1.59^2 in 0.5 % of all cases.
const LARGEST_RMS: f64 = 1.59;
/// Least share of all forces whose error is within 1.96 stated deviations. The expected share is 0.95; the share of 100 fingers deviates by 0.022.
const LEAST_HELD: f64 = 0.90;
/// Error of the arms' quadrature, mm.
const QUADRATURE_MM: f64 = 1e-4;

/// Forces on unseen solids err as each finger states. Without arms, forces on fingers with fillets or rods err at least twice as much.
#[test]
fn forces_on_unseen_solids_keep_the_stated_model_error() {
    let cases = cases();
    let mut kinds: BTreeMap<String, [Vec<f64>; 2]> = BTreeMap::new();
    for row in rows("fingers.csv") {
        let [ruled, bare] = [true, false].map(|with_arms| scene_of(&row, with_arms));
        let of_kind = kinds.entry(row[1].clone()).or_default();
        for case in &cases[&row[0]] {
            for (errors, scene) in of_kind.iter_mut().zip([&ruled, &bare]) {
                errors.push(force_error(&scene.finger, case, row[1] == "rods") / ruled.model_error.share());
            }
        }
    }
    assert_eq!(kinds.len(), 10);
    let mut all = Vec::new();
    for (kind, [ruled, bare]) in kinds {
        let held = ruled.iter().filter(|error| error.abs() < 1.96).count() as f64 / ruled.len() as f64;
        println!("{kind}: rms {:.2} sigma, {held:.3} held; without arms rms {:.2} sigma", rms(&ruled), rms(&bare));
        assert!(rms(&ruled) < LARGEST_RMS, "{kind}: {:.2} sigma", rms(&ruled));
        all.extend(ruled.iter().map(|error| f64::from(u8::from(error.abs() < 1.96))));
        let is_filled = kind.contains("fillets") || kind == "short" || kind == "rods";
        assert!(!is_filled || rms(&bare) > 2.0 * rms(&ruled), "{kind}: {:.2} sigma", rms(&bare));
    }
    let held = all.iter().sum::<f64>() / all.len() as f64;
    assert!(held > LEAST_HELD && all.len() == 300, "{held} of {} forces", all.len());
}

/// Share of the front plate's length by which a solid moves: solids are linear.
const SHARE: f64 = 1e-4;

/// Largest root mean square error of a force of unknown direction, by kind of finger. Errors of single kinds are up to 3 % on 400 other solids, and
/// 4.4 % with fillets that meet if axial forces do not bend plates.
const LARGEST_UNKNOWN: f64 = 0.036;

/// Forces of unknown direction on unseen solids lie in their intervals, and err little where no rib is near the base.
#[test]
fn intervals_of_unknown_directions_hold_on_unseen_solids() {
    let cases = cases();
    let (mut held, mut all) = (0, 0);
    let mut kinds: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for row in rows("fingers.csv") {
        let scene = scene_of(&row, true);
        let finger = &scene.finger;
        for case in &cases[&row[0]] {
            let asked = ContactQuestion::new(Some(ContactPosition::Node(case.load)), Direction::Auto);
            let contacts = SensorContacts::Asked(vec![asked]);
            let sensor = Sensor::new(scene.clone(), contacts, SensorOptions::default()).expect("a sensor");
            let largest = case.moved.iter().map(|(_, moved)| moved.norm()).fold(0.0, f64::max);
            let largest_mm = SHARE * finger.plate_length_mm(Plate::Front);
            let force_n = largest_mm / largest;
            let marker =
                |(node, moved): &(NodeId, Vector)| Marker { node: *node, displacement: moved * force_n, weight: 1.0 };
            let measurement = Measurement::new(finger, case.moved.iter().map(marker)).expect("a measurement");
            let sensed = sensor.sense_displacements(&measurement, Some(1e-3 * largest_mm), None).expect("a force");
            let [low_n, high_n] = sensed.forces[0].interval_n();
            kinds.entry(row[1].clone()).or_default().push(sensed.forces[0].force_n / force_n - 1.0);
            held += usize::from(low_n <= force_n && force_n <= high_n);
            all += 1;
        }
    }
    for (kind, errors) in kinds {
        println!("{kind}: {:.2} %", 100.0 * rms(&errors));
        assert!(kind.contains("inclined") || rms(&errors) < LARGEST_UNKNOWN, "{kind}: {}", rms(&errors));
    }
    println!("{held} of {all} forces");
    // A binomial share of 0.94 in 300 cases is below 0.9 in 0.5 % of all cases.
    assert!(held as f64 > 0.9 * f64::from(all) && all == 300, "{held} of {all} forces");
}

const PIECE: &str = "name = \"piece\"\n[finger]\nbase_width_mm = 60.0\nfront_length_mm = 120.0\nback_length_mm = 120.0\ndepth_mm = 20.0\n\
    poissons_ratio = 0.45\nfillet_mm = 0.0\n[finger.front]\nthickness_mm = 2.0\nyoungs_modulus_mpa = 48.0\n\
    [finger.back]\nthickness_mm = 2.0\nyoungs_modulus_mpa = 48.0\n[finger.ribs]\ncount = 5\njoints = \"rigid\"\nthickness_mm = 1.5\n\
    youngs_modulus_mpa = 48.0\n";

/// With sharp corners, the widths grow linearly, and the integrals of the arms are closed forms.
#[test]
fn arms_of_sharp_corners_are_closed_forms() {
    let finger = Scene::from_toml(PIECE).expect("a scene").finger;
    let angle = (30.0_f64 / 120.0).acos();
    let (plate_mm, rib_mm) = (2.0, 1.5);
    let rib_corner_mm = 0.5 * plate_mm / angle.sin();
    let both_sides = rib_mm / 8.0 * (1.0 - (1.0 + 4.0 * rib_corner_mm / rib_mm).powi(-2));
    let rib_arm_mm = rib_corner_mm - both_sides - 0.1 * plate_mm;
    let of_plate = |angle: f64| {
        let corner_mm = 0.5 * (rib_mm + plate_mm * angle.cos()) / angle.sin();
        corner_mm - plate_mm / 0.8 * (1.0 - (1.0 + 0.4 * corner_mm / plate_mm).powi(-2))
    };
    let clamp_arm_mm = (0.021 + 0.29 * 0.05 + 0.26 / angle.tan().powi(2)) * plate_mm;
    let apart = |found: [f64; 2], expected: [f64; 2]| (found[0] - expected[0]).hypot(found[1] - expected[1]);
    assert!(apart(finger.rib_arms_mm(2), [rib_arm_mm; 2]) < QUADRATURE_MM, "{:?}, {rib_arm_mm}", finger.rib_arms_mm(2));
    for plate in [Plate::Front, Plate::Back] {
        let towards_base = of_plate(std::f64::consts::PI - angle);
        let inner = [of_plate(angle), towards_base];
        assert!(
            apart(finger.member_arms_mm(plate, 2), inner) < QUADRATURE_MM,
            "{:?}, {inner:?}",
            finger.member_arms_mm(plate, 2)
        );
        assert!(apart(finger.member_arms_mm(plate, 0), [clamp_arm_mm, towards_base]) < QUADRATURE_MM);
        assert_eq!(finger.member_arms_mm(plate, 5)[1], 0.0);
    }
}

/// With sharp corners, the lengths that tension loses and the elastic axis are closed forms, too: the integrals of 1 - t / w - 12 t e^2 / w^3 and of
/// 12 e / w^3, with a width w that grows linearly, and by 2 e on one face.
#[test]
fn stretching_between_arms_is_a_closed_form() {
    let finger = Scene::from_toml(PIECE).expect("a scene").finger;
    let angle = (30.0_f64 / 120.0).acos();
    let (plate_mm, rib_mm) = (2.0, 1.5);
    let rib_corner_mm = 0.5 * plate_mm / angle.sin();
    let rib_lost_mm = rib_corner_mm - rib_mm / 4.0 * (4.0 * rib_corner_mm / rib_mm).ln_1p() - 0.1 * plate_mm;
    // Length that tension loses, mm, and rotation by an axial force, 1/mm.
    let of_plate = |angle: f64| {
        let corner_mm = 0.5 * (rib_mm + plate_mm * angle.cos()) / angle.sin();
        let widest = 1.0 + 0.4 * corner_mm / plate_mm;
        let beside = 3.0 * (widest.ln() + 2.0 / widest - 0.5 / widest.powi(2) - 1.5);
        let lost_mm = corner_mm - plate_mm / 0.4 * (widest.ln() + beside);
        [lost_mm, 6.0 / (0.4 * plate_mm) * (0.5 - 1.0 / widest + 0.5 / widest.powi(2))]
    };
    let check = |section: Section, whole: Section, arms_mm: [f64; 2], lost_mm: f64, length_mm: f64| {
        let [first_mm, second_mm] = section.axis_mm;
        let mean_square_mm2 = (first_mm * first_mm + first_mm * second_mm + second_mm * second_mm) / 3.0;
        let free_mm = length_mm - arms_mm[0] - arms_mm[1];
        let factor = 1.0 / ((length_mm - lost_mm) / free_mm - 12.0 * mean_square_mm2 / plate_mm.powi(2));
        assert!((section.axial_rigidity_n / whole.axial_rigidity_n - factor).abs() < QUADRATURE_MM / length_mm);
        assert!(factor < 0.999 && section.bending_rigidity_nmm2 == whole.bending_rigidity_nmm2);
    };
    let (rib, plate) = (finger.rib_section(2).expect("it deforms"), finger.member_section(Plate::Front, 2));
    let whole = |part| finger.section(part).expect("it deforms");
    check(rib, whole(Part::Ribs), finger.rib_arms_mm(2), 2.0 * rib_lost_mm, finger.rib_length_mm(2));
    let [[lost_mm, turned], [other_mm, other]] = [of_plate(angle), of_plate(std::f64::consts::PI - angle)];
    let arms_mm = finger.member_arms_mm(Plate::Front, 2);
    check(plate, whole(Part::Front), arms_mm, lost_mm + other_mm, 20.0);
    // The inner face is to the right of the front plate, and to the left of the back plate.
    let by_force = |turned: f64, other: f64| {
        plate_mm.powi(3) / 12.0 * (4.0 * turned - 2.0 * other) / (20.0 - arms_mm[0] - arms_mm[1])
    };
    let axis_mm = [by_force(turned, other), by_force(other, turned)];
    for (plate, sign) in [(Plate::Front, -1.0), (Plate::Back, 1.0)] {
        let found_mm = finger.member_section(plate, 2).axis_mm;
        let apart = |i: usize| (found_mm[i] - sign * axis_mm[i]).abs();
        assert!(apart(0) < QUADRATURE_MM && apart(1) < QUADRATURE_MM && axis_mm[0] > 0.01, "{found_mm:?}, {axis_mm:?}");
    }
}

/// Fillets that meet on the last rib leave an elastic part of each member, and the finger becomes stiffer the larger they are.
#[test]
fn fillets_that_meet_on_the_last_rib_stiffen_the_tip() {
    let compliance = |fillet_mm: f64| {
        let ribs = "positions_mm = [[30.0, 30.0], [60.0, 60.0], [112.0, 112.0]]";
        let scene = PIECE.replace("count = 5", ribs).replace("fillet_mm = 0.0", &format!("fillet_mm = {fillet_mm:?}"));
        let finger = Scene::from_toml(&scene).expect("a scene").finger;
        let node = finger.contact_nodes().nth(1).expect("a node");
        let load = Load::at_node(node, finger.direction(0.0));
        let shape = solve(&Mesh::key_nodes(&finger), &[load], Kinematics::Linear).expect("a shape");
        shape.motion(node).displacement.dot(&finger.direction(0.0))
    };
    let found = [0.5, 1.0, 1.5, 2.0, 3.0].map(compliance);
    assert!(found.is_sorted_by(|a, b| a > b) && found[4] > 0.0, "{found:?}");
}

/// The refusal names the largest radius: it fits, and a larger one does not.
#[test]
fn the_largest_radius_fits() {
    let with =
        |fillet_mm: f64| Scene::from_toml(&PIECE.replace("fillet_mm = 0.0", &format!("fillet_mm = {fillet_mm:?}")));
    let message = with(9.0).expect_err("too large").message;
    let largest_mm = message.split("at most ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a radius");
    let largest_mm: f64 = largest_mm.parse().expect("a number");
    assert!(with(largest_mm).is_ok() && with(largest_mm + 0.002).is_err(), "{message}");
}

/// A rib's own fillets replace those of the plates at its ends.
#[test]
fn each_rib_can_have_its_own_fillets() {
    let with = |ribs: &str| {
        let scene = PIECE.replace("fillet_mm = 0.0", "fillet_mm = 1.0") + ribs;
        Scene::from_toml(&scene).map(|scene| scene.finger)
    };
    let (alike, own) =
        (with("").expect("a finger"), with("fillet_mm = [1.0, 1.0, 0.2, 1.0, 1.0]\n").expect("a finger"));
    for rib in 0..5 {
        let [before, after] = [&alike, &own].map(|finger| finger.rib_arms_mm(rib));
        assert_eq!(rib == 2, after[0] < before[0] - 0.2 && after[1] < before[1] - 0.2, "{before:?}, {after:?}");
    }
    let message = with("fillet_mm = [1.0]\n").expect_err("one of five").message;
    assert_eq!(message, "finger.ribs.fillet_mm: expected one radius for each of 5 ribs, found 1 values");
    let both = PIECE.replace("[finger.front]\n", "[finger.front]\nfillet_mm = 1.0\n") + "fillet_mm = 1.0\n";
    let message = Scene::from_toml(&both).expect_err("two radii").message;
    assert!(
        message.starts_with("finger.front.fillet_mm: expected either this key or fillet_mm of the ribs"),
        "{message}"
    );
    let message = Scene::from_toml(&both.replace("fillet_mm = 0.0\n", "").replacen("fillet_mm = 1.0\n", "", 1))
        .expect_err("alone")
        .message;
    assert!(message.starts_with("finger.ribs.fillet_mm: expected finger.fillet_mm beside it"), "{message}");
}

/// Larger fillets stiffen the finger, each plate by its own.
#[test]
fn each_fillet_lengthens_the_arms_of_its_plate() {
    let with = |more: &str| {
        Scene::from_toml(&PIECE.replace(
            "thickness_mm = 2.0\nyoungs_modulus_mpa = 48.0\n[finger.back]",
            &format!("thickness_mm = 2.0\n{more}youngs_modulus_mpa = 48.0\n[finger.back]"),
        ))
        .expect("a scene")
        .finger
    };
    let (sharp, round) = (with(""), with("fillet_mm = 1.0\n"));
    let [before, after] = [&sharp, &round].map(|finger| finger.rib_arms_mm(1));
    assert!(after[0] > before[0] + 0.3 && after[1] == before[1], "{before:?}, {after:?}");
    let longer = |plate| round.member_arms_mm(plate, 1)[1] - sharp.member_arms_mm(plate, 1)[1];
    assert!(longer(Plate::Front) > 0.05 && longer(Plate::Back) == 0.0);
}

#[test]
fn fillets_beside_what_they_exclude_are_refused() {
    let refused = |from: &str, to: &str| Scene::from_toml(&PIECE.replace(from, to)).expect_err(to).message;
    for (from, to, expected) in [
        (
            "fillet_mm = 0.0",
            "fillet_mm = 1.0\nrod_arm_mm = 0.1",
            "finger.fillet_mm: expected no fillets beside rod_arm_mm",
        ),
        (
            "fillet_mm = 0.0",
            "fillet_mm = 1.0\nclamp_arm_mm = 0.0",
            "finger.fillet_mm: expected no fillets beside rod_arm_mm",
        ),
        (
            "\"rigid\"",
            "\"hinged\"",
            "finger.fillet_mm: expected no fillets beside hinged joints, brackets and undeformable ribs",
        ),
        (
            "joints = \"rigid\"\nthickness_mm = 1.5\nyoungs_modulus_mpa = 48.0",
            "joints = \"rigid\"\nrigid = true",
            "finger.fillet_mm: expected no fillets beside hinged joints",
        ),
        ("fillet_mm = 0.0", "fillet_mm = 9.0", "finger.fillet_mm: expected at most "),
        ("fillet_mm = 0.0", "fillet_mm = -1.0", "finger.fillet_mm: expected a length in mm, zero or more"),
        (
            "fillet_mm = 0.0\n[finger.front]",
            "[finger.front]\nfillet_mm = 1.0",
            "finger.front.fillet_mm: expected fillet_mm in [finger]",
        ),
    ] {
        let message = refused(from, to);
        assert!(message.starts_with(expected), "{message}");
    }
}

/// Fillets state shear and model error, unless the scene states its own; a scene without fillets keeps neither. Stated arms state a model error if the
/// scene also has shear and Poisson's ratio.
#[test]
fn fillets_and_arms_state_shear_and_model_error() {
    let read = |to: &str| Scene::from_toml(&PIECE.replace("fillet_mm = 0.0", to)).expect("a scene");
    let figures = |to: &str| [read(to).finger.description().shear_correction, read(to).model_error.share()];
    assert_eq!(figures("fillet_mm = 0.0"), [5.0 / 6.0, FingerKind::OnePiece.model_error()]);
    assert_eq!(figures("fillet_mm = 0.0\nshear_correction = 0.0\nmodel_error = 0.01"), [0.0, 0.01]);
    assert_eq!(figures(""), [0.0, 0.0]);
    let kind = |to: &str| read(to).model_error.kind;
    assert_eq!(kind("rod_arm_mm = 1.2"), FingerKind::Beams);
    assert_eq!(kind("rod_arm_mm = 1.2\nshear_correction = 0.8"), FingerKind::Rods);
    assert_eq!(kind("rib_arm_mm = 0.7\nshear_correction = 0.8"), FingerKind::StatedArms);
    assert_eq!(kind("fillet_mm = 1.0"), FingerKind::FilletedBase);
    assert_eq!(kind("fillet_mm = 1.0\nbase_fillet_mm = 0.0"), FingerKind::OnePiece);
}

/// Fillets that leave less than two thicknesses of the first plate member free join an inclined rib to the base: forces on this solid err by 10 %
/// (`fixtures/solids/unseen.py`, inclined base fillets, seed 62, rounded).
#[test]
fn fillets_join_an_inclined_rib_to_the_base() {
    let row = |fillet: f64| {
        let row = [
            "", "inclined", "45.4", "89.8", "89.8", "2.52", "2.79", "2.23", "0.35", "F", "F", "0",
            "32.8 9.03 57.7 37.1",
        ];
        row.map(|cell| cell.replace('F', &fillet.to_string())).to_vec()
    };
    let kind = |fillet: f64| scene_of(&row(fillet), true).model_error.kind;
    assert_eq!(kind(2.46), FingerKind::RibNearBase);
    assert_eq!(kind(0.3), FingerKind::InclinedRibs);
}
