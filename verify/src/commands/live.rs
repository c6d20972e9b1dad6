//! The command `finray live`.

mod newest;
mod serve;

use super::contacts::Contacts;
use super::frames::{Content, Format, Source, observed, states};
use crate::commands::prelude::*;
use finray_files::frames::LARGEST_SIDE_PX;
use finray_files::live::{Line, contact_forces};
use finray_files::recording::{ContactForce, Recording};
use finray_files::{open_stream, streamed};
use finray_imaging::locate::Observer;
use finray_model::sensor::{FingerResult, FingerTracker, FrameState, SensorOptions};

use newest::Newest;
use serve::Server;
use std::io::Write;
use std::net::SocketAddr;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  ffmpeg -i /dev/video0 -f yuv4mpegpipe - | finray live scene.toml --contact-at auto@normal
  finray live scene.toml --contact-at auto@normal --image frames/*.png --every-frame
  finray live scene.toml --contact-at 80@-20 --input positions.csv --every-frame

Guide: finray guide live";

/// Estimate contact forces in the frames of a stream; write one line of JSON per evaluated frame.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML)
    #[arg(required_unless_present = "finger")]
    scene: Option<PathBuf>,
    /// Name and scene of each finger, if frames show several fingers
    #[arg(long, help_heading = "Input", value_name = "NAME=SCENE", value_parser = named_scene, num_args = 1.., conflicts_with = "scene")]
    finger: Vec<(String, PathBuf)>,
    /// Video (YUV4MPEG2, raw, ffmpeg) or positions (JSON, CSV)
    #[arg(long, help_heading = "Input", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// Images (PNG, JPEG) instead of a stream, in order of time
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
    /// Take the first N evaluated frames as reference
    #[arg(long, help_heading = "Input", value_name = "N", default_value_t = 0)]
    rest_frames: usize,
    /// Standard deviation of the noise in one coordinate, mm [default: the scene's value; without one, the value stated for each marker]
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
    /// Recording for ROS 2 (MCAP): JSON lines and WrenchStamped forces
    #[arg(long, help_heading = "Output", value_name = "FILE")]
    record: Option<PathBuf>,
    /// Also record each evaluated image (Image, rgb8)
    #[arg(long, help_heading = "Output", requires = "record")]
    record_images: bool,
    /// Address of a page that shows the forces; port 0 chooses a free port
    #[arg(long, help_heading = "Output", value_name = "ADDR:PORT", value_parser = address)]
    serve: Option<SocketAddr>,
}

/// Name and scene file of a finger, from `NAME=SCENE`.
fn named_scene(text: &str) -> Result<(String, PathBuf), String> {
    // Names must be valid in ROS 2 topics: a name begins with a letter, has no two underscores in a row, and does not end with an underscore.
    let is_name = |name: &str| {
        let has_parts = name.split('_').all(|part| !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric()));
        has_parts && name.starts_with(|first: char| first.is_ascii_alphabetic())
    };
    let named = text.split_once('=').filter(|(name, scene)| is_name(name) && !scene.is_empty());
    let (name, scene) = named.ok_or(
        "expected NAME=SCENE, such as left=left.toml; NAME begins with a letter and consists of letters, digits \
            and single _",
    )?;
    Ok((name.to_owned(), PathBuf::from(scene)))
}

/// Width and height, px, from `WxH`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides
        .filter(|sides: &[u32; 2]| sides.iter().all(|side| (1..=LARGEST_SIDE_PX).contains(side)))
        .ok_or_else(|| format!("expected WIDTHxHEIGHT from 1 to {LARGEST_SIDE_PX} px, such as 1600x1400"))
}

/// Address and port, from `ADDR:PORT`.
fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| "expected an IP address and a port, such as 127.0.0.1:8080 or [::1]:8080".to_owned())
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let unnamed = arguments.scene.iter().map(|scene| (String::new(), scene.clone()));
    let fingers: Vec<(String, PathBuf)> = unnamed.chain(arguments.finger.iter().cloned()).collect();
    if let Some((name, _)) =
        fingers.iter().enumerate().find_map(|(i, named)| fingers[..i].iter().find(|(name, _)| *name == named.0))
    {
        return Err(bad_input(format!("--finger {name}: expected each name once")));
    }
    let scene_files = || fingers.iter().map(|(_, scene)| scene);
    let streams = [&arguments.input].into_iter().filter(|_| arguments.image.is_empty());
    require_one_standard_input(scene_files().chain(streams.clone()))?;
    if arguments.record.as_deref().is_some_and(is_standard_stream) {
        return Err(bad_input("--record: expected a file, found -, but standard output receives the lines"));
    }
    let inputs = scene_files().chain(streams).chain(&arguments.image).map(PathBuf::as_path);
    require_separate_files([&arguments.out].into_iter().chain(&arguments.record).map(PathBuf::as_path), inputs)?;
    let listener = arguments.serve.map(serve::bind).transpose()?;
    let scenes: Vec<(&str, Scene)> = fingers
        .iter()
        .map(|(name, path)| {
            let scene = load_scene(path)?;
            hints::of_scene(path, &scene);
            Ok((name.as_str(), scene))
        })
        .collect::<Result<_, Failure>>()?;
    let networks = Networks::read(&finray_fixtures::NETWORKS)?;
    let shown = scenes.iter().map(|(name, scene)| (*name, &scene.finger));
    let server = listener.map(|listener| Server::start(listener, shown)).transpose()?;
    let source = match &arguments.image[..] {
        [] => Source::open(&arguments.input, arguments.format, arguments.size)?,
        images => Source::of_images(images),
    };
    let shows_pixels = source.shows_pixels();
    if arguments.record_images && !shows_pixels {
        return Err(bad_input("--record-images: expected a stream of images, found positions of markers"));
    }
    let mut watched: Vec<(FingerTracker, Option<Observer>)> = scenes
        .iter()
        .map(|(name, scene)| {
            let finger = tracker(arguments, &networks, name, scene)?;
            Ok((finger, shows_pixels.then(|| Observer::new(scene, None)).transpose().map_err(bad_input)?))
        })
        .collect::<Result<_, Failure>>()?;
    for (_, scene) in &scenes {
        source.require_size(scene)?;
    }
    let mut out = open_stream(&arguments.out)?;
    let mut recording = arguments.record.as_deref().map(Recording::create).transpose()?;
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
        let unknown = unknown_finger(&frame.content, &fingers);
        let result = |(finger, observer, scene)| {
            let (finger, observer, scene): (&mut FingerTracker, &mut Option<Observer>, &Scene) =
                (finger, observer, scene);
            let seen = match &unknown {
                None => observed(&frame.content, finger.name(), observer.as_mut()),
                Some(reason) => Err((FrameState::Refused, reason.clone())),
            };
            if let (0, Ok(seen)) = (frame.info.number, &seen) {
                hints::of_other_scene(&arguments.input, seen, scene);
            }
            finger.evaluate(seen)
        };
        let results: Vec<FingerResult> = watched
            .iter_mut()
            .zip(&scenes)
            .map(|((finger, observer), (_, scene))| result((finger, observer, scene)))
            .collect();
        let line = Line::new(&frame.info, &results);
        counts[line.state as usize] += 1;
        dropped += frame.info.dropped;
        let mut text = line.to_json().map_err(not_computed)?;
        if let Some(recording) = &mut recording {
            let forces: Vec<ContactForce> = results.iter().flat_map(contact_forces).collect();
            let image = frame.content.pixels().filter(|_| arguments.record_images);
            recording.add(frame.info.time_s, image, &text, &forces)?;
        }
        newest.give_back(frame);
        text.push('\n');
        if let Err(reason) = out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            streamed(&arguments.out, Err(reason))?;
            break;
        }
        if let Some(server) = &server {
            server.send(text.trim_end());
        }
    }
    recording.map(Recording::finish).transpose()?;
    ended?;
    for (finger, _) in watched.iter().filter(|(finger, _)| finger.missing_rest_frames() > 0) {
        let (missing, name) = (finger.missing_rest_frames(), finger.name());
        let of = if name.is_empty() { String::new() } else { format!(" of finger {name}") };
        print_message(format_args!(
            "warning: the stream ended {missing} frame(s) before all {} rest frames{of} were read: no force was sensed",
            arguments.rest_frames
        ));
    }
    let frames = count(counts.iter().sum(), "frame");
    let drifts = watched.iter().filter_map(|(finger, _)| finger.drift()).map(|drift| drift.rms_mm);
    let drift = drifts.reduce(f64::max).map_or_else(String::new, |drift_mm| format!("; zero drift {drift_mm:.4} mm"));
    Ok(summary(
        format!("{frames}: {}; {dropped} dropped{drift}", states(counts)),
        [&arguments.out].into_iter().chain(&arguments.record),
    ))
}

/// Prepares the evaluation of a finger.
fn tracker(arguments: &Arguments, networks: &Networks, name: &str, scene: &Scene) -> Result<FingerTracker, Failure> {
    let &Arguments { rest_frames, estimator, noise_mm, .. } = arguments;
    let options = SensorOptions { estimator, networks: networks.clone(), noise_mm, mesh_nodes: None };
    Ok(FingerTracker::new(name, scene.clone(), arguments.contacts.of(scene, 0.0, None)?, options, rest_frames)?)
}

/// Reason for refusing a frame of marker positions that has markers of a finger not named on the command line.
fn unknown_finger(content: &Content, fingers: &[(String, PathBuf)]) -> Option<String> {
    let Content::Markers(found) = content else { return None };
    let unknown = found.iter().find(|found| fingers.iter().all(|(name, _)| *name != found.finger))?;
    let names: Vec<&str> = fingers.iter().map(|(name, _)| name.as_str()).filter(|name| !name.is_empty()).collect();
    Some(match &names[..] {
        [] => format!(
            "expected markers that name no finger, or the option --finger {0}=SCENE, found markers of finger {0:?}",
            unknown.finger
        ),
        names => format!("expected a finger of {}, found {:?}", names.join(", "), unknown.finger),
    })
}
