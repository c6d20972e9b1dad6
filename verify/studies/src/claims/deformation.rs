//! Claims of the paper's sections I and III: deformation under a force.

use super::criteria::{MESH_SHARE, MUCH_SHARE, NEGLIGIBLE_SHARE, at_most_nodes, over_assumptions, statement};
use super::experiments::{self, range_of};
use super::{Claim, ClaimError, ClaimVerdict, Words};
use crate::experiments::continuum::{BeamTheoryRow, Constants, ContinuumStudy, LARGEST_FORCE_N};
use crate::prelude::*;
use crate::problems::{opensees, refinement};
use crate::study::Study;
use minijinja::context;

/// Force at which the linear model is assessed, N: the largest force of the gripper tests.
const FORCE_N: f64 = 3.0;

pub(super) fn claims(study: &Study, words: &Words) -> Result<Vec<Claim>, ClaimError> {
    let mut opensees = opensees::deviations(&study.finger, finray_fixtures::OPENSEES_PAPER)?;
    opensees.retain(|case| case.kinematics == Kinematics::Linear);
    let off_opensees = worst(opensees.iter().map(|case| case.displacement));
    let off_mesh = refinement::linear_difference(&study.finger)?;
    // The finger's depth is an assumption. Shapes depend on force / depth, so twice the depth under the whole force gives the same shape as the given
    // depth under half the force.
    let depths_mm = [1.0, 2.0].map(|times| times * study.finger.description().depth_mm);
    let curved = [
        experiments::linearisation(&study.finger, FORCE_N)?,
        experiments::linearisation(&study.finger, FORCE_N / 2.0)?,
    ];
    let near = curved.each_ref().map(|shares| at_most_nodes(shares, |share| share <= MUCH_SHARE));
    let linear_holds = over_assumptions(&near.map(|(_, most)| statement(most)));
    let linear = context! {
        ranges => curved.each_ref().map(|shares| range_of(shares)), much => MUCH_SHARE, near => near.map(|(count, _)| count),
        nodes => curved[0].len(), force_n => FORCE_N, depths_mm,
    };
    let same_frame = context! { off => off_opensees, cases => opensees.len() };
    let [free, contacts] = [study.finger.free_nodes().count(), study.finger.contact_nodes().count()];
    let counts = [3 * free, 2 * free, 3 * contacts];
    let coarse = study.convergence.error(0, FORCE_N);
    let element_size = coarse.map_or(ClaimVerdict::NotTested, |error| {
        over_assumptions(&[off_mesh, error].map(|share| statement(share <= MESH_SHARE)))
    });
    Ok(vec![
        words.claim("linear", linear_holds, linear)?,
        words.claim("same-frame", statement(off_opensees < NEGLIGIBLE_SHARE), same_frame)?,
        words.claim("finer-mesh", statement(off_mesh < MESH_SHARE), context! { off => off_mesh })?,
        words.claim("coordinates", statement(counts == [69, 46, 36]), context! { counts })?,
        words.claim("element-size", element_size, context! { off => off_mesh, coarse, force_n => FORCE_N })?,
        solid(&study.continuum, words)?,
    ])
}

/// Claim on a model of solid elements: the plane continuum. The paper does not state whether its frame model has the stiffness of plane strain.
///
/// # Errors
/// [`ClaimError`] if the claim's text cannot be completed.
pub fn solid(continuum: &ContinuumStudy, words: &Words) -> Result<Claim, ClaimError> {
    let without_arms = [Constants::Modulus, Constants::PlaneStrain].map(|constants| continuum.with_rods(constants));
    let large: Vec<ClaimVerdict> =
        without_arms.into_iter().flatten().map(|row| statement(row.median > MUCH_SHARE)).collect();
    let arms = continuum.with_rods(Constants::ArmsAndShear);
    let medians =
        |rows: [Option<&BeamTheoryRow>; 3]| rows.into_iter().flatten().map(|row| row.median).collect::<Vec<_>>();
    let numbers = context! {
        with_rods => medians(Constants::ALL.map(|constants| continuum.with_rods(constants))),
        without_rods => medians(Constants::ALL.map(|constants| continuum.without_rods(constants))),
        cases => arms.map(|row| row.cases), worst => arms.map(|row| row.worst), much => MUCH_SHARE, force_n => LARGEST_FORCE_N,
    };
    words.claim("solid", over_assumptions(&large), numbers)
}
