//! Sensing with an assumed contact that differs from the true one.

use finray_model::finger::Plate;
use finray_model::sensing::{Contact, ContactPosition};
use finray_model::{Finger, Scene};
use finray_studies::experiments::assumed::misjudged;
use finray_studies::settings::{DIRECTION_OFF_DEG, POSITION_OFF_MM};

fn finger(text: &str) -> Finger {
    Scene::from_toml(text).expect("a scene").finger
}

/// The assumed contact deviates from the true contact to one side and then to the other side, unless it would leave the plate.
#[test]
fn an_assumed_contact_is_off_to_each_side_in_turn() {
    let finger = finger(finray_fixtures::PAPER_SCENE);
    let length_mm = finger.plate_length_mm(Plate::Front);
    for (s_mm, reached) in [(60.0, &[-1.0, 1.0][..]), (length_mm - 0.5, &[-1.0]), (1.0, &[1.0])] {
        let found = misjudged(&finger, Contact { position: ContactPosition::at(s_mm), angle_deg: 20.0 });
        let of_side = |side: &f64| {
            let position = ContactPosition::at(s_mm + side * POSITION_OFF_MM);
            [-DIRECTION_OFF_DEG, DIRECTION_OFF_DEG].map(|by_deg| Contact { position, angle_deg: 20.0 + by_deg })
        };
        assert_eq!(found, reached.iter().flat_map(of_side).collect::<Vec<_>>());
    }
}

/// On a plate so short that every assumed position lies off the plate, the contacts off the plate remain, which sensors refuse.
#[test]
fn a_plate_shorter_than_the_assumption_keeps_wrong_contacts() {
    let small = finray_fixtures::PAPER_SCENE
        .replace("front_length_mm = 153.0", "front_length_mm = 2.0")
        .replace("back_length_mm = 153.0", "back_length_mm = 2.0")
        .replace("base_width_mm = 58.0", "base_width_mm = 1.0");
    let finger = finger(&small);
    assert!(finger.plate_length_mm(Plate::Front) < 2.0 * POSITION_OFF_MM);
    assert_eq!(misjudged(&finger, Contact { position: ContactPosition::at(1.0), angle_deg: 0.0 }).len(), 4);
}
