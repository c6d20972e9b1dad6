//! Curves over a common quantity.

use super::axis::{Axis, Scale};
use super::canvas::{Canvas, Pen, Words, draw};
use super::colour::{Hue, Ink};
use super::error::{FigureError, require_finite, require_len, require_some};
use super::frame::{Frame, Point, TICK_TEXT};
use super::label_places::{Obstacles, Wish, place_labels};
use super::legend::{Legend, Sample};
use super::marks::{self, Marker};
use super::plot::{self, Heading, Plot, SPACE, Side};
use super::reference::{self, Reference};
use super::stroke::{Area, Dash};
use super::text::width_of;

/// Several series over the same two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct LineChart {
    /// Heading, description and size.
    pub frame: Frame,
    /// The level axis.
    pub x: Axis,
    /// The upright axis.
    pub y: Axis,
    /// The series.
    pub series: Vec<Series>,
    /// Values on the upright axis to compare with.
    pub references: Vec<Reference>,
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Words in the legend; a series without is not listed.
    pub label: String,
    /// The points, in the order they are joined in.
    pub points: Vec<Point>,
    /// Colour.
    pub hue: Hue,
    /// How the joining line is broken; none leaves the points unjoined.
    pub dash: Option<Dash>,
    /// Sign at each point.
    pub marker: Option<Marker>,
    /// How far the value may be off, at each point.
    pub spread: Spread,
    /// Words at each point; none are written where there are none.
    pub labels: Vec<String>,
}

/// How far a series' values may be off: lower and upper ends, one pair a point.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Spread {
    /// Not told.
    #[default]
    None,
    /// An upright stroke at each point.
    Bars(Vec<[f64; 2]>),
    /// A shaded band along the series.
    Band(Vec<[f64; 2]>),
}

impl Spread {
    fn ends(&self) -> &[[f64; 2]] {
        match self {
            Self::None => &[],
            Self::Bars(ends) | Self::Band(ends) => ends,
        }
    }
}

impl Series {
    /// The n-th series of a chart: joined points with signs, in the n-th colour.
    pub fn nth(n: usize, label: impl Into<String>, points: Vec<Point>) -> Self {
        Self {
            label: label.into(),
            points,
            hue: Hue::nth(n),
            dash: Some(Dash::Solid),
            marker: Some(Marker::nth(n)),
            spread: Spread::None,
            labels: Vec::new(),
        }
    }

    fn pen(&self) -> Option<Pen> {
        let pen = Pen::new(self.hue.ink(), 2.6);
        self.dash.map(|dash| pen.dashed(dash))
    }
}

/// Draws the chart.
pub fn lines(chart: &LineChart) -> Result<String, FigureError> {
    let (x_values, y_values) = check(chart)?;
    let plot_height = chart.frame.height_of_plot();
    let y_span = chart.y.span(&y_values)?;
    let y = Side {
        label: chart.y.label.clone(),
        scale: chart.y.scale,
        span: y_span,
        ticks: chart.y.marks(y_span, plot::most_ticks(plot_height, 44.0)),
    };
    let heading = Heading::new(&chart.frame);
    let top = heading.height() + plot::Y_LABEL_HEIGHT;
    let area = Area {
        left: plot::left_margin(&y),
        top,
        right: chart.frame.width - reference::right_margin(&chart.frame, &chart.references),
        bottom: top + plot_height,
    };
    let x_span = chart.x.span(&x_values)?;
    let most = plot::most_ticks(area.right - area.left, 75.0);
    let x =
        Side { label: chart.x.label.clone(), scale: chart.x.scale, span: x_span, ticks: chart.x.marks(x_span, most) };
    let plot = Plot::new(area, &x, &y);
    let entries: Vec<(Sample, String)> = chart
        .series
        .iter()
        .map(|series| {
            let sample = Sample::Series(series.pen(), series.marker, series.hue.ink());
            (sample, series.label.clone())
        })
        .collect();
    let legend = Legend::lay_out(&entries, SPACE, chart.frame.width - SPACE);
    let legend_top = area.bottom + plot::X_LABELS_HEIGHT + SPACE;
    draw(&chart.frame, legend_top + legend.height() + SPACE, |canvas| {
        heading.draw(canvas)?;
        plot.draw_y_label(canvas, &y.label, top)?;
        plot.draw_grid(canvas, &x.ticks, &y.ticks)?;
        reference::draw_references(canvas, &chart.frame, &plot, &chart.references)?;
        for series in &chart.series {
            draw_spread(canvas, &plot, series)?;
        }
        for series in &chart.series {
            draw_series(canvas, &plot, series)?;
        }
        draw_labels(canvas, &plot, &chart.series)?;
        plot.draw_axes(canvas, &x, &y)?;
        legend.draw(canvas, legend_top)
    })
}

/// Refuses what cannot be drawn, and gives back all values across and up.
fn check(chart: &LineChart) -> Result<(Vec<f64>, Vec<f64>), FigureError> {
    chart.frame.check()?;
    require_some("series", &chart.series)?;
    let (mut across, mut up) = (Vec::new(), Vec::new());
    for series in &chart.series {
        require_some(&series.label, &series.points)?;
        require_finite(&series.label, series.points.iter().flatten())?;
        let ends = series.spread.ends();
        if series.spread != Spread::None {
            require_len(&series.label, ends, series.points.len())?;
        }
        require_finite(&series.label, ends.iter().flatten())?;
        if !series.labels.is_empty() {
            require_len(&series.label, &series.labels, series.points.len())?;
        }
        across.extend(series.points.iter().map(|point| point[0]));
        up.extend(series.points.iter().map(|point| point[1]));
        up.extend(ends.iter().flatten().copied().filter(|end| {
            // A lower end at or below nought is cut off at a logarithmic axis's foot.
            chart.y.scale == Scale::Linear || *end > 0.0
        }));
    }
    require_finite("references", chart.references.iter().map(|line| &line.value))?;
    up.extend(chart.references.iter().map(|line| line.value));
    Ok((across, up))
}

fn draw_spread(canvas: &mut Canvas, plot: &Plot, series: &Series) -> Result<(), FigureError> {
    let ink = series.hue.ink();
    let area = plot.area;
    // Kept within the plot, as there is no telling where an axis cuts the spread off.
    let place = |x: f64, y: f64| {
        let [x, y] = plot.place([x, y]);
        // The logarithm of nought or less has no place; the plot's foot stands for it.
        let y = if y.is_finite() { y } else { area.bottom };
        [x.clamp(area.left, area.right), y.clamp(area.top, area.bottom)]
    };
    match &series.spread {
        Spread::None => Ok(()),
        Spread::Bars(ends) => {
            let pen = Pen::new(ink, 1.6);
            for (point, ends) in series.points.iter().zip(ends) {
                if plot.x.place(point[0]) < area.left || plot.x.place(point[0]) > area.right {
                    continue;
                }
                let [low, high] = ends.map(|end| place(point[0], end));
                canvas.line(&[low, high], pen)?;
                for end in [low, high] {
                    canvas.line(&[[end[0] - 5.0, end[1]], [end[0] + 5.0, end[1]]], pen)?;
                }
            }
            Ok(())
        }
        Spread::Band(ends) => {
            let edge = |side: usize| {
                let pairs = series.points.iter().zip(ends);
                pairs.map(move |(point, ends)| place(point[0], ends[side]))
            };
            let mut outline: Vec<Point> = edge(0).collect();
            let upper: Vec<Point> = edge(1).collect();
            outline.extend(upper.iter().rev());
            canvas.polygon(&outline, ink, 0.2)
        }
    }
}

fn draw_series(canvas: &mut Canvas, plot: &Plot, series: &Series) -> Result<(), FigureError> {
    let points: Vec<Point> = series.points.iter().map(|point| plot.place(*point)).collect();
    if let Some(pen) = series.pen() {
        for piece in plot.area.clip_line(&points) {
            canvas.line(&piece, pen)?;
        }
    }
    if let Some(sign) = series.marker {
        for point in points.iter().filter(|point| plot.area.holds(**point)) {
            marks::marker(canvas, sign, *point, series.hue.ink())?;
        }
    }
    Ok(())
}

/// Writes the words at points where they hide neither lines nor points nor each other.
fn draw_labels(canvas: &mut Canvas, plot: &Plot, series: &[Series]) -> Result<(), FigureError> {
    let placed = |series: &Series| series.points.iter().map(|point| plot.place(*point)).collect::<Vec<_>>();
    let lines: Vec<Vec<Point>> = series.iter().filter(|series| series.dash.is_some()).map(placed).collect();
    let marks = series.iter().flat_map(placed).map(|at| Area::about(at, 12.0, 12.0)).collect();
    let labelled = series.iter().flat_map(|series| placed(series).into_iter().zip(&series.labels));
    let (wishes, words): (Vec<Wish>, Vec<&String>) = labelled
        .map(|(anchor, words)| {
            (Wish { anchor, side: [0.7, -0.7], width: width_of(words, TICK_TEXT), height: TICK_TEXT }, words)
        })
        .unzip();
    let obstacles = Obstacles { lines: &lines, areas: marks, within: plot.area };
    for (words, place) in words.into_iter().zip(place_labels(&wishes, obstacles)) {
        canvas.words(Words::new(words, place, TICK_TEXT).inked(Ink::TextOverLines))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> LineChart {
        let points = vec![[1.0, 0.5], [2.0, 3.0], [3.0, 40.0]];
        LineChart {
            frame: Frame::half("Error over force", "error over force"),
            x: Axis::linear("force, N"),
            y: Axis::log("error, %"),
            series: vec![Series::nth(0, "linear", points.clone()), Series::nth(1, "co-rotational", points)],
            references: vec![Reference { value: 10.0, label: "10 %".into() }],
        }
    }

    #[test]
    fn every_series_has_its_line_and_its_markers() {
        let svg = lines(&chart()).unwrap();
        // Three points and the legend's sample.
        assert_eq!(svg.matches(r##"fill="#1F82C4""##).count(), 4);
        assert_eq!(svg.matches(r##"stroke="#D55E00""##).count(), 2);
        assert!(svg.contains(">10 %</text>"));
        assert!(svg.contains("currentColor") && !svg.contains("#000000"));
    }

    #[test]
    fn a_spread_reaching_nought_on_a_log_axis_is_cut_at_its_foot() {
        let mut spread = chart();
        spread.series[0].spread = Spread::Bars(vec![[0.0, 1.0], [2.0, 4.0], [30.0, 50.0]]);
        let svg = lines(&spread).unwrap();
        assert!(!svg.contains("-2147483648") && !svg.contains("NaN"));
        spread.series[0].spread = Spread::Band(vec![[0.4, 1.0]]);
        assert!(matches!(lines(&spread), Err(FigureError::Mismatch { .. })));
    }

    #[test]
    fn points_have_their_words() {
        let mut labelled = chart();
        labelled.series[0].labels = ["first", "second", "third"].map(str::to_owned).into();
        let svg = lines(&labelled).unwrap();
        assert!(["first", "second", "third"].iter().all(|words| svg.contains(&format!(">{words}<"))));
        labelled.series[0].labels.pop();
        assert!(matches!(lines(&labelled), Err(FigureError::Mismatch { .. })));
    }

    #[test]
    fn what_has_no_place_on_the_axes_is_refused() {
        let mut broken = chart();
        broken.series[0].points[0][1] = 0.0;
        assert!(matches!(lines(&broken), Err(FigureError::NotPositive { .. })));
        broken.series[0].points[0][1] = f64::NAN;
        assert!(matches!(lines(&broken), Err(FigureError::NotFinite { .. })));
        broken.series.clear();
        assert!(matches!(lines(&broken), Err(FigureError::Empty { .. })));
    }
}
