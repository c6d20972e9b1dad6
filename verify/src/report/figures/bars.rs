//! Bars in groups: the same quantity from several sources, side by side.

use super::axis::{Axis, Ruler, Scale, Tick};
use super::bar_values::Writing;
use super::canvas::{Canvas, draw};
use super::colour::Hue;
use super::error::{FigureError, require_finite, require_len, require_some};
use super::frame::Frame;
use super::legend::{Legend, Sample};
use super::plot::{self, Heading, Plot, SPACE, Side};
use super::reference::{self, Reference, draw_references};
use super::stroke::Area;

/// One bar for each category and group.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupedBars {
    /// Heading, description and size.
    pub frame: Frame,
    /// What the categories are, e.g. "node".
    pub category_label: String,
    /// Categories in order, e.g. node numbers.
    pub categories: Vec<String>,
    /// The upright axis; linear ones begin at nought, values below nought are refused.
    pub y: Axis,
    /// Groups in order.
    pub groups: Vec<BarGroup>,
    /// Values to compare with.
    pub references: Vec<Reference>,
}

/// The bars of one source.
#[derive(Debug, Clone, PartialEq)]
pub struct BarGroup {
    /// Words in the legend, e.g. "paper".
    pub label: String,
    /// Colour.
    pub hue: Hue,
    /// One value for each category; none where there is no value.
    pub values: Vec<Option<f64>>,
}

/// Share of a category's room that its bars fill.
const FILLED: f64 = 0.82;

/// Draws the bars with their values on top.
pub fn bars(chart: &GroupedBars) -> Result<String, FigureError> {
    let values = check(chart)?;
    let plot_height = chart.frame.height_of_plot();
    let span = span_of(chart, &values)?;
    let y = Side {
        label: chart.y.label.clone(),
        scale: chart.y.scale,
        span,
        ticks: chart.y.marks(span, plot::most_ticks(plot_height, 44.0)),
    };
    let names = chart.categories.iter().enumerate();
    let ticks = names.map(|(index, name)| Tick { value: index as f64, label: name.clone() });
    let ticks = ticks.collect();
    let x = Side {
        label: chart.category_label.clone(),
        scale: Scale::Linear,
        span: [-0.5, chart.categories.len() as f64 - 0.5],
        ticks,
    };
    let heading = Heading::new(&chart.frame);
    let right = chart.frame.width - reference::right_margin(&chart.frame, &chart.references);
    let area = Area {
        left: plot::left_margin(&y),
        top: heading.height() + plot::Y_LABEL_HEIGHT,
        right,
        bottom: heading.height() + plot::Y_LABEL_HEIGHT + plot_height,
    };
    let room = (area.right - area.left) / chart.categories.len() as f64;
    let bar = room * FILLED / chart.groups.len() as f64;
    let writing = Writing::for_values(&values, bar);
    // The scale ends below the outline, so that the tallest bar's value stands inside it.
    let scale_top = area.top + writing.height;
    let plot = Plot { y: Ruler::new(y.scale, span, [area.bottom, scale_top]), ..Plot::new(area, &x, &y) };
    let entries: Vec<(Sample, String)> =
        chart.groups.iter().map(|group| (Sample::Patch(group.hue.ink()), group.label.clone())).collect();
    let legend = Legend::lay_out(&entries, SPACE, chart.frame.width - SPACE);
    let legend_top = area.bottom + plot::X_LABELS_HEIGHT + SPACE;
    draw(&chart.frame, legend_top + legend.height() + SPACE, |canvas| {
        heading.draw(canvas)?;
        plot.draw_y_label(canvas, &y.label, area.top)?;
        plot.draw_grid(canvas, &[], &y.ticks)?;
        draw_bars(canvas, chart, &plot, [room, bar])?;
        draw_references(canvas, &chart.frame, &plot, &chart.references)?;
        draw_values(canvas, chart, &plot, [room, bar], &writing)?;
        plot.draw_axes(canvas, &x, &y)?;
        legend.draw(canvas, legend_top)
    })
}

/// Refuses what cannot be drawn, and gives back all values.
fn check(chart: &GroupedBars) -> Result<Vec<f64>, FigureError> {
    chart.frame.check()?;
    require_some("categories", &chart.categories)?;
    require_some("bar groups", &chart.groups)?;
    for group in &chart.groups {
        require_len(&group.label, &group.values, chart.categories.len())?;
        require_finite(&group.label, group.values.iter().flatten())?;
    }
    require_finite("references", chart.references.iter().map(|line| &line.value))?;
    let values: Vec<f64> = chart.groups.iter().flat_map(|group| group.values.iter().flatten().copied()).collect();
    require_some("bar values", &values)?;
    if values.iter().any(|value| *value < 0.0) {
        let what = "bar values".into();
        return Err(FigureError::NotPositive { what });
    }
    Ok(values)
}

/// Ends of the upright axis. A linear one begins at nought, or the bars'
/// lengths would not be in proportion to their values.
fn span_of(chart: &GroupedBars, values: &[f64]) -> Result<[f64; 2], FigureError> {
    let mut data = values.to_vec();
    data.extend(chart.references.iter().map(|line| line.value));
    match chart.y.scale {
        Scale::Linear => {
            data.push(0.0);
            chart.y.span(&data)
        }
        Scale::Log => {
            let [low, high] = chart.y.span(&data)?;
            let lowest = data.iter().copied().fold(f64::INFINITY, f64::min);
            // The smallest value keeps a bar that can be seen.
            let stands_out = chart.y.limits.is_some() || lowest > low * 1.5;
            Ok([if stands_out { low } else { low / 2.0 }, high])
        }
    }
}

/// A bar's place on the sheet; without value it has no height.
fn place(plot: &Plot, [room, bar]: [f64; 2], nth: usize, category: usize, value: Option<f64>) -> Area {
    let area = plot.area;
    let start = area.left + room * (category as f64 + (1.0 - FILLED) / 2.0);
    let left = start + bar * nth as f64;
    Area {
        left: left + bar * 0.04,
        right: left + bar * 0.96,
        top: value.map_or(area.bottom, |value| plot.y.place(value).clamp(area.top, area.bottom)),
        bottom: area.bottom,
    }
}

fn draw_bars(canvas: &mut Canvas, chart: &GroupedBars, plot: &Plot, sizes: [f64; 2]) -> Result<(), FigureError> {
    for (nth, group) in chart.groups.iter().enumerate() {
        for (category, value) in group.values.iter().enumerate() {
            if value.is_some() {
                let bar = place(plot, sizes, nth, category, *value);
                canvas.cell(bar, group.hue.ink())?;
            }
        }
    }
    Ok(())
}

fn draw_values(
    canvas: &mut Canvas,
    chart: &GroupedBars,
    plot: &Plot,
    sizes: [f64; 2],
    writing: &Writing,
) -> Result<(), FigureError> {
    for (nth, group) in chart.groups.iter().enumerate() {
        for (category, value) in group.values.iter().enumerate() {
            writing.write(canvas, *value, place(plot, sizes, nth, category, *value))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> GroupedBars {
        GroupedBars {
            frame: Frame::full("Error by node", "error by node"),
            category_label: "node".into(),
            categories: vec!["14".into(), "16".into()],
            y: Axis::linear("error, %"),
            groups: vec![
                BarGroup { label: "paper".into(), hue: Hue::Blue, values: vec![Some(2.0), Some(4.0)] },
                BarGroup { label: "ours".into(), hue: Hue::Orange, values: vec![Some(1.0), None] },
            ],
            references: vec![],
        }
    }

    /// Heights of the drawn bars of one colour, the legend's patch left out.
    fn heights(svg: &str, colour: &str) -> Vec<f64> {
        let bars = svg.lines().filter(|line| line.starts_with("<rect") && line.contains(colour));
        let height = |line: &str| line.split("height=\"").nth(1)?.split('"').next()?.parse().ok();
        let mut heights: Vec<f64> = bars.filter_map(height).collect();
        heights.pop();
        heights
    }

    #[test]
    fn bars_are_as_tall_as_their_values() {
        let svg = bars(&chart()).unwrap();
        let blue = heights(&svg, "#1F82C4");
        assert_eq!(blue.len(), 2);
        assert!((blue[1] / blue[0] - 2.0).abs() < 0.01, "{blue:?}");
        let orange = heights(&svg, "#E69F00");
        assert_eq!(orange.len(), 1);
        assert!((blue[0] / orange[0] - 2.0).abs() < 0.01);
        assert!(svg.contains(">–</text>"));
    }

    #[test]
    fn what_makes_no_bar_is_refused() {
        let mut broken = chart();
        broken.groups[0].values[0] = Some(f64::INFINITY);
        assert!(matches!(bars(&broken), Err(FigureError::NotFinite { .. })));
        broken.groups[0].values[0] = Some(-1.0);
        assert!(matches!(bars(&broken), Err(FigureError::NotPositive { .. })));
        broken.groups[0].values.pop();
        assert!(matches!(bars(&broken), Err(FigureError::Mismatch { .. })));
        let mut nought = chart();
        nought.y = Axis::log("error, %");
        nought.groups[0].values[0] = Some(0.0);
        assert!(matches!(bars(&nought), Err(FigureError::NotPositive { .. })));
    }
}
