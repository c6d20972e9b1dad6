//! The command `finray sense`.

use super::contacts::Contacts;
use super::frames::{Source, observed, states};
use super::locate::Images;
use crate::commands::prelude::*;
use clap::ArgGroup;
use finray_files::observations::{Coordinates, ObservationTable, RefusedImage};
use finray_files::read_text;
use finray_files::views::{self, MeasuredForce};
use finray_model::estimators::EstimatorError;
use finray_model::observation::Observation;
use finray_model::sensing::{Alternative, SensingError};
use finray_model::sensor::{
    FrameState, MissingInScene, Refusal, SensedForce, SensedForces, Sensor, SensorOptions, SensorWarning, StreamSensor,
};

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray sense fixtures/scenes/paper.toml --displacements shape.csv --contact 19 --noise-mm 0.067
  finray sense mine.toml --image press1.jpg press2.jpg --rest rest.jpg --contact-at auto@auto
  finray sense mine.toml --video phone.mp4 --contact-at auto@friction --out forces.csv

Guide: finray guide sense";

/// Estimate contact forces and their standard deviations from displacements, images or a video.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[command(group = ArgGroup::new("finger_seen").required(true).args(["displacements", "image", "video"]))]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// CSV with node,ux_mm,uy_mm, or from `locate`; - for standard input
    #[arg(long, help_heading = "Input and output", value_name = "FILE")]
    displacements: Option<PathBuf>,
    /// Images (PNG, JPEG), each evaluated alone
    #[arg(long, help_heading = "Input and output", value_name = "FILE", num_args = 1..)]
    image: Vec<PathBuf>,
    /// Video (YUV4MPEG2; other files through ffmpeg), every frame
    #[arg(long, help_heading = "Input and output", value_name = "FILE")]
    video: Option<PathBuf>,
    /// Image of the unloaded finger, as for `locate`
    #[arg(long, help_heading = "Input and output", value_name = "FILE", conflicts_with = "displacements")]
    rest: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Question")]
    contacts: Contacts,
    /// Estimator of the forces
    #[arg(long, help_heading = "Estimator", value_parser = listed(EstimatorId::ALL, EstimatorId::name), default_value_t = EstimatorId::Nonlinear)]
    estimator: EstimatorId,
    /// Network file from `finray train` [default: the shipped network]
    #[arg(long, help_heading = "Estimator", value_name = "FILE")]
    network: Option<PathBuf>,
    /// Noise of a coordinate, mm [default: scene, else file, else residual]
    #[arg(long, help_heading = "Input and output", value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Upper bound of the friction coefficient; only for contacts with +-SD
    #[arg(long, help_heading = "Question", value_name = "MU", value_parser = not_negative, default_value_t = 0.0)]
    friction: f64,
    /// Name of the image to evaluate, if the file has several images
    #[arg(long, help_heading = "Input and output", value_name = "NAME", conflicts_with_all = ["image", "video"])]
    image_name: Option<String>,
    /// Evaluate every image; write one row per image and contact
    #[arg(long, help_heading = "Input and output", conflicts_with_all = ["image_name", "image", "video"])]
    all_images: bool,
    /// List the answer in each range of positions
    #[arg(long, help_heading = "Estimator", conflicts_with_all = ["all_images", "image", "video"])]
    alternatives: bool,
    /// Measured forces, for the direction `measured` (CSV: image,fx_n,fy_n)
    #[arg(long, help_heading = "Question", value_name = "FILE", conflicts_with_all = ["image", "video"])]
    forces: Option<PathBuf>,
    /// Mesh nodes, only for `nonlinear` [default: refined until converged]
    #[arg(long, help_heading = "Estimator", value_name = "N")]
    mesh_nodes: Option<usize>,
    /// Result file; - for standard output
    #[arg(long, help_heading = "Input and output", value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// Row of a sensed force. Of several images, a row also has the name of its image; of a video, the number and time of its frame; of both, the
/// state of the finger and the warnings. Without a force, a row has no numbers; if it is refused, the row has the reason.
#[derive(Serialize, Default, Clone)]
struct Row {
    #[serde(skip_serializing_if = "Option::is_none")]
    image: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    t_s: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<FrameState>,
    contact: Option<String>,
    s_mm: Option<f64>,
    angle_deg: Option<f64>,
    force_n: Option<f64>,
    sigma_n: Option<f64>,
    /// Limits of the 95 % interval of the force.
    low_n: Option<f64>,
    high_n: Option<f64>,
    /// Standard deviation and limits of the 95 % interval of an estimated position, and standard deviation of an estimated direction.
    s_sigma_mm: Option<f64>,
    s_low_mm: Option<f64>,
    s_high_mm: Option<f64>,
    angle_sigma_deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    warning: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
}

/// Row with `--alternatives`: best position of a range, direction and force there, limits of the 95 % intervals of force and position within the
/// range, and excess of the misfit over the smallest misfit, in variances of the noise.
#[derive(Serialize)]
struct AlternativeRow {
    contact: usize,
    s_mm: f64,
    angle_deg: f64,
    force_n: f64,
    low_n: f64,
    high_n: f64,
    s_low_mm: f64,
    s_high_mm: f64,
    excess_misfit: f64,
}

impl From<Alternative> for AlternativeRow {
    fn from(answer: Alternative) -> AlternativeRow {
        let Alternative { contact, position_mm, position_interval_mm, angle_deg, force_n, interval_n, excess } = answer;
        AlternativeRow {
            contact: contact + 1,
            s_mm: position_mm,
            angle_deg,
            force_n,
            low_n: interval_n[0],
            high_n: interval_n[1],
            s_low_mm: position_interval_mm[0],
            s_high_mm: position_interval_mm[1],
            excess_misfit: excess,
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let Arguments { displacements, image, video, rest, forces, .. } = arguments;
    let inputs =
        [&arguments.scene].into_iter().chain(displacements).chain(image).chain(video).chain(rest).chain(forces);
    require_one_standard_input(inputs)?;
    let scene = load_scene(&arguments.scene)?;
    let finger = &scene.finger;
    hints::of_scene(&arguments.scene, &scene);
    let (networks, _) = networks_of(arguments.network.as_deref(), &[arguments.estimator])?;
    let options = SensorOptions {
        estimator: arguments.estimator,
        networks,
        noise_mm: arguments.noise_mm,
        mesh_nodes: arguments.mesh_nodes,
    };
    let mut question = ImageQuestion {
        scene: &scene,
        contacts: &arguments.contacts,
        friction: arguments.friction,
        forces: None,
        options,
    };
    match (&arguments.forces, arguments.contacts.ask_measured()) {
        (Some(_), true) if arguments.contacts.count() > 1 => {
            return Err(bad_input(
                "a direction is `measured`: expected one contact, because --forces has one force per image",
            ));
        }
        (Some(_), true) => {}
        (Some(_), false) => {
            return Err(bad_input(
                "--forces: expected a contact with the direction `measured`, for instance auto@measured",
            ));
        }
        // Wrong contacts are reported before the images are evaluated, because such contacts are wrong for every image.
        (None, _) => drop(question.sensor(&Observation::default())?),
    }
    if arguments.alternatives && !arguments.contacts.ask_position() {
        return Err(bad_input(
            "--alternatives: expected a contact at an unknown position, for instance --contact-at auto@auto",
        ));
    }
    if arguments.contacts.assume_normal() {
        print_message(
            "note: `auto` has no direction: the force is assumed along the plate's undeformed normal (0 degrees); auto@ANGLE_DEG states a direction, \
             auto@auto estimates it",
        );
    }
    let Some(displacements) = displacements else { return frames(arguments, &question) };
    let text = read_text(displacements)?;
    let table = ObservationTable::new(displacements, &text, finger, Coordinates::Displacements)?;
    question.forces = arguments.forces.as_ref().map(|path| views::forces(path, &table.images()?)).transpose()?;
    let done = if arguments.alternatives {
        let seen = table.observation(arguments.image_name.as_deref())?;
        let found = question.sensor(&seen)?.alternatives(&seen).map_err(|refusal| failure(refusal, &seen, &table))?;
        hints::of_other_scene(displacements, &seen, &scene);
        let answers = found.len();
        let rows: Vec<AlternativeRow> = found.into_iter().map(AlternativeRow::from).collect();
        write_file(&arguments.out, &csv_text(rows)?)?;
        format!("{} found", count(answers, "answer"))
    } else if arguments.all_images {
        let rows = all_images(&question, &table)?;
        if let Some(seen) = table.images()?.iter().find_map(|image| table.observation(Some(image)).ok()) {
            hints::of_other_scene(displacements, &seen, &scene);
        }
        let refused = rows.iter().filter(|row| row.refused.as_deref() != Some("")).count();
        let asked = rows.len();
        write_file(&arguments.out, &csv_text(rows)?)?;
        let images = count(table.images()?.len(), "image");
        format!(
            "{} of {} in {images} sensed, {refused} refused{}",
            asked - refused,
            count(asked, "force"),
            with_model_error(&scene)
        )
    } else {
        let seen = table.observation(arguments.image_name.as_deref())?;
        let sensor = question.sensor(&seen)?;
        let sensed = sensor.sense(&seen).map_err(|refusal| failure(refusal, &seen, &table))?;
        hints::of_other_scene(displacements, &seen, &scene);
        warn("", &sensed.warnings);
        write_file(&arguments.out, &csv_text(rows(&question, &sensed))?)?;
        let warnings = sensor.validity_warnings(&sensed);
        warnings.iter().for_each(|warning| print_message(format_args!("warning: {warning}")));
        format!("{} sensed{}", count(sensed.forces.len(), "force"), with_model_error(&scene))
    };
    hints::of_displacements(displacements, &text, finger);
    Ok(summary(done, [&arguments.out]))
}

/// Senses the forces in image files, or in every frame of a video. Markers are located with the scene that senses.
fn frames(arguments: &Arguments, question: &ImageQuestion) -> Result<String, Failure> {
    let &ImageQuestion { scene, contacts, friction, ref options, .. } = question;
    let sensor = StreamSensor::new(scene.clone(), contacts.of(scene, friction, None)?, options.clone())?;
    let images = Images { scene: &arguments.scene, images: &arguments.image, rest: arguments.rest.as_deref() };
    let mut all = Frames { question, sensor, rows: Vec::new(), counts: [0; 4] };
    let Some(video) = &arguments.video else {
        for seen in images.located(scene)? {
            let (image, seen) = match seen {
                Ok(seen) => (seen.image.clone(), Ok(seen)),
                Err(RefusedImage { image, reason }) => (image, Err((FrameState::Refused, reason))),
            };
            all.add(Row { image: Some(image), ..Row::default() }, seen, None);
        }
        return all.finish("image", &arguments.out);
    };
    let mut observer = images.observer(scene)?;
    let mut source = Source::open(video, None, None)?;
    if !source.shows_pixels() {
        return Err(FileError::content(video, "expected a video, found positions of markers").into());
    }
    source.require_size(scene)?;
    let progress = progress_bar(0, "frames");
    progress.unset_length();
    let (mut spare, mut before) = (None, None);
    while let Some(frame) = source.next(all.counts.iter().sum(), spare.take())? {
        let row = Row { frame: Some(frame.info.number), t_s: Some(frame.info.time_s), ..Row::default() };
        before = all.add(row, observed(&frame.content, "", Some(&mut observer)), before.as_ref());
        spare = Some(frame);
        progress.inc(1);
    }
    progress.finish_and_clear();
    all.finish("frame", &arguments.out)
}

/// Rows of the images or frames that are evaluated so far.
struct Frames<'a> {
    question: &'a ImageQuestion<'a>,
    sensor: StreamSensor,
    rows: Vec<Row>,
    /// Number of frames by state.
    counts: [usize; 4],
}

impl Frames<'_> {
    /// Senses the forces of a frame, starting from those of the frame before, and adds its rows to `row`, which names the frame. Returns the forces.
    fn add(
        &mut self,
        row: Row,
        seen: Result<Observation, (FrameState, String)>,
        before: Option<&SensedForces>,
    ) -> Option<SensedForces> {
        let sensed = seen.and_then(|seen| {
            self.sensor.sense(&seen, before).map_err(|refusal| (FrameState::Refused, refusal.to_string()))
        });
        let (state, sensed, refused) = match sensed {
            Ok(Some(sensed)) => (FrameState::Contact, Some(sensed), String::new()),
            Ok(None) => (FrameState::None, None, String::new()),
            Err((state, reason)) => (state, None, reason),
        };
        self.counts[state as usize] += 1;
        let of_forces = sensed.iter().flat_map(|sensed| &sensed.warnings).map(ToString::to_string);
        let of_beams = sensed.iter().flat_map(|sensed| self.sensor.validity_warnings(sensed));
        let warning = of_forces.chain(of_beams).collect::<Vec<_>>().join("; ");
        let Row { image, frame, t_s, .. } = row;
        let named = |row: Row| Row {
            image: image.clone(),
            frame,
            t_s,
            state: Some(state),
            warning: Some(warning.clone()),
            refused: Some(refused.clone()),
            ..row
        };
        match &sensed {
            Some(sensed) => self.rows.extend(rows(self.question, sensed).into_iter().map(named)),
            None => self.rows.push(named(Row::default())),
        }
        sensed
    }

    /// Writes the table, and says how many frames (`noun`) have which state.
    fn finish(self, noun: &str, out: &PathBuf) -> Result<String, Failure> {
        write_file(out, &csv_text(self.rows)?)?;
        let frames = count(self.counts.iter().sum(), noun);
        Ok(summary(format!("{frames}: {}{}", states(self.counts), with_model_error(self.question.scene)), [out]))
    }
}

/// The errors of the finger that standard deviations include, with their origins; nothing if they include none.
fn with_model_error(scene: &Scene) -> String {
    let Scene { model_error, stiffness_error, thickness_error, .. } = scene;
    let model = (model_error.share() > 0.0).then(|| format!("a model error of {model_error}"));
    let stiffness = (stiffness_error.share() > 0.0).then(|| format!("a stiffness error of {stiffness_error}"));
    let thickness = (thickness_error.sd > 0.0).then(|| thickness_error.to_string());
    let included: Vec<String> = model.into_iter().chain(stiffness).chain(thickness).collect();
    if included.is_empty() { String::new() } else { format!("; sigma_n includes {}", included.join(" and ")) }
}

/// Contacts, friction and estimator for all images, with the measured force of each image.
struct ImageQuestion<'a> {
    scene: &'a Scene,
    contacts: &'a Contacts,
    friction: f64,
    /// Measured forces, if a contact has the direction `measured`.
    forces: Option<Vec<MeasuredForce>>,
    options: SensorOptions,
}

impl ImageQuestion<'_> {
    fn force(&self, image: &str) -> Option<&MeasuredForce> {
        self.forces.iter().flatten().find(|measured| measured.image == image)
    }

    /// Builds the sensor for one image. The direction of a measured force is rotated into the frame of the image's base.
    fn sensor(&self, seen: &Observation) -> Result<Sensor, Failure> {
        let in_base = |measured: &MeasuredForce| seen.frame(self.scene).rotation.inverse() * measured.force;
        let measured_deg = self.force(&seen.image).map(|measured| self.scene.finger.angle_deg(in_base(measured)));
        let contacts = self.contacts.of(self.scene, self.friction, measured_deg)?;
        Ok(Sensor::new(self.scene.clone(), contacts, self.options.clone())?)
    }
}

/// One row per image and contact. Rows of a refused image have a reason instead of numbers.
fn all_images(question: &ImageQuestion, table: &ObservationTable) -> Result<Vec<Row>, Failure> {
    let mut all = Vec::new();
    for image in table.images()? {
        let of_image =
            |row: Row, refused: &str| Row { image: Some(image.to_owned()), refused: Some(refused.to_owned()), ..row };
        let refused = |reason: &str| -> Vec<Row> {
            (0..question.contacts.count()).map(|_| of_image(Row::default(), reason)).collect()
        };
        if let Some(reason) = table.refused(image) {
            all.extend(refused(reason));
            continue;
        }
        if question.forces.is_some() && question.force(image).is_none() {
            all.extend(refused(&MissingInScene::Measured.to_string()));
            continue;
        }
        let seen = table.observation(Some(image))?;
        let sensor = question.sensor(&seen)?;
        match sensor.sense(&seen) {
            Ok(sensed) => {
                warn(&format!("{image}: "), &sensed.warnings);
                let warnings = sensor.validity_warnings(&sensed);
                warnings.iter().for_each(|warning| print_message(format_args!("warning: {image}: {warning}")));
                all.extend(rows(question, &sensed).into_iter().map(|row| of_image(row, "")));
            }
            // An invalid cell of the file ends the command. A refusal for any reason other than an invalid cell affects only the rows of the refused
            // image.
            Err(Refusal::Observation(error)) => return Err(table.error(Some(image), &error).into()),
            Err(refusal) => all.extend(refused(&refusal.to_string())),
        }
    }
    Ok(all)
}

/// The refusal of an image. An invalid cell names its line in the file.
fn failure(refusal: Refusal, seen: &Observation, table: &ObservationTable) -> Failure {
    let image = Some(seen.image.as_str()).filter(|image| !image.is_empty());
    match refusal {
        Refusal::Observation(error) => table.error(image, &error).into(),
        Refusal::Estimator(EstimatorError::Sensing(SensingError::TwoRanges { .. })) => {
            bad_input(format!("{refusal}; --alternatives lists the answer in each range"))
        }
        refusal => refusal.into(),
    }
}

/// Prints each warning, with `about` before it.
fn warn(about: &str, warnings: &[SensorWarning]) {
    for warning in warnings {
        let kind = if *warning == SensorWarning::NoResidual { "note" } else { "warning" };
        print_message(format_args!("{kind}: {about}{warning}"));
    }
}

fn rows(question: &ImageQuestion, sensed: &SensedForces) -> Vec<Row> {
    let row = |sensed: &SensedForce| {
        let [low_n, high_n] = sensed.interval_n().map(Some);
        let limits_mm = sensed.uncertainty.position_interval_mm;
        Row {
            contact: Some(sensed.contact.position.name()),
            s_mm: sensed.contact.position_mm(&question.scene.finger),
            angle_deg: Some(sensed.contact.angle_deg),
            force_n: Some(sensed.force_n),
            sigma_n: Some(sensed.sigma_n),
            low_n,
            high_n,
            s_sigma_mm: sensed.uncertainty.position_sd_mm,
            s_low_mm: limits_mm.map(|limits_mm| limits_mm[0]),
            s_high_mm: limits_mm.map(|limits_mm| limits_mm[1]),
            angle_sigma_deg: sensed.uncertainty.direction_sd_deg,
            ..Row::default()
        }
    };
    sensed.forces.iter().map(row).collect()
}
