//! The paper's tests of grasping forces (section V-C, Figs. 9 to 11, Table II): a finger closes on fixed force sensors.
//!
//! A sensor module has a cap in front of each finger node that it measures; all caps lie in one plane along the gripper. The motor moves the finger's
//! base by eqs (6) to (9). When the rod of a node meets its cap, the cap pushes back along the sensor's axis, across the gripper, without friction.
//! The paper treats the sensor's axis as the known direction of the force. The finger is the co-rotational frame. The other finger deforms as the
//! mirror image of this finger, so only one finger is solved. Forces are sensed from displacements relative to the undeformed finger at the motor
//! angle, with camera noise.

mod closing;

pub use closing::{ClosedStep, closing};

use crate::experiments::table_two::{ContactGroup, FORCES_N, GroupErrors, contact_sets};
use crate::experiments::{Context, Evidence, ExperimentError};
use crate::prelude::*;
use crate::sampling::noise::Noise;

/// Number of noise samples per step.
const SAMPLES: usize = 4;
const SEED: u64 = 1;

/// Results of all tests with sensor modules.
#[derive(Debug, Clone, PartialEq)]
pub struct ModuleStudy {
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// One test for each of [`contact_sets`].
    pub tests: Vec<ModuleTest>,
}

/// Results of a finger that closes on one sensor module.
#[derive(Debug, Clone, PartialEq)]
pub struct ModuleTest {
    /// Nodes of the module.
    pub nodes: &'static [usize],
    /// Steps at rest with a force on at least one node, up to the largest force of the paper's range.
    pub steps: Vec<ModuleStep>,
}

/// Equilibrium of the finger after one step of the motor, with the sensed forces.
#[derive(Debug, Clone, PartialEq)]
pub struct ModuleStep {
    /// Motor angle by which the gripper has closed, degrees.
    pub turned_deg: f64,
    /// Direction of the sensors' axis, degrees from the plate's undeformed inward normal, positive towards the tip.
    pub axis_deg: f64,
    /// True force on each node along the sensors' axis, N.
    pub true_n: Vec<f64>,
    /// Sensed forces of each estimator, N, by noise sample; `None` for a refused sample.
    pub sensed_n: Vec<(EstimatorId, Vec<Option<Vec<f64>>>)>,
}

impl ModuleStep {
    /// Sensed forces of an estimator, N, by noise sample; `None` for a refused sample.
    pub fn of(&self, estimator: EstimatorId) -> &[Option<Vec<f64>>] {
        self.sensed_n.iter().find(|(id, _)| *id == estimator).map_or(&[], |(_, samples)| samples)
    }
}

/// Forces sensed at nodes without contact, while another node of the module is pressed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Untouched {
    /// Number of sensed forces.
    pub count: usize,
    /// Number of sensed forces whose absolute value is within their bound.
    pub within: usize,
    /// Largest absolute sensed force, N.
    pub largest_n: f64,
}

impl Untouched {
    /// Adds a force (N) sensed at a node without contact, with its bound (N).
    pub fn add(&mut self, sensed_n: f64, bound_n: f64) {
        self.count += 1;
        self.within += usize::from(sensed_n.abs() <= bound_n);
        self.largest_n = self.largest_n.max(sensed_n.abs());
    }
}

/// Whether a force (N) is in the range over which the paper averages.
fn counts(force_n: f64) -> bool {
    (FORCES_N[0]..=FORCES_N[1]).contains(&force_n)
}

impl ModuleTest {
    /// Errors over forces in the paper's range: mean relative error of each force, mean error of each force in N, mean relative error of the sum. Also
    /// counts answered and refused samples.
    fn errors(&self, estimator: EstimatorId) -> Option<([f64; 3], [usize; 2])> {
        let (mut each, mut each_n, mut sums, mut counted) = (Vec::new(), Vec::new(), Vec::new(), [0, 0]);
        for step in &self.steps {
            let sum_n: f64 = step.true_n.iter().sum();
            if !step.true_n.iter().any(|force_n| counts(*force_n)) {
                continue;
            }
            for sample in step.of(estimator) {
                counted[usize::from(sample.is_none())] += 1;
                let Some(sensed_n) = sample else { continue };
                for (true_n, sensed_n) in step.true_n.iter().zip(sensed_n).filter(|(true_n, _)| counts(**true_n)) {
                    each.push((sensed_n / true_n - 1.0).abs());
                    each_n.push((sensed_n - true_n).abs());
                }
                sums.push((sensed_n.iter().sum::<f64>() / sum_n - 1.0).abs());
            }
        }
        let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
        (!each.is_empty()).then(|| ([mean(&each), mean(&each_n), mean(&sums)], counted))
    }

    /// Adds the forces sensed at nodes without contact to `into`, each with the bound `bound_n` (N).
    pub fn untouched(&self, estimator: EstimatorId, bound_n: f64, into: &mut Untouched) {
        for step in &self.steps {
            for sensed_n in step.of(estimator).iter().flatten() {
                let free = step.true_n.iter().zip(sensed_n).filter(|(true_n, _)| **true_n == 0.0);
                free.for_each(|(_, sensed_n)| into.add(*sensed_n, bound_n));
            }
        }
    }
}

impl ModuleStudy {
    /// Errors of an estimator for one row of Table II: means over the tests of the row, as in the paper's table.
    pub fn group(&self, group: &ContactGroup, estimator: EstimatorId) -> Option<GroupErrors> {
        let of_set = |nodes: &&[usize]| self.tests.iter().find(|test| test.nodes == *nodes)?.errors(estimator);
        let sets: Vec<_> = group.sets.iter().map(of_set).collect::<Option<_>>()?;
        let mean = |i: usize| sets.iter().map(|(errors, _)| errors[i]).sum::<f64>() / sets.len() as f64;
        let count = |i: usize| sets.iter().map(|(_, counted)| counted[i]).sum();
        Some(GroupErrors {
            force: mean(0),
            force_n: mean(1),
            sum: group.paper_sum.map(|_| mean(2)),
            force_bound: None,
            sum_bound: None,
            answered: count(0),
            refused: count(1),
        })
    }

    /// The test of the module at these nodes; `None` if no test has such a module.
    pub fn test(&self, nodes: &[usize]) -> Option<&ModuleTest> {
        self.tests.iter().find(|test| test.nodes == nodes)
    }
}

impl Evidence for ModuleStudy {}

/// Runs all tests with the paper's finger under noise; `None` for another finger, without noise, or in a quick study.
pub(crate) fn run(context: &Context) -> Result<Option<ModuleStudy>, ExperimentError> {
    if !context.is_paper || context.effort == Effort::Quick || context.noise_mm == 0.0 {
        return Ok(None);
    }
    let scene = Scene::from_toml(finray_fixtures::GRASPED_DISC_SCENE)?;
    let Some(gripper) = scene.gripper else { return Ok(None) };
    let sets = contact_sets();
    context.progress.part("sensor modules", sets.len());
    let scene = PreparedScene::from(Scene::of_finger(context.finger.clone()));
    let sensors = [EstimatorId::LeastSquares, EstimatorId::Nonlinear, EstimatorId::Network]
        .map(|estimator| SensorOptions { networks: context.networks.clone(), ..SensorOptions::of(estimator) });
    let test = |(i, nodes): (usize, &'static [usize])| {
        let mut noise = Noise::of_stream(SEED, i as u64);
        let steps = closing(context.fine, &gripper, nodes)?.into_iter().map(|step| {
            let samples: Vec<Measurement> =
                (0..SAMPLES).map(|_| noise.on(&step.displacements, context.noise_mm)).collect();
            let sensed_n = sensors.each_ref().map(|options| {
                let sensed = sense((&scene, options), nodes, step.axis_deg, &samples, context.noise_mm)?;
                Ok::<_, Refusal>((options.estimator, sensed))
            });
            let sensed_n = sensed_n.into_iter().collect::<Result<_, _>>()?;
            let ClosedStep { turned_deg, axis_deg, true_n, .. } = step;
            Ok(ModuleStep { turned_deg, axis_deg, true_n, sensed_n })
        });
        let steps = steps.collect::<Result<_, ExperimentError>>()?;
        context.progress.step();
        Ok(ModuleTest { nodes, steps })
    };
    let sets: Vec<_> = sets.into_iter().enumerate().collect();
    let tests = sets.into_par_iter().map(test).collect::<Result<_, ExperimentError>>()?;
    Ok(Some(ModuleStudy { noise_mm: context.noise_mm, tests }))
}

/// Senses every sample along the sensors' axis. Networks support only the normal, so they assume the normal instead, as the paper's network does.
fn sense(
    (scene, options): (&PreparedScene, &SensorOptions),
    nodes: &[usize],
    axis_deg: f64,
    samples: &[Measurement],
    noise_mm: f64,
) -> Result<Vec<Option<Vec<f64>>>, Refusal> {
    let angle_deg = if options.estimator.at_nodes() { 0.0 } else { axis_deg };
    let at = |node: &usize| Contact { position: ContactPosition::Node(NodeId(*node)), angle_deg };
    let contacts: Vec<Contact> = nodes.iter().map(at).collect();
    let sensor = Sensor::new(scene.clone(), SensorContacts::known(&contacts), options.clone())?;
    let sense = |seen| {
        let sensed = sensor.sense_displacements(seen, Some(noise_mm), None).ok()?;
        Some(sensed.forces.iter().map(|sensed| sensed.force_n).collect())
    };
    Ok(samples.iter().map(sense).collect())
}
