//! Sensing with an assumed contact: its position and direction are wrong by as much as a user may misjudge them.

use super::Context;
use super::causes::{DIRECTION_OFF_DEG, POSITION_OFF_MM};
use crate::prelude::*;
use crate::sampling::map::{AccuracyMap, MapRequest, accuracy_maps};
use crate::truths::TruthError;

/// The estimator recommended for a known contact.
const ESTIMATOR: EstimatorId = EstimatorId::Nonlinear;
/// Number of combinations of a position error and a direction error, each of either sign.
const SIDES: usize = 4;

/// Accuracy map of the co-rotational finger for the nonlinear estimator with [assumed contacts](AssumedContact). `None` without noise.
pub(crate) fn run(context: &Context) -> Result<Option<AccuracyMap>, TruthError> {
    let &Context { finger, noise_mm, forces, effort, .. } = context;
    if noise_mm == 0.0 {
        return Ok(None);
    }
    let (positions, step_deg, _) = effort.coarse_resolution();
    let (positions_mm, angles_deg) = MapRequest::grid(finger, positions, step_deg);
    let request = MapRequest {
        positions_mm,
        angles_deg,
        forces_n: forces.of_maps_n().to_vec(),
        noise_levels_mm: vec![noise_mm],
        noise_samples: SIDES,
        seed: 1,
    };
    context.progress.part("assumed contacts", request.contact_count());
    let mesh = ESTIMATOR.mesh(finger);
    let informed = ESTIMATOR.on(&mesh, context.networks);
    let assumed = AssumedContact { informed: &*informed, finger };
    Ok(accuracy_maps(finger, context.corotational, &[&assumed], &request, &|| context.progress.step()).pop())
}

/// An estimator that receives contacts with wrong positions (by [`POSITION_OFF_MM`]) and wrong directions (by [`DIRECTION_OFF_DEG`]). Successive
/// estimates take the combinations of signs in turn. Positions off the plate are omitted.
pub struct AssumedContact<'e> {
    /// The estimator that gets the wrong contacts.
    pub informed: &'e dyn Estimator,
    /// The finger on which the contacts lie.
    pub finger: &'e Finger,
}

impl Estimator for AssumedContact<'_> {
    fn id(&self) -> EstimatorId {
        self.informed.id()
    }

    fn prepare<'a>(
        &'a self,
        contacts: &[Contact],
        markers: &Measurement,
    ) -> Result<Box<dyn PreparedEstimator + 'a>, EstimatorError> {
        let length_mm = self.finger.plate_length_mm(Plate::Front);
        let mut sides = Vec::with_capacity(SIDES);
        let mut beyond = None;
        for by_mm in [-POSITION_OFF_MM, POSITION_OFF_MM] {
            for by_deg in [-DIRECTION_OFF_DEG, DIRECTION_OFF_DEG] {
                let off = |contact: &Contact| {
                    let s_mm = contact.position_mm(self.finger).unwrap_or(f64::NAN) + by_mm;
                    Contact { position: ContactPosition::At(s_mm), angle_deg: contact.angle_deg + by_deg }
                };
                let off: Vec<Contact> = contacts.iter().map(off).collect();
                let on_plate = |contact: &Contact| matches!(contact.position, ContactPosition::At(s_mm) if s_mm > 0.0 && s_mm <= length_mm);
                match off.iter().all(on_plate) {
                    true => sides.push(self.informed.prepare(&off, markers)?),
                    false => beyond = Some(off),
                }
            }
        }
        match beyond.filter(|_| sides.is_empty()) {
            // On a plate too short for any wrong position, the estimator gets a contact off the plate and reports the error of this contact.
            Some(off) => self.informed.prepare(&off, markers),
            None => Ok(Box::new(InTurn { sides, next: 0 })),
        }
    }
}

struct InTurn<'a> {
    sides: Vec<Box<dyn PreparedEstimator + 'a>>,
    next: usize,
}

impl PreparedEstimator for InTurn<'_> {
    fn estimate(&mut self, measurement: &Measurement, noise_mm: Option<f64>) -> Result<Sensed, EstimatorError> {
        let side = self.next % self.sides.len();
        self.next += 1;
        self.sides[side].estimate(measurement, noise_mm)
    }
}
