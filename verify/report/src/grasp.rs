//! Grasps: objects between two fingers, and the closed loop that holds a force.

mod animation;
mod drawings;
mod rates;

pub use animation::grasp_animation_svg;
pub use drawings::grasp_svg;

use crate::prelude::*;
use drawings::drawings;
use finray_studies::experiments::grasp::file::force_rows;
use finray_studies::experiments::grasp::study::GraspStudy;
use serde::Serialize;

const CSV: &str = "grasp.csv";
const SCENES_CSV: &str = "grasp_scenes.csv";

/// First column of a row of forces: the scene.
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
    vec![forces, Dataset::new(SCENES_CSV, &scenes(), &study.grasps), rates::dataset(study)]
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
        .both("worst_contact_error", "largest of a contact", Format::Percent, |grasp| {
            grasp.noisy.sensed.worst_contact_error
        })
        .file("totals_within_95", |grasp| grasp.noisy.sensed.totals_within_95)
        .file("asked", |grasp| grasp.noisy.sensed.asked)
        .page("totals within 95 %", Format::Plain, move |grasp| {
            of(grasp.noisy.sensed.totals_within_95, grasp.noisy.sensed.asked)
        })
        .file("contacts_within_95", |grasp| grasp.noisy.sensed.contacts_within_95)
        .file("contacts", |grasp| grasp.noisy.sensed.contacts)
        .page("contacts within 95 %", Format::Plain, move |grasp| {
            of(grasp.noisy.sensed.contacts_within_95, grasp.noisy.sensed.contacts)
        })
        .both("refused", "refused", Format::Plain, |grasp| grasp.noisy.sensed.refused)
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some((first, others)) = study.grasps.split_first() else { return Ok(None) };
    let sensed = &first.noisy.sensed;
    let numbers = minijinja::context! {
        name => &first.name,
        carried_n => first.noisy.largest_total_n,
        clean => first.clean.as_ref().and_then(|clean| clean.sensed.worst_total_error),
        noisy => sensed.mean_total_error,
        within => sensed.totals_within_95,
        asked => sensed.asked,
        noise_mm => first.noise_mm,
    };
    let mut blocks = vec![paragraph("grasp.about", numbers.clone())?, moving(first)?];
    blocks.push(Block::Table(scenes().table(
        "Sensed totals of a finger across the gripper",
        SCENES_CSV,
        &study.grasps,
    )));
    blocks.push(figures(first)?);
    for grasp in others {
        let summary = format!("{}: fingers, object and forces step by step", grasp.name);
        blocks.push(details(summary, vec![figures(grasp)?]));
    }
    blocks.extend(study.closed_loop.as_ref().map(rates::blocks).transpose()?.into_iter().flatten());
    let section = Section::new("grasp", "Grasping an object", blocks);
    Ok(Some(section.saying(say("grasp.verdict", Some(numbers))?)))
}

/// Animated drawing of the whole grasp.
fn moving(grasp: &GraspStudy) -> Result<Block, ReportError> {
    let svg = grasp_animation_svg(&grasp.name, &grasp.scene, &grasp.steps)?;
    let caption = "Every step of the grasp. In print, or if the reader prefers no motion, one step.";
    Ok(Block::Figure(Figure::narrow(svg, caption, CSV)))
}

/// Drawings of a grasp: selected steps, and forces over the steps.
fn figures(grasp: &GraspStudy) -> Result<Block, ReportError> {
    let drawings = drawings(&grasp.name, &grasp.scene, &grasp.steps)?.into_iter();
    Ok(Block::Figures { figures: drawings.map(|it| Figure::narrow(it.svg, it.caption, CSV)).collect() })
}
