//! Energy balance of grasps with every object: the motor's work is stored, or dissipated by friction or by resistance during snaps.

use super::world::steps_of;
use finray_model::Scene;
use finray_studies::experiments::contact_scene::file::load_scene_with_outline;
use finray_studies::experiments::grasp::{GraspEnd, GraspScene, GraspStep, Phase};
use finray_tests::is_full_study;
use std::path::{Path, PathBuf};

/// Name of each object, and whether its equilibrium snaps during the grasp.
const OBJECTS: [(&str, bool); 8] = [
    ("disc", false),
    ("ball", false),
    ("bottle", false),
    ("box", true),
    ("egg", true),
    ("hollow", true),
    ("mouse", true),
    ("wedge", true),
];
/// Objects that only the full study grasps, because each takes as long as several others. A quick study only closes the gripper on the wedge, in the
/// test of long motor steps below.
const LONG: [&str; 2] = ["mouse", "wedge"];
/// Number of elements of each member. The energy balance holds for a mesh of any fineness.
const FINENESS: usize = 2;
/// Tolerance of missing energy, as a share of the largest elastic energy. Work is integrated by the trapezoidal rule. An increment is halved if its
/// missing energy exceeds 1/10 000 of the energy that bends a finger by the object's size. The missing energies of all increments add up.
const MISSING: f64 = 0.01;
/// Tolerance for rounding in sums of works that cancel.
const ROUNDING: f64 = 1e-12;
/// Limit of the work against the numerical resistance in a grasp without a snap, as a share of the largest elastic energy. The resistance holds an
/// object without contacts, and slows the object while it comes to rest.
const RESISTANCE: f64 = 1e-3;

/// The scene of the named object, modified by `change`.
pub(super) fn object(name: &str, change: impl Fn(&mut Scene)) -> GraspScene {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/scenes/grasp");
    let mut given = load_scene_with_outline(&folder.join(format!("{name}.toml"))).unwrap();
    change(&mut given.scene);
    GraspScene::new(&given.scene, &given.corners).unwrap().with_fineness(FINENESS)
}

fn most_elastic_nmm(steps: &[GraspStep]) -> f64 {
    steps.iter().map(|step| step.energy.elastic_nmm).fold(0.0, f64::max)
}

/// Checks that the missing energy of every step is within the stated error, and that lost energy never returns.
fn assert_accounted_for(name: &str, steps: &[GraspStep]) {
    let stored_nmm = most_elastic_nmm(steps);
    let mut lost_nmm = 0.0;
    for step in steps {
        let energy = &step.energy;
        let most_nmm = energy.error_nmm + ROUNDING * stored_nmm;
        assert!(energy.missing_nmm().abs() <= most_nmm, "{name}, step {}: {energy:?}", step.step);
        assert!(energy.lost_nmm() >= lost_nmm - energy.error_nmm, "{name}, step {}: {energy:?}", step.step);
        lost_nmm = f64::max(lost_nmm, energy.lost_nmm());
    }
    let end = &steps.last().unwrap().energy;
    assert!(end.error_nmm <= MISSING * stored_nmm, "{name}: {end:?} of {stored_nmm}");
    assert!(end.created_nmm <= end.error_nmm, "{name}: {end:?}");
    assert!(end.resistance_nmm >= 0.0, "{name}: {end:?}");
}

/// Checks every step of every object. Without a snap, energy is lost only by friction. The full study includes all objects, and its members have two
/// elements.
#[test]
fn energy_is_never_created() {
    let is_full = is_full_study();
    for (name, snaps) in OBJECTS.into_iter().filter(|(name, _)| is_full || !LONG.contains(name)) {
        let scene = object(name, |_| ()).with_fineness(if is_full { FINENESS } else { 1 });
        let (steps, ended) = steps_of(&scene, 0.0, 1);
        assert_eq!(ended, GraspEnd::Done, "{name}");
        assert_accounted_for(name, &steps);
        let lost_nmm = steps.last().unwrap().energy.resistance_nmm;
        assert!(snaps || lost_nmm <= RESISTANCE * most_elastic_nmm(&steps), "{name}: {lost_nmm}");
    }
}

/// After closing and opening, no elastic energy remains, so the motor's work equals the work of friction and numerical resistance, within the stated
/// error.
#[test]
fn the_work_of_a_cycle_is_that_of_friction() {
    let (steps, _) = steps_of(&object("disc", |_| ()), 0.0, 1);
    let end = &steps.last().unwrap().energy;
    assert!(end.elastic_nmm.abs() < 1e-9 && end.lifted_nmm.abs() < 1e-3 && end.friction_nmm > 1.0, "{end:?}");
    let lost_nmm = end.friction_nmm + end.resistance_nmm;
    assert!((end.driven_nmm - lost_nmm).abs() <= end.error_nmm && end.error_nmm < 0.02 * lost_nmm, "{end:?}");
}

/// While the gripper closes, steps a third as long give the same forces at equal motor angles. For a wedge, the force was once 5.9 N instead of 5.3
/// N. A long step had ended in another equilibrium, which would need energy from outside. The full study also includes other objects that rotate or
/// slip.
#[test]
fn a_long_motor_step_does_not_end_in_another_equilibrium() {
    /// Tolerance of a finger's total force, as a share of the largest total force. Friction is computed from the slip of a whole increment.
    const TOLERANCE: f64 = 0.01;
    /// With two elements of each member, the wedge snaps, and friction after the snap depends on the moment of the snap within the motor's step.
    const FINENESS: usize = 3;
    let names = if is_full_study() { &["wedge", "disc", "egg", "hollow"][..] } else { &["wedge"] };
    for &name in names {
        let closing = |step_deg: f64| {
            let scene = object(name, |scene| {
                let grasp = scene.grasp.as_mut().unwrap();
                (grasp.step_deg, grasp.until_force_n, grasp.holds) = (step_deg, None, false);
                (grasp.path_mm, grasp.opens) = (Vec::new(), false);
            })
            .with_fineness(FINENESS);
            steps_of(&scene, 0.0, 1).0
        };
        let (long, short) = (closing(22.5), closing(7.5));
        assert_accounted_for(name, &long);
        assert_accounted_for(name, &short);
        let largest_n = long.iter().map(|step| step.fingers[0].total_n).fold(0.0, f64::max);
        let mut compared = 0;
        for step in long.iter().filter(|step| step.phase == Phase::Close) {
            let Some(same) = short.iter().find(|other| (other.motor_deg - step.motor_deg).abs() < 1e-6) else {
                continue;
            };
            for (a, b) in step.fingers.iter().zip(&same.fingers) {
                assert!(
                    (a.total_n - b.total_n).abs() <= TOLERANCE * largest_n,
                    "{name} at {}: {} and {} N",
                    step.motor_deg,
                    a.total_n,
                    b.total_n
                );
            }
            compared += 1;
        }
        assert!(compared >= 5, "{name}: {compared}");
    }
}
