//! What sensors know of a contact, and which markers they see.

use finray_model::finger::Plate;
use finray_model::sensing::{Contact, ContactPosition, ContactQuestion};
use finray_model::{Kinematics, NodeId, Scene};
use finray_studies::sampling::situation::ContactKnowledge;
use finray_studies::sampling::situation::HiddenMarkers;
use finray_studies::sampling::sweep::Grid;
use finray_studies::settings::{DIRECTION_OFF_DEG, POSITION_OFF_MM};
use finray_studies::truths::{MeshTruth, TruthId, fine_mesh, leaning};
use finray_tests::paper;

/// The contacts that a user assumes for a true contact.
fn misjudged(scene: &Scene, contact: Contact) -> Vec<ContactQuestion> {
    ContactKnowledge::Misjudged.questions(scene, contact)
}

/// The assumed contact deviates from the true contact to one side and then to the other side, unless it would leave the plate.
#[test]
fn an_assumed_contact_is_off_to_each_side_in_turn() {
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene");
    let length_mm = scene.finger.plate_length_mm(Plate::Front);
    for (s_mm, reached) in [(60.0, &[-1.0, 1.0][..]), (length_mm - 0.5, &[-1.0]), (1.0, &[1.0])] {
        let found = misjudged(&scene, Contact { position: ContactPosition::at(s_mm), angle_deg: 20.0 });
        let of_side = |side: &f64| {
            let position = ContactPosition::at(s_mm + side * POSITION_OFF_MM);
            [-DIRECTION_OFF_DEG, DIRECTION_OFF_DEG].map(|by_deg| Contact { position, angle_deg: 20.0 + by_deg }.into())
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
    let scene = Scene::from_toml(&small).expect("a scene");
    assert!(scene.finger.plate_length_mm(Plate::Front) < 2.0 * POSITION_OFF_MM);
    assert_eq!(misjudged(&scene, Contact { position: ContactPosition::at(1.0), angle_deg: 0.0 }).len(), 4);
}

/// The object hides a third of the front plate about the contact, and nothing else; the hidden tip is the last third of both plates.
#[test]
fn an_object_hides_a_contiguous_run_of_the_front_plate() {
    let finger = paper();
    let hidden =
        |hidden: HiddenMarkers, s_mm| hidden.nodes(&finger, s_mm).into_iter().map(|NodeId(node)| node).collect();
    let none: Vec<usize> = hidden(HiddenMarkers::None, 76.5);
    assert_eq!(none, Vec::<usize>::new());
    // Nodes of the front plate are 12.75 mm apart; node 19 is in the middle.
    let middle: Vec<usize> = hidden(HiddenMarkers::Object, 76.5);
    assert_eq!(middle, [17, 18, 19, 20, 21]);
    let tip: Vec<usize> = hidden(HiddenMarkers::Object, 153.0);
    assert_eq!(tip, [13, 14, 15]);
    // Nodes 9 and 17 lie at two thirds of the length, up to rounding.
    let third: Vec<usize> = hidden(HiddenMarkers::Tip, 76.5);
    assert!(
        (10..=16).all(|node| third.contains(&node)) && third.iter().all(|node| (9..=17).contains(node)),
        "{third:?}"
    );
}

/// The weights of a grid add up to the plate times the directions that friction allows, whatever the step is, and forces that friction does not allow
/// have none. The share that a fixed region covers then hardly depends on the grid.
#[test]
fn the_trusted_share_does_not_depend_on_the_step_of_the_grid() {
    let (scene, finger) = (Scene::of_finger(paper()), paper());
    let area = |contact: ContactKnowledge, positions, step_deg| {
        let (positions_mm, angles_deg) = Grid::of_knowledge(&scene, contact, positions, step_deg);
        let grid = Grid {
            positions_mm,
            angles_deg,
            is_leaning: contact.is_leaning(),
            forces_n: vec![1.0],
            noise_levels_mm: vec![0.0],
            noise_samples: 1,
            seed: 1,
        };
        let (lengths_mm, sectors_deg) = (grid.lengths_mm(&finger), grid.sectors_deg());
        let small: f64 = grid
            .angles_deg
            .iter()
            .zip(&sectors_deg)
            .filter(|(angle, _)| angle.abs() < 30.0)
            .map(|(_, part)| part)
            .sum();
        (lengths_mm.iter().sum::<f64>(), sectors_deg.iter().sum::<f64>(), small)
    };
    for (contact, cone_deg) in [
        (ContactKnowledge::Known, 90.0),
        (ContactKnowledge::Nothing, 90.0),
        (ContactKnowledge::Friction, 2.0 * 0.5_f64.atan().to_degrees()),
        (ContactKnowledge::Frictionless, 1.0),
    ] {
        for (positions, step_deg) in [(12, 20.0), (24, 10.0), (48, 5.0)] {
            let (length_mm, sector_deg, small_deg) = area(contact, positions, step_deg);
            assert!((length_mm - 153.0).abs() < 1e-9 && (sector_deg - cone_deg).abs() < 1e-9, "{contact} {sector_deg}");
            assert!((small_deg - sector_deg.min(60.0)).abs() <= step_deg, "{contact} {small_deg}");
        }
    }
}

/// A force that leans by an angle from the deformed normal has this angle to the plate's tangent after bending, on beams as on a truth that knows
/// only its key nodes.
#[test]
fn true_forces_lean_from_the_deformed_normal() {
    let finger = paper();
    let mesh = fine_mesh(&finger).expect("a mesh");
    let truth = MeshTruth::new(TruthId::Corotational, &mesh, Kinematics::Corotational).expect("a finger at rest");
    let mut turned_deg = 0.0_f64;
    for (node, lean_deg) in [(23, -45.0), (19, 0.0), (16, 30.0)] {
        let s_mm = finger.front_position_mm(NodeId(node)).expect("a contact node");
        let (contact, shape) = leaning(&truth, &finger, s_mm, lean_deg, 3.0).expect("an equilibrium");
        let normal_deg = shape.motion(NodeId(node)).rotation.to_degrees();
        assert!((contact.angle_deg - normal_deg - lean_deg).abs() < 2e-3, "{contact} {normal_deg}");
        turned_deg = turned_deg.max(normal_deg.abs());
    }
    assert!(turned_deg > 3.0, "{turned_deg} deg: the normals hardly turn");
}
