//! What the origin of the undeformed positions does to the floors of sensing: a table.

use super::dataset::{Columns, Dataset, Format};
use super::format::Span;
use super::page::{Block, Section, text};
use super::{ReportError, Results};
use crate::experiments::displacement_noise::{
    DisplacementNoiseRow, DisplacementNoiseStudy, FORCE_N, FRAMES, ROTATION_SD_DEG, TRANSLATION_SD_MM,
};

const CSV: &str = "displacement_noise.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, study.displacement_noise.iter().flat_map(|noise| &noise.rows))]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(noise) = study.displacement_noise.as_ref().filter(|noise| !noise.rows.is_empty()) else { return Ok(None) };
    let cases = noise.rows.first().map_or(0, |row| row.cases);
    let columns = Columns::<&DisplacementNoiseRow>::new()
        .page("nodes", Format::Plain, |row| row.nodes.clone())
        .page("undeformed positions", Format::Words, |row| row.noise)
        .page("bound, N", Format::Fixed(4), |row| row.bound_n)
        .page("bound, 25 frames, N", Format::Fixed(4), |row| row.bound_of_25_frames_n)
        .page("generalised / bound", Format::Fixed(2), |row| row.generalised_rms_n / row.bound_n)
        .page("ordinary / bound", Format::Fixed(2), |row| row.ordinary_rms_n / row.bound_n)
        .page("refused", Format::Plain, |row| row.refused);
    let blocks = vec![
        text(format!(
            "A displacement is a position in an image less the undeformed position, and that is not exact either. Everywhere else on this page \
             each displacement coordinate has an independent error of {sd} mm: the paper's worst position error of 0.2 mm taken as three standard \
             deviations, as if one image's error were the displacement's. If the undeformed finger is measured by the same camera, \
             a displacement is the difference of two images: its standard deviation is sqrt(2) times as large, and all frames that use the \
             image at rest share its error, so that averaging {FRAMES} frames does not remove it. If the undeformed positions come from the motor \
             angle (eqs (6)-(10)), one image's error remains, and an error of translation and rotation of the finger base common to all \
             nodes; {TRANSLATION_SD_MM} mm along each axis and {ROTATION_SD_DEG} deg are a choice, as the offsets of motor and camera stand in \
             figures that were not at hand.",
            sd = noise.image_sd_mm
        )),
        text(format!(
            "Bounds are those of Cramer and Rao for {FORCE_N} N along the normal at each contact (of two forces the root mean square). Beside them \
             stands the scatter of {cases} noise samples: of generalised least squares, which knows the covariance, and of ordinary \
             least squares, which takes all errors for independent. Chance moves a scatter by {:.0} %.",
            100.0 / (2.0 * cases.max(1) as f64).sqrt()
        )),
        Block::Table(columns.table("Floors of a force by the noise of displacements", CSV, &noise.rows)),
    ];
    let section = Section::new("displacement-noise", "Where undeformed positions come from", blocks);
    Ok(Some(section.saying(in_words(noise))))
}

/// How much larger the floors become.
fn in_words(study: &DisplacementNoiseStudy) -> Option<String> {
    let of = |name: &'static str| study.rows.iter().filter(move |row| row.noise == name);
    let worse = of("motor angle").zip(of("independent")).map(|(motor, alone)| motor.bound_n / alone.bound_n);
    let ordinary = of("motor angle").map(|row| row.ordinary_rms_n / row.bound_n);
    let (worse, ordinary) = (Span::of(worse)?, Span::of(ordinary)?);
    Some(format!(
        "If the undeformed finger is measured by the same camera, no estimator does better than sqrt(2) times the floors shown elsewhere; if it comes \
         from the motor angle (with {TRANSLATION_SD_MM} mm and {ROTATION_SD_DEG} deg, a choice), {:.1} to {:.1} times, and ordinary least \
         squares up to {:.1} times that bound.",
        worse.least, worse.greatest, ordinary.greatest
    ))
}
