//! Checks whether a file of displacements was made with the scene that reads it.

use super::FileError;
use super::table::Table;
use csv::StringRecord;
use finray_model::camera::Camera;
use finray_model::finger::Plate;
use finray_model::{Finger, NodeId, Scene, Vector};
use nalgebra::{Isometry2, Point2};
use std::path::Path;

const AT_REST: [&str; 5] = ["node", "x_mm", "y_mm", "ux_mm", "uy_mm"];
/// A file belongs to another finger if its undeformed nodes differ from the scene's by more than this share of the front plate's length. A real finger
/// differs slightly from its scene.
const UNLIKE_SHARE: f64 = 0.05;
const SEEN: [&str; 7] = ["u_px", "v_px", "x_mm", "y_mm", "base_x_mm", "base_y_mm", "base_deg"];

/// A key node whose undeformed position in a file differs from the finger's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elsewhere {
    /// The key node.
    pub node: NodeId,
    /// Undeformed position in the file, mm.
    pub stated: Vector,
    /// Undeformed position of the key node in the scene, mm.
    pub own: Vector,
}

/// The key node whose undeformed position differs most from the scene's, if the difference shows that the file belongs to another finger. `None` if
/// all nodes agree, or if the file has no positions. A file may have undeformed positions (`solve`) or deformed ones (`locate`), of nodes or of
/// markers; all four combinations are tried.
pub fn of_another_finger(path: &Path, text: &str, finger: &Finger) -> Option<Elsewhere> {
    let table = Table::of_text(path, text).ok().filter(|table| table.has(&AT_REST))?;
    let off_mm = |found: &Elsewhere| (found.stated - found.own).norm();
    let elsewhere = |row: &StringRecord| {
        let vector = |columns| table.vector(row, columns).ok().flatten();
        let (node, written) = (table.node(row, "node").ok()?, vector(["x_mm", "y_mm"])?);
        if !(1..=finger.key_node_count()).contains(&node.0) {
            return None;
        }
        let displacement = vector(["ux_mm", "uy_mm"])?;
        [finger.position(node), finger.marker_position(node)]
            .into_iter()
            .flat_map(|own| [written, written - displacement].map(|stated| Elsewhere { node, stated, own }))
            .min_by(|a, b| off_mm(a).total_cmp(&off_mm(b)))
    };
    let farthest = table.rows.iter().filter_map(elsewhere).max_by(|a, b| off_mm(a).total_cmp(&off_mm(b)))?;
    (off_mm(&farthest) > UNLIKE_SHARE * finger.plate_length_mm(Plate::Front)).then_some(farthest)
}

/// Largest difference, mm, between a file of `locate` and the positions that the given scene yields for the same markers. Two kinds of positions are
/// compared: the undeformed positions, and the positions that the camera assigns to the pixels, in the plane of the markers and the frame of the
/// base. The result is 0 within rounding if the file was located with this scene, or if the file lacks the columns.
///
/// # Errors
/// [`FileError`] with the line of a cell that is not a number.
pub(super) fn misplaced_mm(path: &Path, text: &str, scene: &Scene) -> Result<f64, FileError> {
    let table = Table::of_text(path, text)?;
    let vector = |row: &StringRecord, columns| table.vector(row, columns);
    let mut worst_mm = 0.0_f64;
    if table.has(&AT_REST) {
        for row in &table.rows {
            let (at, moved) = (vector(row, ["x_mm", "y_mm"])?, vector(row, ["ux_mm", "uy_mm"])?);
            let (Some(at), Some(moved)) = (at, moved) else { continue };
            let node = table.node(row, "node")?;
            if (1..=scene.finger.key_node_count()).contains(&node.0) {
                worst_mm = worst_mm.max((at - moved - scene.finger.marker_position(node)).norm());
            }
        }
    }
    let camera = scene.camera.and_then(|camera| Some(Camera { lens: camera.lens, pose: camera.pose? }));
    if let (true, Some(camera), Some(markers)) = (table.has(&SEEN), camera, scene.markers) {
        for row in &table.rows {
            let (pixel, stated) = (vector(row, ["u_px", "v_px"])?, vector(row, ["x_mm", "y_mm"])?);
            let (Some(pixel), Some(stated)) = (pixel, stated) else { continue };
            let number = |column| table.number(row, column);
            let base = Vector::new(number("base_x_mm")?, number("base_y_mm")?);
            let base = Isometry2::new(base, number("base_deg")?.to_radians());
            // A pixel whose ray misses the plane of the markers was not located with this camera.
            let at = camera.on_plane(&pixel, markers.height_mm);
            let off_mm = at.map_or(f64::INFINITY, |at| ((base.inverse() * Point2::from(at)).coords - stated).norm());
            worst_mm = worst_mm.max(off_mm);
        }
    }
    Ok(worst_mm)
}
