//! What `finray map`, `sweep` and `merge` share: the grid, who is put to the test on it, and how the table is written.

use super::parse::{degrees_between, positive};
use super::sense::EstimatorArgument;
use super::{Failure, progress};
use clap::ValueEnum;
use finray_model::measurement::Measurement;
use finray_model::sensing::SensingError;
use finray_model::{Finger, Kinematics, Mesh, Scene};
use finray_verify::estimators::network::{NetworkSensing, Networks};
use finray_verify::estimators::{BeamEstimator, ELEMENTS, Estimator, EstimatorError, EstimatorKind};
use finray_verify::experiments::networks::accuracy::NAME;
use finray_verify::experiments::twin::twin_of;
use finray_verify::files::{FileError, Reader, Stream, is_stream, load_network_and_digest, load_scene_and_text};
use finray_verify::report::{map_picture, standalone};
use finray_verify::sampling::map::AccuracyMap;
use finray_verify::sampling::sweep::{Grid, Head, Partial, Request, Shard, Sweep, Table};
use finray_verify::truths::{LatticeTruth, MeshTruth, MujocoTruth, Truth, fine_mesh};
use std::io::Read;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct GridArguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Network of `finray train`; without it, those that ship with finray
    #[arg(long, value_name = "FILE")]
    network: Option<PathBuf>,
    /// Sizes of the force, N: one, or several as 1,2,3
    #[arg(long, value_name = "F", value_delimiter = ',', default_values_t = [3.0], value_parser = positive)]
    force_n: Vec<f64>,
    /// Number of noise pictures that a cell's error is averaged over
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: u32,
    /// First seed of the noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// About how many places along the front plate
    #[arg(long, value_name = "N", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    places: u32,
    /// Degrees from one direction to the next, up to 80 on both sides of the normal; 90 for the normal alone
    #[arg(long, value_name = "D", default_value_t = 5.0, value_parser = degrees_between)]
    step_deg: f64,
    /// Compute only share I of N, for `finray merge`
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub enum TruthArgument {
    /// The linear finger
    Linear,
    /// The finger with large rotations, on 684 nodes or four elements a member if that is more
    Corotational,
    /// The finger as rigid bodies and springs, four segments between two key nodes, in the shape of least energy.
    /// Letting the engine settle each shape, the same within 0.05 %, would take an hour
    Lattice,
    /// The finger as MuJoCo solved it: exported shapes of three fingers, at their contact nodes, in the exported
    /// directions, under the exported forces; --places and --step-deg do not count beside it
    Mujoco,
    /// The paper's finger with a softer base and tip, one of several fits of its Table I, co-rotational; for the paper's
    /// scene alone
    Twin,
}

/// Who is put to the test.
pub struct Candidates<'a> {
    pub truths: &'a [TruthArgument],
    pub estimators: &'a [EstimatorArgument],
    /// Standard deviations of one measured coordinate, mm; none given: the scene's camera, else no noise.
    pub noise_mm: &'a [f64],
}

/// The meshes and networks that truths and estimators borrow.
struct Models {
    key_nodes: Mesh,
    fine: Mesh,
    sensing: Mesh,
    networks: Networks,
    /// Of the twin, if it is asked for.
    twin: Option<Mesh>,
}

impl Models {
    fn new(finger: &Finger, networks: Networks, truths: &[TruthArgument]) -> Result<Models, Failure> {
        let twin = if truths.contains(&TruthArgument::Twin) {
            let twin = twin_of(finger).map_err(|error| Failure::BadInput(format!("--truth twin: {error}")))?;
            Some(fine_mesh(&twin)?)
        } else {
            None
        };
        Ok(Models {
            twin,
            key_nodes: Mesh::key_nodes(finger),
            fine: fine_mesh(finger)?,
            sensing: Mesh::with_elements_per_member(finger, ELEMENTS),
            networks,
        })
    }

    fn truth(&self, which: TruthArgument) -> Result<Box<dyn Truth + '_>, Failure> {
        let mesh = self.twin.as_ref().unwrap_or(&self.fine);
        Ok(match which {
            TruthArgument::Twin => Box::new(MeshTruth::new("twin", mesh, Kinematics::Corotational)?),
            TruthArgument::Linear => Box::new(MeshTruth::new("linear", &self.key_nodes, Kinematics::Linear)?),
            TruthArgument::Corotational => {
                Box::new(MeshTruth::new("corotational", &self.fine, Kinematics::Corotational)?)
            }
            TruthArgument::Lattice => Box::new(LatticeTruth::new(self.key_nodes.finger())?),
            TruthArgument::Mujoco => Box::new(MujocoTruth::new(self.key_nodes.finger())?),
        })
    }

    fn estimator(&self, which: EstimatorArgument) -> Box<dyn Estimator + '_> {
        let beam = |kind, mesh| Box::new(BeamEstimator::new(kind, mesh));
        match which {
            EstimatorArgument::LeastSquares => beam(EstimatorKind::LeastSquares, &self.key_nodes),
            EstimatorArgument::Ridge => beam(EstimatorKind::Ridge, &self.key_nodes),
            EstimatorArgument::Nonlinear => beam(EstimatorKind::Nonlinear, &self.sensing),
            EstimatorArgument::Network => Box::new(NetworkSensing {
                name: NAME,
                networks: &self.networks,
                finger: self.key_nodes.finger(),
                refuses: true,
            }),
        }
    }
}

/// Computes a table and writes it, row by row, with what belongs beside it.
pub fn run(arguments: &GridArguments, table: Table, candidates: &Candidates) -> Result<(), Failure> {
    if arguments.network.is_some() && !candidates.estimators.contains(&EstimatorArgument::Network) {
        return Err(Failure::BadInput("--network is for --estimator network".to_owned()));
    }
    let (scene, text) = load_scene_and_text(&arguments.scene)?;
    let finger = &scene.finger;
    let (networks, digest) = match &arguments.network {
        Some(path) => {
            load_network_and_digest(path).map(|(network, digest)| (Networks::of(vec![network]), Some(digest)))?
        }
        None => (Networks::shipped()?, None),
    };
    let models = Models::new(finger, networks, candidates.truths)?;
    let truths = candidates.truths.iter().map(|&truth| models.truth(truth)).collect::<Result<Vec<_>, _>>()?;
    let estimators: Vec<_> = candidates.estimators.iter().map(|&estimator| models.estimator(estimator)).collect();
    let grid = grid(arguments, candidates, &scene)?;
    for estimator in &estimators {
        require_an_answer(finger, &**estimator, &grid)?;
    }
    let sweep = Sweep::new(
        finger,
        truths.iter().map(|truth| &**truth).collect(),
        estimators.iter().map(|estimator| &**estimator).collect(),
        &grid,
    );
    let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
    let request = Request {
        finray: Request::version(),
        table,
        truths: owned(sweep.truth_names()),
        estimators: owned(sweep.estimator_names()),
        network: digest,
        scene: text,
        grid: grid.clone(),
    };
    write(&sweep, finger, Head { shard: arguments.shard, request }, &arguments.out)
}

fn grid(arguments: &GridArguments, candidates: &Candidates, scene: &Scene) -> Result<Grid, Failure> {
    let (places_mm, angles_deg) = if candidates.truths.contains(&TruthArgument::Mujoco) {
        exported_grid(&scene.finger, &arguments.force_n)?
    } else {
        Grid::grid(&scene.finger, arguments.places as usize, arguments.step_deg)
    };
    let growing = |numbers: &[f64]| {
        let mut numbers = numbers.to_vec();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        numbers
    };
    let noise_levels_mm = match candidates.noise_mm {
        [] => vec![scene.camera.map_or(0.0, |camera| camera.noise_mm)],
        given => growing(given),
    };
    Ok(Grid {
        places_mm,
        angles_deg,
        forces_n: growing(&arguments.force_n),
        noise_levels_mm,
        noise_pictures: arguments.seeds as usize,
        seed: arguments.seed,
    })
}

/// The places and directions that MuJoCo's shapes were exported for, if the forces were.
fn exported_grid(finger: &Finger, forces_n: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let exported = MujocoTruth::new(finger)?;
    for &force_n in forces_n {
        exported.require_force(force_n)?;
    }
    Ok(exported.grid())
}

/// An estimator that refuses every place and direction, as a network of another finger, is no candidate.
fn require_an_answer(finger: &Finger, estimator: &dyn Estimator, grid: &Grid) -> Result<(), Failure> {
    let at_rest = Measurement::at_rest(finger);
    let mut refusal = None;
    for contact in 0..grid.contact_count() {
        match estimator.prepare(&[grid.contact(contact)], &at_rest) {
            Ok(_) => return Ok(()),
            Err(error) => refusal = refusal.or(Some(error)),
        }
    }
    Err(match refusal {
        Some(EstimatorError::Sensing(error)) => error.into(),
        Some(EstimatorError::Network(error)) => error.into(),
        Some(EstimatorError::NoNetwork(error)) => Failure::BadInput(error.to_string()),
        None => SensingError::NoContact.into(),
    })
}

fn write(sweep: &Sweep, finger: &Finger, head: Head, out: &Path) -> Result<(), Failure> {
    let table = head.request.table;
    let blocks = head.shard.map_or(0..sweep.block_count(), |shard| shard.blocks(sweep.block_count()));
    let bar = progress::bar(blocks.len() as u64, if table == Table::Map { "map" } else { "sweep" });
    if is_stream(out) {
        let mut stream = Stream::open(out)?;
        let begin = if head.shard.is_some() { head.to_text()? } else { table.header().to_owned() };
        let mut say = |text: &str| match stream.write(text.as_bytes())? {
            Reader::Listens => Ok(()),
            Reader::Left => Err(Stop::Unread),
        };
        let said = say(&begin).and_then(|()| {
            sweep.stream(table, blocks, |count, rows| {
                bar.inc(count as u64);
                say(rows)
            })
        });
        bar.finish_and_clear();
        return match said {
            Ok(()) | Err(Stop::Unread) => Ok(()),
            Err(Stop::Failed(failure)) => Err(failure),
        };
    }
    let out = table_path(table, out);
    let whole = head.shard.is_none();
    if whole && table == Table::Map {
        require_a_place(&picture_path(&out))?;
    }
    let request = head.request.clone();
    let mut partial = Partial::open(&out, head)?;
    bar.set_position(partial.blocks_done() as u64);
    bar.reset_eta();
    let rest = blocks.start + partial.blocks_done()..blocks.end;
    sweep.stream(table, rest, |count, rows| {
        bar.inc(count as u64);
        partial.append(count, rows).map_err(Failure::from)
    })?;
    bar.finish_and_clear();
    let beside = if whole { beside(&request, finger, partial.table()?, &out)? } else { Vec::new() };
    Ok(partial.finish(&beside)?)
}

/// Why a stream ends before its end.
enum Stop {
    Unread,
    Failed(Failure),
}

impl<E: Into<Failure>> From<E> for Stop {
    fn from(error: E) -> Stop {
        Stop::Failed(error.into())
    }
}

/// What stands beside a whole table: the picture of a map.
pub fn beside(
    request: &Request,
    finger: &Finger,
    table: impl Read,
    out: &Path,
) -> Result<Vec<(PathBuf, String)>, Failure> {
    if request.table != Table::Map {
        return Ok(Vec::new());
    }
    let map = AccuracyMap::from_csv(request, table).map_err(|error| Failure::BadInput(error.to_string()))?;
    let picture = map_picture(finger, &map, None).map_err(|error| Failure::NotComputed(error.to_string()))?;
    Ok(vec![(picture_path(out), standalone(&picture))])
}

fn picture_path(out: &Path) -> PathBuf {
    out.with_extension("svg")
}

/// The path itself, unless it would be the picture's.
pub fn table_path(table: Table, out: &Path) -> PathBuf {
    let is_picture = table == Table::Map && out.extension().is_some_and(|extension| extension == "svg");
    if is_picture { out.with_extension("csv") } else { out.to_owned() }
}

/// That a file can stand there is better known before hours of work than after.
fn require_a_place(path: &Path) -> Result<(), FileError> {
    if !path.is_dir() {
        return Ok(());
    }
    Err(FileError::Unwritable { path: path.to_owned(), reason: std::io::ErrorKind::IsADirectory.into() })
}
