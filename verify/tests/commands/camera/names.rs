//! Images with the same file name in several folders.

use super::*;

/// The force in each image, N.
const FORCES_N: [f64; 3] = [2.0, 0.5, 1.0];
const FORCE_OF: [&str; 3] = ["80:2,-20", "80:0.5,-20", "80:1,-20"];

/// Images in numbered folders, as cameras create them: two images have the same file name, and one has another name.
fn images(folder: &Folder) -> [String; 3] {
    ["100", "101"].iter().for_each(|name| std::fs::create_dir(folder.path(name)).expect("a folder"));
    let names = ["100/1.png", "101/1.png", "101/2.png"];
    [0, 1, 2].map(|i| {
        let path = folder.path(names[i]);
        finray(&["render", CAMERA, "--load-at", FORCE_OF[i], "--out", &path]).done();
        path
    })
}

#[test]
fn images_of_one_name_are_distinguished_by_their_folders() {
    let folder = Folder::new();
    let images = images(&folder);
    let nodes = folder.path("nodes.csv");
    let located = ["locate", CAMERA, "--image", &images[0], &images[1], &images[2], "--out", &nodes];
    finray(&located).done();
    let mut names =
        Csv::of(&folder.read("nodes.csv")).texts("image").iter().map(|name| name.to_string()).collect::<Vec<_>>();
    names.dedup();
    assert_eq!(names, ["100/1.png", "101/1.png", "2.png"]);
    let sense = ["sense", CAMERA, "--displacements", &nodes, "--contact-at", "80@-20"];
    let all = Csv::of(&finray(&[&sense[..], &["--all-images"]].concat()).computed());
    assert_eq!(all.texts("image"), names);
    for (force_n, truth_n) in all.numbers("force_n").iter().zip(FORCES_N) {
        assert!((force_n - truth_n).abs() < 0.01, "{force_n}, true {truth_n}");
    }
    // An image is found by its name in the table or by its path. An ambiguous name is refused.
    let named = |name: &str| finray(&[&sense[..], &["--image-name", name]].concat());
    for (i, name) in
        [(0, "100/1.png"), (0, &images[0]), (1, "./101/1.png"), (2, "2.png"), (2, "101/2.png"), (2, &images[2])]
    {
        let force_n = Csv::of(&named(name).computed()).numbers("force_n")[0];
        assert!((force_n - FORCES_N[i]).abs() < 0.01, "{name}: {force_n}");
    }
    assert_says(&named("1.png").refused(), &["\"1.png\" may be 100/1.png or 101/1.png", "--image-name"]);
    assert_says(
        &named("102/1.png").refused(),
        &["\"102/1.png\" is not among the located images", "100/1.png, 101/1.png, 2.png"],
    );
    // Runs `locate` in one of the folders with images.
    let inside =
        command(&["locate", CAMERA, "--image", "1.png", "../101/1.png"]).current_dir(folder.path("100")).output();
    let inside = Csv::of(&String::from_utf8(inside.expect("finray runs").stdout).expect("text"));
    assert_eq!((inside.texts("image")[0], inside.texts("image")[49]), ("100/1.png", "101/1.png"));
    let twice = finray(&["locate", CAMERA, "--image", &images[0], &images[1], &images[0]]).refused();
    assert_says(&twice, &["100/1.png: the image is given twice"]);
}

/// Tables of measured forces name images as in the table of `locate`, or with more of the path.
#[test]
fn forces_find_images_of_one_name_by_their_folders() {
    let folder = Folder::new();
    let images = images(&folder);
    let nodes = folder.path("nodes.csv");
    finray(&["locate", CAMERA, "--image", &images[0], &images[1], &images[2], "--out", &nodes]).done();
    let calibrated = |names: [&str; 3]| {
        let row = |(name, force): (&str, &str)| {
            let [force_n, angle_deg] = [&force[3..force.len() - 4], "-20"].map(|text| text.parse().expect("a number"));
            let [fx, fy] = paper_force(force_n, angle_deg);
            format!("{name},{fx},{fy}\n")
        };
        let rows: String = names.into_iter().zip(FORCE_OF).map(row).collect();
        let forces = folder.put("forces.csv", format!("image,fx_n,fy_n\n{rows}"));
        finray(&["calibrate", CAMERA, "--located", &nodes, "--forces", &forces, "--fit", "modulus"])
    };
    let table = Csv::of(&calibrated(["100/1.png", "101/1.png", "2.png"]).computed());
    assert_eq!(table.texts("parameter")[0], "modulus_factor");
    assert!((table.numbers("value")[0] - 1.0).abs() < 0.01, "{table:?}");
    assert_eq!(Csv::of(&calibrated([&images[0], "x/101/1.png", "101/2.png"]).computed()), table);
    assert_says(&calibrated(["100/1.png", "1.png", "2.png"]).refused(), &["line 3: ", "may be 100/1.png or 101/1.png"]);
    assert_says(
        &calibrated(["100/1.png", "102/1.png", "2.png"]).refused(),
        &["line 3: ", "is not among the located images"],
    );
    assert_says(&calibrated(["100/1.png", &images[0], "2.png"]).refused(), &["line 3: ", "is listed twice"]);
}

/// A truncated image gives one refused row in the table of `locate` and one in the table of `sense`. The other images are located and sensed as if
/// the truncated image were absent.
#[test]
fn a_bad_image_is_one_refused_row() {
    let folder = Folder::new();
    let images = images(&folder);
    let whole = std::fs::read(&images[1]).expect("an image");
    let cut = folder.put("cut.png", &whole[..whole.len() / 2]);
    let nodes = folder.path("nodes.csv");
    let located = finray(&["locate", CAMERA, "--image", &images[0], &cut, &images[2], "--out", &nodes]);
    let (_, warnings) = located.warned();
    assert!(warnings.iter().any(|line| line.contains("cut.png") && line.contains("refused")), "{warnings:?}");
    let all = ["sense", CAMERA, "--displacements", &nodes, "--contact-at", "80@-20", "--all-images"];
    let sensed = Csv::of(&finray(&all).computed());
    assert_eq!(sensed.texts("image"), ["1.png", "cut.png", "2.png"]);
    assert_eq!(sensed.texts("force_n").iter().filter(|force| force.is_empty()).count(), 1);
    assert!(sensed.texts("refused")[1].contains("cut.png"), "{:?}", sensed.texts("refused"));
    let one = ["sense", CAMERA, "--displacements", &nodes, "--contact-at", "80@-20", "--image-name"];
    assert_says(&finray(&[&one[..], &["cut.png"]].concat()).refused(), &["cut.png was refused when it was located"]);
    // If the truncated image is the only image, `locate` fails.
    assert_says(&finray(&["locate", CAMERA, "--image", &cut]).refused(), &["cut.png"]);
}
