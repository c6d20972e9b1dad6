//! What the numbers say, in sentences made from the numbers.

use super::tables::percent;
use super::{causes, contact_scenes, displacement_noise, lattice, networks, speed_error, twin, verdict};
use crate::check::{Check, Kind, Tally, tallies};
use crate::claims::criteria::accounts_for;
use crate::sampling::map::{AccuracyMap, Cell};
use crate::sampling::scatter::{Counts, ScatterRow};
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;
use finray_model::Finger;

/// Where a map is worst among some of its cells.
struct Worst {
    error: f64,
    s_mm: f64,
    angle_deg: f64,
}

fn worst(map: &AccuracyMap, among: impl Fn(&Cell) -> bool) -> Option<Worst> {
    map.cells
        .iter()
        .filter(|cell| among(cell))
        .filter_map(|cell| Some(Worst { error: cell.mean_error?, s_mm: cell.s_mm, angle_deg: cell.angle_deg }))
        .max_by(|a, b| a.error.total_cmp(&b.error))
}

/// The place in words: how far along the plate, and which node is next to it.
fn place(finger: &Finger, s_mm: f64) -> String {
    let distance = |node| finger.front_place_mm(node).map_or(f64::INFINITY, |at: f64| (at - s_mm).abs());
    let nearest = finger.contact_nodes().min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    nearest.map_or_else(|| format!("s = {s_mm:.0} mm"), |node| format!("s = {s_mm:.0} mm, near node {node}"))
}

fn drawn(cell: &Cell) -> bool {
    cell.force_n == DRAWN_FORCE_N
}

/// A sentence, and the section whose numbers say it.
pub(super) struct Finding {
    /// Anchor of the section.
    pub section: &'static str,
    /// The sentence.
    pub sentence: String,
}

/// Every finding, in the order of the page.
pub(super) fn findings(study: &Study) -> Vec<Finding> {
    let of_section =
        |section, sentences: Vec<String>| sentences.into_iter().map(move |sentence| Finding { section, sentence });
    let one = |sentence: Option<String>| sentence.into_iter().collect::<Vec<_>>();
    [
        ("maps", maps(study)),
        ("noise", one(nonlinear(study))),
        ("displacement-noise", one(study.displacement_noise.as_ref().and_then(displacement_noise::words))),
        ("contact-scenes", one(contact_scenes::verdict(study))),
        // At the head of the page stands the largest cause, where causes were sought.
        ("causes", one(causes::verdict(study).and_then(|_| verdict::limit(study)))),
        ("table-one", one(table_one(study))),
        ("twin", one(study.twin.as_ref().map(twin::verdict))),
        ("speed-error", one(speed_error::words(study))),
        ("networks", one(study.networks.as_ref().and_then(networks::words))),
        ("lattice", one(study.lattice.as_ref().and_then(lattice::verdict))),
        ("checks", vec![checks(study)]),
        ("hard-cases", one(hard_cases(study))),
    ]
    .into_iter()
    .flat_map(|(section, sentences)| of_section(section, sentences))
    .collect()
}

/// How many checks pass, those against other programs first and each kind apart.
pub(super) fn checks(study: &Study) -> String {
    let of_kind = |Tally { kind, passed, all }: Tally| match kind {
        Kind::External => format!("{passed} of {all} external checks (figures of another program) pass"),
        Kind::Analytical => format!("{passed} of {all} analytical ones (closed forms, literature)"),
        Kind::Internal => format!("{passed} of {all} internal ones (own other formulation, balance or bound)"),
    };
    let checks: Vec<&Check> = study.all_checks().collect();
    format!("{}.", tallies(checks.into_iter()).map(of_kind).join(", "))
}

/// The same for the page's head, where there is little room.
pub(super) fn checks_in_short(study: &Study) -> String {
    let checks: Vec<&Check> = study.all_checks().collect();
    let of_kind = |Tally { kind, passed, all }: Tally| format!("{} {passed} of {all}", kind.name());
    format!("Checks that pass: {}.", tallies(checks.into_iter()).map(of_kind).join(", "))
}

/// Where linear sensing fails, and what noise adds.
fn maps(study: &Study) -> Vec<String> {
    let mut sentences = Vec::new();
    let finger = &study.finger;
    if let Some(map) = study.map("corotational", false) {
        let summary = map.summary(Some(DRAWN_FORCE_N));
        if let Some(worst) = worst(map, |cell| drawn(cell) && cell.angle_deg == 0.0) {
            sentences.push(format!(
                "Without noise, linear sensing of {DRAWN_FORCE_N} N along the normal of the large-rotation finger errs by \
                 up to {} (at {}); over all places and directions {} of the cells with an equilibrium err by more than 10 % and \
                 {} by more than 25 % ({}).",
                percent(worst.error),
                place(finger, worst.s_mm),
                percent(summary.share_above_10.unwrap_or(f64::NAN)),
                percent(summary.share_above_25.unwrap_or(f64::NAN)),
                summary.counts()
            ));
        }
        if let Some(worst) = worst(map, drawn) {
            sentences.push(format!(
                "Over all directions it fails most at {:.0} deg, at {}: {}.",
                worst.angle_deg,
                place(finger, worst.s_mm),
                percent(worst.error)
            ));
        }
        if summary.without_equilibrium > 0 {
            sentences.push(format!(
                "In {} of {} cells the finger cannot carry {DRAWN_FORCE_N} N: it folds or snaps through before.",
                summary.without_equilibrium, summary.cells
            ));
        }
    }
    if let Some(map) = study.map("linear", true) {
        let smallest = map.request.forces_n.first().copied().unwrap_or(DRAWN_FORCE_N);
        let along_normal = |cell: &Cell| cell.force_n == smallest && cell.angle_deg == 0.0;
        let best = map
            .cells
            .iter()
            .filter(|c| along_normal(c))
            .filter_map(|c| Some((c.mean_error?, c.s_mm)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some(worst), Some(best)) = (worst(map, along_normal), best) {
            sentences.push(format!(
                "Camera noise alone ({} mm a coordinate, linear truth) costs {smallest} N along the normal between {} (at {}) \
                 and {} (at {}).",
                map.noise_mm,
                percent(best.0),
                place(finger, best.1),
                percent(worst.error),
                place(finger, worst.s_mm)
            ));
        }
    }
    sentences
}

/// What the nonlinear estimator makes of noisy pictures.
fn nonlinear(study: &Study) -> Option<String> {
    let noise = study.noise.as_ref()?;
    let of_rows = |rows: &[ScatterRow]| {
        let errors: Vec<f64> = rows.iter().filter_map(ScatterRow::mean_error).collect();
        let low = errors.iter().copied().reduce(f64::min)?;
        Some(format!("{} to {}", percent(low), percent(errors.into_iter().fold(low, f64::max))))
    };
    let pairs = of_rows(&noise.pairs)
        .map_or_else(String::new, |pairs| format!(", two contacts with {pairs} each ({})", Counts::of(&noise.pairs)));
    Some(format!(
        "With {} mm noise the nonlinear estimator senses one contact along the normal with a mean error of {} ({}){pairs}, by \
         its position.",
        noise.noise_mm,
        of_rows(&noise.single)?,
        Counts::of(&noise.single)
    ))
}

/// Which promises of the hard cases are broken.
fn hard_cases(study: &Study) -> Option<String> {
    let broken: Vec<&str> = study.hard_cases.iter().filter(|case| !case.kept()).map(|case| case.case).collect();
    match (&study.hard_cases[..], &broken[..]) {
        ([], _) => None,
        (all, []) => Some(format!("All {} hard cases are answered soundly or refused with a reason.", all.len())),
        (all, broken) => {
            Some(format!("{} of {} hard cases break their promise: {}.", broken.len(), all.len(), broken.join("; ")))
        }
    }
}

/// How much of the paper's large errors in Table I geometric nonlinearity gives.
fn table_one(study: &Study) -> Option<String> {
    let table = study.tables_one.first()?;
    let large = table.rows.iter().filter(|row| row.paper_mean_error > 0.10);
    let (most, less): (Vec<_>, Vec<_>) = large.partition(|row| accounts_for(&[(row.mean_error, row.paper_mean_error)]));
    let list = |rows: &[&crate::experiments::table_one::TableOneRow]| {
        let items: Vec<_> = rows
            .iter()
            .map(|row| {
                format!("node {} (paper {}, ours {})", row.node, percent(row.paper_mean_error), percent(row.mean_error))
            })
            .collect();
        items.join(", ")
    };
    let head = "In simulation, geometric nonlinearity alone gives";
    Some(match (&most[..], &less[..]) {
        ([], less) => format!(
            "{head} less than half of the paper's large errors in Table I: {}. What else causes them is not found out here.",
            list(less)
        ),
        (most, []) => format!("{head} most of the paper's large errors in Table I: {}.", list(most)),
        (most, less) => format!(
            "{head} most of the paper's large errors in Table I at {}, less than half at {}.",
            list(most),
            list(less)
        ),
    })
}
