//! Distribution of forces over an unknown position: mixtures of normal distributions along the valleys of the misfit.

use super::CURVED;
use crate::sensing::{Alternative, SensingError, TWO_SIDED_95};
use statrs::distribution::{ContinuousCDF, Normal};

/// Number of points between neighbouring positions of the profile, by interpolation.
const BETWEEN: usize = 8;
/// Ranges of positions are alternatives if the central intervals of this probability of their forces do not overlap.
const APART: f64 = 0.998;
/// Probability of a wide interval, and half the width of this interval of a normal distribution, in standard deviations.
const WIDE: f64 = 0.999;
const TWO_SIDED_WIDE: f64 = 3.29;

/// Forces that explain a measurement best with the contact at one position.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ForcesAt {
    pub s_mm: f64,
    /// Forces and their standard deviations at this position, N.
    pub forces_n: Vec<f64>,
    pub sigmas_n: Vec<f64>,
    /// Direction of the force at the contact, and its standard deviation at this position, degrees.
    pub angle_deg: f64,
    pub angle_sd_deg: f64,
    /// Growth of the misfit from the smallest misfit, in noise variances.
    pub growth: f64,
}

impl ForcesAt {
    /// Forces at the share `t` of the way to another position. Along a valley, the square root of the growth is nearly linear.
    fn towards(&self, other: &ForcesAt, t: f64) -> ForcesAt {
        let between = |a: f64, b: f64| a + t * (b - a);
        let all = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| between(*a, *b)).collect();
        ForcesAt {
            s_mm: between(self.s_mm, other.s_mm),
            forces_n: all(&self.forces_n, &other.forces_n),
            sigmas_n: all(&self.sigmas_n, &other.sigmas_n),
            angle_deg: between(self.angle_deg, other.angle_deg),
            angle_sd_deg: between(self.angle_sd_deg, other.angle_sd_deg),
            growth: between(self.growth.max(0.0).sqrt(), other.growth.max(0.0).sqrt()).powi(2),
        }
    }
}

/// Weight, mean and standard deviation of one normal distribution of a mixture.
pub(super) type Component = (f64, f64, f64);

/// Value below which the mixture lies with a probability.
pub(super) fn quantile(mixture: &[Component], probability: f64) -> f64 {
    const HALVINGS: usize = 50;
    let normal = Normal::standard();
    let whole: f64 = mixture.iter().map(|(weight, ..)| weight).sum();
    let reach = |sign: f64| mixture.iter().map(move |(_, mean, sd)| mean + sign * 10.0 * sd);
    let mut from = reach(-1.0).fold(f64::INFINITY, f64::min);
    let mut to = reach(1.0).fold(f64::NEG_INFINITY, f64::max);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        let below = |&(weight, mean, sd): &Component| match sd > 0.0 {
            true => weight * normal.cdf((middle - mean) / sd),
            false => weight * f64::from(mean <= middle),
        };
        match mixture.iter().map(below).sum::<f64>() < probability * whole {
            true => from = middle,
            false => to = middle,
        }
    }
    0.5 * (from + to)
}

/// Central interval of a probability.
pub(super) fn interval(mixture: &[Component], probability: f64) -> [f64; 2] {
    [0.5 - 0.5 * probability, 0.5 + 0.5 * probability].map(|below| quantile(mixture, below))
}

/// Forces over all positions that explain a measurement: one list for each connected range, in ascending order of the positions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PositionProfile {
    pub contact: usize,
    /// Whether hidden markers may leave the position weakly determined.
    pub is_weak: bool,
    pub ranges: Vec<Vec<ForcesAt>>,
}

impl PositionProfile {
    /// Whether a range contains the position and the forces of a minimum.
    pub fn contains(&self, s_mm: f64, forces_n: &[f64]) -> bool {
        self.ranges.iter().any(|range| at(range, s_mm).is_some_and(|found| is_same(&found, forces_n)))
    }

    /// Mixture of the distributions of a quantity over one or all ranges, each weighted by the likelihood and the length of plate for which it stands.
    /// `of` returns mean and standard deviation at a point that stands for a length of plate, mm.
    pub fn mixture(ranges: &[Vec<ForcesAt>], of: impl Fn(&ForcesAt, f64) -> (f64, f64)) -> Vec<Component> {
        let pieces = ranges.iter().flat_map(|range| range.windows(2));
        let parts = pieces.flat_map(|ends| {
            (0..BETWEEN).map(move |i| {
                let length_mm = (ends[1].s_mm - ends[0].s_mm) / BETWEEN as f64;
                (length_mm, ends[0].towards(&ends[1], (i as f64 + 0.5) / BETWEEN as f64))
            })
        });
        let component = |(length_mm, point): (f64, ForcesAt)| {
            let (mean, sd) = of(&point, length_mm);
            (length_mm * (-0.5 * point.growth).exp(), mean, sd)
        };
        parts.map(component).collect()
    }

    pub fn force(ranges: &[Vec<ForcesAt>], j: usize) -> Vec<Component> {
        PositionProfile::mixture(ranges, |point, _| (point.forces_n[j], point.sigmas_n[j]))
    }

    pub fn position(ranges: &[Vec<ForcesAt>]) -> Vec<Component> {
        // A uniform distribution over the length of plate has this standard deviation.
        PositionProfile::mixture(ranges, |point, length_mm| (point.s_mm, length_mm / 12.0_f64.sqrt()))
    }

    /// The answer in each range, the best first.
    pub fn alternatives(&self) -> Vec<Alternative> {
        let answer = |range: &Vec<ForcesAt>| {
            let best = range.iter().min_by(|a, b| a.growth.total_cmp(&b.growth))?;
            let range = std::slice::from_ref(range);
            Some(Alternative {
                contact: self.contact,
                position_mm: best.s_mm,
                position_interval_mm: interval(&PositionProfile::position(range), 0.95),
                angle_deg: best.angle_deg,
                force_n: best.forces_n[self.contact],
                interval_n: interval(&PositionProfile::force(range, self.contact), 0.95),
                excess: best.growth,
            })
        };
        let mut answers: Vec<Alternative> = self.ranges.iter().filter_map(answer).collect();
        answers.sort_by(|a, b| a.excess.total_cmp(&b.excess));
        let least = answers.first().map_or(0.0, |best| best.excess);
        answers.iter_mut().for_each(|answer| answer.excess -= least);
        answers
    }

    /// Point with the smallest misfit.
    pub fn best(&self) -> Option<&ForcesAt> {
        self.ranges.iter().flatten().min_by(|a, b| a.growth.total_cmp(&b.growth))
    }

    /// Refuses two ranges with different forces, and a force whose interval is wider than `widest` times the force because its position is uncertain: it
    /// is then also more than [`CURVED`] times as wide as the interval of the standard deviation `certain_n`, N. A weak force is answered if the noise
    /// alone makes it uncertain.
    ///
    /// # Errors
    /// [`SensingError`] that names the ranges.
    pub fn require_determined(&self, certain_n: f64, widest: f64) -> Result<(), SensingError> {
        let (i, contact) = (self.contact, self.contact + 1);
        let intervals_n: Vec<[f64; 2]> =
            (0..self.ranges.len()).map(|k| interval(&PositionProfile::force(&self.ranges[k..=k], i), APART)).collect();
        let is_apart = |k: &usize| intervals_n[*k][0] > intervals_n[0][1] || intervals_n[*k][1] < intervals_n[0][0];
        if let Some(k) = (1..self.ranges.len()).find(is_apart) {
            let ends_mm = |range: &[ForcesAt]| [range[0].s_mm, range[range.len() - 1].s_mm];
            return Err(SensingError::TwoRanges {
                contact,
                forces_n: [intervals_n[0], intervals_n[k]],
                positions_mm: Box::new([ends_mm(&self.ranges[0]), ends_mm(&self.ranges[k])]),
                alternatives: self.alternatives(),
            });
        }
        let force_n = interval(&PositionProfile::force(&self.ranges, i), 0.95);
        let position_mm = interval(&PositionProfile::position(&self.ranges), 0.95);
        let Some(best) = self.best() else { return Ok(()) };
        let widest_n = (widest * best.forces_n[i].abs()).max(2.0 * CURVED * TWO_SIDED_95 * certain_n);
        if force_n[1] - force_n[0] > widest_n {
            return Err(SensingError::WideRange { contact, force_n, position_mm });
        }
        Ok(())
    }
}

/// Root mean square distance of a mixture from a value.
pub(super) fn spread(mixture: &[Component], from: f64) -> f64 {
    let whole: f64 = mixture.iter().map(|(weight, ..)| weight).sum();
    let square = |(weight, mean, sd): &Component| weight * ((mean - from).powi(2) + sd * sd);
    (mixture.iter().map(square).sum::<f64>() / whole).sqrt()
}

/// Standard deviation of the normal distribution about a value that has the longer tail of the mixture. A skewed mixture has a longer tail than a normal
/// distribution of the same [`spread`].
pub(super) fn tail_sd(mixture: &[Component], from: f64) -> f64 {
    interval(mixture, WIDE).into_iter().fold(0.0, |sd: f64, limit| sd.max((limit - from).abs() / TWO_SIDED_WIDE))
}

/// The forces of a range at a position, by interpolation.
pub(super) fn at(range: &[ForcesAt], s_mm: f64) -> Option<ForcesAt> {
    let ends = range.windows(2).find(|ends| (ends[0].s_mm..=ends[1].s_mm).contains(&s_mm))?;
    Some(ends[0].towards(&ends[1], (s_mm - ends[0].s_mm) / (ends[1].s_mm - ends[0].s_mm)))
}

/// Whether forces are those of a point of the profile, up to the error of interpolation and some standard deviations.
pub(super) fn is_same(found: &ForcesAt, forces_n: &[f64]) -> bool {
    let same = |((a, b), sigma_n): ((&f64, &f64), &f64)| (a - b).abs() <= 5.0 * sigma_n + 0.02 * a.abs();
    found.forces_n.iter().zip(forces_n).zip(&found.sigmas_n).all(same)
}
