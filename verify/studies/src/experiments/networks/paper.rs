//! The paper's own method on its Table II: its network as recorded at the paper's contact nodes, against the five figures.
//!
//! Networks are trained as sec. IV-A describes, on noise-free cases of the linear finger, with several seeds; what is recorded
//! is their error on simulated fingers. How the paper scales displacements it does not say: two ways are recorded.

use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{CONTACT_GROUPS, ContactGroup};
use crate::prelude::*;
use crate::truths::TruthId;

/// The recorded recipes that follow the paper, by their scaling of displacements: by the largest, or by their spread.
pub const PAPER_RECIPES: [&str; 2] = ["a", "a, by spread"];
/// A figure is reproduced if ours is within this factor of it. A choice: with inputs scaled by the largest displacement, networks for two
/// contacts that differ in their seed alone are within such a factor of their mean, so that less would judge the seed.
pub const SAME_FACTOR: f64 = 1.5;

/// Whether an error is the paper's, by [`SAME_FACTOR`].
pub fn reproduces(paper: f64, ours: f64) -> bool {
    ours <= SAME_FACTOR * paper && SAME_FACTOR * ours >= paper
}

/// A recorded mean error over the sets of a group.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OverSeeds {
    /// Over the seeds.
    #[serde(flatten)]
    pub errors: Span,
    /// Number of seeds.
    pub seeds: usize,
    /// Cases that were sensed, over sets and seeds.
    pub answered: usize,
    /// Cases that were refused.
    pub refused: usize,
}

/// One of the paper's five figures beside the recorded one.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// The group of tests.
    pub group: ContactGroup,
    /// `each force` or `sum`.
    pub quantity: &'static str,
    /// The paper's.
    pub paper: f64,
    /// As recorded.
    pub recorded: OverSeeds,
}

impl Figure {
    /// Whether the mean over the seeds is the paper's, by [`SAME_FACTOR`].
    pub fn reproduced(&self) -> bool {
        reproduces(self.paper, self.recorded.errors.mean)
    }
}

/// The quantities of a group that the paper's table has, with its figures.
pub fn quantities(group: &ContactGroup) -> impl Iterator<Item = (&'static str, f64)> {
    [Some(("each force", group.paper_force)), group.paper_sum.map(|sum| ("sum", sum))].into_iter().flatten()
}

/// Node numbers as records have them.
pub fn nodes_in_records(nodes: &[usize]) -> String {
    nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// The sets of a group at which a recipe is recorded: not all need be, and what is said of the group holds for these alone.
pub fn recorded_sets(records: &[RecipeRow], recipe: &str, group: &ContactGroup) -> Vec<&'static [usize]> {
    let recorded = |nodes: &&&'static [usize]| {
        let name = nodes_in_records(nodes);
        records.iter().any(|row| row.recipe == recipe && row.nodes == name)
    };
    group.sets.iter().filter(recorded).copied().collect()
}

/// What is recorded of a recipe on a finger, for one quantity of a group: for each seed the mean over the sets that are
/// [recorded](recorded_sets); `None` if none is, or a seed is missing or unanswered at one of them.
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

/// The table's five figures beside those recorded of a recipe on the co-rotational finger; `None` unless all are recorded.
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
