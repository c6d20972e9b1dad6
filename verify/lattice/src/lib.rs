//! A finger as a lattice of rigid bodies and springs: a second discretisation that verifies the beam solver.
//!
//! The lattice uses neither the elements nor the solver of the beam model. The lattice's springs have the stiffnesses EA / l, 12 EI / l^3 and EI / l
//! of the beams' sections; shear deformation reduces 12 EI / l^3. The lattice therefore verifies solver and kinematics of the beam model, but not
//! beam theory.
//!
//! Plates and ribs are cut into short segments, with a rigid body between two segments and at every rod (junction). Each segment becomes one axial
//! spring and up to three bending springs ([`springs`]). The equilibrium is found in two ways. [`settling`] lets the bodies move in the physics
//! engine rapier until they rest; Newton's method minimises the springs' [`energy`]. Comparing the results of rapier and of Newton's method separates
//! errors of the lattice from errors of settling.
//!
//! No parameter is fitted. For small displacements the displacements of the key nodes are exact, as in a frame of beams. For large displacements, the
//! error decreases with the third to fourth power of the segment length.
//!
//! The lattice supports every finger, including fingers with rigid arms, zones, hinged ribs or undeformable ribs. An undeformable rib with rigid
//! joints forms one body with its two rods. An undeformable rib with hinges is a bar with ten times the axial rigidity of the stiffer plate.
//!
//! Objects pressed onto a finger are computed on beams (`finray_contact`). [`engine_pressing`] verifies them: rapier finds the contacts of an object with
//! the lattice on its own.
#![forbid(unsafe_code)]

pub mod bodies;
pub mod energy;
pub mod engine_pressing;
pub mod settling;
pub mod skin;
pub mod springs;

use bodies::{Assembly, BodyLoad};
use energy::{BodyMotion, Energy};
use finray_model::Finger;
use finray_model::mesh::{FingerShape, Load, LoadError};
use settling::{Dynamics, Settling};
use springs::AxialSprings;

/// Reason why a lattice cannot be built or has no equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// The requested number of segments per plate member is zero.
    #[error("a lattice needs at least one segment per member")]
    NoSegments,
    /// The fineness would give more bodies than are supported.
    #[error("a lattice of fineness {fineness} would have too many bodies: choose a smaller fineness")]
    TooFine {
        /// Requested number of segments per plate member of mean length.
        fineness: usize,
    },
    /// A load acts on a node or position that the finger does not have.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A load is infinite or not a number.
    #[error("expected finite loads, found a load that is infinite or not a number")]
    LoadNotFinite,
    /// The bodies still move after the largest number of steps.
    #[error(
        "the lattice has not settled after {steps} steps: its bodies still move by {residual:.1e} of the largest displacement"
    )]
    NotSettled {
        /// Number of time steps taken.
        steps: usize,
        /// Largest movement between the last two position checks, relative to the largest displacement; infinite before the second check.
        residual: f64,
    },
    /// Finger and object cannot be brought into contact, or the finger does not hold the object.
    #[error(transparent)]
    Contact(#[from] finray_contact::ContactError),
    /// A contact force acts on a rib, where the lattice accepts no loads.
    #[error("the object touches a rib, on which the lattice takes no loads")]
    OffPlates,
    /// Newton's method found no stable equilibrium on the way to the full load.
    #[error("no stable equilibrium of the lattice was found beyond {:.4} % of the load", 100.0 * converged_fraction)]
    NoEquilibrium {
        /// Largest fraction of the load, 0 to 1, for which an equilibrium was found.
        converged_fraction: f64,
    },
}

/// A finger divided into rigid bodies connected by springs.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    finger: Finger,
    assembly: Assembly,
}

/// State of a finger after it has come to rest in the physics engine.
#[derive(Debug, Clone, PartialEq)]
pub struct Settled {
    /// Displacements and rotations of the key nodes (ends of plates and ribs), finger frame, mm and rad.
    pub shape: FingerShape,
    /// Number of time steps taken.
    pub steps: usize,
    /// Largest movement of a body between the last two position checks, relative to the largest displacement.
    pub residual: f64,
}

impl Lattice {
    /// Builds a lattice whose segments are about as long as a plate member of mean length divided by `fineness`.
    ///
    /// # Errors
    /// [`LatticeError::NoSegments`] if `fineness` is 0, [`LatticeError::TooFine`] if the lattice would have too many bodies.
    pub fn new(finger: &Finger, fineness: usize) -> Result<Lattice, LatticeError> {
        Lattice::with_axial_springs(finger, fineness, AxialSprings::default())
    }

    /// Builds a lattice as [`new`](Lattice::new) does, but with axial springs that may differ from the springs of a beam.
    ///
    /// # Errors
    /// As for [`new`](Lattice::new).
    pub fn with_axial_springs(finger: &Finger, fineness: usize, axial: AxialSprings) -> Result<Lattice, LatticeError> {
        Ok(Lattice { finger: finger.clone(), assembly: Assembly::new(finger, fineness, axial)? })
    }

    /// The finger that the lattice represents.
    pub fn finger(&self) -> &Finger {
        &self.finger
    }

    /// Bodies and springs of the lattice.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Lets the lattice come to rest in rapier under all loads at once. Equal loads give bit-identical results.
    ///
    /// # Errors
    /// [`LatticeError::NotSettled`] after [`settling::MOST_STEPS`] steps, [`LatticeError::Load`] or [`LatticeError::LoadNotFinite`] for a bad load.
    pub fn settle(&self, loads: &[Load]) -> Result<Settled, LatticeError> {
        self.settle_as(loads, Settling::default())
    }

    /// Lets the lattice come to rest as [`settle`](Lattice::settle) does, with other numbers of sweeps or steps, or another precision.
    ///
    /// # Errors
    /// As for [`settle`](Lattice::settle).
    pub fn settle_as(&self, loads: &[Load], how: Settling) -> Result<Settled, LatticeError> {
        let loads = self.body_loads(loads)?;
        let mut dynamics = Dynamics::new(&self.assembly, &how);
        let rest = dynamics.settle(&loads, how.most_steps)?;
        Ok(Settled { shape: self.shape(&dynamics.motions()), steps: rest.steps, residual: rest.residual })
    }

    /// Stable equilibrium under the loads, found by Newton's method. The equilibrium is followed from the undeformed state as the loads grow.
    ///
    /// # Errors
    /// [`LatticeError::NoEquilibrium`] if the path ends before the full load, [`LatticeError::Load`] or [`LatticeError::LoadNotFinite`] for a bad load.
    pub fn equilibrium(&self, loads: &[Load]) -> Result<FingerShape, LatticeError> {
        match self.path(loads, &[1.0])? {
            (mut shapes, None) => Ok(shapes.swap_remove(0)),
            (_, Some(lost)) => Err(lost),
        }
    }

    /// Equilibria under the loads times each of `factors`, which must increase; each equilibrium is followed from the previous one. If the path ends
    /// before the last factor, the second value is [`LatticeError::NoEquilibrium`] with the share of the load at which the path ended.
    ///
    /// # Errors
    /// [`LatticeError::Load`] or [`LatticeError::LoadNotFinite`] for a bad load.
    pub fn path(
        &self,
        loads: &[Load],
        factors: &[f64],
    ) -> Result<(Vec<FingerShape>, Option<LatticeError>), LatticeError> {
        let loads = self.body_loads(loads)?;
        let energy = Energy::new(&self.assembly);
        let mut motions = vec![BodyMotion::default(); self.assembly.bodies.len()];
        let (mut at, mut shapes) = (0.0, Vec::new());
        for &factor in factors {
            if let Err(lost) = energy.follow(&mut motions, &loads, at, factor) {
                return Ok((shapes, Some(lost)));
            }
            shapes.push(self.shape(&motions));
            at = factor;
        }
        Ok((shapes, None))
    }

    /// Distributes loads on the finger over the bodies that carry them.
    ///
    /// # Errors
    /// [`LatticeError::Load`] if a load is not on the finger, [`LatticeError::LoadNotFinite`] if it is not finite.
    pub fn body_loads(&self, loads: &[Load]) -> Result<Vec<BodyLoad>, LatticeError> {
        let mut shares = Vec::new();
        for load in loads {
            shares.extend(self.assembly.body_loads(&self.finger, load)?);
        }
        let finite = |load: &BodyLoad| load.force.iter().all(|f| f.is_finite()) && load.moment_nmm.is_finite();
        if shares.iter().all(finite) { Ok(shares) } else { Err(LatticeError::LoadNotFinite) }
    }

    /// Displacements and rotations of the key nodes that follow from the motions of all bodies.
    pub fn shape(&self, motions: &[BodyMotion]) -> FingerShape {
        FingerShape::new(&self.finger, false, |node| {
            let anchor = self.assembly.key_nodes[node.0 - 1];
            let motion = motions[anchor.body];
            (motion.displacement_at(anchor.arm), motion.rotation)
        })
    }
}
