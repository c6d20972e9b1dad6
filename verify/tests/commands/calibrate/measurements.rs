//! Measured shapes with large deflection, with hidden or wrong markers, and of the linear finger.

use super::{calibrate, measured};
use crate::kit::*;

/// Under the same weights, the linear finger bends more than the co-rotational finger. A calibration of the linear finger attributes this difference
/// to stiffness.
#[test]
fn weights_that_bend_far_lead_to_the_true_modulus() {
    let folder = Folder::new();
    let truth = folder.put("truth.toml", paper_with(&[("47.976", "43.1784")]));
    let loads = [(17, 1.0), (19, 2.0), (21, 3.0)].map(|(node, force_n)| (node, paper_force(force_n, 0.0)));
    let exact = weighed(&truth, &["--mesh-nodes", "130"], &loads);
    // Deterministic noise of +0.05 mm or -0.05 mm.
    let noisy = |(i, line): (usize, &str)| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if i > 0 && !matches!(&*cells[4], "1" | "25") {
            for (k, cell) in cells[5..].iter_mut().enumerate() {
                let noise_mm = 0.05 * (1.0 - 2.0 * ((7 * i + 5 * k) % 2) as f64);
                *cell = (cell.parse::<f64>().expect("a number") + noise_mm).to_string();
            }
        }
        cells.join(",") + "\n"
    };
    let text: String = exact.lines().enumerate().map(noisy).collect();
    let modulus = |answer: &str| {
        let answer = Csv::of(answer);
        assert_eq!(answer.texts("parameter"), ["youngs_modulus_mpa", "modulus_factor"]);
        (answer.numbers("value")[1], answer.numbers("sigma")[1])
    };
    let (factor, sigma) =
        modulus(&finray_reading(text.as_bytes(), &["calibrate", PAPER, "--measurements", "-"]).done());
    assert!((factor - 0.9).abs() < 3.0 * sigma && sigma < 0.005, "{factor} +- {sigma}");
    // With `--kinematics linear`, the command succeeds with a warning, and the standard deviation covers the model error.
    let (answer, warnings) = calibrate(PAPER, &text).warned();
    let (linear, wide) = modulus(&answer);
    assert!((linear - 0.9).abs() > 3.0 * sigma && (linear - 0.9).abs() < 3.0 * wide, "{linear} +- {wide}");
    assert_says(
        &warnings[0],
        &["the co-rotational finger is closer", "--kinematics linear", "sigma includes the difference"],
    );
    // For shapes of a linear finger, a warning states that the linear finger is closer to the shapes.
    let (_, warnings) =
        finray_reading(measured(&truth).as_bytes(), &["calibrate", PAPER, "--measurements", "-"]).warned();
    assert_says(&warnings.concat(), &["the linear finger is closer", "modulus_factor is 0.9000"]);
    // A wrongly assigned marker is named in a warning, and hardly changes the result.
    let row =
        text.lines().find(|row| row.starts_with("weight 2,21,") && row.split(',').nth(4) == Some("5")).expect("node 5");
    let (answer, warnings) = finray_reading(
        text.replace(row, &format!("{},3.0,-25.0", row.rsplitn(3, ',').last().expect("cells"))).as_bytes(),
        &["calibrate", PAPER, "--measurements", "-"],
    )
    .warned();
    assert!((modulus(&answer).0 - factor).abs() < sigma, "{answer}");
    assert!(warnings.len() == 1 && warnings[0].contains("case 3 in the order of the file: node 5 is"), "{warnings:?}");
}

/// As in the tables for `sense`, empty cells stand for a hidden marker.
#[test]
fn empty_cells_are_a_hidden_marker() {
    let exact = measured(PAPER);
    let is_hidden =
        |line: &&str| line.starts_with("weight 1,21,-0.2,-2,5,") || line.starts_with("weight 0,17,0.1,-1,8,");
    let missing: String = exact.lines().filter(|line| !is_hidden(line)).map(|line| format!("{line}\n")).collect();
    let emptied = |line: &str, cells: &str| {
        let rest: Vec<&str> = line.splitn(6, ',').take(5).collect();
        if is_hidden(&line) { format!("{},{cells}\n", rest.join(",")) } else { format!("{line}\n") }
    };
    let empty: String = exact.lines().map(|line| emptied(line, ",")).collect();
    assert_ne!(missing, exact);
    assert_eq!(calibrate(PAPER, &empty).done(), calibrate(PAPER, &missing).done());
    let half: String = exact.lines().map(|line| emptied(line, "1.0,")).collect();
    assert_says(&calibrate(PAPER, &half).refused(), &["uy_mm: ", "for a hidden marker, leave both cells empty"]);
    let none = format!("{WEIGHTS}a,19,0,-1,7,,\na,19,0,-1,8,,\n");
    assert_says(&calibrate(PAPER, &none).refused(), &["hidden"]);
}
