//! Drawings to scale that move: shots one after the other, shown and hidden by style alone, without scripts.
//!
//! Where nothing moves (in print, for readers who ask for no motion, in programs that know no animations) one of them stands for all.

use super::chart::{Chart, SIDES};
use super::error::{FigureError, require};
use super::panels::{Frame, Panels, Plot};
use super::series::Series;
use super::sheet::{Dash, LABEL_TEXT, LEFT, SPACE, Sheet, font};
use super::svg::paint;
use plotters_backend::BackendStyle;

/// A drawing to scale that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Heading, description and size.
    pub frame: Frame,
    /// Names of the level and the upright axis, of one scale.
    pub labels: [&'static str; 2],
    /// What stands still.
    pub fixed: Vec<Series>,
    /// What moves.
    pub shots: Vec<Shot>,
    /// The shot that stands for all where nothing moves, by its number from 0.
    pub still: usize,
    /// Time of a shot, s.
    pub shot_s: f64,
}

/// What is shown for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Lines of words above the drawing.
    pub words: Vec<String>,
    /// The drawing. Signs and words at points are left out.
    pub series: Vec<Series>,
}

/// Height of a line of words, px.
const LINE: f64 = LABEL_TEXT * 1.4;
/// By how much a shot outlasts its time, percent of all: one is gone when the next is there, not before.
const OVERLAP: f64 = 0.02;

impl Film {
    /// The film as SVG.
    ///
    /// # Errors
    /// [`FigureError`] without shots, or if the numbers have no position on the axes.
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

    /// Films of as many shots share their names, and are alike in all that the names stand for.
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

    /// A shot begins before its time: all are in their places from the start.
    fn opening(&self, shot: usize) -> String {
        let count = self.shots.len();
        let still = if shot == self.still { " still" } else { "" };
        let delay_s = self.shot_s * (shot as f64 - count as f64);
        format!("<g class=\"shot-{count}{still}\" style=\"animation-delay:{delay_s:.2}s\">\n")
    }
}

impl Shot {
    /// Lines of one look are one path: a film has many.
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
            let stroke = paint("stroke", hue.ink().color());
            sheet.markup(&format!("<path d=\"{path}\" fill=\"none\" {stroke} stroke-width=\"{width}\"/>\n"));
        }
        Ok(())
    }
}
