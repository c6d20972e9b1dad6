//! `finray sweep`, `--shard`, `finray merge` and resumed runs: all produce the bytes of one uninterrupted run. This file defines the requested
//! sweep and map.

mod rows;
mod shards;
mod stopped;

use crate::kit::*;
use std::sync::LazyLock;

const HEADER: &str = "truth,estimator,noise_mm,s_mm,angle_deg,force_n,samples,answered,mean_error,bias,spread,sigma_n,refusal,warned,covered,covered_warned";

/// A sweep of a moment with several of everything.
const SWEEP: [&str; 16] = [
    "sweep",
    PAPER,
    "--truth",
    "linear,corotational",
    "--estimator",
    "least-squares,ridge",
    "--noise-mm",
    "0.067,0",
    "--force-n",
    "3,0.5",
    "--seeds",
    "5",
    "--places",
    "12",
    "--step-deg",
    "40",
];
/// What [`SWEEP`] writes.
static SWEPT: LazyLock<String> = LazyLock::new(|| finray(&SWEEP).done());
/// Blocks of [`SWEEP`]: two truths, twelve positions, five directions; rows of each: two estimators, noises and forces.
const BLOCKS: usize = 2 * 12 * 5;
const ROWS_IN_BLOCK: usize = 2 * 2 * 2;
/// A map of a moment.
const MAP: [&str; 14] = [
    "map",
    PAPER,
    "--estimator",
    "least-squares",
    "--truth",
    "linear",
    "--noise-mm",
    "0.067",
    "--force-n",
    "1,2",
    "--seeds",
    "5",
    "--step-deg",
    "40",
];

fn with<'a>(command: &[&'a str], further: &[&'a str]) -> Vec<&'a str> {
    [command, further].concat()
}

/// Writes all shards of a command and gives their paths, the last one first.
fn shards(folder: &Folder, command: &[&str], of: usize) -> Vec<String> {
    let shard = |number: usize| {
        let out = folder.path(&format!("{number}-of-{of}.csv"));
        finray(&with(command, &["--shard", &format!("{number}/{of}"), "--out", &out])).done();
        out
    };
    (1..=of).rev().map(shard).collect()
}

fn merged(shards: &[String], out: &str) -> Answer {
    let shards: Vec<&str> = shards.iter().map(String::as_str).collect();
    finray(&[&["merge"], &shards[..], &["--out", out]].concat())
}
