//! Columns of a sweep's rows, and refused sweeps.

use super::{BLOCKS, HEADER, MAP, ROWS_IN_BLOCK, SWEPT, with};
use crate::kit::*;

#[test]
fn a_row_says_all_that_is_known_of_a_cell() {
    assert_eq!(SWEPT.lines().next(), Some(HEADER));
    let table = Csv::of(&SWEPT);
    assert_eq!(table.rows.len(), BLOCKS * ROWS_IN_BLOCK);
    // Columns by which the rows are sorted: truth, position, direction, estimator, noise, force. The force changes fastest.
    let key = |row: &[String]| -> Vec<String> { [0, 3, 4, 1, 2, 5].iter().map(|&i| row[i].clone()).collect() };
    let mut keys: Vec<_> = table.rows.iter().map(|row| key(row)).collect();
    assert_eq!(
        keys[..3].iter().map(|key| key[3..].join(" ")).collect::<Vec<_>>(),
        ["least-squares 0.0 0.5", "least-squares 0.0 3.0", "least-squares 0.067 0.5"]
    );
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), table.rows.len(), "every combination once");
    let numbers = |column| table.numbers(column);
    let (noise, samples, answered) = (numbers("noise_mm"), numbers("samples"), numbers("answered"));
    let (mean, bias, spread, sigma) = (numbers("mean_error"), numbers("bias"), numbers("spread"), numbers("sigma_n"));
    for i in 0..table.rows.len() {
        assert_eq!(samples[i], if noise[i] > 0.0 { 5.0 } else { 1.0 });
        assert_eq!(answered[i], samples[i]);
        assert!(mean[i] >= bias[i].abs());
        assert_eq!(spread[i] > 0.0, noise[i] > 0.0);
        // Without noise, the standard deviation may be zero.
        assert!(sigma[i] > 0.0 || noise[i] == 0.0);
    }
    assert!(table.texts("refusal").iter().all(|refusal| refusal.is_empty()));
}

/// Map and sweep have the same results.
#[test]
fn a_map_is_a_sweep_with_fewer_columns() {
    let map = Csv::of(&finray(&MAP).done());
    let sweep = Csv::of(&finray(&with(&["sweep"], &MAP[1..])).done());
    for column in &map.header {
        assert_eq!(map.texts(column), sweep.texts(column), "{column}");
    }
    // The forces of one cell are in successive rows.
    assert_eq!(map.texts("force_n")[..4], ["1.0", "2.0", "1.0", "2.0"]);
}

/// The sweep states the same standard deviation as `sense`.
#[test]
fn the_stated_deviation_is_that_of_sense() {
    let arguments = ["--truth", "linear", "--noise-mm", "0.1", "--seeds", "3", "--force-n", "2", "--places", "12"];
    let arguments = [&["--estimator", "least-squares"], &arguments[..]].concat();
    let table = Csv::of(&finray(&with(&["sweep", PAPER], &arguments)).done());
    let at = |row: &Vec<String>| row[3] == "76.5" && row[4] == "0.0";
    let row = table.rows.iter().position(at).expect("the middle of the plate");
    let shape = finray(&["solve", PAPER, "--kinematics", "linear", "--load-at", "76.5:2,0"]).done();
    let sense = ["sense", PAPER, "--displacements", "-", "--contact-at", "76.5", "--noise-mm", "0.1"];
    let sense = [&sense[..], &["--estimator", "least-squares"]].concat();
    let sigma = Csv::of(&finray_reading(shape.as_bytes(), &sense).done()).numbers("sigma_n");
    assert_close(&table.numbers("sigma_n")[row..=row], &sigma, LINEAR_ROUNDING);
}

/// The asymmetric finger was solved as beams and, with rods, as a continuum. The shapes from MuJoCo exist for directions that are 30 degrees apart,
/// and the shapes from the continuum model for -40, 0 and 40 degrees. The normal is the only direction for which both have shapes.
#[test]
fn exported_fingers_are_swept_where_all_have_shapes() {
    let folder = Folder::new();
    let rods = format!("{}\n[contact]\nrod_radius_mm = 1.75\n", finray_fixtures::ASYMMETRIC_SCENE);
    let scene = folder.put("scene.toml", rods);
    let sweep = ["sweep", &scene, "--truth", "mujoco,continuum", "--estimator", "least-squares", "--force-n", "3"];
    let table = Csv::of(&finray(&sweep).done());
    assert_eq!(table.rows.len(), 2 * 7);
    assert!(table.numbers("angle_deg").iter().all(|angle| *angle == 0.0));
    assert!(table.numbers("answered").iter().all(|answered| *answered == 1.0), "every shape was exported");
}

#[test]
fn sweeps_that_make_no_sense_are_refused() {
    for (arguments, expected) in [
        (["--force-n", "1,0"], "expected more than zero"),
        (["--noise-mm", "0.1,-1"], "expected zero or more"),
        (["--places", "0"], "0"),
        (["--step-deg", "0"], "expected 0.01 or more"),
        (["--truth", "linear,plastic"], "corotational, twin, lattice, mujoco, continuum, linear"),
        (["--estimator", "ridge,guess"], "least-squares"),
        (["--network", "net.safetensors"], "--estimator network"),
    ] {
        assert_says(&finray(&with(&["sweep", PAPER], &arguments)).refused(), &[expected]);
    }
    // All shipped networks are for the paper's finger.
    assert_says(&finray(&["sweep", SPRING_STEEL, "--estimator", "network"]).refused(), &["no network ships"]);
}

/// Networks return forces only for the contacts for which they were trained; the nonlinear estimator returns forces for all contacts.
#[test]
fn every_estimator_can_be_mapped() {
    let folder = Folder::new();
    let out = folder.path("map.csv");
    let nodes = ["--places", "12", "--step-deg", "40", "--noise-mm", "0.067", "--seeds", "3", "--out", &out];
    // The shipped networks include one for each single node from 14 to 24 and one for any subset of nodes 13 to 24; all are for forces along the
    // normal.
    for (estimator, answered) in [("network", 12), ("nonlinear", 60)] {
        finray(&[&["map", PAPER, "--estimator", estimator], &nodes[..]].concat()).done();
        let map = Csv::of(&folder.read("map.csv"));
        let errors: Vec<f64> = map.texts("mean_error").iter().filter_map(|error| error.parse().ok()).collect();
        assert_eq!(errors.len(), answered, "{estimator}");
        // For 3 N with noise, the errors are below 10 %, an error that linear sensing reaches.
        assert!(errors.iter().all(|error| *error < 0.1), "{estimator}: {errors:?}");
        let empty = errors.len() < map.rows.len();
        assert_eq!(folder.read("map.svg").contains(">refused<"), empty);
    }
    let reasons = ["sweep", PAPER, "--estimator", "network", "--places", "12", "--step-deg", "40"];
    let table = Csv::of(&finray(&reasons).done());
    let refusals = table.texts("refusal");
    assert_eq!(refusals.iter().filter(|refusal| refusal.contains("no network ships for these contacts")).count(), 48);
}

/// If the finger cannot carry the force, the row states this.
#[test]
fn a_force_without_equilibrium_is_named() {
    let folder = Folder::new();
    let scene = folder.put("scene.toml", paper_with(&[("count = 11", "count = 0")]));
    let table = Csv::of(
        &finray(&["sweep", &scene, "--estimator", "least-squares", "--force-n", "0.15", "--step-deg", "40"]).done(),
    );
    let empty = table.rows.iter().filter(|row| row[8].is_empty());
    let mut count = 0;
    for row in empty {
        assert!(row[12].contains("no equilibrium") && row[6] == "0" && row[7] == "0", "{row:?}");
        count += 1;
    }
    assert!(count > 0 && count < table.rows.len());
}
