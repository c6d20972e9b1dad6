//! Sensing of a moving force, frame by frame: time, error, and the error of the mesh.
//!
//! A force at a node oscillates over the range [`TWO_FORCES_N`] once per second, at the paper's 25 frames per second. The force changes by up to 0.34
//! N between frames. Frames contain the displacements, with noise, of the co-rotational finger on the finest mesh. The nonlinear estimator is timed
//! from a cold start (the least-squares solution) and from a warm start (the answer for the previous frame). Other estimators do not iterate from a
//! starting point. The first answer for a contact, which includes all preparation, is timed separately. As in `finray sense`, answers include the
//! standard deviations with the errors of linearisation and mesh.

use super::{ASKED_NODES, ExperimentError, SpeedErrorPoint, Start, Task, TimedBy, mark_fronts, spread};
use crate::prelude::*;
use crate::sampling::bound::{ForceBound, linearised_markers};
use crate::sampling::noise::Noise;
use crate::settings::TWO_FORCES_N;
use crate::statistics::percentile;
use finray_model::statics::Ladder;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Number of frames in one oscillation of a force: one second at the paper's 25 Hz.
pub const FRAMES_A_PERIOD: usize = 25;
const SEED: u64 = 11;
/// Number of times that the preparation of an estimator for a set of contacts is timed. The median of the times counts.
const PREPARATIONS: usize = 5;

/// One frame: true forces and measurement.
pub struct Frame {
    /// True forces, N.
    pub forces_n: Vec<f64>,
    /// Displacements with noise.
    pub seen: Measurement,
    /// Displacements without noise.
    pub exact: Measurement,
    /// Cramer-Rao bound of each force under the stream's noise, N; `None` if it cannot be computed.
    pub bound_n: Option<Vec<f64>>,
}

/// Frames of oscillating forces at one set of contacts.
pub struct Stream {
    /// Contacts at which the forces act.
    pub contacts: Vec<Contact>,
    /// The frames in time order.
    pub frames: Vec<Frame>,
}

impl Stream {
    /// Generates `frames` frames of the co-rotational finger `truth` under forces in `range_n` (N), with noise `noise_mm` (mm). Two forces differ by a
    /// quarter of a period in phase. `stream` selects independent noise.
    pub fn take(
        truth: &Mesh,
        nodes: &[NodeId],
        noise_mm: f64,
        range_n: [f64; 2],
        frames: usize,
        stream: u64,
    ) -> Stream {
        let finger = truth.finger();
        let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
        let model = Mesh::with_elements_per_member(finger, ELEMENTS);
        let bent = |statics: &mut Statics<Ladder<'_>>, frame: usize| {
            let forces_n: Vec<f64> = (0..contacts.len()).map(|contact| force_n(range_n, frame, contact)).collect();
            let loads = contacts
                .iter()
                .zip(&forces_n)
                .map(|(contact, &force_n)| truth.frame_load(&contact.load(finger, force_n)));
            let loads = loads.collect::<Result<Vec<_>, _>>().ok()?;
            // Forces without equilibrium have no frame.
            let equilibrium = statics.equilibrium(&loads).ok()?;
            let exact = Measurement::of_shape(finger, &truth.shape(&equilibrium.motion));
            let mut model_statics = Statics::ladder(&model, Kinematics::Corotational);
            let linearised = linearised_markers(&mut model_statics, &model, &contacts, &forces_n);
            let bound = linearised.and_then(|(_, derivatives)| ForceBound::new(&derivatives));
            Some((forces_n, exact, bound.map(|bound| bound.sigmas_n(noise_mm))))
        };
        let statics = || Statics::ladder(truth, Kinematics::Corotational);
        // Periods differ only in their noise.
        let of_period: Vec<_> = (0..frames.min(FRAMES_A_PERIOD)).into_par_iter().map_init(statics, bent).collect();
        let mut noise = Noise::of_stream(SEED, stream);
        let taken = of_period.iter().cycle().take(frames).flatten().map(|(forces_n, exact, bound_n)| Frame {
            forces_n: forces_n.clone(),
            seen: noise.on(exact, noise_mm),
            exact: exact.clone(),
            bound_n: bound_n.clone(),
        });
        Stream { contacts, frames: taken.collect() }
    }
}

/// Force at a contact in a frame, N, within a range.
fn force_n([low, high]: [f64; 2], frame: usize, contact: usize) -> f64 {
    let phase = TAU * frame as f64 / FRAMES_A_PERIOD as f64 + FRAC_PI_2 * contact as f64;
    0.5 * (low + high) + 0.5 * (high - low) * phase.sin()
}

/// An estimator to be timed.
pub struct TimedEstimator {
    /// Estimator and mesh.
    pub options: SensorOptions,
    /// Mesh or other setting, in words.
    pub setting: String,
    /// Starting point of each frame.
    pub start: Start,
}

impl TimedEstimator {
    /// Setting and starting point in words, as in tables and benches.
    pub fn in_words(&self) -> String {
        format!("{}{}", self.setting, self.start.suffix())
    }
}

/// Meshes with one, two, four and eight elements per member.
pub fn sensing_meshes(finger: &Finger) -> Vec<Mesh> {
    [1, 2, 4, 8].map(|elements| Mesh::with_elements_per_member(finger, elements)).into()
}

/// The beam estimators to be timed: the linear estimators on the first of [`sensing_meshes`], and the nonlinear estimator on all meshes, with cold
/// and warm start.
pub fn beam_estimators(meshes: &[Mesh]) -> Vec<TimedEstimator> {
    let on = |mesh: &Mesh, estimator, start| TimedEstimator {
        options: SensorOptions { mesh_nodes: Some(mesh.node_count()), ..SensorOptions::of(estimator) },
        setting: format!("{} nodes", mesh.node_count()),
        start,
    };
    let linear = |mesh| [EstimatorId::LeastSquares, EstimatorId::Ridge].map(|id| on(mesh, id, Start::None));
    let nonlinear = |start| meshes.iter().map(move |mesh| on(mesh, EstimatorId::Nonlinear, start));
    meshes.first().into_iter().flat_map(linear).chain(nonlinear(Start::Cold)).chain(nonlinear(Start::Warm)).collect()
}

/// A sensor that is asked frame by frame.
pub struct FrameSensor {
    sensor: Sensor,
    start: Start,
    last: Option<SensedForces>,
}

impl FrameSensor {
    /// A sensor for the contacts of a stream on a finger.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator does not support the contacts.
    pub fn new(scene: &PreparedScene, timed: &TimedEstimator, contacts: &[Contact]) -> Result<FrameSensor, Refusal> {
        let sensor = Sensor::new(scene.clone(), SensorContacts::known(contacts), timed.options.clone())?;
        Ok(FrameSensor { sensor, start: timed.start, last: None })
    }

    /// Senses a frame with noise `noise_mm` (mm), from the last frame's forces after a warm start.
    ///
    /// # Errors
    /// [`Refusal`] as for [`Sensor::sense`].
    pub fn sense(&mut self, seen: &Measurement, noise_mm: f64) -> Result<&SensedForces, Refusal> {
        let near = self.last.take().filter(|_| self.start == Start::Warm);
        Ok(self.last.insert(self.sensor.sense_displacements(seen, Some(noise_mm), near.as_ref())?))
    }
}

/// Sets of one node each for sensing: at most `nodes` nodes, evenly spaced over the front plate.
pub fn singles(finger: &Finger, nodes: usize) -> Vec<Vec<NodeId>> {
    spread(finger, nodes).map(|node| vec![node]).collect()
}

/// One set of two neighbouring nodes in the middle of the front plate: 19 and 20 of the paper's finger. Empty if there are fewer than two contact
/// nodes besides the tip.
pub fn neighbours(finger: &Finger) -> Vec<Vec<NodeId>> {
    let loaded: Vec<NodeId> = finger.contact_nodes().skip(1).collect();
    let first = (loaded.len() / 2).min(loaded.len().saturating_sub(2));
    loaded.windows(2).skip(first).take(1).map(<[NodeId]>::to_vec).collect()
}

/// Times sensing of one oscillating force at [`ASKED_NODES`] nodes, and of two forces at neighbouring nodes, on the finger of `truth`. `periods` are
/// the numbers of oscillations for the two tasks. The noise is `noise_mm` (mm). The estimators in `further` are timed in addition to the beam
/// estimators.
pub(crate) fn sensing(
    truth: &Mesh,
    noise_mm: f64,
    forces: ReportForces,
    periods: [usize; 2],
    further: Vec<TimedEstimator>,
) -> Result<Vec<SpeedErrorPoint>, ExperimentError> {
    let finger = truth.finger();
    let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
    let meshes = sensing_meshes(finger);
    let beams = beam_estimators(&meshes);
    let tasks = [(Task::SenseOne, singles(finger, ASKED_NODES)), (Task::SenseNeighbours, neighbours(finger))];
    let range_n = forces.scaled(TWO_FORCES_N);
    let mut points = Vec::new();
    for ((task, sets), periods) in tasks.into_iter().zip(periods) {
        let frames = periods * FRAMES_A_PERIOD;
        let streams: Vec<Stream> = sets
            .par_iter()
            .enumerate()
            .map(|(stream, set)| Stream::take(truth, set, noise_mm, range_n, frames, stream as u64))
            .collect();
        let estimators: Vec<&TimedEstimator> = beams.iter().chain(&further).collect();
        let of_task = estimators.iter().map(|timed| sensed(&scene, task, timed, noise_mm, &streams));
        let mut of_task = of_task.collect::<Result<Vec<_>, _>>()?;
        // Timing is complete at this point, so the model errors may be computed in parallel. The model error does not depend on the starting point,
        // so cold starts get the error of warm starts.
        let once: Vec<&&TimedEstimator> = estimators.iter().filter(|timed| timed.start != Start::Cold).collect();
        let biases = once.par_iter().map(|timed| largest_bias(&scene, timed, noise_mm, &streams));
        let biases: Vec<Option<f64>> = biases.collect::<Result<_, _>>()?;
        for (point, timed) in of_task.iter_mut().zip(&estimators) {
            let same = |other: &&&TimedEstimator| {
                (other.options.estimator, &other.setting) == (timed.options.estimator, &timed.setting)
            };
            point.bias_sigmas = once.iter().position(same).and_then(|i| biases[i]);
        }
        points.append(&mut of_task);
    }
    mark_fronts(&mut points);
    Ok(points)
}

/// Time and error of an estimator on streams of frames with noise `noise_mm` (mm). The model error (`bias_sigmas`) is left `None`.
///
/// # Errors
/// [`ExperimentError`] if the estimator does not support the contacts.
pub fn sensed(
    scene: &PreparedScene,
    task: Task,
    timed: &TimedEstimator,
    noise_mm: f64,
    streams: &[Stream],
) -> Result<SpeedErrorPoint, ExperimentError> {
    let (mut seconds, mut preparations, mut errors, mut asked) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for stream in streams {
        let Some(first) = stream.frames.first() else { continue };
        for _ in 0..PREPARATIONS {
            let start = Instant::now();
            // A refusal prepares the sensor, too.
            let _ = FrameSensor::new(scene, timed, &stream.contacts)?.sense(&first.seen, noise_mm);
            preparations.push(start.elapsed().as_secs_f64());
        }
        let mut sensor = FrameSensor::new(scene, timed, &stream.contacts)?;
        for frame in &stream.frames {
            asked += 1;
            let start = Instant::now();
            let answer = sensor.sense(&frame.seen, noise_mm);
            let elapsed = start.elapsed().as_secs_f64();
            if let Ok(answer) = answer {
                seconds.push(elapsed);
                let pairs = answer.forces.iter().zip(&frame.forces_n);
                errors.extend(pairs.map(|(sensed, force_n)| (sensed.force_n / force_n - 1.0).abs()));
            }
        }
    }
    Ok(SpeedErrorPoint {
        task,
        model: timed.options.estimator.name().to_owned(),
        estimator: Some(timed.options.estimator),
        setting: timed.in_words(),
        start: timed.start,
        seconds: percentile(&mut seconds, 50.0),
        seconds_95: Some(percentile(&mut seconds, 95.0)),
        preparation_seconds: Some(percentile(&mut preparations, 50.0)),
        error: mean(errors).unwrap_or(f64::NAN),
        bias_sigmas: None,
        failed: asked - seconds.len(),
        asked,
        on_front: false,
        timed_by: TimedBy::Report,
    })
}

/// Model error of an estimator: largest error over frames without noise, in standard deviations of the noise. The standard deviations are those of
/// the Cramer-Rao bound. The estimator's stated standard deviation is not used, because it grows with the model error.
///
/// # Errors
/// [`ExperimentError`] if the estimator does not support the contacts.
pub fn largest_bias(
    scene: &PreparedScene,
    timed: &TimedEstimator,
    noise_mm: f64,
    streams: &[Stream],
) -> Result<Option<f64>, ExperimentError> {
    let of_stream = |stream: &Stream| {
        let mut sensor = FrameSensor::new(scene, timed, &stream.contacts)?;
        let of_frame = |frame: &Frame| {
            let answer = sensor.sense(&frame.exact, noise_mm).ok()?;
            let forces = answer.forces.iter().zip(&frame.forces_n).zip(frame.bound_n.as_ref()?);
            forces.map(|((sensed, force_n), bound_n)| ((sensed.force_n - force_n) / bound_n).abs()).reduce(f64::max)
        };
        // Without noise all periods have the same frames.
        Ok(stream.frames.iter().take(FRAMES_A_PERIOD).filter_map(of_frame).reduce(f64::max))
    };
    let of_streams: Vec<Option<f64>> = streams.par_iter().map(of_stream).collect::<Result<_, ExperimentError>>()?;
    Ok(of_streams.into_iter().flatten().reduce(f64::max))
}
