//! `finray render`, `finray locate` and `finray lens`: from a scene to an image, from there to displacements, and to the force; from images of a
//! grid to the lens.

use crate::kit::*;
use finray_fixtures::CAMERA_SCENE;
use image::{DynamicImage, ImageFormat, RgbImage};
use std::io::Cursor;

/// The paper's finger, its markers and the camera that sees them.
const CAMERA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/camera.toml");
/// Largest error of a coordinate, mm, as asked of rendered images with grey noise 2 and a blur of 0.8 px.
const LARGEST_MM: f64 = 0.015;

/// An image of the paper's finger under a force, with the shape that `solve` gives it.
fn image_of(folder: &Folder, name: &str, load_at: &str, options: &[&str]) -> (String, Csv) {
    let shape = Csv::of(&finray(&["solve", CAMERA, "--load-at", load_at]).done());
    let path = folder.path(name);
    let disturbed = ["--grey-noise", "2", "--blur-px", "0.8"];
    finray(&[&["render", CAMERA, "--load-at", load_at, "--out", &path], &disturbed[..], options].concat()).done();
    (path, shape)
}

/// Checks every located node of an image against the shape.
fn assert_located(located: &Csv, image: &str, shape: &Csv) {
    let (nodes, all) = (located.texts("node"), shape.texts("node"));
    for (i, node) in nodes.iter().enumerate().filter(|(i, _)| located.texts("image")[*i] == image) {
        let of = all.iter().position(|other| other == node).expect("a key node");
        for column in ["ux_mm", "uy_mm"] {
            let error = located.numbers(column)[i] - shape.numbers(column)[of];
            assert!(error.abs() < LARGEST_MM, "{image} node {node} {column}: {error}");
        }
    }
}

#[test]
fn an_image_leads_back_to_the_force() {
    let folder = Folder::new();
    let (image, shape) = image_of(&folder, "image.png", "80:2,-20", &["--hide", "7", "18"]);
    let nodes = folder.path("nodes.csv");
    finray(&["locate", CAMERA, "--image", &image, "--out", &nodes]).done();
    let located = Csv::of(&folder.read("nodes.csv"));
    assert_eq!(located.header.join(","), "image,node,u_px,v_px,x_mm,y_mm,ux_mm,uy_mm,sigma_mm");
    assert_eq!(located.rows.len(), 23);
    assert!(!located.texts("node").contains(&"7") && !located.texts("node").contains(&"18"));
    assert_located(&located, "image.png", &shape);
    for estimator in ["nonlinear", "least-squares", "ridge"] {
        // The mesh of the image, so that it is the noise alone that is tested.
        let mesh: &[&str] = if estimator == "nonlinear" { &["--mesh-nodes", "25"] } else { &[] };
        let arguments =
            ["sense", CAMERA, "--displacements", &nodes, "--contact-at", "80@-20", "--estimator", estimator];
        let sensed = Csv::of(&finray(&[&arguments, mesh].concat()).computed());
        let (force, sigma) = (sensed.numbers("force_n")[0], sensed.numbers("sigma_n")[0]);
        assert!((force - 2.0).abs() < 4.0 * sigma, "{estimator}: {force} +- {sigma}");
        // 0.067 mm would leave 1.2 % at the worst node; a camera leaves a tenth.
        assert!(estimator != "nonlinear" || (force - 2.0).abs() < 0.0024, "{force}");
    }
}

#[test]
fn a_stream_is_sensed_image_by_image() {
    let folder = Folder::new();
    let images =
        ["1", "1.2", "3.5"].map(|force| image_of(&folder, &format!("{force}.png"), &format!("60:{force}"), &[]));
    let (rest, _) = image_of(&folder, "rest.png", "60:0", &[]);
    let paths: Vec<&str> = images.iter().map(|(path, _)| path.as_str()).collect();
    let nodes = folder.path("nodes.csv");
    finray(&[&["locate", CAMERA, "--rest", &rest, "--out", &nodes, "--image"], &paths[..]].concat()).done();
    let located = Csv::of(&folder.read("nodes.csv"));
    assert_eq!(located.rows.len(), 3 * 25);
    for (path, shape) in &images {
        let name = path.rsplit(['/', '\\']).next().expect("a name");
        assert_located(&located, name, shape);
    }
    let sense = ["sense", CAMERA, "--displacements", &nodes, "--contact-at", "60", "--mesh-nodes", "25"];
    assert_says(&finray(&sense).refused(), &["--image-name", "1.png, 1.2.png, 3.5.png"]);
    assert_says(&finray(&[&sense[..], &["--image-name", "2.png"]].concat()).refused(), &["--image-name", "1.png"]);
    let sensed = Csv::of(&finray(&[&sense[..], &["--image-name", "3.5.png"]].concat()).computed());
    assert!((sensed.numbers("force_n")[0] - 3.5).abs() < 0.01, "{sensed:?}");
}

/// The pose need not be in the scene where an image of the unloaded finger is at hand.
#[test]
fn the_pose_may_come_from_an_image_at_rest() {
    let folder = Folder::new();
    let (image, shape) = image_of(&folder, "image.png", "100:3", &[]);
    let (rest, _) = image_of(&folder, "rest.png", "60:0", &["--seed", "5"]);
    let (before, after) = CAMERA_SCENE.split_once("rotation_vector_rad").expect("a pose");
    let without = format!("{before}{}", &after[after.find("\n\n").expect("the next table")..]);
    let scene = folder.put("scene.toml", &without);
    let located = Csv::of(&finray(&["locate", &scene, "--image", &image, "--rest", &rest]).done());
    assert_located(&located, "image.png", &shape);
    let message = finray(&["locate", &scene, "--image", &image]).refused();
    assert_says(&message, &["rotation_vector_rad", "[camera]"]);
    // A bent finger is no finger at rest.
    let message = finray(&["locate", &scene, "--image", &image, "--rest", &image]).refused();
    assert_says(&message, &["unloaded"]);
    // A little of a load may be markers that are off their nodes.
    let (bent, _) = image_of(&folder, "bent.png", "80:0.05", &[]);
    let (_, warnings) = finray(&["locate", &scene, "--image", &image, "--rest", &bent]).warned();
    assert_says(&warnings.join(" "), &["bent.png", "px rms from those of the scene's unloaded finger"]);
}

#[test]
fn the_same_seed_gives_the_same_image() {
    let folder = Folder::new();
    let render = |name: &str, seed: &str| {
        let path = folder.path(name);
        let arguments = ["render", CAMERA, "--grey-noise", "3", "--clutter", "9", "--light-falloff", "0.2"];
        finray(&[&arguments[..], &["--seed", seed, "--out", &path]].concat()).done();
        std::fs::read(path).expect("the image")
    };
    let first = render("1.png", "1");
    assert!(first == render("2.png", "1") && first != render("3.png", "2"));
    assert_eq!(&first[..8], b"\x89PNG\r\n\x1a\n");
}

/// A shape from a file is the shape of the same load.
#[test]
fn shapes_are_rendered_from_files() {
    let folder = Folder::new();
    let (of_load, _) = image_of(&folder, "load.png", "90:2,10", &[]);
    let shape = folder.path("shape.csv");
    finray(&["solve", CAMERA, "--load-at", "90:2,10", "--out", &shape]).done();
    let of_shape = folder.path("shape.png");
    let arguments = ["render", CAMERA, "--shape", &shape, "--grey-noise", "2", "--blur-px", "0.8", "--out", &of_shape];
    finray(&arguments).done();
    assert!(std::fs::read(of_load).expect("an image") == std::fs::read(of_shape).expect("an image"));
    let text = folder.read("shape.csv");
    let short = folder.put("short.csv", text.rsplit_once("\n25,").expect("node 25").0);
    assert_says(&finray(&["render", CAMERA, "--shape", &short]).refused(), &["node 25 is missing"]);
    assert!(
        finray(&["render", CAMERA, "--shape", &shape, "--load", "19:0,-1"]).refused().contains("cannot be used with")
    );
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), format).expect("an image in memory");
    bytes
}

#[test]
fn bad_images_are_refused_and_nothing_is_written() {
    let folder = Folder::new();
    let (image, _) = image_of(&folder, "image.png", "80:2", &[]);
    let good = std::fs::read(&image).expect("the image");
    let black = DynamicImage::ImageRgb8(RgbImage::new(1600, 1400));
    let small = DynamicImage::ImageRgb8(RgbImage::new(16, 14));
    let everything: Vec<String> = (1..=25).map(|node| node.to_string()).collect();
    let everything: Vec<&str> = everything.iter().map(String::as_str).collect();
    let (hidden, _) = image_of(&folder, "hidden.png", "80:2", &[&["--hide"], &everything[..]].concat());
    // A header that promises 60 000 x 60 000 pixels.
    let mut huge = good.clone();
    huge[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
    for (name, bytes, expected) in [
        ("empty.png", Vec::new(), "expected an image, PNG or JPEG"),
        ("text.png", b"node,ux_mm\n".to_vec(), "expected an image, PNG or JPEG"),
        ("short.png", good[..good.len() / 2].to_vec(), "expected a whole image"),
        ("head.png", good[..40].to_vec(), "expected a whole image"),
        ("huge.png", huge, "expected a whole image"),
        ("small.png", encoded(&small, ImageFormat::Png), "expected an image of 1600 x 1400 px"),
        ("black.jpg", encoded(&black, ImageFormat::Jpeg), "found 0 of 23 markers"),
        ("hidden.png", std::fs::read(&hidden).expect("the image"), "found 0 of 23 markers"),
    ] {
        let path = folder.put(name, bytes);
        let out = folder.put("out.csv", "as before");
        for role in ["--image", "--rest"] {
            let other = if role == "--image" { vec![] } else { vec!["--image", &image] };
            let arguments = [&["locate", CAMERA, role, &path, "--out", &out], &other[..]].concat();
            let message = finray(&arguments).refused();
            if role == "--image" {
                assert_says(&message, &[name, expected]);
            }
            assert_says(&message, &[name]);
            assert_eq!(folder.read("out.csv"), "as before");
        }
    }
    assert_says(&finray(&["locate", CAMERA, "--image", "nowhere.png"]).refused(), &["nowhere.png", "cannot be read"]);
    assert_says(&finray(&["locate", PAPER, "--image", &image]).refused(), &["[camera]"]);
    assert_says(&finray(&["render", PAPER]).refused(), &["[camera]"]);
    assert_says(&finray(&["render", CAMERA, "--hide", "26"]).refused(), &["--hide", "1 to 25"]);
}

/// Files in other formats of colour show the same finger.
#[test]
fn other_kinds_of_image_files_are_read() {
    let folder = Folder::new();
    let (image, shape) = image_of(&folder, "image.png", "80:2", &[]);
    let decoded = image::open(&image).expect("the image");
    for (name, bytes) in [
        ("16.png", encoded(&DynamicImage::ImageRgb16(decoded.to_rgb16()), ImageFormat::Png)),
        ("alpha.png", encoded(&DynamicImage::ImageRgba8(decoded.to_rgba8()), ImageFormat::Png)),
    ] {
        let path = folder.put(name, bytes);
        let located = Csv::of(&finray(&["locate", CAMERA, "--image", &path]).done());
        assert_eq!(located.rows.len(), 25, "{name}");
        assert_located(&located, name, &shape);
    }
    // Without colour the markers cannot be told from the rest.
    let grey = folder.put("grey.png", encoded(&DynamicImage::ImageLuma8(decoded.to_luma8()), ImageFormat::Png));
    assert_says(&finray(&["locate", CAMERA, "--image", &grey]).refused(), &["found 0 of 23 markers"]);
}

/// Damaged image files end with a message, whatever is in them.
#[test]
fn damaged_images_do_no_harm() {
    use rand::{RngExt, SeedableRng};
    let folder = Folder::new();
    let (image, _) = image_of(&folder, "image.png", "80:2", &[]);
    let decoded = image::open(&image).expect("the image");
    let files = [std::fs::read(&image).expect("the image"), encoded(&decoded, ImageFormat::Jpeg)];
    let mut chance = rand_chacha::ChaCha8Rng::seed_from_u64(18);
    for number in 0..40 {
        let mut bytes = files[number % 2].clone();
        for _ in 0..chance.random_range(1..20) {
            // Half of the damage is in the header, where lengths and kinds stand.
            let end = if chance.random_bool(0.5) { 700 } else { bytes.len() };
            let at = chance.random_range(0..end.min(bytes.len()));
            bytes[at] = chance.random();
        }
        let path = folder.put("damaged", &bytes);
        let answer = finray(&["locate", CAMERA, "--image", &path]);
        if answer.code != Some(0) {
            answer.refused();
        }
    }
}

#[test]
fn cameras_and_markers_of_a_scene_are_checked() {
    let refused = |from: &str, to: &str| {
        assert!(CAMERA_SCENE.contains(from), "the scene has no {from}");
        crate::kit::scene::refused(&CAMERA_SCENE.replace(from, to))
    };
    for (from, to, expected) in [
        ("size_px = [1600, 1400]", "size_px = [1600]", "camera.size_px: expected a list of 2 numbers"),
        ("size_px = [1600, 1400]", "size_px = [1600.5, 1400]", "camera.size_px: expected whole numbers"),
        ("size_px = [1600, 1400]", "size_px = [0, 1400]", "camera.size_px: expected width and height"),
        ("focal_px = [1360.0, 1360.0]\n", "", "camera.focal_px is missing"),
        ("[1360.0, 1360.0]", "[1360.0, nan]", "camera.focal_px"),
        ("[1360.0, 1360.0]", "[-1360.0, 1360.0]", "camera.focal_px: expected two focal lengths above 0"),
        ("distortion = [0.0,", "distortion = [-2.0,", "camera.distortion: expected coefficients that do not fold"),
        ("distortion = [0.0,", "distortion = [\"a\",", "camera.distortion: expected a list of 5 numbers"),
        ("translation_mm = [-75.0, 0.0, 170.0]\n", "", "camera.translation_mm is missing"),
        ("[-75.0, 0.0, 170.0]", "[-75.0, 0.0, 1e9]", "camera.translation_mm: expected a translation of at most"),
        ("radius_mm = 1.5", "radius_mm = 0", "markers.radius_mm: expected a length in mm, above 0"),
        ("height_mm = 0.0\n", "", "markers.height_mm is missing"),
        ("[226, 186, 46]", "[226, 186]", "markers.front_rgb: expected a list of 3 numbers"),
        ("[226, 186, 46]", "[226, 186, 256]", "markers.front_rgb: expected whole numbers from 0 to 255"),
        ("back_rgb", "back_rbg", "unknown key `markers.back_rbg`; the nearest known key is `back_rgb`"),
    ] {
        assert_says(&refused(from, to), &[expected, "line "]);
    }
    // What can be written but not seen.
    let folder = Folder::new();
    let (image, _) = image_of(&folder, "image.png", "80:2", &[]);
    for (from, to, expected) in [
        ("[-75.0, 0.0, 170.0]", "[-75.0, 0.0, -170.0]", "behind the camera"),
        ("[-75.0, 0.0, 170.0]", "[300.0, 0.0, 170.0]", "outside the image"),
        ("radius_mm = 1.5", "radius_mm = 0.1", "radius of 0.8 px"),
        ("[226, 186, 46]", "[200, 200, 200]", "markers.front_rgb: expected a colour that is not a shade of grey"),
    ] {
        let scene = folder.put("scene.toml", CAMERA_SCENE.replace(from, to));
        assert_says(&finray(&["locate", &scene, "--image", &image]).refused(), &[expected]);
    }
}

/// An image of a grid of 10 mm before the camera of the scene, without its distortion, slanted by an angle (rad).
fn grid(folder: &Folder, name: &str, slant: f64) -> String {
    use finray_imaging::render::{Disturbances, GridPlate, render_grid};
    use finray_model::camera::{Camera, Pose};
    let lens = finray_model::Scene::from_toml(CAMERA_SCENE).expect("the fixture").camera.expect("a camera").lens;
    let pose = Pose::new([std::f64::consts::PI, 0.0, slant], [5.0, -3.0, 200.0]);
    let plate = GridPlate { pitch_mm: 10.0, radius_mm: 2.5, counts: [17, 15], greys: [210, 50] };
    let disturbances = Disturbances { blur_px: 0.8, grey_noise: 2.0, ..Disturbances::default() };
    let image = render_grid(&Camera { lens, pose }, &plate, |_| false, disturbances);
    folder.put(name, encoded(&DynamicImage::ImageRgb8(image), ImageFormat::Png))
}

/// What `lens` writes is a scene's camera table.
#[test]
fn a_lens_from_grids_serves_a_scene() {
    let folder = Folder::new();
    let images = [("1.png", 0.6), ("2.png", -0.5), ("3.png", 0.3)].map(|(name, slant)| grid(&folder, name, slant));
    let paths: Vec<&str> = images.iter().map(String::as_str).collect();
    let lens = finray(&[&["lens", "--grid-mm", "10", "--image"], &paths[..]].concat());
    assert_eq!(lens.code, Some(0), "{}", lens.err);
    let (before, after) = CAMERA_SCENE.split_once("[camera]").expect("a camera");
    let (_, after) = after.split_once("rotation_vector_rad").expect("a pose");
    let scene = folder.put("scene.toml", format!("{before}{}rotation_vector_rad{after}", lens.out));
    let (image, shape) = image_of(&folder, "image.png", "80:2", &[]);
    let (rest, _) = image_of(&folder, "rest.png", "60:0", &[]);
    let located = Csv::of(&finray(&["locate", &scene, "--image", &image, "--rest", &rest]).done());
    assert_eq!(located.rows.len(), 25);
    assert_located(&located, "image.png", &shape);
}

#[test]
fn images_without_a_grid_give_no_lens() {
    let folder = Folder::new();
    let (finger, _) = image_of(&folder, "finger.png", "80:2", &[]);
    let good = grid(&folder, "grid.png", 0.4);
    let black = folder.put("black.png", encoded(&DynamicImage::ImageRgb8(RgbImage::new(160, 140)), ImageFormat::Png));
    let out = folder.put("out.toml", "as before");
    for (images, expected) in [
        (vec![&black], "expected a plane grid"),
        (vec![&finger], "expected a plane grid"),
        (vec![&good, &black], "expected"),
    ] {
        let images: Vec<&str> = images.into_iter().map(String::as_str).collect();
        let message = finray(&[&["lens", "--grid-mm", "10", "--out", &out, "--image"], &images[..]].concat()).refused();
        assert_says(&message, &[expected]);
        assert_eq!(folder.read("out.toml"), "as before");
    }
    for pitch in ["0", "-1", "nan", "ten"] {
        assert_says(&finray(&["lens", "--grid-mm", pitch, "--image", &good]).refused(), &["--grid-mm"]);
    }
    // One image without slant does not show the focal length.
    let answer = finray(&["lens", "--grid-mm", "10", "--image", &grid(&folder, "flat.png", 0.0)]);
    assert!(answer.code == Some(0) && answer.err.starts_with("note: ") && answer.err.contains("fx"), "{}", answer.err);
}

/// `lens --plane` gives the pose of the grid's plane: origin in the middle of the image, z towards the camera. It takes images of one place alone.
#[test]
fn the_plane_of_a_grid_is_written() {
    use finray_model::camera::Pose;
    use nalgebra::Vector3;
    let folder = Folder::new();
    let images = [("1.png", 0.3), ("2.png", 0.3), ("3.png", -0.3)].map(|(name, slant)| grid(&folder, name, slant));
    let lens = |images: &[&str]| finray(&[&["lens", "--grid-mm", "10", "--plane", "--image"], images].concat());
    let written = lens(&[&images[0], &images[1]]);
    assert_eq!(written.code, Some(0), "{}", written.err);
    let (before, _) = CAMERA_SCENE.split_once("[camera]").expect("a camera");
    let scene = finray_model::Scene::from_toml(&format!("{before}{}", written.out)).expect("a scene");
    let found = scene.camera.expect("a camera").pose.expect("a pose");
    let truth = Pose::new([std::f64::consts::PI, 0.0, 0.3], [5.0, -3.0, 200.0]);
    let [z, true_z] = [found, truth].map(|pose| pose.rotation * Vector3::z());
    // Two images in one place leave the focal length at its usual value, and with it slant and distance.
    assert!(z.dot(&true_z).abs() > 0.03_f64.cos() && z.z < 0.0, "{z} {true_z}");
    let along = true_z.dot(&truth.translation_mm) / true_z.dot(&found.translation_mm);
    let focal = scene.camera.expect("a camera").lens.focal_px()[0] / 1360.0;
    assert!((along * focal - 1.0).abs() < 0.005, "{along} {focal}");
    assert_says(
        &lens(&[&images[0], &images[2]]).refused(),
        &["--plane: expected images of a grid in one place", "image"],
    );
}

/// A finger with grey markers whose base is anywhere: from an image to displacements and the force.
#[test]
fn grey_markers_lead_back_to_the_force() {
    const BRACKETED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/bracketed.toml");
    let folder = Folder::new();
    let image = folder.path("image.png");
    let render =
        ["render", BRACKETED, "--base", "40,-70,95", "--load-at", "75:3,10", "--blur-px", "0.8", "--grey-noise", "2"];
    finray(&[&render[..], &["--clutter", "20", "--out", &image]].concat()).done();
    let nodes = folder.path("nodes.csv");
    finray(&["locate", BRACKETED, "--image", &image, "--out", &nodes]).done();
    let located = Csv::of(&folder.read("nodes.csv"));
    let base = "base_x_mm,base_y_mm,base_deg,base_sigma_mm,base_sigma_deg,marker_sigma_mm";
    assert_eq!(located.header.join(","), format!("image,node,u_px,v_px,x_mm,y_mm,ux_mm,uy_mm,sigma_mm,{base}"));
    assert_eq!(located.texts("node"), ["2", "3", "4", "5", "7", "8", "9", "10"]);
    for (column, truth, tolerance) in [("base_x_mm", 40.0, 0.03), ("base_y_mm", -70.0, 0.03), ("base_deg", 95.0, 0.1)] {
        assert_close(&[located.numbers(column)[0]], &[truth], tolerance / truth.abs());
    }
    let shape = Csv::of(&finray(&["solve", BRACKETED, "--load-at", "75:3,10"]).done());
    for (i, node) in located.texts("node").iter().enumerate() {
        let of = shape.texts("node").iter().position(|other| other == node).expect("a key node");
        for (found, truth) in [("ux_mm", "hinge_ux_mm"), ("uy_mm", "hinge_uy_mm")] {
            let (error, sigma) = (located.numbers(found)[i] - shape.numbers(truth)[of], located.numbers("sigma_mm")[i]);
            assert!(error.abs() < 5.0 * sigma && sigma < 0.1, "node {node} {found}: {error} {sigma}");
        }
    }
    let sense = ["sense", BRACKETED, "--displacements", &nodes, "--contact-at", "75@10", "--mesh-nodes", "11"];
    let sensed = Csv::of(&finray(&sense).computed());
    let (force, sigma) = (sensed.numbers("force_n")[0], sensed.numbers("sigma_n")[0]);
    assert!((force - 3.0).abs() < 4.0 * sigma && sigma < 0.05, "{force} +- {sigma}");
    // Without references the base is only about where the ribs have it, as a warning says: it is sought with the force. The force leans from the
    // undeformed normal by the arctangent of 10 degrees, wherever that normal points.
    let (scene, _) = finray_fixtures::BRACKETED_SCENE.split_once("[[base.reference]]").expect("references");
    let (_, camera) = finray_fixtures::BRACKETED_SCENE.split_once("[camera]").expect("a camera");
    let contact = "[contact]\nfriction = 0.17633\nnormal = \"undeformed\"\n";
    let without = folder.put("without.toml", format!("{scene}{contact}[camera]{camera}"));
    let found = folder.path("found.csv");
    let (_, warnings) = finray(&["locate", &without, "--image", &image, "--out", &found]).warned();
    assert_says(
        &warnings.join("\\n"),
        &["image.png: two references on the base were not found", "where the base is sought with the forces"],
    );
    let located = Csv::of(&folder.read("found.csv"));
    assert_eq!((located.numbers("base_sigma_mm")[0] > 5.0, located.numbers("marker_sigma_mm")[0] < 0.1), (true, true));
    let sense = ["sense", &without, "--displacements", &found, "--contact-at", "75@friction", "--mesh-nodes", "11"];
    let sensed = Csv::of(&finray(&sense).computed());
    let (force, sigma) = (sensed.numbers("force_n")[0], sensed.numbers("sigma_n")[0]);
    assert!((force - 3.0).abs() < 4.0 * sigma && sigma < 0.06, "{force} +- {sigma}");
}

#[test]
fn shades_and_references_of_a_scene_are_checked() {
    let folder = Folder::new();
    let image = folder.put("image.png", encoded(&DynamicImage::ImageRgb8(RgbImage::new(1920, 1080)), ImageFormat::Png));
    for (from, to, expected) in [
        (
            "shade = \"bright\"",
            "shade = \"white\"",
            "markers.shade: expected one of \"bright\", \"dark\", found the text \"white\"",
        ),
        (
            "inner_radius_mm = 1.0",
            "inner_radius_mm = 2.0",
            "markers.inner_radius_mm: expected a length in mm, zero or more and below radius_mm",
        ),
        (
            "shade = \"bright\"",
            "shade = \"bright\"\nfront_rgb = [226, 186, 46]",
            "markers.shade: expected either shade or front_rgb and back_rgb, found shade and front_rgb",
        ),
        ("at_mm = [-16.0, 20.0]", "at_mm = [-16.0]", "base.reference[1].at_mm: expected a list of 2 numbers"),
        ("at_mm = [-16.0, 20.0]", "", "base.reference[1].at_mm is missing"),
        ("at_mm = [-16.0, 20.0]", "at_mm = [-1e9, 20.0]", "base.reference[1].at_mm: expected lengths of at most"),
        ("at_mm = [-16.0, -10.0]\nshade = \"dark\"", "at_mm = [-16.0, -10.0]", "base.reference[2].shade is missing"),
        ("[base]", "[base]\nreferences = 2", "unknown key `base.references`; the nearest known key is `reference`"),
        ("[base]", "[base]\nsigma_mm = 0.1", "base.sigma_deg is missing"),
        ("[base]", "[base]\nsigma_mm = -0.1\nsigma_deg = 0.1", "base.sigma_mm: expected a length in mm, zero or more"),
        ("[base]", "[base]\nsigma_mm = 0.1\nsigma_deg = 100", "base.sigma_deg: expected an angle in degrees, 0 to 90"),
        ("[base]", "[base]\nturn_deg_per_n = 0.1", "base.sigma_mm is missing"),
        (
            "[base]",
            "[base]\nsigma_mm = 0.1\nsigma_deg = 0.1\nturn_deg_per_n = 11",
            "base.turn_deg_per_n: expected an angle in degrees a newton, -10 to 10",
        ),
        (
            "[markers]",
            "[markers]\nmodel_error_mm = nan",
            "markers.model_error_mm: expected a length in mm, zero or more",
        ),
        ("[markers]", "[markers]\nnoise_factor = 0.0", "markers.noise_factor: expected a number above 0 and up to 1"),
        (
            "[base]",
            "[contact]\nfriction = -20\n[base]",
            "contact.friction: expected a coefficient of friction, -10 to 10",
        ),
        (
            "[base]",
            "[contact]\nfriction_range = [0.5, 0.0]\n[base]",
            "contact.friction_range: expected two coefficients",
        ),
        (
            "[base]",
            "[contact]\nfriction_range = [0.0, 0.5]\nfriction = 0.2\n[base]",
            "contact.friction_range: expected either friction or friction_range, found both",
        ),
        (
            "[base]",
            "[contact]\nforce_error_share = 2.0\n[base]",
            "contact.force_error_share: expected a share from 0 to 1, found 2.0",
        ),
        ("[base]", "[contact]\npad_mm = -1\n[base]", "contact.pad_mm: expected a length in mm, zero or more"),
        (
            "[base]",
            "[contact]\npad_length_mm = 300.0\n[base]",
            "contact.pad_length_mm: expected a length in mm, no more than the front plate's 150.16, found 300.0",
        ),
        ("[base]", "[contact]\nfriction_sigma = 0.1\n[base]", "contact.friction is missing: expected a coefficient"),
        (
            "[base]",
            "[contact]\nfriction = 0.1\nnormal = \"own\"\n[base]",
            "contact.normal: expected one of \"deformed\", \"undeformed\"",
        ),
        (
            "[base]",
            "[contact]\nfriction = 0.1\nnormal = \"undeformed\"\nnormal_over_mm = 5\n[base]",
            "contact.normal_over_mm: expected nothing",
        ),
        (
            "bracket_mm = 3.0",
            "bracket_mm = [[3.0, 2.0]]",
            "finger.ribs.bracket_mm: expected a pair for each of 4 ribs, found 1",
        ),
    ] {
        let text = finray_fixtures::BRACKETED_SCENE.replacen(from, to, 1);
        assert_ne!(text, finray_fixtures::BRACKETED_SCENE, "{from}");
        let scene = folder.put("scene.toml", text);
        assert_says(&finray(&["locate", &scene, "--image", &image]).refused(), &["line ", expected]);
    }
    assert_says(
        &finray(&["render", CAMERA, "--base", "1,2,3"]).refused(),
        &["--base: expected a scene with a table [base]"],
    );
    let numbers = finray(&["render", CAMERA, "--base", "1,2"]).refused();
    assert_says(&numbers, &["expected X_MM,Y_MM,DEG, three numbers"]);
}
