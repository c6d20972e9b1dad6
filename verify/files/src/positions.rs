//! Reads positions of markers from a stream, line by line: CSV or JSON.

use csv::StringRecord;
use finray_model::observation::{Observation, ObservedMarker};
use finray_model::{NodeId, Vector};
use serde::Deserialize;
use std::io::{BufRead, Read};

/// Longest line, bytes.
const LONGEST_LINE: u64 = 1 << 20;
/// Largest number of characters that a message quotes.
const LONGEST_QUOTE: usize = 100;
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

/// Latest time of a frame, s; the limit exists because recordings store times as nanoseconds in 64 bits.
const LATEST_S: f64 = 1e10;

fn is_time(time_s: &f64) -> bool {
    (0.0..=LATEST_S).contains(time_s)
}

/// Largest number of fingers in a frame.
const MOST_FINGERS: usize = 64;

/// One frame as a line of JSON.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrameLine {
    t_s: Option<f64>,
    image: Option<String>,
    markers: Vec<MarkerLine>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MarkerLine {
    #[serde(default)]
    finger: String,
    node: usize,
    // Both coordinates are `null` if the marker is hidden. With `deserialize_with`, they cannot be left out.
    #[serde(deserialize_with = "Option::deserialize")]
    x_mm: Option<f64>,
    #[serde(deserialize_with = "Option::deserialize")]
    y_mm: Option<f64>,
    sigma_mm: Option<f64>,
}

/// Reads frames of positions one after another.
///
/// JSON has one line per frame: `{"t_s": 0.04, "markers": [{"node": 13, "x_mm": 146.1, "y_mm": 3.2, "sigma_mm": 0.02}, ...]}`. The keys `t_s`, `image` and
/// `sigma_mm` may be omitted; both coordinates of a hidden marker are `null` or `NaN`. CSV has a header and one line per marker. The columns, in any order, are `t_s` or `image`, `node`, `x_mm`, `y_mm`, and optionally
/// `sigma_mm`. A CSV frame ends where `t_s` changes, or, without `t_s`, where `image` changes. In a stream of several fingers, each marker also has the key or
/// column `finger`.
pub struct PositionReader<R> {
    source: R,
    /// Columns of a table. `None` for JSON.
    columns: Option<Columns>,
    /// Number of the last line read, from 1.
    line: usize,
    /// The last line read, as in the stream.
    bytes: Vec<u8>,
    /// Whether the last line is the first row of the next frame of a table.
    is_next: bool,
}

/// Name of a row's frame, name of the row's finger, and the row's marker; the marker is `None` if it is hidden.
type Row<'t> = (&'t str, Result<(&'t str, Option<ObservedMarker>), String>);

#[derive(Clone, Copy)]
struct Columns {
    frame: usize,
    is_time: bool,
    finger: Option<usize>,
    node: usize,
    at: [usize; 2],
    sigma: Option<usize>,
}

impl<R: BufRead> PositionReader<R> {
    /// A reader of a stream of JSON (`is_json`) or CSV.
    ///
    /// # Errors
    /// [`PositionError`] if the stream cannot be read, or its header lacks a column.
    pub fn new(source: R, is_json: bool) -> Result<PositionReader<R>, PositionError> {
        let mut reader = PositionReader { source, columns: None, line: 0, bytes: Vec::new(), is_next: false };
        if !is_json {
            reader.next_line()?;
            let header = reader.text().map_err(PositionError::Form)?;
            reader.columns = Some(Columns::of(header).map_err(PositionError::Form)?);
        }
        Ok(reader)
    }

    /// The next frame. `None` at the end of the stream.
    ///
    /// # Errors
    /// [`PositionError`] if the stream cannot be read further. An invalid line is not returned as an error, but reported in [`PositionFrame::seen`]
    /// of its frame.
    pub fn read(&mut self) -> Result<Option<PositionFrame>, PositionError> {
        match self.columns {
            None => self.read_json(),
            Some(columns) => self.read_csv(columns),
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
        let of_text = |text: &str| {
            // Python writes numbers that are missing as NaN, which is no JSON.
            let text = text.trim_start_matches('\u{feff}').replace(": NaN", ": null").replace(":NaN", ":null");
            serde_json::from_str(&text).map_err(|error| format!("line {line}: {error}"))
        };
        let frame: Result<FrameLine, String> = self.text().and_then(of_text);
        let frame = frame.and_then(|frame| match frame.t_s {
            Some(time_s) if !is_time(&time_s) => {
                Err(format!("line {line}: t_s: expected a time in s of 0 or more, found {time_s}"))
            }
            _ => Ok(frame),
        });
        let time_s = frame.as_ref().ok().and_then(|frame| frame.t_s);
        let seen = frame.and_then(|frame| {
            let mut fingers = Fingers::default();
            for of in frame.markers {
                let at = of.x_mm.zip(of.y_mm).map(|(x, y)| Vector::new(x, y));
                if at.is_none() && (of.x_mm.is_some() || of.y_mm.is_some()) {
                    return Err(format!("line {line}: node {}: expected two coordinates, or two times null", of.node));
                }
                let marker = at.map(|at| marker(NodeId(of.node), at, of.sigma_mm));
                fingers.add(&of.finger, marker).map_err(|reason| format!("line {line}: {reason}"))?;
            }
            Ok(fingers.observations(&frame.image.unwrap_or_default()))
        });
        Ok(Some(PositionFrame { time_s, seen }))
    }

    fn read_csv(&mut self, columns: Columns) -> Result<Option<PositionFrame>, PositionError> {
        let mut name: Option<String> = None;
        let mut seen: Result<Fingers, String> = Ok(Fingers::default());
        let (mut rows, mut cells) = (0, StringRecord::new());
        loop {
            if !std::mem::take(&mut self.is_next) && !self.next_line()? {
                break;
            }
            let (of, marker) = match self.text().and_then(|text| split(text, self.line, &mut cells)) {
                Ok(()) => columns.row(&cells, self.line),
                // A line that is not UTF-8, or too long, counts as part of the current frame.
                Err(reason) => (name.as_deref().unwrap_or_default(), Err(reason)),
            };
            if name.as_ref().is_some_and(|name| name != of) {
                self.is_next = true;
                break;
            }
            rows += 1;
            if rows > MOST_ROWS {
                let message =
                    format!("line {}: expected a row with another t_s or image within {MOST_ROWS} rows", self.line);
                return Err(PositionError::Form(message));
            }
            match (marker, &mut seen) {
                (Ok((finger, marker)), Ok(fingers)) => {
                    if let Err(reason) = fingers.add(finger, marker) {
                        seen = Err(format!("line {}: {reason}", self.line));
                    }
                }
                (Err(reason), Ok(_)) => seen = Err(reason),
                (_, Err(_)) => {}
            }
            if name.is_none() {
                name = Some(of.to_owned());
            }
        }
        let Some(name) = name else { return Ok(None) };
        let time = columns.is_time.then(|| name.parse().ok().filter(is_time));
        if time == Some(None) {
            let line = self.line;
            seen = Err(format!("line {line}: t_s: expected a time in s of 0 or more, found {name:?}"));
        }
        let time_s = time.flatten();
        let image = if columns.is_time { String::new() } else { name };
        Ok(Some(PositionFrame { time_s, seen: seen.map(|fingers| fingers.observations(&image)) }))
    }
}

/// Markers of a frame by finger.
#[derive(Default)]
struct Fingers(Vec<(String, Vec<ObservedMarker>)>);

impl Fingers {
    /// Adds a marker of a finger; `None` for a hidden marker.
    fn add(&mut self, finger: &str, marker: Option<ObservedMarker>) -> Result<(), String> {
        let is_full = self.0.len() == MOST_FINGERS;
        match self.0.iter_mut().find(|(name, _)| name == finger) {
            Some((_, markers)) => markers.extend(marker),
            None if is_full => {
                return Err(format!("expected at most {MOST_FINGERS} fingers in a frame"));
            }
            None => self.0.push((finger.to_owned(), marker.into_iter().collect())),
        }
        Ok(())
    }

    fn observations(self, image: &str) -> Vec<FingerObservation> {
        let of = |(finger, markers)| {
            let seen = Observation { image: image.to_owned(), markers, base: None };
            FingerObservation { finger, seen }
        };
        self.0.into_iter().map(of).collect()
    }
}

impl Columns {
    fn of(header: &str) -> Result<Columns, String> {
        let header = header.trim_start_matches('\u{feff}');
        let mut names = StringRecord::new();
        split(header, 1, &mut names)?;
        let column = |name: &str| names.iter().position(|found| found == name);
        let needed = |name| {
            column(name).ok_or_else(|| {
                format!(
                    "line 1: expected a header with t_s or image, node, x_mm, y_mm; {name} is missing in {:?}",
                    header.chars().take(LONGEST_QUOTE).collect::<String>()
                )
            })
        };
        Ok(Columns {
            frame: column("t_s").map_or_else(|| needed("image"), Ok)?,
            is_time: column("t_s").is_some(),
            finger: column("finger"),
            node: needed("node")?,
            at: [needed("x_mm")?, needed("y_mm")?],
            sigma: column("sigma_mm"),
        })
    }

    fn row<'t>(&self, row: &'t StringRecord, line: usize) -> Row<'t> {
        let Columns { frame, is_time: _, finger, node, at, sigma } = *self;
        let columns = [Some(frame), finger, Some(node), Some(at[0]), Some(at[1]), sigma];
        let mut cells = [None; 6];
        for (found, column) in cells.iter_mut().zip(columns) {
            *found = column.and_then(|index| row.get(index));
        }
        let [frame, finger, ..] = cells.map(Option::unwrap_or_default);
        let marker = self.marker(cells).map(|marker| (finger, marker));
        (frame, marker.map_err(|reason| format!("line {line}: {reason}")))
    }

    /// Marker of a row with cells for frame, finger, node, two coordinates and standard deviation; `None` for a row without coordinates, whose marker
    /// is hidden.
    fn marker(&self, [_, _, node, x, y, sigma]: [Option<&str>; 6]) -> Result<Option<ObservedMarker>, String> {
        let number = |text: &str, name: &str| -> Result<f64, String> {
            let number = text.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| format!("{name}: expected a number, found {text:?}"))
        };
        let node = needed(node, self.node)?;
        let node = NodeId(node.parse().map_err(|_| format!("node: expected a number of a node, found {node:?}"))?);
        if (x, y) == (Some(""), Some("")) {
            return Ok(None);
        }
        let at = Vector::new(number(needed(x, self.at[0])?, "x_mm")?, number(needed(y, self.at[1])?, "y_mm")?);
        let sigma_mm = sigma.filter(|sigma| !sigma.is_empty()).map(|sigma| number(sigma, "sigma_mm")).transpose()?;
        Ok(Some(marker(node, at, sigma_mm)))
    }
}

/// Splits a line of a table into cells. A line without quotes needs no parser of CSV, which would have to be built for each line.
fn split(text: &str, line: usize, cells: &mut StringRecord) -> Result<(), String> {
    cells.clear();
    if text.contains('"') {
        let table = csv::ReaderBuilder::new().has_headers(false).trim(csv::Trim::All).from_reader(text.as_bytes());
        table
            .into_records()
            .take(1)
            .try_for_each(|row| row.map(|row| *cells = row))
            .map_err(|error| format!("line {line}: {error}"))
    } else {
        text.split(',').for_each(|cell| cells.push_field(cell.trim()));
        Ok(())
    }
}

/// The cell of a column, or the message that the row is too short.
fn needed(cell: Option<&str>, column: usize) -> Result<&str, String> {
    cell.ok_or_else(|| format!("expected {} cells", column + 1))
}

fn marker(node: NodeId, position: Vector, sd_mm: Option<f64>) -> ObservedMarker {
    ObservedMarker { node, pixel: None, position: Some(position), displacement: None, sd_mm, own_sd_mm: None }
}
