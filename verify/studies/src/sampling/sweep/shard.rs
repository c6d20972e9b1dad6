//! Shards of a sweep, for machines that work independently.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// A share of a sweep: a range of consecutive blocks. Shards in sequence form the whole sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of this shard, from 1.
    pub number: usize,
    /// Number of all shards.
    pub of: usize,
}

impl Shard {
    /// Blocks of this shard among `count` blocks; the range can be empty if there are more shards than blocks.
    pub fn blocks(self, count: usize) -> Range<usize> {
        // u128, because the product of two counts may overflow usize.
        let bound = |shards: usize| (count as u128 * shards as u128 / self.of as u128) as usize;
        bound(self.number - 1)..bound(self.number)
    }

    /// Whether the shard's number is between 1 and the number of shards.
    pub(super) fn is_sound(self) -> bool {
        (1..=self.of).contains(&self.number)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    /// Parses `I/N`.
    fn from_str(text: &str) -> Result<Shard, String> {
        let shard = text
            .split_once('/')
            .and_then(|(number, of)| Some(Shard { number: number.trim().parse().ok()?, of: of.trim().parse().ok()? }));
        shard
            .filter(|shard| shard.is_sound())
            .ok_or_else(|| format!("expected I/N with I from 1 to N, for instance 3/7, found \"{text}\""))
    }
}
