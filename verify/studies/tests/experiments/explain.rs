//! Explanations of the maps, compared with independent results: scatter over noise samples, finite differences of equilibria, and sensing under
//! slightly wrong assumptions.

use finray_model::estimators::network::Networks;
use finray_model::estimators::{ELEMENTS, EstimatorId};
use finray_model::measurement::{Marker, Measurement};
use finray_model::sensing::{ContactPosition, ContactQuestion, Direction, NonlinearEstimator};
use finray_model::{Kinematics, Load, Mesh, Scene, Vector, statics};
use finray_studies::experiments::explain::{Explanation, ExplanationMap};
use finray_studies::sampling::map::{MapRequest, accuracy_maps};
use finray_studies::sampling::sampled::SampledSensor;
use finray_studies::truths::MeshTruth;
use finray_studies::truths::TruthId;
use finray_tests::{at_position, noisy, paper};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::LazyLock;

const FORCE_N: f64 = 3.0;
/// Positions between the ribs, which are 12.75 mm apart. At a rib, the strain of the plate differs between the two sides of the rib.
const POSITIONS_MM: [f64; 4] = [17.0, 49.0, 83.0, 147.0];
const ANGLES_DEG: [f64; 3] = [-50.0, 0.0, 40.0];
/// Noise, mm, that is so small that its effect on the sensed force is linear.
const NOISE_MM: f64 = 0.002;
/// Number of samples; `SCATTER` is the relative tolerance of a standard deviation. The relative standard error of a standard deviation is 1 / sqrt(2
/// n) for n samples. Among a dozen standard deviations, the worst deviates by three standard errors, and by four once in a thousand runs.
const SAMPLES: usize = 1000;
const SCATTER: f64 = 4.0 / 44.7;
/// Steps of the central differences, and the relative tolerance of these differences. Their error is of third order.
const FORCE_STEP_N: f64 = 0.01;
const ANGLE_STEP_DEG: f64 = 0.5;
const POSITION_STEP_MM: f64 = 0.1;
const DIFFERENCES: f64 = 5e-3;
/// Absolute tolerance of an error per degree or mm, dimensionless. If the error is nearly zero, because it changes its sign, the third-order term
/// dominates.
const NOTHING: f64 = 2e-5;

static MESH: LazyLock<Mesh> = LazyLock::new(|| Mesh::with_elements_per_member(&paper(), ELEMENTS));
static EXPLAINED: LazyLock<Vec<Explanation>> = LazyLock::new(|| {
    let map =
        ExplanationMap::new(&MESH, &POSITIONS_MM, &ANGLES_DEG, FORCE_N, NOISE_MM).expect("positions on the plate");
    assert_eq!(map.cells.len(), POSITIONS_MM.len() * ANGLES_DEG.len());
    assert!(map.cells.iter().all(|cell| cell.bound.is_some()), "3 N are carried everywhere");
    map.cells
});

fn shape_under(mesh: &Mesh, s_mm: f64, force: Vector) -> Measurement {
    let shape =
        statics::solve(mesh, &[Load::at_position(s_mm, force)], Kinematics::Corotational).expect("an equilibrium");
    Measurement::of_shape(mesh.finger(), &shape)
}

fn measured(mesh: &Mesh, cell: &Explanation) -> Measurement {
    shape_under(mesh, cell.s_mm, mesh.finger().direction(cell.angle_deg) * cell.force_n)
}

#[track_caller]
fn assert_near(ours: f64, theirs: f64, relative: f64, absolute: f64, cell: &Explanation) {
    assert!((ours - theirs).abs() <= relative * theirs.abs() + absolute, "{ours} against {theirs} in {cell:?}");
}

#[test]
fn the_bound_is_how_the_nonlinear_estimator_scatters() {
    let truth = MeshTruth::new(TruthId::Corotational, &MESH, Kinematics::Corotational).expect("a finger");
    let nonlinear = SampledSensor::new(EstimatorId::Nonlinear, Networks::none());
    let request = MapRequest {
        positions_mm: POSITIONS_MM.into(),
        angles_deg: ANGLES_DEG.into(),
        is_leaning: false,
        forces_n: vec![FORCE_N],
        noise_levels_mm: vec![NOISE_MM],
        noise_samples: SAMPLES,
        seed: 5,
    };
    let map = accuracy_maps(Scene::of_finger(paper()), &truth, &[nonlinear], &request, &|| ()).swap_remove(0);
    for (cell, sensed) in EXPLAINED.iter().zip(&map.cells) {
        assert_eq!((cell.s_mm, cell.angle_deg), (sensed.s_mm, sensed.angle_deg));
        assert_near(cell.bound.unwrap(), sensed.spread.expect("an answer"), SCATTER, 0.0, cell);
    }
}

/// Both force and direction are unknown.
#[test]
fn the_bounds_of_an_unknown_direction_are_how_force_and_direction_scatter() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for cell in EXPLAINED.iter().filter(|cell| cell.s_mm > 40.0) {
        let question = ContactQuestion::new(Some(ContactPosition::at(cell.s_mm)), Direction::Auto);
        let mut estimator = NonlinearEstimator::new(&MESH, &[question]).expect("a contact");
        let clean = measured(&MESH, cell);
        let (mut forces, mut angles) = (Vec::new(), Vec::new());
        for _ in 0..SAMPLES {
            let noisy = noisy(&clean, NOISE_MM, &mut rng);
            let estimate = estimator.estimate(&noisy, Some(NOISE_MM)).expect("an answer");
            forces.push(estimate.forces.forces_n[0] / FORCE_N);
            angles.push(estimate.contacts[0].angle_deg);
        }
        assert_near(cell.bound_unknown_direction.unwrap(), deviation(&forces), SCATTER, 0.0, cell);
        assert_near(cell.direction_sigma_deg.unwrap(), deviation(&angles), SCATTER, 0.0, cell);
    }
}

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt()
}

/// Bounds and condition number agree with finite differences of equilibria under slightly changed normal and tangential forces.
#[test]
fn bounds_and_condition_follow_from_differences_of_equilibria() {
    let finger = paper();
    for cell in EXPLAINED.iter() {
        let column = |direction: Vector| -> Vec<f64> {
            let at = |step: f64| {
                shape_under(&MESH, cell.s_mm, finger.direction(cell.angle_deg) * FORCE_N + direction * step)
            };
            let (more, less) = (at(FORCE_STEP_N), at(-FORCE_STEP_N));
            let pairs = more.markers().iter().zip(less.markers());
            let rate = |(a, b): (&Marker, &Marker)| {
                let rate = (a.displacement - b.displacement) / (2.0 * FORCE_STEP_N);
                [rate.x, rate.y]
            };
            pairs.flat_map(rate).collect()
        };
        let columns = [column(finger.direction(0.0)), column(finger.direction(90.0))].concat();
        let rates = DMatrix::from_vec(columns.len() / 2, 2, columns);
        let values = rates.clone().singular_values();
        assert_near(cell.condition.unwrap(), values.max() / values.min(), DIFFERENCES, 0.0, cell);
        // Converts normal and tangential components to components along and across the force.
        let (sine, cosine) = cell.angle_deg.to_radians().sin_cos();
        let turned = rates * DMatrix::from_column_slice(2, 2, &[cosine, sine, -sine, cosine]);
        let covariance = (turned.transpose() * &turned).try_inverse().unwrap() * (NOISE_MM / FORCE_N).powi(2);
        assert_near(cell.bound_unknown_direction.unwrap(), covariance[(0, 0)].sqrt(), DIFFERENCES, 0.0, cell);
        assert_near(cell.direction_sigma_deg.unwrap(), covariance[(1, 1)].sqrt().to_degrees(), DIFFERENCES, 0.0, cell);
        assert_near(cell.bound.unwrap(), NOISE_MM / FORCE_N / turned.column(0).norm(), DIFFERENCES, 0.0, cell);
    }
}

/// Ratio of sensed to true force for the shape of a cell, with an assumed position and direction.
fn sensed(mesh: &Mesh, cell: &Explanation, s_mm: f64, angle_deg: f64) -> f64 {
    let contact = at_position(s_mm, angle_deg);
    let mut estimator = NonlinearEstimator::new(mesh, &[contact.into()]).expect("a contact");
    // The stated noise covers the misfit of the wrong assumption, so that no marker counts as an outlier.
    estimator.estimate(&measured(mesh, cell), Some(0.5)).expect("an answer").forces.forces_n[0] / FORCE_N
}

/// Senses forces with assumed directions that are wrong by half a degree to each side.
#[test]
fn wrong_directions_carry_as_far_as_said() {
    for cell in EXPLAINED.iter() {
        let off = |step: f64| sensed(&MESH, cell, cell.s_mm, cell.angle_deg + step);
        let per_deg = (off(ANGLE_STEP_DEG) - off(-ANGLE_STEP_DEG)) / (2.0 * ANGLE_STEP_DEG);
        assert_near(cell.error_per_deg.unwrap(), per_deg.abs(), DIFFERENCES, NOTHING, cell);
    }
}

/// Senses forces at assumed positions that are wrong by a tenth of a millimetre to each side.
#[test]
fn wrong_positions_carry_as_far_as_said() {
    for cell in EXPLAINED.iter() {
        let off = |step: f64| sensed(&MESH, cell, cell.s_mm + step, cell.angle_deg);
        let per_mm = (off(POSITION_STEP_MM) - off(-POSITION_STEP_MM)) / (2.0 * POSITION_STEP_MM);
        assert_near(cell.error_per_mm.unwrap(), per_mm.abs(), DIFFERENCES, NOTHING, cell);
    }
}

#[test]
fn what_has_no_equilibrium_has_no_explanation() {
    let map = ExplanationMap::new(&MESH, &[150.0], &[0.0], 1e4, NOISE_MM).expect("a position on the plate");
    let cell = map.cells[0];
    let all = [cell.bound, cell.bound_unknown_direction, cell.condition, cell.error_per_deg, cell.error_per_mm];
    assert_eq!(all, [None; 5]);
    assert!(ExplanationMap::new(&MESH, &[160.0], &[0.0], FORCE_N, NOISE_MM).is_err(), "off the plate");
}
