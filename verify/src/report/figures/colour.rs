//! Colours: names for lines and bars, and an ordered scale for maps of values.

use super::axis::Scale;
use super::error::{FigureError, require_limits};

/// A line or bar colour that colour-blind readers can tell from the others
/// (Okabe and Ito's set, less the black and the pale yellow).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hue {
    /// Blue.
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
        const ORDER: [Hue; 6] = [Hue::Blue, Hue::Vermilion, Hue::Green, Hue::Orange, Hue::Purple, Hue::SkyBlue];
        ORDER[n % ORDER.len()]
    }

    /// The ink to draw with.
    pub(super) fn ink(self) -> Ink {
        match self {
            // A little lighter than in the published set, to carry on a dark page too.
            Self::Blue => Ink::Rgb([0x1f, 0x82, 0xc4]),
            Self::Vermilion => Ink::Rgb([0xd5, 0x5e, 0x00]),
            Self::Green => Ink::Rgb([0x00, 0x9e, 0x73]),
            Self::Orange => Ink::Rgb([0xe6, 0x9f, 0x00]),
            Self::Purple => Ink::Rgb([0xcc, 0x79, 0xa7]),
            Self::SkyBlue => Ink::Rgb([0x56, 0xb4, 0xe9]),
            Self::Neutral => Ink::Text,
        }
    }
}

/// What a stroke, an area or a text is drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ink {
    /// The page's text colour.
    Text,
    /// The page's text colour over an outline in the page's own background, to read across lines.
    TextOverLines,
    /// Dark on a light outline, the same in light and dark mode: for text on a coloured map.
    OnMap,
    /// A colour that does not depend on the page.
    Rgb([u8; 3]),
}

/// How values become colours: the same scale makes several maps comparable.
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

    /// Equal differences of value are equal steps of colour.
    pub fn linear(low: f64, high: f64) -> Self {
        Self { scale: Scale::Linear, limits: [low, high] }
    }

    /// Refuses limits in the wrong order, or not above zero on a logarithmic scale.
    pub(super) fn check(&self) -> Result<(), FigureError> {
        require_limits("colour scale", self.limits)?;
        if self.scale == Scale::Log && self.limits[0] <= 0.0 {
            return Err(FigureError::NotPositive { what: "colour scale".into() });
        }
        Ok(())
    }

    /// Where a value lies between the ends, 0 to 1, values beyond being brought to the end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        let [low, high] = self.limits;
        let value = value.clamp(low, high);
        let [value, low, high] = [value, low, high].map(|number| self.scale.measure(number));
        (value - low) / (high - low)
    }

    /// A number that grows evenly along the scale and, unlike the colour, beyond its upper end.
    pub(super) fn evenly(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            // An error of exactly nought has no logarithm; the lowest colour stands for it.
            Scale::Log => value.max(self.limits[0]).log10(),
        }
    }

    /// The value's colour.
    pub(super) fn ink(&self, value: f64) -> Ink {
        Ink::Rgb(viridis(self.fraction(value)))
    }
}

/// Matplotlib's viridis at seventeen equal steps: even in lightness, so
/// the order of values survives colour blindness and grey printing.
const VIRIDIS: [[u8; 3]; 17] = [
    [68, 1, 84],
    [72, 24, 106],
    [71, 45, 123],
    [66, 64, 134],
    [59, 82, 139],
    [51, 99, 141],
    [44, 114, 142],
    [38, 130, 142],
    [33, 145, 140],
    [31, 160, 136],
    [40, 174, 128],
    [63, 188, 115],
    [94, 201, 98],
    [132, 212, 75],
    [173, 220, 48],
    [216, 226, 25],
    [253, 231, 37],
];

/// The colour at a fraction from 0 (dark violet) to 1 (yellow).
pub(super) fn viridis(fraction: f64) -> [u8; 3] {
    let last = VIRIDIS.len() - 1;
    let place = fraction.clamp(0.0, 1.0) * last as f64;
    let below = (place.floor() as usize).min(last - 1);
    let part = place - below as f64;
    std::array::from_fn(|channel| {
        let from = f64::from(VIRIDIS[below][channel]);
        let to = f64::from(VIRIDIS[below + 1][channel]);
        (from + (to - from) * part).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Perceived lightness, near enough to order colours by.
    fn lightness([r, g, b]: [u8; 3]) -> f64 {
        0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
    }

    #[test]
    fn a_larger_value_is_lighter() {
        let shades: Vec<f64> = (0..=40).map(|i| lightness(viridis(f64::from(i) / 40.0))).collect();
        assert!(shades.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn a_log_scale_gives_each_decade_the_same_share() {
        let scale = ColourScale::log(0.01, 100.0);
        assert!((scale.fraction(0.1) - 0.25).abs() < 1e-12);
        assert!((scale.fraction(1.0) - 0.5).abs() < 1e-12);
        assert_eq!(scale.fraction(0.0), 0.0);
        assert_eq!(scale.fraction(1e9), 1.0);
    }

    #[test]
    fn a_log_scale_from_zero_is_refused() {
        assert!(ColourScale::log(0.0, 1.0).check().is_err());
        assert!(ColourScale::linear(1.0, 1.0).check().is_err());
    }
}
