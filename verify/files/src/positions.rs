//! Reads positions of markers from a stream, line by line: CSV or JSON.

mod json;
mod time;

use crate::observations::{LOCATED_WITH, NOISE, PIXEL, noise};
use crate::table::{Columns, NODE};
use csv::StringRecord;
use finray_model::observation::{EstimatedNoise, LocatedWith, Observation, ObservedMarker};
use finray_model::{NodeId, Vector};
use std::io::{BufRead, Read};
use time::TimeName;

/// Columns and keys of a marker's coordinates, mm, of their standard deviation, mm, and of the marker's finger; column and key of a frame's image.
const AT: [&str; 2] = ["x_mm", "y_mm"];
const SIGMA: &str = "sigma_mm";
const FINGER: &str = "finger";
const IMAGE: &str = "image";
/// Column of a table whose positions are relative to a moving base.
const MOVING_BASE: &str = "base_x_mm";

/// Longest line, bytes.
const LONGEST_LINE: u64 = 1 << 20;
/// Largest number of rows of one frame of a table.
const MOST_ROWS: usize = 100_000;

/// Positions of the markers in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionFrame {
    /// Time of the frame, s, if it is stated.
    pub time_s: Option<f64>,
    /// The markers of each finger, in the order in which the fingers appear; or, if a line of the frame is invalid, the reason.
    pub seen: Result<Vec<FingerObservation>, String>,
}

/// The markers of one finger in a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FingerObservation {
    /// Name of the finger; empty if the stream does not state it.
    pub finger: String,
    /// The markers.
    pub seen: Observation,
}

/// Reason why a stream of positions cannot be read further.
#[derive(Debug, thiserror::Error)]
pub enum PositionError {
    /// The stream cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// The header or the form of the stream is invalid.
    #[error("{0}")]
    Form(String),
}

/// Largest number of fingers in a frame.
const MOST_FINGERS: usize = 64;

/// Reads frames of positions one after another.
///
/// JSON has one line per frame: `{"t_s": 0.04, "markers": [{"node": 13, "x_mm": 146.1, "y_mm": 3.2, "sigma_mm": 0.02}, ...]}`. The time, `image` and `sigma_mm`
/// may be omitted; both coordinates of a hidden marker are `null` or `NaN`. CSV has a header and one line per marker. The columns, in any order, are a time or
/// `image`, `node`, `x_mm`, `y_mm`, and optionally `sigma_mm` and those of `locate` for pixels, noise and scene; cells are those of a [table](crate::table). A CSV frame ends where the time changes, or, without
/// a time, where `image` changes. In a stream of several fingers, each marker also has the key or column `finger`. Further keys and columns are ignored.
///
/// The time is `time_s`, `time_ms`, `time_us` or `time_ns` (or `t_s` and so on), or a text in ISO 8601 under one of these names, `time`, `timestamp` or `stamp`.
pub struct PositionReader<R> {
    source: R,
    /// The table. `None` for JSON.
    table: Option<PositionTable>,
    /// Number of the last line read, from 1.
    line: usize,
    /// The last line read, as in the stream.
    bytes: Vec<u8>,
    /// Whether the last line is the first row of the next frame of a table.
    is_next: bool,
}

/// A table of positions.
#[derive(Debug, Clone)]
struct PositionTable {
    columns: Columns,
    /// Column that names the frame.
    frame: &'static str,
    time: Option<TimeName>,
}

impl<R: BufRead> PositionReader<R> {
    /// A reader of a stream of JSON (`is_json`) or CSV.
    ///
    /// # Errors
    /// [`PositionError`] if the stream cannot be read, or its header lacks a column.
    pub fn new(source: R, is_json: bool) -> Result<PositionReader<R>, PositionError> {
        let mut reader = PositionReader { source, table: None, line: 0, bytes: Vec::new(), is_next: false };
        if !is_json {
            reader.next_line()?;
            let header = reader.text().map_err(PositionError::Form)?;
            reader.table = Some(PositionTable::of(header).map_err(PositionError::Form)?);
        }
        Ok(reader)
    }

    /// The next frame. `None` at the end of the stream.
    ///
    /// # Errors
    /// [`PositionError`] if the stream cannot be read further. An invalid line is not returned as an error, but reported in [`PositionFrame::seen`]
    /// of its frame.
    pub fn read(&mut self) -> Result<Option<PositionFrame>, PositionError> {
        match self.table.take() {
            None => self.read_json(),
            Some(table) => {
                let frame = self.read_csv(&table);
                self.table = Some(table);
                frame
            }
        }
    }

    /// Reads the next line that is not blank. Returns false at the end of the stream. Of a line that is too long, the first bytes are kept.
    fn next_line(&mut self) -> Result<bool, PositionError> {
        loop {
            self.bytes.clear();
            self.line += 1;
            let count = (&mut self.source).take(LONGEST_LINE).read_until(b'\n', &mut self.bytes)?;
            if self.is_too_long() {
                self.source.skip_until(b'\n')?;
            }
            if count == 0 || !self.text().is_ok_and(str::is_empty) {
                return Ok(count > 0);
            }
        }
    }

    fn is_too_long(&self) -> bool {
        self.bytes.len() as u64 == LONGEST_LINE && !self.bytes.ends_with(b"\n")
    }

    /// The last line without its end, or the reason why the line is invalid.
    fn text(&self) -> Result<&str, String> {
        if self.is_too_long() {
            return Err(format!("line {}: expected at most {LONGEST_LINE} bytes", self.line));
        }
        let text = std::str::from_utf8(&self.bytes).map(str::trim_end);
        text.map_err(|_| format!("line {}: expected text in UTF-8", self.line))
    }

    fn read_json(&mut self) -> Result<Option<PositionFrame>, PositionError> {
        if !self.next_line()? {
            return Ok(None);
        }
        let line = self.line;
        let in_line = |reason: String| format!("line {line}: {reason}");
        let frame = self.text().and_then(|text| json::object(text).map_err(|reason| format!("line {line}{reason}")));
        let time_s = frame.as_ref().map_err(String::clone).and_then(|frame| json::time_s(frame).map_err(in_line));
        let seen = frame.and_then(|frame| json::observations(&frame).map_err(in_line));
        Ok(Some(PositionFrame { time_s: time_s.clone().ok().flatten(), seen: time_s.and(seen) }))
    }

    fn read_csv(&mut self, table: &PositionTable) -> Result<Option<PositionFrame>, PositionError> {
        // Name of the frame, and the line of its first row.
        let mut first: Option<(String, usize)> = None;
        let mut seen: Result<Fingers, String> = Ok(Fingers::default());
        let (mut rows, mut cells) = (0, StringRecord::new());
        loop {
            if !std::mem::take(&mut self.is_next) && !self.next_line()? {
                break;
            }
            let line = self.line;
            let in_line = |reason| format!("line {line}: {reason}");
            let split = self.text().and_then(|text| table.columns.split(text, &mut cells).map_err(in_line));
            // A line without the cell of its frame counts as part of the current frame.
            let of = match table.columns.cell(&cells, table.frame) {
                "" if split.is_err() => first.as_ref().map_or("", |(name, _)| name),
                of => of,
            };
            if first.as_ref().is_some_and(|(name, _)| name != of) {
                self.is_next = true;
                break;
            }
            rows += 1;
            if rows > MOST_ROWS {
                let message = format!("expected a row with another {} within {MOST_ROWS} rows", table.frame);
                return Err(PositionError::Form(in_line(message)));
            }
            if first.is_none() {
                first = Some((of.to_owned(), line));
            }
            let read = split
                .and_then(|()| Ok((table.marker(&cells).map_err(in_line)?, table.of_image(&cells).map_err(in_line)?)));
            seen = seen.and_then(|mut fingers| {
                let (marker, of_image) = read?;
                fingers.add(table.columns.cell(&cells, FINGER), marker).map_err(in_line)?;
                fingers.of_image = of_image;
                Ok(fingers)
            });
        }
        let Some((name, line)) = first else { return Ok(None) };
        let time_s = table.time.map(|time| time.seconds(&name)).transpose();
        let time_s = time_s.map_err(|reason| format!("line {line}: {reason}"));
        let image = if table.time.is_some() { String::new() } else { name };
        let seen = seen.map(|fingers| fingers.observations(&image));
        Ok(Some(PositionFrame { time_s: time_s.clone().ok().flatten(), seen: time_s.and(seen) }))
    }
}

/// Markers of a frame by finger.
#[derive(Default)]
struct Fingers {
    markers: Vec<(String, Vec<ObservedMarker>)>,
    /// Noise of the image, and the scene with which it was located.
    of_image: (Option<EstimatedNoise>, Option<LocatedWith>),
}

impl Fingers {
    /// Adds a marker of a finger; `None` for a hidden marker.
    fn add(&mut self, finger: &str, marker: Option<ObservedMarker>) -> Result<(), String> {
        let is_full = self.markers.len() == MOST_FINGERS;
        match self.markers.iter_mut().find(|(name, _)| name == finger) {
            Some((_, markers)) => markers.extend(marker),
            None if is_full => {
                return Err(format!("expected at most {MOST_FINGERS} fingers in a frame"));
            }
            None => self.markers.push((finger.to_owned(), marker.into_iter().collect())),
        }
        Ok(())
    }

    fn observations(self, image: &str) -> Vec<FingerObservation> {
        let (noise, located_with) = self.of_image;
        let of = |(finger, markers)| {
            let seen = Observation { image: image.to_owned(), markers, base: None, noise, located_with };
            FingerObservation { finger, seen }
        };
        self.markers.into_iter().map(of).collect()
    }
}

impl PositionTable {
    fn of(header: &str) -> Result<PositionTable, String> {
        let in_line = |reason| format!("line 1: {reason}");
        let columns = Columns::of_line(header).map_err(in_line)?;
        let time = TimeName::first(|name| columns.has(&[name]));
        if time.is_none() && !columns.has(&[IMAGE]) {
            let found = columns.listed();
            return Err(in_line(format!(
                "expected a column time_s (or time_ms, time_ns, time, t_s) or image, found the columns {found}"
            )));
        }
        let optional = [&[SIGMA, FINGER, IMAGE, LOCATED_WITH][..], &PIXEL, &NOISE].concat();
        columns.require(&[NODE, AT[0], AT[1]], &optional).map_err(in_line)?;
        Ok(PositionTable { columns, frame: time.map_or(IMAGE, |time| time.name), time })
    }

    /// Marker of a row; `None` for a row without coordinates, whose marker is hidden.
    fn marker(&self, row: &StringRecord) -> Result<Option<ObservedMarker>, String> {
        let node = self.columns.node(row, NODE)?;
        let Some(at) = self.columns.vector(row, AT)? else { return Ok(None) };
        let has_sigma = !self.columns.is_missing(row, SIGMA);
        let sigma_mm = has_sigma.then(|| self.columns.number(row, SIGMA)).transpose()?;
        // The pixels of a moving base are unknown, so that the pixels of its markers have no position.
        let has_pixels = self.columns.has(&PIXEL) && !self.columns.has(&[MOVING_BASE]);
        let pixel = if has_pixels { self.columns.vector(row, PIXEL)? } else { None };
        Ok(Some(ObservedMarker { pixel, ..marker(node, at, sigma_mm) }))
    }

    /// Noise of the row's image, and the scene with which it was located.
    fn of_image(&self, row: &StringRecord) -> Result<(Option<EstimatedNoise>, Option<LocatedWith>), String> {
        let number = |column: &str| self.columns.number(row, column);
        let noise = noise(&|column| self.columns.is_missing(row, column), &number, &|message| message)?;
        let with = self.columns.cell(row, LOCATED_WITH);
        let wrong = |error| format!("{LOCATED_WITH}: {error}, found {with:?}");
        let is_stated = !self.columns.is_missing(row, LOCATED_WITH);
        Ok((noise, is_stated.then(|| with.parse().map_err(wrong)).transpose()?))
    }
}

fn marker(node: NodeId, position: Vector, sd_mm: Option<f64>) -> ObservedMarker {
    ObservedMarker { node, pixel: None, position: Some(position), displacement: None, sd_mm, own_sd_mm: None }
}
