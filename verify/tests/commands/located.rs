//! Tables of `locate` hold everything that `sense` needs, and say with which scene they were made.

use crate::kit::*;

/// Folder of images that Pillow compressed, and their scene.
const COMPRESSED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/compressed");
const FORCE: [&str; 5] = ["force_n", "sigma_n", "low_n", "high_n", "angle_deg"];
/// Direction and position of the force in the images.
const CONTACT: [&str; 2] = ["--contact-at", "80@-20"];
/// Force in the image `press.jpg`, N.
const PRESS_N: f64 = 1.5;

struct Images {
    folder: Folder,
    scene: String,
    rest: String,
    press: String,
}

impl Images {
    fn new() -> Images {
        let [scene, rest, press] = ["scene.toml", "rest.jpg", "press.jpg"].map(|name| format!("{COMPRESSED}/{name}"));
        Images { folder: Folder::new(), scene, rest, press }
    }

    /// The scene with all occurrences of some texts replaced.
    fn changed(&self, name: &str, changes: &[(&str, &str)]) -> String {
        let text = std::fs::read_to_string(&self.scene).expect("the fixture");
        self.folder.put(name, replaced(&text, changes))
    }

    /// The table of `press.jpg`, located with a scene and, if `has_rest`, with the image of the unloaded finger.
    fn located(&self, scene: &str, has_rest: bool) -> String {
        let out = self.folder.path("located.csv");
        let rest = ["--rest", &self.rest];
        let locate = ["locate", scene, "--image", &self.press, "--out", &out];
        // A pose that is not that of the image causes a warning.
        finray(&[&locate[..], if has_rest { &rest } else { &[] }].concat()).computed();
        out
    }
}

fn sensed(scene: &str, source: &[&str]) -> Vec<f64> {
    let answer = finray(&[&["sense", scene][..], &CONTACT, source].concat());
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let table = Csv::of(&answer.out);
    FORCE.map(|column| table.numbers(column)[0]).to_vec()
}

/// A table of `locate` once lost the degrees of freedom and the shared error of compressed images, so that its interval was narrower than that of the
/// image; with an image of the unloaded finger, the shared error of that image was lost, too.
#[test]
fn a_table_of_compressed_images_senses_as_the_images_do() {
    let images = Images::new();
    for has_rest in [false, true] {
        let rest = ["--rest", &images.rest];
        let direct = [&["--image", &images.press][..], if has_rest { &rest } else { &[] }].concat();
        let direct = sensed(&images.scene, &direct);
        let table = images.located(&images.scene, has_rest);
        assert_close(&sensed(&images.scene, &["--displacements", &table]), &direct, 1e-9);
        assert!(direct[2] < PRESS_N && PRESS_N < direct[3], "{direct:?}");
        let lines = finray(&[&["live", &images.scene, "--input", &table][..], &CONTACT].concat()).done();
        let expected = format!("\"sigma_n\":{:?}", direct[1]);
        // `live` takes displacements from the scene's finger.
        assert!(has_rest || lines.contains(&expected), "{lines}");
        // Without the two columns, the interval is narrower.
        let mut text = images.folder.read("located.csv");
        text = text.replacen("noise_degrees_of_freedom,shared_sigma_mm", "unknown_a,unknown_b", 1);
        let without = sensed(&images.scene, &["--displacements", &images.folder.put("without.csv", text)]);
        assert!(without[1] < 0.97 * direct[1], "{has_rest}: {without:?} {direct:?}");
    }
}

/// The image of the unloaded finger errs as the other image does, so that the error that all markers share is larger by sqrt(2), as far as the noise of the
/// two images is the same.
#[test]
fn the_shared_error_of_the_rest_image_counts() {
    let images = Images::new();
    let shared = |has_rest| {
        let text = std::fs::read_to_string(images.located(&images.scene, has_rest)).expect("a table");
        Csv::of(&text).numbers("shared_sigma_mm")[0]
    };
    let ratio = shared(true) / shared(false);
    assert!((1.2..3.0).contains(&ratio), "{ratio}");
}

/// Markers of another camera or lens are located again from their pixels; the forces are those of a table that was located with the present scene.
#[test]
fn a_table_of_another_scene_is_located_again() {
    let images = Images::new();
    type Change<'c> = (&'c str, &'c [(&'c str, &'c str)], &'c str);
    let changes: [Change; 4] = [
        (
            "moved",
            &[("translation_mm = [-75.0, 0.0, 170.0]", "translation_mm = [-75.1, 0.1, 170.5]")],
            "pose of the camera",
        ),
        ("lens", &[("focal_px = [680.0, 680.0]", "focal_px = [678.0, 678.0]")], "lens"),
        ("height", &[("height_mm = 0.0", "height_mm = 0.5")], "lens"),
        ("finger", &[("base_width_mm = 58.0", "base_width_mm = 58.2")], "finger"),
    ];
    for (name, change, word) in changes {
        let older = images.changed(&format!("{name}.toml"), change);
        let table = images.located(&older, false);
        let answer = finray(&[&["sense", &images.scene, "--displacements", &table][..], &CONTACT].concat());
        assert_eq!(answer.code, Some(0), "{name}: {}", answer.err);
        assert_says(&answer.err, &["note: ", &format!("located with another {word} than the scene's")]);
        let found = sensed(&images.scene, &["--displacements", &table]);
        let quiet = ["sense", &images.scene, "--displacements", &table, "--quiet"];
        finray(&[&quiet[..], &CONTACT].concat()).done();
        let anew = sensed(&images.scene, &["--displacements", &images.located(&images.scene, false)]);
        // The search for a marker's edge starts from another radius, which matters little.
        assert!((found[0] - anew[0]).abs() < 0.2 * anew[1], "{name}: {found:?} {anew:?}");
        assert!((found[1] / anew[1] - 1.0).abs() < 0.1, "{name}: {found:?} {anew:?}");
    }
    // Materials and colours do not matter.
    let softer = images.changed("softer.toml", &[("47.976", "48.5"), ("[226, 186, 46]", "[225, 186, 46]")]);
    finray(&[&["sense", &images.scene, "--displacements", &images.located(&softer, false)][..], &CONTACT].concat())
        .done();
}

/// Displacements from an image of the unloaded finger cannot be computed again without that image, and nodes of other numbers have other names.
#[test]
fn a_stale_table_that_cannot_be_located_again_is_refused() {
    let images = Images::new();
    let refused = |scene: &str, table: &str| {
        finray(&[&["sense", scene, "--displacements", table][..], &CONTACT].concat()).refused()
    };
    let other = images.changed("lens.toml", &[("focal_px = [680.0, 680.0]", "focal_px = [670.0, 670.0]")]);
    let table = images.located(&images.scene, true);
    assert_says(&refused(&other, &table), &["located.csv", "another lens", "image of the unloaded finger", "locate"]);
    let fewer = images.changed("fewer.toml", &[("count = 11", "count = 10")]);
    assert_says(&refused(&fewer, &table), &["another finger", "other numbers"]);
    // Another geometry of the finger does not change the difference of two images.
    let wider = images.changed("wider.toml", &[("base_width_mm = 58.0", "base_width_mm = 58.2")]);
    finray(&[&["sense", &wider, "--displacements", &table][..], &CONTACT].concat()).done();
    // A table without the column works as before, and a damaged cell is named.
    let text = images.folder.read("located.csv");
    let without = images.folder.put("without.csv", text.replacen("located_with", "unknown", 1));
    finray(&[&["sense", &other, "--displacements", &without][..], &CONTACT].concat()).computed();
    let digest = text.lines().nth(1).and_then(|line| line.rsplit(',').next()).expect("a digest");
    let damaged = images.folder.put("damaged.csv", text.replacen(digest, "25.zz-rest-0", 1));
    assert_says(&refused(&images.scene, &damaged), &["damaged.csv", "line 2", "located_with", "25.zz-rest-0"]);
    let live = finray(&[&["live", &other, "--input", &table][..], &CONTACT].concat()).computed();
    assert_says(&live, &["\"refused\"", "another lens"]);
}
