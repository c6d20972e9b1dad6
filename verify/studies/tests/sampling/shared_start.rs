//! A map senses each noise sample as a user would: the search from the noise-free forces gives the answer of a sensor that knows nothing else.

use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::sensor::PreparedScene;
use finray_model::{Kinematics, Scene};
use finray_studies::sampling::noise::Noise;
use finray_studies::sampling::sampled::{SampledForces, SampledSensor};
use finray_studies::truths::{MeshTruth, Truth, TruthId, fine_mesh};
use finray_tests::paper;

const NOISE_MM: f64 = 0.067;
const SAMPLES: usize = 4;
/// Tolerance between two searches for the same answer. A search ends if a step changes a force by less than 1e-7 of its scale; in ill-conditioned
/// cells, the difference is slightly larger.
const SAME_ANSWER: f64 = 1e-5;
/// Tolerance of the standard deviation, relative. It includes the error of the mesh, which samples share.
const SAME_SIGMA: f64 = 1e-2;

#[test]
fn samples_of_a_cell_are_sensed_as_a_user_senses_them() {
    let finger = paper();
    let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
    let softer = Scene::from_toml(finray_fixtures::TWIN_SCENE).expect("a good scene").finger;
    let asked = SampledSensor::new(EstimatorId::Nonlinear, Networks::none());
    let (mut answered, mut refused, mut warned) = (0, 0, 0);
    for (truth, own) in [(TruthId::Corotational, &finger), (TruthId::Twin, &softer)] {
        let fine = fine_mesh(own).expect("a mesh");
        let truth = MeshTruth::new(truth, &fine, Kinematics::Corotational).expect("a finger at rest");
        for (cell, s_mm) in [8.0, 40.0, 90.0, 130.0, 150.0].into_iter().enumerate() {
            for angle_deg in [-80.0, -30.0, 0.0, 50.0, 80.0] {
                let contact = Contact { position: ContactPosition::at(s_mm), angle_deg };
                let mut noise = Noise::of_stream(3, cell as u64);
                let sensor = asked.at(&scene, contact).expect("a contact on the plate").remove(0);
                for shape in truth.shapes(&contact, &[0.5, 3.0]) {
                    let seen = Measurement::of_shape(&finger, &shape);
                    let sampled = SampledForces::new(&sensor, &seen, NOISE_MM, SAMPLES);
                    for _ in 0..SAMPLES {
                        let noisy = noise.on(&seen, NOISE_MM);
                        let at = format!("{:?} at {s_mm} mm, {angle_deg} deg", truth.id());
                        let alone = sensor.clone().sense_displacements(&noisy, Some(NOISE_MM), None);
                        match [alone, sampled.sense(&noisy)] {
                            [Ok(alone), Ok(sampled)] => {
                                let [one, other] = [alone.forces[0], sampled.forces[0]];
                                let apart = (one.force_n / other.force_n - 1.0).abs();
                                let sigma = (one.sigma_n / other.sigma_n - 1.0).abs();
                                let is_warned = !alone.warnings.is_empty();
                                assert!(apart <= SAME_ANSWER && sigma < SAME_SIGMA, "{at}: {alone:?}, {sampled:?}");
                                assert_eq!(is_warned, !sampled.warnings.is_empty(), "{at}: {alone:?}, {sampled:?}");
                                answered += 1;
                                warned += usize::from(is_warned);
                            }
                            [Err(alone), Err(sampled)] => {
                                assert_eq!(alone.to_string(), sampled.to_string(), "{at}");
                                refused += 1;
                            }
                            different => panic!("{at}: {different:?}"),
                        }
                    }
                }
            }
        }
    }
    assert!(answered > 300 && refused > 0 && warned > 20, "{answered} answered, {refused} refused, {warned} warned");
}
