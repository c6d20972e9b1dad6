//! The paper's Table II, by finger, noise and estimator.

use super::page::{Block, Cell, Column, Row, Section, Table};
use super::sections::{self, text};
use super::tables::{error, percent};
use crate::scatter::ScatterRow;
use crate::study::Study;
use crate::table_two::{CASES_WITHOUT_FIT, CONTACT_SETS, ContactSet, FORCES_N, MOST_FITS, TableTwo, TableTwoFinger};
use serde::Serialize;

pub(super) const CSV: &str = "table_two.csv";
/// Errors below this are shown as none: no reader asks for a millionth of a percent.
const ROUNDING: f64 = 1e-8;

/// One quantity of one set of contacts, as it stands in the CSV.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableTwoRow {
    /// Kinematics of the sensed finger.
    pub truth: &'static str,
    /// Standard deviation of one coordinate, mm.
    pub noise_mm: f64,
    /// Name of the estimator.
    pub estimator: String,
    /// Contact nodes, by spaces.
    pub nodes: String,
    /// `each force` or `sum`.
    pub quantity: &'static str,
    /// Cases that were drawn.
    pub drawn: usize,
    /// Cases that were answered; the mean is theirs.
    pub answered: usize,
    /// Cases that the estimator refused.
    pub refused: usize,
    /// What the paper measured on its gripper.
    pub paper_mean_error: f64,
    /// Mean of |sensed / true - 1|.
    pub mean_error: Option<f64>,
    /// What an estimator that reaches the Cramer-Rao bound has as its mean error.
    pub mean_error_bound: Option<f64>,
}

/// A row for the mean of the forces, and for their sum where there are several.
pub(super) fn rows(table: &TableTwo) -> impl Iterator<Item = TableTwoRow> {
    let rows = table.fingers.iter().flat_map(|finger| finger.rows.iter().map(|row| (finger.truth, row)));
    rows.flat_map(|(truth, row)| {
        let quantities = CONTACT_SETS.into_iter().filter(|set| row.nodes == set.nodes).flat_map(|set| {
            let each = ("each force", set.paper_force, row.mean_error(), row.mean_error_bound());
            let sum = set.paper_sum.map(|paper| ("sum", paper, sum(row), sum_bound(row)));
            [Some(each), sum].into_iter().flatten()
        });
        let rows = quantities.map(|(quantity, paper_mean_error, mean_error, mean_error_bound)| TableTwoRow {
            truth,
            noise_mm: row.noise_mm,
            estimator: row.estimator.clone(),
            nodes: nodes_in_words(&row.nodes, " "),
            quantity,
            drawn: row.drawn(),
            answered: row.cases,
            refused: row.refused,
            paper_mean_error,
            mean_error,
            mean_error_bound,
        });
        rows.collect::<Vec<_>>()
    })
}

/// Node numbers in a row.
pub(super) fn nodes_in_words(nodes: &[usize], between: &str) -> String {
    nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(between)
}

/// Share of cases that were refused.
pub(super) fn share_refused<'r>(rows: impl IntoIterator<Item = &'r ScatterRow>) -> String {
    share_in_words(rows.into_iter().map(|row| [row.refused, row.cases]))
}

/// The same of numbers of refused and of sensed cases.
pub(super) fn share_in_words(counts: impl Iterator<Item = [usize; 2]>) -> String {
    let [refused, sensed] = counts.fold([0, 0], |[r, s], [refused, sensed]| [r + refused, s + sensed]);
    if refused == 0 { "0".to_owned() } else { percent(refused as f64 / (refused + sensed) as f64) }
}

pub(super) fn sum(row: &ScatterRow) -> Option<f64> {
    row.sum.map(|sum| sum.mean_error)
}

fn sum_bound(row: &ScatterRow) -> Option<f64> {
    Some(row.sum?.bound?.mean_error_bound)
}

pub(super) fn section(study: &Study) -> Option<Section> {
    let two = study.table_two.as_ref()?;
    let mut blocks = vec![text(format!(
        "Forces of {} to {} N along the normal act on one node (19), on two neighbours (19 and 20) and on two nodes apart (18 \
         and 20); nodes and directions are known. The paper measured on its gripper and sensed with a network; here a known \
         finger is sensed, {} times for each set of contacts, all estimators from the same pictures. Shown is the mean error \
         of a force and, behind it, of the sum of both; the bound is that of Cramer and Rao. The nonlinear estimator takes its time \
         and senses the first {} of them; the linear finger, which it does not fit, {} times. The network is that which ships \
         for these contacts, trained on the large-rotation finger.",
        FORCES_N[0],
        FORCES_N[1],
        two.cases,
        two.cases.min(MOST_FITS),
        two.cases.min(CASES_WITHOUT_FIT)
    ))];
    blocks.extend(words(two).map(text));
    blocks.push(Block::Table(table(two)));
    Some(sections::section("table-two", "The paper's Table II", blocks))
}

/// What the table says, and why.
pub(super) fn words(two: &TableTwo) -> Option<String> {
    let noisy = |truth: &str, estimator: &str, set: &ContactSet| -> Option<(f64, Option<f64>)> {
        let finger = two.fingers.iter().find(|finger| finger.truth == truth)?;
        let seen = |row: &&ScatterRow| row.estimator == estimator && row.nodes == set.nodes && row.noise_mm > 0.0;
        let row = finger.rows.iter().find(seen)?;
        Some((row.mean_error()?, sum(row)))
    };
    let [_, neighbours, apart] = CONTACT_SETS;
    let (near, near_sum) = noisy("corotational", "least-squares", &neighbours)?;
    let (far, far_sum) = noisy("corotational", "least-squares", &apart)?;
    let sums = near_sum?.max(far_sum?);
    let (alone, _) = noisy("linear", "least-squares", &neighbours)?;
    let (nonlinear, _) = noisy("corotational", "nonlinear", &neighbours)?;
    let [_, near_condition, far_condition] = two.condition_numbers[..] else { return None };
    Some(format!(
        "As in the paper, two forces at once are sensed badly and their sum well: least squares on the large-rotation finger \
         errs by {} for each of two neighbours and by {} for two nodes apart, but by no more than {} in the sum. Noise is not \
         the cause: on the linear finger, with the same noise, neighbours err by {}. The cause is large rotation times the \
         condition number of the contacts: neighbours bend the finger nearly alike, so what linear theory gets wrong of the \
         shape is taken for a shift of force from one node to the other, enlarged by up to {near_condition:.1} for \
         neighbours and {far_condition:.1} for nodes apart, while their sum hardly changes. Sensing with the finger that rotates \
         ends this: {} for neighbours.",
        percent(near),
        percent(far),
        percent(sums),
        percent(alone),
        percent(nonlinear),
    ))
}

/// A row for the paper, then one for each finger, noise and estimator; a bound where there is noise.
fn table(two: &TableTwo) -> Table {
    let paper = CONTACT_SETS.map(|set| errors(Some(set.paper_force), set.paper_sum, set.paper_sum.is_some()));
    let words = ["the paper's gripper", "-", "network"].map(Cell::plain);
    let cells = words.into_iter().chain(paper.into_iter().flatten()).chain([Cell::plain("")]);
    let mut rows = vec![Row { cells: cells.collect() }];
    for finger in &two.fingers {
        rows.extend(finger_rows(finger));
    }
    let columns = CONTACT_SETS.iter().flat_map(|set| {
        let sum = set.paper_sum.map(|_| Column::numbers("sum"));
        [Some(Column::numbers(set.name)), sum].into_iter().flatten()
    });
    Table {
        caption: format!(
            "Mean error of each force and of the sum, forces of {} to {} N; grey above 10 %, dark above 25 %",
            FORCES_N[0], FORCES_N[1]
        ),
        columns: ["finger", "noise, mm", "sensed by"]
            .map(Column::words)
            .into_iter()
            .chain(columns)
            .chain([Column::numbers("refused")])
            .collect(),
        rows,
        csv: Some(CSV.to_owned()),
    }
}

/// For each level of noise the bound, if there is one, and a row an estimator.
fn finger_rows(finger: &TableTwoFinger) -> Vec<Row> {
    let mut seen: Vec<(f64, &str)> = Vec::new();
    for row in &finger.rows {
        if !seen.contains(&(row.noise_mm, &row.estimator)) {
            seen.push((row.noise_mm, &row.estimator));
        }
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut rows = Vec::new();
    let mut last_noise_mm = 0.0;
    for (noise_mm, estimator) in seen {
        let of_set = |set: &ContactSet| {
            let wanted =
                |row: &&ScatterRow| row.noise_mm == noise_mm && row.estimator == estimator && row.nodes == set.nodes;
            finger.rows.iter().find(wanted)
        };
        let line = |what: &str, figures: fn(&ScatterRow) -> [Option<f64>; 2], refused: String| {
            let cells = CONTACT_SETS.iter().flat_map(|set| {
                let [force, sum] = of_set(set).map_or([None, None], figures);
                errors(force, sum, set.paper_sum.is_some())
            });
            let words = [finger_name(finger.truth), &noise_mm.to_string(), what].map(Cell::plain);
            Row { cells: words.into_iter().chain(cells).chain([Cell::plain(refused)]).collect() }
        };
        // The bound is the same beside all estimators; the first one saw all cases.
        if noise_mm > last_noise_mm {
            rows.push(line("bound", |row| [row.mean_error_bound(), sum_bound(row)], String::new()));
            last_noise_mm = noise_mm;
        }
        let refused = share_refused(CONTACT_SETS.iter().filter_map(of_set));
        rows.push(line(estimator, |row| [row.mean_error(), sum(row)], refused));
    }
    rows
}

pub(super) fn finger_name(truth: &str) -> &str {
    match truth {
        "linear" => "linear",
        _ => "large rotation",
    }
}

/// The cells of one set of contacts: each force, and the sum where there is one.
pub(super) fn errors(force: Option<f64>, sum: Option<f64>, has_sum: bool) -> Vec<Cell> {
    let cell = |share: Option<f64>| match share {
        None => Cell::plain("-"),
        Some(rounding) if rounding < ROUNDING => Cell::plain("0 %"),
        Some(share) => error(share),
    };
    if has_sum { vec![cell(force), cell(sum)] } else { vec![cell(force)] }
}
