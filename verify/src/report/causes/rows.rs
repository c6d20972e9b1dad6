//! Causes as rows: the file behind the section, and what the summary has of it.

use super::shares::{Region, Shares};
use crate::experiments::causes::{Cause, CauseCell, CauseMap};
use crate::study::Study;
use serde::Serialize;

/// How one way of sensing errs at one place and direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CauseRow {
    truth: &'static str,
    estimator: &'static str,
    contact: &'static str,
    s_mm: f64,
    angle_deg: f64,
    force_n: f64,
    /// Root mean square of sensed / true - 1.
    rms_error: Option<f64>,
    largest: Option<&'static str>,
    noise: Option<f64>,
    linearisation: Option<f64>,
    discretisation: Option<f64>,
    modulus: Option<f64>,
    direction: Option<f64>,
    place: Option<f64>,
    base_compliance: Option<f64>,
    tip_compliance: Option<f64>,
    network_fit: Option<f64>,
    rms_zones_and_modulus_known: Option<f64>,
    rms_and_contact_known: Option<f64>,
    rms_and_nonlinear: Option<f64>,
}

/// A region of a map in a few figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CauseSummary {
    /// Name of the truth.
    pub truth: &'static str,
    /// How it is sensed.
    pub estimator: &'static str,
    /// Whether place and direction of the contact are known or assumed.
    pub contact: &'static str,
    /// True force, N.
    pub force_n: f64,
    /// Which cells: near the base, middle, near the tip, along the normal; or all.
    pub region: &'static str,
    /// Number of cells.
    pub cells: usize,
    /// Those that are answered with every cause.
    pub answered: usize,
    /// Root mean square of sensed / true - 1 over these.
    pub rms_error: f64,
    /// The cause with the largest share of the mean square error.
    pub largest: Option<&'static str>,
    /// Its share; cells that are not answered without it count as if nothing went away.
    pub share: Option<f64>,
    /// Root mean square of sensed / true - 1 without it, over the cells that are answered then.
    pub rms_without: Option<f64>,
    /// Number of these.
    pub cells_without: Option<usize>,
}

pub(in crate::report) fn rows(study: &Study) -> Vec<CauseRow> {
    let of_map = |map: &CauseMap| {
        let row = |cell: &CauseCell| {
            let share = |cause: Cause| map.causes.iter().position(|other| *other == cause).and_then(|i| cell.shares[i]);
            let remedied = |taken: usize| cell.remedied.get(taken).copied().flatten();
            CauseRow {
                truth: map.truth,
                estimator: map.practice.name(),
                contact: map.contact.name(),
                s_mm: cell.s_mm,
                angle_deg: cell.angle_deg,
                force_n: cell.force_n,
                rms_error: cell.rms_error,
                largest: cell.largest().map(|(cause, _)| map.causes[cause].name()),
                noise: share(Cause::Noise),
                linearisation: share(Cause::Linearisation),
                discretisation: share(Cause::Discretisation),
                modulus: share(Cause::Modulus),
                direction: share(Cause::Direction),
                place: share(Cause::Place),
                base_compliance: share(Cause::BaseCompliance),
                tip_compliance: share(Cause::TipCompliance),
                network_fit: share(Cause::NetworkFit),
                rms_zones_and_modulus_known: remedied(0),
                rms_and_contact_known: remedied(1),
                rms_and_nonlinear: remedied(2),
            }
        };
        map.cells.iter().map(row).collect::<Vec<_>>()
    };
    study.causes.iter().flat_map(of_map).collect()
}

pub(in crate::report) fn summaries(study: &Study) -> Vec<CauseSummary> {
    let mut all = Vec::new();
    for map in &study.causes {
        for &force_n in &map.request.forces_n {
            for region in Region::ALL {
                let Some(shares) = Shares::of(&study.finger, map, force_n, region) else { continue };
                let largest = shares.largest();
                all.push(CauseSummary {
                    truth: map.truth,
                    estimator: map.practice.name(),
                    contact: map.contact.name(),
                    force_n,
                    region: region.name(),
                    rms_error: shares.rms_error,
                    cells: shares.cells,
                    answered: shares.answered,
                    largest: largest.map(|of| of.cause.name()),
                    share: largest.map(|of| of.share),
                    rms_without: largest.map(|of| of.rms_without),
                    cells_without: largest.map(|of| of.cells),
                });
            }
        }
    }
    all
}
