//! Calibrates on successively finer meshes.

use super::{FoundQuantity, Sought, View, ViewEstimate, ViewModel, views_from};
use crate::calibration::CalibrationError;
use crate::finger::Finger;

/// Refinement ends when doubling the mesh changes each quantity by at most this share of its standard deviation, or by at most `NEGLIGIBLE`: a share of
/// a factor, and mm, degrees or N mm of any other quantity.
const REFINEMENT_SIGMAS: f64 = 0.5;
const NEGLIGIBLE: f64 = 1e-4;
/// If refinement has converged, the error of the last mesh is this share of the last change, because errors decrease with the square of the element
/// length (Richardson).
const REMAINS: f64 = 1.0 / 3.0;
/// Largest number of beam elements per member.
const MOST_ELEMENTS: usize = 64;

/// Estimates like [`views`](super::views), but refines the mesh from the elements of `model` until doubling the mesh changes each sought quantity by at
/// most half of its standard deviation. Standard deviations include the remaining error of the mesh. Refinement also ends at 64 elements per member; the
/// whole change by the last doubling then counts as the error of the mesh.
///
/// On a coarse mesh, a force between two nodes bends the finger differently. The search compensates this difference by a wrong position and by a
/// modulus that is wrong by up to some tenths of a percent, more than the standard deviation that some images with little noise lead to.
///
/// # Errors
/// [`CalibrationError`] from the estimate on any of the meshes.
pub fn refined_views(
    finger: &Finger,
    views: &[View],
    sought: &[Sought],
    model: &ViewModel,
) -> Result<ViewEstimate, CalibrationError> {
    let mut model = *model;
    let (mut coarse, mut settled) = views_from(None, finger, views, sought, &model)?;
    while !sought.is_empty() {
        model.elements *= 2;
        let (mut fine, finer) = views_from(Some(settled), finger, views, sought, &model)?;
        let mut pairs = fine.quantities.iter().zip(&coarse.quantities);
        let is_settled = pairs.all(|(fine, coarse)| is_small(fine.value - coarse.value, fine));
        if is_settled || 2 * model.elements > MOST_ELEMENTS {
            let remains = if is_settled { REMAINS } else { 1.0 };
            for (fine, coarse) in fine.quantities.iter_mut().zip(&coarse.quantities) {
                fine.sigma = fine.sigma.hypot(remains * (fine.value - coarse.value));
            }
            return Ok(fine);
        }
        (coarse, settled) = (fine, finer);
    }
    Ok(coarse)
}

/// Whether a change of a quantity by refinement is small.
fn is_small(change: f64, found: &FoundQuantity) -> bool {
    let unit = if found.sought.quantity.is_modulus() { found.value } else { 1.0 };
    change.abs() <= (REFINEMENT_SIGMAS * found.sigma).max(NEGLIGIBLE * unit)
}
