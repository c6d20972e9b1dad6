//! From images to displacements and forces.

use super::*;
use finray_fixtures::CAMERA_SCENE;

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
