//! Statements of the paper that the report checks, and their verdicts.

use crate::prelude::*;
use finray_studies::claims::{Claim, ClaimVerdict};

const CSV: &str = "claims.csv";
/// Meaning of the verdicts.
const ABOUT: &str = "Claims of Xu et al. (IEEE T-RO 2021) are compared with computations on models of the finger. \"Refuted\" means \
    that the model contradicts a statement about mechanics. \"Not reproduced\" means that the model does not yield a \
    measured value. \"Depends on assumption\" means that the verdict depends on something that the paper does not \
    state. \"In simulation\" and \"less error in simulation\" mean that the claim is true for a simulated finger whose \
    model is known, which does not contradict the measurement. claims.csv states how each verdict is computed.";

pub(super) fn datasets<'s>(Results { claims, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, claims)]
}

pub(super) fn section(Results { claims, .. }: Results) -> Result<Option<Section>, ReportError> {
    if claims.is_empty() {
        return Ok(None);
    }
    let columns = Columns::<&Claim>::new()
        .cells("verdict", Format::Words, |claim| verdict(claim.verdict))
        .page("claim", Format::Words, |claim| claim.claim.clone())
        .page("paper", Format::Words, |claim| claim.paper.clone())
        .page("ours", Format::Words, |claim| claim.ours.clone())
        .page("criterion", Format::Words, |claim| claim.criterion.clone());
    let refuted = claims.iter().filter(|claim| claim.verdict == ClaimVerdict::Refuted);
    let short = Columns::<&Claim>::new().page("refuted", Format::Words, |claim| claim.claim.clone());
    let short = short.page("ours", Format::Words, |claim| claim.ours.clone());
    let mut blocks = vec![text(ABOUT)];
    let short = short.table("Claims that the model contradicts", CSV, refuted);
    blocks.extend((!short.rows.is_empty()).then_some(Block::Table(short)));
    blocks.push(details("All claims", vec![Block::Table(columns.table("The paper's claims", CSV, claims))]));
    Ok(Some(Section::new("claims", "The paper's claims", blocks).saying([counted(claims)])))
}

/// A verdict as a coloured cell.
pub fn verdict(verdict: ClaimVerdict) -> Cell {
    let words = verdict.in_words();
    match verdict {
        ClaimVerdict::Reproduced => Cell::shaded(words, Shade::Pass),
        ClaimVerdict::Refuted | ClaimVerdict::NotReproduced => Cell::shaded(words, Shade::Fail),
        // `InSimulation`, `LessInSimulation`, `Depends` and `NotTested` neither confirm nor refute a measurement.
        ClaimVerdict::InSimulation
        | ClaimVerdict::LessInSimulation
        | ClaimVerdict::Depends
        | ClaimVerdict::NotTested => Cell::plain(words),
    }
}

/// Sentence with the number of claims by verdict.
pub fn counted(claims: &[Claim]) -> String {
    let counts = ClaimVerdict::ALL.map(|verdict| {
        let count = claims.iter().filter(|claim| claim.verdict == verdict).count();
        let words = match verdict {
            ClaimVerdict::Depends => "depend on assumptions",
            ClaimVerdict::InSimulation => "hold in simulation",
            ClaimVerdict::LessInSimulation => "err less in simulation",
            verdict => verdict.in_words(),
        };
        format!("{count} {words}")
    });
    format!("Of {} claims: {}.", claims.len(), counts.join(", "))
}
