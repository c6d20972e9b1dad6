//! Linear equations of one Newton step: equilibrium of the fingers' bodies and of the object, and two contact laws per contact.
//!
//! The two laws of a contact involve only the contact's two forces, the motion of the finger's body in contact, and the motion of the object. The two
//! laws of each contact are solved for the two forces of that contact. Once the contact forces are eliminated, only the motions are unknown, whatever
//! the number of contacts.

use super::bordered::Bordered;
use super::contact::{Tangent, Touching};
use super::near::{ContactPair, Grip};
use super::scene::{Scene, State, Surroundings};
use crate::energy::SpringEnergy;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

/// Residual and its derivatives. The unknowns are the motions of the fingers' bodies, then the object's pose.
struct Equations<'s> {
    residual: Vec<f64>,
    derivatives: Bordered<'s>,
}

/// One law of a contact: its value, and its derivatives with respect to the six motions and to the normal and friction force.
struct Law {
    value: f64,
    by_motion: [f64; 6],
    by_forces: [f64; 2],
}

/// Change of a contact's two forces that follows from the contact's two laws: the negative of `value` + `by_motion` times the changes of the six
/// motions.
struct ForceChange {
    value: Vector2<f64>,
    by_motion: SMatrix<f64, 2, 6>,
}

impl ForceChange {
    /// Solves the two laws of a contact for the change of its forces; `None` if the laws do not determine the forces.
    fn of(laws: &[Law; 2]) -> Option<ForceChange> {
        let inverse = Matrix2::from_fn(|law, force| laws[law].by_forces[force]).try_inverse()?;
        let by_motion = SMatrix::<f64, 2, 6>::from_fn(|law, unknown| laws[law].by_motion[unknown]);
        Some(ForceChange {
            value: inverse * Vector2::new(laws[0].value, laws[1].value),
            by_motion: inverse * by_motion,
        })
    }
}

/// Indices of a contact's six unknowns: three motions of the body (`None` if the body is clamped or is the support), then three of the object.
fn unknowns(of_body: Option<usize>, object: usize) -> [Option<usize>; 6] {
    [0, 1, 2, 3, 4, 5].map(|i| if i < 3 { of_body.map(|first| first + i) } else { Some(object + i - 3) })
}

impl Scene<'_> {
    /// Correction of one Newton step: changes of the bodies' motions, then of the object's pose, then of the forces of the closed pairs. With
    /// `is_lagging`, the friction bound uses the normal force of the previous step. `None` if the equations are singular.
    pub(super) fn correction(
        &self,
        state: &State,
        before: &State,
        around: &Surroundings,
        closed: &[(ContactPair, Grip)],
        is_lagging: bool,
    ) -> Option<Vec<f64>> {
        let object = self.first(self.fingers.len());
        let orders = self.fingers.iter().map(|standing| &standing.order);
        let mut equations = Equations { residual: vec![0.0; object + 3], derivatives: Bordered::new(orders, 3) };
        for finger in 0..self.fingers.len() {
            self.balance_finger(&mut equations, finger, state, before, around);
        }
        self.balance_object(&mut equations, object, state, before, around);
        let mut changes = Vec::with_capacity(closed.len());
        for (pair, grip) in closed {
            let (tangent, forces) = (self.tangent(pair, state, before), state.forces[&pair.key]);
            let change = ForceChange::of(&self.laws(*grip, &pair.touching, &tangent, forces, is_lagging))?;
            let of_contact = unknowns(self.first_of_body(pair), object);
            self.add_contact(&mut equations, of_contact, &tangent, forces, &change);
            changes.push((of_contact, change));
        }
        let mut correction: Vec<f64> = equations.residual.iter().map(|r| -r).collect();
        equations.derivatives.solve(&mut correction)?;
        for (of_contact, change) in changes {
            let motions = SVector::<f64, 6>::from(of_contact.map(|unknown| unknown.map_or(0.0, |i| correction[i])));
            correction.extend((change.value + change.by_motion * motions).iter().map(|change| -change));
        }
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
            // If a hand holds the object in a coordinate, an equation that keeps this coordinate constant replaces the equation of balance.
            let (drag, load) = if self.held[i] { (1.0, 0.0) } else { (drags[i], loads[i]) };
            equations.residual[object + i] += drag * (state.object[i] - from[i]) - load;
            equations.derivatives.add(object + i, object + i, drag);
        }
        if !self.held[2] {
            equations.derivatives.add(object + 2, object + 2, arm.dot(&around.weight));
        }
    }

    /// Index of the first unknown of the pair's body; `None` if the body is clamped or is the support.
    fn first_of_body(&self, pair: &ContactPair) -> Option<usize> {
        let body = pair.part?.body;
        Some(self.first(pair.key.0) + self.fingers[pair.key.0].energy.first_unknown(body)?)
    }

    /// Adds a pair's forces, and the change of these forces with the motions, to the equilibrium equations of the pair's body and of the object.
    fn add_contact(
        &self,
        equations: &mut Equations,
        of_contact: [Option<usize>; 6],
        Tangent { pull, pull_by, .. }: &Tangent,
        forces: [f64; 2],
        change: &ForceChange,
    ) {
        let is_held = |i: usize| i >= 3 && self.held[i - 3];
        for i in (0..6).filter(|i| !is_held(*i)) {
            let Some(row) = of_contact[i] else { continue };
            for axis in 0..2 {
                equations.residual[row] -= (forces[axis] - change.value[axis]) * pull[axis][i];
            }
            for (j, by) in pull_by.iter().enumerate() {
                let Some(column) = of_contact[j] else { continue };
                let of_axis = |axis: usize| pull[axis][i] * change.by_motion[(axis, j)] - forces[axis] * by[axis][i];
                equations.derivatives.add(row, column, of_axis(0) + of_axis(1));
            }
        }
    }

    /// The two laws of a closed pair: one for the normal force, one for friction.
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
}
