//! Claims are counted by verdict.

use finray_report::claims::counted;
use finray_report::page::{Cell, Shade};
use finray_studies::claims::{Claim, ClaimVerdict};

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
        words.contains("Of 3 claims") && words.contains("2 hold in simulation") && words.contains("1 refuted"),
        "{words}"
    );
    assert!(words.contains("0 reproduced"), "{words}");
    assert_eq!(finray_report::claims::verdict(ClaimVerdict::InSimulation), Cell::plain("in simulation"));
    assert_eq!(finray_report::claims::verdict(ClaimVerdict::Refuted), Cell::shaded("refuted", Shade::Fail));
}
