//! `finray press`: rows that agree with `sense`, and scenes that cannot be pressed.

use crate::kit::*;

const DISC: &str = "[object]\nshape = \"disc\"\nradius_mm = 20\nat_mm = 74\nforce_n = 2\nsteps = 2\n";
/// Tolerance between `press` and `sense`. `press` senses on its own mesh, and `sense` refines its mesh until the force changes by less than 0.2 %.
const MESH_TOLERANCE: f64 = 2e-3;

fn scene(folder: &Folder, object: &str) -> String {
    folder.put("scene.toml", paper_with(&[]) + "\n" + object)
}

/// From the shape that `press` writes, `sense` computes the same forces as `press`.
#[test]
fn its_shape_and_forces_agree_with_sense() {
    let folder = Folder::new();
    let scene = scene(&folder, DISC);
    let (shape, out) = (folder.path("shape.csv"), folder.path("forces.csv"));
    finray(&["press", &scene, "--fineness", "2", "--shape", &shape, "--out", &out]).done();
    let forces = Csv::of(&folder.read("forces.csv"));
    assert_eq!(forces.texts("contact"), ["19", "total", "19", "total"]);
    assert_eq!(forces.texts("step"), ["1", "1", "2", "2"]);
    let true_n: Vec<f64> = forces.numbers("force_n");
    assert!((true_n[3] - 2.0).abs() < 1e-3, "pressed to 2 N: {true_n:?}");
    let contact = format!("19@{}", forces.texts("angle_deg")[2]);
    let sense = ["sense", &scene, "--displacements", &shape, "--contact", &contact, "--estimator", "nonlinear"];
    let other = Csv::of(&finray(&sense).done()).numbers("force_n")[0];
    let own: f64 = forces.texts("sensed_n")[2].parse().expect("a number");
    assert!((own / other - 1.0).abs() < MESH_TOLERANCE, "{own} N, sense has {other} N");
}

/// If the standard deviations of the contacts are stated, `sense` computes the same forces and standard deviations as `press` with friction.
#[test]
fn sense_of_measured_contacts_gives_what_press_gives() {
    /// Standard deviation that `press` uses without noise, mm, and standard deviation of a known direction, degrees.
    const LEAST_MM: &str = "0.01";
    const KNOWN: f64 = 1e-6;
    let folder = Folder::new();
    let scene = scene(&folder, &DISC.replace("at_mm = 74", "at_mm = 74\nfriction = 0.3"));
    let (shape, out) = (folder.path("shape.csv"), folder.path("forces.csv"));
    finray(&["press", &scene, "--fineness", "2", "--noise-mm", "0", "--shape", &shape, "--out", &out]).done();
    let forces = Csv::of(&folder.read("forces.csv"));
    let last = forces.texts("contact").iter().rposition(|contact| *contact != "total").expect("a contact");
    let of_press = ["sensed_n", "sigma_n"].map(|column| forces.texts(column)[last].parse::<f64>().expect("a number"));
    let contact = format!("{}@{}+-{KNOWN}", forces.texts("contact")[last], forces.texts("read_angle_deg")[last]);
    let sense = ["sense", &scene, "--displacements", &shape, "--contact", &contact, "--noise-mm", LEAST_MM];
    let sensed = Csv::of(&finray(&[&sense[..], &["--friction", "0.3"]].concat()).done());
    let of_sense = ["force_n", "sigma_n"].map(|column| sensed.numbers(column)[0]);
    for (press, sense) in of_press.iter().zip(of_sense) {
        assert!((press / sense - 1.0).abs() < 1e-6, "{of_press:?} and {of_sense:?}");
    }
    // Without the friction cone, the direction counts as exact. The residual contradicts this direction, and widens the standard deviation.
    let exact = Csv::of(&finray(&sense).warned().0).numbers("sigma_n")[0];
    assert!(exact > of_sense[1], "{exact} and {of_sense:?}");
    let mixed = [&sense[..], &["--contact", "17"]].concat();
    assert_says(&finray(&mixed).refused(), &["expected standard deviations (+-) for all contacts or for no contact"]);
    // A standard deviation is refused, and not ignored silently, if another quantity of the same contact is unknown.
    for contact in ["auto@-20+-3", "80+-0.5@normal", "80+-0.5@auto"] {
        let sense = ["sense", &scene, "--displacements", &shape, "--contact-at", contact, "--noise-mm", LEAST_MM];
        assert_says(&finray(&sense).refused(), &["expected numbers for its position and its direction"]);
    }
}

#[test]
fn noise_is_that_of_its_seed() {
    let folder = Folder::new();
    let scene = scene(&folder, &DISC.replace("steps = 2", "steps = 1"));
    let run = |seed: &str, noise: &str| {
        finray(&["press", &scene, "--fineness", "1", "--seed", seed, "--noise-mm", noise]).done()
    };
    assert_eq!(run("1", "0.067"), run("1", "0.067"));
    assert_ne!(run("1", "0.067"), run("2", "0.067"));
    assert_eq!(run("1", "0"), run("2", "0"));
}

#[test]
fn scenes_without_an_object_are_refused() {
    let message = finray(&["press", PAPER]).refused();
    assert_says(&message, &[PAPER, "line 1: object is missing: expected a table [object]"]);
}

#[test]
fn the_shape_goes_to_a_file_of_its_own() {
    let folder = Folder::new();
    let (scene, out) = (scene(&folder, DISC), folder.path("out.csv"));
    assert_says(&finray(&["press", &scene, "--shape", "-"]).refused(), &["--shape: expected a file, found -"]);
    assert_says(
        &finray(&["press", &scene, "--shape", &out, "--out", &out]).refused(),
        &["expected different files for --shape and --out"],
    );
}

/// The outline is a file in the folder of the scene.
#[test]
fn outlines_are_read_and_checked() {
    let folder = Folder::new();
    let polygon =
        DISC.replace("\"disc\"\nradius_mm = 20", "\"polygon\"\npoints_csv = \"outline.csv\"").replace("= 2", "= 1");
    let scene = scene(&folder, &polygon);
    let outline = folder.path("outline.csv");
    let press = ["press", &scene, "--fineness", "1"];
    assert_says(&finray(&press).refused(), &[&outline, "cannot be read"]);
    for (text, expected) in [
        ("x_mm,y_mm\n-5,-5\n5,-5\n", "expected three corners or more, found 2"),
        ("x_mm,y_mm\n-5,-5\n5,5\n5,-5\n-5,5\n", "crosses itself or encloses nothing"),
        ("x_mm,y_mm\n-5,-5\n5,five\n5,-5\n", "line 3: y_mm: expected a finite number, found \"five\""),
        ("x_mm,y_mm\n-5,-5\n5,5\n5,-5e7\n", "line 4: corner 3 is not within 10000 mm"),
        ("x,y\n-5,-5\n5,5\n5,-5\n", "line 1: expected a column x_mm"),
    ] {
        folder.put("outline.csv", text);
        assert_says(&finray(&press).refused(), &[&outline, expected]);
    }
    folder.put("outline.csv", "x_mm,y_mm\n-5,-5\n5,-5\n5,5\n-5,5\n");
    let square = finray(&press).done();
    folder.put(
        "scene.toml",
        paper_with(&[])
            + "\n"
            + &DISC.replace("\"disc\"\nradius_mm = 20", "\"box\"\nwidth_mm = 10\nheight_mm = 10").replace("= 2", "= 1"),
    );
    assert_eq!(finray(&press).done(), square, "a square is a box");
}

/// Members of 17 mm once had three segments, like members of 13 mm, and the forces had errors of 5 %. The expected totals come from an independent
/// frame model with contact and a fine mesh.
#[test]
fn the_default_mesh_suits_the_finger() {
    const FRAME: [(f64, f64); 4] = [(3.75, 12.253524), (7.5, 24.280193), (11.25, 34.523518), (15.0, 48.599816)];
    let folder = Folder::new();
    let scene = folder.put(
        "scene.toml",
        "name = \"long members\"\n[finger]\nbase_width_mm = 35\nfront_length_mm = 70\nback_length_mm = 78.26237921249263\ndepth_mm = 35\n\
         [finger.front]\nthickness_mm = 2\nyoungs_modulus_mpa = 18.5\n[finger.back]\nthickness_mm = 4\nyoungs_modulus_mpa = 18.5\n\
         [finger.ribs]\npositions_mm = [[17.5463, 19.3603], [35.0, 39.1312], [52.4537, 58.7303]]\njoints = \"rigid\"\nthickness_mm = 3\n\
         youngs_modulus_mpa = 18.5\n[contact]\nrod_radius_mm = 1\n\
         [object]\nshape = \"disc\"\nradius_mm = 20\nat_mm = 26\ntravel_mm = 15\nsteps = 4\n",
    );
    // Four contacts some millimetres apart are not identifiable, so one step is noted as not sensed.
    let Answer { code, out, err, .. } = finray(&["press", &scene, "--noise-mm", "0"]);
    assert_eq!(code, Some(0), "{err}");
    let forces = Csv::of(&out);
    let totals = forces.texts("contact").into_iter().zip(forces.numbers("force_n")).zip(forces.numbers("travel_mm"));
    let totals: Vec<(f64, f64)> = totals
        .filter(|((contact, _), _)| *contact == "total")
        .map(|((_, force_n), travel_mm)| (travel_mm, force_n))
        .collect();
    for ((travel_mm, force_n), (told_mm, frame_n)) in totals.into_iter().zip(FRAME) {
        assert!(
            (travel_mm - told_mm).abs() < 1e-9 && (force_n / frame_n - 1.0).abs() < 3e-3,
            "{travel_mm} mm, {force_n} N"
        );
    }
}

/// The steps before a failed step are written, and the message states this. Once, these steps were lost.
#[test]
fn steps_before_a_failure_are_written() {
    let folder = Folder::new();
    let scene = scene(&folder, &DISC.replace("force_n = 2\nsteps = 2", "force_n = 80\nsteps = 40"));
    let out = folder.path("out.csv");
    let message = finray(&["press", &scene, "--fineness", "2", "--noise-mm", "0", "--out", &out]).failed();
    assert_says(&message, &["of 40: the finger does not hold the object", "the steps until then", "are written"]);
    let totals: Vec<f64> = Csv::of(&folder.read("out.csv")).numbers("step");
    assert!(totals.len() > 1 && totals[0] == 1.0, "{totals:?}");
}

/// If the first step has no equilibrium, nothing is written, and the message names the step.
#[test]
fn an_object_that_nothing_holds_is_an_error() {
    let folder = Folder::new();
    // The object slides past the tip and never returns.
    let scene = scene(
        &folder,
        "[object]\nshape = \"disc\"\nradius_mm = 5\nat_mm = 153\ndirection_deg = 80\nforce_n = 5\nsteps = 1\n",
    );
    let out = folder.path("out.csv");
    let message = finray(&["press", &scene, "--fineness", "1", "--out", &out]).failed();
    assert_says(&message, &["step 1 of 1: the finger does not hold the object against the force"]);
    let (_, after) = message.split_once("they last touched at ").expect("a force");
    let touched_n: f64 = after.split_whitespace().next().expect("a number").parse().expect("a number");
    assert!(touched_n > 0.0 && touched_n < 5.0, "{message}");
    assert_eq!(folder.names(), ["scene.toml"]);
}
