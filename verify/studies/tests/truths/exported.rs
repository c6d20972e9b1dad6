//! Shapes from other programs as the true finger.

use crate::exports::mujoco::exported;
use finray_model::finger::{Finger, FingerDescription};
use finray_model::sensing::Contact;
use finray_model::{NodeId, Scene};
use finray_studies::exports::{Program, calculix, mujoco};
use finray_studies::truths::{ExportedTruth, NotExported, Truth, TruthError, TruthId};
use finray_tests::{finger_of, paper};

fn mujoco_truth(finger: &Finger) -> Result<ExportedTruth, NotExported> {
    ExportedTruth::new(TruthId::Mujoco, &mujoco::PROGRAM, finger)
}

#[test]
fn mujoco_as_truth_answers_for_what_was_exported_alone() {
    let truth = mujoco_truth(&paper()).expect("the paper's finger was exported");
    let (positions, angles) = truth.positions(&[3.0]).expect("exported").expect("not everywhere");
    assert_eq!(positions.len(), 12);
    assert_eq!(angles, [-60.0, -30.0, 0.0, 30.0, 60.0]);
    let contact = Contact { angle_deg: -30.0, ..Contact::at_node(NodeId(19)) };
    let case = exported("paper").cases().expect("a table");
    let case = case.iter().find(|c| (c.node, c.angle_deg, c.force_n) == (NodeId(19), -30.0, 3.0)).expect("the case");
    assert_eq!(truth.shapes(&contact, &[1.0, 3.0])[1], case.shape);
    assert_eq!(truth.shapes(&contact, &[1.0, 2.0]).len(), 1);
    assert!(truth.shapes(&Contact { angle_deg: -31.0, ..contact }, &[1.0]).is_empty());
    assert!(matches!(
        truth.positions(&[3.0, 2.0]),
        Err(TruthError::NotExported(TruthId::Mujoco, NotExported::Force { .. }))
    ));
    let steel = finger_of(finray_fixtures::SPRING_STEEL_SCENE);
    assert!(matches!(mujoco_truth(&steel), Err(NotExported::Finger(_))));
    assert!(
        mujoco_truth(&paper().with_modulus_factor(1.2).expect("a finger")).is_err(),
        "MuJoCo's springs have the scene's stiffness"
    );
}

#[test]
fn a_continuum_answers_for_what_was_exported_alone() {
    let truth = ExportedTruth::new(TruthId::Continuum, &calculix::PROGRAM, &paper()).expect("the paper's finger");
    let (positions, angles) = truth.positions(&[0.5, 1.0, 3.0, 5.0]).expect("exported").expect("not everywhere");
    assert_eq!((positions.len(), angles), (12, vec![-40.0, -20.0, 0.0, 20.0, 40.0]));
    assert_eq!(truth.shapes(&Contact::at_node(NodeId(19)), &[0.5, 1.0, 3.0, 5.0]).len(), 4);
    assert!(truth.positions(&[2.0]).is_err());
    // CalculiX found no equilibrium of this finger under 5 N at the middle of the plate.
    let thin = finger_of(finray_fixtures::CONTINUUM_THIN_SCENE);
    let truth = ExportedTruth::new(TruthId::Continuum, &calculix::PROGRAM, &thin).expect("the thin finger");
    assert_eq!(truth.shapes(&Contact::at_node(NodeId(18)), &[0.5, 1.0, 3.0, 5.0]).len(), 3);
}

fn export(program: &Program, finger: &Finger) -> Option<&'static str> {
    program.export_of(finger).map(|export| export.name)
}

/// A beam model whose material and arms differ from those of the printed finger still belongs to this finger. Another drawing is another finger.
#[test]
fn the_continuum_belongs_to_the_drawing_and_not_to_what_beams_assume() {
    let printed = finger_of(finray_fixtures::CONTINUUM_PAPER_SCENE);
    let beams = paper();
    let continuum = |finger: &Finger| export(&calculix::PROGRAM, finger);
    let changed = |change: &dyn Fn(&mut FingerDescription)| {
        let mut description = printed.description().clone();
        change(&mut description);
        Finger::new(description).expect("a finger")
    };
    for finger in [&printed, &beams, &beams.with_modulus_factor(1.617).expect("a finger")] {
        assert_eq!(continuum(finger), Some("paper"));
    }
    assert_eq!(
        continuum(&finger_of(finray_fixtures::SOFT_ZONE_SCENE)),
        Some("soft-zone"),
        "zones, without nu and arms"
    );
    assert_eq!(continuum(&finger_of(finray_fixtures::ASYMMETRIC_SCENE)), Some("asymmetric"));
    for name in ["thick", "thin", "hinged", "hinged-rigid"] {
        let export = calculix::PROGRAM.fingers.iter().find(|export| export.name == name).expect("a finger");
        assert_eq!(continuum(&export.finger().expect("a scene")), Some(name));
    }
    let others: [&dyn Fn(&mut FingerDescription); 5] = [
        &|d| d.depth_mm = 21.0,
        &|d| d.front.thickness_mm = 1.4,
        &|d| d.back.youngs_modulus_mpa *= 1.1,
        &|d| d.rigid_ends[0].tip_mm = 5.0,
        &|d| d.zones = finger_of(finray_fixtures::TWIN_SCENE).description().zones.clone(),
    ];
    for (i, change) in others.iter().enumerate() {
        assert_eq!(continuum(&changed(change)), None, "change {i}");
    }
    // Scaling the modulus in the scene's text gives the same finger as a modulus factor, up to rounding.
    let text = finray_fixtures::PAPER_SCENE.replace("47.976", &(47.976 * 1.6).to_string());
    assert_eq!(continuum(&Scene::from_toml(&text).expect("a scene").finger), Some("paper"));
}
