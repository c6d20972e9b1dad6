//! Marker residuals drawn over the photograph in which the markers were located.

use data_encoding::BASE64;
use finray_studies::experiments::measured::picture::{Arrow, Picture};

/// Length of the longest residual in the drawings, px.
const LONGEST_PX: f64 = 48.0;
/// Largest length of the scale bar, px.
const LONGEST_BAR_PX: f64 = 120.0;
/// Colours that contrast with grey and white. The colours of the residuals do not depend on the page's colours.
const RESIDUAL: &str = "#d6004b";
const HALO: &str = "#ffffff";

/// Magnification of the residuals: a round number, the same for all pictures.
pub fn magnified(pictures: &[Picture]) -> f64 {
    let length = |arrow: &Arrow| arrow.residual_px[0].hypot(arrow.residual_px[1]);
    let longest_px = pictures.iter().flat_map(|picture| &picture.arrows).map(length).fold(0.0, f64::max);
    if longest_px > 0.0 { round_below(LONGEST_PX / longest_px) } else { 1.0 }
}

/// The largest number of the form 1, 2 or 5 times a power of ten that does not exceed `number`.
fn round_below(number: f64) -> f64 {
    let decade = 10.0_f64.powf(number.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|step| step * decade).find(|round| *round <= number).unwrap_or(decade)
}

/// The picture with its residuals as SVG. The colours of this SVG do not depend on the page.
pub fn svg(picture: &Picture, magnified: f64) -> String {
    let [width, height] = picture.size_px;
    let strokes = [(HALO, 6.0), (RESIDUAL, 2.5)].map(|(colour, stroke)| {
        let arrows: String = picture.arrows.iter().map(|arrow| path(arrow, magnified)).collect();
        format!(
            "<g fill=\"none\" stroke=\"{colour}\" stroke-width=\"{stroke}\" stroke-linecap=\"round\">{arrows}{}</g>",
            bar(picture, magnified).map_or_else(String::new, |(_, path)| path)
        )
    });
    let words = bar(picture, magnified).map_or_else(String::new, |(bar_mm, _)| {
        format!(
            "<text x=\"20\" y=\"{}\" font-size=\"22\" font-weight=\"600\" fill=\"{RESIDUAL}\" stroke=\"{HALO}\" stroke-width=\"5\" \
             paint-order=\"stroke\">{bar_mm} mm</text>",
            height.saturating_sub(32)
        )
    });
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"The image {} with the residual of each marker\">\
         <image width=\"{width}\" height=\"{height}\" href=\"data:image/jpeg;base64,{}\"/>{}{words}</svg>",
        escaped(&picture.image),
        BASE64.encode(&picture.jpeg),
        strokes.concat()
    )
}

/// SVG path of a circle at the located marker and of its residual.
fn path(Arrow { seen: [x, y], residual_px }: &Arrow, magnified: f64) -> String {
    let [to_x, to_y] = [x + magnified * residual_px[0], y + magnified * residual_px[1]];
    format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/><path d=\"M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}\"/>")
}

/// Scale bar in the lower left corner: the length of the residual that the bar represents, mm, and the SVG path of the bar.
fn bar(picture: &Picture, magnified: f64) -> Option<(f64, String)> {
    let px_a_mm = picture.px_a_mm * magnified;
    let bar_mm = (px_a_mm > 0.0).then(|| round_below(LONGEST_BAR_PX / px_a_mm))?;
    let y = picture.size_px[1].saturating_sub(20);
    Some((bar_mm, format!("<path d=\"M20 {y}h{:.1}\"/>", bar_mm * px_a_mm)))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
