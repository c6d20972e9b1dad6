//! Recorded trainings are summarised over their seeds.

use finray_report::page::Table;
use finray_report::trainings::{RECIPES, by_recipe, by_size};
use finray_studies::experiments::networks::records::{CurveRow, RecipeRow};
use finray_studies::truths::TruthId;

/// Records of two seeds at node 19, with camera noise and without noise.
fn recipe(truth: TruthId, errors: [f64; 2]) -> Vec<RecipeRow> {
    let row = |noise_mm: f64, seed: usize| RecipeRow {
        recipe: "a".to_owned(),
        seed: seed as u64,
        truth,
        noise_mm,
        nodes: "19".to_owned(),
        quantity: "each force".to_owned(),
        cases: 99,
        refused: 1,
        mean_error: Some(errors[seed]),
    };
    [0.0, 0.067].into_iter().flat_map(|noise_mm| [0, 1].map(|seed| row(noise_mm, seed))).collect()
}

fn curve(samples: usize, seed: u64, mean_error: f64) -> CurveRow {
    CurveRow {
        curve: "samples".to_owned(),
        nodes: "24".to_owned(),
        samples,
        hidden_layers: "32-32".to_owned(),
        weights: 1220,
        seed,
        cases: 100,
        mean_error: Some(mean_error),
        mean_error_bound: Some(0.02),
    }
}

fn texts(table: &Table, row: usize) -> Vec<&str> {
    table.rows[row].iter().map(|cell| cell.text.as_str()).collect()
}

#[test]
fn recipes_are_shown_on_the_uniform_finger_over_their_seeds() {
    let rows = [recipe(TruthId::Linear, [0.3, 0.3]), recipe(TruthId::Corotational, [0.04, 0.06])].concat();
    let table = by_recipe(&rows);
    assert_eq!(table.rows.len(), 2 * RECIPES.len());
    let noisy = texts(&table, RECIPES.len());
    assert_eq!((noisy[..3].to_vec(), noisy.last()), (vec!["(a)", "0.067", "5.0 % (4.0\u{2013}6.0)"], Some(&"1.0 %")));
    // The other recipes have no records.
    assert_eq!(texts(&table, 1)[2], "-");
}

#[test]
fn networks_that_differ_in_their_seed_are_one_line() {
    let table = by_size(&[curve(30, 1, 0.03), curve(30, 2, 0.05), curve(100, 1, 0.02)]);
    assert_eq!(table.rows.len(), 2);
    assert_eq!(texts(&table, 0), ["24", "30", "32-32", "1220", "4.0 % (3.0\u{2013}5.0)", "2.00 %"]);
    assert_eq!(texts(&table, 1)[4], "2.0 %");
}
