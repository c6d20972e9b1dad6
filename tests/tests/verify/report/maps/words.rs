//! Medians of maps.

use finray_verify::report::maps::words::median;

#[test]
fn the_median_is_the_middle_one() {
    assert_eq!(median([3.0, 1.0, 2.0].into_iter()), Some(2.0));
    assert_eq!(median([4.0, 1.0, 2.0, 3.0].into_iter()), Some(2.5));
    assert_eq!(median(std::iter::empty()), None);
}
