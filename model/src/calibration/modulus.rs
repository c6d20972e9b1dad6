//! Estimates one modulus of the co-rotational finger. The method is robust to markers with a wrong node number.

use super::{
    CalibrationCase, CalibrationError, FactorModel, OutlyingMarker, RobustFactors, UnknownFactor, robust_factors,
};
use crate::Kinematics;
use crate::finger::Finger;
use crate::sensing::ResidualTest;

/// Modulus of the finger as a factor on the scene's modulus.
#[derive(Debug, Clone, PartialEq)]
pub struct ModulusEstimate {
    /// Factor on all moduli of the finger, dimensionless.
    pub factor: f64,
    /// Standard deviation of the factor, dimensionless, including the error of the mesh.
    pub sigma: f64,
    /// Mean distance between measured and computed positions of a node, mm.
    pub mean_distance_mm: f64,
    /// Test of the residual against the stated noise, if the measurement contradicts this noise. `sigma` then follows from the residual.
    pub contradiction: Option<ResidualTest>,
    /// Down-weighted markers that are far from their computed positions.
    pub outliers: Vec<OutlyingMarker>,
}

/// Young's modulus of the co-rotational finger by [`robust_factors`]: the factor on all moduli that minimises the sum of squared distances between
/// measured and computed positions of the nodes. Distant markers are down-weighted.
///
/// `elements` is the number of beam elements per member. `noise_mm` is the standard deviation of one measured coordinate, mm. If the noise is unknown
/// or contradicts the residual, it is estimated from the residual.
///
/// # Reference
/// Eq. (11) of Xu et al. (2021) as in [`youngs_modulus`](super::youngs_modulus), with co-rotational equilibria and weighted squares of distances.
///
/// # Errors
/// [`CalibrationError`] if the statics fail at every tried modulus, or the factor is not identifiable.
pub fn corotational_modulus(
    finger: &Finger,
    cases: &[CalibrationCase],
    elements: usize,
    noise_mm: Option<f64>,
) -> Result<ModulusEstimate, CalibrationError> {
    let model = FactorModel { kinematics: Kinematics::Corotational, elements, noise_mm };
    let RobustFactors { estimate, contradiction, outliers } =
        robust_factors(finger, cases, &[UnknownFactor::Modulus], &model)?;
    let factor = estimate.factors[0];
    Ok(ModulusEstimate {
        factor,
        sigma: factor * estimate.relative_sigmas[0],
        mean_distance_mm: estimate.distances_mm.iter().sum::<f64>() / estimate.distances_mm.len() as f64,
        contradiction,
        outliers,
    })
}
