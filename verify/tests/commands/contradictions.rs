//! `calibrate` refuses measurements that contradict the images (by a wrong name, sign, unit or row) before it writes anything, or warns of them.

use crate::kit::*;
use crate::photographs::{PRESSES, force, images, scene};
use rayon::prelude::*;
use std::fmt::Write;

/// Mass in grams whose weight is 1 N.
const GRAMS_A_NEWTON: f64 = 101.97;

/// The table of the located images and the measured forces; each case changes them.
struct Located {
    folder: Folder,
    scene: String,
    rows: String,
    forces: Vec<[f64; 2]>,
}

impl Located {
    fn new() -> Located {
        let folder = Folder::new();
        let (scene, images) = (scene(&folder), images(&folder));
        let images: Vec<&str> = images.iter().map(String::as_str).collect();
        let rows = finray(&[&["locate", &scene, "--image"], &images[..]].concat()).done();
        let forces = PRESSES.map(|([_, force_n, angle], [.., deg])| force([force_n, angle], deg)).to_vec();
        Located { folder, scene, rows, forces }
    }

    /// The rows of the table, with two node names exchanged in one image.
    fn renamed(&self, image: &str, [one, other]: [&str; 2]) -> String {
        let renamed = |line: &str| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if cells[0] == image {
                let name = cells[1];
                cells[1] = if name == one { other } else { name };
                cells[1] = if name == other { one } else { cells[1] };
            }
            cells.join(",") + "\n"
        };
        // `calibrate` computes displacements from the positions of the markers, so it is enough to exchange the node names.
        self.rows.lines().map(renamed).collect()
    }

    /// Calibrates with these rows and forces. The names of the run's files begin with `name`.
    fn calibrated(&self, name: &str, rows: &str, forces: &[[f64; 2]]) -> Answer {
        let mut text = "image,fx_n,fy_n\n".to_owned();
        for (i, [fx, fy]) in forces.iter().enumerate() {
            writeln!(text, "press{i}.png,{fx},{fy}").expect("memory");
        }
        let rows = self.folder.put(&format!("{name}-located.csv"), rows);
        let forces = self.folder.put(&format!("{name}-forces.csv"), text);
        let (out, calibrated) = (self.folder.path(&format!("{name}.csv")), self.folder.path(&format!("{name}.toml")));
        let of_images =
            ["calibrate", &self.scene, "--located", &rows, "--forces", &forces, "--calibrated", &calibrated];
        let answer = finray(&[&of_images[..], &["--fit", "modulus,bracket", "--out", &out]].concat());
        let written = [&out, &calibrated].map(|path| std::path::Path::new(path).exists());
        assert_eq!(written, [answer.code == Some(0); 2], "{name}: {}", answer.err);
        answer
    }
}

#[test]
fn measurements_that_contradict_their_images_are_refused_by_name() {
    let located = Located::new();
    let with = |change: &dyn Fn(&mut Vec<[f64; 2]>)| {
        let mut forces = located.forces.clone();
        change(&mut forces);
        forces
    };
    let rows = |image: &str, names: [&str; 2]| located.renamed(image, names);
    let scaled = |times: f64| move |force: &mut [f64; 2]| *force = force.map(|part| times * part);
    let as_measured = located.forces.clone();
    let names = ["press1.png: the marker of node", "near to node", "check the node numbers"];
    let force =
        ["the measured force is", "times the force that the markers show", "check its sign, unit, frame and row"];
    // For each case: its name, the changed rows, the forces, and the expected parts of the message.
    let cases = vec![
        ("front", rows("press1.png", ["7", "8"]), as_measured.clone(), names.to_vec()),
        ("back", rows("press1.png", ["3", "4"]), as_measured.clone(), names.to_vec()),
        ("across", rows("press1.png", ["5", "7"]), as_measured.clone(), names.to_vec()),
        (
            "sign",
            located.rows.clone(),
            with(&|forces| scaled(-1.0)(&mut forces[2])),
            [&["press2.png: ", "force is -"], &force[..]].concat(),
        ),
        (
            "grams",
            located.rows.clone(),
            with(&|forces| scaled(GRAMS_A_NEWTON)(&mut forces[1])),
            [&["press1.png: "], &force[..]].concat(),
        ),
        (
            "all-grams",
            located.rows.clone(),
            with(&|forces| forces.iter_mut().for_each(scaled(GRAMS_A_NEWTON))),
            vec!["the median ratio of measured forces to the forces that the markers show is", "unit (N)"],
        ),
        (
            "all-signs",
            located.rows.clone(),
            with(&|forces| forces.iter_mut().for_each(scaled(-1.0))),
            vec!["the median ratio of measured forces to the forces that the markers show is -", "sign"],
        ),
        ("exchanged", located.rows.clone(), with(&|forces| forces.swap(0, 2)), [&["press"], &force[..]].concat()),
    ];
    cases.into_par_iter().for_each(|(name, rows, forces, said)| {
        let message = located.calibrated(name, &rows, &forces).refused();
        println!("{name}: {message}");
        assert_says(&message, &said);
    });
}

/// Exchanged rows of nearly equal forces, and a marker with an error of 1 mm, cause warnings; correct input causes none.
#[test]
fn what_stands_out_is_said() {
    let located = Located::new();
    let silent = located.calibrated("silent", &located.rows, &located.forces);
    assert!(!silent.err.contains("warning"), "{}", silent.err);
    let mut forces = located.forces.clone();
    forces.swap(1, 3);
    let warnings = warnings_of(located.calibrated("alike", &located.rows, &forces));
    println!("{warnings:?}");
    for image in ["press1.png", "press3.png"] {
        let of_image = warnings.iter().find(|warning| warning.contains(image)).expect("a warning");
        assert_says(
            of_image,
            &["the ratio of the measured force to the force that the markers show is", "check unit, frame and row"],
        );
    }
    // Adds 1 mm to the position and to the displacement in the row of one marker.
    let moved = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if cells[0] == "press2.png" && cells[1] == "8" {
            for cell in [4, 6] {
                cells[cell] = (cells[cell].parse::<f64>().expect("a number") + 1.0).to_string();
            }
        }
        cells.join(",") + "\n"
    };
    let rows: String = located.rows.lines().map(moved).collect();
    let warnings = warnings_of(located.calibrated("moved", &rows, &located.forces));
    println!("{warnings:?}");
    let of_marker = warnings.iter().find(|warning| warning.contains("marker")).expect("a warning");
    assert_says(of_marker, &["press2.png", "node 8"]);
}

/// Warnings of a successful run, without its notes.
fn warnings_of(answer: Answer) -> Vec<String> {
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    answer.err.lines().filter(|line| line.starts_with("warning: ")).map(str::to_owned).collect()
}
