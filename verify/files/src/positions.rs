//! Positions of markers, line by line: CSV or JSON.

use finray_model::observation::{Observation, ObservedMarker};
use finray_model::{NodeId, Vector};
use serde::Deserialize;
use std::io::BufRead;

/// A frame of positions, and its time in s if it is stated.
pub type TimedObservation = (Observation, Option<f64>);

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
    node: usize,
    x_mm: f64,
    y_mm: f64,
    sigma_mm: Option<f64>,
}

/// Reads frames of positions one after another.
///
/// Lines of JSON: `{"t_s": 0.04, "markers": [{"node": 13, "x_mm": 146.1, "y_mm": 3.2, "sigma_mm": 0.02}, ...]}`, one line a frame; `t_s`, `image` and `sigma_mm`
/// may be left out. CSV: a header with `t_s` or `image`, `node`, `x_mm`, `y_mm` and possibly `sigma_mm` in any order, one line a marker. A CSV frame ends where
/// `t_s` or `image` changes.
pub struct PositionReader<R> {
    source: R,
    /// Columns of a table: name of the frame, node, x, y, standard deviation. `None` for JSON.
    columns: Option<Columns>,
    /// Number of the last line read, from 1.
    line: usize,
    /// First row of the next frame of a table.
    next: Option<(String, Option<ObservedMarker>)>,
    text: String,
}

#[derive(Clone, Copy)]
struct Columns {
    frame: usize,
    is_time: bool,
    node: usize,
    at: [usize; 2],
    sigma: Option<usize>,
}

impl<R: BufRead> PositionReader<R> {
    /// A stream whose first line decides between JSON (`{`) and CSV.
    ///
    /// # Errors
    /// The reason if the stream cannot be read, or its header lacks a column.
    pub fn new(mut source: R) -> Result<PositionReader<R>, String> {
        let is_json = source.fill_buf().map_err(|error| format!("cannot be read: {error}"))?.first() == Some(&b'{');
        let mut reader = PositionReader { source, columns: None, line: 0, next: None, text: String::new() };
        if !is_json {
            reader.read_line()?;
            reader.columns = Some(Columns::of(&reader.text)?);
        }
        Ok(reader)
    }

    /// The next frame. `None` at the end of the stream. A frame with an invalid line is an error, after which the stream can be read on.
    pub fn next(&mut self) -> Option<Result<TimedObservation, String>> {
        match self.columns {
            None => self.next_json(),
            Some(columns) => self.next_csv(columns).transpose(),
        }
    }

    /// Reads a line into `text`. False at the end of the stream.
    fn read_line(&mut self) -> Result<bool, String> {
        self.text.clear();
        self.line += 1;
        let line = self.line;
        let count =
            self.source.read_line(&mut self.text).map_err(|error| format!("line {line}: cannot be read: {error}"))?;
        Ok(count > 0)
    }

    fn next_json(&mut self) -> Option<Result<TimedObservation, String>> {
        loop {
            match self.read_line() {
                Ok(false) => return None,
                Err(reason) => return Some(Err(reason)),
                Ok(true) if self.text.trim().is_empty() => {}
                Ok(true) => break,
            }
        }
        let frame: Result<FrameLine, _> = serde_json::from_str(&self.text);
        Some(frame.map_err(|error| format!("line {}: {error}", self.line)).map(|frame| {
            let marker = |of: MarkerLine| marker(NodeId(of.node), Vector::new(of.x_mm, of.y_mm), of.sigma_mm);
            let markers = frame.markers.into_iter().map(marker).collect();
            (Observation { image: frame.image.unwrap_or_default(), markers, base: None }, frame.t_s)
        }))
    }

    fn next_csv(&mut self, columns: Columns) -> Result<Option<TimedObservation>, String> {
        let (mut name, mut markers) = (None, Vec::new());
        if let Some((first, marker)) = self.next.take() {
            (name, markers) = (Some(first), marker.into_iter().collect());
        }
        let mut wrong = None;
        while self.read_line()? {
            if self.text.trim().is_empty() {
                continue;
            }
            let row = columns.row(&self.text).map_err(|reason| format!("line {}: {reason}", self.line));
            match row {
                Err(reason) => wrong = wrong.or(Some(reason)),
                Ok((of, marker)) if name.as_ref().is_none_or(|name| *name == of) => {
                    name = Some(of);
                    markers.extend(marker);
                }
                Ok((of, marker)) => {
                    self.next = Some((of, marker));
                    break;
                }
            }
        }
        match (wrong, name) {
            (Some(reason), _) => Err(reason),
            (None, None) => Ok(None),
            (None, Some(name)) => {
                let t_s = columns.is_time.then(|| name.trim().parse().ok()).flatten();
                let image = if columns.is_time { String::new() } else { name };
                Ok(Some((Observation { image, markers, base: None }, t_s)))
            }
        }
    }
}

impl Columns {
    fn of(header: &str) -> Result<Columns, String> {
        let names: Vec<&str> = header.trim().trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
        let column = |name: &str| names.iter().position(|found| *found == name);
        let needed = |name| {
            column(name).ok_or_else(|| {
                format!(
                    "line 1: expected a header with t_s or image, node, x_mm, y_mm; {name} is missing in {:?}",
                    header.trim()
                )
            })
        };
        Ok(Columns {
            frame: column("t_s").map_or_else(|| needed("image"), Ok)?,
            is_time: column("t_s").is_some(),
            node: needed("node")?,
            at: [needed("x_mm")?, needed("y_mm")?],
            sigma: column("sigma_mm"),
        })
    }

    /// Name of the frame and marker of a row. No marker for a row without coordinates, whose marker is hidden.
    fn row(&self, line: &str) -> Result<(String, Option<ObservedMarker>), String> {
        let cells: Vec<&str> = line.trim_end().split(',').map(str::trim).collect();
        let cell = |column: usize| cells.get(column).copied().ok_or_else(|| format!("expected {} cells", column + 1));
        let number = |column: usize, name: &str| -> Result<f64, String> {
            let text = cell(column)?;
            text.parse().map_err(|_| format!("{name}: expected a number, found {text:?}"))
        };
        let name = cell(self.frame)?.to_owned();
        let text = cell(self.node)?;
        let node = NodeId(text.parse().map_err(|_| format!("node: expected a number of a node, found {text:?}"))?);
        if self.at.iter().all(|column| cells.get(*column) == Some(&"")) {
            return Ok((name, None));
        }
        let at = Vector::new(number(self.at[0], "x_mm")?, number(self.at[1], "y_mm")?);
        let sigma = self.sigma.filter(|column| cells.get(*column).is_some_and(|cell| !cell.is_empty()));
        let sigma_mm = sigma.map(|column| number(column, "sigma_mm")).transpose()?;
        Ok((name, Some(marker(node, at, sigma_mm))))
    }
}

fn marker(node: NodeId, position: Vector, sd_mm: Option<f64>) -> ObservedMarker {
    ObservedMarker { node, pixel: None, position: Some(position), displacement: None, sd_mm, own_sd_mm: None }
}
