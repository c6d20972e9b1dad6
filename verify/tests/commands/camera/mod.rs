//! `finray render`, `finray locate` and `finray lens`: from shapes to images, and back to displacements, forces and the lens.

mod files;
mod hinges;
mod lens;
mod locate;
mod names;
mod render;

use crate::kit::*;
use image::{DynamicImage, ImageFormat, RgbImage};
use std::io::Cursor;

/// Scene of the paper's finger with markers and a camera.
const CAMERA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/scenes/camera.toml");
/// Limit of the error of a coordinate, mm, in rendered images with a noise of two grey levels and a blur of 0.8 px.
const LARGEST_MM: f64 = 0.015;

/// Option with which `solve` computes the shape that `render` draws.
const FINE: [&str; 2] = ["--mesh-nodes", "1000"];

/// Renders an image of the paper's finger under a force. Also returns the shape that `solve` computes for this force.
fn image_of(folder: &Folder, name: &str, load_at: &str, options: &[&str]) -> (String, Csv) {
    let shape = Csv::of(&finray(&["solve", CAMERA, "--load-at", load_at, FINE[0], FINE[1]]).done());
    let path = folder.path(name);
    let disturbed = ["--grey-noise", "2", "--blur-px", "0.8"];
    finray(&[&["render", CAMERA, "--load-at", load_at, "--out", &path], &disturbed[..], options].concat()).done();
    (path, shape)
}

/// Compares every located node of an image with the shape.
fn assert_located(located: &Csv, image: &str, shape: &Csv) {
    let (nodes, all) = (located.texts("node"), shape.texts("node"));
    for (i, node) in nodes.iter().enumerate().filter(|(i, _)| located.texts("image")[*i] == image) {
        let of = all.iter().position(|other| other == node).expect("a key node");
        for column in ["ux_mm", "uy_mm"] {
            let error = located.numbers(column)[i] - shape.numbers(column)[of];
            assert!(error.abs() < LARGEST_MM, "{image} node {node} {column}: {error}");
        }
    }
}

/// The bytes of an image file.
fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), format).expect("an image in memory");
    bytes
}
