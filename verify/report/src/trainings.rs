//! Recorded trainings: comparison of recipes, and error by number of cases and by network size.

use super::format::{NOTHING, Span, error_as, list, percent_with, share_of_counts, span_in_words};
use crate::prelude::*;
use finray_studies::experiments::networks::records::{CurveRow, RecipeRow, Records};
use finray_studies::experiments::table_two::COMPARED_SETS;

const RECIPES_CSV: &str = "training_recipes.csv";
const CURVES_CSV: &str = "training_curves.csv";
/// Names of the recipes in the records and in tables.
pub const RECIPES: [(&str, &str); 4] = [("a", "(a)"), ("a, by spread", "(a), by spread"), ("b", "(b)"), ("c", "(c)")];

pub(super) fn datasets(study: &Study) -> [Dataset<'static>; 2] {
    let records = Records::shipped().ok().filter(|_| study.is_paper).unwrap_or_default();
    [Dataset::records(RECIPES_CSV, records.recipes), Dataset::records(CURVES_CSV, records.curves)]
}

/// Tables of the recorded trainings; none for a finger that is not the paper's.
pub(super) fn blocks(study: &Study) -> Result<Vec<Block>, ReportError> {
    if !study.is_paper {
        return Ok(Vec::new());
    }
    let records = Records::shipped()?;
    Ok(vec![
        text(about(&records.recipes)),
        details("By recipe", vec![Block::Table(by_recipe(&records.recipes))]),
        details("By training cases and size", vec![Block::Table(by_size(&records.curves))]),
    ])
}

/// Text on the recipes, each with its number of seeds.
fn about(recorded: &[RecipeRow]) -> String {
    let [a, spread, b, c] = RECIPES.map(|(recipe, _)| {
        let seeds = recorded.iter().filter(|row| row.recipe == recipe).map(|row| row.seed);
        seeds.collect::<std::collections::BTreeSet<_>>().len()
    });
    format!(
        "Three training recipes: (a) the paper's recipe with 150-200-150 units and 20 000 noise-free cases of the \
            linear finger, with displacements divided by the largest displacement (recorded with {a} seeds) or by \
            their spread ({spread} seeds); (b) recipe (a) with noise ({b} seeds); (c) the recipe of the shipped \
            networks, trained on the uniform finger with noise ({c} seeds)."
    )
}

/// Errors of the recipes with and without noise, on the uniform finger.
pub fn by_recipe(recorded: &[RecipeRow]) -> Table {
    type Line<'r> = (&'static str, f64, Vec<&'r RecipeRow>);
    let settings = recorded_settings(recorded).into_iter().filter(|(truth, _)| *truth == TruthId::Corotational);
    let lines = settings.flat_map(|(truth, noise_mm)| {
        RECIPES.map(|(recipe, name)| {
            let here = |row: &&RecipeRow| row.recipe == recipe && (row.truth, row.noise_mm) == (truth, noise_mm);
            (name, noise_mm, recorded.iter().filter(here).collect())
        })
    });
    let quantities = COMPARED_SETS.iter().flat_map(|set| match set.nodes.len() {
        1 => vec![(set, "each force", set.name)],
        _ => vec![(set, "each force", set.name), (set, "sum", "sum")],
    });
    Columns::<Line>::new()
        .page("recipe", Format::Words, |(name, ..)| *name)
        .page("noise, mm", Format::Plain, |(_, noise_mm, _)| *noise_mm)
        .each(quantities, |columns, (set, quantity, heading)| {
            let nodes = list(set.nodes, " ");
            columns.cells(heading, Format::Plain, move |(.., rows)| {
                let of_set = rows.iter().filter(|row| row.nodes == nodes && row.quantity == quantity);
                let errors = Span::of(of_set.filter_map(|row| row.mean_error));
                errors.map_or(Cell::plain(NOTHING), |errors| error_as(span_in_words(errors), errors.mean))
            })
        })
        .page("refused", Format::Plain, |(.., rows)| share_of_counts(rows.iter().map(|row| [row.refused, row.cases])))
        .table("On the uniform finger: mean error over the seeds (least to greatest)", RECIPES_CSV, lines)
}

/// Errors by number of cases and network size for recipe (c), one row per group of networks that differ only in their seed.
pub fn by_size(recorded: &[CurveRow]) -> Table {
    let alike = |a: &CurveRow, b: &CurveRow| {
        (&a.curve, &a.nodes, a.samples, &a.hidden_layers) == (&b.curve, &b.nodes, b.samples, &b.hidden_layers)
    };
    let caption = "On the uniform finger with noise: mean error over the seeds (least to greatest)";
    Columns::<&[CurveRow]>::new()
        .page("nodes", Format::Words, |rows| rows[0].nodes.clone())
        .page("training cases", Format::Plain, |rows| rows[0].samples)
        .page("hidden layers", Format::Words, |rows| rows[0].hidden_layers.clone())
        .page("weights", Format::Plain, |rows| rows[0].weights)
        .page("mean error", Format::Plain, |rows| {
            Some(span_in_words(Span::of(rows.iter().filter_map(|row| row.mean_error))?))
        })
        .page("at the bound", Format::Plain, |rows| rows[0].mean_error_bound.map(|share| percent_with(share, 2)))
        .table(caption, CURVES_CSV, recorded.chunk_by(alike))
}

/// True fingers and noise levels (mm) for which records exist.
fn recorded_settings(records: &[RecipeRow]) -> Vec<(TruthId, f64)> {
    let mut settings = Vec::new();
    for truth in [TruthId::Linear, TruthId::Corotational] {
        let mut levels: Vec<f64> = records.iter().filter(|row| row.truth == truth).map(|row| row.noise_mm).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        settings.extend(levels.into_iter().map(|noise_mm| (truth, noise_mm)));
    }
    settings
}
