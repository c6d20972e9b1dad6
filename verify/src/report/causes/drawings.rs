//! Pictures of causes: the largest one over place and direction, and what each costs along the finger.

use super::{CSV, Region, Shares, practice_in_words, truth_in_words};
use crate::causes::{Cause, CauseMap};
use crate::report::ReportError;
use crate::report::drawings::ALONG_THE_PLATE;
use crate::report::figures::{self, Axis, Category, CategoryMap, Dash, Frame, Hue, LineChart, Series};
use crate::report::page::Figure;
use crate::report::tables::percent;
use crate::study::{DRAWN_FORCE_N, Study};

/// Below this an error needs no explanation: root mean square of sensed / true - 1.
const SMALL_ERROR: f64 = 0.02;
/// Less is not drawn, %.
const LEAST_DRAWN_PERCENT: f64 = 0.1;

fn category(cause: Cause) -> Category {
    // Okabe and Ito's colours, and two greys.
    let (sign, colour) = match cause {
        Cause::Noise => ("N", [0x56, 0xb4, 0xe9]),
        Cause::Linearisation => ("L", [0xe6, 0x9f, 0x00]),
        Cause::Discretisation => ("E", [0x8a, 0x8f, 0x98]),
        Cause::Modulus => ("M", [0xcc, 0x79, 0xa7]),
        Cause::Direction => ("D", [0x00, 0x9e, 0x73]),
        Cause::Place => ("P", [0xf0, 0xe4, 0x42]),
        Cause::BaseCompliance => ("B", [0x00, 0x72, 0xb2]),
        Cause::TipCompliance => ("T", [0xd5, 0x5e, 0x00]),
        Cause::NetworkFit => ("F", [0x5c, 0x60, 0x66]),
    };
    Category { label: cause.name().to_owned(), sign: sign.to_owned(), colour }
}

/// As near to the colour on the maps as lines have one.
fn line(cause: Cause) -> (Hue, Dash) {
    match cause {
        Cause::Noise => (Hue::SkyBlue, Dash::Solid),
        Cause::Linearisation => (Hue::Orange, Dash::Solid),
        Cause::Discretisation => (Hue::Orange, Dash::Dashed),
        Cause::Modulus => (Hue::Purple, Dash::Solid),
        Cause::Direction => (Hue::Green, Dash::Solid),
        Cause::Place => (Hue::Green, Dash::Dashed),
        Cause::BaseCompliance => (Hue::Blue, Dash::Solid),
        Cause::TipCompliance => (Hue::Vermilion, Dash::Solid),
        Cause::NetworkFit => (Hue::Purple, Dash::Dashed),
    }
}

pub(super) fn map_figure(study: &Study, map: &CauseMap) -> Result<Figure, ReportError> {
    let (angles, places) = (map.request.angles_deg.len(), map.request.places_mm.len());
    let (mut categories, small) =
        (map.causes.iter().map(|cause| category(*cause)).collect::<Vec<_>>(), map.causes.len());
    let hidden = small + 1;
    categories.push(Category {
        label: format!("error below {}", percent(SMALL_ERROR)),
        sign: String::new(),
        colour: [0xd9, 0xdd, 0xe2],
    });
    categories.push(Category {
        label: "each hides others".to_owned(),
        sign: "-".to_owned(),
        colour: [0xa9, 0xae, 0xb5],
    });
    let of_cell = |place: usize, angle: usize| {
        let mut at = map.cells.iter().filter(|cell| cell.force_n == DRAWN_FORCE_N);
        let cell = at.nth(place * angles + angle)?;
        Some(match cell.rms_error? {
            rms if rms < SMALL_ERROR => small,
            _ => cell.largest().map_or(hidden, |(cause, _)| cause),
        })
    };
    let title =
        format!("Largest cause at {DRAWN_FORCE_N} N, finger {}; {}", truth_in_words(map), practice_in_words(map));
    let svg = figures::category_map(&CategoryMap {
        frame: Frame::half(title.clone(), format!("{title}: by place along the front plate and direction.")),
        x_label: ALONG_THE_PLATE.to_owned(),
        x: map.request.places_mm.clone(),
        y_label: "force direction, deg from normal (+ to tip)".to_owned(),
        y: map.request.angles_deg.clone(),
        y_ticks: (-2..=2).map(|i| f64::from(i) * 40.0).collect(),
        categories,
        values: (0..angles).map(|angle| (0..places).map(|place| of_cell(place, angle)).collect()).collect(),
        missing_label: "no equilibrium or no answer".to_owned(),
    })?;
    let shares = Shares::of(&study.finger, map, DRAWN_FORCE_N, Region::All);
    let over_all = shares.map_or_else(String::new, |shares| {
        let list: Vec<_> = (shares.by_cause.iter().take(3).filter(|(_, share)| *share > 0.0))
            .map(|(cause, share)| format!("{} {}", cause.name(), percent(*share)))
            .collect();
        format!(
            " Over all cells, root mean square error {}; shares of its square: {}.",
            percent(shares.rms_error),
            list.join(", ")
        )
    });
    Ok(Figure {
        svg,
        caption: format!("The cause whose absence lessens the error most.{over_all}"),
        csv: Some(CSV.to_owned()),
        wide: false,
    })
}

/// `None` where nothing is large enough to be drawn.
pub(super) fn line_figure(map: &CauseMap) -> Result<Option<Figure>, ReportError> {
    let title =
        format!("Along the normal at {DRAWN_FORCE_N} N, finger {}; {}", truth_in_words(map), practice_in_words(map));
    let cells = || map.cells.iter().filter(|cell| cell.angle_deg == 0.0 && cell.force_n == DRAWN_FORCE_N);
    let shown = |point: [f64; 2]| (point[1] >= LEAST_DRAWN_PERCENT).then_some(point);
    let of_cause = |(i, cause): (usize, &Cause)| {
        let points = cells().filter_map(|cell| shown([cell.s_mm, 100.0 * cell.error_of(i)?])).collect();
        let (hue, dash) = line(*cause);
        Series { marker: None, hue, dash: Some(dash), ..Series::nth(i, cause.name(), points) }
    };
    let all = cells().filter_map(|cell| shown([cell.s_mm, 100.0 * cell.rms_error?])).collect();
    let all = Series { hue: Hue::Neutral, ..Series::nth(0, "all causes", all) };
    let series = std::iter::once(all).chain(map.causes.iter().enumerate().map(of_cause));
    let series: Vec<Series> = series.filter(|series| !series.points.is_empty()).collect();
    if series.is_empty() {
        return Ok(None);
    }
    Ok(Some(Figure {
        svg: figures::lines(&LineChart {
            frame: Frame::half(title.clone(), format!("{title}: error by place, one line a cause.")),
            x: Axis::linear(ALONG_THE_PLATE),
            y: Axis::log("error that goes away with it, %"),
            series,
            references: Vec::new(),
        })?,
        caption: format!(
            "Root of the mean square error that goes away when a cause is switched off; nothing below {LEAST_DRAWN_PERCENT} %, nor for \
             one that hides others."
        ),
        csv: Some(CSV.to_owned()),
        wide: false,
    }))
}
