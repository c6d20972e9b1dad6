//! One finger in the frames of a stream: its state, its forces, and the reasons of refusals.

use super::{
    PreparedScene, Refusal, RestPositions, SensedForce, SensedForces, SensorContacts, SensorOptions, StreamSensor,
    ZeroDrift,
};
use crate::finger::Finger;
use crate::observation::Observation;
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
pub struct FingerTracker {
    name: String,
    scene: PreparedScene,
    contacts: SensorContacts,
    options: SensorOptions,
    sensor: StreamSensor,
    rest: RestPositions,
    /// Number of frames of the unloaded finger that are still to be read.
    rest_frames: usize,
    /// Whether the first frames show the unloaded finger.
    measures_from_rest: bool,
    /// Forces of the last evaluated frame, if it showed any.
    sensed: Option<SensedForces>,
    /// Standard deviation of one coordinate in one frame, mm, if the options or the scene state it, or the rest frames show it.
    noise_mm: Option<f64>,
    /// Warning that the finger was not at rest in the rest frames.
    restlessness: Option<String>,
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
    /// Warning that the finger was not at rest in the rest frames.
    pub restlessness: Option<&'a str>,
    /// Drift of the unloaded finger since the rest frames, as of the latest free frame.
    pub drift: Option<ZeroDrift>,
}

impl FingerTracker {
    /// Prepares the evaluation of a finger. `name` is empty for the only finger. The first `rest_frames` frames show the unloaded finger; later
    /// displacements are measured from the mean marker positions in these frames.
    ///
    /// # Errors
    /// [`Refusal`] if the estimator does not support the contacts.
    pub fn new(
        name: impl Into<String>,
        scene: impl Into<PreparedScene>,
        contacts: SensorContacts,
        options: SensorOptions,
        rest_frames: usize,
    ) -> Result<FingerTracker, Refusal> {
        let (name, scene) = (name.into(), scene.into());
        let noise_mm = options.noise_mm.or(scene.noise_mm);
        Ok(FingerTracker {
            name,
            sensor: sensor(&scene, &contacts, &options, noise_mm, rest_frames)?,
            scene,
            contacts,
            options,
            rest: RestPositions::default(),
            rest_frames,
            measures_from_rest: rest_frames > 0,
            sensed: None,
            noise_mm,
            restlessness: None,
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
        let &mut FingerTracker { ref name, ref scene, ref sensed, ref restlessness, drift, .. } = self;
        let (sensed, restlessness) = (sensed.as_ref(), restlessness.as_deref());
        FingerResult { name, finger: &scene.finger, state, markers, sensed, refused, restlessness, drift }
    }

    /// Number of rest frames that are still to be read.
    pub fn missing_rest_frames(&self) -> usize {
        self.rest_frames
    }

    /// Drift of the unloaded finger since the rest frames, as of the latest free frame.
    pub fn drift(&self) -> Option<ZeroDrift> {
        self.drift
    }

    /// Name of the finger; empty for the only finger.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Senses the forces, or adds a frame of the unloaded finger. Returns the state, or the reason of a refusal.
    fn state(&mut self, seen: &Observation, before: Option<&SensedForces>) -> Result<FrameState, String> {
        let scene = self.scene.clone();
        let seen = &*seen.renewed(&scene).map_err(|error| error.to_string())?;
        if self.rest_frames > 0 {
            self.rest.add(&self.scene, seen).map_err(|error| error.to_string())?;
            self.rest_frames -= 1;
            if self.rest_frames == 0 {
                self.begin().map_err(|refusal| refusal.to_string())?;
            }
            return Ok(FrameState::None);
        }
        if !self.measures_from_rest {
            return self.sensed_state(seen, before);
        }
        let state = self.sensed_state(&self.rest.displaced(&self.scene.finger, seen), before)?;
        if state == FrameState::None {
            self.drift = self.rest.drift(&self.scene, seen, self.noise_mm);
        }
        Ok(state)
    }

    /// Ends the rest frames. If neither the options, the scene nor the markers state a noise, the noise follows from the rest frames.
    fn begin(&mut self) -> Result<(), Refusal> {
        self.restlessness = self.rest.restlessness(&self.scene, self.noise_mm);
        if self.noise_mm.is_none() && !self.rest.states_noise() {
            self.noise_mm = self.rest.noise_mm();
            self.sensor = sensor(&self.scene, &self.contacts, &self.options, self.noise_mm, self.rest.frames())?;
        }
        Ok(())
    }

    /// Senses the forces. Returns the state, or the reason of a refusal.
    fn sensed_state(&mut self, seen: &Observation, before: Option<&SensedForces>) -> Result<FrameState, String> {
        self.sensed = self.sensor.sense(seen, before).map_err(|refusal| refusal.to_string())?;
        Ok(if self.sensed.is_some() { FrameState::Contact } else { FrameState::None })
    }
}

/// The sensor of a stream in which displacements are measured from the mean of the rest frames: the noise of this mean adds to that of the frame.
fn sensor(
    scene: &PreparedScene,
    contacts: &SensorContacts,
    options: &SensorOptions,
    noise_mm: Option<f64>,
    rest_frames: usize,
) -> Result<StreamSensor, Refusal> {
    let wider = if rest_frames == 0 { 1.0 } else { (1.0 + 1.0 / rest_frames as f64).sqrt() };
    let options = SensorOptions { noise_mm: noise_mm.map(|noise_mm| wider * noise_mm), ..options.clone() };
    StreamSensor::new(scene.clone(), contacts.clone(), options)
}

impl FingerResult<'_> {
    /// Component of the sum of all forces along the undeformed inward normal of the front plate, N.
    pub fn total_n(&self) -> f64 {
        self.sensed.map_or(0.0, |sensed| sensed.sum_along(self.finger, self.finger.direction(0.0))[0])
    }

    /// Warnings about the forces, the rest frames and the zero drift, separated by semicolons.
    pub fn warning(&self) -> Option<String> {
        let of_forces = self.sensed.into_iter().flat_map(|sensed| &sensed.warnings).map(ToString::to_string);
        let of_rest = self.restlessness.map(str::to_owned);
        let of_drift = self.drift.and_then(|drift| drift.warning());
        let warnings: Vec<String> = of_forces.chain(of_rest).chain(of_drift).collect();
        Some(warnings.join("; ")).filter(|warning| !warning.is_empty())
    }

    /// The sensed forces; none unless the finger is in contact.
    pub fn forces(&self) -> &[SensedForce] {
        self.sensed.map_or(&[], |sensed| &sensed.forces)
    }
}
