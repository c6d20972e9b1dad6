//! Sections V-A and V-B: the single finger of Table I.

use super::criteria::{
    MUCH_SHARE, SAME_ERROR, TPU_MPA, accounts_for, all_simulated, figure, in_simulation, recalibration,
};
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
    let Some(table) = study.tables_one.first() else { return Ok(Vec::new()) };
    let twin = study.twin.as_ref();
    let modulus = context! { modulus_factor => table.modulus_factor };
    let mut claims = vec![words.claim("modulus", ClaimVerdict::NotTested, modulus)?];
    claims.extend(middle(table, words)?);
    claims.extend(ends(table, twin, words)?);
    claims.extend(noise(study, table, words)?);
    if let Some(twin) = twin {
        claims.extend(on_the_twin(table, twin, words)?);
    }
    Ok(claims)
}

fn listed<'r>(rows: impl IntoIterator<Item = &'r TableOneRow>, of: impl Fn(&TableOneRow) -> f64) -> String {
    rows.into_iter().map(|row| format!("{} at {}", percent(of(row)), row.node)).collect::<Vec<_>>().join(", ")
}

/// The paper's mean of a row.
fn papers(row: &TableOneRow) -> f64 {
    row.paper_mean_error
}

fn split(table: &TableOne) -> (Vec<&TableOneRow>, Vec<&TableOneRow>) {
    table.rows.iter().partition(|row| row.paper_mean_error <= MUCH_SHARE)
}

fn row_at(table: &TableOne, node: usize) -> Option<&TableOneRow> {
    table.rows.iter().find(|row| row.node == node)
}

fn largest(row: &TableOneRow) -> f64 {
    worst(row.range().map(f64::abs))
}

fn middle(table: &TableOne, words: &Words) -> Result<[Claim; 2], ClaimError> {
    let (middle, _) = split(table);
    let row = |key: &str, of: fn(&TableOneRow) -> f64, bound: f64| {
        let ours = listed(middle.iter().copied(), of);
        let paper = listed(middle.iter().copied(), papers);
        let holds = !middle.is_empty() && middle.iter().all(|row| of(row) < bound);
        words.claim(key, figure(holds), context! { ours, paper, bound, angle_deg => table.angle_deg })
    };
    let [mean, single] = PAPER_MIDDLE_BOUNDS;
    Ok([row("middle-mean", |row| row.mean_error, mean)?, row("middle-largest", largest, single)?])
}

fn ends(table: &TableOne, twin: Option<&TwinStudy>, words: &Words) -> Result<Vec<Claim>, ClaimError> {
    let (_, ends) = split(table);
    let angle_deg = table.angle_deg;
    let pairs: Vec<(f64, f64)> = ends.iter().map(|row| (row.mean_error, row.paper_mean_error)).collect();
    let positive = ends.iter().filter(|row| row.errors.iter().all(|error| *error > 0.0)).count();
    let too_large = figure(!ends.is_empty() && positive == ends.len());
    let [paper, ours] = [papers, |row: &TableOneRow| row.mean_error].map(|of| listed(ends.iter().copied(), of));
    let mut claims = vec![
        words.claim("systematic", figure(accounts_for(&pairs)), context! { paper, ours, angle_deg })?,
        words.claim("too-large", too_large, context! { positive, nodes => ends.len(), angle_deg })?,
    ];
    let on_twin = |node: usize| twin.and_then(|twin| row_at(&twin.after, node));
    if let Some(row) = row_at(table, 14) {
        let off = worst(row.range().iter().zip(PAPER_RANGE_AT_14).map(|(ours, paper)| (ours - paper).abs()));
        let numbers = context! {
            paper => PAPER_RANGE_AT_14, ours => row.range(), twin => on_twin(14).map(TableOneRow::range),
            same => SAME_ERROR, angle_deg,
        };
        claims.push(words.claim("range-at-14", figure(off < SAME_ERROR), numbers)?);
    }
    for (node, paper) in PAPER_LARGEST_ERRORS {
        let Some(row) = row_at(table, node.0) else { continue };
        let (ours, twin) = (largest(row), on_twin(node.0).map(largest));
        let numbers = context! { node => node.0, paper, ours, twin, same => SAME_ERROR, angle_deg };
        claims.push(words.claim("largest-at", figure((ours - paper).abs() < SAME_ERROR), numbers)?);
    }
    Ok(claims)
}

/// Errors of sensing on a finger that equals its model.
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

/// Conclusions of the paper from its errors, on a finger fitted to them.
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
