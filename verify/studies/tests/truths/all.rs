//! Properties of every model of the true finger.

use finray_model::Scene;
use finray_studies::truths::TruthId;
use finray_tests::at_node;

/// A true finger may be softer at its ends or have another discretisation. The displacement of a true finger still differs from that of the linear
/// finger by less than this factor.
const SOFTER: f64 = 2.0;

/// Under 1 N in the middle, every true finger moves in the direction of the force, by about as much as the linear finger. The finger is the paper's;
/// for the continuum, with the continuum's material and arms.
#[test]
fn every_truth_bends_away_from_a_force() {
    let contact = at_node(19, 0.0);
    let moved = |id: TruthId, scene: &Scene| {
        let mesh = id.mesh(&scene.finger).unwrap_or_else(|error| panic!("{id}: {error}"));
        let truth = id.on(&mesh, scene).unwrap_or_else(|error| panic!("{id}: {error}"));
        assert_eq!(truth.id(), id);
        let shapes = truth.shapes(&contact, &[1.0]);
        assert_eq!(shapes.len(), 1, "{id}");
        shapes[0].motion(finray_model::NodeId(19)).displacement.dot(&scene.finger.direction(0.0))
    };
    for &id in TruthId::ALL {
        let scene = match id {
            TruthId::Continuum => finray_fixtures::CONTINUUM_PAPER_SCENE,
            _ => finray_fixtures::PAPER_SCENE,
        };
        let scene = Scene::from_toml(scene).expect("a scene");
        let over_linear = moved(id, &scene) / moved(TruthId::Linear, &scene);
        assert!((1.0 / SOFTER..SOFTER).contains(&over_linear), "{id}: {over_linear}");
    }
}
