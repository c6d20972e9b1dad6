//! Time and error of every model of the finger and every estimator, on the paper's finger.
//!
//! `FINRAY_TEST_CASES=full cargo bench -p finray-bench --bench speed_error` records the results in `fixtures/results`, and the report of the paper's
//! finger shows them. Run as a test, this bench times nothing and compares the errors with the record.
//!
//! A shape is computed under one force along the front plate, and compared with converged beams. A force is sensed frame by frame: a force along the
//! normal oscillates once per second, and 25 frames a second show the finger on a mesh of 684 nodes, with noise. A cold start is the least-squares
//! solution, a warm start the answer for the previous frame. Preparation for a contact is timed separately. Standard deviations cover only noise, so
//! that the error of linearisation and mesh can be compared with it.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, criterion_group, criterion_main};
use finray_bench::paper;
use finray_lattice::Lattice;
use finray_model::estimators::network::Networks;
use finray_model::estimators::{ELEMENTS, EstimatorId};
use finray_model::measurement::Measurement;
use finray_model::mesh::FingerShape;
use finray_model::sensing::network::NetworkEstimator;
use finray_model::sensing::{Contact, ForcePrior, LinearEstimator, NonlinearEstimator};
use finray_model::statics::{Statics, solve};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId};
use finray_studies::sampling::noise::Noise;
use finray_studies::settings::{CAMERA_NOISE_MM, TRUSTED_ERROR, TWO_FORCES_N};
use finray_studies::truths::fine_mesh;
use finray_tests::{assert_recorded, assert_said, is_full_study, shapes_apart};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Loaded nodes of the paper's finger (sec. V), one at a time, and two neighbours.
const NODES: std::ops::RangeInclusive<usize> = 14..=24;
const NEIGHBOURS: [usize; 2] = [19, 20];
/// Force under which shapes are computed, N, and its directions, degrees.
const SOLVED_N: f64 = 3.0;
const SOLVED_ANGLES_DEG: [f64; 3] = [-40.0, 0.0, 40.0];
/// Elements per member of converged beams. Doubling this number changes displacements of the paper's finger under 5 N by at most 1e-6, relative.
const CONVERGED_ELEMENTS: usize = 32;
/// Frames in one oscillation of a force, and oscillations of one force and of two forces.
const FRAMES_A_PERIOD: usize = 25;
const PERIODS: [usize; 2] = [2, 8];
const SEED: u64 = 11;
/// The preparation for a set of contacts is timed this often.
const PREPARATIONS: usize = 5;
/// A shape counts as accurate up to this relative error, the tolerance of the paper's mesh of key nodes.
const GOOD_SHAPE: f64 = 0.01;
/// A recommended setting has at most this model error, in standard deviations of the noise. At 0.4, the interval of 1.96 standard deviations covers
/// Phi(1.96 - 0.4) - Phi(-1.96 - 0.4) = 93 % instead of 95 %. Checks of coverage have the lower limit 93 %.
const LARGEST_BIAS_SIGMAS: f64 = 0.4;
/// The error of a recommended setting is at most this multiple of the best error. The mean error over a hundred noisy frames has a standard error of
/// 10 %.
const NEAR_BEST: f64 = 1.25;
/// Errors of two machines are the same within this share: iterations end at a step of 1e-7 of the forces.
const SAME: f64 = 1e-3;

/// Time and error of one method; `fixtures/README.md` describes the columns.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Row {
    task: String,
    model: String,
    setting: String,
    start: String,
    seconds: f64,
    seconds_95: Option<f64>,
    preparation_seconds: Option<f64>,
    error: Option<f64>,
    bias_sigmas: Option<f64>,
    failed: usize,
    asked: usize,
    timed_by: String,
    machine: String,
}

/// Value of a share of sorted figures: 0.5 gives the median.
fn quantile(figures: &mut [f64], share: f64) -> f64 {
    figures.sort_by(f64::total_cmp);
    figures[((share * figures.len() as f64).ceil() as usize).saturating_sub(1)]
}

/// Median and 95th percentile of the time of one answer, s. `answer` computes the n-th case and states whether it has an answer.
fn times(group: &mut BenchmarkGroup<WallTime>, id: BenchmarkId, mut answer: impl FnMut(usize) -> bool) -> [f64; 2] {
    let (mut seconds, mut n) = (Vec::new(), 0);
    group.bench_function(id, |bencher| {
        bencher.iter_custom(|iterations| {
            let mut sum = Duration::ZERO;
            for _ in 0..iterations {
                let start = Instant::now();
                let answers = black_box(answer(black_box(n)));
                let elapsed = start.elapsed();
                n += 1;
                sum += elapsed;
                if answers {
                    seconds.push(elapsed.as_secs_f64());
                }
            }
            sum
        });
    });
    [0.5, 0.95].map(|share| quantile(&mut seconds, share))
}

/// Name of the processor; empty where the system does not state it.
fn machine() -> String {
    let about = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    name.map(|(_, name)| format!("{name}, one core")).unwrap_or_default()
}

fn row(task: &str, model: &str, setting: &str, start: &str, [seconds, seconds_95]: [f64; 2]) -> Row {
    Row {
        task: task.to_owned(),
        model: model.to_owned(),
        setting: setting.to_owned(),
        start: start.to_owned(),
        seconds,
        seconds_95: Some(seconds_95),
        preparation_seconds: None,
        error: None,
        bias_sigmas: None,
        failed: 0,
        asked: 0,
        timed_by: "criterion".to_owned(),
        machine: machine(),
    }
}

/// A method for the shape under a load: model, setting, and the method.
type Solver<'m> = (&'static str, String, Box<dyn FnMut(&Load) -> Option<FingerShape> + 'm>);

/// Beams by kinematics and mesh. Linear elements are exact at the nodes, so finer meshes only take longer.
fn beams(finger: &Finger) -> Vec<(&'static str, Kinematics, Mesh)> {
    let theories: [(_, _, &[usize]); 3] = [
        ("linear beams", Kinematics::Linear, &[1]),
        ("co-rotational, strain of the chord", Kinematics::CorotationalChord, &[1, 2, 4, 8]),
        ("co-rotational", Kinematics::Corotational, &[1, 2, 4, 8]),
    ];
    let on = |n: usize| Mesh::with_elements_per_member(finger, n);
    theories
        .into_iter()
        .flat_map(|(model, kinematics, meshes)| meshes.iter().map(move |&n| (model, kinematics, on(n))))
        .collect()
}

fn solver<'m>((model, kinematics, mesh): &'m (&'static str, Kinematics, Mesh)) -> Solver<'m> {
    let mut statics = Statics::ladder(mesh, *kinematics);
    let shape = move |load: &Load| {
        let load = mesh.frame_load(load).ok()?;
        Some(mesh.shape(&statics.equilibrium(&[load]).ok()?.motion))
    };
    (model, format!("{} nodes", mesh.node_count()), Box::new(shape))
}

fn bodies(lattice: &Lattice) -> String {
    format!("{} bodies", lattice.assembly().bodies.len())
}

fn shapes(criterion: &mut Criterion) -> Vec<Row> {
    let finger = paper();
    let loads: Vec<Load> = NODES
        .flat_map(|node| SOLVED_ANGLES_DEG.map(|angle_deg| (node, finger.direction(angle_deg) * SOLVED_N)))
        .map(|(node, force)| Load::at_node(NodeId(node), force))
        .collect();
    let fine = Mesh::with_elements_per_member(&finger, CONVERGED_ELEMENTS);
    let reference = |load: &Load| solve(&fine, &[*load], Kinematics::Corotational).expect("an equilibrium");
    let references: Vec<FingerShape> = loads.par_iter().map(reference).collect();
    let mut group = criterion.benchmark_group("speed_error/solve");
    let mut rows = Vec::new();
    let (beams, lattices) = (beams(&finger), [1, 2, 3, 4].map(|n| Lattice::new(&finger, n).expect("a lattice")));
    let by_newton = lattices.iter().map(|lattice| -> Solver {
        ("spring lattice, Newton", bodies(lattice), Box::new(|load: &Load| lattice.equilibrium(&[*load]).ok()))
    });
    for (model, setting, mut shape) in beams.iter().map(solver).chain(by_newton) {
        let errors = loads.iter().zip(&references).filter_map(|(load, exact)| Some(shapes_apart(&shape(load)?, exact)));
        let errors: Vec<f64> = errors.collect();
        let id = BenchmarkId::new(model, &setting);
        let times = times(&mut group, id, |n| shape(&loads[n % loads.len()]).is_some());
        let (answered, asked) = (errors.len(), loads.len());
        let error = errors.into_iter().reduce(f64::max);
        rows.push(Row { error, failed: asked - answered, asked, ..row("solve", model, &setting, "none", times) });
    }
    group.finish();
    // Settling takes a hundred times as long as Newton's method, so one load is settled once.
    for lattice in &lattices[..2] {
        let start = Instant::now();
        let settled = lattice.settle(&loads[..1]).expect("a lattice at rest");
        let seconds = start.elapsed().as_secs_f64();
        let error = Some(shapes_apart(&settled.shape, &references[0]));
        let of = row("solve", "spring lattice, rapier", &bodies(lattice), "none", [seconds; 2]);
        rows.push(Row { error, asked: 1, ..of });
    }
    rows
}

/// One frame: true forces (N), displacements with and without noise, and the Cramer-Rao bound of each force (N).
struct Frame {
    forces_n: Vec<f64>,
    seen: Measurement,
    exact: Measurement,
    bound_n: Vec<f64>,
}

/// Frames of oscillating forces at some contacts; two forces differ by a quarter of a period in phase.
fn frames(truth: &Mesh, nodes: &[usize], periods: usize, stream: u64) -> (Vec<Contact>, Vec<Frame>) {
    let finger = truth.finger();
    let contacts: Vec<Contact> = nodes.iter().map(|&node| Contact::at_node(NodeId(node))).collect();
    let model = Mesh::with_elements_per_member(finger, ELEMENTS);
    let mut bound = nonlinear(&model, &contacts);
    let mut statics = Statics::ladder(truth, Kinematics::Corotational);
    let [low, high] = TWO_FORCES_N;
    let mut of_period = Vec::new();
    for frame in 0..FRAMES_A_PERIOD {
        let force = |contact: usize| {
            let phase = TAU * frame as f64 / FRAMES_A_PERIOD as f64 + FRAC_PI_2 * contact as f64;
            0.5 * (low + high) + 0.5 * (high - low) * phase.sin()
        };
        let forces_n: Vec<f64> = (0..contacts.len()).map(force).collect();
        let load =
            |(contact, &force_n): (&Contact, &f64)| truth.frame_load(&contact.load(finger, force_n)).expect("a load");
        let loads: Vec<_> = contacts.iter().zip(&forces_n).map(load).collect();
        let exact = Measurement::of_shape(finger, &truth.shape(&statics.equilibrium(&loads).expect("carried").motion));
        let bound_n = bound.estimate(&exact, Some(CAMERA_NOISE_MM)).expect("an estimate").forces.sigmas_n;
        of_period.push((forces_n, exact, bound_n));
    }
    let mut noise = Noise::of_stream(SEED, stream);
    let frame = |(forces_n, exact, bound_n): &(Vec<f64>, Measurement, Vec<f64>)| Frame {
        forces_n: forces_n.clone(),
        seen: noise.on(exact, CAMERA_NOISE_MM),
        exact: exact.clone(),
        bound_n: bound_n.clone(),
    };
    (contacts, of_period.iter().cycle().take(periods * FRAMES_A_PERIOD).map(frame).collect())
}

fn nonlinear<'m>(mesh: &'m Mesh, contacts: &[Contact]) -> NonlinearEstimator<'m> {
    let questions: Vec<_> = contacts.iter().map(|&contact| contact.into()).collect();
    NonlinearEstimator::new(mesh, &questions).expect("contact nodes")
}

/// Forces (N) that a prepared estimator finds in a measurement, if it answers.
type Prepared<'m> = Box<dyn FnMut(&Measurement) -> Option<Vec<f64>> + 'm>;
/// A way of sensing: estimator, setting, start, and the preparation for contacts.
type Way<'m> = (EstimatorId, String, &'static str, Box<dyn Fn(&[Contact]) -> Prepared<'m> + 'm>);

fn ways<'m>(finger: &'m Finger, meshes: &'m [Mesh], networks: &'m Networks) -> Vec<Way<'m>> {
    let mut all: Vec<Way> = Vec::new();
    for (id, prior) in [(EstimatorId::LeastSquares, ForcePrior::None), (EstimatorId::Ridge, ForcePrior::PAPER)] {
        let prepare = move |contacts: &[Contact]| -> Prepared<'m> {
            let estimator = LinearEstimator::new(finger, contacts, &Measurement::at_rest(finger)).expect("contacts");
            Box::new(move |seen| Some(estimator.estimate(seen, Some(CAMERA_NOISE_MM), prior).forces_n))
        };
        all.push((id, format!("{} nodes", finger.key_node_count()), "none", Box::new(prepare)));
    }
    for (start, is_cold) in [("cold", true), ("warm", false)] {
        for mesh in meshes {
            let prepare = move |contacts: &[Contact]| -> Prepared<'m> {
                let mut estimator = nonlinear(mesh, contacts);
                Box::new(move |seen| {
                    if is_cold {
                        estimator.reset();
                    }
                    estimator.estimate(seen, Some(CAMERA_NOISE_MM)).ok().map(|found| found.forces.forces_n)
                })
            };
            all.push((EstimatorId::Nonlinear, format!("{} nodes", mesh.node_count()), start, Box::new(prepare)));
        }
    }
    let prepare = move |contacts: &[Contact]| -> Prepared<'m> {
        let network = networks.choose(finger, contacts).expect("a network that ships");
        let at_rest = Measurement::at_rest(finger);
        let mut estimator = NetworkEstimator::new(network, finger, contacts, &at_rest).expect("its contacts");
        Box::new(move |seen| estimator.estimate(seen, Some(CAMERA_NOISE_MM)).ok().map(|found| found.forces_n))
    };
    all.push((EstimatorId::Network, "shipped networks".to_owned(), "none", Box::new(prepare)));
    all
}

fn forces(criterion: &mut Criterion) -> Vec<Row> {
    let finger = paper();
    let truth = fine_mesh(&finger).expect("684 nodes");
    let meshes = [1, 2, 4, 8].map(|elements| Mesh::with_elements_per_member(&finger, elements));
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that ship");
    let tasks =
        [("sense-one", NODES.map(|node| vec![node]).collect()), ("sense-neighbours", vec![NEIGHBOURS.to_vec()])];
    let mut rows = Vec::new();
    for ((task, sets), periods) in tasks.into_iter().zip(PERIODS) {
        let sets: Vec<Vec<usize>> = sets;
        let streams: Vec<_> =
            sets.par_iter().enumerate().map(|(n, nodes)| frames(&truth, nodes, periods, n as u64)).collect();
        let mut group = criterion.benchmark_group(format!("speed_error/{task}"));
        for (id, setting, start, prepare) in ways(&finger, &meshes, &networks) {
            let (mut preparations, mut errors, mut biases, mut failed) = (Vec::new(), Vec::new(), Vec::new(), 0);
            let mut prepared: Vec<(Prepared, &[Frame])> = Vec::new();
            for (contacts, frames) in &streams {
                for _ in 0..PREPARATIONS {
                    let start = Instant::now();
                    drop(black_box(prepare(contacts)));
                    preparations.push(start.elapsed().as_secs_f64());
                }
                let mut estimate = prepare(contacts);
                for frame in &frames[..FRAMES_A_PERIOD] {
                    let sensed = estimate(&frame.exact).into_iter().flatten();
                    biases
                        .extend(sensed.zip(&frame.forces_n).zip(&frame.bound_n).map(|((f, t), s)| ((f - t) / s).abs()));
                }
                for frame in frames {
                    match estimate(&frame.seen) {
                        Some(sensed) => {
                            errors.extend(sensed.iter().zip(&frame.forces_n).map(|(f, t)| (f / t - 1.0).abs()))
                        }
                        None => failed += 1,
                    }
                }
                prepared.push((estimate, frames));
            }
            // Frames of one contact are consecutive, because a warm start requires this order.
            let frames = streams[0].1.len();
            let answer = |n: usize| {
                let (estimate, of_stream) = &mut prepared[n / frames % streams.len()];
                estimate(&of_stream[n % frames].seen).is_some()
            };
            let times = times(&mut group, BenchmarkId::new(id.name(), format!("{setting}, {start}")), answer);
            rows.push(Row {
                preparation_seconds: Some(quantile(&mut preparations, 0.5)),
                error: Some(errors.iter().sum::<f64>() / errors.len() as f64),
                bias_sigmas: biases.into_iter().reduce(f64::max),
                failed,
                asked: frames * streams.len(),
                ..row(task, id.name(), &setting, start, times)
            });
        }
        group.finish();
    }
    rows
}

/// A time with three significant digits.
fn time(seconds: f64) -> String {
    let (value, unit) = if seconds < 1e-3 { (1e6 * seconds, "\u{b5}s") } else { (1e3 * seconds, "ms") };
    format!("{value:.*} {unit}", (2.0 - value.log10().floor()).clamp(0.0, 3.0) as usize)
}

fn percent(share: f64) -> String {
    format!("{:.*} %", (1.0 - (100.0 * share).log10().floor()).max(0.0) as usize, 100.0 * share)
}

/// Model error over both tasks, in standard deviations of the noise, and the larger of the two errors, of the way that `one` senses one force.
/// `None` if a frame was refused.
fn over_both(rows: &[Row], one: &Row) -> Option<[f64; 2]> {
    let same = |row: &&Row| (&row.model, &row.setting, &row.start) == (&one.model, &one.setting, &one.start);
    let sensed = rows.iter().filter(same).filter(|row| row.task != "solve");
    sensed
        .map(|row| (row.failed == 0).then_some([row.bias_sigmas?, row.error?]))
        .try_fold([0.0; 2], |[bias, error], of| of.map(|[b, e]| [f64::max(bias, b), f64::max(error, e)]))
}

/// The fastest way that senses any contact, has a small model error, and nearly the smallest error. Networks sense only the contacts for which they
/// were trained.
fn recommended(rows: &[Row]) -> &Row {
    let any_contact =
        |row: &&Row| row.task == "sense-one" && row.start != "cold" && row.model != EstimatorId::Network.name();
    let holds = |row: &'_ Row| over_both(rows, row).filter(|[bias, _]| *bias <= LARGEST_BIAS_SIGMAS);
    let found: Vec<(&Row, f64)> =
        rows.iter().filter(any_contact).filter_map(|row| Some((row, holds(row)?[1]))).collect();
    let best = found.iter().map(|(_, error)| *error).reduce(f64::min).expect("a way of sensing");
    let near = found.into_iter().filter(|(_, error)| *error <= NEAR_BEST * best).map(|(row, _)| row);
    near.min_by(|a, b| a.seconds.total_cmp(&b.seconds)).expect("a way of sensing")
}

/// Records the sentences on times.
fn say(rows: &[Row]) {
    let of = |row: &Row| {
        let mesh = row.setting.replace(" nodes", " mesh nodes");
        format!("{} ({mesh}) in {}, error {}", row.model, time(row.seconds), percent(row.error.expect("an error")))
    };
    let solved = || rows.iter().filter(|row| row.task == "solve");
    let fastest =
        |rows: &mut dyn Iterator<Item = &Row>| of(rows.min_by(|a, b| a.seconds.total_cmp(&b.seconds)).expect("a row"));
    let nearest = solved().min_by(|a, b| a.error.partial_cmp(&b.error).expect("errors")).expect("a row");
    assert_said(
        "speed-error",
        "says",
        format!(
            "For the shape under {SOLVED_N} N, the fastest model with an error of at most {} is {}. The most accurate model is {}. The fastest model is {}.",
            percent(GOOD_SHAPE),
            fastest(&mut solved().filter(|row| row.error <= Some(GOOD_SHAPE))),
            of(nearest),
            fastest(&mut solved())
        ),
    );
    let way = recommended(rows);
    let cold = rows.iter().find(|row| {
        (&row.task, &row.model, &row.setting) == (&way.task, &way.model, &way.setting) && row.start == "cold"
    });
    let slowest = cold.and_then(|cold| cold.seconds_95).expect("a nonlinear estimator");
    assert_said(
        "speed-error",
        "says",
        format!(
            "To sense one force, the recommended estimator is {}; without a previous answer, 95 % take less than {}. The fastest estimator is {}.",
            of(way),
            time(slowest),
            fastest(&mut rows.iter().filter(|row| row.task == "sense-one"))
        ),
    );
    assert!(way.error < Some(TRUSTED_ERROR), "{way:?}");
}

fn speed_error(criterion: &mut Criterion) {
    let rows = [shapes(criterion), forces(criterion)].concat();
    if is_full_study() {
        say(&rows);
    }
    let near = |a: Option<f64>, b: Option<f64>, share: f64| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= share * b.abs() + 1e-9,
        (a, b) => a == b,
    };
    let same = |a: &Row, b: &Row| {
        let name = |row: &Row| [&row.task, &row.model, &row.setting, &row.start].map(String::clone);
        name(a) == name(b)
            && (a.failed, a.asked) == (b.failed, b.asked)
            && near(a.error, b.error, SAME)
            && near(a.bias_sigmas, b.bias_sigmas, 10.0 * SAME)
    };
    assert_recorded("speed_error.csv", |row: &Row| row.timed_by == "criterion", rows, same);
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    targets = speed_error
}
criterion_main!(benches);
