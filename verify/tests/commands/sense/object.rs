//! Tests the sensing of a contact with an object of known shape; the scene may also state the pose of the object.

use crate::kit::*;

const OBJECT: &str =
    "[contact.object]\nshape = \"disc\"\nradius_mm = 20.0\npose_mm = [75.45, 29.45]\npose_sigma_mm = 0.05\n";

fn scene(folder: &Folder, tables: &str) -> String {
    folder.put("scene.toml", paper_with(&[]) + "\n" + tables)
}

/// `press` finds the contact from the pose of the object. From the shape that `press` writes, `sense` with the same object recovers the same forces.
#[test]
fn what_presses_is_sensed_where_it_is() {
    /// Relative tolerance. In the lattice, the plate is a chain of straight capsules; the direction of a capsule deviates from the plate's direction
    /// by up to half a degree.
    const LATTICE: f64 = 3e-3;
    let folder = Folder::new();
    let press = "[object]\nshape = \"disc\"\nradius_mm = 20\npath_mm = [[76.7, 35.9], [75.45, 29.45]]\nsteps = 1\n";
    let scene = scene(&folder, &format!("[contact]\nrod_radius_mm = 0.0\n{OBJECT}{press}"));
    let shape = folder.path("shape.csv");
    let pressed = Csv::of(&finray(&["press", &scene, "--fineness", "6", "--shape", &shape]).done());
    assert_eq!(pressed.texts("contact"), ["at", "total"]);
    let sense = ["sense", &scene, "--displacements", &shape, "--noise-mm", "0.01", "--contact-at", "auto@object"];
    let sensed = Csv::of(&finray(&sense).done());
    assert_close(&sensed.numbers("force_n"), &pressed.numbers("force_n")[..1], LATTICE);
    let found_mm = sensed.numbers("s_mm")[0];
    let true_mm: f64 = pressed.texts("s_mm")[0].parse().expect("a position");
    assert!((found_mm - true_mm).abs() < 0.3, "{found_mm} mm, {true_mm} mm");
}

/// If the pose of the object is unknown, the direction of the force follows from the plate alone. If the pose of the object is stated in the camera's
/// plane, `sense` uses the base pose of the image to convert it to the finger frame.
#[test]
fn poses_are_in_their_frame_or_unknown() {
    let folder = Folder::new();
    let shape = finray(&["solve", PAPER, "--load-at", "74:1,0.35"]).done();
    let sense = |object: &str, shape: &str, contact: &str| {
        let scene = scene(&folder, object);
        let all = ["sense", &scene, "--displacements", "-", "--noise-mm", "0.01", "--contact-at", contact];
        finray_reading(shape.as_bytes(), &all)
    };
    let known = sense(OBJECT, &shape, "auto@object").done();
    let unknown = OBJECT.replace("pose_mm = [75.45, 29.45]\npose_sigma_mm = 0.05\n", "");
    assert_eq!(sense(&unknown, &shape, "auto@object").done(), sense(OBJECT, &shape, "auto@normal").done());
    // The base is rotated by 90 degrees and displaced: x' = 10 - y, y' = 20 + x.
    let moved = OBJECT.replace("[75.45, 29.45]", "[-19.45, 95.45]") + "frame = \"plane\"\n";
    let rows = shape.lines().enumerate().map(|(i, row)| match i {
        0 => format!("{row},base_x_mm,base_y_mm,base_deg\n"),
        _ => format!("{row},10,20,90\n"),
    });
    let placed = Csv::of(&sense(&moved, &rows.collect::<String>(), "auto@object").done());
    assert_close(&placed.numbers("force_n"), &Csv::of(&known).numbers("force_n"), 1e-6);
    // If the displacement file states no base pose, `sense` uses the base pose that the camera's pose implies.
    assert_says(&sense(&moved, &shape, "auto@object").refused(), &["the object cannot touch the plate at contact 1"]);
}

#[test]
fn objects_that_cannot_be_are_refused() {
    let folder = Folder::new();
    let refused = |tables: &str, options: &[&str]| {
        let scene = scene(&folder, tables);
        let shape = finray(&["solve", PAPER, "--load-at", "74:1,0.35"]).done();
        let all = [&["sense", &scene, "--displacements", "-", "--contact-at", "auto@object"][..], options].concat();
        finray_reading(shape.as_bytes(), &all).refused()
    };
    let noise = ["--noise-mm", "0.01"];
    assert_says(&refused("", &noise), &["expected a table [contact.object] in the scene"]);
    assert_says(&refused(OBJECT, &[]), &["noise of the displacements must be known"]);
    assert_says(&refused(OBJECT, &["--estimator", "ridge"]), &["`object` or `auto` needs the estimator nonlinear"]);
    for (from, to, expected) in [
        ("[75.45, 29.45]", "[75.45, 31.45]", "so the outline lies outside the finger"),
        ("[75.45, 29.45]", "[75.45, 27.45]", "inside the finger"),
        ("radius_mm = 20.0", "", "contact.object.radius_mm is missing"),
        ("radius_mm", "radius", "line 30: unknown key `contact.object.radius`"),
        (
            "= 20.0",
            "= -1",
            "line 30: contact.object.radius_mm: expected a length in mm above zero, up to 10000, found -1.0",
        ),
        ("\"disc\"", "\"cube\"", "line 29: contact.object.shape: expected one of \"disc\", \"ellipse\", \"polygon\""),
        ("\"disc\"", "\"ellipse\"", "line 30: contact.object.radius_mm: expected no such key, found a key that an"),
        ("radius_mm = 20.0", "rotation_deg = 3", "contact.object.radius_mm is missing"),
        ("= 0.05", "= 0.05\nrotation_deg = 3", "line 33: contact.object.rotation_deg: expected no such key"),
        (
            "pose_mm = [75.45, 29.45]",
            "",
            "contact.object.pose_mm is missing: expected [x, y] in mm, because the table has `pose_sigma_mm`",
        ),
        ("pose_sigma_mm = 0.05", "", "contact.object.pose_sigma_mm is missing"),
        (
            "= 0.05",
            "= -0.05",
            "line 32: contact.object.pose_sigma_mm: expected a standard deviation in mm, 0 to 10000, found -0.05",
        ),
        ("= 0.05", "= 0.05\nframe = \"tip\"", "line 33: contact.object.frame: expected one of \"base\", \"plane\""),
        (
            "\"disc\"\nradius_mm = 20.0",
            "\"polygon\"\ncorners_mm = [[0, 0], [4, 0], [1, 1], [0, 4]]",
            "line 30: contact.object.corners_mm: expected three or more corners of a convex polygon, listed in order",
        ),
        ("\"disc\"\nradius_mm = 20.0", "\"ellipse\"\nsemi_axes_mm = [3, 0]", "line 30: contact.object.semi_axes_mm"),
    ] {
        assert_says(&refused(&OBJECT.replace(from, to), &noise), &[expected]);
    }
}
