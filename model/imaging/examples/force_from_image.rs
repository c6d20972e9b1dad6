//! From an image file to a force: which force bends the finger in this image?
//!
//! `cargo run --release -p finray-imaging --example force_from_image` reads `fixtures/pictures/camera.png`, which `finray render` made from
//! `fixtures/scenes/camera.toml` with a force of 2 N at 80 mm. To use another scene and image, give both paths after `--`.

use finray_imaging::locate::Observer;
use finray_model::Scene;
use finray_model::sensing::{ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let file = |i: usize, shipped: &str| arguments.get(i).cloned().unwrap_or_else(|| format!("{fixtures}/{shipped}"));

    // The scene describes the finger, its camera and its markers. The observation contains the markers that the image shows.
    let scene = Scene::from_toml(&std::fs::read_to_string(file(0, "scenes/camera.toml"))?)?;
    let image = image::open(file(1, "pictures/camera.png"))?.to_rgb8();
    let seen = Observer::new(&scene, None)?.observe(&image)?;

    // The force, its direction and its position are unknown.
    let question = ContactQuestion::new(None, Direction::Auto);
    let sensor = Sensor::new(scene, SensorContacts::Asked(vec![question]), SensorOptions::default())?;
    let sensed = sensor.sense(&seen)?;
    for force in &sensed.forces {
        println!("{:.3} N at {}, 95 % interval {:.3?} N", force.force_n, force.contact, force.interval_n());
    }
    sensed.warnings.iter().for_each(|warning| println!("warning: {warning}"));
    Ok(())
}
