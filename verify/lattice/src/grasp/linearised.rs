//! The linear equations of one step of Newton's method: balance of the fingers' bodies and of the object, and two laws a contact.

use super::bordered::Bordered;
use super::contact::{Tangent, Touching};
use super::near::{ContactPair, Grip};
use super::scene::{Scene, State, Surroundings};
use crate::energy::SpringEnergy;

/// Residual and its derivatives. Unknowns are the motions of the fingers' bodies, then the object's pose and the two forces of each closed pair.
struct Equations<'s> {
    residual: Vec<f64>,
    derivatives: Bordered<'s>,
}

/// One law of a contact: value and derivatives by the six unknowns of its bodies, and by its normal and friction force.
struct Law {
    value: f64,
    by_motion: [f64; 6],
    by_forces: [f64; 2],
}

/// Number of the i-th of a contact's six unknowns: of a body, none where that is clamped or the support, then of the object.
fn unknown(of_body: Option<usize>, object: usize, i: usize) -> Option<usize> {
    if i < 3 { of_body.map(|first| first + i) } else { Some(object + i - 3) }
}

impl Scene<'_> {
    /// A step of Newton's method. Where friction is lagging, its bound is that of the normal force before the step.
    pub(super) fn correction(
        &self,
        state: &State,
        before: &State,
        around: &Surroundings,
        closed: &[(ContactPair, Grip)],
        is_lagging: bool,
    ) -> Option<Vec<f64>> {
        let object = self.first(self.fingers.len());
        let count = object + 3 + 2 * closed.len();
        let orders = self.fingers.iter().map(|standing| &standing.order);
        let derivatives = Bordered::new(orders, count - object);
        let mut equations = Equations { residual: vec![0.0; count], derivatives };
        for finger in 0..self.fingers.len() {
            self.balance_finger(&mut equations, finger, state, before, around);
        }
        self.balance_object(&mut equations, object, state, before, around);
        for (k, (pair, grip)) in closed.iter().enumerate() {
            let (tangent, forces) = (self.tangent(pair, state, before), state.forces[&pair.key]);
            self.add_contact(&mut equations, object, object + 3 + 2 * k, pair, &tangent, forces);
            let laws = self.laws(*grip, &pair.touching, &tangent, forces, is_lagging);
            self.add_laws(&mut equations, object, object + 3 + 2 * k, pair, &laws);
        }
        let mut correction: Vec<f64> = equations.residual.iter().map(|r| -r).collect();
        equations.derivatives.solve(&mut correction)?;
        Some(correction)
    }

    fn balance_finger(
        &self,
        equations: &mut Equations,
        finger: usize,
        state: &State,
        before: &State,
        around: &Surroundings,
    ) {
        let (standing, first) = (&self.fingers[finger], self.first(finger));
        let (order, blocks) = equations.derivatives.blocks(finger);
        let springs = standing.energy.springs(&state.motions[finger]);
        for (SpringEnergy { bodies, gradient, curvature, .. }, link) in springs.zip(order.links()) {
            let part = |i: usize, j: usize| curvature.fixed_view::<3, 3>(3 * i, 3 * j);
            for (i, body) in bodies.into_iter().enumerate() {
                let Some(own) = standing.energy.first_unknown(body) else { continue };
                (0..3).for_each(|axis| equations.residual[first + own + axis] += gradient[3 * i + axis]);
                blocks[own / 3] += part(i, i);
            }
            if let Some([right, below]) = *link {
                blocks[right] += part(0, 1);
                blocks[below] += part(1, 0);
            }
        }
        for (body, (now, then)) in state.motions[finger].iter().zip(&before.motions[finger]).enumerate() {
            let Some(i) = standing.energy.first_unknown(body).map(|i| first + i) else { continue };
            let resistance = (now.displacement - then.displacement) * around.finger_drag;
            for axis in 0..2 {
                equations.residual[i + axis] += resistance[axis];
                equations.derivatives.add(i + axis, i + axis, around.finger_drag);
            }
        }
    }

    fn balance_object(
        &self,
        equations: &mut Equations,
        object: usize,
        state: &State,
        before: &State,
        around: &Surroundings,
    ) {
        let arm = nalgebra::Rotation2::new(state.object[2]) * self.centre;
        let drags = self.drags(around);
        let loads = [around.weight.x, around.weight.y, arm.perp(&around.weight)];
        let from = around.carried_from(before.object);
        for i in 0..3 {
            equations.residual[object + i] += drags[i] * (state.object[i] - from[i]) - loads[i];
            equations.derivatives.add(object + i, object + i, drags[i]);
        }
        equations.derivatives.add(object + 2, object + 2, arm.dot(&around.weight));
    }

    /// The first unknown of the finger's body in a pair; none where it is clamped, or the support.
    fn first_of_body(&self, pair: &ContactPair) -> Option<usize> {
        let body = pair.part?.body;
        Some(self.first(pair.key.0) + self.fingers[pair.key.0].energy.first_unknown(body)?)
    }

    /// What the forces of a pair do to the balance of its bodies.
    fn add_contact(
        &self,
        equations: &mut Equations,
        object: usize,
        first_row: usize,
        pair: &ContactPair,
        Tangent { pull, pull_by, .. }: &Tangent,
        forces: [f64; 2],
    ) {
        let of_body = self.first_of_body(pair);
        for i in 0..6 {
            let Some(row) = unknown(of_body, object, i) else { continue };
            for axis in 0..2 {
                equations.residual[row] -= forces[axis] * pull[axis][i];
                equations.derivatives.add(row, first_row + axis, -pull[axis][i]);
            }
            for (j, by) in pull_by.iter().enumerate() {
                let Some(column) = unknown(of_body, object, j) else { continue };
                equations.derivatives.add(row, column, -forces[0] * by[0][i] - forces[1] * by[1][i]);
            }
        }
    }

    /// The laws of a pair by its status: of its normal force, and of its friction.
    fn laws(&self, grip: Grip, touching: &Touching, tangent: &Tangent, forces: [f64; 2], is_lagging: bool) -> [Law; 2] {
        let given = self.yield_mm(1.0);
        let [normal_n, friction_n] = forces;
        let no_motion = [0.0; 6];
        let closed =
            Law { value: touching.gap_mm + given * normal_n, by_motion: tangent.pull[0], by_forces: [given, 0.0] };
        match grip {
            Grip::Sticks => {
                let value = touching.slip_mm + given * friction_n;
                [closed, Law { value, by_motion: tangent.slip_by, by_forces: [0.0, given] }]
            }
            Grip::Slips { forwards } => {
                let bound = if forwards { -self.friction } else { self.friction };
                let by_normal = if is_lagging { 0.0 } else { -bound };
                let value = friction_n - bound * normal_n;
                [closed, Law { value, by_motion: no_motion, by_forces: [by_normal, 1.0] }]
            }
        }
    }

    fn add_laws(
        &self,
        equations: &mut Equations,
        object: usize,
        first_row: usize,
        pair: &ContactPair,
        laws: &[Law; 2],
    ) {
        let of_body = self.first_of_body(pair);
        for (axis, law) in laws.iter().enumerate() {
            let row = first_row + axis;
            equations.residual[row] = law.value;
            for (other, by) in law.by_forces.into_iter().enumerate() {
                equations.derivatives.add(row, first_row + other, by);
            }
            for (i, by) in law.by_motion.into_iter().enumerate() {
                if let Some(column) = unknown(of_body, object, i) {
                    equations.derivatives.add(row, column, by);
                }
            }
        }
    }
}
