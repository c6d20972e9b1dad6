//! Linear equations of one Newton step: motions of the touched nodes, and balance of the object.
//!
//! The two laws of a contact involve only the contact's two forces, the motion of the nodes that carry the contact, and the motion of the object. The
//! two laws of each contact are solved for its two forces. A finger enters through the compliance C between its touched nodes, the ports, and
//! through the ports' motion q0 by Newton's correction under the present forces. With the change dG of the forces on the ports, the ports move by
//! q0 + C dG. These equations and the balance of the object form a dense system, whose size depends on the number of contacts and not on the mesh.

use crate::newton::Correction;
use crate::pair::{Tangent, Touching, UNKNOWNS};
use crate::scene::{Scene, State, Surroundings};
use crate::status::{ContactPair, Grip};
use finray_model::Vector;
use finray_model::frame::{FrameLoad, NodeIndex};
use finray_model::statics::EquilibriumEquations;
use nalgebra::{DMatrix, DVector, Matrix2, SMatrix, SVector, Vector2};

/// One law of a contact: its value, and its derivatives with respect to the motions and to the normal and friction force.
struct Law {
    value: f64,
    by_motion: [f64; UNKNOWNS],
    by_forces: [f64; 2],
}

/// Change of a contact's two forces that follows from the contact's two laws: the negative of `value` + `by_motion` times the changes of the motions.
struct ForceChange {
    value: Vector2<f64>,
    by_motion: SMatrix<f64, 2, UNKNOWNS>,
}

impl ForceChange {
    /// Solves the two laws of a contact for the change of its forces; `None` if the laws do not determine the forces.
    fn of(laws: &[Law; 2]) -> Option<ForceChange> {
        let inverse = Matrix2::from_fn(|law, force| laws[law].by_forces[force]).try_inverse()?;
        let by_motion = SMatrix::<f64, 2, UNKNOWNS>::from_fn(|law, unknown| laws[law].by_motion[unknown]);
        Some(ForceChange {
            value: inverse * Vector2::new(laws[0].value, laws[1].value),
            by_motion: inverse * by_motion,
        })
    }
}

/// A closed pair in the equations of a Newton step.
struct ClosedContact {
    /// Row of each of the contact's unknowns in the dense system; `None` for an unknown that does not move.
    rows: [Option<usize>; UNKNOWNS],
    change: ForceChange,
    /// Generalised forces at present, and their change with the contact's unknowns, without a change of the contact's forces.
    forces: SVector<f64, UNKNOWNS>,
    /// Change of the generalised forces: `constant` + `by_motion` times the changes of the unknowns.
    constant: SVector<f64, UNKNOWNS>,
    by_motion: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
}

impl ClosedContact {
    fn new(
        rows: [Option<usize>; UNKNOWNS],
        Tangent { pull, pull_by, .. }: &Tangent,
        forces: [f64; 2],
        change: ForceChange,
    ) -> ClosedContact {
        let pulls = SMatrix::<f64, UNKNOWNS, 2>::from_fn(|i, axis| pull[axis][i]);
        let turning = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::from_fn(|i, unknown| {
            forces[0] * pull_by[unknown][0][i] + forces[1] * pull_by[unknown][1][i]
        });
        ClosedContact {
            rows,
            forces: pulls * Vector2::from(forces),
            constant: -(pulls * change.value),
            by_motion: turning - pulls * change.by_motion,
            change,
        }
    }
}

impl Scene<'_> {
    /// Correction of one Newton step. With `is_lagging`, the friction bound uses the normal force of the previous step. `None` if the equations are
    /// singular.
    pub(crate) fn correction(
        &mut self,
        state: &State,
        before: &State,
        around: &Surroundings,
        closed: &[(ContactPair, Grip)],
        is_lagging: bool,
    ) -> Option<Correction> {
        let ports: Vec<Vec<NodeIndex>> = (0..self.fingers.len()).map(|finger| ports(finger, closed)).collect();
        let first: Vec<usize> =
            ports.iter().scan(0, |next, ports| Some(std::mem::replace(next, *next + 3 * ports.len()))).collect();
        let object = 3 * ports.iter().map(Vec::len).sum::<usize>();
        let mut contacts = Vec::with_capacity(closed.len());
        for (pair, grip) in closed {
            let (tangent, forces) = (pair.tangent(state, before), state.forces[&pair.key]);
            let change = ForceChange::of(&self.laws(*grip, &pair.touching, &tangent, forces, is_lagging))?;
            let mounts = pair.pair.carrier.mounts();
            let row = |unknown: usize| {
                if unknown >= 6 {
                    return Some(object + unknown - 6);
                }
                let mount = mounts[unknown / 3].filter(|mount| !mount.clamped)?;
                let port = ports.get(pair.key.0)?.iter().position(|node| *node == mount.node)?;
                Some(first[pair.key.0] + 3 * port + unknown % 3)
            };
            contacts.push(ClosedContact::new(std::array::from_fn(row), &tangent, forces, change));
        }

        // Change of the forces on ports and object with the motions of ports and object.
        let count = object + 3;
        let (mut forces, mut constant) = (DVector::zeros(count), DVector::zeros(count));
        let mut by_motion = DMatrix::<f64>::zeros(count, count);
        for contact in &contacts {
            for (i, row) in contact.rows.iter().enumerate() {
                let Some(row) = *row else { continue };
                forces[row] += contact.forces[i];
                constant[row] += contact.constant[i];
                for (j, column) in contact.rows.iter().enumerate() {
                    if let Some(column) = *column {
                        by_motion[(row, column)] += contact.by_motion[(i, j)];
                    }
                }
            }
        }
        let mut matrix = DMatrix::<f64>::identity(count, count);
        let mut right = DVector::zeros(count);
        let mut loads = Vec::with_capacity(ports.len());
        for (finger, ports) in ports.iter().enumerate() {
            let (at, length) = (first[finger], 3 * ports.len());
            loads.push(nodal_loads(ports, forces.rows(at, length).as_slice()));
            let resistance = (around.finger_drag, &before.motions[finger]);
            let ladder = &mut self.fingers[finger].ladder;
            ladder.linearise_with_springs(&state.motions[finger], &loads[finger], resistance);
            if ports.is_empty() {
                continue;
            }
            let compliance = ladder.compliance_at(ports);
            let change = &compliance * by_motion.rows(at, length);
            matrix.rows_mut(at, length).zip_apply(&change, |entry, change| *entry -= change);
            let moved = DVector::from_vec(ladder.correction_at(ports)) + compliance * constant.rows(at, length);
            right.rows_mut(at, length).copy_from(&moved);
        }
        self.balance_object((&mut matrix, &mut right), object, (state, before, around));
        for i in (0..3).filter(|i| !self.held[*i]) {
            for column in 0..count {
                matrix[(object + i, column)] -= by_motion[(object + i, column)];
            }
            right[object + i] += forces[object + i] + constant[object + i];
        }
        let motions = matrix.lu().solve(&right)?;
        if motions.iter().any(|x| !x.is_finite()) {
            return None;
        }

        let changed = forces + constant + by_motion * &motions;
        let mut corrected = Vec::with_capacity(ports.len());
        for (finger, ports) in ports.iter().enumerate() {
            let after = nodal_loads(ports, changed.rows(first[finger], 3 * ports.len()).as_slice());
            let (ladder, mut motion) = (&mut self.fingers[finger].ladder, state.motions[finger].clone());
            if !ports.is_empty() {
                let springs = (around.finger_drag, &before.motions[finger]);
                ladder.change_loads(&state.motions[finger], &loads[finger], &after, springs);
            }
            ladder.correct(&mut motion).is_finite().then_some(())?;
            corrected.push(motion);
        }
        let of_contact = |contact: &ClosedContact| {
            let moved = SVector::<f64, UNKNOWNS>::from(contact.rows.map(|row| row.map_or(0.0, |row| motions[row])));
            (-(contact.change.value + contact.change.by_motion * moved)).into()
        };
        Some(Correction {
            motions: corrected,
            object: [0, 1, 2].map(|i| motions[object + i]),
            forces: contacts.iter().map(of_contact).collect(),
        })
    }

    /// Writes the balance of the object under its weight and the numerical resistance, without contact forces.
    fn balance_object(
        &self,
        (matrix, right): (&mut DMatrix<f64>, &mut DVector<f64>),
        object: usize,
        (state, before, around): (&State, &State, &Surroundings),
    ) {
        let arm = nalgebra::Rotation2::new(state.object[2]) * self.centre;
        let drags = self.drags(around);
        let loads = [around.weight.x, around.weight.y, arm.perp(&around.weight)];
        let from = around.carried_from(before.object);
        for i in 0..3 {
            // If a hand holds the object in a coordinate, an equation that keeps this coordinate constant replaces the equation of balance.
            let (drag, load) = if self.held[i] { (1.0, 0.0) } else { (drags[i], loads[i]) };
            matrix[(object + i, object + i)] = drag;
            right[object + i] = load - drag * (state.object[i] - from[i]);
        }
        if !self.held[2] {
            matrix[(object + 2, object + 2)] += arm.dot(&around.weight);
        }
    }

    /// The two laws of a closed pair: one for the normal force, one for friction.
    fn laws(&self, grip: Grip, touching: &Touching, tangent: &Tangent, forces: [f64; 2], is_lagging: bool) -> [Law; 2] {
        let given = self.yield_mm(1.0);
        let [normal_n, friction_n] = forces;
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
                [closed, Law { value, by_motion: [0.0; UNKNOWNS], by_forces: [by_normal, 1.0] }]
            }
        }
    }
}

/// The free nodes that carry the closed pairs of a finger.
fn ports(finger: usize, closed: &[(ContactPair, Grip)]) -> Vec<NodeIndex> {
    let of_finger = closed.iter().filter(|(pair, _)| pair.key.0 == finger);
    let mounts = of_finger.flat_map(|(pair, _)| pair.pair.carrier.mounts()).flatten();
    let mut ports: Vec<NodeIndex> = mounts.filter(|mount| !mount.clamped).map(|mount| mount.node).collect();
    ports.sort_unstable();
    ports.dedup();
    ports
}

/// Forces on ports as loads on the mesh.
fn nodal_loads(ports: &[NodeIndex], forces: &[f64]) -> Vec<FrameLoad> {
    let load = |(node, force): (&NodeIndex, &[f64])| FrameLoad::Node {
        node: *node,
        force: Vector::new(force[0], force[1]),
        moment_nmm: force[2],
    };
    ports.iter().zip(forces.chunks_exact(3)).map(load).collect()
}
