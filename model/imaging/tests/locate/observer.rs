//! Scenes that an observer refuses, and warnings of images.

use crate::kit::{DISTURBED, camera_of, scene};
use finray_fixtures::{BRACKETED_SCENE, CAMERA_SCENE};
use finray_imaging::locate::{ImageWarning, Observer};
use finray_imaging::render::{RenderRequest, render};
use finray_model::mesh::FingerShape;
use finray_model::observation::{Observation, ObservedMarker};
use finray_model::{Finger, Kinematics, Load, Mesh, NodeId, Scene, Vector, statics};
use image::RgbImage;
use nalgebra::UnitComplex;

/// A valid scene is refused if its camera cannot see the finger or its markers.
#[test]
fn cameras_that_do_not_see_the_markers_are_refused() {
    for (from, to, expected) in [
        ("[-75.0, 0.0, 170.0]", "[-75.0, 0.0, -170.0]", "behind the camera"),
        ("[-75.0, 0.0, 170.0]", "[300.0, 0.0, 170.0]", "outside the image"),
        ("radius_mm = 1.5", "radius_mm = 0.1", "radius of 0.8 px"),
        // k1 = -2 folds at a radius of 0.41, 69 mm from the axis; node 1 is 80 mm from it.
        ("distortion = [0.0,", "distortion = [-2.0,", "the marker of node 1 lies beyond the radius"),
        ("[226, 186, 46]", "[200, 200, 200]", "markers.front_rgb: expected a colour that is not a shade of grey"),
    ] {
        let scene = Scene::from_toml(&CAMERA_SCENE.replace(from, to)).expect("a scene");
        let error = Observer::new(&scene, None).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// Shape of a scene's finger under a force, N.
fn bent(finger: &Finger, force_n: f64) -> FingerShape {
    let mesh = Mesh::with_elements_per_member(finger, 4);
    let load = Load::at_position(80.0, finger.direction(0.0) * force_n);
    statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium")
}

/// Image of a scene's finger under a force, N, without the markers of some nodes.
fn image(scene: &Scene, force_n: f64, hidden: &[usize]) -> RgbImage {
    let finger = &scene.finger;
    let shape = bent(finger, force_n);
    let references = scene.base.iter().flat_map(|base| base.references.clone()).collect::<Vec<_>>();
    let (camera, markers) = (camera_of(scene), scene.markers.expect("markers"));
    let request = RenderRequest {
        offsets: &scene.marker_offsets,
        references: &references,
        hidden: &hidden.iter().map(|node| NodeId(*node)).collect::<Vec<_>>(),
        disturbances: DISTURBED,
        ..RenderRequest::of(&camera, finger, &shape, &markers)
    };
    render(&request).expect("a finger in sight")
}

fn warnings(scene: &Scene, image: &RgbImage) -> Vec<ImageWarning> {
    let mut observer = Observer::new(scene, None).expect("an observer");
    observer.observe(image).expect("a finger");
    observer.warnings
}

#[test]
fn an_image_warns_of_what_it_shows() {
    let right = scene();
    let plain = image(&right, 1.0, &[]);
    assert_eq!(warnings(&right, &plain), []);
    assert_eq!(warnings(&right, &image(&right, 1.0, &[1, 25])), [ImageWarning::PoseNotVerified]);
    let changed = |from: &str, to: &str| Scene::from_toml(&CAMERA_SCENE.replace(from, to)).expect("a scene");
    let found = warnings(&changed("[-75.0, 0.0,", "[-75.0, 0.5,"), &plain);
    assert!(
        matches!(found[..], [ImageWarning::ClampedMarker { node: NodeId(1), distance_mm }] if (distance_mm - 0.5).abs() < 0.02),
        "{found:?}"
    );
    assert!(found[0].to_string().contains("of clamped node 1 is 0.50 mm away from the position that the pose gives"));
    let found = warnings(&changed("radius_mm = 1.5", "radius_mm = 1.35"), &plain);
    assert!(
        matches!(found[..], [ImageWarning::OtherRadius(other)] if other.stated_mm == 1.35 && (other.shown_mm - 1.5).abs() < 0.02),
        "{found:?}"
    );
    // A finger under a small load is no image of the unloaded finger.
    let rest_px =
        |force_n| Observer::new(&right, Some(&image(&right, force_n, &[]))).expect("a finger").rest_residual_px;
    let warning = |force_n| ImageWarning::of_rest(rest_px(force_n).expect("a fit"));
    assert!(matches!(warning(0.05), Some(ImageWarning::RestResidual(px)) if px < 1.0));
    assert_eq!(warning(0.0), None);
}

#[test]
fn missing_grey_markers_and_references_are_warned_of() {
    let scene = Scene::from_toml(BRACKETED_SCENE).expect("the fixture");
    let plain = image(&scene, 1.0, &[]);
    assert_eq!(warnings(&scene, &plain), []);
    let (start, _) = BRACKETED_SCENE.split_once("[[base.reference]]").expect("references");
    let (_, camera) = BRACKETED_SCENE.split_once("[camera]").expect("a camera");
    let without = Scene::from_toml(&format!("{start}[camera]{camera}")).expect("a scene");
    assert_eq!(warnings(&without, &plain), [ImageWarning::BaseFromRibs]);
    let nodes: Vec<usize> = scene.finger.marked_nodes().map(|node| node.0).collect();
    let found = warnings(&scene, &image(&scene, 1.0, &nodes[..2]));
    let expected = nodes.len();
    assert_eq!(found, [ImageWarning::MarkersMissing { found: expected - 2, expected }]);
}

/// The base of one image is turned against the bases of the others; images without a known base do not count.
#[test]
fn an_image_upside_down_is_found_among_others() {
    let scene = Scene::from_toml(BRACKETED_SCENE).expect("the fixture");
    let seen = Observer::new(&scene, None).expect("an observer").observe(&image(&scene, 1.0, &[])).expect("a finger");
    let turned = |deg: f64, is_known: bool| {
        let mut seen: Observation = seen.clone();
        let base = seen.base.as_mut().expect("a base");
        (base.pose.rotation, base.is_known) = (UnitComplex::new(deg.to_radians()), is_known);
        seen
    };
    let images =
        [turned(1.0, true), turned(-179.0, true), turned(170.0, false), turned(-3.0, true), turned(20.0, true)];
    assert_eq!(ImageWarning::turned(&images.iter().collect::<Vec<_>>()), [false, true, false, false, false]);
    assert_eq!(ImageWarning::turned(&[&images[1]]), [false]);
}

/// Markers of a bent finger that are up to 0.6 mm away from their nodes show the displacements of the nodes. The plates turn by up to 0.2 rad, so that an
/// offset that did not turn with them would err by 0.1 mm; the chord between the neighbours turns as the node does within 0.07 rad.
#[test]
fn markers_beside_their_nodes_show_the_displacements_of_the_nodes() {
    let mut scene = scene();
    let offset = |i: usize| Vector::new(0.4 * (2.1 * i as f64).sin(), 0.4 * (1.3 * i as f64).cos());
    scene.marker_offsets = (0..scene.finger.key_node_count()).map(offset).collect();
    let errors = |scene: &Scene, image: &RgbImage, rest: Option<&RgbImage>| -> f64 {
        let shape = bent(&scene.finger, 3.0);
        let seen = Observer::new(scene, rest).expect("an observer").observe(image).expect("a finger");
        let error = |marker: &ObservedMarker| {
            (marker.displacement.expect("a displacement") - shape.motion(marker.node).displacement).norm()
        };
        seen.markers.iter().map(error).fold(0.0, f64::max)
    };
    let (seen, rest) = (image(&scene, 3.0, &[]), image(&scene, 0.0, &[]));
    let (known, from_rest) = (errors(&scene, &seen, None), errors(&scene, &seen, Some(&rest)));
    assert!(known < 0.04 && from_rest < 0.04, "{known} {from_rest}");
    let residual_px = Observer::new(&scene, Some(&rest)).expect("a finger").rest_residual_px.expect("a fit");
    assert_eq!(ImageWarning::of_rest(residual_px), None);
    scene.marker_offsets.clear();
    assert!(errors(&scene, &seen, None) > 0.3);
}
