//! `finray report`: the page, the summary for machines and a CSV behind every figure.

mod camera;
mod checks;
mod command;
mod maps;
mod models;
mod networks;
mod page;
pub mod shared;
mod timing;
