//! Finds outliers among the measured forces and markers of a fit, and refuses a fit that is too inaccurate for use.

use super::contradiction::Compared;
use super::forces::new_image;
use super::problem::{Point, Problem};
use super::{ForceError, ViewError};
use crate::NodeId;
use crate::calibration::{CalibrationError, median};
use crate::optimise::Fit;
use nalgebra::DMatrix;
use std::fmt;

/// A measured force is an outlier only if it deviates from its expected value by more than this factor. Force sensors are more accurate.
const EXPECTED_TIMES: f64 = 1.1;
/// A measured force is an outlier only if it deviates by more than this many standard deviations. The standard deviation follows from the median deviation of
/// the forces.
const MOST_SIGMAS: f64 = 6.0;
/// Ratio of the standard deviation of normal errors to their median absolute deviation.
const SD_OF_MEDIAN: f64 = 1.4826;
/// The marker with the largest residual is an outlier if normal errors would cause a largest residual of that size with less than this probability.
const CHANCE: f64 = 1e-4;
/// A fit is too inaccurate for use if the relative standard deviation of a force reaches this value. From this value on, the lower end of the force's
/// 95 % interval is about zero or below.
const OF_NO_USE: f64 = 0.5;

/// A measured force or marker of a view that deviates more than the scatter of the other forces or markers suggests.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlier {
    /// Name of the view.
    pub view: String,
    /// Whether the force or a marker is the outlier, with its deviation.
    pub what: OutlierKind,
}

/// Kind of an outlier, with its deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OutlierKind {
    /// The measured force.
    Force {
        /// Ratio of the measured force to the force estimated from the markers, divided by the median ratio of all views, dimensionless.
        times: f64,
    },
    /// A marker.
    Marker {
        /// Node of the marker.
        node: NodeId,
        /// Distance of the marker from its computed position, mm.
        away_mm: f64,
        /// Root mean square distance of all markers from their computed positions, mm.
        rms_mm: f64,
    },
}

impl fmt::Display for Outlier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let view = &self.view;
        match self.what {
            OutlierKind::Force { times } => write!(
                f,
                "{view}: the ratio of the measured force to the force that the markers show is {times:.3} times \
                    the median ratio of all images; check unit, frame and row of the measured force"
            ),
            OutlierKind::Marker { node, away_mm, rms_mm } => write!(
                f,
                "{view}: the marker of node {node} is {away_mm:.2} mm from its position on the calibrated finger, while all markers deviate by \
                 {rms_mm:.2} mm rms: check the node number and rim of this marker"
            ),
        }
    }
}

/// Deviation of a marker of a view from the fit.
struct OffMarker<'p> {
    view: &'p str,
    node: NodeId,
    away_mm: f64,
    moved_mm: f64,
    /// Sum of the squares of the two residuals (x, y), each divided by its variance. `standardised` also divides each square by its degrees of
    /// freedom. `free` is the sum of the degrees of freedom of the two residuals (x, y).
    squares: f64,
    standardised: f64,
    free: f64,
}

/// Outliers of a fit with the given covariance. Reports only the worst marker, because a wrong marker makes other markers deviate.
pub(super) fn outliers(problem: &Problem, fitted: &Fit<Point>, covariance: &DMatrix<f64>) -> Vec<Outlier> {
    let mut all = times(problem, fitted, covariance);
    // Markers that hardly determine a force cannot contradict this force.
    all.retain(|it| it.inverse_sd < OF_NO_USE);
    let logarithms: Vec<f64> = all.iter().map(|it| it.times.ln()).collect();
    let usual = median(logarithms.iter().copied()).unwrap_or_default();
    let off: Vec<f64> = logarithms.iter().map(|logarithm| (logarithm - usual).abs()).collect();
    let mut sorted = off.clone();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.get(sorted.len().saturating_sub(1) / 2).copied().unwrap_or_default();
    let most = EXPECTED_TIMES.ln().max(MOST_SIGMAS * SD_OF_MEDIAN * half);
    let is_off = |it: &Compared, off: f64| (off.is_nan() || off > most) && it.is_surely_not(usual.exp());
    let forces = all.iter().zip(&off).filter(|(it, off)| is_off(it, **off)).map(|(it, _)| Outlier {
        view: it.view.name.clone(),
        what: OutlierKind::Force { times: it.times / usual.exp() },
    });
    forces.chain(marker_outlier(&off_markers(problem, fitted, covariance))).collect()
}

/// Ratio of each measured force to the force estimated from all other data. Omits views whose markers and base do not determine the force.
fn times<'p>(problem: &'p Problem, fitted: &Fit<Point>, covariance: &DMatrix<f64>) -> Vec<Compared<'p>> {
    let Some(scatter) = problem.scatter else { return Vec::new() };
    let shared = covariance.view((0, 0), (problem.sought.len(), problem.sought.len()));
    let mut all = Vec::new();
    for (view, own, rows, column) in problem.parts(&fitted.point) {
        let measured_n = view.force.map(|force| force.norm());
        let alone =
            measured_n.and_then(|n| Some((n, new_image(problem, &fitted.jacobian, [rows.start, column], view, n)?)));
        if let Some((measured_n, alone)) = alone {
            // The residual of a measured force shows only part of the force's error. The fit has absorbed the rest of the force's error as errors
            // of markers and finger.
            let of_both = alone.variance + scatter * scatter;
            let of_finger = (alone.by_shared.transpose() * shared * &alone.by_shared)[0];
            let free = (scatter * scatter / of_both * (1.0 - of_finger / of_both)).max(f64::MIN_POSITIVE);
            let off = (own.force_n / measured_n - 1.0) / free;
            all.push(Compared { view, times: 1.0 / (1.0 + off), inverse_sd: alone.variance.sqrt() });
        }
    }
    all
}

fn off_markers<'p>(problem: &'p Problem, fitted: &Fit<Point>, covariance: &DMatrix<f64>) -> Vec<OffMarker<'p>> {
    let mut all = Vec::new();
    for (view, _, rows, _) in problem.parts(&fitted.point) {
        for (i, marker) in view.measurement.markers().iter().enumerate() {
            let rows = [rows.start + 2 * i, rows.start + 2 * i + 1];
            let free = rows.map(|row| {
                let by = fitted.jacobian.row(row);
                (1.0 - (by * covariance).dot(&by)).max(f64::EPSILON)
            });
            let squares = rows.map(|row| fitted.residual[row].powi(2));
            all.push(OffMarker {
                view: &view.name,
                node: marker.node,
                away_mm: (squares[0] + squares[1]).sqrt() * problem.errors.sd_mm(view.noise_mm / marker.weight),
                moved_mm: marker.displacement.norm(),
                squares: squares[0] + squares[1],
                standardised: squares[0] / free[0] + squares[1] / free[1],
                free: free[0] + free[1],
            });
        }
    }
    all
}

/// Checks that a fit is accurate enough for use.
///
/// # Errors
/// [`ViewError::MarkerErrors`] if markers deviate by at least half of their displacements (root mean squares). [`ViewError::ForceErrors`] if the
/// relative standard deviation of a new force is one half or more. [`ViewError::MarkerErrors`] and [`ViewError::ForceErrors`] name the view that
/// deviates most.
pub(super) fn check_use(
    problem: &Problem,
    fitted: &Fit<Point>,
    covariance: &DMatrix<f64>,
    error: Option<ForceError>,
) -> Result<(), CalibrationError> {
    let refused = |view: &str, error| Err(CalibrationError::View { name: view.to_owned(), error });
    let markers = off_markers(problem, fitted, covariance);
    let rms = |of: fn(&OffMarker) -> f64| rms_mm(markers.iter().map(of));
    let (missed_mm, moved_mm) = (rms(|marker| marker.away_mm), rms(|marker| marker.moved_mm));
    let worst = markers.iter().max_by(|a, b| a.away_mm.total_cmp(&b.away_mm));
    if let Some(worst) = worst.filter(|_| missed_mm >= OF_NO_USE * moved_mm) {
        let (node, away_mm) = (worst.node, worst.away_mm);
        return refused(worst.view, ViewError::MarkerErrors { node, away_mm, missed_mm, moved_mm });
    }
    let times = times(problem, fitted, covariance);
    let off = |times: f64| if times > 0.0 { times.ln().abs() } else { f64::INFINITY };
    let further = |a: &&Compared, b: &&Compared| off(a.times).total_cmp(&off(b.times));
    let shown = times.iter().filter(|it| it.inverse_sd < OF_NO_USE).max_by(further);
    let worst = shown.or_else(|| times.iter().max_by(further));
    match (error, worst) {
        (Some(ForceError { of_new, .. }), Some(&Compared { view, times, .. })) if of_new >= OF_NO_USE => {
            refused(&view.name, ViewError::ForceErrors { share: of_new, times })
        }
        _ => Ok(()),
    }
}

/// The marker that deviates most, if its deviation is improbable for normal errors.
///
/// # Reference
/// For n independent squared normal residuals, the sum of two exceeds a share q of the total sum with probability (1 - q)^(n / 2 - 1). The share of
/// two residuals in the total sum has a beta distribution, as for internally studentised residuals (Cook and Weisberg, Residuals and Influence in
/// Regression, 1982, sec. 2.2).
fn marker_outlier(all: &[OffMarker]) -> Option<Outlier> {
    let worst = all.iter().max_by(|a, b| a.standardised.total_cmp(&b.standardised))?;
    let sum: f64 = all.iter().map(|marker| marker.squares).sum();
    let free: f64 = all.iter().map(|marker| marker.free).sum();
    let chance = all.len() as f64 * (1.0 - (worst.standardised / sum).min(1.0)).powf(0.5 * free - 1.0);
    let rms_mm = rms_mm(all.iter().map(|marker| marker.away_mm));
    let what = OutlierKind::Marker { node: worst.node, away_mm: worst.away_mm, rms_mm };
    (free > 2.0 && chance < CHANCE).then(|| Outlier { view: worst.view.to_owned(), what })
}

fn rms_mm(lengths_mm: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = lengths_mm.len() as f64;
    (lengths_mm.map(|length_mm| length_mm * length_mm).sum::<f64>() / count).sqrt()
}
