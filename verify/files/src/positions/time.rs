//! Times of frames, as streams state them.

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
const DAY_S: f64 = 86_400.0;

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

/// Seconds since 1970-01-01T00:00:00Z of a time `YYYY-MM-DDThh:mm[:ss[.fraction]][Z|+hh:mm|-hh:mm]`. A space may replace the T. A time without an offset
/// is taken as UTC.
fn iso_8601(text: &str) -> Option<f64> {
    let (date, clock) = text.split_once(['T', 't', ' '])?;
    let [year, month, day] = numbers(date, '-')?[..] else { return None };
    let (clock, offset_s) = match clock.find(['Z', 'z', '+', '-']) {
        None => (clock, 0.0),
        Some(at) if matches!(&clock[at..], "Z" | "z") => (&clock[..at], 0.0),
        Some(at) => {
            let sign = if clock.as_bytes()[at] == b'-' { -1.0 } else { 1.0 };
            let [hours, minutes] = numbers(&clock[at + 1..], ':')?[..] else { return None };
            (&clock[..at], sign * (3600.0 * hours + 60.0 * minutes))
        }
    };
    let [hour, minute, second] = match numbers(clock, ':')?[..] {
        [hour, minute] => [hour, minute, 0.0],
        [hour, minute, second] => [hour, minute, second],
        _ => return None,
    };
    let is_whole = [year, month, day, hour, minute].iter().all(|number| number.fract() == 0.0);
    let is_date = (1.0..=12.0).contains(&month) && (1.0..=31.0).contains(&day) && (1970.0..=2286.0).contains(&year);
    if !is_whole || !is_date || hour > 24.0 || minute >= 60.0 || second >= 61.0 {
        return None;
    }
    let days = days_since_1970(year as i64, month as i64, day as i64) as f64;
    Some(DAY_S * days + 3600.0 * hour + 60.0 * minute + second - offset_s)
}

/// Numbers of digits, of which the last may have a fraction, with a separator between them.
fn numbers(text: &str, separator: char) -> Option<Vec<f64>> {
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    text.split(separator).map(|part| part.parse().ok().filter(|_| is_number(part))).collect()
}

/// Days from 1970-01-01 to a date of the Gregorian calendar.
///
/// # Reference
/// E. M. Reingold, N. Dershowitz, Calendrical Calculations (2018), eq. (2.17), with the year beginning in March.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month < 3 { year - 1 } else { year };
    let of_months = (153 * ((month + 9) % 12) + 2) / 5;
    365 * year + year / 4 - year / 100 + year / 400 + of_months + day - 719_469
}
