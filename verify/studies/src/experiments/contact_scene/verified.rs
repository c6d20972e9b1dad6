//! Steps of a scene against rapier, and against the lattice's equilibrium under the forces that were found.

use super::{ContactScene, SceneStep};
use crate::lattice::accuracy::difference;
use crate::prelude::*;
use finray_lattice::pressing::Push;
use finray_lattice::pressing::settled::EnginePressing;

/// What becomes of a step elsewhere; none where it does not come to rest there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedStep {
    /// Rapier lets finger and object come to rest, beginning where the step has them: how far the finger is from there then.
    pub engine: Option<EngineDifference>,
    /// How far the lattice's equilibrium under the contact forces alone is from the step's shape, as a share of the largest displacement.
    pub equilibrium: Option<f64>,
}

/// Rapier's rest less a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EngineDifference {
    /// Largest difference of a displacement, as a share of the largest.
    pub shape: f64,
    /// Difference of the sum of contact forces, as a share of it; 0 where nothing touches in either.
    pub force: f64,
}

impl ContactScene {
    /// Verifies steps that were found on a lattice of some fineness.
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
