//! The paper's claims, and what became of them.

use super::page::{Block, Cell, Column, Row, Section, Shade, Table};
use super::sections::{self, text};
use crate::ledger::{Claim, ClaimVerdict};
use crate::study::Study;

pub(super) const CSV: &str = "claims.csv";

pub(super) fn section(study: &Study) -> Option<Section> {
    if study.claims.is_empty() {
        return None;
    }
    let blocks = vec![
        text(
            "What Xu et al. (IEEE T-RO 2021) say, and what the computations of this report say to it. They are made on models of the finger, \
             not on the finger: \"better\" and \"refuted\" hold as far as the finger is what its model takes it for.",
        ),
        text(counted(&study.claims)),
        Block::Table(Table {
            caption: "The paper's claims".to_owned(),
            columns: ["claim", "paper", "ours", "how", "verdict"].map(Column::words).into(),
            rows: study.claims.iter().map(row).collect(),
            csv: Some(CSV.to_owned()),
        }),
    ];
    Some(sections::section("claims", "The paper's claims, one by one", blocks))
}

fn row(claim: &Claim) -> Row {
    let words = [&claim.claim, &claim.paper, &claim.ours, &claim.how].map(|text| Cell::plain(text.as_str()));
    let verdict = claim.verdict.in_words();
    let verdict = match claim.verdict {
        ClaimVerdict::Reproduced | ClaimVerdict::Better | ClaimVerdict::Explained => Cell::shaded(verdict, Shade::Pass),
        ClaimVerdict::Refuted => Cell::shaded(verdict, Shade::Fail),
        ClaimVerdict::NotTestableHere => Cell::plain(verdict),
    };
    Row { cells: words.into_iter().chain([verdict]).collect() }
}

/// How many claims came to what.
fn counted(claims: &[Claim]) -> String {
    use ClaimVerdict::{Better, Explained, NotTestableHere, Refuted, Reproduced};
    let counts = [Reproduced, Better, Explained, Refuted, NotTestableHere].map(|verdict| {
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
        let claim =
            |verdict| Claim { claim: "a".into(), paper: "1".into(), ours: "2".into(), how: "so".into(), verdict };
        let claims = [ClaimVerdict::Better, ClaimVerdict::Refuted, ClaimVerdict::Better].map(claim);
        let words = counted(&claims);
        assert!(words.contains("Of 3 claims") && words.contains("2 better") && words.contains("1 refuted"), "{words}");
        assert!(words.contains("0 reproduced"), "{words}");
        assert_eq!(row(&claims[1]).cells[4], Cell::shaded("refuted", Shade::Fail));
    }
}
