//! Animated drawings to scale: a sequence of shots that CSS shows and hides, without scripts. A script of the page may control the shots instead; for
//! the script, each shot has the attribute `data-shot-s` with its duration in s.
//!
//! If no animation runs (in print, for readers who prefer no motion, in programs without animation), one chosen shot is shown.

use super::chart::{Chart, SIDES};
use super::error::{FigureError, require};
use super::panels::{Frame, Panels, Plot};
use super::series::Series;
use super::sheet::{Dash, LABEL_TEXT, LEFT, SPACE, Sheet, font};
use super::svg::paint;
use plotters_backend::BackendStyle;

/// An animated drawing to scale.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Heading, description and size of the figure.
    pub frame: Frame,
    /// Labels of the horizontal and the vertical axis, which have the same scale.
    pub labels: [&'static str; 2],
    /// Series that every shot shows.
    pub fixed: Vec<Series>,
    /// Shots in the order in which they are shown.
    pub shots: Vec<Shot>,
    /// Index, from 0, of the shot that is shown if the animation does not run.
    pub still: usize,
    /// Duration of a shot, s.
    pub shot_s: f64,
}

/// One still drawing of an animation.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Lines of text above this shot's drawing.
    pub words: Vec<String>,
    /// Series of the drawing, which are drawn without labels. Series with a solid line are also drawn without symbols.
    pub series: Vec<Series>,
}

/// Height of a line of text above a shot, px.
const LINE: f64 = LABEL_TEXT * 1.4;
/// Overlap of successive shots, percent of the whole duration, so that the animation does not flicker.
const OVERLAP: f64 = 0.02;

impl Film {
    /// Draws the animation as SVG.
    ///
    /// # Errors
    /// [`FigureError`] if there are no shots, or if numbers cannot be drawn on the axes.
    pub fn svg(&self) -> Result<String, FigureError> {
        require(self.still < self.shots.len(), FigureError::Empty, "film")?;
        let moving = || self.shots.iter().flat_map(|shot| &shot.series);
        self.fixed.iter().chain(moving()).try_for_each(Series::check)?;
        let points = || self.fixed.iter().chain(moving()).flat_map(|series| &series.points);
        let data = [0, 1].map(|i| points().map(|point| point[i]).collect());
        let chart = Chart::to_scale(self.frame.clone(), self.labels, Vec::new());
        let (axes, height) = chart.scaled(&data);
        let head = LINE * self.shots.iter().map(|shot| shot.words.len()).max().unwrap_or(0) as f64;
        let mut panels = Panels::new(&self.frame, [&axes[0], &axes[1]]);
        (panels.head, panels.height) = (head, height.unwrap_or(panels.height) + head);
        (panels.data, panels.sides) = (data, SIDES);
        let listed = self.fixed.iter().chain(&self.shots[self.still].series);
        panels.legend = listed.map(Series::entry).collect();
        panels.draw(|sheet, plots| {
            sheet.markup(&self.style());
            self.fixed.iter().try_for_each(|series| series.draw(sheet, &plots[0]))?;
            self.shots.iter().enumerate().try_for_each(|(i, shot)| {
                sheet.markup(&self.opening(i));
                shot.draw(sheet, &plots[0])?;
                sheet.markup("</g>\n");
                Ok(())
            })
        })
    }

    /// CSS of the animation. Animations with equal numbers of shots use the same class names. Animations with equal numbers of shots on one page must
    /// therefore have shots of equal duration.
    fn style(&self) -> String {
        let count = self.shots.len();
        let (all_s, share) = (self.shot_s * count as f64, (100.0 / count as f64 + OVERLAP).min(100.0));
        format!(
            "<style>.shot-{count}{{visibility:hidden;animation:shot-{count} {all_s:.2}s step-end infinite}}\
             .shot-{count}.still{{visibility:visible}}\
             @keyframes shot-{count}{{0%{{visibility:visible}}{share:.4}%{{visibility:hidden}}100%{{visibility:hidden}}}}\
             @media print{{.shot-{count}{{animation:none}}}}\
             @media (prefers-reduced-motion:reduce){{.shot-{count}{{animation:none}}}}</style>\n"
        )
    }

    /// Opening tag of a shot. A negative delay starts each shot at its own time within the common cycle.
    fn opening(&self, shot: usize) -> String {
        let count = self.shots.len();
        let still = if shot == self.still { " still" } else { "" };
        let delay_s = self.shot_s * (shot as f64 - count as f64);
        let shot_s = self.shot_s;
        format!("<g class=\"shot-{count}{still}\" data-shot-s=\"{shot_s}\" style=\"animation-delay:{delay_s:.2}s\">\n")
    }
}

impl Shot {
    /// Draws a shot. Lines of equal style are combined into one path, because a film has many lines.
    fn draw(&self, sheet: &Sheet, plot: &Plot) -> Result<(), FigureError> {
        let left = plot.area.left + SPACE;
        for (line, words) in self.words.iter().enumerate() {
            sheet.words(words, [left, plot.area.top + (line as f64 + 0.7) * LINE], &font(LABEL_TEXT).pos(LEFT))?;
        }
        for alike in self.series.chunk_by(|a, b| (a.hue, a.width, a.dash) == (b.hue, b.width, b.dash)) {
            let [Series { hue, width, dash: Dash::Solid, .. }, ..] = alike else {
                alike.iter().try_for_each(|series| series.draw(sheet, plot))?;
                continue;
            };
            let line = |series: &Series| {
                let points = plot.line(&series.points).into_iter().map(|[x, y]| format!("{x:.1} {y:.1}"));
                format!("M{}", points.collect::<Vec<_>>().join("L"))
            };
            let path: String = alike.iter().map(line).collect();
            let stroke = paint("stroke", hue.0.color());
            sheet.markup(&format!("<path d=\"{path}\" fill=\"none\" {stroke} stroke-width=\"{width}\"/>\n"));
        }
        Ok(())
    }
}
