//! Shapes from MuJoCo as the true finger.

use crate::mujoco::exported;
use finray_model::NodeId;
use finray_model::sensing::Contact;
use finray_studies::truths::{MujocoTruth, NotExported, Truth, TruthError};
use finray_tests::{finger_of, paper};

#[test]
fn mujoco_as_truth_answers_for_what_was_exported_alone() {
    let truth = MujocoTruth::new(&paper()).expect("the paper's finger was exported");
    let (positions, angles) = truth.positions(&[3.0]).expect("exported").expect("not everywhere");
    assert_eq!(positions.len(), 12);
    assert_eq!(angles, [-60.0, -30.0, 0.0, 30.0, 60.0]);
    let contact = Contact { angle_deg: -30.0, ..Contact::at_node(NodeId(19)) };
    let case = exported("paper").cases().expect("a table");
    let case = case.iter().find(|c| (c.node, c.angle_deg, c.force_n) == (NodeId(19), -30.0, 3.0)).expect("the case");
    assert_eq!(truth.shapes(&contact, &[1.0, 3.0])[1], case.shape);
    assert_eq!(truth.shapes(&contact, &[1.0, 2.0]).len(), 1);
    assert!(truth.shapes(&Contact { angle_deg: -31.0, ..contact }, &[1.0]).is_empty());
    assert!(matches!(truth.positions(&[3.0, 2.0]), Err(TruthError::NotExported(NotExported::Force { .. }))));
    let steel = finger_of(finray_fixtures::SPRING_STEEL_SCENE);
    assert!(matches!(MujocoTruth::new(&steel), Err(NotExported::Finger)));
}
