//! From images of an uncalibrated finger to its forces: `locate`, `calibrate --located`, `locate` and `sense`. The finger in the images is softer
//! than the scene's, its brackets have other lengths, and its base has another pose in every image.

use crate::kit::*;
use finray_fixtures::BRACKETED_SCENE;
use std::fmt::Write;

/// Modulus of the finger in the images relative to the scene's modulus, and lengths of its brackets (mm).
const MODULUS_FACTOR: f64 = 0.93;
const BRACKETS_MM: [f64; 2] = [3.3, 2.8];
/// For each image: position (mm), force (N) and angle (degrees) of the load; then x (mm), y (mm) and rotation (degrees) of the base.
pub(super) const PRESSES: [([f64; 3], [f64; 3]); 4] = [
    ([60.0, 2.0, 8.0], [0.0, 0.0, 0.0]),
    ([72.0, 4.0, 15.0], [-1.5, 0.8, 0.4]),
    ([90.0, 6.0, 12.0], [-3.0, 0.2, -0.5]),
    ([70.0, 3.0, 10.0], [-2.0, 1.5, 0.7]),
];

/// Unit vectors of the undeformed front plate: inward and towards the tip.
fn front_plate() -> [[f64; 2]; 2] {
    let (width, front, back) = (73.24_f64, 150.16_f64, 167.08_f64);
    let tip_y = (back * back - front * front) / (2.0 * width);
    let along_y = tip_y - 0.5 * width;
    let along = [(front * front - along_y * along_y).sqrt() / front, along_y / front];
    [[along[1], -along[0]], along]
}

/// Converts a force from the finger frame to the frame in which the scene states the camera's pose, in which the base is rotated by `base_deg`.
pub(super) fn force([force_n, angle_deg]: [f64; 2], base_deg: f64) -> [f64; 2] {
    let [inward, along] = front_plate();
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let [x, y] = [0, 1].map(|k| force_n * (cos * inward[k] + sin * along[k]));
    let (sin, cos) = base_deg.to_radians().sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

pub(super) fn scene(folder: &Folder) -> String {
    folder.put("scene.toml", BRACKETED_SCENE)
}

pub(super) fn images(folder: &Folder) -> Vec<String> {
    let modulus = format!("youngs_modulus_mpa = {:?}", 213000.0 * MODULUS_FACTOR);
    let bracket = format!("bracket_mm = {BRACKETS_MM:?}");
    let truth =
        BRACKETED_SCENE.replace("youngs_modulus_mpa = 213000.0", &modulus).replace("bracket_mm = 3.0", &bracket);
    let truth = folder.put("truth.toml", truth);
    let image = |(i, ([s, force_n, angle], [x, y, deg])): (usize, ([f64; 3], [f64; 3]))| {
        let path = folder.path(&format!("press{i}.png"));
        let (load, base) = (format!("{s}:{force_n},{angle}"), format!("{x},{y},{deg}"));
        let arguments =
            ["render", &truth, "--load-at", &load, "--base", &base, "--grey-noise", "2", "--blur-px", "0.8"];
        finray(&[&arguments[..], &["--out", &path]].concat()).done();
        path
    };
    PRESSES.into_iter().enumerate().map(image).collect()
}

#[test]
fn photographs_lead_to_a_finger_and_to_its_forces() {
    let folder = Folder::new();
    let images = images(&folder);
    // In the calibrated scene, the fitted friction coefficient replaces the range of friction.
    let scene = folder.put("scene.toml", format!("{BRACKETED_SCENE}[contact]\nfriction_range = [0.0, 0.6]\n"));
    let located = folder.path("located.csv");
    finray(&["locate", &scene, "--image", &images[0], &images[1], &images[2], "--out", &located]).done();
    let mut forces = "image,fx_n,fy_n\n".to_owned();
    for (i, ([_, force_n, angle], [.., deg])) in PRESSES.iter().enumerate().take(3) {
        let [fx, fy] = force([*force_n, *angle], *deg);
        writeln!(forces, "press{i}.png,{fx},{fy}").expect("memory");
    }
    let forces = folder.put("forces.csv", forces);
    let calibrated = folder.path("calibrated.toml");
    let calibrate = ["calibrate", &scene, "--located", &located, "--forces", &forces, "--calibrated", &calibrated];
    let fit = "modulus,bracket,friction,base-compliance,force-error=0.02";
    let answer = finray(&[&calibrate[..], &["--fit", fit, "--images", &folder.path("images.csv")]].concat());
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    // The measurement error of the references does not include their position errors on the base, so a note states the assumed values.
    assert_says(&answer.err, &["note: base.sigma_mm, base.sigma_deg", "1 mm and 1 degree"]);
    let found = Csv::of(&answer.out);
    let names = [
        "modulus_factor", "front_bracket_mm", "back_bracket_mm", "base_deg_per_n", "friction", "noise_factor",
        "model_error_mm", "force_error_share",
    ];
    assert_eq!(found.texts("parameter"), names);
    let (values, sigmas) = (found.numbers("value"), found.texts("sigma"));
    for (i, truth) in [MODULUS_FACTOR, BRACKETS_MM[0], BRACKETS_MM[1]].into_iter().enumerate() {
        let sigma: f64 = sigmas[i].parse().expect("a number");
        assert!((values[i] - truth).abs() < 4.0 * sigma, "{}: {} +- {sigma}", names[i], values[i]);
    }
    assert!((values[0] / MODULUS_FACTOR - 1.0).abs() < 0.01, "{}", values[0]);
    // `force_error_share` includes the stated 0.02 for differences between objects, which the images do not show.
    assert!((0.02..0.03).contains(&values[7]), "{}", values[7]);
    // The fitted `model_error_mm` is small, because the residual is only the noise of the images.
    assert!(values[6] < 0.02, "{}", values[6]);
    // Slope of the fitted line through rotations of 0, 0.4 and -0.5 degrees at 2, 4 and 6 N.
    assert!((values[3] + 0.125).abs() < 0.01, "{}", values[3]);
    let of_images = Csv::of(&folder.read("images.csv"));
    assert_close(&of_images.numbers("force_n"), &PRESSES.map(|([_, force_n, _], _)| force_n)[..3], 1e-9);
    // The written scene differs from the original scene only in the fitted values.
    let written = folder.read("calibrated.toml");
    assert!(written.contains("# The spring-steel finger as it is built"), "{written}");
    assert!(!written.contains("friction_range"), "{written}");
    assert!(written.contains("[base]\nsigma_mm = 1.0\nsigma_deg = 1.0\n"), "{written}");
    assert!(
        ["friction_sigma", "noise_factor", "model_error_mm", "force_error_share"]
            .iter()
            .all(|key| written.contains(key)),
        "{written}"
    );
    // Fits a clip length per plate. The true finger has no clips, so the result shows the effect of the prior.
    let clipped =
        folder.put("clipped.toml", BRACKETED_SCENE.replace("bracket_mm = 3.0", "bracket_mm = 3.0\nclip_mm = 2.0"));
    let clips = folder.path("clips.toml");
    let fit = ["--forces", &forces, "--calibrated", &clips, "--fit", "modulus,bracket,front-clip,back-clip=0.5"];
    let answer = finray(&[&["calibrate", &clipped, "--located", &located][..], &fit].concat());
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let (found, notes) = (Csv::of(&answer.out), answer.err);
    assert_eq!(found.texts("parameter")[3..5], ["front_clip_mm", "back_clip_mm"]);
    assert_says(&notes, &["note: front_clip_mm: prior of 1 (standard", "note: back_clip_mm: prior of 0.5 (standard"]);
    let written = folder.read("clips.toml");
    let pair = written.split("clip_mm = [").nth(1).and_then(|rest| rest.split(']').next()).expect("a pair");
    let pair: Vec<f64> = pair.split(", ").map(|number| number.parse().expect("a number")).collect();
    assert_close(&pair, &found.numbers("value")[3..5], 1e-12);
    // Without a measured force, the remaining uncertainty of the finger is written to the scene.
    let unforced = ["--fit", "bracket", "--calibrated", &folder.path("unforced.toml")];
    let answer = finray(&[&["calibrate", &scene, "--located", &located][..], &unforced].concat());
    assert_says(&answer.err, &["warning: no force was measured", "--forces"]);
    let unforced = folder.read("unforced.toml");
    assert_says(&unforced, &["errors = [[", "force_error_share = 0.0365"]);
    // Senses the force in an image that was not used in the calibration, with another force and another pose of the base.
    let other = folder.path("other.csv");
    finray(&["locate", &calibrated, "--image", &images[3], "--out", &other]).done();
    let [s, force_n, angle] = PRESSES[3].0;
    for direction in [format!("{angle}"), "friction".to_owned()] {
        let contact = format!("auto@{direction}");
        let sensed =
            Csv::of(&finray(&["sense", &calibrated, "--displacements", &other, "--contact-at", &contact]).computed());
        let [found_s, found_n, sigma] = ["s_mm", "force_n", "sigma_n"].map(|column| sensed.numbers(column)[0]);
        assert!((found_n - force_n).abs() < 3.0 * sigma, "{direction}: {found_n} +- {sigma}");
        assert!(direction == "friction" || (found_n / force_n - 1.0).abs() < 0.02, "{found_n}");
        assert!((found_s - s).abs() < 1.5, "{direction}: {found_s}");
    }
    let anew = folder.path("anew.csv");
    finray(&["locate", &calibrated, "--image", &images[0], &images[1], &images[2], "--out", &anew]).done();
    let mut objects = "image,fx_n,fy_n,object\n".to_owned();
    for (row, object) in folder.read("forces.csv").lines().skip(1).zip(["disc", "disc", "bar"]) {
        writeln!(objects, "{row},{object}").expect("memory");
    }
    let objects = folder.put("objects.csv", objects);
    friction_is_judged(&folder, &scene, &located, &objects);
    compared_in_a_report(&folder, &calibrated, [&located, &anew], &objects, &images);
    // With `--all-images`, every image of a table has a row, even an image that shows no finger.
    let mut rows = folder.read("other.csv");
    let seen = Csv::of(&rows);
    let moved = ["ux_mm", "uy_mm"].map(|column| seen.header.iter().position(|name| name == column).expect("a column"));
    for (i, row) in seen.rows.iter().enumerate() {
        let mut cells = row.clone();
        cells[0] = "nothing.png".to_owned();
        cells[moved[i % 2]] = if i % 3 == 0 { "60" } else { "-60" }.to_owned();
        rows += &(cells.join(",") + "\n");
    }
    let both = folder.put("both.csv", rows);
    let sense = ["sense", &calibrated, "--displacements", &both, "--all-images", "--contact-at", "auto@friction"];
    let sensed = Csv::of(&finray(&sense).computed());
    let columns = "image,contact,s_mm,angle_deg,force_n,sigma_n,low_n,high_n,s_sigma_mm,s_low_mm,s_high_mm,angle_sigma_deg,refused";
    assert_eq!(sensed.header.join(","), columns);
    assert_eq!(sensed.texts("image"), ["press3.png", "nothing.png"]);
    let refused = sensed.texts("refused");
    assert!(refused[0].is_empty() && !refused[1].is_empty(), "{refused:?}");
    assert!(sensed.texts("force_n")[1].is_empty());
    let sense = ["sense", PAPER, "--displacements", "-", "--all-images", "--contact", "19"];
    assert_says(&finray_reading(b"node,ux_mm,uy_mm\n19,1,1\n", &sense).refused(), &["image"]);
}

/// The friction of each object is predicted from the other objects. Forces with a wrong sign in one component are refused.
fn friction_is_judged(folder: &Folder, scene: &str, located: &str, objects: &str) {
    let calibrate = ["calibrate", scene, "--located", located, "--fit", "modulus,bracket,friction=0.05", "--forces"];
    let answer = finray(&[&calibrate[..], &[objects]].concat());
    assert_says(&answer.err, &["from object to object", "object bar, left out: predicted mean lean", "measured"]);
    assert!(!answer.err.contains("warning: friction"), "{}", answer.err);
    assert!(Csv::of(&answer.out).texts("parameter").contains(&"friction_between_objects"));
    let mut mirrored = "image,fx_n,fy_n\n".to_owned();
    for (i, ([_, force_n, angle], [.., deg])) in PRESSES.iter().enumerate().take(3) {
        let [fx, fy] = force([*force_n, -angle], *deg);
        writeln!(mirrored, "press{i}.png,{fx},{fy}").expect("memory");
    }
    let answer = finray(&[&calibrate[..], &[&folder.put("mirrored.csv", mirrored)]].concat());
    assert_says(&answer.refused(), &["mirrored about the plate's normal", "check the sign of fx_n and fy_n"]);
}

/// The report compares the sensed forces of the images with the measured forces.
fn compared_in_a_report(
    folder: &Folder,
    calibrated: &str,
    [elsewhere, located]: [&str; 2],
    forces: &str,
    images: &[String],
) {
    let out = folder.path("report");
    let report = ["report", calibrated, "--quick", "--out", &out, "--measurements", located, "--forces", forces];
    let other = finray(&[&report[..], &["--image", &images[3]]].concat()).refused();
    assert_says(&other, &["\"press3.png\" is not among the located images"]);
    let answer = finray(&[&report[..], &["--image", &images[0], &images[2]]].concat());
    assert!(!answer.err.contains("another scene"), "{}", answer.err);
    let measured = ["3 images with measured forces (friction of the scene)", "All other results are simulated"];
    assert_says(&answer.computed(), &measured);
    let caveat = ["contact force in 3 images (objects disc, bar)", "section on measured images is simulation"];
    assert_says(&folder.read("report/summary.json"), &caveat);
    let page = folder.read("report/measured.html");
    let section =
        page.split("id=\"measured\"").nth(1).expect("the section").split("</section>").next().unwrap_or_default();
    assert_eq!(section.matches("<svg").count(), 4);
    assert_says(section, &["3 images with measured contact force", "friction of the scene", "no brackets"]);
    let rows = Csv::of(&folder.read("report/measured_forces.csv"));
    let errors = |known: &str| -> Vec<[f64; 2]> {
        let of_known = rows
            .texts("known")
            .iter()
            .enumerate()
            .filter(|(_, other)| **other == known)
            .map(|(i, _)| i)
            .collect::<Vec<_>>();
        let number = |i: usize, column: &str| rows.texts(column)[i].parse().unwrap_or(f64::INFINITY);
        of_known.into_iter().map(|i| [number(i, "error"), number(i, "error_over_sigma")]).collect()
    };
    // Coverage and error for all images, and for each object.
    let coverage = Csv::of(&folder.read("report/measured_coverage.csv"));
    assert_eq!(coverage.texts("object")[..3], ["all", "disc", "bar"]);
    assert_eq!(coverage.numbers("images")[..3], [3.0, 2.0, 1.0]);
    let of_objects: Vec<f64> = coverage.numbers("mean_error")[..3].to_vec();
    assert!((of_objects[0] - (2.0 * of_objects[1] + of_objects[2]) / 3.0).abs() < 1e-12, "{of_objects:?}");
    assert_eq!(coverage.numbers("within_95")[0], coverage.numbers("within_95")[1..3].iter().sum::<f64>());
    assert!(folder.read("report/summary.json").contains("\"measured_coverage\": ["));
    assert_says(section, &["By object", "By image"]);
    // The calibrated finger explains the images; without brackets, without friction or without lens distortion, the errors are larger.
    let known = errors("direction measured");
    assert_eq!(known.len(), 3);
    assert!(known.iter().all(|[error, sigmas]| error.abs() < 0.01 && sigmas.abs() < 3.0), "{known:?}");
    // The error of a single image may be small by chance, so mean errors are compared.
    let mean = |all: &[[f64; 2]]| all.iter().map(|[error, _]| error.abs()).sum::<f64>() / all.len() as f64;
    for worse in ["no friction", "direction measured, no brackets", "direction measured, no distortion of the lens"] {
        let all = errors(worse);
        assert!(all.len() == 3 && mean(&all) > (5.0 * mean(&known)).max(0.01), "{worse}: {all:?} for {known:?}");
    }
    // Two of the images are shown with the residuals of their markers. Each marker has two circles, one of which is a halo.
    assert_eq!(section.matches("data:image/jpeg;base64,").count(), 2);
    assert_eq!(section.matches("r=\"4\"/><path d=\"M").count(), 2 * 2 * 8);
    assert!(section.contains("press2.png: residual of each marker, magnified"));
    let residuals = Csv::of(&folder.read("report/measured_residuals.csv"));
    assert_eq!(residuals.rows.len(), 3 * 8);
    assert!(residuals.numbers("residual_x_mm").iter().all(|left| left.abs() < 0.06));
    // A table that was located with the brackets of the scene before calibration. A missing image ends the command before the report is made.
    let report = ["report", calibrated, "--measurements", elsewhere, "--forces", forces, "--image", "nothing.png"];
    assert_says(
        &finray(&report).err,
        &["warning: ", "located with another scene", "positions of markers differ by up to"],
    );
    // With another focal length and a moving base, the pixels of the markers do not suffice to locate them again.
    let camera = folder.read("calibrated.toml").replace("focal_px = [1040.0, 1040.0]", "focal_px = [1050.0, 1050.0]");
    let camera = folder.put("camera.toml", camera);
    let stale = finray(&["report", &camera, "--measurements", located, "--forces", forces]).refused();
    assert_says(&stale, &["located with another lens", "the base moves with reference marks"]);
    // Without measured forces, the command refuses, because it has nothing to compare.
    let alone = finray(&["report", calibrated, "--measurements", located]).refused();
    assert_says(&alone, &["--forces"]);
}

#[test]
fn what_images_cannot_show_is_refused() {
    let folder = Folder::new();
    let scene = scene(&folder);
    // Undeformed positions of hinges with small displacements; the values do not matter for this test.
    let rows = "image,node,x_mm,y_mm,ux_mm,uy_mm,sigma_mm\na,2,47,-20,0.1,0.1,0.01\na,3,76,-9,0.1,0.1,0.01\n";
    let located = folder.put("located.csv", rows);
    let refused = |scene: &str, options: &[&str]| {
        finray(&[&["calibrate", scene, "--located", &located][..], options].concat()).refused()
    };
    assert_says(&refused(&scene, &["--fit", "modulus,size"]), &["--fit", "modulus, front-modulus", "\"size\""]);
    assert_says(&refused(&scene, &["--fit", "ribs=-1"]), &["--fit", "ribs", "more than zero"]);
    assert_says(&refused(&scene, &["--fit", "bracket,bracket"]), &["front_bracket_mm is named twice"]);
    let clips = refused(&scene, &["--fit", "clip,front-clip"]);
    assert_says(&clips, &["expected either clip, or front-clip and back-clip; found both"]);
    assert_says(
        &refused(&scene, &["--fit", "friction,friction-build-up"]),
        &["expected one of friction and friction-build-up"],
    );
    assert_says(&refused(&scene, &["--fit", "modulus"]), &["not identifiable", "--forces"]);
    assert_says(&refused(&scene, &["--fit", "bracket"]), &["friction", "contact"]);
    assert_says(&refused(PAPER, &["--fit", "bracket"]), &["bracket_mm", "finger.ribs"]);
    // Without names, the modulus is sought.
    assert_says(&refused(&scene, &[]), &["not identifiable", "--forces"]);
    let forces = folder.put("forces.csv", "image,fx_n,fy_n\nb,0,-1\n");
    assert_says(&refused(&scene, &["--fit", "modulus", "--forces", &forces]), &["forces.csv", "line 2", "\"b\""]);
    let forces = folder.put("forces.csv", "image,fx_n,fy_n\na,0,-1\n");
    let few = refused(&scene, &["--fit", "modulus,bracket,ribs,friction", "--forces", &forces]);
    assert_says(&few, &["not identifiable"]);
}

/// A base without marks is expected at the pose that the scene's camera implies, up to the stated uncertainty and compliance. A pose of the base that
/// `locate` estimates from the ribs is ignored.
#[test]
fn a_base_without_marks_is_expected_to_give_way() {
    const TURN_DEG_PER_N: f64 = -0.1;
    let folder = Folder::new();
    let [s_mm, force_n, angle_deg] = [72.0, 6.0, 15.0];
    let marked = BRACKETED_SCENE.split("[base]").next().expect("a beginning");
    let camera = &BRACKETED_SCENE[BRACKETED_SCENE.find("[camera]").expect("a camera")..];
    let scene = |name: &str, turn: &str| {
        let friction = "friction = 0.27\nfriction_sigma = 0.1\nnormal = \"undeformed\"\n";
        folder.put(
            name,
            format!("{marked}[base]\nsigma_mm = 0.05\nsigma_deg = 0.05\n{turn}[contact]\n{friction}{camera}"),
        )
    };
    let yields = scene("yields.toml", &format!("turn_deg_per_n = {TURN_DEG_PER_N:?}\n"));
    let stands = scene("stands.toml", "");
    let (image, located) = (folder.path("press.png"), folder.path("located.csv"));
    let (load, base) = (format!("{s_mm}:{force_n},{angle_deg}"), format!("0.03,-0.04,{}", TURN_DEG_PER_N * force_n));
    let of_image = ["--load-at", &load, "--base", &base, "--grey-noise", "2", "--blur-px", "0.8", "--out", &image];
    finray(&[&["render", &yields][..], &of_image].concat()).done();
    assert_eq!(finray(&["locate", &yields, "--image", &image, "--out", &located]).code, Some(0));
    let [with, without] = [&yields, &stands].map(|scene| {
        let sensed = finray(&["sense", scene, "--displacements", &located, "--contact-at", "auto@friction"]).computed();
        let sensed = Csv::of(&sensed);
        ["force_n", "sigma_n"].map(|column| sensed.numbers(column)[0])
    });
    assert!((with[0] - force_n).abs() < 3.0 * with[1] && with[1] < 0.1 * force_n, "{with:?}");
    assert!(without[1] > 1.5 * with[1], "{without:?} where no turn is expected, {with:?} where it is");
}
