//! Hard cases: checks of fingers and loads at the limits of what can be computed, and their results.

use super::format::{figure, verdict};
use crate::prelude::*;
use finray_studies::check::{Check, EXACT_COUNT};
use finray_studies::experiments::hard_cases::{HardCase, TIME_LIMIT_S};

const CSV: &str = "hard_cases.csv";
const VERDICTS: [&str; 2] = ["kept", "broken"];

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::new(CSV, &columns(), &study.hard_cases).csv_alone()]
}

fn columns<'s>() -> Columns<'s, &'s HardCase> {
    Columns::new()
        .file("case", |case: &&HardCase| case.case)
        .page("case", Format::Words, |case| unbroken(case.case))
        .page("what is checked", Format::Words, |case| unbroken(case.expectation))
        .file("difficulty", |case| case.difficulty)
        .file("promise", |case| case.expectation)
        .file("outcome", |case| outcome(case))
        .file("seconds", |case| case.seconds)
        .file("verdict", |case| VERDICTS[usize::from(!case.passes())])
        .cells("verdict", Format::Words, |case| verdict(case.passes(), VERDICTS))
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    if study.hard_cases.is_empty() {
        return Ok(None);
    }
    let broken = study.hard_cases.iter().filter(|case| !case.passes()).map(|case| unbroken(&outcome(case)));
    let table = columns().table("Kept: answered or refused as required", CSV, &study.hard_cases);
    let mut blocks = vec![text(about()), details("The cases", vec![Block::Table(table)])];
    blocks.extend(broken.map(text));
    Ok(Some(Section::new("hard-cases", "Hard cases", blocks).saying([in_words(&study.hard_cases)])))
}

/// Text on what hard cases are, and on how they are checked.
fn about() -> String {
    format!(
        "Variants of the finger at the limits of what can be computed. Each variant is compared with a scaling law, another method, a known limit or \
         the true force, and must finish within {TIME_LIMIT_S} s. checks.csv contains every number."
    )
}

/// Sentence that counts the cases, or names those that fail a check.
fn in_words(cases: &[HardCase]) -> String {
    let broken: Vec<&str> = cases.iter().filter(|case| !case.passes()).map(|case| case.case).collect();
    match &broken[..] {
        [] => format!("All {} hard cases are answered soundly or refused with a reason.", cases.len()),
        broken => format!("{} of {} hard cases fail their checks: {}.", broken.len(), cases.len(), broken.join("; ")),
    }
}

/// Result of a case: its notes, one line per computed number, and the run time.
fn outcome(case: &HardCase) -> String {
    let mut lines = case.notes.clone();
    lines.extend(case.checks.iter().map(compared));
    lines.push(match case.seconds {
        s if s < 0.01 => "< 0.01 s".to_owned(),
        s => format!("{s:.2} s"),
    });
    lines.join("\n")
}

fn compared(check: &Check) -> String {
    let Check { source, quantity, reference, ours, tolerance, .. } = check;
    let broken = if check.passes() { "" } else { " - BROKEN" };
    if *tolerance == EXACT_COUNT {
        return match reference {
            0.0 => format!("{quantity}: {ours}{broken}"),
            _ => format!("{quantity}: {ours} of {reference}{broken}"),
        };
    }
    // The format `{:?}` writes small numbers with a power of ten.
    let limit = match reference {
        0.0 => format!("\u{2264} {tolerance:?}"),
        reference => format!("in {reference:?} \u{b1} {tolerance:?}"),
    };
    format!("{quantity}: {} {limit} ({source}){broken}", figure(*ours))
}

/// Makes the hyphen of a power of ten such as 1e-6 non-breaking, so that the number is not split between two lines.
fn unbroken(words: &str) -> String {
    words.replace("e-", "e\u{2011}")
}
