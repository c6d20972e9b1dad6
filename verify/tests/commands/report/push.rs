//! Tests the finger that a reader can push on the first page: in a browser, and against the commands.

use super::browsed::{assert_passes, driven};
use super::shared::*;
use crate::kit::*;
use finray_fixtures::PAPER_SCENE;
use finray_model::Scene;
use finray_push::{Knowledge, MESH_NODES, Push, Pushed, PushedFinger, Sensed};
use finray_tests::{case_count, random_stream};
use rand::RngExt;

/// Pointer, keys and choices change the drawing without script errors. If no force was sensed, the page shows no sensed force.
#[test]
fn the_finger_of_the_page_can_be_pushed() {
    let Some(browser) = browser::browser() else { return };
    let html = PAPERS.read("index.html");
    let results = |html: &str, width| driven(&browser, html, include_str!("push/after.js"), width);
    for width in [1400, 520] {
        assert_passes(&results(&html, width), 19);
    }
    // The test detects a force that is shown twice as large.
    let broken = html.replacen("`Sensed ${newton(force_n)}`", "`Sensed ${newton(2 * force_n)}`", 1);
    assert!(results(&broken, 1400).iter().any(|line| line.starts_with("FAIL")), "a wrong force is not seen");
    // Without the program, or with a program that is none or does not know the scene, a sentence says why there is no drawing.
    let faults = [
        ("id=\"push-program\"", "id=\"push-nothing\"", "the page has no program"),
        ("id=\"push-program\">H4sI", "id=\"push-program\">AAAA", ""),
        ("base_width_mm", "base_breadth_mm", "base_breadth_mm"),
    ];
    for (sound, broken, reason) in faults {
        assert!(html.contains(sound), "{sound}");
        let without = results(&html.replacen(sound, broken, 1), 1400);
        let is_said = |line: &String| line.starts_with("PASS a sentence says why: ") && line.contains(reason);
        assert!(without.iter().any(|line| line.starts_with("FAIL the picture is shown")), "{without:?}");
        assert!(without.iter().any(is_said), "{without:?}");
    }
}

#[test]
fn the_scene_of_the_page_can_be_changed() {
    let Some(browser) = browser::browser() else { return };
    let html = PAPERS.read("your-finger.html");
    assert_passes(&driven(&browser, &html, include_str!("push/own.js"), 1400), 10);
}

/// Relative tolerance between the numbers of the page's finger and the numbers of the commands.
const SAME: f64 = 1e-9;

/// The page shows the same numbers as `solve` and `sense`.
#[test]
fn a_pushed_finger_is_what_solve_and_sense_say() {
    let pushed = PushedFinger::new(PAPER_SCENE, None).expect("a scene");
    let finger = Scene::from_toml(PAPER_SCENE).expect("a scene").finger;
    let free: Vec<usize> = finger.free_nodes().map(|node| node.0).collect();
    let folder = Folder::new();
    let scene = folder.put("scene.toml", PAPER_SCENE);
    let mut chance = random_stream(46, 1);
    let mut answered = 0;
    for image in 0..case_count(12, 200) as u64 {
        let push = Push {
            s_mm: chance.random_range(5.0..150.0),
            angle_deg: chance.random_range(-60.0..60.0),
            force_n: chance.random_range(0.2..3.0),
            is_other: false,
            contact: if image % 4 == 3 { Knowledge::Sought } else { Knowledge::Known },
            estimator: ["nonlinear", "least-squares"][image as usize / 2 % 2].to_owned(),
            noise_mm: 0.067,
            image,
        };
        let Push { s_mm, angle_deg, force_n, .. } = push;
        let load = format!("{s_mm}:{force_n},{angle_deg}");
        let nodes = MESH_NODES.to_string();
        let solved = finray(&["solve", &scene, "--load-at", &load, "--mesh-nodes", &nodes]);
        let Pushed::Bent(bent) = pushed.push(&push) else {
            assert_eq!(solved.code, Some(3), "{load}: {}", solved.err);
            continue;
        };
        assert_eq!(solved.code, Some(0), "{}", solved.err);
        let shape = Csv::of(&solved.out);
        let [ux, uy] = ["ux_mm", "uy_mm"].map(|column| shape.numbers(column));
        let said: Vec<f64> = free.iter().flat_map(|node| [ux[node - 1], uy[node - 1]]).collect();
        let shown: Vec<f64> = bent.displacements.iter().flatten().copied().collect();
        assert_close(&shown, &said, SAME * said.iter().fold(0.0, |largest: f64, it| largest.max(it.abs())));

        let rows = free.iter().zip(&bent.seen).map(|(node, [x, y])| format!("{node},{x},{y}\n"));
        let seen = folder.put("seen.csv", format!("node,ux_mm,uy_mm\n{}", rows.collect::<String>()));
        let contact = match push.contact {
            Knowledge::Sought => "auto@auto".to_owned(),
            _ => format!("{s_mm}@{angle_deg}"),
        };
        let given = ["sense", &scene, "--displacements", &seen, "--contact-at", &contact, "--noise-mm", "0.067"];
        let sensed = finray(&[&given[..], &["--estimator", &push.estimator]].concat());
        match &bent.sensed {
            Sensed::Force(force) => {
                assert_eq!(sensed.code, Some(0), "{}", sensed.err);
                assert_eq!(force.warnings.is_empty(), !sensed.err.contains("warning: "), "{}", sensed.err);
                let row = Csv::of(&sensed.out);
                let of = |column: &str| row.numbers(column)[0];
                let [force_n, sigma_n] = [of("force_n"), of("sigma_n")];
                assert_close(&[force.force_n, force.sigma_n], &[force_n, sigma_n], SAME * force_n.abs());
                answered += 1;
            }
            Sensed::Refused(reason) => assert!(sensed.err.contains(reason.as_str()), "{reason}: {}", sensed.err),
            Sensed::Unasked => panic!("the sensor was asked"),
        }
    }
    assert!(answered > 5, "{answered}");
}
