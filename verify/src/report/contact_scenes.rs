//! Objects pressed onto the finger: drawings, force over travel, and sensed forces.

use super::ReportError;
use super::drawings::{ACROSS_AXIS, ALONG_AXIS, point};
use super::page::{Block, Cell, Column, Figure, Row, Section, Table};
use super::sections::{self, text};
use super::tables::percent;
use crate::check::worst;
use crate::experiments::contact_scene::samples::NoiseSamples;
use crate::experiments::contact_scene::study::{SceneStudy, StudiedStep};
use crate::experiments::contact_scene::{ForceRow, SeenContact, SensedForce, contacts_sensed};
use crate::figures::{Axis, Chart, Dash, FigureError, Frame, Hue, Series, Spread};
use crate::settings::TWO_SIDED_95;
use crate::study::Study;
use finray_model::Finger;
use finray_model::finger::Plate;
use finray_model::mesh::FingerShape;
use finray_model::sensing::ContactPlace;
use serde::Serialize;
use std::collections::BTreeMap;

pub(super) const CSV: &str = "contact_scenes.csv";
/// Length of the largest force's arrow, as a share of the front plate's.
const LONGEST_ARROW: f64 = 0.2;

/// A row of the CSV file.
#[derive(Serialize)]
pub(super) struct SceneRow<'s> {
    scene: &'s str,
    step: usize,
    travel_mm: f64,
    contact: &'s str,
    s_mm: Option<f64>,
    angle_deg: Option<f64>,
    force_n: f64,
    friction_n: Option<f64>,
    sensed_n: Option<f64>,
    sigma_n: Option<f64>,
    read_s_mm: Option<f64>,
    read_angle_deg: Option<f64>,
    /// Noise samples of the step, and how many were answered.
    samples: Option<usize>,
    answered: Option<usize>,
    /// Share of the samples whose stated 95 % interval holds the true force.
    covered: Option<f64>,
    rms_error_n: Option<f64>,
    rms_sigma_n: Option<f64>,
}

pub(super) fn rows(study: &Study) -> impl Iterator<Item = SceneRow<'_>> {
    study.contact_scenes.iter().flat_map(|scene| {
        let mut felt = 0;
        scene.rows.iter().map(move |row: &ForceRow| {
            let samples = scene.steps.get(row.step - 1).and_then(|studied| studied.samples.as_ref());
            // Rows of a step are its contacts, those on the clamp not felt, then the total: the order of the samples.
            let samples = samples.filter(|_| row.contact != "clamp");
            let which = felt;
            felt = match row.contact.as_str() {
                "total" => 0,
                "clamp" => felt,
                _ => felt + 1,
            };
            SceneRow {
                scene: &scene.name,
                step: row.step,
                travel_mm: row.travel_mm,
                contact: &row.contact,
                s_mm: row.s_mm,
                angle_deg: row.angle_deg,
                force_n: row.force_n,
                friction_n: row.friction_n,
                sensed_n: row.sensed_n,
                sigma_n: row.sigma_n,
                read_s_mm: row.read_s_mm,
                read_angle_deg: row.read_angle_deg,
                samples: samples.map(|samples| samples.taken),
                answered: samples.map(|samples| samples.answered),
                covered: samples.map(|samples| samples.coverage(which)),
                rms_error_n: samples.filter(|s| s.answered > 0).map(|samples| samples.rms_error_n(which)),
                rms_sigma_n: samples.filter(|s| s.answered > 0).map(|samples| samples.rms_sigma_n(which)),
            }
        })
    })
}

pub(super) fn section(study: &Study) -> Result<Option<Section>, ReportError> {
    if study.contact_scenes.is_empty() {
        return Ok(None);
    }
    let mut blocks = vec![text(
        "An object is pressed onto the finger, built as a lattice of rigid bodies and springs in the physics engine rapier, with \
         its rods as balls and its front plate as capsules. The forces of the engine's contacts are the true ones: this is \
         simulation. Sensing (nonlinear, on beams) is given what a camera could see: the displacements of the key nodes, and of \
         every contact its position and direction, read from points on the outlines of object and finger; all carry the camera's \
         noise, outline points as much a coordinate as markers. Which parts touch is taken as known, and so is the \
         coefficient of friction, as a bound: where it is not zero, the angle between force and normal is unknown within it. The stated \
         intervals allow for all of this. Lines are true forces, signs are sensed ones of one noise sample with their stated 95 % interval.",
    )];
    for scene in &study.contact_scenes {
        blocks.push(Block::Figures { figures: figures(&study.finger, scene)? });
        blocks.push(text(words(scene)));
    }
    blocks.push(Block::Table(table(&study.contact_scenes)));
    Ok(Some(sections::section("contact-scenes", "Pressing objects", blocks)))
}

/// The sentence at the head of the page: scenes without friction, and with it.
pub(super) fn verdict(study: &Study) -> Option<String> {
    let worst_total = |with_friction: bool| {
        let scenes = study.contact_scenes.iter().filter(|scene| (scene.friction > 0.0) == with_friction);
        let steps = scenes.flat_map(|scene| &scene.steps);
        let totals = steps.filter_map(|step| Some(step.clean.as_ref().ok()?.as_ref()?.total.relative_error().abs()));
        let totals: Vec<f64> = totals.collect();
        (!totals.is_empty()).then(|| percent(worst(totals)))
    };
    let smooth = worst_total(false)?;
    let rough = worst_total(true).map_or(String::new(), |rough| {
        format!(", and with friction, of which sensing knows the coefficient alone, by up to {rough}")
    });
    let smallest = least_known(&study.contact_scenes).map_or(String::new(), |least| {
        format!(
            " Single contacts are sensed worse: {} carries {:.2} N, and its sensed force scatters by {:.2} N.",
            least.name, least.true_n, least.rms_error_n
        )
    });
    Some(format!(
        "In simulation, with objects pressed onto the lattice, the sensed total errs by up to {smooth} without noise and friction{rough}.{smallest}"
    ))
}

/// A contact of the last step of a scene under noise.
struct LeastKnown {
    name: String,
    true_n: f64,
    rms_error_n: f64,
}

/// The contact, among the last steps of all scenes, whose error under noise is the largest share of its force.
fn least_known(scenes: &[SceneStudy]) -> Option<LeastKnown> {
    let ends = scenes.iter().filter_map(|scene| Some((scene, scene.steps.last()?)));
    let contacts = ends.flat_map(|(scene, last)| {
        let felt = last.step.contacts.iter().filter(|seen| !seen.clamped).enumerate();
        felt.filter_map(move |(which, seen)| {
            let samples = last.samples.as_ref().filter(|samples| samples.answered > 0)?;
            let name = format!("{} in the scene \"{}\"", name_of(seen), scene.name);
            Some(LeastKnown { name, true_n: seen.normal_n, rms_error_n: samples.rms_error_n(which) })
        })
    });
    contacts.max_by(|a, b| (a.rms_error_n / a.true_n).total_cmp(&(b.rms_error_n / b.true_n)))
}

fn figures(finger: &Finger, scene: &SceneStudy) -> Result<Vec<Figure>, FigureError> {
    let mut figures = Vec::new();
    if let Some(last) = scene.steps.last() {
        figures.push(Figure {
            svg: picture(finger, scene, last)?,
            caption: format!("The scene \"{}\" at its end: true forces on the finger.", scene.name),
            csv: Some(CSV.to_owned()),
            wide: false,
        });
    }
    let series = force_over_travel(finger, scene);
    if !series.is_empty() {
        let title = format!("{}, {} mm noise", scene.name, scene.noise_mm);
        let frame = Frame::half(title, format!("True and sensed forces of the scene {} over the travel.", scene.name));
        let axes = [Axis::linear("travel of the object, mm"), Axis::linear("force, N")];
        let svg = Chart::new(frame, axes, series).svg()?;
        figures.push(Figure {
            svg,
            caption: "Force along each contact's normal, and in all along the object's way.".to_owned(),
            csv: Some(CSV.to_owned()),
            wide: false,
        });
    }
    Ok(figures)
}

fn lines_of(finger: &Finger, at: impl Fn(finray_model::NodeId) -> [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let plates = [Plate::Front, Plate::Back].map(|plate| finger.plate_nodes(plate));
    let ribs = (0..finger.rib_count()).map(|rib| finger.rib_nodes(rib).to_vec());
    plates.into_iter().chain(ribs).map(|nodes| nodes.into_iter().map(&at).collect()).collect()
}

fn picture(finger: &Finger, scene: &SceneStudy, last: &StudiedStep) -> Result<String, FigureError> {
    let pressed = &last.step.pressed;
    let deformed = |shape: &FingerShape| {
        lines_of(finger, |node| {
            let motion = shape.motion(node);
            point(&(motion.position + motion.displacement))
        })
    };
    let outline = scene.outline.iter().map(|corner| point(&(corner + pressed.object))).collect();
    let longest_mm = LONGEST_ARROW * finger.plate_length_mm(Plate::Front);
    let largest_n = worst(last.step.contacts.iter().map(|seen| seen.force.norm()));
    // Small forces keep an arrow that can be seen.
    let length_mm = |force_n: f64| longest_mm * (0.3 + 0.7 * force_n / largest_n);
    let arrows = last.step.contacts.iter().map(|seen| {
        let foot = seen.point - seen.force.normalize() * length_mm(seen.force.norm());
        Series::arrow([point(&foot), point(&seen.point)], format!("{:.2} N", seen.force.norm()), Hue::Vermilion)
    });
    let alt = format!("The finger bent by the object of the scene {}, with the contact forces.", scene.name);
    let at_rest = lines_of(finger, |node| point(&finger.position(node)));
    let lines = [
        Series::lines("at rest", at_rest, Hue::Faint, 3.0),
        Series::lines("pressed", deformed(&pressed.shape), Hue::Blue, 2.4),
        Series::lines("object", vec![outline], Hue::Green, 2.4),
    ];
    let series = lines.into_iter().flatten().chain(arrows).collect();
    Chart::to_scale(Frame::half(&scene.name, alt), [ALONG_AXIS, ACROSS_AXIS], series).svg()
}

/// One contact through the steps in which it is there.
#[derive(Default)]
struct Course {
    truth: Vec<[f64; 2]>,
    sensed: Vec<[f64; 2]>,
    intervals: Vec<[f64; 2]>,
}

/// The rods that a place of the front plate lies between.
fn between(finger: &Finger, s_mm: f64) -> String {
    let (nodes, places) = (finger.plate_nodes(Plate::Front), finger.plate_places_mm(Plate::Front));
    let after = places.iter().position(|place| *place > s_mm).filter(|after| *after > 0);
    after.map_or(String::new(), |after| format!(", nodes {} to {}", nodes[after - 1], nodes[after]))
}

/// For each contact, and the total, the true forces as a line and the sensed ones as signs.
fn force_over_travel(finger: &Finger, scene: &SceneStudy) -> Vec<Series> {
    let mut courses: BTreeMap<(usize, String), Course> = BTreeMap::new();
    for row in &scene.rows {
        let name = match row.contact.as_str() {
            "total" => (0, "in all".to_owned()),
            "at" => (2, format!("plate{}", between(finger, row.s_mm.unwrap_or_default()))),
            "clamp" => (3, "clamp (not felt)".to_owned()),
            node => (1, format!("node {node}")),
        };
        let course = courses.entry(name).or_default();
        course.truth.push([row.travel_mm, row.force_n]);
        if let (Some(sensed_n), Some(sigma_n)) = (row.sensed_n, row.sigma_n) {
            course.sensed.push([row.travel_mm, sensed_n]);
            course.intervals.push([sensed_n - TWO_SIDED_95 * sigma_n, sensed_n + TWO_SIDED_95 * sigma_n]);
        }
    }
    let mut series = Vec::new();
    for (n, ((_, name), course)) in courses.into_iter().enumerate() {
        let truth = Series::nth(n, name, course.truth);
        let marker = truth.marker;
        series.push(Series { marker: None, ..truth });
        if !course.sensed.is_empty() {
            let sensed = Series::nth(n, "", course.sensed);
            series.push(Series { marker, dash: Dash::None, spread: Spread::Bars(course.intervals), ..sensed });
        }
    }
    series
}

fn words(scene: &SceneStudy) -> String {
    let mut sentences = Vec::new();
    if let Some(error) = &scene.stopped {
        sentences.push(format!("The scene ended after {} steps: {error}.", scene.steps.len()));
    }
    let clean: Vec<_> = scene.steps.iter().filter_map(|studied| studied.clean.as_ref().ok()?.as_ref()).collect();
    if clean.is_empty() {
        sentences.push("Nothing was sensed.".to_owned());
        return sentences.join(" ");
    }
    let total = worst(clean.iter().map(|sensed| sensed.total.relative_error().abs()));
    let balance = worst(scene.steps.iter().filter_map(|studied| studied.step.pressed.imbalance()));
    sentences.push(format!(
        "Without noise the sensed total is within {} of the true one at every step; contact forces balance those of the hand and \
         of the clamps within {balance:.0e} of their size.",
        percent(total)
    ));
    let sampled: Vec<&NoiseSamples> = scene.steps.iter().filter_map(|studied| studied.samples.as_ref()).collect();
    if !sampled.is_empty() {
        let sum = |of: &dyn Fn(&NoiseSamples) -> usize| sampled.iter().map(|samples| of(samples)).sum::<usize>();
        let coverages = |of: &dyn Fn(&NoiseSamples) -> std::ops::Range<usize>| {
            let cells = sampled.iter().flat_map(|samples| of(samples).map(|which| samples.coverage(which)));
            let cells: Vec<f64> = cells.collect();
            let least = cells.iter().copied().fold(f64::INFINITY, f64::min);
            (cells.iter().sum::<f64>() / cells.len() as f64, least)
        };
        let contacts = coverages(&|samples| 0..samples.sensed.len() - 1);
        let total = coverages(&|samples| samples.sensed.len() - 1..samples.sensed.len());
        sentences.push(format!(
            "Of {} noise samples of all steps, {} are answered. The stated 95 % intervals hold the true force of a contact in {} of all \
             samples (in {} where that is least), and the true total in {} ({}); refused samples count as not held.",
            sum(&|samples| samples.taken),
            sum(&|samples| samples.answered),
            percent(contacts.0),
            percent(contacts.1),
            percent(total.0),
            percent(total.1),
        ));
    }
    if scene.friction > 0.0 {
        sentences.push(format!(
            "With friction ({}) forces lie anywhere in a cone of {:.1} deg around the normal; the intervals are widened by what the markers \
             leave open of that.",
            scene.friction,
            scene.friction.atan().to_degrees()
        ));
    }
    sentences.join(" ")
}

fn name_of(seen: &SeenContact) -> String {
    match seen.contact.place {
        _ if seen.clamped => "clamp (not felt)".to_owned(),
        ContactPlace::Node(node) => format!("node {node}"),
        ContactPlace::Place(s_mm) => format!("plate at {s_mm:.1} mm"),
    }
}

fn table(scenes: &[SceneStudy]) -> Table {
    let columns = vec![
        Column::words("scene"),
        Column::words("contact"),
        Column::numbers("normal, deg"),
        Column::numbers("true, N"),
        Column::numbers("friction, N"),
        Column::numbers("sensed, N"),
        Column::numbers("error"),
        Column::numbers("noise: rms error, N"),
        Column::numbers("stated sigma, N"),
        Column::numbers("within 1.96 sigma"),
    ];
    let rows = scenes.iter().filter_map(|scene| Some((scene, scene.steps.last()?))).flat_map(|(scene, last)| {
        let clean = last.clean.as_ref().ok().and_then(Option::as_ref);
        let mut which = 0;
        let mut noisy = move |sensed: Option<SensedForce>| {
            let samples = last.samples.as_ref().filter(|samples| samples.answered > 0)?;
            sensed?;
            which += 1;
            let [error, sigma] = [samples.rms_error_n(which - 1), samples.rms_sigma_n(which - 1)];
            Some([format!("{error:.3}"), format!("{sigma:.3}"), percent(samples.coverage(which - 1))])
        };
        let mut rows: Vec<Row> = Vec::new();
        let contacts = contacts_sensed(&last.step, clean);
        let total = clean.map(|sensed| sensed.total);
        let contacts = contacts.map(|(seen, sensed)| {
            (
                name_of(seen),
                Some(seen.contact.angle_deg),
                seen.normal_n,
                Some(seen.friction_n),
                sensed.map(|sensed| sensed.force),
            )
        });
        let whole = total.map(|total| ("in all".to_owned(), None, total.true_n, None, Some(total)));
        for (name, angle_deg, true_n, friction_n, sensed) in contacts.chain(whole) {
            let number = |value: Option<f64>, digits: usize| {
                // What rounds to nothing has no sign.
                let rounded = |value: f64| if value.abs() < 0.5 * 0.1_f64.powi(digits as i32) { 0.0 } else { value };
                Cell::plain(value.map_or("-".to_owned(), |value| format!("{:.digits$}", rounded(value))))
            };
            let noisy = noisy(sensed).unwrap_or(["-", "-", "-"].map(str::to_owned));
            rows.push(Row {
                cells: [
                    Cell::plain(scene.name.clone()),
                    Cell::plain(name),
                    number(angle_deg, 1),
                    number(Some(true_n), 3),
                    number(friction_n, 3),
                    number(sensed.map(|force| force.sensed_n), 3),
                    Cell::plain(sensed.map_or("-".to_owned(), |force| percent(force.relative_error().abs()))),
                ]
                .into_iter()
                .chain(noisy.map(Cell::plain))
                .collect(),
            });
        }
        rows
    });
    Table {
        caption: "True and sensed forces at the end of each scene: sensed without noise; error, stated standard deviation and coverage with \
                  noise"
            .to_owned(),
        columns,
        rows: rows.collect(),
        csv: Some(CSV.to_owned()),
    }
}
