//! One finger in the frames of a stream: its state, its forces, and the reasons of refusals.

use super::{Refusal, RestPositions, SensedForces, SensorContacts, SensorOptions, StreamSensor, ZeroDrift};
use crate::finger::Finger;
use crate::observation::{Observation, check_at_rest};
use crate::scene::Scene;
use crate::sensing::Contact;
use serde::Serialize;

/// State of a finger in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FrameState {
    /// Contact forces are sensed.
    Contact,
    /// The finger carries no detectable force: noise explains the displacements, or the interval of the force contains zero. Also the state of rest frames.
    None,
    /// No force can be estimated; [`FingerResult::refused`] states the reason.
    Refused,
    /// The finger is not found in the image.
    Lost,
}

/// A finger in a stream: its sensor, the positions of its markers without load, and the forces of the previous frame.
#[derive(Debug, Clone)]
pub struct WatchedFinger<'s> {
    name: &'s str,
    scene: &'s Scene,
    sensor: StreamSensor<'s>,
    rest: RestPositions,
    /// Number of frames of the unloaded finger that are still to be read.
    rest_frames: usize,
    /// Whether the first frames show the unloaded finger.
    measures_from_rest: bool,
    /// Standard deviation of a displacement from the mean rest position, relative to that of a position.
    wider: f64,
    /// Forces of the last evaluated frame, if it showed any.
    sensed: Option<SensedForces>,
    /// Standard deviation of one coordinate in one frame, mm, if the options or the scene state it.
    noise_mm: Option<f64>,
    /// Drift in the last free frame after the rest frames.
    drift: Option<ZeroDrift>,
}

/// Result of a frame for one finger.
#[derive(Debug, Clone)]
pub struct FingerResult<'a> {
    /// Name of the finger; empty for the only finger.
    pub name: &'a str,
    /// The finger.
    pub finger: &'a Finger,
    /// Whether forces are sensed, and if not, why.
    pub state: FrameState,
    /// Number of markers found.
    pub markers: usize,
    /// The forces of a finger in contact.
    pub sensed: Option<&'a SensedForces>,
    /// Reason why no force is given.
    pub refused: Option<String>,
    /// Drift of the unloaded finger since the rest frames, as of the latest free frame.
    pub drift: Option<ZeroDrift>,
}

impl<'s> WatchedFinger<'s> {
    /// Prepares the evaluation of a finger. `name` is empty for the only finger. The first `rest_frames` frames show the unloaded finger; later
    /// displacements are measured from the mean marker positions in these frames.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator does not support the contacts.
    pub fn new(
        name: &'s str,
        scene: &'s Scene,
        contacts: SensorContacts,
        options: SensorOptions<'s>,
        rest_frames: usize,
    ) -> Result<WatchedFinger<'s>, Refusal> {
        // Displacements are measured from the mean of the rest frames, so the noise of this mean adds to that of the frame.
        let wider = if rest_frames == 0 { 1.0 } else { (1.0 + 1.0 / rest_frames as f64).sqrt() };
        let noise_mm = options.noise_mm.or(scene.noise_mm);
        let options = SensorOptions { noise_mm: noise_mm.map(|noise_mm| wider * noise_mm), ..options };
        Ok(WatchedFinger {
            name,
            scene,
            sensor: StreamSensor::new(scene, contacts, options)?,
            rest: RestPositions::default(),
            rest_frames,
            measures_from_rest: rest_frames > 0,
            wider,
            sensed: None,
            noise_mm,
            drift: None,
        })
    }

    /// Evaluates a frame; `seen` contains the observed markers or, if there are none, the state of the finger and the reason for this state.
    pub fn evaluate(&mut self, seen: Result<Observation, (FrameState, String)>) -> FingerResult<'_> {
        let before = self.sensed.take();
        let (state, markers, refused) = match seen {
            Err((state, reason)) => (state, 0, Some(reason)),
            Ok(seen) => {
                let markers = seen.markers.len();
                let (state, refused) = match self.state(&seen, before.as_ref()) {
                    Ok(state) => (state, None),
                    Err(reason) => (FrameState::Refused, Some(reason)),
                };
                (state, markers, refused)
            }
        };
        let &mut WatchedFinger { name, scene, ref sensed, drift, .. } = self;
        FingerResult { name, finger: &scene.finger, state, markers, sensed: sensed.as_ref(), refused, drift }
    }

    /// Drift of the unloaded finger since the rest frames, as of the latest free frame.
    pub fn drift(&self) -> Option<ZeroDrift> {
        self.drift
    }

    /// Name of the finger; empty for the only finger.
    pub fn name(&self) -> &'s str {
        self.name
    }

    /// Senses the forces, or adds a frame of the unloaded finger. Returns the state, or the reason of a refusal.
    fn state(&mut self, seen: &Observation, before: Option<&SensedForces>) -> Result<FrameState, String> {
        if self.rest_frames > 0 {
            // A frame with markers that the finger does not have is refused; as a rest frame it would make every later frame invalid. Clamped markers
            // may be shifted relative to the scene, as all markers may.
            let finger = &self.scene.finger;
            check_at_rest(finger, seen).map_err(|error| error.to_string())?;
            let free = seen.without_clamped(finger);
            let found = free.for_sensing(self.scene, true, None).map_err(|error| error.to_string())?;
            if found.measurement.markers().is_empty() {
                return Err("no marker is seen".to_owned());
            }
            self.rest_frames -= 1;
            self.rest.add(seen);
            if self.rest_frames == 0 && self.noise_mm.is_none() && found.noise_mm.is_none() {
                // A displacement has the noise of the frame and of the mean at rest.
                self.sensor.unloaded_noise_mm = self.rest.scatter_mm().map(|noise_mm| self.wider * noise_mm);
            }
            return Ok(FrameState::None);
        }
        if !self.measures_from_rest {
            return self.sensed_state(seen, before);
        }
        let state = self.sensed_state(&self.rest.displaced(seen), before)?;
        if state == FrameState::None {
            self.drift = self.rest.drift(self.scene, seen, self.noise_mm);
        }
        Ok(state)
    }

    /// Senses the forces. Returns the state, or the reason of a refusal.
    fn sensed_state(&mut self, seen: &Observation, before: Option<&SensedForces>) -> Result<FrameState, String> {
        self.sensed = self.sensor.sense(seen, before).map_err(|refusal| refusal.to_string())?;
        Ok(if self.sensed.is_some() { FrameState::Contact } else { FrameState::None })
    }
}

impl FingerResult<'_> {
    /// Component of the sum of all forces along the undeformed inward normal of the front plate, N.
    pub fn total_n(&self) -> f64 {
        self.sensed.map_or(0.0, |sensed| sensed.sum_along(self.finger, self.finger.direction(0.0))[0])
    }

    /// Warnings about the forces and the zero drift, separated by semicolons.
    pub fn warning(&self) -> Option<String> {
        let of_forces = self.sensed.into_iter().flat_map(|sensed| &sensed.warnings).map(ToString::to_string);
        let of_drift = self.drift.and_then(|drift| drift.warning());
        let warnings: Vec<String> = of_forces.chain(of_drift).collect();
        Some(warnings.join("; ")).filter(|warning| !warning.is_empty())
    }

    /// The contacts, each with its index and the sensed forces to which the index refers.
    pub fn contacts(&self) -> impl Iterator<Item = (usize, &SensedForces, &Contact)> {
        self.sensed
            .into_iter()
            .flat_map(|sensed| sensed.contacts.iter().enumerate().map(move |(i, contact)| (i, sensed, contact)))
    }
}
