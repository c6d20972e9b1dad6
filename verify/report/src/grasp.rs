//! Grasps: objects between two fingers, and the closed loop that holds a force.

mod animation;
mod drawings;
pub(super) mod rates;

pub use animation::grasp_animation_svg;
pub use drawings::grasp_svg;

use super::format::{or_nothing, percent};
use crate::prelude::*;
use finray_studies::experiments::grasp::file::force_rows;
use finray_studies::experiments::grasp::study::GraspStudy;
use finray_studies::experiments::grasp::{SensedSummary, Summary};
use serde::Serialize;

const CSV: &str = "grasp.csv";
const SCENES_CSV: &str = "grasp_scenes.csv";
/// How grasps are computed and sensed.
const ABOUT: &str = "In simulation, two fingers of beams on the paper's linkage close on a free object, lift it, carry it and put it \
    down: a disc off the centre, a box in an oblique pose that the fingers rotate, and a ball in mid-air between \
    spring-steel fingers. Every step is an equilibrium of fingers, object, gravity and contacts with Coulomb friction. \
    The lengths of the linkage are assumed, because the paper gives them only in a figure that was not available. \
    Sensing receives the motor angle and, with noise, the displacements of the key nodes and points on both outlines. \
    Sensing also receives which parts touch, and the coefficient of friction. Nothing was tested on a real gripper. \
    The object lies on rails, between which the fingers pass. A grasp ends if the fingers touch each other.";

/// First column of the file of forces; it names the scene.
#[derive(Serialize)]
struct OfScene<'s> {
    scene: &'s str,
}

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let rows = study.grasps.iter().flat_map(|grasp| {
        let rows = grasp.steps.iter().flat_map(|step| force_rows(&grasp.scene, step));
        rows.map(|row| (OfScene { scene: &grasp.name }, row))
    });
    let forces = Dataset::records(CSV, rows).csv_alone();
    vec![forces, Dataset::new(SCENES_CSV, &scenes(), &study.grasps)]
}

/// Columns with the key figures of every grasp.
fn scenes<'c>() -> Columns<'c, &'c GraspStudy> {
    let of = |within: usize, all: usize| format!("{within} of {all}");
    Columns::<&GraspStudy>::new()
        .both("scene", "object", Format::Words, |grasp| grasp.name.clone())
        .file("noise_mm", |grasp| grasp.noise_mm)
        .file("ended", |grasp| grasp.noisy.ended.clone())
        .both("steps", "steps", Format::Plain, |grasp| grasp.noisy.steps)
        .both("largest_total_n", "largest total, N", Format::Fixed(2), |grasp| grasp.noisy.largest_total_n)
        .both("mean_total_error", "mean error", Format::Percent, |grasp| grasp.noisy.sensed.mean_total_error)
        .both("worst_total_error", "largest", Format::Percent, |grasp| grasp.noisy.sensed.worst_total_error)
        .both("worst_contact_error", "largest, one contact", Format::Percent, |grasp| {
            grasp.noisy.sensed.worst_contact_error
        })
        .file("totals_within_95", |grasp| grasp.noisy.sensed.totals_within_95)
        .file("asked", |grasp| grasp.noisy.sensed.asked)
        .page("totals in interval", Format::Plain, move |grasp| {
            of(grasp.noisy.sensed.totals_within_95, grasp.noisy.sensed.asked)
        })
        .file("contacts_within_95", |grasp| grasp.noisy.sensed.contacts_within_95)
        .file("contacts", |grasp| grasp.noisy.sensed.contacts)
        .page("contacts in interval", Format::Plain, move |grasp| {
            of(grasp.noisy.sensed.contacts_within_95, grasp.noisy.sensed.contacts)
        })
        .both("refused", "refused", Format::Plain, |grasp| grasp.noisy.sensed.refused)
}

/// The first grasp, animated, with its forces over the steps, and the key figures of all grasps.
pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(first) = study.grasps.first() else { return Ok(None) };
    let figures = std::iter::once(moving(first)?).chain(courses(first)?.into_iter().take(1)).collect();
    let caption = "Total force that a finger exerts in the direction across the gripper, sensed with noise. Intervals are 95 % intervals; errors are \
                   relative to the true force";
    let table = scenes().table(caption, SCENES_CSV, &study.grasps);
    let blocks = vec![Block::Figures(figures), Block::Table(table)];
    Ok(Some(Section::new("grasp", "Grasping an object", blocks).saying(says(first))))
}

/// Section with a text on how grasps are computed, followed by every grasp with its forces.
pub(super) fn all(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let mut blocks = vec![text(ABOUT)];
    for (n, grasp) in study.grasps.iter().enumerate() {
        // The animation of the first grasp is on the first page.
        let moving = if n == 0 { None } else { Some(moving(grasp)?) };
        blocks.push(Block::Figures(moving.into_iter().chain(courses(grasp)?).collect()));
    }
    Ok((!study.grasps.is_empty()).then(|| Section::new("grasps", "Grasps step by step", blocks)))
}

/// Sentence on the sensed forces of a grasp; `None` if no total force was sensed.
fn says(GraspStudy { name, noise_mm, noisy, clean, .. }: &GraspStudy) -> Option<String> {
    let Summary { largest_total_n, sensed, .. } = noisy;
    let SensedSummary { mean_total_error, worst_total_error, worst_contact_error, totals_within_95, asked, .. } =
        sensed;
    let clean = clean.as_ref().and_then(|clean| clean.sensed.worst_total_error);
    let clean = clean.map_or_else(String::new, |clean| format!(" (without noise: {})", percent(clean)));
    let error = percent((*mean_total_error)?);
    let [total, contact] = [worst_total_error, worst_contact_error].map(|error| or_nothing(error.map(percent)));
    Some(format!(
        "In simulation, each finger presses with up to {largest_total_n:.2} N on a {name} that is grasped, carried and placed. With {noise_mm} mm noise \
         the total errs by {error} on average and {total} at most{clean}, and the force at one of several contacts by up to {contact}. The 95 % intervals \
         contain {totals_within_95} of {asked} true totals."
    ))
}

/// Animated drawing of the whole grasp.
fn moving(grasp: &GraspStudy) -> Result<Figure, ReportError> {
    let svg = grasp_animation_svg(&grasp.name, &grasp.scene, &grasp.steps)?;
    Ok(Figure::narrow(svg, "Every step of the grasp; a printed page shows only one step.", CSV))
}

/// Charts of the forces of a grasp.
fn courses(grasp: &GraspStudy) -> Result<Vec<Figure>, ReportError> {
    let charts = drawings::courses(&grasp.name, &grasp.steps)?.into_iter();
    Ok(charts.map(|(svg, caption)| Figure::narrow(svg, caption, CSV)).collect())
}
