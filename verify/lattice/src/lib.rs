//! The finger as a lattice of rigid bodies and springs, in which nothing of the beam model's elements or solver is used. Its springs
//! are EA / l, 12 EI / l^3 and EI / l of the same sections: it is another discretisation of the same theory, and verifies solver and
//! kinematics, not Euler-Bernoulli itself.
//!
//! Plates and ribs are cut into short segments. Between two segments, and at every rod, sits a rigid body; a segment
//! becomes an axial spring and two or three against bending, laid out in [`springs`]. [`settling`] lets the bodies move in
//! the physics engine rapier until they rest. Their rest position is a minimum of the springs' [`energy`], which Newton's
//! method finds as well: that separates errors of the lattice from those of the settling.
//!
//! No parameter is fitted. For small displacements the lattice is exact at the key nodes, like a frame of slender beams;
//! its geometrically nonlinear error falls with the third to fourth power of the segments' length.
//!
//! Every finger can be built: with arms, zones, hinged ribs, and ribs that do not deform (one body with their rods, or
//! between hinges a bar ten times as stiff as a plate is along itself).
//!
//! [`grasp`] finds the equilibrium of two fingers with an object between, [`pressing`] with the same method that of one finger and an object that a hand
//! holds, which rapier verifies ([`pressing::settled`]).
#![forbid(unsafe_code)]

pub mod bodies;
pub mod energy;
pub mod grasp;
pub mod pattern;
pub mod pressing;
pub mod settling;
pub mod skin;
pub mod springs;

use bodies::{Assembly, BodyLoad};
use energy::{BodyMotion, BranchEnd, Energy};
use finray_model::Finger;
use finray_model::mesh::{FingerShape, Load, LoadError};
use settling::{Dynamics, Settling};
use springs::AxialSprings;

/// Why a lattice was not built, or did not come to rest.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// A fineness of zero.
    #[error("a lattice has at least one segment a member")]
    NoSegments,
    /// More bodies than are of use.
    #[error("a lattice of fineness {fineness} has too many bodies: use a coarser one")]
    TooFine {
        /// The number that was given.
        fineness: usize,
    },
    /// The load is not on the finger.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A load is infinite or not a number.
    #[error("a load is not a finite number")]
    LoadNotFinite,
    /// The bodies still moved when the steps ran out.
    #[error(
        "the lattice has not settled after {steps} steps: its bodies still move by {residual:.1e} of the largest displacement"
    )]
    NotSettled {
        /// Steps taken.
        steps: usize,
        /// Largest movement between the last two looks, as a share of the largest displacement; infinite before the first.
        residual: f64,
    },
    /// The outline of a front plate that tapers is not parallel to its middle line, which objects here take it for.
    #[error("finger.front.tip_thickness_mm: expected a front plate of one thickness where an object touches it")]
    Tapered,
    /// An object that is to be pressed onto the finger does not start outside it.
    #[error("the object overlaps the undeformed finger by {overlap_mm:.3} mm where it starts")]
    Overlap {
        /// How deep, mm.
        overlap_mm: f64,
    },
    /// An object pressed with a force goes free.
    #[error(
        "the finger does not hold the object against the force{}", touched_n.map_or(String::new(), |n| format!(": they last touched at {n:.3} N"))
    )]
    LetGo {
        /// Force under which the object last touched the finger, N; `None` if it never did.
        touched_n: Option<f64>,
    },
    /// No equilibrium with the object at its prescribed position.
    #[error("no stable equilibrium of finger and object is found{}", if *is_folded { ": the finger folds" } else { "" })]
    NoContactEquilibrium {
        /// Whether a part of the finger has turned so far that it folds.
        is_folded: bool,
    },
    /// Newton's method found no stable equilibrium on the way to the full load.
    #[error("no stable equilibrium of the lattice was found beyond {:.4} % of the load", 100.0 * converged_fraction)]
    NoEquilibrium {
        /// Share of the load, 0..1, at which an equilibrium was last found.
        converged_fraction: f64,
    },
}

/// A finger cut into rigid bodies with springs between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    finger: Finger,
    assembly: Assembly,
}

/// A finger come to rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Settled {
    /// Motion of the key nodes.
    pub shape: FingerShape,
    /// Steps taken.
    pub steps: usize,
    /// Largest movement of a body between the last two looks, as a share of the largest displacement.
    pub residual: f64,
}

impl Lattice {
    /// Builds a lattice with `fineness` segments in a plate member of mean length, and segments of about this length
    /// everywhere.
    ///
    /// # Errors
    /// [`LatticeError::NoSegments`], [`LatticeError::TooFine`].
    pub fn new(finger: &Finger, fineness: usize) -> Result<Lattice, LatticeError> {
        Lattice::with_axial_springs(finger, fineness, AxialSprings::default())
    }

    /// [`new`](Lattice::new) with other axial springs than those of a beam.
    ///
    /// # Errors
    /// As there.
    pub fn with_axial_springs(finger: &Finger, fineness: usize, axial: AxialSprings) -> Result<Lattice, LatticeError> {
        Ok(Lattice { finger: finger.clone(), assembly: Assembly::new(finger, fineness, axial)? })
    }

    /// The finger that it stands for.
    pub fn finger(&self) -> &Finger {
        &self.finger
    }

    /// Its bodies and springs.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Shape in which the lattice comes to rest in rapier, all loads put on at once. The same loads give the same bits.
    ///
    /// # Errors
    /// [`LatticeError::NotSettled`] after [`settling::MOST_STEPS`] steps; a load that is not on the finger.
    pub fn settle(&self, loads: &[Load]) -> Result<Settled, LatticeError> {
        self.settle_as(loads, Settling::default())
    }

    /// [`settle`](Lattice::settle) with other sweeps, precision or limit of the steps.
    ///
    /// # Errors
    /// As there.
    pub fn settle_as(&self, loads: &[Load], how: Settling) -> Result<Settled, LatticeError> {
        let loads = self.body_loads(loads)?;
        let mut dynamics = Dynamics::new(&self.assembly).settling_as(&how);
        let rest = dynamics.settle(&loads, how.most_steps)?;
        Ok(Settled { shape: self.shape(&dynamics.motions()), steps: rest.steps, residual: rest.residual })
    }

    /// Shape of least energy, by Newton's method: the stable equilibrium that follows from rest as the loads grow.
    ///
    /// # Errors
    /// [`LatticeError::NoEquilibrium`] where none follows; a load that is not on the finger.
    pub fn equilibrium(&self, loads: &[Load]) -> Result<FingerShape, LatticeError> {
        match self.path(loads, &[1.0])? {
            (mut shapes, None) => Ok(shapes.swap_remove(0)),
            (_, Some(BranchEnd { converged_fraction })) => Err(LatticeError::NoEquilibrium { converged_fraction }),
        }
    }

    /// Shapes of least energy under growing multiples of the loads, each followed from the one before; and where
    /// the path was lost, if it was.
    ///
    /// # Errors
    /// A load that is not on the finger or not finite.
    pub fn path(&self, loads: &[Load], factors: &[f64]) -> Result<(Vec<FingerShape>, Option<BranchEnd>), LatticeError> {
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

    /// Loads of the bodies that loads of the finger come to.
    ///
    /// # Errors
    /// [`LatticeError::Load`], [`LatticeError::LoadNotFinite`].
    pub fn body_loads(&self, loads: &[Load]) -> Result<Vec<BodyLoad>, LatticeError> {
        let mut shares = Vec::new();
        for load in loads {
            shares.extend(self.assembly.body_loads(&self.finger, load)?);
        }
        let finite = |load: &BodyLoad| load.force.iter().all(|f| f.is_finite()) && load.moment_nmm.is_finite();
        if shares.iter().all(finite) { Ok(shares) } else { Err(LatticeError::LoadNotFinite) }
    }

    /// Motion of the key nodes where the bodies move so.
    pub fn shape(&self, motions: &[BodyMotion]) -> FingerShape {
        FingerShape::new(&self.finger, |node| {
            let anchor = self.assembly.key_nodes[node.0 - 1];
            let motion = motions[anchor.body];
            (motion.displacement_at(anchor.arm), motion.rotation)
        })
    }
}
