//! The finger as it is built: plates, ribs, numbered nodes, clamps and forces.

use super::arrows::{Arrow, arrow_ends, draw_arrows};
use super::canvas::{Canvas, Pen, Words, draw};
use super::colour::{Hue, Ink};
use super::error::FigureError;
use super::frame::{Frame, Point, TICK_TEXT};
use super::label_places::{Obstacles, Wish, place_labels};
use super::legend::{Legend, Sample};
use super::marks;
use super::plane::{Lines, Plane, middle};
use super::plot::SPACE;
use super::stroke::{Area, gap, unit};
use super::text::width_of;

/// A finger at rest, base to tip across the sheet.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerDrawing {
    /// Heading, description and size.
    pub frame: Frame,
    /// Label of the level axis, e.g. "base to tip, mm".
    pub x_label: String,
    /// Label of the upright axis.
    pub y_label: String,
    /// The plate that touches the object.
    pub front: Vec<Point>,
    /// The plate on the other side.
    pub back: Vec<Point>,
    /// The ribs between the plates.
    pub ribs: Lines,
    /// Nodes to number.
    pub nodes: Vec<NodeMark>,
    /// Forces or directions.
    pub arrows: Vec<Arrow>,
}

/// A numbered place of the finger.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeMark {
    /// Its number.
    pub number: usize,
    /// Where it lies, in millimetres.
    pub at: Point,
    /// Whether it is held in place and direction.
    pub clamped: bool,
}

/// Draws the finger.
pub fn finger(drawing: &FingerDrawing) -> Result<String, FigureError> {
    let structure = structure(drawing);
    let labels = [drawing.x_label.as_str(), drawing.y_label.as_str()];
    let mut points: Vec<Point> = structure.iter().flatten().copied().collect();
    points.extend(drawing.nodes.iter().map(|node| node.at));
    points.extend(arrow_ends(&drawing.arrows));
    // Room around the finger for numbers and clamps.
    let plane = Plane::around(&drawing.frame, labels, &points, 44.0)?;
    let legend = Legend::lay_out(&legend_entries(drawing), SPACE, drawing.frame.width - SPACE);
    let height = plane.bottom + legend.height() + SPACE;
    draw(&drawing.frame, height, |canvas| {
        plane.draw(canvas)?;
        draw_structure(canvas, drawing, &plane)?;
        let mut taken = draw_nodes(canvas, drawing, &plane, &structure)?;
        let lines = plane.place_lines(&structure);
        draw_arrows(canvas, &drawing.arrows, &plane, &lines, &mut taken)?;
        legend.draw(canvas, plane.bottom)
    })
}

const FRONT: Hue = Hue::Blue;
const BACK: Hue = Hue::Vermilion;
const RIBS: Hue = Hue::Green;

fn structure(drawing: &FingerDrawing) -> Lines {
    [&drawing.front, &drawing.back].into_iter().chain(&drawing.ribs).filter(|line| !line.is_empty()).cloned().collect()
}

fn legend_entries(drawing: &FingerDrawing) -> Vec<(Sample, String)> {
    let line = |hue: Hue, width: f64| Sample::Series(Some(Pen::new(hue.ink(), width)), None, hue.ink());
    let mut entries = Vec::new();
    for (there, sample, name) in [
        (!drawing.front.is_empty(), line(FRONT, 4.0), "front plate"),
        (!drawing.back.is_empty(), line(BACK, 4.0), "back plate"),
        (!drawing.ribs.is_empty(), line(RIBS, 2.6), "ribs"),
        (drawing.nodes.iter().any(|node| !node.clamped), Sample::Node, "node"),
        (drawing.nodes.iter().any(|node| node.clamped), Sample::Clamp, "clamped node"),
    ] {
        if there {
            entries.push((sample, name.to_owned()));
        }
    }
    entries
}

fn draw_structure(canvas: &mut Canvas, drawing: &FingerDrawing, plane: &Plane) -> Result<(), FigureError> {
    let plates = [drawing.front.clone(), drawing.back.clone()];
    for rib in plane.place_lines(&drawing.ribs) {
        canvas.line(&rib, Pen::new(RIBS.ink(), 2.6))?;
    }
    for (plate, hue) in plane.place_lines(&plates).iter().zip([FRONT, BACK]) {
        canvas.line(plate, Pen::new(hue.ink(), 4.0))?;
    }
    Ok(())
}

/// Draws nodes with their numbers, and returns the ground they take.
fn draw_nodes(
    canvas: &mut Canvas,
    drawing: &FingerDrawing,
    plane: &Plane,
    structure: &[Vec<Point>],
) -> Result<Vec<Area>, FigureError> {
    let lines = plane.place_lines(structure);
    let points: Vec<Point> = lines.iter().flatten().copied().collect();
    let nodes: Vec<Point> = drawing.nodes.iter().map(|node| plane.plot.place(node.at)).collect();
    let centre = middle(if points.is_empty() { &nodes } else { &points });
    let mut taken: Vec<Area> = nodes.iter().map(|at| Area::about(*at, 11.0, 11.0)).collect();
    for (node, at) in drawing.nodes.iter().zip(&nodes) {
        if node.clamped {
            let ground = nearest_side(*at, &points);
            marks::clamp(canvas, *at, ground)?;
            let reach = marks::CLAMP_DEPTH / 2.0;
            let middle = [at[0] + ground[0] * reach, at[1] + ground[1] * reach];
            taken.push(Area::about(middle, 2.0 * reach, 2.0 * reach));
        }
        canvas.disc(*at, 4.0, Ink::Text)?;
    }
    let texts: Vec<String> = drawing.nodes.iter().map(|node| node.number.to_string()).collect();
    let wishes: Vec<Wish> = nodes
        .iter()
        .zip(&texts)
        .map(|(at, text)| Wish {
            anchor: *at,
            side: outward(*at, &lines, centre),
            width: width_of(text, TICK_TEXT),
            height: TICK_TEXT,
        })
        .collect();
    let within = plane.plot.area;
    let areas = taken.clone();
    // Numbers keep off the arrows too, which are drawn later.
    let arrows = drawing.arrows.iter().map(|arrow| vec![arrow.from, arrow.to]);
    let mut kept_free = plane.place_lines(&arrows.collect::<Lines>());
    kept_free.extend(lines);
    let obstacles = Obstacles { lines: &kept_free, areas, within };
    for ((place, text), wish) in place_labels(&wishes, obstacles).iter().zip(&texts).zip(&wishes) {
        canvas.words(Words::new(text, *place, TICK_TEXT).inked(Ink::TextOverLines))?;
        taken.push(Area::about(*place, wish.width, wish.height));
    }
    Ok(taken)
}

/// Away from the finger's middle, square to the nearest line.
fn outward(at: Point, lines: &[Vec<Point>], centre: Point) -> Point {
    let away = [at[0] - centre[0], at[1] - centre[1]];
    let nearest =
        lines.iter().flat_map(|line| line.windows(2)).min_by(|one, other| gap(at, one).total_cmp(&gap(at, other)));
    let along = nearest.and_then(|pair| unit([pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]]));
    let Some([x, y]) = along else {
        return unit(away).unwrap_or([0.0, -1.0]);
    };
    let normal = [-y, x];
    if normal[0] * away[0] + normal[1] * away[1] >= 0.0 { normal } else { [y, -x] }
}

/// The direction of the side of the box around the points that the node lies nearest to.
fn nearest_side(at: Point, points: &[Point]) -> Point {
    let beyond = |axis: usize, sign: f64| {
        let furthest = points.iter().map(|point| sign * point[axis]).fold(f64::NEG_INFINITY, f64::max);
        furthest - sign * at[axis]
    };
    [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)]
        .into_iter()
        .min_by(|one, other| beyond(one.0, one.1).total_cmp(&beyond(other.0, other.1)))
        .map_or([-1.0, 0.0], |(axis, sign)| if axis == 0 { [sign, 0.0] } else { [0.0, sign] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing() -> FingerDrawing {
        let front = vec![[0.0, 0.0], [75.0, 0.0], [150.0, 20.0]];
        let back = vec![[0.0, 58.0], [75.0, 40.0], [150.0, 20.0]];
        let at = |number: usize, at: Point| NodeMark { number, at, clamped: at[0] == 0.0 };
        FingerDrawing {
            frame: Frame::full("Finger", "a finger"),
            x_label: "x, mm".into(),
            y_label: "y, mm".into(),
            nodes: vec![at(1, back[0]), at(2, back[1]), at(13, back[2]), at(19, front[1]), at(24, front[0])],
            ribs: vec![vec![front[1], back[1]]],
            front,
            back,
            arrows: vec![Arrow { from: [75.0, -20.0], to: [75.0, 0.0], label: "3 N".into(), hue: Hue::Neutral }],
        }
    }

    #[test]
    fn every_node_and_arrow_has_its_words() {
        let svg = finger(&drawing()).unwrap();
        for words in ["1", "2", "13", "19", "24", "3 N", "ribs", "clamped node"] {
            assert!(svg.contains(&format!(">{words}</text>")), "{words}");
        }
        // Five nodes and the legend's sample.
        assert_eq!(svg.matches("<circle").count(), 6);
        assert!(svg.contains("currentColor") && !svg.contains("#000000"));
    }

    #[test]
    fn numbers_stand_outside_and_clamps_on_the_base() {
        let lines = [drawing().front, drawing().back];
        assert!(outward([75.0, 0.0], &lines, [75.0, 29.0])[1] < 0.0);
        assert!(outward([75.0, 40.0], &lines, [75.0, 29.0])[1] > 0.0);
        let points: Vec<Point> = lines.concat();
        assert_eq!(nearest_side([0.0, 30.0], &points), [-1.0, 0.0]);
    }

    #[test]
    fn a_node_without_place_is_refused() {
        let mut broken = drawing();
        broken.nodes[0].at[1] = f64::NAN;
        assert!(matches!(finger(&broken), Err(FigureError::NotFinite { .. })));
    }
}
