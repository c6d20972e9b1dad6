//! Causes of sensing errors on the uniform finger and on the finger with softer ends.
//!
//! A finger, co-rotational on a fine mesh, is pushed at a position in a direction. Sensing follows a user's practice: softer zones are unknown, the
//! modulus is calibrated by shapes under weights, position and direction are assumed with errors, and the camera is noisy. The share of a cause is the
//! part of the mean square error that disappears without the cause. Shares need not add up to one, because errors of equal sign reinforce each other
//! when squared, and a cause that compensates another has a negative share.

use super::WEIGHTS_N;
use super::table_one::{CALIBRATION_NODES, cases};
use finray_model::calibration::{FactorModel, UnknownFactor, factors};
use finray_model::estimators::{ELEMENTS, EstimatorId};
use finray_model::finger::{FingerDescription, Part, Plate};
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ForcePrior, LinearEstimator, NonlinearEstimator};
use finray_model::{Finger, Kinematics, Mesh};
use finray_studies::sampling::sweep::Grid;
use finray_studies::settings::{DIRECTION_OFF_DEG, POSITION_OFF_MM};
use finray_studies::truths::{MeshTruth, Truth, TruthId, fine_mesh, twin_of};
use finray_tests::{CAMERA_NOISE_MM, assert_recorded, at_position, is_full_study, paper, recorded};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Number of positions, step of the directions (degrees) and forces (N) of the recorded cells.
const GRID: (usize, f64) = (24, 20.0);
const FORCES_N: [f64; 2] = [0.5, 3.0];
/// Length of each of the regions near base and tip, as a share of the plate: two members.
const NEAR_AN_END: f64 = 1.0 / 6.0;
/// Errors of two machines agree within this difference of their shares.
const SAME: f64 = 2e-3;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Cause {
    Noise,
    /// Assumption of small rotations; without it, sensing is nonlinear.
    Linearisation,
    Modulus,
    Direction,
    Position,
    /// Unknown zones nearer to the base than to the tip, or nearer to the tip.
    Base,
    Tip,
}
use Cause::{Base, Direction, Linearisation, Modulus, Noise, Position, Tip};

const NAMES: [(Cause, &str); 7] = [
    (Noise, "noise"),
    (Linearisation, "linearisation"),
    (Modulus, "wrong modulus"),
    (Direction, "wrong direction"),
    (Position, "wrong position"),
    (Base, "base compliance"),
    (Tip, "tip compliance"),
];
/// Remedies in the order in which they are added, with the causes that they remove.
const REMEDIES: [&[Cause]; 3] = [&[Base, Tip, Modulus], &[Direction, Position], &[Linearisation]];

/// The finger with only the zones at the ends that are known.
fn with_zones(finger: &Finger, base: bool, tip: bool) -> Finger {
    let mut description: FingerDescription = finger.description().clone();
    description.zones.retain(|zone| {
        let plate = if zone.part == Part::Back { Plate::Back } else { Plate::Front };
        if zone.from_mm + zone.to_mm < finger.plate_length_mm(plate) { base } else { tip }
    });
    Finger::new(description).expect("a finger")
}

/// A true finger, and the models with which a user senses.
struct World {
    truth: TruthId,
    mesh: Mesh,
    /// Models by what is wrong in them.
    models: Vec<([bool; 4], Mesh)>,
}

impl World {
    fn of(truth: TruthId, finger: &Finger) -> World {
        let mesh = fine_mesh(finger).expect("a mesh");
        let pushed = MeshTruth::new(truth, &mesh, Kinematics::Corotational).expect("a finger");
        let weighed: Vec<_> =
            CALIBRATION_NODES.iter().flat_map(|&node| cases(finger, &pushed, node, 0.0, &WEIGHTS_N)).collect();
        let model = |number: usize| {
            let wrong @ [base, tip, modulus, linear] = [0, 1, 2, 3].map(|bit| number >> bit & 1 == 1);
            let zoned = with_zones(finger, !base, !tip);
            let kinematics = if linear { Kinematics::Linear } else { Kinematics::Corotational };
            let how = FactorModel { kinematics, elements: ELEMENTS, noise_mm: None };
            let calibrated = || factors(&zoned, &weighed, &[UnknownFactor::Modulus], &how).expect("a modulus").finger;
            (wrong, Mesh::with_elements_per_member(&if modulus { calibrated() } else { zoned.clone() }, ELEMENTS))
        };
        World { truth, models: (0..16).into_par_iter().map(model).collect(), mesh }
    }

    fn pushed(&self) -> MeshTruth<'_> {
        MeshTruth::new(self.truth, &self.mesh, Kinematics::Corotational).expect("a finger")
    }

    /// Mean square of sensed / true - 1 if these causes are present, over all assumed contacts on the plate; `None` if sensing refuses. With a wrong
    /// model, a stated standard deviation follows from the residual; here it is scaled to the noise.
    fn square(&self, causes: &[Cause], seen: &Measurement, contact: &Contact, force_n: f64) -> Option<f64> {
        let has = |cause| causes.contains(&cause);
        let wrong = [has(Base), has(Tip), has(Modulus), has(Linearisation)];
        let (_, mesh) = self.models.iter().find(|(of, _)| *of == wrong)?;
        let finger = mesh.finger();
        let noise_mm = if has(Noise) { CAMERA_NOISE_MM } else { 0.0 };
        let sides = |off: bool, by: f64| if off { vec![-by, by] } else { vec![0.0] };
        let s_mm = contact.position_mm(finger)?;
        let (mut sum, mut count) = (0.0, 0);
        for off_mm in sides(has(Position), POSITION_OFF_MM) {
            if s_mm + off_mm <= 0.0 || s_mm + off_mm > finger.plate_length_mm(Plate::Front) {
                continue;
            }
            for off_deg in sides(has(Direction), DIRECTION_OFF_DEG) {
                let assumed = at_position(s_mm + off_mm, contact.angle_deg + off_deg);
                let [sensed_n, sigma_n] = if has(Linearisation) {
                    let estimator = LinearEstimator::new(finger, &[assumed], seen).ok()?;
                    let sensed_n = estimator.estimate(seen, Some(noise_mm), ForcePrior::None).forces_n[0];
                    [sensed_n, estimator.inverse().sigmas_per_noise[0] * noise_mm]
                } else {
                    let mut estimator = NonlinearEstimator::new(mesh, &[assumed.into()]).ok()?;
                    let found = estimator.estimate(seen, Some(CAMERA_NOISE_MM)).ok()?.forces;
                    [found.forces_n[0], found.sigmas_n[0] * noise_mm / found.trusted_noise_mm]
                };
                sum += (sensed_n / force_n - 1.0).powi(2) + (sigma_n / force_n).powi(2);
                count += 1;
            }
        }
        Some(sum / f64::from(count))
    }
}

/// A user's practice: estimator, whether the contact is known, forces (N), and whether only the normal is studied.
type Practice = (EstimatorId, bool, &'static [f64], bool);
const PRACTICES: [Practice; 4] = [
    (EstimatorId::LeastSquares, true, &FORCES_N, false),
    (EstimatorId::LeastSquares, false, &[3.0], false),
    (EstimatorId::Nonlinear, true, &[3.0], false),
    (EstimatorId::Nonlinear, false, &[3.0], true),
];

fn present(truth: TruthId, (estimator, is_known, ..): Practice) -> Vec<Cause> {
    let holds = |cause: &Cause| match cause {
        Linearisation => estimator == EstimatorId::LeastSquares,
        Direction | Position => !is_known,
        Base | Tip => truth == TruthId::Twin,
        Noise | Modulus => true,
    };
    NAMES.map(|(cause, _)| cause).into_iter().filter(holds).collect()
}

/// Errors of one force at one position and direction: with all causes, without each, and after each remedy.
struct Cell {
    contact: Contact,
    s_mm: f64,
    all: Option<f64>,
    without: Vec<Option<f64>>,
    remedied: [Option<f64>; 3],
}

fn cell(world: &World, causes: &[Cause], contact: Contact, force_n: f64) -> Cell {
    let s_mm = contact.position_mm(world.mesh.finger()).expect("a position");
    let shape = world.pushed().shapes(&contact, &[force_n]).pop();
    let seen = shape.map(|shape| Measurement::of_shape(world.mesh.finger(), &shape));
    let square = |off: &[Cause]| {
        let left: Vec<Cause> = causes.iter().copied().filter(|cause| !off.contains(cause)).collect();
        world.square(&left, seen.as_ref()?, &contact, force_n)
    };
    let remedied = [1, 2, 3].map(|taken| square(&REMEDIES[..taken].concat()));
    Cell { contact, s_mm, all: square(&[]), without: causes.iter().map(|cause| square(&[*cause])).collect(), remedied }
}

/// Of one force sensed by least squares with an assumed contact: errors (root mean squares), and the largest cause.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct CellRow {
    truth: String,
    s_mm: f64,
    angle_deg: f64,
    force_n: f64,
    rms_error: Option<f64>,
    largest: String,
    zones_known: Option<f64>,
    contact_known: Option<f64>,
    nonlinear: Option<f64>,
}

/// Error in a region, with its largest cause and the error without it.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Row {
    truth: String,
    estimator: String,
    contact: String,
    force_n: f64,
    region: String,
    cells: usize,
    answered: usize,
    rms_error: f64,
    largest: String,
    share: Option<f64>,
    rms_without: Option<f64>,
    answered_without: Option<usize>,
}

/// Name of the cause with the largest positive share, that share, and the index of the cause.
fn largest(causes: &[Cause], shares: &[f64]) -> (&'static str, Option<(usize, f64)>) {
    let most = shares.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, share)| *share > 0.0);
    let name = |i: usize| NAMES.iter().find(|(cause, _)| *cause == causes[i]).map_or("", |(_, name)| name);
    (most.map_or("causes cancel", |(i, _)| name(i)), most)
}

fn rounded(error: f64) -> f64 {
    format!("{error:.3e}").parse().expect("a number")
}

fn cell_row(world: &World, causes: &[Cause], force_n: f64, cell: &Cell) -> CellRow {
    let rms = |square: Option<f64>| square.map(|square| rounded(square.sqrt()));
    let share = |without: &Option<f64>| Some(1.0 - (*without)? / cell.all?);
    let shares: Vec<f64> = cell.without.iter().map(|without| share(without).unwrap_or(f64::NEG_INFINITY)).collect();
    let [zones_known, contact_known, nonlinear] = cell.remedied.map(rms);
    CellRow {
        truth: world.truth.name().to_owned(),
        s_mm: cell.s_mm,
        angle_deg: cell.contact.angle_deg,
        force_n,
        rms_error: rms(cell.all),
        largest: if cell.all.is_some() { largest(causes, &shares).0.to_owned() } else { String::new() },
        zones_known,
        contact_known,
        nonlinear,
    }
}

/// Name of a region, and whether it covers a position (share of the plate length) and a direction (whether along the normal).
type Region = (&'static str, fn(f64, bool) -> bool);

/// Rows of a practice by region: near the base, the middle and near the tip along the normal, and all cells.
fn by_region(world: &World, practice: Practice, causes: &[Cause], force_n: f64, cells: &[Cell]) -> Vec<Row> {
    let length_mm = world.mesh.finger().plate_length_mm(Plate::Front);
    let row = |(region, covers): Region| {
        let within: Vec<&Cell> =
            cells.iter().filter(|cell| covers(cell.s_mm / length_mm, cell.contact.angle_deg == 0.0)).collect();
        let answered: Vec<(f64, &Cell)> = within.iter().filter_map(|cell| Some((cell.all?, *cell))).collect();
        let total: f64 = answered.iter().map(|(square, _)| square).sum();
        let left = |i: usize| answered.iter().filter_map(move |(square, cell)| Some([*square, cell.without[i]?]));
        // A cell that refuses without the cause counts as no reduction.
        let shares: Vec<f64> =
            (0..causes.len()).map(|i| left(i).map(|[all, left]| all - left).sum::<f64>() / total).collect();
        let (name, most) = largest(causes, &shares);
        let without = most.map(|(i, _)| {
            let (sum, count) = left(i).fold((0.0, 0), |(sum, count), [_, left]| (sum + left, count + 1));
            (f64::sqrt(sum / count as f64), count)
        });
        Row {
            truth: world.truth.name().to_owned(),
            estimator: practice.0.name().to_owned(),
            contact: if practice.1 { "known" } else { "assumed" }.to_owned(),
            force_n,
            region: region.to_owned(),
            cells: within.len(),
            answered: answered.len(),
            rms_error: rounded((total / answered.len() as f64).sqrt()),
            largest: name.to_owned(),
            share: most.map(|(_, share)| rounded(share)),
            rms_without: without.map(|(rms, _)| rounded(rms)),
            answered_without: without.map(|(_, count)| count),
        }
    };
    let regions: [Region; 4] = [
        ("near the base", |along, normal| normal && along <= NEAR_AN_END),
        ("middle", |along, normal| normal && along > NEAR_AN_END && along < 1.0 - NEAR_AN_END),
        ("near the tip", |along, normal| normal && along >= 1.0 - NEAR_AN_END),
        ("all", |_, _| true),
    ];
    regions.map(row).into()
}

fn worlds() -> [World; 2] {
    [(TruthId::Corotational, paper()), (TruthId::Twin, twin_of(&paper()).expect("the paper's finger"))]
        .map(|(truth, finger)| World::of(truth, &finger))
}

/// A full study records every cell and region; another run compares some cells of the strongest practice.
#[test]
fn causes_are_recorded() {
    let near =
        |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(a == b, |(a, b)| (a - b).abs() <= SAME * b.abs().max(SAME));
    let same = |a: &CellRow, b: &CellRow| {
        (&a.truth, a.s_mm, a.angle_deg, &a.largest) == (&b.truth, b.s_mm, b.angle_deg, &b.largest)
            && near(a.rms_error, b.rms_error)
            && near(a.zones_known, b.zones_known)
            && near(a.contact_known, b.contact_known)
            && near(a.nonlinear, b.nonlinear)
    };
    let worlds = worlds();
    if !is_full_study() {
        let (rows, causes) = (recorded::<CellRow>("causes_by_cell.csv"), |truth| present(truth, PRACTICES[1]));
        for row in rows.iter().skip(100).step_by(97) {
            let world = worlds.iter().find(|world| world.truth.name() == row.truth).expect("a finger");
            let causes = causes(world.truth);
            let found = cell(world, &causes, at_position(row.s_mm, row.angle_deg), row.force_n);
            let found = cell_row(world, &causes, row.force_n, &found);
            assert!(same(&found, row), "{found:?}, recorded {row:?}: run this example with FINRAY_TEST_CASES=full");
        }
        for world in &worlds {
            let causes = present(world.truth, PRACTICES[0]);
            let contacts =
                Grid::grid(world.mesh.finger(), GRID.0, GRID.1).0.into_iter().map(|s_mm| at_position(s_mm, 0.0));
            let cells: Vec<Cell> = contacts.map(|contact| cell(world, &causes, contact, 3.0)).collect();
            let found = by_region(world, PRACTICES[0], &causes, 3.0, &cells);
            let way = |row: &Row| [&row.truth, &row.estimator, &row.contact, &row.region].map(String::clone);
            for row in found.iter().filter(|row| row.region != "all") {
                let of = recorded::<Row>("causes.csv").into_iter().find(|of| way(of) == way(row) && of.force_n == 3.0);
                let of = of.expect("a recorded region");
                assert!(
                    of.largest == row.largest && near(Some(row.rms_error), Some(of.rms_error)),
                    "{row:?}, recorded {of:?}"
                );
            }
        }
        return;
    }
    let (mut cell_rows, mut rows) = (Vec::new(), Vec::new());
    for world in &worlds {
        let (positions_mm, angles_deg) = Grid::grid(world.mesh.finger(), GRID.0, GRID.1);
        for practice in PRACTICES {
            let (_, _, forces_n, only_normal) = practice;
            let angles_deg = if only_normal { &[0.0][..] } else { &angles_deg };
            let contacts: Vec<Contact> =
                positions_mm.iter().flat_map(|&s| angles_deg.iter().map(move |&angle| at_position(s, angle))).collect();
            let causes = present(world.truth, practice);
            for &force_n in forces_n {
                let cells: Vec<Cell> =
                    contacts.par_iter().with_max_len(1).map(|c| cell(world, &causes, *c, force_n)).collect();
                rows.extend(by_region(world, practice, &causes, force_n, &cells));
                if practice == PRACTICES[1] {
                    cell_rows.extend(cells.iter().map(|cell| cell_row(world, &causes, force_n, cell)));
                }
            }
        }
    }
    assert_recorded("causes.csv", |_| true, rows, |_: &Row, _| true);
    assert_recorded("causes_by_cell.csv", |_| true, cell_rows, same);
}

/// Zones are the cause of errors where they are, linearisation where all else is known, and what is left without every cause is noise at its bound.
#[test]
fn causes_are_where_they_are() {
    let [uniform, twin] = worlds();
    let share = |world: &World, practice: usize, contact, force_n, cause: Cause| {
        let causes = present(world.truth, PRACTICES[practice]);
        let found = cell(world, &causes, contact, force_n);
        let i = causes.iter().position(|of| *of == cause).expect("a cause");
        1.0 - found.without[i].expect("an answer") / found.all.expect("an answer")
    };
    // Nodes 14 and 24.
    for (s_mm, cause, other) in [(140.25, Tip, Base), (12.75, Base, Tip)] {
        let of = |cause| share(&twin, 0, at_position(s_mm, 0.0), 1.0, cause);
        assert!(of(cause) > 0.8 && of(other).abs() < 0.1, "{s_mm} mm: {}, {}", of(cause), of(other));
    }
    let at = at_position(63.75, -40.0);
    assert!(share(&uniform, 0, at, 3.0, Linearisation) > 0.9 && share(&uniform, 2, at, 3.0, Noise) > 0.9);
    let found = cell(&uniform, &present(uniform.truth, PRACTICES[1]), at, 3.0);
    let shape = uniform.pushed().shapes(&at, &[3.0]).pop().expect("carried");
    let mut estimator = NonlinearEstimator::new(&uniform.models[0].1, &[at.into()]).expect("a contact");
    let seen = Measurement::of_shape(uniform.mesh.finger(), &shape);
    let bound = estimator.estimate(&seen, Some(CAMERA_NOISE_MM)).expect("an estimate").forces.sigmas_n[0] / 3.0;
    let left = found.remedied[2].expect("an answer").sqrt();
    // The mesh of the estimator adds an error of a quarter of the bound, squared.
    assert!((1.0..1.05).contains(&(left / bound)), "{left} against {bound}");
}
