//! What the values of a map are painted with: a colour scale, or a few classes.

use plotters::style::RGBColor;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};

use super::axis::Scale;
use super::colour::{DARK, LIGHT, ON_MAP};
use super::error::{FigureError, require, require_limits};
use super::geometry::Area;
use super::legend::Entry;
use super::sheet::Sheet;

/// What values are painted with.
#[derive(Debug, Clone, PartialEq)]
pub enum Shades {
    /// A colour scale and what its values mean, e.g. "force error, %".
    Scale(ColourScale, String),
    /// A few classes, in rising order.
    Classes(Vec<Class>),
}

/// Values that share a colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Class {
    /// The largest value of the class; those of the class before are smaller.
    pub up_to: f64,
    /// Words in the legend; classes that are nowhere are not listed.
    pub label: String,
    /// Written on the map, so that colour is not the only sign; nothing where empty.
    pub sign: String,
    /// What its cells are filled with.
    pub fill: Paint,
}

/// Filling of a class's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paint {
    /// Red, green and blue.
    Colour([u8; 3]),
    /// Slanting lines on the page's own ground: from left to right rising, or falling.
    Hatch {
        /// Whether they rise.
        rising: bool,
    },
}

/// Viridis between two values: equal ratios of value are equal steps of lightness, so that the order survives colour blindness and grey
/// print. The same scale makes several maps comparable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColourScale {
    /// Values at the two ends; values beyond take the end's colour.
    pub(super) limits: [f64; 2],
}

impl ColourScale {
    /// A scale from a value above zero to a larger one.
    pub fn log(low: f64, high: f64) -> Self {
        Self { limits: [low, high] }
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        require_limits("colour scale", self.limits)?;
        require(self.limits[0] > 0.0, FigureError::NotPositive, "colour scale")
    }

    /// Position of a value between the ends, 0 to 1.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        Scale::Log.fraction(value.clamp(self.limits[0], self.limits[1]), self.limits)
    }

    pub(super) fn ink(&self, value: f64) -> RGBColor {
        Self::at(self.fraction(value))
    }

    /// The colour at a fraction from 0 (dark violet) to 1 (yellow).
    pub(super) fn at(fraction: f64) -> RGBColor {
        ViridisRGB.get_color_normalized(fraction, 0.0, 1.0)
    }
}

/// Colours up to this fraction of the scale are dark.
const DARK_COLOURS: f64 = 0.6;

impl Shades {
    /// Refuses limits in the wrong order, and values without colour, given the smallest and the largest.
    pub(super) fn check(&self, [least, largest]: [f64; 2]) -> Result<(), FigureError> {
        match self {
            Self::Scale(colours, _) => {
                colours.check()?;
                require(least >= 0.0, FigureError::NotPositive, "map values")
            }
            Self::Classes(classes) => {
                let holds = classes.last().is_some_and(|class| largest <= class.up_to);
                require(holds, FigureError::Empty, "class of a value")
            }
        }
    }

    /// Filling of a value, what is written into its cell, and in which ink.
    pub(super) fn paint(&self, value: f64, written: Option<fn(f64) -> String>) -> (Paint, String, RGBColor) {
        match self {
            Self::Scale(colours, _) => {
                let ink = if colours.fraction(value) < DARK_COLOURS { LIGHT } else { DARK };
                let RGBColor(r, g, b) = colours.ink(value);
                (Paint::Colour([r, g, b]), written.map_or(String::new(), |written| written(value)), ink)
            }
            Self::Classes(classes) => {
                let Class { sign, fill, .. } = &classes[class(classes, value)];
                (*fill, sign.clone(), ON_MAP)
            }
        }
    }

    /// Classes that some of the values have.
    pub(super) fn legend(&self, values: impl Iterator<Item = f64>) -> Vec<Entry<'static>> {
        let Self::Classes(classes) = self else { return Vec::new() };
        let mut shown: Vec<usize> = values.map(|value| class(classes, value)).collect();
        shown.sort_unstable();
        shown.dedup();
        let entry = |nth: usize| {
            let Class { label, sign, fill, .. } = classes.get(nth)?;
            let words = if sign.is_empty() { label.clone() } else { format!("{sign}: {label}") };
            let fill = *fill;
            Some(Entry::new(words, move |sheet, area| fill.draw(sheet, Area::about(area.centre(), 26.0, 15.0))))
        };
        shown.into_iter().filter_map(entry).collect()
    }
}

impl Paint {
    pub(super) fn draw(self, sheet: &Sheet, area: Area) -> Result<(), FigureError> {
        match self {
            Paint::Colour([r, g, b]) => sheet.cell(area, RGBColor(r, g, b)),
            Paint::Hatch { rising } => sheet.hatch(area, rising),
        }
    }
}

/// The class of a value.
fn class(classes: &[Class], value: f64) -> usize {
    classes.iter().take_while(|class| value > class.up_to).count()
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
