//! Number formats of the report, each defined once.

pub use finray_studies::statistics::Span;

use super::page::{Cell, Shade};
use finray_model::finger::Strip;
use finray_studies::settings::{GROSS_ERROR, TRUSTED_ERROR};

/// Text for a missing number.
pub const NOTHING: &str = "-";

/// A number with four significant digits; very small or large numbers have a power of ten.
pub fn figure(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = if size == 0.0 { 0 } else { (3 - size.log10().floor() as i32).clamp(0, 7) as usize };
    format!("{value:.digits$}")
}

/// A share in percent: two decimals below 1 %, one decimal below 10 %, otherwise none. A share below 0.01 % is written as `< 0.01 %`.
pub fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        0.0 => "0 %".to_owned(),
        p if p < 0.01 => "< 0.01 %".to_owned(),
        p if p < 0.95 => percent_with(share, 2),
        p if p < 9.95 => percent_with(share, 1),
        _ => percent_with(share, 0),
    }
}

/// A share in percent with this number of decimals.
pub fn percent_with(share: f64, decimals: usize) -> String {
    format!("{:.decimals$} %", 100.0 * share)
}

/// A share in percent with at least two significant digits, down to 0.000001 %.
pub fn percent_two_digits(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".to_owned(),
        p if p < 1e-6 => "< 0.000001 %".to_owned(),
        p => percent_with(share, (1.0 - p.log10().floor()).max(0.0) as usize),
    }
}

/// A time with three significant digits, such as `228 \u{b5}s`.
pub fn time(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (1e6 * s, "\u{b5}s"),
        s if s < 1.0 => (1e3 * s, "ms"),
        s => (s, "s"),
    };
    let digits = (2.0 - value.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{value:.digits$} {unit}")
}

/// An error in percent. The cell is amber above 10 % and red above 25 %, with the shades of the paper's Table I.
pub fn error(share: f64) -> Cell {
    let shade = match share {
        e if e > GROSS_ERROR => Some(Shade::Red),
        e if e > TRUSTED_ERROR => Some(Shade::Amber),
        _ => None,
    };
    Cell { shade, ..Cell::plain(percent(share)) }
}

/// An error as text, with the colour that [`error`] gives the share.
pub fn error_as(words: impl Into<String>, share: f64) -> Cell {
    Cell { text: words.into(), ..error(share) }
}

/// The value as text, or [`NOTHING`] if the value is missing.
pub fn or_nothing(value: Option<impl ToString>) -> String {
    value.map_or_else(|| NOTHING.to_owned(), |value| value.to_string())
}

/// Cell that says whether a tolerance holds: the text `kept` in green or `broken` in red.
pub fn verdict(holds: bool, [kept, broken]: [&str; 2]) -> Cell {
    if holds { Cell::shaded(kept, Shade::Pass) } else { Cell::shaded(broken, Shade::Fail) }
}

/// The text with a capital first letter.
pub fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Items joined by the text `between`.
pub fn list<T: ToString>(items: impl IntoIterator<Item = T>, between: &str) -> String {
    items.into_iter().map(|item| item.to_string()).collect::<Vec<_>>().join(between)
}

/// Share of refused cases, from pairs of counts (refused, answered); `0` if no case is refused.
pub fn share_of_counts(counts: impl Iterator<Item = [usize; 2]>) -> String {
    let [refused, answered] = counts.fold([0, 0], |[r, a], [refused, answered]| [r + refused, a + answered]);
    if refused == 0 { "0".to_owned() } else { percent(refused as f64 / (refused + answered) as f64) }
}

/// Mean, least and greatest value of a span as text, such as `5.1 % (4.2\u{2013}6.0)`.
pub fn span_in_words(span: Span) -> String {
    let bare = |share: f64| percent(share).trim_end_matches(" %").to_owned();
    let [least, greatest] = [span.least, span.greatest].map(bare);
    match least == greatest {
        true => percent(span.mean),
        false => format!("{} ({least}\u{2013}{greatest})", percent(span.mean)),
    }
}

/// Least and greatest value of a span as text, such as `4.2 % to 6.0 %`.
pub fn range_of(span: Span) -> String {
    format!("{} to {}", percent(span.least), percent(span.greatest))
}

/// Thickness of a plate, mm, from base to tip.
pub(super) fn thickness(Strip { thickness_mm, tip_thickness_mm, .. }: &Strip) -> String {
    match tip_thickness_mm {
        Some(tip_mm) => format!("{thickness_mm} to {tip_mm}"),
        None => thickness_mm.to_string(),
    }
}
