//! Equilibria of fingers and object satisfy the laws of statics.

use super::energy::object;
use finray_contact::outline::ContactOutline;
use finray_contact::{Drive, GraspFailure, TouchedBody, World};
use finray_model::gripper::Placement;
use finray_model::scene::ObjectMotion;
use finray_model::{Mesh, Scene, Vector};
use finray_studies::experiments::grasp::{Eyes, GraspEnd, GraspScene, GraspStep, Phase};
use std::f64::consts::FRAC_PI_2;

/// Number of elements of each member.
const FINENESS: usize = 2;
/// Share of the weight up to which the solver leaves forces at rest undetermined: friction depends on the path within this share.
const AT_REST: f64 = 1e-5;

fn grasp(text: &str) -> GraspScene {
    GraspScene::new(&Scene::from_toml(text).unwrap(), &[]).unwrap().with_fineness(FINENESS)
}

pub(super) fn steps_of(scene: &GraspScene, noise_mm: f64, seed: u64) -> (Vec<GraspStep>, GraspEnd) {
    let mut steps = Vec::new();
    let ended = scene.run(&Eyes::Noise(noise_mm), seed, |step| steps.push(step.clone())).unwrap();
    (steps, ended)
}

/// Text of the disc scene, with some lines changed.
pub(super) fn disc(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(finray_fixtures::GRASPED_DISC_SCENE.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

/// Forces on the object and on the bases balance. Both fingers press with equal forces, wherever the disc starts, and each finger carries half of the
/// disc's weight.
#[test]
fn a_carried_disc_is_in_balance_between_equal_fingers() {
    let (steps, ended) = steps_of(&grasp(finray_fixtures::GRASPED_DISC_SCENE), 0.0, 1);
    assert_eq!(ended, GraspEnd::Done);
    let phases = [Phase::Approach, Phase::Close, Phase::Lift, Phase::Carry, Phase::Place, Phase::Open];
    let mut seen: Vec<Phase> = steps.iter().map(|step| step.phase).collect();
    seen.dedup();
    assert_eq!(seen, phases);
    for step in &steps {
        assert!(step.imbalance <= 1e-5, "step {}: {}", step.step, step.imbalance);
        let [left, right] = step.fingers.each_ref().map(|finger| finger.on_object);
        if step.support_force.norm() == 0.0 {
            assert!((left.x + right.x).abs() <= 1e-6 * left.x, "step {}", step.step);
            assert!(
                (left.y - right.y).abs() <= AT_REST * step.weight.norm()
                    && (left.y + 0.5 * step.weight.y).abs() <= AT_REST * step.weight.norm()
            );
        }
    }
    let carried = steps.iter().find(|step| step.phase == Phase::Carry).unwrap();
    assert!(carried.support_force.norm() == 0.0 && carried.fingers[0].total_n > 1.0);
    // The gripper puts the disc down at x = 60 mm.
    let end = steps.last().unwrap();
    assert!((end.object[0] - 60.0).abs() < 1e-3 && (end.object[1] - 110.0).abs() < 1e-3, "{:?}", end.object);
}

/// Without friction, there is no hysteresis: while the disc is on its support, opening and closing have equal forces at each motor angle.
#[test]
fn without_friction_opening_retraces_closing() {
    let smooth = disc(&[
        ("friction = 0.4", "friction = 0.0"),
        ("motor_deg = [0.0, -495.0]", "motor_deg = [0.0, -382.5]"),
        ("path_mm = [[0.0, -40.0], [60.0, -40.0], [60.0, 0.0]]\npath_steps = 12", "open = true"),
    ]);
    let (steps, ended) = steps_of(&grasp(&smooth), 0.0, 1);
    assert_eq!(ended, GraspEnd::Done);
    let closing: Vec<&GraspStep> = steps.iter().filter(|step| step.phase == Phase::Close).collect();
    assert!(closing.len() > 8);
    for there in &closing[..closing.len() - 1] {
        let back = steps.iter().find(|step| step.phase == Phase::Open && step.motor_deg == there.motor_deg).unwrap();
        for finger in 0..2 {
            let [a, b] = [there, back].map(|step| step.fingers[finger].total_n);
            assert!((a - b).abs() <= 1e-4 * closing.last().unwrap().fingers[finger].total_n, "{a} and {b} N");
        }
    }
    let end = steps.last().unwrap();
    assert!(end.energy.friction_nmm.abs() < 1e-9 && end.energy.elastic_nmm.abs() < 1e-9, "{:?}", end.energy);
}

/// A failed grasp ends with the reason of its failure.
#[test]
fn what_goes_wrong_is_named() {
    let ended = |changes: &[(&str, &str)]| steps_of(&grasp(&disc(changes)), 0.0, 1).1;
    let wide = [("motor_deg = [0.0, -495.0]", "motor_deg = [450.0, 225.0]")];
    assert_eq!(ended(&wide), GraspEnd::OutOfReach { motor_deg: 225.0 });
    let weak = [("motor_deg = [0.0, -495.0]", "motor_deg = [0.0, -270.0]\nuntil_force_n = 1.0")];
    assert!(matches!(ended(&weak), GraspEnd::TooWeak { sensed_n, .. } if sensed_n > 0.1 && sensed_n < 1.0));
    // The object has a mass of 2 kg and a friction coefficient of 0.05, and the fingers press with 1 N.
    let heavy = [("friction = 0.4", "friction = 0.05"), ("mass_g = 60.0", "mass_g = 2000.0")];
    let lost = ended(&heavy);
    // The grasp ends after the object has slipped by half of its radius of 15 mm.
    assert!(matches!(lost, GraspEnd::Slipped { slid_mm } if slid_mm > 7.5), "{lost:?}");
}

/// A slippery disc of 500 g without support falls out of the fingers, and a squeezed wedge near the fingertips folds a finger.
#[test]
fn drops_and_folds_are_named() {
    let ended = |scene: &GraspScene| steps_of(scene, 0.0, 1).1;
    let slippery = disc(&[
        ("friction = 0.4", "friction = 0.02"),
        ("mass_g = 60.0", "mass_g = 500.0"),
        ("path_mm = [[0.0, -40.0], [60.0, -40.0], [60.0, 0.0]]\npath_steps = 12", "support = false"),
    ]);
    assert_eq!(ended(&grasp(&slippery).with_fineness(1)), GraspEnd::Halted(GraspFailure::Dropped));
    let squeezed = object("wedge", |scene| {
        let (grasp, object) = (scene.grasp.as_mut().unwrap(), scene.object.as_mut().unwrap());
        (grasp.motor_deg, grasp.path_mm, grasp.opens) = ([225.0, -900.0], Vec::new(), false);
        let ObjectMotion::Free { centre_mm, .. } = &mut object.motion else { unreachable!() };
        *centre_mm = Vector::new(0.0, 135.0);
    });
    assert_eq!(ended(&squeezed.with_fineness(1)), GraspEnd::Halted(GraspFailure::Folded));
}

/// A disc that is pushed by one finger rolls away on its support, or slides if there is no friction. Despite rounding errors of the forces, only the
/// support counts as a contact. As soon as both fingers touch the disc, both press.
#[test]
fn what_moves_freely_is_not_touched() {
    for friction in ["friction = 0.4", "friction = 0.0"] {
        let (steps, _) = steps_of(&grasp(&disc(&[("friction = 0.4", friction)])), 0.0, 1);
        let pushed = steps.iter().filter(|step| (step.object[0] - 3.0).abs() > 1e-3 && step.fingers[0].total_n < 1e-3);
        let mut count = 0;
        for step in pushed.filter(|step| matches!(step.phase, Phase::Approach | Phase::Close)) {
            assert!(step.fingers.iter().all(|finger| finger.contacts.is_empty()), "{friction}, step {}", step.step);
            count += 1;
        }
        assert!(count > 0, "{friction}");
        for force_n in steps.iter().flat_map(|step| &step.fingers).flat_map(|of| &of.contacts).map(|of| of.force.norm())
        {
            // The weight of the disc is 0.6 N.
            assert!(force_n > 1e-6, "{friction}: {force_n}");
        }
    }
}

/// A force below 1e-5 of the weight does not count as a contact; a force ten times as large does. A finger pushes a box, which cannot roll, with
/// forces of 1e-4 and 1e-6 of the box's weight. The force on the finger's base is correct whether or not the contact counts.
#[test]
fn a_force_that_is_nothing_beside_the_weight_is_no_contact() {
    const WEIGHT_N: f64 = 1.0;
    const LEAST_N: f64 = 1e-5 * WEIGHT_N;
    const STEP_MM: f64 = 0.01;
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).unwrap().finger;
    let mesh = Mesh::with_elements_per_member(&finger, 1);
    // The finger hangs to the left of the box, with its front towards the box.
    let drive = |x_mm: f64| Drive {
        placements: vec![Placement { origin: Vector::new(x_mm, 60.0), angle_rad: -FRAC_PI_2, mirrored: false }],
        weight: Vector::new(0.0, -WEIGHT_N),
        gripper: Vector::zeros(),
    };
    let corners = [[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]].map(|[x, y]| Vector::new(x, y));
    let support = Some((Vector::zeros(), Vector::y()));
    let mut x_mm = -25.0;
    let object = (ContactOutline::polygon(&corners), 0.5);
    let mut world = World::new(&[&mesh], 1.5, object, [0.0; 3], drive(x_mm), support).unwrap();
    let pushed_n = |world: &World| world.on_base(0).0.norm();
    while pushed_n(&world) < 10.0 * LEAST_N {
        x_mm += STEP_MM;
        world.advance(&drive(x_mm)).unwrap();
    }
    let before_n = pushed_n(&world);
    x_mm += STEP_MM;
    world.advance(&drive(x_mm)).unwrap();
    let stiffness = (pushed_n(&world) - before_n) / STEP_MM;
    for (force_n, touching) in [(10.0 * LEAST_N, 1), (0.1 * LEAST_N, 0)] {
        // The rod first slides on the box, and sticks when the finger moves back. A sliding rod and a sticking rod have different stiffnesses, so
        // several corrections of the finger's position are needed.
        for _ in 0..12 {
            x_mm += (force_n - pushed_n(&world)) / stiffness;
            world.advance(&drive(x_mm)).unwrap();
        }
        assert!((pushed_n(&world) / force_n - 1.0).abs() < 0.1, "{} and {force_n} N", pushed_n(&world));
        let contacts = world.contacts();
        let of_finger = contacts.iter().filter(|contact| contact.partner == TouchedBody::Finger(0));
        assert_eq!(of_finger.count(), touching, "{force_n} N: {contacts:?}");
    }
}

/// The requested force is reached, and held on the path despite friction.
#[test]
fn a_force_is_reached_and_held() {
    let held = disc(&[(
        "motor_deg = [0.0, -495.0]",
        "motor_deg = [0.0, -800.0]\nuntil_force_n = 1.6\nhold = true\nframes_per_s = 25.0",
    )]);
    let (steps, ended) = steps_of(&grasp(&held), 0.01, 1);
    assert_eq!(ended, GraspEnd::Done);
    let figures = finray_studies::experiments::grasp::loop_figures(&steps, 1.6, Some(30.0)).unwrap();
    assert!(figures.largest_error < 0.05 && figures.overshoot < 0.05, "{figures:?}");
    assert!(figures.rise_s.unwrap() > 0.0);
}

/// A triangle rests on its support; the reference point of the triangle is in a corner. By the lever rule about its centroid, one corner carries two
/// thirds of the weight and the other corner one third.
#[test]
fn a_triangle_rests_on_its_corners_by_the_lever_rule() {
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE).unwrap().finger;
    let mesh = Mesh::with_elements_per_member(&finger, 1);
    let far = Placement { origin: Vector::new(1e3, 0.0), ..Placement::IDENTITY };
    let drive = Drive { placements: vec![far], weight: Vector::new(0.0, -1.0), gripper: Vector::zeros() };
    let triangle = ContactOutline::polygon(&[Vector::zeros(), Vector::new(30.0, 0.0), Vector::new(0.0, 20.0)]);
    let support = Some((Vector::zeros(), Vector::new(0.0, 1.0)));
    let mut world = World::new(&[&mesh], 1.5, (triangle, 0.5), [0.0; 3], drive.clone(), support).unwrap();
    world.advance(&drive).unwrap();
    let contacts = world.contacts();
    assert_eq!(contacts.len(), 2);
    for contact in contacts {
        let share = if contact.point.x < 15.0 { 2.0 / 3.0 } else { 1.0 / 3.0 };
        assert!((contact.force - Vector::new(0.0, share)).norm() < 1e-5, "{:?}", contact.force);
    }
}
