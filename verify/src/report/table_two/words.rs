//! What Table II says of linear sensing, and of the paper's own network.

use super::scaling as recipe_scaling;
use crate::estimators::EstimatorId;
use crate::experiments::networks::paper::{Figure, PAPER_RECIPES, SAME_FACTOR, figures};
use crate::experiments::networks::records::RecipeRow;
use crate::experiments::table_two::{CONTACT_GROUPS, TableTwo};
use crate::report::format::{list, percent};
use crate::truths::TruthId;

/// Noise is not the cause where the linear finger, with the same noise, errs by less than this share.
const MINOR: f64 = 0.5;

/// Errors of least squares and of the nonlinear estimator on the co-rotational finger.
pub(super) fn ours(two: &TableTwo, noise_mm: f64) -> Option<String> {
    let of = |group, estimator| two.group(group, TruthId::Corotational, noise_mm, estimator);
    let [_, neighbours, apart] = &CONTACT_GROUPS;
    let (near, far) = (of(neighbours, EstimatorId::LeastSquares)?, of(apart, EstimatorId::LeastSquares)?);
    let nonlinear = of(neighbours, EstimatorId::Nonlinear)?;
    Some(format!(
        "Least squares on the uniform finger errs by {} for each of two neighbours, by {} for each of two nodes apart and by no more than {} in \
         a sum; the nonlinear estimator by {} for neighbours ({} of {} cases refused).",
        percent(near.force),
        percent(far.force),
        percent(near.sum?.max(far.sum?)),
        percent(nonlinear.force),
        nonlinear.refused,
        nonlinear.refused + nonlinear.answered
    ))
}

/// Why least squares errs so, where noise is the lesser part of it.
pub(super) fn linearisation(two: &TableTwo, noise_mm: f64) -> Option<String> {
    let [_, neighbours, apart] = &CONTACT_GROUPS;
    let of = |truth| two.group(neighbours, truth, noise_mm, EstimatorId::LeastSquares);
    let (near, alone) = (of(TruthId::Corotational)?, of(TruthId::Linear)?);
    let range = |group| two.condition_range(group).map(|[low, high]| format!("{low:.1} to {high:.1}"));
    let (near_range, far_range) = (range(neighbours)?, range(apart)?);
    (alone.force < MINOR * near.force).then(|| {
        format!(
            "Noise is the lesser part: on the linear finger neighbours err by {}. The rest is the error of linearisation, enlarged by up to the \
             condition number of the contacts ({near_range}; apart {far_range}): neighbours bend the finger nearly alike.",
            percent(alone.force)
        )
    })
}

/// How many of the paper's five figures its own method reproduces on the simulated finger, by the way of scaling.
pub fn papers(records: &[RecipeRow], noise_mm: f64) -> Option<String> {
    let of_recipe = |recipe: &&'static str| {
        let all = figures(records, recipe, noise_mm)?;
        let hit = all.iter().filter(|figure| figure.reproduced()).count();
        Some((recipe_scaling(recipe), hit, all))
    };
    let found: Vec<(&str, usize, Vec<Figure>)> = PAPER_RECIPES.iter().map(of_recipe).collect::<Option<_>>()?;
    let seeds = found.iter().flat_map(|(.., all)| all).map(|figure| figure.recorded.seeds).min()?;
    let all = found.iter().all(|(_, hit, all)| *hit == all.len());
    let counts =
        found.iter().map(|(scaling, hit, all)| format!("{hit} of {} figures scaled by the {scaling}", all.len()));
    Some(format!(
        "In simulation, on the uniform finger with {noise_mm} mm noise, the network of the paper, as recorded, {} Table II: within a factor of \
         {SAME_FACTOR} it \
         meets {} (mean of {seeds} seeds).",
        if all { "reproduces" } else { "does not reproduce" },
        list(counts, ", ")
    ))
}
