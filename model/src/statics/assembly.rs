//! From the elements to the energy, residual and tangent stiffness of the frame.

use crate::element::{Kinematics, Response};
use crate::frame::{Attachment, BeamEnd, Equations, FrameMotion, MEMBER_COORDINATES, PlaneFrame};
use crate::{Vector, frame::NodeIndex};
use nalgebra::{SMatrix, SVector};
use sprs::{CsMat, TriMat};

/// A dead load on a frame: it keeps its direction whatever the frame does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrameLoad {
    /// Force (N) and moment (N mm) on a node.
    Node {
        /// The node.
        node: NodeIndex,
        /// Force, N.
        force: Vector,
        /// Moment, N mm, from x to y.
        moment_nmm: f64,
    },
    /// Force (N) at the end of a rigid arm.
    Arm {
        /// The beam end whose arm carries the force.
        end: BeamEnd,
        /// Force, N.
        force: Vector,
    },
    /// Force (N) between the ends of a member.
    Interior {
        /// Index of the member.
        member: usize,
        /// Fraction of its length, 0..1.
        xi: f64,
        /// Force, N.
        force: Vector,
    },
}

impl FrameLoad {
    /// The load multiplied by a factor.
    pub fn scaled(self, factor: f64) -> FrameLoad {
        match self {
            FrameLoad::Node { node, force, moment_nmm } => {
                FrameLoad::Node { node, force: force * factor, moment_nmm: moment_nmm * factor }
            }
            FrameLoad::Arm { end, force } => FrameLoad::Arm { end, force: force * factor },
            FrameLoad::Interior { member, xi, force } => FrameLoad::Interior { member, xi, force: force * factor },
        }
    }

    /// Whether force, moment and place are finite numbers.
    pub fn is_finite(&self) -> bool {
        let force_is_finite = |force: &Vector| force.iter().all(|f| f.is_finite());
        match self {
            FrameLoad::Node { force, moment_nmm, .. } => force_is_finite(force) && moment_nmm.is_finite(),
            FrameLoad::Arm { force, .. } => force_is_finite(force),
            FrameLoad::Interior { xi, force, .. } => xi.is_finite() && force_is_finite(force),
        }
    }
}

/// Position in the value array of each entry of a member's matrix; `ABSENT` where a coordinate is held.
type Slots = [[u32; MEMBER_COORDINATES]; MEMBER_COORDINATES];
const ABSENT: u32 = u32::MAX;

/// Energy, residual and tangent stiffness of a frame; the sparsity pattern is found once.
#[derive(Debug, Clone)]
pub struct Assembly<'f> {
    frame: &'f PlaneFrame,
    kinematics: Kinematics,
    equations: Equations,
    stiffness: CsMat<f64>,
    slots: Vec<Slots>,
    gradient: Vec<f64>,
    energy: f64,
}

impl<'f> Assembly<'f> {
    /// Numbers the unknowns and lays out the matrix.
    pub fn new(frame: &'f PlaneFrame, kinematics: Kinematics) -> Assembly<'f> {
        let equations = Equations::of(frame);
        let count = equations.count();
        let members: Vec<_> =
            frame.members().iter().map(|member| equations.of_pair(frame, &member.ends.map(Attachment::from))).collect();
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
        Assembly { frame, kinematics, equations, stiffness, slots, gradient: vec![0.0; count], energy: 0.0 }
    }

    /// The frame that is assembled.
    pub fn frame(&self) -> &'f PlaneFrame {
        self.frame
    }

    /// The kinematics it is assembled with.
    pub fn kinematics(&self) -> Kinematics {
        self.kinematics
    }

    /// The numbering of the unknowns.
    pub fn equations(&self) -> &Equations {
        &self.equations
    }

    /// Tangent stiffness of the last [`evaluate`](Assembly::evaluate), N/mm, N and N mm; full and symmetric.
    pub fn stiffness(&self) -> &CsMat<f64> {
        &self.stiffness
    }

    /// Internal minus external forces of the last [`evaluate`](Assembly::evaluate), by equation.
    pub fn residual(&self) -> &[f64] {
        &self.gradient
    }

    /// Elastic energy of the last [`evaluate`](Assembly::evaluate), N mm.
    pub fn elastic_energy(&self) -> f64 {
        self.energy
    }

    fn linear(&self) -> bool {
        self.kinematics == Kinematics::Linear
    }

    /// Evaluates elastic energy, residual and tangent at a motion, under `factor` times the loads.
    pub fn evaluate(&mut self, motion: &FrameMotion, loads: &[FrameLoad], factor: f64) {
        self.gradient.fill(0.0);
        self.stiffness.data_mut().fill(0.0);
        self.energy = 0.0;
        let frame = self.frame;
        for (index, member) in frame.members().iter().enumerate() {
            let ends = member.ends.map(Attachment::from);
            let motions = ends.map(|end| frame.motion_at(motion, &end, self.linear()));
            let response = member.beam.response(self.kinematics, &motions);
            self.energy += response.energy;
            let (gradient, tangent) = frame.pull_back(motion, &ends, &response, self.linear());
            self.scatter_member(index, &gradient, &tangent);
        }
        for load in loads {
            self.add_load(motion, load, factor);
        }
    }

    /// Subtracts a load from residual and tangent.
    fn add_load(&mut self, motion: &FrameMotion, load: &FrameLoad, factor: f64) {
        let frame = self.frame;
        match *load {
            FrameLoad::Node { node, force, moment_nmm } => {
                let at = Attachment { node, rotation: frame.rotation_of(node), arm: Vector::zeros() };
                self.add_point_load(motion, at, force * factor, moment_nmm * factor);
            }
            FrameLoad::Arm { end, force } => self.add_point_load(motion, end.into(), force * factor, 0.0),
            FrameLoad::Interior { member: index, xi, force } => {
                let member = frame.members()[index];
                let ends = member.ends.map(Attachment::from);
                let motions = ends.map(|end| frame.motion_at(motion, &end, self.linear()));
                let mut work = member.beam.interior_work(self.kinematics, xi, force * -factor, &motions);
                work.energy = 0.0;
                let (gradient, tangent) = frame.pull_back(motion, &ends, &work, self.linear());
                self.scatter_member(index, &gradient, &tangent);
            }
        }
    }

    fn add_point_load(&mut self, motion: &FrameMotion, at: Attachment, force: Vector, moment_nmm: f64) {
        let mut work = Response { energy: 0.0, gradient: SVector::zeros(), tangent: SMatrix::zeros() };
        work.gradient.fixed_rows_mut::<3>(0).copy_from_slice(&[-force.x, -force.y, -moment_nmm]);
        let ends = [at, at];
        let (gradient, tangent) = self.frame.pull_back(motion, &ends, &work, self.linear());
        let coordinates = self.equations.of_pair(self.frame, &ends);
        // Only the diagonal of the tangent is there: the point moves on circles.
        for (k, equation) in coordinates.iter().enumerate() {
            if let Some(e) = *equation {
                self.gradient[e] += gradient[k];
                if let Some(index) = self.stiffness.nnz_index(e, e) {
                    self.stiffness.data_mut()[index.0] += tangent[(k, k)];
                }
            }
        }
    }

    fn scatter_member(
        &mut self,
        index: usize,
        gradient: &SVector<f64, MEMBER_COORDINATES>,
        tangent: &SMatrix<f64, MEMBER_COORDINATES, MEMBER_COORDINATES>,
    ) {
        let member = &self.frame.members()[index];
        let coordinates = self.equations.of_pair(self.frame, &member.ends.map(Attachment::from));
        let slots = &self.slots[index];
        let values = self.stiffness.data_mut();
        for (row, equation) in coordinates.iter().enumerate() {
            let Some(equation) = *equation else { continue };
            self.gradient[equation] += gradient[row];
            for (column, &slot) in slots[row].iter().enumerate() {
                if slot != ABSENT {
                    values[slot as usize] += tangent[(row, column)];
                }
            }
        }
    }
}
