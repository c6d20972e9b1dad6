//! Objects pressed onto the finger: drawings, force over travel, and sensed forces.

mod words;

use super::drawings::{ACROSS_AXIS, ALONG_AXIS, lines_of, point, side_by_side, true_and_sensed};
use crate::prelude::*;
use finray_contact::Wall;
use finray_contact::press::{ForceRow, SceneStep, SeenContact};
use finray_model::sensing::ContactPosition;
use finray_studies::experiments::contact_scene::samples::NoiseSamples;
use finray_studies::experiments::contact_scene::study::SceneStudy;
use std::collections::BTreeMap;

const CSV: &str = "contact_scenes.csv";
/// Length of the arrow of the largest force, as a share of the front plate's length.
const LONGEST_ARROW: f64 = 0.2;

/// A force of a scene. For a sensed force, the row also has the noise samples of the step, and the index of the force in these samples.
type StepRow<'s> = (&'s SceneStudy, &'s ForceRow, Option<(&'s NoiseSamples, usize)>);

fn rows(scene: &SceneStudy) -> impl Iterator<Item = StepRow<'_>> {
    let mut sensed = 0;
    scene.rows.iter().map(move |row| {
        let samples = scene.steps.get(row.step - 1).and_then(|studied| studied.samples.as_ref());
        // Rows and samples of a step have the same order: contacts, then the total. Contacts on clamped parts are not sensed.
        let which = sensed;
        sensed = match row.contact.as_str() {
            "total" => 0,
            "clamp" => sensed,
            _ => sensed + 1,
        };
        (scene, row, samples.filter(|_| row.contact != "clamp").map(|samples| (samples, which)))
    })
}

pub(super) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    let answered = |samples: &Option<(&'s NoiseSamples, usize)>| samples.filter(|(samples, _)| samples.answered > 0);
    let columns = Columns::<StepRow>::new()
        .file("scene", |(scene, ..)| scene.name.clone())
        .file("step", |(_, row, _)| row.step)
        .file("travel_mm", |(_, row, _)| row.travel_mm)
        .file("contact", |(_, row, _)| row.contact.clone())
        .file("s_mm", |(_, row, _)| row.s_mm)
        .file("angle_deg", |(_, row, _)| row.angle_deg)
        .file("force_n", |(_, row, _)| row.force_n)
        .file("friction_n", |(_, row, _)| row.friction_n)
        .file("sensed_n", |(_, row, _)| row.sensed_n)
        .file("sigma_n", |(_, row, _)| row.sigma_n)
        .file("read_s_mm", |(_, row, _)| row.read_s_mm)
        .file("error_without_noise", |(scene, row, _)| match row.contact.as_str() {
            "total" => words::error_without_noise(scene.steps.get(row.step - 1)?),
            _ => None,
        })
        .file("read_angle_deg", |(_, row, _)| row.read_angle_deg)
        .file("samples", |(.., samples)| samples.map(|(samples, _)| samples.taken))
        .file("answered", |(.., samples)| samples.map(|(samples, _)| samples.answered))
        .file("covered", |(.., samples)| samples.map(|(samples, which)| samples.coverage(which)))
        .file("rms_error_n", move |(.., samples)| answered(samples).map(|(samples, which)| samples.rms_error_n(which)))
        .file("rms_sigma_n", move |(.., samples)| answered(samples).map(|(samples, which)| samples.rms_sigma_n(which)));
    vec![Dataset::new(CSV, &columns, study.contact_scenes.iter().flat_map(rows)).csv_alone()]
}

pub(super) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    if study.contact_scenes.is_empty() {
        return Ok(None);
    }
    let mut blocks = vec![text(words::ABOUT)];
    for scene in &study.contact_scenes {
        blocks.push(Block::Figures(figures(&study.finger, scene)?));
    }
    let stopped = study.contact_scenes.iter().filter_map(|scene| Some((scene, scene.stopped.as_ref()?)));
    blocks.extend(stopped.map(|(scene, error)| {
        text(format!("The scene \"{}\" ended after {} steps: {error}.", scene.name, scene.steps.len()))
    }));
    blocks.push(Block::Table(words::by_scene(&study.contact_scenes)));
    let section = Section::new("contact-scenes", "Pressing objects", blocks);
    Ok(Some(section.saying(words::verdict(&study.contact_scenes))))
}

/// Data for the drawing of a pressed object.
pub struct DrawnPress<'p> {
    /// The pressed finger.
    pub finger: &'p Finger,
    /// Name of the scene, for titles.
    pub name: &'p str,
    /// Standard deviation of the noise in one coordinate of markers and outline points, mm.
    pub noise_mm: f64,
    /// Closed outline of the object, relative to its reference point, mm.
    pub outline: &'p [Vector],
    /// True and sensed forces of all steps, one row per contact.
    pub rows: &'p [ForceRow],
    /// The last step; the drawing shows it.
    pub last: &'p SceneStep,
}

/// Drawings on one sheet: finger and object in the last step, and forces over the travel.
///
/// # Errors
/// [`FigureError`] if there is nothing to draw.
pub fn press_svg(press: &DrawnPress) -> Result<String, FigureError> {
    let drawings = [Some(drawing(press)?), force_over_travel(press)?];
    Ok(side_by_side(&drawings.into_iter().flatten().collect::<Vec<_>>(), 2))
}

fn figures(finger: &Finger, scene: &SceneStudy) -> Result<Vec<Figure>, FigureError> {
    let SceneStudy { name, noise_mm, outline, rows, .. } = scene;
    let mut figures = Vec::new();
    let Some(last) = scene.steps.last().map(|studied| &studied.step) else { return Ok(figures) };
    let press = DrawnPress { finger, name, noise_mm: *noise_mm, outline, rows, last };
    let caption = format!("Scene \"{name}\" at its end: true forces.");
    figures.push(Figure::narrow(drawing(&press)?, caption, CSV));
    if let Some(svg) = force_over_travel(&press)? {
        let caption = "Each contact force is along its normal, and the total is along the object's motion. The intervals are 95 % intervals.";
        figures.push(Figure::narrow(svg, caption, CSV));
    }
    Ok(figures)
}

fn drawing(press: &DrawnPress) -> Result<String, FigureError> {
    let DrawnPress { finger, last, .. } = press;
    let pressed = &last.pressed;
    let outline = press.outline.iter().map(|corner| point(&(corner + pressed.object))).collect();
    let longest_mm = LONGEST_ARROW * finger.plate_length_mm(Plate::Front);
    let largest_n = worst(last.contacts.iter().map(|seen| seen.force.norm()));
    // Arrow lengths have a lower limit, so that arrows of small forces stay visible.
    let length_mm = |force_n: f64| longest_mm * (0.3 + 0.7 * force_n / largest_n);
    let arrows = last.contacts.iter().map(|seen| {
        let foot = seen.point - seen.force.normalize() * length_mm(seen.force.norm());
        Series::arrow([point(&foot), point(&seen.point)], format!("{:.2} N", seen.force.norm()), Hue::VERMILION)
    });
    let alt = format!("The finger bent by the object of the scene {}, with the contact forces.", press.name);
    let at_rest = lines_of(finger, |at| point(&finger.point(at)));
    let deformed = lines_of(finger, |at| point(&pressed.shape.point(at)));
    let lines = [
        Series::lines("at rest", at_rest, Hue::FAINT, 3.0),
        Series::lines("pressed", deformed, Hue::BLUE, 2.4),
        Series::lines("object", vec![outline], Hue::GREEN, 2.4),
    ];
    let series = lines.into_iter().flatten().chain(arrows).collect();
    Chart::to_scale(Frame::half(press.name, alt), [ALONG_AXIS, ACROSS_AXIS], series).svg()
}

/// Text that names the two nodes between which the position `s_mm` on the front plate lies; empty if `s_mm` is not between two nodes.
fn between(finger: &Finger, s_mm: f64) -> String {
    let (nodes, places) = (finger.plate_nodes(Plate::Front), finger.plate_positions_mm(Plate::Front));
    let after = places.iter().position(|place| *place > s_mm).filter(|after| *after > 0);
    after.map_or(String::new(), |after| format!(", nodes {} to {}", nodes[after - 1], nodes[after]))
}

/// Chart over the travel (mm): true forces as lines, sensed forces as symbols. `None` for a press without forces.
fn force_over_travel(press: &DrawnPress) -> Result<Option<String>, FigureError> {
    let end_mm = press.rows.iter().map(|row| row.travel_mm).fold(0.0, f64::max);
    let series = courses(press.finger, press.rows, 0.02 * end_mm);
    if series.is_empty() {
        return Ok(None);
    }
    let DrawnPress { name, noise_mm, .. } = press;
    let alt = format!("True forces of the scene {name} over the travel, and forces sensed with {noise_mm} mm noise.");
    let frame = Frame::half(format!("{name}: true (lines), sensed (symbols)"), alt);
    // The axis extends beyond the last point, so that the symbol of this point does not touch the edge of the plot.
    let axes = [Axis::linear("travel of the object, mm").within(0.0, 1.06 * end_mm), Axis::linear("force, N")];
    Ok(Some(Chart::new(frame, axes, series).svg()?))
}

/// Series of true forces (lines) and sensed forces (symbols), for each contact and for the total. The line of a contact that exists in one step only is
/// twice `half_mm` long.
fn courses(finger: &Finger, rows: &[ForceRow], half_mm: f64) -> Vec<Series> {
    // For each contact: points (travel, true force), points (travel, sensed force), and the intervals of the sensed forces.
    let mut courses: BTreeMap<(usize, String), [Vec<Point>; 3]> = BTreeMap::new();
    for row in rows {
        let name = match row.contact.as_str() {
            "total" => (0, "total".to_owned()),
            "at" => (2, format!("plate{}", between(finger, row.s_mm.unwrap_or_default()))),
            "clamp" => (3, "clamp (not sensed)".to_owned()),
            node => (1, format!("node {node}")),
        };
        let [truth, sensed, intervals] = courses.entry(name).or_default();
        truth.push([row.travel_mm, row.force_n]);
        if let (Some(sensed_n), Some(sigma_n)) = (row.sensed_n, row.sigma_n) {
            sensed.push([row.travel_mm, sensed_n]);
            intervals.push([sensed_n - TWO_SIDED_95 * sigma_n, sensed_n + TWO_SIDED_95 * sigma_n]);
        }
    }
    let mut series = Vec::new();
    for (n, ((_, name), [truth, sensed, intervals])) in courses.into_iter().enumerate() {
        let truth = match truth[..] {
            [[travel_mm, force_n]] => vec![[travel_mm - half_mm, force_n], [travel_mm + half_mm, force_n]],
            _ => truth,
        };
        series.extend(true_and_sensed(n, name, truth, (sensed, intervals)));
    }
    series
}

fn name_of(seen: &SeenContact) -> String {
    match (seen.contact.position, seen.wall) {
        _ if seen.clamped => "clamp (not sensed)".to_owned(),
        (ContactPosition::Node(node), _) => format!("node {node}"),
        (ContactPosition::At(at), Wall::Back) => format!("back plate at {:.1} mm", at.s_mm),
        (ContactPosition::At(at), Wall::Rib(rib)) => format!("rib {} at {:.1} mm", rib + 1, at.s_mm),
        (ContactPosition::At(at), _) => format!("plate at {:.1} mm", at.s_mm),
    }
}
