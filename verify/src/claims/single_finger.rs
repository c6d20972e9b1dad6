//! Sections V-A and V-B: the single finger of Table I.

use super::criteria::{
    MUCH_SHARE, SAME_ERROR, TPU_MPA, accounts_for, all_simulated, figure, in_simulation, recalibration,
};
use super::{Claim, ClaimVerdict, between, claim, percent};
use crate::check::worst;
use crate::experiments::table_one::{
    PAPER_LARGEST_ERRORS, PAPER_MIDDLE_BOUNDS, PAPER_RANGE_AT_14, TableOne, TableOneRow,
};
use crate::experiments::twin::moduli_mpa;
use crate::experiments::twin::study::{TwinSensing, TwinStudy};
use crate::study::Study;

pub(super) fn claims(study: &Study) -> Vec<Claim> {
    let Some(table) = study.tables_one.first() else { return Vec::new() };
    let twin = study.twin.as_ref();
    let mut claims = vec![modulus(table)];
    claims.extend(middle(table));
    claims.extend(ends(table, twin));
    claims.extend(noise(study, table));
    claims.extend(twin.into_iter().flat_map(|twin| on_the_twin(table, twin)));
    claims
}

/// Method of all figures of the uniform finger.
fn how(table: &TableOne) -> String {
    format!(
        "simulated: the paper's linear model on the co-rotational finger, weights at {} deg (assumed), no noise; of all nonlinearity it \
         has the geometric one alone",
        table.angle_deg
    )
}

fn listed(rows: &[&TableOneRow], of: impl Fn(&TableOneRow) -> f64) -> String {
    rows.iter().map(|row| format!("{} at {}", percent(of(row)), row.node)).collect::<Vec<_>>().join(", ")
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

fn modulus(table: &TableOne) -> Claim {
    claim(
        "\"the calibrated Young's modulus of our finger is 4.7976 x 10^7 Pa\" (sec. V-A)",
        "47.976 MPa",
        format!("{:.4} of the true one", table.modulus_factor),
        "the paper's measured shapes are not published; on shapes of the simulated co-rotational finger eq. (11) finds this share of the \
         true modulus",
        "",
        ClaimVerdict::NotTested,
    )
}

fn middle(table: &TableOne) -> [Claim; 2] {
    let (middle, _) = split(table);
    let [mean, single] = PAPER_MIDDLE_BOUNDS;
    let row = |words: &str, paper: String, of: &dyn Fn(&TableOneRow) -> f64, bound: f64| {
        claim(
            words,
            paper,
            listed(&middle, of),
            how(table),
            format!("each less than {}", percent(bound)),
            figure(!middle.is_empty() && middle.iter().all(|row| of(row) < bound)),
        )
    };
    [
        row(
            "\"the average sensing error at nodes 18, 20, and 22 is less than 3%\" (sec. V-B)",
            listed(&middle, |row| row.paper_mean_error),
            &|row| row.mean_error,
            mean,
        ),
        row(
            "\"even the maximum error at these three nodes is less than 5%\" (sec. V-B)",
            percent(single),
            &largest,
            single,
        ),
    ]
}

fn ends(table: &TableOne, twin: Option<&TwinStudy>) -> Vec<Claim> {
    let (_, ends) = split(table);
    let pairs: Vec<(f64, f64)> = ends.iter().map(|row| (row.mean_error, row.paper_mean_error)).collect();
    let mut claims = vec![claim(
        "\"these errors are not random errors but systemic errors, which are caused by the nonlinearity of the compliant finger\" (sec. V-B, \
         Table I)",
        listed(&ends, |row| row.paper_mean_error),
        listed(&ends, |row| row.mean_error),
        how(table),
        "at each more than half of the paper's error; a nonlinear material is not tested",
        figure(accounts_for(&pairs)),
    )];
    let positive = ends.iter().filter(|row| row.errors.iter().all(|error| *error > 0.0)).count();
    claims.push(claim(
        "\"the sensed forces at nodes 14, 16, and 24 are all larger than the ground truths\" (sec. V-B)",
        "all",
        format!("at {positive} of {} nodes", ends.len()),
        how(table),
        "under every weight at every one of them",
        figure(!ends.is_empty() && positive == ends.len()),
    ));
    let on_twin = |node: usize, of: &dyn Fn(&TableOneRow) -> String| {
        let row = twin.and_then(|twin| row_at(&twin.after, node));
        row.map_or_else(String::new, |row| format!("; on the finger fitted to the means, {}", of(row)))
    };
    if let Some(row) = row_at(table, 14) {
        let in_words = |row: &TableOneRow| between(row.range(), percent);
        let off = worst(row.range().iter().zip(PAPER_RANGE_AT_14).map(|(ours, paper)| (ours - paper).abs()));
        claims.push(claim(
            "\"although nearly all errors at node 14 exceed 50%, their variation is small, which ranges from 49.6 to 63.7%\" (sec. V-B)",
            between(PAPER_RANGE_AT_14, percent),
            format!("{}{}", in_words(row), on_twin(14, &in_words)),
            how(table),
            format!("both ends within {} of the paper's, on the uniform finger", percent(SAME_ERROR)),
            figure(off < SAME_ERROR),
        ));
    }
    for (node, paper) in PAPER_LARGEST_ERRORS {
        let Some(row) = row_at(table, node.0) else { continue };
        let in_words = |row: &TableOneRow| percent(largest(row));
        claims.push(claim(
            format!("\"the maximum sensing error at nodes 16 and 24 reaches 18% and 24.2%\" (sec. V-B): node {node}"),
            percent(paper),
            format!("{}{}", in_words(row), on_twin(node.0, &in_words)),
            how(table),
            format!("within {} of the paper's, on the uniform finger", percent(SAME_ERROR)),
            figure((largest(row) - paper).abs() < SAME_ERROR),
        ));
    }
    claims
}

/// Errors of sensing on a finger that equals its model.
fn noise(study: &Study, table: &TableOne) -> Option<Claim> {
    let noise = study.noise.as_ref()?;
    let (_, ends) = split(table);
    let ours = |row: &&TableOneRow| {
        let sensed = noise.single.iter().find(|sensed| sensed.nodes == [row.node])?;
        Some((row.node, sensed.mean_error()?, row.paper_mean_error, sensed.refused))
    };
    let found: Vec<_> = ends.iter().map(ours).collect::<Option<_>>()?;
    let words: Vec<String> = found
        .iter()
        .map(|(node, error, _, refused)| format!("{} at {node} ({refused} cases refused)", percent(*error)))
        .collect();
    let pairs: Vec<(f64, f64)> = found.iter().map(|(_, ours, paper, _)| (*ours, *paper)).collect();
    Some(claim(
        "\"the compliant finger ... had poor accuracy (error more than 20%) near the finger tip or base, especially the tip\" (sec. VII)",
        listed(&ends, |row| row.paper_mean_error),
        words.join(", "),
        format!(
            "simulated: nonlinear estimator, {} mm noise, forces of 0.5 to 3 N along the normal, on a finger that is as its model has it",
            noise.noise_mm
        ),
        "at each less than the paper measured",
        all_simulated(&pairs),
    ))
}

/// Conclusions of the paper from its errors, on a finger fitted to them.
fn on_the_twin(table: &TableOne, twin: &TwinStudy) -> Vec<Claim> {
    let all: Vec<&TableOneRow> = table.rows.iter().collect();
    let after: Vec<&TableOneRow> = twin.after.rows.iter().collect();
    let moduli = moduli_mpa(&twin.finger);
    let under = moduli.iter().filter(|modulus| **modulus < TPU_MPA[0]).count();
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
    let compensated = compensated.unwrap_or_default();
    let how = "simulated: a finger with softer zones at base and tip, fitted to these six means; one of several sets of zones that fit";
    vec![
        claim(
            "\"the real equivalent Young's modulus at the tip and base should be lower than the above-calibrated value\" (sec. V-B, inferred)",
            listed(&all, |row| row.paper_mean_error),
            listed(&after, |row| row.mean_error),
            format!(
                "{how}. A fit to the figures that it is to explain tests nothing; it shows that the guess suffices: {under} of its {} softened parts have less than the {} MPa that \
                 the paper quotes for TPU (least: {:.1} MPa)",
                moduli.len(),
                TPU_MPA[0],
                moduli.iter().copied().fold(f64::INFINITY, f64::min)
            ),
            "",
            ClaimVerdict::NotTested,
        ),
        claim(
            "\"recalibration using more nodes is not recommended because this will decrease the sensing accuracy at the middle part, although \
             it could improve the accuracy at the tip and base\" (sec. V-B)",
            "no figure",
            format!(
                "mean error {} in the middle becomes {}, {} at nodes 14, 16 and 24 becomes {}",
                percent(middle[0]),
                percent(middle[1]),
                percent(ends[0]),
                percent(ends[1])
            ),
            format!(
                "{how}; eq. (11) from weights at nine nodes from 14 to 24 instead of three: {:.2} of the modulus",
                twin.recalibrated
            ),
            "larger in the middle, smaller at the ends: the direction of the change, for which the paper has no size",
            recalibration(middle, ends),
        ),
        claim(
            "\"the above errors are also possible to be well compensated by various methods, such as using nonconstant Young's modulus\" \
             (sec. V-B)",
            "no figure",
            compensated.iter().map(|error| percent(*error)).collect::<Vec<_>>().join(", ") + " at 14, 16 and 24",
            format!(
                "{how}; linear least squares with zones calibrated from simulated weights, random forces, {} mm noise",
                twin.noise_mm
            ),
            format!("each less than {}", percent(MUCH_SHARE)),
            in_simulation(!compensated.is_empty() && compensated.iter().all(|error| *error < MUCH_SHARE)),
        ),
    ]
}
