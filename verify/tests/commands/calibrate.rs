//! `finray calibrate`: from measured shapes under known loads to Young's modulus.

mod measurements;

use crate::kit::*;
use finray_fixtures::TWIN_SCENE;

/// Tolerance for rounding of the displacements and for the search for the factor.
const RECOVERED: f64 = 1e-9;
/// Loads of two cases: node, and force in N.
const LOADS: [(usize, [f64; 2]); 2] = [(17, [0.1, -1.0]), (21, [-0.2, -2.0])];

/// Displacements of all key nodes of a linear finger, one case for each of [`LOADS`].
fn measured(scene: &str) -> String {
    weighed(scene, &["--kinematics", "linear"], &LOADS)
}

/// Calibrates with eq. (11) of the paper and the linear finger, which fits linear shapes exactly.
fn calibrate(scene: &str, measurements: &str) -> Answer {
    finray_reading(measurements.as_bytes(), &["calibrate", scene, "--measurements", "-", "--kinematics", "linear"])
}

#[test]
fn a_softer_finger_gives_its_own_modulus() {
    let folder = Folder::new();
    // The true scene states the modulus multiplied by 0.8; all parts of the finger have this modulus.
    let truth = folder.put("truth.toml", paper_with(&[("47.976", "38.3808")]));
    let answer = Csv::of(&calibrate(PAPER, &measured(&truth)).done());
    assert_eq!(answer.header, ["parameter", "value", "sigma"]);
    assert_eq!(answer.texts("parameter"), ["youngs_modulus_mpa", "modulus_factor"]);
    let value = answer.numbers("value");
    assert_close(&value[..1], &[38.3808], RECOVERED);
    assert_close(&value[1..], &[0.8], RECOVERED);
    assert!(answer.numbers("sigma").iter().all(|sigma| (0.0..RECOVERED).contains(sigma)));
}

#[test]
fn parts_of_different_moduli_are_listed_each() {
    let folder = Folder::new();
    let moduli = |front: f64, back: f64, ribs: f64| {
        let mut parts = [front, back, ribs].into_iter();
        let with_next = |line: &str| match line.starts_with("youngs_modulus_mpa") {
            true => format!("youngs_modulus_mpa = {:?}\n", parts.next().expect("three parts")),
            false => format!("{line}\n"),
        };
        paper_with(&[]).lines().map(with_next).collect::<String>()
    };
    let scene = folder.put("scene.toml", moduli(40.0, 60.0, 50.0));
    let truth = folder.put("truth.toml", moduli(50.0, 75.0, 62.5));
    let answer = Csv::of(&calibrate(&scene, &measured(&truth)).done());
    let names = ["front_youngs_modulus_mpa", "back_youngs_modulus_mpa", "ribs_youngs_modulus_mpa", "modulus_factor"];
    assert_eq!(answer.texts("parameter"), names);
    for (ours, truth) in answer.numbers("value").into_iter().zip([50.0, 75.0, 62.5, 1.25]) {
        assert_close(&[ours], &[truth], RECOVERED);
    }
    // Undeformable ribs have no modulus.
    let rows = weighed(SPRING_STEEL, &["--kinematics", "linear"], &[(8, [0.0, -1.0])]);
    let answer = Csv::of(&calibrate(SPRING_STEEL, &rows).done());
    assert_eq!(answer.texts("parameter"), [names[0], names[1], names[3]]);
    assert_close(&answer.numbers("value")[2..], &[1.0], RECOVERED);
}

/// Rows may have another order, and lines may end with CR and LF. The sum of distances is robust against one wrongly assigned marker.
#[test]
fn order_does_not_matter_and_single_bad_markers_hardly() {
    let text = measured(PAPER);
    let mut rows: Vec<_> = text.lines().skip(1).collect();
    rows.reverse();
    rows.swap(3, 30);
    let shuffled = format!("{WEIGHTS}{}\r\n", rows.join("\r\n"));
    let factor = |text: &str| {
        let answer = Csv::of(&calibrate(PAPER, text).done());
        (answer.numbers("value")[1], answer.numbers("sigma")[1])
    };
    assert_close(&[factor(&shuffled).0], &[1.0], RECOVERED);
    let bad = rows.iter().position(|row| row.starts_with("weight 1,21,-0.2,-2,5,")).expect("node 5");
    rows[bad] = "weight 1,21,-0.2,-2,5,3.0,-9.0";
    let (factor, sigma) = factor(&format!("{WEIGHTS}{}", rows.join("\n")));
    assert!((factor - 1.0).abs() < 1e-3 && sigma >= 0.0, "{factor} +- {sigma}");
}

#[test]
fn measurements_that_do_not_fit_are_refused_by_file_and_line() {
    let folder = Folder::new();
    let good = "a,19,0,-1,7,0,-1\n";
    for (rows, expected) in [
        (
            "a,19,0,-1,8,0,-1\na,19,0,-1.1,9,0,-1\n",
            "line 4: case a: expected the same load as in the first row of this case",
        ),
        (
            "b,19,0,-1,8,0,-1\na,18,0,-1,9,0,-1\n",
            "line 4: case a: expected the same load as in the first row of this case",
        ),
        ("a,19,0,-1,7,0,-1\n", "line 3: node 7 is listed twice"),
        ("a,19,0,-1,26,0,-1\n", "line 3: node 26 does not exist"),
        ("a,19,0,-1,25,0,-1\n", "line 3: node 25 is clamped"),
        ("b,1,0,-1,7,0,-1\n", "line 3: node 1 is clamped: a load on it"),
        ("b,27,0,-1,7,0,-1\n", "line 3: node 27 does not exist"),
        ("b,19,0,down,7,0,-1\n", "line 3: fy_n: expected a finite number, found \"down\""),
        ("b,19,0,nan,7,0,-1\n", "line 3: fy_n: expected a finite number"),
        ("b,19,0,-1,7,inf,-1\n", "line 3: ux_mm: expected a finite number"),
        ("b,tip,0,-1,7,0,-1\n", "line 3: load_node: expected the number of a node, found \"tip\""),
        ("b,19,0,-1,7,0\n", "line 3: expected 7 columns as in the header, found 6"),
    ] {
        let path = folder.put("weights.csv", format!("{WEIGHTS}{good}{rows}"));
        let message = finray(&["calibrate", PAPER, "--measurements", &path]).refused();
        assert_says(&message, &[&path, expected]);
    }
    for (text, expected) in [
        ("", "found nothing"),
        (WEIGHTS, "expected rows of case,load_node,fx_n,fy_n,node,ux_mm,uy_mm, found none"),
        ("case,load_node,fx_n,node,ux_mm,uy_mm\na,19,0,7,0,-1\n", "line 1: expected a column fy_n"),
    ] {
        let path = folder.put("weights.csv", text);
        assert_says(&finray(&["calibrate", PAPER, "--measurements", &path]).refused(), &[&path, expected]);
    }
}

/// Markers of clamped nodes have noise, like all other markers.
#[test]
fn clamped_nodes_may_carry_noise() {
    let exact = measured(PAPER);
    let noisy: String = exact
        .lines()
        .map(|line| match line.strip_suffix(",0.0,0.0") {
            Some(clamped) => format!("{clamped},0.05,-0.04\n"),
            None => format!("{line}\n"),
        })
        .collect();
    assert_ne!(noisy, exact);
    assert_eq!(calibrate(PAPER, &noisy).done(), calibrate(PAPER, &exact).done());
    let shifted = noisy.replace(",0.05,-0.04", ",0.5,-4");
    assert_says(&calibrate(PAPER, &shifted).refused(), &["is clamped, so its displacement must be zero"]);
}

/// Options for images have no meaning for shapes under known loads; they are refused and not ignored silently.
#[test]
fn options_of_images_are_refused_beside_measurements() {
    let folder = Folder::new();
    let weights = folder.put("weights.csv", measured(PAPER));
    for option in ["--fit", "--forces", "--images"] {
        let message = finray(&["calibrate", PAPER, "--measurements", &weights, option, "modulus"]).refused();
        assert_says(&message, &["--measurements", option, "cannot be used with"]);
    }
    for option in [&["--zones=1"][..], &["--kinematics", "linear"], &["--noise-mm", "0.1"]] {
        let located = [&["calibrate", PAPER, "--located", "located.csv", "--fit", "modulus"], option].concat();
        assert_says(&finray(&located).refused(), &["--located", "cannot be used with"]);
    }
    // Without any input, the message names all ways to calibrate.
    assert_says(&finray(&["calibrate", PAPER]).refused(), &["--weight", "--measurements", "--located", "--fit"]);
}

/// A modulus a hundred times as large as in the scene indicates a wrong unit.
#[test]
fn a_modulus_far_from_the_scene_gives_a_warning() {
    let folder = Folder::new();
    let stiff = folder.put("stiff.toml", paper_with(&[("47.976", "4797.6")]));
    let (answer, warnings) = calibrate(PAPER, &measured(&stiff)).warned();
    assert_close(&Csv::of(&answer).numbers("value")[1..], &[100.0], RECOVERED);
    assert!(warnings.len() == 1 && warnings[0].contains("modulus_factor is 1.000e2"), "{warnings:?}");
    let in_pa = folder.put("pa.toml", paper_with(&[("47.976", "47.976e6")]));
    let (_, warnings) = finray(&["solve", &in_pa, "--load", "19:0,-1"]).warned();
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert_says(&warnings[0], &[&in_pa, "finger.front.youngs_modulus_mpa", "did you mean 47.976 MPa?"]);
}

#[test]
fn measurements_that_tell_no_modulus_are_refused() {
    for (rows, expected) in [
        ("a,19,0,0,7,0,-1\n", "no load of the measurements moves a measured node"),
        ("a,19,0,-1,1,0,0\n", "no load of the measurements moves a measured node"),
        ("a,19,0,-1,7,0,1\na,19,0,-1,18,0,1\n", "do not move with the loads"),
        ("a,19,0,-1,7,0,0\na,19,0,-1,18,0,0\n", "do not move with the loads"),
        ("a,19,0,-1,7,0,-1e-310\n", "not identifiable"),
    ] {
        assert_says(&calibrate(PAPER, &(WEIGHTS.to_owned() + rows)).refused(), &[expected]);
    }
}

/// The twin scene with other modulus factors; each factor applies to one zone of the front plate and one of the back plate.
fn twin_with(factors: [f64; 3]) -> String {
    let from = ["0.7216", "0.1528", "0.0641"].map(|factor| format!("modulus_factor = {factor}"));
    from.iter().zip(factors).fold(TWIN_SCENE.to_owned(), |scene, (from, factor)| {
        assert!(scene.contains(from));
        scene.replace(from, &format!("modulus_factor = {factor:?}"))
    })
}

/// Measurements of a scene's finger under weights at four nodes, along the normal of the plate.
fn measured_at_four(scene: &str, kinematics: &str) -> String {
    let loads = [14, 16, 20, 24].map(|node| (node, paper_force(1.0, 0.0)));
    weighed(scene, &["--kinematics", kinematics, "--mesh-nodes", "130"], &loads)
}

#[test]
fn zones_are_found_with_their_sigmas_and_correlations() {
    let folder = Folder::new();
    let truth = folder.put("truth.toml", twin_with([0.6, 0.2, 0.1]));
    let start = folder.put("start.toml", twin_with([1.0, 1.0, 1.0]));
    // Linear shapes are exact. The co-rotational shapes come from another mesh than the calibration's, so the tolerance is larger.
    for (kinematics, tolerance) in [("linear", 1e-6), ("corotational", 0.01)] {
        let measurements = measured_at_four(&truth, kinematics);
        let correlations = folder.path("correlations.csv");
        let zones = ["--zones=1+2,3+4,5+6", "--kinematics", kinematics, "--correlations", &correlations];
        let command = [&["calibrate", &start, "--measurements", "-"][..], &zones].concat();
        let answer = Csv::of(&finray_reading(measurements.as_bytes(), &command).done());
        assert_eq!(answer.header, ["parameter", "value", "sigma"]);
        let zones = (1..=6).map(|zone| format!("zone_{zone}_modulus_factor"));
        let names: Vec<_> =
            ["youngs_modulus_mpa", "modulus_factor"].map(str::to_owned).into_iter().chain(zones).collect();
        assert_eq!(answer.texts("parameter"), names);
        for (ours, truth) in answer.numbers("value").iter().zip([49.44, 1.0, 0.6, 0.6, 0.2, 0.2, 0.1, 0.1]) {
            assert!((ours / truth - 1.0).abs() < tolerance, "{kinematics}: {ours}, true {truth}");
        }
        assert!(answer.numbers("sigma").iter().all(|sigma| *sigma >= 0.0));
        let pairs = Csv::of(&folder.read("correlations.csv"));
        assert_eq!(pairs.header, ["parameter", "other", "correlation"]);
        assert_eq!(pairs.texts("other").len(), 6);
        assert!(pairs.numbers("correlation").iter().all(|correlation| correlation.abs() < 1.0));
    }
}

/// A marker that is off by 3 mm is named with and without `--zones`. With `--zones`, it once passed silently.
#[test]
fn zones_are_warned_of_like_a_single_modulus() {
    let folder = Folder::new();
    let scene = folder.put("scene.toml", twin_with([0.6, 0.2, 0.1]));
    let exact = measured_at_four(&scene, "corotational");
    let row = exact.lines().nth(7).expect("node 7");
    let cells: Vec<&str> = row.split(',').collect();
    let off = format!("{},{},{}", cells[..5].join(","), cells[5].parse::<f64>().expect("a number") + 3.0, cells[6]);
    let text = exact.replacen(row, &off, 1);
    for zones in [&[][..], &["--zones=1+2"]] {
        let command = [&["calibrate", &scene, "--measurements", "-", "--noise-mm", "0.02"][..], zones].concat();
        let (_, warnings) = finray_reading(text.as_bytes(), &command).warned();
        assert_says(
            &warnings[0],
            &["warning: case 1 in the order of the file: node 7 is", "check the row's node number"],
        );
    }
}

#[test]
fn zones_that_are_not_identifiable_or_named_are_refused() {
    let folder = Folder::new();
    let measurements = measured(PAPER);
    let refused = |scene: &str, options: &[&str]| {
        finray_reading(measurements.as_bytes(), &[&["calibrate", scene, "--measurements", "-"], options].concat())
            .refused()
    };
    assert_says(&refused(PAPER, &["--zones"]), &["--zones", "expected tables [[finger.zone]] in the scene"]);
    let scene = folder.put("scene.toml", twin_with([1.0, 1.0, 1.0]));
    for (groups, expected) in [
        ("--zones=7", "expected groups of zones, 1 to 6"),
        ("--zones=0", "expected groups of zones, 1 to 6"),
        ("--zones=1,tip", "found \"tip\""),
        ("--zones=1+2,2", "zone 2 is named twice"),
    ] {
        assert_says(&refused(&scene, &[groups]), &["--zones", expected]);
    }
    // The factors of two identical zones are not identifiable.
    let twice = "[[finger.zone]]\nplate = \"front\"\nfrom_mm = 0.0\nto_mm = 30.0\nmodulus_factor = 1.0\n";
    let scene = folder.put("twice.toml", format!("{}\n{twice}\n{twice}", paper_with(&[])));
    let message = refused(&scene, &["--zones", "--kinematics", "linear"]);
    assert_says(&message, &["do not separate zone_1_modulus_factor, zone_2_modulus_factor;"]);
}
