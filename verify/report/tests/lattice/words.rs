//! Sentences about the lattice follow from its study.

use super::samples::sample;
use finray_report::lattice::words::{findings, precision, verdict};

#[test]
fn findings_are_made_from_the_numbers() {
    let mut study = sample();
    study.sensing.difference.largest = 1e-5;
    let said = findings(&study).join("\n");
    for words in [
        "From 2 to 4 segments per plate member, the difference from beams falls from 0.16 % to 0.010 %. The order of convergence in \
         the segment length is 3.0 to 4.0: at least second order",
        "by 10 % at 1 N and by 50 % at 5 N",
        "Sensing on the lattice agrees with the uniform finger over 1 forces of the maps",
        "senses forces on the lattice within 0.040 %",
    ] {
        assert!(said.contains(words), "{words} is not in {said}");
    }
    let head = verdict(&study).expect("a sentence");
    assert!(
        head.contains("within 0.010 % of the largest displacement up to 5 N")
            && head.contains("within 0.0010 % of the force"),
        "{head}"
    );
    assert!(precision(&study).contains("up to 0.060 % of the load"));
    study.rows[1].errors = vec![4e-4, 1e-4];
    study.sensing.difference.largest = 0.1;
    let said = findings(&study).join("\n");
    assert!(said.contains("another difference remains") && said.contains("lattice DOES NOT AGREE"), "{said}");
}
