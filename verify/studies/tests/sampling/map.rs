//! Summaries of maps with refused cells and cells without equilibrium.

use finray_model::Finger;
use finray_model::estimators::EstimatorId;
use finray_model::finger::{Plate, RibPositions};
use finray_studies::sampling::map::{AccuracyMap, MapRequest};
use finray_studies::sampling::situation::Situation;
use finray_studies::sampling::sweep::MapCell;
use finray_studies::truths::TruthId;
use finray_tests::paper;

/// A map with one force, and one direction per cell. Each cell is given by error, number of samples and number of answers.
fn map(cells: &[(Option<f64>, usize, usize)]) -> AccuracyMap {
    let cell = |(n, &(mean_error, samples, answered)): (usize, &(Option<f64>, usize, usize))| MapCell {
        s_mm: 10.0,
        angle_deg: n as f64,
        force_n: 3.0,
        mean_error,
        bias: mean_error,
        spread: None,
        samples,
        answered,
        warned: None,
        covered: None,
        covered_warned: None,
    };
    AccuracyMap {
        request: MapRequest {
            positions_mm: vec![10.0],
            angles_deg: (0..cells.len()).map(|n| n as f64).collect(),
            is_leaning: false,
            forces_n: vec![3.0],
            noise_levels_mm: vec![0.1],
            noise_samples: 10,
            seed: 1,
        },
        truth: TruthId::Linear,
        estimator: EstimatorId::Network,
        situation: Situation::default(),
        noise_mm: 0.1,
        cells: cells.iter().enumerate().map(cell).collect(),
    }
}

#[test]
fn a_map_of_which_most_is_refused_is_not_a_good_one() {
    let mut cells = vec![(None, 10, 3); 11];
    cells.push((Some(0.0098), 10, 8));
    let summary = map(&cells).summary(Some(3.0));
    assert_eq!((summary.cells, summary.answered, summary.refused, summary.without_equilibrium), (12, 1, 11, 0));
    assert_eq!(summary.mean_error, Some(0.0098));
    assert_eq!((summary.share_above_10, summary.share_above_25), (Some(11.0 / 12.0), Some(11.0 / 12.0)));
    assert_eq!(summary.share_of_samples_refused, Some((120.0 - 41.0) / 120.0));
    assert_eq!(summary.counts(), "12 cells: 1 answered, 11 refused, 0 without equilibrium");
}

#[test]
fn a_cell_without_equilibrium_counts_in_no_share() {
    let summary = map(&[(None, 0, 0), (Some(0.2), 10, 10), (Some(0.01), 10, 10)]).summary(None);
    assert_eq!((summary.answered, summary.refused, summary.without_equilibrium), (2, 0, 1));
    assert_eq!((summary.share_above_10, summary.share_above_25), (Some(0.5), Some(0.0)));
    let nothing = map(&[(None, 0, 0)]).summary(None);
    assert_eq!((nothing.mean_error, nothing.share_above_10, nothing.share_of_samples_refused), (None, None, None));
}

#[test]
fn one_refused_force_refuses_the_mean_over_all() {
    let mut both = map(&[(Some(0.05), 10, 10), (None, 10, 1)]);
    both.request.forces_n = vec![1.0, 3.0];
    both.request.angles_deg = vec![0.0];
    (both.cells[0].force_n, both.cells[1].angle_deg) = (1.0, 0.0);
    let summary = both.summary(None);
    assert_eq!((summary.cells, summary.answered, summary.refused, summary.mean_error), (1, 0, 1, None));
    assert_eq!(both.summary(Some(1.0)).answered, 1);
}

/// For a finger without ribs, a rounding error once put the last position beyond the tip, and the report failed.
#[test]
fn a_grid_ends_at_the_tip() {
    let description = paper().description().clone();
    for tenths in 500..2000 {
        let mut description = description.clone();
        description.front_length_mm = f64::from(tenths) / 10.0;
        description.back_length_mm = description.front_length_mm;
        description.ribs.positions = RibPositions::Count(0);
        let finger = Finger::new(description).expect("a finger");
        let (positions_mm, _) = MapRequest::grid(&finger, 48, 90.0);
        assert_eq!(positions_mm.last(), Some(&finger.plate_length_mm(Plate::Front)));
    }
}
