//! `finray report`: the page, the summary for machines and a CSV behind every figure.

#[path = "../common/mod.rs"]
mod common;
mod shared;

mod checks;
mod command;
mod maps;
mod models;
mod networks;
mod page;
mod timing;
