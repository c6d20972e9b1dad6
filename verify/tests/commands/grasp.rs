//! `finray grasp`: its output files, sensing from images, and scenes that are refused.

use crate::kit::*;
use finray_fixtures::{GRASPED_DISC_SCENE as DISC, WATCHED_DISC_SCENE as CAMERA};
use serde_json::Value;

fn summary(folder: &Folder, out: &str) -> Value {
    serde_json::from_str(&folder.read(&format!("{out}/summary.json"))).expect("JSON")
}

#[test]
fn a_grasp_writes_forces_motion_figure_and_summary() {
    let folder = Folder::new();
    let scene = folder.put("disc.toml", DISC);
    let run = |out: &str| {
        finray(&["grasp", &scene, "--fineness", "1", "--noise-mm", "0.067", "--out", &folder.path(out)]).done()
    };
    run("one");
    run("two");
    for file in ["forces.csv", "object.csv", "grasp.svg", "grasp-animation.svg", "summary.json"] {
        assert_eq!(folder.read(&format!("one/{file}")), folder.read(&format!("two/{file}")), "{file}: same bits");
    }
    let forces = folder.read("one/forces.csv");
    assert!(
        forces.starts_with("step,motor_deg,phase,finger,contact,s_mm,angle_deg,force_n,friction_n,sensed_n,sigma_n\n")
    );
    let object = folder.read("one/object.csv");
    assert!(object.starts_with("step,motor_deg,phase,x_mm,y_mm,rotation_rad,force_x_n,force_y_n,"));
    let (forces, object) = (Csv::of(&forces), Csv::of(&object));
    let steps = object.texts("step").len();
    let totals: Vec<usize> =
        (0..forces.texts("contact").len()).filter(|i| forces.texts("contact")[*i] == "total").collect();
    assert_eq!(totals.len(), 2 * steps, "a total a finger and step");
    // In a step without support, the total forces of both fingers are equal, and their friction carries the weight of 60 g.
    let (force_n, friction_n) = (forces.numbers("force_n"), forces.numbers("friction_n"));
    let carried = totals.iter().position(|i| forces.texts("phase")[*i] == "carry").expect("carried");
    let [left, right] = [totals[carried], totals[carried + 1]];
    assert_eq!([forces.texts("finger")[left], forces.texts("finger")[right]], ["left", "right"]);
    assert!((force_n[left] / force_n[right] - 1.0).abs() < 2e-3);
    assert!((friction_n[left] + friction_n[right] - 0.06 * 9.81).abs() < 1e-3);
    // Every step is one frame (`shot`) of the animation, whose text states the figures of the files; one frame is also shown without animation.
    let animation = folder.read("one/grasp-animation.svg");
    let shots: Vec<&str> = animation.split("<g class=\"shot-").skip(1).collect();
    assert!(shots.len() == steps && steps < 60 && animation.len() < 500_000, "{} of {steps}", shots.len());
    for (step, shot) in shots.iter().enumerate() {
        let of_step = |key: &str| object.texts(key)[step].to_owned();
        let motor_deg: f64 = of_step("motor_deg").parse().expect("an angle");
        assert!(shot.contains(&format!(">phase: {}, motor at {motor_deg:.1} deg<", of_step("phase"))), "step {step}");
        for (finger, total) in ["left", "right"].iter().zip(&totals[2 * step..]) {
            let sensed_n: f64 = forces.texts("sensed_n")[*total].parse().expect("sensed");
            let says = format!(">{finger}: true {:.2} N, sensed {sensed_n:.2} N<", force_n[*total]);
            assert!(shot.contains(&says), "step {step}: {says}");
        }
    }
    let still: Vec<&&str> =
        shots.iter().filter(|shot| shot.split_once('"').is_some_and(|(class, _)| class.contains("still"))).collect();
    assert!(still.len() == 1 && still[0].contains(">phase: carry, motor"), "{} stand still", still.len());
    assert!(!animation.contains("<script"));
    // Both plots of the force are drawn: over the steps and over the motor's angle.
    let figure = folder.read("one/grasp.svg");
    assert!(["true (lines), sensed (symbols)", "over the motor's angle"].iter().all(|it| figure.contains(it)));
    let summary = summary(&folder, "one");
    assert_eq!(summary["ended"], "done");
    assert!(summary["worst_imbalance"].as_f64().expect("a number") < 1e-3);
    assert_eq!(summary["sensed"]["by"], "errors in all variables");
    // A disc of 60 g between fingers with a friction coefficient of 0.4 hardly slides.
    let slid_mm = summary["slid_mm"].as_f64().expect("a number");
    assert!(slid_mm > 0.0 && slid_mm < 1.0, "{slid_mm}");
}

#[test]
fn a_grasp_is_sensed_by_the_estimator_that_is_asked_for() {
    let folder = Folder::new();
    let scene = folder.put("disc.toml", DISC);
    for (name, refuses) in [("least-squares", false), ("network", true)] {
        let out = folder.path(name);
        let run =
            finray(&["grasp", &scene, "--fineness", "1", "--estimator", name, "--noise-mm", "0.067", "--out", &out]);
        assert_eq!(
            (run.code, run.err.contains("no network ships for these contacts")),
            (Some(0), refuses),
            "{}",
            run.err
        );
        let sensed = &summary(&folder, name)["sensed"];
        assert_eq!((&sensed["by"], sensed["refused"].as_u64() > Some(0)), (&Value::from(name), refuses), "{sensed}");
    }
    let scene = [scene.as_str(), "--estimator", "guess"];
    assert_says(&finray(&[&["grasp"], &scene[..]].concat()).refused(), &["guess", "least-squares"]);
}

/// A camera is in front of each finger, or one camera is on the gripper and sees one finger rotated about the finger's axis.
#[test]
fn forces_are_sensed_in_images_of_the_fingers() {
    let folder = Folder::new();
    let coarser = [("motor_deg = [-135.0, -405.0]", "motor_deg = [-135.0, -405.0]\nstep_deg = 45.0")];
    let on_gripper = [
        ("translation_mm = [-75.0, 0.0, 170.0]", "translation_mm = [0.0, 95.0, 200.0]"),
        ("open = true", "open = true\ncamera_on_gripper = true"),
    ];
    for (name, changes) in [("finger", &[][..]), ("gripper", &on_gripper[..])] {
        let scene = folder.put(&format!("{name}.toml"), replaced(&replaced(CAMERA, &coarser), changes));
        finray(&["grasp", &scene, "--images", "--out", &folder.path(name)]).done();
        let sensed = &summary(&folder, name)["sensed"];
        let count = |key: &str| sensed[key].as_u64().expect("a count");
        assert!(count("asked") > 8 && count("refused") == 0);
        // Of a dozen 95 % intervals, at most two may miss the force.
        assert!(count("totals_within_95") + 2 >= count("asked"), "{sensed}");
        assert!(sensed["mean_total_error"].as_f64().expect("a number") < 0.005, "{sensed}");
    }
}

#[test]
fn a_grasp_that_fails_says_how_and_keeps_what_was() {
    let folder = Folder::new();
    let slippery = [("friction = 0.4", "friction = 0.02"), ("mass_g = 60.0", "mass_g = 3000.0")];
    let scene = folder.put("disc.toml", replaced(DISC, &slippery));
    let message = finray(&["grasp", &scene, "--fineness", "1", "--out", &folder.path("out")]).failed();
    assert!(["drop", "slip", "gets away"].iter().any(|word| message.contains(word)), "{message}");
    assert!(Csv::of(&folder.read("out/object.csv")).texts("step").len() > 5);
    let summary = summary(&folder, "out");
    assert_ne!(summary["ended"], "done");
    assert!(summary["slid_mm"].as_f64() > Some(7.5), "{summary}");
}

/// The object is so thin that the tips of the fingers touch each other. The steps before the contact of the tips are written.
#[test]
fn fingers_that_touch_each_other_are_named() {
    let folder = Folder::new();
    let thin = [("radius_mm = 15.0", "radius_mm = 1.0"), ("motor_deg = [0.0, -495.0]", "motor_deg = [0.0, -900.0]")];
    let scene = folder.put("disc.toml", replaced(DISC, &thin));
    let message = finray(&["grasp", &scene, "--fineness", "1", "--out", &folder.path("out")]).failed();
    assert_says(&message, &["the fingers touch each other; the steps before the failure are in"]);
    assert!(Csv::of(&folder.read("out/object.csv")).texts("step").len() > 5);
    assert_eq!(summary(&folder, "out")["ended"], "the fingers touch each other");
}

#[test]
fn bad_scenes_are_refused() {
    let folder = Folder::new();
    let cases: [(&[(&str, &str)], &str); 18] = [
        (&[("mass_g = 60.0", "mass_g = 0.0")], "object.mass_g: expected a mass in g above zero"),
        (&[("mass_g = 60.0", "mass_g = -5.0")], "object.mass_g: expected a mass in g above zero"),
        (&[("friction = 0.4", "friction = nan")], "object.friction: expected a coefficient of friction"),
        (&[("centre_mm = [3.0, 110.0]", "centre_mm = [30.0, 110.0]")], "the object overlaps the right finger by"),
        (&[("centre_mm = [3.0, 110.0]", "centre_mm = [50.0, 110.0]")], "the object overlaps the right finger"),
        (
            &[("radius_mm = 15.0", "radius_mm = 5.0"), ("centre_mm = [3.0, 110.0]", "centre_mm = [-45.0, 110.0]")],
            "the object overlaps the left finger",
        ),
        (
            &[("path_steps = 12", "step_deg = 9.0\nframes_per_s = 5.0")],
            "grasp.step_deg: expected either step_deg or frames_per_s, found both",
        ),
        (&[("[60.0, 0.0]]", "[60.0, 5.0]]")], "grasp.path_mm: point 3 leads 5.000 mm below the surface of the support"),
        (&[("link_mm = [25.0, 40.0]", "link_mm = [5.0, 10.0]")], "gripper.link_mm: "),
        (
            &[("motor_deg = [0.0, -495.0]", "motor_deg = [0.0, 99999.0]")],
            "grasp.motor_deg: expected motor angles within reach",
        ),
        (
            &[("motor_deg = [0.0, -495.0]", "motor_deg = [0.0, 0.0]")],
            "grasp.motor_deg: expected two different motor angles",
        ),
        (&[("path_steps = 12", "hold = true")], "grasp.hold: expected until_force_n in the same table"),
        (&[("path_steps = 12", "path_stepz = 12")], "unknown key `grasp.path_stepz`"),
        (&[("mass_g = 60.0\n", "mass_g = 60.0\nat_mm = 70.0\n")], "object.at_mm: expected no such key"),
        (&[("path_steps = 12", "support = true\ngravity_m_s2 = [0.0, 0.0]")], "grasp.support: expected a gravity"),
        (
            &[("path_steps = 12", "support = \"rails\"")],
            "grasp.support: expected true or false or \"table\", found the text",
        ),
        (
            &[("path_steps = 12", "support = \"table\"")],
            "grasp.motor_deg: the left finger touches the table where the gripper starts, at a motor angle of 0.0 degrees",
        ),
        (
            &[
                ("radius_mm = 15.0", "radius_mm = 0.5"),
                ("centre_mm = [3.0, 110.0]", "centre_mm = [0.0, 40.0]"),
                ("motor_deg = [0.0, -495.0]", "motor_deg = [-900.0, -990.0]"),
            ],
            "grasp.motor_deg: the fingers touch each other where the gripper starts",
        ),
    ];
    for (changes, says) in cases {
        let scene = folder.put("scene.toml", replaced(DISC, changes));
        let message = finray(&["grasp", &scene, "--out", &folder.path("out")]).refused();
        assert_says(&message, &[says]);
    }
    for table in ["[gripper]", "[grasp]", "[object]"] {
        let (before, after) = DISC.split_once(table).expect("a table");
        let rest = after.find("\n[").map_or("", |end| &after[end..]);
        let scene = folder.put("scene.toml", format!("{before}{rest}"));
        let message = finray(&["grasp", &scene, "--out", &folder.path("out")]).refused();
        assert_says(&message, &[table.trim_matches(['[', ']'])]);
    }
    let message = finray(&["grasp", &folder.put("scene.toml", DISC), "--out", "-"]).refused();
    assert_says(&message, &["--out: expected a folder"]);
    assert_says(&finray(&["press", &folder.path("scene.toml")]).refused(), &["the object is free (mass_g)"]);
    assert!(!folder.names().contains(&"out".to_owned()), "nothing is written");
}
