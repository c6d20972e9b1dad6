//! The paper's own method on Table II: recorded errors of the paper's network at the paper's contact nodes, beside the paper's five figures.
//!
//! Networks are trained as in sec. IV-A, on noise-free cases of the linear finger, with several seeds. The records contain the networks' errors on
//! simulated fingers. The paper does not state its scaling of displacements, so two scalings are recorded.

use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{CONTACT_GROUPS, ContactGroup};
use crate::prelude::*;
use crate::truths::TruthId;

/// Names of the recorded recipes that follow the paper: displacements scaled by the largest displacement, or by their spread.
pub const PAPER_RECIPES: [&str; 2] = ["a", "a, by spread"];
/// A figure of the paper counts as reproduced if the larger of our figure and the paper's is at most this multiple of the smaller. The factor 1.5 is
/// a choice. With inputs scaled by the largest displacement, errors of networks that differ only in their seed are within this factor of their mean.
pub const SAME_FACTOR: f64 = 1.5;

/// Whether our error reproduces the paper's, by [`SAME_FACTOR`].
pub fn reproduces(paper: f64, ours: f64) -> bool {
    ours <= SAME_FACTOR * paper && SAME_FACTOR * ours >= paper
}

/// A recorded mean relative error over the contact sets of a group, summarised over the seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OverSeeds {
    /// Mean, least and greatest relative error over the seeds.
    #[serde(flatten)]
    pub errors: Span,
    /// Number of seeds.
    pub seeds: usize,
    /// Number of answered cases, over sets and seeds.
    pub answered: usize,
    /// Number of refused cases, over sets and seeds.
    pub refused: usize,
}

/// One of the paper's five figures, with the recorded figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Group of tests: a row of the paper's table.
    pub group: ContactGroup,
    /// Quantity whose error is stated: `each force` or `sum`.
    pub quantity: &'static str,
    /// The paper's mean relative error.
    pub paper: f64,
    /// The recorded mean relative error.
    pub recorded: OverSeeds,
}

impl Figure {
    /// Whether the mean over the seeds reproduces the paper's figure, by [`SAME_FACTOR`].
    pub fn reproduced(&self) -> bool {
        reproduces(self.paper, self.recorded.errors.mean)
    }
}

/// Quantities of a group in the paper's table, each with the paper's figure.
pub fn quantities(group: &ContactGroup) -> impl Iterator<Item = (&'static str, f64)> {
    [Some(("each force", group.paper_force)), group.paper_sum.map(|sum| ("sum", sum))].into_iter().flatten()
}

/// Node numbers in the format of the records.
pub fn nodes_in_records(nodes: &[usize]) -> String {
    nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// Contact sets of a group for which a recipe has records. Some sets may be missing; the results for the group then refer only to the recorded sets.
pub fn recorded_sets(records: &[RecipeRow], recipe: &str, group: &ContactGroup) -> Vec<&'static [usize]> {
    let recorded = |nodes: &&&'static [usize]| {
        let name = nodes_in_records(nodes);
        records.iter().any(|row| row.recipe == recipe && row.nodes == name)
    };
    group.sets.iter().filter(recorded).copied().collect()
}

/// Recorded relative error of a recipe on a finger, for one quantity of a group, at one noise level (mm). Each seed contributes the mean over the
/// [recorded](recorded_sets) sets. `None` if no set is recorded, or if the network of one seed answered no case of a set.
pub fn recorded(
    records: &[RecipeRow],
    recipe: &str,
    truth: TruthId,
    noise_mm: f64,
    group: &ContactGroup,
    quantity: &str,
) -> Option<OverSeeds> {
    let of_finger = |row: &&RecipeRow| {
        row.recipe == recipe && row.truth == truth && row.noise_mm == noise_mm && row.quantity == quantity
    };
    let rows: Vec<&RecipeRow> = records.iter().filter(of_finger).collect();
    let of_set = |nodes: &&[usize]| {
        let name = nodes_in_records(nodes);
        rows.iter().filter(|row| row.nodes == name).copied().collect::<Vec<_>>()
    };
    let sets: Vec<Vec<&RecipeRow>> = recorded_sets(records, recipe, group).iter().map(of_set).collect();
    let seeds: Vec<u64> = sets.first()?.iter().map(|row| row.seed).collect();
    let of_seed = |seed: &u64| {
        let of_set = |set: &Vec<&RecipeRow>| set.iter().find(|row| row.seed == *seed)?.mean_error;
        let errors: Vec<f64> = sets.iter().map(of_set).collect::<Option<_>>()?;
        mean(errors)
    };
    Some(OverSeeds {
        errors: Span::of(seeds.iter().map(of_seed).collect::<Option<Vec<f64>>>()?)?,
        seeds: seeds.len(),
        answered: sets.iter().flatten().map(|row| row.cases).sum(),
        refused: sets.iter().flatten().map(|row| row.refused).sum(),
    })
}

/// The paper's five figures, each with the figure recorded for a recipe on the co-rotational finger, at one noise level (mm). `None` unless all five
/// are recorded.
pub fn figures(records: &[RecipeRow], recipe: &str, noise_mm: f64) -> Option<Vec<Figure>> {
    let mut all = Vec::new();
    for group in CONTACT_GROUPS {
        for (quantity, paper) in quantities(&group) {
            let recorded = recorded(records, recipe, TruthId::Corotational, noise_mm, &group, quantity)?;
            all.push(Figure { group, quantity, paper, recorded });
        }
    }
    Some(all)
}
