//! Sweeps: every truth and estimator on a grid of positions, directions, forces and noise.
//!
//! A [`Cell`] is one force of one contact at one level of noise, sensed by one estimator on one truth; the noise samples
//! of a cell are reduced to mean error, bias and spread. A *block* is all cells of one truth and contact: they share the
//! truth's path of shapes and each estimator's preparation, so it is what threads and [`Shard`]s divide. Blocks are
//! numbered by truth, then position, then direction; the cells of a block go by estimator, then noise, then force. Neither
//! order nor numbers depend on the threads, so rows can be written as they come ([`Sweep::stream`]), a run that was
//! stopped goes on where its [`Partial`] file ends, and [`Shards`] put together are one run's bytes.

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
pub use cell::{Cell, Covered, Errors, Outcome};
pub use grid::Grid;
pub use map_cell::{CellState, MapCell};
pub use merge::{MergeError, Shards};
pub use partial::Partial;
pub use request::{Head, Request};
pub use shard::Shard;
pub use table::Table;
