//! Rendered images of the finger.

use super::*;

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

/// Without --mesh-nodes, `render` draws the converged finger. This image equals that of a much finer mesh, except for single pixels whose rounded
/// coverage differs. The image of a mesh with only key nodes differs from the image of the converged finger.
#[test]
fn the_converged_finger_is_drawn() {
    let folder = Folder::new();
    let pixels = |options: &[&str]| {
        let path = folder.path("image.png");
        finray(&[&["render", CAMERA, "--load-at", "90:4,10", "--out", &path], options].concat()).done();
        image::open(path).expect("the image").to_rgb8().into_raw()
    };
    let drawn = pixels(&[]);
    let others = |other: Vec<u8>| drawn.iter().zip(&other).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    let [fine, coarse] = ["4000", "25"].map(|nodes| others(pixels(&["--mesh-nodes", nodes])));
    assert!(fine <= 30 && coarse > 10_000, "{fine} {coarse}");
}

/// `render` draws the same image from a shape in a file as from the load that caused the shape.
#[test]
fn shapes_are_rendered_from_files() {
    let folder = Folder::new();
    let (of_load, _) = image_of(&folder, "load.png", "90:2,10", &FINE);
    let shape = folder.path("shape.csv");
    finray(&["solve", CAMERA, "--load-at", "90:2,10", FINE[0], FINE[1], "--out", &shape]).done();
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

#[test]
fn the_motion_of_a_base_is_checked() {
    assert_says(
        &finray(&["render", CAMERA, "--base", "1,2,3"]).refused(),
        &["--base: expected a scene with a table [base]"],
    );
    let numbers = finray(&["render", CAMERA, "--base", "1,2"]).refused();
    assert_says(&numbers, &["expected X_MM,Y_MM,DEG, three numbers"]);
}
