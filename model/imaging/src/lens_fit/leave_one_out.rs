//! Scatter of a fitted lens between images, estimated by the jackknife.

use super::usual_lens::PARAMETERS;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

type Normal = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Smallest number of images from which the scatter is estimated.
const LEAST_IMAGES: usize = 3;

/// Standard deviations of the lens's parameters by the jackknife, which omits each image in turn and uses the resulting changes of the parameters.
/// The standard deviations include errors that the dots of an image share, for instance due to a bent board or a wrong model of the dots. The columns
/// of `jacobian` belong to the lens's parameters, then six to each pose. The rows of `jacobian` are two per dot, image by image, followed by the rows
/// of the priors. `dots` is the number of dots of each image. `None` for fewer than three images, or if a parameter depends on a single image.
///
/// # Reference
/// B. Efron, The jackknife, the bootstrap and other resampling plans, SIAM (1982), sec. 3. The effect of omitting an image is linearised.
pub(super) fn sds(jacobian: &DMatrix<f64>, residual: &DVector<f64>, dots: &[usize]) -> Option<[f64; PARAMETERS]> {
    if dots.len() < LEAST_IMAGES {
        return None;
    }
    let mut images: Vec<(Normal, SVector<f64, PARAMETERS>)> = Vec::with_capacity(dots.len());
    let mut row = 0;
    for (number, count) in dots.iter().enumerate() {
        let by_lens = jacobian.view((row, 0), (2 * count, PARAMETERS));
        let by_pose = jacobian.view((row, PARAMETERS + 6 * number), (2 * count, 6));
        let mixed = by_pose.tr_mul(&by_lens);
        // The pose of the grid adapts to a change of the lens, so the pose is eliminated from the normal equations.
        let eliminated = mixed.tr_mul(&by_pose.tr_mul(&by_pose).cholesky()?.solve(&mixed));
        let normal = by_lens.tr_mul(&by_lens) - eliminated;
        let gradient = by_lens.tr_mul(&residual.rows(row, 2 * count));
        images.push((Normal::from_fn(|i, k| normal[(i, k)]), SVector::from_fn(|i, _| gradient[i])));
        row += 2 * count;
    }
    let priors = jacobian.view((row, 0), (jacobian.nrows() - row, PARAMETERS));
    let priors = priors.tr_mul(&priors);
    let all = images.iter().fold(Normal::from_fn(|i, k| priors[(i, k)]), |sum, (normal, _)| sum + normal);
    let mut squares = SVector::<f64, PARAMETERS>::zeros();
    for (normal, gradient) in &images {
        let change = (all - normal).cholesky()?.solve(gradient);
        squares += change.component_mul(&change);
    }
    let share = 1.0 - 1.0 / dots.len() as f64;
    Some(std::array::from_fn(|i| (share * squares[i]).sqrt()))
}
