//! Datasets of the causes: the CSV file of the section, and its part of the summary.

use super::CSV;
use super::shares::{CauseShare, Region, Shares};
use crate::prelude::*;
use finray_studies::experiments::causes::{Cause, CauseCell, CauseMap};

/// Errors at each position and direction for each estimator: root mean squares of sensed / true - 1, and shares of the causes.
pub(super) fn by_cell(study: &Study) -> Dataset<'_> {
    type Row<'s> = (&'s CauseMap, &'s CauseCell);
    const SHARES: [(&str, Cause); 8] = [
        ("noise", Cause::Noise),
        ("linearisation", Cause::Linearisation),
        ("modulus", Cause::Modulus),
        ("direction", Cause::Direction),
        ("place", Cause::Position),
        ("base_compliance", Cause::BaseCompliance),
        ("tip_compliance", Cause::TipCompliance),
        ("network_fit", Cause::NetworkFit),
    ];
    const REMEDIED: [&str; 3] = ["rms_zones_and_modulus_known", "rms_and_contact_known", "rms_and_nonlinear"];
    let share = |map: &CauseMap, cell: &CauseCell, cause: Cause| {
        map.causes.iter().position(|other| *other == cause).and_then(|i| cell.shares[i])
    };
    let columns = Columns::<Row>::new()
        .file("truth", |(map, _)| map.truth.name())
        .file("estimator", |(map, _)| map.practice.estimator().name())
        .file("contact", |(map, _)| map.contact.name())
        .file("s_mm", |(_, cell)| cell.s_mm)
        .file("angle_deg", |(_, cell)| cell.angle_deg)
        .file("force_n", |(_, cell)| cell.force_n)
        .file("rms_error", |(_, cell)| cell.rms_error)
        .file("largest", |(map, cell)| cell.largest().map(|(cause, _)| map.causes[cause].name()))
        .each(SHARES, |columns, (key, cause)| columns.file(key, move |(map, cell)| share(map, cell, cause)))
        .each(REMEDIED.into_iter().enumerate(), |columns, (taken, key)| {
            columns.file(key, move |(_, cell)| cell.remedied.get(taken).copied().flatten())
        });
    let cells = study.causes.iter().flat_map(|map| map.cells.iter().map(move |cell| (map, cell)));
    Dataset::new(CSV, &columns, cells).csv_alone()
}

/// Key figures of each map by region (near base, middle, near tip, all): answered cells, error and largest cause.
pub(super) fn by_region(study: &Study) -> Dataset<'_> {
    struct Row<'s> {
        map: &'s CauseMap,
        force_n: f64,
        region: Region,
        shares: Shares,
        largest: Option<CauseShare>,
    }
    let rows = study.causes.iter().flat_map(|map| map.request.forces_n.iter().map(move |force_n| (map, *force_n)));
    let rows = rows.flat_map(|(map, force_n)| Region::ALL.map(|region| (map, force_n, region))).filter_map(
        |(map, force_n, region)| {
            let shares = Shares::of(&study.finger, map, force_n, region)?;
            Some(Row { map, force_n, region, largest: shares.largest(), shares })
        },
    );
    let columns = Columns::<Row>::new()
        .file("truth", |row| row.map.truth.name())
        .file("estimator", |row| row.map.practice.estimator().name())
        .file("contact", |row| row.map.contact.name())
        .file("force_n", |row| row.force_n)
        .file("region", |row| row.region.name())
        .file("cells", |row| row.shares.cells)
        .file("answered", |row| row.shares.answered)
        .file("rms_error", |row| row.shares.rms_error)
        .file("largest", |row| Some(row.largest?.cause.name()))
        .file("share", |row| Some(row.largest?.share))
        .file("rms_without", |row| Some(row.largest?.rms_without))
        .file("cells_without", |row| Some(row.largest?.cells));
    Dataset::new(CSV, &columns, rows).summary_alone()
}
