//! First screen: drawings, shares and files that show where a force can be trusted. In each cell the force with the largest error counts.

use super::drawings::{ACROSS_AXIS, ALONG_THE_PLATE, at_rest, error_classes, plate_ticks, point, rank_of};
use super::format::{capitalised, list, percent};
use super::maps::map_csv_name;
use crate::prelude::*;
use finray_figures::Patch;
use finray_studies::experiments::explain::Explanation;
use finray_studies::sampling::situation::ContactKnowledge;
use finray_studies::sampling::trust::{WeighedShare, WorstCell};
use finray_studies::settings::{DIRECTION_OFF_DEG, FRICTION_MAX, POSITION_OFF_MM};

/// File with the cells of all situations.
pub(super) const CSV: &str = "trust.csv";
/// Largest number of contact nodes at which the drawing has a fan of all directions.
const FANS: usize = 6;
/// Two upper limits of the length of a fan's rays: a share of the distance between fans, and a share of the plate length. The smaller limit applies.
const REACH: [f64; 2] = [0.48, 0.1];
/// Half the width of the coloured plate in the drawing, as a share of the plate length.
const HALF_WIDTH: f64 = 0.012;

/// A situation in which the recommended estimator is evaluated.
pub(super) struct Situation<'s> {
    /// Name in files, headings and sentences: what is known and seen.
    pub name: String,
    /// Whether the contact is assumed with an error of position and direction.
    pub is_misjudged: bool,
    csv: String,
    /// Map of the errors by position, direction and force.
    pub map: &'s AccuracyMap,
    /// Cells with their worst force.
    pub cells: Vec<WorstCell>,
}

impl Situation<'_> {
    /// The trusted share of a region; `region` says whether a position (share of the plate length) and direction (degrees) belong to it.
    pub(super) fn trust_in(&self, finger: &Finger, region: impl Fn(f64, f64) -> bool) -> TrustShare {
        let length_mm = finger.plate_length_mm(Plate::Front);
        TrustShare::of(self.cells.iter().filter(|cell| region(cell.s_mm / length_mm, cell.angle_deg)))
    }

    /// The trusted share of the whole map.
    pub(super) fn trust(&self) -> TrustShare {
        TrustShare::of(&self.cells)
    }

    /// The trusted share after weighing the finger, if the uncertain modulus reduces the share.
    pub(super) fn weighed(&self, study: &Study) -> Option<WeighedShare> {
        self.map.weighed(&study.finger, study.stiffness_error)
    }

    /// The trusted share in words, with the modulus as its cause where it is one.
    pub(super) fn in_words(&self, study: &Study) -> String {
        let share = self.trust().share().map_or_else(|| "no equilibrium".to_owned(), percent);
        self.weighed(study).map_or_else(|| share.clone(), |weighed| format!("{share}: {weighed}"))
    }

    /// What limits most of the untrusted part of the map: refusals, the modulus, camera noise or the model's error; `None` if all is trusted.
    pub(super) fn limit(&self, study: &Study) -> Option<&'static str> {
        let trust = self.trust();
        let untrusted = trust.carried - trust.trusted;
        if untrusted <= 0.0 {
            return None;
        }
        let weighed = self.weighed(study).map_or(0.0, |weighed| weighed.share * trust.carried - trust.trusted);
        let failed = (untrusted - trust.refused - weighed).max(0.0);
        let (cells, by_noise) = self.failures();
        let by_noise = failed * by_noise as f64 / cells.len().max(1) as f64;
        let causes = [
            (by_noise, "camera noise"),
            (trust.refused, "refusals of ambiguous contacts"),
            (weighed, "the uncertain modulus"),
            (failed - by_noise, "error of the model"),
        ];
        // Of equal causes, the first counts.
        let largest = causes.into_iter().reduce(|most, next| if next.0 > most.0 { next } else { most })?;
        Some(largest.1)
    }

    /// The answered cells of the map whose error is above the trusted limit, and the number of these cells in which the spread due to noise exceeds
    /// the bias.
    pub(super) fn failures(&self) -> (Vec<&MapCell>, usize) {
        let is_wrong =
            |cell: &&MapCell| cell.state() == CellState::Answered && cell.is_above(TRUSTED_ERROR) == Some(true);
        let failed: Vec<&MapCell> = self.map.cells.iter().filter(is_wrong).collect();
        let by_noise = failed.iter().filter(|cell| cell.spread > cell.bias.map(f64::abs)).count();
        (failed, by_noise)
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
}

/// All situations, the unknown contact first; then the known contact, and the known contact on a finger that is softer than its model.
pub(super) fn situations<'s>(study: &'s Study) -> Vec<Situation<'s>> {
    let of_map = |map: &'s AccuracyMap| Situation {
        name: map.situation.to_string(),
        is_misjudged: map.situation.contact == ContactKnowledge::Misjudged,
        csv: map_csv_name(map),
        map,
        cells: map.worst(&study.finger),
    };
    let softer = study.map_by(TruthId::Twin, EstimatorId::Nonlinear, study.noise_mm > 0.0);
    let softer = softer.map(|map| Situation { name: SOFTER.to_owned(), csv: map_csv_name(map), ..of_map(map) });
    study.situations.iter().map(of_map).chain(known(study).map(of_map)).chain(softer).collect()
}

/// Name of the situation on the finger with softer ends.
pub(super) const SOFTER: &str = "contact known, base and tip softer than modelled";

/// The map of the known contact.
fn known(study: &Study) -> Option<&AccuracyMap> {
    study.map_by(TruthId::Corotational, EstimatorId::Nonlinear, study.noise_mm > 0.0)
}

/// The situation with a known contact, if there is one.
pub(super) fn of_known<'a, 's>(study: &Study, all: &'a [Situation<'s>]) -> Option<&'a Situation<'s>> {
    let map = known(study)?;
    all.iter().find(|situation| std::ptr::eq(situation.map, map))
}

pub(super) fn datasets<'s>(study: &'s Study) -> Vec<Dataset<'s>> {
    let cells = Columns::<(String, WorstCell)>::new()
        .file("case", |(name, _)| name.clone())
        .file("s_mm", |(_, cell)| cell.s_mm)
        .file("angle_deg", |(_, cell)| cell.angle_deg)
        .file("state", |(_, cell)| cell.state.name())
        .file("worst_error", |(_, cell)| cell.worst_error)
        .file("is_trusted", |(_, cell)| cell.is_trusted)
        .file("refused_samples", |(_, cell)| cell.refused_samples)
        .file("warned_samples", |(_, cell)| cell.warned_samples)
        .file("weight_mm_deg", |(_, cell)| cell.weight);
    let samples = |of: &Situation, i: usize| of.trust().samples().map(|shares| shares[i]);
    let shares = Columns::<Situation>::new()
        .file("case", |of| of.name.clone())
        .file("cells", |of| of.trust().cells)
        .file("without_equilibrium", |of| of.trust().without_equilibrium)
        .file("share_trusted", |of| of.trust().share())
        .file("share_refused", |of| of.trust().refused_share())
        .file("share_of_samples_refused", move |of| samples(of, 0))
        .file("share_of_samples_warned", move |of| samples(of, 1))
        .file("failed_by_direction", |of| of.is_misjudged.then(|| of.failed_by_direction(study)).flatten());
    let found = situations(study);
    let all_cells =
        found.iter().flat_map(|of| of.cells.iter().map(|cell| (of.name.clone(), *cell))).collect::<Vec<_>>();
    let mut all =
        vec![Dataset::new(CSV, &cells, all_cells).csv_alone(), Dataset::new(CSV, &shares, found).summary_alone()];
    all.extend(study.situations.iter().map(|map| Dataset::records(&map_csv_name(map), &map.cells).csv_alone()));
    all
}

/// Caption of the drawings.
pub(super) fn caption(study: &Study) -> String {
    let forces_n = list(study.forces.of_maps_n(), ", ");
    let [limit, misjudged] = [percent(TRUSTED_ERROR), format!("{POSITION_OFF_MM} mm and {DIRECTION_OFF_DEG} deg")];
    format!(
        "Share: part of the plate's length and of the directions that friction allows in which the mean error of the nonlinear estimator is within {limit} \
         under each of {forces_n} N. A force that is mostly refused is not within it. Friction allows directions up to {:.0} deg from the normal (a \
         coefficient of {FRICTION_MAX}), or a known range. Directions count from the normal of the bent plate; with a known or misjudged contact, from the \
         undeformed normal. Colour: the largest error. The plate shows forces along its normal; the fans show all directions on the side from which the \
         force comes. Hidden at the object: a third of the front plate. Misjudged: {misjudged} off. \
         `--quick` has the same forces, but coarser grids.",
        FRICTION_MAX.atan().to_degrees()
    )
}

/// Text below the drawing of a situation: refusals, warnings, and cells without equilibrium.
fn counted(situation: &Situation) -> String {
    let trust = situation.trust();
    let samples = trust.samples().map_or_else(String::new, |shares| {
        let [refused, warned] = shares.map(percent);
        format!("Noise samples: {refused} refused, {warned} with a warning.")
    });
    match trust.without_equilibrium {
        0 => samples,
        without => format!("{samples} Without equilibrium: {without} of {} cells.", trust.cells),
    }
}

/// One drawing of the finger per situation.
pub(super) fn figures(Results { study, .. }: Results) -> Result<Vec<Figure>, ReportError> {
    situations(study).iter().enumerate().map(|(nth, situation)| figure(study, situation, nth == 0)).collect()
}

fn figure(study: &Study, situation: &Situation, is_first: bool) -> Result<Figure, ReportError> {
    let finger = &study.finger;
    let title = format!("{}: {}", capitalised(&situation.name), situation.in_words(study));
    let [front, back, ribs] = at_rest(finger);
    let series = Series::lines("", [back, ribs, front].concat(), Hue::FAINT, 2.2);
    let alt = format!(
        "{title} trusted. The finger is drawn with its base on the left. The front plate is coloured by the error along \
            the normal, the fans by the error in every direction."
    );
    // The unknown contact is drawn larger, above the others.
    let frame = if is_first { Frame::full(&title, alt) } else { Frame::half(&title, alt) };
    let frame = frame.with_plot_height(if is_first { 400.0 } else { 250.0 });
    let drawn = Chart::to_scale(frame, [ALONG_THE_PLATE, ACROSS_AXIS], series);
    let [x, top] = along_the_plate(finger);
    let chart = Chart { patches: patches(finger, situation), x, top: Some(top), ..drawn };
    Ok(Figure { wide: is_first, ..Figure::wide(chart.svg()?, counted(situation), &situation.csv) })
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
