//! The finger with softer ends (the twin), which is one of several fingers that fit Table I; and the gain in sensing accuracy if the zones of the
//! twin are known.

pub mod words;

use super::drawings::{Line, by_contact};
use super::format::{figure, list};
use crate::prelude::*;
use finray_model::calibration::FactorEstimate;
use finray_studies::experiments::table_one::{TableOne, TableOneRow};
use finray_studies::experiments::twin::fit::TwinFit;
use finray_studies::experiments::twin::study::{TwinSensing, TwinStudy};

const CSV: &str = "twin.csv";
const SETS_CSV: &str = "twin_zone_sets.csv";
const CALIBRATION_CSV: &str = "twin_calibration.csv";

/// One contact node: its rows of Table I, if any, on the uniform finger and on the twin; and the errors at this node on the twin with noise.
struct NodeComparison<'s> {
    before: Option<&'s TableOneRow>,
    after: Option<&'s TableOneRow>,
    sensing: &'s TwinSensing,
}

fn at_nodes(study: &TwinStudy) -> impl Iterator<Item = NodeComparison<'_>> {
    let of_node = |table: &'_ TableOne, node| table.rows.iter().position(|row| row.node == node);
    study.sensing.iter().map(move |sensing| NodeComparison {
        before: of_node(&study.before, sensing.node).map(|i| &study.before.rows[i]),
        after: of_node(&study.after, sensing.node).map(|i| &study.after.rows[i]),
        sensing,
    })
}

/// Errors by node: the paper's errors; errors of the uniform finger and of the twin under the weights of Table I; errors of the twin with noise.
fn by_node<'s>(study: Option<&'s TwinStudy>) -> Dataset<'s> {
    let columns = Columns::<NodeComparison>::new()
        .file("node", |at| at.sensing.node)
        .file("paper_mean_error", |at| Some(at.after?.paper_mean_error))
        .file("uniform_finger", |at| Some(at.before?.mean_error))
        .file("twin", |at| Some(at.after?.mean_error))
        .file("twin_lowest", |at| Some(at.after?.range()[0]))
        .file("twin_highest", |at| Some(at.after?.range()[1]))
        .file("noisy_uniform_model", |at| at.sensing.uniform.mean_error())
        .file("noisy_zones_least_squares", |at| at.sensing.linear.mean_error())
        .file("noisy_zones_nonlinear", |at| at.sensing.nonlinear.mean_error())
        .file("bound", |at| at.sensing.nonlinear.mean_error_bound());
    Dataset::new(CSV, &columns, study.into_iter().flat_map(at_nodes))
}

/// A calibrated factor: number of the repetition (from 1), the estimate of the repetition, and the index of the factor in that estimate.
type Factor<'s> = (usize, &'s FactorEstimate, usize);

fn calibrated<'s>() -> Columns<'s, Factor<'s>> {
    Columns::<Factor>::new()
        .file("repetition", |(repetition, ..)| *repetition)
        .file("parameter", |(_, found, i)| found.unknowns[*i].to_string())
        .page("parameter", Format::Words, |(_, found, i)| found.unknowns[*i].to_string().replace('_', " "))
        .both("found_over_true", "found / true", Format::Fixed(4), |(_, found, i)| found.factors[*i])
        .both("sigma", "stated sigma", Format::Fixed(4), |(_, found, i)| found.factors[*i] * found.relative_sigmas[*i])
}

/// All factors of the twin, calibrated from displacements with noise.
fn factors(study: &TwinStudy) -> impl Iterator<Item = Factor<'_>> {
    let repetitions = (1..).zip(&study.calibrations);
    repetitions.flat_map(|(repetition, found)| (0..found.factors.len()).map(move |i| (repetition, found, i)))
}

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let twin = study.twin.as_ref();
    // Standard deviations assume six independent errors. A set of zones fits if its misfit is below 1.
    let sets = Columns::<(&TwinFit, usize)>::new()
        .file("zones", |(fit, _)| fit.set.name)
        .file("group", |(_, group)| group + 1)
        .file("factor", |(fit, group)| fit.factors[*group])
        .file("sigma", |(fit, group)| fit.sigmas[*group])
        .file("misfit", |(fit, _)| fit.misfit)
        .file("modulus_factor", |(fit, _)| fit.modulus_factor);
    let fits = twin.into_iter().flat_map(|twin| &twin.fits);
    let groups = fits.flat_map(|fit| (0..fit.factors.len()).map(move |group| (fit, group)));
    vec![
        by_node(twin),
        Dataset::new(SETS_CSV, &sets, groups),
        Dataset::new(CALIBRATION_CSV, &calibrated(), twin.into_iter().flat_map(factors)),
    ]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(twin) = &study.twin else { return Ok(None) };
    let sets = Columns::<&TwinFit>::new()
        .page("zones softened", Format::Words, |fit| fit.set.name)
        .page("factors", Format::Words, |fit| list(fit.factors.iter().map(|factor| figure(*factor)), ", "))
        .page("misfit", Format::Fixed(2), |fit| fit.misfit);
    let first = factors(twin).filter(|(repetition, ..)| *repetition == 1);
    let mut folded = vec![Block::Table(sets.table(
        "Sets of zones fitted to Table I; a set fits the table if its misfit is below 1",
        SETS_CSV,
        &twin.fits,
    ))];
    folded.extend(words::calibration(twin).map(text));
    folded.push(Block::Table(calibrated().table("One of the calibrations", CALIBRATION_CSV, first)));
    let caption = format!(
        "The first three lines show Table I without noise. The last two show random forces with {} mm noise, sensed with the zones in the model.",
        twin.noise_mm
    );
    let mut blocks = vec![text(words::ABOUT)];
    blocks.extend(drawing(twin)?.map(|svg| Block::Figure(Figure::wide(svg, caption, CSV))));
    blocks.push(details("The fits, and how zones are calibrated", folded));
    let section = Section::new("twin", "One fit of Table I: the finger with softer ends", blocks);
    Ok(Some(section.saying(words::verdict(twin))))
}

fn drawing(study: &TwinStudy) -> Result<Option<String>, FigureError> {
    let mut rows: Vec<(String, NodeComparison)> =
        at_nodes(study).map(|row| (row.sensing.node.to_string(), row)).collect();
    rows.reverse();
    let title = "Table I, the finger with softer ends";
    let alt = "Mean error by node: in the paper, on the uniform finger, on the finger with softer ends, and on the finger \
        with softer ends when its zones are known.";
    let lines: [Line<NodeComparison>; 5] = [
        ("paper", |row| Some(100.0 * row.after?.paper_mean_error)),
        ("uniform finger", |row| Some(100.0 * row.before?.mean_error)),
        ("softer ends", |row| Some(100.0 * row.after?.mean_error)),
        ("zones known, least squares", |row| Some(100.0 * row.sensing.linear.mean_error()?)),
        ("zones known, nonlinear", |row| Some(100.0 * row.sensing.nonlinear.mean_error()?)),
    ];
    by_contact(Frame::full(title, alt), "mean error, %", &rows, &lines)
}
