//! Hard cases: invalid, extreme and non-finite input.

use super::soundness::Soundness;
use super::{Findings, Question, Unexpected, middle};
use crate::prelude::*;
use finray_fixtures::PAPER_SCENE;
use finray_model::measurement::MeasurementError;

pub(super) const QUESTIONS: &[Question] = &[
    Question {
        case: "denormal, infinite and not-a-number loads",
        difficulty: "energies underflow and overflow long before displacements do",
        expectation: "loads that are infinite or not a number are refused; tiny loads, down to the smallest normal number, give \
            proportional displacements",
        answer: loads,
    },
    Question {
        case: "denormal, infinite and not-a-number scene values",
        difficulty: "one invalid value invalidates every result computed from it",
        expectation: "each refused with its line and key",
        answer: scene_values,
    },
    Question {
        case: "scene values of 1e-100 to 1e100",
        difficulty: "valid numbers whose products underflow or overflow",
        expectation: "refused, or a sound equilibrium",
        answer: extreme_scene_values,
    },
    Question {
        case: "denormal, infinite and not-a-number displacements",
        difficulty: "files may contain non-finite and denormal values, although no camera measures them",
        expectation: "displacements that are infinite or not a number are refused; finite displacements give proportional \
            forces, or are refused",
        answer: displacements,
    },
];

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
/// Relative tolerance of proportionality: after scaling by powers of ten, results agree in nine digits.
const PROPORTIONAL: f64 = 1e-9;
/// Tolerance of a displacement that must be zero, mm.
const NOTHING_MM: f64 = 1e-300;
/// Invalid values for any number. The next constant contains invalid values for any size.
const NO_NUMBERS: [&str; 4] = ["nan", "inf", "-inf", "1e999"];
const NO_SIZES: [&str; 3] = ["5e-324", "-5e-324", "-1.0"];
/// Optional keys for the paper's scene, inserted before `[finger.front]`. The next constant is appended to the scene.
const OPTIONAL_SIZES: &str =
    "rod_arm_mm = 0.5\nrib_arm_mm = 0.7\nclamp_arm_mm = 0.3\npoissons_ratio = 0.3\nshear_correction = 0.8\n";
const ZONE: &str = "[[finger.zone]]\nplate = \"front\"\nfrom_mm = 60.0\nto_mm = 95.0\nmodulus_factor = 0.5\n[camera]\nnoise_mm = 0.1\n";
const EXTREME_VALUES: [&str; 6] = ["1e-100", "1e-30", "1e-10", "1e10", "1e30", "1e100"];
/// Load on extreme fingers, N.
const LOAD_N: f64 = 1e-3;

fn loads(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let node = middle(finger);
    let solve = |load: &Load, kinematics| {
        let load = mesh.frame_load(load)?;
        Ok(Statics::ladder(&mesh, kinematics).equilibrium(&[load])?.motion.displacements[mesh.frame_node(node)])
    };
    let (mut asked, mut refused) = (0, 0);
    for bad in NOT_FINITE {
        for kinematics in [Kinematics::Linear, Kinematics::Corotational] {
            for load in [
                Load::at_node(node, Vector::new(bad, 0.0)),
                Load::Node { node, force: Vector::zeros(), moment_nmm: bad },
                Load::at_position(50.0, Vector::new(0.0, bad)),
                Load::at_position(bad, Vector::new(0.0, 1.0)),
            ] {
                asked += 1;
                let answer: Result<Vector, StaticsError> = solve(&load, kinematics);
                refused += usize::from(matches!(answer, Err(StaticsError::LoadNotFinite | StaticsError::Load(_))));
            }
        }
    }
    findings.counts("not a load", "loads refused", asked, refused);
    let unit = solve(&Load::at_node(node, finger.direction(0.0)), Kinematics::Linear)?;
    let mut off = Vec::new();
    for exponent in [-300, -200, -160, -100, -20] {
        let force_n = 10_f64.powi(exponent);
        for kinematics in [Kinematics::Linear, Kinematics::Corotational] {
            let moved = solve(&Load::at_node(node, finger.direction(0.0) * force_n), kinematics)?;
            off.push((moved / force_n - unit).norm() / unit.norm());
        }
    }
    findings.vanishes(
        "linear limit",
        "displacement / (load x compliance) - 1, for loads of 1e-300 to 1e-20 N",
        worst(off),
        PROPORTIONAL,
    );
    let denormal = solve(&Load::at_node(node, finger.direction(0.0) * 5e-324), Kinematics::Corotational)?;
    findings.vanishes("linear limit", "displacement under 5e-324 N (mm)", denormal.norm(), NOTHING_MM);
    let huge = solve(&Load::at_node(node, finger.direction(0.0) * 1e300), Kinematics::Corotational);
    findings.counts("no equilibrium", "refusals of 1e300 N", 1, usize::from(huge.is_err()));
    Ok(())
}

/// Copies of the scene, each with one number replaced by `value`; each copy comes with the key of its replaced number.
fn scenes_with<'s>(scene: &'s str, value: &'static str) -> impl Iterator<Item = (&'s str, String)> {
    let lines: Vec<&str> = scene.lines().collect();
    (0..lines.len()).filter_map(move |i| {
        let (key, old) = lines[i].split_once(" = ")?;
        old.parse::<f64>().ok()?;
        let replaced = format!("{key} = {value}");
        let changed = lines.iter().enumerate().map(|(j, line)| if i == j { replaced.as_str() } else { line });
        Some((key, changed.collect::<Vec<_>>().join("\n")))
    })
}

fn full_scene() -> String {
    PAPER_SCENE.replacen("[finger.front]", &format!("{OPTIONAL_SIZES}[finger.front]"), 1) + ZONE
}

fn scene_values(_: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let full = full_scene();
    Scene::from_toml(&full)?;
    let no_numbers = NO_NUMBERS.into_iter().flat_map(|value| scenes_with(&full, value));
    // Optional keys may be zero or denormal, so invalid sizes are tested only in the scene without optional keys.
    let no_sizes = NO_SIZES.into_iter().flat_map(|value| scenes_with(PAPER_SCENE, value));
    let (mut asked, mut refused) = (0, 0);
    for (key, scene) in no_numbers.chain(no_sizes) {
        asked += 1;
        refused += usize::from(Scene::from_toml(&scene).is_err_and(|error| error.message.contains(key)));
    }
    findings.counts("no size", "scenes refused by line and key", asked, refused);
    Ok(())
}

fn extreme_scene_values(_: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mut sound = Soundness::default();
    let (mut asked, mut refused) = (0, 0);
    let full = full_scene();
    for (_, scene) in EXTREME_VALUES.into_iter().flat_map(|value| scenes_with(&full, value)) {
        asked += 1;
        let Ok(scene) = Scene::from_toml(&scene) else {
            refused += 1;
            continue;
        };
        let finger = scene.finger;
        let mesh = Mesh::key_nodes(&finger);
        let force = finger.direction(0.0) * LOAD_N;
        if sound.add(&mesh, middle(&finger), force).is_err() {
            refused += 1;
        }
    }
    findings.note(format!("{refused} of {asked} refused."));
    sound.report(findings);
    Ok(())
}

fn displacements(finger: &Finger, _: Effort, findings: &mut Findings) -> Result<(), Unexpected> {
    let mesh = Mesh::key_nodes(finger);
    let node = middle(finger);
    let contact = Contact::at_node(node);
    let refused = NOT_FINITE.into_iter().filter(|bad| {
        let marker = Marker { node, displacement: Vector::new(0.0, *bad), weight: 1.0 };
        matches!(Measurement::new(finger, [marker]), Err(MeasurementError::NotFinite { .. }))
    });
    findings.counts("not a displacement", "markers refused", NOT_FINITE.len(), refused.count());
    let load = mesh.frame_load(&contact.unit_load(finger))?;
    let motion = Statics::ladder(&mesh, Kinematics::Linear).equilibrium(&[load])?.motion;
    let unit = Measurement::of_shape(finger, &mesh.shape(&motion));
    let linear = LinearEstimator::new(finger, &[contact], &unit)?;
    let mut nonlinear = NonlinearEstimator::new(&mesh, &[contact.into()])?;
    let (mut off, mut wrong, mut refusals) = (Vec::new(), 0, Vec::new());
    for exponent in [-300, -160, -100, -20, 20, 100, 160, 300] {
        let factor = 10_f64.powi(exponent);
        let scaled =
            unit.markers().iter().map(|marker| Marker { displacement: marker.displacement * factor, ..*marker });
        let scaled = Measurement::new(finger, scaled)?;
        off.push((linear.estimate(&scaled, None, Prior::None).forces_n[0] / factor - 1.0).abs());
        nonlinear.reset();
        match nonlinear.estimate(&scaled, None) {
            // Under tiny displacements, forces equal those of the linear finger; displacements of 1e20 mm are impossible.
            Ok(found) if exponent < 0 => off.push((found.forces.forces_n[0] / factor - 1.0).abs()),
            Ok(found) => {
                // A returned force counts as wrong only if its residual is so small that the force seems to fit.
                wrong += usize::from(found.forces.residual_rms_mm < 0.01 * factor);
            }
            Err(error) => refusals.push((exponent, error)),
        }
    }
    if let Some((exponent, error)) = refusals.first() {
        findings.note(format!("From 1e{exponent} mm on: {error}."));
    }
    findings.vanishes("proportionality", "force / (displacement x stiffness) - 1", worst(off), PROPORTIONAL);
    findings.counts(
        "no finger moves so far",
        "sensed forces whose shapes seem to fit displacements of 1e20 mm and more",
        0,
        wrong,
    );
    Ok(())
}
