//! Number formats of the report.

use finray_report::format::{
    Span, capitalised, figure, percent, percent_two_digits, share_of_counts, span_in_words, time,
};

#[test]
fn shares_keep_two_digits_where_it_matters() {
    assert_eq!([0.0003, 0.0123, 0.123, -0.5].map(percent), ["0.03 %", "1.2 %", "12 %", "-50 %"]);
    assert_eq!([0.0, 1e-7, 0.00456].map(percent), ["0 %", "< 0.01 %", "0.46 %"]);
    assert_eq!([1e-6, 0.0016, 0.5, 1e-12].map(percent_two_digits), ["0.00010 %", "0.16 %", "50 %", "< 0.000001 %"]);
    assert_eq!([2.284e-4, 8.2e-6, 0.0123, 2.0].map(time), ["228 \u{b5}s", "8.20 \u{b5}s", "12.3 ms", "2.00 s"]);
    assert_eq!([0.000_123_4, 0.1234, 1234.5, 0.0].map(figure), ["1.23e-4", "0.1234", "1234", "0"]);
}

#[test]
fn sentences_begin_with_a_capital() {
    assert_eq!(["least squares", ""].map(capitalised), ["Least squares", ""]);
}

#[test]
fn seeds_that_agree_have_no_range() {
    assert_eq!(Span::of([0.3, 0.5]).map(span_in_words).as_deref(), Some("40 % (30\u{2013}50)"));
    assert_eq!(Span::of([0.02, 0.02]).map(span_in_words).as_deref(), Some("2.0 %"));
    assert_eq!(Span::of([]), None);
}

#[test]
fn refused_cases_are_a_share_of_all() {
    assert_eq!(share_of_counts([[0, 10], [5, 5]].into_iter()), "25 %");
    assert_eq!(share_of_counts([[0, 10]].into_iter()), "0");
}
