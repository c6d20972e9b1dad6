//! A finger under one force with given values of all unknowns: the residuals and derivatives of one image in a calibration.

use super::derivatives::{linearise_with_loads, state_after_step};
use super::linearised::{Linearised, Seen};
use super::problem::{ForceProblem, State};
use super::states::{settle, state_of};
use super::unknowns::{PosePart, Unknown};
use super::values::Nuisances;
use crate::Vector;
use crate::frame::{FrameLoad, FrameMotion};
use crate::measurement::{Marker, Measurement};
use crate::mesh::{LoadError, Mesh};
use crate::sensing::{Contact, ContactPosition, ContactQuestion};
use nalgebra::{DMatrix, Isometry2};

/// The direction of a force has settled if it changes by at most this angle between two shapes, degrees.
const SETTLED_DEG: f64 = 5e-8;

/// The unknowns of one force in one image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ForceUnknowns {
    /// Position of the force along the front plate, mm.
    pub s_mm: f64,
    /// Motion of the base from its expected pose, mm and rad.
    pub base: Isometry2<f64>,
    /// Magnitude of the force, N.
    pub force_n: f64,
    /// Difference between the lean of the force (its angle from the normal) and the mean lean, degrees.
    pub further_lean_deg: f64,
}

impl ForceUnknowns {
    /// A force with the mean lean, on a finger whose base has its expected pose.
    pub fn at(s_mm: f64, force_n: f64) -> ForceUnknowns {
        ForceUnknowns { s_mm, base: Isometry2::identity(), force_n, further_lean_deg: 0.0 }
    }
}

/// One force on a finger, and what an image shows of it.
#[derive(Debug, Clone)]
pub(crate) struct Press<'m> {
    pub mesh: &'m Mesh,
    /// What is known of the force.
    pub question: ContactQuestion,
    /// Loads on the unloaded finger.
    pub preload: Option<FrameLoad>,
    /// Displacements of the markers and uncertainty of the base. The weight of a marker is the reciprocal of its standard deviation, 1/mm.
    pub measurement: Measurement,
}

/// A shape and the loads under which it is in equilibrium.
#[derive(Debug, Clone)]
pub(crate) struct LoadedShape {
    motion: FrameMotion,
    loads: Vec<FrameLoad>,
}

/// A finger in equilibrium under one force.
pub(crate) struct PressedFinger<'m> {
    problem: ForceProblem<'m>,
    measurement: Measurement,
    state: State,
}

impl<'m> PressedFinger<'m> {
    /// The equilibrium for given values of the unknowns. The search starts from `near`, the shape of almost the same finger and force, unless a changed
    /// length gives the fingers different frames: for instance, two ribs at one junction may move apart. `None` if no equilibrium is found.
    pub fn new(press: Press<'m>, unknowns: &ForceUnknowns, near: Option<&LoadedShape>) -> Option<PressedFinger<'m>> {
        let mut problem = press.problem()?;
        let contact = Contact { position: ContactPosition::at(unknowns.s_mm), angle_deg: 0.0 };
        let mut nuisances = Nuisances::expected(1, &[]);
        nuisances.base = unknowns.base;
        nuisances.further_leans_deg[0] = unknowns.further_lean_deg;
        let mut state = state_of(&problem, vec![contact], vec![unknowns.force_n], nuisances).ok()?;
        let at_rest = LoadedShape { motion: state.motion.clone(), loads: Vec::new() };
        let mut is_settled_from = |LoadedShape { motion, loads }| {
            (state.motion, state.loads) = (motion, loads);
            settle(&mut problem, &mut state, SETTLED_DEG).unwrap_or(false)
        };
        let near = near.filter(|near| near.motion.fits(press.mesh.frame())).cloned();
        let is_settled = near.is_some_and(&mut is_settled_from) || is_settled_from(at_rest);
        is_settled.then_some(PressedFinger { problem, measurement: press.measurement, state })
    }

    /// Force on the finger, N, finger frame.
    pub fn force(&self) -> Vector {
        self.state.contacts[0].direction(self.problem.finger()) * self.state.forces_n[0]
    }

    /// Rotation of the plate's normal at the contact, rad, averaged over a length of plate.
    ///
    /// # Errors
    /// [`LoadError`] for a contact off its plate.
    pub fn normal_turn_rad(&self, over_mm: f64) -> Result<f64, LoadError> {
        let load = self.state.contacts[0].unit_load(self.problem.finger());
        self.problem.mesh.normal_turn(&self.state.motion, &load, over_mm)
    }

    /// Computed minus measured displacement of each marker, mm, finger frame.
    pub fn misses_mm(&self) -> impl Iterator<Item = Vector> {
        self.weighted_misses().map(|(marker, missed)| missed / marker.weight)
    }

    fn weighted_misses(&self) -> impl Iterator<Item = (&Marker, Vector)> {
        let miss = |marker| -self.state.linearised.distance(marker, self.state.posed());
        self.measurement.markers().iter().map(move |marker| (marker, miss(marker)))
    }

    /// Residuals in standard deviations: two rows per marker, then the priors in the order of the unknowns.
    pub fn residual(&self) -> Vec<f64> {
        let State { nuisances, forces_n, .. } = &self.state;
        let markers = self.weighted_misses().flat_map(|(_, missed)| <[f64; 2]>::from(missed));
        markers.chain(self.problem.priors.rows(nuisances, forces_n).map(|row| -row.left_mm)).collect()
    }

    /// Residuals of another finger under the same force, to first order in the difference between the fingers. `None` if the frames of the fingers
    /// differ, or the other finger is not stable in this shape.
    pub fn residual_of(&self, other: Press) -> Option<Vec<f64>> {
        let mut problem = other.problem()?;
        let linearised = Linearised::new(other.mesh, &problem.unknowns);
        let mut from = State { linearised, ..self.state.clone() };
        from.motion.fits(other.mesh.frame()).then_some(())?;
        // Brackets of another length carry the ends of the ribs elsewhere.
        other.mesh.frame().follow_links(&mut from.motion, false);
        from.loads = from.loads_under(other.mesh, &problem.questions, &from.forces_n).ok()?;
        from.loads.extend_from_slice(&problem.further_loads);
        problem.statics.linearise(&from.motion, &from.loads).then_some(())?;
        let state = state_after_step(&mut problem, &from, None, &mut from.loads.clone()).ok()?;
        Some(PressedFinger { problem, measurement: other.measurement, state }.residual())
    }

    /// Derivatives of the residuals with respect to position (1/mm), base x, base y (1/mm), rotation of the base (1/rad), force (1/N) and, if the
    /// direction is uncertain, lean (1/degree). `None` if the equilibrium is not stable.
    pub fn jacobian(&mut self) -> Option<DMatrix<f64>> {
        linearise_with_loads(&mut self.problem, &mut self.state).ok()?;
        let mut by_unknown = self.state.linearised.derivatives(&self.measurement);
        let base = [PosePart::X, PosePart::Y, PosePart::Turn].map(Unknown::Base);
        let order = [&[Unknown::Position(0)], &base[..], &[Unknown::Force(0), Unknown::Across(0)]].concat();
        let column = |unknown: Unknown| self.problem.unknowns.iter().position(|other| *other == unknown);
        if let Some(across) = column(Unknown::Across(0)) {
            // A force across the direction turns it by its ratio to the force.
            by_unknown.column_mut(across).scale_mut(self.state.forces_n[0].to_radians());
        }
        Some(by_unknown.select_columns(&order.into_iter().filter_map(column).collect::<Vec<_>>()))
    }

    /// The shape and its loads, from which the search for a similar equilibrium may start.
    pub fn into_shape(self) -> LoadedShape {
        LoadedShape { motion: self.state.motion, loads: self.state.loads }
    }
}

impl<'m> Press<'m> {
    fn problem(&self) -> Option<ForceProblem<'m>> {
        let mut problem = ForceProblem::new(self.mesh, &[self.question]).ok()?;
        problem.further_loads.extend(self.preload);
        problem.expect(Seen { measurement: &self.measurement, marker_noise_mm: Some(1.0) }).ok()?;
        Some(problem)
    }
}
