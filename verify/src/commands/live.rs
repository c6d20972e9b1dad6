//! The command `finray live`.

mod input;
mod line;
mod newest;

use super::contacts::Contacts;
use crate::commands::prelude::*;
use finray_files::{open_stream, streamed};
use finray_imaging::locate::Observer;
use finray_model::observation::Observation;
use finray_model::sensor::{RestPositions, SensorOptions, StreamSensor};
use input::{Content, Frame, Source};
use line::{Line, State};
use newest::Newest;
use std::io::Write;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  ffmpeg -i /dev/video0 -f yuv4mpegpipe -pix_fmt yuv444p - | finray live scene.toml --contact-at auto@normal
  finray live scene.toml --contact-at auto@normal --image frames/*.png --every-frame
  finray live scene.toml --contact-at 80@-20 --input positions.csv --every-frame

Guide: finray guide live";

/// Estimate contact forces in each frame of a stream, one line of JSON a frame.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Stream of frames (YUV4MPEG2, or raw with --format), or of positions (JSON lines, CSV); - for standard input
    #[arg(long, help_heading = "Input", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// Images (PNG, JPEG) instead of a stream, in the order in which they were taken
    #[arg(long, help_heading = "Input", value_name = "FILE", num_args = 1.., conflicts_with_all = ["input", "format"])]
    image: Vec<PathBuf>,
    /// Format of raw frames
    #[arg(long, help_heading = "Input", value_enum, requires = "size")]
    format: Option<Format>,
    /// Size of raw frames, px
    #[arg(long, help_heading = "Input", value_name = "WxH", value_parser = size, requires = "format")]
    size: Option<[u32; 2]>,
    /// Evaluate every frame; without it, frames that arrive during an evaluation are dropped except for the newest
    #[arg(long, help_heading = "Input")]
    every_frame: bool,
    /// Measure displacements from the mean of the first N frames, which show the unloaded finger
    #[arg(long, help_heading = "Input", value_name = "N", default_value_t = 0)]
    rest_frames: usize,
    /// Standard deviation of the noise in one coordinate, mm [default: the scene's, else that of each marker]
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

/// Format of raw frames.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// Red, green and blue of each pixel, 8 bits each
    Rgb24,
}

/// Width and height, px, from `WxH`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides
        .filter(|[width, height]| *width > 0 && *height > 0)
        .ok_or("expected WIDTHxHEIGHT in px, such as 1600x1400".to_owned())
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    if arguments.image.is_empty() {
        require_one_standard_input([&arguments.scene, &arguments.input])?;
    }
    let scene = load_scene(&arguments.scene)?;
    hints::of_moduli(&arguments.scene, &scene.finger);
    let networks = Networks::read(&finray_fixtures::NETWORKS)?;
    let options = SensorOptions {
        estimator: arguments.estimator,
        networks: &networks,
        noise_mm: arguments.noise_mm,
        mesh_nodes: None,
    };
    let sensor = StreamSensor::new(&scene, arguments.contacts.of(&scene, 0.0, None)?, options)?;
    let mut out = open_stream(&arguments.out)?;
    let source = match &arguments.image[..] {
        [] => Source::open(&arguments.input, arguments.size)?,
        images => Source::of_images(images),
    };
    let mut watched = Watched {
        scene: &scene,
        sensor,
        observer: None,
        rest: RestPositions::default(),
        rest_frames: arguments.rest_frames,
    };
    let newest = Newest::of(source, arguments.every_frame);
    let mut counts = [0; 4];
    let mut ended = None;
    while let Some(next) = newest.take() {
        let frame = match next {
            Ok(frame) => frame,
            Err(failure) => {
                ended = Some(failure);
                break;
            }
        };
        let line = watched.line(&frame)?;
        counts[line.state as usize] += 1;
        newest.give_back(frame);
        if let Err(reason) = writeln!(out, "{}", line.to_json()?).and_then(|()| out.flush()) {
            streamed(&arguments.out, Err(reason))?;
            break;
        }
    }
    let [in_contact, free, refused, lost] = counts;
    let frames = count(counts.iter().sum(), "frame");
    let done = format!("{frames}: {in_contact} in contact, {free} free, {refused} refused, {lost} without finger");
    match ended {
        None => Ok(summary(done, [&arguments.out])),
        Some(failure) => {
            print_message(done);
            Err(failure)
        }
    }
}

/// The finger in a stream.
struct Watched<'s> {
    scene: &'s Scene,
    sensor: StreamSensor<'s>,
    /// Locator of the markers; `None` until a frame with pixels arrives.
    observer: Option<Observer<'s>>,
    rest: RestPositions,
    /// Number of frames that still show the unloaded finger.
    rest_frames: usize,
}

impl Watched<'_> {
    /// The line of a frame.
    ///
    /// # Errors
    /// [`Failure`] for a scene that does not describe camera and markers, if the frame has pixels.
    fn line(&mut self, frame: &Frame) -> Result<Line, Failure> {
        let seen = match &frame.content {
            Content::Pixels(image) => {
                let observer = match &mut self.observer {
                    Some(observer) => observer,
                    none => none.insert(Observer::new(self.scene, None).map_err(bad_input)?),
                };
                observer.observe(image).map_err(|error| (State::Lost, error.to_string()))
            }
            Content::Markers(seen) => Ok(seen.clone()),
            Content::Unreadable(reason) => Err((State::Refused, reason.clone())),
        };
        let seen = match seen {
            Err((state, reason)) => return Ok(Line::without_forces(frame, state, 0, Some(reason))),
            Ok(seen) => seen,
        };
        let markers = seen.markers.len();
        if self.rest_frames > 0 {
            self.rest_frames -= 1;
            self.rest.add(&seen);
            return Ok(Line::without_forces(frame, State::None, markers, None));
        }
        let seen = if self.rest.is_empty() { seen } else { self.rest.displaced(&seen) };
        Ok(self.sensed(frame, &seen, markers))
    }

    fn sensed(&self, frame: &Frame, seen: &Observation, markers: usize) -> Line {
        match self.sensor.sense(seen) {
            Ok(Some(sensed)) => Line::of_forces(frame, &self.scene.finger, &sensed, markers),
            Ok(None) => Line::without_forces(frame, State::None, markers, None),
            Err(refusal) => Line::without_forces(frame, State::Refused, markers, Some(refusal.to_string())),
        }
    }
}
