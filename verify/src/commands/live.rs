//! The command `finray live`.

mod input;
mod line;
mod newest;

use super::contacts::Contacts;
use crate::commands::prelude::*;
use finray_files::frames::LARGEST_SIDE_PX;
use finray_files::{open_stream, streamed};
use finray_imaging::locate::{LocateError, Observer};
use finray_model::observation::Observation;
use finray_model::sensor::{RestPositions, SensedForces, SensorOptions, StreamSensor};
use input::{Content, Format, Frame, Source};
use line::{Line, State};
use newest::Newest;
use std::io::Write;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  ffmpeg -i /dev/video0 -f yuv4mpegpipe - | finray live scene.toml --contact-at auto@normal
  finray live scene.toml --contact-at auto@normal --image frames/*.png --every-frame
  finray live scene.toml --contact-at 80@-20 --input positions.csv --every-frame

Guide: finray guide live";

/// Estimate contact forces in each frame of a stream; write one line of JSON per frame.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Stream of frames (YUV4MPEG2, or raw with --format rgb24), or of marker positions (JSON lines, CSV); - for standard input
    #[arg(long, help_heading = "Input", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// Images (PNG, JPEG) instead of a stream, in the order in which they were taken
    #[arg(long, help_heading = "Input", value_name = "FILE", num_args = 1.., conflicts_with_all = ["input", "format", "size"])]
    image: Vec<PathBuf>,
    /// Format of the stream [default: recognised by the first byte]
    #[arg(long, help_heading = "Input", value_enum)]
    format: Option<Format>,
    /// Size of raw frames (rgb24), px
    #[arg(long, help_heading = "Input", value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Evaluate every frame, not only the newest
    #[arg(long, help_heading = "Input")]
    every_frame: bool,
    /// Measure displacements from the mean of the first N frames, which show the unloaded finger
    #[arg(long, help_heading = "Input", value_name = "N", default_value_t = 0)]
    rest_frames: usize,
    /// Standard deviation of the noise in one coordinate, mm [default: the scene's, else stated per marker]
    #[arg(long, help_heading = "Input", value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    #[command(flatten, next_help_heading = "Question")]
    contacts: Contacts,
    /// Estimator of the forces
    #[arg(long, help_heading = "Estimator", value_parser = listed(EstimatorId::ALL, EstimatorId::name), default_value_t = EstimatorId::Nonlinear)]
    estimator: EstimatorId,
    /// Result file; - for standard output
    #[arg(long, help_heading = "Output", value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

/// Width and height, px, from `WxH`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides
        .filter(|sides: &[u32; 2]| sides.iter().all(|side| (1..=LARGEST_SIDE_PX).contains(side)))
        .ok_or_else(|| format!("expected WIDTHxHEIGHT from 1 to {LARGEST_SIDE_PX} px, such as 1600x1400"))
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    if arguments.image.is_empty() {
        require_one_standard_input([&arguments.scene, &arguments.input])?;
    }
    let scene = load_scene(&arguments.scene)?;
    hints::of_moduli(&arguments.scene, &scene.finger);
    let networks = Networks::read(&finray_fixtures::NETWORKS)?;
    // Displacements are measured from the mean of the rest frames, so the noise of this mean adds to that of the frame.
    let wider = if arguments.rest_frames == 0 { 1.0 } else { (1.0 + 1.0 / arguments.rest_frames as f64).sqrt() };
    let options = SensorOptions {
        estimator: arguments.estimator,
        networks: &networks,
        noise_mm: arguments.noise_mm.or(scene.noise_mm).map(|noise_mm| wider * noise_mm),
        mesh_nodes: None,
    };
    let sensor = StreamSensor::new(&scene, arguments.contacts.of(&scene, 0.0, None)?, options)?;
    let source = match &arguments.image[..] {
        [] => Source::open(&arguments.input, arguments.format, arguments.size)?,
        images => Source::of_images(images),
    };
    let observer = match source.shows_pixels() {
        true => Some(Observer::new(&scene, None).map_err(bad_input)?),
        false => None,
    };
    source.require_size(camera_size_px(&scene))?;
    let mut out = open_stream(&arguments.out)?;
    let mut watched = Watched {
        scene: &scene,
        sensor,
        observer,
        rest: RestPositions::default(),
        rest_frames: arguments.rest_frames,
        measures_from_rest: arguments.rest_frames > 0,
        before: None,
    };
    let newest = Newest::of(source, arguments.every_frame)?;
    let (mut counts, mut dropped) = ([0; 4], 0);
    let mut ended = Ok(());
    while let Some(next) = newest.take() {
        let frame = match next {
            Ok(frame) => frame,
            Err(failure) => {
                ended = Err(failure);
                break;
            }
        };
        let line = watched.line(&frame);
        counts[line.state as usize] += 1;
        dropped += frame.dropped;
        newest.give_back(frame);
        let text = line.to_json()? + "\n";
        if let Err(reason) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            streamed(&arguments.out, Err(reason))?;
            break;
        }
    }
    ended?;
    let [in_contact, free, refused, lost] = counts;
    let frames = count(counts.iter().sum(), "frame");
    let states = format!("{in_contact} in contact, {free} free, {refused} refused, {lost} without finger");
    Ok(summary(format!("{frames}: {states}; {dropped} dropped"), [&arguments.out]))
}

/// Width and height of the scene's camera, px.
fn camera_size_px(scene: &Scene) -> Option<[u32; 2]> {
    scene.camera.map(|camera| camera.lens.size_px())
}

/// Evaluation of a stream: marker locator, sensor, and positions of the markers on the unloaded finger.
struct Watched<'s> {
    scene: &'s Scene,
    sensor: StreamSensor<'s>,
    /// Locator of the markers; `None` for a stream of positions.
    observer: Option<Observer<'s>>,
    rest: RestPositions,
    /// Number of frames of the unloaded finger that are still to be read.
    rest_frames: usize,
    /// Whether the first frames show the unloaded finger.
    measures_from_rest: bool,
    /// Forces of the frame before, if it showed any.
    before: Option<SensedForces>,
}

impl Watched<'_> {
    /// Evaluates a frame. Returns its line of the result.
    fn line(&mut self, frame: &Frame) -> Line {
        let seen = match (&frame.content, &mut self.observer) {
            (Content::Pixels(image), Some(observer)) => observer.observe(image).map_err(|error| match error {
                LocateError::Size { .. } => (State::Refused, error.to_string()),
                _ => (State::Lost, error.to_string()),
            }),
            (Content::Pixels(_), None) => Err((State::Refused, "expected positions, found an image".to_owned())),
            (Content::Markers(seen), _) => Ok(seen.clone()),
            (Content::Unreadable(reason), _) => Err((State::Refused, reason.clone())),
        };
        let seen = match seen {
            Err((state, reason)) => return Line::without_forces(frame, state, 0, Some(reason)),
            Ok(seen) => seen,
        };
        let markers = seen.markers.len();
        if self.rest_frames == 0 {
            let seen = if self.measures_from_rest { self.rest.displaced(&seen) } else { seen };
            return self.sensed(frame, &seen, markers);
        }
        // A frame with markers that the finger does not have is refused; as a rest frame it would make every later frame invalid.
        match seen.for_sensing(self.scene, true, None) {
            Ok(found) if !found.measurement.markers().is_empty() => {
                self.rest_frames -= 1;
                self.rest.add(&seen);
                Line::without_forces(frame, State::None, markers, None)
            }
            Ok(_) => Line::without_forces(frame, State::Refused, markers, Some("no marker is seen".to_owned())),
            Err(error) => Line::without_forces(frame, State::Refused, markers, Some(error.to_string())),
        }
    }

    fn sensed(&mut self, frame: &Frame, seen: &Observation, markers: usize) -> Line {
        match self.sensor.sense(seen, self.before.take().as_ref()) {
            Ok(Some(sensed)) => {
                let line = Line::of_forces(frame, &self.scene.finger, &sensed, markers);
                self.before = Some(sensed);
                line
            }
            Ok(None) => Line::without_forces(frame, State::None, markers, None),
            Err(refusal) => Line::without_forces(frame, State::Refused, markers, Some(refusal.to_string())),
        }
    }
}
