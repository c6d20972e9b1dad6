//! Colours: placeholders for the page's own colours, and named colours of lines and bars.

use plotters::style::{Color, RGBAColor, RGBColor};

/// Placeholder for the page's text colour. The SVG writer replaces this colour, [`OVER_LINES`] and [`ON_MAP`]; no figure uses them otherwise.
pub(super) const TEXT: RGBColor = RGBColor(1, 2, 3);
/// Placeholder for text that is legible on top of lines: the page's text colour, outlined in the background colour.
pub(super) const OVER_LINES: RGBColor = RGBColor(1, 2, 4);
/// Placeholder for text that is legible on the colours of a map: dark with a white outline, in light and dark mode.
pub(super) const ON_MAP: RGBColor = RGBColor(1, 2, 5);
/// The dark colour that replaces [`ON_MAP`].
pub(super) const DARK: RGBColor = RGBColor(0x14, 0x17, 0x1a);

/// A colour of lines or bars that colour-blind readers can distinguish: the palette of Okabe and Ito without black and pale yellow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hue {
    /// Blue, slightly lighter than in the published palette, so that it is visible on a dark page.
    Blue,
    /// Vermilion.
    Vermilion,
    /// Bluish green.
    Green,
    /// Orange.
    Orange,
    /// Reddish purple.
    Purple,
    /// Sky blue.
    SkyBlue,
    /// The page's text colour.
    Neutral,
    /// The page's text colour, faint, for background items.
    Faint,
}

impl Hue {
    /// The n-th colour; the sequence repeats after the sixth.
    pub fn nth(n: usize) -> Self {
        [Hue::Blue, Hue::Vermilion, Hue::Green, Hue::Orange, Hue::Purple, Hue::SkyBlue][n % 6]
    }

    /// The colour as red, green, blue and opacity.
    pub(super) fn ink(self) -> RGBAColor {
        let ink = match self {
            Self::Blue => RGBColor(0x1f, 0x82, 0xc4),
            Self::Vermilion => RGBColor(0xd5, 0x5e, 0x00),
            Self::Green => RGBColor(0x00, 0x9e, 0x73),
            Self::Orange => RGBColor(0xe6, 0x9f, 0x00),
            Self::Purple => RGBColor(0xcc, 0x79, 0xa7),
            Self::SkyBlue => RGBColor(0x56, 0xb4, 0xe9),
            Self::Neutral => TEXT,
            Self::Faint => return TEXT.mix(0.35),
        };
        ink.to_rgba()
    }
}
