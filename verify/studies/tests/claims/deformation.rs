//! Claims on deformation: the verdict on solid elements follows from the figures.

use finray_studies::claims::deformation::solid;
use finray_studies::claims::{ClaimVerdict, Words};
use finray_studies::experiments::continuum::{BeamTheoryRow, Constants, ContinuumStudy};

/// A study with these median deviations: beams with E, beams with plane strain, and beams with arms and shear.
fn study(medians: [f64; 3]) -> ContinuumStudy {
    let row = |(constants, median): (&Constants, f64)| BeamTheoryRow {
        continuum: "paper",
        constants: *constants,
        cases: 165,
        median,
        worst: 2.0 * median,
        load: 14,
        node: 13,
        scale: 1.0 + median,
    };
    ContinuumStudy { rows: Constants::ALL.iter().zip(medians).map(row).collect(), tables_one: Vec::new() }
}

#[test]
fn a_large_difference_must_be_large_with_and_without_plane_strain() {
    let words = Words::shipped().expect("texts");
    let verdict = |study: &ContinuumStudy| solid(study, &words).expect("a claim").verdict;
    assert_eq!(verdict(&study([0.59, 0.27, 0.003])), ClaimVerdict::Reproduced);
    assert_eq!(verdict(&study([0.59, 0.05, 0.003])), ClaimVerdict::Depends);
    assert_eq!(verdict(&study([0.05, 0.04, 0.003])), ClaimVerdict::Refuted);
    assert_eq!(verdict(&ContinuumStudy::default()), ClaimVerdict::NotTested);
    let said = solid(&study([0.59, 0.27, 0.003]), &words).expect("a claim").ours;
    assert!(said.contains("165 forces") && said.contains("59.0 %") && said.contains("27.0 %"), "{said}");
}
