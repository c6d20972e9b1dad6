//! Tests that each criterion can both confirm and reject its claim.

use finray_studies::claims::ClaimVerdict::{
    Depends, InSimulation, LessInSimulation, NotReproduced, NotTested, Refuted, Reproduced,
};
use finray_studies::claims::criteria::{
    accounts_for, all_simulated, at_most_nodes, figure, in_simulation, over_assumptions, recalibration, simulated,
    statement,
};

#[test]
fn every_kind_of_claim_can_go_either_way() {
    assert_eq!((statement(true), statement(false)), (Reproduced, Refuted));
    assert_eq!((figure(true), figure(false)), (Reproduced, NotReproduced));
    assert_eq!((simulated(0.01, 0.2), simulated(0.3, 0.2)), (LessInSimulation, NotReproduced));
    assert_eq!((in_simulation(true), in_simulation(false)), (InSimulation, NotReproduced));
    assert_eq!(simulated(f64::NAN, 0.2), NotReproduced);
    assert_eq!(all_simulated(&[(0.01, 0.2), (0.02, 0.1)]), LessInSimulation);
    assert_eq!(all_simulated(&[(0.01, 0.2), (0.2, 0.1)]), NotReproduced);
    assert_eq!(all_simulated(&[]), NotTested);
    assert_eq!(recalibration([0.02, 0.06], [0.3, 0.25]), InSimulation);
    assert_eq!(recalibration([0.02, 0.01], [0.3, 0.25]), NotReproduced);
    assert_eq!(recalibration([0.02, 0.06], [0.3, 0.31]), NotReproduced);
}

#[test]
fn a_verdict_that_an_assumption_turns_depends_on_it() {
    assert_eq!(over_assumptions(&[Reproduced, Reproduced]), Reproduced);
    assert_eq!(over_assumptions(&[Refuted, Reproduced]), Depends);
    assert_eq!(over_assumptions(&[NotReproduced]), NotReproduced);
    assert_eq!(over_assumptions(&[]), NotTested);
}

#[test]
fn a_statement_about_nodes_holds_at_most_of_them() {
    assert_eq!(at_most_nodes(&[0.1, 0.2, 0.9], |x| x < 0.5), (2, true));
    assert_eq!(at_most_nodes(&[0.1, 0.9], |x| x < 0.5), (1, false));
    assert_eq!(at_most_nodes(&[], |x| x < 0.5), (0, false));
    assert_eq!(at_most_nodes(&[f64::NAN], |x| x < 0.5), (0, false));
}

#[test]
fn a_cause_accounts_for_most_of_every_error() {
    assert!(accounts_for(&[(0.3, 0.563), (0.07, 0.121)]));
    assert!(!accounts_for(&[(0.3, 0.563), (0.05, 0.121)]));
    assert!(!accounts_for(&[]));
}
