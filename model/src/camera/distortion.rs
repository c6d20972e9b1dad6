//! Distortion of lenses: the polynomial, rational and fisheye models, in OpenCV's convention.

use nalgebra::{Matrix2, Vector2};

/// Tangent of the largest considered angle from the optical axis, 79 degrees.
const WIDEST: f64 = 5.0;
/// Number of radii at which a fold is searched for. The slope of the distorted radius has at most three sign changes for a polynomial, and few for the
/// rational and the fisheye model, so that no two of them share a step in practice.
const FOLD_STEPS: usize = 2000;
/// Below this r^2, `atan(r) / r` and its derivative come from a series. The first neglected term of the derivative is 7 q^6 / 15, below 1e-13.
const NEAR_AXIS: f64 = 5e-3;

/// Distortion coefficients in OpenCV's convention, dimensionless. Here x and y are the undistorted coordinates X/Z and Y/Z, and r^2 = x^2 + y^2.
///
/// The distorted coordinates are x' = x f + 2 p1 x y + p2 (r^2 + 2 x^2) and y' = y f + p1 (r^2 + 2 y^2) + 2 p2 x y, with the factor f of [`Radial`].
///
/// Source: D. C. Brown, Decentering distortion of lenses, Photogrammetric Engineering 32 (1966); OpenCV, calib3d.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// Radial distortion.
    pub radial: Radial,
    /// Tangential coefficients p1, p2, dimensionless; zero for a fisheye lens.
    pub tangential: [f64; 2],
}

/// Radial distortion: the factor f by which the distance r from the optical axis grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Radial {
    /// f = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6). The polynomial model of Brown and Conrady has the denominator 1.
    Rational {
        /// k1, k2, k3.
        numerator: [f64; 3],
        /// k4, k5, k6.
        denominator: [f64; 3],
    },
    /// f = t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) / r with the angle t = atan r from the optical axis.
    ///
    /// Source: J. Kannala, S. S. Brandt, A generic camera model, IEEE Trans. PAMI 28 (2006).
    Fisheye([f64; 4]),
}

impl Default for Radial {
    fn default() -> Radial {
        Radial::Rational { numerator: [0.0; 3], denominator: [0.0; 3] }
    }
}

/// A list of coefficients that is no supported distortion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CoefficientsError {
    /// The list has no length of the model of Brown and Conrady, polynomial or rational.
    #[error("4 (k1, k2, p1, p2), 5 (and k3) or 8 coefficients (and k4, k5, k6), found {0}")]
    Count(usize),
    /// The list has no length of the fisheye model.
    #[error("the 4 coefficients of a fisheye lens (k1, k2, k3, k4), found {0}")]
    FisheyeCount(usize),
    /// The list states a thin prism: s1, s2, s3 or s4 is not zero.
    #[error(
        "at most 8 coefficients, found a thin prism (s1 to s4, coefficients 9 to 12): calibrate without the thin prism model"
    )]
    ThinPrism,
    /// The list states a tilted sensor: a coefficient after the twelfth is not zero.
    #[error(
        "at most 8 coefficients, found a tilted sensor (coefficients 13 and 14): calibrate without the tilted model"
    )]
    Tilted,
}

impl Distortion {
    /// Distortion from the coefficients k1, k2, p1, p2, k3, in OpenCV's order.
    pub fn from_opencv([k1, k2, p1, p2, k3]: [f64; 5]) -> Distortion {
        let radial = Radial::Rational { numerator: [k1, k2, k3], denominator: [0.0; 3] };
        Distortion { radial, tangential: [p1, p2] }
    }

    /// Distortion from the coefficients k1, k2, p1, p2, k3, k4, k5, k6 in OpenCV's order, of which 4, 5 or 8 are given; an empty list is no distortion.
    /// OpenCV also writes 12 or 14 coefficients: those after the eighth must be zero.
    ///
    /// # Errors
    /// [`CoefficientsError`] for another number of coefficients, a thin prism or a tilted sensor.
    pub fn rational(coefficients: &[f64]) -> Result<Distortion, CoefficientsError> {
        if !matches!(coefficients.len(), 0 | 4 | 5 | 8 | 12 | 14) {
            return Err(CoefficientsError::Count(coefficients.len()));
        }
        match coefficients.iter().rposition(|value| *value != 0.0) {
            Some(12..) => return Err(CoefficientsError::Tilted),
            Some(8..) => return Err(CoefficientsError::ThinPrism),
            _ => {}
        }
        let [k1, k2, p1, p2, k3, k4, k5, k6] = std::array::from_fn(|i| coefficients.get(i).copied().unwrap_or(0.0));
        let radial = Radial::Rational { numerator: [k1, k2, k3], denominator: [k4, k5, k6] };
        Ok(Distortion { radial, tangential: [p1, p2] })
    }

    /// Distortion of a fisheye lens from its coefficients k1, k2, k3, k4; an empty list stands for zeros.
    ///
    /// # Errors
    /// [`CoefficientsError`] for another number of coefficients.
    pub fn fisheye(coefficients: &[f64]) -> Result<Distortion, CoefficientsError> {
        let four = if coefficients.is_empty() { Ok([0.0; 4]) } else { coefficients.try_into() };
        let four = four.map_err(|_| CoefficientsError::FisheyeCount(coefficients.len()))?;
        Ok(Distortion { radial: Radial::Fisheye(four), tangential: [0.0; 2] })
    }

    /// Whether the lens is a fisheye lens.
    pub fn is_fisheye(&self) -> bool {
        matches!(self.radial, Radial::Fisheye(_))
    }

    /// The coefficients in OpenCV's order: k1, k2, p1, p2, k3 of a polynomial, further k4, k5, k6 of a rational lens; k1, k2, k3, k4 of a fisheye lens.
    pub fn coefficients(&self) -> Vec<f64> {
        let [p1, p2] = self.tangential;
        match self.radial {
            Radial::Fisheye(coefficients) => coefficients.to_vec(),
            Radial::Rational { numerator: [k1, k2, k3], denominator } => {
                let further: &[f64] = if denominator == [0.0; 3] { &[] } else { &denominator };
                [&[k1, k2, p1, p2, k3], further].concat()
            }
        }
    }

    /// Radial factor f and its derivative by q = r^2; dimensionless. `None` beyond a pole of a rational lens.
    pub(super) fn factor(&self, q: f64) -> Option<(f64, f64)> {
        match self.radial {
            Radial::Rational { numerator, denominator } => {
                let [(top, top_by_q), (bottom, bottom_by_q)] = [numerator, denominator]
                    .map(|[a, b, c]| (1.0 + q * (a + q * (b + q * c)), a + q * (2.0 * b + q * 3.0 * c)));
                let f = top / bottom;
                (bottom > 0.0).then(|| (f, (top_by_q - f * bottom_by_q) / bottom))
            }
            Radial::Fisheye([k1, k2, k3, k4]) => {
                let (angle, angle_by_q) = angle_over_tangent(q);
                let t = q * angle * angle;
                let bent = 1.0 + t * (k1 + t * (k2 + t * (k3 + t * k4)));
                let bent_by_t = k1 + t * (2.0 * k2 + t * (3.0 * k3 + t * 4.0 * k4));
                Some((angle * bent, angle_by_q * bent + angle * bent_by_t * angle / (1.0 + q)))
            }
        }
    }

    /// Distorted coordinates, and their 2 x 2 derivatives by the undistorted coordinates; dimensionless. `None` beyond a pole of a rational lens.
    pub(super) fn bend(&self, at: &Vector2<f64>) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let (x, y, q) = (at.x, at.y, at.norm_squared());
        let (f, slope) = self.factor(q)?;
        let [p1, p2] = self.tangential;
        let bent = Vector2::new(
            x * f + 2.0 * p1 * x * y + p2 * (q + 2.0 * x * x),
            y * f + p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let mixed = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let by_x = f + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let by_y = f + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        Some((bent, Matrix2::new(by_x, mixed, mixed, by_y)))
    }

    /// Undistorted radius of the first fold of the radial part, where r f(r^2) stops growing; dimensionless, at most [`WIDEST`].
    pub(super) fn first_fold(&self) -> f64 {
        let grows = |r: f64| self.factor(r * r).is_some_and(|(f, by_q)| f + 2.0 * r * r * by_q > 0.0);
        let radius = |step: usize| WIDEST * step as f64 / FOLD_STEPS as f64;
        let Some(step) = (1..=FOLD_STEPS).find(|&step| !grows(radius(step))) else { return WIDEST };
        let (mut below, mut above) = (radius(step - 1), radius(step));
        while above - below > f64::EPSILON * above {
            let middle = 0.5 * (below + above);
            if middle <= below || middle >= above {
                break;
            }
            if grows(middle) { below = middle } else { above = middle }
        }
        below
    }
}

/// `atan(r) / r` and its derivative by q = r^2.
fn angle_over_tangent(q: f64) -> (f64, f64) {
    if q < NEAR_AXIS {
        let series = |terms: [f64; 6]| terms.iter().rev().fold(0.0, |sum, term| term + q * sum);
        return (
            series([1.0, -1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0]) + q.powi(6) / 13.0,
            series([-1.0 / 3.0, 2.0 / 5.0, -3.0 / 7.0, 4.0 / 9.0, -5.0 / 11.0, 6.0 / 13.0]),
        );
    }
    let r = q.sqrt();
    let share = r.atan() / r;
    (share, (1.0 / (1.0 + q) - share) / (2.0 * q))
}
