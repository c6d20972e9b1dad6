//! Tests of maps: every cell is drawn, hatched or listed, and lists of wrong length are refused.

use finray_figures::{Axis, Cells, Class, FigureError, Frame, Map, Paint};

fn axes() -> [Axis; 2] {
    [Axis::linear("position, mm"), Axis::linear("direction, deg")]
}

fn cells(values: [[Option<f64>; 3]; 2]) -> Cells {
    let values = values.map(Vec::from).into();
    Cells { note: "all clear".to_owned(), x: vec![10.0, 20.0, 35.0], y: vec![-30.0, 0.0], values }
}

fn classes(plots: Vec<Option<Cells>>) -> Map {
    let class = |up_to, label: &str, sign: &str, grey| Class {
        up_to,
        label: label.into(),
        sign: sign.into(),
        fill: Paint::Colour([grey; 3]),
    };
    let classes = vec![class(10.0, "clear", "", 9), class(25.0, "grey", "G", 8), class(99.0, "dark", "D", 7)];
    let rows = vec!["linear".to_owned(); plots.len()];
    let map = Map::new(Frame::full("Errors", "errors"), axes(), classes, plots);
    Map { missing_label: "refused".to_owned(), rows, ..map }
}

fn map(values: [[f64; 3]; 2]) -> Map {
    let top = Some(Axis::linear("node").named(vec![(20.0, "n24".to_owned())]));
    let classes = classes(Vec::new()).classes;
    let plots = vec![Some(cells(values.map(|row| row.map(Some))))];
    let lone = Map::new(Frame::half("Error", "error"), axes(), classes, plots);
    Map { missing_label: "no equilibrium".to_owned(), top, ..lone }
}

/// Number of filled cells: all drawn rectangles except `others`, the number of rectangles in the legend.
fn filled(map: &Map, others: usize) -> usize {
    map.svg().unwrap().matches("<rect ").count() - others
}

const VALUES: [[f64; 3]; 2] = [[0.1, 12.0, 0.9], [12.7, 8.1, 24.3]];

#[test]
fn every_cell_is_drawn_and_one_without_value_is_hatched_and_explained() {
    let mut map = map(VALUES);
    assert_eq!(filled(&map, 2), 6);
    assert!(!map.svg().unwrap().contains("no equilibrium") && map.svg().unwrap().contains(">n24<"));
    map.plots[0] = Some(cells([[Some(0.1), None, Some(3.0)], [Some(7.0), Some(19.0), Some(2.0)]]));
    assert!(filled(&map, 2) == 5 && map.svg().unwrap().contains(">no equilibrium<"));
}

#[test]
fn values_are_written_into_their_cells_and_blank_ones_stay_empty() {
    let written = Map { written: Some(|value| format!("v{value}")), blank: |row, column| row == column, ..map(VALUES) };
    let svg = written.svg().unwrap();
    assert!(filled(&written, 2) == 4 && svg.contains(">v12<") && !svg.contains(">v0.1<"));
    assert!(!svg.contains("no equilibrium"));
}

#[test]
fn neighbours_of_a_class_are_one_and_only_classes_that_are_there_are_listed() {
    let one = cells([[Some(10.0), Some(25.0), Some(25.0)], [None, Some(1.0), Some(1.0)]]);
    let lone = Cells { y: vec![0.0], values: vec![vec![Some(1.0); 3]], ..one.clone() };
    let map = classes(vec![Some(one), None, Some(lone)]);
    let svg = map.svg().unwrap();
    assert_eq!(filled(&map, 2), 2 + 1 + 1);
    assert!([">clear<", ">G: grey<", ">refused<", ">linear<", ">all clear<"].iter().all(|words| svg.contains(words)));
    assert!(!svg.contains("dark"));
}

#[test]
fn data_that_do_not_fit_together_are_refused() {
    let refusal = |change: fn(&mut Cells)| {
        let mut broken = map(VALUES);
        broken.plots.iter_mut().flatten().for_each(change);
        broken.svg().unwrap_err()
    };
    assert!(matches!(refusal(|cells| cells.values.truncate(1)), FigureError::Mismatch(_, 2, 1)));
    assert!(matches!(refusal(|cells| cells.values[0].truncate(1)), FigureError::Mismatch(_, 3, 1)));
    assert!(matches!(refusal(|cells| cells.x.swap(1, 2)), FigureError::NotMonotone(_)));
    assert!(matches!(refusal(|cells| cells.values[0][0] = Some(f64::NAN)), FigureError::NotFinite(_)));
    assert!(matches!(classes(vec![]).svg(), Err(FigureError::Empty(_))));
    let unknown = cells([[Some(100.0); 3]; 2]);
    assert!(matches!(classes(vec![Some(unknown)]).svg(), Err(FigureError::Empty(_))));
}
