//! Tables of observed markers: written by `locate`, read by `sense` and `calibrate`.

use super::table::{Row, Table, header};
use super::{FileError, image_named};
use finray_model::finger::MarkerPoints;
use finray_model::measurement::BaseUncertainty;
use finray_model::observation::{MarkerError, Observation, ObservationError, ObservedBase, ObservedMarker};
use finray_model::{Finger, Vector};
use nalgebra::Isometry2;
use serde::Serialize;
use std::path::{Path, PathBuf};

const POSE_COLUMNS: [&str; 3] = ["base_x_mm", "base_y_mm", "base_deg"];
const BASE_COLUMNS: [&str; 2] = ["base_sigma_mm", "base_sigma_deg"];
const OWN_SIGMA: &str = "marker_sigma_mm";
const SIGMA: &str = "sigma_mm";
const REFUSED: &str = "refused";
/// Largest number of images that a message lists.
const SHOWN: usize = 5;

/// Columns from which a table's marker coordinates are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// Displacements `ux_mm,uy_mm`, or `hinge_ux_mm,hinge_uy_mm` if the scene has its markers on hinges and the table has these columns.
    Displacements,
    /// Located positions of the markers, `x_mm,y_mm`.
    Positions,
}

/// An image in which no finger was located.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RefusedImage {
    /// Name of the image.
    pub image: String,
    /// Reason why no finger was located.
    pub reason: String,
}

/// A table of observed markers. Each field holds some columns of the file; all fields have the same rows in the same order.
pub struct ObservationTable {
    path: PathBuf,
    coordinates: Coordinates,
    rows: Table<3>,
    images: Option<Table<1>>,
    sigmas: Option<Table<1>>,
    own_sigmas: Option<Table<1>>,
    poses: Option<Table<3>>,
    base_sigmas: Option<Table<2>>,
    /// Deformed positions, mm; `None` if the table has only displacements. Position minus displacement gives the undeformed position.
    positions: Option<Table<2>>,
    refused: Option<Table<1>>,
}

impl ObservationTable {
    /// Reads the columns `node` and two coordinates. The columns `image,sigma_mm,marker_sigma_mm,base_x_mm,base_y_mm,base_deg,base_sigma_mm,
    /// base_sigma_deg,refused` are optional; further columns are ignored.
    ///
    /// # Errors
    /// [`FileError`] if the text is not a CSV table, has no rows, or lacks a required column.
    pub fn new(path: &Path, text: &str, finger: &Finger, coordinates: Coordinates) -> Result<Self, FileError> {
        let columns = header(text);
        let has = |wanted: &[&str]| wanted.iter().all(|name| columns.iter().any(|column| column == name));
        let on_hinges = finger.description().markers_on == MarkerPoints::Hinges && has(&["hinge_ux_mm"]);
        let [x, y] = match coordinates {
            Coordinates::Positions => ["x_mm", "y_mm"],
            Coordinates::Displacements if on_hinges => ["hinge_ux_mm", "hinge_uy_mm"],
            Coordinates::Displacements => ["ux_mm", "uy_mm"],
        };
        let single = |name: &'static str| has(&[name]).then(|| Table::of_text(path, text, [name])).transpose();
        let sigmas = single(SIGMA)?;
        let is_apart = sigmas.is_some() && has(&BASE_COLUMNS) && has(&[OWN_SIGMA]);
        Ok(ObservationTable {
            path: path.to_owned(),
            coordinates,
            images: single("image")?,
            // Only `locate` writes deformed positions, and its tables have the column `image`.
            positions: has(&["image", "x_mm", "y_mm"])
                .then(|| Table::of_text(path, text, ["x_mm", "y_mm"]))
                .transpose()?,
            refused: single(REFUSED)?,
            own_sigmas: if is_apart { single(OWN_SIGMA)? } else { None },
            base_sigmas: is_apart.then(|| Table::of_text(path, text, BASE_COLUMNS)).transpose()?,
            poses: has(&POSE_COLUMNS).then(|| Table::of_text(path, text, POSE_COLUMNS)).transpose()?,
            rows: Table::of_text(path, text, ["node", x, y])?,
            sigmas,
        })
    }

    /// Names of the images, in the order of their first rows.
    ///
    /// # Errors
    /// [`FileError`] if the table has no column `image`.
    pub fn images(&self) -> Result<Vec<&str>, FileError> {
        let Some(table) = &self.images else {
            return Err(self.wrong("expected a column image, as locate writes it"));
        };
        let mut images: Vec<&str> = Vec::new();
        for row in table.rows() {
            if !images.contains(&row.cells[0].as_str()) {
                images.push(&row.cells[0]);
            }
        }
        Ok(images)
    }

    /// Reason why `locate` refused an image; `None` if it did not refuse the image.
    pub fn refused(&self, image: &str) -> Option<&str> {
        let (images, refused) = self.images.as_ref().zip(self.refused.as_ref())?;
        let reasons = images.rows().iter().zip(refused.rows()).filter(|(name, _)| name.cells[0] == image);
        reasons.map(|(_, refused)| refused.cells[0].as_str()).find(|reason| !reason.is_empty())
    }

    /// The observation of the named image. Without a name, the table must have a single image or no column `image`.
    ///
    /// # Errors
    /// [`FileError`] with the line of an invalid cell, or for an image that is missing, ambiguous or refused.
    pub fn observation(&self, image: Option<&str>) -> Result<Observation, FileError> {
        let image = self.image_meant(image)?;
        if let Some(reason) = image.and_then(|image| self.refused(image)) {
            return Err(self.wrong(format!("{} was refused when it was located: {reason}", image.unwrap_or_default())));
        }
        let chosen = self.rows_of(image);
        let markers = chosen.iter().map(|&i| self.marker(i)).collect::<Result<_, _>>()?;
        let base = chosen.first().map(|&i| self.base(i)).transpose()?.flatten();
        Ok(Observation { image: image.unwrap_or_default().to_owned(), markers, base })
    }

    /// Converts the model's error about an image's observation to an error that names file, line and column.
    pub fn error(&self, image: Option<&str>, error: &ObservationError) -> FileError {
        let Ok(chosen) = self.image_meant(image).map(|image| self.rows_of(image)) else { return self.wrong(error) };
        let row = |i: usize| chosen.get(i).map(|&row| &self.rows.rows()[row]);
        let at = |row: Option<&Row<3>>, message: String| match row {
            Some(row) => self.rows.wrong(row, message),
            None => self.wrong(message),
        };
        match error {
            ObservationError::Marker { index, reason: reason @ MarkerError::Deviation { is_own, .. } } => {
                let column = if *is_own { OWN_SIGMA } else { SIGMA };
                at(row(*index), format!("{column}: {reason}"))
            }
            ObservationError::Marker { index, reason } => at(row(*index), reason.to_string()),
            ObservationError::Base => at(row(0), format!("{}: expected zero or more", BASE_COLUMNS.join(", "))),
            ObservationError::NoNoise => {
                self.wrong("expected a column sigma_mm, as locate writes it, or noise_mm in the scene's table camera")
            }
        }
    }

    fn wrong(&self, message: impl ToString) -> FileError {
        FileError::content(&self.path, message)
    }

    /// Full name of the image to which `image` refers; `None` if the table has no column `image`.
    fn image_meant(&self, image: Option<&str>) -> Result<Option<&str>, FileError> {
        if self.images.is_none() {
            return match image {
                None => Ok(None),
                Some(_) => Err(self.wrong("--image-name: expected a column image, as locate writes it")),
            };
        }
        let images = self.images()?;
        let meant = match image {
            Some(name) => image_named(name, &images),
            None if images.len() == 1 => Ok(images[0]),
            None => Err(format!("there are {} images", images.len())),
        };
        meant.map(Some).map_err(|reason| {
            let more = if images.len() > SHOWN { ", ..." } else { "" };
            let listed = images[..images.len().min(SHOWN)].join(", ");
            self.wrong(format!("{reason}; expected --image-name with one of the file's images: {listed}{more}"))
        })
    }

    /// Indices of the rows of an image with a visible marker; a row without coordinates belongs to a hidden marker.
    fn rows_of(&self, image: Option<&str>) -> Vec<usize> {
        let of_image =
            |i: &usize| self.images.as_ref().is_none_or(|names| Some(names.rows()[*i].cells[0].as_str()) == image);
        let is_seen = |i: &usize| !matches!(self.rows.vector(&self.rows.rows()[*i], [1, 2]), Ok(None));
        (0..self.rows.rows().len()).filter(of_image).filter(is_seen).collect()
    }

    fn marker(&self, i: usize) -> Result<ObservedMarker, FileError> {
        let row = &self.rows.rows()[i];
        let node = self.rows.node(row, 0)?;
        let at = self.rows.vector(row, [1, 2])?;
        // An empty cell means an unknown standard deviation.
        let number = |table: &Option<Table<1>>| {
            let table = table.as_ref().filter(|table| !table.rows()[i].cells[0].is_empty());
            table.map(|table| table.number(&table.rows()[i], 0)).transpose()
        };
        let is_position = self.coordinates == Coordinates::Positions;
        let beside = self.positions.as_ref().filter(|_| !is_position);
        let beside = beside.map(|table| table.vector(&table.rows()[i], [0, 1])).transpose()?.flatten();
        Ok(ObservedMarker {
            node,
            pixel: None,
            position: at.filter(|_| is_position).or(beside),
            displacement: at.filter(|_| !is_position),
            sd_mm: number(&self.sigmas)?,
            own_sd_mm: number(&self.own_sigmas)?,
        })
    }

    /// Pose of the base and its uncertainty from row `i`; all rows of an image repeat them.
    fn base(&self, i: usize) -> Result<Option<ObservedBase>, FileError> {
        let Some(poses) = &self.poses else { return Ok(None) };
        let number = |column| poses.number(&poses.rows()[i], column);
        let pose = Isometry2::new(Vector::new(number(0)?, number(1)?), number(2)?.to_radians());
        let uncertainty = match &self.base_sigmas {
            None => None,
            Some(table) => {
                let number = |column| table.number(&table.rows()[i], column);
                let (sd_mm, sd_rad) = (number(0)?, number(1)?.to_radians());
                Some(BaseUncertainty { sd_mm, sd_rad, ..BaseUncertainty::default() })
            }
        };
        Ok(Some(ObservedBase { pose, uncertainty, is_known: true }))
    }
}

#[derive(Serialize, Default)]
struct MarkerRow<'o> {
    image: &'o str,
    node: Option<usize>,
    u_px: Option<f64>,
    v_px: Option<f64>,
    x_mm: Option<f64>,
    y_mm: Option<f64>,
    ux_mm: Option<f64>,
    uy_mm: Option<f64>,
    sigma_mm: Option<f64>,
}

/// Pose of the base and its uncertainty, repeated on each row of its image.
#[derive(Serialize, Default)]
struct BaseRow {
    base_x_mm: Option<f64>,
    base_y_mm: Option<f64>,
    base_deg: Option<f64>,
    base_sigma_mm: Option<f64>,
    base_sigma_deg: Option<f64>,
    marker_sigma_mm: Option<f64>,
}

/// Last column, `refused`, of a table in which at least one image was refused.
#[derive(Serialize)]
struct RefusedRow<'o> {
    refused: &'o str,
}

/// Observations as CSV: `image,node,u_px,v_px,x_mm,y_mm,ux_mm,uy_mm,sigma_mm`, one row per marker. If all images show the base, also
/// `base_x_mm,base_y_mm,base_deg,base_sigma_mm,base_sigma_deg,marker_sigma_mm`. If images were refused, also `refused`; a refused image has one row.
///
/// # Errors
/// A `csv::Error` from the CSV writer; none is expected, because the text is written to memory.
pub fn to_csv(seen: &[Result<Observation, RefusedImage>]) -> Result<String, csv::Error> {
    let shows_base = seen.iter().flatten().all(|seen| seen.base.is_some());
    let rows = seen.iter().flat_map(rows_of_image);
    match (shows_base, seen.iter().any(Result::is_err)) {
        (false, false) => super::csv_text(rows.map(|(marker, ..)| marker)),
        (true, false) => super::csv_text(rows.map(|(marker, base, _)| (marker, base))),
        (false, true) => super::csv_text(rows.map(|(marker, _, refused)| (marker, refused))),
        (true, true) => super::csv_text(rows),
    }
}

fn rows_of_image(seen: &Result<Observation, RefusedImage>) -> Vec<(MarkerRow<'_>, BaseRow, RefusedRow<'_>)> {
    match seen {
        Ok(seen) => {
            let base = |marker| seen.base.map(|base| base_row(&base, marker)).unwrap_or_default();
            let row = |marker| (marker_row(&seen.image, marker), base(marker), RefusedRow { refused: "" });
            seen.markers.iter().map(row).collect()
        }
        Err(RefusedImage { image, reason }) => {
            vec![(MarkerRow { image, ..MarkerRow::default() }, BaseRow::default(), RefusedRow { refused: reason })]
        }
    }
}

fn marker_row<'o>(image: &'o str, marker: &ObservedMarker) -> MarkerRow<'o> {
    let coordinate = |vector: Option<Vector>, i: usize| vector.map(|vector| vector[i]);
    MarkerRow {
        image,
        node: Some(marker.node.0),
        u_px: coordinate(marker.pixel, 0),
        v_px: coordinate(marker.pixel, 1),
        x_mm: coordinate(marker.position, 0),
        y_mm: coordinate(marker.position, 1),
        ux_mm: coordinate(marker.displacement, 0),
        uy_mm: coordinate(marker.displacement, 1),
        sigma_mm: marker.sd_mm,
    }
}

fn base_row(base: &ObservedBase, marker: &ObservedMarker) -> BaseRow {
    BaseRow {
        base_x_mm: Some(base.pose.translation.x),
        base_y_mm: Some(base.pose.translation.y),
        base_deg: Some(base.pose.rotation.angle().to_degrees()),
        base_sigma_mm: base.uncertainty.map(|uncertainty| uncertainty.sd_mm),
        base_sigma_deg: base.uncertainty.map(|uncertainty| uncertainty.sd_rad.to_degrees()),
        marker_sigma_mm: marker.own_sd_mm,
    }
}
