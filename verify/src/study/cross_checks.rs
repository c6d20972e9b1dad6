//! Problems with known answers.

use crate::check::{Check, Comparison};
use crate::mujoco::ExportedFinger;
use crate::problems::{self, ProblemError};
use finray_model::Finger;

/// Promises, and differences that are expected.
type Findings = (Vec<Check>, Vec<Comparison>);

/// Problems about every finger, then those about the paper's alone, then MuJoCo's.
pub(super) fn cross_checks(finger: &Finger, is_paper: bool) -> Result<Findings, ProblemError> {
    // MuJoCo's triangle takes as long as all others together.
    let (ours, mujoco) = rayon::join(
        || -> Result<_, ProblemError> {
            let papers = if is_paper { of_the_paper(finger)? } else { Findings::default() };
            Ok([of_all(finger)?, papers])
        },
        || of_mujoco(finger, is_paper),
    );
    let (mut checks, mut comparisons) = Findings::default();
    for (more_checks, more_comparisons) in ours?.into_iter().chain([mujoco?]) {
        checks.extend(more_checks);
        comparisons.extend(more_comparisons);
    }
    Ok((checks, comparisons))
}

fn of_mujoco(finger: &Finger, is_paper: bool) -> Result<Findings, ProblemError> {
    let mut checks = match ExportedFinger::of(finger) {
        Some(exported) => problems::mujoco::static_checks(exported)?,
        None => Vec::new(),
    };
    if !is_paper {
        return Ok((checks, Vec::new()));
    }
    checks.extend(problems::mujoco::contact_checks()?);
    Ok((checks, problems::mujoco::triangle()?))
}

fn of_all(finger: &Finger) -> Result<Findings, ProblemError> {
    let mut checks = problems::elastica::checks()?;
    checks.extend(problems::full_circle::checks()?);
    checks.extend(problems::lee_frame::checks()?);
    checks.extend(problems::toggle::checks()?);
    checks.extend(problems::refinement::checks(finger)?);
    Ok((checks, problems::refinement::comparisons(finger)?))
}

fn of_the_paper(finger: &Finger) -> Result<Findings, ProblemError> {
    let mut checks = problems::opensees::paper_checks(finger)?;
    checks.extend(problems::rigid_rotation::checks(finger));
    checks.extend(problems::tangent::checks(finger)?);
    checks.extend(problems::energy_balance::checks(finger)?);
    checks.extend(problems::grid_convergence::checks(finger)?);
    Ok((checks, problems::opensees::linear_against_large_rotation(finger)?))
}
