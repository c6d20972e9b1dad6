//! Drawings to scale: the finger as it is built or bent, its numbered nodes, clamps and forces.

use super::axis::Axis;
use super::colour::{Hue, TEXT};
use super::error::{FigureError, require, require_finite};
use super::geometry::{Area, Lines, Point, along, direction, gap, segments};
use super::labels::{Label, Obstacles};
use super::legend::Entry;
use super::marks::{self, CLAMP_DEPTH};
use super::panels::{Frame, Panels, Plot};
use super::sheet::{Dash, Pen, SPACE, Sheet};

/// Lines, nodes and arrows in a plane in which a millimetre is as long across as up.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Heading, description and size.
    pub frame: Frame,
    /// Label of the level axis, e.g. "base to tip, mm".
    pub x_label: String,
    /// Label of the upright axis.
    pub y_label: String,
    /// Lines, in the order they are drawn and listed in.
    pub strokes: Vec<Stroke>,
    /// Nodes to number.
    pub nodes: Vec<NodeMark>,
    /// Forces or directions.
    pub arrows: Vec<Arrow>,
}

/// Lines of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// Words in the legend, e.g. "3 N at node 19, co-rotational".
    pub label: String,
    /// The lines, in millimetres.
    pub lines: Lines,
    /// Colour; neutral lines are drawn faintly.
    pub hue: Hue,
    /// How the lines are broken.
    pub dash: Dash,
    /// Width, px.
    pub width: f64,
}

/// A numbered node.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeMark {
    /// Its number.
    pub number: usize,
    /// Its position, in millimetres.
    pub at: Point,
    /// Whether position and direction are held.
    pub clamped: bool,
}

/// An arrow with words.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrow {
    /// Its foot, in millimetres.
    pub from: Point,
    /// Its point, in millimetres.
    pub to: Point,
    /// What it is; no words are written when empty.
    pub label: String,
    /// Its colour.
    pub hue: Hue,
}

impl Stroke {
    /// Unbroken lines.
    pub fn new(label: impl Into<String>, lines: Lines, hue: Hue, width: f64) -> Self {
        Self { label: label.into(), lines, hue, dash: Dash::Solid, width }
    }

    fn pen(&self) -> Pen {
        let pen = Pen::new(self.hue.ink(), self.width).dashed(self.dash);
        if self.hue == Hue::Neutral { pen.faint(0.35) } else { pen }
    }
}

/// Room around the drawing for numbers and clamps, px.
const MARGIN: f64 = 44.0;
/// Room for tick labels of four letters, and right of the plot, px.
const SIDES: [f64; 2] = [58.0, 2.0 * SPACE];

impl Drawing {
    /// The drawing as SVG.
    ///
    /// # Errors
    /// [`FigureError`] if a line has no points, or a coordinate is not finite.
    pub fn svg(&self) -> Result<String, FigureError> {
        for stroke in &self.strokes {
            require(!stroke.lines.is_empty(), FigureError::Empty, &stroke.label)?;
        }
        let ends = self.arrows.iter().flat_map(|arrow| [arrow.from, arrow.to]);
        let lines: Lines = self.strokes.iter().flat_map(|stroke| stroke.lines.iter().cloned()).collect();
        let points: Vec<Point> =
            lines.iter().flatten().copied().chain(self.nodes.iter().map(|node| node.at)).chain(ends).collect();
        require(!points.is_empty(), FigureError::Empty, "drawing")?;
        require_finite("drawing", points.iter().flatten())?;
        let Area { left, right, top: low, bottom: high } = around(&points);
        let width = self.frame.width - SIDES[0] - SIDES[1];
        let most = self.frame.plot_height.unwrap_or(self.frame.width * 0.75);
        let per_mm =
            [(width, right - left), (most, high - low)].map(|(room, size)| (room - 2.0 * MARGIN) / size.max(1e-9));
        let per_mm = per_mm[0].min(per_mm[1]);
        let height = (high - low) * per_mm + 2.0 * MARGIN;
        let axis = |label: &String, low: f64, high: f64, pixels: f64| {
            let (middle, half) = ((low + high) / 2.0, pixels / per_mm / 2.0);
            Axis::linear(label).within(middle - half, middle + half)
        };
        let axes = [axis(&self.x_label, left, right, width), axis(&self.y_label, low, high, height)];
        let mut panels = Panels::new(&self.frame, [&axes[0], &axes[1]]);
        (panels.height, panels.sides, panels.legend) = (height, SIDES, self.legend());
        panels.draw(|sheet, plots, _| {
            let plot = &plots[0];
            for stroke in &self.strokes {
                stroke.lines.iter().try_for_each(|line| sheet.line(&plot.line(line), stroke.pen()))?;
            }
            let mut obstacles = Obstacles {
                lines: lines.iter().map(|line| plot.line(line)).collect(),
                areas: Vec::new(),
                within: plot.area,
            };
            let mut labels = self.node_labels(sheet, plot, &mut obstacles)?;
            labels.extend(self.arrow_labels(sheet, plot, &mut obstacles)?);
            obstacles.write(sheet, &labels)
        })
    }

    fn legend(&self) -> Vec<Entry<'_>> {
        let line = |stroke: &Stroke| {
            let pen = stroke.pen();
            Entry::new(&stroke.label, move |sheet, area| {
                sheet.line(&[area.left, area.right].map(|x| [x, area.centre()[1]]), pen)
            })
        };
        let mut entries: Vec<Entry> = self.strokes.iter().map(line).collect();
        if self.nodes.iter().any(|node| !node.clamped) {
            entries.push(Entry::new("node", |sheet, area| sheet.disc(area.centre(), 4.0, TEXT)));
        }
        if self.nodes.iter().any(|node| node.clamped) {
            let clamp =
                |sheet: &Sheet, area: Area| marks::clamp(sheet, along(area.centre(), [1.0, 0.0], 8.0), [-1.0, 0.0]);
            entries.push(Entry::new("clamped node", clamp));
        }
        entries
    }

    /// Draws nodes and clamps; their numbers are to stand outside the finger.
    fn node_labels(&self, sheet: &Sheet, plot: &Plot, obstacles: &mut Obstacles) -> Result<Vec<Label>, FigureError> {
        let points: Vec<Point> = obstacles.lines.concat();
        let Some(bounds) = (!self.nodes.is_empty()).then(|| around(&points)) else { return Ok(Vec::new()) };
        let mut labels = Vec::new();
        for node in &self.nodes {
            let at = plot.at(node.at);
            if node.clamped {
                let ground = nearest_side(at, bounds);
                marks::clamp(sheet, at, ground)?;
                let middle = along(at, ground, CLAMP_DEPTH / 2.0);
                obstacles.areas.push(Area::about(middle, CLAMP_DEPTH, CLAMP_DEPTH));
            }
            sheet.disc(at, 4.0, TEXT)?;
            obstacles.areas.push(Area::about(at, 11.0, 11.0));
            let side = outward(at, &obstacles.lines, bounds.centre());
            labels.push(Label { text: node.number.to_string(), anchor: at, side });
        }
        Ok(labels)
    }

    /// Draws arrows; their words are to stand at the end that lies freer.
    fn arrow_labels(&self, sheet: &Sheet, plot: &Plot, obstacles: &mut Obstacles) -> Result<Vec<Label>, FigureError> {
        let mut labels = Vec::new();
        let lines = obstacles.lines.clone();
        for Arrow { from, to, label, hue } in &self.arrows {
            let [from, to] = [*from, *to].map(|end| plot.at(end));
            marks::arrow(sheet, from, to, hue.ink())?;
            obstacles.lines.push(vec![from, to]);
            let clear = |end: Point| segments(&lines).map(|pair| gap(end, pair)).fold(f64::INFINITY, f64::min);
            let (anchor, other) = if clear(from) >= clear(to) { (from, to) } else { (to, from) };
            let side = direction(other, anchor).unwrap_or([0.0, -1.0]);
            labels.push(Label { text: label.clone(), anchor, side });
        }
        Ok(labels)
    }
}

/// The box around points.
fn around(points: &[Point]) -> Area {
    let start = Area { left: f64::INFINITY, top: f64::INFINITY, right: f64::NEG_INFINITY, bottom: f64::NEG_INFINITY };
    points.iter().fold(start, |area, [x, y]| Area {
        left: area.left.min(*x),
        top: area.top.min(*y),
        right: area.right.max(*x),
        bottom: area.bottom.max(*y),
    })
}

/// Away from the middle, square to the nearest line.
fn outward(at: Point, lines: &Lines, middle: Point) -> Point {
    let away = direction(middle, at).unwrap_or([0.0, -1.0]);
    let nearest = segments(lines).min_by(|a, b| gap(at, *a).total_cmp(&gap(at, *b)));
    match nearest.and_then(|[from, to]| direction(from, to)) {
        None => away,
        Some([x, y]) if away[1] * x >= away[0] * y => [-y, x],
        Some([x, y]) => [y, -x],
    }
}

/// Towards the side of a box that a point lies nearest to.
fn nearest_side([x, y]: Point, bounds: Area) -> Point {
    let sides = [
        (x - bounds.left, [-1.0, 0.0]),
        (bounds.right - x, [1.0, 0.0]),
        (y - bounds.top, [0.0, -1.0]),
        (bounds.bottom - y, [0.0, 1.0]),
    ];
    sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or([-1.0, 0.0], |side| side.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing() -> Drawing {
        let front = vec![[0.0, 0.0], [75.0, 0.0], [150.0, 20.0]];
        let back = vec![[0.0, 58.0], [75.0, 40.0], [150.0, 20.0]];
        let node = |number: usize, at: Point| NodeMark { number, at, clamped: at[0] == 0.0 };
        let nodes = vec![node(1, back[0]), node(2, back[1]), node(13, back[2]), node(19, front[1]), node(24, front[0])];
        let rib = vec![vec![front[1], back[1]]];
        Drawing {
            frame: Frame::full("Finger", "a finger"),
            x_label: "x, mm".to_owned(),
            y_label: "y, mm".to_owned(),
            strokes: vec![
                Stroke::new("plates", vec![front, back], Hue::Blue, 4.0),
                Stroke::new("ribs", rib, Hue::Green, 2.6),
            ],
            nodes,
            arrows: vec![Arrow { from: [75.0, -20.0], to: [75.0, 0.0], label: "3 N".to_owned(), hue: Hue::Neutral }],
        }
    }

    #[test]
    fn every_line_node_and_arrow_is_drawn_and_named() {
        let svg = drawing().svg().unwrap();
        for words in ["1", "2", "13", "19", "24", "3 N", "plates", "ribs", "node", "clamped node"] {
            assert!(svg.contains(&format!(">{words}</text>")), "{words}");
        }
        // Five nodes and the legend's sample; two plates and theirs.
        assert_eq!((svg.matches("<circle").count(), svg.matches("stroke=\"#1f82c4\"").count()), (6, 3));
    }

    #[test]
    fn a_millimetre_is_as_long_across_as_up() {
        let svg = drawing().svg().unwrap();
        let rib = svg.lines().find(|line| line.contains("#009e73")).and_then(|line| line.split('"').nth(1)).unwrap();
        let plate = svg.lines().find(|line| line.contains("#1f82c4")).and_then(|line| line.split('"').nth(1)).unwrap();
        let coordinates = |points: &str| points.split([' ', ',']).map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
        let (rib, plate) = (coordinates(rib), coordinates(plate));
        assert!(((rib[1] - rib[3]) / 40.0 - (plate[2] - plate[0]) / 75.0).abs() < 0.01, "{rib:?} {plate:?}");
    }

    #[test]
    fn numbers_stand_outside_and_clamps_on_the_base() {
        let lines: Lines = drawing().strokes[0].lines.clone();
        assert!(
            outward([75.0, 0.0], &lines, [75.0, 29.0])[1] < 0.0 && outward([75.0, 40.0], &lines, [75.0, 29.0])[1] > 0.0
        );
        assert_eq!(nearest_side([0.0, 30.0], around(&lines.concat())), [-1.0, 0.0]);
    }

    #[test]
    fn what_has_no_position_is_refused() {
        let mut broken = drawing();
        broken.nodes[0].at[1] = f64::NAN;
        assert!(matches!(broken.svg(), Err(FigureError::NotFinite(_))));
        broken.strokes[0].lines.clear();
        assert!(matches!(broken.svg(), Err(FigureError::Empty(_))));
    }
}
