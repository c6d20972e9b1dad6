//! Checks against other programs, analytical solutions and internal references, and comparisons whose difference is expected.

use super::format::{percent, verdict};
use crate::prelude::*;
use finray_studies::check::{Kind, Tally, tallies};
use finray_studies::experiments::continuum::{Constants, ContinuumStudy, LARGEST_FORCE_N};
use finray_studies::problems::opensees::verified_features;

const CSV: &str = "checks.csv";
const COMPARISONS_CSV: &str = "comparisons.csv";
const ABOUT: &str = "External checks compare with other programs: OpenSees and MuJoCo, with separate models. Analytical checks use closed forms, \
                     theoretical orders of convergence, and solutions from the literature. Internal checks use our second formulation (among them \
                     the spring lattice, which rapier2d brings to equilibrium), an inverse, a balance or a bound. All checks \
                     use the EA and EI of the beams, so they verify solvers and kinematics. Material and joints of a real finger are not verified \
                     here.";
/// Text for a finger that no program solved as a continuum.
const NO_CONTINUUM: &str =
    "Beam theory is not verified here either, because this finger was not solved as a continuum.";
/// Text on the first page for a finger that no program solved as a continuum. The text names the guide that states the errors for other fingers.
const NO_CONTINUUM_IN_SHORT: &str = "This finger was not solved as a continuum. The guide \"your-finger\" states the error of beam theory on other fingers.";
/// Text on the checks that exist only for the paper's finger, and on those that other fingers share.
const OF_ANOTHER_FINGER: &str = "Reference values of other programs for the finger itself, the paper's Table I, the spring lattice and the hard \
                                 cases exist only for the paper's finger. Features of this finger that OpenSees verified on other fingers:";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, &study.checks), Dataset::records(COMPARISONS_CSV, &study.comparisons)]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let mut blocks = Vec::new();
    if !study.is_paper {
        blocks.push(text(format!("{OF_ANOTHER_FINGER} {}", features(study))));
    }
    blocks.push(text(format!("{ABOUT} {}", beam_theory(&study.continuum))));
    blocks.extend(disagreements(study)?.map(Block::Figure));
    let tables = [by_source(&study.checks), files()];
    blocks.push(details("Checks by source", tables.map(Block::Table).into()));
    Ok(Some(Section::new("checks", "Cross-checks", blocks).saying([in_words(study)])))
}

/// Text on the features of an own finger that external checks cover on other fingers, and on those that they do not cover.
fn features(study: &Study) -> String {
    let list = |features: Vec<&str>| if features.is_empty() { "none".to_owned() } else { features.join(", ") };
    let [verified, not] = verified_features(&study.finger).map(list);
    format!("{verified}. No other program verified: {not}.")
}

/// Text on what beam theory neglects, and on the load under which the beam model errs most, from the comparison with a plane continuum.
fn beam_theory(continuum: &ContinuumStudy) -> String {
    let of = |constants| continuum.of(constants);
    let (Some(modulus), Some(arms)) = (of(Constants::Modulus), of(Constants::ArmsAndShear)) else {
        return NO_CONTINUUM.to_owned();
    };
    format!(
        "A plane continuum solved by CalculiX shows what beam theory neglects ({COMPARISONS_CSV}; not counted as a \
            check). The comparison covers {} forces up to {LARGEST_FORCE_N} N, not on the tip. Beams with Young's \
            modulus alone move {:.2} times as far (median). With Poisson's ratio, rigid arms at the rods and shear, \
            the beams differ by {} of the largest displacement (median), and by {} at most: at node {}, with the force \
            on node {}.",
        arms.cases,
        modulus.scale,
        percent(arms.median),
        percent(arms.worst),
        arms.node,
        arms.load
    )
}

/// Two sentences for the first page: how much beams differ from a continuum, and under which force they differ most.
pub(super) fn beam_theory_in_short(study: &Study) -> String {
    let of = |constants| study.continuum.of(constants);
    let (Some(modulus), Some(best)) = (of(Constants::Modulus), of(Constants::ArmsAndShear)) else {
        return NO_CONTINUUM_IN_SHORT.to_owned();
    };
    format!(
        "Beams with Young's modulus alone move {:.1} times as far as a continuum. With Poisson's ratio, rod arms and shear, the beams differ by {} \
         of the largest displacement (median; at most {}, under a force {} mm from the base of the {} mm plate).",
        modulus.scale,
        percent(best.median),
        percent(best.worst),
        study.finger.front_position_mm(NodeId(best.load)).unwrap_or_default().round(),
        study.finger.plate_length_mm(Plate::Front).round()
    )
}

/// Table of the files that contain each check with its numbers.
fn files() -> Table {
    let checks = [CSV, "every check: reference, our figure, tolerance"];
    Columns::<[&str; 2]>::new()
        .cells("file", Format::Words, |[file, _]| Cell::file(*file))
        .page("holds", Format::Words, |[_, holds]| *holds)
        .table("One by one", CSV, [checks, [COMPARISONS_CSV, "comparisons in which a difference is expected"]])
}

/// Sentence with the numbers of passed checks by kind of reference, first those against other programs.
fn in_words(study: &Study) -> String {
    let about = |kind: Kind| match kind {
        Kind::External => "external checks (OpenSees, MuJoCo)",
        Kind::Analytical => "analytical checks (closed forms, literature)",
        Kind::Internal => "internal checks (our second formulation, a balance or a bound)",
    };
    let counted = counted(study);
    let parts = counted.iter().map(|Tally { kind, passed, all }| format!("{passed} of {all} {}", about(*kind)));
    format!("Checks that pass: {}.", parts.collect::<Vec<_>>().join(", "))
}

/// Checks counted by kind of reference.
pub(super) fn counted(study: &Study) -> Vec<Tally> {
    tallies(study.checks.iter())
}

/// A disagreement of 0 is drawn at this value, because a logarithmic axis has no 0.
const LAST_BIT: f64 = f64::EPSILON;

/// Figure of the relative disagreement with each independent reference, one point per check.
fn disagreements(study: &Study) -> Result<Option<Figure>, FigureError> {
    let mut found: Vec<(Kind, &str, f64)> =
        study.checks.iter().filter_map(|check| Some((check.kind, &*check.source, check.disagreement?))).collect();
    found.sort_by_key(|(kind, source, _)| (*kind, *source));
    let mut sources: Vec<&str> = found.iter().map(|(_, source, _)| *source).collect();
    sources.dedup();
    if sources.is_empty() {
        return Ok(None);
    }
    // The order is reversed, because rows of a figure are numbered from the bottom.
    sources.reverse();
    let row = |of: &str| sources.iter().position(|source| *source == of).unwrap_or(0) as f64;
    let of_kind = |kind: Kind| {
        let at = found.iter().filter(move |(of, ..)| *of == kind);
        (kind.name(), at.map(|(_, source, off)| [off.max(LAST_BIT), row(source)]).collect::<Vec<Point>>())
    };
    let groups = [Kind::External, Kind::Analytical].map(of_kind);
    let series = groups.into_iter().filter(|(_, points)| !points.is_empty()).enumerate();
    let series = series.map(|(n, (name, points))| Series { dash: Dash::None, ..Series::nth(n, name, points) });
    let axes = [
        Axis::log("difference / reference").within(LAST_BIT / 2.0, 1.0),
        Axis::categories("reference", sources.iter().map(|source| (*source).to_owned()).collect()),
    ];
    let alt =
        "Relative disagreement of every external and analytical check, one row per reference, on a logarithmic axis.";
    let frame = Frame::full("Disagreement with each independent reference", alt);
    let height = 30.0 * sources.len() as f64;
    let svg = Chart::new(frame.with_plot_height(height), axes, series.collect()).svg()?;
    let caption = "One symbol per check. If the reference is 0, the difference is relative to the largest displacement or in \
        radians. Checks of error terms compare orders of convergence. A symbol at the left edge means equality to the \
        last bit.";
    Ok(Some(Figure::wide(svg, caption, CSV)))
}

/// Table of the checks: one row per reference, grouped by kind, with the largest difference relative to its tolerance.
fn by_source(checks: &[Check]) -> Table {
    type Source<'c> = (Kind, &'c str);
    let mut sources: Vec<Source> = Vec::new();
    for check in checks {
        if !sources.contains(&(check.kind, &check.source)) {
            sources.push((check.kind, &check.source));
        }
    }
    sources.sort_by_key(|(kind, _)| *kind);
    let of = |source: &Source| {
        let found = checks.iter().filter(|check| (check.kind, check.source.as_str()) == *source);
        found.collect::<Vec<_>>()
    };
    let share = |check: &Check| (check.ours - check.reference).abs() / check.tolerance;
    Columns::new()
        .page("kind", Format::Words, |(kind, _): &Source| kind.name())
        .page("source", Format::Words, |(_, source)| *source)
        .page("checks", Format::Plain, |source| of(source).len())
        .page("largest difference / tolerance", Format::Percent, |source| worst(of(source).into_iter().map(share)))
        .cells("verdict", Format::Words, |source| verdict(of(source).into_iter().all(Check::passes), ["pass", "fail"]))
        .table("Checks by kind and by source of the reference value", CSV, sources)
}
