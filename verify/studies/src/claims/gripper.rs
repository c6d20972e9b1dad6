//! Claims of the paper's section V-C: the gripper of Table II.

use super::criteria::{figure, over_assumptions, simulated};
use super::{Claim, ClaimError, Words};
use crate::experiments::networks::paper::{Figure, PAPER_RECIPES, SAME_FACTOR, figures, recorded_sets};
use crate::experiments::table_two::{CONTACT_GROUPS, ContactGroup, GroupErrors, PAPER_ERROR_N, TableTwo};
use crate::study::Study;
use crate::truths::TruthId;
use finray_model::estimators::EstimatorId;
use minijinja::value::Serde;
use minijinja::{Value, context};

/// Bounds of relative errors in the paper's conclusion (sec. VII): upper bound for the sum of two forces, lower bound for each single force.
const SUM_BOUND: f64 = 0.08;
const EACH_BOUND: f64 = 0.30;

pub(super) fn claims(study: &Study, words: &Words) -> Result<Vec<Claim>, ClaimError> {
    let Some(two) = study.table_two.as_ref().filter(|_| study.noise_mm > 0.0) else { return Ok(Vec::new()) };
    let noise_mm = study.noise_mm;
    let by_recipe = PAPER_RECIPES.map(|recipe| figures(&study.records.recipes, recipe, noise_mm));
    let mut claims = Vec::new();
    if let [Some(largest), spread] = &by_recipe {
        for (i, ours) in largest.iter().enumerate() {
            let by_spread = spread.as_ref().and_then(|spread| spread.get(i));
            let recorded_at = recorded_sets(&study.records.recipes, PAPER_RECIPES[0], &ours.group);
            claims.push(of_the_papers_network(ours, by_spread, &recorded_at, noise_mm, words)?);
        }
        claims.extend(in_the_conclusion(largest, spread.as_deref().unwrap_or_default(), noise_mm, words)?);
    }
    for group in CONTACT_GROUPS {
        claims.extend(with_the_model(two, &group, noise_mm, words)?);
    }
    Ok(claims)
}

fn listed(sets: &[&[usize]]) -> String {
    let sets = sets.iter().map(|set| set.iter().map(usize::to_string).collect::<Vec<_>>().join(" and "));
    sets.collect::<Vec<_>>().join("; ")
}

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

/// Claim on the paper's own method: its error on the simulated finger against the error that the paper measured.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn of_the_papers_network(
    ours: &Figure,
    by_spread: Option<&Figure>,
    recorded_at: &[&'static [usize]],
    noise_mm: f64,
    words: &Words,
) -> Result<Claim, ClaimError> {
    let verdicts: Vec<_> = [Some(ours), by_spread].into_iter().flatten().map(|of| figure(of.reproduced())).collect();
    let numbers = context! {
        quoted => quoted(&ours.group, ours.quantity),
        paper => ours.paper,
        over => Serde(ours.recorded),
        spread => by_spread.map(|of| Value::from(Serde(of.recorded))),
        recorded_at => listed(recorded_at),
        sets => listed(ours.group.sets),
        noise_mm,
        factor => SAME_FACTOR,
    };
    words.claim("papers-network", over_assumptions(&verdicts), numbers)
}

/// Claims of the paper's conclusion, for networks whose inputs are scaled by the largest displacement or by the spread of the displacements.
/// `noise_mm` is the noise of a coordinate, mm.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn in_the_conclusion(
    largest: &[Figure],
    spread: &[Figure],
    noise_mm: f64,
    words: &Words,
) -> Result<[Claim; 2], ClaimError> {
    let row = |key: &str, quantity: &str, bound: f64, holds: &dyn Fn(f64) -> bool| {
        let of_two = |all: &&[Figure]| -> Vec<Figure> {
            let two = all.iter().filter(|figure| figure.group.paper_sum.is_some() && figure.quantity == quantity);
            two.cloned().collect()
        };
        let scalings: Vec<_> = [largest, spread].iter().map(of_two).filter(|figures| !figures.is_empty()).collect();
        let all_hold = |figures: &Vec<Figure>| figure(figures.iter().all(|figure| holds(figure.recorded.errors.mean)));
        let verdicts: Vec<_> = scalings.iter().map(all_hold).collect();
        let named = |figure: &Figure| context! { group => figure.group.name, error => figure.recorded.errors.mean };
        let scalings: Vec<Vec<_>> = scalings.iter().map(|figures| figures.iter().map(named).collect()).collect();
        words.claim(key, over_assumptions(&verdicts), context! { scalings, bound, noise_mm })
    };
    Ok([
        row("total-force", "sum", SUM_BOUND, &|error| error < SUM_BOUND)?,
        row("each-force", "each force", EACH_BOUND, &|error| error > EACH_BOUND)?,
    ])
}

/// Claims on the nodes of Table II, tested with estimators that know the simulated finger's model.
fn with_the_model(
    two: &TableTwo,
    group: &ContactGroup,
    noise_mm: f64,
    words: &Words,
) -> Result<Vec<Claim>, ClaimError> {
    let of = |estimator| two.group(group, TruthId::Corotational, noise_mm, estimator);
    let Some(nonlinear) = of(EstimatorId::Nonlinear) else { return Ok(Vec::new()) };
    let others =
        [("linear least squares", of(EstimatorId::LeastSquares)), ("network that ships", of(EstimatorId::Network))];
    let of_group = OfGroup { group, noise_mm, nonlinear, others, words };
    let each = of_group.row("known-model", "each force", group.paper_force, |found| Some(found.force))?;
    let other = match (group.paper_sum, nonlinear.sum) {
        (Some(paper), Some(_)) => of_group.row("known-model", "the sum", paper, |found| found.sum)?,
        _ => of_group.row("known-model-newtons", "", PAPER_ERROR_N, |found| Some(found.force_n))?,
    };
    Ok(each.into_iter().chain(other).collect())
}

/// Errors of the nonlinear estimator and of other estimators at a group of contacts.
pub(super) struct OfGroup<'g> {
    pub group: &'g ContactGroup,
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    pub nonlinear: GroupErrors,
    pub others: [(&'static str, Option<GroupErrors>); 2],
    pub words: &'g Words,
}

impl OfGroup<'_> {
    /// Claim that compares one relative error with the paper's; `None` if the nonlinear estimator has no such error.
    pub fn row(
        &self,
        key: &str,
        quantity: &str,
        paper: f64,
        error: fn(&GroupErrors) -> Option<f64>,
    ) -> Result<Option<Claim>, ClaimError> {
        let &OfGroup { group, noise_mm, ref nonlinear, ref others, words } = self;
        let Some(ours) = error(nonlinear) else { return Ok(None) };
        let other = |(name, found): &(&str, Option<GroupErrors>)| {
            Some(context! { name => *name, error => error(found.as_ref()?)? })
        };
        let numbers = context! {
            group => group.name, quantity, paper, ours, noise_mm, sets => listed(group.sets),
            others => others.iter().filter_map(other).collect::<Vec<_>>(),
            refused => nonlinear.refused, answered => nonlinear.answered,
        };
        words.claim(key, simulated(ours, paper), numbers).map(Some)
    }
}
