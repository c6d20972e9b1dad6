//! Measures, on rendered images, how often 95 % intervals contain the true force, and how much each unknown quantity costs. The rendered fingers
//! carry known forces and differ from their scene. As in the README, the scene is calibrated on some images and senses the forces in the others.
//!
//! Every image has its own force, contact position and friction, and shows a finger whose base was mounted anew. A pad between object and plate
//! distributes the force, and friction acts on the pad's surface, at a distance from the plate. Intervals include calibration errors, which all
//! images of a finger share, so coverage is averaged over several fingers, each calibrated separately. `FINRAY_TEST_CASES=<number>` sets the number
//! of sensed images, otherwise 8; `--nocapture` prints the tables.

use crate::kit::*;
use crate::photographs::force;
use finray_fixtures::BRACKETED_SCENE;
use finray_model::Mesh;
use finray_model::sensing::Pad;
use finray_tests::{Figure, TWO_SIDED_95, at_position, case_count, finger_of, record_figures, share_error, under_pad};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::fmt::Write;

/// Number of images per finger for calibration, smallest number of them that must be located, and number of images per finger for sensing in the full
/// study.
const CALIBRATED_ON: usize = 10;
const LEAST_CALIBRATED_ON: usize = 7;
const SENSED: usize = 20;
/// Smallest number of fingers.
const FINGERS: usize = 2;
/// Standard deviations of the differences between built and drawn finger: of the modulus (as a share), the brackets (mm) and the positions of the
/// ribs (mm).
const MODULUS_OFF: f64 = 0.05;
const BRACKETS_OFF_MM: f64 = 0.3;
const RIBS_OFF_MM: f64 = 0.1;
/// Standard deviations of the position (mm) and the rotation (degrees) at which the base is mounted.
const REMOUNTED: [f64; 2] = [0.5, 0.5];
const LARGEST_FRICTION: f64 = 0.5;
/// Number of forces that represent a uniform pressure.
const PARTS: usize = 7;
/// Number of mesh nodes of the rendered finger.
const MESH_NODES: usize = 200;
/// Pads between object and plate. `TOUCHING` represents an object that touches the plate over 2 mm; `PAD` is a soft pad.
const TOUCHING: Pad = Pad { length_mm: 2.0, thickness_mm: 0.0 };
const PAD: Pad = Pad { length_mm: 8.0, thickness_mm: 3.0 };
/// With at least this number of images, a coverage of 75 % is significantly below 95 %. The difference between 75 % and 95 % is five standard errors
/// of independent images; the margin is large because fingers differ.
const ENOUGH: usize = 30;
/// Tolerance of a coverage, in standard errors. With few images, the standard error estimated from the differences between fingers is too small if
/// most intervals contain the force.
const STANDARD_ERRORS: f64 = 3.0;

/// An image and its true load.
pub(super) struct Press {
    pub name: String,
    pub s_mm: f64,
    pub force_n: f64,
    /// Direction of the force, degrees from the undeformed normal; it follows from the friction.
    pub lean_deg: f64,
    /// Rotation of the base in the image, degrees.
    pub base_deg: f64,
}

/// Quantities that are known when a force is sensed.
#[derive(Clone, Copy)]
enum Known {
    PlaceAndDirection,
    Direction,
    DirectionOfExactBase,
    RangeOfFriction,
    NoFriction,
}

impl Known {
    const ALL: [Known; 5] = [
        Known::PlaceAndDirection,
        Known::Direction,
        Known::DirectionOfExactBase,
        Known::RangeOfFriction,
        Known::NoFriction,
    ];

    fn in_words(self) -> &'static str {
        match self {
            Known::PlaceAndDirection => "position and direction",
            Known::Direction => "direction",
            Known::DirectionOfExactBase => "direction, the base taken as exact",
            Known::RangeOfFriction => "friction between 0 and 0.5",
            Known::NoFriction => "nothing, friction taken as none",
        }
    }

    /// The argument for the contact. `found_base_deg` is the measured rotation of the base in the image.
    fn contact(self, press: &Press, found_base_deg: f64) -> String {
        let angle_deg = press.lean_deg + press.base_deg - found_base_deg;
        match self {
            Known::PlaceAndDirection => format!("{}@{angle_deg}", press.s_mm),
            Known::Direction | Known::DirectionOfExactBase => format!("auto@{angle_deg}"),
            Known::RangeOfFriction => "auto@friction".to_owned(),
            Known::NoFriction => "auto@normal".to_owned(),
        }
    }
}

/// Relative errors of the sensed forces, and counts from which the coverage of their intervals follows.
#[derive(Default)]
pub(super) struct Tally {
    pub errors: Vec<f64>,
    /// For each finger: number of intervals that contain the true force, and number of images.
    pub within: Vec<[usize; 2]>,
}

impl Tally {
    pub fn add(&mut self, press: &Press, answer: &Answer) {
        let Some([within, asked]) = self.within.last_mut() else { return };
        *asked += 1;
        if answer.code != Some(0) {
            return;
        }
        let found = Csv::of(&answer.out);
        let [force_n, sigma_n] = ["force_n", "sigma_n"].map(|column| found.numbers(column)[0]);
        self.errors.push((force_n / press.force_n - 1.0).abs());
        *within += usize::from((force_n - press.force_n).abs() <= TWO_SIDED_95 * sigma_n);
    }

    pub fn mean(&self) -> f64 {
        self.errors.iter().sum::<f64>() / self.errors.len() as f64
    }

    pub fn asked(&self) -> usize {
        self.within.iter().map(|[_, asked]| asked).sum()
    }

    pub fn coverage(&self) -> f64 {
        self.within.iter().map(|[within, _]| within).sum::<usize>() as f64 / self.asked() as f64
    }

    /// Standard error of the coverage: the larger of two values, one for independent images and one for independent fingers. All fingers have equal
    /// numbers of images.
    pub fn standard_error(&self) -> f64 {
        let fingers = self.within.len() as f64;
        let off = |[within, asked]: &[usize; 2]| (*within as f64 / *asked as f64 - self.coverage()).powi(2);
        let of_fingers = (self.within.iter().map(off).sum::<f64>() / (fingers * (fingers - 1.0))).sqrt();
        of_fingers.max(share_error(0.95, self.asked()))
    }

    /// Whether the coverage agrees with 95 % up to sampling error.
    pub fn holds(&self) -> bool {
        (self.coverage() - 0.95).abs() <= STANDARD_ERRORS * self.standard_error()
    }

    /// Whether the coverage is significantly below 95 %.
    fn misses(&self) -> bool {
        self.coverage() < 0.95 - STANDARD_ERRORS * self.standard_error()
    }
}

/// The nominal scene, from which every built finger deviates.
fn drawn(pad: Pad) -> String {
    let [sigma_mm, sigma_deg] = REMOUNTED;
    let base = format!("[base]\nsigma_mm = {sigma_mm}\nsigma_deg = {sigma_deg}\n");
    let contact = format!("[contact]\nfriction_range = [0.0, {LARGEST_FRICTION}]\nnormal = \"undeformed\"\n");
    let pad = format!("pad_mm = {:?}\npad_length_mm = {:?}\n", pad.thickness_mm, pad.length_mm);
    BRACKETED_SCENE.replace("[base]\n", &base).replace("bracket_mm = 3.0", "bracket_mm = 3.0\nclip_mm = 6.0")
        + &contact
        + &pad
}

/// True dimensions and modulus of a built finger.
struct Built {
    modulus_mpa: f64,
    brackets_mm: [f64; 2],
    ribs_mm: [[f64; 2]; 4],
}

impl Built {
    fn new(number: usize) -> Built {
        let chance = &mut ChaCha8Rng::seed_from_u64(1900 + number as u64);
        let drawn_mm = [[27.0, 45.67], [54.0, 78.69], [81.0, 107.5], [108.0, 132.27]];
        Built {
            modulus_mpa: 213000.0 * (1.0 + MODULUS_OFF * normal(chance)),
            brackets_mm: [0; 2].map(|_| 3.0 + BRACKETS_OFF_MM * normal(chance)),
            ribs_mm: drawn_mm.map(|at| at.map(|at_mm| at_mm + RIBS_OFF_MM * normal(chance))),
        }
    }
}

/// The true scene of an image; the positions of its base marks contain the error with which the base was mounted for this image.
fn mounted(built: &Built, chance: &mut ChaCha8Rng) -> String {
    let scene = drawn(Pad::default())
        .replace("youngs_modulus_mpa = 213000.0", &format!("youngs_modulus_mpa = {:?}", built.modulus_mpa))
        .replace("bracket_mm = 3.0", &format!("bracket_mm = {:?}", built.brackets_mm))
        .replace("[[27.0, 45.67], [54.0, 78.69], [81.0, 107.5], [108.0, 132.27]]", &format!("{:?}", built.ribs_mm));
    with_marks_off(scene, REMOUNTED, chance)
}

/// Moves and rotates all marks of a scene together by random errors with the given standard deviations (mm and degrees).
pub(super) fn with_marks_off(mut scene: String, [sd_mm, sd_deg]: [f64; 2], chance: &mut ChaCha8Rng) -> String {
    let (x, y, turn) = (sd_mm * normal(chance), sd_mm * normal(chance), (sd_deg * normal(chance)).to_radians());
    let (sin, cos) = turn.sin_cos();
    for at in [[-16.0, 20.0], [-16.0, -10.0]] {
        let moved = [x + cos * at[0] - sin * at[1], y + sin * at[0] + cos * at[1]];
        scene = scene.replace(&format!("at_mm = {at:?}"), &format!("at_mm = {moved:?}"));
    }
    scene
}

pub(super) fn normal(chance: &mut ChaCha8Rng) -> f64 {
    rand_distr::Distribution::sample(&rand_distr::StandardNormal, chance)
}

/// Renders an image of a finger that is pressed at a random position.
fn press(folder: &Folder, built: &Built, number: usize, pad: Pad) -> Press {
    let mut chance = ChaCha8Rng::seed_from_u64(19 + number as u64);
    let scene = mounted(built, &mut chance);
    let (s_mm, force_n) = (chance.random_range(45.0..95.0), chance.random_range(1.0..8.0_f64));
    let lean_deg = chance.random_range(0.0..LARGEST_FRICTION).atan().to_degrees();
    let base = [chance.random_range(-4.0..4.0), chance.random_range(-4.0..4.0), chance.random_range(-3.0..3.0_f64)];
    let press = Press { name: format!("press{number}.png"), s_mm, force_n, lean_deg, base_deg: base[2] };
    render(folder, &scene, &press, Rendering { pad, base, seed: number, preload_nmm: 0.0 });
    press
}

/// How an image is rendered.
pub(super) struct Rendering {
    pub pad: Pad,
    /// Pose of the base in the image: x (mm), y (mm) and rotation (degrees).
    pub base: [f64; 3],
    pub seed: usize,
    /// Preload: moment at the tip, N mm.
    pub preload_nmm: f64,
}

/// Renders a scene's finger under the force of a press; a force of zero renders the finger without contact.
pub(super) fn render(folder: &Folder, scene: &str, press: &Press, rendering: Rendering) {
    let Rendering { pad, base: [x, y, base_deg], seed, preload_nmm } = rendering;
    let &Press { ref name, s_mm, force_n, lean_deg, .. } = press;
    let built = &Mesh::with_nodes(&finger_of(scene), MESH_NODES).expect("as many nodes");
    let scene = folder.put(&format!("built{seed}.toml"), scene);
    let tip = built.finger().tip();
    let mut arguments = vec!["--load".to_owned(), format!("{}:0,0,{preload_nmm}", tip.0)];
    if force_n > 0.0 {
        let forces = under_pad(built, at_position(s_mm, lean_deg), force_n, pad, PARTS).expect("carried");
        for (at, force_n) in forces {
            let at_mm = at.position_mm(built.finger()).expect("on the plate");
            arguments.extend(["--load-at".to_owned(), format!("{at_mm}:{force_n},{}", at.angle_deg)]);
        }
    }
    arguments.extend(["--mesh-nodes".to_owned(), MESH_NODES.to_string()]);
    arguments.extend(["--base".to_owned(), format!("{x},{y},{base_deg}"), "--out".to_owned(), folder.path(name)]);
    arguments.extend(["--seed".to_owned(), seed.to_string()]);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    finray(&[&["render", &scene, "--grey-noise", "2", "--blur-px", "0.8"], &arguments[..]].concat()).done();
}

/// Number of sensed images.
fn images() -> usize {
    case_count(8, 200)
}

/// Images of one finger in a folder: `known` for the calibration of its scene, `unknown` for sensing.
struct Photographed {
    folder: Folder,
    known: Vec<Press>,
    unknown: Vec<Press>,
}

/// Renders the images of all fingers, with a pad between object and plate.
fn photographed(pad: Pad) -> Vec<Photographed> {
    let fingers = (images() / SENSED).max(FINGERS);
    let of_finger = |finger| {
        let (folder, built) = (Folder::new(), Built::new(finger));
        let numbers = (0..CALIBRATED_ON + images() / fingers).into_par_iter();
        let numbers = numbers.map(|i| finger * (CALIBRATED_ON + SENSED) + i);
        let mut known: Vec<Press> = numbers.map(|number| press(&folder, &built, number, pad)).collect();
        let unknown = known.split_off(CALIBRATED_ON);
        Photographed { folder, known, unknown }
    };
    (0..fingers).into_par_iter().map(of_finger).collect()
}

/// Command that measures the results stated in the guide.
const COMMAND: &str =
    "FINRAY_TEST_CASES=200 cargo test --release -p finray-verify --test commands -- rendered --nocapture";
/// Smallest number of images for which the results are recorded.
const RECORDED: usize = 200;

/// Records the results of a study for each case in [`Known::ALL`].
fn record(study: &str, question: &str, tallies: &[Tally; 5]) {
    if tallies[0].asked() < RECORDED {
        return;
    }
    let figure = |(known, tally): (&Known, &Tally)| Figure {
        row: known.in_words().to_owned(),
        question: question.to_owned(),
        cases: tally.asked(),
        refused: tally.asked() - tally.errors.len(),
        mean_error: tally.mean(),
        largest_error: tally.errors.iter().copied().fold(0.0, f64::max),
        within: tally.coverage(),
        standard_error: tally.standard_error(),
        ..Figure::default()
    };
    record_figures(study, COMMAND, Known::ALL.iter().zip(tallies).map(figure).collect());
}

/// Calibrates and senses with a scene that states a pad. Prints a table and returns the results for each of [`Known::ALL`].
fn sensed(fingers: &[Photographed], stated: Pad) -> [Tally; 5] {
    let answers: Vec<Vec<[Answer; 5]>> = fingers.par_iter().map(|finger| sensed_with(finger, stated)).collect();
    let mut tallies: [Tally; 5] = std::array::from_fn(|_| Tally::default());
    for (finger, answers) in fingers.iter().zip(&answers) {
        for (i, tally) in tallies.iter_mut().enumerate() {
            tally.within.push([0, 0]);
            finger.unknown.iter().zip(answers).for_each(|(press, answers)| tally.add(press, &answers[i]));
        }
    }
    println!("{:36} {:>8} {:>8} {:>8} {:>8}", "what is known", "refused", "mean", "largest", "within");
    for (known, tally) in Known::ALL.iter().zip(&tallies) {
        let largest = tally.errors.iter().copied().fold(0.0, f64::max);
        let (refused, mean) = (tally.asked() - tally.errors.len(), tally.mean());
        let (within, error) = (tally.coverage(), tally.standard_error());
        println!("{:36} {refused:8} {mean:8.4} {largest:8.4} {within:8.3} +- {error:.3}", known.in_words());
    }
    tallies
}

/// Calibrates the scene on the known images of a finger, and senses the forces in the unknown images.
fn sensed_with(Photographed { folder, known, unknown }: &Photographed, stated: Pad) -> Vec<[Answer; 5]> {
    let found = Folder::new();
    let calibrated = calibrated([folder, &found], stated, known);
    let exact = found.read("calibrated.toml").replace("sigma_mm = 0.5\nsigma_deg = 0.5\n", "");
    let exact = found.put("exact.toml", exact);
    let answers = unknown.par_iter().map(|press| {
        let located = found.path(&format!("{}.csv", press.name));
        let seen = finray(&["locate", &calibrated, "--image", &folder.path(&press.name), "--out", &located]);
        if seen.code != Some(0) {
            return Known::ALL.map(|_| seen.clone());
        }
        let found_base_deg = Csv::of(&found.read(&format!("{}.csv", press.name))).numbers("base_deg")[0];
        Known::ALL.map(|known| {
            let scene = if matches!(known, Known::DirectionOfExactBase) { &exact } else { &calibrated };
            let contact = known.contact(press, found_base_deg);
            finray(&["sense", scene, "--displacements", &located, "--contact-at", &contact])
        })
    });
    answers.collect()
}

/// Checks that the intervals have 95 % coverage if the scene states all uncertainties. Omitted uncertainties reduce the coverage.
fn assert_intervals_hold([place, direction, exact_base, friction, none]: &[Tally; 5]) {
    for tally in [place, direction, friction] {
        assert!(tally.holds(), "{} within, +- {}", tally.coverage(), tally.standard_error());
    }
    assert!(place.mean() < 0.001 && direction.mean() < 0.003 && friction.mean() < 0.06);
    assert!(place.mean() < direction.mean() && direction.mean() < friction.mean() && friction.mean() < none.mean());
    assert!(exact_base.mean() > 3.0 * direction.mean());
    // With few images, a coverage of 75 % might be chance.
    assert!(exact_base.misses() || exact_base.asked() < ENOUGH, "{}", exact_base.coverage());
    assert!(none.coverage() < 0.5, "{}", none.coverage());
}

#[test]
fn intervals_hold_on_rendered_images() {
    let tallies = sensed(&photographed(TOUCHING), Pad::default());
    record("rendered", "no pad", &tallies);
    assert_intervals_hold(&tallies);
}

/// If the scene lacks the pad, the model does not fit: forces have errors of about a percent, and their intervals are wider.
#[test]
fn intervals_hold_with_a_pad_that_the_scene_has_and_are_wider_without() {
    let fingers = photographed(PAD);
    let tallies = sensed(&fingers, PAD);
    record("rendered, with the pad", "pad", &tallies);
    assert_intervals_hold(&tallies);
    let without = sensed(&fingers, Pad::default());
    record("rendered, without the pad", "pad that the scene lacks", &without);
    let [place, direction, _, _, _] = &without;
    assert!(place.coverage() > 0.75, "{}", place.coverage());
    assert!(place.mean() < 0.03 && direction.mean() < place.mean(), "{} {}", place.mean(), direction.mean());
}

/// Calibrates the scene on images with measured forces, and returns the path of the calibrated scene.
fn calibrated([images, folder]: [&Folder; 2], stated: Pad, presses: &[Press]) -> String {
    let (scene, calibrated) = (folder.put("drawn.toml", drawn(stated)), folder.path("calibrated.toml"));
    // Refused images are omitted, as a user would omit them.
    let seen = presses.par_iter().map(|press| finray(&["locate", &scene, "--image", &images.path(&press.name)]));
    let seen: Vec<(&Press, Answer)> =
        presses.iter().zip(seen.collect::<Vec<_>>()).filter(|(_, it)| it.code == Some(0)).collect();
    assert!(
        seen.len() >= LEAST_CALIBRATED_ON,
        "{} images of {} are refused",
        presses.len() - seen.len(),
        presses.len()
    );
    let rows = |i: usize| seen[i].1.out.lines().skip(usize::from(i > 0)).map(|line| format!("{line}\n"));
    let located = folder.put("located.csv", (0..seen.len()).flat_map(rows).collect::<String>());
    let mut forces = "image,fx_n,fy_n\n".to_owned();
    for (Press { name, force_n, lean_deg, base_deg, .. }, _) in &seen {
        let [fx, fy] = force([*force_n, *lean_deg], *base_deg);
        writeln!(forces, "{name},{fx},{fy}").expect("memory");
    }
    let forces = folder.put("forces.csv", forces);
    let of_images = ["calibrate", &scene, "--located", &located, "--forces", &forces];
    let said = finray(&[&of_images[..], &["--fit", "modulus,bracket,ribs=0.2", "--calibrated", &calibrated]].concat());
    println!("{}", said.out);
    assert_eq!(said.code, Some(0), "{}", said.err);
    calibrated
}
