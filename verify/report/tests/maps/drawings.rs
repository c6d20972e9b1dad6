//! Tests of the notes in the overview: refused cells do not count as trusted.

use finray_report::maps::drawings::note;
use finray_studies::sampling::worst::TrustCounts;

#[test]
fn refused_cells_are_said_and_count_as_not_trusted() {
    let counts =
        |cells, trusted, refused, without_equilibrium| TrustCounts { cells, trusted, refused, without_equilibrium };
    assert_eq!(note(counts(12, 1, 11, 0)), "8 % of 12 trusted, 92 % refused");
    assert_eq!(note(counts(10, 4, 0, 2)), "50 % of 8 trusted");
    assert_eq!(note(counts(10, 0, 0, 10)), "no equilibrium");
}
