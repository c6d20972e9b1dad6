//! Displacements of the key nodes: what `solve` writes and `sense` reads.

use super::FileError;
use super::clamped::Clamped;
use super::table::Table;
use finray_model::finger::MarkerPoints;
use finray_model::measurement::{BaseUncertainty, Marker, MarkerErrors, Measurement};
use finray_model::mesh::{FingerShape, NodeMotion};
use finray_model::{Finger, NodeId, Vector};
use nalgebra::{Isometry2, Point2};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Row {
    node: usize,
    x_mm: f64,
    y_mm: f64,
    ux_mm: f64,
    uy_mm: f64,
    theta_rad: f64,
}

/// The joint of a node's rib, where brackets hold ribs off the plates.
#[derive(Serialize)]
struct Hinge {
    hinge_x_mm: f64,
    hinge_y_mm: f64,
    hinge_ux_mm: f64,
    hinge_uy_mm: f64,
}

/// CSV of a shape: `node,x_mm,y_mm,ux_mm,uy_mm,theta_rad`, a row a key node, undeformed position and displacement; with brackets
/// also `hinge_x_mm,hinge_y_mm,hinge_ux_mm,hinge_uy_mm`, those of the joint at their end.
///
/// # Errors
/// None in memory; the signature is the CSV writer's.
pub fn to_csv(shape: &FingerShape, finger: &Finger) -> Result<String, csv::Error> {
    let row = |motion: &NodeMotion| Row {
        node: motion.node.0,
        x_mm: motion.position.x,
        y_mm: motion.position.y,
        ux_mm: motion.displacement.x,
        uy_mm: motion.displacement.y,
        theta_rad: motion.rotation,
    };
    if !finger.has_brackets() {
        return super::csv_text(shape.motions().iter().map(row));
    }
    let hinge = |motion: &NodeMotion| Hinge {
        hinge_x_mm: motion.hinge_position.x,
        hinge_y_mm: motion.hinge_position.y,
        hinge_ux_mm: motion.hinge_displacement.x,
        hinge_uy_mm: motion.hinge_displacement.y,
    };
    super::csv_text(shape.motions().iter().map(|motion| (row(motion), hinge(motion))))
}

/// Reads the shape of a whole finger: `node,ux_mm,uy_mm,theta_rad`, found by name, a row a key node in any order.
///
/// # Errors
/// [`FileError`] naming the line for anything that is not a node of this finger, and for nodes that are missing.
pub fn load_shape(path: &Path, finger: &Finger) -> Result<FingerShape, FileError> {
    let table = Table::read(path, ["node", "ux_mm", "uy_mm", "theta_rad"])?;
    let mut motions: Vec<Option<(Vector, f64)>> = vec![None; finger.key_node_count()];
    for row in table.rows() {
        let node = table.node(row, 0)?;
        let numbers = [table.number(row, 1)?, table.number(row, 2)?, table.number(row, 3)?];
        let Some(motion) = node.0.checked_sub(1).and_then(|i| motions.get_mut(i)) else {
            let count = finger.key_node_count();
            return Err(
                table.wrong(row, format!("node {node} does not exist: the finger has the key nodes 1 to {count}"))
            );
        };
        if motion.replace((Vector::new(numbers[0], numbers[1]), numbers[2])).is_some() {
            return Err(table.wrong(row, format!("node {node} is listed twice")));
        }
    }
    if let Some(missing) = motions.iter().position(Option::is_none) {
        let message = format!(
            "expected a row for every key node, as solve and press write them; node {} is missing",
            missing + 1
        );
        return Err(FileError::content(path, message));
    }
    Ok(FingerShape::new(finger, |node| motions[node.0 - 1].unwrap_or_default()))
}

/// Displacements as a file has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Displacements {
    /// The displacements; weights follow from the file's standard deviations, where it has them.
    pub measurement: Measurement,
    /// Standard deviation of a coordinate of weight 1, mm, where the file has a column `sigma_mm`.
    pub noise_mm: Option<f64>,
    /// Where the base is in the frame of the camera's pose; there, where the file does not say.
    pub frame: Isometry2<f64>,
}

/// How displacements are read, and what is known of their errors beside what their file says.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reading {
    /// From the positions that were located, `x_mm,y_mm`, and where this scene has its undeformed markers, whatever scene they were located with.
    pub from_positions: bool,
    /// Errors of markers beside those that the file states.
    pub errors: MarkerErrors,
    /// How well the base is where the file has it, if not exactly.
    pub base: Option<BaseUncertainty>,
    /// Whether the base is sought: its error, which all markers share, is then not part of theirs.
    pub base_is_sought: bool,
    /// Whether the base is about where the camera's pose has it, no marks showing where: displacements count from there, whatever base `locate` took
    /// the markers to be on.
    pub base_is_of_pose: bool,
    /// Standard deviation of one coordinate, mm, where it is stated elsewhere than in the file.
    pub noise_mm: Option<f64>,
}

const POSE_COLUMNS: [&str; 3] = ["base_x_mm", "base_y_mm", "base_deg"];
const BASE_COLUMNS: [&str; 3] = ["base_sigma_mm", "base_sigma_deg", "marker_sigma_mm"];

impl Displacements {
    /// The displacements with one standard deviation for all, stated elsewhere.
    pub fn of_equal_weight(self) -> Measurement {
        self.measurement.of_equal_weight()
    }
}

/// Reads `node,ux_mm,uy_mm`, found by name, in any order; nodes may be missing. Where the scene has its markers on hinges, a file of
/// `solve` gives `hinge_ux_mm,hinge_uy_mm` instead. Rows of clamped nodes carry noise and are ignored, if noise explains them: that of a
/// column `sigma_mm`, as `locate` writes it, or that of the reading. Of a file of several images (a column `image`) the rows of `image_name` are read. Where
/// the base is sought, `marker_sigma_mm,base_sigma_mm,base_sigma_deg` stand for `sigma_mm`, which holds them all.
///
/// # Errors
/// [`FileError`] naming the line for anything that is not a marker of this finger.
pub fn load(
    path: &Path,
    finger: &Finger,
    image_name: Option<&str>,
    reading: Reading,
) -> Result<Displacements, FileError> {
    of_text(path, &super::read_text(path)?, finger, image_name, reading)
}

/// As [`load`], from the text of the file.
///
/// # Errors
/// [`FileError`] naming the line for anything that is not a marker of this finger.
pub fn of_text(
    path: &Path,
    text: &str,
    finger: &Finger,
    image_name: Option<&str>,
    reading: Reading,
) -> Result<Displacements, FileError> {
    let columns = super::table::header(text);
    let has = |name: &str| columns.iter().any(|column| column == name);
    let images = match has("image") {
        true => Some(rows_of_image(path, text, image_name)?),
        false if image_name.is_some() => {
            return Err(FileError::content(path, "--image-name: expected a column image, as locate writes it"));
        }
        false => None,
    };
    let is_chosen = |number: usize| images.as_ref().is_none_or(|chosen| chosen[number]);
    let frame = match POSE_COLUMNS.iter().all(|column| has(column)) {
        true => frame_of_image(path, text, is_chosen)?,
        false => Isometry2::identity(),
    };
    let mut measurement = Measurement::empty();
    let of_file = frame;
    let frame = if reading.base_is_of_pose { Isometry2::identity() } else { of_file };
    let on_hinges = finger.description().markers_on == MarkerPoints::Hinges && has("hinge_ux_mm");
    let [ux_mm, uy_mm] = match on_hinges {
        _ if reading.from_positions => ["x_mm", "y_mm"],
        true => ["hinge_ux_mm", "hinge_uy_mm"],
        false => ["ux_mm", "uy_mm"],
    };
    // Of a node that does not exist the measurement tells.
    let exists = |node: NodeId| (1..=finger.key_node_count()).contains(&node.0);
    let from = |node: NodeId| match reading.from_positions && exists(node) {
        true => finger.marker_position(node),
        false => Vector::zeros(),
    };
    let placed = |node: NodeId, displacement: Vector| match reading.base_is_of_pose && exists(node) {
        true => {
            let rest = finger.marker_position(node);
            (of_file * Point2::from(rest + displacement)).coords - rest
        }
        false => displacement,
    };
    if !has("sigma_mm") {
        let table = Table::of_text(path, text, ["node", ux_mm, uy_mm])?;
        let mut rows = Vec::new();
        for (_, row) in table.rows().iter().enumerate().filter(|(number, _)| is_chosen(*number)) {
            let node = table.node(row, 0)?;
            let displacement = placed(node, Vector::new(table.number(row, 1)?, table.number(row, 2)?) - from(node));
            rows.push((row, node, displacement));
        }
        let clamped = Clamped::new(finger, reading.noise_mm, rows.iter().map(|(.., displacement)| *displacement));
        for (row, node, displacement) in rows {
            if !clamped.holds(node, displacement, &table, row)? {
                let marker = Marker { node, displacement, weight: 1.0 };
                measurement.add(finger, marker).map_err(|error| table.wrong(row, error))?;
            }
        }
        let measurement = with_base(measurement, reading, None);
        return Ok(Displacements { measurement, noise_mm: None, frame });
    }
    let base_apart = reading.base_is_sought && BASE_COLUMNS.iter().all(|column| has(column));
    let base = match base_apart && !reading.base_is_of_pose {
        true => base_of_image(path, text, is_chosen)?,
        false => None,
    };
    let sigma = if base_apart { "marker_sigma_mm" } else { "sigma_mm" };
    let table = Table::of_text(path, text, ["node", ux_mm, uy_mm, sigma])?;
    let mut rows = Vec::new();
    for (_, row) in table.rows().iter().enumerate().filter(|(number, _)| is_chosen(*number)) {
        let (node, sigma_mm) = (table.node(row, 0)?, table.number(row, 3)?);
        if !(sigma_mm > 0.0 && sigma_mm.is_normal()) {
            return Err(table.wrong(row, format!("{sigma}: expected a length in mm above zero, found {sigma_mm}")));
        }
        let sigma_mm = reading.errors.sd_mm(sigma_mm);
        let displacement = placed(node, Vector::new(table.number(row, 1)?, table.number(row, 2)?) - from(node));
        if !Clamped::new(finger, Some(sigma_mm), []).holds(node, displacement, &table, row)? {
            rows.push((row, node, displacement, sigma_mm));
        }
    }
    let squares: f64 = rows.iter().map(|(_, _, _, sigma_mm)| sigma_mm * sigma_mm).sum();
    let noise_mm = (squares / rows.len().max(1) as f64).sqrt();
    for (row, node, displacement, sigma_mm) in rows {
        let marker = Marker { node, displacement, weight: noise_mm / sigma_mm };
        measurement.add(finger, marker).map_err(|error| table.wrong(row, error))?;
    }
    Ok(Displacements { measurement: with_base(measurement, reading, base), noise_mm: Some(noise_mm), frame })
}

/// A measurement from a base that is known as a file and a scene have it, if it is to be sought.
fn with_base(measurement: Measurement, reading: Reading, of_file: Option<BaseUncertainty>) -> Measurement {
    let base = match (of_file, reading.base) {
        // Marks show by how much the base gave way.
        (Some(one), Some(other)) => Some(BaseUncertainty {
            sd_mm: one.sd_mm.hypot(other.sd_mm),
            sd_rad: one.sd_rad.hypot(other.sd_rad),
            ..BaseUncertainty::default()
        }),
        (one, other) => one.or(other),
    };
    match base.filter(|_| reading.base_is_sought) {
        Some(base) => measurement.with_uncertain_base(base),
        None => measurement,
    }
}

/// How well an image's base is known: what the first of its rows says, as all do; `None` where it is known exactly.
fn base_of_image(
    path: &Path,
    text: &str,
    is_chosen: impl Fn(usize) -> bool,
) -> Result<Option<BaseUncertainty>, FileError> {
    let table = Table::of_text(path, text, ["base_sigma_mm", "base_sigma_deg"])?;
    let mut rows = table.rows().iter().enumerate().filter(|(number, _)| is_chosen(*number));
    let Some((_, row)) = rows.next() else { return Ok(None) };
    let [sd_mm, sd_deg] = [table.number(row, 0)?, table.number(row, 1)?];
    if sd_mm < 0.0 || sd_deg < 0.0 {
        return Err(table.wrong(row, "base_sigma_mm, base_sigma_deg: expected zero or more".to_owned()));
    }
    let base = BaseUncertainty { sd_mm, sd_rad: sd_deg.to_radians(), ..BaseUncertainty::default() };
    Ok(Some(base).filter(|base| base.sd_mm > 0.0 || base.sd_rad > 0.0))
}

/// Where an image's base is in the frame of the camera's pose: what the first of its rows says, as all do.
fn frame_of_image(path: &Path, text: &str, is_chosen: impl Fn(usize) -> bool) -> Result<Isometry2<f64>, FileError> {
    let table = Table::of_text(path, text, POSE_COLUMNS)?;
    let mut rows = table.rows().iter().enumerate().filter(|(number, _)| is_chosen(*number));
    let Some((_, row)) = rows.next() else { return Ok(Isometry2::identity()) };
    let at = Vector::new(table.number(row, 0)?, table.number(row, 1)?);
    Ok(Isometry2::new(at, table.number(row, 2)?.to_radians()))
}

/// The images of a file, in the order of their first rows.
///
/// # Errors
/// [`FileError`] where it has no column `image`.
pub fn images(path: &Path, text: &str) -> Result<Vec<String>, FileError> {
    let table = Table::of_text(path, text, ["image"])?;
    let mut images: Vec<String> = Vec::new();
    for row in table.rows() {
        if !images.contains(&row.cells[0]) {
            images.push(row.cells[0].clone());
        }
    }
    Ok(images)
}

/// Which rows belong to an image; without a name the file must have one image alone.
fn rows_of_image(path: &Path, text: &str, image_name: Option<&str>) -> Result<Vec<bool>, FileError> {
    let table = Table::of_text(path, text, ["image"])?;
    let names: Vec<&str> = table.rows().iter().map(|row| row.cells[0].as_str()).collect();
    let images = images(path, text)?;
    let chosen = match image_name {
        Some(name) if names.contains(&name) => name,
        None if images.len() == 1 => names[0],
        _ => {
            const SHOWN: usize = 5;
            let more = if images.len() > SHOWN { ", ..." } else { "" };
            let listed = images[..images.len().min(SHOWN)].join(", ");
            let message = format!("expected --image-name with one of the file's images: {listed}{more}");
            return Err(FileError::content(path, message));
        }
    };
    Ok(names.iter().map(|name| *name == chosen).collect())
}
