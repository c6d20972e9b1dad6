//! Makes the writer's SVG fit for the page: it scales, it has a name, and
//! its neutral ink takes the page's colours.

use std::fmt::Write as _;

use super::colour::Ink;
use super::frame::Frame;

/// The stand-in colour that an ink is written in until the page's takes its place.
///
/// Near-black values that no palette uses.
pub(super) fn stand_in(ink: Ink) -> [u8; 3] {
    match ink {
        Ink::Text => [1, 2, 3],
        Ink::TextOverLines => [1, 2, 4],
        Ink::OnMap => [1, 2, 5],
        Ink::Rgb(channels) => channels,
    }
}

/// What takes the place of each stand-in, as an attribute (fill, then stroke).
const EXCHANGES: [(&str, &str); 6] = [
    (r##" fill="#010203""##, r#" fill="currentColor""#),
    (r##" stroke="#010203""##, r#" stroke="currentColor""#),
    (
        r##" fill="#010204""##,
        r#" fill="currentColor" style="paint-order:stroke;stroke:var(--paper,Canvas);stroke-width:50px;stroke-linejoin:round""#,
    ),
    (r##" stroke="#010204""##, r#" stroke="currentColor""#),
    (
        r##" fill="#010205""##,
        r##" fill="#14171a" style="paint-order:stroke;stroke:#ffffff;stroke-width:80px;stroke-linejoin:round""##,
    ),
    (r##" stroke="#010205""##, r##" stroke="#14171a""##),
];

/// Exchanges the stand-ins and the outer tag, and drops what says nothing.
pub(super) fn dress(svg: &str, frame: &Frame, [width, height]: [u32; 2]) -> String {
    let mut dressed = opening(frame, width, height);
    // The first line is the writer's own opening tag.
    for line in svg.lines().skip(1) {
        let mut line = line.replace(r#" opacity="1""#, "");
        if line.starts_with('<') && !line.starts_with("</") {
            for (written, meant) in EXCHANGES {
                line = line.replace(written, meant);
            }
            line = line.replace(r#" stroke="none""#, "");
            line = line.replace("<rect ", r#"<rect shape-rendering="crispEdges" "#);
        }
        dressed.push_str(&line);
        // A line break inside a text element would be set as a space.
        if !line.starts_with("<text") && (line.starts_with('<')) {
            dressed.push('\n');
        }
    }
    dressed
}

fn opening(frame: &Frame, width: u32, height: u32) -> String {
    let name = if frame.title.is_empty() { &frame.alt } else { &frame.title };
    let mut tag = String::new();
    // Writing into a string cannot fail.
    let _ = write!(
        tag,
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="100%" style="display:block;height:auto;max-width:{}px" role="img" stroke-linejoin="round"><title>{}</title>"#,
        frame.width.round(),
        escape(name),
    );
    if !frame.alt.is_empty() {
        let _ = write!(tag, "<desc>{}</desc>", escape(&frame.alt));
    }
    tag.push('\n');
    tag
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::super::canvas::{Pen, Words, draw};
    use super::*;

    fn sample() -> String {
        let frame = Frame::full("a < b & c", "what it shows");
        draw(&frame, 200.0, |canvas| {
            canvas.line(&[[0.0, 0.0], [10.0, 10.0]], Pen::new(Ink::Text, 1.0).faint(0.2))?;
            canvas.words(Words::new("here", [5.0, 5.0], 16.0).inked(Ink::TextOverLines))?;
            canvas.words(Words::new("fill=\"#010203\" & <i>", [5.0, 50.0], 16.0))?;
            canvas.polygon(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], Ink::OnMap, 1.0)
        })
        .unwrap()
    }

    #[test]
    fn neutral_ink_takes_the_page_colours() {
        let svg = sample();
        assert!(svg.contains(r#"stroke="currentColor""#) && svg.contains(r#"fill="currentColor""#));
        assert!(svg.contains("var(--paper,Canvas)"));
        for left_over in ["=\"#01020", "#000000"] {
            assert!(!svg.contains(left_over), "{left_over} in {svg}");
        }
    }

    #[test]
    fn the_drawing_scales_and_has_a_name() {
        let svg = sample();
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
        assert!(svg.contains(r#"viewBox="0 0 9000 2000" width="100%""#));
        assert!(svg.contains(r#"role="img""#));
        assert!(svg.contains("<title>a &lt; b &amp; c</title><desc>what it shows</desc>"));
        assert_eq!(svg.matches("<svg").count(), 1);
    }

    #[test]
    fn words_are_escaped_and_stand_without_line_breaks() {
        let svg = sample();
        assert!(svg.contains(">here</text>"));
        assert!(svg.contains("fill=&quot;#010203&quot; &amp; &lt;i&gt;</text>"));
    }
}
