//! Checks against other programs, closed forms and ourselves, and comparisons where a difference is expected.

use super::dataset::{Columns, Dataset, Format};
use super::format::verdict;
use super::page::{Block, Column, Section, Table, details, text};
use super::{ReportError, Results};
use crate::check::{Check, Comparison, Kind, Tally, tallies, worst};
use crate::study::Study;

const CSV: &str = "checks.csv";
const COMPARISONS_CSV: &str = "comparisons.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, study.all_checks()), Dataset::records(COMPARISONS_CSV, &study.comparisons)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let mut blocks = Vec::new();
    if !study.is_paper {
        blocks.push(text(
            "Reference values of other programs (OpenSees) and the paper's Table I exist for the paper's finger alone, and \
             so do the spring lattice and the hard cases; they are left out for this scene.",
        ));
    }
    blocks.push(text(
        "External references are figures of another program: OpenSees, MuJoCo, and shapes at which rapier2d comes to rest. Analytical ones \
         are closed forms, theoretical orders and solutions of the literature. Internal ones are our own: another formulation or mesh, \
         a balance, a bound, the true forces of a simulation. OpenSees, MuJoCo and the lattice are given the same EA and EI of the same \
         sections as the beams: they verify solvers and kinematics, not that Euler-Bernoulli beams describe a real finger.",
    ));
    blocks.push(Block::Table(by_source(&study.checks)));
    blocks.push(details(format!("All {} of them", study.checks.len()), vec![Block::Table(table(&study.checks))]));
    blocks.push(details("Where a difference is expected", vec![Block::Table(comparisons(&study.comparisons))]));
    Ok(Some(Section::new("checks", "Cross-checks", blocks).saying([in_words(study)])))
}

/// How many checks pass, those against other programs first and each kind apart.
fn in_words(study: &Study) -> String {
    let of_kind = |Tally { kind, passed, all }: Tally| match kind {
        Kind::External => format!("{passed} of {all} external checks (figures of another program) pass"),
        Kind::Analytical => format!("{passed} of {all} analytical ones (closed forms, literature)"),
        Kind::Internal => format!("{passed} of {all} internal ones (own other formulation, balance or bound)"),
    };
    format!("{}.", counted(study).map(of_kind).join(", "))
}

/// The same for the page's head, where there is little room.
pub(super) fn in_short(study: &Study) -> String {
    let of_kind = |Tally { kind, passed, all }: Tally| format!("{} {passed} of {all}", kind.name());
    format!("Checks that pass: {}.", counted(study).map(of_kind).join(", "))
}

fn counted(study: &Study) -> [Tally; 3] {
    tallies(study.all_checks().collect::<Vec<_>>().into_iter())
}

/// The checks in short: a row for each reference, grouped by its kind, with how close its closest check comes to failing.
fn by_source(checks: &[Check]) -> Table {
    type Source<'c> = (Kind, &'c str);
    let mut sources: Vec<Source> = Vec::new();
    for check in checks {
        if !sources.contains(&(check.kind, &check.source)) {
            sources.push((check.kind, &check.source));
        }
    }
    sources.sort_by_key(|(kind, _)| *kind);
    let of = |source: &Source| {
        let found = checks.iter().filter(|check| (check.kind, check.source.as_str()) == *source);
        found.collect::<Vec<_>>()
    };
    let share = |check: &Check| (check.ours - check.reference).abs() / check.tolerance;
    Columns::new()
        .page("kind", Format::Words, |(kind, _): &Source| kind.name())
        .page("source", Format::Words, |(_, source)| *source)
        .page("checks", Format::Plain, |source| of(source).len())
        .page("largest difference / tolerance", Format::Percent, |source| worst(of(source).into_iter().map(share)))
        .cells(Column::words("verdict"), |source| verdict(of(source).into_iter().all(Check::passes), ["pass", "fail"]))
        .table("Checks by kind and source of their reference", CSV, sources)
}

/// Every check, figure by figure.
pub(super) fn table<'c>(checks: impl IntoIterator<Item = &'c Check>) -> Table {
    Columns::<&Check>::new()
        .page("kind", Format::Words, |check| check.kind.name())
        .page("problem", Format::Words, |check| check.problem.clone())
        .page("source", Format::Words, |check| check.source.clone())
        .page("quantity", Format::Words, |check| check.quantity.clone())
        .page("reference", Format::Plain, |check| to_tolerance(check.reference, check.tolerance))
        .page("ours", Format::Plain, |check| to_tolerance(check.ours, check.tolerance))
        .page("tolerance", Format::Plain, |check| format!("{:.0e}", check.tolerance))
        .cells(Column::words("verdict"), |check| verdict(check.passes(), ["pass", "fail"]))
        .table("Checks: our figure against a reference, and the largest difference that passes", CSV, checks)
}

/// As many decimals as the tolerance speaks of, so that small differences can be seen.
fn to_tolerance(value: f64, tolerance: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if value.abs() < 10.0 * tolerance {
        return format!("{value:.1e}");
    }
    let decimals = (1.0 - tolerance.log10()).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$}")
}

fn comparisons(comparisons: &[Comparison]) -> Table {
    Columns::<&Comparison>::new()
        .page("problem", Format::Words, |of| of.problem.clone())
        .page("source", Format::Words, |of| of.source.clone())
        .page("quantity", Format::Words, |of| of.quantity.clone())
        .page("reference", Format::Figure, |of| of.reference)
        .page("ours", Format::Figure, |of| of.ours)
        .table("Where a difference is expected and nothing is checked", COMPARISONS_CSV, comparisons)
}
