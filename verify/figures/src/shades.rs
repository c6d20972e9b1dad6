//! Classes of values, and the fill of each class in a map.

use plotters::style::RGBColor;

use super::error::{FigureError, require};
use super::geometry::Area;
use super::legend::Entry;
use super::sheet::Sheet;

/// A range of values that share a fill.
#[derive(Debug, Clone, PartialEq)]
pub struct Class {
    /// Largest value of the class. The class begins above the largest value of the previous class.
    pub up_to: f64,
    /// Text in the legend; the legend lists only classes that contain values.
    pub label: String,
    /// Text that the map writes on the cells, so that classes differ by more than colour; may be empty.
    pub sign: String,
    /// Fill of the cells.
    pub fill: Paint,
}

/// Fill of a class's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paint {
    /// Red, green and blue, 0 to 255.
    Colour([u8; 3]),
    /// Slanted lines on the page's background.
    Hatch {
        /// Whether the lines rise from left to right.
        rising: bool,
    },
}

/// Checks that the largest value lies in a class.
pub(super) fn check(classes: &[Class], largest: f64) -> Result<(), FigureError> {
    require(classes.last().is_some_and(|class| largest <= class.up_to), FigureError::Empty, "class of a value")
}

/// The class that contains a value.
pub(super) fn class(classes: &[Class], value: f64) -> &Class {
    &classes[classes.iter().take_while(|class| value > class.up_to).count()]
}

/// Legend entries of the classes that occur among the values.
pub(super) fn legend(classes: &[Class], values: impl Iterator<Item = f64>) -> Vec<Entry<'_>> {
    let values: Vec<f64> = values.collect();
    let is_there = |it: &&Class| values.iter().any(|value| class(classes, *value) == *it);
    let entry = |Class { label, sign, fill, .. }: &Class| {
        let (words, fill) = (if sign.is_empty() { label.clone() } else { format!("{sign}: {label}") }, *fill);
        Entry::new(words, move |sheet, area| fill.draw(sheet, Area::about(area.centre(), 26.0, 15.0)))
    };
    classes.iter().filter(is_there).map(entry).collect()
}

impl Paint {
    pub(super) fn draw(self, sheet: &Sheet, area: Area) -> Result<(), FigureError> {
        match self {
            Paint::Colour([r, g, b]) => sheet.cell(area, RGBColor(r, g, b)),
            Paint::Hatch { rising } => sheet.hatch(area, rising),
        }
    }
}
