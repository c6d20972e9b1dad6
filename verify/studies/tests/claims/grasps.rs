//! Observations of grasps lead to confirming and to rejecting verdicts.

use finray_model::estimators::EstimatorId;
use finray_studies::claims::grasps::{crossing, left_right, order, pick_and_place, untouched};
use finray_studies::claims::{Claim, ClaimError, ClaimVerdict, Words};
use finray_studies::experiments::grasp::modules::{ModuleStep, ModuleTest, Untouched};
use finray_studies::experiments::grasp::observations::{Observations, Totals};

fn observed(left_right: f64, opening: f64, within: usize) -> Observations {
    let totals = |share| Totals {
        left_right: [share, 2.0 * share],
        opening: Some(0.0),
        opening_at_nodes: Some(opening),
        opening_sensed: Some(opening),
    };
    let found = |within| Untouched { count: 10, within, largest_n: 0.4 };
    Observations {
        noise_mm: 0.067,
        objects: vec![("disc".to_owned(), totals(0.01)), ("box".to_owned(), totals(left_right))],
        untouched: vec![(EstimatorId::LeastSquares, found(1)), (EstimatorId::Nonlinear, found(within))],
        beside_sensor: found(10),
    }
}

type Judge = fn(Option<&Observations>, &Words) -> Result<Claim, ClaimError>;

#[test]
fn a_verdict_on_grasps_is_that_of_its_figure() {
    use ClaimVerdict::{InSimulation, NotReproduced, NotTested};
    let words = Words::shipped().expect("words of the claims");
    let rows: [(Judge, Observations, Observations); 3] = [
        (left_right, observed(0.02, 0.0, 10), observed(0.2, 0.0, 10)),
        (pick_and_place, observed(0.0, 0.05, 10), observed(0.0, 0.15, 10)),
        (untouched, observed(0.0, 0.0, 10), observed(0.0, 0.0, 9)),
    ];
    for (judge, holds, fails) in rows {
        let of = |observed: Option<&Observations>| judge(observed, &words).expect("all numbers");
        let [yes, no, unknown] = [of(Some(&holds)), of(Some(&fails)), of(None)];
        assert_eq!([yes.verdict, no.verdict, unknown.verdict], [InSimulation, NotReproduced, NotTested], "{no:?}");
        assert!(!yes.criterion.is_empty() && unknown.criterion.is_empty() && unknown.ours == "-", "{unknown:?}");
        assert!(yes.how.contains("simulated") && !yes.ours.contains("none"), "{yes:?}");
    }
}

#[test]
fn forces_cross_in_the_paper_s_order_or_not() {
    let words = Words::shipped().expect("words of the claims");
    let test = |forces: &[[f64; 2]]| {
        let step = |(i, true_n): (usize, &[f64; 2])| ModuleStep {
            turned_deg: 100.0 * (i + 1) as f64,
            axis_deg: 0.0,
            true_n: true_n.to_vec(),
            sensed_n: Vec::new(),
        };
        ModuleTest { nodes: &[18, 20], steps: forces.iter().enumerate().map(step).collect() }
    };
    let verdict = |test: Option<&ModuleTest>| crossing(test, &words).expect("all numbers").verdict;
    let as_the_paper = test(&[[0.0, 0.5], [0.2, 0.8], [1.0, 0.9]]);
    assert_eq!(order(&as_the_paper), [Some(200.0), Some(300.0)]);
    assert_eq!(verdict(Some(&as_the_paper)), ClaimVerdict::InSimulation);
    for other in [test(&[[0.0, 0.5], [0.2, 0.8]]), test(&[[0.5, 0.0], [0.8, 0.2]]), test(&[[0.3, 0.5], [0.9, 0.8]])] {
        assert_eq!(verdict(Some(&other)), ClaimVerdict::NotReproduced, "{other:?}");
    }
    assert_eq!(verdict(None), ClaimVerdict::NotTested);
}
