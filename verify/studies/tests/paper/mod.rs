//! Studies that concern only the paper's finger: its Tables I and II, one fit of Table I, and its claims. `FINRAY_TEST_CASES=full` records their
//! results in `fixtures/results`, and the report shows these files. Other runs compare cheap figures with the record.

mod claims;
mod table_one;
mod table_two;
mod twin;

use finray_tests::assert_recorded;
use serde::{Deserialize, Serialize};

/// Two machines give the same figure up to this share of the figure.
const SAME: f64 = 1e-5;

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(1e-3)
}

#[derive(Debug, Serialize, Deserialize)]
struct Sentence {
    section: String,
    shown: String,
    sentence: String,
}

/// Checks a recorded sentence of a section, which begins like this one.
#[track_caller]
fn assert_said(section: &str, shown: &str, sentence: String) {
    let begins: String = sentence.chars().take(30).collect();
    let row = Sentence { section: section.to_owned(), shown: shown.to_owned(), sentence };
    let group = |row: &Sentence| row.section == section && row.sentence.starts_with(&begins);
    assert_recorded("sentences.csv", group, vec![row], |a, b| a.sentence == b.sentence && a.shown == b.shown);
}

/// A share in percent, as in the report's sentences: two decimals below 1 %, one below 10 %.
fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        p if p < 0.95 => format!("{:.2} %", 100.0 * share),
        p if p < 9.95 => format!("{:.1} %", 100.0 * share),
        _ => format!("{:.0} %", 100.0 * share),
    }
}

/// Least and greatest of some figures.
fn ends(figures: impl IntoIterator<Item = f64>) -> [f64; 2] {
    figures.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], it| [least.min(it), most.max(it)])
}

fn joined<T: ToString>(items: impl IntoIterator<Item = T>, between: &str) -> String {
    items.into_iter().map(|item| item.to_string()).collect::<Vec<_>>().join(between)
}
