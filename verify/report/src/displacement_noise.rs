//! Effect of errors in the undeformed positions of the nodes on the Cramer-Rao bounds of sensed forces.

use super::drawings::{Line, one_and_two};
use crate::prelude::*;
use finray_studies::experiments::displacement_noise::{
    DisplacementNoiseRow, DisplacementNoiseStudy, FRAMES, ROTATION_SD_DEG, TRANSLATION_SD_MM,
};

const CSV: &str = "displacement_noise.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, study.displacement_noise.iter().flat_map(|noise| &noise.rows))]
}

/// Rows of one set of contacts. Each row is for one noise model: independent, two images or motor angle.
type OfSet<'s> = &'s [DisplacementNoiseRow];

/// The row of a noise model.
fn of<'s>(of_set: OfSet<'s>, model: &str) -> Option<&'s DisplacementNoiseRow> {
    of_set.iter().find(|row| row.noise == model)
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(noise) = study.displacement_noise.as_ref().filter(|noise| !noise.rows.is_empty()) else { return Ok(None) };
    let of_sets = noise.rows.chunk_by(|a, b| a.nodes == b.nodes);
    let rows = of_sets.map(|of_set| (of_set[0].nodes.replace(' ', ", "), of_set)).rev().collect();
    let lines: [Line<OfSet>; 4] = [
        ("independent errors", |of_set| Some(of(of_set, "independent")?.bound_n)),
        ("two images", |of_set| Some(of(of_set, "two images")?.bound_n)),
        ("motor angle", |of_set| Some(of(of_set, "motor angle")?.bound_n)),
        ("motor angle, least squares", |of_set| Some(of(of_set, "motor angle")?.ordinary_rms_n)),
    ];
    let title = format!("Uncertainty of {} N", noise.force_n);
    let charts = one_and_two(&title, "standard deviation of a force, N", rows, &lines, CSV)?;
    let blocks = vec![text(about(noise)), charts];
    let section = Section::new("displacement-noise", "Where undeformed positions come from", blocks);
    Ok(Some(section.saying(says(noise))))
}

/// Text on the errors of the displacements under each noise model.
fn about(DisplacementNoiseStudy { image_sd_mm, .. }: &DisplacementNoiseStudy) -> String {
    format!(
        "On the other pages each displacement coordinate has an independent error of {image_sd_mm} mm, as if undeformed positions were exact. If \
         displacements come from two images, averaging over {FRAMES} frames does not remove the error of the image at rest. If undeformed positions come \
         from the motor angle, all nodes share an error of the finger base. Ordinary least squares assumes independent errors."
    )
}

/// Sentence on the factors by which errors of the undeformed positions increase the bounds.
fn says(study: &DisplacementNoiseStudy) -> Option<String> {
    let of = |name: &'static str| study.rows.iter().filter(move |row| row.noise == name);
    let worse = of("motor angle").zip(of("independent")).map(|(motor, alone)| motor.bound_n / alone.bound_n);
    let ordinary = of("motor angle").map(|row| row.ordinary_rms_n / row.bound_n);
    let ([least, greatest], ordinary) = (Span::of(worse)?.ends(), Span::of(ordinary)?.greatest);
    Some(format!(
        "If the same camera measures the undeformed finger, the Cramer-Rao bounds shown elsewhere become sqrt(2) times as large. With undeformed \
         positions from the motor angle (assumed errors {TRANSLATION_SD_MM} mm, {ROTATION_SD_DEG} deg) the bounds become {least:.1} to {greatest:.1} \
         times as large, and ordinary least squares errs by up to {ordinary:.1} times this bound."
    ))
}
