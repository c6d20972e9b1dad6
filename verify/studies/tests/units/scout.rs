//! Tests of the scout, which predicts whether loads have an equilibrium. The scout never refuses loads that have an equilibrium.

use super::*;
use finray_model::Scene;

/// A grid of force pairs acts on two nodes near the tip of a finger that carries only the smaller pairs. The scout refuses no pair that the finger
/// carries or nearly carries, and accepts no pair that the finger does not carry. The scout decides nearly all pairs without computing their
/// equilibrium paths.
#[test]
fn forces_that_are_carried_are_never_refused() -> Result<(), Box<dyn std::error::Error>> {
    let finger = Scene::from_toml(finray_fixtures::SOFT_SCENE)?.finger;
    let mesh = Mesh::with_elements_per_member(&finger, 4);
    let nodes: Vec<_> = finger.contact_nodes().take(2).collect();
    let contacts: Vec<Contact> = nodes.into_iter().map(Contact::at_node).collect();
    let ratio_limits = RatioLimits::new(&mesh, Kinematics::Corotational, &contacts, [0.1, 2.9]);
    let mut scout = ratio_limits.scout();
    let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
    let (mut refused, mut carried) = (0, 0);
    for first in 1..=14 {
        for second in 1..=14 {
            // The order of the forces is unrelated to their size.
            let forces_n = [first * 5 % 14, second * 3 % 14].map(|n| 0.1 + 0.2 * f64::from(n));
            let loads = loads(&mesh, &contacts, &forces_n)?;
            let share = match statics.equilibrium(&loads) {
                Ok(_) => 1.0,
                Err(StaticsError::NoEquilibrium { converged_fraction }) => converged_fraction,
                Err(other) => return Err(other.into()),
            };
            let sees = scout.sees(&forces_n);
            let refuses = sees == LoadClass::TooLarge;
            assert!(!refuses || share < CLEARLY_TOO_LARGE, "{forces_n:?} N are refused, {share} of them are carried");
            assert!(sees != LoadClass::Carried || share == 1.0, "{forces_n:?} N count as carried, {share} of them are");
            refused += usize::from(refuses);
            carried += usize::from(share == 1.0);
        }
    }
    assert!(carried > 10 && refused > 100, "{carried} carried, {refused} refused");
    // For hundreds of forces, the scout computes few equilibrium paths besides the paths for the force ratios.
    let followed = scout.limits.len() - ratio_limits.limits.get().ok_or("limits are there")?.len();
    assert!(followed < refused / 10, "{followed} forces followed for {refused} refusals");
    Ok(())
}
