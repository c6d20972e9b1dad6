//! Where sensing fails: an overview of all truths and estimators, then the maps one by one and what explains them.

mod drawings;
mod tables;
mod words;

use super::dataset::Dataset;
use super::drawings::{Quantity, errors_along_the_normal, map_figure_svg, quantity_svg};
use super::page::{Block, Figure, Section, details, text};
use super::{ReportError, Results};
use crate::estimators::EstimatorId;
use crate::experiments::explain::Explanation;
use crate::sampling::map::AccuracyMap;
use crate::settings::{DRAWN_FORCE_N, MAP_FORCES_N};
use crate::study::Study;
use crate::truths::TruthId;
use tables::{EXPLANATIONS_CSV, OVERVIEW_CSV};

pub(super) use tables::map_csv_name;

/// A map of the overview: on the coarse grid where it was computed on the fine one, which would only weigh the page down.
fn small(study: &Study, truth: TruthId, estimator: EstimatorId, noisy: bool) -> Option<AccuracyMap> {
    let map = study.map_by(truth, estimator, noisy).filter(|map| map.request.forces_n.contains(&DRAWN_FORCE_N))?;
    let coarse = study.map_by(truth, EstimatorId::Ridge, noisy).map(|map| &map.request);
    Some(match coarse.filter(|coarse| coarse.contact_count() < map.request.contact_count()) {
        Some(coarse) => map.thinned(&coarse.positions_mm, &coarse.angles_deg),
        None => map.clone(),
    })
}

/// A quantity of explanations.
type Of = fn(&Explanation) -> Option<f64>;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    tables::datasets(study)
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let noisy = study.noise_mm > 0.0;
    let mut blocks = vec![
        text(
            "A force is put on a true finger at a known position and in a known direction; its size is sensed from the \
             displacements of the key nodes by an estimator that knows the uniform finger, not the truth. The shades are those \
             of the paper's Table I: clear up to 10 %, grey up to 25 %, dark above.",
        ),
        Block::Figure(overview(study, noisy)?),
        Block::List { items: words::findings(study) },
    ];
    blocks.push(details("The finest maps: linear least squares", least_squares(study)?));
    blocks.push(details("Bias and spread apart", bias_and_spread(study)?));
    blocks.push(details("What explains them: bound, condition, wrong directions and positions", explanations(study)?));
    if noisy {
        blocks.push(details("All truths and estimators without noise", vec![Block::Figure(overview(study, false)?)]));
    }
    blocks.push(details("Every map in figures, with its cells", vec![Block::Table(tables::figures(study))]));
    Ok(Some(Section::new("maps", "Where sensing fails", blocks).saying(words::says(study))))
}

fn overview(study: &Study, noisy: bool) -> Result<Figure, ReportError> {
    let samples =
        |estimator| study.map_by(TruthId::Corotational, estimator, noisy).map(|map| map.request.noise_samples);
    let noise = match (samples(EstimatorId::LeastSquares), samples(EstimatorId::Nonlinear)) {
        (Some(most), Some(fewer)) if noisy => {
            let few = study
                .map_by(TruthId::Linear, EstimatorId::Nonlinear, noisy)
                .map_or(fewer, |map| map.request.noise_samples);
            let (networks, twin) = if study.is_paper { (" and for networks", "the twin and ") } else { ("", "") };
            format!(
                "with {} mm noise a coordinate: mean error of {most} noise samples a cell for least squares on the co-rotational \
                 and the linear finger{networks}, {few} for the nonlinear estimator on {twin}the linear finger, which it cannot \
                 explain, {fewer} for all others",
                study.noise_mm
            )
        }
        _ => "without noise".to_owned(),
    };
    let only = match study.is_paper {
        true => " Networks ship for contact nodes along the normal alone; MuJoCo's shapes were exported at the nodes.",
        false => " Digital twin, lattice, MuJoCo and networks exist for the paper's finger alone.",
    };
    Ok(Figure {
        svg: drawings::overview(study, noisy)?,
        caption: format!(
            "Error of a sensed force of {DRAWN_FORCE_N} N, {noise}. Rows: the finger that bends; columns: what senses it. Shares are of the \
             cells with an equilibrium; hatched are cells without, and those of which the estimator refuses more than half of the \
             noise samples. The list below counts them.{only}"
        ),
        csv: Some(OVERVIEW_CSV.to_owned()),
        wide: true,
    })
}

fn noise_in_words(map: &AccuracyMap) -> String {
    match map.noise_mm {
        0.0 => "without noise".to_owned(),
        noise => format!("with {noise} mm noise a coordinate, {} noise samples a cell", map.request.noise_samples),
    }
}

/// Least squares on the co-rotational and the linear finger: the maps on the finest grid, each force and their mean.
fn least_squares(study: &Study) -> Result<Vec<Block>, ReportError> {
    let of = |truth: TruthId| [false, true].into_iter().filter_map(move |noisy| study.map(truth, noisy));
    let figure_of = |map: &AccuracyMap, force_n: Option<f64>| -> Result<Figure, ReportError> {
        let force = force_n.map_or_else(|| "mean over all forces".to_owned(), |f| format!("{f} N"));
        Ok(Figure {
            svg: map_figure_svg(&study.finger, map, force_n)?,
            caption: format!(
                "Sensed by linear least squares on the {} finger, {}; {force}; {}.",
                map.truth.label(),
                noise_in_words(map),
                map.summary(force_n).counts()
            ),
            csv: Some(map_csv_name(map)),
            wide: false,
        })
    };
    let figures =
        |force_n| of(TruthId::Corotational).chain(of(TruthId::Linear)).map(move |map| figure_of(map, force_n));
    let lines = of(TruthId::Corotational).map(|map| {
        Ok(Figure {
            svg: errors_along_the_normal(map)?,
            caption: format!(
                "The same along the normal, for each force ({} of the whole map).",
                map.summary(None).counts()
            ),
            csv: Some(map_csv_name(map)),
            wide: false,
        })
    });
    let forces = MAP_FORCES_N.map(|f| f.to_string()).join(", ");
    Ok(vec![
        text(
            "Colour is the error |sensed / true - 1|, with lines at 10 and 25 %. Directions are counted from the front plate's \
             undeformed inward normal, positive towards the tip.",
        ),
        Block::Figures { figures: figures(Some(DRAWN_FORCE_N)).collect::<Result<_, _>>()? },
        Block::Figures { figures: lines.collect::<Result<_, ReportError>>()? },
        text(format!("Mean over {forces} N:")),
        Block::Figures { figures: figures(None).collect::<Result<_, _>>()? },
    ])
}

/// Bias beside spread, on one scale.
fn bias_and_spread(study: &Study) -> Result<Vec<Block>, ReportError> {
    let noisy = study.noise_mm > 0.0;
    let mut blocks = vec![text(
        "The bias is what is wrong whatever the noise: no camera mends it, a better model does. The spread is what the noise \
         does: a better camera, more images or more markers lessen it. The bias of n noise samples is itself known to spread / sqrt(n) \
         only.",
    )];
    for (truth, estimator) in [
        (TruthId::Corotational, EstimatorId::LeastSquares),
        (TruthId::Corotational, EstimatorId::Nonlinear),
        (TruthId::Twin, EstimatorId::LeastSquares),
    ] {
        let Some(map) = small(study, truth, estimator, noisy) else { continue };
        let figure = |quantity: Quantity| -> Result<Figure, ReportError> {
            let what = if quantity == Quantity::Bias { "Bias (its size)" } else { "Spread" };
            Ok(Figure {
                svg: quantity_svg(&study.finger, &map, Some(DRAWN_FORCE_N), quantity)?,
                caption: format!(
                    "{what}: {}, {} truth, {DRAWN_FORCE_N} N, {}; {}.",
                    estimator.label(),
                    map.truth.label(),
                    noise_in_words(&map),
                    map.summary(Some(DRAWN_FORCE_N)).counts()
                ),
                csv: Some(map_csv_name(&map)),
                wide: false,
            })
        };
        let quantities = if noisy { &[Quantity::Bias, Quantity::Spread][..] } else { &[Quantity::Bias] };
        blocks.push(Block::Figures { figures: quantities.iter().map(|q| figure(*q)).collect::<Result<_, _>>()? });
    }
    Ok(blocks)
}

fn explanations(study: &Study) -> Result<Vec<Block>, ReportError> {
    Ok(vec![
        text(format!(
            "All of these follow from the tangent stiffness of the co-rotational finger in its shape under {DRAWN_FORCE_N} N, \
             to first order, with all free key nodes as markers. The bound is the Cramer-Rao bound: no unbiased estimator \
             scatters less."
        )),
        Block::Figures { figures: drawings::explanations(study)? },
    ])
}
