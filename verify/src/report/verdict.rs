//! The verdict: three sentences at the head of the page, made from the numbers, and the map beside them.

mod cost;

use super::format::{Span, percent};
use super::maps::map_csv_name;
use super::page::Figure;
use super::{ReportError, causes, drawings};
use crate::estimators::EstimatorId;
use crate::sampling::map::{AccuracyMap, Cell, CellState};
use crate::sampling::scatter::{Counts, ScatterRow};
use crate::study::Study;
use crate::truths::TruthId;
use cost::cost;
use finray_model::finger::Plate;

/// Errors up to here are trusted: the lighter of the two shades of the paper's Table I begins there.
const TRUSTED: f64 = 0.10;
/// Regions of a map of which less than this share is trusted are named.
const MOSTLY: f64 = 0.9;

/// Where the finger can be trusted to feel, what limits it, and what to run at which cost.
pub(super) fn sentences(study: &Study) -> Vec<String> {
    [trusted(study), causes::in_short(study).or_else(|| limit(study)), cost(study)].into_iter().flatten().collect()
}

/// The one map beside the sentences.
pub(super) fn lead(study: &Study) -> Result<Option<Figure>, ReportError> {
    // The estimator that is recommended, where it was mapped.
    let Some(map) = map_by(study, EstimatorId::Nonlinear).or_else(|| map_by(study, EstimatorId::LeastSquares)) else {
        return Ok(None);
    };
    Ok(Some(Figure {
        svg: drawings::map_figure_svg(&study.finger, map, None)?,
        caption: format!(
            "Error of one force by its position and direction, sensed by {}{}; mean over {}. Inside the line of 10 % it can be \
             trusted on average. {}.",
            in_words(map.estimator),
            noise_in_words(map.noise_mm),
            forces_in_words(&map.request.forces_n),
            map.summary(None).counts()
        ),
        csv: Some(map_csv_name(map)),
        wide: false,
    }))
}

/// The noisiest map of the co-rotational finger by an estimator.
fn map_by(study: &Study, estimator: EstimatorId) -> Option<&AccuracyMap> {
    let maps = study.all_maps().filter(|map| map.truth == TruthId::Corotational && map.estimator == estimator);
    maps.max_by(|a, b| a.noise_mm.total_cmp(&b.noise_mm))
}

fn in_words(estimator: EstimatorId) -> String {
    match estimator {
        EstimatorId::LeastSquares => "linear least squares".to_owned(),
        EstimatorId::Network => "the network".to_owned(),
        other => format!("the {} estimator", other.label()),
    }
}

fn noise_in_words(noise_mm: f64) -> String {
    match noise_mm {
        0.0 => " without noise".to_owned(),
        noise_mm => format!(" from displacements with {noise_mm} mm noise"),
    }
}

fn forces_in_words(forces_n: &[f64]) -> String {
    match forces_n {
        [] => "no force".to_owned(),
        [one] => format!("{one} N"),
        [first, .., last] => format!("{first} to {last} N"),
    }
}

/// Where the finger can be trusted.
fn trusted(study: &Study) -> Option<String> {
    let linear = map_by(study, EstimatorId::LeastSquares)?;
    let nonlinear = map_by(study, EstimatorId::Nonlinear);
    let noise = match linear.noise_mm {
        0.0 => "In simulation, without noise,".to_owned(),
        noise_mm => format!("In simulation, with {noise_mm} mm noise,"),
    };
    let share = |map| Trusted::of(study, map, |_, _| true).in_words();
    let mapped = nonlinear.map(|map| {
        format!("by the nonlinear estimator at {}, by linear least squares at {}", share(map), share(linear))
    });
    let feels = mapped.or_else(|| {
        let rows = &study.noise.as_ref()?.single;
        let kept = rows.iter().filter(|row| row.is_within(TRUSTED)).count();
        Some(format!(
            "by the nonlinear estimator at {kept} of {} nodes along the normal ({}), by linear least squares at {}",
            rows.len(),
            Counts::of(rows),
            share(linear)
        ))
    });
    let feels = feels.unwrap_or_else(|| format!("by linear least squares at {}", share(linear)));
    Some(format!(
        "{noise} a force of {} at a known position, in a known direction, is sensed within {} (mean error, each of the forces) {feels}; {}.",
        forces_in_words(&linear.request.forces_n),
        percent(TRUSTED),
        weak_regions(study, nonlinear.unwrap_or(linear))
    ))
}

/// The cells (position, direction) of a region, each under all of the map's forces.
#[derive(Default)]
struct Trusted {
    cells: usize,
    /// Cells whose error is trusted under each of the forces.
    kept: usize,
    /// Cells in which a force is refused; they are not trusted.
    refused: usize,
    /// Cells in which a force has no equilibrium: there is nothing to sense.
    without_equilibrium: usize,
}

impl Trusted {
    /// Counts the cells of a region, by position over the plate's length and angle in degrees.
    fn of(study: &Study, map: &AccuracyMap, region: impl Fn(f64, f64) -> bool) -> Trusted {
        let length_mm = study.finger.plate_length_mm(Plate::Front);
        let mut trusted = Trusted::default();
        for cells in map.cells.chunks(map.request.forces_n.len()) {
            if !region(cells[0].s_mm / length_mm, cells[0].angle_deg) {
                continue;
            }
            trusted.cells += 1;
            match cells.iter().map(Cell::state).max() {
                Some(CellState::WithoutEquilibrium) => trusted.without_equilibrium += 1,
                Some(CellState::Refused) => trusted.refused += 1,
                _ => trusted.kept += usize::from(cells.iter().all(|cell| cell.is_above(TRUSTED) == Some(false))),
            }
        }
        trusted
    }

    /// Share of the cells with an equilibrium; `None` of none.
    fn share(&self) -> Option<f64> {
        let bent = self.cells - self.without_equilibrium;
        (bent > 0).then(|| self.kept as f64 / bent as f64)
    }

    /// The share with its counts.
    fn in_words(&self) -> String {
        let Trusted { cells, refused, without_equilibrium, .. } = self;
        let answered = cells - refused - without_equilibrium;
        let counts =
            format!("{cells} cells: {answered} answered, {refused} refused, {without_equilibrium} without equilibrium");
        match self.share() {
            Some(share) => format!("{} of the positions and directions ({counts})", percent(share)),
            None => format!("no position or direction ({counts})"),
        }
    }
}

/// A part of a map: its name, and what belongs to it.
type Region = (&'static str, fn(f64, f64) -> bool);

/// The regions in which most fails, worst first.
fn weak_regions(study: &Study, map: &AccuracyMap) -> String {
    const REGIONS: [Region; 5] = [
        ("in the tenth of the plate next to the base", |s, _| s < 0.1),
        ("in the tenth next to the tip", |s, _| s > 0.9),
        ("for forces that point more than 45 deg towards the base", |_, angle| angle < -45.0),
        ("for forces that point more than 45 deg towards the tip", |_, angle| angle > 45.0),
        ("within 45 deg of the normal", |s, angle| (0.1..=0.9).contains(&s) && angle.abs() <= 45.0),
    ];
    let share = |(name, holds): &Region| Some((Trusted::of(study, map, holds).share()?, *name));
    let mut weak: Vec<(f64, &str)> = REGIONS.iter().filter_map(share).collect();
    weak.retain(|(share, _)| *share < MOSTLY);
    weak.sort_by(|a, b| a.0.total_cmp(&b.0));
    let named: Vec<String> = weak.iter().take(2).map(|(share, name)| format!("{name} ({})", percent(*share))).collect();
    if named.is_empty() {
        return "no end of the plate and no range of directions falls behind".to_owned();
    }
    format!("{} can be trusted least {}", in_words(map.estimator), named.join(" and "))
}

/// What limits it there: how often linear sensing fails by its bias, and how near the nonlinear estimator is to what noise allows.
pub(super) fn limit(study: &Study) -> Option<String> {
    let map = map_by(study, EstimatorId::LeastSquares)?;
    let failed = map.cells.iter().filter(|cell| cell.mean_error.is_some_and(|error| error > TRUSTED));
    let (mut all, mut biased) = (0_usize, 0_usize);
    for cell in failed {
        all += 1;
        biased += usize::from(cell.bias.map(f64::abs) > cell.spread);
    }
    if all == 0 {
        return Some("Linear least squares errs nowhere by more than 10 %.".to_owned());
    }
    let linear = format!(
        "Where linear least squares errs by more than {}, its bias (the geometric nonlinearity that it leaves out) outweighs \
         the scatter of the noise in {} of the cells",
        percent(TRUSTED),
        percent(biased as f64 / all as f64)
    );
    let over = |row: &ScatterRow| Some(row.mean_error()? / row.mean_error_bound()?);
    let over: Vec<f64> = study.noise.iter().flat_map(|noise| &noise.single).filter_map(over).collect();
    let nodes = over.len();
    Some(match Span::of(over) {
        None => format!("{linear}."),
        Some(over) => format!(
            "{linear}; the nonlinear estimator, which has the simulated finger's own model, errs along the normal by {:.2} times the \
             Cramer-Rao bound of the noise (mean over {nodes} nodes).",
            over.mean
        ),
    })
}
