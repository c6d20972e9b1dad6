//! Tests of a dataset in its three forms: a CSV file, an array of the summary, and a table of the page.

use finray_report::dataset::{Columns, Dataset, Format};
use finray_report::page::{Cell, Shade};

/// A node and its error, which may be missing.
type Sample = (usize, Option<f64>);

fn columns() -> Columns<'static, Sample> {
    Columns::<Sample>::new()
        .both("node", "node", Format::Plain, |(node, _)| *node)
        .both("mean_error", "mean error", Format::Error, |(_, error)| *error)
        .page("known", Format::Words, |(_, error)| if error.is_some() { "yes" } else { "no" })
}

fn rows() -> [Sample; 2] {
    [(17, Some(1.0 / 3.0)), (18, None)]
}

fn dataset() -> Dataset<'static> {
    Dataset::new("samples.csv", &columns(), rows())
}

#[test]
fn a_file_has_shortest_numbers_and_empty_fields() {
    let (name, text) = dataset().csv().expect("text").expect("a file");
    assert_eq!(name, "samples.csv");
    assert_eq!(text, "node,mean_error\n17,0.3333333333333333\n18,\n");
    assert!(dataset().summary_alone().csv().expect("no text").is_none());
    assert!(Dataset::new("samples.csv", &columns(), Vec::new()).csv().expect("no text").is_none());
}

#[test]
fn the_summary_has_null_in_the_order_of_the_columns() {
    let dataset = dataset();
    let (key, text) = dataset.json().expect("text").expect("an array");
    let lines: String = text.lines().map(str::trim).collect();
    let wanted = r#"[{"node": 17,"mean_error": 0.3333333333333333},{"node": 18,"mean_error": null}]"#;
    assert_eq!((key, lines.as_str()), ("samples", wanted));
    assert!(dataset.csv_alone().json().expect("no text").is_none());
    // A dataset without rows is an empty array in the summary.
    let none = Dataset::new("samples.csv", &columns(), Vec::new());
    assert_eq!(none.json().expect("text"), Some(("samples", "[]".to_owned())));
}

#[test]
fn the_page_has_the_shown_columns_formatted() {
    let table = columns().table("Samples", "samples.csv", rows());
    assert_eq!((table.caption.as_str(), table.csv.as_deref()), ("Samples", Some("samples.csv")));
    let headings: Vec<_> = table.columns.iter().map(|column| (column.name.as_str(), column.numeric)).collect();
    assert_eq!(headings, [("node", true), ("mean error", true), ("known", false)]);
    assert_eq!(table.rows[0], [Cell::plain("17"), Cell::shaded("33 %", Shade::Red), Cell::plain("yes")]);
    assert_eq!(table.rows[1], ["18", "-", "no"].map(Cell::plain));
}

#[test]
fn records_are_written_as_they_are() {
    let dataset = Dataset::records("pairs.csv", [(1, 0.5), (2, f64::NAN)]);
    assert_eq!(dataset.csv().expect("text").expect("a file").1, "1,0.5\n2,NaN\n");
    assert!(dataset.json().expect("text").expect("an array").1.contains("null"));
}
