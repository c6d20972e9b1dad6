//! What the values of a map are painted with: a few classes.

use plotters::style::RGBColor;

use super::error::{FigureError, require};
use super::geometry::Area;
use super::legend::Entry;
use super::sheet::Sheet;

/// Values that share a filling.
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

/// Refuses values without a class, given the largest.
pub(super) fn check(classes: &[Class], largest: f64) -> Result<(), FigureError> {
    require(classes.last().is_some_and(|class| largest <= class.up_to), FigureError::Empty, "class of a value")
}

/// The class of a value.
pub(super) fn class(classes: &[Class], value: f64) -> &Class {
    &classes[classes.iter().take_while(|class| value > class.up_to).count()]
}

/// Classes that some of the values have.
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
