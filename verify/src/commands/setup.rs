//! The command `finray setup`.

use super::frames::{Source, observed};
use crate::commands::prelude::*;
use finray_files::{load_scene_and_text, with_comments};
use finray_imaging::locate::{DotColour, ImageWarning, Observer, ObserverError, Survey};
use finray_model::keys::{CAMERA, FINGER, MARKERS};
use finray_model::observation::Observation;
use finray_model::scene::MarkerLook;
use finray_model::sensor::{PreparedScene, RestPositions, expected_sigma};
use finray_studies::statistics::median;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray setup drawing.toml --rest rest.jpg --out mine.toml
  finray setup drawing.toml --rest rest.png --video rest.mp4 --out mine.toml > check.csv
  finray sense mine.toml --video press.mp4 --contact-at auto@friction

Guide: finray guide photographs";

/// Force for which standard deviations are computed, N.
const FORCE_N: f64 = 1.0;
/// Places along the front plate for which standard deviations are computed, as shares of its length.
const PLACES: [f64; 3] = [0.3, 0.5, 0.7];
/// Radius of a dot, px, from which a larger one hardly improves the accuracy; and the least contrast, in grey levels.
const GOOD_RADIUS_PX: f64 = 8.0;
const GOOD_CONTRAST: f64 = 60.0;
/// Largest share of a dot's pixels that may be clipped, and largest blur as a share of the radius.
const CLIPPED: f64 = 0.02;
const BLURRED: f64 = 0.15;
/// Relative standard deviation of the moduli from which they count as guessed: between the 1 to 2 % of a hung weight and the 10 % of a data sheet.
const GUESSED: f64 = 0.05;
/// Relative standard deviation of a printed member's thickness, written if the drawing does not state one. An assumption: 0.04 mm of a plate of 2 mm,
/// which callipers hardly show on soft material. No printed fingers were measured.
const PRINTED_THICKNESS: f64 = 0.02;
/// Dots placed by hand are within this share of their radius from their nodes. If they deviate by more, a length of the drawing is wrong.
const DEVIATES: f64 = 0.25;

/// Write a scene with the camera's pose, dots and errors from images of the unloaded finger; check them.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML) with lens and coloured markers
    scene: PathBuf,
    /// Image of the unloaded finger (PNG, JPEG)
    #[arg(long, value_name = "FILE")]
    rest: PathBuf,
    /// Video of the unloaded finger, with the camera and codec of later videos
    #[arg(long, value_name = "FILE")]
    video: Option<PathBuf>,
    /// The scene file to write, with all other keys and comments of SCENE
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Table of checks; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    check: PathBuf,
}

/// A row of the table of checks. `advice` is empty if nothing needs to be improved.
#[derive(Serialize)]
struct Check {
    check: String,
    value: f64,
    unit: &'static str,
    advice: String,
}

fn check(check: impl Into<String>, value: f64, unit: &'static str, advice: Option<&str>) -> Check {
    Check { check: check.into(), value, unit, advice: advice.unwrap_or_default().to_owned() }
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let Arguments { scene: path, rest, video, out, check: checks_path } = arguments;
    require_one_standard_input([path].into_iter().chain([rest]).chain(video))?;
    let inputs = [path, rest].into_iter().chain(video).map(PathBuf::as_path);
    require_separate_files([out.as_path(), checks_path.as_path()], inputs)?;
    let (scene, text) = load_scene_and_text(path)?;
    camera_of(path, &scene)?;
    if let MarkerLook::Grey { .. } = markers_of(path, &scene)?.look {
        return Err(bad_input(
            "expected markers of two colours (front_rgb, back_rgb): grey markers do not show the camera's pose; find it with `finray lens --plane`",
        ));
    }
    let image = load_image(rest)?.0;
    let survey = Survey::of(&scene, &image).map_err(|error| match error {
        ObserverError::Rest(error) => FileError::content(rest, error).into(),
        error => bad_input(error),
    })?;
    let values = scene_values(&scene, &survey, &text);
    let written = with_comments(&text, &values).map_err(bad_input)?;
    let mine = Scene::from_toml(&written).map_err(not_computed)?;
    let mut observer = Observer::new(&mine, None).map_err(bad_input)?;
    let at_rest = observer.observe(&image).map_err(|error| FileError::content(rest, error))?;
    let mut checks = checks_of_dots(&survey, &at_rest);
    if let Some(video) = video {
        checks.extend(checks_of_video(&mine, &mut observer, video)?);
    }
    checks.extend(expected(mine, &at_rest));
    if let Some(warning) = ImageWarning::of_rest(survey.rest.residual_sd_px) {
        print_message(format_args!("warning: {}: {warning}", rest.display()));
    }
    if survey.rest.camera.pose.eye().z < 0.0 {
        print_message(
            "warning: the camera sees the finger from below (from -z), so that the scene is written mirrored: front_rgb and back_rgb are probably \
             exchanged; the front plate is the one that touches objects",
        );
    }
    for missing in &survey.missing {
        let cause = match missing.is_swapped {
            true => "a dot of the other plate's colour is in its place",
            false => "no dot of its colour is in its place",
        };
        print_message(format_args!("warning: the marker of node {} is missing: {cause}", missing.node));
    }
    for node in &survey.weak {
        print_message(format_args!("warning: the marker of node {node} is weak: covered, dirty or poorly lit"));
    }
    let improve = checks.iter().filter(|check| !check.advice.is_empty()).count();
    write_all_or_nothing(&[(out.clone(), written), (checks_path.clone(), csv_text(checks)?)])?;
    Ok(summary(format!("{} written, {improve} to improve", count(values.len(), "key")), [out, checks_path]))
}

/// The keys of the scene that the image determines, each with its value and a comment on its uncertainty.
/// A `model_error_mm` that an earlier run wrote into the scene's text is replaced.
fn scene_values(scene: &Scene, survey: &Survey, text: &str) -> Vec<(String, String, String)> {
    let rest = &survey.rest;
    let is_own = lines_of(text, MARKERS.model_error_mm.name).any(|line| line.contains("# setup: "));
    let in_words = |sds: &[f64]| sds.iter().map(|sd| format!("{sd:.4}")).collect::<Vec<_>>().join(", ");
    let pose_sds = rest.pose_sds();
    let degrees: Vec<f64> = pose_sds[..3].iter().map(|sd| sd.to_degrees()).collect();
    let mut values = vec![
        (
            CAMERA.rotation_vector_rad.path(),
            format!("{:?}", rest.camera.pose.rotation_vector_rad()),
            format!("setup: +-{} degrees about the camera's axes", in_words(&degrees)),
        ),
        (
            CAMERA.translation_mm.path(),
            format!("{:?}", <[f64; 3]>::from(rest.camera.pose.translation_mm)),
            format!("setup: +-{} mm", in_words(&pose_sds[3..])),
        ),
        (
            CAMERA.pose_errors.path(),
            format!(
                "[{}]",
                rest.pose_errors()
                    .iter()
                    .map(|row| format!("[{}]", row.map(|x| format!("{x:.3e}")).join(", ")))
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
            "setup: one standard deviation each, with the translation in mm".to_owned(),
        ),
        (MARKERS.radius_mm.path(), format!("{:?}", rest.radius_mm), format!("setup: +-{:.4} mm", survey.radius_sd_mm)),
    ];
    for (key, colour) in [MARKERS.front_rgb.path(), MARKERS.back_rgb.path()].into_iter().zip(survey.colours) {
        let Some(DotColour { rgb, sd, .. }) = colour else { continue };
        values.push((key, format!("{rgb:?}"), format!("setup: +-{sd:.0} between the dots")));
    }
    if is_guessed(scene) && lines_of(text, FINGER.thickness_sigma.name).next().is_none() {
        let comment = "setup: assumed of a printed finger; state what callipers show".to_owned();
        values.push((FINGER.thickness_sigma.path(), format!("{PRINTED_THICKNESS:?}"), comment));
    }
    let [deviation_mm, noise_mm] = deviation(survey);
    if is_own || deviation_mm > noise_mm || !scene.marker_offsets.is_empty() {
        let offset = |node: NodeId| {
            let found = rest.located.iter().find(|marker| marker.node == node);
            let [x, y] = found.map_or([0.0; 2], |at| (at.position - scene.finger.marker_position(node)).into());
            format!("[{x:.4}, {y:.4}]")
        };
        let offsets: Vec<String> = (1..=scene.finger.key_node_count()).map(|node| offset(NodeId(node))).collect();
        let comment = format!("setup: +-{noise_mm:.4} mm, centres of the dots from their nodes");
        values.push((MARKERS.offsets_mm.path(), format!("[{}]", offsets.join(", ")), comment));
        let missing: Vec<usize> = survey.missing.iter().map(|missing| missing.node.0).collect();
        if !missing.is_empty() || !scene.missing_markers.is_empty() {
            let comment = "setup: their distances from their nodes are unknown".to_owned();
            values.push((MARKERS.missing_nodes.path(), format!("{missing:?}"), comment));
        }
        // A calibrated scene states its own error.
        if is_own || scene.marker_errors.calibration_error_mm == 0.0 {
            let comment = "setup: noise of the image from which offsets_mm are".to_owned();
            values.push((MARKERS.model_error_mm.path(), format!("{:?}", (1e4 * noise_mm).ceil() / 1e4), comment));
        }
    }
    values
}

/// Whether the moduli come from a data sheet, and not from a measurement of this finger.
fn is_guessed(scene: &Scene) -> bool {
    scene.stiffness_error.modulus >= GUESSED
}

/// Lines of a scene's text that state a key.
fn lines_of<'t>(text: &'t str, key: &'t str) -> impl Iterator<Item = &'t str> {
    text.lines().filter(move |line| line.trim_start().starts_with(key))
}

/// Deviation of the dots from their places on the drawing, and their noise, both as the standard deviation of a coordinate, mm.
fn deviation(survey: &Survey) -> [f64; 2] {
    let rest = &survey.rest;
    let mm_a_px = rest.radius_mm / survey.radius_px;
    let squares: f64 = rest.located.iter().map(|marker| marker.sd_mm.powi(2)).sum();
    [rest.residual_sd_px * mm_a_px, (squares / rest.located.len().max(1) as f64).sqrt()]
}

/// Light, sharpness, size and noise of the dots.
fn checks_of_dots(survey: &Survey, at_rest: &Observation) -> Vec<Check> {
    let when = |bad: bool, advice| Some(advice).filter(|_| bad);
    let rest = &survey.rest;
    let missing = survey.missing.len() as f64;
    let blur = rest.blur_px / survey.radius_px;
    let mut checks = vec![
        check("missing markers", missing, "", when(missing > 0.0, "uncover, repaint or light these dots")),
        check(
            "radius of the dots",
            survey.radius_px,
            "px",
            when(survey.radius_px < GOOD_RADIUS_PX, "larger dots, a closer camera or more pixels"),
        ),
        check("blur", rest.blur_px, "px", when(blur > BLURRED, "focus, or a faster shutter")),
    ];
    for (plate, colour) in ["front", "back"].into_iter().zip(survey.colours) {
        let Some(DotColour { contrast, clipped, .. }) = colour else { continue };
        let dull = when(contrast < GOOD_CONTRAST, "more saturated dots, another background or more light");
        checks.push(check(format!("contrast of the {plate} dots"), contrast, "grey levels", dull));
        let bright = when(clipped > CLIPPED, "shorter exposure or less light");
        checks.push(check(format!("clipped pixels of the {plate} dots"), 100.0 * clipped, "%", bright));
    }
    let [deviation_mm, noise_mm] = deviation(survey);
    let off = when(
        deviation_mm > DEVIATES * rest.radius_mm,
        "compare the lengths of the drawing with the finger, or place the dots on its nodes",
    );
    checks.push(check("noise of a coordinate in the image", at_rest.noise_mm().unwrap_or(noise_mm), "mm", None));
    checks.push(check("deviation of the dots from the drawing", deviation_mm, "mm", off));
    checks
}

/// Noise in the frames of a video of the unloaded finger: as stated in each frame, and as the dots scatter in time.
fn checks_of_video(scene: &Scene, observer: &mut Observer, video: &Path) -> Result<Vec<Check>, Failure> {
    let mut source = Source::open(video, None, None)?;
    source.require_size(scene)?;
    let (mut rest, mut stated_mm, mut lost) = (RestPositions::default(), Vec::new(), 0_usize);
    let mut spare = None;
    while let Some(frame) = source.next(stated_mm.len() + lost, spare.take())? {
        match observed(&frame.content, "", Some(observer)) {
            Ok(seen) => {
                rest.add(scene, &seen).map_err(|error| FileError::content(video, error))?;
                stated_mm.extend(seen.noise_mm());
            }
            Err(_) => lost += 1,
        }
        spare = Some(frame);
    }
    let Some(stated) = median(stated_mm.iter().copied()) else {
        return Err(FileError::content(video, "expected frames of the unloaded finger, found none").into());
    };
    let moved = rest.restlessness(scene, None).map(|_| "hold finger and camera still, and record again");
    let mut checks = vec![
        check("frames", stated_mm.len() as f64, "", None),
        check("frames without finger", lost as f64, "", Some("keep the whole finger in view").filter(|_| lost > 0)),
        check("noise of a coordinate in the video", stated, "mm", None),
    ];
    checks
        .extend(rest.scatter_mm().map(|scatter_mm| check("scatter of a coordinate in time", scatter_mm, "mm", moved)));
    Ok(checks)
}

/// Expected standard deviations of a force of [`FORCE_N`] at a few places.
fn expected(scene: Scene, at_rest: &Observation) -> Vec<Check> {
    let length_mm = scene.finger.plate_length_mm(finray_model::finger::Plate::Front);
    let (stiffness, is_guessed) = (scene.stiffness_error, is_guessed(&scene));
    let mut checks = Vec::new();
    if stiffness.share() > 0.0 {
        let guessed = is_guessed.then_some("measure the modulus: hang a weight (finray calibrate --weight)");
        checks.push(check("uncertainty of moduli and depth", 100.0 * stiffness.share(), "%", guessed));
    }
    let scene = PreparedScene::from(scene);
    for s_mm in PLACES.map(|share| (share * length_mm).round()) {
        let mut add = |question: &str, sigma: Result<f64, String>| {
            let advice = sigma.as_ref().err().cloned().unwrap_or_default();
            let name = format!("sigma of {FORCE_N} N at {s_mm} mm, {question}");
            checks.push(Check { check: name, value: sigma.unwrap_or(f64::NAN), unit: "N", advice });
        };
        match expected_sigma(&scene, at_rest, s_mm, FORCE_N) {
            Ok(of) => {
                add("known contact", of.known_n.map_err(|refusal| refusal.to_string()));
                add("unknown contact", of.unknown_n.map_err(|refusal| refusal.to_string()));
            }
            Err(refusal) => add("known contact", Err(refusal.to_string())),
        }
    }
    checks
}
