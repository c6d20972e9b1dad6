//! SVG backend for plotters.
//!
//! Plotters draws in whole units. One drawing unit is a tenth of a pixel, so that curves stay smooth. Neutral colours become the page's colours: text
//! in `currentColor`, outlines of text in the page's background.

use std::cell::RefCell;
use std::fmt::{Error, Write};
use std::rc::Rc;

use plotters::style::{Color, FontStyle, RGBColor};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};

use super::colour::{DARK, ON_MAP, OVER_LINES, TEXT};
use super::text::width_of;

/// Drawing units per pixel.
pub(super) const UNITS: f64 = 10.0;

type Done = Result<(), DrawingErrorKind<Error>>;

/// A drawing in progress; its clones write to the same SVG text.
#[derive(Clone, Default)]
pub(super) struct Svg {
    pub(super) text: Rc<RefCell<String>>,
    /// Width and height in drawing units.
    pub(super) size: (u32, u32),
}

impl Svg {
    /// Writes an SVG element, unless its colour is fully transparent.
    fn element(&self, colour: BackendColor, text: &str) -> Done {
        if colour.alpha == 0.0 {
            return Ok(());
        }
        writeln!(self.text.borrow_mut(), "{text}").map_err(DrawingErrorKind::DrawingError)
    }

    fn filled(&self, shape: &str, style: &impl BackendStyle) -> Done {
        self.element(style.color(), &format!("{shape} {}/>", paint("fill", style.color())))
    }
}

/// A `fill` or `stroke` attribute with colour and opacity.
pub(super) fn paint(name: &str, colour: BackendColor) -> String {
    let (r, g, b) = colour.rgb;
    let opacity = if colour.alpha < 1.0 { format!(" opacity=\"{}\"", colour.alpha) } else { String::new() };
    match RGBColor(r, g, b) {
        TEXT | OVER_LINES => format!("{name}=\"currentColor\"{opacity}"),
        ON_MAP => paint(name, DARK.to_backend_color()),
        _ => format!("{name}=\"#{r:02x}{g:02x}{b:02x}\"{opacity}"),
    }
}

fn px(units: i32) -> f64 {
    f64::from(units) / UNITS
}

fn list(points: impl IntoIterator<Item = BackendCoord>) -> String {
    points.into_iter().map(|(x, y)| format!("{},{}", px(x), px(y))).collect::<Vec<_>>().join(" ")
}

/// Escapes characters that have a meaning in markup.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

impl DrawingBackend for Svg {
    type ErrorType = Error;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    /// Fills the rectangle, even if only an outline is requested. Edges are not smoothed, so that neighbours leave no gap.
    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, _: bool) -> Done {
        let [x, y, width, height] = [from.0, from.1, to.0 - from.0, to.1 - from.1].map(px);
        let shape =
            format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" shape-rendering=\"crispEdges\"");
        self.filled(&shape, style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        let (points, width) = (list(path), px(style.stroke_width() as i32));
        let stroke = paint("stroke", style.color());
        self.element(
            style.color(),
            &format!("<polyline points=\"{points}\" fill=\"none\" {stroke} stroke-width=\"{width}\"/>"),
        )
    }

    /// Fills the circle, even if only an outline is requested.
    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, _: bool) -> Done {
        let [x, y, radius] = [x, y, radius as i32].map(px);
        self.filled(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\""), style)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        self.filled(&format!("<polygon points=\"{}\"", list(path)), style)
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Done {
        let ([x, y], size, anchor) = ([x, y].map(px), style.size() / UNITS, style.anchor());
        let across = match anchor.h_pos {
            HPos::Left => "start",
            HPos::Center => "middle",
            HPos::Right => "end",
        };
        // Distance of the baseline below the anchor (top, middle or bottom of the line), as a share of the text size.
        let down = match anchor.v_pos {
            VPos::Top => 0.76,
            VPos::Center => 0.35,
            VPos::Bottom => -0.24,
        };
        let baseline = ((y + down * size) * UNITS).round() / UNITS;
        let (r, g, b) = style.color().rgb;
        let outline = match RGBColor(r, g, b) {
            OVER_LINES => {
                " style=\"paint-order:stroke;stroke-linejoin:round;stroke:var(--paper,Canvas);stroke-width:5px\""
            }
            ON_MAP => " style=\"paint-order:stroke;stroke-linejoin:round;stroke:#ffffff;stroke-width:4px\"",
            _ => "",
        };
        let bold = if matches!(style.style(), FontStyle::Bold) { " font-weight=\"bold\"" } else { "" };
        let rising = matches!(style.transform(), FontTransform::Rotate270);
        let turned = if rising { format!(" transform=\"rotate(270 {x} {y})\"") } else { String::new() };
        let (paint, text) = (paint("fill", style.color()), escape(text));
        let font = format!("font-family=\"sans-serif\" font-size=\"{size}\" text-anchor=\"{across}\"{bold}");
        let text = format!("<text x=\"{x}\" y=\"{baseline}\" {font}{turned} {paint}{outline}>{text}</text>");
        self.element(style.color(), &text)
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Error>> {
        Ok((width_of(text, style.size()) as u32, style.size() as u32))
    }
}
