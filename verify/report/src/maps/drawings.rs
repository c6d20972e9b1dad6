//! Drawings of the overview, and of maps that explain where sensing fails.

use super::{EXPLANATIONS_CSV, ExplainedQuantity, small};
use crate::drawings::{by_direction, error_cells, percent_classes, plate_map, small_maps};
use crate::prelude::*;

/// Selects the true fingers and estimators of an overview.
pub(super) type MapFilter = fn(TruthId, EstimatorId) -> bool;

/// One small map for each selected pair of true finger and estimator.
pub(super) fn overview(study: &Study, shown: MapFilter) -> Result<String, FigureError> {
    let noisy = study.noise_mm > 0.0;
    let small = |truth, estimator| if shown(truth, estimator) { small(study, truth, estimator, noisy) } else { None };
    let is_asked = |estimator: &EstimatorId| TruthId::ALL.iter().any(|truth| small(*truth, *estimator).is_some());
    let columns: Vec<EstimatorId> = EstimatorId::ALL.iter().copied().filter(is_asked).collect();
    let rows = TruthId::ALL.iter().filter_map(|&truth| {
        let row = columns.iter().map(|&estimator| small(truth, estimator));
        let row: Vec<Option<Cells>> = row.map(|map| map.as_ref().map(|map| small_map(&study.finger, map))).collect();
        row.iter().any(Option::is_some).then(|| (truth.label().to_owned(), row))
    });
    let frame = Frame::full(
        "Error of the worst force by position and direction",
        "Small maps of the error of a sensed force by position and direction: a row for each true finger, a column for each \
         estimator.",
    );
    let names = columns.iter().map(|estimator| estimator.label().to_owned()).collect();
    small_maps(&study.finger, frame, names, rows.collect()).svg()
}

fn small_map(finger: &Finger, map: &AccuracyMap) -> Cells {
    Cells { note: note(&map.trust(finger)), ..error_cells(finger, map, None) }
}

/// Note above a small map: the trusted share and the refused share, whole percentages.
pub fn note(trust: &TrustShare) -> String {
    let Some((share, refused)) = trust.share().zip(trust.refused_share()) else { return "no equilibrium".to_owned() };
    let refused = match refused {
        0.0 => String::new(),
        refused => format!(", {:.0} % refused", 100.0 * refused),
    };
    format!("{:.0} % trusted{refused}", 100.0 * share)
}

/// A map that explains where sensing fails: its title, quantity and caption.
struct Kind {
    title: &'static str,
    value_label: &'static str,
    of: ExplainedQuantity,
    missing_label: &'static str,
    caption: &'static str,
}

/// Maps of the error bound and of the sensitivity to wrong direction and position. Without noise the bound is not drawn.
pub(super) fn explanations(study: &Study) -> Result<Vec<Figure>, ReportError> {
    let noise = format!("{} mm noise per coordinate", study.explanations.noise_mm);
    let kinds = kinds().into_iter().filter(|kind| study.noise_mm > 0.0 || !kind.title.contains("bound"));
    let figure = |kind: Kind| -> Result<Figure, ReportError> {
        Ok(Figure::narrow(explanation(study, &kind)?, kind.caption.replace("NOISE", &noise), EXPLANATIONS_CSV))
    };
    kinds.map(figure).collect()
}

fn kinds() -> [Kind; 4] {
    [
        Kind {
            title: "bound, direction known",
            value_label: "least standard deviation / force, %",
            of: |cell| cell.bound.map(|share| 100.0 * share),
            missing_label: "no equilibrium",
            caption: "Cramer-Rao bound of a force with known position and direction, with NOISE.",
        },
        Kind {
            title: "bound, direction unknown",
            value_label: "least standard deviation / force, %",
            of: |cell| cell.bound_unknown_direction.map(|share| 100.0 * share),
            missing_label: "no equilibrium, or not identifiable",
            caption: "Cramer-Rao bound of a force with two unknown components, to first order, with NOISE.",
        },
        Kind {
            title: "wrong direction",
            value_label: "error of the force, % per degree",
            of: |cell| cell.error_per_deg.map(|share| 100.0 * share),
            missing_label: "no equilibrium",
            caption: "Change of the sensed force if the direction is wrong by one degree.",
        },
        Kind {
            title: "wrong position",
            value_label: "error of the force, % per mm",
            of: |cell| cell.error_per_mm.map(|share| 100.0 * share),
            missing_label: "no equilibrium",
            caption: "Change of the sensed force if the position is wrong by one millimetre.",
        },
    ]
}

fn explanation(study: &Study, kind: &Kind) -> Result<String, FigureError> {
    let map = &study.explanations;
    let title = format!("{}, {} N", kind.title, map.force_n);
    let alt = format!("{title}: {} by position along the front plate and direction.", kind.value_label);
    let cells = by_direction(&map.positions_mm, &map.angles_deg, map.cells.iter().map(kind.of));
    let drawn = plate_map(&study.finger, Frame::half(title, alt), percent_classes(), cells);
    Map { missing_label: kind.missing_label.to_owned(), ..drawn }.svg()
}
