//! Means and medians of short and empty lists.

use finray_studies::statistics::{Span, mean, median, rms};

#[test]
fn the_median_is_the_middle_one() {
    assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
    assert_eq!(median([4.0, 1.0, 2.0, 3.0]), Some(2.5));
    assert_eq!(median([]), None);
}

#[test]
fn of_nothing_there_is_no_mean() {
    assert_eq!((mean([1.0, 2.0, 6.0]), rms([1.0, -7.0])), (Some(3.0), Some(5.0)));
    assert_eq!((mean([]), rms([]), Span::of([])), (None, None, None));
    assert_eq!(Span::of([1.0, -7.0]).map(Span::ends), Some([-7.0, 1.0]));
}
