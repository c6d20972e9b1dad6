//! Colours: inks that follow the page, names for lines and bars, an ordered scale for maps.

use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};

use super::axis::Scale;
use super::error::{FigureError, require, require_limits};

/// The page's text colour. This and the next two are no colours of any palette; the SVG writer puts the page's in their stead.
pub(super) const TEXT: RGBColor = RGBColor(1, 2, 3);
/// The page's text colour, with an outline in the page's background: legible across lines.
pub(super) const OVER_LINES: RGBColor = RGBColor(1, 2, 4);
/// Dark with a white outline in light and dark mode alike: legible on the colours of a map.
pub(super) const ON_MAP: RGBColor = RGBColor(1, 2, 5);
/// Dark ink on a map.
pub(super) const DARK: RGBColor = RGBColor(0x14, 0x17, 0x1a);
/// Light ink on a map.
pub(super) const LIGHT: RGBColor = RGBColor(255, 255, 255);

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
}

impl Hue {
    /// The n-th colour of a series, starting again after the sixth.
    pub fn nth(n: usize) -> Self {
        [Hue::Blue, Hue::Vermilion, Hue::Green, Hue::Orange, Hue::Purple, Hue::SkyBlue][n % 6]
    }

    pub(super) fn ink(self) -> RGBColor {
        match self {
            Self::Blue => RGBColor(0x1f, 0x82, 0xc4),
            Self::Vermilion => RGBColor(0xd5, 0x5e, 0x00),
            Self::Green => RGBColor(0x00, 0x9e, 0x73),
            Self::Orange => RGBColor(0xe6, 0x9f, 0x00),
            Self::Purple => RGBColor(0xcc, 0x79, 0xa7),
            Self::SkyBlue => RGBColor(0x56, 0xb4, 0xe9),
            Self::Neutral => TEXT,
        }
    }
}

/// Viridis between two values: even in lightness, so that the order survives colour blindness and grey print.
///
/// The same scale makes several maps comparable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColourScale {
    /// Whether equal steps of colour are equal differences or equal ratios.
    pub scale: Scale,
    /// Values at the two ends; values beyond take the end's colour.
    pub limits: [f64; 2],
}

impl ColourScale {
    /// Equal ratios of value are equal steps of colour.
    pub fn log(low: f64, high: f64) -> Self {
        Self { scale: Scale::Log, limits: [low, high] }
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        require_limits("colour scale", self.limits)?;
        require(self.scale == Scale::Linear || self.limits[0] > 0.0, FigureError::NotPositive, "colour scale")
    }

    /// Position of a value between the ends, 0 to 1.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        self.scale.fraction(value.clamp(self.limits[0], self.limits[1]), self.limits)
    }

    pub(super) fn ink(&self, value: f64) -> RGBColor {
        Self::at(self.fraction(value))
    }

    /// The colour at a fraction from 0 (dark violet) to 1 (yellow).
    pub(super) fn at(fraction: f64) -> RGBColor {
        ViridisRGB.get_color_normalized(fraction, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_larger_value_is_lighter() {
        let scale = ColourScale::log(0.01, 100.0);
        let lightness = |RGBColor(r, g, b)| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
        let shades: Vec<f64> = (0..=40).map(|i| lightness(scale.ink(10f64.powf(f64::from(i) / 10.0 - 2.0)))).collect();
        assert!(shades.windows(2).all(|pair| pair[0] < pair[1]), "{shades:?}");
    }

    #[test]
    fn a_log_scale_gives_each_decade_the_same_share() {
        let scale = ColourScale::log(0.01, 100.0);
        let near = |value: f64, share: f64| (scale.fraction(value) - share).abs() < 1e-12;
        assert!(near(0.1, 0.25) && near(1.0, 0.5) && near(0.0, 0.0) && near(1e9, 1.0));
        assert!(ColourScale::log(0.0, 1.0).check().is_err() && ColourScale::log(1.0, 1.0).check().is_err());
    }
}
