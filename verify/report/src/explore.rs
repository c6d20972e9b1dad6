//! Data of the interactive section: the report's numbers in the form that the section's script reads.

use super::maps::small;
use crate::prelude::*;
use finray_contact::press::{SensedContact, contacts_sensed};
use finray_model::finger::FingerPoint;
use finray_studies::experiments::contact_scene::study::{SceneStudy, StudiedStep};
use finray_studies::experiments::explain::{CAUSES, Explanation, ExplanationMap};
use finray_studies::sampling::situation::ContactKnowledge;
use serde_json::{Value, json};

/// The data as JSON without `<`, so that it can be embedded in the page.
pub(super) fn data(Results { study, .. }: Results) -> String {
    let finger = &study.finger;
    let noisy = study.noise_mm > 0.0;
    // The recommended estimator is listed first, so that it is the initial choice.
    let mut estimators = EstimatorId::ALL.to_vec();
    estimators.sort_by_key(|estimator| !estimator.searches());
    let all = TruthId::ALL.iter().flat_map(|truth| estimators.iter().map(|estimator| (*truth, *estimator)));
    let known = all.filter_map(|(truth, estimator)| small(study, truth, estimator, noisy));
    // The unknown contact is listed first.
    let maps: Vec<Value> = study.situations.iter().cloned().chain(known).map(|map| of_map(finger, &map)).collect();
    let off = ContactKnowledge::Misjudged.label();
    let pairs = study.noise.iter().flat_map(|noise| noise.pairs.iter().zip(&noise.linear_pairs).map(of_pair));
    let points = drawn_points(&study.finger);
    let shape = |touched: &finray_studies::experiments::shapes::TouchedFinger| {
        let xy: Vec<Value> = points.iter().map(|at| point(&touched.shape.point(*at))).collect();
        json!({"truth": touched.truth.label(), "node": touched.node, "angle_deg": touched.angle_deg, "force_n": touched.force_n, "xy": xy})
    };
    let data = json!({
        "finger": of_finger(finger, study.noise_mm),
        "about": super::page::about(),
        "maps": maps,
        "causes": [of_causes(&study.explanations, off)],
        "shapes": study.touched.iter().map(shape).collect::<Vec<Value>>(),
        "pairs": pairs.collect::<Vec<Value>>(),
        "scenes": study.contact_scenes.iter().map(|scene| of_scene(finger, scene)).collect::<Vec<Value>>(),
    });
    data.to_string().replace('<', "\\u003c")
}

/// A number rounded to four significant digits.
fn number(value: f64) -> Value {
    format!("{value:.3e}").parse::<f64>().ok().filter(|rounded| rounded.is_finite()).into()
}

fn point(at: &Vector) -> Value {
    json!([number(at.x), number(at.y)])
}

/// Points of the drawn finger: key nodes in their order, then the joints between ribs and brackets.
fn drawn_points(finger: &Finger) -> Vec<FingerPoint> {
    let mut points: Vec<FingerPoint> =
        (1..=finger.key_node_count()).map(|node| FingerPoint::Node(NodeId(node))).collect();
    let lines = finger.outline();
    let hinges = lines.iter().flat_map(|(_, line)| line).filter(|at| matches!(at, FingerPoint::Hinge(_)));
    points.extend(hinges);
    points
}

fn of_finger(finger: &Finger, noise_mm: f64) -> Value {
    let points = drawn_points(finger);
    let nodes: Vec<Value> = points.iter().map(|at| point(&finger.point(*at))).collect();
    let number_of = |named: FingerPoint| points.iter().position(|at| *at == named).map(|index| index + 1);
    let lines = finger.outline();
    let pairs = lines.iter().flat_map(|(_, line)| line.windows(2));
    let members: Vec<[usize; 2]> = pairs.filter_map(|ends| Some([number_of(ends[0])?, number_of(ends[1])?])).collect();
    let contacts = finger.contact_nodes().rev().filter_map(|node| Some((node, finger.front_position_mm(node)?)));
    let contacts: Vec<Value> = contacts.map(|(node, s_mm)| json!({"node": node.0, "s_mm": number(s_mm)})).collect();
    json!({
        "nodes": nodes, "members": members, "contacts": contacts,
        "front_mm": number(finger.plate_length_mm(Plate::Front)), "noise_mm": noise_mm,
    })
}

fn of_map(finger: &Finger, map: &AccuracyMap) -> Value {
    let values =
        |of: fn(&MapCell) -> Option<f64>| map.cells.iter().map(|cell| of(cell).map(number)).collect::<Vec<_>>();
    let counts = |of: fn(&MapCell) -> usize| map.cells.iter().map(of).collect::<Vec<usize>>();
    let request = &map.request;
    json!({
        "truth": map.truth.label(), "estimator": map.estimator.label(), "contact": map.situation.to_string(),
        "csv": super::maps::map_csv_name(map),
        "s_mm": request.positions_mm, "angle_deg": request.angles_deg, "force_n": request.forces_n,
        "weight": map.worst(finger).iter().map(|cell| number(cell.weight)).collect::<Vec<Value>>(),
        "error": values(|cell| cell.mean_error), "bias": values(|cell| cell.bias), "spread": values(|cell| cell.spread),
        "samples": counts(|cell| cell.samples), "answered": counts(|cell| cell.answered),
    })
}

/// The largest cause of error of an assumed contact in each cell, to first order, and its share of the mean square.
fn of_causes(map: &ExplanationMap, off: &str) -> Value {
    let errors = || map.cells.iter().map(Explanation::errors);
    let share = |errors: [f64; 3]| {
        number(errors[super::causes::largest(errors)].powi(2) / errors.iter().map(|error| error * error).sum::<f64>())
    };
    json!({
        "truth": TruthId::Corotational.label(), "estimator": EstimatorId::Nonlinear.label(), "practice": "to first order", "contact": off,
        "s_mm": map.positions_mm, "angle_deg": map.angles_deg, "force_n": map.force_n,
        "cause": errors().map(|errors| errors.map(|errors| CAUSES[super::causes::largest(errors)])).collect::<Vec<_>>(),
        "share": errors().map(|errors| errors.map(share)).collect::<Vec<_>>(),
    })
}

/// Data of a pair of contacts, for each of two estimators: mean error of the two single forces, and mean error of the sum of the forces.
fn of_pair((nonlinear, linear): (&ScatterRow, &ScatterRow)) -> Value {
    let errors = |row: &ScatterRow| json!([row.mean_error().map(number), row.sum.map(|sum| number(sum.mean_error))]);
    let of = |row: &ScatterRow| (row.estimator.label().to_owned(), errors(row));
    let mut pair = serde_json::Map::from_iter([nonlinear, linear].map(of));
    pair.insert("nodes".to_owned(), json!(nonlinear.nodes));
    Value::Object(pair)
}

/// Steps of a pressed object. For each contact, a step contains the true force along the true normal, and the force along the measured normal that
/// was sensed from one noise sample.
fn of_scene(finger: &Finger, scene: &SceneStudy) -> Value {
    let step = |studied: &StudiedStep| {
        let pressed = &studied.step.pressed;
        let bent = drawn_points(finger).into_iter().map(|at| point(&pressed.shape.point(at)));
        let sensed = studied.noisy.as_ref().ok().and_then(Option::as_ref);
        let contacts = contacts_sensed(&studied.step.contacts, sensed).map(|(seen, sensed)| {
            let along = |of: &SensedContact| point(&(of.read.contact.direction(finger) * of.force.sensed_n));
            json!({
                "x": number(seen.point.x), "y": number(seen.point.y),
                "true": point(&(seen.contact.direction(finger) * seen.normal_n)),
                "sensed": sensed.as_ref().map(along), "sigma_n": sensed.as_ref().map(|of| number(of.force.sigma_n)),
            })
        });
        json!({
            "travel_mm": number(studied.step.travel_mm),
            "xy": bent.collect::<Vec<Value>>(),
            "outline": scene.outline.iter().map(|corner| point(&(corner + pressed.object))).collect::<Vec<Value>>(),
            "contacts": contacts.collect::<Vec<Value>>(),
        })
    };
    json!({"name": scene.name, "steps": scene.steps.iter().map(step).collect::<Vec<Value>>()})
}
