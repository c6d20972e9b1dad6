//! How long an answer takes, and how far it is off: every model of the finger, and every way to sense.
//!
//! Each point is timed where it is computed, on one core, as the median of its answers. What is prepared once for a finger, a mesh
//! or a contact is not counted: a stream of frames, or a sweep, pays for it once. Results of [criterion] and of [other programs](peers)
//! join them where they were handed over.

pub mod criterion;
pub mod peers;

use crate::check::worst;
use crate::estimators::{BeamEstimator, Estimator, EstimatorError, EstimatorKind};
use crate::lattice::accuracy::{CONVERGED_ELEMENTS, difference};
use crate::lattice::{Lattice, LatticeError};
use finray_model::measurement::Measurement;
use finray_model::mesh::{FingerShape, Load};
use finray_model::sensing::Contact;
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Finger, Kinematics, Mesh, NodeId};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use std::fmt;
use std::time::Instant;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// The shape under a load.
    Solve,
    /// One force from a noisy picture.
    SenseOne,
    /// Two forces at neighbouring nodes from a noisy picture.
    SenseNeighbours,
}

impl Task {
    /// All of them.
    pub const ALL: [Task; 3] = [Task::Solve, Task::SenseOne, Task::SenseNeighbours];

    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Task::Solve => "solve",
            Task::SenseOne => "sense-one",
            Task::SenseNeighbours => "sense-neighbours",
        }
    }
}

/// Who took a time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub enum TimedBy {
    /// The report itself, where it computed the point.
    Report,
    /// Criterion, in the project's benches.
    Criterion,
    /// A script that ran another program.
    OtherProgram {
        /// Its name.
        program: String,
        /// Its version.
        version: String,
    },
}

impl fmt::Display for TimedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TimedBy::Report => f.write_str("timed here"),
            TimedBy::Criterion => f.write_str("criterion"),
            TimedBy::OtherProgram { program, version } => write!(f, "{program} {version}"),
        }
    }
}

impl From<TimedBy> for String {
    fn from(timed_by: TimedBy) -> String {
        timed_by.to_string()
    }
}

/// One way to answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedErrorPoint {
    /// What is asked for.
    pub task: Task,
    /// The model or estimator.
    pub model: String,
    /// How it is set.
    pub setting: String,
    /// Median time of an answer, s.
    pub seconds: f64,
    /// Of shapes the worst difference from the reference, as a share of the largest displacement; of forces the mean
    /// |sensed / true - 1|.
    pub error: f64,
    /// Answers that were refused, or had no equilibrium; they count nowhere else.
    pub failed: usize,
    /// Answers asked for.
    pub asked: usize,
    /// Whether no other point of the task is both faster and nearer; points of other programs take no part.
    pub on_front: bool,
    /// Who took the time.
    pub timed_by: TimedBy,
}

/// Force of the loads that shapes are solved for, N.
pub const SOLVED_N: f64 = 3.0;
const SOLVED_ANGLES_DEG: [f64; 3] = [-40.0, 0.0, 40.0];
/// Range of the forces that are sensed, N.
pub const SENSED_N: [f64; 2] = [0.5, 3.0];
/// Noise that estimators are told of is that of the pictures.
const SEED: u64 = 11;

/// Why no points were computed.
#[derive(Debug, thiserror::Error)]
pub enum SpeedErrorError {
    /// The reference has no equilibrium.
    #[error(transparent)]
    Statics(#[from] StaticsError),
    /// A lattice was not built.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// An estimator is not made for the contacts.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
}

/// Loads, with the reference's shapes.
struct Solved {
    loads: Vec<Load>,
    reference: Vec<FingerShape>,
}

impl Solved {
    /// A point from a way to solve.
    fn point(
        &self,
        model: &str,
        setting: String,
        mut shape: impl FnMut(&Load) -> Option<FingerShape>,
    ) -> SpeedErrorPoint {
        let (mut seconds, mut errors) = (Vec::new(), Vec::new());
        for (load, reference) in self.loads.iter().zip(&self.reference) {
            let start = Instant::now();
            let shape = shape(load);
            let elapsed = start.elapsed().as_secs_f64();
            if let Some(shape) = shape {
                seconds.push(elapsed);
                errors.push(difference(reference, &shape));
            }
        }
        point(Task::Solve, model, setting, seconds, worst(errors), self.loads.len())
    }
}

fn point(task: Task, model: &str, setting: String, mut seconds: Vec<f64>, error: f64, asked: usize) -> SpeedErrorPoint {
    seconds.sort_by(f64::total_cmp);
    SpeedErrorPoint {
        task,
        model: model.to_owned(),
        setting,
        seconds: seconds.get(seconds.len() / 2).copied().unwrap_or(f64::NAN),
        error: if seconds.is_empty() { f64::NAN } else { error },
        failed: asked - seconds.len(),
        asked,
        on_front: false,
        timed_by: TimedBy::Report,
    }
}

/// Marks the points of each task that no other beats in both time and error.
fn mark_fronts(points: &mut [SpeedErrorPoint]) {
    let ours = |point: &SpeedErrorPoint| !matches!(point.timed_by, TimedBy::OtherProgram { .. });
    let beaten = |point: &SpeedErrorPoint, by: &SpeedErrorPoint| {
        ours(by)
            && by.task == point.task
            && by.seconds <= point.seconds
            && by.error <= point.error
            && (by.seconds < point.seconds || by.error < point.error)
    };
    for i in 0..points.len() {
        let point = &points[i];
        let answers = ours(point) && point.seconds.is_finite() && point.error.is_finite();
        points[i].on_front = answers && !points.iter().any(|by| beaten(point, by));
    }
}

/// Beams on several meshes and lattices of several finenesses, each under [`SOLVED_N`] on `nodes` nodes of the finger, spread over the front
/// plate, in three directions; errors against beams of [`CONVERGED_ELEMENTS`] elements a member. Nothing for a finger without such nodes.
///
/// # Errors
/// [`SpeedErrorError`] if the reference has no equilibrium or a lattice cannot be built.
pub fn solving(finger: &Finger, nodes: usize) -> Result<Vec<SpeedErrorPoint>, SpeedErrorError> {
    let loads = solved_loads(finger, nodes);
    if loads.is_empty() {
        return Ok(Vec::new());
    }
    let fine = Mesh::with_elements_per_member(finger, CONVERGED_ELEMENTS);
    let solve = |mesh: &Mesh, kinematics, load: &Load| -> Result<FingerShape, StaticsError> {
        finray_model::statics::solve(mesh, &[*load], kinematics)
    };
    let reference = loads.iter().map(|load| solve(&fine, Kinematics::Corotational, load)).collect::<Result<_, _>>()?;
    let solved = Solved { loads, reference };
    let mut points = Vec::new();
    for Beams { model, setting, kinematics, mesh } in beams(finger) {
        let mut statics = Statics::ladder(&mesh, kinematics);
        points.push(solved.point(model, setting, |load| {
            let load = mesh.frame_load(load).ok()?;
            Some(mesh.shape(&statics.equilibrium(&[load]).ok()?.motion))
        }));
    }
    for (setting, lattice) in lattices(finger)? {
        points.push(solved.point(LATTICE, setting, |load| lattice.equilibrium(&[*load]).ok()));
    }
    // Settling takes a hundred times longer: one load tells enough.
    let one = Solved {
        loads: solved.loads.into_iter().take(1).collect(),
        reference: solved.reference.into_iter().take(1).collect(),
    };
    for fineness in [1, 2] {
        let lattice = Lattice::new(finger, fineness)?;
        let setting = bodies(&lattice);
        points.push(one.point("spring lattice, rapier", setting, |load| Some(lattice.settle(&[*load]).ok()?.shape)));
    }
    mark_fronts(&mut points);
    Ok(points)
}

/// Beams as they are timed.
pub struct Beams {
    /// Name of the model.
    pub model: &'static str,
    /// The mesh in words.
    pub setting: String,
    /// Theory.
    pub kinematics: Kinematics,
    /// The mesh.
    pub mesh: Mesh,
}

/// Every theory on every mesh that is timed.
pub fn beams(finger: &Finger) -> Vec<Beams> {
    let theories = [
        (Kinematics::Linear, "linear beams"),
        (Kinematics::CorotationalChord, "large rotations, strain of the chord"),
        (Kinematics::Corotational, "large rotations"),
    ];
    let on_meshes = |(kinematics, model)| {
        // Linear frames are exact at the nodes: other meshes only cost more.
        let elements: &[usize] = if kinematics == Kinematics::Linear { &[1] } else { &[1, 2, 4, 8] };
        elements.iter().map(move |&elements| {
            let mesh = Mesh::with_elements_per_member(finger, elements);
            Beams { model, setting: format!("{} nodes", mesh.node_count()), kinematics, mesh }
        })
    };
    theories.into_iter().flat_map(on_meshes).collect()
}

/// Name of the lattices that Newton's method solves.
pub const LATTICE: &str = "spring lattice, Newton";

/// Every lattice whose equilibrium is timed, after its setting in words.
///
/// # Errors
/// [`LatticeError`] if one cannot be built.
pub fn lattices(finger: &Finger) -> Result<Vec<(String, Lattice)>, LatticeError> {
    let build = |fineness| Lattice::new(finger, fineness).map(|lattice| (bodies(&lattice), lattice));
    [1, 2, 3, 4].into_iter().map(build).collect()
}

fn bodies(lattice: &Lattice) -> String {
    format!("{} bodies", lattice.assembly().bodies.len())
}

/// The loads that shapes are timed under: [`SOLVED_N`] on `nodes` nodes along the front plate, in three directions.
pub fn solved_loads(finger: &Finger, nodes: usize) -> Vec<Load> {
    let directions =
        |node| SOLVED_ANGLES_DEG.map(|angle_deg| Load::at_node(node, finger.direction(angle_deg) * SOLVED_N));
    spread(finger, nodes).flat_map(directions).collect()
}

/// So many of the contact nodes, evenly, without the tip.
fn spread(finger: &Finger, nodes: usize) -> impl Iterator<Item = NodeId> {
    let contact: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
    let every = contact.len().div_ceil(nodes.max(1)).max(1);
    contact.into_iter().step_by(every)
}

/// One force on nodes spread over the front plate, and two on neighbours in its middle, sensed from `pictures` noisy pictures each of
/// the large-rotation finger `truth`; `further` estimators join those of beams.
///
/// # Errors
/// [`SpeedErrorError`] if an estimator is not made for the contacts.
pub fn sensing(
    truth: &Mesh,
    noise_mm: f64,
    nodes: usize,
    pictures: usize,
    further: &[(&dyn Estimator, &str)],
) -> Result<Vec<SpeedErrorPoint>, SpeedErrorError> {
    let finger = truth.finger();
    let meshes = sensing_meshes(finger);
    let estimators = beam_estimators(&meshes);
    let all = estimators.iter().map(|(estimator, setting)| (estimator as &dyn Estimator, setting.as_str()));
    let all: Vec<(&dyn Estimator, &str)> = all.chain(further.iter().copied()).collect();

    let tasks = [(Task::SenseOne, singles(finger, nodes)), (Task::SenseNeighbours, neighbours(finger))];
    let mut points = Vec::new();
    for (task, sets) in tasks {
        let pictures = match task {
            Task::SenseNeighbours => pictures * nodes,
            _ => pictures,
        };
        let taken: Vec<Pictures> = sets
            .iter()
            .enumerate()
            .map(|(stream, set)| Pictures::take(truth, set, noise_mm, pictures, stream as u64))
            .collect();
        for (estimator, setting) in &all {
            points.push(sensed(task, *estimator, setting, noise_mm, &taken)?);
        }
    }
    mark_fronts(&mut points);
    Ok(points)
}

/// One, two, four and eight elements a member.
pub fn sensing_meshes(finger: &Finger) -> Vec<Mesh> {
    [1, 2, 4, 8].map(|elements| Mesh::with_elements_per_member(finger, elements)).into()
}

/// The estimators on beams that are timed, each with its setting in words, on [`sensing_meshes`].
pub fn beam_estimators(meshes: &[Mesh]) -> Vec<(BeamEstimator<'_>, String)> {
    fn on(kind: EstimatorKind, mesh: &Mesh) -> (BeamEstimator<'_>, String) {
        (BeamEstimator::new(kind, mesh), format!("{} nodes", mesh.node_count()))
    }
    let linear = [EstimatorKind::LeastSquares, EstimatorKind::Ridge].into_iter();
    let linear = linear.flat_map(|kind| meshes.first().map(|mesh| on(kind, mesh)));
    linear.chain(meshes.iter().map(|mesh| on(EstimatorKind::Nonlinear, mesh))).collect()
}

/// The single nodes whose force is sensed: so many, spread over the front plate.
pub fn singles(finger: &Finger, nodes: usize) -> Vec<Vec<NodeId>> {
    spread(finger, nodes).map(|node| vec![node]).collect()
}

/// The two neighbours whose forces are sensed, in the middle of the front plate; 19 and 20 of the paper's finger.
pub fn neighbours(finger: &Finger) -> Vec<Vec<NodeId>> {
    let loaded: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
    let first = (loaded.len() / 2).min(loaded.len().saturating_sub(2));
    loaded.windows(2).skip(first).take(1).map(<[NodeId]>::to_vec).collect()
}

/// Pictures of forces at one set of contacts.
pub struct Pictures {
    /// The contacts.
    pub contacts: Vec<Contact>,
    /// True forces, N, and what the camera sees.
    pub seen: Vec<(Vec<f64>, Measurement)>,
}

impl Pictures {
    /// Takes pictures of random forces within [`SENSED_N`] on nodes of the large-rotation finger; `stream` tells one set's chance from
    /// another's.
    pub fn take(truth: &Mesh, nodes: &[NodeId], noise_mm: f64, pictures: usize, stream: u64) -> Pictures {
        let finger = truth.finger();
        let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        rng.set_stream(stream);
        let mut statics = Statics::ladder(truth, Kinematics::Corotational);
        let mut seen = Vec::new();
        for _ in 0..pictures {
            let forces_n: Vec<f64> = contacts.iter().map(|_| rng.random_range(SENSED_N[0]..SENSED_N[1])).collect();
            let loads = contacts
                .iter()
                .zip(&forces_n)
                .map(|(contact, &force_n)| truth.frame_load(&contact.load(finger, force_n)));
            let Ok(loads) = loads.collect::<Result<Vec<_>, _>>() else { continue };
            // A finger that does not carry a draw is not asked for it.
            let Ok(equilibrium) = statics.equilibrium(&loads) else { continue };
            let mut picture = Measurement::of_shape(finger, &truth.shape(&equilibrium.motion));
            picture.add_noise(noise_mm, || StandardNormal.sample(&mut rng));
            seen.push((forces_n, picture));
        }
        Pictures { contacts, seen }
    }
}

fn sensed(
    task: Task,
    estimator: &dyn Estimator,
    setting: &str,
    noise_mm: f64,
    taken: &[Pictures],
) -> Result<SpeedErrorPoint, SpeedErrorError> {
    let (mut seconds, mut errors, mut asked) = (Vec::new(), Vec::new(), 0);
    for pictures in taken {
        let Some((_, first)) = pictures.seen.first() else { continue };
        let mut prepared = estimator.prepare(&pictures.contacts, first)?;
        for (forces_n, picture) in &pictures.seen {
            asked += 1;
            let start = Instant::now();
            let answer = prepared.estimate(picture, Some(noise_mm));
            let elapsed = start.elapsed().as_secs_f64();
            if let Ok(answer) = answer {
                seconds.push(elapsed);
                errors.extend(answer.forces_n.iter().zip(forces_n).map(|(sensed, force)| (sensed / force - 1.0).abs()));
            }
        }
    }
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    Ok(point(task, estimator.name(), setting.to_owned(), seconds, mean, asked))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let of = |seconds: f64, error: f64| SpeedErrorPoint {
            error,
            ..point(Task::Solve, "", String::new(), vec![seconds], error, 1)
        };
        let mut points = [of(1.0, 1.0), of(2.0, 0.5), of(3.0, 0.6), of(1.0, 2.0), of(f64::NAN, 0.1)];
        // Faster than all, for another task.
        points[3].task = Task::SenseOne;
        mark_fronts(&mut points);
        assert_eq!(points.map(|point| point.on_front), [true, true, false, true, false]);
    }

    #[test]
    fn what_fails_is_counted_and_has_no_error() {
        let failed = point(Task::Solve, "", String::new(), Vec::new(), 0.0, 3);
        assert!(failed.error.is_nan() && failed.seconds.is_nan() && failed.failed == 3);
    }
}
