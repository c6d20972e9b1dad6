//! Tests of the layout of all figures: heading, ticks with their labels, line breaks, legends and other labels.

use finray_figures::{Axis, Cells, Chart, Class, FigureError, Frame, Hue, Map, Marker, Paint, Point, Series};

/// Words of a drawing with their anchors, in the order in which they are drawn.
fn words(svg: &str) -> Vec<(String, Point)> {
    let of_line = |line: &str| {
        let coordinate = |name: &str| line.split(name).nth(1)?.split('"').next()?.parse().ok();
        let text = line.split('>').nth(1)?.split('<').next()?;
        Some((text.to_owned(), [coordinate(" x=\"")?, coordinate(" y=\"")?]))
    };
    svg.lines().filter(|line| line.starts_with("<text")).filter_map(of_line).collect()
}

fn anchor(svg: &str, text: &str) -> Point {
    let found = words(svg).into_iter().find(|(word, _)| word == text);
    found.unwrap_or_else(|| panic!("{text} is not in {svg}")).1
}

/// Points, px, of the lines whose markup contains `with`.
fn lines(svg: &str, with: &str) -> Vec<Vec<Point>> {
    let drawn = svg.lines().filter(|line| line.starts_with("<polyline") && line.contains(with));
    let points = drawn.map(|line| {
        let points = line.split('"').nth(1).expect("points").split(' ');
        let point = points.map(|point| {
            let numbers: Vec<f64> = point.split(',').map(|number| number.parse().expect("a number")).collect();
            [numbers[0], numbers[1]]
        });
        point.collect()
    });
    points.collect()
}

/// A dotted line in the page's text colour; its colour differs from all colours for which the tests search.
fn guide(points: Vec<Point>) -> Vec<Series> {
    vec![Series::guide("", points)]
}

/// Names of the ticks on the vertical axis, from bottom to top.
fn ticks(y: Axis, points: Vec<Point>) -> Vec<String> {
    let frame = Frame::full("", "ticks").with_plot_height(360.0);
    let svg = Chart::new(frame, [Axis::linear("").with_ticks([]), y], guide(points)).svg().expect("a chart");
    let mut names = words(&svg);
    names.retain(|(text, _)| !text.is_empty());
    names.sort_by(|a, b| b.1[1].total_cmp(&a.1[1]));
    names.into_iter().map(|(text, _)| text).collect()
}

/// Names of the ticks between two limits.
fn within(axis: Axis, low: f64, high: f64) -> String {
    ticks(axis.within(low, high), vec![[0.0, low], [1.0, high]]).join(" ")
}

#[test]
fn the_drawing_scales_and_has_a_name() {
    let frame = Frame::full("a < b & \"c\"", "what it shows");
    let axes = [Axis::linear("x").within(0.0, 1.0), Axis::linear("y").within(0.0, 1.0)];
    let svg = Chart::new(frame, axes, guide(vec![[0.0, 0.0], [1.0, 1.0]])).svg().unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && svg.matches("<svg").count() == 1);
    assert!(svg.contains("viewBox=\"0 0 900 ") && svg.contains("width=\"100%\"") && svg.contains("role=\"img\""));
    assert!(svg.contains("<title>a &lt; b &amp; \"c\"</title><desc>what it shows</desc>"));
    assert!(svg.contains("aria-label=\"a &lt; b &amp; &quot;c&quot;\""));
}

#[test]
fn neutral_ink_is_the_page_s_and_words_are_escaped() {
    let labels = vec!["fill=\"#010203\" & <i>".to_owned(), String::new()];
    let series = vec![Series { labels, ..Series::guide("", vec![[0.0, 0.0], [1.0, 1.0]]) }];
    let svg = Chart::new(Frame::half("", "ink"), [Axis::linear("x"), Axis::linear("y")], series).svg().unwrap();
    assert!(svg.contains("stroke=\"currentColor\"") && svg.contains("var(--paper,Canvas)"));
    assert!(!svg.contains("stroke=\"#01020") && !svg.contains("#000000"), "{svg}");
    assert!(svg.contains(">fill=\"#010203\" &amp; &lt;i&gt;</text>"));
}

#[test]
fn a_line_ends_where_its_axes_do() {
    let axes = [Axis::linear("x").within(0.0, 1.0), Axis::linear("y").within(0.0, 1.0)];
    let series = Series::lines("line", vec![vec![[0.0, 0.0], [1.0, 1.0]]], Hue::BLUE, 2.0);
    let svg = Chart::new(Frame::full("", "ends"), axes, series).svg().unwrap();
    let drawn = &lines(&svg, "#1f82c4")[0];
    // The outline of the plot is closed.
    let outline = lines(&svg, "currentColor").into_iter().find(|line| line.len() == 5).expect("an outline");
    let [[left, top], _, [right, bottom], ..] = outline[..] else { panic!("{outline:?}") };
    let off = [drawn[0][0] - left, drawn[0][1] - bottom, drawn[1][0] - right, drawn[1][1] - top];
    assert!(off.iter().all(|off| off.abs() < 0.2), "{drawn:?} in {outline:?}");
}

#[test]
fn ticks_are_round_and_within_the_span() {
    assert_eq!(within(Axis::linear(""), -60.0, 60.0), "−60 −40 −20 0 20 40 60");
    assert_eq!(within(Axis::linear(""), 0.0, 0.5), "0 0.1 0.2 0.3 0.4 0.5");
    assert_eq!(within(Axis::log(""), 0.01, 100.0), "0.01 0.1 1 10 100");
    assert_eq!(within(Axis::log(""), 1.0, 20.0), "1 2 5 10 20");
}

#[test]
fn names_that_would_touch_are_left_out_and_their_ticks_stay() {
    let drawn = |places: &[f64]| {
        let x = Axis::linear("").within(0.0, 10.0).with_ticks(places.iter().copied());
        let y = Axis::linear("").within(0.0, 1.0).with_ticks([]);
        Chart::new(Frame::full("", "ticks"), [x, y], guide(vec![[0.0, 0.0], [10.0, 1.0]])).svg().unwrap()
    };
    let crowded = drawn(&[0.0, 4.0, 4.1, 10.0, 11.0]);
    let names: Vec<String> =
        words(&crowded).into_iter().map(|(text, _)| text).filter(|text| !text.is_empty()).collect();
    assert_eq!(names, ["0", "4", "10"]);
    // A tick without a name still has a line.
    assert!(lines(&crowded, "currentColor").len() > lines(&drawn(&[0.0, 4.0, 10.0]), "currentColor").len());
}

#[test]
fn a_log_axis_has_its_geometric_mean_in_the_middle() {
    let axes = [Axis::linear("x"), Axis::log("y").within(0.1, 10.0)];
    let series = Series::lines("line", vec![vec![[0.0, 0.1], [1.0, 1.0], [2.0, 10.0]]], Hue::BLUE, 2.0);
    let svg = Chart::new(Frame::full("", "log"), axes, series).svg().unwrap();
    let [low, middle, high] = lines(&svg, "#1f82c4")[0][..] else { panic!("three points") };
    assert!((2.0 * middle[1] - low[1] - high[1]).abs() < 0.3, "{low:?} {middle:?} {high:?}");
}

#[test]
fn the_span_holds_the_data_and_refuses_what_has_no_position() {
    let ends = |axis: Axis, data: &[f64]| {
        let names = ticks(axis, (0..).map(f64::from).zip(data.iter().copied()).map(Point::from).collect());
        [names[0].clone(), names[names.len() - 1].clone()]
    };
    assert_eq!(ends(Axis::linear(""), &[0.3, 9.7]), ["0", "10"]);
    assert_eq!(ends(Axis::linear(""), &[3.0]), ["1.5", "4.5"]);
    assert_eq!(ends(Axis::log(""), &[0.3, 40.0]), ["0.2", "50"]);
    let refused = |axis: Axis, data: Vec<Point>| {
        Chart::new(Frame::full("", "refused"), [Axis::linear("x"), axis], guide(data)).svg().unwrap_err()
    };
    let two = |low: f64, high: f64| vec![[0.0, low], [1.0, high]];
    assert!(matches!(refused(Axis::log("y"), two(0.0, 1.0)), FigureError::NotPositive(_)));
    assert!(matches!(refused(Axis::linear("y"), two(0.0, f64::NAN)), FigureError::NotFinite(_)));
    assert!(matches!(refused(Axis::linear("y").within(1.0, 1.0), two(1.0, 1.0)), FigureError::NoRoom(..)));
}

#[test]
fn numbers_keep_three_digits_and_lose_trailing_zeros() {
    let named = |value: f64| {
        let axis = Axis::linear("").with_ticks([value]);
        ticks(axis.within(value - 1.0, value + 1.0), vec![[0.0, value]]).concat()
    };
    let numbers = [0.0, -2.5, 0.012_34, 1234.6, 100.0, 1e-6, 2.5e7, -0.0];
    assert_eq!(numbers.map(named), ["0", "−2.5", "0.0123", "1235", "100", "10⁻⁶", "2.5×10⁷", "0"]);
}

#[test]
fn a_long_heading_is_broken_and_loses_no_word() {
    let title = "force found from the shape of the front plate against the force applied";
    let axes = [Axis::linear("x").with_ticks([]), Axis::linear("y").with_ticks([])];
    let svg = Chart::new(Frame::third(title, ""), axes, guide(vec![[0.0, 0.0], [1.0, 1.0]])).svg().unwrap();
    let heading: Vec<String> =
        svg.lines().filter(|line| line.contains("font-weight")).flat_map(words).map(|(text, _)| text).collect();
    assert!(heading.len() > 1 && heading.join(" ") == title, "{heading:?}");
}

#[test]
fn entries_go_on_in_the_next_row_and_long_words_are_broken() {
    let rows = |labels: &[&str]| {
        let series = labels.iter().map(|label| Series::guide(*label, vec![[0.0, 0.0], [1.0, 1.0]]));
        let axes = [Axis::linear("x"), Axis::linear("y")];
        Chart::new(Frame::third("", "legend"), axes, series.collect()).svg().unwrap()
    };
    let svg = rows(&["the first entry", "the second one", "the third of them"]);
    let [first, second, third] =
        ["the first entry", "the second one", "the third of them"].map(|text| anchor(&svg, text));
    assert!(first[1] == second[1] && first[0] < second[0] && third[1] > first[1] && third[0] == first[0]);
    let long = "a co-rotational solution with every node free to turn, and two";
    let svg = rows(&[long, "", "next"]);
    let broken: Vec<_> = words(&svg).into_iter().filter(|(text, _)| !text.is_empty() && long.contains(text)).collect();
    assert!(
        broken.len() > 1 && broken[1].1[1] > broken[0].1[1] && anchor(&svg, "next")[1] > broken[1].1[1],
        "{broken:?}"
    );
}

/// Width and height of a label with three digits, px.
const LABEL_PX: [f64; 2] = [29.0, 14.0];

#[test]
fn crowded_labels_hide_neither_each_other_nor_the_line() {
    let points: Vec<Point> = (0..8).map(|i| [0.3 + 0.02 * f64::from(i), 0.5]).collect();
    let line = vec![[0.0, 0.5], [1.0, 0.5]];
    let labels = points.iter().enumerate().map(|(i, _)| format!("{}", 120 + i)).collect();
    let marks = Series { marker: None, ..Series::marks("", Marker::Node, (points, labels)) };
    let axes = [Axis::linear("x").within(0.0, 1.0), Axis::linear("y").within(0.0, 1.0)];
    let series = vec![Series::lines("", vec![line], Hue::BLUE, 2.0).remove(0), marks];
    let svg = Chart::new(Frame::full("", "labels"), axes, series).svg().unwrap();
    let level = lines(&svg, "#1f82c4")[0][0][1];
    let at: Vec<Point> = (120..128).map(|label| anchor(&svg, &label.to_string())).collect();
    for (i, [x, y]) in at.iter().enumerate() {
        // The position of a text is on its baseline, so the letters lie above it.
        assert!(*y < level || *y > level + LABEL_PX[1] - 3.0, "{y} on {level}");
        let apart = |[left, up]: &Point| (x - left).abs() >= LABEL_PX[0] || (y - up).abs() >= LABEL_PX[1];
        assert!(at[..i].iter().all(apart), "{at:?}");
    }
}

#[test]
fn words_of_a_drawing_stand_outside_its_lines() {
    let plate = |from: Point, to: Point| vec![from, [75.0, (from[1] + to[1]) / 2.0], to];
    let plates = vec![plate([0.0, 0.0], [150.0, 20.0]), plate([0.0, 58.0], [150.0, 20.0])];
    let mut series = Series::lines("plates", plates, Hue::BLUE, 4.0);
    let nodes = vec![[75.0, 10.0], [75.0, 39.0]];
    series.push(Series::marks("", Marker::Node, (nodes, vec!["lower".to_owned(), "upper".to_owned()])));
    let svg = Chart::to_scale(Frame::full("", "two plates"), ["x", "y"], series).svg().unwrap();
    let drawn = lines(&svg, "#1f82c4");
    // The y coordinate grows downwards.
    assert!(anchor(&svg, "lower")[1] > drawn[0][1][1] && anchor(&svg, "upper")[1] < drawn[1][1][1]);
}

#[test]
fn cells_meet_halfway_and_reach_as_far_beyond_the_ends() {
    let values = vec![vec![Some(1.0), Some(2.0), Some(3.0)]];
    let class =
        |up_to: f64| Class { up_to, label: String::new(), sign: String::new(), fill: Paint::Colour([up_to as u8; 3]) };
    let cells = vec![Some(Cells::new(&[10.0, 20.0, 35.0], &[0.0], values))];
    let axes = [Axis::linear("x"), Axis::linear("y").within(-1.0, 1.0)];
    let svg = Map::new(Frame::full("", "cells"), axes, [1.0, 2.0, 3.0].map(class).into(), cells).svg().unwrap();
    let lefts = svg.lines().filter(|line| line.starts_with("<rect"));
    let lefts: Vec<f64> = lefts.map(|line| line.split('"').nth(1).unwrap().parse().unwrap()).collect();
    // The edges of the cells are at 5, 15, 27.5 and 42.5.
    assert!(((lefts[1] - lefts[0]) / (lefts[2] - lefts[1]) - 10.0 / 12.5).abs() < 0.01, "{lefts:?}");
    let outline = lines(&svg, "currentColor").into_iter().find(|line| line.len() == 5).expect("an outline");
    assert!(((outline[1][0] - lefts[2]) / (lefts[1] - lefts[0]) - 1.5).abs() < 0.01, "{lefts:?} {outline:?}");
}
