//! Accepted and refused formats of a measurement.

use super::{CONTACTS, HEADER, SENSED, TRUTH, linear_shape, sense, sense_text};
use crate::kit::*;

#[test]
fn what_solve_writes_sense_reads() {
    let sensed = sense(&linear_shape(&TRUTH), &CONTACTS);
    assert_eq!(sensed.header[..HEADER.len()], HEADER);
    let further = ["low_n", "high_n", "s_sigma_mm", "s_low_mm", "s_high_mm", "angle_sigma_deg"];
    assert_eq!(sensed.header[HEADER.len()..], further);
    // Positions and directions are stated.
    assert!(further[2..].iter().all(|column| sensed.texts(column) == ["", "", ""]), "{sensed:?}");
    assert_eq!(sensed.texts("contact"), ["16", "20", "23"]);
    assert_close(&sensed.numbers("s_mm"), &[114.75, 63.75, 25.5], 1e-15);
    assert_eq!(sensed.numbers("angle_deg"), TRUTH.map(|(_, angle, _)| angle));
    assert_close(&sensed.numbers("force_n"), &TRUTH.map(|(_, _, force)| force), SENSED);
    let [low_n, high_n] = ["low_n", "high_n"].map(|column| sensed.numbers(column));
    assert_close(&low_n, &TRUTH.map(|(_, _, force)| force), SENSED);
    assert_close(&high_n, &TRUTH.map(|(_, _, force)| force), SENSED);
    // A perfect fit has no residual, so the estimated noise is zero.
    assert!(sensed.numbers("sigma_n").iter().all(|sigma| (0.0..SENSED).contains(sigma)));
}

/// A file may have hidden markers, another order of rows, further columns, Windows line ends, a byte order mark, spaces, and no final line end.
#[test]
fn a_measurement_may_be_written_in_many_ways() {
    let shape = Csv::of(&linear_shape(&TRUTH));
    let (node, ux, uy) = (shape.texts("node"), shape.texts("ux_mm"), shape.texts("uy_mm"));
    let row = |i: usize| format!("{},a word,{} , {},{}", uy[i], node[i], ux[i], i as f64);
    for hidden in [vec![], vec![3, 4, 11, 17], (6..25).collect::<Vec<_>>()] {
        let mut rows: Vec<_> = (0..25).rev().filter(|i| !hidden.contains(i)).map(row).collect();
        rows.rotate_left(2);
        rows.swap(0, 3);
        for line_end in ["\n", "\r\n"] {
            let text = format!("\u{feff}uy_mm,remark, node ,ux_mm,weight{line_end}{}", rows.join(line_end));
            let forces = sense(&text, &CONTACTS).numbers("force_n");
            // Five markers near the base of the back plate determine the forces less well.
            let lost = if hidden.len() > 10 { 1e4 } else { 1.0 };
            assert_close(&forces, &TRUTH.map(|(_, _, force)| force), lost * SENSED);
        }
    }
}

/// Markers on hinges move differently from markers on the junctions of the plate. The force is sensed correctly from markers on hinges and from
/// markers on junctions.
#[test]
fn markers_on_hinges_are_compared_with_hinges() {
    let folder = Folder::new();
    let bracketed = finray_fixtures::BRACKETS_SCENE.to_owned();
    let on_plates = folder.put("plates.toml", &bracketed);
    let on_hinges = folder.put("hinges.toml", bracketed + "[markers]\non = \"hinges\"\n");
    let shape = finray(&["solve", &on_plates, "--load-at", "102:1.5,10", "--mesh-nodes", "100"]).done();
    let table = Csv::of(&shape);
    let column = |name: &str| table.numbers(name);
    let moved =
        |x: &str, y: &str| -> Vec<[f64; 2]> { column(x).into_iter().zip(column(y)).map(|(x, y)| [x, y]).collect() };
    let hinges = moved("hinge_ux_mm", "hinge_uy_mm");
    assert!(hinges.iter().zip(moved("ux_mm", "uy_mm")).any(|(a, b)| (a[0] - b[0]).abs() > 0.3));
    let seen = |moved: Vec<[f64; 2]>| {
        let rows = moved.iter().enumerate().map(|(node, [x, y])| format!("{},{x},{y}\n", node + 1));
        "node,ux_mm,uy_mm\n".to_owned() + &rows.collect::<String>()
    };
    let force = |scene: &str, text: &str| -> f64 {
        let arguments = ["sense", scene, "--displacements", "-", "--contact", "9@10", "--mesh-nodes", "100"];
        Csv::of(&finray_reading(text.as_bytes(), &arguments).computed()).numbers("force_n")[0]
    };
    let truth = 1.5;
    for (scene, text) in [
        (&on_plates, shape.clone()),
        (&on_hinges, shape.clone()),
        (&on_hinges, seen(hinges.clone())),
        (&on_plates, seen(moved("ux_mm", "uy_mm"))),
    ] {
        assert_close(&[force(scene, &text)], &[truth], 1e-6);
    }
    // If displacements of hinges are read as displacements of junctions, the sensed force is wrong by more than a hundred times the tolerance.
    assert!((force(&on_plates, &seen(hinges)) - truth).abs() > 1e-4 * truth);
}

/// `solve` writes undeformed positions, and `locate` writes deformed positions, possibly rounded. Positions that are not numbers are ignored.
#[test]
fn displacements_of_another_finger_are_warned_of() {
    let shape = linear_shape(&TRUTH);
    // Replaces x and y of each row by values that follow from its position and displacement.
    let with = |text: &str, new: &dyn Fn(f64, f64) -> String| -> String {
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            let [x, y, ux, uy] = [1, 2, 3, 4].map(|i| cells[i].parse::<f64>().unwrap_or(f64::NAN));
            let [x, y] = if x.is_nan() { [1, 2].map(|i| cells[i].to_owned()) } else { [new(x, ux), new(y, uy)] };
            format!("{},{x},{y},{},{}\n", cells[0], cells[3], cells[4])
        };
        text.lines().map(row).collect()
    };
    let of_paper = |text: &str| sense_text(text, &CONTACTS);
    let undeformed = |x: f64, _| format!("{x:.1}");
    let deformed = |x: f64, u: f64| format!("{:.2}", x + u);
    for own in [with(&shape, &undeformed), with(&shape, &|_, _| "aside".to_owned())] {
        of_paper(&own).done();
    }
    // The deformed positions differ from the undeformed positions by more than the limit beyond which `sense` suspects another finger.
    let bent = paper_shape(&[(19, 3.0, 0.0)], &[]).computed();
    let own = sense_text(&with(&bent, &deformed), &["--contact", "19", "--estimator", "nonlinear"]);
    assert_eq!((own.code, own.err.contains("another finger?")), (Some(0), false), "{}", own.err);
    const SOFT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/soft.toml");
    let soft = finray(&["solve", SOFT, "--load", "10:0,-0.001"]).done();
    for other in [soft.clone(), with(&soft, &deformed)] {
        assert_says(
            &of_paper(&other).err,
            &["warning: ", ": undeformed node ", " mm in the file, and at (", "another finger?"],
        );
    }
}

#[test]
fn rows_of_clamped_nodes_carry_noise_and_are_refused_beyond_it() {
    let shape = linear_shape(&TRUTH);
    let free: String =
        shape.lines().filter(|l| !l.starts_with("1,") && !l.starts_with("25,")).map(|l| format!("{l}\n")).collect();
    assert_eq!(free.lines().count(), shape.lines().count() - 2);
    assert_eq!(sense(&free, &CONTACTS), sense(&shape, &CONTACTS));
    // A clamped marker may move by 2 % of the other markers' displacement (1 mm), or by six standard deviations of a stated noise. A displacement of
    // 0.05 mm is always allowed.
    let with = |moving: &str| format!("node,ux_mm,uy_mm\n7,0,-1\n{moving}\n8,0,-1\n9,0.1,-1\n");
    for (moving, noise) in [
        ("1,0,0.021", &[][..]),
        ("25,0.2,0", &[]),
        ("25,-1,-1", &[]),
        ("25,0.051,0", &["--noise-mm", "0.001"]),
        ("25,0.121,0", &["--noise-mm", "0.02"]),
    ] {
        let message = sense_text(&with(moving), &[&["--contact", "19"], noise].concat()).refused();
        assert_says(&message, &["standard input: line 3: node ", "is clamped, so its displacement must be zero"]);
        assert_says(&message, &["expected at most", "numbered as in the scene"]);
    }
    let free = sense_text("node,ux_mm,uy_mm\n7,0,-1\n8,0,-1\n9,0.1,-1\n", &["--contact", "19"]).done();
    for moving in ["1,0,1e-9", "1,0,0.019", "25,-0.01,0.01"] {
        assert_eq!(sense_text(&with(moving), &["--contact", "19"]).done(), free, "{moving}");
    }
    for (moving, noise_mm) in [("25,0.049,0", "0.001"), ("25,0.119,0", "0.02")] {
        let (sensed, _) = sense_text(&with(moving), &["--contact", "19", "--noise-mm", noise_mm]).warned();
        assert!(sensed.starts_with("contact,"), "{moving}");
    }
}

/// Trackers leave the cells of a lost marker empty. A row with only one coordinate is refused.
#[test]
fn empty_cells_are_a_hidden_marker() {
    let shape = linear_shape(&TRUTH);
    let rows = |change: &dyn Fn(&str) -> Option<String>| -> String {
        let cells = shape.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let row = |cells: Vec<&str>| match matches!(cells[0], "2" | "7" | "19") {
            true => change(cells[0]),
            false => Some(format!("{},{},{}\n", cells[0], cells[3], cells[4])),
        };
        cells.filter_map(row).collect()
    };
    let missing = sense(&rows(&|_| None), &CONTACTS);
    for empty in [",,", ", , ", ",\"\",\"\"", ",NaN,nan", ",NA,NA", ",null,null"] {
        assert_eq!(sense(&rows(&|node| Some(format!("{node}{empty}\n"))), &CONTACTS), missing);
    }
    for (half, empty) in [("1.5,", "uy_mm"), (",1.5", "ux_mm")] {
        let message = sense_text(&rows(&|node| Some(format!("{node},{half}\n"))), &CONTACTS).refused();
        assert_says(&message, &["line 3: ", empty, "for a hidden marker, leave both cells empty"]);
    }
    let none = sense_text("node,ux_mm,uy_mm\n7,,\n8,,\n", &["--contact", "19"]).refused();
    assert_says(&none, &["too few measured coordinates (0)", "unknowns (1)"]);
}

#[test]
fn measurements_that_cannot_be_read_are_refused_by_file_and_line() {
    let folder = Folder::new();
    for (text, expected) in [
        ("", vec!["expected the columns node,ux_mm,uy_mm, found nothing"]),
        ("\n\n", vec!["expected the columns node,ux_mm,uy_mm, found nothing"]),
        ("node,ux_mm,uy_mm\n", vec!["expected rows of node,ux_mm,uy_mm, found none"]),
        ("node,ux_mm\n7,0\n", vec!["line 1: expected a column uy_mm", "node,ux_mm"]),
        ("7,0,-1\n8,0,-1\n", vec!["line 1: expected a column node"]),
        ("node,ux_mm,uy_mm,uy_mm\n7,0,-1,2\n", vec!["line 1: expected the column uy_mm once, found it twice"]),
        ("node,ux_mm,uy_mm\n7,0,-1\n\n99,0,-1\n", vec!["line 4: node 99 does not exist", "1 to 25"]),
        ("node,ux_mm,uy_mm\n0,0,-1\n", vec!["line 2: node 0 does not exist"]),
        ("node,ux_mm,uy_mm\n7,0,-1\n8,0,-1\n7,0,-1\n", vec!["line 4: node 7 is listed twice"]),
        (
            "node,ux_mm,uy_mm\r\n7,0,-1\r\n8,left,-1\r\n",
            vec!["line 3: ux_mm: expected a finite number, found \"left\""],
        ),
        ("node,ux_mm,uy_mm\n7,0,NaN\n", vec!["line 2: uy_mm: expected a finite number, found \"NaN\""]),
        ("node,ux_mm,uy_mm\n7,-inf,0\n", vec!["line 2: ux_mm: expected a finite number"]),
        ("node,ux_mm,uy_mm\n7,1e999,0\n", vec!["line 2: ux_mm: expected a finite number"]),
        ("node,ux_mm,uy_mm\n7,,0\n", vec!["line 2: ux_mm: expected a finite number, found \"\""]),
        ("node,ux_mm,uy_mm\n7.0,0,0\n", vec!["line 2: node: expected the number of a node, found \"7.0\""]),
        ("node,ux_mm,uy_mm\n-7,0,0\n", vec!["line 2: node: expected the number of a node, found \"-7\""]),
        ("node,ux_mm,uy_mm\n7,\"0\n0\",0\n", vec!["line 2: ux_mm: expected a finite number, found \"0\\n0\""]),
        ("node,ux_mm,uy_mm\r\n7,0,-1\r\n8,0\r\n", vec!["line 3: expected 3 columns as in the header, found 2"]),
        ("node,ux_mm,uy_mm\n7,0,-1\n8,0,-1,5\n", vec!["line 3: expected 3 columns as in the header, found 4"]),
        ("node;ux_mm;u_mm\n7;0;-1\n", vec!["line 1: expected a column uy_mm", "node;ux_mm;u_mm"]),
        ("node,ux_mm,uy_mm\n7,0,\"-1\n8,0,-1\n", vec!["line 2: uy_mm: expected a finite number, found \"-1\\n8,0,-1"]),
    ] {
        let path = folder.put("measured.csv", text);
        let message = finray(&["sense", PAPER, "--displacements", &path, "--contact", "19"]).refused();
        assert_says(&message, &[&[path.as_str()], &expected[..]].concat());
    }
    let path = folder.put("measured.csv", b"node,ux_mm,uy_mm\n7,0,-1\n\xff,0,0\n");
    let message = finray(&["sense", PAPER, "--displacements", &path, "--contact", "19"]).refused();
    assert_says(&message, &[&path, "line 3: expected text in UTF-8"]);
    for path in [folder.path("missing.csv"), folder.path("")] {
        let message = finray(&["sense", PAPER, "--displacements", &path, "--contact", "19"]).refused();
        assert_says(&message, &[&path, "cannot be read"]);
    }
}

#[test]
fn more_unknowns_than_coordinates_are_refused() {
    let two_markers = "node,ux_mm,uy_mm\n7,0,-1\n8,0,-1\n";
    let five = ["--contact", "14", "16", "18", "20", "22"];
    let message = sense_text(two_markers, &five).refused();
    assert_says(&message, &["not identifiable", "too few measured coordinates (4)", "unknowns (5)"]);
    let message = sense_text("node,ux_mm,uy_mm\n1,0,0\n25,0,0\n", &["--contact", "19"]).refused();
    assert_says(&message, &["too few measured coordinates (0)", "unknowns (1)"]);
}

/// The direction of a measured force follows from its components and the rotations of base and plate. Users once computed it by hand with an
/// arctangent.
#[test]
fn a_measured_force_has_its_direction_in_the_frame_of_the_base() {
    let folder = Folder::new();
    let shape = Csv::of(&paper_shape(&[(19, 2.0, 12.0)], &["--mesh-nodes", "200"]).computed());
    let (node, ux, uy) = (shape.texts("node"), shape.texts("ux_mm"), shape.texts("uy_mm"));
    let [x, y] = paper_force(2.0, 12.0);
    let mut located = "image,node,ux_mm,uy_mm,base_x_mm,base_y_mm,base_deg\n".to_owned();
    let mut forces = "image,fx_n,fy_n,object\n".to_owned();
    for (image, base_deg) in [("a.png", 0.0_f64), ("b.png", -25.0), ("c.png", 3.0)] {
        let row = |i: usize| format!("{image},{},{},{},4.0,-2.0,{base_deg}\n", node[i], ux[i], uy[i]);
        located.extend((0..node.len()).map(row));
        if image != "c.png" {
            let (sin, cos) = (y.atan2(x) + base_deg.to_radians()).sin_cos();
            forces += &format!("{image},{},{},disc\n", 2.0 * cos, 2.0 * sin);
        }
    }
    let (located, forces) = (folder.put("located.csv", located), folder.put("forces.csv", forces));
    let sense = |contact: &str, options: &[&str]| {
        let asked = ["sense", PAPER, "--displacements", &located, "--noise-mm", "0.01", "--contact", contact];
        finray(&[&asked[..], options].concat())
    };
    let with_forces = ["--forces", &forces, "--all-images"];
    let sensed = Csv::of(&sense("19@measured", &with_forces).computed());
    assert_eq!(sensed.texts("image"), ["a.png", "b.png", "c.png"]);
    let number = |column: &str, i: usize| -> f64 { sensed.texts(column)[i].parse().expect("a number") };
    for i in 0..2 {
        assert!((number("angle_deg", i) - 12.0).abs() < 1e-9, "{}", number("angle_deg", i));
        assert!((number("force_n", i) / 2.0 - 1.0).abs() < 2e-3, "{}", number("force_n", i));
    }
    // An image whose force was not measured is refused, both alone and among other images.
    assert_says(sensed.texts("refused")[2], &["measured", "force of the image"]);
    assert!(sensed.texts("force_n")[2].is_empty());
    let alone = |image: &str| sense("19@measured", &["--forces", &forces, "--image-name", image]);
    assert_eq!(Csv::of(&alone("b.png").computed()).texts("force_n")[0], sensed.texts("force_n")[1]);
    assert_says(&alone("c.png").refused(), &["measured", "force of the image"]);
    // `sense` refuses `@measured` without a measured force, a measured force without `@measured`, and one measured force for two contacts.
    assert_says(&sense("19@measured", &["--all-images"]).refused(), &["measured", "force of the image"]);
    assert_says(
        &sense("19@12", &with_forces).refused(),
        &["--forces: expected a contact with the direction `measured`"],
    );
    let two = sense("19@measured", &[&with_forces[..], &["--contact", "16@5"]].concat());
    assert_says(&two.refused(), &["expected one contact"]);
    let nameless = folder.put("nameless.csv", "image,fx_n,fy_n,object\na.png,0,-1,\n");
    let refused = sense("19@measured", &["--forces", &nameless, "--all-images"]).refused();
    assert_says(&refused, &["nameless.csv", "line 2", "object"]);
}
