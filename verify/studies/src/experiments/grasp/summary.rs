//! Figures that summarise a grasp: outcome, totals, energy and sensing errors.

use super::outlook::{LoopFigures, loop_figures};
use super::{GraspEnd, GraspScene, GraspStep, Phase};
use crate::prelude::*;
use finray_contact::Account;

/// Figures of one grasp: outcome, totals, energy and sensing errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub name: String,
    /// Outcome: `done`, or the failure.
    pub ended: String,
    /// Number of steps at rest.
    pub steps: usize,
    /// Number of steps of each phase, in temporal order.
    pub phases: Vec<(Phase, usize)>,
    /// Largest true total force of a finger, N.
    pub largest_total_n: f64,
    /// Largest imbalance of forces and moments, relative to the largest force of the step.
    pub worst_imbalance: f64,
    /// Largest difference between the two fingers' totals in steps without load on the support, relative to the larger total; `None` if there are no
    /// such steps.
    pub left_right_difference: Option<f64>,
    /// Largest displacement of the object relative to the gripper while the object was lifted and carried, mm; `None` without a path.
    pub slid_mm: Option<f64>,
    /// Work and energy over the grasp, N mm.
    pub energy: Account,
    /// Largest elastic energy of the fingers, N mm.
    pub largest_elastic_nmm: f64,
    /// Sensed contact forces and totals, compared with the true forces and totals.
    pub sensed: SensedSummary,
    /// Figures of the closed loop; `None` if the grasp has no closed loop.
    #[serde(rename = "loop")]
    pub closed_loop: Option<LoopFigures>,
}

/// Sensed forces of a grasp compared with the true forces.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct SensedSummary {
    /// Name of the estimator, or `errors in all variables`.
    pub by: &'static str,
    /// Number of requests: steps of a finger with a contact that can be sensed.
    pub asked: usize,
    /// Number of refused requests.
    pub refused: usize,
    /// Number of answered contacts.
    pub contacts: usize,
    /// Among answered contacts: the number whose stated 95 % interval contains the true force.
    pub contacts_within_95: usize,
    /// Among answered totals: the number whose stated 95 % interval contains the true total.
    pub totals_within_95: usize,
    /// Mean relative error of totals above a tenth of the largest total; `None` without such totals.
    pub mean_total_error: Option<f64>,
    /// Largest relative error of totals above a tenth of the largest total; `None` without such totals.
    pub worst_total_error: Option<f64>,
    /// Largest relative error of contact forces above a tenth of the largest total; `None` without such forces.
    pub worst_contact_error: Option<f64>,
}

impl Summary {
    /// Summarises a grasp from its steps.
    pub fn new(name: &str, scene: &GraspScene, steps: &[GraspStep], ended: &GraspEnd) -> Summary {
        let mut phases: Vec<(Phase, usize)> = Vec::new();
        for step in steps {
            match phases.last_mut() {
                Some((phase, count)) if *phase == step.phase => *count += 1,
                _ => phases.push((step.phase, 1)),
            }
        }
        let held = steps.iter().filter(|step| step.support_force.norm() == 0.0);
        let difference = |step: &GraspStep| {
            let [left, right] = step.fingers.each_ref().map(|finger| finger.on_object.x.abs());
            let larger = left.max(right);
            (larger > 0.0).then(|| (left - right).abs() / larger)
        };
        let largest = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::max);
        let grasp = scene.grasp();
        let held_n = grasp.until_force_n.filter(|_| grasp.holds);
        let motor_deg_per_s = grasp.frames_per_s.map(|_| grasp.motor_deg_per_s);
        Summary {
            name: name.to_owned(),
            ended: ended.to_string(),
            steps: steps.len(),
            phases,
            largest_total_n: largest_total_n(steps),
            worst_imbalance: steps.iter().map(|step| step.imbalance).fold(0.0, f64::max),
            left_right_difference: largest(&mut held.filter_map(difference)),
            slid_mm: slid_mm(steps),
            energy: steps.last().map_or(Account::default(), |step| step.energy),
            largest_elastic_nmm: steps.iter().map(|step| step.energy.elastic_nmm).fold(0.0, f64::max),
            sensed: SensedSummary {
                by: scene.estimator().map_or("errors in all variables", EstimatorId::name),
                ..sensed(steps)
            },
            closed_loop: held_n.and_then(|target_n| loop_figures(steps, target_n, motor_deg_per_s)),
        }
    }
}

/// Largest displacement of the object in the gripper's frame since the beginning of the path, mm; `None` without a path.
fn slid_mm(steps: &[GraspStep]) -> Option<f64> {
    let begins = steps.iter().position(|step| step.phase == Phase::Lift)?;
    let at = |step: &GraspStep| Vector::new(step.object[0], step.object[1]) - step.gripper_mm;
    let from = at(&steps[begins.checked_sub(1)?]);
    let carried = steps[begins..].iter().take_while(|step| matches!(step.phase, Phase::Lift | Phase::Carry));
    carried.map(|step| (at(step) - from).norm()).reduce(f64::max)
}

fn largest_total_n(steps: &[GraspStep]) -> f64 {
    steps.iter().flat_map(|step| &step.fingers).map(|finger| finger.total_n).fold(0.0, f64::max)
}

fn sensed(steps: &[GraspStep]) -> SensedSummary {
    let counts_n = 0.1 * largest_total_n(steps);
    let mut summary = SensedSummary::default();
    let (mut errors, mut of_contacts) = (Vec::new(), Vec::new());
    for finger in steps.iter().flat_map(|step| &step.fingers) {
        let sensed = match &finger.sensed {
            Ok(None) => continue,
            Ok(Some(sensed)) => Some(sensed),
            Err(_) => None,
        };
        summary.asked += 1;
        let Some(sensed) = sensed else {
            summary.refused += 1;
            continue;
        };
        let within = |error: f64| usize::from(error.abs() <= TWO_SIDED_95);
        summary.contacts += sensed.contacts.len();
        summary.totals_within_95 += within(sensed.total.standardised_error());
        for contact in &sensed.contacts {
            summary.contacts_within_95 += within(contact.force.standardised_error());
            if contact.force.true_n > counts_n {
                of_contacts.push(contact.force.relative_error().abs());
            }
        }
        if sensed.total.true_n > counts_n {
            errors.push(sensed.total.relative_error().abs());
        }
    }
    summary.mean_total_error = mean(errors.iter().copied());
    summary.worst_total_error = errors.into_iter().reduce(f64::max);
    summary.worst_contact_error = of_contacts.into_iter().reduce(f64::max);
    summary
}
