//! A second formulation of plane beams, for problems with limit loads: the differential equation of the elastic line, integrated from one end to the
//! other (shooting). This formulation shares the Euler-Bernoulli theory with the model, but neither the elements nor the solver.

use super::ProblemError;
use nalgebra::{DMatrix, DVector};

/// Number of integration steps for each straight segment. The error falls with the fourth power of the step length and is below 1e-10.
const STEPS: usize = 200;
/// Step of central differences, relative to the scale of each unknown. Truncation and rounding errors both stay below 1e-9.
const DIFFERENCE_STEP: f64 = 1e-5;
/// The search has converged if the correction, relative to the scale of each unknown, is below this value. Second differences allow no smaller
/// value. To first order, an error of the position on the equilibrium path does not change the limit load.
const CORRECTION_TOLERANCE: f64 = 1e-7;
/// Largest number of corrections. A search that needs more corrections started too far from the limit load.
const MAX_CORRECTIONS: usize = 40;

/// Rigidities of a beam, in the consistent units of its problem.
#[derive(Debug, Clone, Copy)]
pub struct Rigidity {
    /// Axial rigidity EA, in units of force.
    pub axial: f64,
    /// Bending rigidity EI, in units of force times length squared.
    pub bending: f64,
}

/// A cross-section of the deformed beam: position, direction of the axis, and stress resultants, in the consistent units of its problem.
#[derive(Debug, Clone, Copy)]
pub struct Section {
    /// Position (x, y), in units of length.
    pub at: [f64; 2],
    /// Direction of the axis, rad, from x towards y.
    pub direction: f64,
    /// Force (x, y) that the part of the beam beyond this section exerts on the section, in units of force.
    pub force: [f64; 2],
    /// Moment that the part of the beam beyond this section exerts on the section, in units of force times length.
    pub moment: f64,
}

impl Section {
    /// The section at the end of a straight segment of the given undeformed length, by the classical Runge-Kutta method.
    ///
    /// Derivatives with respect to the undeformed length, with position r, unit tangent t, moment M, constant force F and axial force N = F . t: r' =
    /// (1 + N / EA) t, direction' = M / EI, M' = -r' x F.
    ///
    /// Source: Antman, Nonlinear Problems of Elasticity, ch. 4 (planar elastica without shear).
    pub fn beyond(self, length: f64, rigidity: Rigidity) -> Section {
        let [fx, fy] = self.force;
        let slope = |[_, _, direction, moment]: [f64; 4]| {
            let (sin, cos) = f64::sin_cos(direction);
            let stretch = 1.0 + (fx * cos + fy * sin) / rigidity.axial;
            [stretch * cos, stretch * sin, moment / rigidity.bending, stretch * (fx * sin - fy * cos)]
        };
        let step = length / STEPS as f64;
        let mut state = [self.at[0], self.at[1], self.direction, self.moment];
        for _ in 0..STEPS {
            let moved = |by: [f64; 4], share: f64| std::array::from_fn(|i| state[i] + share * step * by[i]);
            let k1 = slope(state);
            let k2 = slope(moved(k1, 0.5));
            let k3 = slope(moved(k2, 0.5));
            let k4 = slope(moved(k3, 1.0));
            state = std::array::from_fn(|i| state[i] + step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
        Section { at: [state[0], state[1]], direction: state[2], moment: state[3], ..self }
    }
}

/// The limit load nearest to `start`. `start` contains the unknowns and, as its last entry, the load. At the limit load the N residuals `miss` are
/// zero and their derivative with respect to the unknowns is singular. `scale` contains the magnitude of each entry of `start`. Fails if the search
/// does not converge.
pub(crate) fn limit_load<const N: usize, const M: usize>(
    miss: impl Fn(&[f64; M]) -> [f64; N],
    start: [f64; M],
    scale: [f64; M],
) -> Result<f64, ProblemError> {
    let moved = |at: &[f64; M], i: usize, share: f64| {
        let mut moved = *at;
        moved[i] += share * scale[i];
        moved
    };
    // Derivatives with respect to the scaled unknowns and load.
    let derivative = |at: &[f64; M]| {
        let columns: [_; M] = std::array::from_fn(|i| {
            let (plus, minus) = (miss(&moved(at, i, DIFFERENCE_STEP)), miss(&moved(at, i, -DIFFERENCE_STEP)));
            DVector::from_fn(N, |row, _| (plus[row] - minus[row]) / (2.0 * DIFFERENCE_STEP))
        });
        DMatrix::from_columns(&columns)
    };
    let singular = |at: &[f64; M]| derivative(at).columns(0, N).into_owned().determinant();
    let mut at = start;
    for _ in 0..MAX_CORRECTIONS {
        let (missed, by) = (miss(&at), derivative(&at));
        let value = DVector::from_fn(M, |i, _| if i < N { missed[i] } else { singular(&at) });
        // The determinant already consists of differences, so differences of the determinant need longer steps.
        let step = 100.0 * DIFFERENCE_STEP;
        let by_singular: [f64; M] =
            std::array::from_fn(|i| (singular(&moved(&at, i, step)) - singular(&moved(&at, i, -step))) / (2.0 * step));
        let matrix =
            DMatrix::from_fn(M, M, |row, column| if row < N { by[(row, column)] } else { by_singular[column] });
        let Some(correction) = matrix.lu().solve(&-value) else { break };
        for i in 0..M {
            at[i] += correction[i] * scale[i];
        }
        if correction.amax() <= CORRECTION_TOLERANCE {
            return Ok(at[M - 1]);
        }
    }
    Err(ProblemError::Reference("the elastic line has no limit load near the start of the search".to_owned()))
}
