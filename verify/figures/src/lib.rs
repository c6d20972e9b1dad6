//! Figures: pure functions from numbers to SVG text.
//!
//! The SVG is embedded in an HTML page. It scales with the width of the page. Neutral items have the page's text colour (`currentColor`). Outlines
//! that cover other elements have the page's background colour: the CSS variable `--paper` if the page defines it. Colour-blind readers can
//! distinguish the colours, in light and dark mode; dashes and markers distinguish series without colour.
//!
//! Plotters provides coordinates, axes and shapes. This crate adds to the plotters library: maps with missing cells, label positions, drawings to
//! scale and layout.
#![forbid(unsafe_code)]

mod axis;
mod bars;
mod cells;
mod chart;
mod colour;
mod error;
mod film;
mod geometry;
mod labels;
mod legend;
mod map;
mod marks;
mod panels;
mod patch;
mod series;
mod shades;
mod sheet;
mod svg;
mod text;

pub use axis::Axis;
pub use bars::Bars;
pub use cells::Cells;
pub use chart::Chart;
pub use colour::Hue;
pub use error::FigureError;
pub use film::{Film, Shot};
pub use geometry::{Lines, Point};
pub use map::Map;
pub use marks::Marker;
pub use panels::Frame;
pub use patch::Patch;
pub use series::Series;
pub use shades::{Class, Paint};
pub use sheet::Dash;
