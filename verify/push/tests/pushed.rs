//! Tests of the answers of a pushed finger.

use finray_fixtures::{PAPER_SCENE, SPRING_STEEL_SCENE, TWIN_SCENE};
use finray_model::{Kinematics, Load, Mesh, Scene, statics};
use finray_push::{Knowledge, MESH_NODES, Push, Pushed, PushedFinger, Sensed, Session};
use serde_json::{Value, json};

fn push(contact: Knowledge) -> Push {
    Push {
        s_mm: 70.0,
        angle_deg: 10.0,
        force_n: 2.0,
        is_other: false,
        contact,
        estimator: "nonlinear".to_owned(),
        noise_mm: 0.067,
        image: 1,
    }
}

fn bent(finger: &PushedFinger, push: &Push) -> finray_push::Bent {
    match finger.push(push) {
        Pushed::Bent(bent) => *bent,
        Pushed::NotCarried(reason) => panic!("{reason}"),
    }
}

fn force(bent: &finray_push::Bent) -> &finray_push::SensedForce {
    match &bent.sensed {
        Sensed::Force(force) => force,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_pushed_finger_has_the_shape_that_statics_gives() {
    let finger = PushedFinger::new(SPRING_STEEL_SCENE, None).expect("a scene");
    let scene = Scene::from_toml(SPRING_STEEL_SCENE).expect("a scene");
    let mesh = Mesh::with_nodes(&scene.finger, MESH_NODES).expect("as many nodes");
    let load = Load::at_position(70.0, scene.finger.direction(10.0) * 2.0);
    let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium");
    let found = bent(&finger, &push(Knowledge::Unasked));
    assert_eq!(found.sensed, Sensed::Unasked);
    let marked: Vec<[f64; 2]> = scene.finger.free_nodes().map(|node| shape.motion(node).displacement.into()).collect();
    assert_eq!(found.displacements, marked);
    // The lines of the members end at nodes.
    let at_rest = finger.drawing();
    let moved = |(from, to): (&[f64; 2], &[f64; 2])| (to[0] - from[0]).hypot(to[1] - from[1]);
    let ends = at_rest.lines.iter().zip(&found.lines).filter_map(|(from, to)| Some(moved((from.last()?, to.last()?))));
    let largest = |lengths: &mut dyn Iterator<Item = f64>| lengths.fold(0.0, f64::max);
    let of_nodes = largest(&mut marked.iter().map(|by| by[0].hypot(by[1])));
    assert!((largest(&mut ends.into_iter()) - of_nodes).abs() < 1e-12 && of_nodes > 1.0, "{of_nodes}");
}

#[test]
fn a_known_force_lies_in_its_interval_and_a_wrong_contact_is_wrong() {
    let finger = PushedFinger::new(PAPER_SCENE, Some(TWIN_SCENE)).expect("two scenes");
    let images = 40;
    let holds = |contact: Knowledge, is_other| {
        let held_without_warning = |image: &u64| {
            // The contact is near the base, where a wrong contact and softer ends have the largest effect.
            let found = bent(&finger, &Push { image: *image, is_other, s_mm: 20.0, ..push(contact) });
            let [low, high] = force(&found).interval_n;
            low <= 2.0 && 2.0 <= high && force(&found).warnings.is_empty()
        };
        (1..=images).filter(held_without_warning).count()
    };
    // The coverage is 95 % within four standard errors for 40 images.
    assert!(holds(Knowledge::Known, false) >= 33 && holds(Knowledge::Sought, false) >= 33);
    let off = Knowledge::Off { by_mm: -1.5, by_deg: 12.5 };
    assert_eq!([holds(off, false), holds(Knowledge::Known, true)], [0, 0], "what is wrong must not look right");
}

#[test]
fn an_image_has_its_own_noise_whatever_the_force() {
    let finger = PushedFinger::new(PAPER_SCENE, None).expect("a scene");
    let noise = |push: Push| -> Vec<[f64; 2]> {
        let found = bent(&finger, &push);
        let pairs = found.displacements.iter().zip(&found.seen);
        pairs.map(|(exact, seen)| [0, 1].map(|i| ((seen[i] - exact[i]) * 1e9).round())).collect()
    };
    let of = |image, force_n| noise(Push { image, force_n, ..push(Knowledge::Unasked) });
    assert_eq!(of(1, 0.5), of(1, 2.0));
    assert_ne!(of(1, 0.5), of(2, 0.5));
    let rms = |noise: Vec<[f64; 2]>| {
        let squares: f64 = noise.iter().flatten().map(|it| (it / 1e9).powi(2)).sum();
        (squares / (2 * noise.len()) as f64).sqrt()
    };
    assert!((rms(of(3, 1.0)) / 0.067 - 1.0).abs() < 0.4, "46 numbers know their deviation to 10 %");
}

#[test]
fn questions_without_an_answer_say_why() {
    let mut session = Session::default();
    let mut ask =
        |question: Value| -> Value { serde_json::from_str(&session.answer(&question.to_string())).expect("JSON") };
    let known = |estimator: &str, force_n: f64| {
        json!({ "push": { "s_mm": 70.0, "angle_deg": 0.0, "force_n": force_n, "contact": "known", "estimator": estimator,
            "noise_mm": 0.067, "image": 1 } })
    };
    let says = |answer: &Value, part: &str| assert!(answer.to_string().contains(part), "{part}: {answer}");
    says(&ask(known("nonlinear", 1.0)), "expected a finger first");
    let broken = PAPER_SCENE.replace("thickness_mm", "thicknes_mm");
    says(&ask(json!({ "finger": { "scene": broken } }))["error"], "line ");
    assert!(ask(json!({ "finger": { "scene": PAPER_SCENE } })).get("lines").is_some());
    says(&ask(known("linear", 1.0))["bent"]["sensed"]["refused"], "least-squares");
    says(&ask(known("nonlinear", 1e6)), "not_carried");
    says(&ask(json!({ "pull": {} }))["error"], "pull");
    // An invalid question does not discard the loaded finger.
    assert!(ask(known("nonlinear", 1.0))["bent"]["sensed"]["force"]["force_n"].is_number());
}
