//! Coverage of stated intervals over positions, directions and forces, by finger and estimator.
//!
//! On the finger that equals the estimators' model, every cell has its own noise samples. Samples shared by several cells, as in maps, test coverage
//! poorly. On the finger with softer ends, the model's error dominates. The cells of this finger's maps are therefore counted, although they share
//! noise samples.

use super::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::map::{AccuracyMap, MapRequest};
use crate::sampling::noise::Noise;
use crate::sampling::sampled::{SampledForces, SampledSensor};
use crate::sampling::sweep::MapCell;
use crate::truths::{Truth, TruthId};
use finray_model::sensor::SensedForce;
use std::convert::Infallible;
use std::ops::Add;

/// Nominal coverage: probability that a normal variable lies within 1.96 standard deviations.
const NOMINAL: f64 = 0.95;
/// Tolerance of the coverage of answers without a warning. A coverage of 93 to 97 % means that a stated standard deviation is correct within 10 %.
const TOLERANCE: f64 = 0.02;
/// Allowance for sampling error in addition to the tolerance, in standard deviations of a share.
const CHANCE: f64 = 3.0;
/// On the paper's finger, at most this share of the samples plus one sample may be refused. Next to a limit load, about one sample in 10 000 is
/// refused.
const REFUSED: f64 = 0.001;
/// At most this share of samples may be refused on another finger, whose forces may be too small to sense. If more samples were refused, coverage
/// would remain untested.
const REFUSED_OF_ANOTHER: f64 = 0.5;
/// For answers with a warning, rms sigma may differ from the rms error by at most this factor. A larger sigma would cover the error but provide no
/// information.
const LARGEST_SIGMA: f64 = 3.0;
/// Type of true finger on which the coverage of stated intervals is checked. On a finger with softer ends the estimators' model is wrong, and the
/// estimators warn.
pub const TRUTH: TruthId = TruthId::Corotational;

/// Coverage of the intervals that one estimator states on one finger.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoverageRow {
    /// Type of the true finger.
    pub truth: TruthId,
    /// Estimator that states the intervals.
    pub estimator: EstimatorId,
    /// Standard deviation of the noise of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Number of contacts (pairs of position and direction).
    pub contacts: usize,
    /// Number of noise samples over all contacts and forces with an equilibrium.
    pub samples: usize,
    /// Number of samples that the estimator refused.
    pub refused: usize,
    /// Number of answers with a warning.
    pub warned: usize,
    /// Number of answers without a warning.
    pub without_warning: usize,
    /// Among answers without a warning: the share whose interval contains the true force; `None` without such answers.
    pub covered_without_warning: Option<f64>,
    /// Among answers with a warning: the share whose interval contains the true force; `None` without such answers.
    pub covered_with_warning: Option<f64>,
    /// For answers with a warning: rms error divided by rms stated sigma, dimensionless. `None` without such answers, or if the row counts a map's
    /// cells.
    pub error_over_sigma_with_warning: Option<f64>,
}

const SEED: u64 = 5;

impl Evidence for CoverageRow {
    fn checks(&self, context: &Context) -> Vec<Check> {
        self.checks(context.is_paper && context.forces == ReportForces::PAPER)
    }
}

/// Coverage on the co-rotational finger: over positions and directions, and for networks at the contact nodes. Includes maps of the finger with
/// softer ends, whose stiffness no estimator knows. Empty without noise.
pub fn run(context: &Context, maps: &[AccuracyMap]) -> Result<Vec<CoverageRow>, Infallible> {
    let &Context { finger, noise_mm, forces, effort, is_paper, .. } = context;
    if noise_mm == 0.0 {
        return Ok(Vec::new());
    }
    // With this grid, the paper's finger has 720 samples (quick) or 12 960 (full). A coverage of 95 % then has a standard deviation of 0.8 % (quick)
    // or 0.2 % (full).
    let (positions, step_deg, samples) = effort.choose((17, 40.0, 3), (60, 20.0, 6));
    let request = |(positions_mm, angles_deg), samples| MapRequest {
        positions_mm,
        angles_deg,
        forces_n: forces.of_maps_n().to_vec(),
        noise_levels_mm: vec![noise_mm],
        noise_samples: samples,
        seed: SEED,
    };
    let cells = request(MapRequest::grid(finger, positions, step_deg), samples);
    let nodes_mm = finger.contact_nodes().rev().filter_map(|node| finger.front_position_mm(node)).collect();
    let nodes = request((nodes_mm, vec![0.0]), effort.choose(20, 100));
    let node_contacts = usize::from(is_paper) * nodes.contact_count();
    context.progress.part("coverage", cells.contact_count() + node_contacts);
    let step = || context.progress.step();

    let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
    let sensors = EstimatorId::ALL.iter().map(|id| SampledSensor::new(*id, context.networks));
    let (at_nodes, everywhere): (Vec<_>, Vec<_>) = sensors.partition(|sensor| sensor.options.estimator.at_nodes());
    let truth = context.corotational;
    let mut rows = coverage(&scene, truth, &everywhere, (&cells, noise_mm), &step);
    if is_paper {
        rows.extend(coverage(&scene, truth, &at_nodes, (&nodes, noise_mm), &step));
        let softer = maps.iter().filter(|map| map.truth == TruthId::Twin && map.noise_mm > 0.0);
        rows.extend(softer.filter_map(of_map));
    }
    Ok(rows)
}

/// Coverage over the cells of a map; `None` if its estimator states no standard deviation.
fn of_map(map: &AccuracyMap) -> Option<CoverageRow> {
    let stated = |cell: &MapCell| Some([cell.warned?, cell.covered?, cell.covered_warned?]);
    map.cells.iter().find_map(stated)?;
    let counts = map.cells.iter().map(|cell| {
        // A cell in which every sample was refused has no interval.
        let [warned, covered, covered_warned] = stated(cell).unwrap_or_default();
        Counts {
            samples: cell.samples,
            refused: cell.samples - cell.answered,
            answers: [[cell.answered - warned, covered], [warned, covered_warned]],
            squares_n2: [0.0; 2],
        }
    });
    let counts = counts.fold(Counts::default(), Counts::add);
    let of = (map.truth, map.estimator, map.noise_mm, map.request.contact_count());
    Some(CoverageRow { error_over_sigma_with_warning: None, ..counts.row(of) })
}

#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    samples: usize,
    refused: usize,
    /// Counts for answers without a warning, then with a warning: number of answers, and number of answers whose interval contains the true force.
    answers: [[usize; 2]; 2],
    /// Sums over the answers with a warning: squared errors and squared stated standard deviations, N^2.
    squares_n2: [f64; 2],
}

impl Add for Counts {
    type Output = Counts;

    fn add(self, other: Counts) -> Counts {
        let [plain, warned] = [0, 1].map(|k| [0, 1].map(|i| self.answers[k][i] + other.answers[k][i]));
        Counts {
            samples: self.samples + other.samples,
            refused: self.refused + other.refused,
            answers: [plain, warned],
            squares_n2: [0, 1].map(|i| self.squares_n2[i] + other.squares_n2[i]),
        }
    }
}

/// Senses every contact and force of a grid by each sensor. Each contact and force has independent noise samples, as many as the grid requests.
/// Returns one row per sensor. `progress` is called after each contact. The result does not depend on the number of threads.
pub fn coverage(
    scene: &PreparedScene,
    truth: &dyn Truth,
    sensors: &[SampledSensor],
    (grid, noise_mm): (&MapRequest, f64),
    progress: &(dyn Fn() + Sync),
) -> Vec<CoverageRow> {
    let of_contact = |number: usize| {
        let contact = grid.contact(number);
        let shapes = truth.shapes(&contact, &grid.forces_n);
        let sensors: Vec<_> = sensors.iter().map(|sensor| sensor.at(scene, contact)).collect();
        let mut counts = vec![Counts::default(); sensors.len()];
        let mut noise = Noise::of_stream(grid.seed, number as u64);
        for (shape, &force_n) in shapes.iter().zip(&grid.forces_n) {
            let seen = Measurement::of_shape(&scene.finger, shape);
            let samples: Vec<_> = (0..grid.noise_samples).map(|_| noise.on(&seen, noise_mm)).collect();
            for (counts, sensors) in counts.iter_mut().zip(&sensors) {
                let sampled = sensors.as_ref().ok().and_then(|sensors| sensors.first());
                let sampled = sampled.map(|sensor| SampledForces::new(sensor, &seen, noise_mm, samples.len()));
                samples.iter().for_each(|sample| counts.sense(sampled.as_ref(), sample, force_n));
            }
        }
        progress();
        counts
    };
    let contacts: Vec<Vec<Counts>> = (0..grid.contact_count()).into_par_iter().map(of_contact).collect();
    let row = |(i, sensor): (usize, &SampledSensor)| {
        let counts = contacts.iter().map(|counts| counts[i]).fold(Counts::default(), Counts::add);
        counts.row((truth.id(), sensor.options.estimator, noise_mm, grid.contact_count()))
    };
    sensors.iter().enumerate().map(row).collect()
}

impl Counts {
    /// Converts the counts into shares for a finger, an estimator, a noise level (mm) and a number of contacts.
    fn row(self, (truth, estimator, noise_mm, contacts): (TruthId, EstimatorId, f64, usize)) -> CoverageRow {
        let share = |[answers, covered]: [usize; 2]| (answers > 0).then(|| covered as f64 / answers as f64);
        let [plain, warned] = self.answers;
        CoverageRow {
            truth,
            estimator,
            noise_mm,
            contacts,
            samples: self.samples,
            refused: self.refused,
            warned: warned[0],
            without_warning: plain[0],
            covered_without_warning: share(plain),
            covered_with_warning: share(warned),
            error_over_sigma_with_warning: (warned[0] > 0).then(|| (self.squares_n2[0] / self.squares_n2[1]).sqrt()),
        }
    }

    /// Adds one sample. The sample counts as refused if the estimator does not support the contact.
    fn sense(&mut self, sensor: Option<&SampledForces>, sample: &Measurement, force_n: f64) {
        self.samples += 1;
        let Some(sensed) = sensor.and_then(|sensor| sensor.sense(sample).ok()) else {
            self.refused += 1;
            return;
        };
        let SensedForce { force_n: sensed_n, sigma_n, .. } = sensed.forces[0];
        let is_warned = !sensed.warnings.is_empty();
        let [answers, covered] = &mut self.answers[usize::from(is_warned)];
        *answers += 1;
        let error_n = sensed_n - force_n;
        *covered += usize::from(error_n.abs() <= TWO_SIDED_95 * sigma_n);
        if is_warned {
            for (sum, figure) in self.squares_n2.iter_mut().zip([error_n, sigma_n]) {
                *sum += figure * figure;
            }
        }
    }
}

impl CoverageRow {
    /// Share of all samples answered without a warning.
    pub fn share_without_warning(&self) -> f64 {
        self.without_warning as f64 / self.samples.max(1) as f64
    }

    /// Checks on the finger that equals the estimators' model. Few samples are refused. Up to sampling error, coverage is 93 to 97 % without a
    /// warning, and at least 93 % with a warning. With a warning, rms sigma and rms error differ by at most the factor `LARGEST_SIGMA`, up to sampling error.
    pub fn checks(&self, is_paper: bool) -> Vec<Check> {
        if self.truth != TRUTH {
            return Vec::new();
        }
        let new = |quantity: String, reference: f64, ours: f64, tolerance: f64| {
            let problem = format!(
                "stated intervals of {} at {} positions and directions, {} mm noise",
                self.estimator, self.contacts, self.noise_mm
            );
            Check::new(Kind::Internal, problem, "true forces", quantity, reference, ours, tolerance)
        };
        let answered = new(
            format!("share of {} samples that is refused", self.samples),
            0.0,
            self.refused as f64 / self.samples as f64,
            if is_paper { REFUSED + 1.0 / self.samples as f64 } else { REFUSED_OF_ANOTHER },
        );
        let check = |which: &str, covered: f64, answers: usize, reference: f64, tolerance: f64| {
            let chance = CHANCE * (NOMINAL * (1.0 - NOMINAL) / answers as f64).sqrt();
            let quantity = format!(
                "share within 1.96 sigma of the true force, among {answers} answers (of {}) {which}",
                self.samples - self.refused
            );
            new(quantity, reference, covered, tolerance + chance)
        };
        let plain = self
            .covered_without_warning
            .map(|covered| check("without a warning", covered, self.without_warning, NOMINAL, TOLERANCE));
        // The check states the interval from 93 to 100 % by its middle, the reference, and its half width, the tolerance.
        let least = NOMINAL - TOLERANCE;
        let warned = self
            .covered_with_warning
            .map(|covered| check("with a warning", covered, self.warned, 0.5 * (1.0 + least), 0.5 * (1.0 - least)));
        // The rms of n independent normal errors has a relative standard deviation of 1 / sqrt(2 n).
        let chance = 1.0 + CHANCE / (2.0 * self.warned as f64).sqrt();
        // A logarithm, because an upper limit of sigma would pass a sigma of 0.
        let sharp = self.error_over_sigma_with_warning.map(|share| {
            let quantity = "ln(rms sigma / rms error of answers with a warning)".to_owned();
            new(quantity, 0.0, -share.ln(), (LARGEST_SIGMA * chance).ln())
        });
        std::iter::once(answered).chain(plain).chain(warned).chain(sharp).collect()
    }
}
