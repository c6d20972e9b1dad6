//! Sensing with an uncertain base and uncertain friction. Stated standard deviations include the uncertainties of base and friction.

use finray_model::measurement::{BaseUncertainty, Marker, Measurement, SharedError};
use finray_model::mesh::MeshLevels;
use finray_model::sensing::{
    Contact, ContactPosition, ContactQuestion, Direction, Estimate, Lean, NearForces, NonlinearEstimator, Normal,
    Refinement, SensingError,
};
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Vector};
use finray_tests::{
    ELEMENTS, TWO_SIDED_95, assert_standardised, at_node, at_position, case_count, finger_of, noisy, seen, share_error,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const NOISE_MM: f64 = 0.02;
/// Rotation of a compliant base in these tests: a tenth of a degree per newton, towards the back of the finger.
const TURN_RAD_PER_N: f64 = -0.002;
/// Uncertainty of the mounting of a rigid base.
const MOUNTED: BaseUncertainty =
    BaseUncertainty { sd_mm: 0.05, sd_rad: 0.001, turn_rad_per_n: 0.0, turn_sd_rad_per_n: 0.0 };
/// Number of forces that are sensed with compliant bases.
fn giving_way() -> usize {
    case_count(120, 200)
}

/// The finger with brackets and clips of 3 mm.
fn bracketed() -> Finger {
    finger_of(finray_fixtures::BRACKETED_SCENE)
}

/// Finds, by iteration, a force that leans by an angle from the normal of the deformed plate. Each iteration applies a dead force, whose direction
/// follows from the shape of the previous iteration.
fn leaning(mesh: &Mesh, node: usize, force_n: f64, lean_deg: f64) -> Result<(Contact, Measurement), StaticsError> {
    let finger = mesh.finger();
    let mut contact = at_node(node, lean_deg);
    let mut statics = Statics::ladder(mesh, Kinematics::Corotational);
    for _ in 0..30 {
        let load = mesh.frame_load(&contact.load(finger, force_n)).expect("on the plate");
        let motion = statics.equilibrium(&[load])?.motion;
        contact.angle_deg = lean_deg + mesh.shape(&motion).motion(NodeId(node)).rotation.to_degrees();
    }
    let load = mesh.frame_load(&contact.load(finger, force_n)).expect("on the plate");
    let motion = statics.equilibrium(&[load])?.motion;
    Ok((contact, Measurement::of_shape(finger, &mesh.shape(&motion))))
}

/// Displacements of the same deformed finger, measured from an assumed base relative to which the true base is moved and rotated.
fn from_another_base(finger: &Finger, seen: &Measurement, moved: Vector, turned_rad: f64) -> Measurement {
    let (sin, cos) = turned_rad.sin_cos();
    let marker = |marker: &Marker| {
        let rest = finger.position(marker.node) + finger.marker_offset(marker.node);
        let at = rest + marker.displacement;
        let seen_at = moved + Vector::new(cos * at.x - sin * at.y, sin * at.x + cos * at.y);
        Marker { displacement: seen_at - rest, ..*marker }
    };
    Measurement::new(finger, seen.markers().iter().map(marker)).expect("the same nodes")
}

/// Without noise, force and pose of the base are recovered exactly, for any pose of the base.
#[test]
fn a_base_that_is_elsewhere_is_found() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let (contact, seen) = leaning(&mesh, 8, 6.0, 0.0).expect("carried");
    let loose = BaseUncertainty { sd_mm: 10.0, sd_rad: 0.3, ..BaseUncertainty::default() };
    // A known direction is stated relative to the base that the measurement assumes.
    let estimate = |measurement: &Measurement, turned_rad: f64| {
        let contact = Contact { angle_deg: contact.angle_deg + turned_rad.to_degrees(), ..contact };
        let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("on the plate");
        estimator.estimate(measurement, Some(1e-6)).map(|found| found.forces)
    };
    for (moved, turned_rad) in [(Vector::new(1.5, -2.0), 0.05), (Vector::new(-0.3, 0.4), -0.02)] {
        let elsewhere = from_another_base(&finger, &seen, moved, turned_rad);
        let found = estimate(&elsewhere.clone().with_base(loose), turned_rad).expect("identifiable");
        assert!((found.forces_n[0] / 6.0 - 1.0).abs() < 1e-5, "{found:?}");
        // If a base at a wrong pose is assumed to be exact, the force has a large error, or the measurement is refused.
        let wrong = estimate(&elsewhere, turned_rad);
        assert!(wrong.is_err() || wrong.is_ok_and(|found| (found.forces_n[0] / 6.0 - 1.0).abs() > 0.05));
    }
}

/// Bases, leans and noise are drawn from their priors; errors are then as large as stated.
#[test]
fn stated_sigmas_hold_what_base_and_friction_leave_open() {
    let cases = case_count(30, 300);
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let mut rng = ChaCha8Rng::seed_from_u64(19);
    let base = BaseUncertainty { sd_mm: 0.1, sd_rad: 0.002, ..BaseUncertainty::default() };
    let lean = Lean::of_friction(0.3, 0.05);
    let question = ContactQuestion::new(None, Direction::Leaning(lean));
    let (mut errors, mut largest) = (Vec::new(), 0.0_f64);
    for _ in 0..cases {
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let lean_deg = lean.angle_deg + lean.sd_deg * normal();
        let moved = Vector::new(normal(), normal()) * base.sd_mm;
        let turned_rad = normal() * base.sd_rad;
        let (node, force_n) = (rng.random_range(8..=9), rng.random_range(1.0..8.0));
        let (_, seen) = leaning(&mesh, node, force_n, lean_deg).expect("carried");
        let seen = noisy(&from_another_base(&finger, &seen, moved, turned_rad), NOISE_MM, &mut rng);
        let mut estimator = NonlinearEstimator::new(&mesh, &[question]).expect("on the plate");
        let Ok(found) = estimator.estimate(&seen.with_base(base), Some(NOISE_MM)) else { continue };
        errors.push((found.forces.forces_n[0] - force_n) / found.forces.sigmas_n[0]);
        largest = largest.max(found.forces.sigmas_n[0] / force_n);
    }
    assert!(errors.len() * 60 >= cases * 59, "{} of {cases} answered", errors.len());
    assert_standardised("sensing::nonlinear::nuisances", &errors);
    assert!(largest > 0.02, "the priors are part of the sigmas: {largest}");
}

/// If the friction lies within a wide range, the markers hardly determine the lean of the force. The standard deviation of the force follows from the
/// forces at both ends of the range of the lean. At one end of the range of the lean, the force differs from the estimate by more than the tangent at
/// the estimate predicts.
#[test]
fn a_wide_range_of_friction_widens_by_its_ends() {
    // A stated noise so large that the markers do not constrain the lean.
    const STATED_MM: f64 = 0.2;
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let lean = Lean { from: Normal::Undeformed, ..Lean::within([0.0, 0.5]) };
    let mut largest = 0.0_f64;
    for (s_mm, force_n) in [(66.0, 3.0), (80.0, 5.0), (55.0, 2.0)] {
        let bent = seen(&mesh, &[at_position(s_mm, lean.angle_deg)], &[force_n], Kinematics::Corotational);
        let bent = bent.expect("carried");
        let sensed = |lean: Lean| {
            let question = ContactQuestion::new(None, Direction::Leaning(lean));
            let mut estimator = NonlinearEstimator::new(&mesh, &[question]).expect("on the plate");
            estimator.estimate(&bent, Some(STATED_MM)).expect("identifiable").forces
        };
        let held = |further_sd: f64| {
            sensed(Lean { angle_deg: lean.angle_deg + further_sd * lean.sd_deg, sd_deg: 0.0, ..lean })
        };
        let root3 = 3.0_f64.sqrt();
        let off_n = [-root3, root3].map(|end| held(end).forces_n[0] - force_n);
        let by_ends_n = ((off_n[0].powi(2) + off_n[1].powi(2)) / 6.0).sqrt();
        let step = 0.01;
        let by_tangent_n = (held(step).forces_n[0] - held(-step).forces_n[0]) / (2.0 * step);
        let noise_n = held(0.0).sigmas_n[0];
        let stated_n = sensed(lean).sigmas_n[0];
        assert!((stated_n / noise_n.hypot(by_ends_n) - 1.0).abs() < 0.02, "{stated_n}, {noise_n} and {by_ends_n}");
        largest = largest.max(by_ends_n / by_tangent_n.abs());
    }
    assert!(largest > 1.1, "{largest}");
}

/// If friction builds up with the force by the stated law, the force is recovered exactly, with the lean measured from the undeformed or the deformed
/// normal.
#[test]
fn friction_that_builds_up_is_followed() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    for (force_n, from) in
        [(0.8, Normal::Deformed { over_mm: 0.0 }), (5.0, Normal::Deformed { over_mm: 0.0 }), (5.0, Normal::Undeformed)]
    {
        let lean = Lean { build_up_n: 2.0, from, ..Lean::of_friction(0.4, 0.0) };
        let lean_deg = 0.4_f64.atan().to_degrees() * (1.0 - (-force_n / 2.0_f64).exp());
        let seen = match from {
            Normal::Deformed { .. } => leaning(&mesh, 9, force_n, lean_deg).expect("carried").1,
            Normal::Undeformed | Normal::Object => {
                seen(&mesh, &[at_node(9, lean_deg)], &[force_n], Kinematics::Corotational).expect("carried")
            }
        };
        let question = ContactQuestion::new(None, Direction::Leaning(lean));
        let mut estimator = NonlinearEstimator::new(&mesh, &[question]).expect("on the plate");
        let found = estimator.estimate(&seen, Some(1e-5)).expect("identifiable");
        assert!((found.forces.forces_n[0] / force_n - 1.0).abs() < 1e-4, "{force_n} N: {found:?}");
    }
}

/// Results of many estimates: share of intervals that contain the true force, mean square of the relative error, and mean of the relative stated
/// standard deviation.
#[derive(Debug, Clone, Copy, Default)]
struct Sensed {
    within: f64,
    square: f64,
    sigma: f64,
}

/// Senses forces with friction on bases without reference marks, once with each uncertainty of the base in `stated`. The mounting error of the true
/// base is drawn with the standard deviations of the first entry of `stated`. The true base also rotates by the force times `turn_rad_per_n`. This
/// compliance is drawn for each case with the standard deviation `turn_sd_rad_per_n`.
fn sensed_from_bases_that_give_way(turn_sd_rad_per_n: f64, stated: [BaseUncertainty; 2]) -> [Sensed; 2] {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let lean = Lean::of_friction(0.3, 0.1);
    let question = ContactQuestion::new(None, Direction::Leaning(lean));
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    let mut all = [Sensed::default(); 2];
    for _ in 0..giving_way() {
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let lean_deg = lean.angle_deg + lean.sd_deg * normal();
        let moved = Vector::new(normal(), normal()) * stated[0].sd_mm;
        let by_chance_rad = normal() * stated[0].sd_rad;
        let turn_rad_per_n = TURN_RAD_PER_N + turn_sd_rad_per_n * normal();
        let force_n = rng.random_range(3.0..9.0);
        let (_, seen) = leaning(&mesh, 8, force_n, lean_deg).expect("carried");
        let turned_rad = turn_rad_per_n * force_n + by_chance_rad;
        let seen = noisy(&from_another_base(&finger, &seen, moved, turned_rad), NOISE_MM, &mut rng);
        for (sensed, base) in all.iter_mut().zip(stated) {
            let mut estimator = NonlinearEstimator::new(&mesh, &[question]).expect("on the plate");
            let Ok(found) = estimator.estimate(&seen.clone().with_base(base), Some(NOISE_MM)) else {
                continue;
            };
            let error_n = found.forces.forces_n[0] - force_n;
            let is_within = error_n.abs() <= TWO_SIDED_95 * found.forces.sigmas_n[0];
            let count = giving_way() as f64;
            sensed.within += f64::from(u8::from(is_within)) / count;
            sensed.square += (error_n / force_n).powi(2) / count;
            sensed.sigma += found.forces.sigmas_n[0] / force_n / count;
        }
    }
    all
}

/// A compliant base without reference marks. If the expected rotation of the base is the force times the base's compliance, the rotation provides
/// information on the force. If the expected rotation of the base is zero, the markers contradict it: intervals widen, and errors of the force grow.
#[test]
fn a_base_that_gives_way_is_expected_to_turn() {
    let yields = BaseUncertainty { turn_rad_per_n: TURN_RAD_PER_N, ..MOUNTED };
    let [expected, not] = sensed_from_bases_that_give_way(0.0, [yields, MOUNTED]);
    assert!((expected.within - 0.95).abs() <= 3.0 * share_error(0.95, giving_way()), "{expected:?}");
    assert!(not.square > 1.5 * expected.square && not.sigma > 2.0 * expected.sigma, "{expected:?}, {not:?}");
}

/// If the standard deviation of the base's uncertain compliance is stated, intervals contain the force as often as stated. If the uncertain
/// compliance of the base is assumed to be exact, errors are larger and intervals too narrow.
#[test]
fn a_compliance_that_is_not_quite_known_is_in_the_interval() {
    const SHARE: f64 = 0.3;
    let exact = BaseUncertainty { turn_rad_per_n: TURN_RAD_PER_N, ..MOUNTED };
    let turn_sd_rad_per_n = SHARE * TURN_RAD_PER_N.abs();
    let known = BaseUncertainty { turn_sd_rad_per_n, ..exact };
    let [known, exact] = sensed_from_bases_that_give_way(turn_sd_rad_per_n, [known, exact]);
    let chance = 3.0 * share_error(0.95, giving_way());
    assert!((known.within - 0.95).abs() <= chance, "{known:?}");
    assert!(exact.within < 0.95 - chance && exact.square > known.square, "{known:?}, {exact:?}");
}

/// Without a noise of the measurement, the weight of a prior is undefined.
#[test]
fn priors_need_a_noise() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let contact = at_node(9, 0.0);
    let base = BaseUncertainty { sd_mm: 0.1, sd_rad: 0.002, ..BaseUncertainty::default() };
    let measurement = Measurement::at_rest(&finger).with_base(base);
    let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("a contact node");
    assert_eq!(estimator.estimate(&measurement, None), Err(SensingError::NoiseNotStated));
}

/// The error of the base's assumed pose may exceed the deflection of the finger, for example for a small force on a newly mounted finger.
#[test]
fn bases_far_off_are_found() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let base = BaseUncertainty { sd_mm: 3.0, sd_rad: 0.06, ..BaseUncertainty::default() };
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut within = |from: f64, to: f64| rng.random_range(from..to);
    for _ in 0..100 {
        let contact = Contact { position: ContactPosition::at(within(45.0, 95.0)), angle_deg: within(0.0, 25.0) };
        let force_n = within(1.0, 4.0);
        let clean = seen(&mesh, &[contact], &[force_n], Kinematics::Corotational).expect("carried");
        let (moved, turned_rad) = (Vector::new(within(-5.0, 5.0), within(-5.0, 5.0)), within(-0.1, 0.1));
        let elsewhere = from_another_base(&finger, &clean, moved, turned_rad).with_base(base);
        let direction = Direction::Angle(contact.angle_deg + turned_rad.to_degrees());
        let mut estimator =
            NonlinearEstimator::new(&mesh, &[ContactQuestion::new(None, direction)]).expect("on the plate");
        let found = estimator.estimate(&elsewhere, Some(0.01)).map(|found| found.forces);
        let is_right = |found: &Estimate| (found.forces_n[0] - force_n).abs() < TWO_SIDED_95 * found.sigmas_n[0];
        assert!(found.as_ref().is_ok_and(is_right), "{contact:?}, {force_n} N, {moved} {turned_rad}: {found:?}");
    }
}

/// The square of the stated standard deviation is the sum of the squared responses of the force to the noise of each coordinate.
#[test]
fn sigmas_are_responses_to_noise() {
    // The base is so uncertain that its prior does not contribute to the standard deviation of the force.
    let loose = BaseUncertainty { sd_mm: 100.0, sd_rad: 1.0, ..BaseUncertainty::default() };
    responses_of(loose, 0.0);
    // A base that rotates by exactly its compliance times the force acts as a second force sensor. The prior of a base with exactly known compliance
    // contributes equally little to the standard deviation of the force.
    responses_of(BaseUncertainty { sd_rad: 1e-7, turn_rad_per_n: TURN_RAD_PER_N, ..loose }, TURN_RAD_PER_N * 8.0);
}

/// Senses 8 N with a rotated base, and compares the stated standard deviation with the responses of the force to noise.
fn responses_of(base: BaseUncertainty, turned_rad: f64) {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let contact = Contact { position: ContactPosition::at(70.0), angle_deg: 15.0 };
    let clean = seen(&mesh, &[contact], &[8.0], Kinematics::Corotational).expect("carried");
    let clean = from_another_base(&finger, &clean, Vector::zeros(), turned_rad);
    let direction = Direction::Angle(contact.angle_deg + turned_rad.to_degrees());
    let question = ContactQuestion::new(None, direction);
    let mut estimator = NonlinearEstimator::new(&mesh, &[question]).expect("on the plate");
    let (noise_mm, step_mm) = (1e-3, 1e-4);
    let mut sensed = |moved: Option<(NodeId, Vector)>| {
        let marker = |marker: &Marker| match moved {
            Some((node, by)) if node == marker.node => Marker { displacement: marker.displacement + by, ..*marker },
            _ => *marker,
        };
        let measurement = Measurement::new(&finger, clean.markers().iter().map(marker)).expect("the same nodes");
        let found = estimator.estimate(&measurement.with_base(base), Some(noise_mm));
        found.expect("identifiable").forces
    };
    let Estimate { forces_n, sigmas_n, .. } = sensed(None);
    assert!((forces_n[0] / 8.0 - 1.0).abs() < 1e-5, "{forces_n:?}");
    let stated = sigmas_n[0];
    let mut variance = 0.0;
    for marker in clean.markers() {
        for way in [Vector::x(), Vector::y()] {
            let [plus, minus] = [step_mm, -step_mm].map(|step| sensed(Some((marker.node, way * step))).forces_n[0]);
            variance += ((plus - minus) / (2.0 * step_mm) * noise_mm).powi(2);
        }
    }
    let responses = variance.sqrt();
    // The responses are central differences of forces that have converged to a hundredth of their standard deviation.
    assert!((stated / responses - 1.0).abs() < 0.01, "stated {stated} N, responses {responses} N");
}

/// Exact markers outweigh every prior, so a prior then counts neither as a measured coordinate nor as a degree of freedom. With ten degrees of
/// freedom, half a 95 % interval is 2.2281 residual standard deviations (Student's t distribution), and 1.96 trusted ones.
#[test]
fn priors_do_not_count_without_noise() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let (contact, seen) = leaning(&mesh, 8, 6.0, 0.0).expect("carried");
    let seen = noisy(&seen, NOISE_MM, &mut ChaCha8Rng::seed_from_u64(21)).with_base(MOUNTED);
    let estimate = |markers: usize| {
        let hidden: Vec<NodeId> = seen.markers().iter().skip(markers).map(|marker| marker.node).collect();
        let mut estimator = NonlinearEstimator::new(&mesh, &[contact.into()]).expect("on the plate");
        estimator.estimate(&seen.clone().without(&hidden), Some(0.0)).map(|found| found.forces)
    };
    assert_eq!(estimate(1), Err(SensingError::TooFewMarkers { unknowns: 4, coordinates: 2 }));
    let found = estimate(7).expect("identifiable");
    let residual_sd_mm = found.residual_rms_mm * (14.0_f64 / 10.0).sqrt();
    assert!((found.trusted_noise_mm / residual_sd_mm / (2.228_139 / 1.959_964) - 1.0).abs() < 1e-5, "{found:?}");
}

/// From one frame of a stream to the next, an uncertain base becomes exact and as many errors that all markers share become uncertain, or the
/// reverse. The shapes of the frame before belong to other unknowns, and do not change the estimate.
#[test]
fn shapes_for_other_unknowns_of_the_same_number_are_not_used() {
    let finger = bracketed();
    let mesh = Mesh::with_elements_per_member(&finger, ELEMENTS);
    let (contact, seen) = leaning(&mesh, 8, 6.0, 0.0).expect("carried");
    let base = BaseUncertainty { sd_mm: 0.5, sd_rad: 0.01, ..BaseUncertainty::default() };
    let seen = from_another_base(&finger, &seen, Vector::new(0.4, -0.3), 0.006);
    let seen = noisy(&seen, NOISE_MM, &mut ChaCha8Rng::seed_from_u64(22));
    // To first order, the shared errors are the three motions of the base.
    let positions: Vec<Vector> =
        (1..=finger.key_node_count()).map(|node| finger.marker_position(NodeId(node))).collect();
    let pattern = |of: &dyn Fn(&Vector) -> Vector| SharedError {
        pattern_mm: positions.iter().map(of).collect(),
        plate: Vec::new(),
        start: 0.0,
    };
    let errors = vec![
        pattern(&|_| Vector::new(base.sd_mm, 0.0)),
        pattern(&|_| Vector::new(0.0, base.sd_mm)),
        pattern(&|at| Vector::new(-at.y, at.x) * base.sd_rad),
    ];
    let of_base = seen.clone().with_base(base);
    let of_errors = seen.with_shared_errors(errors);
    for [first, second] in [[&of_base, &of_errors], [&of_errors, &of_base]] {
        let refinement = || Refinement::new(MeshLevels::new(&finger), &[contact.into()]);
        let mut stream = refinement();
        let before = stream.sense(None, first, Some(NOISE_MM), None).expect("identifiable");
        let near = NearForces { contacts: &before.contacts, forces_n: &before.forces.forces_n, shape: None };
        assert!(stream.keeps(near));
        let [found, alone] = [stream, refinement()].map(|mut refinement| {
            refinement.sense(None, second, Some(NOISE_MM), Some(near)).expect("identifiable").forces
        });
        let off = (found.forces_n[0] - alone.forces_n[0]) / alone.sigmas_n[0];
        assert!(off.abs() < 1e-3 && (found.sigmas_n[0] / alone.sigmas_n[0] - 1.0).abs() < 1e-3, "{found:?} {alone:?}");
        assert!((alone.forces_n[0] - 6.0).abs() < 4.0 * alone.sigmas_n[0], "{alone:?}");
    }
}
