//! Detection of the undeformed finger in an image. No initial pose is needed, because two rows of markers that meet at the tip identify the finger.
//!
//! After its lens distortion is removed, a camera maps straight lines to straight lines. Among the lines through two markers of one colour, the line
//! that contains the most markers is taken as a plate. Four markers, two near the ends of each plate, are matched to nodes near the plates' ends and
//! define a homography. The homography that maps the most nodes onto markers decides which marker belongs to which node.

use super::blobs::Blob;
use super::marker_count;
use finray_model::camera::{Lens, Pixel};
use finray_model::finger::Plate;
use finray_model::{Finger, NodeId, Vector};
use nalgebra::Matrix3;

/// At most this number of patches of a marker's colour is considered, the largest patches first.
const MOST_BLOBS: usize = 150;
/// A marker belongs to a plate only within this distance of the line of that plate, in marker radii.
const ON_LINE: f64 = 0.7;
/// A marker belongs to a node only within this distance of the predicted position of that node, in marker radii.
const ON_NODE: f64 = 1.2;
/// At each end of a line, the search allows for fewer than this number of false markers. At each end of a plate, the search allows for fewer than
/// this number of nodes whose markers are hidden.
const DOUBTFUL: usize = 3;
/// A finger is recognised only if the image shows at least this share of its markers.
const LEAST_SHARE: f64 = 0.6;

/// A marker with its undistorted image position (dimensionless) and its pixel.
#[derive(Debug, Clone, Copy)]
struct Mark {
    /// Whether, by its colour, the marker may belong to the front plate, and whether it may belong to the back plate.
    sides: [bool; 2],
    /// Undistorted image position of the marker, dimensionless.
    at: Vector,
    /// Pixel of the marker's centre.
    pixel: Pixel,
}

/// Nodes of the undeformed finger with their pixels; `None` if the image does not show the finger's two rows of markers. `radius_px` is the radius of a marker;
/// `alike` states whether both plates have the same colour.
pub(super) fn at_rest(
    finger: &Finger,
    lens: &Lens,
    blobs: &[Blob],
    (radius_px, alike): (f64, bool),
) -> Option<Vec<(NodeId, Pixel)>> {
    let radius = radius_px / (0.5 * (lens.focal_px()[0] + lens.focal_px()[1]));
    let mark = |blob: &Blob| {
        let sides = [Plate::Front, Plate::Back].map(|side| alike || side == blob.side);
        Some(Mark { sides, at: lens.undistorted(&blob.centre).ok()?, pixel: blob.centre })
    };
    let marks: Vec<Mark> = blobs.iter().take(MOST_BLOBS).filter_map(mark).collect();
    let front = row(&marks, Plate::Front, radius, &[])?;
    let taken: &[usize] = if alike { &front } else { &[] };
    let back = row(&marks, Plate::Back, radius, taken)?;
    let marked = |plate| finger.plate_nodes(plate).into_iter().filter(|node| finger.has_marker(*node));
    let front_nodes: Vec<NodeId> = marked(Plate::Front).collect();
    // The tip counts as a marker of the front plate.
    let back_nodes: Vec<NodeId> = marked(Plate::Back).filter(|node| *node != finger.tip()).collect();
    let mut best = Named::default();
    let rows = if alike { vec![(&front, &back), (&back, &front)] } else { vec![(&front, &back)] };
    for (front, back) in rows {
        for first in ends(front, &front_nodes) {
            for second in ends(back, &back_nodes) {
                let pairs = [first[0], first[1], second[0], second[1]];
                let positions = pairs.map(|(_, node)| finger.marker_position(node));
                let Some(homography) = through(&positions, &pairs.map(|(mark, _)| marks[mark].at)) else { continue };
                // Seen from above (from z > 0), the finger is mirrored in pixel coordinates, because the pixel coordinate `v` increases downwards. If
                // both plates have the same colour, only the handedness of the homography (whether it mirrors the finger) distinguishes them.
                if alike && !is_from_above(&homography, &positions[0]) {
                    continue;
                }
                let found = named(finger, &marks, &homography, radius);
                let (more, fewer) = (found.nodes.len(), best.nodes.len());
                if more > fewer || (more == fewer && found.distance < best.distance) {
                    best = found;
                }
            }
        }
    }
    (best.nodes.len() as f64 >= LEAST_SHARE * marker_count(finger) as f64).then_some(best.nodes)
}

/// Nodes with their pixels, and the sum of the markers' distances from the positions that the homography predicts.
#[derive(Debug, Clone, Default)]
struct Named {
    /// Nodes with the pixels of their markers.
    nodes: Vec<(NodeId, Pixel)>,
    /// Sum of the distances between markers and predicted positions, in undistorted image coordinates, dimensionless.
    distance: f64,
}

/// Markers of a plate, in order along a line. Among all lines through two markers, the line that contains the most markers is chosen. `None` for
/// fewer than two markers. Markers in `taken` are excluded.
fn row(marks: &[Mark], side: Plate, radius: f64, taken: &[usize]) -> Option<Vec<usize>> {
    let of_side: Vec<usize> =
        (0..marks.len()).filter(|i| marks[*i].sides[side as usize] && !taken.contains(i)).collect();
    let mut best: Vec<usize> = Vec::new();
    for (k, &first) in of_side.iter().enumerate() {
        for &second in &of_side[k + 1..] {
            let from = marks[first].at;
            let Some(along) = (marks[second].at - from).try_normalize(radius) else { continue };
            let is_on_line = |&&i: &&usize| (marks[i].at - from).perp(&along).abs() < ON_LINE * radius;
            if of_side.iter().filter(is_on_line).count() > best.len() {
                best = of_side.iter().filter(is_on_line).copied().collect();
                best.sort_by(|&a, &b| marks[a].at.dot(&along).total_cmp(&marks[b].at.dot(&along)));
            }
        }
    }
    (best.len() >= 2).then_some(best)
}

/// Pairs of markers near the ends of a row, matched to pairs of nodes near the ends of a plate. Each row is matched in both directions.
fn ends(row: &[usize], nodes: &[NodeId]) -> Vec<[(usize, NodeId); 2]> {
    let mut ways = Vec::new();
    for (i, k) in (0..DOUBTFUL).flat_map(|i| (0..DOUBTFUL).map(move |k| (i, k))) {
        for (n, m) in (0..DOUBTFUL).flat_map(|n| (0..DOUBTFUL).map(move |m| (n, m))) {
            // A skipped marker is assumed not to belong to the finger; the marker of a skipped node is assumed to be hidden.
            if i + k + 2 > row.len() || n + m + 2 > nodes.len() {
                continue;
            }
            let (first, last) = (row[i], row[row.len() - 1 - k]);
            let (near, far) = (nodes[n], nodes[nodes.len() - 1 - m]);
            ways.push([(first, near), (last, far)]);
            ways.push([(last, near), (first, far)]);
        }
    }
    ways
}

/// The homography that maps `positions` to `seen`; `None` if three of the positions, or the first three of `seen`, lie on one line.
fn through(positions: &[Vector; 4], seen: &[Vector; 4]) -> Option<Matrix3<f64>> {
    Some(from_basis(seen)? * from_basis(positions)?.try_inverse()?)
}

/// The homography that maps the three unit vectors and their sum to four points; `None` if the first three points lie on one line.
fn from_basis(points: &[Vector; 4]) -> Option<Matrix3<f64>> {
    let [first, second, third, sum] = points.map(|point| point.push(1.0));
    let columns = Matrix3::from_columns(&[first, second, third]);
    Some(columns * Matrix3::from_diagonal(&(columns.try_inverse()? * sum)))
}

fn is_from_above(homography: &Matrix3<f64>, at: &Vector) -> bool {
    let depth = (homography * at.push(1.0)).z;
    homography.determinant() / depth.powi(3) < 0.0
}

/// Nodes with a marker near the position that the homography predicts. If two nodes claim the same marker, the result is empty.
fn named(finger: &Finger, marks: &[Mark], homography: &Matrix3<f64>, radius: f64) -> Named {
    let mut named = Named::default();
    let mut taken = vec![false; marks.len()];
    for node in (1..=finger.key_node_count()).map(NodeId).filter(|node| finger.has_marker(*node)) {
        let seen = homography * finger.marker_position(node).push(1.0);
        let at = seen.xy() / seen.z;
        let side = if node >= finger.tip() { Plate::Front } else { Plate::Back };
        let of_side = (0..marks.len()).filter(|&i| marks[i].sides[side as usize]);
        let nearest = of_side.map(|i| ((marks[i].at - at).norm(), i)).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, i)) = nearest.filter(|(distance, _)| *distance < ON_NODE * radius) {
            if std::mem::replace(&mut taken[i], true) {
                return Named::default();
            }
            named.nodes.push((node, marks[i].pixel));
            named.distance += distance;
        }
    }
    named
}
