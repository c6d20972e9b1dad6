//! Invalid, extreme and non-finite input.

use super::soundness::Soundness;
use super::{Case, Outcome, middle, worst};
use finray_fixtures::PAPER_SCENE;
use finray_model::measurement::{Marker, Measurement, MeasurementError};
use finray_model::sensing::{Contact, ForcePrior, LinearEstimator, NonlinearEstimator};
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Kinematics, Load, Mesh, Scene, Vector};
use finray_tests::{paper, seen};

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
/// Relative tolerance of proportionality: after scaling by powers of ten, results agree in nine digits.
const PROPORTIONAL: f64 = 1e-9;
/// Optional keys for the paper's scene, inserted before `[finger.front]`. The next constant is appended to the scene.
const OPTIONAL_SIZES: &str = "rod_arm_mm = 0.5\nrib_arm_mm = 0.7\nclamp_arm_mm = 0.3\npoissons_ratio = 0.3\nshear_correction = 0.8\n[finger.front]";
const ZONE: &str = "[[finger.zone]]\nplate = \"front\"\nfrom_mm = 60.0\nto_mm = 95.0\nmodulus_factor = 0.5\n[camera]\nnoise_mm = 0.1\n";

#[test]
fn loads() -> Outcome {
    let mut case = Case::new(
        "denormal, infinite and not-a-number loads",
        "energies underflow and overflow long before displacements do",
        "loads that are infinite or not a number are refused; tiny loads, down to the smallest normal number, give \
         proportional displacements",
    );
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let node = middle(&finger);
    let solve = |load: &Load, kinematics| -> Result<Vector, StaticsError> {
        let load = mesh.frame_load(load)?;
        Ok(Statics::ladder(&mesh, kinematics).equilibrium(&[load])?.motion.displacements[mesh.frame_node(node)])
    };
    let along = |force_n: f64| Load::at_node(node, finger.direction(0.0) * force_n);
    let both = [Kinematics::Linear, Kinematics::Corotational];
    let bad_loads = NOT_FINITE.into_iter().flat_map(|bad| {
        [
            Load::at_node(node, Vector::new(bad, 0.0)),
            Load::Node { node, force: Vector::zeros(), moment_nmm: bad },
            Load::at_position(50.0, Vector::new(0.0, bad)),
            Load::at_position(bad, Vector::new(0.0, 1.0)),
        ]
    });
    let answers = bad_loads.flat_map(|load| both.map(|kinematics| solve(&load, kinematics)));
    let refused = answers.filter(|it| matches!(it, Err(StaticsError::LoadNotFinite | StaticsError::Load(_))));
    case.counts("not a load", "loads refused", 24, refused.count());
    let unit = solve(&along(1.0), Kinematics::Linear)?;
    let mut off = Vec::new();
    for exponent in [-300, -200, -160, -100, -20] {
        let force_n = 10_f64.powi(exponent);
        for kinematics in both {
            off.push((solve(&along(force_n), kinematics)? / force_n - unit).norm() / unit.norm());
        }
    }
    let quantity = "displacement / (load x compliance) - 1, for loads of 1e-300 to 1e-20 N";
    case.vanishes("linear limit", quantity, worst(off), PROPORTIONAL);
    let huge = solve(&along(1e300), Kinematics::Corotational);
    case.counts("no equilibrium", "refusals of 1e300 N", 1, usize::from(huge.is_err()));
    case.holds()
}

/// Copies of the scene, each with one number replaced by `value`; each copy comes with the key of its replaced number.
fn scenes_with<'s>(scene: &'s str, value: &'static str) -> impl Iterator<Item = (&'s str, String)> {
    let lines: Vec<&str> = scene.lines().collect();
    (0..lines.len()).filter_map(move |i| {
        let (key, old) = lines[i].split_once(" = ")?;
        old.parse::<f64>().ok()?;
        let mut changed = lines.clone();
        let replaced = format!("{key} = {value}");
        changed[i] = &replaced;
        Some((key, changed.join("\n")))
    })
}

fn full_scene() -> String {
    PAPER_SCENE.replacen("[finger.front]", OPTIONAL_SIZES, 1) + ZONE
}

#[test]
fn scene_values() -> Outcome {
    let mut case = Case::new(
        "denormal, infinite and not-a-number scene values",
        "one invalid value invalidates every result computed from it",
        "each refused with its line and key",
    );
    let full = full_scene();
    Scene::from_toml(&full)?;
    let no_numbers = ["nan", "inf", "-inf", "1e999"].into_iter().flat_map(|value| scenes_with(&full, value));
    // Optional keys may be zero or denormal, so invalid sizes are tested only in the scene without optional keys.
    let no_sizes = ["5e-324", "-5e-324", "-1.0"].into_iter().flat_map(|value| scenes_with(PAPER_SCENE, value));
    let refused =
        |(key, scene): (&str, String)| Scene::from_toml(&scene).is_err_and(|error| error.message.contains(key));
    let answers: Vec<bool> = no_numbers.chain(no_sizes).map(refused).collect();
    case.counts("no size", "scenes refused by line and key", answers.len(), answers.iter().filter(|it| **it).count());
    case.holds()
}

#[test]
fn extreme_scene_values() -> Outcome {
    let mut case = Case::new(
        "scene values of 1e-100 to 1e100",
        "valid numbers whose products underflow or overflow",
        "refused, or a sound equilibrium",
    );
    let mut sound = Soundness::default();
    let full = full_scene();
    let values = ["1e-100", "1e-30", "1e-10", "1e10", "1e30", "1e100"];
    for (_, scene) in values.into_iter().flat_map(|value| scenes_with(&full, value)) {
        let Ok(Scene { finger, .. }) = Scene::from_toml(&scene) else { continue };
        // A refusal is allowed; a solution must be sound.
        let _ = sound.add(&Mesh::key_nodes(&finger), middle(&finger), finger.direction(0.0) * 1e-3);
    }
    sound.report(&mut case);
    case.holds()
}

#[test]
fn displacements() -> Outcome {
    let mut case = Case::new(
        "denormal, infinite and not-a-number displacements",
        "files may contain non-finite and denormal values, although no camera measures them",
        "displacements that are infinite or not a number are refused; finite displacements give proportional forces, or are refused",
    );
    let finger = paper();
    let mesh = Mesh::key_nodes(&finger);
    let node = middle(&finger);
    let contact = Contact::at_node(node);
    let refused = NOT_FINITE.into_iter().filter(|bad| {
        let marker = Marker { node, displacement: Vector::new(0.0, *bad), weight: 1.0 };
        matches!(Measurement::new(&finger, [marker]), Err(MeasurementError::NotFinite { .. }))
    });
    case.counts("not a displacement", "markers refused", NOT_FINITE.len(), refused.count());
    let unit = seen(&mesh, &[contact], &[1.0], Kinematics::Linear)?;
    let linear = LinearEstimator::new(&finger, &[contact], &unit)?;
    let mut nonlinear = NonlinearEstimator::new(&mesh, &[contact.into()])?;
    let (mut off, mut answered) = (Vec::new(), 0);
    for exponent in [-300, -160, -100, -20, 20, 100, 160, 300] {
        let factor = 10_f64.powi(exponent);
        let scaled = unit.markers().iter().map(|it| Marker { displacement: it.displacement * factor, ..*it });
        let scaled = Measurement::new(&finger, scaled)?;
        off.push((linear.estimate(&scaled, None, ForcePrior::None).forces_n[0] / factor - 1.0).abs());
        nonlinear.reset();
        // The estimator may refuse. Under tiny displacements, forces equal those of the linear finger; displacements of 1e20 mm are impossible.
        match (exponent, nonlinear.estimate(&scaled, None)) {
            (..0, Ok(found)) => off.push((found.forces.forces_n[0] / factor - 1.0).abs()),
            (_, found) => answered += usize::from(exponent > 0 && found.is_ok()),
        }
    }
    case.vanishes("proportionality", "force / (displacement x stiffness) - 1", worst(off), PROPORTIONAL);
    case.counts("no finger moves so far", "forces stated for displacements of 1e20 mm and more", 0, answered);
    case.holds()
}
