//! Means over the frames of a stream, with their variances.

use crate::Vector;
use crate::measurement::BaseUncertainty;
use crate::observation::{ObservedBase, ObservedMarker};

/// Mean position of a marker.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeanPosition {
    pub(super) weights: MeanWeights,
    pub(super) position: Vector,
    /// Variance of one coordinate of the mean, mm^2, from the frames that state a standard deviation.
    pub(super) variance_mm2: f64,
    /// Like `variance_mm2`, without the error of the base.
    pub(super) own_variance_mm2: f64,
}

/// Errors of a mean pose of the base.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeanBase {
    pub(super) weights: MeanWeights,
    /// Variance of one coordinate, mm^2.
    pub(super) variance_mm2: f64,
    /// Variance of the rotation, rad^2.
    pub(super) variance_rad2: f64,
}

/// Weights of the frames in a mean. The mean of the first frames is their arithmetic mean; later frames form an exponential moving average.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeanWeights {
    pub(super) frames: usize,
    /// Sum of the squared weights of all frames.
    pub(super) squares: f64,
}

impl MeanWeights {
    /// Adds a frame. Returns its weight, which is at least `1 / most`.
    pub(super) fn add(&mut self, most: usize) -> f64 {
        self.frames = (self.frames + 1).min(most);
        let weight = 1.0 / self.frames as f64;
        self.squares = mixed(self.squares, weight, 1.0);
        weight
    }
}

/// Variance of a mean after a frame of the given weight and variance.
fn mixed(variance: f64, weight: f64, of_frame: f64) -> f64 {
    (1.0 - weight).powi(2) * variance + weight.powi(2) * of_frame
}

impl MeanPosition {
    pub(super) fn add(&mut self, marker: &ObservedMarker, position: Vector, most: usize) {
        let weight = self.weights.add(most);
        self.position += weight * (position - self.position);
        self.variance_mm2 = mixed(self.variance_mm2, weight, marker.sd_mm.unwrap_or(0.0).powi(2));
        self.own_variance_mm2 = mixed(self.own_variance_mm2, weight, marker.own_sd_mm.unwrap_or(0.0).powi(2));
    }
}

impl MeanBase {
    pub(super) fn add(&mut self, base: Option<ObservedBase>, most: usize) {
        let base = base.and_then(|base| base.uncertainty).unwrap_or_default();
        let weight = self.weights.add(most);
        self.variance_mm2 = mixed(self.variance_mm2, weight, base.sd_mm.powi(2));
        self.variance_rad2 = mixed(self.variance_rad2, weight, base.sd_rad.powi(2));
    }

    /// The base of an image whose displacements are measured from this mean.
    pub(super) fn with(&self, base: BaseUncertainty) -> BaseUncertainty {
        let [sd_mm, sd_rad] = [self.variance_mm2.sqrt(), self.variance_rad2.sqrt()];
        BaseUncertainty { sd_mm: base.sd_mm.hypot(sd_mm), sd_rad: base.sd_rad.hypot(sd_rad), ..base }
    }
}
