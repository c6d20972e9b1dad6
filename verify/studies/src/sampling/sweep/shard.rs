//! Shares of a sweep for machines that work apart.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// One of several shares: each a run of neighbouring blocks, so that shards one after the other are the whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which one, from 1.
    pub number: usize,
    /// How many there are.
    pub of: usize,
}

impl Shard {
    /// The blocks of this share; none where there are more shards than blocks.
    pub fn blocks(self, count: usize) -> Range<usize> {
        // Wide, as a product of two counts may not fit.
        let bound = |shards: usize| (count as u128 * shards as u128 / self.of as u128) as usize;
        bound(self.number - 1)..bound(self.number)
    }

    /// Whether this is a shard at all.
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

    /// `I/N`.
    fn from_str(text: &str) -> Result<Shard, String> {
        let shard = text
            .split_once('/')
            .and_then(|(number, of)| Some(Shard { number: number.trim().parse().ok()?, of: of.trim().parse().ok()? }));
        shard
            .filter(|shard| shard.is_sound())
            .ok_or_else(|| format!("expected I/N with I from 1 to N, for instance 3/7, found \"{text}\""))
    }
}
