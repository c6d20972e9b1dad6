//! Maps of where sensing fails: an overview of all true fingers and estimators, single maps, and their explanation.

pub mod drawings;
mod tables;
pub mod words;

use super::drawings::map_figure_svg;
use crate::prelude::*;
use drawings::MapFilter;
use finray_studies::experiments::explain::Explanation;
use tables::{EXPLANATIONS_CSV, OVERVIEW_CSV};

pub(super) use tables::{datasets, map_csv_name};

/// A map of the overview. The returned map has only the cells of the coarse grid, to keep the page small.
pub(super) fn small(study: &Study, truth: TruthId, estimator: EstimatorId, noisy: bool) -> Option<AccuracyMap> {
    let map = study.map_by(truth, estimator, noisy)?;
    let coarse = study.map_by(truth, EstimatorId::Ridge, noisy).map(|map| &map.request);
    Some(match coarse.filter(|coarse| coarse.contact_count() < map.request.contact_count()) {
        Some(coarse) => map.thinned(&coarse.positions_mm, &coarse.angles_deg),
        None => map.clone(),
    })
}

/// Reads from a cell one of the quantities that explain errors.
type ExplainedQuantity = fn(&Explanation) -> Option<f64>;

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let first: MapFilter = |truth, estimator| truth != TruthId::Linear && estimator != EstimatorId::Ridge;
    let mut blocks = vec![Block::Figure(overview(study, first)?)];
    let all = Block::Figure(overview(study, |_, _| true)?);
    blocks.push(details("The overview with the ridge estimator and the linear finger", vec![all]));
    blocks.push(details("Large maps of least squares and the nonlinear estimator", in_full(study)?));
    blocks.push(details("What limits any estimator", vec![Block::Figures(drawings::explanations(study)?)]));
    blocks.push(details("Key figures and cells of every map", vec![Block::Table(tables::figures(study))]));
    Ok(Some(Section::new("maps", "Every finger by every estimator", blocks).saying(words::says(study))))
}

fn overview(study: &Study, shown: MapFilter) -> Result<Figure, ReportError> {
    Ok(Figure::wide(drawings::overview(study, shown)?, words::overview(study), OVERVIEW_CSV))
}

/// Maps of the co-rotational finger on the finest grid, with their bias and scatter.
fn in_full(study: &Study) -> Result<Vec<Block>, ReportError> {
    let noisy = study.noise_mm > 0.0;
    let maps = [EstimatorId::LeastSquares, EstimatorId::Nonlinear].into_iter();
    let maps = maps.filter_map(|estimator| study.map_by(TruthId::Corotational, estimator, noisy));
    let figure = |map: &AccuracyMap| -> Result<Figure, ReportError> {
        let samples =
            if noisy { format!(", {} noise samples per cell", map.request.noise_samples) } else { String::new() };
        let caption = format!("Sensed by {}{samples}. {}", map.estimator.label(), words::kind_of_error(map));
        Ok(Figure::narrow(map_figure_svg(&study.finger, map, None)?, caption, map_csv_name(map)))
    };
    Ok(vec![Block::Figures(maps.map(figure).collect::<Result<_, _>>()?)])
}
