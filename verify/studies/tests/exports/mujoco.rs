//! Tests of the fingers solved by MuJoCo: tables and manifest agree, and contact forces balance, obey friction and are sensed.
//!
//! `fixtures/mujoco/README.md` states how the files were made and how accurate they are.

use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPosition, sense_refining};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, statics};
use finray_studies::exports::ExportedFinger;
use finray_studies::exports::mujoco::{ContactStep, PROGRAM, TouchedRod, contact_steps};
use finray_tests::{CAMERA_NOISE_MM, paper};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Relative tolerance of a rod's sensed force.
const SENSED_TOLERANCE: f64 = 0.05;
/// Tolerances of the sum of contact forces and reactions, N, and of the sum of their moments about the origin, N mm. MuJoCo's positions have rounding
/// errors of 1e-14 mm, and its springs have stiffnesses of about 1e4 N/mm.
const BALANCE_TOLERANCE_N: f64 = 1e-6;
const BALANCE_TOLERANCE_NMM: f64 = 1e-4;
/// Tolerance between two formulations in MuJoCo, as a share of the largest displacement; the comparison with beams has the same tolerance. The second
/// formulation has gaps of 1e-4 mm in its welds, and coarse meshes.
const GUARD_TOLERANCE: f64 = 3e-4;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/mujoco")
}

fn manifest() -> Value {
    let text = fs::read_to_string(folder().join("manifest.json")).expect("a manifest");
    serde_json::from_str(&text).expect("a manifest in JSON")
}

fn list<'v>(value: &'v Value, key: &str) -> &'v Vec<Value> {
    value[key].as_array().unwrap_or_else(|| panic!("a list {key}"))
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("a number {key}"))
}

fn text<'v>(value: &'v Value, key: &str) -> &'v str {
    value[key].as_str().unwrap_or_else(|| panic!("a text {key}"))
}

fn digest(path: &Path) -> String {
    let bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

pub fn exported(name: &str) -> &'static ExportedFinger {
    PROGRAM.fingers.iter().find(|exported| exported.name == name).expect("an exported finger")
}

#[test]
fn tables_models_and_manifest_belong_together() {
    let manifest = manifest();
    let listed = manifest["sha256"].as_object().expect("digests");
    for (file, expected) in listed {
        assert_eq!(Some(digest(&folder().join(file)).as_str()), expected.as_str(), "{file}");
    }
    let there: BTreeSet<String> = ["", "mjcf"]
        .iter()
        .flat_map(|part| fs::read_dir(folder().join(part)).expect("the folder"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv" || extension == "xml"))
        .map(|path| path.strip_prefix(folder()).expect("inside").to_string_lossy().into_owned())
        .collect();
    assert_eq!(there, listed.keys().cloned().collect(), "files in the folder and in the manifest");

    let pushes = list(&manifest["contact"], "pushes");
    for record in list(&manifest, "static").iter().chain(pushes) {
        for model in list(record, "mjcf") {
            if let Some(file) = model["file"].as_str() {
                assert_eq!(digest(&folder().join(file)), text(model, "sha256"), "{file}");
            }
        }
    }
    assert_eq!(text(&manifest["versions"], "mujoco"), "4.0.0");
}

#[test]
fn the_manifest_tells_what_the_tables_hold() {
    let manifest = manifest();
    for record in list(&manifest, "static") {
        let exported = exported(text(record, "csv").trim_end_matches(".csv"));
        let cases = exported.cases().expect("a table");
        assert_eq!(cases.len() as f64, number(record, "cases"), "{}", exported.name);
        let scene = fs::read_to_string(folder().join("..").join(text(record, "scene"))).expect("the scene file");
        assert_eq!(Scene::from_toml(&scene).expect("a scene").finger, exported.finger().expect("a finger"));
        assert!(number(record, "imbalance_n") < BALANCE_TOLERANCE_N, "{record:?}");
        assert!(number(record, "imbalance_nmm") < BALANCE_TOLERANCE_NMM, "{record:?}");
    }
    let steps: f64 = list(&manifest["contact"], "pushes").iter().map(|push| number(push, "steps")).sum();
    assert_eq!(contact_steps().expect("a table").len() as f64, steps);
    for guard in list(&manifest["guard"], "against_a") {
        assert!(number(guard, "displacement") < GUARD_TOLERANCE, "{guard:?}");
    }
}

/// Beams have no equilibrium under the loads for which MuJoCo found no stable equilibrium.
#[test]
fn beams_cannot_carry_what_mujoco_could_not() {
    for record in list(&manifest(), "static") {
        let finger = exported(text(record, "csv").trim_end_matches(".csv")).finger().expect("a finger");
        let mesh = Mesh::with_elements_per_member(&finger, 16);
        for load in list(record, "no_stable_equilibrium") {
            let force = finger.direction(number(load, "angle_deg")) * number(load, "force_n");
            let load = Load::at_node(NodeId(number(load, "node") as usize), force);
            let solved = statics::solve(&mesh, &[load], Kinematics::Corotational);
            assert!(solved.is_err(), "beams carry {load:?}");
        }
    }
}

#[test]
fn contact_forces_and_reactions_cancel() {
    let table = fs::read_to_string(folder().join("contact-steps.csv")).expect("a table");
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let column = |name: &str| header.iter().position(|column| *column == name).expect("a column");
    for line in lines {
        let values: Vec<f64> = line.split(',').map(|field| field.parse().expect("a number")).collect();
        let sum = |part: &str| values[column(&format!("contact_{part}"))] + values[column(&format!("reaction_{part}"))];
        assert!(sum("fx_n").abs() < BALANCE_TOLERANCE_N && sum("fy_n").abs() < BALANCE_TOLERANCE_N, "{line}");
        assert!(sum("m_nmm").abs() < BALANCE_TOLERANCE_NMM, "{line}");
    }
}

/// Without friction, the force on a rod acts through the rod's centre. With a spinning cylinder, the force lies on the friction cone.
#[test]
fn contact_forces_obey_coulomb() {
    let finger = paper();
    for step in contact_steps().expect("a table") {
        for rod in step.touched {
            let arm = rod.moment_nmm / rod.force.norm();
            let expected = 1.5 * step.friction / (1.0 + step.friction * step.friction).sqrt();
            assert!((arm.abs() - expected).abs() < 1e-4, "push {}, {} mm, {rod:?}: {arm}", step.push, step.depth_mm);
            assert!(rod.force.dot(&finger.direction(0.0)) > 0.0, "contacts push");
        }
    }
}

/// Contact at which the line of the force crosses the plate: at the rod without friction, and beside it with friction on the rod's surface.
fn position_of_force(finger: &Finger, step: &ContactStep, rod: &TouchedRod) -> Contact {
    let tangent = nalgebra::Rotation2::new(step.shape.motion(rod.node).rotation) * finger.front_tangent();
    let (normal, along) = (finger.direction(0.0), finger.direction(90.0));
    Contact {
        position: ContactPosition::at(
            finger.front_position_mm(rod.node).expect("a front node") + rod.moment_nmm / tangent.perp(&rod.force),
        ),
        angle_deg: rod.force.dot(&along).atan2(rod.force.dot(&normal)).to_degrees(),
    }
}

#[test]
fn the_force_on_every_rod_is_sensed() {
    let finger = paper();
    for step in contact_steps().expect("a table") {
        let contacts: Vec<_> = step.touched.iter().map(|rod| position_of_force(&finger, &step, rod).into()).collect();
        let measurement = Measurement::of_shape(&finger, &step.shape);
        let sensed =
            sense_refining(&finger, &contacts, None, &measurement, Some(CAMERA_NOISE_MM), None).expect("an answer");
        for (rod, force_n) in step.touched.iter().zip(&sensed.forces.forces_n) {
            let error = force_n / rod.force.norm() - 1.0;
            assert!(error.abs() < SENSED_TOLERANCE, "push {}, {} mm, {rod:?}: {force_n} N", step.push, step.depth_mm);
        }
    }
}
