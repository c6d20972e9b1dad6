//! Colours: placeholders for the page's own colours, and named colours of lines and bars.

use plotters::style::{RGBAColor, RGBColor};

/// Placeholder for the page's text colour. The SVG writer replaces this colour, [`OVER_LINES`] and [`ON_MAP`]. No figure uses these three placeholder
/// colours as real colours.
pub(super) const TEXT: RGBColor = RGBColor(1, 2, 3);
/// Placeholder for text that is legible on top of lines: the page's text colour, outlined in the background colour.
pub(super) const OVER_LINES: RGBColor = RGBColor(1, 2, 4);
/// Placeholder for text that is legible on the colours of a map: dark with a white outline, in light and dark mode.
pub(super) const ON_MAP: RGBColor = RGBColor(1, 2, 5);
/// The dark colour that replaces [`ON_MAP`].
pub(super) const DARK: RGBColor = RGBColor(0x14, 0x17, 0x1a);

/// A colour of lines or bars from the palette of Okabe and Ito without black and pale yellow, which colour-blind readers can distinguish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hue(pub(super) RGBAColor);

impl Hue {
    /// Blue, slightly lighter than in the published palette, so that it is visible on a dark page.
    pub const BLUE: Hue = Hue(RGBAColor(0x1f, 0x82, 0xc4, 1.0));
    /// Vermilion.
    pub const VERMILION: Hue = Hue(RGBAColor(0xd5, 0x5e, 0x00, 1.0));
    /// Bluish green.
    pub const GREEN: Hue = Hue(RGBAColor(0x00, 0x9e, 0x73, 1.0));
    /// Orange.
    pub const ORANGE: Hue = Hue(RGBAColor(0xe6, 0x9f, 0x00, 1.0));
    /// Reddish purple.
    pub const PURPLE: Hue = Hue(RGBAColor(0xcc, 0x79, 0xa7, 1.0));
    /// Sky blue.
    pub const SKY_BLUE: Hue = Hue(RGBAColor(0x56, 0xb4, 0xe9, 1.0));
    /// The page's text colour.
    pub const NEUTRAL: Hue = Hue(RGBAColor(TEXT.0, TEXT.1, TEXT.2, 1.0));
    /// The page's text colour, faint, for background items.
    pub const FAINT: Hue = Hue(RGBAColor(TEXT.0, TEXT.1, TEXT.2, 0.35));

    /// The n-th colour; the sequence repeats after the sixth.
    pub fn nth(n: usize) -> Self {
        [Hue::BLUE, Hue::VERMILION, Hue::GREEN, Hue::ORANGE, Hue::PURPLE, Hue::SKY_BLUE][n % 6]
    }
}
