//! The lattice compared with beams, as in the report.

use crate::check::assert_all_pass;
use finray_studies::problems::lattice;
use finray_tests::paper;

/// The report's checks compare the lattice with beams, linear theory and settled shapes, and test repeatability.
#[test]
fn paper_finger_is_that_of_beams() {
    let checks = lattice::checks(&paper()).expect("every load has an equilibrium");
    // Checks: six forces, linear theory, settling, two forces on the settled lattice, and identical bits of two runs.
    assert_eq!(checks.len(), 11);
    assert_all_pass(&checks);
}

/// For large forces, linear theory must differ from the lattice: by more than a tenth at 5 N.
#[test]
fn linear_beams_part_from_the_lattice() {
    let comparisons = lattice::comparisons(&paper()).expect("every load has an equilibrium");
    assert!(comparisons.windows(2).all(|pair| pair[0].ours < pair[1].ours), "{comparisons:?}");
    assert!(comparisons.last().is_some_and(|last| last.ours > 0.1), "{comparisons:?}");
}
