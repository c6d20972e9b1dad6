//! Intervals of forces at contacts that are not known exactly hold the force, on random fingers with all or some of the markers visible.

use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::finger::Plate;
use finray_model::sensor::PreparedScene;
use finray_model::{Finger, Kinematics, NodeId, Scene};
use finray_studies::experiments::situations::SITUATIONS;
use finray_studies::sampling::noise::Noise;
use finray_studies::sampling::sampled::SampledSensor;
use finray_studies::sampling::situation::{ContactKnowledge, Situation};
use finray_studies::truths::{MeshTruth, TruthId, fine_mesh, leaning};
use finray_tests::{
    CAMERA_NOISE_MM, Figure, built_finger, case_count, contact_node, force_for_deflection, record_figures, share_error,
};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rayon::prelude::*;

/// Figures of this number of cases or more are recorded.
const RECORDED: usize = 200;
const COMMAND: &str = "FINRAY_TEST_CASES=400 cargo test --release --workspace --test studies -- situations --nocapture";
/// Deviation of the share of intervals that hold: a standard deviation that is 10 % wrong, and 2.5 standard errors.
const TOLERANCE: f64 = 0.02;
const STANDARD_ERRORS: f64 = 2.5;
/// Forces move their contact by these shares of the finger's length.
const DEFLECTIONS: [f64; 2] = [0.01, 0.12];
/// Forces act between these shares of the plate's length.
const POSITIONS: [f64; 2] = [0.1, 1.0];

/// Relative error of a sensed force, and whether its interval holds the force. `None` if the force is refused or warned of.
type Answer = Option<(f64, bool)>;

/// Answers of the nonlinear estimator in every situation with an unknown part to one force on a random finger; `None` if the finger does not carry it.
fn answers(finger: &Finger, case: u64) -> Option<Vec<Answer>> {
    let mut chance = Noise::of_stream(31, case);
    let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
    let mesh = fine_mesh(finger).ok()?;
    let truth = MeshTruth::new(TruthId::Corotational, &mesh, Kinematics::Corotational).ok()?;
    let (share, deflection) = (chance.evenly(POSITIONS), chance.evenly(DEFLECTIONS));
    let s_mm = share * finger.plate_length_mm(Plate::Front);
    let node: NodeId = contact_node(finger, 1.0 - share);
    let force_n = force_for_deflection(finger, node, 0.0, deflection).norm();
    let along = chance.evenly([0.0, 1.0]);
    let answer = |situation: Situation| {
        let [least, most] = situation.contact.allowed_deg(&scene);
        let (contact, shape) = leaning(&truth, finger, s_mm, least + along * (most - least), force_n)?;
        let sensor = SampledSensor { situation, ..SampledSensor::new(EstimatorId::Nonlinear, Networks::none()) };
        let seen = sensor.sees(finger, &shape, s_mm);
        let noisy = chance.clone().on(&seen, CAMERA_NOISE_MM);
        let sensors = sensor.at(&scene, contact).expect("a contact on the plate");
        let sensed = sensors[0].sense_displacements(&noisy, Some(CAMERA_NOISE_MM), None);
        Some(sensed.ok().filter(|sensed| sensed.warnings.is_empty()).map(|sensed| {
            let [least_n, most_n] = sensed.forces[0].interval_n();
            (sensed.forces[0].force_n / force_n - 1.0, (least_n..=most_n).contains(&force_n))
        }))
    };
    asked().map(answer).collect()
}

/// Situations in which intervals are expected to hold: all but misjudged contacts.
fn asked() -> impl Iterator<Item = Situation> {
    SITUATIONS.into_iter().filter(|situation| situation.contact != ContactKnowledge::Misjudged)
}

#[test]
fn intervals_of_unknown_contacts_hold_the_force() {
    let cases = case_count(40, 400);
    let mut runner = TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]));
    // A finger with few markers, such as a plate without ribs, tells nothing of an unknown contact.
    let fingers = built_finger().prop_filter("few markers", |finger| finger.rib_count() >= 2);
    let mut draw = || fingers.new_tree(&mut runner).expect("a finger").current();
    let drawn: Vec<Finger> = (0..2 * cases).map(|_| draw()).collect();
    let found = drawn.par_iter().enumerate().filter_map(|(case, finger)| answers(finger, case as u64));
    let found: Vec<Vec<Answer>> = found.collect::<Vec<_>>().into_iter().take(cases).collect();
    assert_eq!(found.len(), cases, "few fingers carry their forces");
    let mut figures = Vec::new();
    for (i, situation) in asked().enumerate() {
        let answered: Vec<(f64, bool)> = found.iter().filter_map(|answers| answers[i]).collect();
        let count = answered.len();
        let within = answered.iter().filter(|(_, holds)| *holds).count() as f64 / count as f64;
        let mut errors: Vec<f64> = answered.iter().map(|(error, _)| error.abs()).collect();
        errors.sort_by(f64::total_cmp);
        let figure = Figure {
            row: situation.to_string(),
            question: "marker noise 0.067 mm".to_owned(),
            cases,
            refused: cases - count,
            mean_error: errors.iter().sum::<f64>() / count as f64,
            largest_error: errors.last().copied().unwrap_or(f64::NAN),
            within,
            standard_error: share_error(0.95, count),
            ..Figure::default()
        };
        println!(
            "{situation}: {:.3} hold of {count} in {cases}, mean error {:.3}, median {:.3}, largest {:.2}",
            within,
            figure.mean_error,
            errors[count / 2],
            figure.largest_error
        );
        figures.push(figure);
    }
    for figure in &figures {
        let (count, cases) = (figure.cases - figure.refused, figure.cases);
        // With the tip hidden, about half of the forces are refused. If hardly any force were answered, coverage would remain untested.
        assert!(3 * count > cases, "{figure:?}: most are refused");
        let least = 0.95 - TOLERANCE - STANDARD_ERRORS * figure.standard_error;
        assert!(figure.within >= least, "{figure:?}: expected at least {least}");
    }
    if cases >= RECORDED {
        record_figures("unknown contacts", COMMAND, figures);
    }
}
