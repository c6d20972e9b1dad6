//! Times of frames, as streams state them.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// Names of a time, each with the number of its units in a second; `None` for a name without a unit, whose times are texts in ISO 8601.
const NAMES: [(&str, Option<f64>); 11] = [
    ("t_s", Some(1.0)),
    ("time_s", Some(1.0)),
    ("t_ms", Some(1e3)),
    ("time_ms", Some(1e3)),
    ("t_us", Some(1e6)),
    ("time_us", Some(1e6)),
    ("t_ns", Some(1e9)),
    ("time_ns", Some(1e9)),
    ("time", None),
    ("timestamp", None),
    ("stamp", None),
];
/// Latest time of a frame, s; the limit exists because recordings store times as nanoseconds in 64 bits.
const LATEST_S: f64 = 1e10;

/// Column or key of a frame's time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeName {
    pub name: &'static str,
    per_second: Option<f64>,
}

impl TimeName {
    /// The first name of a time that a stream has.
    pub fn first(has: impl Fn(&str) -> bool) -> Option<TimeName> {
        let (name, per_second) = NAMES.into_iter().find(|(name, _)| has(name))?;
        Some(TimeName { name, per_second })
    }

    /// The time in s from its text: a number in the unit that the name states, or a time in ISO 8601.
    ///
    /// # Errors
    /// A message for a text of another form, and for a time before 0 or after 1e10 s.
    pub fn seconds(self, text: &str) -> Result<f64, String> {
        // A number may have a decimal comma, as in ISO 8601.
        let text = &text.replace(',', ".");
        let counted = self.per_second.and_then(|per_second| counted(text, per_second));
        let time_s = counted.or_else(|| iso_8601(text)).filter(|time_s| (0.0..=LATEST_S).contains(time_s));
        time_s.ok_or_else(|| match self.per_second {
            Some(_) => {
                let (_, unit) = self.name.rsplit_once('_').unwrap_or_default();
                format!("{}: expected a time in {unit} of 0 or more, or in ISO 8601, found {text:?}", self.name)
            }
            None => format!(
                "{}: expected a time in ISO 8601 such as 2026-11-28T14:05:00.25Z, found {text:?}; the name of a number states its unit: time_s, \
                 time_ms, time_us or time_ns",
                self.name
            ),
        })
    }
}

/// Seconds of a number of units. Whole seconds of a whole number are exact, because nanoseconds since 1970 have more digits than a float.
fn counted(text: &str, per_second: f64) -> Option<f64> {
    let Ok(count) = text.parse::<u64>() else { return Some(text.parse::<f64>().ok()? / per_second) };
    let units = per_second as u64;
    Some((count / units) as f64 + (count % units) as f64 / per_second)
}

/// Seconds since 1970-01-01T00:00:00Z of a time in ISO 8601 with date and clock. A time without an offset is taken as UTC.
fn iso_8601(text: &str) -> Option<f64> {
    let without_offset = || Some(text.parse::<DateTime>().ok()?.to_zoned(TimeZone::UTC).ok()?.timestamp());
    let time = text.parse::<Timestamp>().ok().or_else(without_offset).filter(|_| text.contains(':'))?;
    Some(time.as_second() as f64 + f64::from(time.subsec_nanosecond()) / 1e9)
}
