//! Causes of sensing errors at one position and direction.

use super::models::{Known, Models};
use super::{Cause, CauseCell, ContactKnowledge, DIRECTION_OFF_DEG, POSITION_OFF_MM, Practice, REMEDIES};
use crate::prelude::*;
use crate::truths::Truth;

/// One way in which a user senses a force: the estimator with all its settings.
pub(super) struct Sensor<'m> {
    pub practice: Practice,
    pub contact: ContactKnowledge,
    pub models: &'m Models,
    /// Standard deviation of the noise of a measured coordinate, mm.
    pub noise_mm: f64,
    pub zones_known: bool,
    pub causes: Vec<Cause>,
}

/// Cells (results) of each sensor at one position (mm) and direction (degrees), one cell for each force (N).
pub(super) fn cells(
    truth: &dyn Truth,
    sensors: &[Sensor],
    s_mm: f64,
    angle_deg: f64,
    forces_n: &[f64],
) -> Vec<Vec<CauseCell>> {
    let contact = Contact { position: ContactPosition::At(s_mm), angle_deg };
    let shapes = truth.shapes(&contact, forces_n);
    let of_sensor = |sensor: &Sensor| {
        let seen: Vec<_> = shapes.iter().map(|shape| Measurement::of_shape(sensor.models.finger(), shape)).collect();
        let with_all = sensor.errors(&seen, s_mm, angle_deg, forces_n, &[]);
        let without: Vec<_> = sensor
            .causes
            .iter()
            .map(|&cause| match cause {
                Cause::Noise => with_all.iter().map(|error| error.map(Squared::without_noise)).collect(),
                cause => sensor.errors(&seen, s_mm, angle_deg, forces_n, &[cause]),
            })
            .collect();
        let remedied: Vec<_> = (1..=REMEDIES.len())
            .map(|taken| {
                let off: Vec<Cause> = REMEDIES[..taken].iter().flat_map(|(_, causes)| *causes).copied().collect();
                sensor.errors(&seen, s_mm, angle_deg, forces_n, &off)
            })
            .collect();
        let cell = |(i, &force_n): (usize, &f64)| {
            let all = with_all[i].map(Squared::sum);
            let share = |without: &Vec<Option<Squared>>| Some(1.0 - without[i]?.sum() / all?);
            CauseCell {
                s_mm,
                angle_deg,
                force_n,
                rms_error: all.map(f64::sqrt),
                shares: without.iter().map(share).collect(),
                remedied: remedied.iter().map(|errors| Some(errors[i]?.sum().sqrt())).collect(),
            }
        };
        forces_n.iter().enumerate().map(cell).collect()
    };
    sensors.iter().map(of_sensor).collect()
}

/// Contacts near a position (mm) and direction (degrees). Each flag states whether that quantity, `position` or `direction`, is wrong to both sides
/// in turn or exact. Positions off the plate are omitted.
pub(super) fn beside(finger: &Finger, s_mm: f64, angle_deg: f64, [position, direction]: [bool; 2]) -> Vec<Contact> {
    let sides = |off: bool, by: f64| if off { vec![-by, by] } else { vec![0.0] };
    let length_mm = finger.plate_length_mm(Plate::Front);
    let mut contacts = Vec::new();
    for off_mm in sides(position, POSITION_OFF_MM) {
        for off_deg in sides(direction, DIRECTION_OFF_DEG) {
            let position_mm = s_mm + off_mm;
            if position_mm > 0.0 && position_mm <= length_mm {
                let position = ContactPosition::At(position_mm);
                contacts.push(Contact { position, angle_deg: angle_deg + off_deg });
            }
        }
    }
    contacts
}

/// Mean square of sensed / true - 1, split into `bias` and `noise`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Squared {
    /// Squared error without noise.
    bias: f64,
    /// Variance caused by noise.
    noise: f64,
}

impl Squared {
    fn of(sensed_n: f64, sigma_n: f64, force_n: f64) -> Squared {
        Squared { bias: (sensed_n / force_n - 1.0).powi(2), noise: (sigma_n / force_n).powi(2) }
    }

    /// Squared error of the nonlinear estimator on a noise-free shape under `force_n` (N), and the variance that noise of `noise_mm` (mm) causes;
    /// `None` if the estimator refuses.
    pub(super) fn of_nonlinear(
        estimator: &mut NonlinearEstimator,
        seen: &Measurement,
        force_n: f64,
        noise_mm: f64,
    ) -> Option<Squared> {
        estimator.reset();
        // The stated noise only sets the size above which a misfit counts as an outlier.
        let sensed = estimator.estimate(seen, Some(noise_mm.max(LEAST_STATED_MM))).ok()?.forces;
        // With a wrong model, the stated standard deviation reflects the residual instead of the noise. It is therefore scaled to the noise.
        Some(Squared::of(sensed.forces_n[0], sensed.sigmas_n[0] * noise_mm / sensed.noise_mm, force_n))
    }

    pub(super) fn sum(self) -> f64 {
        self.bias + self.noise
    }

    fn without_noise(self) -> Squared {
        Squared { noise: 0.0, ..self }
    }
}

impl Sensor<'_> {
    /// Squared errors without the causes in `off`, averaged over all assumed contacts, by force. `None` if the finger has no equilibrium or sensing refuses.
    fn errors(
        &self,
        seen: &[Measurement],
        s_mm: f64,
        angle_deg: f64,
        forces_n: &[f64],
        off: &[Cause],
    ) -> Vec<Option<Squared>> {
        let on = |cause: Cause| !off.contains(&cause) && !self.contact.leaves_out().contains(&cause);
        let is_linear = self.practice == Practice::LeastSquares && on(Cause::Linearisation);
        let known = Known {
            base: self.zones_known || !on(Cause::BaseCompliance),
            tip: self.zones_known || !on(Cause::TipCompliance),
            modulus: !on(Cause::Modulus),
            kinematics: if is_linear { Kinematics::Linear } else { Kinematics::Corotational },
        };
        let off = [on(Cause::Position), on(Cause::Direction)];
        let assumed = beside(self.models.finger(), s_mm, angle_deg, off);
        let mut sums = vec![Some(Squared { bias: 0.0, noise: 0.0 }); forces_n.len()];
        for contact in &assumed {
            let errors = self.sense(known, contact, seen, forces_n);
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum = sum.zip(errors.get(i).copied().flatten()).map(|(sum, error)| Squared {
                    bias: sum.bias + error.bias / assumed.len() as f64,
                    noise: sum.noise + error.noise / assumed.len() as f64,
                });
            }
        }
        sums
    }

    /// Squared errors of sensing with one model, by shape.
    fn sense(&self, known: Known, contact: &Contact, seen: &[Measurement], forces_n: &[f64]) -> Vec<Option<Squared>> {
        let mesh = self.models.mesh(known);
        let Some(markers) = seen.first() else { return Vec::new() };
        let pairs = seen.iter().zip(forces_n);
        if known.kinematics == Kinematics::Linear {
            let Ok(estimator) = LinearEstimator::new(mesh.finger(), &[*contact], markers) else { return Vec::new() };
            let sense = |(seen, &force_n): (&Measurement, &f64)| {
                let sensed = estimator.estimate(seen, Some(self.noise_mm), Prior::None);
                // If the linear model does not fit the measurement, the stated standard deviation reflects the residual, whereas `noise_n` reflects
                // only the noise.
                let noise_n = estimator.inverse().sigmas_per_noise[0] * self.noise_mm;
                Some(Squared::of(sensed.forces_n[0], noise_n, force_n))
            };
            return pairs.map(sense).collect();
        }
        let Ok(mut estimator) = NonlinearEstimator::new(mesh, &[(*contact).into()]) else { return Vec::new() };
        let sense = |(seen, &force_n): (&Measurement, &f64)| {
            Squared::of_nonlinear(&mut estimator, seen, force_n, self.noise_mm)
        };
        pairs.map(sense).collect()
    }
}
