//! What the recorded trainings say, in sentences made from their errors.

use super::Setting;
use crate::estimators::EstimatorId;
use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{COMPARED_SETS, ComparedSet, TableTwo, contact_sets};
use crate::report::format::percent;
use crate::truths::TruthId;

/// Seeds whose largest error exceeds the smallest by this factor matter.
const SEEDS_MATTER: f64 = 1.2;
/// Errors that differ by less than this factor are alike.
const ALIKE: f64 = 1.6;
/// Errors on another finger that exceed those on the finger of the training by this factor are due to the finger.
const OTHER_FINGER: f64 = 3.0;

/// What the table says, and why; sentences that the numbers do not bear out are left away.
pub(super) fn paragraphs(recorded: &[RecipeRow], live: &TableTwo) -> Vec<String> {
    let noise_mm = recorded.iter().map(|row| row.noise_mm).fold(0.0, f64::max);
    let corotational = Setting { recorded, live, truth: TruthId::Corotational, noise_mm };
    let clean = Setting { noise_mm: 0.0, ..corotational };
    let linear = Setting { truth: TruthId::Linear, noise_mm: 0.0, ..corotational };
    let paragraphs = [another_finger(corotational, linear), random_start(clean), cure(corotational)];
    paragraphs.into_iter().flatten().collect()
}

/// What (a) has learnt, and what it makes of a finger that it was not trained on.
fn another_finger(corotational: Setting, linear: Setting) -> Option<String> {
    let [_, neighbours, _] = COMPARED_SETS;
    let near = corotational.recipe("a", &neighbours, "each force")?;
    let learnt = linear.recipe("a", &neighbours, "each force")?;
    if near.mean < OTHER_FINGER * learnt.mean {
        return None;
    }
    Some(format!(
        "Trained as in the paper, (a) has learnt the linear finger ({} for neighbours, without noise) and errs by {} on the co-rotational \
         finger with noise, on which it was not trained. How that compares with the paper's gripper stands in the section on Table II.",
        learnt.in_words(),
        near.in_words(),
    ))
}

/// Where the seed matters, training left weights as they were drawn.
fn random_start(clean: Setting) -> Option<String> {
    let [_, neighbours, _] = COMPARED_SETS;
    let (a, b) = (clean.recipe("a", &neighbours, "each force")?, clean.recipe("b", &neighbours, "each force")?);
    let least_squares = clean.estimator(EstimatorId::LeastSquares, &neighbours, "each force")?;
    if a.greatest < SEEDS_MATTER * a.least {
        return None;
    }
    let at = contact_sets().iter().position(|set| *set == neighbours.nodes)?;
    let condition = clean.live.condition_numbers.get(at)?;
    let mut words = format!(
        "The answer depends on the seed, without any noise: {} for neighbours. Linear cases of two forces lie in a \
         plane of the displacements, and geometric nonlinearity moves the nodes out of it, along directions that training has never shown: \
         there the weights keep their random start.",
        a.range()
    );
    let alike = (b.mean / least_squares).max(least_squares / b.mean) < ALIKE;
    if alike && b.greatest / b.least < a.greatest / a.least {
        words += &format!(
            " Noise in training shows all directions, and the seeds agree better: {} with (b). The rest is what least squares \
             has too ({}): the error of linearisation times the condition number of the contacts ({condition:.1}), as in Table II.",
            b.in_words(),
            percent(least_squares)
        );
    }
    Some(words)
}

/// (c) senses the finger that it was trained on.
fn cure(corotational: Setting) -> Option<String> {
    let [one, neighbours, apart] = COMPARED_SETS;
    let of = |recipe: &str, set: &ComparedSet| corotational.recipe(recipe, set, "each force");
    let (single, near, far) = (of("c", &one)?, of("c", &neighbours)?, of("c", &apart)?);
    let nonlinear = corotational.estimator(EstimatorId::Nonlinear, &neighbours, "each force")?;
    if near.mean > 0.5 * of("b", &neighbours)?.mean {
        return None;
    }
    Some(format!(
        "Cases of the co-rotational finger with noise end this: (c) errs by {} for one node, {} for each of two neighbours and {} for \
         each of two nodes apart; the nonlinear estimator, which solves the finger anew for every noise sample, has {} for neighbours.",
        single.in_words(),
        near.in_words(),
        far.in_words(),
        percent(nonlinear)
    ))
}

#[cfg(test)]
mod tests {
    use super::super::{blocks, table};
    use super::*;
    use crate::experiments::table_two::TableTwoFinger;
    use crate::sampling::scatter::{Scatter, ScatterRow};

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

    /// Neighbours on the co-rotational finger: least squares errs by 30 %, the nonlinear estimator by 2 %.
    fn live() -> TableTwo {
        let row = |estimator: EstimatorId, noise_mm: f64, mean_error: f64| ScatterRow {
            estimator,
            nodes: vec![19, 20],
            noise_mm,
            cases: 100,
            not_carried: 0,
            refused: 0,
            forces: vec![Scatter { mean_error, ..Scatter::default() }; 2],
            sum: Some(Scatter { mean_error: 0.07, ..Scatter::default() }),
        };
        let rows = [0.0, NOISE_MM]
            .map(|noise| [row(EstimatorId::LeastSquares, noise, 0.3), row(EstimatorId::Nonlinear, noise, 0.02)]);
        let fingers = vec![TableTwoFinger { truth: TruthId::Corotational, rows: rows.concat() }];
        TableTwo { cases: 100, condition_numbers: vec![1.0, 1.0, 1.0, 13.2, 13.0, 6.5, 4.0], fingers }
    }

    const A_LINEAR: Errors = ("a", TruthId::Linear, [[0.004; 2], [0.03; 2], [0.004; 2]]);
    const A: Errors = ("a", TruthId::Corotational, [[0.05, 0.06], [0.3, 0.5], [0.08, 0.09]]);
    const A_BY_SPREAD: Errors = ("a, by spread", TruthId::Corotational, [[0.07, 0.09], [0.3, 0.4], [0.12; 2]]);
    const B: Errors = ("b", TruthId::Corotational, [[0.02; 2], [0.31, 0.33], [0.07; 2]]);
    const C: Errors = ("c", TruthId::Corotational, [[0.003; 2], [0.022, 0.024], [0.002; 2]]);

    fn said(errors: &[Errors]) -> String {
        paragraphs(&recorded(errors), &live()).join(" ")
    }

    #[test]
    fn what_the_numbers_bear_out_is_said_with_them() {
        let said = said(&[A_LINEAR, A, A_BY_SPREAD, B, C]);
        for words in [
            "has learnt the linear finger (3.0 % for neighbours, without noise) and errs by 40 % (30\u{2013}50) on the co-rotational",
            "depends on the seed, without any noise: 30 % to 50 %",
            "keep their random start",
            "agree better: 32 % (31\u{2013}33) with (b)",
            "what least squares has too (30 %)",
            "(13.2)",
            "(c) errs by 0.3 % for one node, 2.3 % (2.2\u{2013}2.4) for each of two neighbours",
            "has 2.0 % for neighbours",
        ] {
            assert!(said.contains(words), "{words}: {said}");
        }
    }

    #[test]
    fn what_the_numbers_deny_is_not_said() {
        let good = ("a", TruthId::Corotational, [[0.05, 0.06], [0.04, 0.06], [0.08, 0.09]]);
        assert!(!said(&[A_LINEAR, good, B, C]).contains("has learnt"));
        // The paper's table is compared at all of its nodes, elsewhere.
        assert!(!said(&[A_LINEAR, A, A_BY_SPREAD, B, C]).contains("reproduces"));
        let alike = ("a", TruthId::Corotational, [[0.05, 0.06], [0.40, 0.42], [0.08, 0.09]]);
        assert!(!said(&[A_LINEAR, alike, B, C]).contains("seed"));
        let unlike = ("b", TruthId::Corotational, [[0.02; 2], [0.11, 0.12], [0.07; 2]]);
        let said_of_unlike = said(&[A_LINEAR, A, unlike, C]);
        assert!(said_of_unlike.contains("seed") && !said_of_unlike.contains("condition number"));
        let no_cure = ("c", TruthId::Corotational, [[0.003; 2], [0.2, 0.2], [0.002; 2]]);
        assert!(!said(&[A_LINEAR, A, B, no_cure]).contains("end this"));
    }

    #[test]
    fn nothing_recorded_is_nothing_shown() {
        assert!(blocks(&[], &live()).is_empty());
        // Recipes and estimators of one finger with and without noise.
        assert_eq!(table(&recorded(&[A, B, C]), &live()).rows.len(), 2 * (3 + 2));
    }
}
