//! The digital twin of Table I: one of several fingers that are fitted to the table, and what sensing gains from knowing it.

use super::ReportError;
use super::drawings::{PAPER_SHADES_PERCENT, percent_line};
use super::page::{Block, Cell, Column, Figure, Row, Section, Table};
use super::sections::{self, text};
use super::tables::{error, figure, percent};
use crate::claims::criteria::TPU_MPA;
use crate::experiments::table_one::{TableOne, TableOneRow};
use crate::experiments::twin::fit::TwinFit;
use crate::experiments::twin::moduli_mpa;
use crate::experiments::twin::study::{LOADED, TwinSensing, TwinStudy};
use crate::figures::{Axis, Bars, Chart, FigureError, Frame, Hue};
use crate::study::Study;
use serde::Serialize;

pub(super) const CSV: &str = "twin.csv";
pub(super) const SETS_CSV: &str = "twin_zone_sets.csv";
pub(super) const CALIBRATION_CSV: &str = "twin_calibration.csv";
/// A set of zones whose misfit is below this comes as near to Table I as its figures are known.
const FITS: f64 = 1.0;

/// One contact node.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TwinRow {
    /// The node.
    pub node: usize,
    /// The paper's mean error, at the nodes of Table I; likewise the next four.
    pub paper_mean_error: Option<f64>,
    /// On the uniform finger, weights and uniform model of Table I, no noise.
    pub uniform_finger: Option<f64>,
    /// On the twin, weights and uniform model of Table I, no noise.
    pub twin: Option<f64>,
    /// Smallest of sensed / true - 1 over the weights, on the twin.
    pub twin_lowest: Option<f64>,
    /// Largest of sensed / true - 1 over the weights, on the twin.
    pub twin_highest: Option<f64>,
    /// Random forces on the twin with noise, least squares with the uniform model.
    pub noisy_uniform_model: Option<f64>,
    /// The same with the calibrated zones in the model.
    pub noisy_zones_least_squares: Option<f64>,
    /// The nonlinear estimator with the calibrated zones in the model.
    pub noisy_zones_nonlinear: Option<f64>,
    /// Mean error of an estimator that reaches the Cramer-Rao bound.
    pub bound: Option<f64>,
}

/// One group of zones of a set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ZoneSetRow {
    /// The set.
    pub zones: &'static str,
    /// The group, from 1.
    pub group: usize,
    /// Its fitted factor.
    pub factor: f64,
    /// Its standard deviation, taking the six errors for independent measurements.
    pub sigma: f64,
    /// Misfit of the set, below 1 where it fits.
    pub misfit: f64,
    /// Fitted modulus outside the zones over the published one.
    pub modulus_factor: f64,
}

/// One factor in one repetition of the calibration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CalibrationRow {
    /// The repetition, from 1.
    pub repetition: usize,
    /// What is sought.
    pub parameter: String,
    /// Found over true.
    pub found_over_true: f64,
    /// Stated standard deviation of that.
    pub sigma: f64,
}

pub(super) fn rows(study: &TwinStudy) -> Vec<TwinRow> {
    fn of_node(table: &TableOne, node: usize) -> Option<&TableOneRow> {
        table.rows.iter().find(|row| row.node == node)
    }
    let row = |sensing: &TwinSensing| {
        let (before, after) = (of_node(&study.before, sensing.node), of_node(&study.after, sensing.node));
        TwinRow {
            node: sensing.node,
            paper_mean_error: after.map(|row| row.paper_mean_error),
            uniform_finger: before.map(|row| row.mean_error),
            twin: after.map(|row| row.mean_error),
            twin_lowest: after.and_then(|row| row.errors.iter().copied().reduce(f64::min)),
            twin_highest: after.and_then(|row| row.errors.iter().copied().reduce(f64::max)),
            noisy_uniform_model: sensing.uniform.mean_error(),
            noisy_zones_least_squares: sensing.linear.mean_error(),
            noisy_zones_nonlinear: sensing.nonlinear.mean_error(),
            bound: sensing.nonlinear.mean_error_bound(),
        }
    };
    study.sensing.iter().map(row).collect()
}

pub(super) fn set_rows(study: &TwinStudy) -> Vec<ZoneSetRow> {
    let of_fit = |fit: &TwinFit| {
        let (zones, misfit, modulus_factor) = (fit.set.name, fit.misfit, fit.modulus_factor);
        let groups = fit.factors.iter().zip(&fit.sigmas).enumerate();
        let rows = groups.map(move |(i, (&factor, &sigma))| ZoneSetRow {
            zones,
            group: i + 1,
            factor,
            sigma,
            misfit,
            modulus_factor,
        });
        rows.collect::<Vec<_>>()
    };
    study.fits.iter().flat_map(of_fit).collect()
}

pub(super) fn calibration_rows(study: &TwinStudy) -> Vec<CalibrationRow> {
    let of_one = |(i, found): (usize, &finray_model::calibration::FactorEstimate)| {
        let factors = found.factors.iter().zip(&found.relative_sigmas).zip(&found.unknowns);
        let rows = factors.map(|((&factor, relative), unknown)| CalibrationRow {
            repetition: i + 1,
            parameter: unknown.to_string(),
            found_over_true: factor,
            sigma: factor * relative,
        });
        rows.collect::<Vec<_>>()
    };
    study.calibrations.iter().enumerate().flat_map(of_one).collect()
}

/// What the twin is, in a sentence or two: a fit, its freedom, and how far its moduli are from the material's.
pub(super) fn verdict(study: &TwinStudy) -> String {
    let large: Vec<_> = (study.after.rows.iter().filter(|row| row.paper_mean_error > 0.10))
        .map(|row| format!("node {} {} (paper {})", row.node, percent(row.mean_error), percent(row.paper_mean_error)))
        .collect();
    format!(
        "A fit, not a finding: a simulated finger that was given softer zones at base and tip errs as Table I has it: {}. {} {} Material, \
         hysteresis and what else the paper did not publish are not in it.",
        large.join(", "),
        freedom_in_words(&study.fits),
        moduli_in_words(&moduli_mpa(&study.finger)),
    )
}

/// How many numbers are fitted to how many, and which other sets of zones do as well or better.
fn freedom_in_words(fits: &[TwinFit]) -> String {
    let Some((own, others)) = fits.split_first() else { return String::new() };
    // The modulus outside the zones is fitted, too.
    let parameters = format!(
        "Its {} parameters, {} factors of zones and the modulus outside, are fitted to six means and the calibrated modulus",
        own.factors.len() + 1,
        own.factors.len()
    );
    let fitting = others.iter().filter(|fit| fit.misfit < FITS).count();
    let better: Vec<&str> = others.iter().filter(|fit| fit.misfit < own.misfit).map(|fit| fit.set.name).collect();
    match (others.len(), better.len()) {
        (0, _) => format!("{parameters}; other sets of zones were not fitted this time."),
        (tried, 0) => {
            format!("{parameters}; of {tried} other sets of zones {fitting} fit as well as the figures are known.")
        }
        (tried, _) => format!(
            "{parameters}; of {tried} other sets of zones {fitting} fit as well as the figures are known, and {} better than this one.",
            better.join("; ")
        ),
    }
}

/// The zones' moduli against those that the paper quotes for its material.
fn moduli_in_words(moduli: &[f64]) -> String {
    let [least, most] = TPU_MPA;
    let listed = |moduli: &[f64]| {
        let mut words: Vec<String> = Vec::new();
        for modulus in moduli.iter().map(|modulus| format!("{modulus:.1}")) {
            if !words.contains(&modulus) {
                words.push(modulus);
            }
        }
        words.join(", ")
    };
    let outside: Vec<f64> = moduli.iter().copied().filter(|modulus| !(least..=most).contains(modulus)).collect();
    match outside.len() {
        0 => format!(
            "The zones have {} MPa, within the {least} to {most} MPa that the paper quotes for TPU.",
            listed(moduli)
        ),
        _ => format!(
            "Of the zones' moduli ({} MPa) {} MPa lie outside the {least} to {most} MPa that the paper quotes for TPU.",
            listed(moduli),
            listed(&outside)
        ),
    }
}

pub(super) fn section(study: &Study) -> Result<Option<Section>, ReportError> {
    let Some(twin) = &study.twin else { return Ok(None) };
    let mut blocks = vec![
        text(
            "The paper infers from its errors that the modulus \"at the tip and base should be lower\", and leaves it there. \
             Here a simulated finger is given zones of lower modulus, front and back plate alike; \
             their factors are fitted to the six published mean errors, and the modulus outside so that the paper's own \
             calibration finds the published one. Sensed too large, by the paper's text, are nodes 14, 16 and 24; at 18 to 22 \
             the signs are not published, and zero is fitted, give or take 3 %. The weights are assumed to pull along the \
             normal. That soft ends err so was put in; it is not found out by it. The result ships as the scene twin.toml and as finray \
             map --truth twin.",
        ),
        text(fit_words(twin)),
        Block::Figure(Figure {
            svg: drawing(twin)?,
            caption: format!(
                "Mean error by loaded node. First three: the protocol of Table I, without noise. Last two: random forces of \
                 0.5 to 3 N on the twin with {} mm noise, the zones in the model calibrated from noise samples.",
                twin.noise_mm
            ),
            csv: Some(CSV.to_owned()),
            wide: true,
        }),
        Block::Table(table(twin)),
        text(calibration_words(twin)),
        Block::Table(calibration_table(twin)),
    ];
    blocks.push(text(spread_words(twin)));
    blocks.push(Block::Table(sets_table(twin)));
    Ok(Some(sections::section("twin", "One fit of Table I: a digital twin", blocks)))
}

/// How far the fit determines the zones.
fn fit_words(study: &TwinStudy) -> String {
    let Some(own) = study.fits.first() else { return String::new() };
    let factors: Vec<_> = own.factors.iter().zip(&own.sigmas).map(|(f, s)| format!("{f:.3} +- {s:.3}")).collect();
    let others = &study.fits[1..];
    let as_well: Vec<_> = others.iter().filter(|fit| fit.misfit < FITS).map(|fit| fit.set.name).collect();
    let rest = match (others.len(), as_well.len()) {
        (0, _) => String::new(),
        (tried, 0) => format!(" None of {tried} other sets of zones fits."),
        (tried, found) => format!(
            " It is not the only answer: of {tried} other sets of zones that were tried, {found} fit within the uncertainty of the figures \
             ({}). Within this family of fits the table asks for lower stiffness at the base and in the third next to the tip; it does not \
             say in which plate, in plates or ribs, or how it is spread, and no other cause was fitted.",
            as_well.join("; ")
        ),
    };
    format!(
        "Three factors and the modulus outside, four parameters, from six means and the calibrated modulus: {} (base, before the tip, tip; \
         the deviations take the six means for independent measurements), modulus outside {} of the published one; root mean square misfit {:.2} of what the numbers may be off \
         (2 % at 14, 16 and 24, 3 % at 18 to 22).{rest}",
        factors.join(", "),
        percent(own.modulus_factor),
        own.misfit
    )
}

/// Whether the errors depend on the load.
fn spread_words(study: &TwinStudy) -> String {
    let spans: Vec<_> = rows(study)
        .iter()
        .filter_map(|row| {
            let [lowest, highest] = [row.twin_lowest?, row.twin_highest?].map(|error| 100.0 * error);
            Some(format!("{lowest:.0} to {highest:.0} % at {}", row.node))
        })
        .collect();
    format!(
        "Over the six weights the errors on the twin run from {}; the paper has 49.6 to 63.7 % at 14, at most 18 % at 16, \
         below 5 % at 18 to 22 and at most 24.2 % at 24. These ranges were not fitted.",
        spans.join(", ")
    )
}

fn calibration_words(study: &TwinStudy) -> String {
    let Some(first) = study.calibrations.first() else { return String::new() };
    let entangled = match first.entangled().len() {
        0 => "No two of them are entangled: no correlation reaches 0.95".to_owned(),
        pairs => format!("{pairs} pairs of them are strongly correlated (0.95 or more)"),
    };
    format!(
        "Such zones can be found on a real finger by hanging weights on it: finray calibrate --zones. From one noise sample \
         ({} mm) of the twin for each of six weights at nodes {}, {} repetitions find the factors again. \
         {entangled}. Over all repetitions the root mean square of error over stated sigma is {:.2} (1 is meant).",
        study.noise_mm,
        LOADED.map(|node| node.to_string()).join(", "),
        study.calibrations.len(),
        study.rms_over_sigma()
    )
}

fn drawing(study: &TwinStudy) -> Result<String, FigureError> {
    let rows = rows(study);
    let rounded = |error: f64| (1000.0 * error).round() / 10.0;
    let group = |label: &str, hue, of: fn(&TwinRow) -> Option<f64>| Bars {
        label: label.to_owned(),
        hue,
        values: rows.iter().map(|row| of(row).map(rounded)).collect(),
    };
    let alt = "Mean error by node: the paper's, the uniform finger, the twin, and with its zones known.";
    let nodes = Axis::categories("loaded node", rows.iter().map(|row| row.node.to_string()).collect());
    let bars = vec![
        group("paper", Hue::Neutral, |row| row.paper_mean_error),
        group("uniform finger", Hue::nth(0), |row| row.uniform_finger),
        group("twin", Hue::nth(1), |row| row.twin),
        group("zones known, linear", Hue::nth(2), |row| row.noisy_zones_least_squares),
        group("zones known, nonlinear", Hue::nth(3), |row| row.noisy_zones_nonlinear),
    ];
    let chart = Chart::of_bars(Frame::full("", alt), [nodes, Axis::linear("mean error, %")], bars);
    chart.compared(PAPER_SHADES_PERCENT.map(percent_line)).svg()
}

fn table(study: &TwinStudy) -> Table {
    let cell = |share: Option<f64>| share.map_or(Cell::plain("-"), error);
    let rows = rows(study).into_iter().map(|row| {
        let shares = [
            row.paper_mean_error,
            row.uniform_finger,
            row.twin,
            row.noisy_uniform_model,
            row.noisy_zones_least_squares,
            row.noisy_zones_nonlinear,
            row.bound,
        ];
        Row { cells: [Cell::plain(row.node.to_string())].into_iter().chain(shares.map(cell)).collect() }
    });
    let columns = ["node", "paper", "before", "after", "uniform model", "zones, linear", "zones, nonlinear", "bound"];
    Table {
        caption:
            "Mean error by loaded node; grey above 10 %, dark above 25 %. Before and after: weights of Table I \
                  on the uniform finger and on the twin, both sensed with the uniform model. Then the twin under random forces \
                  with noise, by model and estimator"
                .to_owned(),
        columns: columns.map(Column::numbers).into(),
        rows: rows.collect(),
        csv: Some(CSV.to_owned()),
    }
}

/// The first repetition.
fn calibration_table(study: &TwinStudy) -> Table {
    let rows = calibration_rows(study).into_iter().filter(|row| row.repetition == 1).map(|row| {
        let numbers = [format!("{:.4}", row.found_over_true), format!("{:.4}", row.sigma)];
        Row { cells: std::iter::once(row.parameter).chain(numbers).map(Cell::plain).collect() }
    });
    Table {
        caption:
            "The twin's factors as calibrated from noise samples, over the true ones; the file has all repetitions"
                .to_owned(),
        columns: std::iter::once(Column::words("parameter"))
            .chain(["found / true", "stated sigma"].map(Column::numbers))
            .collect(),
        rows: rows.collect(),
        csv: Some(CALIBRATION_CSV.to_owned()),
    }
}

fn sets_table(study: &TwinStudy) -> Table {
    let rows = study.fits.iter().map(|fit| {
        let factors: Vec<_> = fit.factors.iter().map(|factor| figure(*factor)).collect();
        let words = [fit.set.name.to_owned(), factors.join(", ")].map(Cell::plain);
        let errors = fit.errors.iter().map(|share| Cell::plain(format!("{:.1} %", 100.0 * share)));
        Row { cells: words.into_iter().chain(errors).chain([Cell::plain(figure(fit.misfit))]).collect() }
    });
    let nodes = study.after.rows.iter().map(|row| Column::numbers(format!("node {}", row.node)));
    Table {
        caption:
            "Sets of zones fitted to Table I: factors in the order named, mean of sensed / true - 1 by node, and root \
                  mean square misfit (below 1 fits)"
                .to_owned(),
        columns: ["zones softened", "factors"]
            .map(Column::words)
            .into_iter()
            .chain(nodes)
            .chain([Column::numbers("misfit")])
            .collect(),
        rows: rows.collect(),
        csv: Some(SETS_CSV.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::twin::{OTHERS, TWIN, ZoneSet};
    use finray_model::Scene;

    fn fit_of(set: ZoneSet, misfit: f64) -> TwinFit {
        TwinFit {
            set,
            finger: Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("the paper's scene").finger,
            factors: set.groups.iter().map(|(_, start)| *start).collect(),
            sigmas: vec![0.1; set.groups.len()],
            modulus_factor: 1.0,
            errors: Vec::new(),
            misfit,
        }
    }

    #[test]
    fn the_twin_is_one_of_several_fits() {
        let words = freedom_in_words(&[
            fit_of(TWIN, 0.5),
            fit_of(OTHERS[0], 0.4),
            fit_of(OTHERS[1], 0.9),
            fit_of(OTHERS[2], 3.0),
        ]);
        assert!(words.contains("Its 4 parameters, 3 factors of zones and the modulus outside"), "{words}");
        assert!(words.contains("of 3 other sets of zones 2 fit") && words.contains(OTHERS[0].name), "{words}");
        assert!(words.contains("better than this one") && !words.contains(OTHERS[1].name), "{words}");
        let best = freedom_in_words(&[fit_of(TWIN, 0.3), fit_of(OTHERS[0], 0.4)]);
        assert!(best.contains("1 fit") && !best.contains("better"), "{best}");
        assert!(freedom_in_words(&[fit_of(TWIN, 0.3)]).contains("not fitted this time"));
    }

    /// The shipped twin is softer than the softest TPU that the paper quotes; a finger within the range is not said to be.
    #[test]
    fn moduli_are_held_against_the_material() {
        let twin = Scene::from_toml(finray_fixtures::TWIN_SCENE).expect("the twin's scene").finger;
        let words = moduli_in_words(&moduli_mpa(&twin));
        assert!(words.contains("(35.7, 7.6, 3.2 MPa) 7.6, 3.2 MPa lie outside the 10 to 1000 MPa"), "{words}");
        assert!(moduli_in_words(&[12.0, 40.0]).contains("within"));
        assert!(moduli_in_words(&[12.0, 1200.0]).contains("1200.0 MPa lie outside"));
    }
}
