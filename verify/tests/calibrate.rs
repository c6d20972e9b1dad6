//! `finray calibrate`: measured shapes under known loads in, Young's modulus out.

mod common;

use common::*;
use std::fmt::Write;

const COLUMNS: &str = "case,load_node,fx_n,fy_n,node,ux_mm,uy_mm\n";
/// Rounding of displacements, and of the search for the factor.
const RECOVERED: f64 = 1e-9;
/// Loads of two cases: node and force.
const LOADS: [(usize, [f64; 2]); 2] = [(17, [0.1, -1.0]), (21, [-0.2, -2.0])];

/// Measurements of all free nodes of a linear finger under the loads, a case each.
fn measured(scene: &str) -> String {
    let mut text = COLUMNS.to_owned();
    for (case, (load_node, [fx, fy])) in LOADS.iter().enumerate() {
        let load = format!("{load_node}:{fx},{fy}");
        let shape = Csv::of(&finray(&["solve", scene, "--kinematics", "linear", "--load", &load]).done());
        let markers = shape.texts("node").into_iter().zip(shape.texts("ux_mm")).zip(shape.texts("uy_mm"));
        for ((node, ux), uy) in markers {
            writeln!(text, "weight {case},{load_node},{fx},{fy},{node},{ux},{uy}").expect("memory");
        }
    }
    text
}

fn calibrate(scene: &str, measurements: &str) -> Answer {
    finray_reading(measurements.as_bytes(), &["calibrate", scene, "--measurements", "-"])
}

#[test]
fn a_softer_finger_gives_its_own_modulus() {
    let folder = Folder::new();
    // Every modulus by 0.8, written out: the scene has but one.
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
    // Ribs that do not deform have no modulus.
    let load = ["solve", SPRING_STEEL, "--kinematics", "linear", "--load", "8:0,-1"];
    let shape = finray(&load).done();
    let rows: String = shape
        .lines()
        .skip(1)
        .map(|line| line.split(',').collect::<Vec<_>>())
        .map(|cells| format!("a,8,0,-1,{},{},{}\n", cells[0], cells[3], cells[4]))
        .collect();
    let answer = Csv::of(&calibrate(SPRING_STEEL, &(COLUMNS.to_owned() + &rows)).done());
    assert_eq!(answer.texts("parameter"), [names[0], names[1], names[3]]);
    assert_close(&answer.numbers("value")[2..], &[1.0], RECOVERED);
}

/// Rows in another order and columns between them; sums of distances forgive one marker that was taken for another.
#[test]
fn order_does_not_matter_and_single_bad_markers_hardly() {
    let text = measured(PAPER);
    let mut rows: Vec<_> = text.lines().skip(1).collect();
    rows.reverse();
    rows.swap(3, 30);
    let shuffled = format!("{COLUMNS}{}\r\n", rows.join("\r\n"));
    let factor = |text: &str| {
        let answer = Csv::of(&calibrate(PAPER, text).done());
        (answer.numbers("value")[1], answer.numbers("sigma")[1])
    };
    assert_close(&[factor(&shuffled).0], &[1.0], RECOVERED);
    let bad = rows.iter().position(|row| row.starts_with("weight 1,21,-0.2,-2,5,")).expect("node 5");
    rows[bad] = "weight 1,21,-0.2,-2,5,3.0,-9.0";
    let (factor, sigma) = factor(&format!("{COLUMNS}{}", rows.join("\n")));
    assert!((factor - 1.0).abs() < 1e-3 && sigma >= 0.0, "{factor} +- {sigma}");
}

#[test]
fn measurements_that_do_not_fit_are_refused_by_file_and_line() {
    let folder = Folder::new();
    let good = "a,19,0,-1,7,0,-1\n";
    for (rows, expected) in [
        ("a,19,0,-1,8,0,-1\na,19,0,-1.1,9,0,-1\n", "line 4: case a: expected the load of the case's first row again"),
        ("b,19,0,-1,8,0,-1\na,18,0,-1,9,0,-1\n", "line 4: case a: expected the load of the case's first row again"),
        ("a,19,0,-1,7,0,-1\n", "line 3: node 7 is listed twice"),
        ("a,19,0,-1,26,0,-1\n", "line 3: node 26 does not exist"),
        ("a,19,0,-1,25,0,-1\n", "line 3: node 25 is clamped"),
        ("b,1,0,-1,7,0,-1\n", "line 3: node 1 is clamped: a load there"),
        ("b,27,0,-1,7,0,-1\n", "line 3: node 27 does not exist"),
        ("b,19,0,down,7,0,-1\n", "line 3: fy_n: expected a finite number, found \"down\""),
        ("b,19,0,nan,7,0,-1\n", "line 3: fy_n: expected a finite number"),
        ("b,19,0,-1,7,inf,-1\n", "line 3: ux_mm: expected a finite number"),
        ("b,tip,0,-1,7,0,-1\n", "line 3: load_node: expected the number of a node, found \"tip\""),
        ("b,19,0,-1,7,0\n", "line 3: expected 7 columns as in the header, found 6"),
    ] {
        let path = folder.put("weights.csv", format!("{COLUMNS}{good}{rows}"));
        let message = finray(&["calibrate", PAPER, "--measurements", &path]).refused();
        assert_says(&message, &[&path, expected]);
    }
    for (text, expected) in [
        ("", "found nothing"),
        (COLUMNS, "expected rows of case,load_node,fx_n,fy_n,node,ux_mm,uy_mm, found none"),
        ("case,load_node,fx_n,node,ux_mm,uy_mm\na,19,0,7,0,-1\n", "line 1: expected a column fy_n"),
    ] {
        let path = folder.put("weights.csv", text);
        assert_says(&finray(&["calibrate", PAPER, "--measurements", &path]).refused(), &[&path, expected]);
    }
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
        assert_says(&calibrate(PAPER, &(COLUMNS.to_owned() + rows)).refused(), &[expected]);
    }
}
