//! Sentences on Table II: least squares, the nonlinear estimator, and the paper's network.

use super::scaling;
use crate::format::{list, percent};
use crate::prelude::*;
use finray_studies::experiments::networks::paper::{Figure, PAPER_RECIPES, SAME_FACTOR, figures};
use finray_studies::experiments::networks::records::RecipeRow;
use finray_studies::experiments::table_two::{CONTACT_GROUPS, ContactGroup, FORCES_N, MOST_FITS, TableTwo};

/// Noise counts as a minor cause if, with the same noise on both fingers, error on the linear finger / error on the co-rotational finger is below
/// this.
const MINOR: f64 = 0.5;

/// Text on the contacts, cases and forces of the table.
pub(super) fn about(cases: usize) -> String {
    let of_group = |ContactGroup { name, sets, .. }| {
        format!("{name} ({})", list(sets.iter().map(|set| list(*set, " and ")), "; "))
    };
    let (groups, fits) = (list(CONTACT_GROUPS.map(of_group), ", "), cases.min(MOST_FITS));
    let forces_n = list(FORCES_N, " to ");
    format!(
        "The paper's network senses forces on the paper's gripper; here forces are sensed on a simulated finger at \
            the same nodes, {groups}. Each group has {cases} cases ({fits} for the nonlinear estimator) of {forces_n} \
            N along the normal; nodes and directions are known. \"Network of the paper\" is trained as in sec. IV-A on \
            noise-free cases of the linear finger, with two scalings of displacements, because the paper states no \
            scaling."
    )
}

/// Sentence on the errors of least squares and of the nonlinear estimator on the co-rotational finger.
pub(super) fn ours(two: &TableTwo, noise_mm: f64) -> Option<String> {
    let of = |group, estimator| two.group(group, TruthId::Corotational, noise_mm, estimator);
    let [_, neighbours, apart] = &CONTACT_GROUPS;
    let (near, far) = (of(neighbours, EstimatorId::LeastSquares)?, of(apart, EstimatorId::LeastSquares)?);
    let nonlinear = of(neighbours, EstimatorId::Nonlinear)?;
    let (refused, cases) = (nonlinear.refused, nonlinear.refused + nonlinear.answered);
    let [near, far, sum, nonlinear] = [near.force, far.force, near.sum?.max(far.sum?), nonlinear.force].map(percent);
    Some(format!(
        "Least squares on the uniform finger errs by {near} for each force at two neighbours, by {far} for each \
            force at two nodes apart, and by up to {sum} for a sum (means over pairs). The nonlinear estimator errs by \
            {nonlinear} for neighbours ({refused} of {cases} cases refused)."
    ))
}

/// Sentence on the cause of the error of least squares; `None` unless noise causes only the minor part of this error.
pub(super) fn linearisation(two: &TableTwo, noise_mm: f64) -> Option<String> {
    let [_, neighbours, apart] = &CONTACT_GROUPS;
    let of = |truth| two.group(neighbours, truth, noise_mm, EstimatorId::LeastSquares);
    let (near, alone) = (of(TruthId::Corotational)?.force, of(TruthId::Linear)?.force);
    let ([near_least, near_most], [far_least, far_most]) =
        (two.condition_range(neighbours)?, two.condition_range(apart)?);
    (alone < MINOR * near).then(|| {
        format!(
            "Noise causes the smaller part of the errors: on the linear finger, which has no error of \
                linearisation, the forces at neighbours err by {}. The rest is the error of linearisation. It is \
                amplified by up to the condition number of the contacts (neighbours: {near_least:.1} to \
                {near_most:.1}; nodes apart: {far_least:.1} to {far_most:.1}), because forces at neighbours bend the \
                finger almost equally.",
            percent(alone)
        )
    })
}

/// Sentence that states, for each scaling of the displacements, how many of the five errors in Table II the paper's network reproduces on the
/// simulated finger.
pub fn papers(records: &[RecipeRow], noise_mm: f64) -> Option<String> {
    let found = PAPER_RECIPES.iter().map(|recipe| Some((*recipe, figures(records, recipe, noise_mm)?)));
    let found: Vec<(&str, Vec<Figure>)> = found.collect::<Option<_>>()?;
    let figures = || found.iter().flat_map(|(_, figures)| figures);
    let met = |(recipe, all): &(&str, Vec<Figure>)| {
        let hit = all.iter().filter(|figure| figure.reproduced()).count();
        format!("{hit} of {} figures with displacements scaled by the {}", all.len(), scaling(recipe))
    };
    let met = list(found.iter().map(met), ", ");
    let reproduces = if figures().all(Figure::reproduced) { "reproduces" } else { "does not reproduce" };
    let seeds = figures().map(|figure| figure.recorded.seeds).min()?;
    Some(format!(
        "In simulation, on the uniform finger with {noise_mm} mm noise, the network of the paper, in its recorded \
            trainings, {reproduces} Table II: within a factor of {SAME_FACTOR}, it meets {met} (mean of {seeds} \
            seeds)."
    ))
}
