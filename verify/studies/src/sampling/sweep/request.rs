//! The request of a sweep, which is written at the head of every file that can be resumed or merged.

use super::{Grid, Shard, Table};
use crate::prelude::*;
use crate::sampling::situation::Situation;
use crate::truths::TruthId;
use std::io::BufRead;

/// Everything that determines the rows of a table: equal requests give identical bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Version of finray; other versions may compute other digits.
    pub finray: String,
    /// Columns of the table.
    pub table: Table,
    /// The true fingers.
    pub truths: Vec<TruthId>,
    /// The estimators.
    pub estimators: Vec<EstimatorId>,
    /// What the sensors know of the contacts, and which markers they see.
    #[serde(default)]
    pub situation: Situation,
    /// SHA-256 of the user's network file, hexadecimal; `None` without such a file.
    pub network: Option<String>,
    /// Text of the scene file.
    pub scene: String,
    /// Positions, directions, forces and noise levels.
    pub grid: Grid,
}

impl Request {
    /// Number of rows in every block.
    pub fn rows_in_block(&self) -> usize {
        self.estimators.len() * self.grid.noise_levels_mm.len() * self.grid.forces_n.len()
    }

    /// Name of the first property in which two requests differ, for messages; `None` if they are equal.
    pub fn difference(&self, other: &Request) -> Option<&'static str> {
        let differences = [
            (self.finray != other.finray, "version of finray"),
            (self.table != other.table, "command"),
            (self.truths != other.truths, "--truth"),
            (self.estimators != other.estimators, "--estimator"),
            (self.network != other.network, "--network"),
            (self.scene != other.scene, "scene"),
            (self.situation.contact != other.situation.contact, "--knows"),
            (self.situation.hidden != other.situation.hidden, "--hidden"),
            (self.grid.forces_n != other.grid.forces_n, "--force-n"),
            (self.grid.noise_levels_mm != other.grid.noise_levels_mm, "--noise-mm"),
            (self.grid.noise_samples != other.grid.noise_samples, "--seeds"),
            (self.grid.seed != other.grid.seed, "--seed"),
            (self.grid != other.grid, "grid of positions and directions"),
        ];
        differences.into_iter().find_map(|(differs, what)| differs.then_some(what))
    }
}

/// First lines of a shard or unfinished file: the request as TOML. Each line begins with `#`, so readers of tables treat it as a comment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// Shard whose rows follow the head; `None` if all rows of the sweep follow.
    pub shard: Option<Shard>,
    /// The request.
    pub request: Request,
}

/// Prefix of every line of a head.
const MARK: &str = "# ";

impl Head {
    /// The head as text, followed by the header of the table.
    ///
    /// # Errors
    /// [`toml::ser::Error`] if TOML cannot represent the request.
    pub fn to_text(&self) -> Result<String, toml::ser::Error> {
        let toml = toml::to_string(self)?;
        let marked: String = toml.lines().map(|line| format!("{MARK}{line}\n")).collect();
        Ok(marked + self.request.table.header())
    }

    /// Parses the output of [`to_text`](Head::to_text), without the table's header.
    pub(super) fn from_lines(lines: &str) -> Option<Head> {
        let toml: String = lines.split_inclusive('\n').map(|line| line.strip_prefix(MARK).unwrap_or(line)).collect();
        let head: Head = toml::from_str(&toml).ok()?;
        head.shard.is_none_or(Shard::is_sound).then_some(head)
    }

    /// Number of rows of the complete file.
    pub fn row_count(&self) -> usize {
        // One block for each true finger and contact.
        let blocks = self.request.truths.len() * self.request.grid.contact_count();
        self.shard.map_or(blocks, |shard| shard.blocks(blocks).len()) * self.request.rows_in_block()
    }
}

/// Leading lines of a file that begin with `#`, which may be a head. Leaves the reader at the first line that does not begin with `#`.
pub(super) fn lines_of_head(reader: &mut impl BufRead) -> std::io::Result<String> {
    let mut lines = String::new();
    while reader.fill_buf()?.starts_with(&MARK.as_bytes()[..1]) {
        if reader.read_line(&mut lines)? == 0 {
            break;
        }
    }
    Ok(lines)
}
