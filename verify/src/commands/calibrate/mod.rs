//! `finray calibrate`

mod images;
mod modulus;
mod notes;

use crate::commands::prelude::*;
use clap::ValueEnum;
use finray_files::measurements;
use finray_model::Kinematics;
use finray_model::calibration::{self, CalibrationError, FactorEstimate, FactorModel, Unknown};
use finray_model::estimators::ELEMENTS;
use finray_model::finger::FingerDescription;
use nalgebra::DMatrix;

/// Find Young's modulus from measured shapes under known loads.
///
/// Reads case,load_node,fx_n,fy_n,node,ux_mm,uy_mm, the load repeated on each row of its case, and
/// writes parameter,value,sigma: the factor on all moduli of the scene for which measured and
/// computed nodes are closest, and the moduli that follow. The finger is co-rotational; single
/// markers that are far off count little. --kinematics linear is eq. (11) of Xu et al. 2021, which
/// holds for small displacements; where the co-rotational finger is closer, a warning says so and
/// sigma holds the difference.
///
/// With --zones the modulus_factor of each zone of the scene is estimated too, starting from the
/// value of the scene, by least squares (Gauss-Newton). A compliant clamp is a zone at the base.
/// Factors that are not identifiable are refused; pairs that are hardly separable are named.
///
/// With --located a finger and its rig are calibrated from images of the pressed finger, all at once:
/// --fit names what the scene has only nominally. modulus, front-modulus, back-modulus: factors on
/// moduli; bracket, clip: their lengths; brackets: of each rib by itself; ribs: where each sits on
/// each plate; height: of the markers above the beams, which is their scale; base: where the finger
/// is in the frame of its references (or of the camera's pose). Where forces were measured (--forces,
/// in the frame of the camera's pose), friction is the coefficient about the normal of the scene's
/// table contact, friction-build-up also the force over which it builds up. A column object in
/// --forces names what pressed the finger: of several objects friction_between_objects is by how much
/// the coefficient differs between them, and each is predicted from the others; friction=0.05 states
/// it for one object. base-compliance is by how much a force turns the base, degrees a newton, where
/// all images are of one mounting. Without forces geometry alone is identifiable. noise_factor is
/// what markers err by as a share of what `finray locate` states: what is wrong alike in all images
/// is then part of what was found. model_error_mm is by how much the calibrated finger still misses
/// its markers, with what is open of its geometry; force_error_share by which share it misses forces:
/// the scatter of those that were measured, and what is open alike for all forces, as a modulus is.
/// --calibrated writes the scene that `finray sense` takes. Markers and forces that contradict the
/// other images are refused, or said where they stand out: a name, a sign, a unit.
///
/// Examples:
///   finray calibrate fixtures/scenes/paper.toml --measurements weights.csv
///   finray calibrate fixtures/scenes/twin.toml --measurements weights.csv --zones
///   finray calibrate fixtures/scenes/twin.toml --measurements weights.csv --zones=1+2,3+4,5+6
///   finray calibrate fixtures/scenes/bracketed.toml --located nodes.csv --forces forces.csv
///       --fit modulus,bracket,ribs=0.2,friction --calibrated calibrated.toml
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
#[command(group = clap::ArgGroup::new("several").args(["zones", "located"]).multiple(true))]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Measured shapes under known loads (CSV); - for standard input
    #[arg(long, value_name = "FILE", conflicts_with_all = ["fit", "forces", "calibrated", "images"])]
    measurements: Option<PathBuf>,
    /// Images of the pressed finger as `finray locate` has located them (CSV); - for standard input
    #[arg(long, value_name = "FILE", conflicts_with = "measurements", requires = "fit")]
    located: Option<PathBuf>,
    /// What the images are to show, with --located: names joined by commas, each perhaps with a prior, as ribs=0.2
    #[arg(long, value_name = "NAMES", requires = "located")]
    fit: Option<String>,
    /// Contact forces that were measured in some of the images: image,fx_n,fy_n, perhaps object (CSV), with --located
    #[arg(long, value_name = "FILE", requires = "located")]
    forces: Option<PathBuf>,
    /// File for the scene with all that was found (TOML), with --located
    #[arg(long, value_name = "FILE", requires = "located")]
    calibrated: Option<PathBuf>,
    /// File for what was found of each image (CSV), with --located
    #[arg(long, value_name = "FILE", requires = "located")]
    images: Option<PathBuf>,
    /// Seek the factors of the scene's zones too: of each, or of those named, by their order from 1; zones joined by +
    /// share a factor
    #[arg(long, value_name = "GROUPS", num_args = 0..=1, require_equals = true, default_missing_value = EACH)]
    zones: Option<String>,
    /// How displacements become deformations, with --measurements
    #[arg(long, value_enum, requires = "measurements", default_value_t = KinematicsArgument::Corotational)]
    kinematics: KinematicsArgument,
    /// Standard deviation of one measured coordinate, mm, with --measurements; the scene's camera table if not given, else
    /// estimated from the residual
    #[arg(long, value_name = "S", requires = "measurements", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// File for the correlation of each two values that were found (CSV), with --zones or --located
    #[arg(long, value_name = "FILE", requires = "several")]
    correlations: Option<PathBuf>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// What `--zones` without groups means.
const EACH: &str = "each";

#[derive(Clone, Copy, ValueEnum)]
enum KinematicsArgument {
    /// Small displacements
    Linear,
    /// Co-rotational, on four elements a member, or eight where one factor is sought
    Corotational,
}

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

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let (Some(located), Some(fit)) = (&arguments.located, &arguments.fit) {
        return images::run(arguments, located, fit);
    }
    let Some(measured) = &arguments.measurements else {
        return Err(bad_input(
            "expected --measurements FILE, shapes under known loads, or --located FILE with --fit NAMES, images of the pressed finger",
        ));
    };
    not_both_from_standard_input(&arguments.scene, measured, "--measurements")?;
    let scene = load_scene(&arguments.scene)?;
    let finger = scene.finger;
    hints::of_moduli(&arguments.scene, &finger);
    let noise_mm = arguments.noise_mm.or(scene.noise_mm);
    let cases = measurements::load(measured, &finger, noise_mm)?;
    let Some(groups) = &arguments.zones else { return modulus::run(arguments, &finger, &cases, noise_mm) };
    let unknowns = unknowns(groups, finger.description().zones.len())?;
    let (kinematics, elements) = match arguments.kinematics {
        KinematicsArgument::Linear => (Kinematics::Linear, 1),
        KinematicsArgument::Corotational => (Kinematics::Corotational, ELEMENTS),
    };
    let model = FactorModel { kinematics, elements, noise_mm };
    let estimate = calibration::factors(&finger, &cases, &unknowns, &model).map_err(failure)?;
    // The factor on all moduli is the first unknown.
    if let Some(factor) = estimate.factors.first() {
        warn_of_modulus(*factor);
    }
    if let KinematicsArgument::Linear = arguments.kinematics {
        let model = FactorModel { kinematics: Kinematics::Corotational, elements: ELEMENTS, noise_mm };
        let closer = calibration::factors(&finger, &cases, &unknowns, &model).ok();
        if let Some(closer) =
            closer.filter(|other| other.residual_rms_mm < estimate.residual_rms_mm && estimate.differs_from(other))
        {
            print_message(format_args!(
                "warning: the co-rotational finger is closer to the measured nodes ({:.3} mm rms, the linear one {:.3} mm) and has other factors: \
                 displacements are too large for --kinematics linear",
                closer.residual_rms_mm, estimate.residual_rms_mm
            ));
        }
    }
    for (i, j, correlation) in estimate.entangled() {
        let [one, other] = [i, j].map(|k| &estimate.unknowns[k]);
        print_message(format_args!("warning: {one} and {other} are hardly separable: correlation {correlation:.3}"));
    }
    let mut files = Vec::new();
    if let Some(path) = &arguments.correlations {
        let names: Vec<String> = estimate.unknowns.iter().map(ToString::to_string).collect();
        files.push((path.clone(), csv_text(correlations(&names, &estimate.correlation))?));
    }
    files.push((arguments.out.clone(), csv_text(factor_rows(&finger, &estimate))?));
    Ok(write_all_or_nothing(&files)?)
}

/// Largest factor, and one over the smallest, that says something of a material and not of a wrong unit.
const LARGEST_FACTOR: f64 = 10.0;

/// Names a factor on all moduli that a unit or another numbering explains more likely than the material.
fn warn_of_modulus(factor: f64) {
    if !(1.0 / LARGEST_FACTOR..=LARGEST_FACTOR).contains(&factor) {
        print_message(format_args!(
            "warning: modulus_factor is {factor:.3e}: the finger is hardly the scene's; check units (N, mm, MPa), thicknesses and the numbers of the \
             nodes"
        ));
    }
}

fn failure(error: CalibrationError) -> Failure {
    match error {
        CalibrationError::Statics(inner) => inner.into(),
        CalibrationError::NoMinimum => not_computed(error),
        other => bad_input(other),
    }
}

/// The general modulus and the zones of `1+2,3`, counted from 1.
fn unknowns(groups: &str, zone_count: usize) -> Result<Vec<Unknown>, Failure> {
    let bad = |reason: String| bad_input(format!("--zones: {reason}"));
    if zone_count == 0 {
        return Err(bad("the scene has no [[finger.zone]]".to_owned()));
    }
    let zones: Vec<Vec<usize>> = if groups == EACH {
        (0..zone_count).map(|zone| vec![zone]).collect()
    } else {
        let zone = |text: &str| {
            let number = text.trim().parse::<usize>().ok().filter(|number| (1..=zone_count).contains(number));
            number.map(|number| number - 1).ok_or_else(|| {
                bad(format!("expected groups of zones, 1 to {zone_count}, for instance 1+2,3, found \"{text}\""))
            })
        };
        groups.split(',').map(|group| group.split('+').map(zone).collect()).collect::<Result<_, _>>()?
    };
    let mut named: Vec<usize> = zones.concat();
    named.sort_unstable();
    if let Some(twice) = named.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(bad(format!("zone {} is named twice", twice[0] + 1)));
    }
    Ok(std::iter::once(Unknown::Modulus).chain(zones.into_iter().map(Unknown::Zones)).collect())
}

/// The moduli and the factor on all of them, then the factor of each zone that was sought.
fn factor_rows(finger: &Finger, estimate: &FactorEstimate) -> Vec<Row> {
    let relative = |k: usize| estimate.relative_sigmas[k];
    let mut rows = Vec::new();
    for (k, unknown) in estimate.unknowns.iter().enumerate() {
        match unknown {
            Unknown::Modulus => {
                let factor = estimate.factors[k];
                rows.extend(modulus_rows(finger, factor, factor * relative(k)));
            }
            Unknown::Zones(zones) => rows.extend(zones.iter().map(|&zone| {
                let value = estimate.finger.description().zones[zone].modulus_factor;
                Row { parameter: Unknown::Zones(vec![zone]).to_string(), value, sigma: Some(value * relative(k)) }
            })),
        }
    }
    rows
}

/// The correlation of each two values of these names.
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
