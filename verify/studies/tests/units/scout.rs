//! The scout, which predicts whether loads have an equilibrium: it refuses none that have one.

use super::*;
use finray_model::Scene;

/// Over a grid of pairs of forces on two nodes near the tip of a finger that carries only the smaller of them, the scout refuses none
/// that the finger carries, none that it carries nearly, and takes none for carried that are not; nearly all of them without following them.
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
            // In an order that has nothing to do with their size.
            let forces_n = [first * 5 % 14, second * 3 % 14].map(|n| 0.1 + 0.2 * f64::from(n));
            let loads = loads(&mesh, &contacts, &forces_n).ok_or("the contacts are on the mesh")?;
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
    // Of hundreds of forces, few are followed beside those of the ratios.
    let followed = scout.limits.len() - ratio_limits.limits.get().ok_or("limits are there")?.len();
    assert!(followed < refused / 10, "{followed} forces followed for {refused} refusals");
    Ok(())
}
