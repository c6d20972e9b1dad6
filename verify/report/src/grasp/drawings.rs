//! Drawings of a grasp: fingers, object and forces at selected steps, and the forces over all steps.

use crate::drawings::{lines_of, side_by_side, true_and_sensed};
use crate::prelude::*;
use finray_figures::Lines;
use finray_model::finger::FingerPoint;
use finray_model::scene::Support;
use finray_studies::experiments::grasp::{GraspScene, GraspStep, Phase, finger_name};
use nalgebra::Rotation2;

/// Length of the arrow of the largest force, as a share of the front plate's length.
const LONGEST_ARROW: f64 = 0.2;

/// Charts of the forces over the steps and over the motor angle, each with its caption.
pub(super) fn courses(name: &str, steps: &[GraspStep]) -> Result<Vec<(String, &'static str)>, FigureError> {
    let over_steps = over(steps, |step| step.step as f64);
    let svg = forces(format!("{name}: true (lines), sensed (symbols)"), "step", over_steps)?;
    let mut drawings = vec![(
        svg,
        "Forces in the direction across the gripper, which are equal for both fingers, with 95 % intervals.",
    )];
    let in_phases = |phases: &[Phase]| -> Vec<GraspStep> {
        steps.iter().filter(|step| phases.contains(&step.phase)).cloned().collect()
    };
    let closing = in_phases(&[Phase::Approach, Phase::Close]);
    if closing.len() > 1 {
        let mut series = over(&closing, |step| step.motor_deg);
        let opening = in_phases(&[Phase::Open]);
        let mut caption = "While the gripper closes.";
        if !opening.is_empty() {
            let points = opening.iter().map(|step| [step.motor_deg, step.fingers[0].total_n]).collect();
            series.push(Series::guide("left, opening again", points));
            caption = "Forces while the gripper closes; dotted lines: forces while the gripper opens. Friction causes the difference.";
        }
        let svg = forces(format!("{name}: over the motor's angle"), "motor angle, deg", series)?;
        drawings.push((svg, caption));
    }
    Ok(drawings)
}

/// All drawings of a grasp on one sheet.
///
/// # Errors
/// [`FigureError`] if there is nothing to draw.
pub fn grasp_svg(name: &str, scene: &GraspScene, steps: &[GraspStep]) -> Result<String, FigureError> {
    let moments = moments(steps).into_iter().map(|step| moment(scene, step));
    let courses = courses(name, steps)?.into_iter().map(|(svg, _)| Ok(svg));
    Ok(side_by_side(&moments.chain(courses).collect::<Result<Vec<_>, FigureError>>()?, 2))
}

/// The drawn steps: the first contact, the last step of closing or holding, the middle step of the transport (lifting, carrying, placing), and the
/// last step of the grasp.
fn moments(steps: &[GraspStep]) -> Vec<&GraspStep> {
    let touches = |step: &&GraspStep| step.fingers.iter().any(|finger| !finger.contacts.is_empty());
    let on_way: Vec<&GraspStep> =
        steps.iter().filter(|step| matches!(step.phase, Phase::Lift | Phase::Carry | Phase::Place)).collect();
    let chosen = [
        steps.iter().find(touches),
        steps.iter().rfind(|step| matches!(step.phase, Phase::Close | Phase::Hold)),
        on_way.get(on_way.len() / 2).copied(),
        steps.last(),
    ];
    let mut chosen: Vec<&GraspStep> = chosen.into_iter().flatten().collect();
    chosen.dedup_by_key(|step| step.step);
    chosen
}

/// A point in the coordinates of the drawing, mm. The fingertips point downwards, as in a grasp from above.
fn drawn(at: Vector) -> Point {
    [at.x, -at.y]
}

/// Drawing of fingers, object, support and forces at one step.
fn moment(scene: &GraspScene, step: &GraspStep) -> Result<String, FigureError> {
    let title = format!("step {}, {}: motor at {:.1} deg", step.step, step.phase, step.motor_deg);
    let at_rest = outlines(scene, step, |_, named| scene.finger().point(named));
    let mut series = Series::lines("undeformed", at_rest, Hue::FAINT, 2.0);
    series.extend(bent(scene, step));
    series.extend(object(scene, step));
    series.extend(support(scene, std::slice::from_ref(step)));
    let largest_n = step.fingers.iter().flat_map(|of| &of.contacts).map(|seen| seen.force.norm()).fold(0.0, f64::max);
    series.extend(arrows(scene, step, largest_n));
    let at = drawn(Vector::new(step.object[0], step.object[1]));
    series.extend(keys(at));
    let alt = format!("Two fingers and the object of the grasp at {title}.");
    Chart::to_scale(Frame::half(title, alt), ["across the gripper, mm", "up, mm"], series).svg()
}

/// Lines of both fingers; `at` gives the position of a finger's point in the finger's frame, mm.
fn outlines(scene: &GraspScene, step: &GraspStep, at: impl Fn(usize, FingerPoint) -> Vector) -> Lines {
    let placement = |finger: usize| step.fingers[finger].placement;
    let each = |finger| lines_of(scene.finger(), |named| drawn(placement(finger).outwards(at(finger, named))));
    (0..step.fingers.len()).flat_map(each).collect()
}

/// Series of both deformed fingers.
pub(super) fn bent(scene: &GraspScene, step: &GraspStep) -> Vec<Series> {
    let lines = outlines(scene, step, |finger, named| step.fingers[finger].shape.point(named));
    Series::lines("fingers", lines, Hue::BLUE, 2.0)
}

/// Series of the object's outline.
pub(super) fn object(scene: &GraspScene, step: &GraspStep) -> Vec<Series> {
    let (turn, at) = (Rotation2::new(step.object[2]), Vector::new(step.object[0], step.object[1]));
    let outline = scene.outline().iter().map(|corner| drawn(at + turn * corner)).collect();
    Series::lines("object", vec![outline], Hue::GREEN, 2.4)
}

/// Series of the support, if any. The drawn support spans the positions of all given steps.
pub(super) fn support(scene: &GraspScene, steps: &[GraspStep]) -> Vec<Series> {
    let Some((on_it, upward)) = scene.support() else { return Vec::new() };
    let along = Vector::new(upward.y, -upward.x);
    let half_mm = 0.5 * scene.finger().plate_length_mm(Plate::Front);
    let ways = steps.iter().map(|step| step.gripper_mm.dot(&along));
    let [least, most] = [f64::min, f64::max].map(|of| ways.clone().fold(0.0, of));
    let ends = [least - half_mm, most + half_mm].map(|way_mm| drawn(on_it + along * way_mm));
    let (label, dash) = match scene.grasp().support {
        Some(Support::Table) => ("table", Dash::Solid),
        _ => ("rails before and behind the fingers", Dash::Dashed),
    };
    let lines = Series::lines(label, vec![ends.to_vec()], Hue::NEUTRAL, 3.0).into_iter();
    lines.map(|line| Series { dash, ..line }).collect()
}

/// Two arrows at every contact: the true force along the true normal, and the sensed force along the measured normal. Each arrow ends at its contact.
/// A force of `largest_n`, N, has the longest arrow.
pub(super) fn arrows(scene: &GraspScene, step: &GraspStep, largest_n: f64) -> Vec<Series> {
    let finger = scene.finger();
    let longest_mm = LONGEST_ARROW * finger.plate_length_mm(Plate::Front);
    let mut series = Vec::new();
    for of in &step.fingers {
        for (seen, sensed) in of.contacts_sensed() {
            let foot = of.placement.outwards(seen.point);
            // Arrow lengths have a lower limit, so that arrows of small forces stay visible.
            let arrow = |force: Vector| {
                let length_mm = longest_mm * (0.25 + 0.75 * force.norm() / largest_n);
                let away = (of.placement.axes() * force).normalize() * length_mm;
                [drawn(foot + away), drawn(foot)]
            };
            if seen.normal_n > 0.0 {
                let along = seen.contact.direction(finger) * seen.normal_n;
                series.push(Series::arrow(arrow(along), format!("{:.2} N", seen.normal_n), Hue::VERMILION));
            }
            if let Some(sensed) = sensed.filter(|sensed| sensed.force.sensed_n > 0.0) {
                let along = sensed.read.contact.direction(finger) * sensed.force.sensed_n;
                let arrow = Series::arrow(arrow(along), "", Hue::PURPLE);
                series.push(Series { labels: Vec::new(), dash: Dash::Dashed, ..arrow });
            }
        }
    }
    series
}

/// Series that have no visible points and add entries for the arrows to the legend.
pub(super) fn keys(at: Point) -> [Series; 2] {
    let key = |label: &str, hue, dash| Series { hue, dash, width: 2.4, ..Series::guide(label, vec![at; 2]) };
    let truth = key("true force along the normal", Hue::VERMILION, Dash::Solid);
    [truth, key("sensed along the normal", Hue::PURPLE, Dash::Dashed)]
}

/// Series of the true and the sensed total force on each finger, over the quantity that `at` gives.
fn over(steps: &[GraspStep], at: impl Fn(&GraspStep) -> f64) -> Vec<Series> {
    let mut series = Vec::new();
    for finger in 0..2 {
        let truth = steps.iter().map(|step| [at(step), step.fingers[finger].total_n]).collect();
        let sensed = steps.iter().filter_map(|step| {
            let total = step.fingers[finger].sensed.as_ref().ok()?.as_ref()?.total;
            let half = TWO_SIDED_95 * total.sigma_n;
            Some(([at(step), total.sensed_n], [total.sensed_n - half, total.sensed_n + half]))
        });
        let mut both = true_and_sensed(finger, finger_name(finger), truth, sensed.unzip());
        // The lines have different widths, so that both are visible if they coincide.
        both.iter_mut().take(1).for_each(|truth| truth.width = if finger == 0 { 4.5 } else { 2.0 });
        series.extend(both);
    }
    series
}

fn forces(title: String, along: &str, series: Vec<Series>) -> Result<String, FigureError> {
    let alt = format!("{title}: lines are true forces, symbols are sensed forces with 95 % intervals.");
    Chart::new(Frame::half(title, alt), [Axis::linear(along), Axis::linear("force across, N")], series).svg()
}
