//! Tests of the report of a whole study.

use finray_model::estimators::EstimatorId;
use finray_model::validity::StrainLimits;
use finray_studies::experiments::contact_scene::study::SceneWithOutline;
use finray_studies::sampling::map::AccuracyMap;
use finray_studies::sampling::sweep::MapCell;
use finray_studies::settings;
use finray_studies::study::Study;
use finray_studies::truths::TruthId;
use std::sync::LazyLock;

/// A quick study of the paper's finger; all tests share the study.
static STUDY: LazyLock<Study> = LazyLock::new(|| {
    struct Silent;
    impl settings::Progress for Silent {
        fn part(&self, _: &str, _: usize) {}
        fn step(&self) {}
    }
    let scene = SceneWithOutline::from_toml(finray_fixtures::PAPER_SCENE).expect("paper scene");
    Study::run(&scene, settings::ReportForces::PAPER, settings::Effort::Quick, &Silent)
        .expect("the paper's finger is solved")
});

/// In this test, the finger does not carry the forces in every cell, and its material allows only little strain. The first screen of the report must
/// refer its shares to the cells that carry the forces, and state the limits of the beam model.
#[test]
fn the_first_screen_says_where_finger_and_model_end() {
    let mut study = STUDY.clone();
    let known = |map: &&mut AccuracyMap| {
        let [truth, estimator] = [map.truth == TruthId::Corotational, map.estimator == EstimatorId::Nonlinear];
        truth && estimator && map.noise_mm > 0.0
    };
    let map = study.maps.iter_mut().find(known).expect("the map of the first answer");
    let forces = map.request.forces_n.len();
    let [cells, lost] = [map.cells.len() / forces, 7];
    // The largest force of the first cells has no equilibrium.
    for cell in map.cells.iter_mut().skip(forces - 1).step_by(forces).take(lost) {
        *cell = MapCell { mean_error: None, bias: None, spread: None, samples: 0, answered: 0, ..*cell };
    }
    study.strain_limits = StrainLimits { front: Some(0.01), back: Some(0.01), ribs: Some(0.01) };
    let answers = finray_report::report(&study).expect("the report is drawn").verdict;
    // Cells in directions that friction does not allow count in no share.
    let known = finray_report::report(&STUDY).expect("the report is drawn").verdict;
    let said = "the finger has no equilibrium under at least one of these forces in ";
    assert!(answers[0].contains(said) && !known[0].contains(said), "{}", answers[0]);
    let counts = answers[0].split(said).nth(1).and_then(|rest| rest.split(" cells, which count in no share").next());
    let (without, counted) = counts.and_then(|counts| counts.split_once(" of ")).expect("counts");
    let [without, counted] = [without, counted].map(|count| count.parse::<usize>().expect("a count"));
    assert!(without > 0 && without <= lost && counted < cells, "{without} of {counted}");
    let physics = answers.iter().find(|answer| answer.starts_with("Is the physics right?")).expect("an answer");
    assert!(physics.contains("At 3 N along the normal the beam model is beyond its limits: a strain of "), "{physics}");
    assert!(physics.contains("(limit 1.0 %)"), "{physics}");
}

/// The accuracy map has the errors that other programs found at 3 N: up to about 9 % along the normal (node 24), and over 30 % at -80 deg.
#[test]
fn the_map_shows_what_is_known() {
    let study = &*STUDY;
    let map = study.map(TruthId::Corotational, false).expect("the map without noise");
    let at_3_n = |angle: f64| map.cells.iter().filter(move |c| c.force_n == 3.0 && c.angle_deg == angle);
    let largest = at_3_n(0.0).filter_map(|c| c.mean_error).fold(0.0, f64::max);
    assert!((0.08..0.10).contains(&largest), "along the normal: {largest}");
    let middle: Vec<f64> =
        at_3_n(-80.0).filter(|c| (30.0..140.0).contains(&c.s_mm)).filter_map(|c| c.mean_error).collect();
    assert!(middle.iter().all(|e| *e > 0.30), "at -80 deg: {middle:?}");
    let drawn = finray_report::report(study).expect("the report is drawn");
    // Soft ends are a property of another finger, the twin, so the verdict must not name them as a cause of this finger's errors.
    let head: Vec<String> = drawn.verdict.iter().take(5).cloned().collect();
    let why = head.iter().find(|answer| answer.starts_with("Why not elsewhere?")).expect("an answer");
    let known = why.split("Contact unknown:").next().expect("what is said of the known finger");
    for circular in ["compliance", "softer", "twin", "as the paper's seems"] {
        assert!(!known.contains(circular), "{circular}: {known}");
    }
    let linear = study.map(TruthId::Linear, false).expect("the linear map");
    assert!(linear.cells.iter().all(|c| c.mean_error.is_some_and(|e| e < 1e-9)));
    let files = drawn.files;
    let pages = files.iter().filter(|(name, _)| name.extension().is_some_and(|e| e == "html"));
    let page: String = pages.map(|(_, page)| page.as_str()).collect();
    for (name, _) in files.iter().filter(|(name, _)| name.extension().is_some_and(|e| e == "csv")) {
        let name = name.display().to_string();
        assert!(page.contains(&name), "no page names {name}");
    }
}

/// The page once drew the true force with its full length beside the sensed normal component.
#[test]
fn a_force_across_the_normal_is_not_drawn_beside_the_sensed_one() {
    let mut study = STUDY.clone();
    let contacts =
        study.contact_scenes.iter_mut().flat_map(|scene| &mut scene.steps).flat_map(|of| &mut of.step.contacts);
    let mut normals = Vec::new();
    for contact in contacts {
        // A tangential force, as friction would add.
        let across = study.finger.direction(contact.contact.angle_deg + 90.0);
        contact.force += across * contact.normal_n;
        normals.push(contact.normal_n);
    }
    let drawn = finray_report::report(&study).expect("a report");
    let page = &drawn.files.iter().find(|(name, _)| name.ends_with("maps.html")).expect("the page").1;
    let data = page.split("id=\"explore-data\">").nth(1).and_then(|rest| rest.split("</script>").next());
    let data: serde_json::Value = serde_json::from_str(data.expect("the data")).expect("JSON");
    let list = |value: &serde_json::Value, key: &str| value[key].as_array().expect("a list").clone();
    let contacts = list(&data, "scenes").into_iter().flat_map(|scene| list(&scene, "steps"));
    let lengths = contacts.flat_map(|step| list(&step, "contacts")).map(|contact| {
        let [x, y] = [0, 1].map(|i| contact["true"][i].as_f64().expect("a number"));
        x.hypot(y)
    });
    let lengths: Vec<f64> = lengths.collect();
    assert!(lengths.len() == normals.len() && normals.len() > 2);
    // The page contains four digits of each number.
    assert!(lengths.iter().zip(&normals).all(|(drawn, normal)| (drawn - normal.abs()).abs() < 1e-3 * normal.abs()));
}
