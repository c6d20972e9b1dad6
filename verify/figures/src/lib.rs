//! Figures: numbers in, SVG text out.
//!
//! Each figure is a pure function of its data. The SVG is meant to stand inside an HTML page: it scales with the page's width, its
//! neutral ink is the page's text colour (`currentColor`), and what must hide something behind it is drawn in the page's background,
//! `--paper` where the page defines it. Colours stay apart for colour-blind readers, in light and dark mode; dashes and markers
//! distinguish series without any colour.
//!
//! Plotters has coordinates, axes and shapes; here are maps with holes, label positions, drawings to scale, a layout.
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
pub use series::{Series, Spread};
pub use shades::{Class, Paint};
pub use sheet::Dash;
