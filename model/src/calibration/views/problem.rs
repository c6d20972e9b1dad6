//! Least-squares problem of a calibration: all views and their own unknowns at once.

use super::quantity::changed;
use super::{Quantity, Sought, View, ViewModel};
use crate::finger::{Finger, Plate, RibPositions};
use crate::frame::{FrameLoad, FrameMotion};
use crate::measurement::{Marker, MarkerErrors};
use crate::mesh::Mesh;
use crate::sensing::{AssemblyErrors, Contact, ContactPosition, Normal, PadForce, plate_turn};
use crate::statics::Statics;
use crate::{Kinematics, Vector};
use nalgebra::{Isometry2, Point2, UnitComplex};
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
/// The normal has settled if its rotation changes by at most this angle in a step, rad. The iteration fails after `NORMAL_STEPS` steps.
const SETTLED_RAD: f64 = 1e-9;
const NORMAL_STEPS: usize = 60;

/// All unknowns, as one point of the search.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Point {
    /// Changes of the quantities that all views share: the logarithm of a factor, or a change in mm, degrees, N mm or standard deviations.
    pub shared: Vec<f64>,
    /// Unknowns of each view.
    pub own: Vec<ViewUnknowns>,
}

/// The unknowns of one view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ViewUnknowns {
    /// Position of the force along the front plate, mm.
    pub s_mm: f64,
    /// Deviation of this view's base from the shared pose, mm and rad.
    pub base: Isometry2<f64>,
    /// Magnitude of the force, N.
    pub force_n: f64,
    /// Difference between the lean of the force (its angle from the normal) and the mean lean, degrees.
    pub further_lean_deg: f64,
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
    /// Deviation of the lean (angle between force and normal) from the mean lean, degrees, common to all forces that were not measured.
    pub lean_deg: f64,
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
}

/// Equilibrium of a finger under the force of a view.
pub(super) struct Pressed {
    /// The force in the finger frame, N.
    pub force: Vector,
    /// Displacements and rotations of the mesh.
    pub motion: FrameMotion,
    /// Rotation of the plate's normal at the contact, rad.
    pub normal_turn_rad: f64,
    loads: Vec<FrameLoad>,
    plate_rad: f64,
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
        let (mut preload_nmm, mut lean_deg) = (self.model.preload_nmm, 0.0);
        for (sought, &change) in self.sought.iter().zip(shared) {
            match sought.quantity {
                Quantity::MarkerHeight => marker_height_mm += change,
                Quantity::BaseX => at.x += change,
                Quantity::BaseY => at.y += change,
                Quantity::BaseTurn => turn_deg += change,
                Quantity::Preload => preload_nmm += change,
                Quantity::Lean => lean_deg += change,
                of_finger => changed(&mut description, self.finger.rib_count(), of_finger, change),
            }
        }
        let finger = Finger::new(description).ok()?;
        let base = Isometry2::new(at, turn_deg.to_radians());
        let mesh = Mesh::with_elements_per_member(&finger, self.model.elements);
        Some(Candidate { mesh, marker_height_mm, base, preload_nmm, lean_deg })
    }

    /// Each view with its unknowns at a point, the rows of its residuals, and the first column of its unknowns.
    pub(super) fn parts<'s, 'p>(
        &'s self,
        point: &'p Point,
    ) -> impl Iterator<Item = (&'s View, &'p ViewUnknowns, Range<usize>, usize)> {
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

    /// Number of residuals of a view: for the markers, for the base, and for a measured force that is not exact. Without a measured force, the last
    /// residual is for the lean (angle between force and normal).
    pub(super) fn row_count(&self, view: &View) -> usize {
        let further = usize::from(view.force.is_none() || self.scatter.is_some());
        view.measurement.coordinate_count() + BASE_ROWS + further
    }

    /// Equilibrium under the force of a view. `None` if the finger has no equilibrium under the force of the view.
    pub(super) fn pressed(&self, candidate: &Candidate, view: &View, own: &ViewUnknowns) -> Option<Pressed> {
        self.pressed_from(None, candidate, view, own)
    }

    /// Equilibrium under the force of a view. The search starts from `near`, the equilibrium of almost the same finger and force, unless a changed
    /// length gives the fingers different frames: for instance, two ribs at one junction may move apart.
    fn pressed_from(
        &self,
        near: Option<&Pressed>,
        candidate: &Candidate,
        view: &View,
        own: &ViewUnknowns,
    ) -> Option<Pressed> {
        let finger = candidate.mesh.finger();
        let near = near.filter(|near| near.motion.fits(candidate.mesh.frame()));
        let over_mm = match self.model.lean.from {
            Normal::Deformed { over_mm } => over_mm,
            Normal::Undeformed | Normal::Object => 0.0,
        };
        let mut statics = Statics::ladder(&candidate.mesh, Kinematics::Corotational);
        let pad = self.model.pad;
        let measured = view
            .force
            .map(|force| (candidate.base * own.base).rotation.inverse() * force * (own.force_n / force.norm()));
        let lean_deg = self.model.lean.mean_deg(own.force_n) + candidate.lean_deg + own.further_lean_deg;
        // The direction of a force and the load of a pad may depend on the normal, which the force itself rotates. A few iterations settle this
        // rotation.
        let preload = AssemblyErrors::load(finger, candidate.preload_nmm);
        let preload = candidate.mesh.frame_load(&preload).ok().filter(|_| candidate.preload_nmm != 0.0);
        let turns_lean = matches!((view.force, self.model.lean.from), (None, Normal::Deformed { .. }));
        let mut normal_rad = near.filter(|_| turns_lean).map_or(0.0, |near| near.normal_turn_rad);
        let mut plate_rad = near.map_or(0.0, |near| near.plate_rad);
        let mut last = near.map(|near| (near.motion.clone(), near.loads.clone()));
        for _ in 0..NORMAL_STEPS {
            let leaning = || finger.direction(lean_deg + normal_rad.to_degrees()) * own.force_n;
            let force = measured.unwrap_or_else(leaning);
            let angle_deg = finger.angle_deg(force);
            let contact = Contact { position: ContactPosition::at(own.s_mm), angle_deg };
            let force_on_pad = PadForce { contact, force_n: force.norm(), pad, plate_turn_rad: plate_rad };
            let mut loads = force_on_pad.loads(&candidate.mesh).collect::<Result<Vec<_>, _>>().ok()?;
            loads.extend(preload);
            // The normal turns little per step, so the search starts from the last equilibrium.
            let near = last.take().and_then(|(motion, from)| statics.shifted(&motion, &from, &loads).ok());
            let motion = near.map_or_else(|| statics.equilibrium(&loads), Ok).ok()?.motion;
            let load = contact.unit_load(finger);
            let normal_turn_rad = candidate.mesh.normal_turn(&motion, &load, over_mm).ok()?;
            let before = [normal_rad, plate_rad];
            if turns_lean {
                normal_rad = normal_turn_rad;
            }
            plate_rad = plate_turn(pad, &candidate.mesh, &contact, &motion).ok()?;
            if (normal_rad - before[0]).abs().max((plate_rad - before[1]).abs()) <= SETTLED_RAD {
                return Some(Pressed { force, motion, normal_turn_rad, loads, plate_rad });
            }
            last = Some((motion, loads));
        }
        None
    }

    /// Computed minus observed position of each marker of a view, mm, in the frame of the view.
    pub(super) fn residuals<'v>(
        &self,
        candidate: &'v Candidate,
        view: &'v View,
        own: &ViewUnknowns,
        pressed: &'v Pressed,
    ) -> impl Iterator<Item = (&'v Marker, Vector)> {
        let (finger, stated) = (candidate.mesh.finger(), self.finger);
        let placed = candidate.base * own.base;
        let height_mm = self.model.camera_height_mm;
        // Markers above their stated height appear farther from the camera's axis than they are.
        let nearer = (height_mm - candidate.marker_height_mm) / (height_mm - self.model.marker_height_mm);
        view.measurement.markers().iter().map(move |marker| {
            let (at, node) = (finger.marker_position(marker.node), candidate.mesh.marker_node(marker.node));
            let bent = at + pressed.motion.displacements[node];
            let seen = stated.marker_position(marker.node) + marker.displacement;
            (marker, (placed * Point2::from(bent)).coords - (view.eye + (seen - view.eye) * nearer))
        })
    }

    /// Residuals of one view divided by their standard deviations, priors last. The search for the equilibrium starts from `near`. `None` if no equilibrium is
    /// found.
    pub(super) fn weighted(
        &self,
        near: Option<&Pressed>,
        candidate: &Candidate,
        view: &View,
        own: &ViewUnknowns,
    ) -> Option<Vec<f64>> {
        let pressed = self.pressed_from(near, candidate, view, own)?;
        let mut rows = Vec::with_capacity(view.measurement.coordinate_count() + OWN);
        for (marker, residual) in self.residuals(candidate, view, own, &pressed) {
            let sd_mm = self.errors.sd_mm(view.noise_mm / marker.weight);
            rows.extend((residual / sd_mm).iter());
        }
        let at = own.base.translation.vector / view.base.sd_mm;
        let turn_rad = own.base.rotation.angle() - view.base.turn_rad_per_n * own.force_n;
        rows.extend([at.x, at.y, turn_rad / view.base.sd_rad_under(own.force_n)]);
        if let (Some(force), Some(scatter)) = (view.force, self.scatter) {
            rows.push((own.force_n / force.norm() - 1.0) / scatter);
        }
        if view.force.is_none() {
            rows.push(own.further_lean_deg / self.further_lean_sd_deg());
        }
        Some(rows)
    }
}

impl ViewUnknowns {
    /// Unknowns of a view in which the force has the mean lean and the base has the shared pose.
    pub(super) fn at(s_mm: f64, force_n: f64) -> ViewUnknowns {
        ViewUnknowns { s_mm, base: Isometry2::identity(), force_n, further_lean_deg: 0.0 }
    }

    /// A copy in which one unknown (by index) is changed by `by`, in mm, rad, N or degrees.
    pub(super) fn moved(&self, finger: &Finger, unknown: usize, by: f64) -> ViewUnknowns {
        let mut moved = *self;
        match unknown {
            0 => {
                let [least_mm, most_mm] = free_part_mm(finger);
                moved.s_mm = (self.s_mm + by).clamp(least_mm, most_mm);
            }
            1 => moved.base.translation.x += by,
            2 => moved.base.translation.y += by,
            3 => moved.base.rotation = UnitComplex::new(by) * self.base.rotation,
            4 => moved.force_n += by,
            _ => moved.further_lean_deg += by,
        }
        moved
    }
}

/// Lower and upper limit of sought contact positions along the front plate, mm.
pub(super) fn free_part_mm(finger: &Finger) -> [f64; 2] {
    [MARGIN, 1.0 - MARGIN].map(|share| share * finger.plate_length_mm(Plate::Front))
}
