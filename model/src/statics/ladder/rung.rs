//! The back and front node of one rib: a block of six unknowns.

use super::ldl::Ldl;
use crate::Vector;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

pub(super) type Vector6 = SVector<f64, 6>;
type Matrix6 = SMatrix<f64, 6, 6>;

/// x, y, rotation of the back node, then of the front node; and after [`eliminate`](Rung::eliminate) how they move.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rung {
    stiffness: Matrix6,
    gradient: Vector6,
    /// Gradient at the front node before anything was eliminated: what pulls at a rigid link.
    front_pull: Vector,
    /// Factor of the block, in generalised coordinates where `spread` says how the nodes move with them.
    factor: Ldl<6>,
    spread: Option<Matrix6>,
    /// Motion by itself, and with the six of the rung below (in nodal coordinates, both).
    alone: Vector6,
    with_below: Matrix6,
    /// The same for the rotation of a hinged rigid link.
    link: Option<(f64, SMatrix<f64, 1, 6>)>,
    pub work: f64,
}

impl Default for Rung {
    fn default() -> Rung {
        Rung {
            stiffness: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            front_pull: Vector::zeros(),
            factor: Ldl::of(&Matrix6::identity()),
            spread: None,
            alone: Vector6::zeros(),
            with_below: Matrix6::zeros(),
            link: None,
            work: 0.0,
        }
    }
}

impl Rung {
    /// Adds the end of a line (or a load) at the back (row 0) or front node (row 3).
    pub(super) fn add_node(
        &mut self,
        row: usize,
        stiffness: &Matrix3<f64>,
        gradient: &Vector3<f64>,
        raw: &Vector3<f64>,
    ) {
        let mut block = self.stiffness.fixed_view_mut::<3, 3>(row, row);
        block += stiffness;
        let mut part = self.gradient.fixed_rows_mut::<3>(row);
        part += gradient;
        if row == 3 {
            self.front_pull += Vector::new(raw[0], raw[1]);
        }
    }

    /// Couples back and front node by a rib.
    pub(super) fn couple(&mut self, back_front: &Matrix3<f64>) {
        let mut upper = self.stiffness.fixed_view_mut::<3, 3>(0, 3);
        upper += back_front;
        let mut lower = self.stiffness.fixed_view_mut::<3, 3>(3, 0);
        lower += back_front.transpose();
    }

    /// Takes the eliminated tip into account.
    pub(super) fn subtract_tip(
        &mut self,
        couplings: &[Matrix3<f64>; 2],
        with: &[Matrix3<f64>; 2],
        alone: &Vector3<f64>,
    ) {
        for (i, coupling) in couplings.iter().enumerate() {
            for (j, with) in with.iter().enumerate() {
                let mut block = self.stiffness.fixed_view_mut::<3, 3>(3 * i, 3 * j);
                block -= coupling * with;
            }
            let mut part = self.gradient.fixed_rows_mut::<3>(3 * i);
            part -= coupling * alone;
        }
    }

    /// Takes the eliminated rung above into account; `back` and `front` couple this rung (rows) to that one (columns).
    pub(super) fn subtract(&mut self, above: &Rung, back: &Matrix3<f64>, front: &Matrix3<f64>) {
        for (row, coupling) in [(0, back), (3, front)] {
            let with = above.with_below.fixed_view::<3, 6>(row, 0);
            let mut block = self.stiffness.fixed_view_mut::<3, 6>(row, 0);
            block -= coupling * with;
            let mut part = self.gradient.fixed_rows_mut::<3>(row);
            part -= coupling * above.alone.fixed_rows::<3>(row);
        }
    }

    /// Eliminates the block; `back` and `front` couple the rung below (rows) to this one (columns). `lever` runs from
    /// the back to the front node where an undeformable rib joins them, and `together` says that they also turn
    /// together. Returns whether the block is positive definite.
    pub(super) fn eliminate(
        &mut self,
        lever: Option<Vector>,
        together: bool,
        linear: bool,
        back: &Matrix3<f64>,
        front: &Matrix3<f64>,
    ) -> bool {
        // Rows of this rung, columns of the one below.
        let mut coupling = Matrix6::zeros();
        coupling.fixed_view_mut::<3, 3>(0, 0).copy_from(&back.transpose());
        coupling.fixed_view_mut::<3, 3>(3, 3).copy_from(&front.transpose());
        let Some(lever) = lever else {
            let ldl = Ldl::of(&self.stiffness);
            self.alone = ldl.solve(&self.gradient);
            self.with_below = ldl.solve(&coupling);
            self.work = self.gradient.dot(&self.alone);
            (self.factor, self.spread) = (ldl, None);
            return ldl.positive;
        };
        // Generalised coordinates: back x, y, rotation; rotation of the link; front rotation. The nodal motions are
        // `spread` times these. Coordinates that are not needed stay in place with unit stiffness.
        let mut spread = Matrix6::zeros();
        spread.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        spread[(3, 0)] = 1.0;
        spread[(4, 1)] = 1.0;
        let turn = if together { 2 } else { 3 };
        spread[(3, turn)] = -lever.y;
        spread[(4, turn)] = lever.x;
        spread[(5, if together { 2 } else { 4 })] = 1.0;
        let mut stiffness = spread.transpose() * self.stiffness * spread;
        if !linear {
            stiffness[(turn, turn)] -= self.front_pull.dot(&lever);
        }
        for unused in if together { 3..6 } else { 5..6 } {
            stiffness[(unused, unused)] = 1.0;
        }
        let gradient = spread.transpose() * self.gradient;
        let ldl = Ldl::of(&stiffness);
        let alone = ldl.solve(&gradient);
        let with_below = ldl.solve(&(spread.transpose() * coupling));
        self.work = gradient.dot(&alone);
        self.alone = spread * alone;
        self.with_below = spread * with_below;
        (self.factor, self.spread) = (ldl, Some(spread));
        self.link = (!together).then(|| (alone[3], with_below.fixed_rows::<1>(3).into_owned()));
        ldl.positive
    }

    /// Correction of the six nodal coordinates, and of the rotation of a hinged rigid link, from that of the rung below.
    pub(super) fn correction(&self, below: &Vector6) -> (Vector6, Option<f64>) {
        let link = self.link.map(|(alone, with)| -(alone + (with * below)[0]));
        (-(self.alone + self.with_below * below), link)
    }

    /// How the six nodal coordinates answer to forces on them, those of the rung below held.
    pub(super) fn answer(&self, forces: &Vector6) -> Vector6 {
        match &self.spread {
            None => self.factor.solve(forces),
            Some(spread) => spread * self.factor.solve(&(spread.transpose() * forces)),
        }
    }

    /// What forces on this rung put on the one below.
    pub(super) fn passed_down(&self, forces: &Vector6) -> Vector6 {
        -(self.with_below.transpose() * forces)
    }

    /// How this rung moves with the one below.
    pub(super) fn carried(&self, below: &Vector6) -> Vector6 {
        -(self.with_below * below)
    }
}
