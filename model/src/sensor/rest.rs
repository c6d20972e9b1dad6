//! The unloaded finger in the first frames of a stream: the positions of its markers, and their scatter.

use super::means::{MeanBase, MeanPosition};
use super::stream::FALSE_ALARM;
use crate::Vector;
use crate::finger::{Finger, NodeId};
use crate::observation::{EstimatedNoise, Observation, ObservationError, ObservedBase, ObservedMarker, exists};
use crate::rigid_fit::rigid_fit;
use crate::scene::Scene;
use crate::sensing::ResidualTest;
use nalgebra::{Isometry2, Point2, UnitComplex};

/// The scatter of the markers states the noise only if it has at least this many degrees of freedom. With fewer, the noise would be uncertain by more than
/// a third.
const LEAST_DEGREES_OF_FREEDOM: f64 = 12.0;
/// Degrees of freedom of a noise from the median change between frames, as a share of those of the variance. The change has 2/3 of the information in the
/// variance, and the median 0.64 of that in the mean.
const OF_MEDIAN_CHANGE: f64 = 0.4;
/// Without a stated noise, the finger was not at rest if the variance of its markers exceeds the noise from the changes between frames by this factor.
/// White noise exceeds this factor in at most 0.7 % of the streams with one marker, and in 0.04 % with two.
const RESTLESS: f64 = 2.5;
/// The unloaded markers must lie where the scene has them, up to a rigid motion and this share of their distance from their centre (root mean squares).
/// Assembly errors are smaller. Another unit, a scale error of more than 3 %, other numbers of the nodes or another finger exceed this share.
const MISPLACED: f64 = 0.03;
/// A rotation of the markers at rest counts if it exceeds this number of its standard deviations.
const TURNED_SIGMAS: f64 = 3.0;

/// Mean positions of the markers of the unloaded finger, from which later displacements are measured, and their drift in later frames.
#[derive(Debug, Clone, Default)]
pub struct RestPositions {
    pub(super) markers: Vec<RestMarker>,
    /// Errors of the base at rest and in the recent free frames.
    pub(super) bases: [MeanBase; 2],
    /// Number of observations at rest.
    pub(super) frames: usize,
    /// Mean square change of a coordinate from each observation at rest to the next, mm^2.
    changes_mm2: Vec<f64>,
    /// Rotation from the finger frame to the frame of the positions.
    turn: UnitComplex<f64>,
    /// The least certain noise of the observations at rest. Compression repeats its errors while nothing moves, so that a mean does not reduce them.
    noise: Option<EstimatedNoise>,
}

/// Reason for which an observation does not show the scene's finger without load.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RestError {
    /// The observation does not fit the finger.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// No free marker is seen.
    #[error("no marker is seen")]
    NoMarker,
    /// The markers are elsewhere.
    #[error(
        "the unloaded finger's markers are {misplaced_mm:.3} mm (rms) from their places in the scene, after the best rigid motion: check the unit, the \
         numbers of the nodes and the finger"
    )]
    Misplaced {
        /// Distance of the markers from their places in the scene, root mean square, mm.
        misplaced_mm: f64,
    },
}

/// A marker of the unloaded finger.
#[derive(Debug, Clone)]
pub(super) struct RestMarker {
    pub(super) node: NodeId,
    pub(super) at_rest: MeanPosition,
    /// Mean over the recent free frames after the rest frames.
    pub(super) recent: MeanPosition,
    /// Position in the last observation at rest that shows the marker, mm.
    last: Vector,
    /// Sum of squared deviations of the coordinates from their mean at rest, mm^2.
    scatter_mm2: f64,
}

impl RestMarker {
    /// Stated variance of a coordinate in one observation at rest, mm^2.
    fn variance_of_frame_mm2(&self) -> f64 {
        self.at_rest.variance_mm2 / self.at_rest.weights.squares
    }
}

impl RestPositions {
    /// Adds an observation of the unloaded finger at rest.
    ///
    /// # Errors
    /// [`RestError`] if the markers are not those of the scene's finger without load. The observation is then not added.
    pub fn add(&mut self, scene: &Scene, seen: &Observation) -> Result<(), RestError> {
        let finger = &scene.finger;
        // Clamped markers may be shifted relative to the scene, as all markers may.
        let free = |marker: &&ObservedMarker| !finger.is_clamped(marker.node);
        let free = Observation { markers: seen.markers.iter().filter(free).copied().collect(), ..seen.clone() };
        if free.for_sensing(scene, true, None)?.measurement.markers().is_empty() {
            return Err(RestError::NoMarker);
        }
        let positions = || seen.markers.iter().filter_map(|marker| Some((marker.node, marker.position?)));
        let (_, [misplaced_mm, spread_mm]) = fitted(finger, positions());
        if misplaced_mm > MISPLACED * spread_mm {
            return Err(RestError::Misplaced { misplaced_mm });
        }
        self.frames += 1;
        self.bases[0].add(seen.base, usize::MAX);
        self.noise = self.noise.into_iter().chain(seen.noise).reduce(|one, other| EstimatedNoise {
            degrees_of_freedom: one.degrees_of_freedom.min(other.degrees_of_freedom),
            shared_sd_mm: one.shared_sd_mm.max(other.shared_sd_mm),
        });
        let (mut changes_mm2, mut coordinates) = (0.0, 0);
        for marker in &seen.markers {
            let Some(position) = marker.position else { continue };
            let known = self.markers.iter().position(|known| known.node == marker.node);
            let known = known.unwrap_or_else(|| {
                let [at_rest, recent] = [MeanPosition::default(); 2];
                let node = marker.node;
                self.markers.push(RestMarker { node, at_rest, recent, last: position, scatter_mm2: 0.0 });
                self.markers.len() - 1
            });
            let known = &mut self.markers[known];
            if known.at_rest.weights.frames > 0 {
                changes_mm2 += (position - known.last).norm_squared();
                coordinates += 2;
            }
            let from_old_mean = position - known.at_rest.position;
            known.at_rest.add(marker, position, usize::MAX);
            // Welford's update of the sum of squares.
            known.scatter_mm2 += from_old_mean.dot(&(position - known.at_rest.position));
            known.last = position;
        }
        if coordinates > 0 {
            self.changes_mm2.push(changes_mm2 / f64::from(coordinates));
        }
        // Positions relative to an observed base are in the finger frame.
        if seen.base.is_none() {
            self.turn = turn(finger, self.markers.iter().map(|marker| (marker.node, marker.at_rest.position)));
        }
        Ok(())
    }

    /// Number of observations at rest.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Whether the observations at rest state standard deviations of their markers.
    pub fn states_noise(&self) -> bool {
        self.markers.iter().any(|marker| marker.at_rest.variance_mm2 > 0.0)
    }

    /// Number of coordinates of all observations at rest minus number of their means.
    fn degrees_of_freedom(&self) -> usize {
        self.markers.iter().map(|marker| 2 * (marker.at_rest.weights.frames - 1)).sum()
    }

    /// Standard deviation of one coordinate, mm, from the changes of the markers between the observations at rest: the median over the changes, so that a
    /// single motion has no influence, enlarged by the uncertainty of this estimate. `None` if the observations are too few, or identical.
    pub fn noise_mm(&self) -> Option<f64> {
        let degrees_of_freedom = OF_MEDIAN_CHANGE * self.degrees_of_freedom() as f64;
        let mut changes_mm2 = self.changes_mm2.clone();
        changes_mm2.sort_by(f64::total_cmp);
        // A change has the variance of two observations.
        let variance_mm2 = changes_mm2.get(changes_mm2.len() / 2)? / 2.0;
        let enlarged = 1.0 + (2.0 / degrees_of_freedom).sqrt();
        let is_enough = changes_mm2.len() > 1 && degrees_of_freedom >= LEAST_DEGREES_OF_FREEDOM;
        let is_known = is_enough && variance_mm2 > 0.0;
        is_known.then(|| (variance_mm2 * enlarged).sqrt())
    }

    /// Standard deviation of a coordinate about its mean over the observations at rest, mm. `None` with a single observation.
    pub fn scatter_mm(&self) -> Option<f64> {
        let degrees_of_freedom = self.degrees_of_freedom();
        let sum_mm2: f64 = self.markers.iter().map(|marker| marker.scatter_mm2).sum();
        (degrees_of_freedom > 0).then(|| (sum_mm2 / degrees_of_freedom as f64).sqrt())
    }

    /// The scene's noise factor for observations like those at rest. `noise_mm` is the stated standard deviation of one coordinate, mm.
    pub(super) fn noise_factor(&self, scene: &Scene, noise_mm: Option<f64>) -> f64 {
        let mean_mm2 = || {
            let sum_mm2: f64 = self.markers.iter().map(RestMarker::variance_of_frame_mm2).sum();
            sum_mm2 / self.markers.len().max(1) as f64
        };
        scene.marker_errors.of_image(noise_mm.unwrap_or_else(|| mean_mm2().sqrt())).noise_factor
    }

    /// A warning, in words, if the markers moved during the observations at rest. `noise_mm` is the stated standard deviation of one coordinate, mm.
    pub fn restlessness(&self, scene: &Scene, noise_mm: Option<f64>) -> Option<String> {
        let (degrees_of_freedom, scatter_mm) = (self.degrees_of_freedom(), self.scatter_mm().unwrap_or_default());
        let factor = self.noise_factor(scene, noise_mm);
        let stated_mm2 = |marker: &RestMarker| match noise_mm {
            Some(noise_mm) => (factor * noise_mm).powi(2),
            None => factor.powi(2) * marker.variance_of_frame_mm2(),
        };
        let is_stated = self.markers.iter().all(|marker| stated_mm2(marker) > 0.0);
        let is_restless = if is_stated {
            let squares: f64 = self.markers.iter().map(|marker| marker.scatter_mm2 / stated_mm2(marker)).sum();
            // The errors of an observed base are shared by all markers of an image, so only the three errors of each image are independent.
            let independent = match self.bases[0].variance_mm2 > 0.0 {
                true => 3 * (self.frames - 1),
                false => degrees_of_freedom,
            };
            let scaled = squares * independent as f64 / degrees_of_freedom.max(1) as f64;
            ResidualTest::new(Some(1.0), scaled, independent).is_some_and(|test| test.p_value() < FALSE_ALARM)
        } else {
            self.noise_mm().is_some_and(|noise_mm| scatter_mm > RESTLESS.sqrt() * noise_mm)
        };
        is_restless.then(|| {
            format!(
                "the markers moved during the rest frames: they scatter by {scatter_mm:.4} mm, more than noise explains; all forces refer to these \
                 frames"
            )
        })
    }

    /// The observation with displacements from the mean positions, in the finger frame. Markers that were seen in fewer than half of the observations at
    /// rest are left out. The standard deviations include the uncertainty of the mean positions.
    pub fn displaced(&self, finger: &Finger, seen: &Observation) -> Observation {
        let displaced = |marker: &ObservedMarker| {
            let known = self.markers.iter().find(|known| known.node == marker.node);
            let Some(known) = known.filter(|known| 2 * known.at_rest.weights.frames >= self.frames) else {
                // A node that does not exist is kept, so that the observation is refused.
                return (!exists(finger, marker.node)).then_some(*marker);
            };
            let at_rest = known.at_rest;
            // A rest frame without a standard deviation counts as exact as this frame. An invalid standard deviation is kept, so that the observation is
            // refused.
            let wider = |sd_mm: Option<f64>, variance_mm2: f64| {
                let of_rest_mm = |sd_mm: f64| f64::max(variance_mm2.sqrt(), sd_mm * at_rest.weights.squares.sqrt());
                sd_mm.map(|sd_mm| if sd_mm > 0.0 { sd_mm.hypot(of_rest_mm(sd_mm)) } else { sd_mm })
            };
            Some(ObservedMarker {
                displacement: Some(self.turn.inverse() * (marker.position? - at_rest.position)),
                sd_mm: wider(marker.sd_mm, at_rest.variance_mm2),
                own_sd_mm: wider(marker.own_sd_mm, at_rest.own_variance_mm2),
                ..*marker
            })
        };
        let base = seen.base.map(|base| ObservedBase {
            uncertainty: base.uncertainty.map(|uncertainty| self.bases[0].with(uncertainty)),
            ..base
        });
        let markers: Vec<ObservedMarker> = seen.markers.iter().filter_map(displaced).collect();
        let of_seen_mm2 = seen.markers.iter().filter_map(|marker| marker.sd_mm).map(|sd_mm| sd_mm.powi(2)).sum::<f64>();
        let of_rest_mm2 = self.markers.iter().map(|marker| marker.at_rest.variance_mm2).sum::<f64>();
        let [of_seen, of_rest] = [(of_seen_mm2, seen.markers.len()), (of_rest_mm2, self.markers.len())]
            .map(|(sum_mm2, count)| sum_mm2 / count.max(1) as f64);
        let noise = EstimatedNoise::of_difference([(seen.noise, of_seen), (self.noise, of_rest)]);
        Observation { markers, base, noise, ..seen.clone() }
    }
}

/// Rigid motion from the places of the markers in the scene to given positions, mm. Also returns the root mean squares of the markers' distances from the
/// moved places, and of the places from their centre, mm.
fn fitted(finger: &Finger, positions: impl Iterator<Item = (NodeId, Vector)> + Clone) -> (Isometry2<f64>, [f64; 2]) {
    let pairs = positions.map(|(node, position)| (finger.marker_position(node), position, 1.0));
    let motion = rigid_fit(pairs.clone());
    let count = pairs.clone().count().max(1) as f64;
    let centre = pairs.clone().map(|(place, ..)| place).sum::<Vector>() / count;
    let mean_square = |of: &dyn Fn(Vector, Vector) -> Vector| {
        pairs.clone().map(|(place, position, _)| of(place, position).norm_squared()).sum::<f64>() / count
    };
    let misplaced = mean_square(&|place, position| (motion * Point2::from(place)).coords - position);
    (motion, [misplaced.sqrt(), mean_square(&|place, _| place - centre).sqrt()])
}

/// Rotation of the markers at rest relative to the scene. Zero if the rotation is not significant, because the markers' assembly errors then explain it.
fn turn(finger: &Finger, positions: impl ExactSizeIterator<Item = (NodeId, Vector)> + Clone) -> UnitComplex<f64> {
    let coordinates = 2.0 * positions.len() as f64;
    let (motion, [misplaced_mm, spread_mm]) = fitted(finger, positions);
    let sd_rad = misplaced_mm / (spread_mm * (coordinates - 3.0).max(1.0).sqrt());
    let is_turned = motion.rotation.angle().abs() > TURNED_SIGMAS * sd_rad;
    if is_turned { motion.rotation } else { UnitComplex::identity() }
}
