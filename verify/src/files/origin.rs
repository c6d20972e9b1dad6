//! Whether images were located with the scene that reads them.

use super::FileError;
use super::table::{Table, header};
use finray_model::camera::{Camera, Pixel};
use finray_model::{Scene, Vector};
use nalgebra::{Isometry2, Point2};
use std::path::Path;

const AT_REST: [&str; 5] = ["node", "x_mm", "y_mm", "ux_mm", "uy_mm"];
const SEEN: [&str; 7] = ["u_px", "v_px", "x_mm", "y_mm", "base_x_mm", "base_y_mm", "base_deg"];

/// By how much a file of `locate` differs, at worst, from what a scene would have made of the same markers, mm: in where they are without load,
/// and in where its camera sees their pixels in the frame of the base. Zero but for rounding where it was located with this scene, or has not the
/// columns to say.
///
/// # Errors
/// [`FileError`] for cells that are no numbers.
pub(super) fn misplaced_mm(path: &Path, text: &str, scene: &Scene) -> Result<f64, FileError> {
    let columns = header(text);
    let has = |wanted: &[&str]| wanted.iter().all(|name| columns.iter().any(|column| column == name));
    let mut worst_mm = 0.0_f64;
    if has(&AT_REST) {
        let table = Table::of_text(path, text, AT_REST)?;
        for row in table.rows() {
            let node = table.node(row, 0)?;
            if (1..=scene.finger.key_node_count()).contains(&node.0) {
                let [x, y, ux, uy] =
                    [table.number(row, 1)?, table.number(row, 2)?, table.number(row, 3)?, table.number(row, 4)?];
                let rest = Vector::new(x - ux, y - uy);
                worst_mm = worst_mm.max((rest - scene.finger.marker_position(node)).norm());
            }
        }
    }
    let camera = scene.camera.and_then(|camera| Some(Camera { lens: camera.lens, pose: camera.pose? }));
    if let (true, Some(camera), Some(markers)) = (has(&SEEN), camera, scene.markers) {
        let table = Table::of_text(path, text, SEEN)?;
        for row in table.rows() {
            let number = |column| table.number(row, column);
            let (pixel, stated) = (Pixel::new(number(0)?, number(1)?), Vector::new(number(2)?, number(3)?));
            let base = Isometry2::new(Vector::new(number(4)?, number(5)?), number(6)?.to_radians());
            // A pixel that this camera sees nowhere on the plane was another's.
            let at = camera.on_plane(&pixel, markers.height_mm);
            let off_mm = at.map_or(f64::INFINITY, |at| ((base.inverse() * Point2::from(at)).coords - stated).norm());
            worst_mm = worst_mm.max(off_mm);
        }
    }
    Ok(worst_mm)
}
