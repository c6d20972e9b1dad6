//! Tests of the notes in the overview: refused cells do not count as trusted.

use finray_report::maps::drawings::note;
use finray_studies::sampling::sweep::CellState;
use finray_studies::sampling::trust::{TrustShare, WorstCell};

#[test]
fn refused_cells_are_said_and_count_as_not_trusted() {
    let cells = |state: CellState, is_trusted: bool, weight: f64| WorstCell {
        s_mm: 10.0,
        angle_deg: 0.0,
        state,
        worst_error: None,
        is_trusted,
        refused_samples: if state == CellState::Refused { 0.75 } else { 0.0 },
        warned_samples: 0.0,
        weight,
    };
    let trusted = cells(CellState::Answered, true, 1.0);
    let refused = cells(CellState::Refused, false, 11.0);
    assert_eq!(note(&TrustShare::of(&[trusted, refused])), "8 % trusted, 92 % refused");
    assert_eq!(TrustShare::of(&[trusted, refused]).samples(), Some([0.75 * 11.0 / 12.0, 0.0]));
    let wrong = cells(CellState::Answered, false, 1.0);
    let folded = cells(CellState::WithoutEquilibrium, false, 2.0);
    assert_eq!(note(&TrustShare::of(&[trusted, wrong, folded])), "50 % trusted");
    assert_eq!(note(&TrustShare::of(&[folded])), "no equilibrium");
    // A direction that friction does not allow counts nowhere.
    let outside = cells(CellState::Refused, false, 0.0);
    assert_eq!(TrustShare::of(&[trusted, outside]), TrustShare::of(&[trusted]));
}
