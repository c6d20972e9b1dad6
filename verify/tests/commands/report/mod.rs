//! `finray report`: the page, the machine-readable summary, and a CSV file behind every figure.

pub mod browsed;
mod camera;
mod checks;
mod command;
mod maps;
mod models;
mod page;
mod push;
pub mod shared;
mod tables;
