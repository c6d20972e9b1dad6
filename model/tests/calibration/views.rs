//! Calibration of a finger and its rig from several images: deviations from the scene are recovered within the stated standard deviations.

use finray_model::calibration::{
    CalibrationError, FrictionQuestion, MeasuredLean, Quantity, Sought, View, ViewError, ViewEstimate, ViewModel,
    compliance_of, friction_of, refined_views, views,
};
use finray_model::finger::{BracketLengths, FingerDescription, Plate, RibPositions};
use finray_model::measurement::{BaseUncertainty, Marker, Measurement};
use finray_model::sensing::{Lean, Normal};
use finray_model::{Finger, Kinematics, Vector};
use finray_tests::{at_position, finger_of, noisy, paper, seen};
use nalgebra::{Isometry2, Point2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Elements per member of both truth and model, so that the mesh causes no error. The time of the tests is proportional to this number.
const ELEMENTS: usize = 1;
const NOISE_MM: f64 = 0.01;
const BASE: BaseUncertainty =
    BaseUncertainty { sd_mm: 0.05, sd_rad: 0.001, turn_rad_per_n: 0.0, turn_sd_rad_per_n: 0.0 };
const EYE: Vector = Vector::new(70.0, 10.0);
const CAMERA_HEIGHT_MM: f64 = 250.0;
/// Position along the plate, force, and angle of the force from the undeformed normal.
const PRESSES: [(f64, f64, f64); 5] =
    [(60.0, 1.5, 5.0), (70.0, 3.0, 12.0), (72.0, 5.0, 15.0), (90.0, 6.0, 10.0), (50.0, 4.0, -5.0)];

/// Differences of the true finger and rig from the scene.
struct Truth {
    /// The finger of the scene.
    stated: Finger,
    finger: Finger,
    modulus_factor: f64,
    more_height_mm: f64,
    base: Isometry2<f64>,
}

fn scene_finger() -> Finger {
    finger_of(finray_fixtures::BRACKETED_SCENE)
}

fn truth() -> Truth {
    let mut description = scene_finger().description().clone();
    let modulus_factor = 0.92;
    description.front.youngs_modulus_mpa *= modulus_factor;
    description.back.youngs_modulus_mpa *= modulus_factor;
    description.ribs.bracket_mm = BracketLengths::Alike([3.3, 2.8]);
    if let RibPositions::Positions(positions) = &mut description.ribs.positions {
        positions[1][0] += 0.25;
        positions[2][1] -= 0.2;
    }
    let finger = Finger::new(description).expect("a possible finger");
    let base = Isometry2::new(Vector::new(0.8, -0.5), 0.01);
    Truth { stated: scene_finger(), finger, modulus_factor, more_height_mm: 1.5, base }
}

/// Views of the true finger and rig; markers are located as if the rig were the rig of the scene. Each view has its own base.
fn views_of(truth: &Truth, forces: bool, rng: &mut ChaCha8Rng) -> Vec<View> {
    views_at(&PRESSES, truth, forces, rng)
}

fn views_at(presses: &[(f64, f64, f64)], truth: &Truth, forces: bool, rng: &mut ChaCha8Rng) -> Vec<View> {
    views_on(ELEMENTS, presses, truth, forces, rng)
}

/// Views as of `views_of`, for a true finger with `elements` per member.
fn views_on(
    elements: usize,
    presses: &[(f64, f64, f64)],
    truth: &Truth,
    forces: bool,
    rng: &mut ChaCha8Rng,
) -> Vec<View> {
    let stated = truth.stated.clone();
    let mesh = finray_model::Mesh::with_elements_per_member(&truth.finger, elements);
    let mut view = |&(s_mm, force_n, angle_deg): &(f64, f64, f64)| {
        let contact = at_position(s_mm, angle_deg);
        let bent = seen(&mesh, &[contact], &[force_n], Kinematics::Corotational).expect("carried");
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let own = Isometry2::new(Vector::new(normal(), normal()) * BASE.sd_mm, normal() * BASE.sd_rad);
        let placed = truth.base * own;
        let marker = |marker: &Marker| {
            let at = truth.finger.position(marker.node) + truth.finger.marker_offset(marker.node) + marker.displacement;
            let at = (placed * Point2::from(at)).coords;
            // Higher markers appear farther from the point in the plane below the camera.
            let seen_at = EYE + (at - EYE) * (CAMERA_HEIGHT_MM / (CAMERA_HEIGHT_MM - truth.more_height_mm));
            let displacement = seen_at - stated.position(marker.node) - stated.marker_offset(marker.node);
            Marker { displacement, ..*marker }
        };
        let measurement = Measurement::new(&stated, bent.markers().iter().map(marker)).expect("the same nodes");
        let force = placed.rotation * (truth.finger.direction(angle_deg) * force_n);
        View {
            name: format!("press at {s_mm} mm"),
            measurement: noisy(&measurement, NOISE_MM, rng),
            noise_mm: NOISE_MM,
            base: BASE,
            eye: EYE,
            force: forces.then_some(force),
            position: None,
        }
    };
    presses.iter().map(&mut view).collect()
}

fn sought(quantities: &[Quantity], prior_sd: Option<f64>) -> Vec<Sought> {
    quantities.iter().map(|&quantity| Sought { quantity, prior_sd }).collect()
}

fn model(lean: Lean) -> ViewModel {
    ViewModel {
        elements: ELEMENTS,
        camera_height_mm: CAMERA_HEIGHT_MM,
        marker_height_mm: 0.0,
        lean,
        pad: None,
        preload_nmm: 0.0,
        model_error: 0.0,
    }
}

fn ribs() -> Vec<Quantity> {
    let on = |plate| (0..4).map(move |rib| Quantity::RibPosition(plate, rib));
    on(Plate::Front).chain(on(Plate::Back)).collect()
}

fn true_value(truth: &Truth, quantity: Quantity) -> f64 {
    let RibPositions::Positions(positions) = &truth.finger.description().ribs.positions else { return f64::NAN };
    let brackets = truth.finger.description().ribs.bracket_mm.of(0);
    let index = |plate: Plate| usize::from(plate == Plate::Back);
    match quantity {
        Quantity::Modulus => truth.modulus_factor,
        Quantity::Bracket(plate) => brackets[index(plate)],
        Quantity::PlateClip(plate) => truth.finger.description().ribs.clip_mm[index(plate)],
        Quantity::RibPosition(plate, rib) => positions[rib][index(plate)],
        Quantity::MarkerHeight => truth.more_height_mm,
        Quantity::BaseX => truth.base.translation.x,
        Quantity::BaseY => truth.base.translation.y,
        Quantity::BaseTurn => truth.base.rotation.angle().to_degrees(),
        other => panic!("{other} was not changed"),
    }
}

/// Squares of the errors, each divided by its stated standard deviation.
fn squares(truth: &Truth, estimate: &ViewEstimate) -> Vec<f64> {
    // If forces lean independently, a shared lean has no true value.
    let quantities = estimate.quantities.iter().filter(|found| found.sought.quantity != Quantity::Lean);
    quantities.map(|found| ((found.value - true_value(truth, found.sought.quantity)) / found.sigma).powi(2)).collect()
}

/// The fit finds the true noise of the markers, whatever noise is stated. If the true noise is larger than stated, the excess counts as error of the
/// finger. Averaged over several sets of views, the mean square of the found noise is correct, because the estimate accounts for the fitted
/// parameters.
#[test]
fn what_markers_err_by_is_found() {
    const SETS: u64 = 8;
    let truth = truth();
    let known = sought(&[Quantity::Modulus, Quantity::MarkerHeight], None);
    let known = [known, sought(&ribs(), Some(0.2))].concat();
    for stated_mm in [2.0 * NOISE_MM, 0.5 * NOISE_MM] {
        let sets = (0..SETS).map(|seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
            let mut seen = views_of(&truth, true, &mut rng);
            seen.iter_mut().for_each(|view| view.noise_mm = stated_mm);
            let brackets = sought(&[Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)], None);
            let base = sought(&[Quantity::BaseX, Quantity::BaseY, Quantity::BaseTurn], None);
            let all = [&known[..], &brackets, &base].concat();
            let found = views(&scene_finger(), &seen, &all, &model(Lean::NONE)).expect("identifiable");
            found.marker_errors
        });
        let found: Vec<_> = sets.collect();
        let mean_mm2 = found.iter().map(|errors| errors.sd_mm(stated_mm).powi(2)).sum::<f64>() / SETS as f64;
        assert!((mean_mm2.sqrt() / NOISE_MM - 1.0).abs() < 0.1, "stated {stated_mm}: {found:?}");
        let only_noise = found.iter().all(|errors| errors.calibration_error_mm == 0.0 && errors.noise_factor < 1.0);
        let only_finger = found.iter().all(|errors| errors.calibration_error_mm > 0.0 && errors.noise_factor == 1.0);
        assert!(if stated_mm > NOISE_MM { only_noise } else { only_finger }, "stated {stated_mm}: {found:?}");
    }
}

/// If forces are measured, the fit finds modulus, brackets, ribs, height and base together. The found values have the stated accuracy and are far
/// more accurate than the scene's values.
#[test]
fn a_finger_and_its_rig_are_found() {
    let truth = truth();
    let mut all = sought(
        &[
            Quantity::Modulus,
            Quantity::Bracket(Plate::Front),
            Quantity::Bracket(Plate::Back),
            Quantity::MarkerHeight,
            Quantity::BaseX,
            Quantity::BaseY,
            Quantity::BaseTurn,
        ],
        None,
    );
    all.extend(sought(&ribs(), Some(0.2)));
    let mut sum = Vec::new();
    for seed in 0..3 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let seen = views_of(&truth, true, &mut rng);
        let estimate = views(&scene_finger(), &seen, &all, &model(Lean::NONE)).expect("identifiable");
        let modulus = estimate.quantities[0];
        assert!((modulus.value / truth.modulus_factor - 1.0).abs() < 0.01, "{modulus:?}");
        assert!(modulus.sigma < 0.005, "{modulus:?}");
        // The residual contains only noise.
        assert!(estimate.marker_errors.calibration_error_mm < NOISE_MM, "{:?}", estimate.marker_errors);
        for (view, (s_mm, force_n, angle_deg)) in estimate.views.iter().zip(PRESSES) {
            assert!((view.s_mm - s_mm).abs() < 1.0, "{view:?}");
            assert!((view.force.norm() / force_n - 1.0).abs() < 1e-12);
            assert!((view.lean_deg(&estimate.finger, Normal::Undeformed) - angle_deg).abs() < 0.3, "{view:?}");
        }
        sum.extend(squares(&truth, &estimate));
    }
    assert!(sum.iter().all(|square| *square < 16.0), "{sum:?}");
    // Errors of one calibration are correlated: 45 errors count as about half as many independent errors.
    let mean = sum.iter().sum::<f64>() / sum.len() as f64;
    assert!((0.4..1.9).contains(&mean), "mean square {mean}");
}

/// Clips stiffen each plate at the ribs. If forces are measured, the fit finds the lengths of the clips together with a modulus, with the stated
/// accuracy.
#[test]
fn clips_of_each_plate_are_found() {
    let with_clips = |finger: &Finger, clip_mm: [f64; 2]| {
        let mut description = finger.description().clone();
        description.ribs.clip_mm = clip_mm;
        Finger::new(description).expect("a possible finger")
    };
    let mut truth = truth();
    (truth.stated, truth.finger) = (with_clips(&truth.stated, [5.0; 2]), with_clips(&truth.finger, [5.8, 4.3]));
    (truth.more_height_mm, truth.base) = (0.0, Isometry2::identity());
    let clips = [Quantity::PlateClip(Plate::Front), Quantity::PlateClip(Plate::Back)];
    let brackets = [Quantity::Modulus, Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)];
    let all = [sought(&clips, Some(1.0)), sought(&brackets, None), sought(&ribs(), Some(0.2))].concat();
    let mut sum = Vec::new();
    for seed in 0..3 {
        let mut rng = ChaCha8Rng::seed_from_u64(30 + seed);
        let seen = views_of(&truth, true, &mut rng);
        let estimate = views(&truth.stated, &seen, &all, &model(Lean::NONE)).expect("identifiable");
        // The scene states the lengths of the clips only to 1 mm. The back plate carries less force, so the lengths of its clips are found less
        // accurately.
        let [front, back] = [0, 1].map(|i| estimate.quantities[i].sigma);
        assert!(front < 0.4 && back < 0.7, "{:?}", estimate.quantities);
        assert_eq!(estimate.quantities[0].sought.quantity.to_string(), "front_clip_mm");
        sum.extend(squares(&truth, &estimate)[..2].iter().copied());
        // The fit cannot distinguish a common length of all clips from one length for each plate.
        let twice = [sought(&clips, None), sought(&[Quantity::Clip], None)].concat();
        let refused = views(&truth.stated, &seen, &twice, &model(Lean::NONE));
        assert!(refused.as_ref().is_err_and(|error| error.to_string().contains("clip_mm")), "{refused:?}");
    }
    let mean = sum.iter().sum::<f64>() / sum.len() as f64;
    assert!(sum.iter().all(|square| *square < 16.0) && mean < 3.5, "{sum:?}");
}

/// Without measured forces, the fit still finds the geometry if the forces lean within a given range.
#[test]
fn geometry_is_found_without_forces() {
    let truth = truth();
    let quantities = [Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)];
    let mut all = sought(&quantities, None);
    all.extend(sought(&ribs(), Some(0.2)));
    let mut truth = truth;
    (truth.more_height_mm, truth.base) = (0.0, Isometry2::identity());
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let seen = views_of(&truth, false, &mut rng);
    let lean = Lean { from: Normal::Undeformed, ..Lean::within([-0.3, 0.5]) };
    let estimate = views(&scene_finger(), &seen, &all, &model(lean)).expect("identifiable");
    let squares = squares(&truth, &estimate);
    assert!(squares.iter().all(|square| *square < 16.0), "{squares:?} {estimate:?}");
    assert!(estimate.quantities[..2].iter().all(|found| found.sigma < 0.1), "{:?}", estimate.quantities);
}

/// Fits with each force measured in turn confirm which measurement makes the forces most accurate, and how accurate they become.
#[test]
fn the_force_to_measure_next_is_the_most_useful_one() {
    let mut truth = truth();
    (truth.more_height_mm, truth.base) = (0.0, Isometry2::identity());
    let presses = PRESSES.map(|(s_mm, force_n, _)| (s_mm, force_n, 8.0));
    let all = [sought(&ribs(), Some(0.2)), sought(&[Quantity::Preload], Some(10.0))].concat();
    let lean = Lean { from: Normal::Undeformed, ..Lean::within([0.139, 0.142]) };
    let estimate = |measured: Option<usize>| {
        let mut seen = views_at(&presses, &truth, true, &mut ChaCha8Rng::seed_from_u64(11));
        for (i, view) in seen.iter_mut().enumerate() {
            view.force = view.force.filter(|_| Some(i) == measured);
        }
        views(&scene_finger(), &seen, &all, &model(lean)).expect("identifiable")
    };
    let rms = |found: &ViewEstimate| {
        let squares = found.views.iter().map(|view| (view.force_sigma_n / view.force.norm()).powi(2));
        (squares.sum::<f64>() / presses.len() as f64).sqrt()
    };
    let found = estimate(None);
    let next = found.next_force.expect("no force was measured");
    assert!((next.now / rms(&found) - 1.0).abs() < 1e-6, "{next:?}");
    let then: Vec<f64> = (0..presses.len()).map(|view| rms(&estimate(Some(view)))).collect();
    // The forecast is linear and the measured force counts as exact in the fit, so both agree to a fraction of their size.
    let best = then.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(then[next.view] < 1.15 * best && next.then < next.now, "{next:?} {then:?}");
    assert!((next.then / then[next.view]).ln().abs() < 0.5, "{next:?} {then:?}");
}

/// All forces are of one object and lean near one end of the stated range of friction. Leans were once treated as independent, and the standard
/// deviation of their mean was 2.4 times too small.
#[test]
fn one_friction_in_all_views_is_within_the_stated_sigmas() {
    let mut truth = truth();
    (truth.more_height_mm, truth.base) = (0.0, Isometry2::identity());
    truth.finger = truth.stated.clone();
    let presses = [(60.0, 1.5), (65.0, 2.5), (70.0, 4.0), (75.0, 5.5), (80.0, 7.5), (85.0, 9.0)];
    let presses = presses.map(|(s_mm, force_n)| (s_mm, force_n, 30.0));
    let seen = views_at(&presses, &truth, false, &mut ChaCha8Rng::seed_from_u64(3));
    let lean = Lean { from: Normal::Undeformed, ..Lean::within([0.0, 0.6]) };
    let mut all = sought(&ribs(), Some(0.2));
    all.extend(sought(&[Quantity::Preload], Some(8.0)));
    let estimate = views(&scene_finger(), &seen, &all, &model(lean)).expect("identifiable");
    let sigmas = estimate
        .views
        .iter()
        .zip(presses)
        .map(|(view, (_, force_n, _))| (view.force.norm() - force_n) / view.force_sigma_n);
    let sigmas: Vec<f64> = sigmas.collect();
    assert!(sigmas.iter().all(|sigmas| sigmas.abs() < 2.0), "{sigmas:?}");
    let found = estimate.quantities.iter().find(|found| found.sought.quantity == Quantity::Lean).expect("a lean");
    assert!((found.value - 30.0).abs() < 2.0 * found.sigma, "{found:?}");
}

/// A quantity that no measurement determines is refused by name.
#[test]
fn what_is_not_identifiable_is_refused() {
    let truth = truth();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let seen = views_of(&truth, false, &mut rng);
    let lean = Lean { from: Normal::Undeformed, ..Lean::within([-0.3, 0.5]) };
    // Without a measured force, doubling all moduli and all forces together changes no shape.
    let refused = views(&scene_finger(), &seen, &sought(&[Quantity::Modulus], None), &model(lean));
    let by_name = |error: &CalibrationError| error.to_string().contains("modulus_factor");
    assert!(refused.as_ref().is_err_and(by_name), "{refused:?}");
    // One view has fewer measured coordinates than there are unknowns.
    let all: Vec<Quantity> = ribs()
        .into_iter()
        .chain([
            Quantity::Bracket(Plate::Front),
            Quantity::BaseX,
            Quantity::BaseY,
            Quantity::BaseTurn,
            Quantity::MarkerHeight,
            Quantity::Clip,
        ])
        .collect();
    let refused = views(&scene_finger(), &seen[..1], &sought(&all, None), &model(lean));
    assert!(matches!(refused, Err(CalibrationError::TooFewMarkers { .. })), "{refused:?}");
}

/// The uncertainty of brackets and ribs displaces the markers of a new view; the uncertainty of a modulus does not.
#[test]
fn what_is_open_of_the_geometry_counts_as_errors_of_markers() {
    let mut truth = truth();
    (truth.more_height_mm, truth.base) = (0.0, Isometry2::identity());
    let seen = views_of(&truth, true, &mut ChaCha8Rng::seed_from_u64(5));
    let modulus = sought(&[Quantity::Modulus], None);
    let brackets = sought(&[Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)], None);
    let geometry = [&modulus[..], &brackets, &sought(&ribs(), Some(0.2))].concat();
    let more = |stated: &Finger, all: &[Sought]| {
        let found = views(stated, &seen, all, &model(Lean::NONE)).expect("identifiable");
        assert_eq!(found.new_marker_errors.noise_factor, found.marker_errors.noise_factor);
        let [new, old] = [found.new_marker_errors, found.marker_errors].map(|errors| errors.sd_mm(NOISE_MM).powi(2));
        new / old - 1.0
    };
    let [alone, together] = [more(&truth.finger, &modulus), more(&truth.stated, &geometry)];
    assert!(alone < 0.01 && together > 0.05, "{alone} {together}");
}

/// If all forces were measured and the modulus is known, the errors of the calibrated finger still state the uncertainty of the brackets. Such a
/// calibration once stated no errors.
#[test]
fn errors_of_the_geometry_are_stated_if_all_forces_were_measured() {
    let mut truth = truth();
    (truth.more_height_mm, truth.base) = (0.0, Isometry2::identity());
    let seen = views_of(&truth, true, &mut ChaCha8Rng::seed_from_u64(5));
    let brackets = sought(&[Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)], None);
    let geometry = [&brackets[..], &sought(&ribs(), Some(0.2))].concat();
    let mut stated = truth.stated.description().clone();
    stated.front.youngs_modulus_mpa *= truth.modulus_factor;
    stated.back.youngs_modulus_mpa *= truth.modulus_factor;
    let stated = Finger::new(stated).expect("a possible finger");
    let found = views(&stated, &seen, &geometry, &model(Lean::NONE)).expect("identifiable");
    for (plate, bracket) in found.quantities[..2].iter().enumerate() {
        let variance: f64 = found.unloaded_errors.iter().map(|error| error.joints_mm[0][plate][1].powi(2)).sum();
        assert!((variance.sqrt() / bracket.sigma - 1.0).abs() < 1e-9, "{variance} {bracket:?}");
    }
}

/// A small force near the base moves markers by less than their errors. Markers that hardly determine a force cannot contradict its measured value.
/// Markers that determine a force contradict a wrong measured value.
#[test]
fn a_force_that_markers_hardly_show_is_no_outlier() {
    let truth = truth();
    let presses = [&PRESSES[..], &[(14.0, 0.3, 0.0)]].concat();
    let quantities = [Quantity::Modulus, Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)];
    let base = [Quantity::BaseX, Quantity::BaseY, Quantity::BaseTurn, Quantity::MarkerHeight];
    let all = [sought(&quantities, None), sought(&base, None)].concat();
    for seed in 0..4 {
        let mut seen = views_at(&presses, &truth, true, &mut ChaCha8Rng::seed_from_u64(seed));
        let outliers = |seen: &[View]| {
            views(&scene_finger(), seen, &all, &model(Lean::NONE)).map(|found| found.outliers).expect("identifiable")
        };
        assert_eq!(outliers(&seen), [], "seed {seed}");
        seen[1].force = seen[1].force.map(|force| force * 1.4);
        let found = outliers(&seen);
        assert!(found.len() == 1 && found[0].view == "press at 70 mm", "{found:?}");
    }
}

/// If measured forces scatter by half of their size, the calibrated finger is too inaccurate for use. The calibration is refused with the name of the
/// view that deviates most.
#[test]
fn a_finger_of_no_use_is_refused() {
    let truth = truth();
    let mut seen = views_of(&truth, true, &mut ChaCha8Rng::seed_from_u64(1));
    let quantities = [Quantity::Modulus, Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)];
    let all = [
        sought(&quantities, None),
        sought(&[Quantity::BaseX, Quantity::BaseY, Quantity::BaseTurn, Quantity::MarkerHeight], None),
    ]
    .concat();
    let found = views(&scene_finger(), &seen, &all, &model(Lean::NONE)).expect("identifiable");
    assert_eq!(found.outliers, []);
    // The markers of the first and the last view do not determine a force; those of the others differ by less than a factor of two from their median.
    for (view, times) in seen.iter_mut().zip([1.7, 1.0, 1.7, 0.6, 0.6]) {
        view.force = view.force.map(|force| force * times);
    }
    let refused = views(&scene_finger(), &seen, &all, &model(Lean::NONE));
    let is_of_forces = |error: &CalibrationError| matches!(error, CalibrationError::View { error: ViewError::ForceErrors { share, .. }, .. } if *share > 0.5);
    assert!(refused.as_ref().is_err_and(is_of_forces), "{refused:?}");
}

fn leans_of<'o>(object: &'o str, leans: &[(f64, f64)]) -> Vec<MeasuredLean<'o>> {
    leans.iter().map(|(force_n, lean_deg)| (object, *force_n, *lean_deg)).collect()
}

fn asked(builds_up: bool, between_objects: f64) -> FrictionQuestion {
    FrictionQuestion { builds_up, between_objects }
}

/// Friction is fitted to leans that build up with the force by an exponential law, and to leans that scatter about a constant.
#[test]
fn friction_follows_from_leans() {
    let law = |force_n: f64| 20.0 * (1.0 - (-force_n / 2.5_f64).exp());
    let leans = leans_of("", &[0.5, 1.0, 2.0, 4.0, 8.0].map(|force_n| (force_n, law(force_n))));
    let found = friction_of(&leans, Normal::Undeformed, asked(true, 0.0)).expect("identifiable");
    // The fit tries values of the build-up force in steps of 0.7 %.
    assert!((found.lean.build_up_n / 2.5 - 1.0).abs() < 0.007, "{found:?}");
    assert!((found.lean.angle_deg / 20.0 - 1.0).abs() < 0.005 && found.lean.sd_deg < 0.05, "{found:?}");
    assert_eq!((found.between_objects, found.left_out.len()), (None, 0));
    let scattered = leans_of("", &[(1.0, 19.0), (2.0, 21.0), (3.0, 20.0)]);
    let found = friction_of(&scattered, Normal::Undeformed, asked(false, 0.0)).expect("identifiable").lean;
    // The lean is the mean of three leans; its standard deviation is their scatter about the mean.
    assert!((found.angle_deg - 20.0).abs() < 1e-12 && (found.sd_deg - 1.0).abs() < 1e-12, "{found:?}");
    // An assumed difference of 0.05 between the objects' coefficients of friction is a difference of 0.05 cos^2 20 deg between their angles, rad.
    let other = friction_of(&scattered, Normal::Undeformed, asked(false, 0.05)).expect("identifiable").lean;
    let between_deg = (0.05 * 20.0_f64.to_radians().cos().powi(2)).to_degrees();
    assert!((other.sd_deg - 1.0_f64.hypot(between_deg)).abs() < 1e-9, "{other:?}");
    let refused = friction_of(&leans[..2], Normal::Undeformed, asked(true, 0.0));
    assert_eq!(refused, Err(CalibrationError::TooFewViews { views: 2, unknowns: 2 }));
}

/// Leans that still grow at the largest force once led to a lean of 141 degrees for a sliding object, and to a coefficient of -0.80.
#[test]
fn friction_that_still_builds_up_has_no_coefficient() {
    let grows = leans_of("", &[2.0, 4.0, 6.0, 8.0, 10.0].map(|force_n| (force_n, 1.6 * force_n)));
    let refused = friction_of(&grows, Normal::Undeformed, asked(true, 0.05));
    let is_limit = |error: &CalibrationError| matches!(error, CalibrationError::FrictionLimit { angle_deg, largest_n, .. } if *angle_deg > 90.0 && *largest_n == 10.0);
    assert!(refused.as_ref().is_err_and(is_limit), "{refused:?}");
    // If the leans are about a fifth as large, the law has a finite coefficient of friction, but no measured lean reaches the sliding lean.
    let grows = leans_of("", &[2.0, 4.0, 6.0, 8.0, 10.0].map(|force_n| (force_n, 0.3 * force_n)));
    let refused = friction_of(&grows, Normal::Undeformed, asked(true, 0.05));
    assert!(matches!(refused, Err(CalibrationError::FrictionLimit { .. })), "{refused:?}");
    let found = friction_of(&grows, Normal::Undeformed, asked(false, 0.05)).expect("a mean");
    assert!((found.lean.angle_deg - 1.8).abs() < 1e-12, "{found:?}");
}

/// If all objects have equally many leans, restricted likelihood has a closed form. The variance between objects is then the variance of their means
/// minus a share of the variance within objects (Searle, Casella and McCulloch, Variance Components, 1992, sec. 3.8). The lean of each object is
/// predicted by the mean of the other objects.
#[test]
fn friction_differs_from_object_to_object() {
    let of = |object: &'static str, mean_deg: f64| {
        leans_of(object, &[(1.0, mean_deg - 1.0), (2.0, mean_deg), (3.0, mean_deg + 1.0)])
    };
    let means = [10.0, 14.0, 21.0];
    let leans: Vec<MeasuredLean> =
        ["a", "b", "c"].iter().zip(means).flat_map(|(object, mean)| of(object, mean)).collect();
    let found = friction_of(&leans, Normal::Undeformed, asked(false, 0.05)).expect("identifiable");
    assert!((found.lean.angle_deg - 15.0).abs() < 1e-9, "{found:?}");
    // The variance of the three means is 31. The variance within objects is 1, and a third of it is subtracted.
    let between_deg = (31.0_f64 - 1.0 / 3.0).sqrt();
    let between = between_deg.to_radians() / 15.0_f64.to_radians().cos().powi(2);
    // The fit tries standard deviations between objects in steps of 2 %.
    assert!((found.between_objects.expect("three objects") / between - 1.0).abs() < 0.02, "{found:?}");
    assert!(found.lean.sd_deg > 1.2 * between_deg, "{found:?}");
    let predicted: Vec<(f64, f64)> = found.left_out.iter().map(|out| (out.predicted_deg, out.measured_deg)).collect();
    for ((predicted, measured), expected) in predicted.iter().zip([(17.5, 10.0), (15.5, 14.0), (12.0, 21.0)]) {
        assert!(
            (predicted - expected.0).abs() < 1e-9 && (measured - expected.1).abs() < 1e-9,
            "{predicted} {measured}"
        );
    }
}

/// 95 % intervals from two, three or five objects contain the lean of a new object's force in at least 89 % of the cases. The objects hardly differ,
/// or differ up to twice as much as assumed.
#[test]
fn few_objects_leave_open_by_how_much_they_differ() {
    const DRAWS: usize = 60;
    const NAMES: [&str; 5] = ["a", "b", "c", "d", "e"];
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    for objects in [2, 3, 5] {
        for true_deg in [0.5, 3.0, 6.0] {
            let mut within = 0.0;
            for _ in 0..DRAWS {
                let object = |name: &'static str, normal: &mut dyn FnMut() -> f64| {
                    let angle_deg = 20.0 + true_deg * normal();
                    let leans = [1.0, 2.0, 4.0, 6.0, 9.0, 12.0].map(|force_n| (force_n, angle_deg + 1.5 * normal()));
                    leans_of(name, &leans)
                };
                let leans: Vec<MeasuredLean> =
                    NAMES[..objects].iter().flat_map(|name| object(name, &mut normal)).collect();
                let lean = friction_of(&leans, Normal::Undeformed, asked(false, 0.05)).expect("identifiable").lean;
                // Probability that the interval contains the lean of a new force, which is normally distributed.
                let new_deg = 1.5_f64.hypot(true_deg);
                let below = |deg: f64| 0.5 * statrs::function::erf::erfc(-(deg - 20.0) / new_deg / 2.0_f64.sqrt());
                let reach_deg = 1.96 * lean.sd_deg;
                within += (below(lean.angle_deg + reach_deg) - below(lean.angle_deg - reach_deg)) / DRAWS as f64;
            }
            // From two or three objects, intervals may be so wide that they contain every new lean; from five objects, they must be narrower.
            let most = if objects == 5 { 0.99 } else { 1.0 };
            assert!((0.89..most).contains(&within), "{within} of {objects} objects that differ by {true_deg}");
        }
    }
}

/// A line fitted by hand: slope 0.5, residuals of 0.1, -0.2 and 0.1, and hence a variance of 0.06 with one degree of freedom. The squared deviations
/// of the forces from their mean sum to 2.
#[test]
fn a_base_gives_way_along_a_line() {
    let found = compliance_of(&[(1.0, 1.1), (2.0, 1.3), (3.0, 2.1)]).expect("three forces");
    assert!((found.deg_per_n - 0.5).abs() < 1e-12, "{found:?}");
    assert!((found.sigma_deg_per_n - (0.06_f64 / 2.0).sqrt()).abs() < 1e-12, "{found:?}");
    let alike = compliance_of(&[(2.0, 1.1), (2.0, 1.3)]);
    assert_eq!(alike, Err(CalibrationError::NotIdentifiable { parameters: "base_deg_per_n".to_owned() }));
    let one = compliance_of(&[(2.0, 1.1)]);
    assert_eq!(one, Err(CalibrationError::TooFewViews { views: 1, unknowns: 2 }));
}

/// A force sensor with independent errors of 3 %. The calibration finds the scatter of the sensor's errors, and the modulus has the resulting
/// uncertainty.
#[test]
fn forces_that_are_missed_are_noticed() {
    let mut truth = truth();
    (truth.more_height_mm, truth.base) = (0.0, Isometry2::identity());
    let all = sought(&[Quantity::Modulus, Quantity::Bracket(Plate::Front), Quantity::Bracket(Plate::Back)], None);
    let found = |missed_by: f64, seeds: u64| {
        let (mut variance, mut squares) = (0.0, 0.0);
        for seed in 0..seeds {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut seen = views_of(&truth, true, &mut rng);
            for view in &mut seen {
                let normal: f64 = StandardNormal.sample(&mut rng);
                view.force = view.force.map(|force| force * (1.0 + missed_by * normal));
            }
            let estimate = views(&scene_finger(), &seen, &all, &model(Lean::NONE)).expect("identifiable");
            variance += estimate.force_error.expect("forces were measured").scatter.powi(2) / seeds as f64;
            let modulus = estimate.quantities[0];
            squares += ((modulus.value - truth.modulus_factor) / modulus.sigma).powi(2) / seeds as f64;
        }
        (variance.sqrt(), squares)
    };
    // Twelve calibrations with five forces and one modulus have 48 degrees of freedom. The tolerance of the variance is 4 standard errors; the
    // relative standard error is sqrt(2 / 48).
    let (force_error, squares) = found(0.03, 12);
    assert!(((force_error / 0.03).powi(2) - 1.0).abs() < 4.0 * (2.0_f64 / 48.0).sqrt(), "{force_error}");
    // Five forces determine their own scatter poorly. Errors of the modulus, in standard deviations, follow Student's distribution with 4 degrees of
    // freedom, which has a variance of 2, divided by 1.42, the ratio of its 95 % interval to that of the normal distribution. The mean square of
    // twelve errors is thus about 1.
    assert!((0.15..2.5).contains(&squares), "{squares}");
    let (force_error, _) = found(0.0, 4);
    assert!(force_error < 0.005, "{force_error}");
}

/// The paper's finger with 32 elements per member. On a mesh of one element per member, the modulus errs by fifty standard deviations. Refinement makes
/// the error of the mesh smaller than the standard deviation. Forces between nodes once made a modulus too small, even on four elements per member.
#[test]
fn the_error_of_the_mesh_is_below_sigma() {
    const SEEDS: u64 = 2;
    let modulus_factor = 0.92;
    let finger = paper().with_modulus_factor(modulus_factor).expect("a positive modulus");
    let truth = Truth { stated: paper(), finger, modulus_factor, more_height_mm: 0.0, base: Isometry2::identity() };
    let presses = [(40.3, 6.0, -20.0), (66.6, 4.0, 10.0), (95.2, 3.0, 5.0), (120.7, 3.0, -10.0)];
    let all = sought(&[Quantity::Modulus], None);
    let errors = (0..SEEDS).map(|seed| {
        let seen = views_on(32, &presses, &truth, true, &mut ChaCha8Rng::seed_from_u64(seed));
        let [refined, coarse] =
            [refined_views, views].map(|fit| fit(&paper(), &seen, &all, &model(Lean::NONE)).expect("identifiable"));
        [refined.quantities[0], coarse.quantities[0]]
            .map(|found| (found.value - modulus_factor) / refined.quantities[0].sigma)
    });
    let errors: Vec<[f64; 2]> = errors.collect();
    assert!(errors.iter().all(|[refined, coarse]| refined.abs() < 2.5 && *coarse < -20.0), "{errors:?}");
}

/// If rib joints deviate from the scene by 0.6 mm, an image does not determine the position of a small force. A calibration with the image of such a
/// small force still has a starting point, and rib positions are found within 4 sigma.
#[test]
fn an_image_whose_force_has_no_certain_position_starts_a_calibration() {
    const JOINTS_MM: f64 = 0.6;
    for seed in [0, 3, 5, 8] {
        let mut rng = ChaCha8Rng::seed_from_u64(3000 + seed);
        let mut off = || {
            let mut normal = || -> f64 { JOINTS_MM * rng.sample::<f64, _>(StandardNormal) };
            [normal(), normal()]
        };
        let mut description = scene_finger().description().clone();
        if let RibPositions::Positions(positions) = &mut description.ribs.positions {
            positions.iter_mut().for_each(|at| *at = [at[0] + off()[0], at[1] + off()[1]]);
        }
        description.ribs.bracket_mm = BracketLengths::Each((0..4).map(|_| off().map(|mm| 3.0 + mm)).collect());
        let finger = Finger::new(description).expect("a finger");
        let truth = Truth { finger, modulus_factor: 1.0, more_height_mm: 0.0, base: Isometry2::identity(), ..truth() };
        let seen = views_at(&[(50.0 + seed as f64, 0.6, 20.0)], &truth, false, &mut rng);
        let each = |plate| (0..4).map(move |rib| Quantity::OwnBracket(plate, rib));
        let brackets: Vec<Quantity> = each(Plate::Front).chain(each(Plate::Back)).collect();
        let joints = [sought(&ribs(), Some(JOINTS_MM)), sought(&brackets, Some(JOINTS_MM))].concat();
        let lean = Lean { from: Normal::Undeformed, ..Lean::within([0.0, 0.6]) };
        let found = views(&scene_finger(), &seen, &joints, &model(lean)).expect("a starting point");
        let ribs = ViewEstimate { quantities: found.quantities[..8].to_vec(), ..found };
        let squares = squares(&truth, &ribs);
        assert!(squares.iter().all(|square| *square < 16.0), "{seed}: {squares:?}");
    }
}

/// The finger of the scene with all moduli multiplied by a factor.
fn stiffer(factor: f64) -> Truth {
    let mut description = scene_finger().description().clone();
    let FingerDescription { front, back, ribs, .. } = &mut description;
    let strips = [front, back].into_iter().chain(ribs.strip.as_mut());
    strips.for_each(|strip| strip.youngs_modulus_mpa *= factor);
    let finger = Finger::new(description).expect("a possible finger");
    let base = Isometry2::identity();
    Truth { stated: scene_finger(), finger, modulus_factor: factor, more_height_mm: 0.0, base }
}

/// One force that was measured to 1 % determines the modulus to about 1 %. Its difference from the prior of the modulus is no scatter of forces.
#[test]
fn one_force_determines_the_modulus() {
    let (mut held, cases) = (0, 40);
    for seed in 0..cases {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [of_modulus, of_force, of_position]: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
        let modulus_factor = (0.1 * of_modulus).exp();
        let mut seen = views_at(&[(70.0, 3.0, 12.0)], &stiffer(modulus_factor), true, &mut rng);
        seen[0].force = seen[0].force.map(|force| force * (1.0 + 0.01 * of_force));
        seen[0].position = Some([70.0 + of_position, 1.0]);
        let all = sought(&[Quantity::Modulus], Some(0.1));
        let found = views(&scene_finger(), &seen, &all, &model(Lean::NONE)).expect("identifiable");
        let modulus = found.quantities[0];
        let of_new = found.force_error.expect("a force was measured").of_new;
        assert!(modulus.sigma < 0.02 * modulus.value && of_new < 0.03, "{modulus:?}, {of_new}");
        assert_eq!(found.new_marker_errors.calibration_error_mm, found.marker_errors.calibration_error_mm);
        held += usize::from((modulus.value - modulus_factor).abs() < 1.96 * modulus.sigma);
    }
    // Three standard deviations of the number that holds.
    assert!(held >= 34, "{held} of {cases} intervals hold");
}

/// Two forces that agree determine the modulus, however wrong its prior: the difference from the prior is no scatter of forces. It once was, and the
/// factor was 1.06 for 1.5.
#[test]
fn forces_that_agree_outweigh_a_wrong_prior() {
    for (factor, seed) in [(1.5, 0), (1.8, 1), (0.6, 2)] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let seen = views_at(&[(70.0, 3.0, 12.0), (60.0, 2.0, 5.0)], &stiffer(factor), true, &mut rng);
        let found = views(&scene_finger(), &seen, &sought(&[Quantity::Modulus], Some(0.1)), &model(Lean::NONE));
        let modulus = found.expect("identifiable").quantities[0];
        // The prior moves the factor by the square of the ratio of the forces' assumed error, 1 %, to that of the prior.
        assert!((modulus.value / factor - 1.0).abs() < 0.02, "{modulus:?} for {factor}");
    }
}
