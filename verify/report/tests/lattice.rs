//! Figures and tables of the lattice: missing equilibria and errors are stated, not drawn.

mod samples;
mod words;

use finray_report::lattice::{axial, data, drawing, sensing_figure, settled};
use finray_studies::lattice::accuracy::FinenessRow;
use samples::sample;

#[test]
fn a_line_a_force_is_drawn() {
    let rows = sample().rows;
    let svg = drawing(&rows).expect("a figure");
    for words in [">1 N</text>", ">5 N</text>", ">2</text>", ">4</text>"] {
        assert!(svg.contains(words), "{words}");
    }
    // An error of zero has no position on a logarithmic axis, and a single fineness determines no slope.
    let one = FinenessRow { errors: vec![0.0, 1e-3], ..rows[0].clone() };
    let svg = drawing(&[one]).expect("a figure");
    assert!(!svg.contains(">1 N</text>") && !svg.contains("fourth order"));
}

#[test]
fn both_estimators_are_drawn_and_their_cells_named() {
    let figure = sensing_figure(&sample()).expect("a figure");
    assert!(figure.svg.contains(">least squares</text>") && figure.svg.contains(">nonlinear</text>"));
    assert_eq!(figure.csv.as_deref(), Some("map_lattice_nonlinear_without_noise.csv"));
}

#[test]
fn what_has_no_equilibrium_or_does_not_settle_is_said() {
    let mut study = sample();
    let none = axial(&study).rows.pop().expect("springs left out");
    assert_eq!(none[2].text, "no equilibrium");
    let file = data(Some(&study))[1].csv().expect("text").expect("a file").1;
    assert_eq!(file.lines().filter(|line| line.ends_with(',')).count(), 2);
    study.settling[4].error = None;
    let single = settled().table("", "", &study.settling).rows.pop().expect("single precision");
    assert_eq!(single.iter().map(|cell| cell.text.as_str()).collect::<Vec<_>>(), ["32", "single", "-"]);
}
