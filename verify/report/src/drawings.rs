//! Drawings of a study, made with [`figures`](finray_figures).

use super::format::{list, thickness};
use crate::prelude::*;
use finray_figures::{Bars, Lines, Marker, Paint};
use finray_model::finger::{FingerDescription, FingerPoint, Part};

/// Palette of errors: largest error of each class, %, and its colour (red, green, blue). The three shades of green mean trusted; amber and red do
/// not. Colours become darker on both sides of the 10 % threshold, so that the order is visible to colour-blind readers and in grey prints.
const ERROR_CLASSES: [(f64, [u8; 3]); 5] = [
    (2.0, [0x1f, 0x8a, 0x57]),
    (5.0, [0x6c, 0xbf, 0x8b]),
    (10.0, [0xc4, 0xe6, 0xca]),
    (25.0, [0xf2, 0xb1, 0x34]),
    (f64::INFINITY, [0xb0, 0x35, 0x2b]),
];
/// Axis label of the position along the front plate, mm.
pub(super) const ALONG_THE_PLATE: &str = "position along the front plate from the base, mm";
/// Short axis label of the position along the front plate, for small plots.
const ALONG_IN_SHORT: &str = "position from the base, mm";
/// Axis label of the force direction, degrees.
pub(super) const DIRECTION_AXIS: &str = "force direction, deg from normal (+ to tip)";
/// Label of the finger frame's longitudinal axis, mm.
pub(super) const ALONG_AXIS: &str = "base to tip, mm";
/// Label of the finger frame's transverse axis, mm.
pub(super) const ACROSS_AXIS: &str = "back to front, mm";

/// Ranks of the cells that have no error: refused cells, then cells without an equilibrium. The ranks of cells without an error follow the ranks of
/// the error classes.
const REFUSED: usize = ERROR_CLASSES.len();
const NO_EQUILIBRIUM: usize = REFUSED + 1;

/// Rank of a cell: by its error if the cell was answered, otherwise by its state.
pub(super) fn rank_of(state: CellState, error: Option<f64>) -> usize {
    match (state, error) {
        (CellState::WithoutEquilibrium, _) => NO_EQUILIBRIUM,
        (CellState::Answered, Some(error)) => ERROR_CLASSES.iter().take_while(|class| 100.0 * error > class.0).count(),
        _ => REFUSED,
    }
}

/// Classes of errors by their largest error in percent, with legend text and fill.
pub fn percent_classes() -> Vec<Class> {
    let last = ERROR_CLASSES.len() - 1;
    let words = |rank: usize| match rank {
        0 => format!("up to {} %", ERROR_CLASSES[0].0),
        rank if rank == last => format!("above {} %", ERROR_CLASSES[rank - 1].0),
        rank => format!("{} to {} %", ERROR_CLASSES[rank - 1].0, ERROR_CLASSES[rank].0),
    };
    let class = |(rank, (up_to, colour)): (usize, &(f64, [u8; 3]))| Class {
        up_to: *up_to,
        label: words(rank),
        sign: String::new(),
        fill: Paint::Colour(*colour),
    };
    ERROR_CLASSES.iter().enumerate().map(class).collect()
}

/// Classes of errors by rank, followed by the classes of refused cells and of cells without equilibrium.
pub(super) fn error_classes() -> Vec<Class> {
    let hatched = |label: &str, rising| Class {
        up_to: 0.0,
        label: label.to_owned(),
        sign: String::new(),
        fill: Paint::Hatch { rising },
    };
    let all = percent_classes().into_iter().chain([hatched("refused", true), hatched("no equilibrium", false)]);
    all.enumerate().map(|(rank, class)| Class { up_to: rank as f64, ..class }).collect()
}

/// Cells of a map, one row per direction, from values that are ordered by position, then direction.
pub(super) fn by_direction(s_mm: &[f64], angles_deg: &[f64], values: impl Iterator<Item = Option<f64>>) -> Cells {
    let values: Vec<Option<f64>> = values.collect();
    let of_angle = |angle: usize| values.iter().skip(angle).step_by(angles_deg.len()).copied().collect();
    Cells::new(s_mm, angles_deg, (0..angles_deg.len()).map(of_angle).collect())
}

/// Cells of a map with their error under one force, or under the worst force of each cell.
pub(super) fn error_cells(finger: &Finger, map: &AccuracyMap, force_n: Option<f64>) -> Cells {
    let ranks =
        map.worst_of(finger, force_n).into_iter().map(|cell| Some(rank_of(cell.state, cell.worst_error) as f64));
    by_direction(&map.request.positions_mm, &map.request.angles_deg, ranks)
}

/// Combines drawings into one, in rows of `columns` drawings.
pub(super) fn side_by_side(drawings: &[String], columns: usize) -> String {
    let sizes: Vec<[f64; 2]> = drawings.iter().map(|svg| size(svg)).collect();
    let (mut top, mut width, mut inner) = (0.0_f64, 0.0_f64, String::new());
    for (drawings, sizes) in drawings.chunks(columns).zip(sizes.chunks(columns)) {
        let mut left = 0.0;
        for (svg, [w, _]) in drawings.iter().zip(sizes) {
            let body = svg.split_once('>').map_or("", |(_, body)| body.trim_end().trim_end_matches("</svg>"));
            inner += &format!("<g transform=\"translate({left} {top})\">{body}</g>");
            left += w;
        }
        width = width.max(left);
        top += sizes.iter().map(|[_, h]| *h).fold(0.0, f64::max);
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {top}\" width=\"100%\" \
         style=\"display:block;height:auto;max-width:{width}px\" role=\"img\" stroke-linejoin=\"round\">{inner}</svg>"
    )
}

/// Width and height of a drawing, px, from its view box.
fn size(svg: &str) -> [f64; 2] {
    let inside =
        svg.split_once("viewBox=\"").and_then(|(_, rest)| rest.split_once('"')).map_or("", |(inside, _)| inside);
    let mut numbers = inside.split_whitespace().skip(2).filter_map(|number| number.parse().ok());
    [numbers.next().unwrap_or(0.0), numbers.next().unwrap_or(0.0)]
}

/// The drawing for a separate file: dark ink on white, instead of the page's colours.
pub fn standalone(svg: &str) -> String {
    let head = svg.find('>').map_or(0, |end| end + 1);
    let (open, rest) = svg.split_at(head);
    let open = open.replacen("<svg ", "<svg color=\"#1b1f24\" ", 1);
    format!("{open}<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{rest}")
}

/// Converts a vector to a point of a drawing, mm.
pub(super) fn point(v: &Vector) -> [f64; 2] {
    [v.x, v.y]
}

/// Accuracy map under one force (N), or under the worst force of each cell.
///
/// # Errors
/// [`FigureError`] if the map has no cells.
pub fn map_figure_svg(finger: &Finger, map: &AccuracyMap, force_n: Option<f64>) -> Result<String, FigureError> {
    let force = match (force_n, &map.request.forces_n[..]) {
        (Some(force_n), _) | (None, &[force_n]) => format!("{force_n} N"),
        (None, forces_n) => format!("worst of {} N", list(forces_n, ", ")),
    };
    let noise = if map.noise_mm > 0.0 { format!("{} mm noise", map.noise_mm) } else { "no noise".to_owned() };
    let title = format!("{}, {}, {}: {force}, {noise}", map.truth.label(), map.estimator.label(), map.situation);
    let alt = format!("Error of the sensed force by position along the front plate and direction: {title}.");
    plate_map(finger, Frame::half(title, alt), error_classes(), error_cells(finger, map, force_n)).svg()
}

/// A map over position along the plate and direction, with node numbers along its top.
pub(super) fn plate_map(finger: &Finger, frame: Frame, classes: Vec<Class>, cells: Cells) -> Map {
    let x = Axis::linear(ALONG_IN_SHORT);
    let y = Axis::linear(DIRECTION_AXIS).with_ticks((-4..=4).map(|i| f64::from(i) * 20.0));
    Map { top: Some(node_axis(finger)), ..Map::new(frame, [x, y], classes, vec![Some(cells)]) }
}

/// Small maps of ranked errors over the whole plate and all directions. `columns` contains the column names; `rows` contains the name and the cells
/// of each row.
pub(super) fn small_maps(
    finger: &Finger,
    frame: Frame,
    columns: Vec<String>,
    rows: Vec<(String, Vec<Option<Cells>>)>,
) -> Map {
    let (rows, plots): (Vec<String>, Vec<Vec<Option<Cells>>>) = rows.into_iter().unzip();
    // The plate's end has no tick, because its label would touch the first label of the next plot.
    let length_mm = finger.plate_length_mm(Plate::Front);
    let ticks = plate_ticks(length_mm, 1.5).filter(|tick| *tick < 0.85 * length_mm);
    let x = Axis::linear(ALONG_THE_PLATE).within(0.0, length_mm).with_ticks(ticks);
    let y = Axis::linear(DIRECTION_AXIS).within(-90.0, 90.0).with_ticks([-60.0, 0.0, 60.0]);
    let rest_label = "not computed".to_owned();
    Map { rows, columns, rest_label, ..Map::new(frame, [x, y], error_classes(), plots.concat()) }
}

/// Positions along a plate at round numbers of mm, starting at 0. The step is the largest round length for which `times` steps fit into the plate.
pub(super) fn plate_ticks(length_mm: f64, times: f64) -> impl Iterator<Item = f64> {
    let step_mm =
        [500.0, 200.0, 100.0, 50.0, 20.0, 10.0].into_iter().find(|step| times * step <= length_mm).unwrap_or(5.0);
    (0..).map(move |n| f64::from(n) * step_mm).take_while(move |tick| *tick <= length_mm)
}

/// Axis of node numbers along the front plate.
fn node_axis(finger: &Finger) -> Axis {
    // Every n-th node is numbered, so that the numbers do not overlap.
    let every = finger.contact_nodes().len().div_ceil(13);
    let marks = finger.contact_nodes().rev().step_by(every);
    Axis::linear("node")
        .named(marks.filter_map(|node| Some((finger.front_position_mm(node)?, node.to_string()))).collect())
}

/// Lines of the finger; `at` gives the position of a point of the finger in the drawing.
pub(super) fn lines_of(finger: &Finger, at: impl Fn(FingerPoint) -> Point) -> Lines {
    finger.outline().into_iter().map(|(_, points)| points.into_iter().map(&at).collect()).collect()
}

/// Lines of the undeformed front plate, back plate and ribs, mm.
pub(super) fn at_rest(finger: &Finger) -> [Lines; 3] {
    [Part::Front, Part::Back, Part::Ribs].map(|part| {
        let lines = finger.outline().into_iter().filter(|(of, _)| *of == part);
        lines.map(|(_, points)| points.into_iter().map(|at| point(&finger.point(at))).collect()).collect()
    })
}

/// Drawing of the finger with its dimensions, the numbers of its key nodes and ribs, and the sign of a direction.
pub(super) fn finger(study: &Study) -> Result<String, FigureError> {
    let finger = &study.finger;
    let FingerDescription { base_width_mm, front, back, ribs: rib, .. } = finger.description();
    let [plate, other, ribs] = at_rest(finger);
    let clamps = finger.clamped_nodes();
    let numbered = |nodes: Vec<NodeId>| -> (Vec<Point>, Vec<String>) {
        nodes.into_iter().map(|node| (point(&finger.position(node)), node.to_string())).unzip()
    };
    let free = (1..=finger.key_node_count()).map(NodeId).filter(|node| !clamps.contains(node)).collect();
    // Arrows near the middle of the front plate show the directions of forces at 0 and +40 degrees.
    let length = finger.plate_length_mm(Plate::Front);
    let middle = finger.plate_point(Plate::Front, 0.54 * length);
    let arrow = |angle_deg: f64, label: &str, hue| {
        let foot = middle - finger.direction(angle_deg) * (0.14 * length);
        Series::arrow([point(&foot), point(&middle)], label, hue)
    };
    let of_ribs = match (finger.rib_count(), rib.strip) {
        (0, _) => String::new(),
        (count, Some(strip)) if rib.thicknesses_mm.is_none() => {
            format!("ribs r1 to r{count}, {} mm thick", strip.thickness_mm)
        }
        (count, _) => format!("ribs r1 to r{count}"),
    };
    let rib_names = (0..finger.rib_count()).map(|rib| {
        let [one, end] = finger.rib_nodes(rib).map(|node| finger.position(node));
        (point(&((one + end) * 0.5)), format!("r{}", rib + 1))
    });
    let (points, labels) = rib_names.unzip();
    let names = Series { dash: Dash::None, marker: None, hue: Hue::GREEN, labels, ..Series::nth(0, "", points) };
    let mut series = Series::lines("front plate", plate, Hue::BLUE, 4.0);
    series.extend(Series::lines("back plate", other, Hue::VERMILION, 4.0));
    series.extend(Series::lines(&of_ribs, ribs, Hue::GREEN, 2.6));
    // Dimension lines lie outside the finger, at this distance.
    let off_mm = 0.1 * length;
    let foot = |plate| finger.plate_point(plate, 0.0);
    let tip = finger.position(finger.tip());
    let outward = |plate| -finger.direction_on(plate, 0.0) * off_mm;
    let along = |plate: Plate, thickness: String| {
        let words = format!("{} mm, {thickness} mm thick", finger.plate_length_mm(plate));
        dimension([foot(plate), tip], outward(plate), words)
    };
    let base =
        dimension([foot(Plate::Back), foot(Plate::Front)], Vector::new(-off_mm, 0.0), format!("{base_width_mm} mm"));
    let plates = [along(Plate::Front, thickness(front)), along(Plate::Back, thickness(back)), base];
    series.extend(plates.into_iter().flatten());
    if !names.points.is_empty() {
        series.push(names);
    }
    series.extend([
        Series::marks("node", Marker::Node, numbered(free)),
        Series::marks("clamped node", Marker::Clamp, numbered(clamps.to_vec())),
        arrow(0.0, "0 deg", Hue::BLUE),
        arrow(40.0, "+40 deg", Hue::VERMILION),
    ]);
    let alt = "The finger with its dimensions and its numbered key nodes and ribs; the base is on the left, the tip on the right.";
    Chart::to_scale(Frame::full("Dimensions and numbers", alt), [ALONG_AXIS, ACROSS_AXIS], series).svg()
}

/// A dimension line beside the line from one point to another, mm, at the distance `off`, with extension lines. Its text
/// stands at a third, beside the arrows at the middle of the front plate.
fn dimension([from, to]: [Vector; 2], off: Vector, words: String) -> Vec<Series> {
    let [start, end] = [from + off, to + off];
    let lines = vec![
        vec![point(&start), point(&(start * 0.7 + end * 0.3)), point(&end)],
        vec![point(&(from + off * 0.2)), point(&(from + off * 1.2))],
        vec![point(&(to + off * 0.2)), point(&(to + off * 1.2))],
    ];
    let mut series = Series::lines("", lines, Hue::NEUTRAL, 1.0);
    series[0].labels = vec![String::new(), words, String::new()];
    series
}

/// Drawing of the finger, undeformed and under load.
pub(super) fn bent(study: &Study) -> Result<String, FigureError> {
    let finger = &study.finger;
    let mut series = Series::lines("at rest", at_rest(finger).concat(), Hue::FAINT, 3.0);
    for (n, bent) in study.bent.iter().enumerate() {
        let lines = bent.lines.iter().map(|line| line.iter().map(point).collect()).collect();
        let dash = if bent.kinematics == Kinematics::Linear { Dash::Dotted } else { Dash::Solid };
        let lines = Series::lines(&bent.label, lines, Hue::nth(n / 2), 2.4);
        series.extend(lines.into_iter().map(|line| Series { dash, ..line }));
    }
    for (n, bent) in study.bent.iter().enumerate().filter(|(_, bent)| bent.kinematics != Kinematics::Linear) {
        let reach = bent.force.normalize() * (0.1 * finger.plate_length_mm(Plate::Front));
        series.push(Series::arrow([point(&(bent.at - reach)), point(&bent.at)], "", Hue::nth(n / 2)));
    }
    let alt = "The finger at rest and bent by a force at one of three nodes, with linear and co-rotational kinematics.";
    let frame = Frame::full(format!("At rest and under {} N", study.forces.drawn_n()), alt);
    Chart::to_scale(frame, [ALONG_AXIS, ACROSS_AXIS], series).svg()
}

/// Bars of errors in percent; `errors` are shares.
pub(super) fn error_bars(label: impl Into<String>, hue: Hue, errors: impl IntoIterator<Item = Option<f64>>) -> Bars {
    let percent = |error: f64| match error {
        small if small < 0.00995 => (1e4 * small).round() / 100.0,
        large => (1e3 * large).round() / 10.0,
    };
    Bars { label: label.into(), hue, values: errors.into_iter().map(|error| error.map(percent)).collect() }
}

/// Series of true values (line), and of sensed values with their intervals (symbols). A series without points is left out.
pub(super) fn true_and_sensed(
    n: usize,
    name: impl Into<String>,
    truth: Vec<Point>,
    (sensed, spread): (Vec<Point>, Vec<[f64; 2]>),
) -> Vec<Series> {
    let truth = Series { marker: None, ..Series::nth(n, name, truth) };
    let sensed = Series { dash: Dash::None, spread, ..Series::nth(n, "", sensed) };
    [truth, sensed].into_iter().filter(|series| !series.points.is_empty()).collect()
}

/// A line of a chart by contact: its text in the legend, and the function that reads its value from a row (`None` if the value is missing).
pub(super) type Line<'l, R> = (&'l str, fn(&R) -> Option<f64>);

/// Chart of quantities by contact on a logarithmic axis, with one line per quantity; values that are not above zero are left out. `None` if there is
/// nothing to draw.
pub(super) fn by_contact<R>(
    frame: Frame,
    axis: &str,
    rows: &[(String, R)],
    lines: &[Line<R>],
) -> Result<Option<String>, FigureError> {
    let line = |(n, (label, of)): (usize, &Line<R>)| {
        let values = rows.iter().enumerate().filter_map(|(i, (_, row))| Some([i as f64, of(row)?]));
        Series::nth(n, *label, values.filter(|[_, value]| *value > 0.0).collect())
    };
    let series: Vec<Series> = lines.iter().enumerate().map(line).filter(|series| !series.points.is_empty()).collect();
    if series.is_empty() {
        return Ok(None);
    }
    let x = Axis::categories("contact node, base to tip", rows.iter().map(|(name, _)| name.clone()).collect());
    Chart::new(frame, [x, Axis::log(axis)], series).svg().map(Some)
}

/// Two charts [by contact](by_contact): of single contacts, and of pairs. A row is a pair if its name has a comma.
pub(super) fn one_and_two<R>(
    title: &str,
    axis: &str,
    rows: Vec<(String, R)>,
    lines: &[Line<R>],
    csv: &str,
) -> Result<Block, FigureError> {
    let (pairs, singles): (Vec<_>, Vec<_>) = rows.into_iter().partition(|(name, _)| name.contains(','));
    let mut figures = Vec::new();
    for (rows, which) in [(singles, "one contact"), (pairs, "two contacts")] {
        let title = format!("{title}: {which}");
        let alt = format!("{title}, on a logarithmic axis.");
        let drawn = by_contact(Frame::half(title, alt), axis, &rows, lines)?;
        figures.extend(drawn.map(|svg| Figure::narrow(svg, "By contact node, from base to tip.", csv)));
    }
    Ok(Block::Figures(figures))
}
