//! `finray map`

use super::Failure;
use super::parse::{not_negative, positive};
use super::progress;
use clap::ValueEnum;
use finray_model::{Finger, Kinematics, Mesh};
use finray_verify::estimators::{BeamEstimator, EstimatorKind};
use finray_verify::files::{is_standard_stream, load_scene, write_all_or_nothing, write_text};
use finray_verify::map::{AccuracyMap, MapRequest, accuracy_maps};
use finray_verify::report::{map_picture, standalone};
use finray_verify::truth::{LatticeTruth, MeshTruth, MujocoTruth, Truth, fine_mesh};
use finray_verify::twin::twin_of;
use std::path::{Path, PathBuf};

/// Map where a finger can be trusted to feel: error of the sensed force by place and direction.
///
/// A force of known place and direction is put on the true finger, its size is sensed with the linear
/// model from the displacements of the key nodes, and the error |sensed / true - 1| is averaged over
/// the camera noise. Writes s_mm,angle_deg,force_n,mean_error,bias,spread, and the picture beside it
/// as SVG.
///
/// Example:
///   finray map fixtures/scenes/paper.toml --noise-mm 0.067 --out map.csv      (and map.svg)
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// The finger that is sensed
    #[arg(long, value_enum, default_value_t = TruthArgument::Corotational)]
    truth: TruthArgument,
    /// How forces are sensed
    #[arg(long, value_enum, default_value_t = EstimatorArgument::LeastSquares)]
    estimator: EstimatorArgument,
    /// Size of the force, N
    #[arg(long, value_name = "F", default_value_t = 3.0, value_parser = positive)]
    force_n: f64,
    /// Standard deviation of one measured coordinate, mm; the scene's camera table if not given, else none
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Number of noise pictures that a cell's error is averaged over
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: u32,
    /// First seed of the noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Result file (CSV; the picture takes its name with .svg); - for the CSV on standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum TruthArgument {
    /// The linear finger
    Linear,
    /// The finger with large rotations, on 684 nodes or four elements a member if that is more
    Corotational,
    /// The finger as rigid bodies and springs, four segments between two key nodes, in the shape of least energy.
    /// Letting the engine settle each shape, the same within 0.05 %, would take an hour
    Lattice,
    /// The finger as MuJoCo solved it: exported shapes of three fingers, at their contact nodes, in the exported
    /// directions, under the exported forces
    Mujoco,
    /// The paper's finger with the softer base and tip that explain its Table I, with large rotations; for the paper's
    /// scene alone
    Twin,
}

/// The nonlinear estimator would take minutes for a map.
#[derive(Clone, Copy, ValueEnum)]
enum EstimatorArgument {
    /// Linear least squares
    LeastSquares,
    /// Least squares with the paper's range of forces as a prior
    Ridge,
}

impl EstimatorArgument {
    fn kind(self) -> EstimatorKind {
        match self {
            EstimatorArgument::LeastSquares => EstimatorKind::LeastSquares,
            EstimatorArgument::Ridge => EstimatorKind::Ridge,
        }
    }
}

/// Places along the front plate, and degrees between two directions.
const RESOLUTION: (usize, f64) = (48, 5.0);

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scene = load_scene(&arguments.scene)?;
    let finger = &scene.finger;
    let (places_mm, angles_deg) = match arguments.truth {
        TruthArgument::Mujoco => exported_grid(finger, arguments.force_n)?,
        _ => MapRequest::grid(finger, RESOLUTION.0, RESOLUTION.1),
    };
    let request = MapRequest {
        places_mm,
        angles_deg,
        forces_n: vec![arguments.force_n],
        noise_levels_mm: vec![arguments.noise_mm.or(scene.camera.map(|camera| camera.noise_mm)).unwrap_or(0.0)],
        noise_pictures: arguments.seeds as usize,
        seed: arguments.seed,
    };
    let map = compute(finger, arguments.truth, arguments.estimator, &request)?;
    let csv = map.to_csv()?;
    if is_stream(&arguments.out) {
        write_text(&arguments.out, &csv)?;
        return Ok(());
    }
    let picture = map_picture(finger, &map, None).map_err(|error| Failure::NotComputed(error.to_string()))?;
    let picture = standalone(&picture);
    let (csv_path, svg_path) = (named(&arguments.out, "csv"), arguments.out.with_extension("svg"));
    write_all_or_nothing(&[(csv_path, &csv), (svg_path, &picture)])?;
    Ok(())
}

/// The places and directions that MuJoCo's shapes were exported for, if the force was.
fn exported_grid(finger: &Finger, force_n: f64) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let exported = MujocoTruth::new(finger)?;
    exported.require_force(force_n)?;
    Ok(exported.grid())
}

/// Standard output, a device or a pipe: there the CSV goes alone, as nothing can stand beside it.
fn is_stream(out: &Path) -> bool {
    is_standard_stream(out) || out.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// The path itself, unless it would be the picture's.
fn named(out: &Path, extension: &str) -> PathBuf {
    if out.extension().is_some_and(|e| e == "svg") { out.with_extension(extension) } else { out.to_owned() }
}

fn compute(
    finger: &Finger,
    truth: TruthArgument,
    estimator: EstimatorArgument,
    request: &MapRequest,
) -> Result<AccuracyMap, Failure> {
    // Outlives the truth that may borrow it.
    let mesh;
    let truth: Box<dyn Truth + '_> = match truth {
        TruthArgument::Linear => {
            mesh = Mesh::key_nodes(finger);
            Box::new(MeshTruth::new("linear", &mesh, Kinematics::Linear)?)
        }
        TruthArgument::Corotational => {
            mesh = fine_mesh(finger)?;
            Box::new(MeshTruth::new("corotational", &mesh, Kinematics::Corotational)?)
        }
        TruthArgument::Lattice => Box::new(LatticeTruth::new(finger)?),
        TruthArgument::Mujoco => Box::new(MujocoTruth::new(finger)?),
        TruthArgument::Twin => {
            let twin = twin_of(finger).map_err(|error| Failure::BadInput(format!("--truth twin: {error}")))?;
            mesh = fine_mesh(&twin)?;
            Box::new(MeshTruth::new("twin", &mesh, Kinematics::Corotational)?)
        }
    };
    let key_nodes = Mesh::key_nodes(finger);
    let estimator = BeamEstimator { kind: estimator.kind(), mesh: &key_nodes };
    let bar = progress::bar((request.places_mm.len() * request.angles_deg.len()) as u64, "map");
    let mut maps = accuracy_maps(finger, &*truth, &estimator, request, &|| bar.inc(1));
    bar.finish_and_clear();
    // One noise level was asked for.
    Ok(maps.swap_remove(0))
}
