//! Several fingers in the same frames.

use super::recording::{Recorded, recorded};
use super::*;

/// Names of two scenes with one finger each, and translations of their cameras; the images of the fingers do not overlap.
const PLACES: [(&str, &str); 2] = [("left", "[-75.0, 45.0, 240.0]"), ("right", "[-75.0, -45.0, 240.0]")];

fn scenes_of_two_fingers(folder: &Folder) -> [String; 2] {
    PLACES.map(|(name, place)| {
        let scene = finray_fixtures::CAMERA_SCENE.replace("[-75.0, 0.0, 170.0]", place);
        assert!(scene.contains(place));
        folder.put(&format!("{name}.toml"), scene)
    })
}

/// Two fingers in one image are sensed separately. The recording contains the printed lines, and the forces as vectors in the finger frame.
#[test]
fn two_fingers_in_one_image_are_distinguished_and_recorded() {
    let folder = Folder::new();
    let scenes = scenes_of_two_fingers(&folder);
    let [mut both, right] = [0, 1].map(|i| {
        let (load, path) = (["80:2,-20", "60:1.5,-20"][i], folder.path("one.png"));
        finray(&["render", &scenes[i], "--load-at", load, "--grey-noise", "0", "--out", &path]).done();
        image::open(&path).expect("an image").to_rgb8()
    });
    let background = *right.get_pixel(0, 0);
    for (both, right) in both.pixels_mut().zip(right.pixels()) {
        if *right != background {
            *both = *right;
        }
    }
    let (stream, record) =
        (folder.put("stream", yuv4mpeg2(&[both.clone(), both], "444", [1, 1], true)), folder.path("record.mcap"));
    let fingers = [0, 1].map(|i| format!("{}={}", PLACES[i].0, scenes[i]));
    let live = ["live", "--finger", &fingers[0], "--finger", &fingers[1], "--contact-at", "auto@-20", "--every-frame"];
    let found = lines(&finray(&[&live[..], &["--input", &stream, "--record", &record]].concat()).done());
    assert_eq!(states(&found), ["contact"; 2]);
    let Recorded { wrenches, lines: in_recording, .. } = recorded(&record, &[]);
    assert_eq!(in_recording, found);
    assert_eq!(wrenches.len(), 4);
    for (i, (true_n, s_mm)) in [(2.0, 80.0), (1.5, 60.0)].into_iter().enumerate() {
        let (name, contact) = (PLACES[i].0, &found[1]["contacts"][i]);
        assert_eq!((&contact["finger"], &found[1]["fingers"][i]["finger"]), (&name.into(), &name.into()));
        let [force_n, at_mm] = ["force_n", "s_mm"].map(|key| contact[key].as_f64().expect("a number"));
        assert!((force_n - true_n).abs() < 0.01 && (at_mm - s_mm).abs() < 0.1, "{contact}");
        let (topic, time_s, force) = &wrenches[2 + i];
        assert_eq!((topic, time_s), (&format!("/finray/{name}/contact_1"), &0.04));
        let expected = finger().direction(-20.0) * force_n;
        // JSON rounds a number to its shortest form.
        assert_close(&force[..2], expected.as_slice(), 1e-12);
        assert_eq!(force[2], 0.0);
    }
}

/// Positions of several fingers are distinguished by name, as JSON and as a table. A frame with an unexpected name is refused.
#[test]
fn positions_of_several_fingers_have_names() {
    let folder = Folder::new();
    let fingers = scenes_of_two_fingers(&folder);
    let fingers = [0, 1].map(|i| format!("{}={}", PLACES[i].0, fingers[i]));
    let frames = [2.0, 1.0].map(|force_n| positions(&shape(&[pushed(70.0, force_n)]), 0.5, 1));
    let named = |name: &str, [line, rows]: &[String; 2]| {
        let markers = line.replace("{\"node\"", &format!("{{\"finger\":\"{name}\",\"node\""));
        let rows: String = rows.lines().map(|row| format!("{row},{name}\n")).collect();
        [markers, rows]
    };
    let [left, right] = [0, 1].map(|i| named(PLACES[i].0, &frames[i]));
    let json =
        format!("{},{}", left[0].trim_end().trim_end_matches("]}"), right[0].split_once('[').expect("markers").1);
    let table = format!("t_s,node,x_mm,y_mm,sigma_mm,finger\n{}{}", left[1], right[1]);
    let live = ["live", "--finger", &fingers[0], &fingers[1], "--contact-at", "auto@0", "--every-frame"];
    for stream in [&json, &table] {
        let found = lines(&finray_reading(stream.as_bytes(), &live).done());
        let forces = [0, 1].map(|i| found[0]["contacts"][i]["force_n"].as_f64().expect("a force"));
        assert!((forces[0] - 2.0).abs() < 0.1 && (forces[1] - 1.0).abs() < 0.1, "{forces:?}");
    }
    let found = lines(&finray_reading(left[0].as_bytes(), &live).done());
    assert_eq!(
        (&found[0]["fingers"][0]["state"], &found[0]["fingers"][1]["state"]),
        (&"contact".into(), &"lost".into())
    );
    let wrong = lines(&finray_reading(json.replace("right", "rihgt").as_bytes(), &live).done());
    assert_says(
        wrong[0]["refused"].as_str().expect("a reason"),
        &["expected a finger of left, right, found \"rihgt\""],
    );
    let twice = ["live", "--finger", &fingers[0], &fingers[0], "--contact-at", "auto@0"];
    assert_says(&finray(&twice).refused(), &["--finger left", "once"]);
}
