//! The request, at the head of files that are to be resumed or merged.

use super::{Grid, Shard, Table};
use crate::prelude::*;
use crate::truths::TruthId;
use std::io::BufRead;

/// Everything that decides the rows of a table: equal requests give equal bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Version of finray: another one may compute other digits.
    pub finray: String,
    /// Which columns.
    pub table: Table,
    /// The true fingers.
    pub truths: Vec<TruthId>,
    /// The estimators.
    pub estimators: Vec<EstimatorId>,
    /// SHA-256 of a network file of the user's, in hexadecimal digits.
    pub network: Option<String>,
    /// Text of the scene file.
    pub scene: String,
    /// Positions, directions, forces and noise.
    pub grid: Grid,
}

impl Request {
    /// The request of a program of this version.
    pub fn version() -> String {
        env!("CARGO_PKG_VERSION").to_owned()
    }

    /// Number of blocks: a truth and contact each.
    pub fn block_count(&self) -> usize {
        self.truths.len() * self.grid.contact_count()
    }

    /// Number of rows in every block.
    pub fn rows_in_block(&self) -> usize {
        self.estimators.len() * self.grid.noise_levels_mm.len() * self.grid.forces_n.len()
    }

    /// The first thing in which two requests differ, for people; `None` if they are the same.
    pub fn difference(&self, other: &Request) -> Option<&'static str> {
        let differences = [
            (self.finray != other.finray, "version of finray"),
            (self.table != other.table, "command"),
            (self.truths != other.truths, "--truth"),
            (self.estimators != other.estimators, "--estimator"),
            (self.network != other.network, "--network"),
            (self.scene != other.scene, "scene"),
            (self.grid.forces_n != other.grid.forces_n, "--force-n"),
            (self.grid.noise_levels_mm != other.grid.noise_levels_mm, "--noise-mm"),
            (self.grid.noise_samples != other.grid.noise_samples, "--seeds"),
            (self.grid.seed != other.grid.seed, "--seed"),
            (self.grid != other.grid, "grid of positions and directions"),
        ];
        differences.into_iter().find_map(|(differs, what)| differs.then_some(what))
    }
}

/// First lines of a shard or unfinished file: the request as TOML behind `#`, which readers of tables take for comments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// Which share of the rows stands below; `None` for all of them.
    pub shard: Option<Shard>,
    /// The request.
    pub request: Request,
}

/// Prefix of every line of a head.
const MARK: &str = "# ";

impl Head {
    /// As text, with the header of the table below it.
    ///
    /// # Errors
    /// None in practice: numbers, texts and lists have a form in TOML.
    pub fn to_text(&self) -> Result<String, toml::ser::Error> {
        let toml = toml::to_string(self)?;
        let marked: String = toml.lines().map(|line| format!("{MARK}{line}\n")).collect();
        Ok(marked + self.request.table.header())
    }

    /// Reads what [`to_text`](Head::to_text) wrote, without the table's header.
    pub(super) fn from_lines(lines: &str) -> Option<Head> {
        let toml: String = lines.split_inclusive('\n').map(|line| line.strip_prefix(MARK).unwrap_or(line)).collect();
        let head: Head = toml::from_str(&toml).ok()?;
        head.shard.is_none_or(Shard::is_sound).then_some(head)
    }

    /// Number of rows below it when it is whole.
    pub fn row_count(&self) -> usize {
        let blocks = self.request.block_count();
        self.shard.map_or(blocks, |shard| shard.blocks(blocks).len()) * self.request.rows_in_block()
    }
}

/// The lines of a file that may be a head: those behind a mark. The reader then stands at the first line that has none.
///
/// # Errors
/// The reader's.
pub(super) fn lines_of_head(reader: &mut impl BufRead) -> std::io::Result<String> {
    let mut lines = String::new();
    while reader.fill_buf()?.starts_with(&MARK.as_bytes()[..1]) {
        if reader.read_line(&mut lines)? == 0 {
            break;
        }
    }
    Ok(lines)
}
