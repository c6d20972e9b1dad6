//! Table: effect of errors in the undeformed positions of the nodes on the Cramer-Rao bounds of sensed forces.

use crate::prelude::*;
use finray_studies::experiments::displacement_noise::{
    DisplacementNoiseRow, DisplacementNoiseStudy, FRAMES, ROTATION_SD_DEG, TRANSLATION_SD_MM,
};

const CSV: &str = "displacement_noise.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, study.displacement_noise.iter().flat_map(|noise| &noise.rows))]
}

/// Rows of one set of contacts, one per noise model: independent, two images, motor angle.
type OfSet<'s> = &'s [DisplacementNoiseRow];

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(noise) = study.displacement_noise.as_ref().filter(|noise| !noise.rows.is_empty()) else { return Ok(None) };
    let cases = noise.rows.first().map_or(0, |row| row.cases);
    let (pairs, singles): (Vec<OfSet>, Vec<OfSet>) =
        noise.rows.chunk_by(|a, b| a.nodes == b.nodes).partition(|of_set| of_set[0].nodes.contains(' '));
    let of = |of_set: &OfSet, model: &str| of_set.iter().find(|row| row.noise == model).cloned();
    let columns = Columns::<OfSet>::new()
        .page("nodes", Format::Plain, |of_set| of_set[0].nodes.clone())
        .each(["independent", "two images", "motor angle"], |columns, model| {
            columns.page(model, Format::Fixed(4), move |of_set| Some(of(of_set, model)?.bound_n))
        })
        .page("25 frames", Format::Fixed(4), move |of_set| Some(of(of_set, "two images")?.bound_of_25_frames_n))
        .page("ordinary / bound", Format::Fixed(1), move |of_set| {
            of(of_set, "motor angle").map(|row| row.ordinary_rms_n / row.bound_n)
        })
        .page("refused", Format::Plain, |of_set| of_set.iter().map(|row| row.refused).sum::<usize>());
    let blocks = vec![
        paragraph(
            "displacement_noise.about",
            context! { noise_mm => noise.image_sd_mm, frames => FRAMES, cases },
        )?,
        details("By contact", vec![Block::Table(columns.table(
            format!("Cramer-Rao bound of {} N along the normal, N; for 25 frames of two images; ordinary with the motor angle", noise.force_n),
            CSV,
            singles.into_iter().chain(pairs),
        ))]),
    ];
    let section = Section::new("displacement-noise", "Where undeformed positions come from", blocks);
    Ok(Some(section.saying(say("displacement_noise.says", in_words(noise))?)))
}

/// Numbers for the sentence on the increase of the bounds.
fn in_words(study: &DisplacementNoiseStudy) -> Option<Value> {
    let of = |name: &'static str| study.rows.iter().filter(move |row| row.noise == name);
    let worse = of("motor angle").zip(of("independent")).map(|(motor, alone)| motor.bound_n / alone.bound_n);
    let ordinary = of("motor angle").map(|row| row.ordinary_rms_n / row.bound_n);
    let (worse, ordinary) = (Span::of(worse)?.ends(), Span::of(ordinary)?.greatest);
    Some(context! { translation_mm => TRANSLATION_SD_MM, rotation_deg => ROTATION_SD_DEG, worse, ordinary })
}
