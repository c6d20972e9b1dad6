//! Hard cases: what is promised at the edge of what can be computed, and what came out.

use super::page::{Block, Cell, Column, Row, Section, Table};
use super::sections::{self, text};
use super::tables::{self, figure, verdict};
use crate::check::{Check, EXACT_COUNT};
use crate::experiments::hard_cases::{HardCase, TIME_LIMIT_S};
use crate::study::Study;
use serde::Serialize;

pub(super) const CSV: &str = "hard_cases.csv";
const VERDICTS: [&str; 2] = ["kept", "broken"];

/// A case in the CSV file.
#[derive(Serialize)]
pub(super) struct CaseRow<'c> {
    case: &'c str,
    difficulty: &'c str,
    promise: &'c str,
    outcome: String,
    seconds: f64,
    verdict: &'static str,
}

pub(super) fn rows(study: &Study) -> impl Iterator<Item = CaseRow<'_>> {
    study.hard_cases.iter().map(|case| CaseRow {
        case: case.case,
        difficulty: case.difficulty,
        promise: case.promise,
        outcome: outcome(case),
        seconds: case.seconds,
        verdict: if case.kept() { VERDICTS[0] } else { VERDICTS[1] },
    })
}

pub(super) fn section(study: &Study) -> Section {
    let kept = study.hard_cases.iter().filter(|case| case.kept()).count();
    let blocks = vec![
        text(format!(
            "Variants of the finger at the edge of what can be computed. No promise rests on the solver's own word: it is \
             held against a scaling law, another solution method, a known limit or the true force. An equilibrium is sound \
             if the general sparse path finds the same, linear and with large rotations, if reactions and load leave no \
             force or moment, and if the elastic energy is the work of the load. No case may take more than {TIME_LIMIT_S} \
             s. {kept} of {} cases keep their promise.",
            study.hard_cases.len()
        )),
        text(
            "A broken row means that finray may answer wrongly, or not at all, near such a case: do not trust numbers there \
             before its check is understood. It says nothing about the other rows.",
        ),
        Block::Table(table(&study.hard_cases)),
        Block::Details {
            summary: "Every figure behind these verdicts".to_owned(),
            blocks: vec![Block::Table(tables::checks(study.hard_cases.iter().flat_map(|case| &case.checks)))],
        },
    ];
    sections::section("hard-cases", "Hard cases", blocks)
}

/// What came out: words, then figure by figure, a line each.
fn outcome(case: &HardCase) -> String {
    let mut lines = case.notes.clone();
    lines.extend(case.checks.iter().map(came_out));
    lines.push(match case.seconds {
        s if s < 0.01 => "< 0.01 s".to_owned(),
        s => format!("{s:.2} s"),
    });
    lines.join("\n")
}

fn came_out(check: &Check) -> String {
    let Check { source, quantity, reference, ours, tolerance, .. } = check;
    let broken = if check.passes() { "" } else { " - BROKEN" };
    if *tolerance == EXACT_COUNT {
        return match reference {
            0.0 => format!("{quantity}: {ours}{broken}"),
            _ => format!("{quantity}: {ours} of {reference}{broken}"),
        };
    }
    // `{:?}` writes small numbers with a power of ten.
    let limit = match reference {
        0.0 => format!("\u{2264} {tolerance:?}"),
        reference => format!("in {reference:?} \u{b1} {tolerance:?}"),
    };
    format!("{quantity}: {} {limit} ({source}){broken}", figure(*ours))
}

/// Keeps powers of ten such as 1e-6 on one line.
fn unbroken(words: &str) -> String {
    words.replace("e-", "e\u{2011}")
}

fn table(cases: &[HardCase]) -> Table {
    let row = |case: &HardCase| {
        let words = [case.case, case.difficulty, case.promise].map(|words| Cell::plain(unbroken(words)));
        let answers = [Cell::plain(unbroken(&outcome(case))), verdict(case.kept(), VERDICTS)];
        Row { cells: words.into_iter().chain(answers).collect() }
    };
    Table {
        caption: "What is promised, and what came out".to_owned(),
        columns: ["case", "what makes it hard", "what we promise", "what came out", "verdict"]
            .map(Column::words)
            .into(),
        rows: cases.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}
