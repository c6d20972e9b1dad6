//! Colours: inks that follow the page, and names for lines and bars.

use plotters::style::{Color, RGBAColor, RGBColor};

/// The page's text colour. This and the next two are no colours of any palette; the SVG writer puts the page's in their stead.
pub(super) const TEXT: RGBColor = RGBColor(1, 2, 3);
/// The page's text colour, with an outline in the page's background: legible across lines.
pub(super) const OVER_LINES: RGBColor = RGBColor(1, 2, 4);
/// Dark with a white outline in light and dark mode alike: legible on the colours of a map.
pub(super) const ON_MAP: RGBColor = RGBColor(1, 2, 5);
/// The ink that it is drawn in.
pub(super) const DARK: RGBColor = RGBColor(0x14, 0x17, 0x1a);

/// A line or bar colour that colour-blind readers can distinguish (Okabe and Ito's set, less black and pale yellow).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hue {
    /// Blue, a little lighter than the published one, to carry on a dark page too.
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
    /// The page's own text colour.
    Neutral,
    /// The same, faint, for what stands behind.
    Faint,
}

impl Hue {
    /// The n-th colour of a series, starting again after the sixth.
    pub fn nth(n: usize) -> Self {
        [Hue::Blue, Hue::Vermilion, Hue::Green, Hue::Orange, Hue::Purple, Hue::SkyBlue][n % 6]
    }

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
