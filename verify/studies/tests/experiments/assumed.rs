//! Sensing with an assumed contact that differs from the true one.

use finray_model::estimators::{BeamEstimator, Estimator};
use finray_model::finger::Plate;
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPosition, LinearEstimator, Prior};
use finray_model::{Kinematics, Mesh, Scene, statics};
use finray_studies::experiments::assumed::AssumedContact;
use finray_studies::experiments::causes::{DIRECTION_OFF_DEG, POSITION_OFF_MM};

/// The assumed contact deviates from the true contact to one side and then to the other side, unless it would leave the plate. The sensed force
/// equals the result of least squares for the assumed contact.
#[test]
fn an_assumed_contact_is_off_to_each_side_in_turn() {
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the paper's scene").finger;
    let mesh = Mesh::key_nodes(&finger);
    let informed = BeamEstimator::least_squares(&mesh).of_noise_alone();
    let assumed = AssumedContact { informed: &informed, finger: &finger };
    let length_mm = finger.plate_length_mm(Plate::Front);
    for (s_mm, reached) in [(60.0, &[-1.0, 1.0][..]), (length_mm - 0.5, &[-1.0]), (1.0, &[1.0])] {
        let contact = Contact { position: ContactPosition::At(s_mm), angle_deg: 20.0 };
        let shape = statics::solve(&mesh, &[contact.load(&finger, 2.0)], Kinematics::Linear).expect("a shape");
        let seen = Measurement::of_shape(&finger, &shape);
        let mut in_turn = assumed.prepare(&[contact], &seen).expect("a side on the plate");
        for _ in 0..2 {
            for by_mm in reached.iter().map(|side| side * POSITION_OFF_MM) {
                for by_deg in [-DIRECTION_OFF_DEG, DIRECTION_OFF_DEG] {
                    let off = Contact { position: ContactPosition::At(s_mm + by_mm), angle_deg: 20.0 + by_deg };
                    let direct = LinearEstimator::new(&finger, &[off], &seen).expect("identifiable");
                    let direct = direct.estimate(&seen, Some(0.05), Prior::None).forces_n[0];
                    let sensed = in_turn.estimate(&seen, Some(0.05)).expect("an answer").forces_n[0];
                    assert!((sensed / direct - 1.0).abs() < 1e-9 && (sensed - 2.0).abs() > 1e-3, "{sensed} {direct}");
                }
            }
        }
    }
}

/// A plate so short that every assumed position lies off the plate is refused; there is no division by zero.
#[test]
fn a_plate_shorter_than_the_assumption_is_refused() {
    let small = finray_fixtures::PAPER_SCENE
        .replace("front_length_mm = 153.0", "front_length_mm = 2.0")
        .replace("back_length_mm = 153.0", "back_length_mm = 2.0")
        .replace("base_width_mm = 58.0", "base_width_mm = 1.0");
    let finger = Scene::from_toml(&small).expect("a small finger").finger;
    assert!(finger.plate_length_mm(Plate::Front) < 2.0 * POSITION_OFF_MM);
    let mesh = Mesh::key_nodes(&finger);
    let informed = BeamEstimator::least_squares(&mesh);
    let assumed = AssumedContact { informed: &informed, finger: &finger };
    let contact = Contact { position: ContactPosition::At(1.0), angle_deg: 0.0 };
    let shape = statics::solve(&mesh, &[contact.load(&finger, 1e-3)], Kinematics::Linear).expect("a shape");
    assert!(assumed.prepare(&[contact], &Measurement::of_shape(&finger, &shape)).is_err());
}
