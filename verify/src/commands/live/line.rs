//! One line of JSON for each frame.

use super::input::Frame;
use crate::commands::prelude::*;
use finray_model::sensing::ContactPosition;
use finray_model::sensor::SensedForces;

/// Result of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Contact forces are sensed.
    Contact,
    /// The finger carries no detectable force: noise explains the displacements, or the interval of the force contains zero. Also the state of rest frames.
    None,
    /// No force can be estimated; `refused` states the reason.
    Refused,
    /// The finger is not found in the image.
    Lost,
}

/// A line of the result: one frame.
#[derive(Serialize)]
pub struct Line {
    /// Number of the frame in the stream, from 0.
    frame: usize,
    /// Time of the frame in its stream, s.
    time_s: Option<f64>,
    /// Whether forces are sensed, and if not, why.
    pub state: State,
    /// The contacts, in the order of their positions if these are estimated.
    contacts: Vec<ContactLine>,
    /// Component of the sum of all forces along the undeformed inward normal of the front plate, N.
    total_n: f64,
    /// Number of markers found.
    markers: usize,
    /// Warnings about the forces, separated by semicolons.
    warning: Option<String>,
    /// Reason why no force is given.
    refused: Option<String>,
    /// Time from the arrival of the frame to this line, ms.
    latency_ms: f64,
    /// Number of frames dropped since the previous line.
    dropped: usize,
}

/// One contact: its position (mm from the base) and direction (degrees), its force, and the standard deviation and 95 % interval of the force (N).
#[derive(Serialize)]
struct ContactLine {
    contact: String,
    s_mm: Option<f64>,
    angle_deg: f64,
    force_n: f64,
    sigma_n: f64,
    interval_n: [f64; 2],
}

impl Line {
    /// A line without forces; `refused` says why, unless the finger is free.
    pub fn without_forces(frame: &Frame, state: State, markers: usize, refused: Option<String>) -> Line {
        Line {
            frame: frame.number,
            time_s: frame.time_s,
            state,
            contacts: Vec::new(),
            total_n: 0.0,
            markers,
            warning: None,
            refused,
            latency_ms: 0.0,
            dropped: frame.dropped,
        }
        .just_now(frame)
    }

    /// A line with forces.
    pub fn of_forces(frame: &Frame, finger: &Finger, sensed: &SensedForces, markers: usize) -> Line {
        let contact = |(i, contact): (usize, &finray_model::sensing::Contact)| ContactLine {
            contact: match contact.position {
                ContactPosition::Node(node) => node.to_string(),
                ContactPosition::At(_) => "at".to_owned(),
            },
            s_mm: contact.position_mm(finger),
            angle_deg: contact.angle_deg,
            force_n: sensed.forces_n[i],
            sigma_n: sensed.sigmas_n[i],
            interval_n: sensed.interval_n(i),
        };
        let warnings: Vec<String> = sensed.warnings.iter().map(ToString::to_string).collect();
        let [total_n, _] = sensed.sum_along(finger, finger.direction(0.0));
        Line {
            contacts: sensed.contacts.iter().enumerate().map(contact).collect(),
            total_n,
            warning: Some(warnings.join("; ")).filter(|warning| !warning.is_empty()),
            ..Line::without_forces(frame, State::Contact, markers, None)
        }
        .just_now(frame)
    }

    fn just_now(self, frame: &Frame) -> Line {
        Line { latency_ms: frame.arrived.elapsed().as_secs_f64() * 1e3, ..self }
    }

    /// The line as JSON, without a line break.
    ///
    /// # Errors
    /// [`Failure::NotComputed`] from the JSON writer; none is expected.
    pub fn to_json(&self) -> Result<String, Failure> {
        serde_json::to_string(self).map_err(not_computed)
    }
}
