//! Filled areas in a drawing to scale.

use plotters::style::{Color, RGBColor};

use super::colour::TEXT;
use super::error::{FigureError, require, require_finite};
use super::geometry::Point;
use super::legend::Entry;
use super::panels::Plot;
use super::shades::{Class, Paint};
use super::sheet::{Dash, Sheet, pen};

/// A filled area of a drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Class of the area. The legend lists each class once.
    pub class: Class,
    /// Corners of the area, in order along its outline.
    pub outline: Vec<Point>,
}

impl Patch {
    pub(super) fn check(&self) -> Result<(), FigureError> {
        require(self.outline.len() > 2, FigureError::Empty, &self.class.label)?;
        require_finite(&self.class.label, self.outline.iter().flatten())
    }

    pub(super) fn draw(&self, sheet: &Sheet, plot: &Plot) -> Result<(), FigureError> {
        fill(self.class.fill, sheet, &plot.line(&self.outline))
    }

    /// One legend entry per class, in the order in which the classes occur in `patches`.
    pub(super) fn legend(patches: &[Patch]) -> Vec<Entry<'_>> {
        let mut listed: Vec<&Class> = Vec::new();
        for Patch { class, .. } in patches {
            if !listed.contains(&class) {
                listed.push(class);
            }
        }
        let entry = |class: &Class| {
            let paint = class.fill;
            Entry::new(&class.label, move |sheet, area| fill(paint, sheet, &area.outline()[..4]))
        };
        listed.into_iter().map(entry).collect()
    }
}

/// Fills a polygon. A polygon whose class has hatching as its fill gets only an outline.
fn fill(paint: Paint, sheet: &Sheet, corners: &[Point]) -> Result<(), FigureError> {
    let closed: Vec<Point> = corners.iter().chain(corners.first()).copied().collect();
    match paint {
        Paint::Colour([r, g, b]) => {
            sheet.polygon(&closed, RGBColor(r, g, b))?;
            // A thin edge separates neighbouring areas of one colour.
            sheet.line(&closed, pen(TEXT.mix(0.5), 0.8))
        }
        Paint::Hatch { rising } => {
            sheet.dashed(&closed, pen(TEXT.mix(0.7), 1.2), if rising { Dash::Solid } else { Dash::Dotted })
        }
    }
}
