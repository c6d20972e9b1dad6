//! The values written above bars.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Canvas, Words};
use super::colour::Ink;
use super::error::FigureError;
use super::frame::TICK_TEXT;
use super::stroke::Area;
use super::text::{number, width_of};

/// Smallest text that is still read at the figure's natural size.
const LEAST_TEXT: f64 = 13.0;

/// How the values of one chart are written.
pub(super) struct Writing {
    /// Values wider than their bars are written from below to above.
    rising: bool,
    size: f64,
    /// Room the longest takes above its bar.
    pub(super) height: f64,
}

impl Writing {
    /// Chooses the writing for bars of this width.
    pub(super) fn for_values(values: &[f64], bar: f64) -> Self {
        let widest = |size: f64| values.iter().map(|value| width_of(&number(*value), size)).fold(0.0, f64::max);
        let rising = widest(TICK_TEXT) + 2.0 > bar;
        // Rising text is as wide as its bar, so that it does not cover the neighbours.
        let size = if rising { bar.clamp(LEAST_TEXT, TICK_TEXT) } else { TICK_TEXT };
        let height = if rising { widest(size) } else { size } + 10.0;
        Self { rising, size, height }
    }

    /// Writes a value above its bar; where there is none, a dash.
    pub(super) fn write(&self, canvas: &mut Canvas, value: Option<f64>, bar: Area) -> Result<(), FigureError> {
        let rising = self.rising && value.is_some();
        let text = value.map_or("–".into(), number);
        let at = [(bar.left + bar.right) / 2.0, bar.top - 4.0];
        let (across, down) = if rising { (HPos::Left, VPos::Center) } else { (HPos::Center, VPos::Bottom) };
        let words = Words::new(&text, at, self.size).anchored(across, down).inked(Ink::TextOverLines);
        canvas.words(Words { rising, ..words })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_bars_have_their_values_written_upwards() {
        assert!(!Writing::for_values(&[12.3], 60.0).rising);
        assert!(Writing::for_values(&[12.3], 20.0).rising);
    }

    #[test]
    fn there_is_room_for_the_longest_value() {
        assert!(Writing::for_values(&[1.0, 1234.0], 20.0).height > width_of("1234", LEAST_TEXT));
    }
}
