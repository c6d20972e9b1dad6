//! Numbers and lists of numbers, with quantity, unit and range.

use super::{Kind, Refused, described, refused};
use crate::keys::with_article;
use toml::de::DeValue;

/// Name of a physical quantity, and its unit; the unit is empty for a dimensionless quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity(pub &'static str, pub &'static str);

/// Range of valid numbers. Two ranges exclude subnormal numbers, which have too few digits: [`Positive`](Range::Positive), and
/// [`Within`](Range::Within) with the lower limit 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Any finite number.
    Finite,
    /// A range that depends on other values; the text describes the range. The code that reads the other values checks the range.
    ByOthers(&'static str),
    /// Above zero, up to and including this limit.
    Positive(f64),
    /// Above the first limit (excluded), up to the second (included).
    Above(f64, f64),
    /// Between two limits, both included.
    Within(f64, f64),
    /// Between two limits, both excluded.
    Between(f64, f64),
    /// Magnitude up to and including this limit.
    AtMost(f64),
    /// Whole numbers between two limits, both included.
    Whole(f64, f64),
}

impl Range {
    /// Zero or more.
    pub const NOT_NEGATIVE: Range = Range::Within(0.0, f64::INFINITY);
    /// Above zero.
    pub const POSITIVE: Range = Range::Positive(f64::INFINITY);

    /// Whether a number is in the range.
    pub fn contains(self, x: f64) -> bool {
        match self {
            Range::Finite => x.is_finite(),
            Range::ByOthers(_) => true,
            Range::Positive(most) => x.is_normal() && 0.0 < x && x <= most,
            Range::Above(least, most) => least < x && x <= most,
            Range::Within(0.0, most) => x == 0.0 || Range::Positive(most).contains(x),
            Range::Within(least, most) => (least..=most).contains(&x),
            Range::Between(least, most) => least < x && x < most,
            Range::AtMost(most) => x.abs() <= most,
            Range::Whole(least, most) => x.fract() == 0.0 && (least..=most).contains(&x),
        }
    }

    /// Description of quantity, unit and range, without an article.
    fn of(self, quantity: Quantity) -> String {
        let noun = quantity.noun();
        match self {
            Range::Finite => format!("finite {noun}"),
            Range::ByOthers(limits) => format!("{noun}, {limits}"),
            Range::Positive(most) if most.is_infinite() => format!("positive {noun}"),
            Range::Positive(most) => format!("{noun} above zero, up to {most}"),
            Range::Above(least, most) => format!("{noun} above {least} and up to {most}"),
            Range::Within(_, most) if most.is_infinite() => format!("{noun}, zero or more"),
            Range::Within(least, most) => format!("{noun}, {least} to {most}"),
            Range::Between(least, most) => format!("{} between {least} and {most} {}", quantity.0, quantity.1),
            Range::AtMost(most) => format!("{} of at most {most} {}", quantity.0, quantity.1).trim_end().to_owned(),
            Range::Whole(least, most) => format!("whole numbers from {least} to {most}, {noun}"),
        }
    }
}

impl Quantity {
    fn noun(self) -> String {
        if self.1.is_empty() { self.0.to_owned() } else { format!("{} in {}", self.0, self.1) }
    }
}

/// A number with its quantity, unit and range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub Quantity, pub Range);

impl Kind for Number {
    type Value = f64;

    fn noun(&self) -> String {
        with_article(&self.0.noun())
    }

    fn expected(&self) -> String {
        with_article(&self.1.of(self.0))
    }

    fn parse(&self, value: &DeValue) -> Result<f64, Refused> {
        number(value).ok_or_else(|| refused(format!("{}, as a plain number", self.noun()), value))
    }

    fn outside(&self, value: &f64) -> Option<String> {
        (!self.1.contains(*value)).then(|| format!("{value:?}"))
    }
}

/// A list of `N` numbers of one quantity, each within the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers<const N: usize>(pub Quantity, pub Range);

impl<const N: usize> Kind for Numbers<N> {
    type Value = [f64; N];

    fn noun(&self) -> String {
        format!("a list of {N} numbers, {}", self.0.noun())
    }

    fn expected(&self) -> String {
        self.1.of(self.0)
    }

    fn described(&self) -> String {
        format!("a list of {N} numbers, {}", if self.1 == Range::Finite { self.0.noun() } else { self.expected() })
    }

    fn parse(&self, value: &DeValue) -> Result<[f64; N], Refused> {
        let numbers = finite_numbers(value, || self.noun())?;
        let found = numbers.len().to_string();
        <[f64; N]>::try_from(numbers).map_err(|_| Refused { expected: self.noun(), found })
    }

    fn outside(&self, value: &[f64; N]) -> Option<String> {
        (!value.iter().all(|x| self.1.contains(*x))).then(|| format!("{value:?}"))
    }
}

/// A list of any length with numbers of one quantity, each within the range. The code that reads the list checks its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberList(pub Quantity, pub Range);

impl Kind for NumberList {
    type Value = Vec<f64>;

    fn noun(&self) -> String {
        format!("a list of numbers, {}", self.0.noun())
    }

    fn expected(&self) -> String {
        self.1.of(self.0)
    }

    fn described(&self) -> String {
        format!("a list of numbers, {}", self.expected())
    }

    fn parse(&self, value: &DeValue) -> Result<Vec<f64>, Refused> {
        finite_numbers(value, || self.noun())
    }

    fn outside(&self, value: &Vec<f64>) -> Option<String> {
        (!value.iter().all(|x| self.1.contains(*x))).then(|| format!("{value:?}"))
    }
}

/// Reads a list of finite numbers from TOML. `noun` describes the list.
fn finite_numbers(value: &DeValue, noun: impl Fn() -> String) -> Result<Vec<f64>, Refused> {
    let wrong = |found: String| Refused { expected: noun(), found };
    let DeValue::Array(items) = value else { return Err(wrong(described(value))) };
    let numbers: Option<Vec<f64>> = items.iter().map(|item| number(item.get_ref())).collect();
    let numbers = numbers.ok_or_else(|| wrong("a list with values that are not numbers".to_owned()))?;
    match numbers.iter().find(|number| !number.is_finite()) {
        Some(other) => Err(wrong(format!("a list with {other:?}"))),
        None => Ok(numbers),
    }
}

/// Lengths at the front and back plate, mm, zero or more: one number for both plates, or a list of two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideLengths();

impl SideLengths {
    const EACH: Numbers<2> = Numbers(Quantity("lengths", "mm"), Range::NOT_NEGATIVE);
}

impl Kind for SideLengths {
    type Value = [f64; 2];

    fn noun(&self) -> String {
        "a length in mm, or [front, back]".to_owned()
    }

    fn expected(&self) -> String {
        SideLengths::EACH.expected()
    }

    fn described(&self) -> String {
        "a length in mm, zero or more, or [front, back]".to_owned()
    }

    fn parse(&self, value: &DeValue) -> Result<[f64; 2], Refused> {
        match (value, number(value)) {
            (DeValue::Array(_), _) => SideLengths::EACH.parse(value),
            (_, Some(both)) => Ok([both; 2]),
            (_, None) => Err(refused(self.noun(), value)),
        }
    }

    fn outside(&self, value: &[f64; 2]) -> Option<String> {
        SideLengths::EACH.outside(value)
    }
}

/// A property of the ribs: one value for all ribs, or one value per rib.
#[derive(Debug, Clone, PartialEq)]
pub enum OfRibs<T> {
    /// The same value for all ribs.
    Alike(T),
    /// One value per rib, from base to tip.
    Each(Vec<T>),
}

/// Lengths of the brackets of each rib on the front and the back plate, mm.
pub type BracketLengths = OfRibs<[f64; 2]>;

impl BracketLengths {
    /// Brackets of zero length on all ribs.
    pub const NONE: BracketLengths = OfRibs::Alike([0.0; 2]);
}

impl<T: Copy> OfRibs<T> {
    /// Value for a rib; ribs are numbered from 0 at the base.
    pub fn of(&self, rib: usize) -> T {
        match self {
            OfRibs::Alike(all) => *all,
            OfRibs::Each(each) => each[rib],
        }
    }

    /// One value per rib; `None` if all ribs share one value.
    pub fn each(self) -> Option<Vec<T>> {
        if let OfRibs::Each(each) = self { Some(each) } else { None }
    }

    /// The stored values, mutable: one value for all ribs, or one value per rib.
    pub fn all_mut(&mut self) -> &mut [T] {
        match self {
            OfRibs::Alike(all) => std::slice::from_mut(all),
            OfRibs::Each(each) => each,
        }
    }

    /// The stored values: one value for all ribs, or one value per rib.
    pub fn all(&self) -> &[T] {
        match self {
            OfRibs::Alike(all) => std::slice::from_ref(all),
            OfRibs::Each(each) => each,
        }
    }
}

/// One number for all ribs, or a list with one number per rib.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RibNumbers(pub Number);

impl Kind for RibNumbers {
    type Value = OfRibs<f64>;

    fn noun(&self) -> String {
        self.0.noun()
    }

    fn expected(&self) -> String {
        self.0.expected()
    }

    fn described(&self) -> String {
        format!("{}, or a list with one value for each rib", self.0.described())
    }

    fn parse(&self, value: &DeValue) -> Result<OfRibs<f64>, Refused> {
        match value {
            DeValue::Array(each) => {
                let each = each.iter().map(|value| self.0.parse(value.get_ref()));
                each.collect::<Result<_, _>>().map(OfRibs::Each)
            }
            all => self.0.parse(all).map(OfRibs::Alike),
        }
    }

    fn outside(&self, value: &OfRibs<f64>) -> Option<String> {
        value.all().iter().find_map(|number| self.0.outside(number))
    }
}

/// Lengths at the ends of the ribs, mm, zero or more: either [`SideLengths`] for all ribs, or a list with one pair per rib.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RibLengths();

impl Kind for RibLengths {
    type Value = BracketLengths;

    fn noun(&self) -> String {
        SideLengths().noun()
    }

    fn expected(&self) -> String {
        SideLengths().expected()
    }

    fn described(&self) -> String {
        format!("{}, or a list with one pair [front, back] for each rib", SideLengths().described())
    }

    fn parse(&self, value: &DeValue) -> Result<BracketLengths, Refused> {
        match value {
            DeValue::Array(items) if items.iter().any(|item| matches!(item.get_ref(), DeValue::Array(_))) => {
                Pairs("[front, back], lengths in mm", None).parse(value).map(BracketLengths::Each)
            }
            _ => SideLengths().parse(value).map(BracketLengths::Alike),
        }
    }

    fn outside(&self, value: &BracketLengths) -> Option<String> {
        value.all().iter().find_map(|pair| SideLengths().outside(pair))
    }

    fn written(&self, value: &BracketLengths) -> String {
        SideLengths().written(&value.of(0))
    }
}

/// A list of pairs of numbers. The first text names the pairs and their unit. The optional second field contains a short name of the pairs, and the
/// largest valid magnitude of the numbers in a pair, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pairs(pub &'static str, pub Option<(&'static str, f64)>);

impl Kind for Pairs {
    type Value = Vec<[f64; 2]>;

    fn noun(&self) -> String {
        format!("a list of pairs {}", self.0)
    }

    fn expected(&self) -> String {
        self.1.map_or(self.noun(), |(points, most)| format!("{points} within {most} mm"))
    }

    fn described(&self) -> String {
        self.1.map_or(self.noun(), |_| format!("{}; {}", self.noun(), self.expected()))
    }

    fn parse(&self, value: &DeValue) -> Result<Vec<[f64; 2]>, Refused> {
        let pair = |row: Vec<f64>| row.try_into().ok();
        let pairs = rows(value, &self.noun())?.into_iter().map(pair).collect::<Option<Vec<[f64; 2]>>>();
        pairs.ok_or_else(|| of_something_else(self.noun()))
    }

    fn outside(&self, value: &Vec<[f64; 2]>) -> Option<String> {
        let (_, most) = self.1?;
        let is_near = |pair: &&[f64; 2]| pair.iter().all(|x| x.abs() <= most);
        value.iter().find(|pair| !is_near(pair)).map(|pair| format!("{pair:?}"))
    }
}

/// A list of rows of finite numbers. The text names the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows(pub &'static str);

impl Kind for Rows {
    type Value = Vec<Vec<f64>>;

    fn noun(&self) -> String {
        format!("a list of rows {}", self.0)
    }

    fn parse(&self, value: &DeValue) -> Result<Vec<Vec<f64>>, Refused> {
        rows(value, &self.noun())
    }

    fn outside(&self, value: &Vec<Vec<f64>>) -> Option<String> {
        value.iter().find(|row| !row.iter().all(|x| x.is_finite())).map(|row| format!("{row:?}"))
    }
}

/// Reads a list of lists of numbers from TOML.
fn rows(value: &DeValue, noun: &str) -> Result<Vec<Vec<f64>>, Refused> {
    let row = |item: &DeValue| match item {
        DeValue::Array(row) => row.iter().map(|x| number(x.get_ref())).collect::<Option<Vec<f64>>>(),
        _ => None,
    };
    let DeValue::Array(items) = value else { return Err(refused(noun.to_owned(), value)) };
    let rows = items.iter().map(|item| row(item.get_ref())).collect::<Option<Vec<_>>>();
    rows.ok_or_else(|| of_something_else(noun.to_owned()))
}

fn of_something_else(expected: String) -> Refused {
    Refused { expected, found: "a list with values of another kind".to_owned() }
}

fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64),
        _ => None,
    }
}
