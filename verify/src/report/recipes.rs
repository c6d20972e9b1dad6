//! Three ways to train a network, recorded, side by side with what needs no training.

mod words;

use super::dataset::{Columns, Dataset, Format};
use super::format::{NOTHING, Span, error_as, list, share_of_counts, share_refused};
use super::page::{Block, Cell, Column, Table, text};
use super::table_two::{error_or_rounding, recorded_settings};
use crate::estimators::EstimatorId;
use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{COMPARED_SETS, ComparedSet, TableTwo};
use crate::sampling::scatter::ScatterRow;
use crate::truths::TruthId;

const CSV: &str = "training_recipes.csv";
/// Name and how it is shown.
const RECIPES: [(&str, &str); 4] = [("a", "(a)"), ("a, by spread", "(a), by spread"), ("b", "(b)"), ("c", "(c)")];

/// One finger at one level of noise.
#[derive(Debug, Clone, Copy)]
struct Setting<'r> {
    recorded: &'r [RecipeRow],
    live: &'r TableTwo,
    truth: TruthId,
    noise_mm: f64,
}

impl<'r> Setting<'r> {
    /// At the compared sets of contacts.
    fn rows(self, recipe: &str) -> impl Iterator<Item = &'r RecipeRow> {
        let compared = COMPARED_SETS.map(|set| list(set.nodes, " "));
        self.recorded
            .iter()
            .filter(move |row| row.recipe == recipe && row.truth == self.truth && row.noise_mm == self.noise_mm)
            .filter(move |row| compared.contains(&row.nodes))
    }

    /// Over the seeds.
    fn recipe(self, recipe: &str, set: &ComparedSet, quantity: &str) -> Option<Span> {
        let nodes = list(set.nodes, " ");
        let wanted = self.rows(recipe).filter(|row| row.nodes == nodes && row.quantity == quantity);
        Span::of(wanted.filter_map(|row| row.mean_error))
    }

    /// What an estimator of Table II makes of the compared sets.
    fn live(self, estimator: EstimatorId) -> impl Iterator<Item = &'r ScatterRow> {
        let rows = self.live.of(self.truth, self.noise_mm, estimator);
        rows.filter(|row| COMPARED_SETS.iter().any(|set| row.nodes == set.nodes))
    }

    /// Its mean error of each force, or of the sum.
    fn estimator(self, estimator: EstimatorId, set: &ComparedSet, quantity: &str) -> Option<f64> {
        let row = self.live(estimator).find(|row| row.nodes == set.nodes)?;
        if quantity == "sum" { Some(row.sum?.mean_error) } else { row.mean_error() }
    }
}

pub(super) fn dataset(rows: &[RecipeRow]) -> Dataset<'_> {
    Dataset::records(CSV, rows)
}

pub(super) fn blocks(recorded: &[RecipeRow], live: &TableTwo) -> Vec<Block> {
    if recorded.is_empty() {
        return Vec::new();
    }
    let [a, spread, b, c] = RECIPES.map(|(recipe, _)| {
        let seeds = recorded.iter().filter(|row| row.recipe == recipe).map(|row| row.seed);
        seeds.collect::<std::collections::BTreeSet<_>>().len()
    });
    let mut blocks = vec![text(format!(
        "Three ways to train, recorded once, with {a}, {spread}, {b} and {c} seeds. (a) is the paper's: 150-200-150 hidden units, \
         20 000 cases of the linear finger, no noise. How it scales displacements the paper does not say; here they are divided \
         by the largest, or by their spread. (b) adds camera noise to the first. (c) is that of the networks that ship: cases of the co-rotational \
         finger with noise, principal directions as inputs, and beside the hidden layers a linear branch that starts from \
         least squares."
    ))];
    blocks.extend(words::paragraphs(recorded, live).into_iter().map(text));
    blocks.push(Block::Table(table(recorded, live)));
    blocks
}

/// Each force, and the sum of several.
fn quantities(set: &ComparedSet) -> &'static [&'static str] {
    if set.nodes.len() == 1 { &["each force"] } else { &["each force", "sum"] }
}

/// By set and quantity, in the order of the columns.
fn by_set<T>(of: impl Fn(&ComparedSet, &'static str) -> T) -> Vec<T> {
    COMPARED_SETS.iter().flat_map(|set| quantities(set).iter().map(|quantity| of(set, quantity))).collect()
}

fn table(recorded: &[RecipeRow], live: &TableTwo) -> Table {
    let mut lines: Vec<(String, &str, Vec<Cell>, String)> = Vec::new();
    for (truth, noise_mm) in recorded_settings(recorded) {
        let setting = Setting { recorded, live, truth, noise_mm };
        let noise = if noise_mm > 0.0 { format!("{noise_mm}\u{a0}mm") } else { "no noise".to_owned() };
        // Named once for all that sense it.
        let mut named = Some(format!("{}, {noise}", truth.label()));
        for (recipe, name) in RECIPES.into_iter().filter(|(recipe, _)| setting.rows(recipe).next().is_some()) {
            let cells = by_set(|set, quantity| match setting.recipe(recipe, set, quantity) {
                None => Cell::plain(NOTHING),
                Some(errors) => error_as(errors.in_words(), errors.mean),
            });
            let counts = setting.rows(recipe).filter(|row| row.quantity == "each force");
            let refused = share_of_counts(counts.map(|row| [row.refused, row.cases]));
            lines.push((named.take().unwrap_or_default(), name, cells, refused));
        }
        // The networks that ship are trained as recipe (c).
        let others = EstimatorId::ALL.iter().copied().filter(|estimator| *estimator != EstimatorId::Network);
        for estimator in others.filter(|estimator| setting.live(*estimator).next().is_some()) {
            let cells = by_set(|set, quantity| error_or_rounding(setting.estimator(estimator, set, quantity)));
            let refused = share_refused(setting.live(estimator));
            lines.push((named.take().unwrap_or_default(), estimator.label(), cells, refused));
        }
    }
    let headings = by_set(|set, quantity| if quantity == "sum" { quantity } else { set.name });
    Columns::new()
        .page("finger, noise", Format::Words, |(setting, ..): &(String, &str, Vec<Cell>, String)| setting.clone())
        .page("by", Format::Words, |(_, name, ..)| *name)
        .each(headings.into_iter().enumerate(), |columns, (i, heading)| {
            columns.cells(Column::numbers(heading), move |(_, _, cells, _)| cells[i].clone())
        })
        .page("refused", Format::Plain, |(.., refused)| refused.clone())
        .table(
            "Three ways to train: mean error over the seeds (least to greatest), and the estimators of Table II; grey above \
             10 %, dark above 25 %",
            CSV,
            lines,
        )
}
