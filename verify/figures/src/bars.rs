//! Grouped bars with their values above them.

use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use super::colour::{Hue, OVER_LINES};
use super::error::{FigureError, require, require_finite, require_len};
use super::geometry::Area;
use super::legend::Entry;
use super::panels::Plot;
use super::sheet::{LEFT, Sheet, TICK_TEXT, font};
use super::text::{number, widest};

/// One bar per category, all of one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Bars {
    /// Text in the legend, for instance "paper".
    pub label: String,
    /// Colour of the bars.
    pub hue: Hue,
    /// One value, zero or more, per category; `None` for a missing value.
    pub values: Vec<Option<f64>>,
}

/// Share of a category's width that its bars fill together.
const FILLED: f64 = 0.82;

impl Bars {
    pub(super) fn check(&self, categories: &Axis) -> Result<(), FigureError> {
        require_len(&self.label, &self.values, categories.names())?;
        require_finite(&self.label, self.values.iter().flatten())?;
        require(self.values.iter().flatten().all(|value| *value >= 0.0), FigureError::NotPositive, &self.label)
    }

    /// Values that the vertical axis must include: all heights and 0, so that bar lengths are proportional to values.
    pub(super) fn heights(&self) -> impl Iterator<Item = f64> {
        self.values.iter().flatten().copied().chain([0.0])
    }

    pub(super) fn entry(&self) -> Entry<'_> {
        Entry::patch(&self.label, self.hue.0)
    }

    /// Area of bar number `nth` (from 0) of the `of` bars in a category. The height of a bar without a value is 0.
    fn area(plot: &Plot, [nth, of]: [usize; 2], category: usize, value: Option<f64>) -> Area {
        let bar = FILLED / of as f64;
        let left = category as f64 - FILLED / 2.0 + bar * nth as f64;
        Area::between(plot.at([left + 0.04 * bar, 0.0]), plot.at([left + 0.96 * bar, value.unwrap_or(0.0)]))
    }

    pub(super) fn draw(&self, sheet: &Sheet, plot: &Plot, nth: [usize; 2]) -> Result<(), FigureError> {
        let drawn = self.values.iter().enumerate().filter(|(_, value)| value.is_some());
        drawn.into_iter().try_for_each(|(i, value)| sheet.cell(Self::area(plot, nth, i, *value), self.hue.0))
    }
}

/// Text size and orientation of the values that are written above bars.
pub(super) struct Writing {
    /// Whether the values are written vertically, because horizontal text would be wider than the bars.
    rising: bool,
    size: f64,
    /// Space for the longest value above its bar, px.
    pub(super) height: f64,
}

impl Writing {
    /// Chooses the size and orientation of the values for bars in a plot that is `pixels` wide, px.
    pub(super) fn of(bars: &[Bars], categories: &Axis, pixels: f64) -> Self {
        let texts: Vec<String> =
            bars.iter().flat_map(|bars| &bars.values).flatten().map(|value| number(*value)).collect();
        let bar = pixels * FILLED / (categories.names() * bars.len()).max(1) as f64;
        let rising = widest(&texts, TICK_TEXT) + 2.0 > bar;
        // The size of vertical text is at most the bar's width, so that it does not cover neighbouring text. A lower limit keeps the text legible.
        let size = if rising { bar.clamp(13.0, TICK_TEXT) } else { TICK_TEXT };
        let height = if rising { widest(&texts, size) } else { size } + 10.0;
        Self { rising, size, height: if bars.is_empty() { 0.0 } else { height } }
    }

    /// Writes the values above their bars, and a dash for a missing value.
    pub(super) fn write(&self, sheet: &Sheet, plot: &Plot, bars: &Bars, nth: [usize; 2]) -> Result<(), FigureError> {
        bars.values.iter().enumerate().try_for_each(|(category, value)| {
            let bar = Bars::area(plot, nth, category, *value);
            let text = value.map_or("–".to_owned(), number);
            let style = font(self.size).color(&OVER_LINES).pos(Pos::new(HPos::Center, VPos::Bottom));
            let rising = style.transform(FontTransform::Rotate270).pos(LEFT);
            let style = if self.rising && value.is_some() { rising } else { style };
            sheet.words(&text, [bar.centre()[0], bar.top - 4.0], &style)
        })
    }
}
