//! Section V-C: the gripper of Table II.

use super::criteria::{figure, over_assumptions, simulated};
use super::{Claim, claim, newtons, percent};
use crate::estimators::EstimatorId;
use crate::experiments::networks::paper::{Figure, PAPER_RECIPES, SAME_FACTOR, figures, recorded_sets};
use crate::experiments::table_two::{CONTACT_GROUPS, ContactGroup, GroupErrors, PAPER_ERROR_N, TableTwo};
use crate::study::Study;
use crate::truths::TruthId;

/// Bound of the resultant's error, and what each of two forces is said to exceed (sec. VII).
const SUM_BOUND: f64 = 0.08;
const EACH_BOUND: f64 = 0.30;

pub(super) fn claims(study: &Study) -> Vec<Claim> {
    let Some(two) = study.table_two.as_ref().filter(|_| study.noise_mm > 0.0) else { return Vec::new() };
    let noise_mm = study.noise_mm;
    let by_recipe = PAPER_RECIPES.map(|recipe| figures(&study.records.recipes, recipe, noise_mm));
    let mut claims = Vec::new();
    if let [Some(largest), spread] = &by_recipe {
        let of = |(i, ours): (usize, &Figure)| {
            let by_spread = spread.as_ref().and_then(|spread| spread.get(i));
            let recorded_at = recorded_sets(&study.records.recipes, PAPER_RECIPES[0], &ours.group);
            of_the_papers_network(ours, by_spread, &recorded_at, noise_mm)
        };
        claims.extend(largest.iter().enumerate().map(of));
        claims.extend(in_the_conclusion(largest, spread.as_deref().unwrap_or_default(), noise_mm));
    }
    for group in CONTACT_GROUPS {
        claims.extend(with_the_model(two, &group, noise_mm));
    }
    claims
}

fn listed(sets: &[&[usize]]) -> String {
    let sets = sets.iter().map(|set| set.iter().map(usize::to_string).collect::<Vec<_>>().join(" and "));
    sets.collect::<Vec<_>>().join("; ")
}

/// The paper's sentence with the figure.
fn quoted(group: &ContactGroup, quantity: &str) -> &'static str {
    match (group.name, quantity) {
        ("one node", _) => "\"the average relative error is 6.5% when the grasping forces vary from 0.3 to 3 N\"",
        ("neighbours", "sum") => "the resultant of adjacent nodes: \"the average relative error reduces to 7.4%\"",
        ("neighbours", _) => "two adjacent nodes: \"the average relative error is 47.5%\"",
        (_, "sum") => {
            "nonadjacent nodes: \"the average relative error dramatically decreases to 7.6% when calculating the resultant force\""
        }
        _ => "nonadjacent nodes: \"the overall average relative error is 29.8% if only considering a single node\"",
    }
}

/// The paper's own method on the simulated finger, against what it measured with it.
pub fn of_the_papers_network(
    ours: &Figure,
    by_spread: Option<&Figure>,
    recorded_at: &[&'static [usize]],
    noise_mm: f64,
) -> Claim {
    let over = &ours.recorded;
    let verdicts: Vec<_> = [Some(ours), by_spread].into_iter().flatten().map(|of| figure(of.reproduced())).collect();
    let by_spread = by_spread.map_or_else(
        || "not recorded".to_owned(),
        |figure| {
            let over = figure.recorded;
            format!("{}, {} to {}", percent(over.mean), percent(over.least), percent(over.greatest))
        },
    );
    claim(
        format!("{} (sec. V-C, Table II), sensed with the paper's network", quoted(&ours.group, ours.quantity)),
        percent(ours.paper),
        format!(
            "{} ({} to {} over {} seeds; displacements scaled by their spread: {})",
            percent(over.mean),
            percent(over.least),
            percent(over.greatest),
            over.seeds,
            by_spread
        ),
        format!(
            "recorded: network of 150-200-150 trained on 20 000 noise-free linear cases, on the simulated co-rotational finger with {noise_mm} \
             mm noise; recorded at nodes {} of {}; the paper does not say how it scales displacements: by the largest, or by their spread; {} \
             of {} cases refused",
            listed(recorded_at),
            listed(ours.group.sets),
            over.refused,
            over.refused + over.answered
        ),
        format!("mean over the seeds within a factor of {SAME_FACTOR} of the paper's figure, under either scaling"),
        over_assumptions(&verdicts),
    )
}

/// By the network's inputs scaled by the largest displacement, and by their spread.
pub fn in_the_conclusion(largest: &[Figure], spread: &[Figure], noise_mm: f64) -> [Claim; 2] {
    let row = |words: &str, paper: String, quantity: &str, criterion: &str, holds: &dyn Fn(f64) -> bool| {
        let of = |all: &'_ [Figure]| -> Vec<(&'static str, f64)> {
            let two = all.iter().filter(|figure| figure.group.paper_sum.is_some() && figure.quantity == quantity);
            two.map(|figure| (figure.group.name, figure.recorded.mean)).collect()
        };
        let listed = |figures: &[(&str, f64)]| {
            let each = figures.iter().map(|(group, error)| format!("{} for {group}", percent(*error)));
            each.collect::<Vec<_>>().join(", ")
        };
        let scalings: Vec<_> = [of(largest), of(spread)].into_iter().filter(|figures| !figures.is_empty()).collect();
        let verdicts: Vec<_> =
            scalings.iter().map(|figures| figure(figures.iter().all(|(_, error)| holds(*error)))).collect();
        claim(
            words,
            paper,
            scalings.iter().map(|figures| listed(figures)).collect::<Vec<_>>().join("; scaled by spread: "),
            format!(
                "recorded, as the rows above: the paper's network on the simulated finger, {noise_mm} mm noise, inputs scaled by the largest \
                 displacement or by their spread"
            ),
            criterion,
            over_assumptions(&verdicts),
        )
    };
    [
        row(
            "\"the gripper can precisely predict the total grasping force (average error less than 8%)\" (sec. VII)",
            percent(SUM_BOUND),
            "sum",
            "each sum less than 8 %",
            &|error| error < SUM_BOUND,
        ),
        row(
            "\"less accurate (error more than 30%) when estimating the force distribution at each node\" (sec. VII; Table II has 29.8% for nodes \
             apart)",
            percent(EACH_BOUND),
            "each force",
            "each more than 30 %",
            &|error| error > EACH_BOUND,
        ),
    ]
}

/// The same nodes with estimators that have the simulated finger's own model.
fn with_the_model(two: &TableTwo, group: &ContactGroup, noise_mm: f64) -> Vec<Claim> {
    let of = |estimator| two.group(group, TruthId::Corotational, noise_mm, estimator);
    let Some(nonlinear) = of(EstimatorId::Nonlinear) else { return Vec::new() };
    let others =
        [("linear least squares", of(EstimatorId::LeastSquares)), ("network that ships", of(EstimatorId::Network))];
    let beside = |figure: &dyn Fn(&GroupErrors) -> Option<f64>, unit: &dyn Fn(f64) -> String| {
        let listed =
            others.iter().filter_map(|(name, found)| Some(format!("{name}: {}", unit(figure(found.as_ref()?)?))));
        listed.collect::<Vec<_>>().join("; ")
    };
    let how = format!(
        "nonlinear estimator on the simulated co-rotational finger whose model it has, {noise_mm} mm noise, nodes {}; {} of {} cases refused",
        listed(group.sets),
        nonlinear.refused,
        nonlinear.refused + nonlinear.answered
    );
    let row = |words: String, paper: String, ours: f64, figure: f64, unit: &dyn Fn(f64) -> String, others: String| {
        claim(
            words,
            paper,
            format!("{} ({others})", unit(ours)),
            how.clone(),
            "less than the paper measured",
            simulated(ours, figure),
        )
    };
    let force = beside(&|found| Some(found.force), &percent);
    let what = format!("Table II, {}: what a known model could reach", group.name);
    let mut claims = vec![row(
        format!("{what}, each force"),
        percent(group.paper_force),
        nonlinear.force,
        group.paper_force,
        &percent,
        force,
    )];
    if let (Some(paper), Some(sum)) = (group.paper_sum, nonlinear.sum) {
        let others = beside(&|found| found.sum, &percent);
        claims.push(row(format!("{what}, the sum"), percent(paper), sum, paper, &percent, others));
    } else {
        let others = beside(&|found| Some(found.force_n), &newtons);
        claims.push(row(
            "\"the overall average absolute error is 0.07 N when the grasping forces vary from 0 to 3 N\" (sec. V-C; ours: 0.3 to 3 N)".to_owned(),
            newtons(PAPER_ERROR_N),
            nonlinear.force_n,
            PAPER_ERROR_N,
            &|force_n| format!("{force_n:.3} N"),
            others,
        ));
    }
    claims
}
