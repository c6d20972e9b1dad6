//! Verification of a scene's steps by the physics engine rapier, and by the lattice's equilibrium under the computed contact forces.

use super::{ContactScene, SceneStep};
use crate::lattice::accuracy::difference;
use crate::prelude::*;
use finray_lattice::pressing::Push;
use finray_lattice::pressing::settled::EnginePressing;

/// Verification of a step of a contact scene. `engine` is `None` if rapier does not come to rest; `equilibrium` is `None` if the lattice has no
/// equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedStep {
    /// Difference of shape and contact forces between the step and the state of rest that rapier reaches from the step.
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

impl ContactScene {
    /// Verifies steps that were computed on a lattice of this fineness.
    ///
    /// # Errors
    /// [`LatticeError`] if the lattice does not settle even without the object.
    pub fn verify(&self, steps: &[SceneStep], fineness: usize) -> Result<Vec<VerifiedStep>, LatticeError> {
        let lattice = Lattice::new(self.finger(), fineness)?;
        let Ok(rigid) = self.object.rigid() else { return Ok(Vec::new()) };
        let (start, along) = (self.object.start, self.object.along);
        let mut engine = EnginePressing::new(&lattice, self.scene.contact.rod_radius_mm, &rigid, start, along)?;
        let verify = |(SceneStep { pressed: found, .. }, step): (&SceneStep, &super::HandStep)| {
            let push = if let Push::To(_) = step.end { Push::To(found.object) } else { step.end };
            let settled = engine.hold(found, push).ok();
            let force_n = found.contact_force().norm();
            let engine = settled.map(|settled| {
                let off_n = (settled.contact_force() - found.contact_force()).norm();
                let force = if off_n == 0.0 { 0.0 } else { off_n / force_n };
                EngineDifference { shape: difference(&settled.shape, &found.shape), force }
            });
            let equilibrium = lattice.equilibrium_under(&found.touches);
            VerifiedStep { engine, equilibrium: equilibrium.ok().map(|shape| difference(&shape, &found.shape)) }
        };
        Ok(steps.iter().zip(&self.object.steps).map(verify).collect())
    }
}
