//! Least-squares problem of a calibration: all views and their own unknowns at once.

use super::quantity::changed;
use super::{Quantity, Sought, View, ViewModel};
use crate::Vector;
use crate::finger::{Finger, Plate, RibPositions};
use crate::measurement::{Marker, MarkerErrors};
use crate::mesh::Mesh;
use crate::sensing::{
    AssemblyErrors, ContactQuestion, Direction, ForceUnknowns, Lean, LoadedShape, Normal, Press, PressedFinger,
};
use nalgebra::{Isometry2, Point2};
use std::ops::Range;

/// Number of unknowns that every view has: position, base x, base y, rotation of the base. The fifth unknown of a view is the force, unless the force
/// is exact. The last unknown of a view is the lean (angle between force and normal), unless the force was measured.
pub(super) const OWN: usize = 4;
/// Number of residuals for the prior of a view's base.
pub(super) const BASE_ROWS: usize = 3;
/// Contacts are not sought on this share of the plate at either end.
const MARGIN: f64 = 0.02;
/// Smallest standard deviation of a lean (angle between force and normal), degrees. A lean that is stated as exact has this standard deviation.
const SETTLED_DEG: f64 = 1e-3;
/// All views may share a part of the lean (angle between force and normal). If views share a part of the lean, this value is the standard deviation
/// of a view's own part, relative to the lean's standard deviation. The shared part has the whole standard deviation of the lean, because the
/// friction of one object may be the same in all views. Each view also has its own part of the lean, because friction may build up and objects may
/// differ.
const OWN_LEAN: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// All unknowns, as one point of the search.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Point {
    /// Changes of the quantities that all views share: the logarithm of a factor, or a change in mm, degrees, N mm or standard deviations.
    pub shared: Vec<f64>,
    /// Unknowns of each view.
    pub own: Vec<ForceUnknowns>,
}

/// A finger and its rig, with the changes of the sought quantities applied.
pub(super) struct Candidate {
    pub mesh: Mesh,
    /// Height of the markers above the plane of the beams, mm.
    pub marker_height_mm: f64,
    /// Transformation from the finger frame to the frame of a view, mm and rad, without the part that differs between views.
    pub base: Isometry2<f64>,
    /// Moment that the plates of the unloaded finger exert on each other at the tip, N mm.
    pub preload_nmm: f64,
    /// Lean (angle between force and normal) of forces that were not measured. The standard deviation is that of the part that a view does not share
    /// with the other views.
    pub lean: Lean,
}

/// Least-squares problem of a calibration.
pub(super) struct Problem<'p> {
    pub finger: &'p Finger,
    pub views: &'p [View],
    pub sought: &'p [Sought],
    pub model: &'p ViewModel,
    /// Factor on the stated noise of the markers, and the calibration error that adds to this noise.
    pub errors: MarkerErrors,
    /// Relative standard deviation of measured forces, dimensionless. `None` if they are exact.
    pub scatter: Option<f64>,
    /// Shape of each view at the last point. Empty before the first point.
    pub shapes: Vec<LoadedShape>,
}

impl Problem<'_> {
    /// Value that the scene states for a quantity, in its unit. Zero for quantities that are changes or factors.
    pub(super) fn stated(&self, quantity: Quantity) -> f64 {
        let ribs = &self.finger.description().ribs;
        match quantity {
            Quantity::Bracket(plate) => ribs.bracket_mm.of(0)[usize::from(plate == Plate::Back)],
            Quantity::Clip => ribs.clip_mm[0],
            Quantity::PlateClip(plate) => ribs.clip_mm[usize::from(plate == Plate::Back)],
            Quantity::RibPosition(plate, rib) => match &ribs.positions {
                RibPositions::Positions(positions) => positions[rib][usize::from(plate == Plate::Back)],
                RibPositions::Count(_) => f64::NAN,
            },
            Quantity::MarkerHeight => self.model.marker_height_mm,
            Quantity::Preload => self.model.preload_nmm,
            Quantity::Lean => self.model.lean.angle_deg,
            _ => 0.0,
        }
    }

    /// Finger and rig with the changes `shared` of the sought quantities. `None` if the changed finger is impossible.
    pub(super) fn candidate(&self, shared: &[f64]) -> Option<Candidate> {
        let mut description = self.finger.description().clone();
        let (mut marker_height_mm, mut at, mut turn_deg) = (self.model.marker_height_mm, Vector::zeros(), 0.0);
        let mut preload_nmm = self.model.preload_nmm;
        let mut lean = Lean { sd_deg: self.further_lean_sd_deg(), ..self.model.lean };
        for (sought, &change) in self.sought.iter().zip(shared) {
            match sought.quantity {
                Quantity::MarkerHeight => marker_height_mm += change,
                Quantity::BaseX => at.x += change,
                Quantity::BaseY => at.y += change,
                Quantity::BaseTurn => turn_deg += change,
                Quantity::Preload => preload_nmm += change,
                Quantity::Lean => lean.angle_deg += change,
                of_finger => changed(&mut description, self.finger.rib_count(), of_finger, change),
            }
        }
        let finger = Finger::new(description).ok()?;
        let base = Isometry2::new(at, turn_deg.to_radians());
        let mesh = Mesh::with_elements_per_member(&finger, self.model.elements);
        Some(Candidate { mesh, marker_height_mm, base, preload_nmm, lean })
    }

    /// Each view with its unknowns at a point, the rows of its residuals, and the first column of its unknowns.
    pub(super) fn parts<'s, 'p>(
        &'s self,
        point: &'p Point,
    ) -> impl Iterator<Item = (&'s View, &'p ForceUnknowns, Range<usize>, usize)> {
        self.views.iter().zip(&point.own).scan((0, self.sought.len()), |(row, column), (view, own)| {
            let (rows, first) = (*row..*row + self.row_count(view), *column);
            (*row, *column) = (rows.end, first + self.own_count(view));
            Some((view, own, rows, first))
        })
    }

    /// Number of unknowns of a view.
    pub(super) fn own_count(&self, view: &View) -> usize {
        let of_force = match (view.force, self.scatter) {
            (Some(_), Some(_)) => 1,
            (Some(_), None) => 0,
            (None, _) => 2,
        };
        OWN + of_force
    }

    /// Standard deviation of the part of the lean (angle between force and normal) that a view does not share with the other views, degrees.
    fn further_lean_sd_deg(&self) -> f64 {
        let is_shared = self.sought.iter().any(|sought| sought.quantity == Quantity::Lean);
        let share = if is_shared { OWN_LEAN } else { 1.0 };
        (share * self.model.lean.sd_deg).max(SETTLED_DEG)
    }

    /// Number of residuals of a view: for the markers, for the lean (angle between force and normal) unless the force was measured, for the base, and
    /// for a measured force that is not exact.
    pub(super) fn row_count(&self, view: &View) -> usize {
        let further = usize::from(view.force.is_none() || self.scatter.is_some());
        view.measurement.coordinate_count() + BASE_ROWS + further
    }

    /// The force of a view on the finger of a candidate. The displacements of the markers refer to this finger and the base of the candidate.
    pub(super) fn press<'c>(&self, candidate: &'c Candidate, view: &View) -> Press<'c> {
        let (mesh, to_candidate) = (&candidate.mesh, candidate.base.inverse());
        let finger = mesh.finger();
        let direction = match (view.force, candidate.lean.from) {
            (Some(force), _) => Direction::Angle(finger.angle_deg(to_candidate * force)),
            // Calibration knows no outlines of objects.
            (None, Normal::Object) => Direction::Leaning(Lean { from: Normal::Undeformed, ..candidate.lean }),
            (None, _) => Direction::Leaning(candidate.lean),
        };
        let pad = self.model.surface_of(view.force.is_some());
        let preload = AssemblyErrors::load(finger, candidate.preload_nmm);
        let height_mm = self.model.camera_height_mm;
        // Markers above their stated height appear farther from the camera's axis than they are.
        let nearer = (height_mm - candidate.marker_height_mm) / (height_mm - self.model.marker_height_mm);
        let measurement = view.measurement.clone().with_base(view.base).with_markers(|marker| {
            let seen = self.finger.marker_position(marker.node) + marker.displacement;
            let at = to_candidate * Point2::from(view.eye + (seen - view.eye) * nearer);
            marker.displacement = at.coords - finger.marker_position(marker.node);
            marker.weight = 1.0 / self.errors.sd_mm(view.noise_mm / marker.weight);
        });
        Press {
            mesh,
            question: ContactQuestion { pad, ..ContactQuestion::new(None, direction) },
            preload: mesh.frame_load(&preload).ok().filter(|_| candidate.preload_nmm != 0.0),
            measurement,
        }
    }

    /// Equilibrium under the force of a view. `None` if the finger has no equilibrium under this force.
    pub(super) fn pressed<'c>(
        &self,
        candidate: &'c Candidate,
        view: &View,
        own: &ForceUnknowns,
        near: Option<&LoadedShape>,
    ) -> Option<PressedFinger<'c>> {
        PressedFinger::new(self.press(candidate, view), own, near)
    }

    /// Residuals of a view divided by their standard deviations. `rows` are those of the markers and priors. Priors are last.
    pub(super) fn with_force_row(&self, mut rows: Vec<f64>, view: &View, own: &ForceUnknowns) -> Vec<f64> {
        if let (Some(force), Some(scatter)) = (view.force, self.scatter) {
            rows.push((own.force_n / force.norm() - 1.0) / scatter);
        }
        rows
    }
}

/// Computed minus observed position of each marker of a view, mm, in the frame of the view.
pub(super) fn residuals<'v>(
    candidate: &'v Candidate,
    view: &'v View,
    pressed: &'v PressedFinger,
) -> impl Iterator<Item = (&'v Marker, Vector)> {
    view.measurement.markers().iter().zip(pressed.misses_mm().map(|missed| candidate.base.rotation * missed))
}

/// Lower and upper limit of sought contact positions along the front plate, mm.
pub(super) fn free_part_mm(finger: &Finger) -> [f64; 2] {
    [MARGIN, 1.0 - MARGIN].map(|share| share * finger.plate_length_mm(Plate::Front))
}
