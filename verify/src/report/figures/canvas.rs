//! The sheet everything is drawn on: plotters' SVG writer, fed in pixels.
//!
//! Neutral ink is written in colours that stand for the page's own, and
//! exchanged for them at the end, so a figure follows the page's light and
//! dark mode. The writer takes whole numbers only; it is given tenths of a
//! pixel, which keeps curves smooth.

use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBAColor, RGBColor, ShapeStyle, TextStyle};

use super::colour::Ink;
use super::error::FigureError;
use super::frame::{Frame, Point};
use super::stroke::{Area, Dash, dashes};

/// Units of the SVG per pixel of the drawing.
const UNITS: f64 = 10.0;
/// The writer divides text sizes by this, to make points of pixels.
const TEXT_DIVISOR: f64 = 1.24;

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    pub(super) ink: Ink,
    pub(super) width: f64,
    pub(super) opacity: f64,
    pub(super) dash: Dash,
}

impl Pen {
    /// An unbroken, opaque line.
    pub(super) fn new(ink: Ink, width: f64) -> Self {
        Self { ink, width, opacity: 1.0, dash: Dash::Solid }
    }

    /// The same line, fainter.
    pub(super) fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The same line, broken.
    pub(super) fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }
}

/// One line of text and where it stands.
#[derive(Clone, Copy)]
pub(super) struct Words<'a> {
    pub(super) text: &'a str,
    pub(super) at: Point,
    pub(super) size: f64,
    pub(super) ink: Ink,
    /// Which part of the text lies at the place, across and down.
    pub(super) anchor: (HPos, VPos),
    pub(super) bold: bool,
    /// Reads from below to above.
    pub(super) rising: bool,
}

impl<'a> Words<'a> {
    /// Plain text about a place.
    pub(super) fn new(text: &'a str, at: Point, size: f64) -> Self {
        Self { text, at, size, ink: Ink::Text, anchor: (HPos::Center, VPos::Center), bold: false, rising: false }
    }

    /// The same text, placed by another part of it.
    pub(super) fn anchored(self, across: HPos, down: VPos) -> Self {
        Self { anchor: (across, down), ..self }
    }

    /// The same text in another ink.
    pub(super) fn inked(self, ink: Ink) -> Self {
        Self { ink, ..self }
    }
}

/// Paints a figure of the frame's width and this height, and returns the SVG.
pub(super) fn draw(
    frame: &Frame,
    height: f64,
    paint: impl FnOnce(&mut Canvas) -> Result<(), FigureError>,
) -> Result<String, FigureError> {
    let mut svg = String::new();
    let size = [frame.width, height].map(|pixels| (pixels * UNITS).round() as u32);
    let mut canvas = Canvas { backend: SVGBackend::with_string(&mut svg, (size[0], size[1])) };
    paint(&mut canvas)?;
    canvas.backend.present().map_err(failed)?;
    drop(canvas);
    Ok(super::dress::dress(&svg, frame, size))
}

/// The drawing in the making.
pub(super) struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

impl Canvas<'_> {
    /// A line through several points.
    pub(super) fn line(&mut self, points: &[Point], pen: Pen) -> Result<(), FigureError> {
        let style = ShapeStyle {
            color: rgba(pen.ink, pen.opacity),
            filled: false,
            stroke_width: (pen.width * UNITS).round() as u32,
        };
        for piece in dashes(points, pen.dash) {
            let path = piece.into_iter().map(units);
            self.backend.draw_path(path, &style).map_err(failed)?;
        }
        Ok(())
    }

    /// A filled polygon.
    pub(super) fn polygon(&mut self, points: &[Point], ink: Ink, opacity: f64) -> Result<(), FigureError> {
        let path: Vec<_> = points.iter().copied().map(units).collect();
        let style = ShapeStyle::from(rgba(ink, opacity));
        self.backend.fill_polygon(path, &style).map_err(failed)
    }

    /// A filled rectangle whose edges are not softened, so neighbours leave no gap.
    pub(super) fn cell(&mut self, area: Area, ink: Ink) -> Result<(), FigureError> {
        let style = ShapeStyle::from(rgba(ink, 1.0));
        let corners = [[area.left, area.top], [area.right, area.bottom]].map(units);
        self.backend.draw_rect(corners[0], corners[1], &style, true).map_err(failed)
    }

    /// A filled circle.
    pub(super) fn disc(&mut self, centre: Point, radius: f64, ink: Ink) -> Result<(), FigureError> {
        let style = ShapeStyle::from(rgba(ink, 1.0));
        let radius = (radius * UNITS).round() as u32;
        self.backend.draw_circle(units(centre), radius, &style, true).map_err(failed)
    }

    /// One line of text.
    pub(super) fn words(&mut self, words: Words) -> Result<(), FigureError> {
        let mut font = ("sans-serif", words.size * UNITS * TEXT_DIVISOR).into_font();
        if words.bold {
            font = font.style(FontStyle::Bold);
        }
        if words.rising {
            font = font.transform(FontTransform::Rotate270);
        }
        let colour = rgba(words.ink, 1.0);
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(words.anchor.0, words.anchor.1));
        self.backend.draw_text(words.text, &style, units(words.at)).map_err(failed)
    }
}

fn units([x, y]: Point) -> (i32, i32) {
    ((x * UNITS).round() as i32, (y * UNITS).round() as i32)
}

fn rgba(ink: Ink, opacity: f64) -> RGBAColor {
    let [r, g, b] = match ink {
        Ink::Rgb(channels) => channels,
        stand_in => super::dress::stand_in(stand_in),
    };
    RGBColor(r, g, b).mix(opacity)
}

fn failed(error: impl std::fmt::Display) -> FigureError {
    FigureError::Drawing(error.to_string())
}
