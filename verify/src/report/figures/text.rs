//! How much room words take, and how numbers are written.
//!
//! The reader's fonts are unknown when a figure is drawn, so widths are
//! estimates, generous enough for the wider of the common sans-serif faces.

/// Estimated width of one line of text, in pixels.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    let ems: f64 = text
        .chars()
        .map(|letter| match letter {
            'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' => 0.32,
            ' ' | 'f' | 't' | 'r' | '(' | ')' | '-' | '/' | 'I' => 0.38,
            'm' | 'M' | 'w' | 'W' | '%' | '—' | '@' => 0.95,
            '−' | '+' | '=' | '<' | '>' | '≤' | '≥' | '×' => 0.78,
            'A'..='Z' => 0.72,
            _ => 0.61,
        })
        .sum();
    ems * size
}

/// Breaks text at spaces into lines no wider than `width`; a single long word stays whole.
pub(super) fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width_of(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A number to about three significant digits, with a true minus sign.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&size) {
        return power_of_ten(value);
    }
    // Digits after the point so that three significant ones are left.
    let decimals = (2.0 - size.log10().floor()).clamp(0.0, 5.0) as usize;
    fixed(value, decimals)
}

/// A number with so many digits after the point, less trailing zeros.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    if text == "-0" {
        return "0".into();
    }
    text.replace('-', "−")
}

/// `2.5×10⁻⁴`, or `10⁻⁴` where the factor is one.
fn power_of_ten(value: f64) -> String {
    let exponent = value.abs().log10().floor();
    let factor = fixed(value / 10f64.powf(exponent), 1);
    let raised: String = format!("{exponent}").chars().map(superscript).collect();
    match factor.as_str() {
        "1" => format!("10{raised}"),
        "−1" => format!("−10{raised}"),
        _ => format!("{factor}×10{raised}"),
    }
}

fn superscript(digit: char) -> char {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match digit.to_digit(10) {
        Some(value) => RAISED[value as usize],
        None => '⁻',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_three_digits_and_lose_trailing_zeros() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(-2.5), "−2.5");
        assert_eq!(number(0.012_34), "0.0123");
        assert_eq!(number(1234.6), "1235");
        assert_eq!(number(100.0), "100");
        assert_eq!(number(1e-6), "10⁻⁶");
        assert_eq!(number(2.5e7), "2.5×10⁷");
    }

    #[test]
    fn wrapped_lines_fit_and_lose_no_word() {
        let text = "force found from the shape of the front plate against the force applied";
        let lines = wrap(text, 16.0, 200.0);
        assert!(lines.len() > 1);
        assert!(lines.iter().all(|line| width_of(line, 16.0) <= 200.0));
        assert_eq!(lines.join(" "), text);
    }
}
