//! What Table II says of linear sensing, and of the paper's own network.

use super::{paper_network, span};
use crate::estimators::EstimatorId;
use crate::experiments::networks::paper::{Figure, PAPER_RECIPES, SAME_FACTOR, figures, recorded_sets};
use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{CONTACT_GROUPS, ContactGroup, TableTwo};
use crate::report::format::{list, nodes_in_words, percent};
use crate::truths::TruthId;

/// Noise is not the cause where the linear finger, with the same noise, errs by less than this share.
const MINOR: f64 = 0.5;

/// What linear sensing has to do with the table.
pub(super) fn linear(two: &TableTwo) -> Option<String> {
    let noise_mm = two.fingers.iter().flat_map(|finger| &finger.rows).map(|row| row.noise_mm).fold(0.0, f64::max);
    let of = |group: &ContactGroup, truth, estimator| two.group(group, truth, noise_mm, estimator);
    let [_, neighbours, apart] = CONTACT_GROUPS;
    let near = of(&neighbours, TruthId::Corotational, EstimatorId::LeastSquares)?;
    let far = of(&apart, TruthId::Corotational, EstimatorId::LeastSquares)?;
    let alone = of(&neighbours, TruthId::Linear, EstimatorId::LeastSquares)?;
    let nonlinear = of(&neighbours, TruthId::Corotational, EstimatorId::Nonlinear)?;
    let sums = near.sum?.max(far.sum?);
    let mut words = format!(
        "Least squares on the co-rotational finger errs by {} for each of two neighbours, by {} for each of two nodes apart, and by no \
         more than {} in a sum.",
        percent(near.force),
        percent(far.force),
        percent(sums),
    );
    if alone.force < MINOR * near.force {
        let range =
            |group: &ContactGroup| two.condition_range(group).map(|[low, high]| format!("{low:.1} to {high:.1}"));
        words += &format!(
            " Noise is the lesser part: on the linear finger, with the same noise, neighbours err by {}. The rest is the error of \
             linearisation, enlarged by up to the condition number of the contacts, {} for neighbours and {} for nodes apart: \
             neighbours bend the finger nearly alike, and what linear theory gets wrong of the shape is taken for a shift of force from \
             one node to the other.",
            percent(alone.force),
            range(&neighbours)?,
            range(&apart)?,
        );
    }
    words += &format!(
        " The nonlinear estimator, which has the finger's own model, errs by {} for neighbours ({} of {} cases refused).",
        percent(nonlinear.force),
        nonlinear.refused,
        nonlinear.refused + nonlinear.answered
    );
    Some(words)
}

/// Which of the paper's five figures its own method reproduces on the simulated finger.
pub(super) fn papers(records: &[RecipeRow], recipe: &str, noise_mm: f64) -> Option<String> {
    let all = figures(records, recipe, noise_mm)?;
    let listed = |figures: &[&Figure]| {
        let one = |figure: &&Figure| {
            let Figure { group, quantity, paper, recorded } = figure;
            format!("{}, {quantity}: {} (paper {})", group.name, span(recorded).in_words(), percent(*paper))
        };
        list(figures.iter().map(one), "; ")
    };
    let (hit, missed): (Vec<&Figure>, Vec<&Figure>) = all.iter().partition(|figure| figure.reproduced());
    let seeds = all.iter().map(|figure| figure.recorded.seeds).min()?;
    let verdict = match (hit.len(), missed.len()) {
        (_, 0) => {
            format!("reproduces all five figures of Table II within a factor of {SAME_FACTOR}: {}.", listed(&hit))
        }
        (0, _) => format!(
            "reproduces none of the five figures of Table II within a factor of {SAME_FACTOR}: {}.",
            listed(&missed)
        ),
        (some, _) => format!(
            "does not reproduce Table II: {some} of its five figures are met within a factor of {SAME_FACTOR} ({}), the others are missed \
             ({}).",
            listed(&hit),
            listed(&missed)
        ),
    };
    let name = paper_network(recipe);
    let sets = recorded_at(records);
    Some(format!(
        "In simulation, on the co-rotational finger with {noise_mm} mm noise, the {name} (recorded at {sets}; {seeds} seeds) {verdict}"
    ))
}

/// The sets of contacts with records.
pub(super) fn recorded_at(records: &[RecipeRow]) -> String {
    let sets = CONTACT_GROUPS.iter().flat_map(|group| recorded_sets(records, PAPER_RECIPES[0], group));
    format!("nodes {}", list(sets.map(nodes_in_words), "; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::networks::records::Records;
    use crate::settings::CAMERA_NOISE_MM;

    fn with(records: &[RecipeRow], error: impl Fn(&RecipeRow) -> f64) -> Vec<RecipeRow> {
        records.iter().map(|row| RecipeRow { mean_error: Some(error(row)), ..row.clone() }).collect()
    }

    /// The paper's own error of what a row records.
    fn as_in_the_paper(row: &RecipeRow) -> f64 {
        let of_set = |group: &ContactGroup| group.sets.iter().any(|set| list(*set, " ") == row.nodes);
        let group = CONTACT_GROUPS.into_iter().find(of_set).expect("a set of the table");
        if row.quantity == "sum" { group.paper_sum.expect("a sum") } else { group.paper_force }
    }

    /// Four of five figures are not Table II: what is missed is named, with the paper's figure.
    #[test]
    fn table_two_is_reproduced_by_all_five_figures_alone() {
        let records = Records::shipped().expect("records").recipes;
        let said = |records: &[RecipeRow]| papers(records, "a", CAMERA_NOISE_MM).expect("recorded at all nodes");
        assert!(said(&with(&records, as_in_the_paper)).contains("reproduces all five figures"));
        let apart_missed = with(&records, |row| match (&row.nodes[..], &row.quantity[..]) {
            ("18 20" | "16 20", "each force") => 0.11,
            _ => as_in_the_paper(row),
        });
        let words = said(&apart_missed);
        assert!(words.contains("does not reproduce Table II: 4 of its five figures"), "{words}");
        assert!(words.contains("the others are missed (apart, each force: 11 % (paper 30 %))"), "{words}");
        let none = said(&with(&records, |row| 10.0 * as_in_the_paper(row)));
        assert!(none.contains("reproduces none of the five"), "{none}");
    }

    /// What is recorded today misses some of the paper's figures, and the page says so.
    #[test]
    fn the_recorded_network_does_not_reproduce_table_two() {
        let records = Records::shipped().expect("records").recipes;
        for recipe in PAPER_RECIPES {
            let words = papers(&records, recipe, CAMERA_NOISE_MM).expect("recorded at all nodes");
            assert!(words.contains("does not reproduce Table II") && words.contains("missed"), "{words}");
        }
    }
}
