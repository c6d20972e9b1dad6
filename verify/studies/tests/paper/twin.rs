//! A digital twin of the finger behind Table I: the paper's finger with one of several possible sets of softer ends.
//!
//! The modulus factors of zones, and the modulus outside the zones, are fitted to the six published mean errors. Six numbers, with an assumed direction
//! of the weights, do not determine a finger: other zones fit equally well, some even better. Soft ends are an assumption of the fit, so their effect
//! on the twin is no evidence that the real finger has soft ends.

use super::table_one::{NODES, TableOne, modulus_factor, table_one, uniform};
use super::{WEIGHTS_N, ends, joined, percent, same};
use finray_fixtures::TWIN_SCENE;
use finray_model::calibration::{CalibrationCase, FactorEstimate, FactorModel, UnknownFactor, factors};
use finray_model::estimators::{ELEMENTS, EstimatorId};
use finray_model::finger::{FingerDescription, Part, Zone};
use finray_model::measurement::Measurement;
use finray_model::sensor::SensorOptions;
use finray_model::{Finger, Kinematics, Mesh, NodeId, Scene};
use finray_numerics::optimise::{Convergence, FromFunction, LevenbergMarquardt, Refusal, covariance};
use finray_studies::sampling::scatter::{ScatterRequest, ScatterRow, scatter};
use finray_studies::settings::ONE_FORCE_N;
use finray_studies::truths::{MeshTruth, Truth, TruthId, TwinError, fine_mesh, twin_of};
use finray_tests::{
    CAMERA_NOISE_MM, assert_recorded, assert_said, at_node, finger_of, is_full_study, noisy, paper, random_stream,
};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Length of a plate member of the paper's finger, mm.
const MEMBER_MM: f64 = 12.75;
/// Mean of sensed / true - 1 at each node of Table I, and its tolerance. At nodes 14, 16 and 24 the paper's errors scatter by about 5 percentage
/// points. At nodes 18 to 22 the signs are not published, so the target is 0.
const TARGETS: [(f64, f64); 6] = [(0.563, 0.02), (0.121, 0.02), (0.0, 0.03), (0.0, 0.03), (0.0, 0.03), (0.200, 0.02)];
/// Tolerance of the calibrated modulus relative to the published modulus; small, because equality is required.
const MODULUS_TOLERANCE: f64 = 1e-3;
/// Step of ln(factor) for finite differences; the computed errors of Table I are smooth to nine digits.
const DIFFERENCE: f64 = 1e-4;
/// Nodes loaded by weights for the calibration of the zones: the nodes of Table I and of the paper's calibration.
const LOADED: [usize; 9] = [14, 16, 17, 18, 19, 20, 21, 22, 24];
/// Tolerance of the mean relative error at a node with known zones: 10 % above the Cramer-Rao bound at the worst node (24).
const SENSED: f64 = 0.013;
/// Tolerance of (rms error / sigma) - 1 over 10 repetitions and 4 parameters: four standard errors.
const COVERED: f64 = 0.45;

/// Part of the finger, start and end along it from the base in member lengths.
type Section = (Part, f64, f64);
/// Name of a set of zones, and its groups of zones that share a factor, each with the factor at which its fit starts.
type ZoneSet<'s> = (&'static str, Vec<(&'s [Section], f64)>);

const BASE: &[Section] = &[(Part::Front, 0.0, 1.0), (Part::Back, 0.0, 1.0)];
const NEXT: &[Section] = &[(Part::Front, 8.0, 10.0), (Part::Back, 8.0, 10.0)];
const TIP: &[Section] = &[(Part::Front, 10.0, 12.0), (Part::Back, 10.0, 12.0)];
const FRONT_BASE: &[Section] = &[(Part::Front, 0.0, 1.0)];
const BACK_BASE: &[Section] = &[(Part::Back, 0.0, 1.0)];
const TWO_AT_BASE: &[Section] = &[(Part::Front, 0.0, 2.0), (Part::Back, 0.0, 2.0)];
const RIBS: &[Section] = &[(Part::Ribs, 7.9, 12.0)];
const FOUR_AT_TIP: &[Section] = &[(Part::Front, 8.0, 12.0), (Part::Back, 8.0, 12.0)];

/// The twin's zones, then alternative sets.
fn sets() -> [ZoneSet<'static>; 7] {
    [
        ("base, before the tip, tip (drawn here)", vec![(BASE, 0.72), (NEXT, 0.153), (TIP, 0.064)]),
        (
            "base of the front plate alone, members before the tip, tip",
            vec![(FRONT_BASE, 0.55), (NEXT, 0.155), (TIP, 0.062)],
        ),
        (
            "base of the back plate alone, members before the tip, tip",
            vec![(BACK_BASE, 0.35), (NEXT, 0.165), (TIP, 0.062)],
        ),
        (
            "two members at the base, members before the tip, tip",
            vec![(TWO_AT_BASE, 0.71), (NEXT, 0.153), (TIP, 0.064)],
        ),
        ("base, ribs before the tip, tip", vec![(BASE, 0.7), (RIBS, 0.28), (TIP, 0.051)]),
        ("base, four members of tip alike", vec![(BASE, 0.72), (FOUR_AT_TIP, 0.117)]),
        ("half a member at the base of the front plate", vec![(&[(Part::Front, 0.0, 0.5)], 0.014)]),
    ]
}

#[derive(Debug, Serialize, Deserialize)]
struct Fitted {
    zones: String,
    group: usize,
    factor: f64,
    sigma: f64,
    misfit: f64,
    modulus_factor: f64,
}

/// The paper's finger with the factors of a set's zones, and with all moduli multiplied by the last number.
fn with_factors((_, groups): &ZoneSet, numbers: &[f64]) -> Finger {
    let zones = groups.iter().zip(numbers).flat_map(|((sections, _), &modulus_factor)| {
        sections.iter().map(move |&(part, from, to)| Zone {
            part,
            from_mm: from * MEMBER_MM,
            to_mm: to * MEMBER_MM,
            modulus_factor,
        })
    });
    let zoned = FingerDescription { zones: zones.collect(), ..paper().description().clone() };
    Finger::new(zoned).and_then(|finger| finger.with_modulus_factor(numbers[groups.len()])).expect("a finger")
}

/// Fits the logarithms of a set's factors and of the modulus on the co-rotational finger with four elements per member.
fn fit(set: &ZoneSet) -> (Finger, Vec<Fitted>) {
    let numbers = |logs: &DVector<f64>| logs.iter().map(|log| log.exp()).collect::<Vec<_>>();
    let residual = |logs: &DVector<f64>| {
        let mesh = Mesh::with_elements_per_member(&with_factors(set, &numbers(logs)), ELEMENTS);
        let truth = MeshTruth::new(TruthId::Twin, &mesh, Kinematics::Corotational).expect("a finger");
        let table = table_one(&paper(), &truth, 0.0, &WEIGHTS_N);
        let means = table.errors.iter().map(|errors| errors.iter().sum::<f64>() / errors.len() as f64);
        let off = means.zip(TARGETS).map(|(mean, (target, tolerance))| (mean - target) / tolerance);
        DVector::from_vec(off.chain([(table.modulus_factor - 1.0) / MODULUS_TOLERANCE]).collect())
    };
    let linearised = |logs: &DVector<f64>| -> Result<(DVector<f64>, DMatrix<f64>), Refusal<()>> {
        let here = residual(logs);
        let column = |k: usize| {
            let mut moved = logs.clone();
            moved[k] += DIFFERENCE;
            (residual(&moved) - &here) / DIFFERENCE
        };
        let columns: Vec<_> = (0..logs.len()).map(column).collect();
        Ok((here, DMatrix::from_columns(&columns)))
    };
    let start: Vec<f64> = set.1.iter().map(|(_, start)| start.ln()).chain([0.0]).collect();
    let convergence = Convergence { step: 1e-7, ..Convergence::default() };
    let method = LevenbergMarquardt { convergence, most_steps: 40, ..LevenbergMarquardt::default() };
    let found = method.minimise(&mut FromFunction::new(linearised), DVector::from_vec(start)).expect("a fit");
    let (here, jacobian) = linearised(&found.point).expect("a fit");
    let (numbers, covariance) = (numbers(&found.point), covariance(&jacobian).expect("identifiable"));
    let misfit = (here.norm_squared() / TARGETS.len() as f64).sqrt();
    let group = |k: usize| Fitted {
        zones: set.0.to_owned(),
        group: k + 1,
        factor: numbers[k],
        sigma: numbers[k] * covariance[(k, k)].sqrt(),
        misfit,
        modulus_factor: numbers[set.1.len()],
    };
    (with_factors(set, &numbers), (0..set.1.len()).map(group).collect())
}

/// The shipped twin is the fit's finger, to the four digits of its scene. Other sets of zones fit Table I as well.
#[test]
fn the_twin_is_what_the_fit_finds() {
    let (all, twin) = (sets(), finger_of(TWIN_SCENE));
    let (finger, mut rows) = fit(&all[0]);
    let (ours, shipped) = (finger.description(), twin.description());
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-3, "{a} against {b}: {ours:?}");
    close(ours.front.youngs_modulus_mpa, shipped.front.youngs_modulus_mpa);
    assert_eq!(ours.zones.len(), shipped.zones.len());
    for (a, b) in ours.zones.iter().zip(&shipped.zones) {
        assert_eq!((a.part, a.from_mm, a.to_mm), (b.part, b.from_mm, b.to_mm));
        close(a.modulus_factor, b.modulus_factor);
    }
    let own = rows[0].misfit;
    if is_full_study() {
        rows.extend(all[1..].iter().flat_map(|set| fit(set).1));
        let fits: Vec<f64> = rows.iter().filter(|row| row.group == 1).map(|row| row.misfit).skip(1).collect();
        let below = |limit: f64| fits.iter().filter(|misfit| **misfit < limit).count();
        let table = on_twin(&twin).0;
        let moduli: Vec<f64> =
            shipped.zones.iter().map(|zone| zone.modulus_factor * shipped.front.youngs_modulus_mpa).collect();
        let mut outside: Vec<String> =
            moduli.iter().filter(|it| !(10.0..=1000.0).contains(*it)).map(|it| format!("{it:.1}")).collect();
        outside.dedup();
        let large = NODES.into_iter().enumerate().filter(|(_, (_, paper))| *paper > 0.1);
        let large = large.map(|(i, (node, paper))| {
            format!("{} at node {node} (paper {})", percent(table.mean_error(i)), percent(paper))
        });
        assert_said(
            "twin",
            "says",
            format!(
                "This is a fit, not a finding: in simulation, the finger with softer ends errs as in Table I ({}). {} parameters are fitted to six means \
                 and the calibrated modulus; of {} other sets of zones, {} fit within the accuracy of Table I, and {} fit better than this set. Zones of \
                 {} MPa lie outside the 10 to 1000 MPa that the paper quotes for TPU. Material, hysteresis and other unpublished properties are not \
                 modelled.",
                joined(large, ", "),
                all[0].1.len() + 1,
                fits.len(),
                below(1.0),
                below(own),
                joined(outside, " and ")
            ),
        );
    }
    let computed: Vec<String> = rows.iter().map(|row| row.zones.clone()).collect();
    let agree = |a: &Fitted, b: &Fitted| same(a.factor, b.factor) && same(a.sigma, b.sigma) && same(a.misfit, b.misfit);
    assert_recorded("twin_zone_sets.csv", |row: &Fitted| computed.contains(&row.zones), rows, agree);
    assert!(own < 1.0, "{own}");
}

/// Table I on the twin, and its modulus from weights at all of [`LOADED`] relative to the modulus from the paper's three nodes.
pub fn on_twin(twin: &Finger) -> (TableOne, f64) {
    let mesh = fine_mesh(twin).expect("a mesh");
    let truth = MeshTruth::new(TruthId::Twin, &mesh, Kinematics::Corotational).expect("a finger");
    let table = table_one(&paper(), &truth, 0.0, &WEIGHTS_N);
    let recalibrated = modulus_factor(&paper(), &truth, 0.0, &WEIGHTS_N, &LOADED) / table.modulus_factor;
    (table, recalibrated)
}

#[derive(Debug, Serialize, Deserialize)]
struct Node {
    node: usize,
    paper_mean_error: Option<f64>,
    uniform_finger: Option<f64>,
    twin: Option<f64>,
    twin_lowest: Option<f64>,
    twin_highest: Option<f64>,
    noisy_uniform_model: Option<f64>,
    noisy_zones_least_squares: Option<f64>,
    noisy_zones_nonlinear: Option<f64>,
    bound: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Calibrated {
    repetition: u64,
    parameter: String,
    found_over_true: f64,
    sigma: f64,
}

/// Calibrates the twin's modulus and zones from shapes under weights with noise; front and back share factors.
fn calibrate(finger: &Finger, truth: &dyn Truth, seed: u64) -> FactorEstimate {
    let mut rng = random_stream(seed, 0);
    let mut cases = Vec::new();
    for contact in LOADED.map(|node| at_node(node, 0.0)) {
        for (shape, weight_n) in truth.shapes(&contact, &WEIGHTS_N).iter().zip(WEIGHTS_N) {
            let measurement = noisy(&Measurement::of_shape(finger, shape), CAMERA_NOISE_MM, &mut rng);
            cases.push(CalibrationCase { load: contact.load(finger, weight_n), measurement });
        }
    }
    let zones = [[0, 1], [2, 3], [4, 5]].map(|zones| UnknownFactor::Zones(zones.to_vec()));
    let unknowns: Vec<_> = std::iter::once(UnknownFactor::Modulus).chain(zones).collect();
    // Averaged over 54 shapes, noise is smaller than the error of a coarse mesh.
    let model = FactorModel { kinematics: Kinematics::Corotational, elements: 12, noise_mm: Some(CAMERA_NOISE_MM) };
    factors(finger, &cases, &unknowns, &model).expect("identifiable")
}

/// Senses random forces at nodes 14 to 24 of the twin with noise: by the uniform linear model, and by linear and nonlinear models with known zones.
fn sense(twin: &Mesh, known: &Finger) -> Vec<ScatterRow> {
    let bound = Mesh::with_elements_per_member(twin.finger(), ELEMENTS);
    let sets: Vec<_> = (14..=24).map(|node| vec![NodeId(node)]).collect();
    let sense = |finger: &Finger, estimators: &[EstimatorId]| {
        let request = ScatterRequest {
            truth: twin,
            kinematics: Kinematics::Corotational,
            model: &bound,
            scene: &Scene::of_finger(finger.clone()).into(),
            noise_levels_mm: &[CAMERA_NOISE_MM],
            cases: 400,
            seed: 1,
        };
        let sensors: Vec<_> = estimators.iter().map(|&estimator| SensorOptions::of(estimator)).collect();
        scatter(&request, &sensors, &sets, ONE_FORCE_N, &|| ()).expect("contact nodes")
    };
    let uniform = sense(&paper(), &[EstimatorId::LeastSquares]);
    let known = sense(known, &[EstimatorId::LeastSquares, EstimatorId::Nonlinear]);
    uniform.into_iter().zip(known.chunks(2)).flat_map(|(one, both)| [&[one], both].concat()).collect()
}

/// Rows of [`sense`] with the zones of the first calibration.
pub fn sensed_with_known_zones() -> Vec<ScatterRow> {
    let twin = finger_of(TWIN_SCENE);
    let mesh = fine_mesh(&twin).expect("a mesh");
    let truth = MeshTruth::new(TruthId::Twin, &mesh, Kinematics::Corotational).expect("a finger");
    sense(&mesh, &calibrate(&twin, &truth, 0).finger)
}

/// The twin's errors have the shading of the paper's table: dark at node 14, grey at nodes 16 and 24, clear at nodes 18 to 22. They hardly depend on
/// the load. Known zones make forces exact up to noise.
#[test]
fn the_twin_is_shaded_as_table_one() {
    let (twin, before) = (finger_of(TWIN_SCENE), uniform().swap_remove(0));
    let (after, _) = on_twin(&twin);
    assert!((after.modulus_factor - 1.0).abs() < 1e-3, "{}", after.modulus_factor);
    for (i, (node, paper)) in NODES.into_iter().enumerate() {
        let ([low, high], mean) = (ends(after.errors[i].iter().copied()), after.mean_error(i));
        let shade = |error: f64| [0.1, 0.25].map(|limit| error > limit);
        assert!(shade(mean) == shade(paper) && (mean - paper).abs() < 0.03, "node {node}: {mean}");
        assert!(high - low < 0.141 && (mean < 0.1 || low > 0.0), "node {node}: {low} to {high}");
    }
    let sensed = is_full_study().then(|| {
        let mesh = fine_mesh(&twin).expect("a mesh");
        let truth = MeshTruth::new(TruthId::Twin, &mesh, Kinematics::Corotational).expect("a finger");
        let found: Vec<FactorEstimate> = (0..10).map(|seed| calibrate(&twin, &truth, seed)).collect();
        let mut squares = Vec::new();
        let rows = (1..).zip(&found).flat_map(|(repetition, found)| {
            (0..found.factors.len()).map(move |i| (repetition, found, i))
        });
        let rows = rows.map(|(repetition, found, i)| {
            squares.push((found.factors[i].ln() / found.relative_sigmas[i]).powi(2));
            let sigma = found.factors[i] * found.relative_sigmas[i];
            Calibrated { repetition, parameter: found.unknowns[i].to_string(), found_over_true: found.factors[i], sigma }
        });
        assert_recorded("twin_calibration.csv", |_| true, rows.collect::<Vec<_>>(), |_, _| true);
        let off = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        assert!((off - 1.0).abs() < COVERED && found[0].entangled().is_empty(), "{off}");
        assert_said(
            "twin",
            "text",
            format!(
                "The command finray calibrate --zones was simulated with {CAMERA_NOISE_MM} mm noise and six weights at each of 9 nodes. In 10 repetitions, \
                 the factors err by {off:.2} stated sigma (root mean square; 1 is expected); no correlation reaches 0.95."
            ),
        );
        sensed_with_known_zones()
    });
    let row = |(k, node): (usize, usize)| {
        let of_table = NODES.iter().position(|(loaded, _)| *loaded == node);
        let noisy = |n: usize| sensed.as_ref().map(|rows| &rows[3 * k + n]);
        let error = |n: usize| noisy(n).and_then(ScatterRow::mean_error);
        assert!(error(2).is_none_or(|error| error < SENSED), "node {node}");
        let range = of_table.map(|i| ends(after.errors[i].iter().copied()));
        Node {
            node,
            paper_mean_error: of_table.map(|i| NODES[i].1),
            uniform_finger: of_table.map(|i| before.mean_error(i)),
            twin: of_table.map(|i| after.mean_error(i)),
            twin_lowest: range.map(|range| range[0]),
            twin_highest: range.map(|range| range[1]),
            noisy_uniform_model: error(0),
            noisy_zones_least_squares: error(1),
            noisy_zones_nonlinear: error(2),
            bound: noisy(2).and_then(ScatterRow::mean_error_bound),
        }
    };
    let figures = |row: &Node| [row.paper_mean_error, row.uniform_finger, row.twin, row.twin_lowest, row.twin_highest];
    let agree = |a: &Node, b: &Node| {
        let pairs = figures(a).into_iter().zip(figures(b));
        a.node == b.node
            && pairs.into_iter().all(|(a, b)| a.is_some() == b.is_some() && a.zip(b).is_none_or(|(a, b)| same(a, b)))
    };
    assert_recorded("twin.csv", |_| true, (14..=24).enumerate().map(row).collect(), agree);
}

#[test]
fn other_fingers_have_no_twin() {
    let other = paper().with_modulus_factor(1.1).expect("a finger");
    assert_eq!(twin_of(&other), Err(TwinError::NotThePapersFinger));
}
