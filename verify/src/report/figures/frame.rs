//! What every figure has: a heading, words for those who cannot see it, and a size.

use super::error::FigureError;

/// A place in the plane of the drawing's data, usually (x, y) in millimetres.
pub type Point = [f64; 2];

/// Text size of tick labels, legends and node numbers, in pixels of the drawing.
pub(super) const TICK_TEXT: f64 = 16.0;
/// Text size of axis labels.
pub(super) const LABEL_TEXT: f64 = 17.0;
/// Text size of the heading.
pub(super) const HEADING_TEXT: f64 = 18.0;

/// Heading, description and size of a figure.
///
/// The drawing scales with the page; `width` fixes how large its text is
/// against its lines, so a narrow figure stays readable on a phone.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Heading drawn above the figure; none is drawn when empty.
    pub title: String,
    /// What the figure shows, in words, for a reader who cannot see it.
    pub alt: String,
    /// Width in pixels at natural size.
    pub width: f64,
    /// Height of the plotting area in pixels; chosen from the width when absent.
    /// Drawings of equal aspect choose theirs from the data and take this as the most allowed.
    pub plot_height: Option<f64>,
}

impl Frame {
    /// A figure as wide as the page's column (900 px).
    pub fn full(title: impl Into<String>, alt: impl Into<String>) -> Self {
        Self::sized(title.into(), alt.into(), 900.0)
    }

    /// A figure that shares its row with another, or is read on a phone (560 px).
    pub fn half(title: impl Into<String>, alt: impl Into<String>) -> Self {
        Self::sized(title.into(), alt.into(), 560.0)
    }

    /// The same figure with a plotting area of this height in pixels.
    pub fn with_plot_height(mut self, pixels: f64) -> Self {
        self.plot_height = Some(pixels);
        self
    }

    fn sized(title: String, alt: String, width: f64) -> Self {
        Self { title, alt, width, plot_height: None }
    }

    /// The plotting area's height: the one asked for, or a share of the width.
    pub(super) fn height_of_plot(&self) -> f64 {
        // Narrow figures are drawn squarer, or their curves would be flattened.
        let share = if self.width > 700.0 { 0.46 } else { 0.62 };
        self.plot_height.unwrap_or(self.width * share)
    }

    /// Refuses sizes that cannot hold axes and text.
    pub(super) fn check(&self) -> Result<(), FigureError> {
        for (what, pixels, least) in [("figure width", self.width, 300.0), ("plot height", self.height_of_plot(), 80.0)]
        {
            if !(pixels >= least && pixels <= 10_000.0) {
                return Err(FigureError::NoRoom { what: what.into(), low: least, high: pixels });
            }
        }
        Ok(())
    }
}
