//! Solver for any frame: sparse assembly (sprs) and Cholesky factorisation (faer).

use super::EquilibriumEquations;
use super::assembly::Assembly;
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion, PlaneFrame};
use finray_numerics::linear::{Cholesky, IndefiniteFactor};

/// Sparse equilibrium equations of any frame. Sparsity pattern and ordering are computed once.
#[derive(Debug, Clone)]
pub struct SparseEquations<'f> {
    assembly: Assembly<'f>,
    factor: Cholesky,
    /// Factorisation of the stiffness with accessible pivots. This factorisation is computed on demand.
    pivots: IndefiniteFactor,
    correction: Vec<f64>,
}

impl<'f> SparseEquations<'f> {
    /// Numbers the unknowns and builds the sparsity pattern.
    pub fn new(frame: &'f PlaneFrame, kinematics: Kinematics) -> SparseEquations<'f> {
        let assembly = Assembly::new(frame, kinematics);
        let correction = vec![0.0; assembly.equations().count()];
        SparseEquations { assembly, factor: Cholesky::default(), pivots: IndefiniteFactor::default(), correction }
    }

    /// The assembled equations.
    pub fn assembly(&self) -> &Assembly<'f> {
        &self.assembly
    }
}

impl EquilibriumEquations for SparseEquations<'_> {
    fn at_rest(&self) -> FrameMotion {
        FrameMotion::at_rest(self.assembly.frame())
    }

    fn kinematics(&self) -> Kinematics {
        self.assembly.kinematics()
    }

    fn linearise(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) -> bool {
        self.assembly.evaluate(motion, loads, factor);
        // The linear stiffness never changes, so its factorisation is kept. Newton's method refines the solution by the residual. The residual
        // follows from the element deformations, so it keeps digits that the factorisation of a fine mesh loses.
        let keep = self.kinematics() == Kinematics::Linear && self.factor.is_there();
        if !keep && !self.factor.factorise(self.assembly.stiffness()) {
            return false;
        }
        for (c, r) in self.correction.iter_mut().zip(self.assembly.residual()) {
            *c = -r;
        }
        self.factor.solve_in_place(&mut self.correction, self.assembly.equations().count())
    }

    fn log_determinant(&mut self) -> Option<f64> {
        self.pivots.factorise(self.assembly.stiffness())?;
        self.pivots.log_determinant()
    }

    fn elastic_energy(&self) -> f64 {
        self.assembly.elastic_energy()
    }

    fn correct(&mut self, motion: &mut FrameMotion) -> f64 {
        let linear = self.kinematics() == Kinematics::Linear;
        self.assembly.equations().advance(self.assembly.frame(), motion, &self.correction, linear);
        self.correction.iter().zip(self.assembly.residual()).map(|(c, r)| -c * r).sum()
    }
}
