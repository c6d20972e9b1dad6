//! Sensing with the large-rotation finger itself: Gauss-Newton on forces, places and directions.

use super::{
    Contact, ContactPlace, ContactQuestion, Direction, Estimate, LARGEST_SPAN, LinearEstimator, Prior, SensingError,
    check_contacts,
};
use crate::finger::Plate;
use crate::frame::FrameMotion;
use crate::measurement::Measurement;
use crate::mesh::Mesh;
use crate::statics::{FrameLoad, Ladder, Statics, StaticsError};
use crate::{Finger, Kinematics, Vector};
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
/// Markers off by more than this many standard deviations count less (Cauchy's weight beyond it).
const OUTLIER_SIGMAS: f64 = 4.5;
/// Ratio of the median of a Rayleigh distribution to the standard deviation of one coordinate.
const RAYLEIGH_MEDIAN: f64 = 1.177_410_022_515_474_6;
/// A direction known to less than this, degrees, or a place to less than this share of the plate, is not known.
const LARGEST_ANGLE_SIGMA_DEG: f64 = 30.0;
const LARGEST_PLACE_SIGMA: f64 = 0.25;
/// A minimum that leaves more than this share of the displacements, or this many standard deviations, unexplained may
/// be a wrong one: the search starts again from the linear forces times other factors, and the best minimum counts.
const POOR_FIT: f64 = 0.02;
const POOR_FIT_SIGMAS: f64 = 3.0;
const OTHER_STARTS: [f64; 4] = [1.0, -1.0, 0.3, -0.3];
/// Change of a force between a mesh and one twice as fine at which refinement ends, as a share of the largest force.
const REFINEMENT_TOLERANCE: f64 = 2e-3;
/// Elements a member at which refinement begins and ends.
const ELEMENTS: std::ops::RangeInclusive<usize> = 4..=64;

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

/// One unknown: of which contact, and what.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Unknown {
    Force(usize),
    Place(usize),
    /// The part of a force across its current direction, N: with it the direction turns.
    Across(usize),
}

/// Where a search ended.
struct Found {
    state: State,
    linearised: Linearised,
    steps: usize,
}

/// The problem linearised at a state: residual and derivatives, weighted.
struct Linearised {
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
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

    fn unknowns(&self) -> Vec<Unknown> {
        let forces = (0..self.questions.len()).map(Unknown::Force);
        let places = self.questions.iter().enumerate().filter(|(_, q)| q.place.is_none());
        let angles = self.questions.iter().enumerate().filter(|(_, q)| q.direction == Direction::Auto);
        forces.chain(places.map(|(i, _)| Unknown::Place(i))).chain(angles.map(|(i, _)| Unknown::Across(i))).collect()
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

    /// Gauss-Newton from a start to the nearest minimum.
    fn search(
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

    /// Least squares on the linear finger, at the place along the plate where it explains the measurement best.
    /// The forces are multiplied by `factor`.
    fn start(&mut self, measurement: &Measurement, factor: f64) -> Result<State, SensingError> {
        let finger = self.finger();
        // A contact of unknown place is tried at every node; several of them are tried one after the other.
        let mut places: Vec<Option<ContactPlace>> = self.questions.iter().map(|q| q.place).collect();
        for i in 0..places.len() {
            if places[i].is_some() {
                continue;
            }
            let mut best = None;
            for node in finger.contact_nodes() {
                places[i] = Some(ContactPlace::Node(node));
                let Ok((contacts, estimate)) = self.linear_start(&places, measurement) else { continue };
                let inward = contacts.iter().zip(&estimate.forces_n).all(|(_, f)| *f >= 0.0);
                let better = best.is_none_or(|(_, residual)| estimate.residual_rms_mm < residual);
                if inward && better {
                    best = Some((node, estimate.residual_rms_mm));
                }
            }
            places[i] = Some(ContactPlace::Node(best.map_or(finger.tip(), |(node, _)| node)));
        }
        let (contacts, estimate) = self.linear_start(&places, measurement)?;
        // A place that moves is a distance along the plate, not a node.
        let contacts: Vec<Contact> = contacts
            .iter()
            .zip(&self.questions)
            .map(|(contact, question)| match question.place {
                Some(_) => *contact,
                None => {
                    let s_mm = contact.place_mm(finger).unwrap_or(0.5 * finger.plate_length_mm(Plate::Front));
                    Contact { place: ContactPlace::Place(s_mm), ..*contact }
                }
            })
            .collect();
        let mut forces_n: Vec<f64> = estimate.forces_n.iter().map(|f| f * factor).collect();
        // Linear forces may be beyond what the finger carries: halve them until it stands.
        for _ in 0..30 {
            let loads = self.loads(&contacts, &forces_n)?;
            match self.statics.equilibrium(&loads) {
                Ok(equilibrium) => return Ok(State { forces_n, contacts, loads, motion: equilibrium.motion }),
                Err(StaticsError::NoEquilibrium { .. }) => forces_n.iter_mut().for_each(|f| *f *= 0.5),
                Err(other) => return Err(other.into()),
            }
        }
        Err(SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 0.0 }))
    }

    /// Least squares with two components where the direction is unknown, turned into one force and its angle.
    fn linear_start(
        &self,
        places: &[Option<ContactPlace>],
        measurement: &Measurement,
    ) -> Result<(Vec<Contact>, Estimate), SensingError> {
        let finger = self.finger();
        let mut components = Vec::new();
        for (question, place) in self.questions.iter().zip(places) {
            let place = place.or(question.place).unwrap_or(ContactPlace::Node(finger.tip()));
            match question.direction {
                Direction::Angle(angle_deg) => components.push(Contact { place, angle_deg }),
                Direction::Normal => components.push(Contact { place, angle_deg: 0.0 }),
                Direction::Auto => {
                    components.extend([0.0, 90.0].map(|angle_deg| Contact { place, angle_deg }));
                }
            }
        }
        let mut estimate =
            LinearEstimator::new(finger, &components, measurement)?.estimate(measurement, Some(0.0), Prior::None);
        let mut parts = components.iter().zip(estimate.forces_n.clone());
        let (mut contacts, mut forces_n) = (Vec::new(), Vec::new());
        for question in &self.questions {
            let Some((contact, force)) = parts.next() else { break };
            match (question.direction, parts.len()) {
                (Direction::Auto, 1..) => {
                    let across = parts.next().map_or(0.0, |(_, f)| f);
                    contacts.push(Contact { angle_deg: across.atan2(force).to_degrees(), ..*contact });
                    forces_n.push(force.hypot(across));
                }
                _ => {
                    contacts.push(*contact);
                    forces_n.push(force);
                }
            }
        }
        estimate.forces_n = forces_n;
        Ok((contacts, estimate))
    }

    fn loads(&self, contacts: &[Contact], forces_n: &[f64]) -> Result<Vec<FrameLoad>, SensingError> {
        let loads =
            contacts.iter().zip(forces_n).map(|(contact, f)| self.mesh.frame_load(&contact.load(self.finger(), *f)));
        Ok(loads.collect::<Result<_, _>>()?)
    }

    /// Weighted difference between what was measured and the state.
    fn residual(&self, state: &State, measurement: &Measurement, weights: &[f64]) -> DVector<f64> {
        let markers = measurement.markers().iter().zip(weights);
        let differences = markers.flat_map(|(marker, weight)| {
            let difference = marker.displacement - state.motion.displacements[self.mesh.frame_node(marker.node)];
            [difference.x * weight * marker.weight, difference.y * weight * marker.weight]
        });
        DVector::from_iterator(measurement.coordinate_count(), differences)
    }

    /// A weight a marker: 1, and less for one that is wildly off (the square root of Cauchy's weight).
    fn robust_weights(&self, state: &State, measurement: &Measurement, noise_mm: Option<f64>) -> Vec<f64> {
        let off: Vec<f64> = measurement
            .markers()
            .iter()
            .map(|m| m.weight * (m.displacement - state.motion.displacements[self.mesh.frame_node(m.node)]).norm())
            .collect();
        let mut sorted = off.clone();
        sorted.sort_by(f64::total_cmp);
        // The median also stands for what the model itself cannot explain.
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0) / RAYLEIGH_MEDIAN;
        let limit = OUTLIER_SIGMAS * noise_mm.unwrap_or(0.0).max(median);
        off.iter().map(|&off| if off > limit && limit > 0.0 { limit / off } else { 1.0 }).collect()
    }

    fn linearise(
        &mut self,
        state: &State,
        measurement: &Measurement,
        weights: &[f64],
        unknowns: &[Unknown],
    ) -> Result<Linearised, SensingError> {
        if !self.statics.linearise(&state.motion, &state.loads) {
            return Err(SensingError::Statics(StaticsError::NoEquilibrium { converged_fraction: 1.0 }));
        }
        let finger = self.finger();
        let mut jacobian = DMatrix::zeros(measurement.coordinate_count(), unknowns.len());
        let mut moved = vec![Vector::zeros(); finger.key_node_count()];
        for (column, unknown) in unknowns.iter().enumerate() {
            let ladder = self.statics.equations_mut();
            match *unknown {
                Unknown::Force(i) => {
                    let unit = self.mesh.frame_load(&state.contacts[i].unit_load(finger))?;
                    ladder.added_load(&state.motion, &unit, &mut moved);
                }
                Unknown::Across(i) => {
                    let sideways = Contact { angle_deg: state.contacts[i].angle_deg + 90.0, ..state.contacts[i] };
                    let unit = self.mesh.frame_load(&sideways.unit_load(finger))?;
                    ladder.added_load(&state.motion, &unit, &mut moved);
                }
                Unknown::Place(i) => ladder.moved_load(&state.motion, &state.loads[i], &mut moved),
            }
            for (row, (marker, weight)) in measurement.markers().iter().zip(weights).enumerate() {
                let u = moved[marker.node.0 - 1] * (weight * marker.weight);
                jacobian[(2 * row, column)] = u.x;
                jacobian[(2 * row + 1, column)] = u.y;
            }
        }
        Ok(Linearised { residual: self.residual(state, measurement, weights), jacobian })
    }

    /// What counts as one unit of each unknown: 1 N, and for places what moves the finger about as much.
    fn scales(&self, state: &State, unknowns: &[Unknown]) -> Vec<f64> {
        let largest = state.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        unknowns
            .iter()
            .map(|unknown| match *unknown {
                Unknown::Force(_) | Unknown::Across(_) => 1.0,
                Unknown::Place(i) => {
                    let force = state.forces_n[i].abs().max(1e-3 * largest).max(f64::MIN_POSITIVE);
                    0.1 * self.finger().plate_length_mm(Plate::Front) / force
                }
            })
            .collect()
    }

    /// Largest change of an unknown: forces against the largest force, places against the plate.
    fn relative_change(&self, state: &State, unknowns: &[Unknown], step: &DVector<f64>) -> f64 {
        let largest = state.forces_n.iter().fold(f64::MIN_POSITIVE, |m, f| m.max(f.abs()));
        let length = self.finger().plate_length_mm(Plate::Front);
        let change = |(unknown, x): (&Unknown, &f64)| match unknown {
            Unknown::Force(_) | Unknown::Across(_) => x.abs() / largest,
            Unknown::Place(_) => x.abs() / length,
        };
        unknowns.iter().zip(step.iter()).map(change).fold(0.0, f64::max)
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

    /// Standard deviations and refusals.
    fn judged(
        &self,
        found: &Found,
        unknowns: &[Unknown],
        noise_mm: Option<f64>,
    ) -> Result<NonlinearEstimate, SensingError> {
        let Found { state, linearised: Linearised { residual, jacobian }, steps } = found;
        let (coordinates, count) = jacobian.shape();
        let noise_mm = noise_mm.unwrap_or_else(|| match coordinates - count {
            0 => f64::INFINITY,
            freedoms => (residual.norm_squared() / freedoms as f64).sqrt(),
        });
        let scales = self.scales(state, unknowns);
        let scaled = DMatrix::from_fn(coordinates, count, |i, j| jacobian[(i, j)] * scales[j]);
        let svd = scaled.svd(false, true);
        let mut singular_values: Vec<f64> = svd.singular_values.iter().copied().collect();
        singular_values.sort_by(|a, b| b.total_cmp(a));
        let span = singular_values[0] / singular_values[count - 1];
        let Some(v_t) = svd.v_t.filter(|_| span <= LARGEST_SPAN) else {
            return Err(SensingError::IllConditioned { span, limit: LARGEST_SPAN, weakest: 1 });
        };
        let sigma = |j: usize| {
            let sum: f64 = (0..count).map(|k| (v_t[(k, j)] / svd.singular_values[k]).powi(2)).sum();
            scales[j] * sum.sqrt() * noise_mm
        };
        for (j, unknown) in unknowns.iter().enumerate() {
            let (what, contact, sigma, limit, unit) = match *unknown {
                Unknown::Force(_) => continue,
                Unknown::Place(i) => {
                    let limit = LARGEST_PLACE_SIGMA * self.finger().plate_length_mm(Plate::Front);
                    ("the place", i + 1, sigma(j), limit, "mm")
                }
                Unknown::Across(i) => {
                    let sigma_deg = (sigma(j) / state.forces_n[i].abs()).to_degrees();
                    ("the direction", i + 1, sigma_deg, LARGEST_ANGLE_SIGMA_DEG, "deg")
                }
            };
            if sigma > limit {
                return Err(SensingError::Undetermined { what, contact, sigma, unit });
            }
        }
        Ok(NonlinearEstimate {
            forces: Estimate {
                forces_n: state.forces_n.clone(),
                sigmas_n: (0..self.questions.len()).map(sigma).collect(),
                noise_mm,
                residual_rms_mm: (residual.norm_squared() / coordinates as f64).sqrt(),
                singular_values,
            },
            contacts: state
                .contacts
                .iter()
                .map(|c| Contact { angle_deg: c.angle_deg - 360.0 * ((c.angle_deg + 180.0) / 360.0).floor(), ..*c })
                .collect(),
            steps: *steps,
        })
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

/// Senses on ever finer meshes until doubling the mesh changes no force by more than 0.2 % of the largest.
///
/// # Errors
/// [`SensingError`] from the estimate on any of the meshes.
pub fn sense_refining(
    finger: &Finger,
    questions: &[ContactQuestion],
    measurement: &Measurement,
    noise_mm: Option<f64>,
) -> Result<NonlinearEstimate, SensingError> {
    let on = |elements| {
        let mesh = Mesh::with_elements_per_member(finger, elements);
        NonlinearEstimator::new(&mesh, questions)?.estimate(measurement, noise_mm)
    };
    let mut elements = *ELEMENTS.start();
    let mut coarse = on(elements)?;
    while elements < *ELEMENTS.end() {
        elements *= 2;
        let fine = on(elements)?;
        let largest = fine.forces.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let pairs = coarse.forces.forces_n.iter().zip(&fine.forces.forces_n);
        let change = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        coarse = fine;
        if change <= REFINEMENT_TOLERANCE * largest {
            break;
        }
    }
    Ok(coarse)
}
