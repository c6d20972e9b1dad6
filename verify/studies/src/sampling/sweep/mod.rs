//! Sweeps: every true finger and estimator on a grid of positions, directions, forces and noise levels.
//!
//! A [`Cell`] is one force at one contact and noise level, sensed by one estimator on one true finger. The noise samples of a cell are reduced to
//! mean error, bias and spread. A *block* contains all cells of one true finger and contact; these cells share shapes and prepared estimators.
//! Threads and [`Shard`]s divide the blocks. Blocks are numbered by true finger, position, then direction; cells within a block by estimator, noise
//! level, then force. Threads do not change the order and the numbers of blocks and cells. [`Sweep::stream`] writes the rows of finished blocks
//! during the run. A stopped run continues from its [`Partial`] file. The merged [`Shards`] of a sweep equal the output of a single run byte for
//! byte.

mod blocks;
mod cell;
mod grid;
mod map_cell;
mod merge;
mod partial;
mod request;
mod samples;
mod shard;
mod table;
mod tally;

pub use blocks::Sweep;
pub use cell::Cell;
pub use grid::Grid;
pub use map_cell::{CellState, MapCell};
pub use merge::{MergeError, Shards};
pub use partial::Partial;
pub use request::{Head, Request};
pub use shard::Shard;
pub use table::Table;
pub(super) use tally::mean_absolute;
