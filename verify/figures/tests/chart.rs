//! Tests of charts and of drawings to scale: all series, symbols and labels are drawn, and numbers that have no position on an axis are refused.

use finray_figures::{Axis, Chart, FigureError, Frame, Hue, Marker, Series};

fn chart() -> Chart {
    let points = vec![[1.0, 0.5], [2.0, 3.0], [3.0, 40.0]];
    let series = vec![Series::nth(0, "linear", points.clone()), Series::nth(1, "co-rotational", points)];
    let frame = Frame::half("Error over force", "error over force");
    Chart::new(frame, [Axis::linear("force, N"), Axis::log("error, %")], series).compared([(10.0, "10 %".to_owned())])
}

#[test]
fn every_series_has_its_line_its_markers_and_its_words() {
    let mut chart = chart();
    chart.series[0].labels = ["first", "second", "third"].map(str::to_owned).into();
    let svg = chart.svg().unwrap();
    // The four filled shapes are the symbols of three points, and one symbol in the legend. The two strokes are the line, and its sample in the
    // legend.
    assert_eq!(svg.matches("fill=\"#1f82c4\"").count(), 4);
    assert_eq!(svg.matches("stroke=\"#d55e00\"").count(), 2);
    assert!(["10 %", "first", "second", "third", "linear"].iter().all(|words| svg.contains(&format!(">{words}<"))));
}

#[test]
fn a_spread_reaching_zero_on_a_log_axis_is_cut_at_its_foot() {
    let mut chart = chart();
    chart.series[0].spread = vec![[0.0, 1.0], [2.0, 4.0], [30.0, 50.0]];
    let svg = chart.svg().unwrap();
    assert!(!svg.contains("NaN") && !svg.contains("inf") && !svg.contains("-2147483648"), "{svg}");
}

#[test]
fn what_has_no_position_on_the_axes_is_refused() {
    let broken = |change: fn(&mut Chart)| {
        let mut chart = chart();
        change(&mut chart);
        chart.svg().unwrap_err()
    };
    assert!(matches!(broken(|chart| chart.series[0].points[0][1] = 0.0), FigureError::NotPositive(_)));
    assert!(matches!(broken(|chart| chart.series[0].points[0][1] = f64::NAN), FigureError::NotFinite(_)));
    assert!(matches!(broken(|chart| chart.series[0].points.clear()), FigureError::Empty(_)));
    assert!(matches!(broken(|chart| chart.series.clear()), FigureError::Empty(_)));
    assert!(matches!(broken(|chart| chart.series[0].labels.push(String::new())), FigureError::Mismatch(_, 3, 1)));
    let short = |chart: &mut Chart| chart.series[0].spread = vec![[0.4, 1.0]];
    assert!(matches!(broken(short), FigureError::Mismatch(_, 3, 1)));
}

#[test]
fn a_drawing_to_scale_has_its_lines_nodes_clamps_and_arrows_and_its_words() {
    let plate = vec![[0.0, 0.0], [75.0, 0.0], [150.0, 20.0]];
    let nodes = |numbers: &[usize]| {
        (numbers.iter().map(|n| plate[*n]).collect(), numbers.iter().map(|n| format!("n{n}")).collect())
    };
    let mut series = Series::lines("plate", vec![plate.clone(), vec![[75.0, 0.0], [75.0, 40.0]]], Hue::BLUE, 4.0);
    series.push(Series::marks("node", Marker::Node, nodes(&[1, 2])));
    series.push(Series::marks("clamped node", Marker::Clamp, nodes(&[0])));
    series.push(Series::arrow([[40.0, -20.0], [40.0, 0.0]], "3 N", Hue::VERMILION));
    let svg = Chart::to_scale(Frame::full("", "a plate"), ["x, mm", "y, mm"], series).svg().unwrap();
    assert!(
        ["plate", "node", "clamped node", "n0", "n1", "n2", "3 N"]
            .iter()
            .all(|words| svg.contains(&format!(">{words}<")))
    );
    // The five circles are three nodes, and two samples in the legend. Polygon: the head of the arrow.
    assert_eq!((svg.matches("<circle").count(), svg.matches("<polygon").count()), (5, 1));
    let ends = |line: &str| -> Vec<f64> {
        line.split('"').nth(1).unwrap().split([' ', ',']).map(|number| number.parse().unwrap()).collect()
    };
    let lines: Vec<Vec<f64>> = svg.lines().filter(|line| line.contains("#1f82c4")).map(ends).collect();
    let (across, up) = ((lines[0][2] - lines[0][0]) / 75.0, (lines[1][1] - lines[1][3]) / 40.0);
    assert!((across / up - 1.0).abs() < 0.01, "{lines:?}");
}
