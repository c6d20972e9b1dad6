//! Sentences about Table II follow from the records.

use finray_report::format::list;
use finray_report::table_two::words::papers;
use finray_studies::experiments::networks::records::{RecipeRow, Records};
use finray_studies::experiments::table_two::{CONTACT_GROUPS, ContactGroup};
use finray_studies::settings::CAMERA_NOISE_MM;

fn with(records: &[RecipeRow], error: impl Fn(&RecipeRow) -> f64) -> Vec<RecipeRow> {
    records.iter().map(|row| RecipeRow { mean_error: Some(error(row)), ..row.clone() }).collect()
}

/// The paper's error of the quantity that a row records.
fn as_in_the_paper(row: &RecipeRow) -> f64 {
    let of_set = |group: &ContactGroup| group.sets.iter().any(|set| list(*set, " ") == row.nodes);
    let group = CONTACT_GROUPS.into_iter().find(of_set).expect("a set of the table");
    if row.quantity == "sum" { group.paper_sum.expect("a sum") } else { group.paper_force }
}

/// Four of the five figures do not suffice to reproduce Table II.
#[test]
fn table_two_is_reproduced_by_all_five_figures_alone() {
    let records = Records::shipped().expect("records").recipes;
    let said = |records: &[RecipeRow]| papers(records, CAMERA_NOISE_MM).expect("recorded at all nodes");
    let words = said(&with(&records, as_in_the_paper));
    assert!(
        words.contains("in its recorded trainings, reproduces Table II") && words.matches("5 of 5").count() == 2,
        "{words}"
    );
    let apart_missed = with(&records, |row| match (&row.nodes[..], &row.quantity[..]) {
        ("18 20" | "16 20", "each force") => 0.11,
        _ => as_in_the_paper(row),
    });
    let words = said(&apart_missed);
    assert!(words.contains("does not reproduce Table II") && words.matches("4 of 5").count() == 2, "{words}");
    assert!(said(&with(&records, |row| 10.0 * as_in_the_paper(row))).contains("meets 0 of 5"));
    // The shipped records miss some of the paper's figures.
    assert!(said(&records).contains("does not reproduce Table II"));
}
