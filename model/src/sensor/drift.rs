//! Drift of the unloaded finger since the first frames of a stream.

use super::means::MeanPosition;
use super::rest::{RestMarker, RestPositions};
use super::stream::{FALSE_ALARM, noise_test};
use crate::measurement::BaseUncertainty;
use crate::observation::Observation;
use crate::scene::Scene;
use crate::sensing::ResidualTest;

/// Standard deviations, mm and rad, of a base that may be anywhere. They exceed every drift at which the camera still shows the finger in its place.
const ANYWHERE: (f64, f64) = (100.0, 1.0);

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

impl RestPositions {
    /// Adds a later observation of a finger without detectable force. Returns the drift. The mean over the recent free frames is a moving average over
    /// as many frames as there are rest frames. `noise_mm` is the standard deviation of one coordinate in one frame, mm; without it, the standard
    /// deviations of the markers are used.
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
        // Errors of the finger model are the same at rest and in free frames, so only the noise counts.
        let factor = self.noise_factor(scene, noise_mm);
        let sd_mm = |marker: &RestMarker| {
            let [at_rest, recent] = [marker.at_rest, marker.recent];
            let shares = at_rest.weights.squares + recent.weights.squares;
            let of = |mean: MeanPosition| if is_base_apart { mean.own_variance_mm2 } else { mean.variance_mm2 };
            // A rest frame without a standard deviation counts as exact as the recent frames.
            let stated_mm2 = || f64::max(of(at_rest) + of(recent), of(recent) / recent.weights.squares * shares);
            factor * noise_mm.map_or_else(|| stated_mm2().sqrt(), |noise_mm| noise_mm * shares.sqrt())
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
