//! The unloaded finger in a stream: the positions of its markers at rest, their scatter, and their drift since.

use super::stream::{FALSE_ALARM, noise_test};
use crate::Vector;
use crate::finger::NodeId;
use crate::measurement::BaseUncertainty;
use crate::observation::{Observation, ObservedBase, ObservedMarker};
use crate::scene::Scene;
use crate::sensing::ResidualTest;

/// The scatter of the markers is used as noise only if it has at least this many degrees of freedom. For 23 free markers, the test that recognises the
/// unloaded finger then fails in at most 0.3 % of the frames on average (F distribution).
const LEAST_DEGREES_OF_FREEDOM: usize = 100;
/// Standard deviations, mm and rad, of a base that may be anywhere. They exceed every drift at which the camera still shows the finger in its place.
const ANYWHERE: (f64, f64) = (100.0, 1.0);

/// Mean positions of the markers of the unloaded finger, from which later displacements are measured, and their drift in later frames.
#[derive(Debug, Clone, Default)]
pub struct RestPositions {
    markers: Vec<RestMarker>,
    /// Errors of the base at rest and in the recent free frames.
    bases: [MeanBase; 2],
    /// Number of observations at rest.
    frames: usize,
}

/// A marker of the unloaded finger.
#[derive(Debug, Clone)]
struct RestMarker {
    node: NodeId,
    at_rest: MeanPosition,
    /// Mean over the recent free frames after the rest frames.
    recent: MeanPosition,
    /// Sum of squared deviations of the coordinates from their mean at rest, mm^2.
    scatter_mm2: f64,
}

/// Mean position of a marker.
#[derive(Debug, Clone, Copy, Default)]
struct MeanPosition {
    weights: MeanWeights,
    position: Vector,
    /// Variance of one coordinate of the mean, mm^2; zero if no standard deviation is stated.
    variance_mm2: f64,
    /// Like `variance_mm2`, without the error of the base.
    own_variance_mm2: f64,
}

/// Errors of a mean pose of the base.
#[derive(Debug, Clone, Copy, Default)]
struct MeanBase {
    weights: MeanWeights,
    /// Variance of one coordinate, mm^2.
    variance_mm2: f64,
    /// Variance of the rotation, rad^2.
    variance_rad2: f64,
}

/// Weights of the frames in a mean. The mean of the first frames is their arithmetic mean; later frames form an exponential moving average.
#[derive(Debug, Clone, Copy, Default)]
struct MeanWeights {
    frames: usize,
    /// Sum of the squared weights of all frames.
    squares: f64,
}

/// Change of the unloaded finger since the rest frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZeroDrift {
    /// Root mean square over the markers of the distance between the mean position in the recent free frames and the mean position at rest, mm.
    pub rms_mm: f64,
    /// Comparison with the noise, relative to the standard deviations. `None` if the noise is unknown.
    pub test: Option<ResidualTest>,
    /// Whether a rigid motion of all markers explains the drift up to the noise.
    pub is_rigid: bool,
}

impl MeanWeights {
    /// Adds a frame. Returns its weight, which is at least `1 / most`.
    fn add(&mut self, most: usize) -> f64 {
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
    fn add(&mut self, marker: &ObservedMarker, position: Vector, most: usize) {
        let weight = self.weights.add(most);
        self.position += weight * (position - self.position);
        self.variance_mm2 = mixed(self.variance_mm2, weight, marker.sd_mm.unwrap_or(0.0).powi(2));
        self.own_variance_mm2 = mixed(self.own_variance_mm2, weight, marker.own_sd_mm.unwrap_or(0.0).powi(2));
    }
}

impl MeanBase {
    fn add(&mut self, base: Option<ObservedBase>, most: usize) {
        let base = base.and_then(|base| base.uncertainty).unwrap_or_default();
        let weight = self.weights.add(most);
        self.variance_mm2 = mixed(self.variance_mm2, weight, base.sd_mm.powi(2));
        self.variance_rad2 = mixed(self.variance_rad2, weight, base.sd_rad.powi(2));
    }

    /// The base of an image whose displacements are measured from this mean.
    fn with(&self, base: BaseUncertainty) -> BaseUncertainty {
        let [sd_mm, sd_rad] = [self.variance_mm2.sqrt(), self.variance_rad2.sqrt()];
        BaseUncertainty { sd_mm: base.sd_mm.hypot(sd_mm), sd_rad: base.sd_rad.hypot(sd_rad), ..base }
    }
}

impl RestPositions {
    /// Adds an observation of the unloaded finger at rest.
    pub fn add(&mut self, seen: &Observation) {
        self.frames += 1;
        self.bases[0].add(seen.base, usize::MAX);
        for marker in &seen.markers {
            let Some(position) = marker.position else { continue };
            let known = self.markers.iter().position(|known| known.node == marker.node).unwrap_or_else(|| {
                let [at_rest, recent] = [MeanPosition::default(); 2];
                self.markers.push(RestMarker { node: marker.node, at_rest, recent, scatter_mm2: 0.0 });
                self.markers.len() - 1
            });
            let known = &mut self.markers[known];
            let from_old_mean = position - known.at_rest.position;
            known.at_rest.add(marker, position, usize::MAX);
            // Welford's update of the sum of squares.
            known.scatter_mm2 += from_old_mean.dot(&(position - known.at_rest.position));
        }
    }

    /// Standard deviation of one coordinate, mm, from the scatter of the markers at rest. `None` if the rest frames are too few, or identical.
    pub fn scatter_mm(&self) -> Option<f64> {
        let freedom: usize = self.markers.iter().map(|marker| 2 * (marker.at_rest.weights.frames - 1)).sum();
        let squares_mm2: f64 = self.markers.iter().map(|marker| marker.scatter_mm2).sum();
        let scatter_mm = (squares_mm2 / freedom as f64).sqrt();
        (freedom >= LEAST_DEGREES_OF_FREEDOM && scatter_mm > 0.0).then_some(scatter_mm)
    }

    /// The observation with displacements from the mean positions. Markers that were never seen at rest are left out. The standard deviations include
    /// the uncertainty of the mean positions.
    pub fn displaced(&self, seen: &Observation) -> Observation {
        let displaced = |marker: &ObservedMarker| {
            let at_rest = self.markers.iter().find(|known| known.node == marker.node)?.at_rest;
            let wider = |sd_mm: Option<f64>, variance_mm2: f64| sd_mm.map(|sd_mm| sd_mm.hypot(variance_mm2.sqrt()));
            Some(ObservedMarker {
                displacement: Some(marker.position? - at_rest.position),
                sd_mm: wider(marker.sd_mm, at_rest.variance_mm2),
                own_sd_mm: wider(marker.own_sd_mm, at_rest.own_variance_mm2),
                ..*marker
            })
        };
        let base = seen.base.map(|base| ObservedBase {
            uncertainty: base.uncertainty.map(|uncertainty| self.bases[0].with(uncertainty)),
            ..base
        });
        Observation { markers: seen.markers.iter().filter_map(displaced).collect(), base, ..seen.clone() }
    }

    /// Adds a later observation of a finger without detectable force. Returns the drift. The mean over the recent free frames is a moving average over
    /// as many frames as there are rest frames. `noise_mm` is the standard deviation of one coordinate in one frame, mm; without it, the standard
    /// deviations of the markers are used, and without those, the scatter at rest.
    pub fn drift(&mut self, scene: &Scene, seen: &Observation, noise_mm: Option<f64>) -> Option<ZeroDrift> {
        let most = self.frames;
        self.bases[1].add(seen.base, most);
        for marker in &seen.markers {
            let known = self.markers.iter_mut().find(|known| known.node == marker.node);
            if let Some((known, position)) = known.zip(marker.position) {
                known.recent.add(marker, position, most);
            }
        }
        let found = || self.markers.iter().filter(|marker| marker.recent.weights.frames > 0);
        let moved = |marker: &RestMarker| marker.recent.position - marker.at_rest.position;
        let squares_mm2: f64 = found().map(|marker| moved(marker).norm_squared()).sum();
        let rms_mm = (squares_mm2 / found().count().max(1) as f64).sqrt();
        let base = self.bases[1].with(self.bases[0].with(BaseUncertainty::default()));
        let is_base_apart = base != BaseUncertainty::default();
        let stated_mm = |marker: &RestMarker| {
            let variance_mm2 =
                |mean: MeanPosition| if is_base_apart { mean.own_variance_mm2 } else { mean.variance_mm2 };
            (variance_mm2(marker.at_rest) + variance_mm2(marker.recent)).sqrt()
        };
        let is_stated = noise_mm.is_some() || found().any(|marker| stated_mm(marker) > 0.0);
        let of_frame_mm = noise_mm.or_else(|| self.scatter_mm().filter(|_| !is_stated));
        // Errors of the finger model are the same at rest and in free frames, so only the noise counts.
        let factor = if is_stated { scene.marker_errors.noise_factor } else { 1.0 };
        let sd_mm = |marker: &RestMarker| match of_frame_mm {
            Some(noise_mm) => {
                factor * noise_mm * (marker.at_rest.weights.squares + marker.recent.weights.squares).sqrt()
            }
            None => factor * stated_mm(marker),
        };
        let markers = || {
            let known = found().filter(|marker| sd_mm(marker) > 0.0);
            known.map(|marker| (scene.finger.marker_position(marker.node), moved(marker), sd_mm(marker)))
        };
        let test = noise_test(markers(), base);
        let anywhere = BaseUncertainty { sd_mm: ANYWHERE.0, sd_rad: ANYWHERE.1, ..base };
        let is_rigid = || noise_test(markers(), anywhere).is_some_and(|test| test.p_value() >= FALSE_ALARM);
        let drift = ZeroDrift { rms_mm, test, is_rigid: false };
        Some(ZeroDrift { is_rigid: drift.is_significant() && is_rigid(), ..drift }).filter(|_| found().next().is_some())
    }
}

impl ZeroDrift {
    /// Whether noise does not explain the drift.
    pub fn is_significant(&self) -> bool {
        self.test.is_some_and(|test| test.p_value() < FALSE_ALARM)
    }

    /// The drift in words, if it is significant.
    pub fn warning(&self) -> Option<String> {
        let cause = match self.is_rigid {
            true => "a motion of the base or the camera would explain it",
            false => "the unloaded finger has changed its shape, or carries a force too small to detect",
        };
        let warning =
            || format!("zero drift of {:.4} mm since the rest frames: {cause}; sensed forces include it", self.rms_mm);
        self.is_significant().then(warning)
    }
}
