//! The paper's claims, and what became of them.

use super::page::{Block, Cell, Column, Row, Section, Shade, Table};
use super::sections::{self, text};
use crate::claims::{Claim, ClaimVerdict};

pub(super) const CSV: &str = "claims.csv";

pub(super) fn section(claims: &[Claim]) -> Option<Section> {
    if claims.is_empty() {
        return None;
    }
    let blocks = vec![
        text(
            "What Xu et al. (IEEE T-RO 2021) say, in their words where they stand in quotation marks, and what the computations of this report \
             say to it. All are made on models of the finger, not on the finger. \"Refuted\" is a statement about its mechanics that the model \
             contradicts; \"not reproduced\" a measured figure that the model does not give; \"depends on assumption\" what turns with something that \
             the paper leaves open; \"in simulation\" what holds on a simulated finger; \"less error in simulation\" what is sensed better than the \
             paper measured, on a simulated finger whose model is known: that says nothing against the measurement.",
        ),
        text(counted(claims)),
        Block::Table(Table {
            caption: "The paper's claims".to_owned(),
            columns: ["claim", "paper", "ours", "how", "criterion", "verdict"].map(Column::words).into(),
            rows: claims.iter().map(row).collect(),
            csv: Some(CSV.to_owned()),
        }),
    ];
    Some(sections::section("claims", "The paper's claims, one by one", blocks))
}

fn row(claim: &Claim) -> Row {
    let words =
        [&claim.claim, &claim.paper, &claim.ours, &claim.how, &claim.criterion].map(|text| Cell::plain(text.as_str()));
    let verdict = claim.verdict.in_words();
    let verdict = match claim.verdict {
        ClaimVerdict::Reproduced => Cell::shaded(verdict, Shade::Pass),
        ClaimVerdict::Refuted | ClaimVerdict::NotReproduced => Cell::shaded(verdict, Shade::Fail),
        ClaimVerdict::InSimulation
        | ClaimVerdict::LessInSimulation
        | ClaimVerdict::Depends
        | ClaimVerdict::NotTested => Cell::plain(verdict),
    };
    Row { cells: words.into_iter().chain([verdict]).collect() }
}

/// How many claims came to what.
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
        // What a simulation betters is no success against a measurement.
        assert_eq!(row(&claims[0]).cells[5], Cell::plain("in simulation"));
        assert_eq!(row(&claims[1]).cells[5], Cell::shaded("refuted", Shade::Fail));
    }
}
