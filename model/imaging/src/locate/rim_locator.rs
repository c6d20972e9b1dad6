//! Locator of grey markers by their rims, in surroundings of similar shades, on a finger whose base may move.
//!
//! An image has many round rims. The rims whose positions fit one finger are taken as its markers. If the position of the base is unknown, pairs of
//! rims propose positions. The two rims of a pair may be references on the base, or the two ends of a rib. The proposal with the least cost of
//! assigning the markers to nodes (naming the markers) is chosen.

use super::disc::{Buffers, Cover, Disc, UsualCover, median};
use super::elsewhere::{Scenery, ribs_near_base};
use super::error::require_own_junctions;
use super::naming::{Candidate, Marked, Names, NamingError, name, name_at_cost};
use super::rim::{GreyView, Rim, RimShape, rims};
use super::together::{outline_of, wider, without_faint};
use super::{LocateError, Located, LocatorError, SeenRadii, radius_at, radius_px, require_size};
use crate::RgbRows;
use finray_model::camera::Camera;
use finray_model::rigid_fit::rigid_fit;
use finray_model::scene::{Base, MarkerLook, Markers, Reference};
use finray_model::{Finger, NodeId, Vector};
use nalgebra::Isometry2;

/// Tolerance of the distance between two references, mm. The total tolerance is the root sum of squares of this length and of the share
/// [`REFERENCE_SHARE`] of the distance.
const REFERENCE_MM: f64 = 1.5;
/// Tolerance of the distance between two references, as a share of that distance.
const REFERENCE_SHARE: f64 = 0.03;
/// Two rims may be the ends of a rib if their distance deviates from the rib's length by at most this share. The share is large, because the scene's geometry
/// is nominal.
const RIB_SHARE: f64 = 0.08;
/// A rim has cost 1 if the standard deviation of its centre as found by rays is this share of the markers' stated radius. Markers are round, so a rim
/// whose centre has a larger standard deviation costs more.
const ROUND: f64 = 0.02;
/// A rim is rejected as a marker if its standard deviation, as found by rays, exceeds this multiple of the median over all assigned rims. All markers
/// have the same shape, so their standard deviations should be similar.
const LEAST_ROUND: f64 = 4.0;
/// Another position of the base counts as equally good if its cost exceeds the least cost by at most this (dimensionless).
const ALIKE: f64 = 4.0;
/// References are rejected if ribs propose another position of the base whose cost is lower by more than this. The value exceeds the cost of two hidden
/// markers.
const CONTRADICTS: f64 = 13.0;
/// Standard deviation of the position of a base without references about the position estimated from the ribs, mm. The value allows for bending of
/// the finger.
const UNKNOWN_MM: f64 = 10.0;
/// Standard deviation of the rotation of a base without references about the rotation estimated from the ribs, rad.
const UNKNOWN_RAD: f64 = 0.2;
/// Largest number of nodes to which equally good positions of the base may assign different rims. If the assignments differ at more nodes, the image
/// is rejected as ambiguous.
const MOST_DOUBTFUL: usize = 1;

/// A finger that was located in an image.
#[derive(Debug, Clone, PartialEq)]
pub struct SeenFinger {
    /// Pose of the finger's base.
    pub base: SeenBase,
    /// Markers in the order of their nodes, with positions in the finger frame. The standard deviations of the positions include the uncertainty of
    /// the base's pose.
    pub located: Vec<Located>,
    /// Measured radii of markers and references.
    pub radii: SeenRadii,
}

/// Pose of a finger's base in an image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeenBase {
    /// Transform (rotation, and translation in mm) from the finger frame, which moves with the base, to the finger frame at the scene's camera pose.
    pub pose: Isometry2<f64>,
    /// Whether the camera's pose or two references determine the pose of the base. If the pose is not known, the markers determine it only roughly,
    /// and displacements relative to the base are unknown.
    pub is_known: bool,
    /// Mean position of the references, mm, finger frame.
    pub middle: Vector,
    /// Standard deviation of one coordinate of `middle`, mm. All markers of an image share the error of the base's position.
    pub sd_mm: f64,
    /// Standard deviation of the base's rotation about `middle`, rad. All markers of an image share the error of the base's rotation.
    pub sd_rad: f64,
}

impl SeenBase {
    /// Standard deviation of one coordinate of a position in the finger frame, mm, due to the uncertainty of the base's pose. The result is the root
    /// mean square of the standard deviations in x and y.
    pub fn sd_at(&self, position: &Vector) -> f64 {
        self.sd_mm.hypot(self.sd_rad * (position - self.middle).norm() / std::f64::consts::SQRT_2)
    }
}

/// Locator of the grey markers of one finger with one camera.
#[derive(Debug, Clone)]
pub struct RimLocator<'f> {
    finger: &'f Finger,
    camera: Camera,
    shape: RimShape,
    radius_px: f64,
    base: Option<Base>,
}

/// A proposed pose of the base.
struct Proposal {
    base: Isometry2<f64>,
    /// Standard deviation of the proposed position of the base, mm.
    sd_mm: f64,
    /// Index of the rim that shows each reference, in the order of the references; `None` for a reference that was not found.
    references: Vec<Option<usize>>,
}

impl<'f> RimLocator<'f> {
    /// A locator for the finger, camera and markers of a scene. `base` contains the reference marks on a moving base; it is `None` for a fixed base.
    ///
    /// # Errors
    /// [`LocatorError`] for coloured markers, shared junctions of ribs, or a camera that does not see the finger.
    pub fn new(
        finger: &'f Finger,
        camera: &Camera,
        markers: &Markers,
        base: Option<&Base>,
    ) -> Result<RimLocator<'f>, LocatorError> {
        let shape = shape_of(markers)?;
        require_own_junctions(finger)?;
        let radius_px = match base {
            None => radius_px(finger, camera, markers)?,
            // The finger may be anywhere in the image, so the radius in px is computed at the middle of the image.
            Some(_) => radius_at(camera, &camera.lens.middle(), markers)?,
        };
        Ok(RimLocator { finger, camera: *camera, shape, radius_px, base: base.cloned() })
    }

    /// Locates the markers in an image; hidden markers are omitted. Makes no assumption about the shape of the finger.
    ///
    /// # Errors
    /// [`LocateError`] if the image does not show the finger, or the markers cannot be assigned to nodes uniquely.
    pub fn locate(&self, image: &impl RgbRows) -> Result<SeenFinger, LocateError> {
        require_size(&self.camera.lens, image)?;
        let view = GreyView::new(&self.camera, image);
        let rims = rims(&view, &self.shape, self.radius_px);
        let Some(base) = &self.base else {
            let candidates = self.candidates(&rims, &Isometry2::identity());
            let names = name(Marked::at_base(self.finger), &candidates);
            let seen: Vec<_> = candidates.into_iter().zip(rims.iter().map(|rim| rim.pixel)).collect();
            let (finger, camera, height_mm) = (self.finger, &self.camera, self.shape.height_mm);
            if let Some(error) = (Scenery { finger, camera, height_mm, seen: &seen }).elsewhere(&names) {
                return Err(error);
            }
            // A fixed base is exactly where the scene's camera pose puts it.
            let base = SeenBase { is_known: true, ..SeenBase::default() };
            let (named, _) = self.named(&view, &rims, &names?);
            let radii = SeenRadii { markers_mm: middle_radius_mm(&named), references_mm: Vec::new() };
            return Ok(SeenFinger { located: located(&named, &base), base, radii });
        };
        let marks: Vec<Vec<Rim>> = self.marks(&view, base);
        let proposals = match base.references.len() {
            0 | 1 => self.by_ribs(&rims),
            _ => by_references(base, &marks),
        };
        if proposals.is_empty() && base.references.len() > 1 && !rims.is_empty() {
            let like_references = marks.iter().map(Vec::len).collect();
            return Err(LocateError::NoReferences { like_references, like_markers: rims.len() });
        }
        let (cost, best) = self.best(&rims, &proposals)?;
        if best.references.iter().flatten().count() > 1 {
            self.require_base_of_finger(&rims, best, cost)?;
        }
        let marked = Marked { finger: self.finger, base_sd_mm: best.sd_mm };
        let names = name(marked, &self.candidates(&rims, &best.base))?;
        let (named, wider) = self.named(&view, &rims, &names);
        let radius_mm = |i: usize| Some(marks[i][best.references.get(i).copied().flatten()?].radius_mm);
        let references_mm = (0..marks.len()).map(radius_mm).collect();
        let radii = SeenRadii { markers_mm: middle_radius_mm(&named), references_mm };
        let base = seen_base(base, &marks, best, wider);
        Ok(SeenFinger { located: located(&named, &base), base, radii })
    }

    /// For each reference, the rims that may show it. References with the same appearance are searched for only once.
    fn marks(&self, view: &GreyView, base: &Base) -> Vec<Vec<Rim>> {
        let mut known: Vec<(RimShape, Vec<Rim>)> = Vec::new();
        let of_reference = |reference: &Reference| {
            let Ok(shape) = shape_of(&reference.markers) else { return Vec::new() };
            if let Some((_, marks)) = known.iter().find(|(other, _)| *other == shape) {
                return marks.clone();
            }
            let marks = rims(view, &shape, self.radius_px * shape.radius_mm / self.shape.radius_mm);
            known.push((shape, marks.clone()));
            marks
        };
        base.references.iter().map(of_reference).collect()
    }

    /// Proposals for the pose of the base, from pairs of rims that may be the ends of a rib near the base.
    fn by_ribs(&self, rims: &[Rim]) -> Vec<Proposal> {
        let mut proposals = Vec::new();
        for (nodes, sd_mm) in ribs_near_base(self.finger) {
            let ends = nodes.map(|node| self.finger.marker_position(node));
            let rib_mm = (ends[0] - ends[1]).norm();
            for seen in pairs(rims, rims, rib_mm, RIB_SHARE * rib_mm) {
                let base = fitted(&[(ends[0], seen[0]), (ends[1], seen[1])]);
                proposals.push(Proposal { base, sd_mm, references: Vec::new() });
            }
        }
        proposals
    }

    /// The proposal with the least cost of assigning rims to nodes, and that cost.
    fn best<'p>(&self, rims: &[Rim], proposals: &'p [Proposal]) -> Result<(f64, &'p Proposal), NamingError> {
        let mut best: Option<(f64, &Proposal, Names)> = None;
        let mut others: Vec<(f64, Names)> = Vec::new();
        for proposal in proposals {
            let marked = Marked { finger: self.finger, base_sd_mm: proposal.sd_mm };
            let Some((names, cost)) = name_at_cost(marked, &self.candidates(rims, &proposal.base)) else { continue };
            others.push((cost, names.clone()));
            if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                best = Some((cost, proposal, names));
            }
        }
        let all = self.finger.marked_nodes().len();
        let none = NamingError::TooFew { found: 0, all, least: (all / 3).max(all.min(3)) };
        let (cost, proposal, names) = best.ok_or(none)?;
        for (_, other) in others.iter().filter(|(other, _)| *other <= cost + ALIKE) {
            let nodes = names.iter().zip(other).filter(|(a, b)| a != b).count();
            if nodes > MOST_DOUBTFUL {
                return Err(NamingError::Places { nodes });
            }
        }
        Ok((cost, proposal))
    }

    /// Rejects the base's position from references if the ribs near the base fit another position far better. If another position fits far better,
    /// the supposed references are other marks.
    fn require_base_of_finger(&self, rims: &[Rim], by_references: &Proposal, cost: f64) -> Result<(), LocateError> {
        // If the position from ribs is ambiguous, it does not contradict the references.
        let proposals = self.by_ribs(rims);
        let Ok((cost_of_ribs, by_ribs)) = self.best(rims, &proposals) else { return Ok(()) };
        let away_mm = (by_ribs.base.translation.vector - by_references.base.translation.vector).norm();
        match cost_of_ribs + CONTRADICTS < cost && away_mm > by_ribs.sd_mm {
            true => Err(LocateError::OtherReferences { away_mm }),
            false => Ok(()),
        }
    }

    /// Rims as candidates for markers, with positions in the finger frame.
    fn candidates(&self, rims: &[Rim], base: &Isometry2<f64>) -> Vec<Candidate> {
        let candidate = |rim: &Rim| Candidate {
            sides: [true; 2],
            at: base.inverse_transform_point(&rim.centre.into()).coords,
            node: None,
            cost: (rim.rays_sd_mm / (ROUND * self.shape.radius_mm)).powi(2),
        };
        rims.iter().map(candidate).collect()
    }

    /// The rims that are assigned to nodes, except rims that are far less round than the other rims. The rims have one common outline, and standard
    /// deviations that allow for what may cover them in part. Also returns the factor by which the standard deviations of markers, and of marks on the
    /// base, exceed the values for independent pixel errors: background that the edge model neglects makes the errors of neighbouring pixels correlated,
    /// and the markers' residuals show how strongly.
    fn named(&self, view: &GreyView, rims: &[Rim], names: &Names) -> (Vec<(NodeId, Rim)>, f64) {
        let mut named: Vec<(NodeId, Rim)> =
            names.iter().enumerate().filter_map(|(i, name)| Some((NodeId(i + 1), rims[(*name)?]))).collect();
        let most_mm = LEAST_ROUND * median(named.iter().map(|(_, rim)| rim.rays_sd_mm)).unwrap_or_default();
        named.retain(|(_, rim)| rim.rays_sd_mm <= most_mm);
        let discs = |named: &[(NodeId, Rim)]| -> Vec<Disc> { named.iter().filter_map(|(_, rim)| rim.disc).collect() };
        let (outline, mut buffers) = (outline_of(discs(&named).into_iter()), Buffers::default());
        let again =
            |(node, rim): &(NodeId, Rim)| Some((*node, rim.with_outline(view, &self.shape, outline, &mut buffers)?));
        named = named.iter().filter_map(again).collect();
        let by_edge = discs(&named);
        let wider = wider(by_edge.iter().map(|disc| disc.excess_variances));
        let usual = UsualCover::of(by_edge.iter().map(|disc| disc.cover));
        let of_rays = |rim: &Rim| Cover { missed: rim.missed, ..Cover::default() };
        let usual_of_rays = UsualCover::of(named.iter().map(|(_, rim)| of_rays(rim)));
        let widened = |(node, rim): &(NodeId, Rim)| {
            let (wider, usual, cover) = match rim.disc {
                Some(disc) => (wider, &usual, disc.cover),
                None => (1.0, &usual_of_rays, of_rays(rim)),
            };
            let outer_sd_mm = usual.widened_mm(rim.outer_sd_mm * wider, &cover);
            Some((*node, rim.combined(view, &self.shape, outer_sd_mm, wider)?))
        };
        (named.iter().filter_map(widened).collect(), wider)
    }
}

fn middle_radius_mm(named: &[(NodeId, Rim)]) -> Option<f64> {
    median(named.iter().map(|(_, rim)| rim.radius_mm))
}

/// Located markers, without uncertain ones.
fn located(named: &[(NodeId, Rim)], base: &SeenBase) -> Vec<Located> {
    let located = |(node, rim): &(NodeId, Rim)| {
        let position = base.pose.inverse_transform_point(&rim.centre.into()).coords;
        Located { node: *node, pixel: rim.pixel, position, sd_mm: rim.sd_mm.hypot(base.sd_at(&position)) }
    };
    without_faint(named.iter().map(located).collect())
}

fn shape_of(markers: &Markers) -> Result<RimShape, LocatorError> {
    let MarkerLook::Grey { shade, inner_radius_mm } = markers.look else { return Err(LocatorError::NotGrey) };
    Ok(RimShape { radius_mm: markers.radius_mm, inner_radius_mm, shade, height_mm: markers.height_mm })
}

/// Pose of the base that a proposal's references determine. `wider` is the factor on the standard deviations of the reference marks.
fn seen_base(base: &Base, marks: &[Vec<Rim>], proposal: &Proposal, wider: f64) -> SeenBase {
    let found = |i: usize| Some(marks[i][proposal.references.get(i).copied().flatten()?]);
    let seen: Vec<(Vector, Rim)> =
        base.references.iter().enumerate().filter_map(|(i, reference)| Some((reference.at, found(i)?))).collect();
    let count = seen.len() as f64;
    let middle = seen.iter().map(|(at, _)| at).sum::<Vector>() / count.max(1.0);
    let variance = seen.iter().map(|(_, rim)| rim.widened_sd_mm(wider).powi(2)).sum::<f64>() / count.max(1.0);
    let spread: f64 = seen.iter().map(|(at, _)| (at - middle).norm_squared()).sum();
    let is_known = seen.len() > 1;
    SeenBase {
        pose: proposal.base,
        is_known,
        middle,
        sd_mm: if is_known { (variance / count).sqrt() } else { UNKNOWN_MM },
        sd_rad: if is_known { (variance / spread).sqrt() } else { UNKNOWN_RAD },
    }
}

/// Centres of pairs of rims, one from `first` and one from `second`, whose distance equals `distance_mm` within `tolerance_mm`. Two rims that are in
/// both lists form a pair in either order.
fn pairs(first: &[Rim], second: &[Rim], distance_mm: f64, tolerance_mm: f64) -> impl Iterator<Item = [Vector; 2]> {
    let all = first.iter().flat_map(move |a| second.iter().map(move |b| [a.centre, b.centre]));
    all.filter(move |[a, b]| a != b && ((a - b).norm() - distance_mm).abs() <= tolerance_mm)
}

/// Proposals for the pose of the base from pairs of references. Only the proposals with the largest number of found references are kept.
fn by_references(base: &Base, marks: &[Vec<Rim>]) -> Vec<Proposal> {
    let places: Vec<Vector> = base.references.iter().map(|reference| reference.at).collect();
    let mut proposals: Vec<Proposal> = Vec::new();
    for first in 0..places.len() {
        for second in first + 1..places.len() {
            let ends = [places[first], places[second]];
            let distance_mm = (ends[0] - ends[1]).norm();
            let tolerance_mm = REFERENCE_MM.hypot(REFERENCE_SHARE * distance_mm);
            for seen in pairs(&marks[first], &marks[second], distance_mm, tolerance_mm) {
                let rough = fitted(&[(ends[0], seen[0]), (ends[1], seen[1])]);
                let nearest = |(place, marks): (&Vector, &Vec<Rim>)| {
                    let at = (rough * nalgebra::Point2::from(*place)).coords;
                    let away = |mark: &Rim| (mark.centre - at).norm();
                    let nearest = (0..marks.len()).min_by(|&a, &b| away(&marks[a]).total_cmp(&away(&marks[b])))?;
                    (away(&marks[nearest]) <= 2.0 * tolerance_mm).then_some(nearest)
                };
                let references: Vec<Option<usize>> = places.iter().zip(marks).map(nearest).collect();
                let found: Vec<(Vector, Vector)> = references
                    .iter()
                    .enumerate()
                    .filter_map(|(i, mark)| Some((places[i], marks[i][(*mark)?].centre)))
                    .collect();
                proposals.push(Proposal { base: fitted(&found), sd_mm: REFERENCE_MM, references });
            }
        }
    }
    let found = |proposal: &Proposal| proposal.references.iter().flatten().count();
    let most = proposals.iter().map(found).max().unwrap_or(0);
    proposals.retain(|proposal| found(proposal) == most);
    proposals
}

/// Rigid motion that maps the first point of each pair onto the second point.
fn fitted(pairs: &[(Vector, Vector)]) -> Isometry2<f64> {
    rigid_fit(pairs.iter().map(|(from, to)| (*from, *to, 1.0)))
}
