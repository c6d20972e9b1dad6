//! Balance of forces and moments in a step of a grasp.

use finray_contact::{TouchedBody, World};
use finray_model::Vector;

/// Largest imbalance of forces and moments on the object and on the fingers' bases, relative to the largest force. Moments are divided by the
/// object's size.
pub(super) fn imbalance(world: &World, weight: Vector) -> f64 {
    let contacts = world.contacts();
    let largest_n = contacts.iter().map(|contact| contact.force.norm()).fold(weight.norm(), f64::max);
    if largest_n == 0.0 {
        return 0.0;
    }
    let [x, y, angle] = world.object();
    let centre = Vector::new(x, y) + nalgebra::Rotation2::new(angle) * world.shape().centroid();
    let force: Vector = weight + contacts.iter().map(|contact| contact.force).sum::<Vector>();
    let moment_nmm: f64 = contacts.iter().map(|contact| (contact.point - centre).perp(&contact.force)).sum();
    let size_mm = world.shape().size_mm();
    let on_bases = (0..world.placements().len()).map(|finger| {
        let of_finger = contacts.iter().filter(|contact| contact.partner == TouchedBody::Finger(finger));
        let touches = of_finger.filter_map(|contact| contact.touch);
        let (force, moment_nmm) = touches.fold(world.on_base(finger), |(force, moment_nmm), touch| {
            (force - touch.force, moment_nmm - touch.point.perp(&touch.force))
        });
        force.norm().max(moment_nmm.abs() / size_mm)
    });
    let worst = on_bases.fold(force.norm().max(moment_nmm.abs() / size_mm), f64::max);
    worst / largest_n
}
