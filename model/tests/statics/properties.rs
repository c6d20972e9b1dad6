//! Properties of every finger in equilibrium.

use finray_model::finger::{Plate, PlatePosition};
use finray_model::frame::{FrameLoad, FrameMotion};
use finray_model::statics::{Statics, elastic_energy, reaction, solve};
use finray_model::{Finger, Kinematics, Load, Mesh, Vector};
use finray_tests::{
    KINEMATICS, built_finger, built_finger_with_zones, cases, contact_node, force_for_deflection, largest, mirrored,
    motions_apart, shapes_apart,
};
use proptest::prelude::*;

/// Rounding error of a linear solution on a coarse mesh. Stretching is up to 1e5 times stiffer than bending.
const ROUNDING: f64 = 1e-9;
/// Rounding error of a solution on a fine mesh, after a correction by its residual.
const FINE_ROUNDING: f64 = 1e-8;

/// Largest difference between two computations of one equilibrium, due to the tolerance of Newton's method, as a share of the largest displacement.
const SAME_EQUILIBRIUM: f64 = 1e-7;

fn displacements(finger: &Finger, loads: &[Load]) -> Vec<Vector> {
    let shape = solve(&Mesh::key_nodes(finger), loads, Kinematics::Linear).expect("linear solution");
    shape.motions().iter().map(|m| m.displacement).collect()
}

proptest! {
    #![proptest_config(cases(128))]

    /// Maxwell and Betti: a unit force along a at A moves B along b as far as a unit force along b at B moves A along a.
    #[test]
    fn reciprocity(finger in built_finger_with_zones(), at in [0.0..1.0, 0.0..1.0], angles in [-90.0..90.0, -90.0..90.0]) {
        let nodes = at.map(|fraction| contact_node(&finger, fraction));
        let directions = angles.map(|angle| finger.direction(angle));
        let moved = [0, 1].map(|i| displacements(&finger, &[Load::at_node(nodes[i], directions[i])]));
        let there = moved[0][nodes[1].0 - 1].dot(&directions[1]);
        let back = moved[1][nodes[0].0 - 1].dot(&directions[0]);
        let scale = moved.iter().flatten().map(|u| u.norm()).fold(0.0, f64::max);
        prop_assert!((there - back).abs() <= ROUNDING * scale, "{there} against {back}");
    }

    /// Linear displacements under two loads are the sum of the displacements under each load, and are proportional to the load.
    #[test]
    fn superposition(finger in built_finger_with_zones(), at in [0.0..1.0, 0.0..1.0], factors in [-3.0..3.0, -3.0..3.0]) {
        let loads = [0, 1].map(|i| Load::at_node(contact_node(&finger, at[i]), finger.direction(40.0 * i as f64)));
        let scaled = [0, 1].map(|i| match loads[i] {
            Load::Node { node, force, .. } => Load::at_node(node, force * factors[i]),
            front => front,
        });
        let together = displacements(&finger, &scaled);
        let alone = loads.map(|load| displacements(&finger, &[load]));
        let scale = alone.iter().flatten().map(|u| u.norm()).fold(0.0, f64::max);
        for (node, sum) in together.iter().enumerate() {
            let expected: Vector = alone[0][node] * factors[0] + alone[1][node] * factors[1];
            prop_assert!((sum - expected).norm() <= 10.0 * ROUNDING * scale);
        }
    }

    /// The stiffness at rest is symmetric and positive definite: x K x > 0 for any x, and K has a Cholesky factor.
    #[test]
    fn stiffness_is_symmetric_positive_definite(finger in built_finger_with_zones(), seed in prop::collection::vec(-1.0..1.0, 64)) {
        let mesh = Mesh::with_elements_per_member(&finger, 2);
        let mut statics = Statics::sparse(mesh.frame(), Kinematics::Linear);
        prop_assert!(statics.equilibrium(&[]).is_ok());
        let stiffness = statics.equations().assembly().stiffness();
        let scale = largest(stiffness.data());
        for (value, (row, column)) in stiffness {
            let mirrored = stiffness.get(column, row).copied().unwrap_or(0.0);
            prop_assert!((value - mirrored).abs() <= 1e-14 * scale);
        }
        let x: Vec<f64> = (0..stiffness.rows()).map(|i| seed[i % seed.len()] + 0.01 * (i as f64).sin()).collect();
        let work: f64 = stiffness.iter().map(|(value, (row, column))| x[row] * value * x[column]).sum();
        prop_assert!(work > 0.0);
    }

    /// Forces and moments of loads and supports balance in the deformed position, for every kinematics. Each load is either a force with a moment at
    /// a node, or a force between nodes or on an arm.
    #[test]
    fn loads_and_reactions_balance(
        finger in built_finger_with_zones(),
        at in [0.0..1.0, 0.03..1.0],
        angle in -90.0..90.0,
        share in 0.001..0.03,
    ) {
        let mesh = Mesh::with_elements_per_member(&finger, 2);
        let node = contact_node(&finger, at[0]);
        let force = force_for_deflection(&finger, node, angle, share);
        let length = finger.description().front_length_mm;
        let at_node = Load::Node { node, force, moment_nmm: 0.01 * length * force.norm() };
        for load in [at_node, Load::at_position(at[1] * length, force)] {
            let load = mesh.frame_load(&load).expect("on the finger");
            for kinematics in KINEMATICS {
                let Ok(equilibrium) = Statics::sparse(mesh.frame(), kinematics).equilibrium(&[load]) else {
                    return Err(TestCaseError::reject("no equilibrium"));
                };
                let motion = &equilibrium.motion;
                // The linear kinematics assume small displacements, so forces balance in the undeformed position.
                let position = |index: usize| match kinematics {
                    Kinematics::Linear => mesh.frame().position(index),
                    _ => mesh.frame().position(index) + motion.displacements[index],
                };
                let reactions = finger.clamped_nodes().map(|clamp| {
                    reaction(mesh.frame(), motion, kinematics, &[load], mesh.frame_node(clamp))
                });
                let sum: Vector = force + reactions[0].force + reactions[1].force;
                let tolerance = 1e-7 * force.norm();
                prop_assert!(sum.norm() <= tolerance, "{kinematics:?}: forces {sum}");
                if let FrameLoad::Node { node, moment_nmm, .. } = load {
                    let moment: f64 = position(node).perp(&force)
                        + moment_nmm
                        + reactions.iter().map(|r| position(r.node).perp(&r.force) + r.moment_nmm).sum::<f64>();
                    prop_assert!(moment.abs() <= tolerance * length, "{kinematics:?}: moment {moment}");
                }
            }
        }
    }

    /// Clapeyron: the elastic energy of the linear finger is half the work of its load.
    #[test]
    fn linear_energy_is_half_the_work(finger in built_finger_with_zones(), at in 0.0..1.0, angle in -90.0..90.0) {
        let mesh = Mesh::key_nodes(&finger);
        let node = contact_node(&finger, at);
        let force = finger.direction(angle);
        let load = mesh.frame_load(&Load::at_node(node, force)).expect("a contact node");
        let equilibrium = Statics::sparse(mesh.frame(), Kinematics::Linear).equilibrium(&[load]).expect("linear solution");
        let work = force.dot(&equilibrium.motion.displacements[mesh.frame_node(node)]);
        let energy = elastic_energy(mesh.frame(), &equilibrium.motion, Kinematics::Linear);
        prop_assert!((energy - 0.5 * work).abs() <= 1e-8 * work);
    }

    /// The elastic energy of the co-rotational finger equals the work of its load along the path, by Simpson's rule over the force. The error of
    /// Simpson's rule is estimated from half as many steps, because the integrand is not smooth near a snap.
    #[test]
    fn corotational_energy_is_the_work_of_the_load(finger in built_finger_with_zones(), at in 0.0..1.0, angle in -60.0..60.0) {
        const STEPS: usize = 64;
        let mesh = Mesh::key_nodes(&finger);
        let node = contact_node(&finger, at);
        let force = force_for_deflection(&finger, node, angle, 0.03);
        let load = mesh.frame_load(&Load::at_node(node, force)).expect("a contact node");
        let multiples: Vec<f64> = (1..=STEPS).map(|i| i as f64 / STEPS as f64).collect();
        let (path, _) = Statics::sparse(mesh.frame(), Kinematics::Corotational).path(&[load], &multiples);
        prop_assume!(path.len() == STEPS);
        let moved: Vec<f64> = std::iter::once(0.0)
            .chain(path.iter().map(|e| force.dot(&e.motion.displacements[mesh.frame_node(node)])))
            .collect();
        // Work = F u at the end minus the integral of u over the force (complementary energy).
        let work = |every: usize| {
            let u: Vec<f64> = moved.iter().step_by(every).copied().collect();
            let simpson: f64 = u.windows(3).step_by(2).map(|w| (w[0] + 4.0 * w[1] + w[2]) / 3.0).sum();
            moved[STEPS] - simpson * every as f64 / STEPS as f64
        };
        let (work, rough) = (work(1), work(2));
        let energy = elastic_energy(mesh.frame(), &path[STEPS - 1].motion, Kinematics::Corotational);
        prop_assert!((energy - work).abs() <= 1e-6 * work + 5.0 * (work - rough).abs(), "{energy} against {work} ({rough})");
    }

    /// The full load at once leads to the same equilibrium as 100 small steps. If the small steps meet a limit load, the full load is refused as
    /// well.
    #[test]
    fn no_limit_load_is_jumped_over(finger in built_finger_with_zones(), at in 0.0..1.0, angle in -80.0..80.0, share in 0.005..0.03) {
        let mesh = Mesh::key_nodes(&finger);
        let node = contact_node(&finger, at);
        let force = force_for_deflection(&finger, node, angle, share);
        let load = mesh.frame_load(&Load::at_node(node, force)).expect("a contact node");
        let mut statics = Statics::sparse(mesh.frame(), Kinematics::Corotational);
        let multiples: Vec<f64> = (1..=100).map(|i| f64::from(i) / 100.0).collect();
        let (path, limit) = statics.path(&[load], &multiples);
        match (statics.equilibrium(&[load]), limit) {
            (Ok(at_once), None) => {
                let slowly = &path[path.len() - 1].motion;
                let apart = motions_apart(&at_once.motion, slowly);
                prop_assert!(apart <= SAME_EQUILIBRIUM, "{apart}");
            }
            (Ok(_), Some(limit)) => prop_assert!(false, "jumped over: {limit}"),
            (Err(_), _) => {}
        }
    }

    /// Linear frames are exact at their nodes, so refinement changes only rounding errors.
    #[test]
    fn refinement_changes_nothing_linear(finger in built_finger(), at in 0.0..1.0, angle in -90.0..90.0) {
        let node = contact_node(&finger, at);
        let load = Load::at_node(node, finger.direction(angle));
        let coarse = solve(&Mesh::key_nodes(&finger), &[load], Kinematics::Linear).expect("linear solution");
        let fine = Mesh::with_nodes(&finger, 684).expect("a fine mesh");
        let fine = solve(&fine, &[load], Kinematics::Linear).expect("linear solution");
        let apart = shapes_apart(&fine, &coarse);
        prop_assert!(apart <= FINE_ROUNDING, "{apart}");
    }

    /// A load between nodes has the same effect as this load on a node that refinement adds at its position. Positions next to the clamp are
    /// excluded, because displacements there are rounding errors.
    #[test]
    fn consistent_loads_are_exact_at_the_nodes(finger in built_finger(), at in 0.08..1.0, angle in -90.0..90.0) {
        let s_mm = at * finger.description().front_length_mm;
        let load = Load::at_position(s_mm, finger.direction(angle));
        let coarse = solve(&Mesh::key_nodes(&finger), &[load], Kinematics::Linear).expect("linear solution");
        for elements in [3, 8] {
            let fine = solve(&Mesh::with_elements_per_member(&finger, elements), &[load], Kinematics::Linear).expect("linear solution");
            let apart = shapes_apart(&fine, &coarse);
            prop_assert!(apart <= FINE_ROUNDING, "{elements} elements: {apart}");
        }
    }

    /// A force on the back plate bends a finger as the mirrored force on the front plate bends the finger's mirror image. The displaced point of the
    /// plate under the force is mirrored, too.
    #[test]
    fn forces_on_the_back_plate_mirror_those_on_the_front_plate(finger in built_finger(), at in 0.03..1.0, angle in -90.0..90.0, share in 0.001..0.03) {
        let image = mirrored(&finger);
        let flip = |vector: Vector| Vector::new(vector.x, -vector.y);
        let s_mm = at * finger.plate_length_mm(Plate::Back);
        let force = force_for_deflection(&image, contact_node(&image, at), angle, share);
        let positions = [PlatePosition { plate: Plate::Back, s_mm }, s_mm.into()];
        let [ours, theirs] = [(&finger, positions[0], flip(force)), (&image, positions[1], force)].map(|(finger, at, force)| {
            let mesh = Mesh::with_elements_per_member(finger, 2);
            let load = mesh.frame_load(&Load::at_position(at, force)).expect("on the plate");
            let found = Statics::ladder(&mesh, Kinematics::Corotational).equilibrium(&[load]).ok()?;
            let point = mesh.plate_point(&found.motion, at).expect("on the plate");
            Some((mesh.shape(&found.motion), point))
        });
        let (Some(ours), Some(theirs)) = (ours, theirs) else { return Err(TestCaseError::reject("no equilibrium")) };
        let scale = theirs.0.largest_displacement_mm();
        for (ours, theirs) in ours.0.motions().iter().zip(theirs.0.motions().iter().rev()) {
            prop_assert!((ours.displacement - flip(theirs.displacement)).norm() <= SAME_EQUILIBRIUM * scale);
        }
        prop_assert!((ours.1 - flip(theirs.1)).norm() <= SAME_EQUILIBRIUM * scale);
    }

    /// The tangent is the derivative of the residual. Tested with arms, hinges, rigid links and loads between nodes. The tangent is compared with
    /// central differences of the residual in a random direction.
    #[test]
    fn tangent_is_consistent(
        finger in built_finger_with_zones(),
        at in [0.0..1.0, 0.01..1.0],
        direction in prop::collection::vec(-1.0..1.0, 32),
        bent in 0.0..0.05,
    ) {
        let mesh = Mesh::with_elements_per_member(&finger, 2);
        let node = contact_node(&finger, at[0]);
        let loads: Vec<FrameLoad> = [
            Load::Node { node, force: force_for_deflection(&finger, node, 20.0, bent), moment_nmm: 3.0 },
            Load::at_position(at[1] * finger.description().front_length_mm, force_for_deflection(&finger, node, -30.0, bent)),
        ]
        .iter()
        .map(|load| mesh.frame_load(load).expect("on the finger"))
        .collect();
        for kinematics in KINEMATICS {
            let mut assembly = Statics::sparse(mesh.frame(), kinematics).equations().assembly().clone();
            let unknowns = assembly.equations().count();
            let along: Vec<f64> = (0..unknowns).map(|i| direction[i % direction.len()] * (1.0 + 0.1 * (i as f64).cos())).collect();
            let mut start = FrameMotion::at_rest(mesh.frame());
            let linear = kinematics == Kinematics::Linear;
            // The offset has rotations of a few degrees, and displacements of a few tenths of a millimetre.
            let offset: Vec<f64> = along.iter().rev().map(|x| 0.05 * x).collect();
            assembly.equations().clone().advance(mesh.frame(), &mut start, &offset, linear);
            let step = 1e-5;
            let mut at = |factor: f64| {
                let mut motion = start.clone();
                let moved: Vec<f64> = along.iter().map(|x| x * step * factor).collect();
                assembly.equations().clone().advance(mesh.frame(), &mut motion, &moved, linear);
                assembly.evaluate(&motion, &loads, 1.0);
                (assembly.residual().to_vec(), assembly.stiffness().clone())
            };
            let (plus, _) = at(1.0);
            let (minus, _) = at(-1.0);
            let (_, tangent) = at(0.0);
            let mut exact = vec![0.0; unknowns];
            for (value, (row, column)) in &tangent {
                exact[row] += value * along[column];
            }
            let scale = largest(&exact);
            for i in 0..unknowns {
                let difference = (plus[i] - minus[i]) / (2.0 * step);
                prop_assert!((difference - exact[i]).abs() <= 1e-6 * scale, "{kinematics:?}, {i}: {difference} against {}", exact[i]);
            }
        }
    }
}
