//! Figures: numbers in, SVG text out.
//!
//! Each figure is a pure function of its data. The SVG is meant to stand
//! inside an HTML page: it scales with the page's width, its neutral ink is
//! the page's text colour (`currentColor`), and what must hide something
//! behind it is drawn in the page's background, `--paper` where the page
//! defines it. Colours stay apart for colour-blind readers, in light and
//! dark mode; dashes and markers tell series apart without any colour.

mod arrows;
mod axis;
mod bar_values;
mod bars;
mod canvas;
mod category_map;
mod colour;
mod colour_bar;
mod contour;
mod deformed;
mod dress;
mod error;
mod finger;
mod frame;
mod heat_map;
mod label_places;
mod legend;
mod lines;
mod map_grid;
mod map_layers;
mod marks;
mod matrix;
mod plane;
mod plot;
mod reference;
mod stroke;
mod text;

pub use arrows::Arrow;
pub use axis::{Axis, Scale};
pub use bars::{BarGroup, GroupedBars, bars};
pub use category_map::{Category, CategoryMap, category_map};
pub use colour::{ColourScale, Hue};
pub use deformed::{Shape, Shapes, deformed_shapes};
pub use error::FigureError;
pub use finger::{FingerDrawing, NodeMark, finger};
pub use frame::{Frame, Point};
pub use heat_map::{HeatMap, PlaceMark, heat_map};
pub use lines::{LineChart, Series, Spread, lines};
pub use map_grid::{MapGrid, MapRow, SmallMap, map_grid};
pub use marks::Marker;
pub use matrix::{PairCell, PairMatrix, pair_matrix};
pub use plane::Lines;
pub use reference::Reference;
pub use stroke::Dash;
