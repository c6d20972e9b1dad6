//! Covariance and identifiability tests of an estimate.

use super::leaning::FoundLean;
use super::touching::Touching;
use super::unknowns::Unknown;
use super::{NonlinearEstimate, NonlinearEstimator, State, largest_explained_rms_mm};
use crate::finger::Plate;
use crate::frame::FrameMotion;
use crate::measurement::Measurement;
use crate::sensing::residual_test::noise_of;
use crate::sensing::{
    Contact, ContactQuestion, Direction, Estimate, LARGEST_SPAN, ResidualTest, SensingError, Warning,
};
use nalgebra::{DMatrix, DVector};

/// A direction is not identifiable if its standard deviation exceeds this angle, degrees. A position is not identifiable if its standard deviation
/// exceeds the share `LARGEST_POSITION_SIGMA` of the plate's length.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;
pub(crate) const LARGEST_POSITION_SIGMA: f64 = 0.25;
/// Another minimum explains the data equally well if its misfit (sum of squared residuals) exceeds the smallest misfit by at most this many noise variances.
/// The forces of the two minima count as different if one force differs by more than `ANOTHER_ANSWER_SIGMAS` standard deviations.
pub(super) const AS_GOOD: f64 = 9.0;
const ANOTHER_ANSWER_SIGMAS: f64 = 5.0;
/// Without noise, forces count as equal up to a difference of this share of the largest force.
const SAME_ANSWER: f64 = 1e-3;
/// Other positions widen a standard deviation only if it grows by more than this factor. Smaller growth hardly changes how often intervals hold.
const CURVED: f64 = 1.5;
/// An estimate is confirmed if it fits at least this number of measured coordinates per force.
const CONFIRMING_COORDINATES: usize = 4;

impl NonlinearEstimate {
    /// Refuses an estimate with a significant force if zero forces explain the data equally well. Near buckling, a small force causes large
    /// displacements, so noise may be mistaken for a force. Both misfits are in mm^2.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`] for the first force that differs significantly from zero.
    pub(super) fn check_against_nothing(&self, misfit: f64, misfit_at_rest: f64) -> Result<(), SensingError> {
        let Estimate { forces_n, sigmas_n, noise_mm, .. } = &self.forces;
        if misfit_at_rest - misfit > AS_GOOD * noise_mm * noise_mm {
            return Ok(());
        }
        let claimed = (0..forces_n.len()).find(|&i| forces_n[i].abs() > ANOTHER_ANSWER_SIGMAS * sigmas_n[i]);
        claimed.map_or(Ok(()), |i| Err(SensingError::Ambiguous { contact: i + 1, force_n: forces_n[i], other_n: 0.0 }))
    }

    /// Refuses an estimate if other forces explain the data equally well, even if the misfit of the other forces is no minimum. For a linear finger,
    /// forces whose misfit exceeds the smallest misfit by at most [`AS_GOOD`] noise variances lie within three standard deviations of the estimate.
    /// `others` lists misfits, mm^2, and forces, N.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`] for the first force that differs.
    pub(super) fn check_other_forces<'s>(
        &self,
        misfit: f64,
        others: impl Iterator<Item = (f64, &'s Vec<f64>)>,
    ) -> Result<(), SensingError> {
        for (other_misfit, other_n) in others {
            self.is_confirmed_by(other_n, other_misfit - misfit)?;
        }
        Ok(())
    }

    /// Refuses an estimate of several forces if there are no redundant coordinates and the estimate differs from the forces that fit the linear
    /// finger. Without redundant coordinates, many equilibria may explain the measurement exactly. If the search started from the forces that fit the
    /// linear finger, these forces are the first entry of `starts`.
    ///
    /// # Errors
    /// [`SensingError::Unconfirmed`] if the estimate is refused.
    pub(super) fn check_unconfirmed(
        &self,
        coordinates: usize,
        starts: &[(Vec<f64>, FrameMotion)],
    ) -> Result<(), SensingError> {
        let count = self.forces.forces_n.len();
        let is_far = starts.first().is_some_and(|(linear_n, _)| self.other_answer(linear_n).is_some());
        if count > 1 && coordinates <= count && is_far { Err(SensingError::Unconfirmed) } else { Ok(()) }
    }

    /// Whether the forces `other_n`, N, equal the forces of this estimate within its standard deviations. The misfit of `other_n` exceeds the misfit
    /// of this estimate by `excess`, mm^2.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`] if the other forces differ and explain the data equally well.
    fn is_confirmed_by(&self, other_n: &[f64], excess: f64) -> Result<bool, SensingError> {
        match self.other_answer(other_n) {
            Some(i) if excess <= AS_GOOD * self.forces.noise_mm.powi(2) => {
                let (force_n, other_n) = (self.forces.forces_n[i], other_n[i]);
                Err(SensingError::Ambiguous { contact: i + 1, force_n, other_n })
            }
            other => Ok(other.is_none()),
        }
    }

    /// Index of the first force in `other_n`, N, that differs from this estimate's force by more than its standard deviation allows.
    fn other_answer(&self, other_n: &[f64]) -> Option<usize> {
        let Estimate { forces_n, sigmas_n, .. } = &self.forces;
        let largest = forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let same = |i: usize| f64::max(ANOTHER_ANSWER_SIGMAS * sigmas_n[i], SAME_ANSWER * largest);
        (0..forces_n.len()).find(|&i| (forces_n[i] - other_n[i]).abs() > same(i))
    }

    /// Refuses an estimate if another minimum explains the data equally well. Also refuses an estimate from few coordinates if `near` is `false` and
    /// no second minimum confirms the estimate. `near` is `true` if the minimum is locally unique or the equilibria were scanned. `minima` lists
    /// misfit, mm^2, and forces, N, of each minimum.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`] for another minimum, [`SensingError::Unconfirmed`] for an estimate that nothing confirms.
    pub(super) fn check_rivals(
        &self,
        misfit: f64,
        minima: &[(f64, Vec<f64>)],
        near: bool,
        coordinates: usize,
    ) -> Result<(), SensingError> {
        let mut confirmations = 0;
        for (other_misfit, other_n) in minima {
            confirmations += usize::from(self.is_confirmed_by(other_n, other_misfit - misfit)?);
        }
        // One of the minima is the estimate, so a confirmation needs a second minimum. A fit of many coordinates also confirms the estimate.
        let confirmed =
            near || confirmations >= 2 || coordinates >= CONFIRMING_COORDINATES * self.forces.forces_n.len();
        if confirmed { Ok(()) } else { Err(SensingError::Unconfirmed) }
    }

    /// Widens the covariance by another minimum with forces that count as equal, if the minimum explains the data equally well and is separate. The forces
    /// of the other minimum are as likely as the ratio of the likelihoods states. The minimum that widens most counts. `minima` lists misfit, mm^2, and
    /// forces, N, of each minimum, and `misfit` is the misfit of the estimate.
    pub(super) fn widen_by_rivals(&mut self, misfit: f64, minima: &[(f64, Vec<f64>)]) {
        let variance_mm2 = self.forces.noise_mm.powi(2);
        let Estimate { forces_n, sigmas_n, .. } = &self.forces;
        let off = |(other_misfit, other_n): &(f64, Vec<f64>)| {
            let likelihood = (-0.5 * (other_misfit - misfit) / variance_mm2).exp().min(1.0);
            DVector::from_iterator(
                forces_n.len(),
                forces_n.iter().zip(other_n).map(|(force_n, other_n)| likelihood.sqrt() * (other_n - force_n)),
            )
        };
        let size = |off: &DVector<f64>| {
            off.iter().zip(sigmas_n).map(|(off_n, sigma_n)| (off_n / sigma_n).powi(2)).sum::<f64>()
        };
        let largest =
            minima.iter().map(off).filter(|off| size(off).is_finite()).max_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(off) = largest else { return };
        self.covariance_n2 += &off * off.transpose();
        for (sigma_n, off_n) in self.forces.sigmas_n.iter_mut().zip(&off) {
            *sigma_n = sigma_n.hypot(*off_n);
        }
    }

    /// Widens standard deviations if the misfit grows less towards other forces than it does for a linear finger, for which it grows by the squared number of
    /// standard deviations. A position may then change far, and the forces with it. `others` lists misfit, mm^2, and forces, N, for other positions, and `misfit`
    /// is the misfit of the estimate.
    pub(super) fn widen_by_positions(&mut self, misfit: f64, others: &[(f64, Vec<f64>)]) {
        let variance_mm2 = self.forces.noise_mm.powi(2);
        for (other_misfit, other_n) in others {
            let growth = (other_misfit - misfit) / variance_mm2;
            if growth > AS_GOOD || growth.is_nan() {
                continue;
            }
            let growth = growth.max(1.0);
            for (i, other_n) in other_n.iter().enumerate() {
                let needed_n2 = (other_n - self.forces.forces_n[i]).powi(2) / growth;
                let stated_n2 = self.forces.sigmas_n[i].powi(2);
                if needed_n2 <= stated_n2 * CURVED * CURVED {
                    continue;
                }
                let further_n2 = needed_n2 - stated_n2;
                self.covariance_n2[(i, i)] += further_n2;
                self.forces.sigmas_n[i] = self.forces.sigmas_n[i].hypot(further_n2.sqrt());
            }
        }
    }
}

/// The estimated contact. A known direction replaces the estimated direction. The angle is reduced to the range from -180 to 180 degrees.
fn answered(contact: &Contact, question: &ContactQuestion) -> Contact {
    let angle_deg = match question.direction {
        Direction::Angle(angle_deg) => angle_deg,
        _ => contact.angle_deg,
    };
    Contact { angle_deg: angle_deg - 360.0 * ((angle_deg + 180.0) / 360.0).floor(), ..*contact }
}

impl NonlinearEstimator<'_> {
    /// Estimated lean (angle between force and normal) of a contact. `None` unless the direction is [`Direction::Leaning`]. `covariance_n2` returns the
    /// covariance of each force with the force across the contact's direction, N^2. `variance_n2` is the variance of the force across the direction.
    fn found_lean(
        &self,
        state: &State,
        contact: usize,
        covariance_n2: impl Fn(usize) -> f64,
        variance_n2: f64,
        second_order_n2: f64,
    ) -> Option<FoundLean> {
        let Direction::Leaning(lean) = self.questions[contact].direction else { return None };
        let force_n = state.forces_n[contact];
        let deg_per_n = (1.0 / force_n).to_degrees();
        Some(FoundLean {
            contact,
            lean_deg: lean.mean_deg(force_n) + state.nuisances.further_leans_deg[contact],
            sd_deg: variance_n2.sqrt() * deg_per_n.abs(),
            second_order_n2,
            by_lean_n: (0..self.questions.len()).map(|j| covariance_n2(j) / (variance_n2 * deg_per_n)).collect(),
        })
    }

    /// Refuses positions and directions whose standard deviation is too large. `sigma` returns the standard deviation of each unknown in its unit.
    fn require_determined(&self, forces_n: &[f64], sigma: impl Fn(usize) -> f64) -> Result<(), SensingError> {
        for (j, unknown) in self.unknowns.iter().enumerate() {
            let (what, contact, sigma, limit, unit) = match *unknown {
                Unknown::Force(_) | Unknown::Base(_) | Unknown::Object(_) | Unknown::Shared(_) => continue,
                Unknown::Position(i) => {
                    let limit = LARGEST_POSITION_SIGMA * self.finger().plate_length_mm(Plate::Front);
                    ("the position", i + 1, sigma(j), limit, "mm")
                }
                Unknown::Across(i) => {
                    let sigma_deg = (sigma(j) / forces_n[i].abs()).to_degrees();
                    ("the direction", i + 1, sigma_deg, LARGEST_ANGLE_SIGMA_DEG, "deg")
                }
            };
            if sigma > limit {
                return Err(SensingError::Undetermined { what, contact, sigma, unit });
            }
        }
        Ok(())
    }

    /// Computes the standard deviations of an estimate, and refuses estimates whose unknowns are not identifiable.
    ///
    /// # Errors
    /// [`SensingError`] if an unknown is not identifiable, or the shape does not explain the measurement.
    pub(super) fn judged(
        &self,
        state: &mut State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        steps: usize,
    ) -> Result<NonlinearEstimate, SensingError> {
        let (coordinates, count) = (measurement.coordinate_count(), self.unknowns.len());
        let misfit = self.misfit(state, measurement);
        let residual_rms_mm = (misfit / coordinates as f64).sqrt();
        let moved: f64 = measurement.markers().iter().map(|marker| marker.displacement.norm_squared()).sum();
        let moved_rms_mm = (moved / coordinates as f64).sqrt();
        if noise_mm.is_some_and(|noise_mm| residual_rms_mm > largest_explained_rms_mm(noise_mm, moved_rms_mm)) {
            return Err(SensingError::Unexplained { residual_rms_mm, moved_rms_mm });
        }
        let known = self.priors.count() + self.object.as_ref().map_or(0, Touching::row_count);
        let degrees_of_freedom = coordinates + known - count;
        let test = ResidualTest::new(noise_mm, misfit, degrees_of_freedom);
        // A residual that the stated noise does not explain adds to the uncertainty.
        let noise_mm = noise_of(test, noise_mm, misfit, degrees_of_freedom);
        self.rescale(state);
        let parts = state.linearised.singular_parts(measurement)?;
        let span = parts.span();
        if span.is_nan() || span > LARGEST_SPAN {
            let weakest = self.unknowns[parts.weakest().iamax()].contact().unwrap_or_default() + 1;
            return Err(SensingError::IllConditioned { span, limit: LARGEST_SPAN, weakest });
        }
        let scales = &state.linearised.scales;
        let linear = |i: usize, j: usize| scales[i] * scales[j] * parts.covariance(i, j) * noise_mm * noise_mm;
        // A force b across the direction adds b^2 / (2 f) to the force f, to second order. If the force b has the standard deviation s, the mean
        // square of b^2 / (2 f) is 3 s^4 / (4 f^2). Terms of higher order are negligible if the direction is known to within some degrees.
        let by_direction = |i: usize| {
            let across = self.unknowns.iter().position(|unknown| *unknown == Unknown::Across(i));
            across.map_or(0.0, |j| 0.75 * (linear(j, j) / state.forces_n[i]).powi(2))
        };
        let covariance = |i: usize, j: usize| linear(i, j) + if i == j { by_direction(i) } else { 0.0 };
        self.require_determined(&state.forces_n, |j| linear(j, j).sqrt())?;
        let leans = self.unknowns.iter().enumerate().filter_map(|(k, unknown)| match *unknown {
            Unknown::Across(i) => self.found_lean(state, i, |j| linear(j, k), linear(k, k), by_direction(i)),
            _ => None,
        });
        Ok(NonlinearEstimate {
            leans: leans.collect(),
            forces: Estimate {
                forces_n: state.forces_n.clone(),
                sigmas_n: (0..self.questions.len()).map(|i| covariance(i, i).sqrt()).collect(),
                model_error_n: vec![0.0; self.questions.len()],
                misfit_factor: 1.0,
                noise_mm,
                warning: test.filter(ResidualTest::contradicts).map(Warning::Residual),
                residual_rms_mm,
                singular_values: parts.descending(),
            },
            covariance_n2: DMatrix::from_fn(self.questions.len(), self.questions.len(), covariance),
            contacts: state
                .contacts
                .iter()
                .zip(&self.questions)
                .map(|(contact, question)| answered(contact, question))
                .collect(),
            steps,
            shared_errors: state.nuisances.shared.clone(),
        })
    }
}
