//! Axes: their limits and ticks, and the coordinate type for the plotters library.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::error::{FigureError, require, require_finite, require_limits};
use super::sheet::{SPACE, TICK_TEXT};
use super::text::{fixed, number, width_of};

/// Relation between values and positions on an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    /// Linear: equal differences have equal lengths.
    Linear,
    /// Logarithmic: equal ratios have equal lengths; values must be above 0.
    Log,
}

impl Scale {
    /// The quantity that is proportional to the position on the axis: the value or its logarithm.
    pub(super) fn measure(self, value: f64) -> f64 {
        if self == Self::Log { value.log10() } else { value }
    }

    /// Relative position of a value between the limits, 0 to 1.
    pub(super) fn fraction(self, value: f64, limits: [f64; 2]) -> f64 {
        let [value, low, high] = [value, limits[0], limits[1]].map(|number| self.measure(number));
        (value - low) / (high - low)
    }
}

/// One axis of a figure: label, scale, limits and ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Label with quantity and unit.
    pub(super) label: String,
    pub(super) scale: Scale,
    /// Limits of the axis; `None` if they follow from the data.
    pub(super) limits: Option<[f64; 2]>,
    /// Ticks with their names; `None` for ticks at round values.
    pub(super) ticks: Option<Vec<(f64, String)>>,
}

impl Axis {
    /// A linear axis with a label such as "force, N"; its limits follow from the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear, limits: None, ticks: None }
    }

    /// A logarithmic axis; its limits follow from the data.
    pub fn log(label: impl Into<String>) -> Self {
        Self { scale: Scale::Log, ..Self::linear(label) }
    }

    /// An axis of named categories, which lie at 0, 1, 2, ...
    pub fn categories(label: impl Into<String>, names: Vec<String>) -> Self {
        let end = names.len() as f64 - 0.5;
        Self::linear(label).within(-0.5, end).named((0..).map(f64::from).zip(names).collect())
    }

    /// Sets the limits. Data beyond the limits extend the axis, but the cells of a map are cut off at the limits.
    pub fn within(self, low: f64, high: f64) -> Self {
        Self { limits: Some([low, high]), ..self }
    }

    /// Sets ticks at these values and labels each tick with its value.
    pub fn with_ticks(self, ticks: impl IntoIterator<Item = f64>) -> Self {
        self.named(ticks.into_iter().map(|value| (value, number(value))).collect())
    }

    /// Sets ticks at these values, with these names.
    pub fn named(self, ticks: Vec<(f64, String)>) -> Self {
        Self { ticks: Some(ticks), ..self }
    }

    /// Number of ticks that were given by `named` or `with_ticks`; for an axis of categories, the number of categories.
    pub(super) fn names(&self) -> usize {
        self.ticks.as_ref().map_or(0, Vec::len)
    }

    /// Computes the limits, and the ticks that fit into `pixels`. If no limits are given, they are round numbers outside the data, moved a little
    /// further out if the data reach them.
    pub(super) fn ruler(&self, data: &[f64], pixels: f64, upright: bool) -> Result<Ruler, FigureError> {
        require_finite(&self.label, data.iter())?;
        require(self.limits.is_some() || !data.is_empty(), FigureError::Empty, &self.label)?;
        let all = data.iter().chain(self.limits.iter().flatten()).copied();
        let [low, high] = [f64::min, f64::max].map(|of| all.clone().reduce(of).unwrap_or(0.0));
        require(self.scale == Scale::Linear || low > 0.0, FigureError::NotPositive, &self.label)?;
        if let Some(limits) = self.limits {
            require_limits(&self.label, limits)?;
        }
        let span = match self.limits {
            Some(_) => [low, high],
            None => clear(self.scale, [low, high], round_out(self.scale, [low, high])),
        };
        let spacing = if upright { 44.0 } else { 55.0 };
        let most = (pixels / spacing).clamp(2.0, 12.0).floor();
        let ticks = self.ticks.clone().unwrap_or_else(|| round_ticks(self.scale, span, most));
        let mut ruler = Ruler { scale: self.scale, span, ticks };
        ruler.thin(pixels, upright);
        Ok(ruler)
    }
}

/// An axis with known limits and ticks; it is the coordinate type of charts of the plotters library.
#[derive(Debug, Clone)]
pub(super) struct Ruler {
    pub(super) scale: Scale,
    pub(super) span: [f64; 2],
    /// Values of the ticks with their names; a tick with an empty name has no label.
    pub(super) ticks: Vec<(f64, String)>,
}

impl Ruler {
    /// Removes ticks beyond the limits, and names of ticks that would touch the previous name.
    fn thin(&mut self, pixels: f64, upright: bool) {
        let (span, scale, mut free) = (self.span, self.scale, f64::NEG_INFINITY);
        self.ticks.retain(|(value, _)| (-1e-9..=1.0 + 1e-9).contains(&scale.fraction(*value, span)));
        self.ticks.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (value, name) in &mut self.ticks {
            let at = scale.fraction(*value, span) * pixels;
            let room = if upright { TICK_TEXT * 1.1 } else { width_of(name, TICK_TEXT) + SPACE };
            if at - room / 2.0 < free {
                name.clear();
            } else {
                free = at + room / 2.0;
            }
        }
    }
}

impl Ranged for Ruler {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let part = self.scale.fraction(*value, self.span);
        // On a logarithmic axis, a value of zero or less is drawn at the lower end of the axis.
        let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
        from + (part * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.iter().map(|tick| tick.0).collect() }
    }

    fn range(&self) -> Range<f64> {
        self.span[0]..self.span[1]
    }
}

impl ValueFormatter<f64> for Ruler {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.iter().find(|tick| tick.0 == *value).map_or(String::new(), |tick| tick.1.clone())
    }
}

/// Ticks at round values between the limits, with their names; there are about `most` ticks or fewer.
pub(super) fn round_ticks(scale: Scale, [low, high]: [f64; 2], most: f64) -> Vec<(f64, String)> {
    let decades = (high / low).log10();
    // A logarithmic axis of less than a decade contains too few powers of ten, so it has the ticks of a linear axis.
    if scale == Scale::Linear || decades < 1.0 {
        let step = round_up((high - low) / most);
        let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
        let [first, last] = [(low / step - 1e-9).ceil(), (high / step + 1e-9).floor()];
        let values = (0..).map(|i| first + f64::from(i)).take_while(|multiple| *multiple <= last);
        return values.map(|multiple| multiple * step).map(|value| (value, fixed(value, decimals))).collect();
    }
    let factors: &[f64] = if 3.0 * decades <= most { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let stride = (decades / most).ceil().max(1.0) as i32;
    let powers =
        (low.log10().floor() as i32..=high.log10().ceil() as i32).filter(|power| power.rem_euclid(stride) == 0);
    let values = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10f64.powi(power)));
    let within = values.filter(|value| *value >= low * (1.0 - 1e-9) && *value <= high * (1.0 + 1e-9));
    within.map(|value| (value, number(value))).collect()
}

/// Rounds a positive value up to 1, 2 or 5 times a power of ten.
fn round_up(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0]
        .map(|factor| factor * power)
        .into_iter()
        .find(|step| *step >= value * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

fn round_out(scale: Scale, [low, high]: [f64; 2]) -> [f64; 2] {
    match scale {
        Scale::Linear if low == high => {
            // An axis for a single value extends to both sides of the value, by half of the value.
            let room = if low == 0.0 { 1.0 } else { low.abs() * 0.5 };
            [low - room, high + room]
        }
        Scale::Linear => {
            let step = round_up((high - low) / 8.0);
            [(low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step]
        }
        // Rounding the inverse of a value up and inverting the result rounds the value down.
        Scale::Log => match [1.0 / round_up(1.0 / low), round_up(high)] {
            [low, high] if low < high => [low, high],
            [low, high] => [low / 2.0, high * 2.0],
        },
    }
}

/// Moves a limit outwards if the outermost data reach it, so that no symbol lies on the frame. A linear axis may still end at 0, where bars start.
fn clear(scale: Scale, data: [f64; 2], span: [f64; 2]) -> [f64; 2] {
    const ROOM: f64 = 0.015;
    let ends = span.map(|value| scale.measure(value));
    let room = ROOM * (ends[1] - ends[0]);
    let moved = |end: usize, outwards: f64| {
        let distance = (scale.measure(data[end]) - ends[end]).abs();
        if distance > room || (scale == Scale::Linear && data[end] == 0.0) {
            return span[end];
        }
        match scale {
            Scale::Linear => span[end] + outwards * room,
            Scale::Log => span[end] * 10f64.powf(outwards * room),
        }
    };
    [moved(0, -1.0), moved(1, 1.0)]
}
