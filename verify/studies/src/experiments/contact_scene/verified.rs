//! Verification of a scene's steps by the lattice: by its equilibrium under the computed contact forces, and by the physics engine rapier, which finds
//! contacts and forces on its own.

use crate::check::difference;
use crate::prelude::*;
use finray_contact::path::HandStep;
use finray_contact::press::{ContactScene, SceneStep};
use finray_contact::pressing::Push;
use finray_lattice::engine_pressing::EnginePressing;

/// Verification of a step of a contact scene. `engine` is `None` if rapier does not come to rest; `equilibrium` is `None` if the lattice has no
/// equilibrium, or a rib is touched, where the lattice takes no loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedStep {
    /// Difference of shape and contact forces between the step and the state of rest that rapier reaches from the lattice's equilibrium.
    pub engine: Option<EngineDifference>,
    /// Largest difference of the step's shape from the lattice's equilibrium under the contact forces alone, relative to the largest displacement.
    pub equilibrium: Option<f64>,
}

/// Difference between a step and the state in which rapier comes to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngineDifference {
    /// Largest difference of a displacement, relative to the largest displacement.
    pub shape: f64,
    /// Difference of the sum of contact forces, relative to the sum; 0 if neither has contact.
    pub force: f64,
}

/// Verifies steps of a scene on a lattice of this fineness.
///
/// # Errors
/// [`LatticeError`] if the lattice cannot be built, or does not settle even without the object.
pub(super) fn verify(
    scene: &ContactScene,
    steps: &[SceneStep],
    fineness: usize,
) -> Result<Vec<VerifiedStep>, LatticeError> {
    let lattice = Lattice::new(scene.finger(), fineness)?;
    let object = scene.object();
    let rod_radius_mm = scene.scene().contact.rod_radius_mm;
    let mut engine = EnginePressing::new(&lattice, rod_radius_mm, object)?;
    let verify = |(SceneStep { pressed: found, .. }, step): (&SceneStep, &HandStep)| {
        let push = if let Push::To(_) = step.end { Push::To(found.object) } else { step.end };
        let loads = lattice.contact_loads(&found.touches, &found.shape);
        let Ok(motions) = loads.and_then(|loads| lattice.motions_under(&loads)) else {
            return Ok(VerifiedStep { engine: None, equilibrium: None });
        };
        let equilibrium = Some(difference(&lattice.shape(&motions), &found.shape));
        let settled = engine.hold(&motions, found.object, push).ok();
        let force_n = found.contact_force().norm();
        let engine = settled.map(|settled| {
            let off_n = (settled.contact_force() - found.contact_force()).norm();
            let force = if off_n == 0.0 { 0.0 } else { off_n / force_n };
            EngineDifference { shape: difference(&settled.shape, &found.shape), force }
        });
        Ok(VerifiedStep { engine, equilibrium })
    };
    steps.iter().zip(&object.steps).map(verify).collect()
}
