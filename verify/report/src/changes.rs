//! What should a builder change? The trusted share of an unknown contact after one change at a time.

use super::format::{capitalised, percent};
use crate::prelude::*;
use finray_studies::experiments::changes::Change;

const CSV: &str = "changes.csv";

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, &study.changes)]
}

/// The present share, and the change with the largest share above it; of equal shares, the first. Conditions of use are no changes. `None` without
/// shares.
fn best(study: &Study) -> Option<(f64, Option<(f64, &Change)>)> {
    let changes = study.changes.iter().filter(|change| !change.is_condition);
    let shares = changes.filter_map(|change| Some((change.share_trusted?, change)));
    let best = shares.reduce(|most, next| if next.0 > most.0 { next } else { most })?;
    let now = study.changes[0].share_trusted?;
    Some((now, (best.0 > now).then_some(best)))
}

/// Sentence that names the change with the largest share.
pub(super) fn most(study: &Study) -> Option<String> {
    let (now, best) = best(study)?;
    Some(match best {
        Some((share, Change { change, .. })) => {
            format!("{}: {} instead of {}.", capitalised(change), percent(share), percent(now))
        }
        None => format!("No single change raises the share of {}.", percent(now)),
    })
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    if study.changes.is_empty() {
        return Ok(None);
    }
    let columns = Columns::<&Change>::new()
        .page("change", Format::Words, |change| change.change.as_str())
        .page("how", Format::Words, |change| change.means.as_str())
        .page("trusted", Format::Percent, |change| change.share_trusted);
    let caption = "Trusted share of an unknown contact after one change at a time, for this finger and camera. Every share counts as in the map \
                   of the unknown contact. The last two are conditions of use";
    let blocks = vec![Block::Table(columns.table(caption, CSV, &study.changes))];
    let heading = match best(study) {
        Some((_, Some((_, best)))) => format!("What should I change? Most is gained by: {}", best.change),
        _ => "What should I change?".to_owned(),
    };
    Ok(Some(Section::new("changes", &heading, blocks)))
}
