//! Drawings of a study: its numbers arranged for [`figures`](crate::figures).

use crate::experiments::table_one::TableOne;
use crate::figures::{
    Axis, Bars, Cells, Chart, Class, ColourScale, Dash, FigureError, Frame, Hue, Lines, Map, Marker, Point, Series,
    Shades,
};
use crate::sampling::map::AccuracyMap;
use crate::study::Study;
use finray_model::finger::Plate;
use finray_model::{Finger, Kinematics, NodeId, Vector};

/// The paper's two shades: grey above 10 %, dark above 25 %.
pub(super) const PAPER_SHADES_PERCENT: [f64; 2] = [10.0, 25.0];
/// One colour scale for all maps, %.
const ERROR_SCALE_PERCENT: [f64; 2] = [0.1, 100.0];
pub(super) const ALONG_THE_PLATE: &str = "position along the front plate from the base, mm";
pub(super) const DIRECTION_AXIS: &str = "force direction, deg from normal (+ to tip)";
pub(super) const ALONG_AXIS: &str = "base to tip, mm";
pub(super) const ACROSS_AXIS: &str = "back to front, mm";

/// What a map's colours say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Mean of |sensed / true - 1|.
    Error,
    /// What is wrong even without noise, either way.
    Bias,
    /// Standard deviation over the noise.
    Spread,
}

/// The same drawing as a file of its own: dark ink on white, where a page would lend its colours.
pub fn standalone(svg: &str) -> String {
    let head = svg.find('>').map_or(0, |end| end + 1);
    let (open, rest) = svg.split_at(head);
    let open = open.replacen("<svg ", "<svg color=\"#1b1f24\" ", 1);
    format!("{open}<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{rest}")
}

pub(super) fn point(v: &Vector) -> [f64; 2] {
    [v.x, v.y]
}

/// Accuracy map of one force, or of the mean over all.
///
/// # Errors
/// [`FigureError`] if the map has no cells.
pub fn map_figure_svg(finger: &Finger, map: &AccuracyMap, force_n: Option<f64>) -> Result<String, FigureError> {
    quantity_svg(finger, map, force_n, Quantity::Error)
}

/// The same of any quantity of the cells, on the same colours.
///
/// # Errors
/// [`FigureError`] if the map has no cells.
pub(super) fn quantity_svg(
    finger: &Finger,
    map: &AccuracyMap,
    force_n: Option<f64>,
    quantity: Quantity,
) -> Result<String, FigureError> {
    let force = force_n.map_or_else(
        || match map.request.forces_n[..] {
            [one] => format!("{one} N"),
            _ => "mean over all forces".to_owned(),
        },
        |f| format!("{f} N"),
    );
    let noise = if map.noise_mm > 0.0 { format!("{} mm noise", map.noise_mm) } else { "no noise".to_owned() };
    let truth = map.truth.label();
    let (title, what, values, value_label) = match quantity {
        Quantity::Error => {
            let title = format!("{truth} truth, {noise}, {force}");
            (title, "Error", map.errors(force_n), "error |sensed / true - 1|, %")
        }
        Quantity::Bias => {
            let title = format!("bias: {truth} truth, {}", map.estimator.label());
            (title, "Bias", map.values(force_n, |cell| cell.bias.map(f64::abs)), "|mean of sensed / true - 1|, %")
        }
        Quantity::Spread => {
            let title = format!("spread: {truth} truth, {}", map.estimator.label());
            (title, "Spread", map.values(force_n, |cell| cell.spread), "standard deviation of sensed / true, %")
        }
    };
    let alt = format!(
        "{what} of the sensed force by position along the front plate and direction: {title}, {} estimator.",
        map.estimator.label()
    );
    let percent = |error: Option<f64>| error.map(|e| 100.0 * e);
    let values = values.into_iter().map(|row| row.into_iter().map(percent).collect()).collect();
    let cells = Cells::new(&map.request.positions_mm, &map.request.angles_deg, values);
    let shades = Shades::Scale(error_colours(), value_label.to_owned());
    let missing_label = missing_label(map).to_owned();
    Map { missing_label, ..plate_map(finger, Frame::half(title, alt), shades, cells) }.svg()
}

/// The colours of errors, %, one scale for all maps.
pub(super) fn error_colours() -> ColourScale {
    ColourScale::log(ERROR_SCALE_PERCENT[0], ERROR_SCALE_PERCENT[1])
}

/// A map over position along the plate and direction, with node numbers along its top and contours at the paper's shades.
pub(super) fn plate_map(finger: &Finger, frame: Frame, shades: Shades, cells: Cells) -> Map {
    let y = Axis::linear(DIRECTION_AXIS).with_ticks((-4..=4).map(|i| f64::from(i) * 20.0));
    Map {
        contours: PAPER_SHADES_PERCENT.to_vec(),
        contour_unit: " %",
        missing_label: "no equilibrium".to_owned(),
        top: Some(node_axis(finger)),
        ..Map::new(frame, [Axis::linear(ALONG_THE_PLATE), y], shades, cells)
    }
}

/// Small maps over the whole plate and all directions in the paper's shades: names of the columns, and rows with theirs.
pub(super) fn small_maps(
    finger: &Finger,
    frame: Frame,
    columns: Vec<String>,
    rows: Vec<(String, Vec<Option<Cells>>)>,
    missing_label: &str,
) -> Map {
    let [grey, dark] = PAPER_SHADES_PERCENT;
    let class = |up_to, label: String, colour| Class { up_to, label, sign: String::new(), colour };
    let (rows, plots): (Vec<String>, Vec<Vec<Option<Cells>>>) = rows.into_iter().unzip();
    // From clear to dark, the same in light and dark mode: the order of lightness carries the meaning.
    let shades = Shades::Classes(vec![
        class(grey, format!("clear: error up to {grey} %"), [0xd9, 0xee, 0xdf]),
        class(dark, format!("grey: up to {dark} %"), [0xa4, 0xac, 0xb5]),
        class(f64::INFINITY, format!("dark: above {dark} %"), [0x41, 0x49, 0x53]),
    ]);
    let x = Axis::linear(ALONG_THE_PLATE).within(0.0, finger.plate_length_mm(Plate::Front));
    let y = Axis::linear(DIRECTION_AXIS).within(-90.0, 90.0).with_ticks([-60.0, 0.0, 60.0]);
    Map { columns, missing_label: missing_label.to_owned(), ..Map::grid(frame, [x, y], shades, rows, plots.concat()) }
}

/// Why cells are empty: linear sensing answers whatever it is shown.
fn missing_label(map: &AccuracyMap) -> &'static str {
    if map.estimator.is_linear() { "no equilibrium" } else { "no equilibrium, or refused" }
}

/// Node numbers along the front plate.
fn node_axis(finger: &Finger) -> Axis {
    // Thinned evenly, so that they do not run into each other.
    let every = finger.contact_nodes().len().div_ceil(13);
    let marks = finger.contact_nodes().rev().step_by(every);
    Axis::linear("node")
        .named(marks.filter_map(|node| Some((finger.front_position_mm(node)?, node.to_string()))).collect())
}

/// A line to compare percentages with.
pub(super) fn percent_line(value: f64) -> (f64, String) {
    (value, format!("{value} %"))
}

/// Error along the front plate for forces along the normal, one line a force.
pub(super) fn errors_along_the_normal(map: &AccuracyMap) -> Result<String, FigureError> {
    let title = format!(
        "Along the normal, {} truth, {}",
        map.truth.label(),
        if map.noise_mm > 0.0 { format!("{} mm noise", map.noise_mm) } else { "no noise".to_owned() }
    );
    let series = map
        .request
        .forces_n
        .iter()
        .enumerate()
        .map(|(n, &force_n)| {
            let cells = map.cells.iter().filter(|c| c.force_n == force_n && c.angle_deg == 0.0);
            let points = cells.filter_map(|c| Some([c.s_mm, 100.0 * c.mean_error?])).collect();
            Series { marker: None, ..Series::nth(n, format!("{force_n} N"), points) }
        })
        .collect();
    let alt = format!("{title}: error of the sensed force by position, one line a force.");
    let axes = [Axis::linear(ALONG_THE_PLATE), Axis::linear("error |sensed / true - 1|, %")];
    Chart::new(Frame::half(title, alt), axes, series).compared([percent_line(PAPER_SHADES_PERCENT[0])]).svg()
}

/// Plates and ribs, at rest.
fn at_rest(finger: &Finger) -> [Lines; 3] {
    let through = |nodes: &[NodeId]| nodes.iter().map(|node| point(&finger.position(*node))).collect();
    let [front, back] = [Plate::Front, Plate::Back].map(|plate| vec![through(&finger.plate_nodes(plate))]);
    [front, back, (0..finger.rib_count()).map(|rib| through(&finger.rib_nodes(rib))).collect()]
}

/// The finger with its node numbers.
pub(super) fn finger(study: &Study) -> Result<String, FigureError> {
    let finger = &study.finger;
    let [front, back, ribs] = at_rest(finger);
    let clamps = finger.clamped_nodes();
    let numbered = |nodes: Vec<NodeId>| -> (Vec<Point>, Vec<String>) {
        nodes.into_iter().map(|node| (point(&finger.position(node)), node.to_string())).unzip()
    };
    let free = (1..=finger.key_node_count()).map(NodeId).filter(|node| !clamps.contains(node)).collect();
    // An arrow on the middle of the front plate shows what an angle of zero means.
    let length = finger.plate_length_mm(Plate::Front);
    let middle = finger.plate_point(Plate::Front, 0.54 * length);
    let arrow = |angle_deg: f64, label: &str, hue| {
        let foot = middle - finger.direction(angle_deg) * (0.14 * length);
        Series::arrow([point(&foot), point(&middle)], label, hue)
    };
    let plates = Series::lines("front plate", front, Hue::Blue, 4.0).into_iter().chain(Series::lines(
        "back plate",
        back,
        Hue::Vermilion,
        4.0,
    ));
    let marks = [
        Series::marks("node", Marker::Node, numbered(free)),
        Series::marks("clamped node", Marker::Clamp, numbered(clamps.to_vec())),
        arrow(0.0, "0 deg", Hue::Blue),
        arrow(40.0, "+40 deg", Hue::Vermilion),
    ];
    let alt = "The finger with its numbered key nodes; the base is on the left, the tip on the right.";
    let series = plates.chain(Series::lines("ribs", ribs, Hue::Green, 2.6)).chain(marks).collect();
    Chart::to_scale(Frame::full("", alt), [ALONG_AXIS, ACROSS_AXIS], series).svg()
}

/// The finger at rest and bent.
pub(super) fn bent(study: &Study) -> Result<String, FigureError> {
    let finger = &study.finger;
    let mut series = Series::lines("at rest", at_rest(finger).concat(), Hue::Faint, 3.0);
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
    let alt = "The finger at rest and bent by a force at three nodes, linear and co-rotational.";
    Chart::to_scale(Frame::full("", alt), [ALONG_AXIS, ACROSS_AXIS], series).svg()
}

/// Table I as bars: the paper's mean errors and ours.
pub(super) fn table_one(tables: &[TableOne]) -> Result<String, FigureError> {
    let rows = tables.first().map_or(&[][..], |table| &table.rows[..]);
    let percent = |error: f64| Some((1000.0 * error).round() / 10.0);
    let paper = Bars {
        label: "paper".to_owned(),
        hue: Hue::Neutral,
        values: rows.iter().map(|row| percent(row.paper_mean_error)).collect(),
    };
    let ours = tables.iter().take(2).enumerate().map(|(n, table)| Bars {
        label: format!("co-rotational, weights at {} deg", table.angle_deg),
        hue: Hue::nth(n),
        values: table.rows.iter().map(|row| percent(row.mean_error)).collect(),
    });
    let frame = Frame::full("", "Mean error of the sensed force at six nodes: the paper's Table I and ours.");
    let nodes = Axis::categories("loaded node", rows.iter().map(|row| row.node.to_string()).collect());
    let bars = std::iter::once(paper).chain(ours).collect();
    let chart = Chart::of_bars(frame, [nodes, Axis::linear("mean error, %")], bars);
    chart.compared(PAPER_SHADES_PERCENT.map(percent_line)).svg()
}
