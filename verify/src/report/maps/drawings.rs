//! The overview, and the maps that explain.

use super::{EXPLANATIONS_CSV, Of, small};
use crate::estimators::EstimatorId;
use crate::figures::{Cells, ColourScale, FigureError, Frame, Map, Shades};
use crate::report::ReportError;
use crate::report::drawings::{error_colours, plate_map, small_maps};
use crate::report::page::Figure;
use crate::sampling::map::{AccuracyMap, MapSummary};
use crate::settings::DRAWN_FORCE_N;
use crate::study::Study;
use crate::truths::TruthId;

/// Every truth by every estimator, in the paper's shades.
pub(super) fn overview(study: &Study, noisy: bool) -> Result<String, FigureError> {
    let shown =
        |estimator: &EstimatorId| TruthId::ALL.iter().any(|truth| small(study, *truth, *estimator, noisy).is_some());
    let columns: Vec<EstimatorId> = EstimatorId::ALL.iter().copied().filter(shown).collect();
    let rows = TruthId::ALL.iter().filter_map(|&truth| {
        let row = columns.iter().map(|&estimator| small(study, truth, estimator, noisy));
        let row: Vec<Option<Cells>> = row.map(|map| map.as_ref().map(small_map)).collect();
        row.iter().any(Option::is_some).then(|| (truth.label().to_owned(), row))
    });
    let noise = if noisy { format!("{} mm noise", study.noise_mm) } else { "no noise".to_owned() };
    let frame = Frame::full(
        format!("Error of {DRAWN_FORCE_N} N by position and direction, {noise}"),
        "Small maps of the error of a sensed force by position and direction: a row for each true finger, a column for each \
         estimator.",
    );
    let names = columns.iter().map(|estimator| estimator.label().to_owned()).collect();
    small_maps(&study.finger, frame, names, rows.collect(), "no equilibrium, or refused").svg()
}

fn small_map(map: &AccuracyMap) -> Cells {
    let summary = map.summary(Some(DRAWN_FORCE_N));
    let percents = |row: Vec<Option<f64>>| row.into_iter().map(|error| error.map(|e| 100.0 * e)).collect();
    Cells {
        note: note(&summary),
        x: map.request.positions_mm.clone(),
        y: map.request.angles_deg.clone(),
        values: map.errors(Some(DRAWN_FORCE_N)).into_iter().map(percents).collect(),
    }
}

/// What is said above a small map: whole percents of the cells with an equilibrium, as there is little room. Dark counts here the cells
/// that are drawn dark, so that refused ones can stand beside them.
fn note(summary: &MapSummary) -> String {
    let whole = |share: f64| match 100.0 * share {
        some if some > 0.0 && some < 1.0 => "<1 %".to_owned(),
        some => format!("{some:.0} %"),
    };
    let MapSummary { cells, refused, without_equilibrium, .. } = *summary;
    let (Some(above_10), Some(above_25)) = (summary.share_above_10, summary.share_above_25) else {
        return "no equilibrium".to_owned();
    };
    let refused_share = refused as f64 / (cells - without_equilibrium) as f64;
    match above_10 {
        0.0 if without_equilibrium == 0 => "all clear".to_owned(),
        _ if refused > 0 && refused_share < above_10 => format!(
            "{} dark, {} grey, {} refused",
            whole(above_25 - refused_share),
            whole(above_10 - above_25),
            whole(refused_share)
        ),
        _ if refused > 0 => format!("{} refused", whole(refused_share)),
        _ => format!("{} dark, {} grey", whole(above_25), whole(above_10 - above_25)),
    }
}

/// A map that explains: how it is made and said.
struct Kind {
    title: &'static str,
    value_label: &'static str,
    of: Of,
    colours: ColourScale,
    contours: &'static [f64],
    contour_unit: &'static str,
    missing_label: &'static str,
    caption: &'static str,
}

/// Maps of bound, condition, and how far wrong directions and positions carry. Without noise there is no bound.
pub(super) fn explanations(study: &Study) -> Result<Vec<Figure>, ReportError> {
    let noise = format!("{} mm noise a coordinate", study.explanations.noise_mm);
    let kinds = kinds().into_iter().filter(|kind| study.noise_mm > 0.0 || !kind.title.contains("bound"));
    let figure = |kind: Kind| -> Result<Figure, ReportError> {
        Ok(Figure {
            svg: explanation(study, &kind)?,
            caption: kind.caption.replace("NOISE", &noise),
            csv: Some(EXPLANATIONS_CSV.to_owned()),
            wide: false,
        })
    };
    kinds.map(figure).collect()
}

fn kinds() -> [Kind; 5] {
    let errors = error_colours();
    [
        Kind {
            title: "bound, direction known",
            value_label: "least standard deviation / force, %",
            of: |cell| cell.bound.map(|share| 100.0 * share),
            colours: errors,
            contours: &[1.0, 10.0],
            contour_unit: " %",
            missing_label: "no equilibrium",
            caption: "Cramer-Rao bound of the force, position and direction known, with NOISE.",
        },
        Kind {
            title: "bound, direction sought too",
            value_label: "least standard deviation / force, %",
            of: |cell| cell.bound_unknown_direction.map(|share| 100.0 * share),
            colours: errors,
            contours: &[1.0, 10.0],
            contour_unit: " %",
            missing_label: "no equilibrium, or not identifiable",
            caption: "The same when both components of the force are sought, to first order, with NOISE.",
        },
        Kind {
            title: "condition of two components",
            value_label: "largest / smallest singular value",
            of: |cell| cell.condition,
            colours: ColourScale::log(1.0, 1000.0),
            contours: &[10.0, 100.0],
            contour_unit: "",
            missing_label: "no equilibrium",
            caption: "How many times more the markers move under the component of a force that they see best than under the \
                      one that they see worst: how ill-posed an unknown direction is.",
        },
        Kind {
            title: "wrong direction",
            value_label: "error of the force, % per degree",
            of: |cell| cell.error_per_deg.map(|share| 100.0 * share),
            colours: errors,
            contours: &[1.0, 10.0],
            contour_unit: " %",
            missing_label: "no equilibrium",
            caption: "How much a direction that is wrong by a degree changes the sensed force.",
        },
        Kind {
            title: "wrong position",
            value_label: "error of the force, % per mm",
            of: |cell| cell.error_per_mm.map(|share| 100.0 * share),
            colours: errors,
            contours: &[1.0, 10.0],
            contour_unit: " %",
            missing_label: "no equilibrium",
            caption: "How much a position that is wrong by a millimetre changes the sensed force.",
        },
    ]
}

fn explanation(study: &Study, kind: &Kind) -> Result<String, FigureError> {
    let map = &study.explanations;
    let title = format!("{}, {} N", kind.title, map.force_n);
    let alt = format!("{title}: {} by position along the front plate and direction.", kind.value_label);
    let cells = Cells::new(&map.positions_mm, &map.angles_deg, map.values(kind.of));
    let shades = Shades::Scale(kind.colours, kind.value_label.to_owned());
    Map {
        contours: kind.contours.to_vec(),
        contour_unit: kind.contour_unit,
        missing_label: kind.missing_label.to_owned(),
        ..plate_map(&study.finger, Frame::half(title, alt), shades, cells)
    }
    .svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_map_is_not_all_clear() {
        let summary = |[cells, refused, without_equilibrium]: [usize; 3], [above_10, above_25]: [f64; 2]| MapSummary {
            truth: TruthId::Linear,
            estimator: EstimatorId::Network,
            noise_mm: 0.067,
            forces_n: vec![3.0],
            cells,
            answered: cells - refused - without_equilibrium,
            refused,
            without_equilibrium,
            mean_error: Some(0.0098),
            largest_error: Some(0.0098),
            share_above_10: (cells > without_equilibrium).then_some(above_10),
            share_above_25: (cells > without_equilibrium).then_some(above_25),
            share_of_samples_refused: None,
        };
        assert_eq!(note(&summary([12, 11, 0], [11.0 / 12.0; 2])), "92 % refused");
        assert_eq!(note(&summary([10, 2, 0], [0.5, 0.3])), "10 % dark, 20 % grey, 20 % refused");
        assert_eq!(note(&summary([10, 0, 0], [0.5, 0.3])), "30 % dark, 20 % grey");
        assert_eq!(note(&summary([10, 0, 0], [0.0, 0.0])), "all clear");
        assert_eq!(note(&summary([10, 0, 10], [0.0, 0.0])), "no equilibrium");
    }
}
