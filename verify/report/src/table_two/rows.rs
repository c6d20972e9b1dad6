//! Table II as a file: every set of contacts, the means over the paper's groups, and records of the paper's network.

use super::{CSV, paper_network, recorded_settings, settings};
use crate::format::list;
use crate::prelude::*;
use finray_studies::experiments::networks::paper::{PAPER_RECIPES, quantities, recorded, recorded_sets};
use finray_studies::experiments::table_two::{CONTACT_GROUPS, ContactGroup, TableTwo};

/// Errors of one quantity, for one set of contacts or as the mean over the sets of a group.
struct Line {
    truth: TruthId,
    noise_mm: f64,
    /// Name of the estimator. A name that starts with `network of the paper` marks recorded errors, averaged over seeds and sets of contacts.
    estimator: String,
    group: ContactGroup,
    /// Contact nodes separated by spaces, or `mean` for the mean over the group's sets. A row of a record lists the group's recorded sets of nodes,
    /// separated by semicolons.
    nodes: String,
    /// `each force` or `sum`.
    quantity: &'static str,
    /// The paper's mean relative error over all tests of the group, dimensionless.
    paper: Option<f64>,
    answered: usize,
    refused: usize,
    /// Mean relative error, mean error in N, and mean relative error at the Cramer-Rao bound.
    errors: [Option<f64>; 3],
}

/// Rows of all sets, then of the groups, then of the records. Each set, group and record has a row for the mean of its forces, and a row for the sum
/// of its forces if it has several.
pub(super) fn dataset(study: &Study) -> Dataset<'static> {
    let columns = Columns::<Line>::new()
        .file("truth", |line| line.truth.name())
        .file("noise_mm", |line| line.noise_mm)
        .file("estimator", |line| line.estimator.clone())
        .file("group", |line| line.group.name)
        .file("nodes", |line| line.nodes.clone())
        .file("quantity", |line| line.quantity)
        .file("drawn", |line| line.answered + line.refused)
        .file("answered", |line| line.answered)
        .file("refused", |line| line.refused)
        .file("paper_mean_error", |line| line.paper)
        .file("mean_error", |line| line.errors[0])
        .file("mean_error_n", |line| line.errors[1])
        .file("mean_error_bound", |line| line.errors[2]);
    let lines = study.table_two.iter().flat_map(|two| {
        let sets = two.fingers.iter().flat_map(|finger| finger.rows.iter().flat_map(|row| of_set(finger.truth, row)));
        let recorded = recorded_settings(&study.records.recipes).into_iter();
        let recorded = recorded.flat_map(|(truth, noise_mm)| of_records(study, truth, noise_mm));
        sets.chain(of_groups(two)).chain(recorded).collect::<Vec<_>>()
    });
    Dataset::new(CSV, &columns, lines)
}

fn of_set(truth: TruthId, row: &ScatterRow) -> Vec<Line> {
    let Some(group) = CONTACT_GROUPS.into_iter().find(|group| group.sets.contains(&&row.nodes[..])) else {
        return Vec::new();
    };
    let sum_bound = || Some(row.sum?.bound?.mean_error_bound);
    let line = |(quantity, _): (&'static str, f64)| Line {
        truth,
        noise_mm: row.noise_mm,
        estimator: row.estimator.name().to_owned(),
        group,
        nodes: list(&row.nodes, " "),
        quantity,
        paper: None,
        answered: row.cases,
        refused: row.refused,
        errors: match quantity {
            "sum" => [row.sum.map(|sum| sum.mean_error), row.sum.map(|sum| sum.mean_error_n), sum_bound()],
            _ => [row.mean_error(), row.mean_error_n(), row.mean_error_bound()],
        },
    };
    quantities(&group).map(line).collect()
}

fn of_groups(two: &TableTwo) -> impl Iterator<Item = Line> {
    let of_setting = move |(truth, noise_mm, estimator): (TruthId, f64, EstimatorId)| {
        CONTACT_GROUPS.into_iter().flat_map(move |group| {
            let found = two.group(&group, truth, noise_mm, estimator);
            let line = |(quantity, paper): (&'static str, f64)| Line {
                truth,
                noise_mm,
                estimator: estimator.name().to_owned(),
                group,
                nodes: "mean".to_owned(),
                quantity,
                paper: Some(paper),
                answered: found.map_or(0, |found| found.answered),
                refused: found.map_or(0, |found| found.refused),
                errors: found.map_or([None; 3], |found| match quantity {
                    "sum" => [found.sum, None, found.sum_bound],
                    _ => [Some(found.force), Some(found.force_n), found.force_bound],
                }),
            };
            quantities(&group).map(line).collect::<Vec<_>>()
        })
    };
    settings(two).into_iter().flat_map(of_setting)
}

/// Rows of the paper's training recipes, averaged over seeds and sets of contacts.
fn of_records(study: &Study, truth: TruthId, noise_mm: f64) -> Vec<Line> {
    let records = &study.records.recipes;
    let line = |recipe: &str, group: ContactGroup, quantity: &'static str, paper: f64| {
        let found = recorded(records, recipe, truth, noise_mm, &group, quantity)?;
        Some(Line {
            truth,
            noise_mm,
            estimator: paper_network(recipe),
            group,
            nodes: list(recorded_sets(records, recipe, &group).iter().map(|set| list(*set, " ")), "; "),
            quantity,
            paper: Some(paper),
            answered: found.answered,
            refused: found.refused,
            errors: [Some(found.errors.mean), None, None],
        })
    };
    let of_recipe = |recipe: &'static str| {
        let wanted = CONTACT_GROUPS
            .into_iter()
            .flat_map(|group| quantities(&group).map(move |of| (group, of)).collect::<Vec<_>>());
        wanted.filter_map(move |(group, (quantity, paper))| line(recipe, group, quantity, paper))
    };
    PAPER_RECIPES.into_iter().flat_map(of_recipe).collect()
}
