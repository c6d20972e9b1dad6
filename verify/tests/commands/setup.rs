//! From a drawing and an image of the unloaded finger to a scene that senses, and compressed images.

use crate::kit::*;
use finray_fixtures::CAMERA_SCENE;
use finray_model::{NodeId, Scene};
use image::codecs::jpeg::JpegEncoder;

const CAMERA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/camera.toml");

/// An image of the finger under a force at 80 mm, in the direction of -20 degrees.
fn rendered(folder: &Folder, name: &str, force_n: f64, more: &[&str]) -> String {
    let (path, load) = (folder.path(name), format!("80:{force_n},-20"));
    let arguments = ["render", CAMERA, "--load-at", &load, "--grey-noise", "2", "--blur-px", "0.8", "--out", &path];
    finray(&[&arguments[..], more].concat()).done();
    path
}

/// The image as JPEG of low quality.
fn compressed(folder: &Folder, path: &str, name: &str) -> String {
    let (image, out) = (image::open(path).expect("an image").to_rgb8(), folder.path(name));
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, 40).encode_image(&image).expect("encoded");
    std::fs::write(&out, bytes).expect("written");
    out
}

/// The camera's scene without a pose, with another radius and a comment.
fn drawing(folder: &Folder) -> String {
    let keys = |line: &&str| !line.starts_with("rotation_vector_rad") && !line.starts_with("translation_mm");
    let lines: Vec<&str> = CAMERA_SCENE.lines().filter(keys).collect();
    let text = lines.join("\n").replace("radius_mm = 1.5", "radius_mm = 1.4 # drawn");
    folder.put("drawing.toml", &text)
}

/// The scene that `setup` writes senses without an image of the unloaded finger, as the scene with the true pose does, and keeps the drawing's text.
#[test]
fn a_drawing_becomes_a_scene_that_senses_alone() {
    let folder = Folder::new();
    let (rest, press) =
        (rendered(&folder, "rest.png", 0.0, &[]), rendered(&folder, "press.png", 2.0, &["--seed", "5"]));
    let (drawing, mine) = (drawing(&folder), folder.path("mine.toml"));
    let checks = Csv::of(&finray(&["setup", &drawing, "--rest", &rest, "--out", &mine]).done());
    assert!(checks.texts("advice").iter().all(|advice| advice.is_empty()), "{checks:?}");
    let text = folder.read("mine.toml");
    assert!(text.contains("mm; drawn") && text.contains(CAMERA_SCENE.lines().next().expect("a line")), "{text}");
    let images = ["--image", &rest, &press, "--contact-at", "80@-20"];
    for scene in [&mine, CAMERA] {
        let sensed = Csv::of(&finray(&[&["sense", scene][..], &images].concat()).done());
        assert_eq!(sensed.texts("state"), ["none", "contact"], "{scene}");
        let [low_n, high_n] =
            ["low_n", "high_n"].map(|column| sensed.texts(column)[1].parse::<f64>().expect("a number"));
        assert!(low_n < 2.0 && 2.0 < high_n, "{scene}: {low_n} {high_n}");
    }
    let lines = finray(&[&["live", &mine][..], &images].concat()).done();
    assert!(lines.contains("\"none\"") && lines.contains("\"contact\""), "{lines}");
    // Run again on its own result, the command changes nothing but the last digits.
    let again = folder.path("again.toml");
    finray(&["setup", &mine, "--rest", &rest, "--out", &again]).done();
    assert_eq!(folder.read("again.toml").matches("setup:").count(), text.matches("setup:").count());
}

/// A modulus from a data sheet brings assumed thicknesses and the advice to hang a weight, also if its uncertainty is stated. A calibrated modulus and
/// stated thicknesses stay. Stated uncertainties of the modulus once silenced both, and stated thicknesses of 0 were replaced.
#[test]
fn a_guessed_modulus_brings_assumed_thicknesses() {
    let folder = Folder::new();
    let (rest, drawing, mine) = (rendered(&folder, "rest.png", 0.0, &[]), drawing(&folder), folder.path("mine.toml"));
    let drawing = std::fs::read_to_string(drawing).expect("a drawing");
    for (keys, thickness, is_advised) in [
        ("youngs_modulus_sigma = 0.3", Some("thickness_sigma = 0.02 # setup"), true),
        ("youngs_modulus_sigma = 0.3\nthickness_sigma = 0.0", Some("thickness_sigma = 0.0\n"), true),
        ("youngs_modulus_sigma = 0.015", None, false),
    ] {
        let guessed = folder.put("guessed.toml", drawing.replace("[finger]\n", &format!("[finger]\n{keys}\n")));
        let checks = Csv::of(&finray(&["setup", &guessed, "--rest", &rest, "--out", &mine]).done());
        let text = folder.read("mine.toml");
        assert_eq!(text.contains("thickness_sigma"), thickness.is_some(), "{text}");
        assert!(thickness.is_none_or(|line| text.contains(line)), "{text}");
        assert_eq!(checks.texts("advice").iter().any(|advice| advice.contains("weight")), is_advised, "{checks:?}");
    }
}

/// Dots that were placed by hand, up to 0.3 mm beside their nodes: `setup` measures their offsets, and calibration and sensing then need no image of the
/// unloaded finger. Without the offsets, such dots once stopped `calibrate`, because those of clamped nodes seemed to have moved.
#[test]
fn dots_beside_their_nodes_are_measured() {
    let folder = Folder::new();
    let offset = |i: u32| format!("[{:.3}, {:.3}]", 0.2 * (2.1 * f64::from(i)).sin(), 0.2 * (1.3 * f64::from(i)).cos());
    let offsets = format!("[markers]\noffsets_mm = [{}]", (0..25).map(offset).collect::<Vec<_>>().join(", "));
    let truth = folder.put("truth.toml", CAMERA_SCENE.replace("[markers]", &offsets));
    let photograph = |name: &str, load: &str, seed: &str| {
        let path = folder.path(name);
        let disturbed = ["--grey-noise", "2", "--blur-px", "0.8", "--seed", seed];
        finray(&[&["render", &truth, "--load-at", load, "--out", &path][..], &disturbed].concat()).done();
        path
    };
    let (rest, weight) = (photograph("rest.png", "80:0,0", "1"), photograph("weight.png", "100:1,0", "2"));
    let (press, mine) = (photograph("press.png", "80:2,-20", "3"), folder.path("mine.toml"));
    let drawing = drawing(&folder);
    finray(&["setup", &drawing, "--rest", &rest, "--out", &mine]).warned();
    let hung = ["--weight", "1N", "--image", &weight, "--gravity-deg", "0", "--weight-at", "100"];
    let sensed = |scene: &str, more: &[&str]| {
        let asked = ["sense", scene, "--image", &press, "--contact-at", "auto@-20"];
        let row = Csv::of(&finray(&[&asked[..], more].concat()).computed());
        ["force_n", "sigma_n"].map(|column| row.texts(column)[0].parse::<f64>().expect("a number"))
    };
    for more in [&[][..], &["--rest", &rest]] {
        let weighed = folder.path("weighed.toml");
        let calibrated = finray(&[&["calibrate", &mine, "--calibrated", &weighed][..], &hung, more].concat());
        assert_eq!(calibrated.code, Some(0), "{}", calibrated.err);
        for scene in [&mine, &weighed] {
            let [force_n, sigma_n] = sensed(scene, more);
            assert!((force_n - 2.0).abs() < 3.0 * sigma_n && sigma_n < 0.03, "{scene} {more:?}: {force_n} {sigma_n}");
        }
    }
    // With an image of the unloaded finger, the calibration of a scene without offsets uses displacements from that image.
    let text = folder.read("mine.toml");
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("offsets_mm")).collect();
    let bare = folder.put("bare.toml", lines.join("\n"));
    let calibrated = finray(&[&["calibrate", &bare, "--rest", &rest][..], &hung].concat());
    assert_eq!(calibrated.code, Some(0), "{}", calibrated.err);
    // Measured again, the offsets do not add up.
    let again = folder.path("again.toml");
    finray(&["setup", &mine, "--rest", &rest, "--out", &again]).warned();
    let offsets = |name: &str| Scene::from_toml(&folder.read(name)).expect("a scene").marker_offsets;
    let differences =
        offsets("again.toml").into_iter().zip(offsets("mine.toml")).map(|(again, first)| (again - first).norm());
    assert!(differences.fold(0.0, f64::max) < 0.002 && offsets("mine.toml").len() == 25);
    // The offset of a dot that is missing in this image is unknown, so that images that show it do not count it.
    let [covered, partial] = ["covered.png", "partial.toml"].map(|name| folder.path(name));
    finray(&["render", &truth, "--hide", "6", "--grey-noise", "2", "--blur-px", "0.8", "--out", &covered]).done();
    finray(&["setup", &drawing, "--rest", &covered, "--out", &partial]).warned();
    let scene = Scene::from_toml(&folder.read("partial.toml")).expect("a scene");
    assert_eq!(scene.missing_markers, [NodeId(6)]);
    let [force_n, sigma_n] = sensed(&partial, &[]);
    assert!((force_n - 2.0).abs() < 3.0 * sigma_n && sigma_n < 0.03, "{force_n} {sigma_n}");
    let short = folder.put("short.toml", CAMERA_SCENE.replace("[markers]", "[markers]\noffsets_mm = [[0.1, 0.0]]"));
    let expected = ["markers.offsets_mm", "expected 25 pairs", "found 1"];
    assert_says(&finray(&["sense", &short, "--image", &press, "--contact-at", "80@0"]).refused(), &expected);
}

/// A covered dot is named, and the standard deviations are those that `sense` later states.
#[test]
fn a_check_before_work_names_what_to_improve() {
    let folder = Folder::new();
    let (drawing, mine) = (drawing(&folder), folder.path("mine.toml"));
    let rest = rendered(&folder, "rest.png", 0.0, &["--hide", "7"]);
    let (table, warnings) = finray(&["setup", &drawing, "--rest", &rest, "--out", &mine]).warned();
    assert_says(&warnings.join(" "), &["node 7", "missing", "no dot"]);
    let checks = Csv::of(&table);
    assert_says(&checks.texts("advice").join(" "), &["uncover"]);
    let place = checks.texts("check").iter().position(|check| *check == "sigma of 1 N at 77 mm, known contact");
    let expected_n = checks.numbers("value")[place.expect("a place")];
    let press = folder.path("press.png");
    let seen = ["--load-at", "77:1,0", "--grey-noise", "2", "--blur-px", "0.8", "--hide", "7", "--out", &press];
    finray(&[&["render", CAMERA][..], &seen].concat()).done();
    let sensed = Csv::of(&finray(&["sense", &mine, "--image", &press, "--contact-at", "77@0"]).done());
    let sigma_n: f64 = sensed.texts("sigma_n")[0].parse().expect("a number");
    assert!((sigma_n / expected_n - 1.0).abs() < 0.2, "{sigma_n} {expected_n}");
    let bent = rendered(&folder, "bent.png", 3.0, &[]);
    assert_says(&finray(&["setup", &drawing, "--rest", &bent, "--out", &mine]).refused(), &["unloaded"]);
}

/// A noise factor that was calibrated on clean images once refused every compressed image of the same finger.
#[test]
fn compressed_images_are_sensed_with_a_calibration_on_clean_ones() {
    let folder = Folder::new();
    let mut images = Vec::new();
    for force_n in [0.0, 0.5, 1.0, 1.5, 2.0] {
        let path = rendered(&folder, "image.png", force_n, &["--seed", &format!("{}", 7.0 + force_n * 2.0)]);
        images.push(compressed(&folder, &path, &format!("{force_n}.jpg")));
    }
    let images: Vec<&str> = images.iter().map(String::as_str).collect();
    let scene = |keys: &str| folder.put("scene.toml", CAMERA_SCENE.replace("[markers]", &format!("[markers]\n{keys}")));
    let states = |scene: &str| {
        let arguments = [&["sense", scene, "--contact-at", "80@-20", "--image"][..], &images].concat();
        Csv::of(&finray(&arguments).computed())
    };
    let known = "noise_factor = 0.1\nnoise_factor_of_mm = 0.0015";
    let sensed = states(&scene(known));
    assert_eq!(sensed.texts("state"), ["none", "contact", "contact", "contact", "contact"], "{sensed:?}");
    for (row, force_n) in [0.5, 1.0, 1.5, 2.0].iter().enumerate() {
        let [low_n, high_n] =
            ["low_n", "high_n"].map(|column| sensed.texts(column)[row + 1].parse::<f64>().expect("a number"));
        assert!(low_n < *force_n && *force_n < high_n, "{force_n}: {low_n} {high_n}");
    }
    let reduced = states(&scene("noise_factor = 0.1"));
    assert!(reduced.texts("state").contains(&"refused"), "{reduced:?}");
}

/// Changes pixels of a PNG file.
fn painted(folder: &Folder, path: &str, name: &str, change: impl Fn(&mut image::RgbImage)) -> String {
    let (mut image, out) = (image::open(path).expect("an image").to_rgb8(), folder.path(name));
    change(&mut image);
    image.save(&out).expect("written");
    out
}

/// The pixels within 1.2 radii of the dot of a node, in the order of the rows.
fn dot(folder: &Folder, path: &str, node: &str) -> Vec<(u32, u32)> {
    let table = folder.path("dots.csv");
    finray(&["locate", CAMERA, "--image", path, "--out", &table]).done();
    let located = Csv::of(&folder.read("dots.csv"));
    let row = located.texts("node").iter().position(|other| *other == node).expect("a dot");
    let [u, v] = ["u_px", "v_px"].map(|column| located.numbers(column)[row]);
    // The discs of the camera's scene have a radius of 12 px.
    let reach = 15_i64;
    let around = |at: f64| (at.round() as i64 - reach)..=(at.round() as i64 + reach);
    let pixels = around(v).flat_map(|y| around(u).map(move |x| (x, y)));
    let is_inside = |(x, y): &(i64, i64)| (*x as f64 - u).hypot(*y as f64 - v) < 1.2 * 12.0;
    pixels.filter(is_inside).map(|(x, y)| (x as u32, y as u32)).collect()
}

/// A speckled dot is weak, a dot of the other colour is swapped, and saturated pixels are counted; a clean image has none of these.
#[test]
fn weak_swapped_and_clipped_dots_are_named() {
    let folder = Folder::new();
    let (drawing, mine) = (drawing(&folder), folder.path("mine.toml"));
    let rest = rendered(&folder, "rest.png", 0.0, &[]);
    let pixels = dot(&folder, &rest, "6");
    let speckled = painted(&folder, &rest, "speckled.png", |image| {
        for (i, (x, y)) in pixels.iter().enumerate() {
            // Every other pixel is 10 grey levels brighter or darker, in an irregular order.
            let is_brighter = (i * i + i / 3) % 5 < 2;
            for light in &mut image.get_pixel_mut(*x, *y).0 {
                *light = if is_brighter { light.saturating_add(10) } else { light.saturating_sub(10) };
            }
        }
    });
    let (_, warnings) = finray(&["setup", &drawing, "--rest", &speckled, "--out", &mine]).warned();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert_says(&warnings[0], &["node 6", "weak"]);
    // Node 20 is on the front plate, node 6 on the back plate.
    let swapped = painted(&folder, &rest, "swapped.png", |image| {
        pixels.iter().for_each(|(x, y)| image.put_pixel(*x, *y, image::Rgb([226, 186, 46])));
    });
    let (_, warnings) = finray(&["setup", &drawing, "--rest", &swapped, "--out", &mine]).warned();
    assert_says(&warnings.join(" "), &["node 6 is missing", "other plate's colour"]);
    let bright =
        folder.put("bright.toml", CAMERA_SCENE.replace("front_rgb = [226, 186, 46]", "front_rgb = [255, 190, 40]"));
    let clipped = folder.path("clipped.png");
    finray(&["render", &bright, "--grey-noise", "2", "--blur-px", "0.8", "--out", &clipped]).done();
    let checks = Csv::of(&finray(&["setup", &bright, "--rest", &clipped, "--out", &mine]).done());
    let of = |name: &str| checks.texts("check").iter().position(|check| *check == name).expect("a check");
    let [front, back] = ["front", "back"].map(|plate| of(&format!("clipped pixels of the {plate} dots")));
    assert!(checks.numbers("value")[front] > 50.0 && checks.numbers("value")[back] < 2.0, "{checks:?}");
    assert!(checks.texts("advice")[front].contains("exposure") && checks.texts("advice")[back].is_empty());
}

/// With the two colours exchanged, a symmetric finger fits its mirror image, so that only the side of the camera shows the error.
#[test]
fn exchanged_colours_are_named() {
    let folder = Folder::new();
    let exchanged = CAMERA_SCENE
        .replace("front_rgb = [226, 186, 46]", "front_rgb = []")
        .replace("back_rgb = [198, 52, 44]", "back_rgb = [226, 186, 46]")
        .replace("front_rgb = []", "front_rgb = [198, 52, 44]");
    let (exchanged, mine) = (folder.put("exchanged.toml", exchanged), folder.path("mine.toml"));
    let rest = rendered(&folder, "rest.png", 0.0, &[]);
    let (_, warnings) = finray(&["setup", &exchanged, "--rest", &rest, "--out", &mine]).warned();
    assert_says(&warnings.join(" "), &["from below", "front_rgb and back_rgb", "exchanged"]);
}

/// A second run replaces the error that the first run wrote, but not one that a calibration wrote.
#[test]
fn setup_replaces_its_own_model_error() {
    let folder = Folder::new();
    let (mine, again) = (folder.path("mine.toml"), folder.path("again.toml"));
    // The drawing is wider than the finger in the image.
    let wide = folder.put("wide.toml", CAMERA_SCENE.replace("base_width_mm = 58.0", "base_width_mm = 58.2"));
    let rest = rendered(&folder, "rest.png", 0.0, &[]);
    finray(&["setup", &wide, "--rest", &rest, "--out", &mine]).warned();
    let value = |name: &str| {
        let text = folder.read(name);
        let line = text.lines().find(|line| line.starts_with("model_error_mm")).expect("the key").to_owned();
        line.split(['=', '#']).nth(1).expect("a value").trim().parse::<f64>().expect("a number")
    };
    let first = value("mine.toml");
    let text = folder.read("mine.toml");
    let stated = |comment: &str| {
        folder.put(
            "mine.toml",
            text.replace(
                &format!("model_error_mm = {first:?} # setup: "),
                &format!("model_error_mm = 0.5 # {comment}"),
            ),
        )
    };
    stated("setup: ");
    finray(&["setup", &mine, "--rest", &rest, "--out", &again]).warned();
    assert!((value("again.toml") / first - 1.0).abs() < 0.05, "{} {first}", value("again.toml"));
    stated("calibrated: ");
    finray(&["setup", &mine, "--rest", &rest, "--out", &again]).warned();
    assert_eq!(value("again.toml"), 0.5);
}
