//! Sensing with the large-rotation finger itself: Gauss-Newton on forces, places and directions.
//!
//! An estimate starts from least squares on the linear finger ([`start`]) or from the estimate before it, walks to the
//! nearest minimum ([`search`]) of the difference between measured and computed shape ([`linearised`]), and is judged
//! before it is handed out ([`judgement`]).

mod judgement;
mod linearised;
mod refine;
mod search;
mod start;
mod unknowns;

pub use refine::sense_refining;

use super::{Contact, ContactPlace, ContactQuestion, Direction, Estimate, SensingError, check_contacts};
use crate::frame::FrameMotion;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::statics::{FrameLoad, Ladder, Statics};
use crate::{Finger, Kinematics};
use search::Found;

/// A minimum that leaves more than this share of the displacements, or this many standard deviations, unexplained may
/// be a wrong one: the search starts again from the linear forces times other factors, and the best minimum counts.
const POOR_FIT: f64 = 0.02;
const POOR_FIT_SIGMAS: f64 = 3.0;
const OTHER_STARTS: [f64; 4] = [1.0, -1.0, 0.3, -0.3];

/// Sensed forces with the places and directions that go with them.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearEstimate {
    /// Forces, their standard deviations and what these rest on.
    pub forces: Estimate,
    /// Place and direction of each contact as given or found.
    pub contacts: Vec<Contact>,
    /// Gauss-Newton steps taken.
    pub steps: usize,
}

/// Senses forces with the co-rotational finger of one mesh; each estimate starts from the one before it, if there is
/// one, as a stream of camera frames wants it.
///
/// # Requirements
/// At least as many measured coordinates as unknowns (a force a contact, and one more for each unknown place or
/// direction), singular values that span at most [`LARGEST_SPAN`].
///
/// # Reference
/// Minimises |W (u - u(f, s, angle))|^2 by the Levenberg-Marquardt method (Nocedal and Wright, Numerical Optimization,
/// sec. 10.3), u() the equilibrium of the co-rotational finger, its derivatives from the factored tangent. Markers that
/// are wildly off are weighted down (iteratively reweighted least squares).
#[derive(Debug, Clone)]
pub struct NonlinearEstimator<'m> {
    mesh: &'m Mesh,
    questions: Vec<ContactQuestion>,
    statics: Statics<Ladder<'m>>,
    last: Option<State>,
}

/// Unknowns and the equilibrium that belongs to them.
#[derive(Debug, Clone)]
struct State {
    forces_n: Vec<f64>,
    contacts: Vec<Contact>,
    loads: Vec<FrameLoad>,
    motion: FrameMotion,
}

impl<'m> NonlinearEstimator<'m> {
    /// Prepares a mesh for contacts.
    ///
    /// # Errors
    /// [`SensingError`] for contacts that are not on the free front plate or the same twice.
    pub fn new(mesh: &'m Mesh, questions: &[ContactQuestion]) -> Result<NonlinearEstimator<'m>, SensingError> {
        let finger = mesh.finger();
        if questions.is_empty() {
            return Err(SensingError::NoContact);
        }
        // What is known of each contact must be possible; an unknown direction or place takes any value for that.
        for question in questions {
            let angle_deg = if let Direction::Angle(angle) = question.direction { angle } else { 0.0 };
            let place = question.place.unwrap_or(ContactPlace::Node(finger.tip()));
            check_contacts(finger, &[Contact { place, angle_deg }])?;
        }
        let known: Option<Vec<Contact>> = questions.iter().map(ContactQuestion::known).collect();
        if let Some(contacts) = known {
            check_contacts(finger, &contacts)?;
        }
        Ok(NonlinearEstimator {
            mesh,
            questions: questions.to_vec(),
            statics: Statics::ladder(mesh, Kinematics::Corotational),
            last: None,
        })
    }

    /// Forgets the last estimate: the next one starts from least squares.
    pub fn reset(&mut self) {
        self.last = None;
    }

    fn finger(&self) -> &'m Finger {
        self.mesh.finger()
    }

    /// Estimates the forces. `noise_mm` is the standard deviation of one coordinate; without it, it is estimated from
    /// the residual.
    ///
    /// # Errors
    /// [`SensingError`] if the data do not tell the unknowns, or no equilibrium explains them.
    pub fn estimate(
        &mut self,
        measurement: &Measurement,
        noise_mm: Option<f64>,
    ) -> Result<NonlinearEstimate, SensingError> {
        let unknowns = self.unknowns();
        let coordinates = measurement.coordinate_count();
        if unknowns.len() > coordinates {
            return Err(SensingError::TooFewMarkers { unknowns: unknowns.len(), coordinates });
        }
        let moved: f64 = measurement.markers().iter().map(|m| m.displacement.norm_squared()).sum();
        let poor = (POOR_FIT * (moved / coordinates as f64).sqrt()).max(POOR_FIT_SIGMAS * noise_mm.unwrap_or(0.0));
        let explains = |found: &Found| found.linearised.residual.norm() / (coordinates as f64).sqrt() <= poor;
        let mut best: Option<Found> = None;
        let mut failure = None;
        let warm = self.last.take();
        let starts = warm.is_some().then_some(None).into_iter().chain(OTHER_STARTS.map(Some));
        for factor in starts {
            let start = match factor {
                None => warm.clone().map_or_else(|| self.start(measurement, 1.0), Ok),
                Some(factor) => self.start(measurement, factor),
            };
            match start.and_then(|state| self.search(state, measurement, noise_mm, &unknowns)) {
                Ok(found) => {
                    let residual = found.linearised.residual.norm();
                    if best.as_ref().is_none_or(|best| residual < best.linearised.residual.norm()) {
                        best = Some(found);
                    }
                }
                Err(error) => failure = failure.or(Some(error)),
            }
            if best.as_ref().is_some_and(explains) {
                break;
            }
        }
        let found = best.ok_or_else(|| failure.unwrap_or(SensingError::NoContact))?;
        let estimate = self.judged(&found, &unknowns, noise_mm)?;
        self.last = Some(found.state);
        Ok(estimate)
    }

    /// The contacts' forces on the frame.
    fn loads(&self, contacts: &[Contact], forces_n: &[f64]) -> Result<Vec<FrameLoad>, SensingError> {
        let loads =
            contacts.iter().zip(forces_n).map(|(contact, f)| self.mesh.frame_load(&contact.load(self.finger(), *f)));
        Ok(loads.collect::<Result<_, _>>()?)
    }
}
