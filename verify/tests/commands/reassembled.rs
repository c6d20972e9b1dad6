//! Coverage of intervals on rendered images of fingers that were assembled and mounted again. The scene states how much an unloaded finger may differ
//! from the scene. The tests show the gain from an image at rest, from one measured force, and from several images of unknown forces.
//!
//! Every finger differs from its scene in its joints, a preload, the height of its markers and the references on its base. One object with unknown
//! friction presses each finger through a pad that the scene states. `FINRAY_TEST_CASES=<number>` sets the number of fingers (default 1), and
//! `--nocapture` prints the table.

use crate::kit::*;
use crate::photographs::force;
use crate::rendered::{Press, Rendering, Tally, normal, render, with_marks_off};
use finray_fixtures::BRACKETED_SCENE;
use finray_model::sensing::Pad;
use finray_tests::{Figure, TWO_SIDED_95, case_count, record_figures};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Standard deviations of the joints (mm), the preload (N mm), the height of the markers (mm) and the references on the base (mm and degrees).
const JOINTS_MM: f64 = 0.2;
const PRELOAD_NMM: f64 = 8.0;
const HEIGHT_MM: f64 = 1.5;
const BASE: [f64; 2] = [1.0, 1.0];
const LARGEST_FRICTION: f64 = 0.6;
const PAD: Pad = Pad { length_mm: 6.0, thickness_mm: 2.0 };
/// Parameters that are fitted to images of the new mounting.
const FIT: &str = "preload=8,height=1.5,base,brackets=0.2,ribs=0.2";
/// Smallest number of fingers for which the coverage is checked.
const ENOUGH: usize = 10;

/// Smallest number of fingers for which the figures are recorded.
const RECORDED: usize = 120;

/// Ways of sensing a force, as the table of the guide names them.
const REMEDIES: [&str; 4] = [
    "`[assembly]` alone",
    "and an image at rest (`locate --rest`)",
    "calibrated on the six with one measured force",
    "calibrated on the six without any force",
];
const QUESTIONS: [&str; 2] = ["direction known", "friction unknown"];
/// Command that measures the figures of the guide.
const COMMAND: &str =
    "FINRAY_TEST_CASES=120 cargo test --release -p finray-verify --test commands -- reassembled --nocapture";

/// Force in each image of a finger, N.
fn forces_n(fingers: usize) -> Vec<f64> {
    if fingers < ENOUGH { vec![2.0, 4.5, 8.0] } else { vec![1.5, 2.5, 4.0, 5.5, 7.5, 10.0] }
}

/// The nominal scene with the stated uncertainties of the assembly.
fn stated() -> String {
    let [sigma_mm, sigma_deg] = BASE;
    let base = format!("[base]\nsigma_mm = {sigma_mm:?}\nsigma_deg = {sigma_deg:?}\n");
    let contact = format!("[contact]\nfriction_range = [0.0, {LARGEST_FRICTION}]\nnormal = \"undeformed\"\n");
    let pad = format!("pad_mm = {:?}\npad_length_mm = {:?}\n", PAD.thickness_mm, PAD.length_mm);
    let assembly = format!(
        "[assembly]\njoint_sigma_mm = {JOINTS_MM}\npreload_sigma_nmm = {PRELOAD_NMM:?}\nheight_sigma_mm = {HEIGHT_MM}\n"
    );
    BRACKETED_SCENE.replace("[base]\n", &base).replace("bracket_mm = 3.0", "bracket_mm = 3.0\nclip_mm = 6.0")
        + &contact
        + &pad
        + &assembly
}

/// The true scene of an assembled finger.
fn assembled(chance: &mut ChaCha8Rng) -> String {
    let mut off = |at_mm: [f64; 2]| at_mm.map(|mm| mm + JOINTS_MM * normal(chance));
    let ribs_mm = [[27.0, 45.67], [54.0, 78.69], [81.0, 107.5], [108.0, 132.27]].map(&mut off);
    let brackets_mm = [[3.0; 2]; 4].map(&mut off);
    // Only the height of the finger's markers has an error; the references on the base have their stated height.
    let height_mm = HEIGHT_MM * normal(chance);
    let scene = stated()
        .replace("[[27.0, 45.67], [54.0, 78.69], [81.0, 107.5], [108.0, 132.27]]", &format!("{ribs_mm:?}"))
        .replace("bracket_mm = 3.0", &format!("bracket_mm = {brackets_mm:?}"))
        .replacen("height_mm = 0.0", &format!("height_mm = {height_mm:?}"), 1);
    with_marks_off(scene, BASE, chance)
}

/// Presses and answers for the images of one finger. For each of [`REMEDIES`] and each of [`QUESTIONS`], there is an answer for every image whose
/// force was not measured.
fn answers(finger: usize, forces_n: &[f64]) -> (Vec<Press>, [[Vec<Answer>; 2]; 4]) {
    let chance = &mut ChaCha8Rng::seed_from_u64(4400 + finger as u64);
    let folder = Folder::new();
    let (scene, preload_nmm) = (assembled(chance), PRELOAD_NMM * normal(chance));
    let friction = chance.random_range(0.0..LARGEST_FRICTION);
    let s_mm = chance.random_range(50.0..85.0);
    let mut image = |name: String, force_n: f64, number: usize| {
        let base = [chance.random_range(-4.0..4.0), chance.random_range(-4.0..4.0), chance.random_range(-3.0..3.0_f64)];
        let lean_deg = friction.atan().to_degrees();
        let press = Press { name, s_mm: s_mm + number as f64, force_n, lean_deg, base_deg: base[2] };
        render(&folder, &scene, &press, Rendering { pad: PAD, base, seed: 100 * finger + number, preload_nmm });
        press
    };
    image("rest.png".to_owned(), 0.0, 99);
    let presses: Vec<Press> =
        forces_n.iter().enumerate().map(|(i, force_n)| image(format!("press{i}.png"), *force_n, i)).collect();
    let scene = folder.put("scene.toml", stated());
    let images: Vec<String> = presses.iter().map(|press| folder.path(&press.name)).collect();
    let images: Vec<&str> = images.iter().map(String::as_str).collect();
    let locate = |scene: &str, to: &str, more: &[&str]| {
        let to = folder.path(to);
        let all = [&["locate", scene, "--out", &to, "--image"], &images[..], more].concat();
        assert_eq!(finray(&all).code, Some(0));
        to
    };
    let located = locate(&scene, "located.csv", &[]);
    let rest = locate(&scene, "from_rest.csv", &["--rest", &folder.path("rest.png")]);
    // The force of the middle image is measured.
    let measured = &presses[presses.len() / 2];
    let [fx, fy] = force([measured.force_n, measured.lean_deg], measured.base_deg);
    let forces = folder.put("forces.csv", format!("image,fx_n,fy_n\n{},{fx},{fy}\n", measured.name));
    let fitted = |name: &str, forces: &[&str]| {
        let to = folder.path(name);
        let all = ["calibrate", &scene, "--located", &located, "--fit", FIT, "--calibrated", &to];
        let said = finray(&[&all[..], forces].concat());
        assert_eq!(said.code, Some(0), "{}", said.err);
        let located = locate(&to, &format!("{name}.csv"), &[]);
        (to, located)
    };
    let (one, of_one) = fitted("one.toml", &["--forces", &forces]);
    let (several, of_several) = fitted("several.toml", &[]);
    let measured = measured.name.clone();
    let unmeasured: Vec<Press> = presses.into_iter().filter(|press| press.name != measured).collect();
    let ways = [(&scene, &located), (&scene, &rest), (&one, &of_one), (&several, &of_several)];
    let of_way = |(scene, located): (&String, &String)| {
        [0, 1].map(|question| {
            let sensed = |press: &Press| {
                let found_deg = Csv::of(&std::fs::read_to_string(located).expect("located"));
                let row = found_deg.texts("image").iter().position(|name| *name == press.name).expect("a row");
                let found_deg = found_deg.numbers("base_deg")[row];
                let contact = match question {
                    0 => format!("auto@{}", press.lean_deg + press.base_deg - found_deg),
                    _ => "auto@friction".to_owned(),
                };
                finray(&[
                    "sense", scene, "--displacements", located, "--image-name", &press.name, "--contact-at", &contact,
                ])
            };
            unmeasured.par_iter().map(sensed).collect()
        })
    };
    let all = ways.map(of_way);
    (unmeasured, all)
}

/// The 95 % intervals contain the force for all four ways of sensing: with `[assembly]` alone, with an image at rest, with one measured force, and
/// with images of unknown forces.
#[test]
fn intervals_hold_on_rendered_fingers_that_were_assembled_anew() {
    let fingers = case_count(1, 30);
    let forces_n = forces_n(fingers);
    let all: Vec<_> = (0..fingers).into_par_iter().map(|finger| answers(finger, &forces_n)).collect();
    let mut figures = Vec::new();
    println!("{:20} {:10} {:>8} {:>8} {:>8} {:>8}", "remedy", "known", "refused", "mean", "largest", "within");
    for (i, remedy) in REMEDIES.iter().enumerate() {
        for (k, question) in QUESTIONS.iter().enumerate() {
            let mut tally = Tally::default();
            let mut largest_sigmas = 0.0_f64;
            for (presses, of_finger) in &all {
                tally.within.push([0, 0]);
                for (press, answer) in presses.iter().zip(&of_finger[i][k]) {
                    tally.add(press, answer);
                    if answer.code != Some(0) {
                        println!("{remedy}, {question}, {} N: {}", press.force_n, answer.err.trim());
                    }
                    if answer.code == Some(0) {
                        let found = Csv::of(&answer.out);
                        let [force_n, sigma_n] = ["force_n", "sigma_n"].map(|column| found.numbers(column)[0]);
                        largest_sigmas = largest_sigmas.max(((force_n - press.force_n) / sigma_n).abs());
                    }
                }
            }
            let largest = tally.errors.iter().copied().fold(0.0, f64::max);
            let refused = tally.asked() - tally.errors.len();
            let (mean, within, error) = (tally.mean(), tally.coverage(), tally.standard_error());
            figures.push(Figure {
                row: (*remedy).to_owned(),
                question: (*question).to_owned(),
                cases: tally.asked(),
                refused,
                mean_error: mean,
                largest_error: largest,
                within,
                standard_error: error,
                ..Figure::default()
            });
            println!(
                "{remedy:20} {question:10} {refused:8} {mean:8.4} {largest:8.4} {within:8.3} +- {error:.3}, {largest_sigmas:.1} sigma at most"
            );
            assert!(fingers < ENOUGH || tally.holds(), "{remedy}, {question}: {within} +- {error}");
            assert!(fingers >= ENOUGH || largest_sigmas < 2.0 * TWO_SIDED_95, "{remedy}, {question}: {largest_sigmas}");
            assert!([i, k] != [2, 0] || mean < 0.03, "{remedy}, {question}: {mean}");
        }
    }
    if fingers >= RECORDED {
        record_figures("reassembled", COMMAND, figures);
    }
}
