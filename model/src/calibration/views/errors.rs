//! Estimates the errors of markers from the residuals of a fit.

use super::View;
use super::problem::{Point, Problem};
use crate::measurement::{Marker, MarkerErrors};
use crate::optimise::Fit;
use nalgebra::DMatrix;

/// The search tries factors on the stated noise from 1 down to this value, in `STEPS` geometric steps.
const LEAST_NOISE_FACTOR: f64 = 1e-3;
const STEPS: usize = 60;
/// Prior standard deviation of the logarithm of the factor on the stated noise. The prior is needed if the stated noise is equal for all markers,
/// because residuals then show only the sum of calibration error and noise.
const FACTOR_SD: f64 = 1.0;
/// Two solutions count as equally likely if twice the difference of their log-likelihoods is at most this value, which is far from significant.
const ALIKE: f64 = 1e-6;
/// Number of golden-section steps of each search.
const SECTIONS: usize = 50;

/// Residual of one coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CoordinateResidual {
    square_mm2: f64,
    /// Share of the error's variance that remains in the residual, dimensionless. The fit has absorbed the rest of the variance.
    free: f64,
    stated_mm: f64,
}

/// Estimates the factor on the stated marker noise, and the calibration error, from the residuals of a fit. `covariance` is the covariance of the
/// fit.
pub(super) fn marker_errors(problem: &Problem, fitted: &Fit<Point>, covariance: &DMatrix<f64>) -> MarkerErrors {
    let mut left = Vec::new();
    for (view, _, rows, _) in problem.parts(&fitted.point) {
        let markers = view.measurement.markers().iter().flat_map(|marker| [marker; 2]);
        for (row, marker) in rows.zip(markers) {
            let stated_mm = view.noise_mm / marker.weight;
            let by = fitted.jacobian.row(row);
            let fitted_share = (by * covariance).dot(&by);
            left.push(CoordinateResidual {
                square_mm2: (fitted.residual[row] * problem.errors.sd_mm(stated_mm)).powi(2),
                free: (1.0 - fitted_share).max(0.0),
                stated_mm,
            });
        }
    }
    // A marker error that is equal in all images counts as geometry, so residuals do not show this error. Without measured forces, sensed forces
    // depend on the geometry alone. Without measured forces, the stated noise is not reduced.
    likeliest(left, problem.scatter.is_some())
}

/// Errors of the markers in a new view. The uncertainty of the geometry adds `share` (dimensionless) times the mean variance to the variance of each
/// marker.
pub(super) fn new_marker_errors(problem: &Problem, share: f64) -> MarkerErrors {
    let markers = || problem.views.iter().flat_map(|view| view.measurement.markers().iter().map(move |it| (view, it)));
    let variance_mm2 = |(view, marker): (&View, &Marker)| problem.errors.sd_mm(view.noise_mm / marker.weight).powi(2);
    let mean_mm2 = markers().map(variance_mm2).sum::<f64>() / markers().count() as f64;
    let calibration_error_mm = problem.errors.calibration_error_mm.hypot((share * mean_mm2).sqrt());
    MarkerErrors { calibration_error_mm, ..problem.errors }
}

/// Marker errors that maximise the likelihood of the residuals. The noise is the stated noise or, if `may_reduce_noise`, possibly smaller.
///
/// # Reference
/// Restricted maximum likelihood (Patterson and Thompson, Biometrika 58, 1971) for the variances of independent rows. Squared residuals and the
/// shares `free` stay fixed while the likelihood is maximised. Squared residuals are enlarged by the ratio of the mean of a variance to its most
/// likely value, which matters for few degrees of freedom.
fn likeliest(mut left: Vec<CoordinateResidual>, may_reduce_noise: bool) -> MarkerErrors {
    let free: f64 = left.iter().map(|it| it.free).sum();
    if free <= 2.0 {
        return MarkerErrors::default();
    }
    left.iter_mut().for_each(|it| it.square_mm2 *= free / (free - 2.0));
    let unlikely = |errors: &MarkerErrors| {
        let of = |it: &CoordinateResidual| {
            let variance_mm2 = errors.sd_mm(it.stated_mm).powi(2);
            it.free * variance_mm2.ln() + it.square_mm2 / variance_mm2
        };
        left.iter().map(of).sum::<f64>() + (errors.noise_factor.ln() / FACTOR_SD).powi(2)
    };
    let most_mm = left.iter().map(|it| it.square_mm2).sum::<f64>().sqrt();
    let with = |logarithm: f64| {
        let noise_factor = logarithm.exp();
        let of =
            |calibration_error_mm: f64| MarkerErrors { noise_factor, calibration_error_mm, ..MarkerErrors::default() };
        let best = of(least(0.0, most_mm, |error_mm| unlikely(&of(error_mm))));
        if unlikely(&of(0.0)) <= unlikely(&best) + ALIKE { of(0.0) } else { best }
    };
    let as_stated = with(0.0);
    if !may_reduce_noise {
        return as_stated;
    }
    let lowest = LEAST_NOISE_FACTOR.ln();
    let tried = (0..=STEPS).map(|i| lowest * i as f64 / STEPS as f64);
    let unlikely_with = |logarithm: &f64| unlikely(&with(*logarithm));
    let best = tried.min_by(|a, b| unlikely_with(a).total_cmp(&unlikely_with(b))).unwrap_or_default();
    let step = -lowest / STEPS as f64;
    let found = with(least((best - step).max(lowest), (best + step).min(0.0), |logarithm| unlikely_with(&logarithm)));
    if unlikely(&as_stated) <= unlikely(&found) + ALIKE { as_stated } else { found }
}

/// Position of a function's minimum between `low` and `high`, by golden-section search.
fn least(mut low: f64, mut high: f64, of: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..SECTIONS {
        let [lower, upper] = [high - golden * (high - low), low + golden * (high - low)];
        if of(lower) <= of(upper) { high = upper } else { low = lower }
    }
    0.5 * (low + high)
}

#[cfg(test)]
#[path = "../../../tests/units/errors.rs"]
mod tests;
