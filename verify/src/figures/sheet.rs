//! The sheet that a figure is drawn on: lines, areas and words, in pixels.

use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::element::{Circle, DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

use super::colour::{DARK, LIGHT, TEXT};
use super::error::FigureError;
use super::geometry::{Area, Point};
use super::svg::{Svg, UNITS};

/// Text size of tick labels, legends and node numbers, px.
pub(super) const TICK_TEXT: f64 = 16.0;
/// Text size of axis labels, px.
pub(super) const LABEL_TEXT: f64 = 17.0;
/// Space between neighbours, px.
pub(super) const SPACE: f64 = 8.0;

type Done = Result<(), FigureError>;

/// How a line is broken, so that lines differ by more than colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Unbroken.
    #[default]
    Solid,
    /// Long dashes.
    Dashed,
    /// Short dots.
    Dotted,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    ink: RGBColor,
    width: f64,
    opacity: f64,
    dash: Dash,
}

impl Pen {
    pub(super) fn new(ink: RGBColor, width: f64) -> Self {
        Self { ink, width, opacity: 1.0, dash: Dash::Solid }
    }

    /// The pen of axes, ticks and outlines.
    pub(super) fn axis() -> Self {
        Self::new(TEXT, 1.2).faint(0.65)
    }

    pub(super) fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    pub(super) fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    pub(super) fn style(self) -> ShapeStyle {
        self.ink.mix(self.opacity).stroke_width(units(self.width) as u32)
    }
}

/// One line of text and its position: the middle of the text, unless it is said otherwise.
#[derive(Clone)]
pub(super) struct Words<'a> {
    text: &'a str,
    at: Point,
    size: f64,
    ink: RGBColor,
    anchor: (HPos, VPos),
    bold: FontStyle,
    turn: FontTransform,
}

impl<'a> Words<'a> {
    pub(super) fn new(text: &'a str, at: Point) -> Self {
        let anchor = (HPos::Center, VPos::Center);
        Self { text, at, size: TICK_TEXT, ink: TEXT, anchor, bold: FontStyle::Normal, turn: FontTransform::None }
    }

    /// In the size of labels of axes.
    pub(super) fn label(text: &'a str, at: Point) -> Self {
        Self { size: LABEL_TEXT, ..Self::new(text, at) }
    }

    pub(super) fn size(self, size: f64) -> Self {
        Self { size, ..self }
    }

    pub(super) fn ink(self, ink: RGBColor) -> Self {
        Self { ink, ..self }
    }

    pub(super) fn anchor(self, across: HPos, down: VPos) -> Self {
        Self { anchor: (across, down), ..self }
    }

    /// Begins at its position.
    pub(super) fn left(self) -> Self {
        self.anchor(HPos::Left, VPos::Center)
    }

    pub(super) fn bold(self) -> Self {
        Self { bold: FontStyle::Bold, ..self }
    }

    /// Reads upwards from its position.
    pub(super) fn rising(self) -> Self {
        Self { turn: FontTransform::Rotate270, ..self.left() }
    }
}

/// Size of text as plotters takes it.
pub(super) fn font(size: f64) -> TextStyle<'static> {
    TextStyle::from(("sans-serif", size * UNITS).into_font()).color(&TEXT)
}

/// Pixels as whole units.
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * UNITS).round() as i32
}

fn corner([x, y]: Point) -> (i32, i32) {
    (units(x), units(y))
}

/// The whole drawing.
pub(super) struct Sheet(pub(super) DrawingArea<Svg, Shift>);

impl Sheet {
    pub(super) fn line(&self, points: &[Point], pen: Pen) -> Done {
        let path: Vec<_> = points.iter().copied().map(corner).collect();
        let dashed = |size, gap| self.0.draw(&DashedPathElement::new(path.clone(), size, gap, pen.style()));
        Ok(match pen.dash {
            Dash::Solid => self.0.draw(&PathElement::new(path, pen.style())),
            Dash::Dashed => dashed(90, 50),
            Dash::Dotted => dashed(30, 40),
        }?)
    }

    /// A light line on a dark one, which shows on every colour of a map.
    pub(super) fn contour(&self, points: &[Point], dash: Dash) -> Done {
        self.line(points, Pen::new(DARK, 4.6))?;
        self.line(points, Pen::new(LIGHT, 2.2).dashed(dash))
    }

    pub(super) fn polygon(&self, points: &[Point], ink: RGBColor, opacity: f64) -> Done {
        let path: Vec<_> = points.iter().copied().map(corner).collect();
        Ok(self.0.draw(&Polygon::new(path, ink.mix(opacity)))?)
    }

    pub(super) fn cell(&self, area: Area, ink: RGBColor) -> Done {
        let corners = [corner([area.left, area.top]), corner([area.right, area.bottom])];
        Ok(self.0.draw(&Rectangle::new(corners, ink.filled()))?)
    }

    pub(super) fn disc(&self, centre: Point, radius: f64, ink: RGBColor) -> Done {
        Ok(self.0.draw(&Circle::new(corner(centre), units(radius), ink.filled()))?)
    }

    pub(super) fn words(&self, words: Words) -> Done {
        let font = ("sans-serif", words.size * UNITS).into_font().style(words.bold).transform(words.turn);
        let style = TextStyle::from(font).color(&words.ink).pos(Pos::new(words.anchor.0, words.anchor.1));
        Ok(self.0.draw_text(words.text, &style, corner(words.at))?)
    }

    /// Fills an area with slanting lines, for cells without data; those of neighbours meet.
    pub(super) fn hatch(&self, area: Area) -> Done {
        const STEP: f64 = 8.0;
        let first = ((area.left + area.top) / STEP).floor() as i64;
        let last = ((area.right + area.bottom) / STEP).ceil() as i64;
        // Points of one slanting line share the sum of their coordinates.
        for sum in (first..=last).map(|index| index as f64 * STEP) {
            let ends = [[area.left, sum - area.left], [area.right, sum - area.right]];
            if let Some(piece) = area.clip(ends[0], ends[1]) {
                self.line(&piece, Pen::new(TEXT, 1.2).faint(0.45))?;
            }
        }
        Ok(())
    }
}
