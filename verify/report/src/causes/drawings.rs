//! Drawings of causes: maps of the largest cause, and the error at the nodes as remedies are added.

use super::{CSV, OWN, at_nodes, estimator_in_words, own_first};
use crate::drawings::{ALONG_THE_PLATE, DIRECTION_AXIS, by_direction, error_bars, rank_of, small_maps};
use crate::format::percent;
use crate::prelude::*;
use finray_figures::Paint;
use finray_studies::experiments::causes::{Cause, CauseCell, CauseMap, ContactKnowledge, Practice, REMEDIES};

/// Cells whose root mean square of sensed / true - 1 is below this show no cause.
const SMALL_ERROR: f64 = 0.02;

/// Colour class of the n-th cause in a map.
fn class(n: usize, label: &str, sign: &str, colour: [u8; 3]) -> Class {
    Class { up_to: n as f64, label: label.to_owned(), sign: sign.to_owned(), fill: Paint::Colour(colour) }
}

fn class_of(n: usize, cause: Cause) -> Class {
    // Colours of the palette of Okabe and Ito, and a grey.
    let (sign, colour) = match cause {
        Cause::Noise => ("N", [0x56, 0xb4, 0xe9]),
        Cause::Linearisation => ("L", [0xe6, 0x9f, 0x00]),
        Cause::Modulus => ("M", [0xcc, 0x79, 0xa7]),
        Cause::Direction => ("D", [0x00, 0x72, 0xb2]),
        Cause::Position => ("P", [0xf0, 0xe4, 0x42]),
        Cause::BaseCompliance => ("B", [0x00, 0x9e, 0x73]),
        Cause::TipCompliance => ("T", [0xd5, 0x5e, 0x00]),
        Cause::NetworkFit => ("F", [0x5c, 0x60, 0x66]),
    };
    class(n, cause.name(), sign, colour)
}

/// Map of the largest cause by position and direction, for one force in N.
pub(super) fn map_figure(map: &CauseMap, force_n: f64) -> Result<Figure, ReportError> {
    let (small, hidden) = (map.causes.len(), map.causes.len() + 1);
    let mut classes: Vec<Class> = map.causes.iter().enumerate().map(|(n, cause)| class_of(n, *cause)).collect();
    classes.push(class(small, &format!("error below {}", percent(SMALL_ERROR)), "", [0xd9, 0xdd, 0xe2]));
    classes.push(class(hidden, "causes cancel each other", "-", [0xa9, 0xae, 0xb5]));
    let of_cell = |cell: &CauseCell| {
        Some(match cell.rms_error? {
            rms if rms < SMALL_ERROR => small as f64,
            _ => cell.largest().map_or(hidden, |(cause, _)| cause) as f64,
        })
    };
    let (truth, practice, contact) = (map.truth.label(), estimator_in_words(map), map.contact.name());
    let title = format!("Largest cause at {force_n} N, {truth}; {practice}, contact {contact}");
    let frame = Frame::half(&title, format!("{title}: by position along the front plate and direction."));
    let y = Axis::linear(DIRECTION_AXIS).with_ticks((-2..=2).map(|i| f64::from(i) * 40.0));
    let causes = map.cells.iter().filter(|cell| cell.force_n == force_n).map(of_cell);
    let cells = by_direction(&map.request.positions_mm, &map.request.angles_deg, causes);
    let missing_label = "no equilibrium or no answer".to_owned();
    let drawn = Map::new(frame, [Axis::linear(ALONG_THE_PLATE), y], classes, vec![Some(cells)]);
    let svg = Map { missing_label, ..drawn }.svg()?;
    Ok(Figure::narrow(svg, "Colour: the cause whose removal leaves the smallest error.", CSV))
}

/// Small maps of the error, one row per true finger. From left to right, remedies (removals of a cause) are added one after the other; `None` without
/// such results.
pub(super) fn clearing(study: &Study) -> Result<Option<Figure>, ReportError> {
    let force_n = study.forces.drawn_n();
    let rows: Vec<_> =
        own_first(study).filter(|map| is_drawn(map, force_n)).map(|map| clearing_row(study, map)).collect();
    if rows.is_empty() {
        return Ok(None);
    }
    let title = format!("Error of {force_n} N as remedies are added, from left to right");
    let alt =
        format!("{title}: small maps by position and direction, a row for each finger, a column for each remedy.");
    let added = REMEDIES.map(|(name, _)| format!("+ {name}"));
    let columns = std::iter::once("no remedy".to_owned()).chain(added).collect();
    let map = small_maps(&study.finger, Frame::full(title, alt), columns, rows);
    let caption = format!(
        "Root mean square error of a force of {force_n} N. First map: least squares with an assumed contact. Then, one after the other: modulus and \
         zones (softer base and tip) are known; the contact is known; the nonlinear estimator is used."
    );
    Ok(Some(Figure::wide(map.svg()?, caption, CSV)))
}

/// Bars of the error at the nodes as remedies (removals of a cause) are added one after the other. Each bar shows a remaining error, so the bars do not add up.
pub(super) fn remedies(study: &Study) -> Result<Option<Figure>, ReportError> {
    let force_n = study.forces.drawn_n();
    let Some(map) = study.causes.iter().find(|map| map.truth == OWN && is_drawn(map, force_n)) else { return Ok(None) };
    let cells: Vec<(NodeId, &CauseCell)> = at_nodes(study, map).collect();
    if cells.is_empty() {
        return Ok(None);
    }
    let bars = |nth: usize, label: String, error: &dyn Fn(&CauseCell) -> Option<f64>| {
        let hue = if nth == 0 { Hue::NEUTRAL } else { Hue::nth(nth - 1) };
        error_bars(label, hue, cells.iter().map(|(_, cell)| error(cell)))
    };
    let taken = REMEDIES.iter().enumerate().map(|(taken, (name, _))| {
        bars(taken + 1, format!("+ {name}"), &move |cell| cell.remedied.get(taken).copied().flatten())
    });
    let all = std::iter::once(bars(0, "no remedy".to_owned(), &|cell| cell.rms_error)).chain(taken).collect();
    let nodes = Axis::categories("contact node, base to tip", cells.iter().map(|(node, _)| node.to_string()).collect());
    let title = format!("Remaining error of {force_n} N along the normal, {}", OWN.label());
    let alt = "Root mean square error by contact node: with all causes, and as remedies are added one after the other.";
    let axes = [nodes, Axis::linear("root mean square error, %")];
    let caption =
        "Each bar is the remaining error. Causes may cancel each other, so a remedy can also make the error larger.";
    Ok(Some(Figure::wide(Chart::of_bars(Frame::full(title, alt), axes, all).svg()?, caption, CSV)))
}

/// Whether a map belongs to least squares with an assumed contact, and contains the force `force_n`, N.
fn is_drawn(map: &CauseMap, force_n: f64) -> bool {
    map.practice == Practice::LeastSquares
        && map.contact == ContactKnowledge::Assumed
        && map.request.forces_n.contains(&force_n)
}

fn clearing_row(study: &Study, map: &CauseMap) -> (String, Vec<Option<Cells>>) {
    let of_truth: Vec<_> = study.maps.iter().filter(|of| of.truth == map.truth).collect();
    let state = |cell: &CauseCell| {
        let same = |of: &&MapCell| (of.s_mm, of.angle_deg, of.force_n) == (cell.s_mm, cell.angle_deg, cell.force_n);
        match of_truth.iter().find_map(|of| of.cells.iter().find(same)).map(MapCell::state) {
            Some(CellState::WithoutEquilibrium) => CellState::WithoutEquilibrium,
            _ => CellState::Answered,
        }
    };
    let cells: Vec<&CauseCell> = map.cells.iter().filter(|cell| cell.force_n == study.forces.drawn_n()).collect();
    let states: Vec<CellState> = cells.iter().map(|cell| state(cell)).collect();
    let bent = states.iter().filter(|state| **state != CellState::WithoutEquilibrium).count();
    let small = |error: &dyn Fn(&CauseCell) -> Option<f64>| {
        let errors: Vec<Option<f64>> = cells.iter().map(|cell| error(cell)).collect();
        let trusted = errors.iter().filter(|error| error.is_some_and(|error| error <= TRUSTED_ERROR)).count();
        let ranks = states.iter().zip(&errors).map(|(state, error)| Some(rank_of(*state, *error) as f64));
        let note =
            format!("{:.0} % of {bent} within {}", 100.0 * trusted as f64 / bent.max(1) as f64, percent(TRUSTED_ERROR));
        Cells { note, ..by_direction(&map.request.positions_mm, &map.request.angles_deg, ranks) }
    };
    let remedied = (0..REMEDIES.len()).map(|taken| small(&|cell| cell.remedied.get(taken).copied().flatten()));
    let maps = std::iter::once(small(&|cell| cell.rms_error)).chain(remedied).map(Some).collect();
    (map.truth.label().to_owned(), maps)
}
