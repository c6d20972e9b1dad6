//! Tests that `finray sweep`, shards joined by `finray merge`, and resumed runs all produce the bytes of one uninterrupted run. This file defines the
//! requested sweep and map.

mod rows;
mod shards;
mod stopped;

use crate::kit::*;
use std::sync::LazyLock;

const HEADER: &str = "truth,estimator,noise_mm,s_mm,angle_deg,force_n,samples,answered,mean_error,bias,spread,sigma_n,refusal,warned,covered,covered_warned";

/// A quick sweep with several values of each quantity.
const SWEEP: [&str; 16] = [
    "sweep", PAPER, "--truth", "linear,corotational", "--estimator", "least-squares,ridge", "--noise-mm", "0.067,0",
    "--force-n", "3,0.5", "--seeds", "5", "--places", "12", "--step-deg", "40",
];
/// Output of [`SWEEP`].
static SWEPT: LazyLock<String> = LazyLock::new(|| finray(&SWEEP).done());
/// Number of blocks of [`SWEEP`]: two truths, twelve positions, five directions. Each block has rows for two estimators, two noise levels and two
/// forces.
const BLOCKS: usize = 2 * 12 * 5;
const ROWS_IN_BLOCK: usize = 2 * 2 * 2;
/// A quick map.
const MAP: [&str; 14] = [
    "map", PAPER, "--estimator", "least-squares", "--truth", "linear", "--noise-mm", "0.067", "--force-n", "1,2",
    "--seeds", "5", "--step-deg", "40",
];

fn with<'a>(command: &[&'a str], further: &[&'a str]) -> Vec<&'a str> {
    [command, further].concat()
}

/// Writes all shards of a command, and returns their paths in reverse order.
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
