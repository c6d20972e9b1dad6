//! The way to the nearest minimum: the method of Levenberg and Marquardt.

use super::linearised::Linearised;
use super::unknowns::Unknown;
use super::{NonlinearEstimator, State};
use crate::finger::Plate;
use crate::measurement::Measurement;
use crate::sensing::{ContactPlace, Direction, LARGEST_SPAN, SensingError};
use nalgebra::{DMatrix, DVector};

/// Most Gauss-Newton steps; a good start needs three.
const MAX_STEPS: usize = 60;
/// Steps have converged when they change every unknown by less than this share of its scale.
const STEP_TOLERANCE: f64 = 1e-7;
/// Turn of a deformed normal in one step, degrees, below which it counts as settled: worth 1e-6 of the force.
const SETTLED_ANGLE_DEG: f64 = 1e-4;
/// Damping after a step that made things worse; it grows tenfold as long as that goes on.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping beyond which no step helps: the minimum is reached as far as rounding lets it be seen.
const MAX_DAMPING: f64 = 1e8;

/// Where a search ended.
pub(super) struct Found {
    pub state: State,
    pub linearised: Linearised,
    pub steps: usize,
}

impl NonlinearEstimator<'_> {
    /// Gauss-Newton from a start to the nearest minimum.
    pub(super) fn search(
        &mut self,
        start: State,
        measurement: &Measurement,
        noise_mm: Option<f64>,
        unknowns: &[Unknown],
    ) -> Result<Found, SensingError> {
        let mut state = start;
        let mut damping = 0.0;
        let mut steps = 0;
        let mut weights = self.robust_weights(&state, measurement, noise_mm);
        let mut linearised = self.linearise(&state, measurement, &weights, unknowns)?;
        loop {
            steps += 1;
            let step = damped_step(&linearised, &self.scales(&state, unknowns), damping)?;
            let change = self.relative_change(&state, unknowns, &step);
            let tried = self.advanced(&state, unknowns, &step);
            let better = match tried {
                Ok(next) => {
                    let normals_settled = self.normals_settled(&state, &next);
                    let next_weights = self.robust_weights(&next, measurement, noise_mm);
                    let before = linearised.residual.norm_squared();
                    // Compared under the same weights: reweighting is not progress.
                    let after = self.residual(&next, measurement, &weights).norm_squared();
                    // A turning normal may make a good step look worse; what is left after it is corrected by the next.
                    let slack = if normals_settled { 1e-12 } else { 0.5 };
                    let accepted = after <= before * (1.0 + slack) || change <= STEP_TOLERANCE;
                    accepted.then_some((next, next_weights, normals_settled))
                }
                Err(_) => None,
            };
            match better {
                Some((next, next_weights, normals_settled)) => {
                    state = next;
                    weights = next_weights;
                    linearised = self.linearise(&state, measurement, &weights, unknowns)?;
                    damping = if damping > FIRST_DAMPING { 0.1 * damping } else { 0.0 };
                    if change <= STEP_TOLERANCE && normals_settled {
                        break;
                    }
                }
                None if damping >= MAX_DAMPING => break,
                None => damping = f64::max(10.0 * damping, FIRST_DAMPING),
            }
            if steps >= MAX_STEPS {
                let change_n = step.iter().take(self.questions.len()).fold(0.0, |m: f64, x| m.max(x.abs()));
                return Err(SensingError::NotConverged { iterations: steps, change_n });
            }
        }
        Ok(Found { state, linearised, steps })
    }

    /// The state after a step, with its equilibrium.
    fn advanced(&mut self, state: &State, unknowns: &[Unknown], step: &DVector<f64>) -> Result<State, SensingError> {
        let finger = self.finger();
        let (mut forces_n, mut contacts) = (state.forces_n.clone(), state.contacts.clone());
        for (unknown, x) in unknowns.iter().zip(step.iter()) {
            match *unknown {
                Unknown::Force(i) => forces_n[i] += x,
                // Forces come first: the part along the direction is up to date.
                Unknown::Across(i) => {
                    contacts[i].angle_deg += x.atan2(forces_n[i]).to_degrees();
                    forces_n[i] = forces_n[i].hypot(*x);
                }
                Unknown::Place(i) => {
                    if let ContactPlace::Place(s_mm) = &mut contacts[i].place {
                        // On the plate, and no more than a fifth of it at once.
                        let length = finger.plate_length_mm(Plate::Front);
                        *s_mm = (*s_mm + x.clamp(-0.2 * length, 0.2 * length)).clamp(0.01 * length, length);
                    }
                }
            }
        }
        for ((contact, question), load) in contacts.iter_mut().zip(&self.questions).zip(&state.loads) {
            if question.direction == Direction::Normal {
                contact.angle_deg = self.mesh.frame().rotation_at(&state.motion, load).to_degrees();
            }
        }
        let loads = self.loads(&contacts, &forces_n)?;
        let motion = self.statics.shifted(&state.motion, &state.loads, &loads)?.motion;
        Ok(State { forces_n, contacts, loads, motion })
    }

    /// Whether directions along the deformed normal have stopped turning.
    fn normals_settled(&self, before: &State, after: &State) -> bool {
        let turned = before.contacts.iter().zip(&after.contacts).zip(&self.questions);
        turned
            .filter(|(_, question)| question.direction == Direction::Normal)
            .all(|((a, b), _)| (a.angle_deg - b.angle_deg).abs() <= SETTLED_ANGLE_DEG)
    }
}

/// The Levenberg-Marquardt step for a damping, by QR of the scaled Jacobian stacked on the damping.
fn damped_step(linearised: &Linearised, scales: &[f64], damping: f64) -> Result<DVector<f64>, SensingError> {
    let (rows, columns) = linearised.jacobian.shape();
    let norms: Vec<f64> = (0..columns).map(|j| linearised.jacobian.column(j).norm() * scales[j]).collect();
    let mut stacked = DMatrix::zeros(rows + columns, columns);
    let mut right = DVector::zeros(rows + columns);
    right.rows_mut(0, rows).copy_from(&linearised.residual);
    for j in 0..columns {
        for i in 0..rows {
            stacked[(i, j)] = linearised.jacobian[(i, j)] * scales[j];
        }
        stacked[(rows + j, j)] = damping.sqrt() * norms[j];
    }
    let qr = stacked.qr();
    qr.q_tr_mul(&mut right);
    let mut step = right.rows(0, columns).into_owned();
    let solved = qr.r().solve_upper_triangular_mut(&mut step);
    if !solved || !step.iter().all(|x| x.is_finite()) {
        return Err(SensingError::IllConditioned { span: f64::INFINITY, limit: LARGEST_SPAN, weakest: 1 });
    }
    Ok(DVector::from_iterator(columns, step.iter().zip(scales).map(|(x, scale)| x * scale)))
}
