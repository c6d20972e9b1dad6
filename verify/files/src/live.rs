//! Results of a stream, one line of JSON for each evaluated frame.

use crate::recording::ContactForce;
use finray_model::sensor::{FingerResult, FrameState};
use serde::Serialize;
use std::time::Instant;

/// A frame of a stream, without its content.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameInfo {
    /// Number of the frame in the stream, from 0.
    pub number: usize,
    /// Time of the frame in its stream, s, if it is known.
    pub time_s: Option<f64>,
    /// Time at which the frame had arrived completely.
    pub arrived: Instant,
    /// Number of frames that were dropped since the last evaluated frame.
    pub dropped: usize,
}

/// One line of the result, for one frame.
#[derive(Serialize)]
pub struct Line<'a> {
    /// Number of the frame in the stream, from 0.
    frame: usize,
    /// Time of the frame in its stream, s.
    time_s: Option<f64>,
    /// State of the finger. With several fingers, this is the first state in the order contact, refused, lost, none that at least one finger has.
    pub state: FrameState,
    /// The contacts, sorted by finger; the contacts of a finger are sorted by position if the positions are estimated.
    contacts: Vec<ContactLine<'a>>,
    /// Component of the sum of all forces along the undeformed inward normal of the front plate, N. With several fingers, `total_n` is the sum of the
    /// fingers' components.
    total_n: f64,
    /// Number of markers found.
    markers: usize,
    /// Warnings about the forces, separated by semicolons.
    warning: Option<String>,
    /// Reason why no force is given.
    refused: Option<String>,
    /// Drift of the unloaded finger since the rest frames, mm; the largest of several fingers. Left out before the first free frame after the rest
    /// frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    drift_mm: Option<f64>,
    /// Result of each finger; only for several fingers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    fingers: Vec<FingerLine<'a>>,
    /// Time from the arrival of the frame to this line, ms.
    latency_ms: f64,
    /// Number of frames dropped since the previous line.
    dropped: usize,
}

/// One of several fingers.
#[derive(Serialize)]
struct FingerLine<'a> {
    finger: &'a str,
    state: FrameState,
    total_n: f64,
    markers: usize,
    warning: Option<String>,
    refused: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drift_mm: Option<f64>,
}

/// One contact: position (mm from the base), direction (degrees), force, and standard deviation and 95 % interval of the force (N); with several
/// fingers, also the finger's name.
#[derive(Serialize)]
struct ContactLine<'a> {
    #[serde(skip_serializing_if = "str::is_empty")]
    finger: &'a str,
    contact: String,
    s_mm: Option<f64>,
    angle_deg: f64,
    force_n: f64,
    sigma_n: f64,
    interval_n: [f64; 2],
    /// Standard deviations of an estimated position, mm, and direction, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    s_sigma_mm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    angle_sigma_deg: Option<f64>,
}

impl<'a> Line<'a> {
    /// The line of a frame from the results of all fingers.
    pub fn new(frame: &FrameInfo, results: &'a [FingerResult<'a>]) -> Line<'a> {
        let is_one = matches!(results, [_]);
        let said = |of: fn(&FingerResult) -> Option<String>| {
            let said = results.iter().filter_map(|result| {
                let text = of(result)?;
                Some(if is_one { text } else { format!("{}: {text}", result.name) })
            });
            Some(said.collect::<Vec<_>>().join("; ")).filter(|said| !said.is_empty())
        };
        let by_rank = [FrameState::Contact, FrameState::Refused, FrameState::Lost];
        let state = by_rank.into_iter().find(|state| results.iter().any(|result| result.state == *state));
        let finger = |result: &'a FingerResult| FingerLine {
            finger: result.name,
            state: result.state,
            total_n: result.total_n(),
            markers: result.markers,
            warning: result.warning(),
            refused: result.refused.clone(),
            drift_mm: result.drift.map(|drift| drift.rms_mm),
        };
        Line {
            frame: frame.number,
            time_s: frame.time_s,
            state: state.unwrap_or(FrameState::None),
            contacts: results.iter().flat_map(contact_lines).collect(),
            total_n: results.iter().map(FingerResult::total_n).sum(),
            markers: results.iter().map(|result| result.markers).sum(),
            warning: said(|result| result.warning()),
            refused: said(|result| result.refused.clone()),
            drift_mm: results.iter().filter_map(|result| result.drift).map(|drift| drift.rms_mm).reduce(f64::max),
            fingers: if is_one { Vec::new() } else { results.iter().map(finger).collect() },
            latency_ms: frame.arrived.elapsed().as_secs_f64() * 1e3,
            dropped: frame.dropped,
        }
    }

    /// The line as JSON, without a line break.
    ///
    /// # Errors
    /// A `serde_json::Error` from the JSON writer; none is expected.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self)
    }
}

fn contact_lines<'a>(result: &'a FingerResult<'a>) -> impl Iterator<Item = ContactLine<'a>> {
    result.forces().iter().map(|sensed| ContactLine {
        finger: result.name,
        contact: sensed.contact.position.name(),
        s_mm: sensed.contact.position_mm(result.finger),
        angle_deg: sensed.contact.angle_deg,
        force_n: sensed.force_n,
        sigma_n: sensed.sigma_n,
        interval_n: sensed.interval_n(),
        s_sigma_mm: sensed.uncertainty.position_sd_mm,
        angle_sigma_deg: sensed.uncertainty.direction_sd_deg,
    })
}

/// The forces of a frame as vectors.
pub fn contact_forces(result: &FingerResult) -> Vec<ContactForce> {
    let forces = result.forces().iter().zip(1..).map(|(sensed, contact)| ContactForce {
        finger: result.name.to_owned(),
        contact,
        force: sensed.contact.direction(result.finger) * sensed.force_n,
    });
    forces.collect()
}
