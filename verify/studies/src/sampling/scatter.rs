//! Sensing under camera noise: errors of each estimator against the Cramer-Rao bound, and coverage of its stated standard deviation.
//!
//! Random forces deform a true finger, and noise is added to its marker displacements. Each sensor knows the contact nodes and the directions
//! (undeformed normals), and uses no result of earlier cases. All sensors get the same forces and noise. Each error is divided by the Cramer-Rao
//! bound at the true forces of its case. For an unbiased estimator, the root mean square of these ratios is at least 1.

mod cases;

use crate::prelude::*;
use cases::Case;

/// Mean of |x| for x of a normal distribution with standard deviation 1: sqrt(2 / pi).
const MEAN_ABSOLUTE: f64 = 0.797_884_560_802_865_4;
/// Largest number of contact nodes that are sampled. On a finger with more contact nodes than this, only every second node is sampled, or an even
/// smaller share of the nodes.
const MOST_NODES: usize = 12;

/// Parameters of a study of errors under camera noise.
#[derive(Debug, Clone, Copy)]
pub struct ScatterRequest<'m> {
    /// Mesh of the true finger.
    pub truth: &'m Mesh,
    /// Kinematics of the true finger.
    pub kinematics: Kinematics,
    /// Mesh of the true finger on which the Cramer-Rao bound is computed.
    pub model: &'m Mesh,
    /// The scene that the sensors assume.
    pub scene: &'m PreparedScene,
    /// Standard deviations of a coordinate's noise, mm; 0 means no noise. All noise levels use the same forces and the same noise, scaled to the
    /// level.
    pub noise_levels_mm: &'m [f64],
    /// Number of random cases for each set of contacts.
    pub cases: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Errors of one quantity: a force, or the sum of all forces.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Scatter {
    /// Mean of |sensed / true - 1|, dimensionless; computed with the control variate of [`Controlled`], if every case has a bound.
    pub mean_error: f64,
    /// Mean of |sensed - true|, N.
    pub mean_error_n: f64,
    /// Errors relative to the Cramer-Rao bound. `None` if no case has a bound, or without noise, because the bound is then 0.
    #[serde(flatten)]
    pub bound: Option<AgainstBound>,
    /// Coverage of the stated standard deviations; `None` without noise.
    #[serde(flatten)]
    pub coverage: Option<Coverage>,
}

/// Errors relative to the Cramer-Rao bound at the true forces.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct AgainstBound {
    /// Mean of |sensed / true - 1| for an estimator that reaches the bound.
    pub mean_error_bound: f64,
    /// Root mean square of error / bound, dimensionless.
    pub over_bound: f64,
    /// Mean of error / bound, dimensionless.
    pub bias_over_bound: f64,
    /// Root mean square of error / bound with a control variate; `None` if fewer than two cases, or not all cases, have a bound.
    #[serde(flatten)]
    pub controlled: Option<Controlled>,
}

/// Root mean square of z = error / bound, with the first-order response to the same noise as control variate.
///
/// To first order the error is a linear function of the noise, and the bound is its standard deviation. The mean square of z1 = response / bound is
/// therefore 1 up to sampling error. z and z1 share most of this sampling error. So 1 + mean(z^2 - z1^2) has a much smaller standard error than
/// mean(z^2) over the same cases. |response| is the control variate for the mean of |error|: its mean is sqrt(2 / pi) times the bound.
///
/// Reference: control variates; e.g. Owen, Monte Carlo theory, methods and examples, ch. 8.9.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Controlled {
    /// sqrt(1 + mean(z^2 - z1^2)), dimensionless.
    pub over_bound_controlled: f64,
    /// Standard error of `over_bound_controlled`, dimensionless, from the variance of z^2 - z1^2 over the cases.
    pub standard_error: f64,
}

/// Coverage: shares of cases whose stated interval contains the true value.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Coverage {
    /// Share of cases whose true value is within one stated standard deviation; nominally 0.683.
    pub one_sigma: f64,
    /// Share of cases whose true value is within 1.96 stated standard deviations; nominally 0.95.
    pub two_sigma: f64,
}

/// Results of one estimator for one set of contact nodes and one level of noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScatterRow {
    /// The estimator.
    pub estimator: EstimatorId,
    /// The contact nodes.
    pub nodes: Vec<usize>,
    /// Standard deviation of a coordinate's noise, mm.
    pub noise_mm: f64,
    /// Number of answered cases, over which all means are taken.
    pub cases: usize,
    /// Number of draws that were repeated because the finger has no equilibrium under the drawn forces.
    pub not_carried: usize,
    /// Number of cases that the estimator refused. No mean includes refused cases. Reports therefore show the number of refused cases beside a mean,
    /// and a check fails if the number is not 0.
    pub refused: usize,
    /// Errors of each force, in the order of the nodes; empty if no case was answered.
    pub forces: Vec<Scatter>,
    /// Errors of the sum of the forces; `None` if no case was answered.
    pub sum: Option<Scatter>,
}

/// Numbers of drawn and refused cases, shown beside a mean over the answered cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    /// Number of cases with equilibrium.
    pub drawn: usize,
    /// Number of refused cases.
    pub refused: usize,
}

impl Counts {
    /// Counts of all rows together.
    pub fn of<'r>(rows: impl IntoIterator<Item = &'r ScatterRow>) -> Counts {
        let none = Counts { drawn: 0, refused: 0 };
        rows.into_iter()
            .fold(none, |sum, row| Counts { drawn: sum.drawn + row.drawn(), refused: sum.refused + row.refused })
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} cases, {} refused", self.drawn, self.refused)
    }
}

impl ScatterRow {
    /// Number of drawn cases: answered and refused.
    pub fn drawn(&self) -> usize {
        self.cases + self.refused
    }

    /// Whether more cases are needed: for some force or for the sum, |r - 1| plus two standard errors exceeds `tolerance`, where r is the root mean
    /// square of error / bound.
    pub fn is_near_tolerance(&self, tolerance: f64) -> bool {
        let mut figures = self.forces.iter().chain(&self.sum).filter_map(|scatter| scatter.bound?.controlled);
        figures.any(|found| (found.over_bound_controlled - 1.0).abs() + 2.0 * found.standard_error > tolerance)
    }

    /// Whether the mean relative error is within `limit` if each refused case counts as an error of 100 %.
    pub fn is_within(&self, limit: f64) -> bool {
        let drawn = self.drawn() as f64;
        let refused = self.refused as f64 / drawn;
        self.mean_error().is_some_and(|error| error * (1.0 - refused) + refused <= limit)
    }

    /// Mean relative error of all forces; `None` if no case was answered.
    pub fn mean_error(&self) -> Option<f64> {
        mean(self.forces.iter().map(|scatter| scatter.mean_error))
    }

    /// Mean absolute error of all forces, N; `None` if no case was answered.
    pub fn mean_error_n(&self) -> Option<f64> {
        mean(self.forces.iter().map(|scatter| scatter.mean_error_n))
    }

    /// Mean relative error of all forces for an estimator that reaches the bound; `None` without a bound.
    pub fn mean_error_bound(&self) -> Option<f64> {
        let bounds: Option<Vec<f64>> = self.forces.iter().map(|s| Some(s.bound?.mean_error_bound)).collect();
        mean(bounds?)
    }
}

/// Senses random forces, uniform in `range_n` (N), and returns one row for each set of contact nodes, noise level and sensor, in this order.
/// `progress` is called after each set. The results of a sensor do not depend on the number of threads or on the other sensors.
///
/// # Errors
/// [`Refusal`] if a node is no contact node, or an estimator does not support the contacts.
pub fn scatter(
    request: &ScatterRequest,
    sensors: &[SensorOptions],
    sets: &[Vec<NodeId>],
    range_n: [f64; 2],
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<ScatterRow>, Refusal> {
    let of_set = |(stream, nodes): (usize, &Vec<NodeId>)| {
        let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
        let cases = cases::cases(request, sensors, &contacts, range_n, stream as u64)?;
        progress();
        let mut rows = Vec::new();
        for (level, &noise_mm) in request.noise_levels_mm.iter().enumerate() {
            for (i, sensor) in sensors.iter().enumerate() {
                rows.push(row(sensor.estimator, nodes, noise_mm, &cases, [level, i]));
            }
        }
        Ok(rows)
    };
    let rows: Result<Vec<_>, Refusal> = sets.par_iter().enumerate().with_max_len(1).map(of_set).collect();
    Ok(rows?.into_iter().flatten().collect())
}

/// Every contact node, or an evenly spaced selection of at most 12.
pub fn sampled_nodes(finger: &Finger) -> Vec<NodeId> {
    let nodes = finger.contact_nodes();
    let every = nodes.len().div_ceil(MOST_NODES);
    nodes.step_by(every).collect()
}

/// One set per node.
pub fn singles(nodes: &[NodeId]) -> Vec<Vec<NodeId>> {
    nodes.iter().map(|&node| vec![node]).collect()
}

/// One set per pair of nodes.
pub fn pairs(nodes: &[NodeId]) -> Vec<Vec<NodeId>> {
    let from = |i: usize| nodes[i + 1..].iter().map(|&second| vec![nodes[i], second]).collect::<Vec<_>>();
    (0..nodes.len()).flat_map(from).collect()
}

/// Row of the sensor with index `number` at the noise level with index `level`.
fn row(
    estimator: EstimatorId,
    nodes: &[NodeId],
    noise_mm: f64,
    cases: &[Case],
    [level, number]: [usize; 2],
) -> ScatterRow {
    let mut forces = vec![Sums::default(); nodes.len()];
    let mut sum = Sums::default();
    let (mut answered, mut refused, mut not_carried) = (0, 0, 0);
    for case in cases {
        not_carried += case.not_carried;
        let Some(sensed) = &case.sensed[level][number] else {
            refused += 1;
            continue;
        };
        answered += 1;
        let bound = case.bound.as_ref().filter(|_| noise_mm > 0.0);
        let bounds_n = bound.map(|(bound, _)| bound.sigmas_n(noise_mm));
        for (i, (sums, found)) in forces.iter_mut().zip(&sensed.forces).enumerate() {
            let bound =
                bounds_n.as_ref().zip(bound).map(|(sigmas_n, (_, response))| [sigmas_n[i], noise_mm * response[i]]);
            sums.add(case.forces_n[i], found.force_n, found.sigma_n, bound);
        }
        let bound = bound.map(|(bound, response)| [bound.sum_sigma_n(noise_mm), noise_mm * response.sum()]);
        let [sensed_n, sigma_n] = sensed.sum();
        sum.add(case.forces_n.iter().sum(), sensed_n, sigma_n, bound);
    }
    let noisy = noise_mm > 0.0;
    ScatterRow {
        estimator,
        nodes: nodes.iter().map(|node| node.0).collect(),
        noise_mm,
        cases: answered,
        not_carried,
        refused,
        forces: forces.iter().filter_map(|sums| sums.mean(noisy)).collect(),
        sum: sum.mean(noisy),
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    cases: usize,
    error: f64,
    error_n: f64,
    /// Number of cases with a bound, over which the following sums run.
    bounded: usize,
    bound: f64,
    standardised: f64,
    squared: f64,
    /// Sum of |first-order response / true value|.
    response: f64,
    /// Sum of z^2 - z1^2 and of its square, with z and z1 of [`Controlled`].
    beyond: f64,
    beyond_squared: f64,
    one_sigma: usize,
    two_sigma: usize,
}

impl Sums {
    /// Adds a case, given by the true value, the sensed value with its stated standard deviation, and the bound with the first-order error due to the
    /// noise, all N.
    fn add(&mut self, truth: f64, sensed: f64, sigma: f64, bound: Option<[f64; 2]>) {
        let error = sensed - truth;
        self.cases += 1;
        self.error += (error / truth).abs();
        self.error_n += error.abs();
        if let Some([bound, first_order]) = bound {
            let beyond = (error / bound).powi(2) - (first_order / bound).powi(2);
            self.bounded += 1;
            self.bound += MEAN_ABSOLUTE * bound / truth;
            self.standardised += error / bound;
            self.squared += (error / bound).powi(2);
            self.response += (first_order / truth).abs();
            self.beyond += beyond;
            self.beyond_squared += beyond * beyond;
        }
        self.one_sigma += usize::from(error.abs() <= sigma);
        self.two_sigma += usize::from(error.abs() <= TWO_SIDED_95 * sigma);
    }

    fn controlled(&self) -> Controlled {
        let count = self.bounded as f64;
        let mean = self.beyond / count;
        let variance = (self.beyond_squared / count - mean * mean).max(0.0) / (count - 1.0);
        let root = (1.0 + mean).sqrt();
        Controlled { over_bound_controlled: root, standard_error: variance.sqrt() / (2.0 * root) }
    }

    /// Whether every case has a bound. A figure computed with the control variate from only some of the cases would be biased.
    fn is_controlled(&self) -> bool {
        self.bounded > 1 && self.bounded == self.cases
    }

    fn mean(&self, noisy: bool) -> Option<Scatter> {
        let over = |sum: f64, count: usize| sum / count as f64;
        let control = if self.is_controlled() { self.bound - self.response } else { 0.0 };
        (self.cases > 0).then(|| Scatter {
            mean_error: over(self.error + control, self.cases),
            mean_error_n: over(self.error_n, self.cases),
            bound: (self.bounded > 0).then(|| AgainstBound {
                mean_error_bound: over(self.bound, self.bounded),
                over_bound: over(self.squared, self.bounded).sqrt(),
                bias_over_bound: over(self.standardised, self.bounded),
                controlled: self.is_controlled().then(|| self.controlled()),
            }),
            coverage: noisy.then(|| Coverage {
                one_sigma: over(self.one_sigma as f64, self.cases),
                two_sigma: over(self.two_sigma as f64, self.cases),
            }),
        })
    }
}
