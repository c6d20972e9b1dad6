//! Drawings of causes: the largest one over position and direction, and what each costs along the finger.

use super::shares::{Region, Shares};
use super::{CSV, own_first, practice_in_words, truth_in_words};
use crate::experiments::causes::{Cause, CauseCell, CauseMap, ContactKnowledge, Practice, REMEDIES};
use crate::figures::{Axis, Cells, Chart, Class, Dash, Frame, Hue, Map, Marker, Point, Series, Shades};
use crate::report::ReportError;
use crate::report::drawings::{ALONG_THE_PLATE, DIRECTION_AXIS, PAPER_SHADES_PERCENT, small_maps};
use crate::report::format::percent;
use crate::report::page::Figure;
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;

/// Below this an error needs no explanation: root mean square of sensed / true - 1.
const SMALL_ERROR: f64 = 0.02;
/// Less is not drawn, %.
const LEAST_DRAWN_PERCENT: f64 = 0.1;

/// The n-th class of a map is that of the n-th cause.
fn class(n: usize, label: &str, sign: &str, colour: [u8; 3]) -> Class {
    Class { up_to: n as f64, label: label.to_owned(), sign: sign.to_owned(), colour }
}

fn class_of(n: usize, cause: Cause) -> Class {
    // Okabe and Ito's colours, and two greys.
    let (sign, colour) = match cause {
        Cause::Noise => ("N", [0x56, 0xb4, 0xe9]),
        Cause::Linearisation => ("L", [0xe6, 0x9f, 0x00]),
        Cause::Discretisation => ("E", [0x8a, 0x8f, 0x98]),
        Cause::Modulus => ("M", [0xcc, 0x79, 0xa7]),
        Cause::Direction => ("D", [0x00, 0x9e, 0x73]),
        Cause::Position => ("P", [0xf0, 0xe4, 0x42]),
        Cause::BaseCompliance => ("B", [0x00, 0x72, 0xb2]),
        Cause::TipCompliance => ("T", [0xd5, 0x5e, 0x00]),
        Cause::NetworkFit => ("F", [0x5c, 0x60, 0x66]),
    };
    class(n, cause.name(), sign, colour)
}

/// As near to the colour on the maps as lines have one.
fn line(cause: Cause) -> (Hue, Dash) {
    match cause {
        Cause::Noise => (Hue::SkyBlue, Dash::Solid),
        Cause::Linearisation => (Hue::Orange, Dash::Solid),
        Cause::Discretisation => (Hue::Orange, Dash::Dashed),
        Cause::Modulus => (Hue::Purple, Dash::Solid),
        Cause::Direction => (Hue::Green, Dash::Solid),
        Cause::Position => (Hue::Green, Dash::Dashed),
        Cause::BaseCompliance => (Hue::Blue, Dash::Solid),
        Cause::TipCompliance => (Hue::Vermilion, Dash::Solid),
        Cause::NetworkFit => (Hue::Purple, Dash::Dashed),
    }
}

pub(super) fn map_figure(study: &Study, map: &CauseMap) -> Result<Figure, ReportError> {
    let (angles, places) = (map.request.angles_deg.len(), map.request.positions_mm.len());
    let (small, hidden) = (map.causes.len(), map.causes.len() + 1);
    let mut classes: Vec<Class> = map.causes.iter().enumerate().map(|(n, cause)| class_of(n, *cause)).collect();
    classes.push(class(small, &format!("error below {}", percent(SMALL_ERROR)), "", [0xd9, 0xdd, 0xe2]));
    classes.push(class(hidden, "each hides others", "-", [0xa9, 0xae, 0xb5]));
    let of_cell = |place: usize, angle: usize| {
        let mut at = map.cells.iter().filter(|cell| cell.force_n == DRAWN_FORCE_N);
        let cell = at.nth(place * angles + angle)?;
        Some(match cell.rms_error? {
            rms if rms < SMALL_ERROR => small as f64,
            _ => cell.largest().map_or(hidden, |(cause, _)| cause) as f64,
        })
    };
    let title =
        format!("Largest cause at {DRAWN_FORCE_N} N, finger {}; {}", truth_in_words(map), practice_in_words(map));
    let frame = Frame::half(&title, format!("{title}: by position along the front plate and direction."));
    let y = Axis::linear(DIRECTION_AXIS).with_ticks((-2..=2).map(|i| f64::from(i) * 40.0));
    let values = (0..angles).map(|angle| (0..places).map(|place| of_cell(place, angle)).collect()).collect();
    let cells = Cells::new(&map.request.positions_mm, &map.request.angles_deg, values);
    let missing_label = "no equilibrium or no answer".to_owned();
    let drawn = Map::new(frame, [Axis::linear(ALONG_THE_PLATE), y], Shades::Classes(classes), cells);
    let svg = Map { missing_label, ..drawn }.svg()?;
    let shares = Shares::of(&study.finger, map, DRAWN_FORCE_N, Region::All);
    let over_all = shares.map_or_else(String::new, |shares| {
        let list: Vec<_> = (shares.by_cause.iter().take(3).filter(|of| of.share > 0.0))
            .map(|of| format!("{} {}", of.cause.name(), percent(of.share)))
            .collect();
        format!(
            " Over all cells, root mean square error {}; shares of its square: {}.",
            percent(shares.rms_error),
            list.join(", ")
        )
    });
    Ok(Figure {
        svg,
        caption: format!("The cause whose absence lessens the error most.{over_all}"),
        csv: Some(CSV.to_owned()),
        wide: false,
    })
}

/// `None` where nothing is large enough to be drawn.
pub(super) fn line_figure(map: &CauseMap) -> Result<Option<Figure>, ReportError> {
    let title =
        format!("Along the normal at {DRAWN_FORCE_N} N, finger {}; {}", truth_in_words(map), practice_in_words(map));
    let cells = || map.cells.iter().filter(|cell| cell.angle_deg == 0.0 && cell.force_n == DRAWN_FORCE_N);
    let shown = |cell: &CauseCell, error: Option<f64>| {
        let percent = 100.0 * error?;
        (percent >= LEAST_DRAWN_PERCENT).then_some([cell.s_mm, percent])
    };
    let all = Series { hue: Hue::Neutral, ..Series::nth(0, "all causes", Vec::new()) };
    let mut series = pieces(&all, cells().map(|cell| shown(cell, cell.rms_error)));
    for (i, cause) in map.causes.iter().enumerate() {
        let (hue, dash) = line(*cause);
        let of_cause = Series { marker: None, hue, dash, ..Series::nth(i, cause.name(), Vec::new()) };
        series.extend(pieces(&of_cause, cells().map(|cell| shown(cell, cell.error_of(i)))));
    }
    if series.is_empty() {
        return Ok(None);
    }
    let alt = format!("{title}: error by position, one line a cause.");
    let axes = [Axis::linear(ALONG_THE_PLATE), Axis::log("error that goes away with it, %")];
    Ok(Some(Figure {
        svg: Chart::new(Frame::half(title, alt), axes, series).svg()?,
        caption: format!(
            "Root of the mean square error that goes away when a cause is switched off; nothing below {LEAST_DRAWN_PERCENT} %, nor for \
             one that hides others."
        ),
        csv: Some(CSV.to_owned()),
        wide: false,
    }))
}

/// Which cells are cleared as remedies are taken one after the other, on each finger; `None` where that was not asked.
pub(super) fn clearing(study: &Study) -> Result<Option<Figure>, ReportError> {
    let rows: Vec<_> = own_first(study).filter(assumed).map(clearing_row).collect();
    if rows.is_empty() {
        return Ok(None);
    }
    let title = format!("Error of {DRAWN_FORCE_N} N as remedies are taken, from left to right");
    let alt =
        format!("{title}: small maps by position and direction, a row for each finger, a column for each remedy.");
    let columns = std::iter::once("as it is").chain(REMEDIES.map(|(name, _)| name)).map(str::to_owned).collect();
    let map = small_maps(&study.finger, Frame::full(title, alt), columns, rows, "no equilibrium, or no answer");
    Ok(Some(Figure {
        svg: map.svg()?,
        caption: "What clears it: root mean square error by position and direction, by linear least squares with an assumed contact; then with \
                  zones and modulus known; with position and direction known too; and by the nonlinear estimator with four elements a \
                  member."
            .to_owned(),
        csv: Some(CSV.to_owned()),
        wide: true,
    }))
}

/// Whether it is of linear least squares with an assumed contact, over position and direction.
fn assumed(map: &&CauseMap) -> bool {
    map.practice == Practice::LeastSquares
        && map.contact == ContactKnowledge::Assumed
        && map.request.forces_n.contains(&DRAWN_FORCE_N)
}

fn clearing_row(map: &CauseMap) -> (String, Vec<Option<Cells>>) {
    let angles = map.request.angles_deg.len();
    let cells: Vec<&CauseCell> = map.cells.iter().filter(|cell| cell.force_n == DRAWN_FORCE_N).collect();
    let small = |error: &dyn Fn(&CauseCell) -> Option<f64>| {
        let percents: Vec<Option<f64>> = cells.iter().map(|cell| error(cell).map(|error| 100.0 * error)).collect();
        let clear = percents.iter().filter(|error| error.is_some_and(|error| error <= PAPER_SHADES_PERCENT[0])).count();
        Cells {
            note: format!("{:.0} % clear", 100.0 * clear as f64 / percents.len().max(1) as f64),
            x: map.request.positions_mm.clone(),
            y: map.request.angles_deg.clone(),
            values: (0..angles).map(|angle| percents.iter().skip(angle).step_by(angles).copied().collect()).collect(),
        }
    };
    let remedied = (0..REMEDIES.len()).map(|taken| small(&|cell| cell.remedied.get(taken).copied().flatten()));
    let maps = std::iter::once(small(&|cell| cell.rms_error)).chain(remedied).map(Some).collect();
    (truth_in_words(map).to_owned(), maps)
}

/// A series broken where there is no point; the legend has it once. A point on its own is marked, or it would not be seen.
fn pieces(whole: &Series, points: impl Iterator<Item = Option<Point>>) -> Vec<Series> {
    let points: Vec<Option<Point>> = points.collect();
    let runs = points.chunk_by(|one, next| one.is_some() == next.is_some());
    let runs = runs.map(|run| run.iter().copied().flatten().collect::<Vec<Point>>()).filter(|run| !run.is_empty());
    let piece = |(i, points): (usize, Vec<Point>)| Series {
        label: if i == 0 { whole.label.clone() } else { String::new() },
        marker: whole.marker.or((points.len() == 1).then_some(Marker::Circle)),
        points,
        ..whole.clone()
    };
    runs.enumerate().map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_ends_where_points_are_missing() {
        let points = [Some([0.0, 1.0]), Some([1.0, 1.0]), None, None, Some([4.0, 1.0])];
        let whole = Series { marker: None, ..Series::nth(0, "noise", Vec::new()) };
        let found = pieces(&whole, points.into_iter());
        let lengths: Vec<usize> = found.iter().map(|piece| piece.points.len()).collect();
        assert_eq!(lengths, [2, 1]);
        assert_eq!((found[0].label.as_str(), found[1].label.as_str()), ("noise", ""));
        assert_eq!((found[0].marker, found[1].marker), (None, Some(Marker::Circle)));
        assert!(pieces(&whole, [None, None].into_iter()).is_empty());
    }
}
