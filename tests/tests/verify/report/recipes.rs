//! What is said of the recorded recipes follows from their errors.

use finray_verify::experiments::networks::records::RecipeRow;
use finray_verify::report::recipes::{RECIPES, blocks, sentences, table};
use finray_verify::truths::TruthId;

const NOISE_MM: f64 = 0.067;

/// Recipe, finger, and the errors of two seeds for one node, neighbours and their sum.
type Errors = (&'static str, TruthId, [[f64; 2]; 3]);

/// Rows of two seeds, for one node, neighbours and their sum, by recipe and finger, alike at both levels of noise.
fn recorded(errors: &[Errors]) -> Vec<RecipeRow> {
    let mut rows = Vec::new();
    for &(recipe, truth, of_quantities) in errors {
        // Nodes apart err as one node does.
        let sets =
            [("19", "each force", 0), ("19 20", "each force", 1), ("19 20", "sum", 2), ("18 20", "each force", 0)];
        for (nodes, quantity, i) in sets {
            for noise_mm in [0.0, NOISE_MM] {
                rows.extend((1..).zip(of_quantities[i]).map(|(seed, error)| RecipeRow {
                    recipe: recipe.to_owned(),
                    seed,
                    truth,
                    noise_mm,
                    nodes: nodes.to_owned(),
                    quantity: quantity.to_owned(),
                    cases: 100,
                    refused: 0,
                    mean_error: Some(error),
                }));
            }
        }
    }
    rows
}

const A_LINEAR: Errors = ("a", TruthId::Linear, [[0.004; 2], [0.03; 2], [0.004; 2]]);
const A: Errors = ("a", TruthId::Corotational, [[0.05, 0.06], [0.3, 0.5], [0.08, 0.09]]);
const A_BY_SPREAD: Errors = ("a, by spread", TruthId::Corotational, [[0.07, 0.09], [0.3, 0.4], [0.12; 2]]);
const B: Errors = ("b", TruthId::Corotational, [[0.02; 2], [0.31, 0.33], [0.07; 2]]);
const C: Errors = ("c", TruthId::Corotational, [[0.003; 2], [0.022, 0.024], [0.002; 2]]);

fn said(errors: &[Errors]) -> String {
    sentences(&recorded(errors)).expect("words").join(" ")
}

#[test]
fn what_the_numbers_bear_out_is_said_with_them() {
    let said = said(&[A_LINEAR, A, A_BY_SPREAD, B, C]);
    for words in [
        "has learnt the linear finger (3.0 % for neighbours) and errs by 40 % (30\u{2013}50) on the uniform",
        "without noise by 30 % to 50 %, depending on the seed",
        "(c) errs by 2.3 % (2.2\u{2013}2.4), on",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn what_the_numbers_deny_is_not_said() {
    let good = ("a", TruthId::Corotational, [[0.05, 0.06], [0.04, 0.06], [0.08, 0.09]]);
    assert!(!said(&[A_LINEAR, good, B, C]).contains("has learnt"));
    let alike = ("a", TruthId::Corotational, [[0.05, 0.06], [0.40, 0.42], [0.08, 0.09]]);
    assert!(!said(&[A_LINEAR, alike, B, C]).contains("seed"));
    let no_cure = ("c", TruthId::Corotational, [[0.003; 2], [0.2, 0.2], [0.002; 2]]);
    assert!(!said(&[A_LINEAR, A, B, no_cure]).contains("(c) errs"));
}

#[test]
fn nothing_recorded_is_nothing_shown() {
    assert!(blocks(&[]).expect("words").is_empty());
    // Recipes of one finger with and without noise.
    assert_eq!(table(&recorded(&[A, B, C])).rows.len(), 2 * RECIPES.len());
}
