//! The paper's claims and their verdicts.

use super::dataset::{Columns, Dataset, Format};
use super::page::{Block, Cell, Column, Section, Shade, text};
use super::{ReportError, Results};
use crate::claims::{Claim, ClaimVerdict};

const CSV: &str = "claims.csv";

pub(super) fn datasets<'s>(Results { claims, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::records(CSV, claims)]
}

pub(super) fn section(Results { claims, .. }: Results) -> Result<Option<Section>, ReportError> {
    if claims.is_empty() {
        return Ok(None);
    }
    let columns = Columns::<&Claim>::new()
        .page("claim", Format::Words, |claim| claim.claim.clone())
        .page("paper", Format::Words, |claim| claim.paper.clone())
        .page("ours", Format::Words, |claim| claim.ours.clone())
        .page("how", Format::Words, |claim| claim.how.clone())
        .page("criterion", Format::Words, |claim| claim.criterion.clone())
        .cells(Column::words("verdict"), |claim| verdict(claim.verdict));
    let blocks = vec![
        text(
            "What Xu et al. (IEEE T-RO 2021) say, in their words where they stand in quotation marks, and what the computations of this report \
             say to it. All are made on models of the finger, not on the finger. \"Refuted\" is a statement about its mechanics that the model \
             contradicts; \"not reproduced\" a measured figure that the model does not give; \"depends on assumption\" what turns with something that \
             the paper leaves open; \"in simulation\" what holds on a simulated finger; \"less error in simulation\" what is sensed better than the \
             paper measured, on a simulated finger whose model is known: that says nothing against the measurement.",
        ),
        text(counted(claims)),
        Block::Table(columns.table("The paper's claims", CSV, claims)),
    ];
    Ok(Some(Section::new("claims", "The paper's claims, one by one", blocks)))
}

fn verdict(verdict: ClaimVerdict) -> Cell {
    let words = verdict.in_words();
    match verdict {
        ClaimVerdict::Reproduced => Cell::shaded(words, Shade::Pass),
        ClaimVerdict::Refuted | ClaimVerdict::NotReproduced => Cell::shaded(words, Shade::Fail),
        // What a simulation betters is no success against a measurement.
        ClaimVerdict::InSimulation
        | ClaimVerdict::LessInSimulation
        | ClaimVerdict::Depends
        | ClaimVerdict::NotTested => Cell::plain(words),
    }
}

/// Number of claims by verdict.
fn counted(claims: &[Claim]) -> String {
    let counts = ClaimVerdict::ALL.map(|verdict| {
        let count = claims.iter().filter(|claim| claim.verdict == verdict).count();
        format!("{count} {}", verdict.in_words())
    });
    format!("Of {} claims: {}.", claims.len(), counts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claims_are_counted_by_verdict() {
        let claim = |verdict| Claim {
            claim: "a".into(),
            paper: "1".into(),
            ours: "2".into(),
            how: "so".into(),
            criterion: "less".into(),
            verdict,
        };
        let claims = [ClaimVerdict::InSimulation, ClaimVerdict::Refuted, ClaimVerdict::InSimulation].map(claim);
        let words = counted(&claims);
        assert!(
            words.contains("Of 3 claims") && words.contains("2 in simulation") && words.contains("1 refuted"),
            "{words}"
        );
        assert!(words.contains("0 reproduced"), "{words}");
        assert_eq!(super::verdict(ClaimVerdict::InSimulation), Cell::plain("in simulation"));
        assert_eq!(super::verdict(ClaimVerdict::Refuted), Cell::shaded("refuted", Shade::Fail));
    }
}
