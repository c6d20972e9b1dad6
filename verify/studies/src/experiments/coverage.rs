//! Coverage of stated intervals over positions, directions and forces, by finger and estimator.
//!
//! On the finger that equals the estimators' model, every cell has its own noise samples. Samples shared by several cells, as in maps, test coverage
//! poorly. On the finger with softer ends, the model's error dominates. The cells of this finger's maps are therefore counted, although they share
//! noise samples.

use super::{Context, Evidence};
use crate::prelude::*;
use crate::sampling::intervals::IntervalCounts;
use crate::sampling::map::{AccuracyMap, MapRequest};
use crate::sampling::noise::Noise;
use crate::sampling::sampled::{SampledForces, SampledSensor};
use crate::sampling::situation::{ContactKnowledge, HiddenMarkers, Situation};
use crate::sampling::sweep::MapCell;
use crate::truths::{Truth, TruthId};
use std::convert::Infallible;
use std::ops::Add;

/// Nominal coverage: probability that a normal variable lies within 1.96 standard deviations.
const NOMINAL: f64 = 0.95;
/// Tolerance of the coverage of answers without a warning. A coverage of 93 to 97 % means that a stated standard deviation is correct within 10 %.
const TOLERANCE: f64 = 0.02;
/// Allowance for sampling error in addition to the tolerance, in standard deviations of a share at the limit of the tolerance. From 292 answers on, a
/// coverage of 100 % without a warning fails.
const CHANCE: f64 = 3.0;
/// The coverage of fewer answers is not checked. With 30 answers the lower limit is 79 %; with 10 answers it is 69 %, and a standard deviation that is
/// half as large as it should be (coverage of 67 %) would pass in about every second case.
const FEWEST_ANSWERS: usize = 30;
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
    /// What the estimator knows of the contact.
    pub contact: ContactKnowledge,
    /// Hidden markers.
    pub hidden: HiddenMarkers,
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
/// softer ends, whose stiffness no estimator knows, and maps of contacts that are not known exactly. Empty without noise.
pub fn run(
    context: &Context,
    maps: &[AccuracyMap],
    situations: &[AccuracyMap],
) -> Result<Vec<CoverageRow>, Infallible> {
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
        is_leaning: false,
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
    // With a misjudged contact, intervals are not expected to hold. A known range of friction is a prior, whose ends would count too much on a grid;
    // the test of situations draws directions from the range instead.
    let is_asked =
        |map: &&AccuracyMap| map.situation.contact.is_leaning() && map.situation.contact != ContactKnowledge::Friction;
    rows.extend(situations.iter().filter(is_asked).filter_map(of_map));
    Ok(rows)
}

/// Counts of a map's cell, which lacks the squares. A cell in which every sample was refused has no intervals.
fn counts_of_cell(cell: &MapCell) -> IntervalCounts {
    let [warned, covered, covered_warned] =
        [cell.warned, cell.covered, cell.covered_warned].map(Option::unwrap_or_default);
    let answers = [[cell.answered - warned, covered], [warned, covered_warned]];
    IntervalCounts { samples: cell.samples, answers, warned_squares_n2: [0.0; 2] }
}

/// Coverage over the cells of a map; `None` if its estimator answers no sample.
fn of_map(map: &AccuracyMap) -> Option<CoverageRow> {
    let counts = map.cells.iter().map(counts_of_cell).fold(IntervalCounts::default(), Add::add);
    let of = (map.truth, map.estimator, map.situation, map.noise_mm, map.request.contact_count());
    (counts.answered() > 0).then(|| CoverageRow { error_over_sigma_with_warning: None, ..CoverageRow::of(&counts, of) })
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
        let mut counts = vec![IntervalCounts::default(); sensors.len()];
        let mut noise = Noise::of_stream(grid.seed, number as u64);
        for (shape, &force_n) in shapes.iter().zip(&grid.forces_n) {
            let seen = Measurement::of_shape(&scene.finger, shape);
            let samples: Vec<_> = (0..grid.noise_samples).map(|_| noise.on(&seen, noise_mm)).collect();
            for (counts, sensors) in counts.iter_mut().zip(&sensors) {
                let sampled = sensors.as_ref().ok().and_then(|sensors| sensors.first());
                let sampled = sampled.map(|sensor| SampledForces::new(sensor, &seen, noise_mm, samples.len()));
                for sample in &samples {
                    let sensed = sampled.as_ref().and_then(|sampled| sampled.sense(sample).ok());
                    let is_warned = sensed.as_ref().is_some_and(|sensed| !sensed.warnings.is_empty());
                    counts.count(sensed.as_ref().map(|sensed| &sensed.forces[0]), is_warned, force_n);
                }
            }
        }
        progress();
        counts
    };
    let contacts: Vec<Vec<IntervalCounts>> = (0..grid.contact_count()).into_par_iter().map(of_contact).collect();
    let row = |(i, sensor): (usize, &SampledSensor)| {
        let counts = contacts.iter().map(|counts| counts[i]).fold(IntervalCounts::default(), Add::add);
        let of = (truth.id(), sensor.options.estimator, sensor.situation, noise_mm, grid.contact_count());
        CoverageRow::of(&counts, of)
    };
    sensors.iter().enumerate().map(row).collect()
}

impl CoverageRow {
    /// Shares of some counts, for a finger, an estimator, a situation, a noise level (mm) and a number of contacts.
    fn of(
        counts: &IntervalCounts,
        (truth, estimator, situation, noise_mm, contacts): (TruthId, EstimatorId, Situation, f64, usize),
    ) -> CoverageRow {
        let share = |[answers, covered]: [usize; 2]| (answers > 0).then(|| covered as f64 / answers as f64);
        let ([plain, warned], [error_n2, sigma_n2]) = (counts.answers, counts.warned_squares_n2);
        CoverageRow {
            truth,
            estimator,
            contact: situation.contact,
            hidden: situation.hidden,
            noise_mm,
            contacts,
            samples: counts.samples,
            refused: counts.samples - counts.answered(),
            warned: warned[0],
            without_warning: plain[0],
            covered_without_warning: share(plain),
            covered_with_warning: share(warned),
            error_over_sigma_with_warning: (warned[0] > 0).then(|| (error_n2 / sigma_n2).sqrt()),
        }
    }

    /// What the sensor knows and sees.
    pub fn situation(&self) -> Situation {
        Situation { contact: self.contact, hidden: self.hidden }
    }

    /// Share of all samples answered without a warning.
    pub fn share_without_warning(&self) -> f64 {
        self.without_warning as f64 / self.samples.max(1) as f64
    }

    /// Checks on the finger that equals the estimators' model. Few samples of known contacts are refused. Up to sampling error, coverage is 93 to 97 % without a
    /// warning, and at least 93 % with a warning. With a warning, rms sigma and rms error differ by at most the factor `LARGEST_SIGMA`, up to sampling error.
    /// Returns no check of coverage for few answers.
    pub fn checks(&self, is_paper: bool) -> Vec<Check> {
        if self.truth != TRUTH {
            return Vec::new();
        }
        let new = |quantity: String, reference: f64, ours: f64, tolerance: f64| {
            let problem = format!(
                "stated intervals of {} at {} positions and directions, {}, {} mm noise",
                self.estimator,
                self.contacts,
                self.situation(),
                self.noise_mm
            );
            Check::new(Kind::Internal, problem, "true forces", quantity, reference, ours, tolerance)
        };
        let answered = new(
            format!("share of {} samples that is refused", self.samples),
            0.0,
            self.refused as f64 / self.samples as f64,
            if is_paper { REFUSED + 1.0 / self.samples as f64 } else { REFUSED_OF_ANOTHER },
        );
        let check = |which: &str, covered: f64, answers: usize, [least, most]: [f64; 2]| {
            let chance = |share: f64| CHANCE * (share * (1.0 - share) / answers as f64).sqrt();
            let quantity = format!(
                "share within 1.96 sigma of the true force, among {answers} answers (of {}) {which}",
                self.samples - self.refused
            );
            // The check states the interval by its middle, the reference, and its half width, the tolerance.
            let [least, most] = [least - chance(least), most + chance(most)];
            new(quantity, 0.5 * (least + most), covered, 0.5 * (most - least))
        };
        let [least, most] = [NOMINAL - TOLERANCE, NOMINAL + TOLERANCE];
        let plain = self.covered_without_warning.filter(|_| self.without_warning >= FEWEST_ANSWERS);
        let plain = plain.map(|covered| check("without a warning", covered, self.without_warning, [least, most]));
        let are_enough = self.warned >= FEWEST_ANSWERS;
        let warned = self.covered_with_warning.filter(|_| are_enough);
        let warned = warned.map(|covered| check("with a warning", covered, self.warned, [least, 1.0]));
        // The rms of n independent normal errors has a relative standard deviation of 1 / sqrt(2 n).
        let chance = 1.0 + CHANCE / (2.0 * self.warned as f64).sqrt();
        // A logarithm, because an upper limit of sigma would pass a sigma of 0.
        let sharp = self.error_over_sigma_with_warning.filter(|_| are_enough).map(|share| {
            let quantity = "ln(rms sigma / rms error of answers with a warning)".to_owned();
            new(quantity, 0.0, -share.ln(), (LARGEST_SIGMA * chance).ln())
        });
        // Unknown contacts that the markers do not determine are refused, as they should be.
        let answered = (!self.contact.is_leaning()).then_some(answered);
        answered.into_iter().chain(plain).chain(warned).chain(sharp).collect()
    }
}
