//! Forces sensed in images against those that were measured, and the residuals of the markers.

pub mod picture;

use crate::prelude::*;
use finray_figures::Spread;
use finray_studies::experiments::measured::picture::Picture;
use finray_studies::experiments::measured::{MarkerResidual, MeasuredForce, MeasuredStudy};
use finray_studies::statistics::{mean, rms};

const CSV: &str = "measured_forces.csv";
const RESIDUALS_CSV: &str = "measured_residuals.csv";
/// Longest residual of the picture, mm on the page: the others to the same scale.
const LONGEST_MM: f64 = 12.0;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![
        Dataset::records(CSV, study.measured.iter().flat_map(|measured| &measured.forces)),
        Dataset::records(RESIDUALS_CSV, study.measured.iter().flat_map(|measured| &measured.residuals)).csv_alone(),
    ]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(measured) = study.measured.as_ref().filter(|measured| measured.images > 0) else { return Ok(None) };
    let mut blocks = vec![paragraph("measured.about", context! { images => measured.images })?];
    let drawn = [forces(measured)?, residuals(&measured.residuals)?];
    let captions = [
        ("Sensed against measured force, with 95 % intervals.", CSV),
        (
            "Residual of each marker under the measured force, all images: from where it is seen to where the finger has it.",
            RESIDUALS_CSV,
        ),
    ];
    for (svg, (caption, csv)) in drawn.into_iter().zip(captions) {
        if let Some(svg) = svg {
            blocks.push(Block::Figure(Figure::narrow(svg, caption, csv)));
        }
    }
    if !measured.pictures.is_empty() {
        let magnified = picture::magnified(&measured.pictures);
        let figure = |shown: &Picture| {
            let caption = format!(
                "{}: residual of each marker, {magnified} times as long, from where it is seen (circle) to where the finger has it.",
                shown.image
            );
            Figure::narrow(picture::svg(shown, magnified), caption, RESIDUALS_CSV)
        };
        let figures = measured.pictures.iter().map(figure).collect();
        blocks.push(Block::Figures { figures });
    }
    let columns = Columns::<(&'static str, &[MeasuredForce])>::new()
        .page("what is known", Format::Words, |(known, _)| *known)
        .page("images", Format::Plain, |(_, forces)| forces.len())
        .page("refused", Format::Plain, |(_, forces)| forces.iter().filter(|force| force.error.is_none()).count())
        .page("mean error", Format::Percent, |(_, forces)| mean_error(forces))
        .page("largest", Format::Percent, |(_, forces)| errors(forces).reduce(f64::max))
        .page("error / sigma, rms", Format::Fixed(2), |(_, forces)| {
            rms(forces.iter().filter_map(|force| force.error_over_sigma))
        })
        .page("within 95 %", Format::Plain, |(_, forces)| within(forces));
    let caption = "Error of the force as a share of the measured one, by what is known: all that the scene has, and all but one thing";
    blocks.push(Block::Table(columns.table(caption, CSV, measured.by_knowledge())));
    let says = say("measured.says", in_words(measured))?;
    Ok(Some(Section::new("measured", "Measured images", blocks).saying(says)))
}

fn errors(forces: &[MeasuredForce]) -> impl Iterator<Item = f64> {
    forces.iter().filter_map(|force| force.error).map(f64::abs)
}

fn mean_error(forces: &[MeasuredForce]) -> Option<f64> {
    mean(errors(forces))
}

/// Images whose interval holds the measured force.
fn within(forces: &[MeasuredForce]) -> usize {
    forces.iter().filter(|force| force.error_over_sigma.is_some_and(|off| off.abs() <= TWO_SIDED_95)).count()
}

/// The friction of the scene where it has one, else the measured direction.
fn in_words(measured: &MeasuredStudy) -> Option<Value> {
    let all: Vec<_> = measured.by_knowledge().collect();
    let (known, forces) = all.iter().find(|(known, _)| known.starts_with("friction")).or(all.first())?;
    let (error, within) = (mean_error(forces)?, within(forces));
    Some(context! { images => measured.images, known => *known, error, within, forces => forces.len() })
}

fn forces(measured: &MeasuredStudy) -> Result<Option<String>, FigureError> {
    let mut series = Vec::new();
    let mut largest = 0.0_f64;
    // All that the scene has; the rest is in the table.
    for (n, (known, forces)) in measured.by_knowledge().take(3).enumerate() {
        let answered = || forces.iter().filter_map(|force| Some((force.measured_n, force.sensed_n?, force.sigma_n?)));
        let points: Vec<Point> = answered().map(|(measured_n, sensed_n, _)| [measured_n, sensed_n]).collect();
        if points.is_empty() {
            continue;
        }
        let ends = answered()
            .map(|(_, sensed_n, sigma_n)| [sensed_n - TWO_SIDED_95 * sigma_n, sensed_n + TWO_SIDED_95 * sigma_n]);
        largest = points.iter().flatten().fold(largest, |m, x| m.max(*x));
        series.push(Series { dash: Dash::None, spread: Spread::Bars(ends.collect()), ..Series::nth(n, known, points) });
    }
    if series.is_empty() {
        return Ok(None);
    }
    series.push(Series::guide("as measured", vec![[0.0, 0.0], [largest, largest]]));
    let title = "Sensed against measured";
    let frame = Frame::half(title, "Sensed force over measured force, an image each, with intervals");
    Chart::new(frame, [Axis::linear("measured force, N"), Axis::linear("sensed force, N")], series).svg().map(Some)
}

fn residuals(residuals: &[MarkerResidual]) -> Result<Option<String>, FigureError> {
    let length = |left: &MarkerResidual| left.residual_x_mm.hypot(left.residual_y_mm);
    let longest_mm = residuals.iter().map(length).fold(0.0, f64::max);
    if longest_mm <= 0.0 {
        return Ok(None);
    }
    let scale = LONGEST_MM / longest_mm;
    let line = |left: &MarkerResidual| -> Vec<Point> {
        vec![[left.x_mm, left.y_mm], [left.x_mm + scale * left.residual_x_mm, left.y_mm + scale * left.residual_y_mm]]
    };
    let seen: Vec<Point> = residuals.iter().map(|left| [left.x_mm, left.y_mm]).collect();
    let mut series = Series::lines("residual", residuals.iter().map(line).collect(), Hue::nth(1), 2.0);
    series.push(Series { dash: Dash::None, hue: Hue::Neutral, ..Series::nth(0, "markers seen", seen) });
    let title = format!("Residuals, {scale:.0} times as long ({longest_mm:.3} mm at most)");
    let alt = "Markers of all images in the finger frame with the residual of each";
    Chart::to_scale(Frame::half(title, alt), ["x, mm", "y, mm"], series).svg().map(Some)
}
