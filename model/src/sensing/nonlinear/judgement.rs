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
use nalgebra::DMatrix;

/// A direction known to less than this, degrees, or a position to less than this share of the plate, is not known.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;
const LARGEST_POSITION_SIGMA: f64 = 0.25;
/// Another minimum counts as an explanation as good as the best if its misfit, in squared standard deviations, is larger
/// by no more than this, and as another answer if a force differs by more than this many standard deviations.
const AS_GOOD: f64 = 9.0;
const ANOTHER_ANSWER_SIGMAS: f64 = 5.0;
/// Without noise, forces that differ by no more than this share of the largest are the same.
const SAME_ANSWER: f64 = 1e-3;
/// Measured coordinates a force that confirm an answer by fitting it.
const CONFIRMING_COORDINATES: usize = 4;

impl NonlinearEstimate {
    /// Refuses an estimate that claims a force where no force at all explains the data as well: noise has been read as the
    /// onset of buckling, where a little moves much.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`].
    pub(super) fn check_against_nothing(&self, misfit: f64, misfit_at_rest: f64) -> Result<(), SensingError> {
        let Estimate { forces_n, sigmas_n, noise_mm, .. } = &self.forces;
        if misfit_at_rest - misfit > AS_GOOD * noise_mm * noise_mm {
            return Ok(());
        }
        let claimed = (0..forces_n.len()).find(|&i| forces_n[i].abs() > ANOTHER_ANSWER_SIGMAS * sigmas_n[i]);
        claimed.map_or(Ok(()), |i| Err(SensingError::Ambiguous { contact: i + 1, force_n: forces_n[i], other_n: 0.0 }))
    }

    /// Refuses an estimate beside which other forces explain the data as well, though they are no minimum: where the finger answers linearly,
    /// forces whose misfit is no larger than [`AS_GOOD`] allows are within three standard deviations. `others` holds misfits and forces.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`].
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

    /// Refuses several forces that leave no coordinate to confirm them, where they are others than those of the linear finger: any number of
    /// equilibria may then explain the measurement exactly. `starts` begins with the linear forces, if the search did.
    ///
    /// # Errors
    /// [`SensingError::Unconfirmed`].
    pub(super) fn check_unconfirmed(
        &self,
        coordinates: usize,
        starts: &[(Vec<f64>, FrameMotion)],
    ) -> Result<(), SensingError> {
        let count = self.forces.forces_n.len();
        let is_far = starts.first().is_some_and(|(linear_n, _)| self.other_answer(linear_n).is_some());
        if count > 1 && coordinates <= count && is_far { Err(SensingError::Unconfirmed) } else { Ok(()) }
    }

    /// Whether other forces, whose misfit is larger by `excess`, are the same answer.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`] if they are another one that explains the data as well.
    fn is_confirmed_by(&self, other_n: &[f64], excess: f64) -> Result<bool, SensingError> {
        match self.other_answer(other_n) {
            Some(i) if excess <= AS_GOOD * self.forces.noise_mm.powi(2) => {
                let (force_n, other_n) = (self.forces.forces_n[i], other_n[i]);
                Err(SensingError::Ambiguous { contact: i + 1, force_n, other_n })
            }
            other => Ok(other.is_none()),
        }
    }

    /// The first force that differs from this estimate's by more than its standard deviation allows.
    fn other_answer(&self, other_n: &[f64]) -> Option<usize> {
        let Estimate { forces_n, sigmas_n, .. } = &self.forces;
        let largest = forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let same = |i: usize| f64::max(ANOTHER_ANSWER_SIGMAS * sigmas_n[i], SAME_ANSWER * largest);
        (0..forces_n.len()).find(|&i| (forces_n[i] - other_n[i]).abs() > same(i))
    }

    /// Refuses an estimate beside which another minimum explains the data as well, and one from few coordinates, far from
    /// the linear forces, to which one start alone has led. `minima` holds misfit and forces of each minimum that was found.
    ///
    /// # Errors
    /// [`SensingError::Ambiguous`] and [`SensingError::Unconfirmed`].
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
        // One of them is the estimate itself. Many coordinates that all fit confirm it as well.
        let confirmed =
            near || confirmations >= 2 || coordinates >= CONFIRMING_COORDINATES * self.forces.forces_n.len();
        if confirmed { Ok(()) } else { Err(SensingError::Unconfirmed) }
    }
}

/// A contact as it was found: its direction as it was given, else between -180 and 180 degrees.
fn answered(contact: &Contact, question: &ContactQuestion) -> Contact {
    let angle_deg = match question.direction {
        Direction::Angle(angle_deg) => angle_deg,
        _ => contact.angle_deg,
    };
    Contact { angle_deg: angle_deg - 360.0 * ((angle_deg + 180.0) / 360.0).floor(), ..*contact }
}

impl NonlinearEstimator<'_> {
    /// A lean that was sought, from the covariances of all forces with the force across its own, N^2, and the variance of that.
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

    /// Refuses positions and directions whose standard deviation, by unknown, is too large.
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

    /// Standard deviations and refusals.
    ///
    /// # Errors
    /// [`SensingError`] for unknowns that are not identifiable.
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
        // What the stated noise does not explain is uncertainty too.
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
        // What a force has across its direction adds to it by second order, b^2 / (2 f), of mean square 3 s^4 / (4 f^2): all
        // there is of it where a direction is known to some degrees only.
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
