//! Limit points of equilibrium paths, found from determinants.

use super::*;

/// Determinants that fall to zero at a load share of 0.7, with a known power. Adds equilibria at the load shares that the approach requests.
fn approached(power: f64) -> (Approach, usize) {
    let mut approach = Approach::default();
    let mut share = 0.0;
    for steps in 1.. {
        approach.add(share, Some(30.0 + power * (1.0 - share / 0.7_f64).ln()));
        if approach.beyond().is_some() || steps == 40 {
            return (approach, steps);
        }
        share = approach.near().unwrap_or(share + 0.2).min(share + 0.2);
    }
    unreachable!("the loop ends")
}

#[test]
fn ends_are_found_from_determinants() {
    for (power, gap, most) in [(0.5, GAP_TO_FOLD, 12), (1.0, GAP_TO_OTHERS, 12), (2.0 / 3.0, GAP_TO_OTHERS, 16)] {
        let (approach, steps) = approached(power);
        let end = approach.predicted.expect("predicted");
        assert!((end.share / 0.7 - 1.0).abs() < gap, "{power}: {end:?}");
        assert!((end.power - power).abs() < 0.08, "{power}: {end:?}");
        assert!(approach.beyond().is_some_and(|beyond| beyond > 0.7) && steps <= most, "{power}: {steps} steps");
    }
}

#[test]
fn an_end_that_is_told_from_one_steep_fall_does_not_hold_the_path_up() {
    let mut approach = Approach::default();
    approach.add(0.0, Some(469.0));
    approach.add(0.5, Some(428.0));
    let near = approach.near().expect("a prediction");
    assert!(near >= 0.505 && approach.is_disproved_by(near), "{near}");
}

#[test]
fn a_stiffening_path_has_no_end() {
    let mut approach = Approach::default();
    for (share, log) in [(0.0, 5.0), (0.1, 4.9), (0.2, 5.1)] {
        assert!(approach.asks_for(share));
        approach.add(share, Some(log));
    }
    assert!(approach.near().is_none() && approach.beyond().is_none() && !approach.asks_for(0.2));
}
