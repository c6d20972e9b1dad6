//! Filled areas of a drawing to scale.

use plotters::style::{Color, RGBColor};

use super::colour::TEXT;
use super::error::{FigureError, require, require_finite};
use super::geometry::Point;
use super::legend::Entry;
use super::panels::Plot;
use super::sheet::{Dash, Sheet, pen};

/// An area of a drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Words in the legend, listed once for all areas that share them.
    pub label: String,
    /// Its corners in order.
    pub outline: Vec<Point>,
    /// What it is filled with.
    pub fill: Fill,
}

/// Filling of an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fill {
    /// Red, green and blue.
    Colour([u8; 3]),
    /// Nothing, within an outline: for areas without a value.
    Hollow(Dash),
}

impl Patch {
    pub(super) fn check(&self) -> Result<(), FigureError> {
        require(self.outline.len() > 2, FigureError::Empty, &self.label)?;
        require_finite(&self.label, self.outline.iter().flatten())
    }

    pub(super) fn draw(&self, sheet: &Sheet, plot: &Plot) -> Result<(), FigureError> {
        self.fill.draw(sheet, &plot.line(&self.outline))
    }

    /// Entries of the legend, one for each label, in the order in which `patches` have them.
    pub(super) fn legend(patches: &[Patch]) -> Vec<Entry<'_>> {
        let mut listed: Vec<&Patch> = Vec::new();
        for patch in patches {
            if listed.iter().all(|other| other.label != patch.label) {
                listed.push(patch);
            }
        }
        let entry = |patch: &Patch| {
            let fill = patch.fill;
            Entry::new(&patch.label, move |sheet, area| fill.draw(sheet, &area.outline()[..4]))
        };
        listed.into_iter().map(entry).collect()
    }
}

impl Fill {
    fn draw(self, sheet: &Sheet, corners: &[Point]) -> Result<(), FigureError> {
        let closed: Vec<Point> = corners.iter().chain(corners.first()).copied().collect();
        match self {
            Fill::Colour([r, g, b]) => {
                sheet.polygon(&closed, RGBColor(r, g, b))?;
                // A thin edge keeps neighbours of one colour apart.
                sheet.line(&closed, pen(TEXT.mix(0.5), 0.8))
            }
            Fill::Hollow(dash) => sheet.dashed(&closed, pen(TEXT.mix(0.7), 1.2), dash),
        }
    }
}
