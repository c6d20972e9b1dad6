//! Widths of text, and formats of numbers.
//!
//! When a figure is drawn, the reader's fonts are unknown. Widths are estimates that suffice for common sans-serif fonts.

/// Estimated width of one line of text, in the unit of `size` (the text size).
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    let ems = text.chars().map(|letter| match letter {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' => 0.32,
        ' ' | 'f' | 't' | 'r' | '(' | ')' | '-' | '/' | 'I' => 0.38,
        'm' | 'M' | 'w' | 'W' | '%' | '—' | '@' => 0.95,
        '−' | '+' | '=' | '<' | '>' | '≤' | '≥' | '×' => 0.78,
        'A'..='Z' => 0.72,
        _ => 0.61,
    });
    ems.sum::<f64>() * size
}

/// Estimated width of the widest line of text, in the unit of `size`.
pub(super) fn widest<'a>(lines: impl IntoIterator<Item = &'a String>, size: f64) -> f64 {
    lines.into_iter().map(|line| width_of(line, size)).fold(0.0, f64::max)
}

/// Breaks text at spaces into lines of at most `width`; a longer word stays whole.
pub(super) fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width_of(&format!("{line} {word}"), size) <= width => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A number with about three significant digits and a true minus sign. Very small and very large numbers are written with a power of ten.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(1e-3..1e4).contains(&size) {
        let exponent = size.log10().floor();
        let factor = fixed(value / 10f64.powf(exponent), 1);
        let raised = |digit: char| match digit.to_digit(10) {
            Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
            None => '⁻',
        };
        let power: String = exponent.to_string().chars().map(raised).collect();
        return if factor == "1" { format!("10{power}") } else { format!("{factor}×10{power}") };
    }
    fixed(value, (2.0 - size.max(1e-3).log10().floor()).clamp(0.0, 5.0) as usize)
}

/// A number with at most `decimals` digits after the point.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
}
