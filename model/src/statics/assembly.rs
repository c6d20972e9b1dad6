//! Assembly of element responses into energy, residual and tangent stiffness of the frame.

use crate::Vector;
use crate::element::{Kinematics, Response};
use crate::frame::{BeamEnd, Equations, FrameLoad, FrameMotion, MEMBER_COORDINATES, PlaneFrame};
use sprs::{CsMat, TriMat};

/// Index of each entry of a member's matrix in the array of sparse values; `ABSENT` for a fixed coordinate.
type Slots = [[u32; MEMBER_COORDINATES]; MEMBER_COORDINATES];
const ABSENT: u32 = u32::MAX;

/// Energy, residual and tangent stiffness of a frame. The sparsity pattern is computed only once.
#[derive(Debug, Clone)]
pub struct Assembly<'f> {
    frame: &'f PlaneFrame,
    kinematics: Kinematics,
    equations: Equations,
    /// Tangent stiffness, n x n for n unknowns.
    stiffness: CsMat<f64>,
    /// Slots of each member's matrix.
    slots: Vec<Slots>,
    /// Residual, one entry per equation; N or N mm.
    gradient: Vec<f64>,
    /// Forces of the loads at factor 1, one entry per equation; N or N mm.
    load_vector: Vec<f64>,
    /// Elastic energy, N mm.
    energy: f64,
}

impl<'f> Assembly<'f> {
    /// Numbers the unknowns and builds the sparsity pattern.
    pub fn new(frame: &'f PlaneFrame, kinematics: Kinematics) -> Assembly<'f> {
        let equations = Equations::of(frame);
        let count = equations.count();
        let members: Vec<_> = frame.members().iter().map(|member| equations.of_ends(frame, &member.ends)).collect();
        let mut pattern = TriMat::new((count, count));
        for coordinates in &members {
            for row in coordinates.iter().flatten() {
                for column in coordinates.iter().flatten() {
                    pattern.add_triplet(*row, *column, 0.0);
                }
            }
        }
        let stiffness: CsMat<f64> = pattern.to_csc();
        let slot = |row: Option<usize>, column: Option<usize>| match (row, column) {
            (Some(row), Some(column)) => stiffness.nnz_index(row, column).map_or(ABSENT, |index| index.0 as u32),
            _ => ABSENT,
        };
        let slots = members.iter().map(|c| c.map(|row| c.map(|column| slot(row, column)))).collect();
        let (gradient, load_vector) = (vec![0.0; count], vec![0.0; count]);
        Assembly { frame, kinematics, equations, stiffness, slots, gradient, load_vector, energy: 0.0 }
    }

    /// The assembled frame.
    pub fn frame(&self) -> &'f PlaneFrame {
        self.frame
    }

    /// The kinematics with which the elements are evaluated.
    pub fn kinematics(&self) -> Kinematics {
        self.kinematics
    }

    /// The numbering of the unknowns.
    pub fn equations(&self) -> &Equations {
        &self.equations
    }

    /// Tangent stiffness of the last [`evaluate`](Assembly::evaluate). The matrix is n x n for n unknowns; its upper and its lower triangle are
    /// stored. Its entries are in N/mm, N or N mm.
    pub fn stiffness(&self) -> &CsMat<f64> {
        &self.stiffness
    }

    /// Internal minus external forces, computed by the last [`evaluate`](Assembly::evaluate), one entry per equation; N or N mm.
    pub fn residual(&self) -> &[f64] {
        &self.gradient
    }

    /// Forces of the loads at factor 1 and at the motion of the last [`evaluate`](Assembly::evaluate), one per equation; N or N mm. If the load
    /// factor grows by 1, the residual falls by the load vector.
    pub fn load_vector(&self) -> &[f64] {
        &self.load_vector
    }

    /// Elastic energy of the last [`evaluate`](Assembly::evaluate), N mm.
    pub fn elastic_energy(&self) -> f64 {
        self.energy
    }

    fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// Computes elastic energy, residual and tangent stiffness at a motion, under `factor` times the loads.
    pub fn evaluate(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        self.gradient.fill(0.0);
        self.stiffness.data_mut().fill(0.0);
        self.energy = 0.0;
        for load in loads {
            self.add_load(motion, load);
        }
        for (force, gradient) in self.load_vector.iter_mut().zip(&mut self.gradient) {
            *force = -*gradient;
            *gradient *= factor;
        }
        self.stiffness.data_mut().iter_mut().for_each(|value| *value *= factor);
        let frame = self.frame;
        for (index, member) in frame.members().iter().enumerate() {
            let response = member.response(motion, self.kinematics);
            self.energy += response.energy;
            self.scatter_member(motion, index, &response);
        }
    }

    /// Adds the derivatives of a load's potential to residual and tangent stiffness.
    fn add_load(&mut self, motion: &FrameMotion, load: &FrameLoad) {
        let frame = self.frame;
        match *load {
            FrameLoad::Node { node, force, moment_nmm } => {
                self.add_point_load(motion, frame.clamped_end(node), force, moment_nmm);
            }
            FrameLoad::Arm { end, force } => self.add_point_load(motion, end, force, 0.0),
            FrameLoad::Interior { member, xi, force } => {
                let potential = frame.interior_load(motion, member, self.kinematics, xi, force);
                self.scatter_member(motion, member, &potential);
            }
        }
    }

    fn add_point_load(&mut self, motion: &FrameMotion, end: BeamEnd, force: Vector, moment_nmm: f64) {
        let ends = [end, end];
        let potential = self.frame.end_load(motion, end, force, moment_nmm, self.linear());
        let nodes = ends.map(|end| end.node);
        let (gradient, tangent) = self.frame.carry_over_links(motion, nodes, &potential, self.linear());
        // The end of a rigid arm moves on a circle about its node, so the load's tangent has only diagonal entries.
        for (k, equation) in self.equations.of_ends(self.frame, &ends).iter().enumerate() {
            if let Some(e) = *equation {
                self.gradient[e] += gradient[k];
                if let Some(index) = self.stiffness.nnz_index(e, e) {
                    self.stiffness.data_mut()[index.0] += tangent[(k, k)];
                }
            }
        }
    }

    fn scatter_member(&mut self, motion: &FrameMotion, index: usize, response: &Response) {
        let ends = self.frame.members()[index].ends;
        let (gradient, tangent) =
            self.frame.carry_over_links(motion, ends.map(|end| end.node), response, self.linear());
        let values = self.stiffness.data_mut();
        for (row, equation) in self.equations.of_ends(self.frame, &ends).iter().enumerate() {
            let Some(equation) = *equation else { continue };
            self.gradient[equation] += gradient[row];
            for (column, &slot) in self.slots[index][row].iter().enumerate() {
                if slot != ABSENT {
                    values[slot as usize] += tangent[(row, column)];
                }
            }
        }
    }
}
