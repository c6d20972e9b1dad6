//! Three ways to train a network, recorded.

use super::ReportError;
use super::dataset::{Columns, Dataset, Format};
use super::format::{NOTHING, Span, error_as, list, share_of_counts};
use super::page::{Block, Cell, Column, Table, details, text};
use super::table_two::recorded_settings;
use super::words::{paragraph, say};
use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{COMPARED_SETS, ComparedSet};
use crate::truths::TruthId;
use minijinja::context;

const CSV: &str = "training_recipes.csv";
/// Name and how it is shown.
pub const RECIPES: [(&str, &str); 4] = [("a", "(a)"), ("a, by spread", "(a), by spread"), ("b", "(b)"), ("c", "(c)")];

/// Seeds whose largest error exceeds the smallest by this factor matter.
const SEEDS_MATTER: f64 = 1.2;
/// Errors on another finger that exceed those on the finger of the training by this factor are due to the finger.
const OTHER_FINGER: f64 = 3.0;

/// Records of a recipe on one finger at one level of noise, at the compared sets of contacts.
#[derive(Clone, Copy)]
struct Setting<'r>(&'r [RecipeRow], TruthId, f64);

impl<'r> Setting<'r> {
    fn rows(self, recipe: &str, quantity: &str) -> impl Iterator<Item = &'r RecipeRow> {
        let Setting(recorded, truth, noise_mm) = self;
        let compared = COMPARED_SETS.map(|set| list(set.nodes, " "));
        let here = recorded.iter().filter(move |row| (row.truth, row.noise_mm) == (truth, noise_mm));
        here.filter(move |row| row.recipe == recipe && row.quantity == quantity && compared.contains(&row.nodes))
    }

    /// Over the seeds.
    fn recipe(self, recipe: &str, set: &ComparedSet, quantity: &str) -> Option<Span> {
        let nodes = list(set.nodes, " ");
        Span::of(self.rows(recipe, quantity).filter(|row| row.nodes == nodes).filter_map(|row| row.mean_error))
    }
}

pub(super) fn dataset(rows: &[RecipeRow]) -> Dataset<'_> {
    Dataset::records(CSV, rows)
}

/// What was recorded, its sentences and its table; nothing where nothing was.
pub fn blocks(recorded: &[RecipeRow]) -> Result<Vec<Block>, ReportError> {
    if recorded.is_empty() {
        return Ok(Vec::new());
    }
    let [a, spread, b, c] = RECIPES.map(|(recipe, _)| {
        let seeds = recorded.iter().filter(|row| row.recipe == recipe).map(|row| row.seed);
        seeds.collect::<std::collections::BTreeSet<_>>().len()
    });
    let mut blocks = vec![paragraph("recipes.about", context! { a, spread, b, c })?];
    blocks.extend(sentences(recorded)?.into_iter().map(text));
    blocks.push(details("By recipe", vec![Block::Table(table(recorded))]));
    Ok(blocks)
}

/// What training on another finger costs, and what ends it; a sentence that the numbers do not bear out is left away.
pub fn sentences(recorded: &[RecipeRow]) -> Result<Vec<String>, ReportError> {
    let noise_mm = recorded.iter().map(|row| row.noise_mm).fold(0.0, f64::max);
    let [_, neighbours, _] = COMPARED_SETS;
    let of =
        move |recipe, truth, noise_mm| Setting(recorded, truth, noise_mm).recipe(recipe, &neighbours, "each force");
    let noisy = move |recipe| of(recipe, TruthId::Corotational, noise_mm);
    let another_finger = || {
        let (near, clean) = (noisy("a")?, of("a", TruthId::Corotational, 0.0)?);
        let learnt = of("a", TruthId::Linear, 0.0)?.mean;
        let seeds = (clean.greatest >= SEEDS_MATTER * clean.least).then(|| clean.range());
        (near.mean >= OTHER_FINGER * learnt).then(|| context! { learnt, near => near.in_words(), seeds })
    };
    let cure = || {
        let (b, c) = (noisy("b")?, noisy("c")?);
        (c.mean <= 0.5 * b.mean).then(|| context! { c => c.in_words() })
    };
    let said = [say("recipes.another_finger", another_finger())?, say("recipes.cure", cure())?];
    Ok(said.into_iter().flatten().collect())
}

/// Recipes with and without noise on the uniform finger.
pub fn table(recorded: &[RecipeRow]) -> Table {
    let settings = recorded_settings(recorded).into_iter().filter(|(truth, _)| *truth == TruthId::Corotational);
    let lines =
        settings.flat_map(|(truth, noise_mm)| RECIPES.map(|recipe| (Setting(recorded, truth, noise_mm), recipe)));
    let quantities = COMPARED_SETS.iter().flat_map(|set| match set.nodes.len() {
        1 => vec![(set, "each force", set.name)],
        _ => vec![(set, "each force", set.name), (set, "sum", "sum")],
    });
    Columns::<(Setting, (&str, &str))>::new()
        .page("recipe", Format::Words, |(_, (_, name))| *name)
        .page("noise, mm", Format::Plain, |(setting, _)| setting.2)
        .each(quantities, |columns, (set, quantity, heading)| {
            columns.cells(Column::numbers(heading), move |(setting, (recipe, _))| {
                let errors = setting.recipe(recipe, set, quantity);
                errors.map_or(Cell::plain(NOTHING), |errors| error_as(errors.in_words(), errors.mean))
            })
        })
        .page("refused", Format::Plain, |(setting, (recipe, _))| {
            share_of_counts(setting.rows(recipe, "each force").map(|row| [row.refused, row.cases]))
        })
        .table("On the uniform finger: mean error over the seeds (least to greatest)", CSV, lines)
}
