//! Properties of every model of the true finger.

use finray_studies::truths::TruthId;
use finray_tests::{at_node, paper};

/// A true finger may be softer at its ends or have another discretisation. The displacement of a true finger still differs from that of the linear
/// finger by less than this factor.
const SOFTER: f64 = 2.0;

/// Under 1 N in the middle, every true finger moves in the direction of the force, by about as much as the linear finger.
#[test]
fn every_truth_bends_away_from_a_force() {
    let finger = paper();
    let contact = at_node(19, 0.0);
    let moved = |id: TruthId| {
        let mesh = id.mesh(&finger).unwrap_or_else(|error| panic!("{id}: {error}"));
        let truth = id.on(&mesh).unwrap_or_else(|error| panic!("{id}: {error}"));
        assert_eq!(truth.id(), id);
        let shapes = truth.shapes(&contact, &[1.0]);
        assert_eq!(shapes.len(), 1, "{id}");
        shapes[0].motion(finray_model::NodeId(19)).displacement.dot(&finger.direction(0.0))
    };
    let linear = moved(TruthId::Linear);
    for &id in TruthId::ALL {
        let over_linear = moved(id) / linear;
        assert!((1.0 / SOFTER..SOFTER).contains(&over_linear), "{id}: {over_linear}");
    }
}
