//! Intrinsics and distortion from images of a grid.

use super::*;
use finray_fixtures::CAMERA_SCENE;
use finray_model::camera::Distortion;

/// Image of a grid with a pitch of 10 mm, slanted by `slant` (rad). The camera has the lens of the camera scene, which has no distortion.
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

/// The output of `lens` is a valid `[camera]` table of a scene.
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

/// Files of ROS and OpenCV in their various forms state the same lens.
#[test]
fn files_of_ros_and_opencv_state_a_lens() {
    let folder = Folder::new();
    let load = |text: &str| {
        finray_files::load_lens(std::path::Path::new(&folder.put("camera", text))).map_err(|error| error.to_string())
    };
    let calibrator = "image_width: 640\nimage_height: 480\ncamera_name: narrow\ncamera_matrix:\n  rows: 3\n  cols: 3\n  \
        data: [500.5, 0, 320, 0, 501, 239.5, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  \
        cols: 5\n  data: [-0.1, 0.02, 0.001, -0.002, 0]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  \
        data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
    let message = "header:\n  stamp:\n    sec: 1\n  frame_id: camera\nheight: 480\nwidth: 640\ndistortion_model: rational_polynomial\n\
        d:\n- -0.1\n- 0.02\n- 0.001\n- -0.002\n- 0.0\n- 0.0\n- 0.0\n- 0.0\nk:\n- 500.5\n- 0.0\n- 320.0\n- 0.0\n- 501.0\n- 239.5\n\
        - 0.0\n- 0.0\n- 1.0\n---\n";
    let opencv = "%YAML:1.0\n---\ncalibration_time: \"Sat Nov 28\"\nimage_width: 640\nimage_height: 480\nfisheye_model: 0\n\
        camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 5.0050000000000000e+02, 0., 320., 0., 501.,\n       \
        2.3950000000000000e+02, 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 4\n   cols: 1\n   dt: d\n   \
        data: [ -1.0000000000000001e-01, 2.0e-02, 1.0e-03,\n       -2.0e-03 ]\n";
    let xml = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_Width>640</image_Width>\n<image_Height>480</image_Height>\n\
        <Camera_Matrix type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt>\n<data>\n 500.5 0. 320. 0. 501. 239.5 0. 0.\n 1.</data>\
        </Camera_Matrix>\n<Distortion_Coefficients type_id=\"opencv-matrix\"><rows>5</rows><cols>1</cols><dt>d</dt>\n\
        <data>\n -0.1 0.02 0.001 -0.002 0.</data></Distortion_Coefficients>\n</opencv_storage>\n";
    let json = r#"{"image_width": 640, "image_height": 480, "mtx": [[500.5, 0, 320], [0, 501, 239.5], [0, 0, 1]],
        "dist": [[-0.1, 0.02, 0.001, -0.002, 0]]}"#;
    for text in [calibrator, message, opencv, xml, json] {
        let lens = load(text).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert_eq!(
            (lens.size_px(), lens.focal_px(), lens.principal_point_px()),
            ([640, 480], [500.5, 501.0], [320.0, 239.5])
        );
        assert_eq!(lens.distortion().coefficients(), [-0.1, 0.02, 0.001, -0.002, 0.0]);
    }
    for (from, to, expected) in [
        (
            "plumb_bob",
            "omnidirectional",
            "distortion_model: expected one of plumb_bob, rational_polynomial, equidistant",
        ),
        ("-0.002, 0]", "-0.002, 0, 0, 0]", "distortion_coefficients: expected 4 (k1, k2, p1, p2), 5 (and k3) or 8"),
        ("-0.002, 0]", "-0.002, 0, 0, 0, 0, 0, 0, 0, 1]", "found a thin prism"),
        ("-0.002, 0]", "-0.002, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]", "found a tilted sensor"),
        ("plumb_bob", "equidistant", "expected the 4 coefficients of a fisheye lens (k1, k2, k3, k4), found 5"),
        ("500.5, 0,", "500.5, 2,", "camera_matrix: expected fx, 0, cx, 0, fy, cy, 0, 0, 1"),
        ("image_width: 640\n", "", "expected image_width"),
        ("image_width: 640", "image_width: -640", "image_width: expected a number of pixels"),
        ("[500.5", "[five", "camera_matrix: expected numbers"),
        ("camera_matrix:", "camera_matrix: [", "expected YAML, XML or JSON"),
        ("camera_matrix:", "camera_matrice:", "expected camera_matrix"),
    ] {
        assert_says(&load(&calibrator.replacen(from, to, 1)).expect_err(to), &["camera: ", expected]);
    }
    let fisheye = Distortion::fisheye(&[-0.1, 0.02, 0.001, -0.002]).expect("a distortion");
    for (text, from, to) in [
        (opencv, "fisheye_model: 0", "fisheye_model: 1"),
        (opencv, "fisheye_model: 0", "fisheye_model: true"),
        (
            calibrator,
            "plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.02, 0.001, -0.002, 0]",
            "equidistant\ndistortion_coefficients:\n  data: [-0.1, 0.02, 0.001, -0.002]",
        ),
    ] {
        assert_eq!(*load(&text.replacen(from, to, 1)).expect("a fisheye lens").distortion(), fisheye);
    }
    let rational = load(&message.replacen("- 0.0\n- 0.0\n- 0.0\n- 0.0\nk:", "- 0.3\n- 0.1\n- 0.05\n- 0.02\nk:", 1))
        .expect("a lens");
    assert_eq!(rational.distortion().coefficients(), [-0.1, 0.02, 0.001, -0.002, 0.3, 0.1, 0.05, 0.02]);
    assert_says(&load("<opencv_storage>").expect_err("cut off"), &["expected XML"]);
}

#[test]
fn images_without_a_grid_give_no_lens() {
    let folder = Folder::new();
    let finger = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/compressed/press.jpg").to_owned();
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
    // One image without slant does not determine the focal length.
    let answer = finray(&["lens", "--grid-mm", "10", "--image", &grid(&folder, "flat.png", 0.0)]);
    assert!(answer.code == Some(0) && answer.err.starts_with("note: ") && answer.err.contains("fx"), "{}", answer.err);
    assert_says(&answer.err, &["warning: the focal length is uncertain by"]);
    assert!(answer.out.contains("# the focal length is uncertain by"));
}

/// `lens --plane` computes the pose of a frame in the grid's plane: its origin is in the middle of the image, and its z axis points to the camera.
/// All images must show the grid in the same place.
#[test]
fn the_plane_of_a_grid_is_written() {
    use finray_model::camera::{Camera, Lens, Pose};
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
    // Two images of a grid in one place do not determine the focal length, which keeps its prior value. Slant and distance are therefore only
    // approximate.
    assert!(z.dot(&true_z).abs() > 0.03_f64.cos() && z.z < 0.0, "{z} {true_z}");
    // With a known lens, one image determines the pose.
    let known =
        folder.put("known.yaml", "width: 1600\nheight: 1400\nk: [1360, 0, 799.5, 0, 1360, 699.5, 0, 0, 1]\nd: []\n");
    let with_known = lens(&[&images[0], "--from", &known]);
    assert_eq!(with_known.code, Some(0), "{}", with_known.err);
    let exact = finray_model::Scene::from_toml(&format!("{before}{}", with_known.out)).expect("a scene");
    let exact = exact.camera.expect("a camera").pose.expect("a pose");
    assert!((exact.rotation * Vector3::z()).dot(&true_z).abs() > 1.0 - 1e-7, "{exact:?}");
    assert_says(
        &finray(&["lens", "--from", &known, "--grid-mm", "10", "--image", &images[0]]).refused(),
        &["expected --plane"],
    );
    // Distances between positions in the grid's plane are correct even with an inaccurate focal length.
    let apart = |lens: Lens, pose: Pose| {
        let [a, b] = [[300.0, 400.0], [1300.0, 1000.0]]
            .map(|pixel| Camera { lens, pose }.on_plane(&pixel.into(), 0.0).expect("the plane"));
        (a - b).norm()
    };
    let true_lens = finray_model::Scene::from_toml(CAMERA_SCENE).expect("the fixture").camera.expect("a camera").lens;
    assert_close(&[apart(scene.camera.expect("a camera").lens, found)], &[apart(true_lens, truth)], 0.001);
    assert_says(
        &lens(&[&images[0], &images[2]]).refused(),
        &["--plane: expected a grid that does not move between images", "image"],
    );
}
