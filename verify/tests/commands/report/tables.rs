//! Numbers on the report's pages, compared with the files of the report.

use super::shared::*;
use crate::kit::*;

/// A row of a table on a page, and the source of its numbers: the file, the first cells of the row, and column values that identify the row of the
/// file.
struct Sample {
    file: &'static str,
    row: &'static [&'static str],
    records: &'static [(&'static str, &'static str)],
    /// Heading on the page, column of the file, and factor from the number in the file to the number on the page.
    numbers: &'static [(&'static str, &'static str, f64)],
}

const SAMPLES: [Sample; 7] = [
    Sample {
        file: "estimators.csv",
        row: &["nonlinear"],
        records: &[("estimator", "nonlinear")],
        numbers: &[
            ("time per frame", "seconds", 1e6),
            ("of answers without a warning: force in the 95 % interval", "covered_without_warning", 100.0),
        ],
    },
    Sample {
        file: "coverage.csv",
        row: &["softer ends", "nonlinear"],
        records: &[("truth", "twin"), ("estimator", "nonlinear")],
        numbers: &[("covered", "covered_without_warning", 100.0), ("samples", "samples", 1.0)],
    },
    Sample {
        file: "speed_error.csv",
        row: &["solve", "linear beams"],
        records: &[("task", "solve"), ("model", "linear beams")],
        numbers: &[("time", "seconds", 1e6), ("error", "error", 100.0)],
    },
    Sample {
        file: "validity.csv",
        row: &["3 N at node 19, co-rotational"],
        records: &[("shape", "3 N at node 19, co-rotational")],
        numbers: &[("largest strain", "largest_strain", 100.0), ("shear share", "shear_share", 100.0)],
    },
    Sample {
        file: "table_one.csv",
        row: &["uniform finger, weights at 0 deg"],
        records: &[("node", "24"), ("angle_deg", "0.0")],
        numbers: &[("24", "mean_error", 100.0)],
    },
    Sample {
        file: "table_two.csv",
        row: &["the paper, measured"],
        records: &[("group", "neighbours"), ("quantity", "each force"), ("nodes", "mean")],
        numbers: &[("neighbours: each", "paper_mean_error", 100.0)],
    },
    Sample {
        file: "twin_calibration.csv",
        row: &["modulus_factor"],
        records: &[("repetition", "1"), ("parameter", "modulus_factor")],
        numbers: &[("found / true", "found_over_true", 1.0), ("stated sigma", "sigma", 1.0)],
    },
];

/// For a sample of each kind of table, compares the numbers on the page with the table's file, rounded to the shown digits.
#[test]
fn numbers_of_tables_are_those_of_their_files() {
    let page = PAPERS.pages();
    for Sample { file, row, records, numbers } in SAMPLES {
        let csv = Csv::of(&PAPERS.read(file));
        let held =
            |(column, text): &(&str, &str)| csv.texts(column).iter().map(|cell| cell == text).collect::<Vec<_>>();
        let held: Vec<Vec<bool>> = records.iter().map(held).collect();
        let record = (0..csv.rows.len()).find(|&nth| held.iter().all(|column| column[nth])).expect(file);
        let cells = table_row(&page, file, row);
        for &(heading, column, scale) in numbers {
            let (_, shown) = cells.iter().find(|(of, _)| of == heading).expect(heading);
            let shown = shown.split(' ').next().unwrap_or_default();
            let digits = shown.split('.').nth(1).map_or(0, str::len);
            let value: f64 = csv.texts(column)[record].parse().expect(column);
            assert_eq!(shown, format!("{:.digits$}", scale * value), "{file}, {row:?}: {heading}");
        }
    }
}

/// Headings and texts of a row: the first row that begins with the given cells, in the page's tables for a file.
fn table_row(page: &str, file: &str, row: &[&str]) -> Vec<(String, String)> {
    let tables =
        page.split("<figure class=\"table\">").skip(1).filter(|table| table.contains(&format!("href=\"{file}\"")));
    let texts = |html: &str, tag: &str| -> Vec<String> {
        let opening = format!("<{tag}");
        let cells = html.split(&opening).skip(1).filter_map(|cell| cell.split_once('>'));
        // The visible text of a cell, also if the cell contains a link or a name with an explanation.
        let words = |cell: &str| cell.split("</").next()?.rsplit('>').next().map(as_read);
        cells.filter_map(|(_, cell)| words(cell)).collect()
    };
    let found = tables.flat_map(|table| {
        let headings = texts(table.split("<tbody>").next().unwrap_or_default(), "th ");
        let rows = table.split("<tr>").skip(2).map(|row| texts(row, "td")).collect::<Vec<_>>();
        rows.into_iter().map(move |row| headings.iter().cloned().zip(row).collect::<Vec<_>>())
    });
    let mut found = found.filter(|cells| row.iter().zip(cells).all(|(text, (_, cell))| text == cell));
    found.next().unwrap_or_else(|| panic!("{file} has no row {row:?}"))
}

/// For a wrongly assumed contact, the first page states the share of failing cells whose main cause is the direction. The test recomputes the share
/// of failures caused by a wrong direction from the files, cell by cell and to first order.
#[test]
fn failures_of_a_wrong_contact_are_those_of_the_files() {
    // Errors of the assumed contact: position (mm) and direction (degrees).
    const OFF: [f64; 2] = [1.5, 12.5];
    let limits = Csv::of(&PAPERS.read("explanations.csv"));
    let [per_mm, per_deg] = ["error_per_mm", "error_per_deg"].map(|column| limits.texts(column));
    let at = |csv: &Csv| csv.numbers("s_mm").into_iter().zip(csv.numbers("angle_deg")).collect::<Vec<_>>();
    let explained = at(&limits);
    let trust = Csv::of(&PAPERS.read("trust.csv"));
    let [cases, states, trusted] = ["case", "state", "is_trusted"].map(|column| trust.texts(column));
    let (mut failed, mut by_direction) = (0, 0);
    for (row, cell) in at(&trust).into_iter().enumerate() {
        if (cases[row], states[row], trusted[row]) != ("contact misjudged", "answered", "false") {
            continue;
        }
        let same = explained.iter().position(|other| *other == cell);
        let error = |column: &[&str], off: f64| Some(column[same?].parse::<f64>().ok()?.abs() * off);
        if let (Some(position), Some(direction)) = (error(&per_mm, OFF[0]), error(&per_deg, OFF[1])) {
            failed += 1;
            by_direction += usize::from(direction > position);
        }
    }
    let share = by_direction as f64 / f64::from(failed);
    let summary = PAPERS.summary();
    let entry = array(&summary, "trust").iter().find(|entry| entry["case"] == "contact misjudged").expect("the case");
    assert_close(&[entry["failed_by_direction"].as_f64().expect("a share")], &[share], LINEAR_ROUNDING);
    assert!(failed > 20 && share > 0.0 && share < 1.0, "{by_direction} of {failed}");
    let said =
        format!("With a wrong contact, the main cause is its direction in {:.0} % of the failing cells", 100.0 * share);
    assert!(PAPERS.read("index.html").contains(&said), "{said}");
}
