//! The training recipe on a network's card, and recipes that are refused.

use super::{fresh, sensed, tiny, trained};
use finray_model::sensing::SensingError;
use finray_model::sensing::network::{ContactSet, Scaling};
use finray_model::{Kinematics, NodeId};
use finray_tests::{CAMERA_NOISE_MM, at_nodes, paper};
use finray_train::samples::SamplesError;
use finray_train::{TrainError, TrainingRecipe, train};

/// The card contains the recipe. A marker that is listed twice as hidden counts once; a clamped marker does not count.
#[test]
fn the_card_tells_the_recipe() {
    let mut recipe = tiny(&[16, 20], 100, 4, 2);
    recipe.samples.hidden = [19, 2, 19, 25].map(NodeId).to_vec();
    recipe.samples.direction_spread_deg = 2.0;
    recipe.samples.modulus_spread = 0.01;
    recipe.seed = 5;
    let network = trained(&recipe);
    let card = &network.card;
    let seen: Vec<NodeId> = paper().free_nodes().filter(|node| ![2, 19].contains(&node.0)).collect();
    assert_eq!((&card.markers, card.origin.hidden_markers), (&seen, 2));
    assert_eq!((&card.contacts, card.contact_set), (&recipe.samples.contacts, ContactSet::Fixed));
    assert_eq!((card.noise_mm, card.scaling, card.test_samples), (CAMERA_NOISE_MM, Scaling::Principal, 20));
    let origin = card.origin;
    assert_eq!((origin.kinematics, origin.elements_per_member), (Kinematics::Corotational, 4));
    assert_eq!((origin.samples, origin.seed), (100, 5));
    assert_eq!((origin.force_range_n, origin.largest_total_n), ([0.0, 5.0], 10.0));
    assert_eq!((origin.direction_spread_deg, origin.modulus_spread), (2.0, 0.01));
    let samples = fresh(&recipe.samples, 5);
    assert!(sensed(&network, &samples, &samples.displacements).iter().all(|force_n| force_n.is_finite()));
}

#[test]
fn impossible_recipes_are_refused() {
    let finger = paper();
    let refused = |change: &dyn Fn(&mut TrainingRecipe)| {
        let mut recipe = tiny(&[19, 20], 10, 4, 1);
        change(&mut recipe);
        train(&finger, &recipe, &mut |_| {}).expect_err("an impossible recipe")
    };
    let names = |change: &dyn Fn(&mut TrainingRecipe), wrong: &str| match refused(change) {
        TrainError::Samples(SamplesError::Recipe { key, .. }) => assert_eq!(key, wrong),
        other => panic!("{wrong}: {other:?}"),
    };
    for count in [0, 1] {
        names(&|recipe| recipe.count = count, "count");
    }
    for noise_mm in [f64::NAN, f64::INFINITY, -0.1] {
        names(&|recipe| recipe.noise_mm = noise_mm, "noise_mm");
    }
    for rate in [f64::NAN, f64::INFINITY, -1e-3, 0.0] {
        names(&|recipe| recipe.learning_rate = rate, "learning_rate");
    }
    names(&|recipe| recipe.hidden_layers = vec![8, 0], "hidden_layers");
    names(&|recipe| recipe.epochs = 0, "epochs, batch");
    names(&|recipe| recipe.batch = 0, "epochs, batch");
    names(&|recipe| recipe.samples.largest_force_n = f64::NAN, "largest_force_n");
    names(&|recipe| recipe.samples.modulus_spread = -1.0, "modulus_spread");
    // Two invalid cases: no visible marker, and two coordinates for three forces.
    names(&|recipe| recipe.samples.hidden = paper().free_nodes().collect(), "hidden");
    let one_seen = |recipe: &mut TrainingRecipe| {
        recipe.samples.contacts = at_nodes(&[16, 18, 20]);
        recipe.samples.hidden = paper().free_nodes().filter(|node| node.0 != 15).collect();
    };
    names(&one_seen, "hidden");
    let message = refused(&|recipe| recipe.noise_mm = f64::NAN).to_string();
    assert_eq!(message, "noise_mm: expected a length in mm, zero or more, found NaN");
    let elsewhere = refused(&|recipe| recipe.samples.contacts = at_nodes(&[7]));
    assert!(matches!(elsewhere, TrainError::Samples(SamplesError::Contacts(SensingError::NotAContactNode { .. }))));
}
