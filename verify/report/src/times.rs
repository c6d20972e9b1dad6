//! Run time of each part of the report.

use crate::prelude::*;
use finray_studies::study::PartTime;

const CSV: &str = "report_times.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::new(CSV, &columns(), &study.parts)]
}

fn columns<'s>() -> Columns<'s, &'s PartTime> {
    let parts = Columns::<&PartTime>::new().both("part", "part", Format::Words, |of| of.part);
    parts.both("seconds", "s", Format::Fixed(1), |of| of.seconds)
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let all_s: f64 = study.parts.iter().map(|of| of.seconds).sum();
    let table = columns().table("Time of each part", CSV, &study.parts);
    let blocks = vec![details(format!("{all_s:.0} s, part by part"), vec![Block::Table(table)])];
    Ok(Some(Section::new("times", "How long this report took", blocks)))
}
