//! Shapes from other programs as the true finger.

use crate::exports::mujoco::exported;
use finray_model::Finger;
use finray_model::keys::{BACK, CONTACT, FINGER, FRONT, RIBS, SceneTable, ZONE};
use finray_model::sensing::Contact;
use finray_model::{NodeId, Scene};
use finray_studies::exports::{Program, calculix, mujoco};
use finray_studies::truths::{ExportedTruth, NotExported, Truth, TruthError, TruthId};
use finray_tests::{finger_of, paper, random_stream};
use rand::{Rng, RngExt};
use std::collections::BTreeSet;

fn mujoco_truth(finger: &Finger) -> Result<ExportedTruth, NotExported> {
    ExportedTruth::new(TruthId::Mujoco, &mujoco::PROGRAM, &Scene::of_finger(finger.clone()))
}

#[test]
fn mujoco_as_truth_answers_for_what_was_exported_alone() {
    let truth = mujoco_truth(&paper()).expect("the paper's finger was exported");
    let (positions, angles) = truth.positions(&[3.0]).expect("exported").expect("not everywhere");
    assert_eq!(positions.len(), 12);
    assert_eq!(angles, [-60.0, -30.0, 0.0, 30.0, 60.0]);
    let contact = Contact { angle_deg: -30.0, ..Contact::at_node(NodeId(19)) };
    let case = exported("paper").cases().expect("a table");
    let case = case.iter().find(|c| (c.node, c.angle_deg, c.force_n) == (NodeId(19), -30.0, 3.0)).expect("the case");
    assert_eq!(truth.shapes(&contact, &[1.0, 3.0])[1], case.shape);
    assert_eq!(truth.shapes(&contact, &[1.0, 2.0]).len(), 1);
    assert!(truth.shapes(&Contact { angle_deg: -31.0, ..contact }, &[1.0]).is_empty());
    assert!(matches!(
        truth.positions(&[3.0, 2.0]),
        Err(TruthError::NotExported(TruthId::Mujoco, NotExported::Force { .. }))
    ));
    let steel = finger_of(finray_fixtures::SPRING_STEEL_SCENE);
    assert!(matches!(mujoco_truth(&steel), Err(NotExported::Finger { .. })));
    assert!(
        mujoco_truth(&paper().with_modulus_factor(1.2).expect("a finger")).is_err(),
        "MuJoCo's springs have the scene's stiffness"
    );
}

#[test]
fn a_continuum_answers_for_what_was_exported_alone() {
    let truth =
        ExportedTruth::new(TruthId::Continuum, &calculix::PROGRAM, &scene(finray_fixtures::CONTINUUM_PAPER_SCENE))
            .expect("the paper's finger");
    let (positions, angles) = truth.positions(&[0.5, 1.0, 3.0, 5.0]).expect("exported").expect("not everywhere");
    assert_eq!((positions.len(), angles), (12, vec![-40.0, -20.0, 0.0, 20.0, 40.0]));
    assert_eq!(truth.shapes(&Contact::at_node(NodeId(19)), &[0.5, 1.0, 3.0, 5.0]).len(), 4);
    assert!(truth.positions(&[2.0]).is_err());
    // CalculiX found no equilibrium of this finger under 5 N at the middle of the plate.
    let thin = scene(finray_fixtures::CONTINUUM_THIN_SCENE);
    let truth = ExportedTruth::new(TruthId::Continuum, &calculix::PROGRAM, &thin).expect("the thin finger");
    assert_eq!(truth.shapes(&Contact::at_node(NodeId(18)), &[0.5, 1.0, 3.0, 5.0]).len(), 3);
}

/// Keys of the beam model. The scripts that exported the continua do not read these keys.
const BEAMS_ALONE: [&str; 4] =
    ["finger.rod_arm_mm", "finger.rib_arm_mm", "finger.clamp_arm_mm", "finger.shear_correction"];
/// Keys that describe no property of the finger: stated errors, limits and objects. Maps and sweeps hand only the finger and the errors of its model
/// and stiffness to the sensor.
const NO_PROPERTY: [&str; 6] = [
    "model_error", "youngs_modulus_sigma", "depth_sigma_mm", "thickness_sigma", "modulus_per_thickness",
    "largest_strain",
];

fn scene(text: &str) -> Scene {
    Scene::from_toml(text).expect("a scene")
}

/// Whether the shapes of an export change with a key.
fn matters(program: &Program, table: &str, key: &str) -> bool {
    let path = format!("{table}.{key}");
    let is_rod = path == "contact.rod_radius_mm";
    match table {
        "contact" => is_rod && program.name == "CalculiX",
        _ if NO_PROPERTY.contains(&key) => false,
        _ => program.name == "MuJoCo" || !BEAMS_ALONE.contains(&path.as_str()),
    }
}

/// Multiplies a number, or one of the numbers in a list, by a random factor; swaps a word. `None` for other values.
fn changed(value: &toml::Value, chance: &mut impl Rng) -> Option<toml::Value> {
    let factor: f64 = chance.random_range(0.9..0.99);
    Some(match value {
        toml::Value::Float(number) if *number != 0.0 => (number * factor).into(),
        toml::Value::Float(_) => (1.0 - factor).into(),
        toml::Value::Integer(count) => (count + 1).into(),
        toml::Value::Boolean(word) => (!word).into(),
        toml::Value::String(word) if word == "hinged" => "rigid".into(),
        toml::Value::String(_) => "hinged".into(),
        toml::Value::Array(list) => {
            let mut list = list.clone();
            let at = chance.random_range(0..list.len());
            list[at] = changed(&list[at], chance)?;
            list.into()
        }
        _ => return None,
    })
}

/// The keys of a table of a scene, or of the first of several tables; the table is added if the scene lacks it.
fn keys_of<'t>(scene: &'t mut toml::Table, path: &str) -> &'t mut toml::Table {
    path.split('.').fold(scene, |outer, name| {
        let inner = outer.entry(name).or_insert_with(|| toml::Table::new().into());
        let inner = if let toml::Value::Array(all) = inner { &mut all[0] } else { inner };
        inner.as_table_mut().expect("a table")
    })
}

/// The shapes of an export answer for a scene that differs in one key only if they do not depend on this key; otherwise the refusal names the key. A
/// scene without rods was once answered with the shapes of a finger with rods, and nu = 0.3 with those of nu = 0.45.
#[test]
fn each_key_of_a_scene_is_harmless_or_refused_by_name() {
    let tables: [&dyn SceneTable; 6] = [&FINGER, &FRONT, &BACK, &RIBS, &ZONE, &CONTACT];
    // Values of keys that a scene does not state; a key takes those that its kind reads.
    let new: [toml::Value; 6] =
        [0.013.into(), 0.7.into(), vec![0.21, 0.34].into(), true.into(), "hinged".into(), "undeformed".into()];
    let chance = &mut random_stream(6501, 0);
    let programs = [&mujoco::PROGRAM, &calculix::PROGRAM];
    let exported = programs.iter().flat_map(|program| program.fingers.iter().map(move |exported| (*program, exported)));
    let (mut harmless, mut refused) = (BTreeSet::new(), BTreeSet::new());
    for (program, exported) in exported {
        assert_eq!(program.export_of(&exported.scene().expect("a scene")).map(|it| it.name), Some(exported.name));
        let text: toml::Table = exported.text().parse().expect("TOML");
        for table in tables {
            for key in table.entries().into_iter().map(|entry| entry.name) {
                let mut mutated = text.clone();
                let candidates = match keys_of(&mut mutated, table.path()).get(key) {
                    Some(value) => changed(value, chance).into_iter().collect(),
                    None => new.to_vec(),
                };
                let read = candidates.into_iter().find_map(|candidate| {
                    keys_of(&mut mutated, table.path()).insert(key.to_owned(), candidate);
                    Scene::from_toml(&mutated.to_string()).ok()
                });
                let Some(read) = read else { continue };
                // Undeformable ribs have neither thickness nor material.
                let rigid = read.finger.rib_count() > 0 && read.finger.description().ribs.strip.is_none();
                if rigid && table.path() == "finger.ribs" && ["thickness_mm", "youngs_modulus_mpa"].contains(&key) {
                    continue;
                }
                let path = format!("{}.{key}", table.path());
                match ExportedTruth::new(TruthId::Continuum, program, &read) {
                    Ok(_) => {
                        assert!(!matters(program, table.path(), key), "{} {}: {path}", program.name, exported.name);
                        harmless.insert(path);
                    }
                    Err(error) => {
                        let message = error.to_string();
                        let named = if table.path() == "finger.zone" { "finger.zone" } else { &path };
                        assert!(matters(program, table.path(), key), "{} {}: {message}", program.name, exported.name);
                        assert!(message.contains(named) && message.contains("expected"), "{path}: {message}");
                        refused.insert(path);
                    }
                }
            }
        }
    }
    println!("harmless: {harmless:?}\nrefused: {refused:?}");
    assert!(refused.len() >= 24, "{refused:?}");
    let scripts = ["finger.py", "generate.py", "ccx.py"].map(|file| {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/calculix");
        std::fs::read_to_string(format!("{folder}/{file}")).expect("a script")
    });
    for key in BEAMS_ALONE {
        assert!(harmless.contains(key) && refused.contains(key), "{key}: harmless to continua, but not to beams");
        let name = key.trim_start_matches("finger.");
        assert!(scripts.iter().all(|script| !script.contains(name)), "the continua depend on {key}");
    }
}

/// The default radius of rods is that of the paper, 1.5 mm; the continuum has rods of 1.25 mm. All moduli times a factor, or the same positions of
/// ribs in other words.
#[test]
fn an_exported_finger_is_recognised_by_its_values() {
    let continuum = |scene: &Scene| calculix::PROGRAM.export_of(scene).map(|export| export.name);
    let printed = finray_fixtures::CONTINUUM_PAPER_SCENE;
    assert_eq!(continuum(&scene(printed)), Some("paper"));
    assert_eq!(continuum(&scene(finray_fixtures::PAPER_SCENE)), None, "neither Poisson's ratio nor rods of the export");
    assert_eq!(continuum(&scene(&printed.replace("47.976", "59.97"))), None, "another modulus of all parts");
    let of_rods =
        |radius_mm: &str| continuum(&scene(&printed.replace("radius_mm = 1.25", &format!("radius_mm = {radius_mm}"))));
    assert_eq!((of_rods("0.0"), of_rods("3.0")), (Some("paper-plain"), None));
    let positions: Vec<String> = (1..=11).map(|rib| format!("[{0}, {0}]", 12.75 * f64::from(rib))).collect();
    let positions = format!("positions_mm = [{}]", positions.join(", "));
    assert_eq!(continuum(&scene(&printed.replace("count = 11", &positions))), Some("paper"));
}
