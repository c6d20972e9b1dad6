//! The command `finray calibrate`.

mod images;
mod modulus;
mod notes;
mod weights;
mod zones;

use crate::commands::parse::kinematics;
use crate::commands::prelude::*;
use finray_files::{load_scene_and_text, measurements, with_values};
use finray_model::Kinematics;
use finray_model::calibration::{CalibrationError, OutlyingMarker, SceneValues};
use finray_model::finger::FingerDescription;
use finray_model::scene::SceneWarning;
use finray_model::sensing::{ResidualTest, Warning};
use finray_model::text::finite;
use nalgebra::DMatrix;

/// Mesh elements per member. With only four elements per member, the modulus factor errs by 3e-4 for weights that bend the paper's finger by 15 mm.
/// This error of the modulus factor is a fifth of the factor's standard deviation due to noise.
const ELEMENTS: usize = 8;
/// Largest number of outlying markers that warnings name.
const MOST_NAMED: usize = 3;

/// Help text below the options.
const AFTER_HELP: &str = "\
NAMES for --fit, most with an optional standard deviation (ribs=0.2), see the guide:
modulus, front-modulus, back-modulus, bracket, brackets, clip, front-clip, back-clip, ribs, height,
base, base-compliance, preload, friction, friction-build-up, force-error.

Examples:
  finray calibrate fixtures/scenes/paper.toml --measurements weights.csv
  finray calibrate mine.toml --weight 0.2kg --image hung.jpg --plumb 412,80,415,900
  finray calibrate mine.toml --image a.jpg b.jpg --forces forces.csv --fit modulus,ribs=0.2,friction

Guide: finray guide calibrate";

/// Estimate moduli, geometry and friction of a finger from weights or images of the pressed finger.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[command(group = clap::ArgGroup::new("several").args(["zones", "located", "image"]).multiple(true))]
#[command(group = clap::ArgGroup::new("seen").args(["located", "image"]))]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Hung weights with unit (0.2kg, 200g, 1.96N), one or one for each image
    #[arg(long, help_heading = "From photographs of hung weights", value_name = "WEIGHT", value_parser = weights::weight, num_args = 1.., requires = "image", conflicts_with_all = ["measurements", "zones", "kinematics", "noise_mm"])]
    weight: Vec<f64>,
    /// Photographs (PNG, JPEG) of the finger, pressed or with a weight
    #[arg(long, help_heading = "From images", value_name = "FILE", num_args = 1.., conflicts_with_all = ["located", "measurements", "zones", "kinematics", "noise_mm"])]
    image: Vec<PathBuf>,
    /// Image of the unloaded finger, as for `locate`
    #[arg(long, help_heading = "From images", value_name = "FILE", requires = "image")]
    rest: Option<PathBuf>,
    /// Positions of the string along the front plate [default: estimated]
    #[arg(long, help_heading = "From photographs of hung weights", value_name = "S_MM", num_args = 1.., value_parser = positive, requires = "weight")]
    weight_at: Vec<f64>,
    /// Gravity: two pixels of a plumb line, the upper one first
    #[arg(long, help_heading = "From photographs of hung weights", value_name = "U1,V1,U2,V2", value_parser = weights::plumb, requires = "weight")]
    plumb: Option<weights::Plumb>,
    /// Gravity: degrees from the front plate's normal, towards the tip
    #[arg(long, help_heading = "From photographs of hung weights", value_name = "A", value_parser = finite, allow_negative_numbers = true, requires = "weight", conflicts_with = "plumb")]
    gravity_deg: Option<f64>,
    /// Displacements (CSV: case,load_node,fx_n,fy_n,node,ux_mm,uy_mm)
    #[arg(long, help_heading = "From weights", value_name = "FILE", conflicts_with_all = ["fit", "forces", "images"])]
    measurements: Option<PathBuf>,
    /// Markers in images of the pressed finger (file from `finray locate`)
    #[arg(long, help_heading = "From images", value_name = "FILE", conflicts_with_all = ["measurements", "zones", "kinematics", "noise_mm"])]
    located: Option<PathBuf>,
    /// Parameters to estimate, such as modulus,ribs=0.2 [default: modulus]
    #[arg(long, help_heading = "From images", value_name = "NAMES", requires = "seen")]
    fit: Option<String>,
    /// Estimate joints, preload, height and base of a finger mounted again
    #[arg(long, help_heading = "From images", conflicts_with_all = ["fit", "weight"], requires = "seen")]
    remounted: bool,
    /// Measured forces in the frame of the camera's pose (CSV: image,fx_n,fy_n)
    #[arg(long, help_heading = "From images", value_name = "FILE", requires = "seen", conflicts_with = "weight")]
    forces: Option<PathBuf>,
    /// Write the calibrated scene (TOML) to FILE
    #[arg(long, value_name = "FILE")]
    calibrated: Option<PathBuf>,
    /// Write the results of each image (CSV) to FILE
    #[arg(long, help_heading = "From images", value_name = "FILE", requires = "seen")]
    images: Option<PathBuf>,
    /// Also estimate factors of zones: one each, or one per group (1+2,3)
    #[arg(long, help_heading = "From weights", value_name = "GROUPS", num_args = 0..=1, require_equals = true, default_missing_value = EACH)]
    zones: Option<String>,
    /// Kinematics: linear or corotational
    #[arg(long, help_heading = "From weights", hide_possible_values = true, value_parser = kinematics(["linear", "corotational"]), requires = "measurements", default_value = "corotational")]
    kinematics: Kinematics,
    /// Noise of a coordinate, mm [default: scene, else residual]
    #[arg(long, help_heading = "From weights", value_name = "S", requires = "measurements", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Correlations of the results (CSV), with --zones or images
    #[arg(long, value_name = "FILE", requires = "several")]
    correlations: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// Value of `--zones` if no groups are given: each zone then has its own factor.
const EACH: &str = "each";

#[derive(Serialize)]
struct Row {
    parameter: String,
    value: f64,
    sigma: Option<f64>,
}

#[derive(Serialize)]
struct Correlation {
    parameter: String,
    other: String,
    correlation: f64,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    if arguments.located.is_some() || !arguments.image.is_empty() {
        return images::run(arguments);
    }
    let Some(measured) = &arguments.measurements else {
        return Err(bad_input(
            "expected --weight WEIGHT with --image FILE (photographs of a hung weight), --measurements FILE (shapes under known loads), or --image FILE \
             (or --located FILE) with --fit NAMES (images of the pressed finger)",
        ));
    };
    require_one_standard_input([&arguments.scene, measured])?;
    let (scene, text) = load_scene_and_text(&arguments.scene)?;
    // A calibrated modulus replaces its uncertainty and absorbs the state of the side faces.
    hints::of_scene_without(&arguments.scene, &scene, SceneWarning::is_of_stiffness);
    let noise_mm = arguments.noise_mm.or(scene.noise_mm);
    let cases = measurements::load(measured, &scene.finger, noise_mm)?;
    let WeightFit { mut files, values, done } = match &arguments.zones {
        None => modulus::run(arguments, &scene, &cases, noise_mm)?,
        Some(groups) => zones::run(arguments, groups, &scene, &cases, noise_mm)?,
    };
    if let Some(path) = &arguments.calibrated {
        files.push((path.clone(), with_values(&text, &values).map_err(bad_input)?));
    }
    write_all_or_nothing(&files)?;
    Ok(summary(done, files.iter().map(|(path, _)| path)))
}

/// Result of a calibration from weights.
struct WeightFit {
    /// Path and text of each table.
    files: Vec<(PathBuf, String)>,
    /// Values of the calibrated scene, by key; `None` removes a key.
    values: SceneValues,
    /// What was done, for the summary.
    done: String,
}

/// Largest plausible modulus factor; the smallest plausible factor is its reciprocal. A factor outside this range suggests a wrong unit.
const LARGEST_FACTOR: f64 = 10.0;

/// Warns of a modulus factor far from 1: a wrong unit or node numbering is then more likely than a material with this factor. Also warns of a factor that
/// contradicts `sd`, the relative standard deviation of the stiffness that the scene states.
fn warn_of_modulus(factor: f64, sd: f64) {
    notes::warn_of_change("modulus_factor", factor, factor.ln(), sd);
    if !(1.0 / LARGEST_FACTOR..=LARGEST_FACTOR).contains(&factor) {
        print_message(format_args!(
            "warning: modulus_factor is {factor:.3e}, far from 1: check units (N, mm, MPa), thicknesses and node numbers"
        ));
    }
}

/// Warns of outlying markers, those with the largest distances first. Also warns if the residual contradicts the stated noise.
fn warn_of_contradictions(outliers: &[OutlyingMarker], contradiction: Option<ResidualTest>) {
    let mut outliers = outliers.to_vec();
    outliers.sort_by(|a, b| b.distance_mm.total_cmp(&a.distance_mm));
    for outlier in outliers.iter().take(MOST_NAMED) {
        print_message(format_args!(
            "warning: case {} in the order of the file: node {} is {:.2} mm from its computed position, so its row \
                gets little weight; check the row's node number and the load",
            outlier.case + 1,
            outlier.node,
            outlier.distance_mm
        ));
    }
    if let Some(more) = outliers.len().checked_sub(MOST_NAMED).filter(|more| *more > 0) {
        print_message(format_args!("warning: {more} further nodes are far from their computed positions"));
    }
    if let Some(test) = contradiction {
        print_message(format_args!("warning: {}; sigma follows from the residual", Warning::Residual(test)));
    }
}

fn failure(error: CalibrationError) -> Failure {
    match error {
        CalibrationError::Statics(inner) => inner.into(),
        CalibrationError::NoMinimum => not_computed(error),
        other => bad_input(other),
    }
}

/// One row per pair of parameters, with the correlation of their errors.
fn correlations(names: &[String], correlation: &DMatrix<f64>) -> Vec<Correlation> {
    let pairs = (0..names.len()).flat_map(|i| (i + 1..names.len()).map(move |j| (i, j)));
    let of_pair = |(i, j): (usize, usize)| Correlation {
        parameter: names[i].clone(),
        other: names[j].clone(),
        correlation: correlation[(i, j)],
    };
    pairs.map(of_pair).collect()
}

fn modulus_rows(finger: &Finger, factor: f64, sigma: f64) -> Vec<Row> {
    let row = |parameter: &str, scale: f64| Row {
        parameter: parameter.to_owned(),
        value: scale * factor,
        sigma: Some(scale * sigma),
    };
    let moduli = moduli(finger.description());
    moduli.into_iter().map(|(name, modulus)| row(name, modulus)).chain([row("modulus_factor", 1.0)]).collect()
}

/// Names and values (MPa) of the scene's moduli: one row if all parts have the same modulus, otherwise one row per part.
fn moduli(description: &FingerDescription) -> Vec<(&'static str, f64)> {
    let (front, back) = (description.front.youngs_modulus_mpa, description.back.youngs_modulus_mpa);
    let ribs = description.ribs.strip.map(|strip| strip.youngs_modulus_mpa);
    if front == back && ribs.is_none_or(|ribs| ribs == front) {
        return vec![("youngs_modulus_mpa", front)];
    }
    let plates = [("front_youngs_modulus_mpa", front), ("back_youngs_modulus_mpa", back)];
    plates.into_iter().chain(ribs.map(|ribs| ("ribs_youngs_modulus_mpa", ribs))).collect()
}
