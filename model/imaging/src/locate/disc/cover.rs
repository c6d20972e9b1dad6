//! Signs that something covers a part of a disc. The edge of an object displaces the disc's rim on one side, often by so little that every sector still
//! looks like an edge. The centre then moves if the sectors of that side are omitted. If the object displaces the rim farther, sectors miss the disc's edge.

use super::shades::LEAST_CONTRAST;
use super::sums::SectorSums;
use nalgebra::{Matrix2, Vector2};

/// Lengths of the arcs that are omitted, as shares of the rim.
const ARCS: [f64; 4] = [0.125, 0.25, 0.375, 0.5];
/// An arc is omitted only if the rest of the rim keeps this share of the determinant of the centre's normal matrix.
const LEFT: f64 = 0.05;
/// Lower bound of the usual shift, in standard deviations: that of independent pixel errors, without errors of the edge model.
const LEAST_SHIFT: f64 = 1.2;
/// A sector misses the edge if its pixels alone move the edge by more than this, px: farther than an uneven background does.
const ELSEWHERE_PX: f32 = 1.0;
/// A disc tells nothing if the share of its rim that misses the edge is this multiple of the usual share. Objects that displace a large part of a rim
/// move the centre by up to half a radius.
const MISSED: f64 = 4.0;
/// Lower bound of the usual share of a rim that misses the edge.
const LEAST_MISSED: f64 = 0.04;

/// Signs that something covers a part of a disc or rim.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::locate) struct Cover {
    /// Shift of the centre if the arc of the rim is omitted that shifts it most, mm.
    pub shift_mm: f64,
    /// The shift in standard deviations.
    pub shift_sigmas: f64,
    /// Share of the rim that misses the edge, 0..1.
    pub missed: f64,
}

/// Medians of the signs over the markers of an image. Most markers are whole, so the medians are those of whole markers.
pub(in crate::locate) struct UsualCover {
    shift_sigmas: f64,
    missed: f64,
}

impl UsualCover {
    pub fn of(covers: impl Iterator<Item = Cover> + Clone) -> UsualCover {
        let usual = |of: fn(Cover) -> f64, least: f64| median(covers.clone().map(of)).unwrap_or_default().max(least);
        UsualCover {
            shift_sigmas: usual(|cover| cover.shift_sigmas, LEAST_SHIFT),
            missed: usual(|cover| cover.missed, LEAST_MISSED),
        }
    }

    /// Standard deviation of a coordinate of a centre, mm, whose standard deviation without a cover is `sd_mm`. A shift beyond the usual may be an error
    /// of the centre. The information falls to zero as the share of the rim that misses the edge grows: then the standard deviation is infinite. Both are
    /// continuous, so that no marker is omitted by rounding.
    pub fn widened_mm(&self, sd_mm: f64, cover: &Cover) -> f64 {
        let beyond = 1.0 - (self.shift_sigmas / cover.shift_sigmas).powi(2);
        let information = 1.0 - (cover.missed / (MISSED * self.missed)).powi(2);
        sd_mm.hypot(cover.shift_mm * beyond.max(0.0).sqrt()) / information.max(0.0).sqrt()
    }
}

/// The signs at a measured edge. `missed` is [`Cover::missed`], `variance` that of a residual, in squared grey levels, and `floor_px` the standard deviation
/// of the edge model, px. `unit_mm` is the length of one px.
pub(super) fn cover(sectors: &[SectorSums], missed: f64, variance: f64, floor_px: f64, unit_mm: f64) -> Cover {
    let stiffness = |of: &SectorSums| {
        let [xx, xy, yy] = of.stiffness.map(f64::from);
        Matrix2::new(xx, xy, xy, yy)
    };
    let pull = |of: &SectorSums| of.pull.map(f64::from);
    let (count, all) = (sectors.len(), sectors.iter().map(stiffness).sum::<Matrix2<f64>>());
    let mut cover = Cover { missed, ..Cover::default() };
    let Some(inverse) = all.try_inverse() else { return cover };
    for share in ARCS {
        let arc = (share * count as f64) as usize;
        let mut left: Matrix2<f64> = sectors[arc..].iter().map(stiffness).sum();
        let mut pulled: Vector2<f64> = sectors[..arc].iter().map(pull).sum();
        for first in 0..count {
            if let Some(of_left) = left.try_inverse().filter(|_| left.determinant() > LEFT * all.determinant()) {
                let shift = of_left * pulled;
                let covariance = (of_left - inverse) * variance + Matrix2::identity() * (floor_px * floor_px);
                let squared = covariance.try_inverse().map_or(0.0, |weights| shift.dot(&(weights * shift)) / 2.0);
                if squared > cover.shift_sigmas * cover.shift_sigmas {
                    (cover.shift_mm, cover.shift_sigmas) = (shift.norm() * unit_mm, squared.sqrt());
                }
            }
            let (leaves, enters) = (&sectors[first], &sectors[(first + arc) % count]);
            left += stiffness(leaves) - stiffness(enters);
            pulled += pull(enters) - pull(leaves);
        }
    }
    cover
}

/// Share of the sectors in which the edge is elsewhere, or in which there is no edge. Sectors without trust are not counted: there the background is
/// uneven, and nothing is known of the edge.
pub(super) fn missed(sectors: &[SectorSums], trust: &[f32]) -> f64 {
    let misses = |of: &SectorSums| {
        let [pull, stiffness] = of.outwards;
        let has_edge = stiffness > 0.0 && of.contrast2 >= LEAST_CONTRAST * LEAST_CONTRAST * of.count;
        !has_edge || (pull / stiffness).abs() > ELSEWHERE_PX
    };
    let missed = sectors.iter().zip(trust).filter(|(of, trust)| **trust > 0.0 && misses(of)).count();
    missed as f64 / sectors.len() as f64
}

/// Median of the numbers; `None` if there are none.
pub(in crate::locate) fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut numbers: Vec<f64> = numbers.collect();
    let middle = numbers.len() / 2;
    (middle < numbers.len()).then(|| *numbers.select_nth_unstable_by(middle, f64::total_cmp).1)
}
