//! Evaluation of one finger in the frames of a stream.

use super::input::{Content, Frame};
use super::line::{FingerResult, State};
use finray_imaging::locate::{LocateError, Observer};
use finray_model::Scene;
use finray_model::observation::Observation;
use finray_model::sensor::{RestPositions, SensedForces, StreamSensor};

/// A finger in the stream: marker locator, sensor, and positions of the markers on the unloaded finger.
pub struct WatchedFinger<'s> {
    /// Name of the finger; empty for the only finger.
    pub name: &'s str,
    pub scene: &'s Scene,
    pub sensor: StreamSensor<'s>,
    /// Locator of the markers; `None` for a stream of positions.
    pub observer: Option<Observer<'s>>,
    pub rest: RestPositions,
    /// Number of frames of the unloaded finger that are still to be read.
    pub rest_frames: usize,
    /// Whether the first frames show the unloaded finger.
    pub measures_from_rest: bool,
    /// Forces of the last evaluated frame, if it showed any.
    pub sensed: Option<SensedForces>,
}

impl WatchedFinger<'_> {
    /// Evaluates a frame.
    pub fn evaluate(&mut self, frame: &Frame) -> FingerResult<'_> {
        let before = self.sensed.take();
        let (state, markers, refused) = match self.observed(frame) {
            Err((state, reason)) => (state, 0, Some(reason)),
            Ok(seen) => {
                let markers = seen.markers.len();
                let (state, refused) = match self.state(&seen, before.as_ref()) {
                    Ok(state) => (state, None),
                    Err(reason) => (State::Refused, Some(reason)),
                };
                (state, markers, refused)
            }
        };
        let &mut WatchedFinger { name, scene, ref sensed, .. } = self;
        FingerResult { name, finger: &scene.finger, state, markers, sensed: sensed.as_ref(), refused }
    }

    /// Refuses a frame for a reason that concerns all fingers.
    pub fn refuse(&mut self, reason: String) -> FingerResult<'_> {
        self.sensed = None;
        let &mut WatchedFinger { name, scene, .. } = self;
        FingerResult {
            name,
            finger: &scene.finger,
            state: State::Refused,
            markers: 0,
            sensed: None,
            refused: Some(reason),
        }
    }

    /// The markers of this finger in a frame, or the state without markers and its reason.
    fn observed(&mut self, frame: &Frame) -> Result<Observation, (State, String)> {
        match (&frame.content, &mut self.observer) {
            (Content::Pixels(image), Some(observer)) => observer.observe(image).map_err(|error| match error {
                LocateError::Size { .. } => (State::Refused, error.to_string()),
                _ => (State::Lost, error.to_string()),
            }),
            (Content::Pixels(_), None) => Err((State::Refused, "expected positions, found an image".to_owned())),
            (Content::Markers(fingers), _) => {
                let of_this = fingers.iter().find(|of| of.finger == self.name);
                match of_this {
                    Some(of_this) => Ok(of_this.seen.clone()),
                    None if fingers.is_empty() => Ok(Observation::default()),
                    None => Err((State::Lost, "the frame has no markers of this finger".to_owned())),
                }
            }
            (Content::Unreadable(reason), _) => Err((State::Refused, reason.clone())),
        }
    }

    /// Senses the forces, or adds a frame of the unloaded finger. Returns the state, or the reason of a refusal.
    fn state(&mut self, seen: &Observation, before: Option<&SensedForces>) -> Result<State, String> {
        if self.rest_frames > 0 {
            // A frame with markers that the finger does not have is refused; as a rest frame it would make every later frame invalid.
            let found = seen.for_sensing(self.scene, true, None).map_err(|error| error.to_string())?;
            if found.measurement.markers().is_empty() {
                return Err("no marker is seen".to_owned());
            }
            self.rest_frames -= 1;
            self.rest.add(seen);
            return Ok(State::None);
        }
        let displaced = self.measures_from_rest.then(|| self.rest.displaced(seen));
        let sensed = self.sensor.sense(displaced.as_ref().unwrap_or(seen), before);
        self.sensed = sensed.map_err(|refusal| refusal.to_string())?;
        Ok(if self.sensed.is_some() { State::Contact } else { State::None })
    }
}
