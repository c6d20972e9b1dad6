//! Problems with known answers.

use crate::check::{Check, Comparison};
use crate::mujoco::ExportedFinger;
use crate::problems::{self, ProblemError};
use finray_model::Finger;

/// Promises, and differences that are expected. Some problems are about every finger, some about the paper's alone.
pub(super) fn cross_checks(finger: &Finger, is_paper: bool) -> Result<(Vec<Check>, Vec<Comparison>), ProblemError> {
    let mut checks = problems::elastica::checks()?;
    checks.extend(problems::full_circle::checks()?);
    checks.extend(problems::lee_frame::checks()?);
    checks.extend(problems::toggle::checks()?);
    checks.extend(problems::refinement::checks(finger)?);
    let mut comparisons = problems::refinement::comparisons(finger)?;
    if is_paper {
        checks.extend(problems::opensees::paper_checks(finger)?);
        checks.extend(problems::rigid_rotation::checks(finger));
        checks.extend(problems::tangent::checks(finger)?);
        checks.extend(problems::energy_balance::checks(finger)?);
        checks.extend(problems::grid_convergence::checks(finger)?);
        comparisons.extend(problems::opensees::linear_against_large_rotation(finger)?);
    }
    if let Some(exported) = ExportedFinger::of(finger) {
        checks.extend(problems::mujoco::static_checks(exported)?);
    }
    if is_paper {
        checks.extend(problems::mujoco::contact_checks()?);
        comparisons.extend(problems::mujoco::triangle()?);
    }
    Ok((checks, comparisons))
}
