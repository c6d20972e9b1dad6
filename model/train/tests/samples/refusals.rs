//! Requests for random load cases that are refused.

use super::linear;
use finray_model::Kinematics;
use finray_model::mesh::LoadError;
use finray_model::sensing::{Contact, SensingError};
use finray_tests::{at_node, at_position, paper};
use finray_train::samples::{SampleRecipe, SamplesError, Stream};

/// If the finger carries none of the drawn forces, the draw fails with a message.
#[test]
fn forces_beyond_the_finger_are_refused() {
    // The range extends to a million times the force that the finger carries. The probability that the finger carries at least one of a hundred draws
    // is 1e-4.
    let range_n = 1e7;
    let contacts = vec![at_node(19, 0.0)];
    let too_large = SampleRecipe {
        largest_force_n: range_n,
        largest_sum_n: range_n,
        ..SampleRecipe::paper(contacts, Kinematics::Corotational)
    };
    let refused = too_large.draw(&paper(), 2, 1, Stream::Training).expect_err("beyond the finger");
    assert_eq!(refused, SamplesError::NoneCarried { draws: 100 });
    assert!(refused.to_string().contains("under any of 100 random load cases"), "{refused}");
}

#[test]
fn wrong_contacts_are_refused() {
    let finger = paper();
    let refused = |contacts: &[Contact]| {
        let recipe = SampleRecipe { contacts: contacts.to_vec(), ..linear([]) };
        match recipe.draw(&finger, 5, 1, Stream::Training) {
            Err(SamplesError::Contacts(error)) => error,
            other => panic!("{contacts:?}: {other:?}"),
        }
    };
    assert!(matches!(refused(&[]), SensingError::NoContact));
    assert!(matches!(refused(&[at_node(7, 0.0)]), SensingError::NotAContactNode { .. }));
    assert!(matches!(refused(&[at_node(25, 0.0)]), SensingError::Load(LoadError::NodeClamped { .. })));
    assert!(matches!(refused(&[at_node(26, 0.0)]), SensingError::Load(LoadError::NodeMissing { .. })));
    assert!(matches!(refused(&[at_node(19, f64::NAN)]), SensingError::AngleNotFinite { contact: 1 }));
    assert!(matches!(refused(&[at_node(19, 3.0), at_node(19, 3.0)]), SensingError::SameContact { .. }));
    let off_plate = at_position(200.0, 0.0);
    assert!(matches!(refused(&[off_plate]), SensingError::Load(LoadError::PositionOffPlate { .. })));
}

/// Ranges that are not positive, and spreads that are negative or not finite, are refused.
#[test]
fn impossible_ranges_are_refused() {
    let finger = paper();
    let refused = |change: &dyn Fn(&mut SampleRecipe), wrong: &str| {
        let mut recipe = linear([19]);
        change(&mut recipe);
        match recipe.draw(&finger, 5, 1, Stream::Training) {
            Err(SamplesError::Recipe { key, .. }) => assert_eq!(key, wrong),
            other => panic!("{wrong}: {other:?}"),
        }
    };
    for force_n in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(&|recipe| recipe.largest_force_n = force_n, "largest_force_n");
        refused(&|recipe| recipe.largest_sum_n = force_n, "largest_sum_n");
    }
    for spread in [-1.0, f64::NAN, f64::INFINITY] {
        refused(&|recipe| recipe.direction_spread_deg = spread, "direction_spread_deg");
        refused(&|recipe| recipe.modulus_spread = spread, "modulus_spread");
    }
    refused(&|recipe| recipe.elements = 0, "elements");
}
