//! A drawing plane in which a millimetre is as long across as up.

use super::axis::{Scale, ticks};
use super::canvas::Canvas;
use super::error::{FigureError, require_finite, require_some};
use super::frame::{Frame, Point};
use super::plot::{self, Heading, Plot, SPACE, Side};
use super::stroke::Area;

/// Several lines, each through its points in order, in millimetres.
pub type Lines = Vec<Vec<Point>>;

/// Axes of equal scale around the data, with heading.
pub(super) struct Plane {
    heading: Heading,
    x: Side,
    y: Side,
    pub(super) plot: Plot,
    /// Where the next thing below the axes may begin.
    pub(super) bottom: f64,
}

impl Plane {
    /// Fits the plane to the points, leaving `margin` pixels free around them.
    pub(super) fn around(frame: &Frame, labels: [&str; 2], points: &[Point], margin: f64) -> Result<Self, FigureError> {
        frame.check()?;
        require_some("drawing", points)?;
        require_finite("drawing", points.iter().flatten())?;
        let [x, y] = [0, 1].map(|axis| extent(points, axis));
        let heading = Heading::new(frame);
        // Tick labels on a drawing in millimetres have four letters at most.
        let left = 58.0;
        let top = heading.height() + plot::Y_LABEL_HEIGHT;
        let width = frame.width - left - 2.0 * SPACE;
        let most_height = frame.plot_height.unwrap_or(frame.width * 0.75);
        let [across, up] = [x[1] - x[0], y[1] - y[0]];
        let per_mm =
            ((width - 2.0 * margin) / across.max(1e-9)).min((most_height - 2.0 * margin).max(1.0) / up.max(1e-9));
        let height = up * per_mm + 2.0 * margin;
        let widen = |[low, high]: [f64; 2], pixels: f64| {
            let (middle, half) = ((low + high) / 2.0, pixels / per_mm / 2.0);
            [middle - half, middle + half]
        };
        let side = |label: &str, span: [f64; 2], most: usize| Side {
            label: label.to_owned(),
            scale: Scale::Linear,
            span,
            ticks: ticks(Scale::Linear, span, most),
        };
        let x = side(labels[0], widen(x, width), plot::most_ticks(width, 70.0));
        let y = side(labels[1], widen(y, height), plot::most_ticks(height, 44.0));
        let area = Area { left, top, right: left + width, bottom: top + height };
        Ok(Self { heading, plot: Plot::new(area, &x, &y), x, y, bottom: area.bottom + plot::X_LABELS_HEIGHT + SPACE })
    }

    /// Draws heading, grid and axes.
    pub(super) fn draw(&self, canvas: &mut Canvas) -> Result<(), FigureError> {
        self.heading.draw(canvas)?;
        self.plot.draw_y_label(canvas, &self.y.label, self.plot.area.top)?;
        self.plot.draw_grid(canvas, &self.x.ticks, &self.y.ticks)?;
        self.plot.draw_axes(canvas, &self.x, &self.y)
    }

    /// The lines as they lie on the sheet.
    pub(super) fn place_lines(&self, lines: &[Vec<Point>]) -> Lines {
        let place = |line: &Vec<Point>| line.iter().map(|point| self.plot.place(*point)).collect();
        lines.iter().map(place).collect()
    }
}

fn extent(points: &[Point], axis: usize) -> [f64; 2] {
    points
        .iter()
        .map(|point| point[axis])
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// Middle of the box around the points.
pub(super) fn middle(points: &[Point]) -> Point {
    [0, 1].map(|axis| {
        let [low, high] = extent(points, axis);
        (low + high) / 2.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_millimetre_is_as_long_across_as_up() {
        let frame = Frame::full("", "a drawing");
        for points in [[[0.0, 0.0], [153.0, 58.0]], [[0.0, 0.0], [20.0, 150.0]]] {
            let plane = Plane::around(&frame, ["x", "y"], &points, 30.0).unwrap();
            let [a, b] = [[0.0, 0.0], [10.0, 10.0]].map(|point| plane.plot.place(point));
            assert!(((b[0] - a[0]) - (a[1] - b[1])).abs() < 1e-9);
            assert!(points.iter().all(|point| plane.plot.area.holds(plane.plot.place(*point))));
        }
    }

    #[test]
    fn a_drawing_without_points_is_refused() {
        let frame = Frame::full("", "a drawing");
        assert!(Plane::around(&frame, ["x", "y"], &[], 30.0).is_err());
        assert!(Plane::around(&frame, ["x", "y"], &[[0.0, f64::NAN]], 30.0).is_err());
    }
}
