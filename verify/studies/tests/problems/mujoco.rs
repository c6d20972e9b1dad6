//! Beams compared with shapes from MuJoCo.

use crate::check::assert_all_pass;
use crate::exports::mujoco::exported;
use finray_studies::problems::mujoco;

#[test]
fn the_papers_finger_is_as_beams_have_it() {
    assert_all_pass(&mujoco::static_checks(exported("paper")).expect("every case has an equilibrium"));
}

#[test]
fn a_finger_of_unequal_plates_and_zones_is_as_beams_have_it() {
    assert_all_pass(&mujoco::static_checks(exported("asymmetric")).expect("every case has an equilibrium"));
}

#[test]
fn a_finger_with_a_soft_zone_is_as_beams_have_it() {
    assert_all_pass(&mujoco::static_checks(exported("soft-zone")).expect("every case has an equilibrium"));
}

#[test]
fn beams_take_the_shape_that_a_cylinder_gives_the_finger() {
    let checks = mujoco::contact_checks().expect("every step has an equilibrium");
    assert_eq!(checks.len(), 5);
    assert_all_pass(&checks);
}

#[test]
fn beams_lattice_and_mujoco_are_a_triangle() {
    let comparisons = mujoco::triangle().expect("every load has an equilibrium");
    assert_eq!(comparisons.len(), 12, "three pairs for each of four forces");
    for sides in comparisons.chunks(3) {
        let [beams, lattice, between] = [0, 1, 2].map(|side| sides[side].ours);
        assert!(beams < mujoco::STATIC_TOLERANCE, "{sides:?}");
        assert!((lattice - between).abs() < mujoco::STATIC_TOLERANCE, "the lattice is as far from both: {sides:?}");
    }
}
