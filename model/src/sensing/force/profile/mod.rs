//! Profile of the misfit (sum of squared weighted residuals) over unknown positions, on the finger linearised at a minimum.
//!
//! Two explanations of the same measurement have nearly equal shapes, however large their forces are. The tangent at the shape of one explanation therefore
//! maps the difference of their loads to the small difference of their shapes. This tangent, factored once, gives the responses to forces at a grid of
//! positions. For each combination of positions, the best forces and the misfit follow from a small linear problem. Minima of the misfit over the positions are
//! the rivals of the minimum at which the finger is linearised. If that minimum does not explain the measurement, shapes differ more, and the profile is only a
//! guide to better starting points.

use super::AS_GOOD;
use super::linearised::Seen;
use super::marker_motion::marker_displacement;
use super::problem::{ForceProblem, State};
use super::unknowns::Unknown;
use crate::Vector;
use crate::measurement::{Marker, Measurement};
use crate::sensing::{Contact, ContactPosition, Direction, Normal, Pad, PadForce, SensingError, plate_turn};
use grid::Grid;
use least::{Fit, Profile};
use nalgebra::{DMatrix, DVector};

mod grid;
mod least;

/// A minimum of the profile is a rival if its misfit exceeds that of the linearised minimum by at most this number of noise variances. A rival explains the
/// measurement equally well if it adds at most 9 noise variances. The limit is wider because the profile neglects changes of second order. If the linearised
/// minimum does not explain the measurement, the neglected changes are larger: the limit grows by the excess over `EXPLAINED` times the expected misfit.
const RIVAL_VARIANCES: f64 = 25.0;
const EXPLAINED: f64 = 2.0;
/// At most this number of rivals is returned.
const MOST_RIVALS: usize = 4;

/// Contacts and forces, N, near a minimum of the misfit.
#[derive(Debug, Clone)]
pub(super) struct Rival {
    pub contacts: Vec<Contact>,
    pub forces_n: Vec<f64>,
}

/// Rivals of a minimum, and all other forces that explain the measurement.
pub(super) struct Rivals {
    /// Rivals in the order of their predicted misfits.
    pub rivals: Vec<Rival>,
    /// Misfit, mm^2, and forces, N, at all combinations of positions of the grid that explain the measurement. Forces are in the order of
    /// [`ForceProblem::order`].
    pub others: Vec<(f64, Vec<f64>)>,
}

/// Rivals of the minimum `state`, and other forces that explain the measurement.
///
/// # Errors
/// [`SensingError`] if a position is not on the plate, which the grid prevents.
pub(super) fn find_rivals(problem: &mut ForceProblem, state: &State, seen: Seen) -> Result<Rivals, SensingError> {
    let Seen { measurement, marker_noise_mm } = seen;
    let unplaced = problem.unplaced();
    if !problem.statics.linearise(&state.motion, &state.loads) {
        return Err(SensingError::NoContact);
    }
    let profile = profile(problem, &unplaced, state, measurement)?;
    let misfit_mm2 = problem.misfit(state, measurement);
    let degrees_of_freedom = measurement.coordinate_count().saturating_sub(problem.unknowns.len()).max(1);
    let variance_mm2 = marker_noise_mm
        .map_or(misfit_mm2 / degrees_of_freedom as f64, |marker_noise_mm| marker_noise_mm * marker_noise_mm);
    let unexplained_mm2 = (misfit_mm2 - EXPLAINED * degrees_of_freedom as f64 * variance_mm2).max(0.0);
    let limit_mm2 = misfit_mm2 + unexplained_mm2 + RIVAL_VARIANCES * variance_mm2;
    let order = problem.order(&state.contacts);
    let at_mm = |&i: &usize| state.contacts[order[i]].position_mm(problem.finger()).unwrap_or(f64::NAN);
    let here_mm: Vec<f64> = unplaced.iter().map(at_mm).collect();
    let mut found: Vec<(Vec<f64>, Fit)> = Vec::new();
    let fits = profile.fits();
    for (combination, fit) in profile.minima(&fits).into_iter().filter_map(|at| Some((at, fits[at].as_ref()?))) {
        let (at_mm, fit) = profile.refined(profile.at_mm(combination), fit);
        let is_near = |other: &[f64]| at_mm.iter().zip(other).all(|(a, b)| (a - b).abs() <= profile.grid.spacing_mm);
        if fit.misfit_mm2 <= limit_mm2 && !is_near(&here_mm) && !found.iter().any(|(other, _)| is_near(other)) {
            found.push((at_mm, fit));
        }
    }
    found.sort_by(|a, b| a.1.misfit_mm2.total_cmp(&b.1.misfit_mm2));
    found.truncate(MOST_RIVALS);
    let rival = |(at_mm, fit): &(Vec<f64>, Fit)| rival(problem, &unplaced, state, &profile, at_mm, fit);
    let rivals = found.iter().map(rival).collect::<Result<_, _>>()?;
    // The profile simplifies priors, which is accurate enough to find rivals but not to widen standard deviations.
    let is_exact = problem.priors.count() == 0;
    let explaining = fits.iter().enumerate().filter(|_| is_exact).filter_map(|(combination, fit)| {
        let fit = fit.as_ref().filter(|fit| fit.misfit_mm2 <= misfit_mm2 + AS_GOOD * variance_mm2)?;
        Some((profile.at_mm(combination), fit.clone()))
    });
    let other = |found: (Vec<f64>, Fit)| {
        let Rival { contacts, forces_n } = rival(&found)?;
        Ok((found.1.misfit_mm2, problem.order(&contacts).into_iter().map(|i| forces_n[i]).collect()))
    };
    let others = explaining.map(other).collect::<Result<_, SensingError>>()?;
    Ok(Rivals { rivals, others })
}

/// The contact with index `i` of the linearised state at another position.
fn moved(problem: &ForceProblem, i: usize, state: &State, s_mm: f64) -> Result<Contact, SensingError> {
    let contact = Contact { position: ContactPosition::at(s_mm), ..state.contacts[i] };
    let Direction::Leaning(lean) = problem.questions[i].direction else { return Ok(contact) };
    let turn_rad = match lean.from {
        Normal::Deformed { over_mm } => {
            problem.mesh.normal_turn(&state.motion, &contact.unit_load(problem.finger()), over_mm)?
        }
        Normal::Object | Normal::Undeformed => 0.0,
    };
    Ok(Contact { angle_deg: turn_rad.to_degrees() + lean.mean_deg(state.forces_n[i]), ..contact })
}

fn rival(
    problem: &ForceProblem,
    unplaced: &[usize],
    state: &State,
    profile: &Profile,
    at_mm: &[f64],
    fit: &Fit,
) -> Result<Rival, SensingError> {
    let (mut contacts, mut forces_n) = (state.contacts.clone(), state.forces_n.clone());
    let mut components_n = fit.components_n.iter().copied();
    for ((&i, &s_mm), &(_, count)) in unplaced.iter().zip(at_mm).zip(&profile.blocks) {
        let along_n = components_n.next().unwrap_or_default();
        let across_n = if count > 1 { components_n.next().unwrap_or_default() } else { 0.0 };
        contacts[i] = moved(problem, i, state, s_mm)?;
        forces_n[i] = along_n;
        if problem.questions[i].direction == Direction::Auto {
            contacts[i].angle_deg += across_n.atan2(along_n).to_degrees();
            forces_n[i] = along_n.hypot(across_n);
        }
    }
    let known = (0..contacts.len()).filter(|i| !unplaced.contains(i));
    known.zip(components_n).for_each(|(i, force_n)| forces_n[i] = force_n);
    Ok(Rival { contacts, forces_n })
}

/// Columns and products of the least-squares problems, at the factored tangent of `state`.
fn profile(
    problem: &mut ForceProblem,
    unplaced: &[usize],
    state: &State,
    measurement: &Measurement,
) -> Result<Profile, SensingError> {
    let finger = problem.finger();
    let grid = Grid::new(finger, unplaced.len());
    let (mut columns, mut blocks) = (Vec::new(), Vec::new());
    let largest_n = state.forces_n.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let mut right = column(state, measurement, |marker| {
        marker.displacement - state.linearised.seen_displacement(marker.node.0 - 1, state.posed())
    });
    // Row of each nuisance's prior: its column, its derivative and its right-hand side.
    let mut priors: Vec<(usize, f64, f64)> = Vec::new();
    for &i in unplaced {
        let has_across = problem.unknowns.contains(&Unknown::Across(i));
        blocks.push((columns.len(), 1 + usize::from(has_across)));
        let pad = problem.questions[i].pad;
        for &s_mm in &grid.at_mm {
            let contact = moved(problem, i, state, s_mm)?;
            columns.push(response(problem, state, measurement, (&contact, pad))?);
            if has_across {
                let across = Contact { angle_deg: contact.angle_deg + 90.0, ..contact };
                columns.push(response(problem, state, measurement, (&across, pad))?);
            }
        }
    }
    let known_from = columns.len();
    for (i, force_n) in state.forces_n.iter().enumerate() {
        let of_force = response(problem, state, measurement, (&state.contacts[i], problem.questions[i].pad))?;
        right.axpy(*force_n, &of_force, 1.0);
        if !unplaced.contains(&i) {
            columns.push(of_force);
        }
    }
    let known_contacts = columns.len() - known_from;
    let rows: Vec<_> = problem.priors.rows(&state.nuisances, &state.forces_n).collect();
    for (j, unknown) in problem.unknowns.iter().enumerate() {
        if let Unknown::Force(_) | Unknown::Position(_) = unknown {
            continue;
        }
        if unknown.contact().is_some_and(|i| unplaced.contains(&i)) {
            continue;
        }
        if let Some(row) = rows.iter().find(|row| row.index == j) {
            priors.push((columns.len(), row.by_unknown, row.left_mm));
        }
        columns.push(column(state, measurement, |marker| state.linearised.rate(j, marker.node.0 - 1)));
    }
    columns.push(right);
    let matrix = DMatrix::from_columns(&columns);
    let mut products = matrix.tr_mul(&matrix);
    let last = columns.len() - 1;
    for (j, by_unknown, left_mm) in priors {
        products[(j, j)] += by_unknown * by_unknown;
        products[(j, last)] += by_unknown * left_mm;
        products[(last, j)] += by_unknown * left_mm;
        products[(last, last)] += left_mm * left_mm;
    }
    // The lean of a force at an unknown position has a prior. The force across is that of the largest force at this lean.
    for (&i, &(first, count)) in unplaced.iter().zip(&blocks) {
        if let (Direction::Leaning(lean), 2) = (problem.questions[i].direction, count) {
            let per_n = problem.priors.marker_noise_mm() / (largest_n * lean.sd_deg.to_radians().tan());
            for k in 0..grid.at_mm.len() {
                let j = first + 2 * k + 1;
                products[(j, j)] += per_n * per_n;
            }
        }
    }
    let same = |k: usize| (0..k).rev().find(|&l| problem.questions[unplaced[l]] == problem.questions[unplaced[k]]);
    Ok(Profile {
        equal_to: (0..unplaced.len()).map(same).collect(),
        pushes: state.forces_n.iter().all(|force_n| *force_n >= 0.0),
        grid,
        products,
        blocks,
        known_from,
        known_contacts,
        largest_n,
    })
}

/// Weighted displacements of the markers per newton at a contact, mm/N.
fn response(
    problem: &mut ForceProblem,
    state: &State,
    measurement: &Measurement,
    (contact, pad): (&Contact, Option<Pad>),
) -> Result<DVector<f64>, SensingError> {
    let plate_turn_rad = plate_turn(pad, problem.mesh, contact, &state.motion)?;
    let unit = PadForce { contact: *contact, force_n: 1.0, pad, plate_turn_rad };
    let mut sum = vec![Vector::zeros(); problem.finger().key_node_count()];
    let mut of_load = sum.clone();
    for load in unit.loads(problem.mesh) {
        problem.statics.equations_mut().added_load(&state.motion, &load?, &mut of_load);
        sum.iter_mut().zip(&of_load).for_each(|(sum, further)| *sum += further);
    }
    Ok(column(state, measurement, |marker| marker_displacement(&state.nuisances, sum[marker.node.0 - 1])))
}

/// Weighted coordinates of the markers, mm, from a vector for each marker.
fn column(state: &State, measurement: &Measurement, of_marker: impl Fn(&Marker) -> Vector) -> DVector<f64> {
    let markers = measurement.markers();
    let weighted = markers.iter().map(|marker| of_marker(marker) * state.linearised.weight(marker));
    DVector::from_iterator(2 * markers.len(), weighted.flat_map(|value| [value.x, value.y]))
}
