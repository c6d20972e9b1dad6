//! Claims of the paper's sections V-C and V-D: Table II on the moving gripper, and grasps of objects (Figs. 11, 14 and 16).

use super::criteria::{MUCH_SHARE, in_simulation};
use super::gripper::OfGroup;
use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::experiments::grasp::modules::{ModuleStudy, ModuleTest};
use crate::experiments::grasp::observations::{Observations, SMALL_N};
use crate::experiments::table_two::{CONTACT_GROUPS, ContactGroup};
use crate::study::Study;
use finray_model::estimators::EstimatorId;
use minijinja::{Value, context};

/// Contact nodes of the module in the paper's Fig. 11(a).
const CROSSING: [usize; 2] = [18, 20];

pub(super) fn claims(study: &Study, words: &Words) -> Result<Vec<Claim>, ClaimError> {
    let mut claims = Vec::new();
    for group in CONTACT_GROUPS {
        claims.extend(on_the_gripper(study.modules.as_ref(), &group, words)?);
    }
    let test = study.modules.as_ref().and_then(|modules| modules.test(&CROSSING));
    claims.push(crossing(test, words)?);
    let observed = study.observations.as_ref();
    claims.push(left_right(observed, words)?);
    if observed.is_some() {
        claims.push(untouched(observed, words)?);
    }
    claims.push(pick_and_place(observed, words)?);
    Ok(claims)
}

/// Claims on one row of Table II while the gripper closes.
fn on_the_gripper(
    modules: Option<&ModuleStudy>,
    group: &ContactGroup,
    words: &Words,
) -> Result<Vec<Claim>, ClaimError> {
    let of = |estimator| modules.and_then(|modules| modules.group(group, estimator));
    let Some(nonlinear) = of(EstimatorId::Nonlinear) else { return Ok(Vec::new()) };
    let others = [EstimatorId::LeastSquares, EstimatorId::Network].map(|id| (id.label(), of(id)));
    let noise_mm = modules.map_or(f64::NAN, |modules| modules.noise_mm);
    let of_group = OfGroup { group, noise_mm, nonlinear, others, words };
    let each = of_group.row("closing-gripper", "each force", group.paper_force, |errors| Some(errors.force))?;
    let sum = group.paper_sum.map(|paper| of_group.row("closing-gripper", "the sum", paper, |errors| errors.sum));
    Ok(each.into_iter().chain(sum.transpose()?.flatten()).collect())
}

/// Motor angles, degrees, at which the later of two forces begins, and at which the later force exceeds the earlier force (the sequence of Fig.
/// 11(a)).
pub fn order(test: &ModuleTest) -> [Option<f64>; 2] {
    let at =
        |holds: &dyn Fn(&[f64]) -> bool| test.steps.iter().find(|step| holds(&step.true_n)).map(|step| step.turned_deg);
    let begins = at(&|true_n| true_n[0] > 0.0 && true_n[1] > 0.0)
        .filter(|_| test.steps.first().is_some_and(|first| first.true_n[0] == 0.0 && first.true_n[1] > 0.0));
    [begins, at(&|true_n| true_n[0] > true_n[1]).filter(|_| begins.is_some())]
}

/// Claim that one force begins alone and the other force later exceeds it.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn crossing(test: Option<&ModuleTest>, words: &Words) -> Result<Claim, ClaimError> {
    let found = test.map(order);
    let verdict =
        found.map_or(ClaimVerdict::NotTested, |[begins, crosses]| in_simulation(begins.is_some() && crosses.is_some()));
    let [begins_deg, crosses_deg] = found.unwrap_or_default();
    words.claim("crossing", verdict, context! { tested => found.is_some(), begins_deg, crosses_deg })
}

/// Claim that the sensed total forces of both fingers agree.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn left_right(observed: Option<&Observations>, words: &Words) -> Result<Claim, ClaimError> {
    let objects = objects(observed, |totals| Some(totals.left_right[0]));
    let verdict = judged(&objects, |difference| difference <= MUCH_SHARE);
    let largest =
        observed.map(|observed| observed.objects.iter().map(|(_, totals)| totals.left_right[1]).fold(0.0, f64::max));
    let numbers = context! {
        tested => !objects.is_empty(), objects => named(&objects), largest, much => MUCH_SHARE,
        noise_mm => observed.map(|observed| observed.noise_mm),
    };
    words.claim("left-right", verdict, numbers)
}

/// Claim on forces sensed at nodes without contact.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn untouched(observed: Option<&Observations>, words: &Words) -> Result<Claim, ClaimError> {
    let of = |id| observed?.untouched.iter().find(|(estimator, _)| *estimator == id).map(|(_, found)| *found);
    let (nonlinear, linear) = (of(EstimatorId::Nonlinear), of(EstimatorId::LeastSquares));
    let beside = observed.map(|observed| observed.beside_sensor);
    let asked = nonlinear.filter(|found| found.count > 0);
    let verdict = asked.map_or(ClaimVerdict::NotTested, |found| in_simulation(found.within == found.count));
    let counted = |found: Option<crate::experiments::grasp::modules::Untouched>| {
        found.map(|found| context! { count => found.count, within => found.within, largest_n => found.largest_n })
    };
    let numbers = context! {
        tested => asked.is_some(), nonlinear => counted(nonlinear), linear => counted(linear), beside => counted(beside),
        small_n => SMALL_N, noise_mm => observed.map(|observed| observed.noise_mm),
    };
    words.claim("untouched", verdict, numbers)
}

/// Claim that the forces on a finger are the same at equal motor angles while the gripper closes and while it opens.
///
/// # Errors
/// [`ClaimError`] if a number in the claim's text has no value.
pub fn pick_and_place(observed: Option<&Observations>, words: &Words) -> Result<Claim, ClaimError> {
    let objects = objects(observed, |totals| totals.opening_at_nodes);
    let totals = self::objects(observed, |totals| totals.opening);
    let sensed = self::objects(observed, |totals| totals.opening_sensed);
    let verdict = judged(&objects, |difference| difference <= MUCH_SHARE);
    let numbers = context! {
        tested => !objects.is_empty(), objects => named(&objects), totals => named(&totals), sensed => named(&sensed), much => MUCH_SHARE,
        noise_mm => observed.map(|observed| observed.noise_mm),
    };
    words.claim("pick-and-place", verdict, numbers)
}

fn objects(
    observed: Option<&Observations>,
    figure: impl Fn(&crate::experiments::grasp::observations::Totals) -> Option<f64>,
) -> Vec<(String, f64)> {
    let all = observed.into_iter().flat_map(|observed| &observed.objects);
    all.filter_map(|(name, totals)| Some((name.clone(), figure(totals)?))).collect()
}

fn named(objects: &[(String, f64)]) -> Vec<Value> {
    objects.iter().map(|(name, share)| context! { name, share }).collect()
}

/// Verdict in simulation: the criterion must hold for every object.
fn judged(objects: &[(String, f64)], holds: impl Fn(f64) -> bool) -> ClaimVerdict {
    match objects {
        [] => ClaimVerdict::NotTested,
        objects => in_simulation(objects.iter().all(|(_, figure)| holds(*figure))),
    }
}
