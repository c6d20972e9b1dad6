//! Sensing of a moving force, frame by frame: time, error, and the error of the mesh.
//!
//! A force at a node oscillates over the range [`TWO_FORCES_N`] once per second, at the paper's 25 frames per second. The force changes by up to 0.34
//! N between frames. Frames contain the displacements, with noise, of the co-rotational finger on the finest mesh. The nonlinear estimator is timed
//! from a cold start (the least-squares solution) and from a warm start (the answer for the previous frame). Other estimators do not iterate from a
//! starting point. Preparation for a contact is timed separately. In this study, stated standard deviations cover only noise, so that errors of
//! linearisation and mesh can be compared with the noise. `finray sense` also computes the errors of linearisation and mesh, to widen its intervals;
//! that computation is not timed here.

use super::{ASKED_NODES, ExperimentError, SpeedErrorPoint, Start, Task, TimedBy, mark_fronts, spread};
use crate::prelude::*;
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
        let bound = BeamEstimator::nonlinear(&model).of_noise_alone();
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
            let at_truth = bound.prepare(&contacts, &exact).and_then(|mut prepared| {
                prepared.expect_forces(&forces_n);
                prepared.estimate(&exact, Some(noise_mm))
            });
            Some((forces_n, exact, at_truth.ok().and_then(|sensed| sensed.sigmas_n)))
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
pub struct TimedEstimator<'e> {
    /// Estimator whose answers are timed.
    pub estimator: Box<dyn Estimator + 'e>,
    /// Mesh or other setting, in words.
    pub setting: String,
    /// Starting point of each frame.
    pub start: Start,
}

impl TimedEstimator<'_> {
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
pub fn beam_estimators(meshes: &[Mesh]) -> Vec<TimedEstimator<'_>> {
    fn on<'m>(mesh: &'m Mesh, estimator: impl Estimator + 'm, start: Start) -> TimedEstimator<'m> {
        TimedEstimator { estimator: Box::new(estimator), setting: format!("{} nodes", mesh.node_count()), start }
    }
    let linear = |mesh| {
        [BeamEstimator::least_squares(mesh), BeamEstimator::ridge(mesh)]
            .map(|estimator| on(mesh, estimator.of_noise_alone(), Start::None))
    };
    let cold = meshes.iter().map(|mesh| on(mesh, BeamEstimator::nonlinear(mesh).of_noise_alone(), Start::Cold));
    let warm = meshes.iter().map(|mesh| on(mesh, Streaming { mesh }, Start::Warm));
    meshes.first().into_iter().flat_map(linear).chain(cold).chain(warm).collect()
}

/// The nonlinear estimator, which starts each frame from the answer for the previous frame.
struct Streaming<'m> {
    mesh: &'m Mesh,
}

impl Estimator for Streaming<'_> {
    fn id(&self) -> EstimatorId {
        EstimatorId::Nonlinear
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        _: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        let questions: Vec<_> = contacts.iter().map(|&contact| contact.into()).collect();
        Ok(Box::new(PreparedStream(NonlinearEstimator::new(self.mesh, &questions)?)))
    }
}

struct PreparedStream<'m>(NonlinearEstimator<'m>);

impl PreparedEstimator for PreparedStream<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let estimate = self.0.estimate(measurement, noise_mm)?;
        Ok(Sensed {
            sum_sigma_n: Some(estimate.covariance_n2.sum().sqrt()),
            warned: estimate.forces.warning.is_some(),
            forces_n: estimate.forces.forces_n,
            sigmas_n: Some(estimate.forces.sigmas_n),
        })
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
    further: Vec<TimedEstimator<'_>>,
) -> Result<Vec<SpeedErrorPoint>, ExperimentError> {
    let finger = truth.finger();
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
        let estimators: Vec<&TimedEstimator<'_>> = beams.iter().chain(&further).collect();
        let of_task = estimators.iter().map(|timed| sensed(task, timed, noise_mm, &streams));
        let mut of_task = of_task.collect::<Result<Vec<_>, _>>()?;
        // Timing is complete at this point, so the model errors may be computed in parallel. The model error does not depend on the starting point,
        // so cold starts get the error of warm starts.
        let once: Vec<&&TimedEstimator<'_>> = estimators.iter().filter(|timed| timed.start != Start::Cold).collect();
        let biases = once.par_iter().map(|timed| largest_bias(timed, noise_mm, &streams));
        let biases: Vec<Option<f64>> = biases.collect::<Result<_, _>>()?;
        for (point, timed) in of_task.iter_mut().zip(&estimators) {
            let same = |other: &&&TimedEstimator<'_>| {
                (other.estimator.id(), &other.setting) == (timed.estimator.id(), &timed.setting)
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
    task: Task,
    timed: &TimedEstimator<'_>,
    noise_mm: f64,
    streams: &[Stream],
) -> Result<SpeedErrorPoint, ExperimentError> {
    let estimator = &*timed.estimator;
    let (mut seconds, mut preparations, mut errors, mut asked) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for stream in streams {
        let Some(first) = stream.frames.first() else { continue };
        let prepare = || estimator.prepare(&stream.contacts, &first.seen);
        for _ in 0..PREPARATIONS {
            let start = Instant::now();
            let prepared = prepare()?;
            preparations.push(start.elapsed().as_secs_f64());
            drop(prepared);
        }
        let mut prepared = prepare()?;
        for frame in &stream.frames {
            asked += 1;
            let start = Instant::now();
            let answer = prepared.estimate(&frame.seen, Some(noise_mm));
            let elapsed = start.elapsed().as_secs_f64();
            if let Ok(answer) = answer {
                seconds.push(elapsed);
                let pairs = answer.forces_n.iter().zip(&frame.forces_n);
                errors.extend(pairs.map(|(sensed, force)| (sensed / force - 1.0).abs()));
            }
        }
    }
    Ok(SpeedErrorPoint {
        task,
        model: estimator.id().name().to_owned(),
        estimator: Some(estimator.id()),
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
    timed: &TimedEstimator<'_>,
    noise_mm: f64,
    streams: &[Stream],
) -> Result<Option<f64>, ExperimentError> {
    let of_stream = |stream: &Stream| {
        let Some(first) = stream.frames.first() else { return Ok(None) };
        let mut prepared = timed.estimator.prepare(&stream.contacts, &first.seen)?;
        let of_frame = |frame: &Frame| {
            let answer = prepared.estimate(&frame.exact, Some(noise_mm)).ok()?;
            let forces_n = answer.forces_n.iter().zip(&frame.forces_n).zip(frame.bound_n.as_ref()?);
            forces_n.map(|((sensed, force), bound_n)| ((sensed - force) / bound_n).abs()).reduce(f64::max)
        };
        // Without noise all periods have the same frames.
        Ok(stream.frames.iter().take(FRAMES_A_PERIOD).filter_map(of_frame).reduce(f64::max))
    };
    let of_streams: Vec<Option<f64>> = streams.par_iter().map(of_stream).collect::<Result<_, ExperimentError>>()?;
    Ok(of_streams.into_iter().flatten().reduce(f64::max))
}
