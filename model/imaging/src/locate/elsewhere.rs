//! Detection of a finger that is not where the scene's camera pose puts it: upside down, mirrored, displaced, rotated or scaled.
//!
//! First, flips of the image are tried. If no flip fits, pairs of markers propose a placement and a scale of the finger. A pair that proposes a
//! placement consists of the two clamped markers, or of the markers at the ends of a rib near the base. The proposal with the least cost of naming
//! its markers (assigning them to nodes) is chosen.

use super::LocateError;
use super::finger_placement::FingerPlacement;
use super::naming::{Candidate, Marked, Names, NamingError, name_at_cost};
use finray_model::camera::{Camera, Pixel};
use finray_model::finger::Plate;
use finray_model::{Finger, NodeId, Vector};

/// Number of ribs, counted from the base, whose end markers propose a placement in addition to the clamped markers.
const PROPOSING: usize = 2;
/// Standard deviation of the base's position that a rib proposes, as a share of the plate's length up to the rib. The deviation arises because the
/// plate bends.
const BEND_SHARE: f64 = 0.2;
/// A placement is considered only if at least half of the other rib ends near the base have a candidate within this distance of their predicted
/// positions. The distance is a share of the node's distance from the base.
const BENT: f64 = 0.35;
/// Another placement is accepted only if its cost is lower by at least this value than the cost at the scene's camera pose. The value exceeds the
/// cost of two hidden markers.
const GAIN: f64 = 13.0;
/// A placement other than the scene's is accepted only if at least this share of the finger's markers is assigned.
const LEAST_NAMED: f64 = 0.65;

/// Possible flips of an image: description, and signs of u and v about the image's middle.
const FLIPS: [(&str, [f64; 2]); 3] = [
    ("upside down", [-1.0, -1.0]),
    ("mirrored from left to right", [-1.0, 1.0]),
    ("mirrored from top to bottom", [1.0, -1.0]),
];

/// Candidates for markers, found in an image of a finger.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scenery<'a> {
    pub finger: &'a Finger,
    pub camera: &'a Camera,
    /// Height of the markers above the finger's plane, mm.
    pub height_mm: f64,
    /// Candidates for markers, each with its pixel.
    pub seen: &'a [(Candidate, Pixel)],
}

impl Scenery<'_> {
    /// The error for a finger at another placement, if the markers fit that placement significantly better than the scene's camera pose. `None` if no
    /// other placement fits significantly better, or if all clamped markers are at their stated positions.
    pub fn elsewhere(&self, names: &Result<Names, NamingError>) -> Option<LocateError> {
        let finger = self.finger;
        let is_seen = |node: &NodeId| names.as_ref().is_ok_and(|names| names[node.0 - 1].is_some());
        let mut clamped = finger.clamped_nodes().into_iter().filter(|node| finger.has_marker(*node)).peekable();
        if clamped.peek().is_some() && clamped.all(|node| is_seen(&node)) {
            return None;
        }
        let candidates: Vec<Candidate> = self.seen.iter().map(|(candidate, _)| *candidate).collect();
        let cost_here = name_at_cost(Marked::at_base(finger), &candidates).map_or(f64::INFINITY, |(_, cost)| cost);
        if cost_here <= GAIN {
            return None;
        }
        let cost = |candidates: &[Candidate], base_sd_mm: f64| {
            let (names, cost) = name_at_cost(Marked { finger, base_sd_mm }, candidates)?;
            let is_finger = named(&names) >= LEAST_NAMED * super::marker_count(finger) as f64;
            (is_finger && cost + GAIN < cost_here).then_some(cost)
        };
        let flips = FLIPS.iter().filter_map(|(name, signs)| Some((cost(&self.flipped(*signs), 0.0)?, *name)));
        if let Some((_, name)) = flips.min_by(|a, b| a.0.total_cmp(&b.0)) {
            return Some(LocateError::Flipped(name));
        }
        let mut best: Option<(f64, FingerPlacement)> = None;
        for (ends, sd_mm) in proposing_ends(finger) {
            for place in places(finger, &candidates, ends) {
                let to_finger = |candidate: &Candidate| Candidate { at: place.to_finger(&candidate.at), ..*candidate };
                let moved: Vec<Candidate> = candidates.iter().map(to_finger).collect();
                if let Some(cost) = cost(&moved, sd_mm).filter(|cost| best.is_none_or(|(least, _)| *cost < least)) {
                    best = Some((cost, place));
                }
            }
        }
        best.filter(|(_, place)| place.is_other()).map(|(_, place)| LocateError::Elsewhere(place))
    }

    /// Candidates for markers after the image is flipped.
    fn flipped(&self, signs: [f64; 2]) -> Vec<Candidate> {
        let middle = self.camera.lens.middle();
        let flipped = |(candidate, pixel): &(Candidate, Pixel)| {
            let pixel = middle + (pixel - middle).component_mul(&Pixel::from(signs));
            Some(Candidate { at: self.camera.on_plane(&pixel, self.height_mm).ok()?, ..*candidate })
        };
        self.seen.iter().filter_map(flipped).collect()
    }
}

fn named(names: &Names) -> f64 {
    names.iter().flatten().count() as f64
}

/// Pairs of a front and a back node whose markers propose a placement, each with the standard deviation of the base's position, mm.
fn proposing_ends(finger: &Finger) -> Vec<([NodeId; 2], f64)> {
    let clamped = [Plate::Front, Plate::Back].map(|plate| finger.plate_nodes(plate)[0]);
    let ends = std::iter::once((clamped, 0.0)).chain(ribs_near_base(finger));
    ends.filter(|(ends, _)| ends.iter().all(|node| finger.has_marker(*node))).collect()
}

/// End nodes of the ribs near the base, each pair with the standard deviation of the base's position that the pair proposes, mm.
pub(super) fn ribs_near_base(finger: &Finger) -> impl Iterator<Item = ([NodeId; 2], f64)> {
    let plate_mm = finger.plate_positions_mm(Plate::Front);
    (0..finger.rib_count().min(PROPOSING)).map(move |rib| (finger.rib_nodes(rib), BEND_SHARE * plate_mm[rib + 1]))
}

/// Placements that map the two nodes `ends` to two candidates, and at least half of the other rib ends near the base to positions near candidates.
fn places(finger: &Finger, candidates: &[Candidate], ends: [NodeId; 2]) -> Vec<FingerPlacement> {
    let at = ends.map(|node| finger.marker_position(node));
    let next = (0..finger.rib_count().min(PROPOSING)).flat_map(|rib| {
        let reach = BENT * finger.plate_positions_mm(Plate::Front)[rib + 1];
        finger.rib_nodes(rib).into_iter().enumerate().map(move |(side, node)| (side, node, reach))
    });
    let next: Vec<(usize, Vector, f64)> = next
        .filter(|(_, node, _)| finger.has_marker(*node) && !ends.contains(node))
        .map(|(side, node, reach)| (side, finger.marker_position(node), reach))
        .collect();
    let of_side = |side: usize| candidates.iter().filter(move |candidate| candidate.sides[side]);
    let mut places = Vec::new();
    for front in of_side(0) {
        for back in of_side(1).filter(|back| back.at != front.at) {
            for is_mirrored in [false, true] {
                let Some(place) = FingerPlacement::through(at, [front.at, back.at], is_mirrored) else { continue };
                let is_seen = |(side, at, reach): &(usize, Vector, f64)| {
                    of_side(*side).any(|candidate| (place.to_finger(&candidate.at) - at).norm() < *reach)
                };
                if 2 * next.iter().filter(|next| is_seen(next)).count() >= next.len() {
                    places.push(place);
                }
            }
        }
    }
    places
}
