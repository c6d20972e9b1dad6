//! Least-squares problem of modulus factors: fits computed equilibria to measurements.

use super::{FactorModel, UnknownFactor};
use crate::Vector;
use crate::calibration::{CalibrationCase, CalibrationError};
use crate::finger::{Finger, ImpossibleFinger};
use crate::frame::{FrameLoad, FrameMotion};
use crate::keys::{SceneTable, ZONE};
use crate::mesh::Mesh;
use crate::optimise::{LeastSquaresProblem, Refusal, StepBounds};
use crate::statics::{Statics, StaticsError, equilibria};
use nalgebra::{DMatrix, DVector};

/// A step changes ln(factor) by at most this value, dimensionless. A change of 1 multiplies or divides the factor by e.
const LARGEST_STEP: f64 = 1.0;

/// Least-squares problem of the modulus factors. Residuals are weighted differences of displacements (computed minus measured), mm, in two rows (x, y) per
/// marker. The unknowns are logarithms of the factors.
pub(super) struct FactorProblem<'p> {
    pub finger: &'p Finger,
    pub cases: &'p [CalibrationCase],
    pub unknowns: &'p [UnknownFactor],
    pub model: &'p FactorModel,
    /// Equilibrium of each case at the last evaluated point.
    pub motions: Vec<FrameMotion>,
}

impl FactorProblem<'_> {
    fn mesh(&self, logs: &DVector<f64>) -> Result<Mesh, CalibrationError> {
        let finger = with_factors(self.finger, self.unknowns, logs.as_slice())?;
        Ok(Mesh::with_elements_per_member(&finger, self.model.elements))
    }

    fn loads(&self, mesh: &Mesh) -> Result<Vec<[FrameLoad; 1]>, CalibrationError> {
        let loads = self.cases.iter().map(|case| mesh.frame_load(&case.load).map(|load| [load]));
        Ok(loads.collect::<Result<_, _>>().map_err(StaticsError::from)?)
    }

    /// Weighted residuals, mm, at the equilibria of all cases. Stores the equilibria for `jacobian_at`. [`CalibrationError`] if the finger is
    /// impossible or has no equilibrium.
    pub fn residual_at(&mut self, logs: &DVector<f64>) -> Result<DVector<f64>, CalibrationError> {
        let mesh = self.mesh(logs)?;
        let found = equilibria(&mesh, self.model.kinematics, &self.loads(&mesh)?);
        self.motions = found.into_iter().map(|found| Ok(found?.motion)).collect::<Result<_, StaticsError>>()?;
        let mut rows = Vec::new();
        for (case, motion) in self.cases.iter().zip(&self.motions) {
            let shape = mesh.shape(motion);
            for marker in case.measurement.markers() {
                let computed = shape.motion(marker.node).marker_displacement(mesh.finger());
                rows.extend(((computed - marker.displacement) * marker.weight).iter());
            }
        }
        Ok(DVector::from_vec(rows))
    }

    /// Derivatives of the residuals with respect to the logarithms, mm, at the equilibria of the last `residual_at`. [`CalibrationError`] if an
    /// equilibrium is unstable or the finger is impossible.
    pub fn jacobian_at(&self, logs: &DVector<f64>) -> Result<DMatrix<f64>, CalibrationError> {
        let mesh = self.mesh(logs)?;
        let shares: Vec<_> = self.unknowns.iter().map(|unknown| shares(&mesh, unknown)).collect();
        let mut statics = Statics::ladder(&mesh, self.model.kinematics);
        let mut response = vec![Vector::zeros(); mesh.frame().node_count()];
        let coordinates = self.cases.iter().map(|case| case.measurement.coordinate_count()).sum();
        let mut jacobian = DMatrix::zeros(coordinates, self.unknowns.len());
        let mut row = 0;
        for ((case, load), motion) in self.cases.iter().zip(&self.loads(&mesh)?).zip(&self.motions) {
            if !statics.linearise(motion, load) {
                return Err(StaticsError::NoEquilibrium { converged_fraction: 1.0 }.into());
            }
            for (column, shares) in shares.iter().enumerate() {
                statics.equations_mut().stiffened(motion, shares, &mut response);
                for (i, marker) in case.measurement.markers().iter().enumerate() {
                    let change = response[mesh.frame_node(marker.node)] * marker.weight;
                    jacobian.fixed_view_mut::<2, 1>(row + 2 * i, column).copy_from(&change);
                }
            }
            row += case.measurement.coordinate_count();
        }
        Ok(jacobian)
    }
}

impl LeastSquaresProblem for FactorProblem<'_> {
    type Point = DVector<f64>;
    type Error = CalibrationError;

    fn residual(&mut self, logs: &DVector<f64>) -> Result<DVector<f64>, Refusal<CalibrationError>> {
        self.residual_at(logs).map_err(refusal)
    }

    fn jacobian(&mut self, logs: &DVector<f64>, _: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<CalibrationError>> {
        self.jacobian_at(logs).map_err(refusal)
    }

    fn moved(&self, logs: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        logs + step
    }

    fn step_bounds(&self, logs: &DVector<f64>) -> StepBounds {
        StepBounds::within(logs.len(), LARGEST_STEP)
    }
}

/// Requests a shorter step if the statics have no solution, for example because the finger is too soft. Other errors end the search.
fn refusal(error: CalibrationError) -> Refusal<CalibrationError> {
    match error {
        CalibrationError::Statics(_) => Refusal::Here(error),
        _ => Refusal::Altogether(error),
    }
}

/// Index of each affected member, and the relative change of the member's stiffness per relative change of the unknown factor.
fn shares(mesh: &Mesh, unknown: &UnknownFactor) -> Vec<(usize, f64)> {
    match unknown {
        UnknownFactor::Modulus => (0..mesh.frame().members().len()).map(|member| (member, 1.0)).collect(),
        UnknownFactor::Zones(zones) => zones.iter().flat_map(|&zone| mesh.zone_shares(zone)).collect(),
    }
}

/// The finger with factors applied. `logs` are the natural logarithms of the factors.
pub(super) fn with_factors(
    finger: &Finger,
    unknowns: &[UnknownFactor],
    logs: &[f64],
) -> Result<Finger, ImpossibleFinger> {
    let mut description = finger.description().clone();
    let mut general = 1.0;
    for (unknown, log) in unknowns.iter().zip(logs) {
        match unknown {
            UnknownFactor::Modulus => general *= log.exp(),
            UnknownFactor::Zones(zones) => {
                for &zone in zones {
                    let missing = || ImpossibleFinger {
                        key: ZONE.path().to_owned(),
                        reason: format!(
                            "expected at least {} zones, found {}",
                            zone + 1,
                            finger.description().zones.len()
                        ),
                    };
                    description.zones.get_mut(zone).ok_or_else(missing)?.modulus_factor *= log.exp();
                }
            }
        }
    }
    Finger::new(description)?.with_modulus_factor(general)
}
