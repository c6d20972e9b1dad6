//! The finger as a lattice of rigid bodies and springs, compared with beams.
//!
//! The springs have the stiffnesses EA / l, 12 EI / l^3 and EI / l of the beams' own sections, and no parameter is fitted. The comparison verifies
//! solver and co-rotational kinematics, not Euler-Bernoulli theory. Newton's method finds the shapes of least energy, and rapier lets the bodies come
//! to rest.

use super::{CheckRow, assert_all_pass, joined, record_checks, same};
use finray_lattice::energy::{BodyMotion, Energy};
use finray_lattice::settling::{Precision, SWEEPS, Settling};
use finray_lattice::springs::AxialSprings;
use finray_lattice::{Lattice, LatticeError};
use finray_model::estimators::ELEMENTS;
use finray_model::measurement::Measurement;
use finray_model::mesh::FingerShape;
use finray_model::sensing::{ForcePrior, LinearEstimator, NonlinearEstimator};
use finray_model::statics::Statics;
use finray_model::{Kinematics, Load, Mesh, NodeId};
use finray_studies::check::{Check, Kind, NEWTON_LATTICE, SETTLED_LATTICE, difference, worst};
use finray_studies::sampling::sweep::Grid;
use finray_studies::settings::ReportForces;
use finray_studies::truths::{LATTICE_FINENESS, MeshTruth, Truth, TruthId, fine_mesh};
use finray_tests::{assert_recorded, assert_said, at_position, is_full_study, paper};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Elements per member of converged beams. Doubling this number changes displacements of the paper's finger under 5 N by at most 1e-6, relative.
const CONVERGED_ELEMENTS: usize = 32;
/// Segments per plate member in all checks.
const FINENESS: usize = 2;
/// Finenesses that are compared, and the largest fineness that is settled; finer lattices need many seconds.
const FINENESSES: std::ops::RangeInclusive<usize> = 2..=6;
const SETTLED_FINENESS: usize = 4;
const FORCES_N: [f64; 6] = [0.1, 0.5, 1.0, 2.0, 3.0, 5.0];
/// Discretisation error of the lattice against beams, relative. The lattice's segments bend only at their middles. For small rotations the segments
/// deflect like beams, so the error vanishes with the load. The relative difference between lattice and beams is odd in the rotations, so it grows
/// with the force F as a F + b F^3. For two segments per plate member, a = 2.5e-4 / N and b = 2.4e-5 / N^3 describe the difference from 0.1 to 5 N,
/// within 5 %. Both coefficients, a and b, fall with the third to fourth power of the segments' length. The constants allow 25 % more.
const COARSENESS_PER_N: f64 = 3.1e-4;
const COARSENESS_PER_N3: f64 = 3e-5;
/// Error of settling, relative to the largest displacement. 32 solver sweeps per time step cause 6e-5 (measured by varying their number). The
/// criterion by which the bodies count as at rest causes 2e-5.
const SETTLING_TOLERANCE: f64 = 1e-4;
/// A tiny force, N. Co-rotational terms change displacements by a relative amount of at most 0.12 per newton (MuJoCo shows the same at 0.01 N).
const TINY_FORCE_N: f64 = 1e-4;
const TINY_FORCE_TOLERANCE: f64 = 0.13 * TINY_FORCE_N;
/// Tolerance of the difference in sensed / true between lattice and beams. Under 3 N, displacements of the maps' lattice (four segments per member)
/// have a relative error of 1.2e-4. Linear sensing of one force at most doubles the relative error of the displacements.
const SENSED_TOLERANCE: f64 = 2.6e-4;
/// Tolerance of the nonlinear estimator's error on the lattice. The estimator's mesh (four elements per member) has an error of 4e-4 under 3 N; the
/// lattice adds its own error.
const NONLINEAR_TOLERANCE: f64 = 5.3e-4;
const QUANTITY: &str = "largest displacement difference / largest displacement";
/// A lattice counts as not settled after this number of steps, several times the number that the paper's finger needs.
const MOST_STEPS: usize = 20_000;

/// Nodes, directions (degrees) and ascending forces (N) under which lattice and beams are compared.
#[derive(Clone)]
struct Loads {
    at: Vec<(NodeId, f64)>,
    forces_n: Vec<f64>,
}

impl Loads {
    fn of(nodes: &[usize], angles_deg: &[f64], forces_n: &[f64]) -> Loads {
        let at = nodes.iter().flat_map(|&node| angles_deg.iter().map(move |&angle_deg| (NodeId(node), angle_deg)));
        Loads { at: at.collect(), forces_n: forces_n.to_vec() }
    }

    /// All contact nodes except the tip.
    fn all(angles_deg: &[f64], forces_n: &[f64]) -> Loads {
        Loads::of(&(14..=24).collect::<Vec<_>>(), angles_deg, forces_n)
    }

    fn load(&(node, angle_deg): &(NodeId, f64), force_n: f64) -> Load {
        Load::at_node(node, paper().direction(angle_deg) * force_n)
    }
}

/// Shapes by node and direction, then force.
type Shapes = Vec<Vec<FingerShape>>;

fn of_beams(loads: &Loads, kinematics: Kinematics) -> Shapes {
    let mesh = Mesh::with_elements_per_member(&paper(), CONVERGED_ELEMENTS);
    let shapes = |at: &(NodeId, f64)| {
        let load = mesh.frame_load(&Loads::load(at, 1.0)).expect("a free node");
        let (equilibria, stopped) = Statics::ladder(&mesh, kinematics).path(&[load], &loads.forces_n);
        assert!(stopped.is_none(), "{stopped:?}");
        equilibria.iter().map(|equilibrium| mesh.shape(&equilibrium.motion)).collect()
    };
    loads.at.par_iter().map(shapes).collect()
}

/// Shapes of least energy; an error if the lattice has no equilibrium.
fn of_lattice(lattice: &Lattice, loads: &Loads) -> Result<Shapes, LatticeError> {
    let path = |at: &(NodeId, f64)| match lattice.path(&[Loads::load(at, 1.0)], &loads.forces_n)? {
        (shapes, None) => Ok(shapes),
        (_, Some(lost)) => Err(lost),
    };
    loads.at.par_iter().map(path).collect()
}

/// Shapes at rest, largest number of steps, and mean time of one load, ms; an error if the lattice does not settle.
fn settled(lattice: &Lattice, loads: &Loads, how: Settling) -> Result<(Shapes, usize, f64), LatticeError> {
    let settle = |at: &(NodeId, f64), force_n| {
        let start = Instant::now();
        let settled = lattice.settle_as(&[Loads::load(at, force_n)], how)?;
        Ok((settled.shape, settled.steps, 1e3 * start.elapsed().as_secs_f64()))
    };
    let of = |at| loads.forces_n.iter().map(|&force_n| settle(at, force_n)).collect::<Result<Vec<_>, LatticeError>>();
    let all: Vec<Vec<_>> = loads.at.par_iter().map(of).collect::<Result<_, _>>()?;
    let each = || all.iter().flatten();
    let (steps, ms) =
        (each().map(|of| of.1).max().unwrap_or(0), each().map(|of| of.2).sum::<f64>() / each().count() as f64);
    Ok((all.into_iter().map(|of| of.into_iter().map(|(shape, ..)| shape).collect()).collect(), steps, ms))
}

const DEFAULT: Settling = Settling { sweeps: SWEEPS, positions: Precision::Double, most_steps: MOST_STEPS };

/// Largest difference over all nodes and directions, for each force.
fn by_force(reference: &Shapes, other: &Shapes) -> Vec<f64> {
    let at = |n: usize| worst(reference.iter().zip(other).map(|(a, b)| difference(&a[n], &b[n])));
    (0..reference[0].len()).map(at).collect()
}

fn lattice(fineness: usize) -> Lattice {
    Lattice::new(&paper(), fineness).expect("a lattice")
}

#[derive(Debug, Serialize, Deserialize)]
struct FinenessRow {
    segments: usize,
    bodies: usize,
    springs: usize,
    force_n: f64,
    error: f64,
    newton_ms: f64,
    settling_error: Option<f64>,
    settling_steps: Option<usize>,
    settling_ms: Option<f64>,
}

/// Rows of one fineness by force. Times refer to one core while others are busy.
fn of_fineness(fineness: usize, loads: &Loads, beams: &Shapes) -> Vec<FinenessRow> {
    let lattice = lattice(fineness);
    let start = Instant::now();
    lattice.path(&[Loads::load(&loads.at[0], 1.0)], &loads.forces_n).expect("equilibria");
    let newton_ms = 1e3 * start.elapsed().as_secs_f64();
    let errors = by_force(beams, &of_lattice(&lattice, loads).expect("equilibria"));
    let medium = Loads::of(&[18], &[10.0], &[2.0]);
    let settling = (fineness <= SETTLED_FINENESS).then(|| {
        let (shapes, steps, ms) = settled(&lattice, &medium, DEFAULT).expect("rest");
        (by_force(&of_lattice(&lattice, &medium).expect("an equilibrium"), &shapes)[0], steps, ms)
    });
    let row = |(&force_n, error)| FinenessRow {
        segments: fineness,
        bodies: lattice.assembly().bodies.len(),
        springs: lattice.assembly().springs.len(),
        force_n,
        error,
        newton_ms,
        settling_error: settling.map(|of| of.0),
        settling_steps: settling.map(|of| of.1),
        settling_ms: settling.map(|of| of.2),
    };
    loads.forces_n.iter().zip(errors).map(row).collect()
}

/// Finer lattices are nearer to beams, with at least second order.
#[test]
fn finer_lattices_are_nearer_to_beams() {
    let loads = Loads::all(&[-60.0, 0.0, 60.0], &FORCES_N);
    let beams = of_beams(&loads, Kinematics::Corotational);
    let finenesses = if is_full_study() { FINENESSES } else { 2..=3 };
    for fineness in finenesses.clone() {
        let rows = of_fineness(fineness, &loads, &beams);
        let agree = |a: &FinenessRow, b: &FinenessRow| a.bodies == b.bodies && same(a.error, b.error);
        assert_recorded("lattice.csv", |row: &FinenessRow| row.segments == fineness, rows, agree);
    }
    let recorded: Vec<FinenessRow> = finray_tests::recorded("lattice.csv");
    let errors = |of: usize| recorded.iter().filter(|row| row.segments == of).map(|row| row.error).collect::<Vec<_>>();
    let (first, last) = (*FINENESSES.start(), *FINENESSES.end());
    let refined = (last as f64 / first as f64).ln();
    let orders: Vec<f64> = errors(first).iter().zip(errors(last)).map(|(a, b)| (a / b).ln() / refined).collect();
    let [low, high] = super::ends(orders);
    assert!(low >= 2.0, "{low}");
    let [coarse, fine] = [first, last].map(|of| super::percent_two_digits(worst(errors(of))));
    let sentence = format!(
        "A lattice of rigid bodies and springs with the same EA and EI agrees with the beams within {fine} of the largest displacement up to 5 N. From \
         {first} to {last} segments per plate member, the difference falls from {coarse}. The order of convergence in the segment length is {low:.1} to \
         {high:.1}: at least second order, as expected of a discretisation error."
    );
    assert_said("lattice", "says", sentence);
}

#[derive(Debug, Serialize, Deserialize)]
struct AxialRow {
    axial_springs: String,
    inset: f64,
    stiffness: f64,
    force_n: f64,
    error: Option<f64>,
}

/// The axial springs of a beam segment give the smallest error. Other axial springs give larger errors, also for small rotations, and without axial
/// springs there is no equilibrium.
#[test]
fn axial_springs_must_be_those_of_a_beam() {
    // A stiffness 100 times as large changes displacements by 1e-3, relative.
    let beam = AxialSprings::OF_A_BEAM;
    let all = [
        ("as a beam's", beam),
        ("fixed at the segments' ends", AxialSprings { inset: 0.0, ..beam }),
        ("a thousand times as stiff", AxialSprings { stiffness: 1e3, ..beam }),
        ("left out", AxialSprings { stiffness: 0.0, ..beam }),
    ];
    let loads = Loads::all(&[-60.0, 0.0, 60.0], &[0.1, 2.0, 5.0]);
    let beams = of_beams(&loads, Kinematics::Corotational);
    let mut rows = Vec::new();
    for (name, axial) in all {
        let lattice = Lattice::with_axial_springs(&paper(), FINENESS, axial).expect("a lattice");
        let errors = of_lattice(&lattice, &loads).ok().map(|shapes| by_force(&beams, &shapes));
        rows.extend(loads.forces_n.iter().enumerate().map(|(n, &force_n)| AxialRow {
            axial_springs: name.to_owned(),
            inset: axial.inset,
            stiffness: axial.stiffness,
            force_n,
            error: errors.as_ref().map(|errors| errors[n]),
        }));
    }
    let error = |n: usize| rows[n].error.expect("an equilibrium");
    assert!(error(2) * 3.0 < error(5) && error(6) > 0.2 && error(8) > 0.2 && rows[9].error.is_none(), "{rows:?}");
    let agree = |a: &AxialRow, b: &AxialRow| a.error.zip(b.error).map_or(a.error == b.error, |(a, b)| same(a, b));
    assert_recorded("lattice_axial_springs.csv", |_| true, rows, agree);
}

#[derive(Debug, Serialize, Deserialize)]
struct SettlingRow {
    sweeps: usize,
    positions: String,
    error: Option<f64>,
    steps: Option<usize>,
}

/// With more solver sweeps per step, the lattice settles nearer to its equilibrium; only the error of the criterion for rest remains. In single
/// precision, the error is larger. The solver converges most slowly for a load near the tip.
#[test]
fn few_sweeps_and_single_precision_rest_elsewhere() {
    let (lattice, loads) = (lattice(FINENESS), Loads::of(&[14], &[-50.0, 10.0], &[5.0]));
    let equilibria = of_lattice(&lattice, &loads).expect("equilibria");
    let settings = [
        (8, Precision::Double, "double"),
        (16, Precision::Double, "double"),
        (SWEEPS, Precision::Double, "double"),
        (2 * SWEEPS, Precision::Double, "double"),
        (SWEEPS, Precision::Single, "single"),
    ];
    let row = |&(sweeps, positions, name): &(usize, Precision, &str)| {
        let found = settled(&lattice, &loads, Settling { sweeps, positions, most_steps: MOST_STEPS });
        let found = found.map(|(shapes, steps, _)| (by_force(&equilibria, &shapes)[0], steps)).ok();
        SettlingRow { sweeps, positions: name.to_owned(), error: found.map(|of| of.0), steps: found.map(|of| of.1) }
    };
    let rows: Vec<SettlingRow> = settings.par_iter().map(row).collect();
    let [few, more, usual, _, single] = [0, 1, 2, 3, 4].map(|n| rows[n].error.expect("rest"));
    assert!(few > 5.0 * more && more > 2.0 * usual && usual < SETTLING_TOLERANCE && single > 3.0 * usual, "{rows:?}");
    let agree = |a: &SettlingRow, b: &SettlingRow| a.steps == b.steps && a.sweeps == b.sweeps;
    assert_recorded("lattice_settling.csv", |_| true, rows, agree);
    let [double, single] = [Precision::Double, Precision::Single].map(|of| out_of_balance(&lattice, &loads, of));
    assert!(double < 1e-9 && single > 1e-5, "{double} {single}");
    let sentence = format!(
        "If the equilibrium is rounded to single precision, the forces on a body are out of balance by up to {} of the load.",
        super::percent_two_digits(single)
    );
    assert_said("lattice", "text", sentence);
}

/// Largest unbalanced force on a body, relative to the load, after positions and rotations at equilibrium are rounded once to a precision.
fn out_of_balance(lattice: &Lattice, loads: &Loads, precision: Precision) -> f64 {
    let energy = Energy::new(lattice.assembly());
    let share = |at: &(NodeId, f64)| {
        let force_n = loads.forces_n[0];
        let on_bodies = lattice.body_loads(&[Loads::load(at, force_n)]).expect("a load");
        let mut motions = vec![BodyMotion::default(); lattice.assembly().bodies.len()];
        energy.follow(&mut motions, &on_bodies, 0.0, 1.0).expect("an equilibrium");
        for (motion, body) in motions.iter_mut().zip(&lattice.assembly().bodies) {
            let position = (body.position + motion.displacement).map(|x| precision.round(x));
            motion.displacement = position - body.position;
            let (sine, cosine) = motion.rotation.sin_cos();
            motion.rotation = precision.round(sine).atan2(precision.round(cosine));
        }
        // Each body has three entries: two force components and a moment, which is ignored.
        let left = energy.expand(&motions, &on_bodies, 1.0).gradient;
        worst(left.chunks(3).map(|body| body[0].hypot(body[1]))) / force_n
    };
    worst(loads.at.iter().map(share))
}

/// Check that a figure is zero within a tolerance.
fn vanishes(kind: Kind, problem: String, source: &str, quantity: &str, ours: f64, tolerance: f64) -> Check {
    Check::new(kind, problem, source, quantity, 0.0, ours, tolerance)
}

/// Checks of lattice against beams, linear theory and settled shapes, of repeatability, and of sensing on the lattice.
#[test]
fn the_lattice_is_that_of_beams() {
    let lattice = lattice(FINENESS);
    let angles_deg: Vec<f64> = (-4..=4).map(|n| 15.0 * f64::from(n)).collect();
    let full = Loads::all(&angles_deg, &FORCES_N);
    let tolerance = |force_n: f64| COARSENESS_PER_N * force_n + COARSENESS_PER_N3 * force_n.powi(3);
    let name = |what: &str| format!("{what}, {FINENESS} segments per plate member");
    let mut checks: Vec<Check> = Vec::new();
    let bent = of_lattice(&lattice, &full).expect("equilibria");
    for (&force_n, error) in FORCES_N.iter().zip(by_force(&of_beams(&full, Kinematics::Corotational), &bent)) {
        let problem = name(&format!(
            "equilibrium of the lattice against equilibrium of beams, {force_n} N, every node, -60 to 60 deg"
        ));
        checks.push(vanishes(Kind::Internal, problem, NEWTON_LATTICE, QUANTITY, error, tolerance(force_n)));
    }
    let tiny = Loads { forces_n: vec![TINY_FORCE_N], ..full.clone() };
    let shapes = of_lattice(&lattice, &tiny).expect("equilibria");
    let error = by_force(&of_beams(&tiny, Kinematics::Linear), &shapes)[0];
    let problem = name(&format!("equilibrium of the lattice against linear beams, {TINY_FORCE_N} N"));
    checks.push(vanishes(Kind::Internal, problem, NEWTON_LATTICE, QUANTITY, error, TINY_FORCE_TOLERANCE));
    // Directions that the full grid does not contain.
    let few = Loads::of(&[14, 18, 22], &[-50.0, 10.0], &[2.0, 5.0]);
    let (at_rest, ..) = settled(&lattice, &few, DEFAULT).expect("rest");
    let error = worst(by_force(&of_lattice(&lattice, &few).expect("equilibria"), &at_rest));
    let problem = name("settled lattice against the equilibrium of the same lattice, up to 5 N");
    checks.push(vanishes(Kind::Internal, problem, SETTLED_LATTICE, QUANTITY, error, SETTLING_TOLERANCE));
    for (&force_n, error) in few.forces_n.iter().zip(by_force(&of_beams(&few, Kinematics::Corotational), &at_rest)) {
        let problem = name(&format!("settled lattice against beams, {force_n} N, some nodes and directions"));
        checks.push(vanishes(Kind::Internal, problem, SETTLED_LATTICE, QUANTITY, error, tolerance(force_n)));
    }
    let again = lattice.settle(&[Loads::load(&few.at[0], few.forces_n[0])]).expect("rest").shape;
    let bits = |shape: &FingerShape| {
        shape
            .motions()
            .iter()
            .map(|m| [m.displacement.x, m.displacement.y, m.rotation].map(f64::to_bits))
            .collect::<Vec<_>>()
    };
    let changed = usize::from(bits(&again) != bits(&at_rest[0][0]));
    let problem = name("lattice settled twice, 2 N at node 14");
    checks.push(Kind::Internal.on(problem, "itself").counts("shapes whose bits differ", 0, changed));

    let [linear, nonlinear] = sensed_apart();
    let forces = joined(ReportForces::PAPER.of_maps_n(), ", ");
    let problem = format!("least squares on the lattice against the co-rotational finger, {forces} N, no noise");
    checks.push(vanishes(
        Kind::Internal,
        problem,
        NEWTON_LATTICE,
        "largest difference of sensed / true",
        linear,
        SENSED_TOLERANCE,
    ));
    let problem = format!("lattice sensed by the nonlinear estimator, {forces} N, no noise");
    checks.push(vanishes(
        Kind::Internal,
        problem,
        NEWTON_LATTICE,
        "largest |sensed / true - 1|",
        nonlinear,
        NONLINEAR_TOLERANCE,
    ));
    assert_all_pass(&checks);

    let mut rows: Vec<CheckRow> = checks.into_iter().map(CheckRow::from).collect();
    // The differences between lattice and beams are discretisation errors. Their tolerances follow from themselves, so the report shows no verdict.
    let is_measured = |row: &&mut CheckRow| row.problem.contains("beams");
    rows.iter_mut().filter(is_measured).for_each(|row| row.tolerance = None);
    let apart = by_force(&bent, &of_beams(&full, Kinematics::Linear));
    assert!(apart.is_sorted() && apart[5] > 0.1, "{apart:?}");
    rows.extend(FORCES_N.iter().zip(&apart).map(|(force_n, &ours)| CheckRow {
        kind: Kind::Internal,
        problem: format!("linear beams against the lattice, {force_n} N, every node, -60 to 60 deg"),
        source: NEWTON_LATTICE.to_owned(),
        quantity: QUANTITY.to_owned(),
        reference: 0.0,
        ours,
        tolerance: None,
    }));
    record_checks(&[NEWTON_LATTICE, SETTLED_LATTICE, "itself"], rows);
    let [small, large, linear, nonlinear] = [apart[0], apart[5], linear, nonlinear].map(super::percent_two_digits);
    let sentence = format!(
        "Linear theory, which neglects rotations, differs from the lattice by {small} at 0.1 N and by {large} at 5 N. Least-squares forces on the lattice \
         and on the uniform finger agree within {linear} of the force. The nonlinear estimator, whose model is the uniform finger, senses forces on the \
         lattice within {nonlinear}, so the errors of least squares come from linear theory."
    );
    assert_said("lattice", "says", sentence);
}

/// Largest difference of sensed / true by least squares on the lattice and on beams, and largest error of the nonlinear estimator on the lattice.
fn sensed_apart() -> [f64; 2] {
    let finger = paper();
    let (fine, model) = (fine_mesh(&finger).expect("a mesh"), Mesh::with_elements_per_member(&finger, ELEMENTS));
    let beams = MeshTruth::new(TruthId::Corotational, &fine, Kinematics::Corotational).expect("a finger");
    let lattice = lattice(LATTICE_FINENESS);
    let forces_n = ReportForces::PAPER.of_maps_n();
    let (positions_mm, angles_deg) = Grid::grid(&finger, 12, 40.0);
    let contacts: Vec<_> =
        positions_mm.iter().flat_map(|&s| angles_deg.iter().map(move |&a| at_position(s, a))).collect();
    let apart = |contact: &_| {
        let linear = LinearEstimator::new(&finger, &[*contact], &Measurement::at_rest(&finger)).expect("a contact");
        let mut nonlinear = NonlinearEstimator::new(&model, &[(*contact).into()]).expect("a contact");
        let (ours, theirs) = (lattice.shapes(contact, &forces_n), beams.shapes(contact, &forces_n));
        assert_eq!(ours.len(), theirs.len(), "equilibria on lattice and beams");
        let mut largest = [0.0_f64; 2];
        for ((ours, theirs), force_n) in ours.iter().zip(&theirs).zip(forces_n) {
            let [ours, theirs] = [ours, theirs].map(|shape| Measurement::of_shape(&finger, shape));
            let [a, b] =
                [&ours, &theirs].map(|seen| linear.estimate(seen, Some(0.0), ForcePrior::None).forces_n[0] / force_n);
            nonlinear.reset();
            let found = nonlinear.estimate(&ours, Some(1e-6)).expect("an estimate").forces.forces_n[0] / force_n;
            largest = [largest[0].max((a - b).abs()), largest[1].max((found - 1.0).abs())];
        }
        largest
    };
    contacts.par_iter().map(apart).reduce(|| [0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
}
