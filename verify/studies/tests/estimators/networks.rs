//! Accuracy of the shipped networks on new random forces of the co-rotational finger with 684 nodes and camera noise. `FINRAY_TEST_CASES=full` runs
//! the full study, which takes half a minute on two cores.

use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::{Networks, NoNetwork};
use finray_model::measurement::Measurement;
use finray_model::sensing::network::NetworkEstimator;
use finray_model::sensor::SensorOptions;
use finray_model::{Kinematics, Mesh, NodeId, Scene, statics};
use finray_studies::experiments::networks::shipping::{Shipping, shipping};
use finray_studies::sampling::scatter::{ScatterRequest, ScatterRow, scatter, singles};
use finray_studies::settings::TWO_FORCES_N;
use finray_studies::truths::fine_mesh;
use finray_tests::{
    CAMERA_NOISE_MM, STANDARD_ERRORS, at_node, at_nodes, case_count, paper, paper_scene_with, share_error,
};

/// Ratio of the standard deviation to the mean of the relative errors, for forces from 0.3 to 3 N.
const SPREAD: f64 = 1.4;
/// Limit of the excess of a network's root mean square error over the Cramer-Rao bound. The measured excess is up to a tenth for neighbouring nodes,
/// mostly at small forces.
const OVER_BOUND: f64 = 0.15;

fn nodes(numbers: &[usize]) -> Vec<NodeId> {
    numbers.iter().copied().map(NodeId).collect()
}

fn errors(fine: &Mesh, model: &Mesh, sensors: &[SensorOptions], sets: &[Vec<NodeId>], cases: usize) -> Vec<ScatterRow> {
    errors_under(CAMERA_NOISE_MM, fine, model, sensors, sets, cases)
}

fn errors_under(
    noise_mm: f64,
    fine: &Mesh,
    model: &Mesh,
    sensors: &[SensorOptions],
    sets: &[Vec<NodeId>],
    cases: usize,
) -> Vec<ScatterRow> {
    let request = ScatterRequest {
        truth: fine,
        kinematics: Kinematics::Corotational,
        model,
        scene: &Scene::of_finger(fine.finger().clone()).into(),
        noise_levels_mm: &[noise_mm],
        cases,
        seed: 20,
    };
    scatter(&request, sensors, sets, TWO_FORCES_N, &|| {}).expect("contact nodes")
}

/// For every node and every pair of nodes with a shipped network, mean errors are within the tolerance and close to the bound. No case is refused,
/// and the stated standard deviations have their nominal coverage.
#[test]
fn errors_are_near_the_bound() {
    let finger = paper();
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that read");
    let network = SensorOptions { networks, ..SensorOptions::of(EstimatorId::Network) };
    let (fine, key_nodes) = (fine_mesh(&finger).expect("a mesh"), Mesh::key_nodes(&finger));
    let cases = case_count(200, 4000);
    let each = singles(&nodes(&[14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24]));
    let near = [nodes(&[19, 20]), nodes(&[16, 17])];
    let apart = [nodes(&[18, 20]), nodes(&[16, 20])];
    let chance = 1.0 + STANDARD_ERRORS * SPREAD / (cases as f64).sqrt();
    for (sets, force, sum) in [(&each[..], 0.016, 0.016), (&near[..], 0.04, 0.01), (&apart[..], 0.02, 0.01)] {
        for row in errors(&fine, &key_nodes, std::slice::from_ref(&network), sets, cases) {
            assert_eq!((row.cases, row.refused), (cases, 0), "{row:?}");
            let all = row.sum.expect("a sum");
            println!(
                "{:?}: {:.2} %, bound {:.2} %; sum {:.2} %",
                row.nodes,
                100.0 * row.mean_error().expect("forces"),
                100.0 * row.mean_error_bound().expect("noise"),
                100.0 * all.mean_error,
            );
            let mean_error = row.mean_error().expect("forces");
            assert!(mean_error <= force * chance, "{mean_error}: {row:?}");
            assert!(all.mean_error <= sum * chance, "{row:?}");
            for scatter in &row.forces {
                let (bound, covered) = scatter.bound.zip(scatter.coverage).expect("noise and deviations");
                let random = STANDARD_ERRORS / (2.0 * cases as f64).sqrt();
                assert!((bound.over_bound - 1.0).abs() <= OVER_BOUND + random, "{row:?}");
                for (found, meant) in [(covered.one_sigma, 0.683), (covered.two_sigma, 0.95)] {
                    let allowed = STANDARD_ERRORS * share_error(meant, cases) + 0.02;
                    assert!((found - meant).abs() <= allowed, "covers {found}, meant {meant}: {row:?}");
                }
            }
        }
    }
}

/// With less noise than in training, the error of the training's mesh matters: without it, 85 % of the intervals contained the force at 0.02 mm.
#[test]
fn intervals_hold_with_less_noise() {
    const NOISE_MM: f64 = 0.02;
    let finger = paper();
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that read");
    let network = SensorOptions { networks, ..SensorOptions::of(EstimatorId::Network) };
    let (fine, key_nodes) = (fine_mesh(&finger).expect("a mesh"), Mesh::key_nodes(&finger));
    let cases = case_count(100, 2000);
    let pairs = [[19, 20], [16, 17], [18, 20], [16, 20]].map(|pair| nodes(&pair));
    let sets = [singles(&nodes(&[14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24])), pairs.into()].concat();
    let rows = errors_under(NOISE_MM, &fine, &key_nodes, std::slice::from_ref(&network), &sets, cases);
    let shares: Vec<f64> = rows
        .iter()
        .flat_map(|row| row.forces.iter().map(|scatter| scatter.coverage.expect("deviations").two_sigma))
        .collect();
    let covered = shares.iter().sum::<f64>() / shares.len() as f64;
    let refused: usize = rows.iter().map(|row| row.refused).sum();
    println!("{covered:.4} of the intervals, from {:?}, {refused} refused", shares);
    // Forces of a pair share their noise, so only cases count as independent.
    let chance = STANDARD_ERRORS * share_error(0.95, cases * sets.len());
    assert!((0.93 - chance..0.985 + chance).contains(&covered), "{covered}: {shares:?}");
    assert!(refused * 100 <= cases * sets.len(), "{refused} refused");
}

/// For sets of nodes without a network of their own, the network for any subset of the nodes is used. The network for any subset is better than
/// linear ridge regression, from which its training starts.
#[test]
fn the_network_for_any_nodes_beats_ridge() {
    let finger = paper();
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that read");
    let network = SensorOptions { networks, ..SensorOptions::of(EstimatorId::Network) };
    let (fine, key_nodes) = (fine_mesh(&finger).expect("a mesh"), Mesh::key_nodes(&finger));
    let ridge = SensorOptions::of(EstimatorId::Ridge);
    let sets = [&[15, 22][..], &[14, 18, 22], &[15, 16, 17], &[13, 16, 19, 22], &[14, 16, 18, 20, 22]];
    let sets: Vec<_> = sets.into_iter().map(nodes).collect();
    let rows = errors(&fine, &key_nodes, &[network, ridge], &sets, case_count(100, 2000));
    for pair in rows.chunks(2) {
        let [network, ridge] = pair else { panic!("a row for each estimator") };
        let [ours, theirs] = [network, ridge].map(|row| row.mean_error().expect("forces"));
        println!("{:?}: {:.1} %, ridge {:.1} %", network.nodes, 100.0 * ours, 100.0 * theirs);
        assert!(ours < 0.8 * theirs, "{network:?} {ridge:?}");
    }
}

/// The cards of the embedded networks agree with the recipes of the example `shipped_networks`.
#[test]
fn what_ships_was_trained_as_its_card_says() {
    let finger = paper();
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that read");
    let shipped = shipping(&finger);
    assert_eq!(shipped.len(), 16);
    for Shipping { name, recipe } in shipped {
        let network = networks.choose(&finger, &recipe.samples.contacts).expect("a network");
        let (card, origin) = (&network.card, &network.card.origin);
        assert_eq!(card.contacts, recipe.samples.contacts, "{name}");
        assert_eq!((card.scaling, card.noise_mm), (recipe.scaling, recipe.noise_mm), "{name}");
        assert_eq!((origin.samples, origin.seed), (recipe.count, recipe.seed), "{name}");
        assert_eq!(origin.kinematics, Kinematics::Corotational, "{name}");
        let widths: Vec<usize> = network.layers[..network.layers.len() - 1].iter().map(|layer| layer.outputs).collect();
        assert_eq!(widths, recipe.hidden_layers, "{name}");
    }
}

/// Networks are found for contacts in any order and for hidden markers, but not for other contacts.
#[test]
fn networks_are_found_by_their_contacts() {
    let finger = paper();
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that read");
    let name =
        |numbers: &[usize]| networks.choose(&finger, &at_nodes(numbers)).map(|network| network.card.contacts.len());
    for numbers in [[19, 20], [20, 19], [16, 17], [20, 18], [16, 20]] {
        assert_eq!(name(&numbers), Ok(2), "{numbers:?}");
    }
    for node in 14..=24 {
        assert_eq!(name(&[node]), Ok(1), "{node}");
    }
    for numbers in [&[13][..], &[17, 19], &[13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24]] {
        assert_eq!(name(numbers), Ok(12), "{numbers:?}");
    }
    let tilted = [at_node(19, 5.0)];
    assert_eq!(networks.choose(&finger, &tilted), Err(NoNetwork::Contacts("19@5".to_owned())));
    let other = paper_scene_with(&[("depth_mm = 20.0", "depth_mm = 21.0")]).finger;
    assert_ne!(other, finger);
    assert_eq!(networks.choose(&other, &at_nodes(&[19])), Err(NoNetwork::Finger));

    let bent = statics::solve(
        &fine_mesh(&finger).expect("a mesh"),
        &[at_nodes(&[19])[0].load(&finger, 2.0)],
        Kinematics::Corotational,
    );
    let seen = Measurement::of_shape(&finger, &bent.expect("an equilibrium")).without(&nodes(&[5, 13, 14, 22]));
    let network = networks.choose(&finger, &at_nodes(&[19])).expect("a network");
    let mut estimator = NetworkEstimator::new(network, &finger, &at_nodes(&[19]), &seen).expect("principal directions");
    let sensed = estimator.estimate(&seen, Some(CAMERA_NOISE_MM)).expect("an estimate");
    assert!((sensed.forces_n[0] - 2.0).abs() < 2.0 * sensed.sigmas_n[0], "{sensed:?}");
}
