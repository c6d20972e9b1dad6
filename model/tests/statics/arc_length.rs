//! Equilibrium paths by the arc-length method: properties of every frame and finger.

use finray_model::frame::{FrameLoad, NodeIndex, PlaneFrame, Section};
use finray_model::statics::{ArcLength, Assembly, EquilibriumPath, Statics, StaticsError};
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::{cases, contact_node, finger_with_zones, force_for_deflection, largest, motions_apart, paper};
use proptest::prelude::*;

/// Largest difference between two computations of one equilibrium, due to the tolerance of Newton's method.
const SAME_EQUILIBRIUM: f64 = 1e-8;
/// Relative error of the load with 32 elements, for a column bent up to 2.6 rad.
const MESH_ERROR: f64 = 1e-5;

/// Rounding error of forces, N. EA of the toggle is 1e4 N, and strains of 1e-14 are rounding errors.
const ROUNDING_N: f64 = 1e-9;

/// A shallow toggle with pinned feet. All lengths are multiplied by `unit`, and all forces by `force_unit`.
fn toggle(unit: f64, force_unit: f64) -> (PlaneFrame, NodeIndex) {
    let mut frame = PlaneFrame::default();
    let nodes: Vec<NodeIndex> = (0..=16)
        .map(|i| {
            let x = f64::from(i) - 8.0;
            frame.add_node(Vector::new(x, 0.1 * (8.0 - x.abs())) * unit)
        })
        .collect();
    let section = Section {
        axial_rigidity_n: 1e4 * force_unit,
        bending_rigidity_nmm2: 10.0 * force_unit * unit * unit,
        shear_flexibility: 0.0,
        axis_mm: [0.0; 2],
    };
    for pair in nodes.windows(2) {
        frame.add_beam(pair[0], pair[1], section);
    }
    frame.support(nodes[0], [true, true, false]);
    frame.support(nodes[16], [true, true, false]);
    (frame, nodes[8])
}

fn toggle_path(unit: f64, force_unit: f64, load: f64) -> EquilibriumPath {
    let (frame, apex) = toggle(unit, force_unit);
    let load = FrameLoad::Node { node: apex, force: Vector::new(0.0, -load * force_unit), moment_nmm: 0.0 };
    ArcLength::new(&frame, Kinematics::Corotational)
        .follow(&[load], 2000, |point| point.motion.displacements[apex].y < -1.8 * unit)
        .expect("the toggle snaps through")
}

/// The steps along a path do not depend on units (mm or km, N or kN) or on the size of the load.
#[test]
fn paths_do_not_depend_on_units() {
    let reference = toggle_path(1.0, 1.0, 1.0);
    assert!(reference.limits.len() >= 2);
    for (unit, force_unit, load) in [(1e-3, 1.0, 1.0), (1e6, 1.0, 1.0), (1.0, 1e-6, 1.0), (1.0, 1e3, 7.0)] {
        let path = toggle_path(unit, force_unit, load);
        assert_eq!((path.points.len(), path.limits.len()), (reference.points.len(), reference.limits.len()));
        for (ours, theirs) in path.limits.iter().zip(&reference.limits) {
            assert!((ours.multiple * load / theirs.multiple - 1.0).abs() < SAME_EQUILIBRIUM);
        }
    }
}

/// All points of a path are equilibria: the residual is negligible compared with loads and internal forces.
#[test]
fn points_are_equilibria() {
    let (frame, apex) = toggle(1.0, 1.0);
    let load = FrameLoad::Node { node: apex, force: Vector::new(0.0, -1.0), moment_nmm: 0.0 };
    let path = toggle_path(1.0, 1.0, 1.0);
    let mut assembly = Assembly::new(&frame, Kinematics::Corotational);
    for point in &path.points {
        assembly.evaluate(&point.motion, &[load], point.multiple);
        let residual = largest(assembly.residual());
        assert!(residual < ROUNDING_N, "{residual} at {}", point.multiple);
    }
}

/// A clamped column of length 1 and bending rigidity 1 with negligible compression. Also returns the node of the column's free end.
fn column(elements: usize) -> (PlaneFrame, NodeIndex) {
    let mut frame = PlaneFrame::default();
    let section =
        Section { axial_rigidity_n: 1e6, bending_rigidity_nmm2: 1.0, shear_flexibility: 0.0, axis_mm: [0.0; 2] };
    let nodes: Vec<NodeIndex> =
        (0..=elements).map(|i| frame.add_node(Vector::new(i as f64 / elements as f64, 0.0))).collect();
    for pair in nodes.windows(2) {
        frame.add_beam(pair[0], pair[1], section);
    }
    frame.support(nodes[0], [true; 3]);
    (frame, nodes[elements])
}

/// A straight column under a dead load becomes unstable at Euler's load, which is not a limit point. Beyond Euler's load, the path continues
/// straight, and one more pivot of the tangent is negative. This holds however small the motion is before Euler's load.
#[test]
fn straight_path_shows_euler_loads() {
    let (frame, tip) = column(16);
    let load = FrameLoad::Node { node: tip, force: Vector::new(-1.0, 0.0), moment_nmm: 0.0 };
    let path = ArcLength::new(&frame, Kinematics::Corotational)
        .follow(&[load], 1000, |point| point.negative_pivots == 2)
        .expect("the straight path goes on");
    assert!(path.limits.is_empty());
    let euler = 0.25 * std::f64::consts::PI.powi(2);
    for (pivots, critical) in [(0, euler), (1, 9.0 * euler)] {
        let last = path.points.iter().rposition(|point| point.negative_pivots == pivots).expect("on the path");
        let [below, above] = [last, last + 1].map(|i| path.points[i].multiple);
        // Each critical load is bracketed to two thousandths. With 16 elements, the second critical load is as accurate as the first.
        assert!((0.998..1.002).contains(&(below / critical)) && (0.998..1.002).contains(&(above / critical)));
        assert!(above > below);
    }
}

/// A column with a small transverse load follows the bent branch, and no step leaps to the branch on the other side. For the rotation alpha of the
/// column's end, the closed form is P / P_Euler = 1 / agm(1, cos(alpha / 2))^2 (Timoshenko & Gere, Theory of Elastic Stability, sec. 2.7).
#[test]
fn disturbed_column_follows_the_elastica() {
    let agm = |mut a: f64, mut b: f64| {
        while (a - b).abs() > 1e-15 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        a
    };
    for disturbance in [1e-3, 1e-6] {
        let (frame, tip) = column(32);
        let force = Vector::new(-1.0, disturbance);
        let load = FrameLoad::Node { node: tip, force, moment_nmm: 0.0 };
        let path = ArcLength::new(&frame, Kinematics::Corotational)
            .follow(&[load], 1000, |point| point.motion.rotations[tip].abs() > 2.5)
            .expect("the column bends");
        assert!(path.points.iter().all(|point| point.is_stable()) && path.limits.is_empty());
        let bent = path.points.iter().filter(|point| point.motion.rotations[tip] > 0.5);
        for point in bent.clone() {
            let alpha = point.motion.rotations[tip];
            let expected = 0.25 * (std::f64::consts::PI / agm(1.0, (0.5 * alpha).cos())).powi(2);
            let error = (point.multiple / expected - 1.0).abs();
            assert!(error <= 3.0 * disturbance + MESH_ERROR, "{error} at {alpha} rad");
        }
        assert!(bent.count() > 10);
    }
}

/// Loads that cause no motion leave the frame at rest. A frame that can move without deforming is refused.
#[test]
fn degenerate_frames() {
    let (frame, apex) = toggle(1.0, 1.0);
    let none = FrameLoad::Node { node: apex, force: Vector::zeros(), moment_nmm: 0.0 };
    let path = ArcLength::new(&frame, Kinematics::Corotational).follow(&[none], 10, |_| false).expect("at rest");
    assert_eq!(path.points.len(), 10);
    assert!(path.points.iter().all(|point| point.is_stable() && point.motion.largest_displacement() == 0.0));
    let bad = FrameLoad::Node { node: apex, force: Vector::new(f64::NAN, 0.0), moment_nmm: 0.0 };
    let refused = ArcLength::new(&frame, Kinematics::Corotational).follow(&[bad], 10, |_| false);
    assert_eq!(refused, Err(StaticsError::LoadNotFinite));
    let mut free = PlaneFrame::default();
    let nodes = [0.0, 1.0].map(|x| free.add_node(Vector::new(x, 0.0)));
    free.add_beam(
        nodes[0],
        nodes[1],
        Section { axial_rigidity_n: 1.0, bending_rigidity_nmm2: 1.0, shear_flexibility: 0.0, axis_mm: [0.0; 2] },
    );
    let load = FrameLoad::Node { node: nodes[1], force: Vector::new(0.0, 1.0), moment_nmm: 0.0 };
    let refused = ArcLength::new(&free, Kinematics::Corotational).follow(&[load], 10, |_| false);
    assert_eq!(refused, Err(StaticsError::NotHeld));
}

proptest! {
    #![proptest_config(cases(64))]

    /// On its first stable branch, a path passes through the equilibria that load steps find. Tested with arms, hinges, rigid links, moments and
    /// loads between nodes. The path has its first limit point or bifurcation at the load at which load steps end.
    #[test]
    fn paths_pass_through_the_equilibria_of_load_steps(
        finger in finger_with_zones(),
        at in [0.0..1.0, 0.03..1.0],
        angle in -80.0..80.0,
        share in 0.005..0.05,
    ) {
        let mesh = Mesh::with_elements_per_member(&finger, 2);
        let node = contact_node(&finger, at[0]);
        let force = force_for_deflection(&finger, node, angle, share);
        let length = finger.description().front_length_mm;
        let loads = [
            Load::Node { node, force: force * 0.7, moment_nmm: 0.01 * length * force.norm() },
            Load::at_position(at[1] * length, force * 0.3),
        ];
        let loads = loads.map(|load| mesh.frame_load(&load).expect("on the finger"));
        let path = ArcLength::new(mesh.frame(), Kinematics::Corotational)
            .follow(&loads, 400, |point| !point.is_stable() || point.multiple > 1.0);
        let path = path.expect("the path is not lost");
        let mut statics = Statics::sparse(mesh.frame(), Kinematics::Corotational);
        let stable: Vec<_> = path.points.iter().skip(1).take_while(|point| point.is_stable()).collect();
        let multiples: Vec<f64> = stable.iter().map(|point| point.multiple).collect();
        let (found, failed) = statics.path(&loads, &multiples);
        prop_assert!(failed.is_none(), "{failed:?} after {} of {} points", found.len(), stable.len());
        for (point, equilibrium) in stable.iter().zip(&found) {
            let apart = motions_apart(&point.motion, &equilibrium.motion);
            prop_assert!(apart <= SAME_EQUILIBRIUM, "{apart} at {}", point.multiple);
        }
    }
}

/// Load steps on the paper's finger with another solver (ladder, Cholesky) end at the first limit point of the path.
#[test]
fn load_steps_end_at_the_first_limit_point() {
    let finger = paper();
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    for node in [14, 17, 20].map(NodeId) {
        let load = mesh.frame_load(&Load::at_node(node, finger.direction(0.0) * 30.0)).expect("a contact node");
        let path = ArcLength::new(mesh.frame(), Kinematics::Corotational)
            .follow(&[load], 300, |point| point.multiple > 1.0)
            .expect("the path is followed");
        // The finger snaps through and is stable at the end of the path, so the load has as many maxima as minima.
        assert!(path.points.last().is_some_and(|point| point.is_stable() && point.multiple > 1.0));
        assert_eq!(path.limits.len(), 2, "node {node}");
        let limit = &path.limits[0];
        assert!(path.points[..=limit.after].iter().all(|point| point.is_stable()));
        match Statics::ladder(&mesh, Kinematics::Corotational).equilibrium(&[load]) {
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                let missing = 1.0 - converged_fraction / limit.multiple;
                assert!((-1e-9..1e-4).contains(&missing), "node {node}: {converged_fraction} of {}", limit.multiple);
            }
            other => panic!("expected the limit load, found {other:?}"),
        }
    }
}
