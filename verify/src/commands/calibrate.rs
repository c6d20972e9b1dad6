//! `finray calibrate`

use super::{Failure, not_both_from_standard_input};
use finray_model::calibration::{self, CalibrationError};
use finray_model::finger::FingerDescription;
use finray_verify::files::{csv_text, load_scene, measurements, write_text};
use serde::Serialize;
use std::path::PathBuf;

/// Find Young's modulus from measured shapes under known loads (eq. (11) of Xu et al. 2021).
///
/// Reads case,load_node,fx_n,fy_n,node,ux_mm,uy_mm, the load repeated on each row of its case, and
/// writes parameter,value,sigma: the factor on all moduli of the scene for which measured and
/// computed nodes are closest in sum, and the moduli that follow.
///
/// Example:
///   finray calibrate fixtures/scenes/paper.toml --measurements weights.csv
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Measured shapes (CSV); - for standard input
    #[arg(long, value_name = "FILE")]
    measurements: PathBuf,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Row {
    parameter: &'static str,
    value: f64,
    sigma: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    not_both_from_standard_input(&arguments.scene, &arguments.measurements, "--measurements")?;
    let finger = load_scene(&arguments.scene)?.finger;
    let cases = measurements::load(&arguments.measurements, &finger)?;
    let estimate = calibration::youngs_modulus(&finger, &cases).map_err(|error| match error {
        CalibrationError::Statics(inner) => inner.into(),
        other => Failure::BadInput(other.to_string()),
    })?;
    if !(estimate.factor.is_finite() && estimate.sigma.is_finite()) {
        return Err(Failure::BadInput(
            "not identifiable: loads and displacements do not fit each other by hundreds of powers of ten: are the \
             units right?"
                .to_owned(),
        ));
    }
    let moduli = moduli(finger.description());
    let row = |parameter, scale: f64| Row { parameter, value: scale * estimate.factor, sigma: scale * estimate.sigma };
    let rows = moduli.into_iter().map(|(name, modulus)| row(name, modulus)).chain([row("modulus_factor", 1.0)]);
    write_text(&arguments.out, &csv_text(rows)?)?;
    Ok(())
}

/// The moduli of the scene: one if all parts share it, else one a part.
fn moduli(description: &FingerDescription) -> Vec<(&'static str, f64)> {
    let (front, back) = (description.front.youngs_modulus_mpa, description.back.youngs_modulus_mpa);
    let ribs = description.ribs.strip.map(|strip| strip.youngs_modulus_mpa);
    if front == back && ribs.is_none_or(|ribs| ribs == front) {
        return vec![("youngs_modulus_mpa", front)];
    }
    let plates = [("front_youngs_modulus_mpa", front), ("back_youngs_modulus_mpa", back)];
    plates.into_iter().chain(ribs.map(|ribs| ("ribs_youngs_modulus_mpa", ribs))).collect()
}
