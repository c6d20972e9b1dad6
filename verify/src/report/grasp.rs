//! Drawings of a grasp: fingers, object and forces at chosen steps, and the forces through all of them.

use super::dataset::{Columns, Dataset};
use super::page::{Figure, Section};
use super::words::{paragraph, say};
use super::{ReportError, Results};
use crate::experiments::grasp::file::{ForceRow, force_rows};
use crate::experiments::grasp::{FingerStep, GraspScene, GraspStep, Phase, finger_name};
use crate::figures::{Axis, Chart, Dash, FigureError, Frame, Hue, Series, Spread};
use crate::settings::TWO_SIDED_95;
use finray_model::Vector;
use finray_model::finger::{FingerPoint, Plate};
use nalgebra::Rotation2;

/// Length of the largest force's arrow, as a share of the front plate's.
const LONGEST_ARROW: f64 = 0.2;
/// Most moments that are drawn.
const MOMENTS: usize = 4;

const CSV: &str = "grasp.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let rows = study.grasp.iter().flat_map(|grasp| grasp.steps.iter().flat_map(|step| force_rows(&grasp.scene, step)));
    let columns = Columns::<ForceRow>::new()
        .file("step", |row| row.step)
        .file("motor_deg", |row| row.motor_deg)
        .file("phase", |row| row.phase.to_string())
        .file("finger", |row| row.finger)
        .file("contact", |row| row.contact.clone())
        .file("s_mm", |row| row.s_mm)
        .file("angle_deg", |row| row.angle_deg)
        .file("force_n", |row| row.force_n)
        .file("friction_n", |row| row.friction_n)
        .file("sensed_n", |row| row.sensed_n)
        .file("sigma_n", |row| row.sigma_n);
    vec![Dataset::new(CSV, &columns, rows).csv_alone()]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(grasp) = &study.grasp else { return Ok(None) };
    let mut figures = Vec::new();
    for step in moments(&grasp.steps) {
        let caption = format!("Step {}, {}. True forces, and those sensed along the normals.", step.step, step.phase);
        figures.push(Figure::narrow(moment(&grasp.scene, step)?, caption, CSV));
    }
    let series = over(&grasp.steps, |step| step.step as f64);
    let title = format!("{}: force of each finger, {} mm noise", grasp.name, grasp.noise_mm);
    let caption = "Across the gripper. Lines are true (both fingers press alike), signs sensed, with 95 % intervals.";
    figures.push(Figure::narrow(forces(title, "step", series)?, caption, CSV));
    let numbers = minijinja::context! {
        carried_n => grasp.clean.largest_total_n,
        clean => grasp.clean.sensed.worst_total_error,
        noisy => grasp.noisy.sensed.mean_total_error,
        within => grasp.noisy.sensed.totals_within_95,
        asked => grasp.noisy.sensed.asked,
        noise_mm => grasp.noise_mm,
    };
    let blocks = vec![paragraph("grasp.about", numbers.clone())?, super::page::Block::Figures { figures }];
    let section = Section::new("grasp", "Grasping an object", blocks);
    Ok(Some(section.saying(say("grasp.verdict", Some(numbers))?)))
}

/// All drawings of a grasp on one sheet: moments, then forces over the steps and over the motor's angle.
///
/// # Errors
/// [`FigureError`] if there is nothing to draw.
pub fn grasp_svg(name: &str, scene: &GraspScene, steps: &[GraspStep]) -> Result<String, FigureError> {
    let mut drawings = Vec::new();
    for step in moments(steps) {
        drawings.push(moment(scene, step)?);
    }
    let over_steps = over(steps, |step| step.step as f64);
    drawings.push(forces(format!("{name}: force of each finger, step by step"), "step", over_steps)?);
    let closing: Vec<GraspStep> =
        steps.iter().filter(|step| matches!(step.phase, Phase::Approach | Phase::Close)).cloned().collect();
    if closing.len() > 1 {
        let over_angle = over(&closing, |step| step.motor_deg);
        drawings.push(forces(format!("{name}: while the gripper closes"), "motor angle, deg", over_angle)?);
    }
    Ok(side_by_side(&drawings, 2))
}

/// The steps that are drawn: the first touch, the last of closing, the middle of the way and the last with the object held.
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
    chosen.truncate(MOMENTS);
    chosen
}

/// A point with the fingertips below, as a gripper over a table is drawn.
fn drawn(at: Vector) -> [f64; 2] {
    [at.x, -at.y]
}

/// Fingers, object, support and forces at a step.
///
/// # Errors
/// [`FigureError`] if there is nothing to draw.
pub(super) fn moment(scene: &GraspScene, step: &GraspStep) -> Result<String, FigureError> {
    let title = format!("step {}, {}: motor at {:.1} deg", step.step, step.phase, step.motor_deg);
    let finger = scene.finger();
    let lines_of = |at: &dyn Fn(FingerPoint) -> Vector| -> Vec<Vec<[f64; 2]>> {
        finger
            .outline()
            .into_iter()
            .map(|(_, points)| points.into_iter().map(|named| drawn(at(named))).collect())
            .collect()
    };
    let each = |at: &dyn Fn(&FingerStep, FingerPoint) -> Vector| -> Vec<Vec<[f64; 2]>> {
        step.fingers.iter().flat_map(|of| lines_of(&|named| of.placement.outwards(at(of, named)))).collect()
    };
    let at_rest = each(&|_, named| finger.point(named));
    let bent = each(&|of, named| of.shape.point(named));
    let (turn, at) = (Rotation2::new(step.object[2]), Vector::new(step.object[0], step.object[1]));
    let outline = scene.outline().iter().map(|corner| drawn(at + turn * corner)).collect();
    let mut series: Vec<Series> = [
        Series::lines("undeformed", at_rest, Hue::Faint, 2.0),
        Series::lines("fingers", bent, Hue::Blue, 2.0),
        Series::lines("object", vec![outline], Hue::Green, 2.4),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let Some((on_it, upward)) = scene.support() {
        let along = Vector::new(upward.y, -upward.x) * 0.5 * finger.plate_length_mm(Plate::Front);
        let ends = vec![drawn(on_it - along), drawn(on_it + along)];
        series.extend(Series::lines("support", vec![ends], Hue::Neutral, 3.0));
    }
    let longest_mm = LONGEST_ARROW * finger.plate_length_mm(Plate::Front);
    let largest_n = step.fingers.iter().flat_map(|of| &of.contacts).map(|seen| seen.force.norm()).fold(0.0, f64::max);
    for of in &step.fingers {
        for (seen, sensed) in of.contacts_sensed() {
            let world = |vector: Vector| of.placement.axes() * vector;
            let foot = of.placement.outwards(seen.point);
            // An arrow that ends at the contact; small forces keep one that can be seen.
            let arrow = |force: Vector| {
                let length_mm = longest_mm * (0.25 + 0.75 * force.norm() / largest_n);
                [drawn(foot + world(force).normalize() * length_mm), drawn(foot)]
            };
            if seen.force.norm() > 0.0 {
                series.push(Series::arrow(arrow(seen.force), format!("{:.2} N", seen.force.norm()), Hue::Vermilion));
            }
            if let Some(sensed) = sensed.filter(|sensed| sensed.force.sensed_n > 0.0) {
                let along = finger.direction(sensed.read.contact.angle_deg) * sensed.force.sensed_n;
                let arrow = Series::arrow(arrow(along), "", Hue::Purple);
                series.push(Series { labels: Vec::new(), dash: Dash::Dashed, ..arrow });
            }
        }
    }
    series.extend(key("true force on the object", Hue::Vermilion, Dash::Solid, at));
    series.extend(key("sensed along the normal", Hue::Purple, Dash::Dashed, at));
    let alt = format!("Two fingers and the object of the grasp at {title}.");
    Chart::to_scale(Frame::half(title, alt), ["across the gripper, mm", "up, mm"], series).svg()
}

/// An entry of the legend, for arrows.
fn key(label: &str, hue: Hue, dash: Dash, at: Vector) -> Option<Series> {
    let line = Series::lines(label, vec![vec![drawn(at); 2]], hue, 2.4).pop();
    line.map(|line| Series { dash, ..line })
}

/// True and sensed total of each finger over something.
fn over(steps: &[GraspStep], at: impl Fn(&GraspStep) -> f64) -> Vec<Series> {
    let mut series = Vec::new();
    for finger in 0..2 {
        let truth = steps.iter().map(|step| [at(step), step.fingers[finger].total_n]).collect();
        let truth = Series::nth(finger, finger_name(finger), truth);
        let marker = truth.marker;
        // Both lines are seen where they coincide.
        let width = if finger == 0 { 4.5 } else { 2.0 };
        series.push(Series { marker: None, width, ..truth });
        let sensed = steps.iter().filter_map(|step| {
            let total = step.fingers[finger].sensed.as_ref().ok()?.as_ref()?.total;
            let half = TWO_SIDED_95 * total.sigma_n;
            Some(([at(step), total.sensed_n], [total.sensed_n - half, total.sensed_n + half]))
        });
        let (points, intervals): (Vec<_>, Vec<_>) = sensed.unzip();
        if !points.is_empty() {
            let sensed = Series::nth(finger, "", points);
            series.push(Series { marker, dash: Dash::None, spread: Spread::Bars(intervals), ..sensed });
        }
    }
    series
}

fn forces(title: String, along: &str, series: Vec<Series>) -> Result<String, FigureError> {
    let alt = format!("{title}: lines are true forces, signs are sensed ones with 95 % intervals.");
    Chart::new(Frame::half(title, alt), [Axis::linear(along), Axis::linear("force across, N")], series).svg()
}

/// Drawings in rows of `columns`, as one.
fn side_by_side(drawings: &[String], columns: usize) -> String {
    let sizes: Vec<[f64; 2]> = drawings.iter().map(|svg| size(svg)).collect();
    let (mut top, mut width, mut inner) = (0.0_f64, 0.0_f64, String::new());
    for (drawings, sizes) in drawings.chunks(columns).zip(sizes.chunks(columns)) {
        let mut left = 0.0;
        for (svg, [w, _]) in drawings.iter().zip(sizes) {
            let body = svg.split_once('>').map_or("", |(_, body)| body.trim_end().trim_end_matches("</svg>"));
            inner += &format!("<g transform=\"translate({left} {top})\">{body}</g>");
            left += w;
        }
        width = width.max(left);
        top += sizes.iter().map(|[_, h]| *h).fold(0.0, f64::max);
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {top}\" width=\"100%\" \
         style=\"display:block;height:auto;max-width:{width}px\" role=\"img\" stroke-linejoin=\"round\">{inner}</svg>"
    )
}

/// Width and height of a drawing, from its view box.
fn size(svg: &str) -> [f64; 2] {
    let inside =
        svg.split_once("viewBox=\"").and_then(|(_, rest)| rest.split_once('"')).map_or("", |(inside, _)| inside);
    let mut numbers = inside.split_whitespace().skip(2).filter_map(|number| number.parse().ok());
    [numbers.next().unwrap_or(0.0), numbers.next().unwrap_or(0.0)]
}
