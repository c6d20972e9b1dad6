//! Forces sensed in images, compared with measured forces, and residuals of the markers.

pub mod picture;

use super::format::percent_two_digits;
use crate::prelude::*;
use finray_studies::experiments::measured::picture::Picture;
use finray_studies::experiments::measured::{MarkerResidual, MeasuredForce, MeasuredStudy};
use finray_studies::statistics::{mean, rms};

const CSV: &str = "measured_forces.csv";
const COVERAGE_CSV: &str = "measured_coverage.csv";
/// Number of kinds of contact knowledge that are listed image by image. The first kind is the measured direction; the second kind is the scene's
/// friction, or no friction if the scene states none.
const OF_SCENE: usize = 2;
const RESIDUALS_CSV: &str = "measured_residuals.csv";
/// Length of the longest drawn residual, mm on the page; all residuals have the same magnification.
const LONGEST_MM: f64 = 12.0;

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![
        Dataset::records(CSV, study.measured.iter().flat_map(|measured| &measured.forces)),
        Dataset::new(COVERAGE_CSV, &coverage_columns(), study.measured.iter().flat_map(coverages)),
        Dataset::records(RESIDUALS_CSV, study.measured.iter().flat_map(|measured| &measured.residuals)).csv_alone(),
    ]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(measured) = study.measured.as_ref().filter(|measured| measured.images > 0) else { return Ok(None) };
    let mut blocks = vec![text(about(measured.images))];
    let drawn = [forces(measured)?, residuals(&measured.residuals)?];
    let captions = [
        ("Sensed against measured force, with 95 % intervals.", CSV),
        (
            "Residual of each marker under the measured force, all images: from its located position to its position on the finger.",
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
                "{}: residual of each marker, magnified {magnified} times, from its located position (circle) to \
                    its position on the finger.",
                shown.image
            );
            Figure::narrow(picture::svg(shown, magnified), caption, RESIDUALS_CSV)
        };
        let figures = measured.pictures.iter().map(figure).collect();
        blocks.push(Block::Figures(figures));
    }
    let caption = "Error of the force relative to the measured force, by known quantities: first with all quantities that the \
        scene states, then without one of these quantities at a time";
    let of_all = coverages(measured).into_iter().filter(|coverage| coverage.object.is_none());
    blocks.push(Block::Table(coverage_columns().table(caption, COVERAGE_CSV, of_all)));
    let by_object: Vec<Coverage> =
        coverages(measured).into_iter().filter(|coverage| coverage.object.is_some()).collect();
    if !by_object.is_empty() {
        let table = coverage_columns().table("The same by object", COVERAGE_CSV, by_object);
        blocks.push(details("By object", vec![Block::Table(table)]));
    }
    let of_scene = measured.by_knowledge().take(OF_SCENE).flat_map(|(_, forces)| forces);
    let table =
        image_columns().table("Each image, by known quantities; z is the error in standard deviations", CSV, of_scene);
    blocks.push(details("By image", vec![Block::Table(table)]));
    Ok(Some(Section::new("measured", "Measured images", blocks).saying(outcome(measured).map(says))))
}

/// How the images are sensed.
fn about(images: usize) -> String {
    format!(
        "{images} images with measured contact force, each sensed independently with the nonlinear estimator. The position of the contact is unknown. \
         Intervals are 95 %. Nothing is calibrated here; the report cannot know whether the scene was calibrated on these images. Refused images are counted."
    )
}

/// Sentence on the errors and intervals of the sensed forces.
fn says(Outcome { images, known, error, within, forces, .. }: Outcome) -> String {
    let error = percent_two_digits(error);
    format!(
        "In {images} images of the finger itself ({known}), sensed forces err by {error} on average; {within} of {forces} 95 % \
         intervals contain the force."
    )
}

/// Images of one object or of all objects, sensed with the same knowledge of the contact, such as its direction or friction.
struct Coverage<'s> {
    known: &'static str,
    object: Option<&'s str>,
    forces: Vec<&'s MeasuredForce>,
}

impl Coverage<'_> {
    fn errors(&self) -> impl Iterator<Item = f64> {
        self.forces.iter().filter_map(|force| force.error).map(f64::abs)
    }

    /// Number of images whose 95 % interval contains the measured force.
    fn within(&self) -> usize {
        self.forces.iter().filter(|force| force.error_over_sigma.is_some_and(|off| off.abs() <= TWO_SIDED_95)).count()
    }
}

/// Coverage of the intervals for each kind of contact knowledge: over all images, then for each object if the file names objects.
fn coverages(measured: &MeasuredStudy) -> Vec<Coverage<'_>> {
    let mut objects: Vec<&str> = Vec::new();
    for force in measured.forces.iter().filter(|force| !force.object.is_empty()) {
        if !objects.contains(&force.object.as_str()) {
            objects.push(&force.object);
        }
    }
    let of = |(known, forces): (&'static str, _), object: Option<&_>| {
        let forces: &[MeasuredForce] = forces;
        let forces = forces.iter().filter(|force| object.is_none_or(|object: &&str| force.object == *object)).collect();
        Coverage { known, object: object.copied(), forces }
    };
    let by_knowledge = measured.by_knowledge();
    by_knowledge
        .flat_map(|it| {
            std::iter::once(None).chain(objects.iter().map(Some)).map(move |o| of(it, o)).collect::<Vec<_>>()
        })
        .collect()
}

fn coverage_columns<'s>() -> Columns<'s, Coverage<'s>> {
    Columns::new()
        .both("known", "what is known", Format::Words, |of: &Coverage<'s>| of.known)
        .both("object", "object", Format::Words, |of| of.object.unwrap_or("all"))
        .both("images", "images", Format::Plain, |of| of.forces.len())
        .both("refused", "refused", Format::Plain, |of| of.forces.iter().filter(|force| force.error.is_none()).count())
        .both("mean_error", "mean error", Format::Percent, |of| mean(of.errors()))
        .both("largest_error", "largest", Format::Percent, |of| of.errors().reduce(f64::max))
        .both("error_over_sigma_rms", "error / sigma, rms", Format::Fixed(2), |of| {
            rms(of.forces.iter().filter_map(|force| force.error_over_sigma))
        })
        .both("within_95", "within 95 %", Format::Plain, Coverage::within)
}

fn image_columns<'s>() -> Columns<'s, &'s MeasuredForce> {
    Columns::new()
        .page("image", Format::Words, |force: &&'s MeasuredForce| force.image.as_str())
        .page("object", Format::Words, |force| force.object.as_str())
        .page("what is known", Format::Words, |force| force.known)
        .page("measured, N", Format::Fixed(2), |force| force.measured_n)
        .page("sensed, N", Format::Fixed(2), |force| force.sensed_n)
        .page("sigma, N", Format::Fixed(2), |force| force.sigma_n)
        .page("z", Format::Fixed(2), |force| force.error_over_sigma)
}

/// Key figures of the measured images, sensed with one kind of contact knowledge.
pub(super) struct Outcome {
    pub images: usize,
    pub known: &'static str,
    /// Mean relative error, dimensionless.
    pub error: f64,
    /// Number of 95 % intervals that contain the measured force.
    pub within: usize,
    pub forces: usize,
    /// Names of the objects, if the file of forces has them.
    pub objects: Vec<String>,
}

/// Key figures for the conclusion. If the scene states its friction, they are for sensing with this friction, otherwise for sensing with the measured
/// direction.
pub(super) fn outcome(measured: &MeasuredStudy) -> Option<Outcome> {
    let all = coverages(measured);
    let first = all.iter().find(|of| of.known.starts_with("friction") && of.object.is_none()).or(all.first())?;
    let of_known = all.iter().filter(|of| of.known == first.known);
    let objects: Vec<String> = of_known.filter_map(|of| of.object.map(str::to_owned)).collect();
    let (error, within) = (mean(first.errors())?, first.within());
    Some(Outcome { images: measured.images, known: first.known, error, within, forces: first.forces.len(), objects })
}

fn forces(measured: &MeasuredStudy) -> Result<Option<String>, FigureError> {
    let mut series = Vec::new();
    let mut largest = 0.0_f64;
    // Only the first three kinds of contact knowledge are drawn; the table lists all kinds.
    for (n, (known, forces)) in measured.by_knowledge().take(3).enumerate() {
        let answered = || forces.iter().filter_map(|force| Some((force.measured_n, force.sensed_n?, force.sigma_n?)));
        let points: Vec<Point> = answered().map(|(measured_n, sensed_n, _)| [measured_n, sensed_n]).collect();
        if points.is_empty() {
            continue;
        }
        let ends = answered()
            .map(|(_, sensed_n, sigma_n)| [sensed_n - TWO_SIDED_95 * sigma_n, sensed_n + TWO_SIDED_95 * sigma_n]);
        largest = points.iter().flatten().fold(largest, |m, x| m.max(*x));
        series.push(Series { dash: Dash::None, spread: ends.collect(), ..Series::nth(n, known, points) });
    }
    if series.is_empty() {
        return Ok(None);
    }
    series.push(Series::guide("as measured", vec![[0.0, 0.0], [largest, largest]]));
    let title = "Sensed against measured";
    let frame = Frame::half(title, "Sensed force over measured force, one point per image, with intervals");
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
    series.push(Series { dash: Dash::None, hue: Hue::NEUTRAL, ..Series::nth(0, "markers seen", seen) });
    let title = format!("Residuals, magnified {scale:.0} times (longest: {longest_mm:.3} mm)");
    let alt = "Markers of all images in the finger frame with the residual of each";
    Chart::to_scale(Frame::half(title, alt), ["x, mm", "y, mm"], series).svg().map(Some)
}
