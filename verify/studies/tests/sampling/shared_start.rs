//! The search for a noise sample gives the same answer from the noise-free estimate as from a cold start.

use finray_model::estimators::{BeamEstimator, Estimator, PreparedEstimator};
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::{Kinematics, Scene};
use finray_studies::sampling::noise::Noise;
use finray_studies::truths::{MeshTruth, Truth, TruthId, fine_mesh};
use finray_tests::{ELEMENTS, paper};

const NOISE_MM: f64 = 0.067;
const SAMPLES: usize = 4;
/// Tolerance between two searches for the same answer. A search ends if a step changes a force by less than 1e-7 of its scale; in ill-conditioned
/// cells, the difference is slightly larger.
const SAME_ANSWER: f64 = 1e-5;

#[test]
fn samples_of_a_cell_are_answered_alike_from_a_shared_start() {
    let finger = paper();
    let softer = Scene::from_toml(finray_fixtures::TWIN_SCENE).expect("a good scene").finger;
    let mesh = finray_model::Mesh::with_elements_per_member(&finger, ELEMENTS);
    let estimator = BeamEstimator::nonlinear(&mesh);
    let (mut answered, mut refused, mut warned) = (0, 0, 0);
    for (truth, own) in [(TruthId::Corotational, &finger), (TruthId::Twin, &softer)] {
        let fine = fine_mesh(own).expect("a mesh");
        let truth = MeshTruth::new(truth, &fine, Kinematics::Corotational).expect("a finger at rest");
        for (cell, s_mm) in [8.0, 40.0, 90.0, 130.0, 150.0].into_iter().enumerate() {
            for angle_deg in [-80.0, -30.0, 0.0, 50.0, 80.0] {
                let contact = Contact { position: ContactPosition::At(s_mm), angle_deg };
                let mut noise = Noise::of_stream(3, cell as u64);
                for shape in truth.shapes(&contact, &[0.5, 3.0]) {
                    let seen = Measurement::of_shape(&finger, &shape);
                    let prepare = || estimator.prepare(&[contact], &seen).expect("a contact on the plate");
                    let (mut cold, mut shared): (Box<dyn PreparedEstimator>, Box<dyn PreparedEstimator>) =
                        (prepare(), prepare());
                    shared.expect_samples_of(&seen, NOISE_MM, SAMPLES);
                    for _ in 0..SAMPLES {
                        let noisy = noise.on(&seen, NOISE_MM);
                        let answers = [&mut cold, &mut shared].map(|it| it.estimate(&noisy, Some(NOISE_MM)));
                        let at = format!("{:?} at {s_mm} mm, {angle_deg} deg", truth.id());
                        match answers {
                            [Ok(cold), Ok(shared)] => {
                                let apart = (cold.forces_n[0] / shared.forces_n[0] - 1.0).abs();
                                assert!(
                                    apart <= SAME_ANSWER && cold.warned == shared.warned,
                                    "{at}: {cold:?}, {shared:?}"
                                );
                                answered += 1;
                                warned += usize::from(cold.warned);
                            }
                            [Err(cold), Err(shared)] => {
                                assert_eq!(cold.to_string(), shared.to_string(), "{at}");
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
