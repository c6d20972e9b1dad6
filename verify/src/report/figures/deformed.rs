//! The finger bent by forces, over the finger at rest.

use super::arrows::{Arrow, arrow_ends, draw_arrows};
use super::canvas::{Pen, draw};
use super::colour::{Hue, Ink};
use super::error::{FigureError, require_some};
use super::frame::{Frame, Point};
use super::legend::{Legend, Sample};
use super::plane::{Lines, Plane};
use super::plot::SPACE;
use super::stroke::Dash;

/// Several states of one finger.
#[derive(Debug, Clone, PartialEq)]
pub struct Shapes {
    /// Heading, description and size.
    pub frame: Frame,
    /// Label of the level axis, e.g. "base to tip, mm".
    pub x_label: String,
    /// Label of the upright axis.
    pub y_label: String,
    /// The finger at rest, drawn faintly.
    pub undeformed: Lines,
    /// Its words in the legend, e.g. "at rest".
    pub undeformed_label: String,
    /// The bent states.
    pub deformed: Vec<Shape>,
    /// The forces that bend it.
    pub arrows: Vec<Arrow>,
}

/// One bent state.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its words in the legend, e.g. "3 N at node 19, co-rotational".
    pub label: String,
    /// Its lines, in millimetres.
    pub lines: Lines,
    /// Its colour.
    pub hue: Hue,
    /// How its lines are broken, e.g. to tell linear from co-rotational.
    pub dash: Dash,
}

/// Draws the states over each other.
pub fn deformed_shapes(shapes: &Shapes) -> Result<String, FigureError> {
    require_some("undeformed finger", &shapes.undeformed)?;
    for shape in &shapes.deformed {
        require_some(&shape.label, &shape.lines)?;
    }
    let bent = shapes.deformed.iter().flat_map(|shape| &shape.lines);
    let all_lines: Lines = shapes.undeformed.iter().chain(bent).cloned().collect();
    let mut points: Vec<Point> = all_lines.iter().flatten().copied().collect();
    points.extend(arrow_ends(&shapes.arrows));
    let labels = [shapes.x_label.as_str(), shapes.y_label.as_str()];
    let plane = Plane::around(&shapes.frame, labels, &points, 34.0)?;
    let rest = Pen::new(Ink::Text, 3.0).faint(0.35);
    let mut entries = vec![(Sample::Series(Some(rest), None, Ink::Text), shapes.undeformed_label.clone())];
    entries.extend(shapes.deformed.iter().map(|shape| {
        let sample = Sample::Series(Some(pen(shape)), None, shape.hue.ink());
        (sample, shape.label.clone())
    }));
    let legend = Legend::lay_out(&entries, SPACE, shapes.frame.width - SPACE);
    let height = plane.bottom + legend.height() + SPACE;
    draw(&shapes.frame, height, |canvas| {
        plane.draw(canvas)?;
        for line in plane.place_lines(&shapes.undeformed) {
            canvas.line(&line, rest)?;
        }
        for shape in &shapes.deformed {
            for line in plane.place_lines(&shape.lines) {
                canvas.line(&line, pen(shape))?;
            }
        }
        let lines = plane.place_lines(&all_lines);
        draw_arrows(canvas, &shapes.arrows, &plane, &lines, &mut Vec::new())?;
        legend.draw(canvas, plane.bottom)
    })
}

fn pen(shape: &Shape) -> Pen {
    Pen::new(shape.hue.ink(), 2.4).dashed(shape.dash)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shapes() -> Shapes {
        let at_rest = vec![vec![[0.0, 0.0], [150.0, 0.0]]];
        let bent = vec![vec![[0.0, 0.0], [80.0, 5.0], [148.0, 20.0]]];
        Shapes {
            frame: Frame::full("Bent", "a bent line"),
            x_label: "x, mm".into(),
            y_label: "y, mm".into(),
            undeformed: at_rest,
            undeformed_label: "at rest".into(),
            deformed: vec![Shape { label: "3 N, linear".into(), lines: bent, hue: Hue::Blue, dash: Dash::Solid }],
            arrows: vec![Arrow { from: [80.0, -20.0], to: [80.0, 0.0], label: "3 N".into(), hue: Hue::Neutral }],
        }
    }

    #[test]
    fn every_state_is_drawn_and_named() {
        let svg = deformed_shapes(&shapes()).unwrap();
        for name in ["at rest", "3 N, linear", ">3 N<"] {
            assert!(svg.contains(name), "{name}");
        }
        // Once in the drawing, once in the legend.
        assert_eq!(svg.matches(r##"stroke="#1F82C4""##).count(), 2);
    }

    #[test]
    fn a_broken_shape_is_refused() {
        let mut broken = shapes();
        broken.deformed[0].lines[0][1][0] = f64::INFINITY;
        assert!(matches!(deformed_shapes(&broken), Err(FigureError::NotFinite { .. })));
        broken.deformed[0].lines.clear();
        assert!(matches!(deformed_shapes(&broken), Err(FigureError::Empty { .. })));
    }
}
