//! Claims of the paper's sections V-A and V-B: the single finger of Table I.

use super::criteria::{
    MUCH_SHARE, SAME_ERROR, TPU_MPA, accounts_for, all_simulated, figure, in_simulation, over_assumptions,
    recalibration,
};
use super::experiments::range_of;
use super::words::percent;
use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::check::worst;
use crate::experiments::table_one::{
    PAPER_LARGEST_ERRORS, PAPER_MIDDLE_BOUNDS, PAPER_RANGE_AT_14, TableOne, TableOneRow,
};
use crate::experiments::twin::moduli_mpa;
use crate::experiments::twin::study::{TwinSensing, TwinStudy};
use crate::study::Study;
use minijinja::context;

pub(super) fn claims(study: &Study, words: &Words) -> Result<Vec<Claim>, ClaimError> {
    let tables = &study.tables_one[..];
    let Some(table) = tables.first() else { return Ok(Vec::new()) };
    let twin = study.twin.as_ref();
    let factors: Vec<f64> = tables.iter().map(|table| table.modulus_factor).collect();
    let modulus = context! { modulus_factors => range_of(&factors) };
    let mut claims = vec![words.claim("modulus", ClaimVerdict::NotTested, modulus)?];
    claims.extend(middle(tables, words)?);
    claims.extend(ends(tables, twin, words)?);
    claims.extend(noise(study, table, words)?);
    if let Some(twin) = twin {
        claims.extend(on_the_twin(table, twin, words)?);
    }
    Ok(claims)
}

fn listed<'r>(rows: impl IntoIterator<Item = &'r TableOneRow>, of: impl Fn(&TableOneRow) -> f64) -> String {
    rows.into_iter().map(|row| format!("{} at {}", percent(of(row)), row.node)).collect::<Vec<_>>().join(", ")
}

fn papers(row: &TableOneRow) -> f64 {
    row.paper_mean_error
}

/// Splits the rows into two lists: rows with small mean errors in the paper, then rows with large mean errors.
fn split(table: &TableOne) -> (Vec<&TableOneRow>, Vec<&TableOneRow>) {
    table.rows.iter().partition(|row| row.paper_mean_error <= MUCH_SHARE)
}

fn small(table: &TableOne) -> Vec<&TableOneRow> {
    split(table).0
}

fn large(table: &TableOne) -> Vec<&TableOneRow> {
    split(table).1
}

fn row_at(table: &TableOne, node: usize) -> Option<&TableOneRow> {
    table.rows.iter().find(|row| row.node == node)
}

fn largest(row: &TableOneRow) -> f64 {
    worst(row.range().map(f64::abs))
}

/// Combined verdict on one computed value for all assumed directions of the weights, because the paper does not state the finger's orientation.
fn over_angles(tables: &[TableOne], same: impl Fn(&TableOne) -> bool) -> ClaimVerdict {
    over_assumptions(&tables.iter().map(|table| figure(same(table))).collect::<Vec<_>>())
}

/// Text that lists the finding for each assumed direction of the weights.
fn by_angle(tables: &[TableOne], found: impl Fn(&TableOne) -> String) -> String {
    let at = |table: &TableOne| format!("{} deg: {}", table.angle_deg, found(table));
    tables.iter().map(at).collect::<Vec<_>>().join("; ")
}

fn angles_deg(tables: &[TableOne]) -> Vec<f64> {
    tables.iter().map(|table| table.angle_deg).collect()
}

fn middle(tables: &[TableOne], words: &Words) -> Result<[Claim; 2], ClaimError> {
    let row = |key: &str, of: fn(&TableOneRow) -> f64, bound: f64| {
        let ours = by_angle(tables, |table| listed(small(table), of));
        let paper = listed(small(&tables[0]), papers);
        let holds = |table: &TableOne| !small(table).is_empty() && small(table).iter().all(|row| of(row) < bound);
        let numbers = context! { ours, paper, bound, angles_deg => angles_deg(tables) };
        words.claim(key, over_angles(tables, holds), numbers)
    };
    let [mean, single] = PAPER_MIDDLE_BOUNDS;
    Ok([row("middle-mean", |row| row.mean_error, mean)?, row("middle-largest", largest, single)?])
}

fn ends(tables: &[TableOne], twin: Option<&TwinStudy>, words: &Words) -> Result<Vec<Claim>, ClaimError> {
    let angles_deg = &angles_deg(tables);
    let pairs = |table: &TableOne| -> Vec<(f64, f64)> {
        large(table).iter().map(|row| (row.mean_error, row.paper_mean_error)).collect()
    };
    let positive = |table: &TableOne| large(table).iter().filter(|row| row.errors.iter().all(|e| *e > 0.0)).count();
    let all_positive = |table: &TableOne| !large(table).is_empty() && positive(table) == large(table).len();
    let paper = listed(large(&tables[0]), papers);
    let ours = by_angle(tables, |table| listed(large(table), |row| row.mean_error));
    let counts = by_angle(tables, |table| format!("at {} of {} nodes", positive(table), large(table).len()));
    let accounted = over_angles(tables, |table| accounts_for(&pairs(table)));
    let too_large = over_angles(tables, all_positive);
    let mut claims = vec![
        words.claim("systematic", accounted, context! { paper, ours, angles_deg })?,
        words.claim("too-large", too_large, context! { counts, angles_deg })?,
    ];
    let on_twin = |node: usize| twin.and_then(|twin| row_at(&twin.after, node));
    let has = |node: usize| tables.iter().all(|table| row_at(table, node).is_some());
    if has(14) {
        let range = |table: &TableOne| row_at(table, 14).map_or([f64::NAN; 2], TableOneRow::range);
        let off = |table: &TableOne| {
            worst(range(table).iter().zip(PAPER_RANGE_AT_14).map(|(ours, paper)| (ours - paper).abs()))
        };
        let numbers = context! {
            paper => PAPER_RANGE_AT_14, twin => on_twin(14).map(TableOneRow::range), same => SAME_ERROR, angles_deg,
            ours => by_angle(tables, |table| range(table).map(percent).join(" to ")),
        };
        claims.push(words.claim("range-at-14", over_angles(tables, |table| off(table) < SAME_ERROR), numbers)?);
    }
    for (node, paper) in PAPER_LARGEST_ERRORS.into_iter().filter(|(node, _)| has(node.0)) {
        let ours = |table: &TableOne| row_at(table, node.0).map_or(f64::NAN, largest);
        let numbers = context! {
            node => node.0, paper, twin => on_twin(node.0).map(largest), same => SAME_ERROR, angles_deg,
            ours => by_angle(tables, |table| percent(ours(table))),
        };
        let same = |table: &TableOne| (ours(table) - paper).abs() < SAME_ERROR;
        claims.push(words.claim("largest-at", over_angles(tables, same), numbers)?);
    }
    Ok(claims)
}

/// Claim on errors of sensing for a finger that equals its model.
fn noise(study: &Study, table: &TableOne, words: &Words) -> Result<Option<Claim>, ClaimError> {
    let Some(noise) = &study.noise else { return Ok(None) };
    let (_, ends) = split(table);
    let ours = |row: &&TableOneRow| {
        let sensed = noise.single.iter().find(|sensed| sensed.nodes == [row.node])?;
        let error = sensed.mean_error()?;
        Some((context! { node => row.node, error, refused => sensed.refused }, (error, row.paper_mean_error)))
    };
    let Some(found) = ends.iter().map(ours).collect::<Option<Vec<_>>>() else { return Ok(None) };
    let (ours, pairs): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let numbers = context! { paper => listed(ends, papers), ours, noise_mm => noise.noise_mm };
    words.claim("poor-ends", all_simulated(&pairs), numbers).map(Some)
}

/// Claims on conclusions that the paper draws from its measured sensing errors. The claims are tested on the digital twin, a model finger fitted to
/// the paper's measured errors.
fn on_the_twin(table: &TableOne, twin: &TwinStudy, words: &Words) -> Result<[Claim; 3], ClaimError> {
    let moduli = moduli_mpa(&twin.finger);
    let mean = |rows: &[&TableOneRow], factor: f64| {
        let errors = rows.iter().flat_map(|row| &row.errors).map(|error| ((1.0 + error) * factor - 1.0).abs());
        errors.sum::<f64>() / rows.iter().map(|row| row.errors.len()).sum::<usize>() as f64
    };
    let (middle, ends) = split(&twin.after);
    let [middle, ends] = [middle, ends].map(|rows| [mean(&rows, 1.0), mean(&rows, twin.recalibrated)]);
    let at_ends = |sensing: &&TwinSensing| {
        table.rows.iter().any(|row| row.node == sensing.node && row.paper_mean_error > MUCH_SHARE)
    };
    let compensated: Option<Vec<f64>> = twin.sensing.iter().filter(at_ends).map(|of| of.linear.mean_error()).collect();
    let errors = compensated.unwrap_or_default();
    let softer = context! {
        paper => listed(&table.rows, papers),
        ours => listed(&twin.after.rows, |row| row.mean_error),
        under => moduli.iter().filter(|modulus| **modulus < TPU_MPA[0]).count(),
        parts => moduli.len(),
        tpu_mpa => TPU_MPA[0],
        least_mpa => moduli.iter().copied().fold(f64::INFINITY, f64::min),
    };
    let recalibrated = context! { middle, ends, recalibrated => twin.recalibrated };
    let well = in_simulation(!errors.is_empty() && errors.iter().all(|error| *error < MUCH_SHARE));
    Ok([
        words.claim("softer-ends", ClaimVerdict::NotTested, softer)?,
        words.claim("recalibration", recalibration(middle, ends), recalibrated)?,
        words.claim("compensated", well, context! { errors, noise_mm => twin.noise_mm, much => MUCH_SHARE })?,
    ])
}
