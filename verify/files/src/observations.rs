//! Tables of observed markers: written by `locate`, read by `sense` and `calibrate`.

use super::table::Table;
use super::{FileError, image_named};
use csv::StringRecord;
use finray_model::finger::MarkerPoints;
use finray_model::measurement::BaseUncertainty;
use finray_model::observation::{
    EstimatedNoise, LocatedWith, MarkerError, Observation, ObservationError, ObservedBase, ObservedMarker,
};
use finray_model::{Finger, Vector};
use nalgebra::Isometry2;
use serde::Serialize;
use std::collections::HashMap;
use std::path::Path;

const POSITION: [&str; 2] = ["x_mm", "y_mm"];
const POSE_COLUMNS: [&str; 3] = ["base_x_mm", "base_y_mm", "base_deg"];
const BASE_COLUMNS: [&str; 2] = ["base_sigma_mm", "base_sigma_deg"];
const OWN_SIGMA: &str = "marker_sigma_mm";
const SIGMA: &str = "sigma_mm";
pub(crate) const PIXEL: [&str; 2] = ["u_px", "v_px"];
pub(crate) const NOISE: [&str; 2] = ["noise_degrees_of_freedom", "shared_sigma_mm"];
pub(crate) const LOCATED_WITH: &str = "located_with";
const REFUSED: &str = "refused";
/// Largest number of images that a message lists.
const SHOWN: usize = 5;

/// Columns from which a table's marker coordinates are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// Displacements `ux_mm,uy_mm`; or `hinge_ux_mm,hinge_uy_mm`, if the scene's markers are on the hinges and the table has these columns.
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

/// A table of observed markers.
pub struct ObservationTable {
    coordinates: Coordinates,
    /// Columns of the markers' coordinates.
    xy: [&'static str; 2],
    table: Table,
    /// Names of the images, in the order of their first rows.
    images: Vec<String>,
    /// Rows of each image.
    rows: HashMap<String, Vec<usize>>,
}

impl ObservationTable {
    /// Reads the columns `node` and two coordinates. The columns `image,sigma_mm,marker_sigma_mm,base_x_mm,base_y_mm,base_deg,base_sigma_mm,
    /// base_sigma_deg,noise_degrees_of_freedom,shared_sigma_mm,located_with,refused` are optional; further columns are ignored.
    ///
    /// # Errors
    /// [`FileError`] if the text is not a CSV table, has no rows, or lacks a required column.
    pub fn new(path: &Path, text: &str, finger: &Finger, coordinates: Coordinates) -> Result<Self, FileError> {
        let table = Table::of_text(path, text)?;
        let on_hinges = finger.description().markers_on == MarkerPoints::Hinges && table.has(&["hinge_ux_mm"]);
        let xy = match coordinates {
            Coordinates::Positions => POSITION,
            Coordinates::Displacements if on_hinges => ["hinge_ux_mm", "hinge_uy_mm"],
            Coordinates::Displacements => ["ux_mm", "uy_mm"],
        };
        let single = ["image", SIGMA, OWN_SIGMA, LOCATED_WITH, REFUSED];
        let optional = [&single[..], &POSITION, &PIXEL, &NOISE, &POSE_COLUMNS, &BASE_COLUMNS].concat();
        table.require(&["node", xy[0], xy[1]], &optional)?;
        let (mut images, mut rows) = (Vec::new(), HashMap::<String, Vec<usize>>::new());
        for (i, row) in table.rows.iter().enumerate().filter(|_| table.has(&["image"])) {
            let image = table.cell(row, "image");
            let of_image = rows.entry(image.to_owned()).or_default();
            if of_image.is_empty() {
                images.push(image.to_owned());
            }
            of_image.push(i);
        }
        Ok(ObservationTable { coordinates, xy, table, images, rows })
    }

    /// Names of the images, in the order of their first rows.
    ///
    /// # Errors
    /// [`FileError`] if the table has no column `image`.
    pub fn images(&self) -> Result<Vec<&str>, FileError> {
        if !self.table.has(&["image"]) {
            return Err(self.wrong("expected a column `image`, as `finray locate` writes it"));
        }
        Ok(self.images.iter().map(String::as_str).collect())
    }

    /// Reason why `locate` refused an image; `None` for an image that was not refused.
    pub fn refused(&self, image: &str) -> Option<&str> {
        let mut of_image = self.rows.get(image)?.iter().map(|&i| self.table.cell(&self.table.rows[i], REFUSED));
        of_image.find(|reason| !reason.is_empty())
    }

    /// The observation of the named image. If no image is named, the table must have a single image or no column `image`.
    ///
    /// # Errors
    /// [`FileError`] with the line of an invalid cell, or for an image that is missing, ambiguous or refused.
    pub fn observation(&self, image: Option<&str>) -> Result<Observation, FileError> {
        let image = self.image_meant(image)?;
        if let Some(reason) = image.and_then(|image| self.refused(image)) {
            return Err(
                self.wrong(format!("image {} was refused when it was located: {reason}", image.unwrap_or_default()))
            );
        }
        let chosen = self.rows_of(image);
        let markers = chosen.iter().map(|row| self.marker(row)).collect::<Result<_, _>>()?;
        let of_image = |row: &&StringRecord| Ok((self.base(row)?, self.noise(row)?, self.located_with(row)?));
        let (base, noise, located_with) = chosen.first().map(of_image).transpose()?.unwrap_or_default();
        Ok(Observation { image: image.unwrap_or_default().to_owned(), markers, base, noise, located_with })
    }

    /// Converts the model's error about an image's observation to an error that names file, line and column.
    pub fn error(&self, image: Option<&str>, error: &ObservationError) -> FileError {
        let Ok(chosen) = self.image_meant(image).map(|image| self.rows_of(image)) else { return self.wrong(error) };
        let at = |i: usize, message: String| match chosen.get(i) {
            Some(row) => self.table.wrong(row, message),
            None => self.wrong(message),
        };
        match error {
            ObservationError::Marker { index, reason: reason @ MarkerError::Deviation { is_own, .. } } => {
                let column = if *is_own { OWN_SIGMA } else { SIGMA };
                at(*index, format!("{column}: {reason}"))
            }
            ObservationError::Marker { index, reason } => at(*index, reason.to_string()),
            ObservationError::Base => at(0, format!("{}: expected zero or more", BASE_COLUMNS.join(", "))),
            ObservationError::Stale(error) => self.wrong(error),
            ObservationError::NoNoise => self.wrong(
                "expected a column sigma_mm, as `finray locate` writes it, or noise_mm in [camera] of the scene",
            ),
        }
    }

    fn wrong(&self, message: impl ToString) -> FileError {
        FileError::content(&self.table.path, message)
    }

    /// Full name of the image to which `image` refers; `None` if the table has no column `image`.
    fn image_meant(&self, image: Option<&str>) -> Result<Option<&str>, FileError> {
        if !self.table.has(&["image"]) {
            return match image {
                None => Ok(None),
                Some(_) => Err(self.wrong("--image-name: expected a column `image`, as `finray locate` writes it")),
            };
        }
        if let Some((name, _)) = image.and_then(|image| self.rows.get_key_value(image)) {
            return Ok(Some(name));
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

    /// The rows of the visible markers in an image; a row without coordinates belongs to a hidden marker.
    fn rows_of(&self, image: Option<&str>) -> Vec<&StringRecord> {
        let is_seen = |row: &&StringRecord| !matches!(self.table.vector(row, self.xy), Ok(None));
        match image.and_then(|image| self.rows.get(image)) {
            Some(of_image) => of_image.iter().map(|&i| &self.table.rows[i]).filter(is_seen).collect(),
            None => self.table.rows.iter().filter(is_seen).collect(),
        }
    }

    fn marker(&self, row: &StringRecord) -> Result<ObservedMarker, FileError> {
        let at = self.table.vector(row, self.xy)?;
        // A cell without a value means an unknown standard deviation.
        let number = |column: &str| {
            let is_given = !self.table.is_missing(row, column);
            is_given.then(|| self.table.number(row, column)).transpose()
        };
        let is_position = self.coordinates == Coordinates::Positions;
        // Only `locate` writes deformed positions, and its tables have the column `image`.
        let has_positions = !is_position && self.table.has(&["image", POSITION[0], POSITION[1]]);
        let beside = if has_positions { self.table.vector(row, POSITION)? } else { None };
        Ok(ObservedMarker {
            node: self.table.node(row, "node")?,
            pixel: if self.table.has(&PIXEL) { self.table.vector(row, PIXEL)? } else { None },
            position: at.filter(|_| is_position).or(beside),
            displacement: at.filter(|_| !is_position),
            sd_mm: number(SIGMA)?,
            own_sd_mm: if self.is_base_apart() { number(OWN_SIGMA)? } else { None },
        })
    }

    /// Whether the table states separate standard deviations for the base and for the markers.
    fn is_base_apart(&self) -> bool {
        self.table.has(&[SIGMA, OWN_SIGMA]) && self.table.has(&BASE_COLUMNS)
    }

    /// Reads how well the standard deviations are known; all rows of an image repeat these values. Empty cells mean exact ones.
    fn noise(&self, row: &StringRecord) -> Result<Option<EstimatedNoise>, FileError> {
        noise(&|column| self.table.is_missing(row, column), &|column| self.table.number(row, column), &|message| {
            self.table.wrong(row, message)
        })
    }

    /// Reads with which scene the image was located; all rows of an image repeat it.
    fn located_with(&self, row: &StringRecord) -> Result<Option<LocatedWith>, FileError> {
        let with = self.table.cell(row, LOCATED_WITH);
        let wrong = |error| self.table.wrong(row, format!("{LOCATED_WITH}: {error}, found {with:?}"));
        (!self.table.is_missing(row, LOCATED_WITH)).then(|| with.parse().map_err(wrong)).transpose()
    }

    /// Reads the pose of the base and its uncertainty from a row; all rows of an image repeat these values.
    fn base(&self, row: &StringRecord) -> Result<Option<ObservedBase>, FileError> {
        if !self.table.has(&POSE_COLUMNS) {
            return Ok(None);
        }
        let number = |column| self.table.number(row, column);
        let [x, y, turn] = POSE_COLUMNS;
        let pose = Isometry2::new(Vector::new(number(x)?, number(y)?), number(turn)?.to_radians());
        let uncertainty = match self.is_base_apart() {
            false => None,
            true => {
                let (sd_mm, sd_rad) = (number(BASE_COLUMNS[0])?, number(BASE_COLUMNS[1])?.to_radians());
                Some(BaseUncertainty { sd_mm, sd_rad, ..BaseUncertainty::default() })
            }
        };
        Ok(Some(ObservedBase { pose, uncertainty, is_known: true }))
    }
}

/// Reads how well the standard deviations of an image are known from the cells of a row. `wrong` adds the line to a message.
pub(crate) fn noise<E>(
    is_missing: &dyn Fn(&str) -> bool,
    number: &dyn Fn(&str) -> Result<f64, E>,
    wrong: &dyn Fn(String) -> E,
) -> Result<Option<EstimatedNoise>, E> {
    if NOISE.iter().any(|column| is_missing(column)) {
        return Ok(None);
    }
    let [degrees_of_freedom, shared_sd_mm] = [number(NOISE[0])?, number(NOISE[1])?];
    let expected =
        |column: &str, expected: &str, found: f64| wrong(format!("{column}: expected {expected}, found {found}"));
    match (degrees_of_freedom > 0.0, shared_sd_mm >= 0.0) {
        (false, _) => Err(expected(NOISE[0], "a number above zero", degrees_of_freedom)),
        (_, false) => Err(expected(NOISE[1], "zero or more", shared_sd_mm)),
        _ => Ok(Some(EstimatedNoise { degrees_of_freedom, shared_sd_mm })),
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

/// Noise of a compressed image, and the scene with which the image was located, repeated on each row of its image.
#[derive(Serialize, Default)]
struct ImageRow {
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_degrees_of_freedom: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    shared_sigma_mm: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    located_with: Option<String>,
}

/// Last column, `refused`, of a table in which at least one image was refused.
#[derive(Serialize)]
struct RefusedRow<'o> {
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<&'o str>,
}

/// The optional columns of a table.
#[derive(Clone, Copy)]
struct Optional {
    noise: bool,
    located_with: bool,
    refused: bool,
}

/// Observations as CSV: `image,node,u_px,v_px,x_mm,y_mm,ux_mm,uy_mm,sigma_mm`, one row per marker. If all located images show the base, the table
/// also has the columns `base_x_mm,base_y_mm,base_deg,base_sigma_mm,base_sigma_deg,marker_sigma_mm`; if the noise of an image is an estimate,
/// `noise_degrees_of_freedom,shared_sigma_mm`; if the scene that located an image is known, `located_with`. If images were refused, the table also has
/// the column `refused`; a refused image has one row.
///
/// # Errors
/// A `csv::Error` from the CSV writer; none is expected, because the text is written to memory.
pub fn to_csv(seen: &[Result<Observation, RefusedImage>]) -> Result<String, csv::Error> {
    let shows_base = seen.iter().flatten().all(|seen| seen.base.is_some());
    let columns = Optional {
        noise: seen.iter().flatten().any(|seen| seen.noise.is_some()),
        located_with: seen.iter().flatten().any(|seen| seen.located_with.is_some()),
        refused: seen.iter().any(Result::is_err),
    };
    let rows = seen.iter().flat_map(|seen| rows_of_image(seen, columns));
    match shows_base {
        false => super::csv_text(rows.map(|(marker, _, image, refused)| (marker, image, refused))),
        true => super::csv_text(rows),
    }
}

type Cells<'o> = (MarkerRow<'o>, BaseRow, ImageRow, RefusedRow<'o>);

fn rows_of_image(seen: &Result<Observation, RefusedImage>, columns: Optional) -> Vec<Cells<'_>> {
    let of_image = |seen: Option<&Observation>| {
        let noise = |of: fn(EstimatedNoise) -> f64| columns.noise.then(|| Some(of(seen?.noise?)));
        let with = || seen.and_then(|seen| seen.located_with).map_or_else(String::new, |with| with.to_string());
        ImageRow {
            noise_degrees_of_freedom: noise(|noise| noise.degrees_of_freedom),
            shared_sigma_mm: noise(|noise| noise.shared_sd_mm),
            located_with: columns.located_with.then(with),
        }
    };
    let refused = |reason| RefusedRow { refused: Some(reason).filter(|_| columns.refused) };
    match seen {
        Ok(seen) => {
            let base = |marker| seen.base.map(|base| base_row(&base, marker)).unwrap_or_default();
            let row = |marker| (marker_row(&seen.image, marker), base(marker), of_image(Some(seen)), refused(""));
            seen.markers.iter().map(row).collect()
        }
        Err(RefusedImage { image, reason }) => {
            vec![(MarkerRow { image, ..MarkerRow::default() }, BaseRow::default(), of_image(None), refused(reason))]
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
