//! Coloured markers on the hinges of a finger with brackets; tip and clamped nodes have no markers.

use crate::kit::*;
use finray_fixtures::BRACKETED_SCENE;

/// Position (mm), force (N) and angle (degrees) of the load.
const LOAD: [f64; 3] = [80.0, 3.0, 10.0];
/// Limit of the relative error of the force, for noise of two grey levels at 4 px/mm.
const LARGEST_ERROR: f64 = 0.005;

/// The scene of the bracketed finger, with coloured discs instead of bright rims and with a fixed base.
fn scene(folder: &Folder) -> String {
    let (before, after) = BRACKETED_SCENE.split_once("[markers]").expect("markers");
    let camera = &after[after.find("[camera]").expect("a camera")..];
    let markers = "[markers]\non = \"hinges\"\nradius_mm = 2.0\nheight_mm = 0.0\nfront_rgb = [226, 186, 46]\nback_rgb = [198, 52, 44]\n\n";
    folder.put("hinges.toml", format!("{before}{markers}{camera}"))
}

/// `locate --rest` once compared hinge markers with the undeformed nodes and refused its own rendered image of the unloaded finger.
#[test]
fn coloured_markers_on_hinges_are_read_with_and_without_a_rest_image() {
    let folder = Folder::new();
    let scene = scene(&folder);
    let (rest, image, nodes) = (folder.path("rest.png"), folder.path("image.png"), folder.path("nodes.csv"));
    let load = format!("{}:{},{}", LOAD[0], LOAD[1], LOAD[2]);
    let noise = ["--grey-noise", "2", "--blur-px", "0.8"];
    finray(&[&["render", &scene, "--out", &rest][..], &noise].concat()).done();
    finray(&[&["render", &scene, "--load-at", &load, "--out", &image][..], &noise].concat()).done();
    let contact = format!("{}@{}", LOAD[0], LOAD[2]);
    for with_rest in [&[][..], &["--rest", &rest]] {
        finray(&[&["locate", &scene, "--image", &image, "--out", &nodes][..], with_rest].concat()).done();
        let located = Csv::of(&folder.read("nodes.csv"));
        assert_eq!(located.texts("node"), ["2", "3", "4", "5", "7", "8", "9", "10"], "{with_rest:?}");
        let sensed = Csv::of(&finray(&["sense", &scene, "--displacements", &nodes, "--contact-at", &contact]).done());
        let (force_n, sigma_n) = (sensed.numbers("force_n")[0], sensed.numbers("sigma_n")[0]);
        assert!((force_n / LOAD[1] - 1.0).abs() < LARGEST_ERROR, "{with_rest:?}: {force_n} N");
        assert!((force_n - LOAD[1]).abs() < 3.0 * sigma_n, "{with_rest:?}: {force_n} +- {sigma_n} N");
    }
}
