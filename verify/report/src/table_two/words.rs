//! Sentences on Table II: least squares, the nonlinear estimator, and the paper's network.

use super::scaling as recipe_scaling;
use crate::prelude::*;
use finray_studies::experiments::networks::paper::{Figure, PAPER_RECIPES, SAME_FACTOR, figures};
use finray_studies::experiments::networks::records::RecipeRow;
use finray_studies::experiments::table_two::{CONTACT_GROUPS, TableTwo};

/// Noise counts as a minor cause if errors on the linear finger, under the same noise, are below this share of the error.
const MINOR: f64 = 0.5;

/// Sentence on the errors of least squares and of the nonlinear estimator on the co-rotational finger.
pub(super) fn ours(two: &TableTwo, noise_mm: f64) -> Result<Option<String>, ReportError> {
    let numbers = || {
        let of = |group, estimator| two.group(group, TruthId::Corotational, noise_mm, estimator);
        let [_, neighbours, apart] = &CONTACT_GROUPS;
        let (near, far) = (of(neighbours, EstimatorId::LeastSquares)?, of(apart, EstimatorId::LeastSquares)?);
        let nonlinear = of(neighbours, EstimatorId::Nonlinear)?;
        Some(context! {
            near => near.force, far => far.force, sum => near.sum?.max(far.sum?), nonlinear => nonlinear.force,
            refused => nonlinear.refused, cases => nonlinear.refused + nonlinear.answered,
        })
    };
    say("table_two.ours", numbers())
}

/// Sentence on the cause of the error of least squares, if noise is the minor part; otherwise `None`.
pub(super) fn linearisation(two: &TableTwo, noise_mm: f64) -> Result<Option<String>, ReportError> {
    let numbers = || {
        let [_, neighbours, apart] = &CONTACT_GROUPS;
        let of = |truth| two.group(neighbours, truth, noise_mm, EstimatorId::LeastSquares);
        let (near, alone) = (of(TruthId::Corotational)?.force, of(TruthId::Linear)?.force);
        let (near_range, far_range) = (two.condition_range(neighbours)?, two.condition_range(apart)?);
        (alone < MINOR * near).then(|| context! { alone, near => near_range, far => far_range })
    };
    say("table_two.linearisation", numbers())
}

/// Sentence on how many of the paper's five figures its network reproduces on the simulated finger, by scaling of displacements.
pub fn papers(records: &[RecipeRow], noise_mm: f64) -> Result<Option<String>, ReportError> {
    let numbers = || {
        let found = PAPER_RECIPES.iter().map(|recipe| Some((*recipe, figures(records, recipe, noise_mm)?)));
        let found: Vec<(&str, Vec<Figure>)> = found.collect::<Option<_>>()?;
        let figures = || found.iter().flat_map(|(_, figures)| figures);
        let of_recipe = |(recipe, all): &(&str, Vec<Figure>)| {
            let hit = all.iter().filter(|figure| figure.reproduced()).count();
            context! { scaling => recipe_scaling(recipe), hit, of => all.len() }
        };
        Some(context! {
            noise_mm,
            all => figures().all(Figure::reproduced),
            factor => SAME_FACTOR,
            seeds => figures().map(|figure| figure.recorded.seeds).min()?,
            found => found.iter().map(of_recipe).collect::<Vec<_>>(),
        })
    };
    say("table_two.papers", numbers())
}
