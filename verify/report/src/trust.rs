//! First screen: drawings, counts and files that show where a force can be trusted. In each cell the force with the largest error counts.

use super::drawings::{ACROSS_AXIS, ALONG_THE_PLATE, at_rest, error_classes, plate_ticks, point, rank_of};
use super::format::{capitalised, list, percent};
use crate::prelude::*;
use finray_figures::Patch;
use finray_studies::experiments::explain::Explanation;
use finray_studies::sampling::worst::WorstCell;
use finray_studies::settings::{DIRECTION_OFF_DEG, POSITION_OFF_MM};

const CSV: &str = "trust.csv";
/// File with the cells (positions and directions) of the map with assumed contact.
pub(super) const ASSUMED_CSV: &str = "map_corotational_nonlinear_contact_assumed.csv";
/// Largest number of contact nodes at which the drawing has a fan of all directions.
const FANS: usize = 6;
/// Two upper limits of the length of a fan's rays: a share of the distance between fans, and a share of the plate length. The smaller limit applies.
const REACH: [f64; 2] = [0.48, 0.1];
/// Half the width of the coloured plate in the drawing, as a share of the plate length.
const HALF_WIDTH: f64 = 0.012;

/// A case in which the recommended estimator is evaluated: contact and finger are known exactly, or assumed with errors.
pub(super) struct Situation<'s> {
    /// Short name for files and headings.
    pub name: &'static str,
    /// Text that states which quantities are known and which are not.
    pub about: String,
    /// Content of `about`, worded as part of a sentence.
    pub in_words: String,
    /// Content of `about` in a few words.
    pub in_short: String,
    /// Whether the contact is assumed with an error of position and direction, instead of known exactly.
    pub is_assumed: bool,
    csv: &'static str,
    /// Map of the errors by position, direction and force.
    pub map: &'s AccuracyMap,
    /// Cells with their worst force. All situations have the same positions and directions.
    pub cells: Vec<WorstCell>,
}

impl Situation<'_> {
    /// Counts over a region; `region` says whether a position (share of the plate length) and direction (degrees) belong to it.
    pub(super) fn counts(&self, finger: &Finger, region: impl Fn(f64, f64) -> bool) -> TrustCounts {
        let length_mm = finger.plate_length_mm(Plate::Front);
        TrustCounts::of(self.cells.iter().filter(|cell| region(cell.s_mm / length_mm, cell.angle_deg)))
    }

    /// Counts of trusted, refused and other cells over the whole map.
    pub(super) fn all(&self) -> TrustCounts {
        TrustCounts::of(&self.cells)
    }

    /// Share of the answered, untrusted cells in which the wrong direction of an assumed contact causes a larger error than its wrong position, to
    /// first order; `None` if the study explains no such cell.
    pub(super) fn failed_by_direction(&self, study: &Study) -> Option<f64> {
        let by_direction = |cell: &WorstCell| {
            let is_there = |of: &&Explanation| of.s_mm == cell.s_mm && of.angle_deg == cell.angle_deg;
            let [_, direction, position] = study.explanations.cells.iter().find(is_there)?.errors()?;
            Some(direction > position)
        };
        let failed = self.cells.iter().filter(|cell| cell.state == CellState::Answered && !cell.is_trusted);
        let found: Vec<bool> = failed.filter_map(by_direction).collect();
        let by_direction = found.iter().filter(|by_direction| **by_direction).count();
        (!found.is_empty()).then(|| by_direction as f64 / found.len() as f64)
    }

    /// Number of refused noise samples in answered cells, and number of all noise samples in these cells.
    fn refused_samples(&self) -> [usize; 2] {
        let answered = self.map.cells.iter().filter(|cell| cell.state() == CellState::Answered);
        answered.fold([0, 0], |[refused, all], cell| [refused + cell.samples - cell.answered, all + cell.samples])
    }
}

/// All situations: first the one with everything known, then those with errors of the contact or the finger.
pub(super) fn situations<'s>(study: &'s Study) -> Vec<Situation<'s>> {
    let noisy = study.noise_mm > 0.0;
    let mapped = |truth| study.map_by(truth, EstimatorId::Nonlinear, noisy);
    let maps = [mapped(TruthId::Corotational), study.assumed.as_ref(), mapped(TruthId::Twin)];
    let [known, assumed, softer] = maps.map(|map| {
        let map = map?;
        Some(Situation {
            name: "contact known",
            about: "contact and finger known".to_owned(),
            in_words: "contact and finger known".to_owned(),
            in_short: "contact known".to_owned(),
            is_assumed: false,
            csv: CSV,
            map,
            cells: map.worst(),
        })
    });
    let off = format!("{POSITION_OFF_MM} mm and {DIRECTION_OFF_DEG} deg off");
    let assumed = assumed.map(|known| Situation {
        name: "contact assumed",
        about: format!("contact assumed with a wrong position and direction, {off}"),
        in_words: format!("with the contact {off}"),
        in_short: off.clone(),
        is_assumed: true,
        csv: ASSUMED_CSV,
        ..known
    });
    let softer = softer.map(|known| Situation {
        name: "softer ends",
        about:
            "contact known, but base and tip of the finger softer than in its model, as fitted to the paper's Table I"
                .to_owned(),
        in_words: "with base and tip softer than modelled".to_owned(),
        in_short: "base and tip softer than modelled".to_owned(),
        ..known
    });
    [known, assumed, softer].into_iter().flatten().collect()
}

pub(super) fn datasets<'s>(study: &'s Study) -> Vec<Dataset<'s>> {
    let cells = Columns::<(&'static str, WorstCell)>::new()
        .file("case", |(name, _)| *name)
        .file("s_mm", |(_, cell)| cell.s_mm)
        .file("angle_deg", |(_, cell)| cell.angle_deg)
        .file("state", |(_, cell)| cell.state.name())
        .file("worst_error", |(_, cell)| cell.worst_error)
        .file("is_trusted", |(_, cell)| cell.is_trusted);
    let counts = Columns::<Situation>::new()
        .file("case", |of| of.name)
        .file("cells", |of| of.all().cells)
        .file("trusted", |of| of.all().trusted)
        .file("refused", |of| of.all().refused)
        .file("without_equilibrium", |of| of.all().without_equilibrium)
        .file("share_trusted", |of| of.all().share())
        .file("failed_by_direction", |of| of.is_assumed.then(|| of.failed_by_direction(study)).flatten())
        .file("samples_refused_where_answered", |of| of.refused_samples()[0])
        .file("samples_where_answered", |of| of.refused_samples()[1]);
    let found = situations(study);
    let all_cells = found.iter().flat_map(|of| of.cells.iter().map(|cell| (of.name, *cell))).collect::<Vec<_>>();
    let mut all =
        vec![Dataset::new(CSV, &cells, all_cells).csv_alone(), Dataset::new(CSV, &counts, found).summary_alone()];
    all.extend(study.assumed.iter().map(|map| Dataset::records(ASSUMED_CSV, &map.cells).csv_alone()));
    all
}

/// Caption of the drawings.
pub(super) fn caption(study: &Study) -> String {
    let forces_n = list(study.forces.of_maps_n(), ", ");
    format!(
        "The colour shows the worst of the mean errors under {forces_n} N, with the nonlinear estimator. The front \
            plate shows forces along its normal. The fans show all directions, drawn on the side from which the force \
            comes. Green cells are trusted; refused cells (position and direction) are not trusted. Shares count only \
            the cells with an equilibrium."
    )
}

/// Text below the drawing of a situation: its counts.
fn counted(situation: &Situation) -> String {
    let (about, counts) = (capitalised(&situation.about), situation.all());
    let TrustCounts { cells, without_equilibrium, refused, .. } = counts;
    let samples = match situation.refused_samples() {
        [0, _] => String::new(),
        [refused, all] => format!(", and {refused} of {all} noise samples of answered forces"),
    };
    format!("{about}. Refused: {refused} of {cells} cells{samples}. Without equilibrium: {without_equilibrium} cells.")
}

/// One drawing of the finger per situation.
pub(super) fn figures(Results { study, .. }: Results) -> Result<Vec<Figure>, ReportError> {
    situations(study).iter().enumerate().map(|(nth, situation)| figure(study, situation, nth == 0)).collect()
}

fn figure(study: &Study, situation: &Situation, is_first: bool) -> Result<Figure, ReportError> {
    let finger = &study.finger;
    let counts = situation.all();
    let (share, carried) = (counts.share().map_or_else(|| "none".to_owned(), percent), counts.carried());
    let title =
        format!("{}: {share} of {carried} cells within {}", capitalised(situation.name), percent(TRUSTED_ERROR));
    let [front, back, ribs] = at_rest(finger);
    let series = Series::lines("", [back, ribs, front].concat(), Hue::FAINT, 2.2);
    let alt = format!(
        "{title}. The finger is drawn with its base on the left. The front plate is coloured by the error along \
            the normal, the fans by the error in every direction."
    );
    // The situation with everything known is drawn larger, above the others.
    let frame = if is_first { Frame::full(&title, alt) } else { Frame::half(&title, alt) };
    let frame = frame.with_plot_height(if is_first { 400.0 } else { 250.0 });
    let drawn = Chart::to_scale(frame, [ALONG_THE_PLATE, ACROSS_AXIS], series);
    let [x, top] = along_the_plate(finger);
    let chart = Chart { patches: patches(finger, situation), x, top: Some(top), ..drawn };
    Ok(Figure { wide: is_first, ..Figure::wide(chart.svg()?, counted(situation), situation.csv) })
}

/// Axes of the position along the front plate, mm, and of its contact nodes.
fn along_the_plate(finger: &Finger) -> [Axis; 2] {
    let x = |s_mm: f64| finger.plate_point(Plate::Front, s_mm).x;
    let length_mm = finger.plate_length_mm(Plate::Front);
    let positions = plate_ticks(length_mm, 5.0).map(|s_mm| (x(s_mm), s_mm.to_string())).collect();
    let nodes = finger.contact_nodes().filter_map(|node| Some((x(finger.front_position_mm(node)?), node.to_string())));
    [Axis::linear(ALONG_THE_PLATE).named(positions), Axis::linear("node").named(nodes.collect())]
}

/// Areas of the coloured plate and its fans, ordered from the best class to the worst.
fn patches(finger: &Finger, situation: &Situation) -> Vec<Patch> {
    let (positions, angles) = (&situation.map.request.positions_mm, &situation.map.request.angles_deg);
    let length_mm = finger.plate_length_mm(Plate::Front);
    let normal = nearest(angles, 0.0).unwrap_or(0);
    let at = |position: usize, angle: usize| situation.cells.get(position * angles.len() + angle);
    let edges = |positions: &[f64]| -> Vec<f64> {
        let between = positions.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0);
        std::iter::once(0.0).chain(between).chain([length_mm]).collect()
    };
    let across = finger.direction(0.0) * (HALF_WIDTH * length_mm);
    let classes = error_classes();
    let mut painted: Vec<(usize, Patch)> = Vec::new();
    let mut paint = |cell: Option<&WorstCell>, outline| painted.extend(cell.map(|cell| patch(cell, &classes, outline)));
    for (position, ends) in edges(positions).windows(2).enumerate() {
        let [from, to] = [ends[0], ends[1]].map(|s_mm| finger.plate_point(Plate::Front, s_mm));
        let corners = [from - across, to - across, to + across, from + across];
        paint(at(position, normal), corners.iter().map(point).collect());
    }
    let half_deg = angles.windows(2).map(|pair| (pair[1] - pair[0]) / 2.0).next().unwrap_or(5.0);
    let fans = fans(finger);
    let between = fans.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(f64::INFINITY, f64::min);
    let reach_mm = (REACH[0] * between).min(REACH[1] * length_mm);
    for s_mm in fans {
        let Some(position) = nearest(positions, s_mm) else { continue };
        let foot = finger.plate_point(Plate::Front, s_mm) - across;
        for (angle, &angle_deg) in angles.iter().enumerate() {
            let rim = [-1.0, 0.0, 1.0].map(|side| foot - finger.direction(angle_deg + side * half_deg) * reach_mm);
            paint(at(position, angle), std::iter::once(&foot).chain(&rim).map(point).collect());
        }
    }
    painted.sort_by_key(|(class, _)| *class);
    painted.into_iter().map(|(_, patch)| patch).collect()
}

/// Positions of the fans, mm: every n-th contact node from the base, without the node at the tip.
fn fans(finger: &Finger) -> Vec<f64> {
    let nodes: Vec<f64> = finger.contact_nodes().rev().filter_map(|node| finger.front_position_mm(node)).collect();
    let nodes = nodes.split_last().map_or(&[][..], |(_, others)| others);
    nodes.iter().copied().step_by(nodes.len().div_ceil(FANS).max(1)).collect()
}

/// Index of the value that is nearest to `wanted`.
fn nearest(values: &[f64], wanted: f64) -> Option<usize> {
    let distance = |i: &usize| (values[*i] - wanted).abs();
    (0..values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Class rank of a cell (0 is best), and its coloured area.
fn patch(cell: &WorstCell, classes: &[Class], outline: Vec<[f64; 2]>) -> (usize, Patch) {
    let rank = rank_of(cell.state, cell.worst_error);
    (rank, Patch { class: classes[rank].clone(), outline })
}
