//! Priors of a typical lens and sensor, for parameters that the images of a grid do not determine.

use finray_numerics::optimise::Prior;

/// Number of parameters of the lens: focal lengths, principal point, k1, k2, p1, p2, k3.
pub(super) const PARAMETERS: usize = 9;
/// Prior standard deviation of the logarithm of the ratio of the two focal lengths.
const ASPECT_SD: f64 = 0.005;
/// Prior standard deviation of the principal point's offset from the middle of the image, as a share of the image's width.
const CENTRE_SD: f64 = 0.03;
/// Prior standard deviations of the radial distortion coefficients k1, k2, k3.
const RADIAL_SD: [f64; 3] = [0.5, 0.5, 0.2];
/// Prior standard deviation of the tangential distortion coefficients p1 and p2.
const TANGENTIAL_SD: f64 = 0.003;

/// Prior distributions of the parameters of a typical lens, in the order of [`LENS_PARAMETERS`](super::LENS_PARAMETERS).
#[derive(Debug, Clone, Copy)]
pub(super) struct UsualLens {
    /// Middle of the image, px.
    pub middle: [f64; 2],
    /// Width of the image, px.
    pub width: f64,
    /// Expected focal length, px.
    pub focal: f64,
    /// Standard deviation of the logarithm of the focal length, dimensionless.
    pub focal_sd: f64,
}

impl UsualLens {
    /// Priors on all parameters, evaluated at the parameters `p`.
    pub fn priors(&self, p: &[f64; PARAMETERS]) -> Vec<Prior> {
        let centre = CENTRE_SD * self.width;
        let focal =
            Prior { residual: (p[0] / self.focal).ln() / self.focal_sd, by: vec![(0, 1.0 / (p[0] * self.focal_sd))] };
        let aspect = Prior {
            residual: (p[1] / p[0]).ln() / ASPECT_SD,
            by: vec![(0, -1.0 / (p[0] * ASPECT_SD)), (1, 1.0 / (p[1] * ASPECT_SD))],
        };
        let middle = (0..2).map(|axis| Prior::on(2 + axis, p[2 + axis], self.middle[axis], centre));
        let coefficients = self.coefficient_sds().map(|(i, sd)| Prior::on(i, p[i], 0.0, sd));
        [focal, aspect].into_iter().chain(middle).chain(coefficients).collect()
    }

    fn coefficient_sds(&self) -> [(usize, f64); 5] {
        let [k1, k2, k3] = RADIAL_SD;
        [(4, k1), (5, k2), (6, TANGENTIAL_SD), (7, TANGENTIAL_SD), (8, k3)]
    }

    /// Standard deviation of each parameter by the prior alone, in the units of [`LENS_PARAMETERS`](super::LENS_PARAMETERS).
    pub fn sds(&self, p: &[f64; PARAMETERS]) -> [f64; PARAMETERS] {
        let mut sds = [0.0; PARAMETERS];
        (sds[0], sds[1]) = (self.focal_sd * p[0], self.focal_sd.hypot(ASPECT_SD) * p[1]);
        (sds[2], sds[3]) = (CENTRE_SD * self.width, CENTRE_SD * self.width);
        for (i, sd) in self.coefficient_sds() {
            sds[i] = sd;
        }
        sds
    }
}
