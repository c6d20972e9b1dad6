//! What the origin of the undeformed positions does to the floors of sensing: a table.

use super::page::{Block, Cell, Column, Row, Section, Table};
use super::sections::{self, text};
use crate::experiments::displacement_noise::{
    DisplacementNoiseRow, DisplacementNoiseStudy, FORCE_N, FRAMES, ROTATION_SD_DEG, TRANSLATION_SD_MM,
};
use crate::study::Study;

pub(super) const CSV: &str = "displacement_noise.csv";

pub(super) fn section(study: &Study) -> Option<Section> {
    let noise = study.displacement_noise.as_ref().filter(|noise| !noise.rows.is_empty())?;
    let cases = noise.rows.first().map_or(0, |row| row.cases);
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
        Block::Table(table(noise)),
    ];
    Some(sections::section("displacement-noise", "Where undeformed positions come from", blocks))
}

/// The sentence of the section.
pub(super) fn words(study: &DisplacementNoiseStudy) -> Option<String> {
    let of = |name: &'static str| study.rows.iter().filter(move |row| row.noise == name);
    let worse = of("motor angle").zip(of("independent")).map(|(motor, alone)| motor.bound_n / alone.bound_n);
    let ordinary = of("motor angle").map(|row| row.ordinary_rms_n / row.bound_n);
    let largest = |ratios: &mut dyn Iterator<Item = f64>| ratios.reduce(f64::max);
    let worse: Vec<f64> = worse.collect();
    let least = worse.iter().copied().reduce(f64::min)?;
    Some(format!(
        "If the undeformed finger is measured by the same camera, no estimator does better than sqrt(2) times the floors shown elsewhere; if it comes \
         from the motor angle (with {TRANSLATION_SD_MM} mm and {ROTATION_SD_DEG} deg, a choice), {least:.1} to {:.1} times, and ordinary least \
         squares up to {:.1} times that bound.",
        largest(&mut worse.iter().copied())?,
        largest(&mut ordinary.into_iter())?
    ))
}

fn table(study: &DisplacementNoiseStudy) -> Table {
    let row = |row: &DisplacementNoiseRow| Row {
        cells: [
            row.nodes.clone(),
            row.noise.to_owned(),
            format!("{:.4}", row.bound_n),
            format!("{:.4}", row.bound_of_25_frames_n),
            format!("{:.2}", row.generalised_rms_n / row.bound_n),
            format!("{:.2}", row.ordinary_rms_n / row.bound_n),
            row.refused.to_string(),
        ]
        .map(Cell::plain)
        .into(),
    };
    Table {
        caption: "Floors of a force by the noise of displacements".to_owned(),
        columns: vec![
            Column::numbers("nodes"),
            Column::words("undeformed positions"),
            Column::numbers("bound, N"),
            Column::numbers("bound, 25 frames, N"),
            Column::numbers("generalised / bound"),
            Column::numbers("ordinary / bound"),
            Column::numbers("refused"),
        ],
        rows: study.rows.iter().map(row).collect(),
        csv: Some(CSV.to_owned()),
    }
}
