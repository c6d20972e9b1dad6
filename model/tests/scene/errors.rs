//! Invalid scenes are refused with one message that names line, key and expected value.

use super::refused::{assert_all_refused, assert_all_refused_in, assert_refused, changed, refused};
use finray_fixtures::PAPER_SCENE;
use finray_model::{Kinematics, Load, Mesh, NodeId, Scene, statics};

#[test]
fn every_scene_of_the_repository_is_good() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures");
    let mut scenes = 0;
    for inner in ["scenes", "scenes/contact", "opensees"] {
        for entry in std::fs::read_dir(format!("{folder}/{inner}")).expect("fixtures") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                let text = std::fs::read_to_string(&path).expect("a text");
                let scene = Scene::from_toml(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                let load = Load::at_position(60.0, scene.finger.direction(0.0) * 0.05);
                let mesh = Mesh::key_nodes(&scene.finger);
                statics::solve(&mesh, &[load], Kinematics::Corotational).expect("an equilibrium");
                scenes += 1;
            }
        }
    }
    assert!(scenes >= 6);
}

#[test]
fn a_scene_may_be_written_in_many_ways() {
    let scene = |text: &str| Scene::from_toml(text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let reference = scene(PAPER_SCENE);
    for (from, to) in [
        ("\n", "\r\n"),
        ("# The finger", "\u{feff}# The finger"),
        ("58.0", "58"),
        ("58.0", "+5.80e1"),
        ("153.0", "1_53.0"),
        ("count = 11", "count = 0x0B"),
        ("base_width_mm", "\"base_width_mm\""),
        ("[finger.ribs]", "[finger.ribs] # eleven"),
        ("depth_mm = 20.0", "depth_mm = 20.0\nrod_arm_mm = 0\npoissons_ratio = 0.0\nzone = []"),
        ("joints = \"rigid\"", "joints = 'rigid'\nrigid = false"),
    ] {
        // A comment in the first line is valid even after a byte order mark.
        assert_eq!(scene(&changed(PAPER_SCENE, from, to)), reference, "{to:?}");
    }
    let noise = scene(&changed(PAPER_SCENE, "\n[finger]", "[camera]\nnoise_mm = 0.1\n[finger]"));
    assert_eq!((noise.finger, noise.noise_mm), (reference.finger.clone(), Some(0.1)));
    let evenly: Vec<_> = (1..=11).map(|i| format!("[{0:?}, {0:?}]", 153.0 * f64::from(i) / 12.0)).collect();
    let positions =
        scene(&changed(PAPER_SCENE, "count = 11", &format!("positions_mm = [{}]", evenly.join(", ")))).finger;
    assert!(
        (1..=25)
            .all(|node| (positions.position(NodeId(node)) - reference.finger.position(NodeId(node))).norm() < 1e-12)
    );
    // Without ribs, the kind of joints has no effect.
    let ribless = changed(PAPER_SCENE, "count = 11", "count = 0");
    assert_eq!(scene(&changed(&ribless, "joints = \"rigid\"\n", "")), scene(&ribless));
    // Zones change the finger.
    let zone = |to: &str| {
        format!("{PAPER_SCENE}\n[[finger.zone]]\nplate = \"front\"\nfrom_mm = 0\nto_mm = {to}\nmodulus_factor = 2\n")
    };
    let [whole, part] = ["153", "70"].map(|to| scene(&zone(to)).finger);
    assert!(whole != reference.finger && whole != part);
}

#[test]
fn unknown_keys_are_named_with_the_nearest_known_one() {
    let rows = r#"
        base_width_mm | base_widht_mm | finger.base_widht_mm | base_width_mm
        base_width_mm | base_width | finger.base_width | base_width_mm
        base_width_mm | basewidth | finger.basewidth | base_width_mm
        base_width_mm | width | finger.width | base_width_mm
        back_length_mm | length_back | finger.length_back | back_length_mm
        depth_mm = 20.0 | depth_mm = 20.0\nrod_arm = 1.0 | finger.rod_arm | rod_arm_mm
        depth_mm = 20.0 | depth_mm = 20.0\nposson_ratio = 0.3 | finger.posson_ratio | poissons_ratio
        count = 11 | counts = 11 | finger.ribs.counts | count
        count = 11 | position_mm = [] | finger.ribs.position_mm | positions_mm
        joints | joint | finger.ribs.joint | joints
        name | nmae | nmae | name
        \n[finger] | [cammera]\n[finger] | cammera | camera
        \n[finger] | [camera]\nnoise = 0.1\n[finger] | camera.noise | noise_mm
        "#;
    for row in rows.lines().map(str::trim).filter(|row| !row.is_empty()) {
        let cells: Vec<String> = row.split(" | ").map(|cell| cell.replace("\\n", "\n")).collect();
        let [from, to, key, nearest] = &cells[..] else { panic!("{row}") };
        let text = changed(PAPER_SCENE, from, to);
        let written = key.rsplit('.').next().expect("a key");
        let line = text.lines().position(|line| line.trim_start_matches('[').starts_with(written)).expect("the line");
        let expected = format!("line {}: unknown key `{key}`; the nearest known key is `{nearest}`", line + 1);
        assert_refused(&text, &expected);
    }
    // For an unknown key in a plate's table or in the second of two zones, the message names the line of that key.
    let back = changed(PAPER_SCENE, "[finger.back]\nthickness_mm", "[finger.back]\nthicknes_mm");
    assert_refused(&back, "line 19: unknown key `finger.back.thicknes_mm`; the nearest known key is `thickness_mm`");
    let zone = "[[finger.zone]]\nplate = \"front\"\nfrom_mm = 1\nto_mm = 2\nmodulus_factor = 2\n";
    let zones = PAPER_SCENE.to_owned() + zone + &zone.replace("modulus_factor", "factor");
    assert_refused(&zones, "line 36: unknown key `finger.zone[2].factor`; the nearest known key is `modulus_factor`");
}

#[test]
fn values_of_another_type_are_refused() {
    let number = "finger.base_width_mm: expected a length in mm, as a plain number";
    assert_refused(&changed(PAPER_SCENE, "58.0", "true"), number);
    // The text of two lines is shown with an escape.
    assert_refused(&changed(PAPER_SCENE, "58.0", "\"58\\n mm\""), r#"found the text "58\n mm""#);
    assert_all_refused(
        PAPER_SCENE,
        r#"
        58.0 | "58 mm" | base_width_mm | found the text "58 mm"
        58.0 | true | base_width_mm | found true
        58.0 | [58.0] | base_width_mm | found a list
        58.0 | { mm = 58.0 } | base_width_mm | found a table
        58.0 | 1979-05-27 | base_width_mm | found the date 1979-05-27
        58.0 | 99999999999999999999 | base_width_mm | found 99999999999999999999
        "paper" | 5 | name | name: expected a text in quotes, found 5
        count = 11 | count = 11.0 | count | finger.ribs.count: expected a whole number, zero or more, found 11.0
        count = 11 | count = -1 | count | expected a whole number, zero or more, found -1
        count = 11 | count = "11" | count | expected a whole number, zero or more, found the text "11"
        count = 11 | count = 99999999999999999999 | count | expected a whole number, zero or more
        "rigid" | "glued" | joints | finger.ribs.joints: expected one of "rigid", "hinged", found the text "glued"
        joints = "rigid"\nthickness_mm = 1.5 | joints = "rigid"\nthickness_mm = [2.0, 2.0] | thickness_mm = [ | finger.ribs.thickness_mm: expected one thickness for each of 11 ribs, found 2 values
        joints = "rigid"\nthickness_mm = 1.5 | joints = "rigid"\nthickness_mm = [2.0, -1.0] | thickness_mm = [ | finger.ribs.thickness_mm: expected a positive length in mm, found -1.0
        count = 11 | count = 11\nbracket_mm = "3 mm" | bracket_mm | finger.ribs.bracket_mm: expected a length in mm, or [front, back], found the text "3 mm"
        count = 11 | count = 11\nbracket_mm = [3.0] | bracket_mm | finger.ribs.bracket_mm: expected a list of 2 numbers
        \n[finger] | [markers]\non = "ribs"\n[finger] | on = | markers.on: expected one of "junctions", "hinges", found the text "ribs"
        "rigid" | true | joints | expected one of "rigid", "hinged", found true
        count = 11 | count = 11\nrigid = 1 | rigid | finger.ribs.rigid: expected true or false, found 1
        count = 11 | positions_mm = 11 | positions_mm | expected a list of pairs [front, back]
        count = 11 | positions_mm = [[1.0, 2.0, 3.0]] | positions_mm | expected a list of pairs [front, back]
        count = 11 | positions_mm = [1.0, 2.0] | positions_mm | expected a list of pairs [front, back]
        count = 11 | positions_mm = [["1 mm", 2.0]] | positions_mm | expected a list of pairs [front, back]
        depth_mm = 20.0 | depth_mm = 20.0\nzone = 5 | zone | finger.zone: expected tables [[finger.zone]], found 5
        depth_mm = 20.0 | depth_mm = 20.0\nzone = [5] | zone | finger.zone: expected tables [[finger.zone]], found 5
        \n[finger] | camera = 0.1\n[finger] | camera | camera: expected a table, found 0.1
        "#,
    );
    assert_refused("name = \"x\"\nfinger = 5\n", "line 2: finger: expected a table, found 5");
}

/// If a key is missing, the message names the line of the table that should contain the key.
#[test]
fn missing_keys_are_named() {
    assert_all_refused(
        PAPER_SCENE,
        r#"
        base_width_mm = 58.0\n |  | [finger] | finger.base_width_mm is missing: expected a length in mm
        front_length_mm = 153.0\n |  | [finger] | finger.front_length_mm is missing
        back_length_mm = 153.0\n |  | [finger] | finger.back_length_mm is missing
        depth_mm = 20.0\n |  | [finger] | finger.depth_mm is missing
        joints = "rigid"\n |  | [finger.ribs] | finger.ribs.joints is missing: expected one of "rigid", "hinged"
        count = 11\n |  | [finger.ribs] | finger.ribs.count is missing: expected the number of ribs, or positions_mm
        name = "paper"\n |  | # | name is missing: expected a text in quotes
        \n[finger] | [camera]\n[finger] | [camera] | camera.noise_mm is missing
        "#,
    );
    for (table, line) in [("front", 14), ("back", 18), ("ribs", 22)] {
        let (before, after) = PAPER_SCENE.split_once(&format!("[finger.{table}]\n")).expect("the table");
        for key in ["thickness_mm", "youngs_modulus_mpa"] {
            let (start, rest) = after.split_once(key).expect("the key");
            let (_, rest) = rest.split_once('\n').expect("a line end");
            let without = format!("{before}[finger.{table}]\n{start}{rest}");
            assert_refused(&without, &format!("line {line}: finger.{table}.{key} is missing"));
        }
        let without = format!("{before}{}", after.split_once("\n\n").map_or("", |(_, rest)| rest));
        assert_refused(&without, &format!("line 8: finger.{table} is missing: expected a table"));
    }
    assert_refused("", "line 1: name is missing");
    assert_refused("name = \"x\"\n", "line 1: finger is missing: expected a table");
    let zone = PAPER_SCENE.to_owned() + "\n[[finger.zone]]\nplate = \"back\"\nfrom_mm = 1\nmodulus_factor = 2\n";
    assert_refused(&zone, "line 28: finger.zone[1].to_mm is missing");
}

#[test]
fn text_that_is_no_toml_is_refused_by_line() {
    assert_all_refused(
        PAPER_SCENE,
        r#"
        58.0 | 58 mm | base_width_mm | not valid TOML: 
        "paper" | "paper | name | not valid TOML: 
        [finger] | [finger | [finger | not valid TOML: 
        depth_mm = 20.0 | depth_mm = 20.0\ndepth_mm = 21.0 | depth_mm = 21 | not valid TOML: 
        [finger.back] | [finger.front]\n[finger.back] | 18 | not valid TOML: 
        depth_mm = 20.0 | depth_mm | depth_mm | not valid TOML: 
        "#,
    );
    assert!(refused("[").starts_with("line 1: "));
}

/// Scenes with faulty objects or rods are refused; the message names the line of the fault.
#[test]
fn objects_that_cannot_be_are_refused() {
    let disc = "[object]\nshape = \"disc\"\nradius_mm = 5\nat_mm = 70\ntravel_mm = 3\n";
    assert_all_refused_in(
        &format!("{PAPER_SCENE}\n"),
        disc,
        r#"
        radius_mm = 5 | radius = 5 | 30 | unknown key `object.radius`; the nearest known key is `radius_mm`
        "disc" | "ring" | 29 | object.shape: expected one of "disc", "box", "polygon", found the text "ring"
        radius_mm = 5\n |  | 28 | object.radius_mm is missing: expected a length in mm
        = 5 | = 0 | 30 | object.radius_mm: expected a length in mm above zero, up to 10000, found 0.0
        = 5 | = inf | 30 | object.radius_mm: expected a length in mm above zero, up to 10000, found inf
        = 5 | = 5\nwidth_mm = 5 | 31 | object.width_mm: expected no such key, found a key that a disc
        "disc" | "box" | 30 | object.radius_mm: expected no such key, found a key that a box does not have
        = 70 | = 154 | 31 | object.at_mm: expected a position on the front plate, 0 to 153 mm, found 154
        = 70 | = nan | 31 | object.at_mm: expected a position on the front plate, 0 to 153 mm, found NaN
        at_mm = 70\n |  | 28 | object.at_mm is missing: expected the position on the front plate to press at
        = 70 | = 70\ndirection_deg = 90 | 32 | expected an angle between -90 and 90 degrees
        travel_mm = 3 |  | 28 | object.travel_mm is missing: expected the travel of the object in mm (or force_n)
        = 3 | = -3 | 32 | object.travel_mm: expected a length in mm above zero, up to 10000, found -3.0
        = 3 | = 3\nforce_n = 2 | 33 | object.force_n: expected either travel_mm or force_n, found both
        = 3 | = 3\nfriction = -1 | 33 | object.friction: expected a coefficient of friction, 0 to 10
        = 3 | = 3\nsteps = 0 | 33 | object.steps: expected a whole number, 1 to 10000, found 0
        = 3 | = 3\nrotation_deg = inf | 33 | object.rotation_deg: expected a finite angle
        = 3 | = 3\npath_mm = [[1, 2], [3, 4]] | 31 | object.at_mm: expected no such key, found a key that an object with path_mm
        at_mm = 70\ntravel_mm = 3 | path_mm = [[1, 2], [1, 2]] | 31 | object.path_mm: expected two or more different points
        at_mm = 70\ntravel_mm = 3 | path_mm = [[1, 2], [inf, 2]] | 31 | object.path_mm: expected two or more different points
        [object] | [contact]\nrod_radius_mm = -1\n[object] | 29 | contact.rod_radius_mm: expected a length in mm, zero or more
        "#,
    );
}
