//! Tests of bar charts: heights are proportional to values, and invalid bars are refused.

use finray_figures::{Axis, Bars, Chart, FigureError, Frame, Hue};

fn chart() -> Chart {
    let bars =
        |label: &str, hue, values: [Option<f64>; 2]| Bars { label: label.to_owned(), hue, values: values.into() };
    let bars = vec![bars("paper", Hue::BLUE, [Some(2.0), Some(4.0)]), bars("ours", Hue::ORANGE, [Some(1.0), None])];
    let categories = Axis::categories("node", vec!["14".to_owned(), "16".to_owned()]);
    Chart::of_bars(Frame::full("Error by node", "error by node"), [categories, Axis::linear("error, %")], bars)
}

/// Heights of the drawn bars of one colour, without the patch in the legend.
fn heights(svg: &str, colour: &str) -> Vec<f64> {
    let bars = svg.lines().filter(|line| line.starts_with("<rect") && line.contains(colour));
    let height = |line: &str| line.split("height=\"").nth(1)?.split('"').next()?.parse().ok();
    let heights: Vec<f64> = bars.filter_map(height).collect();
    heights[..heights.len() - 1].to_vec()
}

#[test]
fn bars_are_as_tall_as_their_values() {
    let svg = chart().svg().unwrap();
    let (blue, orange) = (heights(&svg, "#1f82c4"), heights(&svg, "#e69f00"));
    assert_eq!((blue.len(), orange.len()), (2, 1));
    assert!((blue[1] / blue[0] - 2.0).abs() < 0.01 && (blue[0] / orange[0] - 2.0).abs() < 0.01, "{blue:?} {orange:?}");
    assert!(svg.contains(">–</text>") && svg.contains(">paper</text>"));
}

#[test]
fn narrow_bars_have_their_values_written_upwards_with_room_above() {
    let [wide, narrow] = [2, 40].map(|count| {
        let mut chart = chart();
        chart.x = Axis::categories("node", (0..count).map(|node| node.to_string()).collect());
        chart.bars.iter_mut().for_each(|bars| bars.values = vec![Some(1234.0); count]);
        chart.svg().unwrap()
    });
    assert!(!wide.contains("rotate(270") && narrow.contains("rotate(270"));
    let tallest = |svg: &str| heights(svg, "#1f82c4").into_iter().fold(0.0, f64::max);
    assert!(tallest(&narrow) < tallest(&wide) - 10.0);
}

#[test]
fn what_makes_no_bar_is_refused() {
    let refusal = |change: fn(&mut Chart)| {
        let mut broken = chart();
        change(&mut broken);
        broken.svg().unwrap_err()
    };
    assert!(matches!(refusal(|c| c.bars[0].values[0] = Some(f64::INFINITY)), FigureError::NotFinite(_)));
    assert!(matches!(refusal(|c| c.bars[0].values[0] = Some(-1.0)), FigureError::NotPositive(_)));
    assert!(matches!(refusal(|c| c.bars[0].values.truncate(1)), FigureError::Mismatch(_, 2, 1)));
    assert!(matches!(refusal(|c| c.y = Axis::log("error, %")), FigureError::NotPositive(_)));
}
