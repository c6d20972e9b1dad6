//! `finray calibrate --weight`: photographs of the finger from which known weights hang.

use super::Arguments;
use crate::commands::locate::Images;
use crate::commands::prelude::*;
use finray_files::observations::RefusedImage;
use finray_model::Vector;
use finray_model::calibration::LocatedView;
use finray_model::camera::Pixel;
use finray_model::finger::Plate;
use finray_model::sensing::{ContactQuestion, Direction};
use finray_model::sensor::{Sensor, SensorContacts, SensorOptions};
use finray_model::text::finite;

/// Standard acceleration of gravity, m/s^2 (3rd General Conference on Weights and Measures, 1901).
const GRAVITY_M_S2: f64 = 9.80665;
/// Standard deviation of the stated position of a string, mm: a string is a millimetre thick, and a ruler is read to half a millimetre.
const STRING_SD_MM: f64 = 1.0;
/// Standard deviation of the stated direction of gravity, degrees.
const GRAVITY_SD_DEG: f64 = 1.0;
/// A string differs from what is stated if the markers show it farther away than this many standard deviations.
const ELSEWHERE: f64 = 3.0;
/// Least distance between the two pixels of a plumb line, px. An error of one pixel then turns gravity by up to one degree.
const LEAST_PLUMB_PX: f64 = 60.0;

/// Units of a weight, and the weight of one unit, N.
const UNITS: [(&str, f64); 3] = [("kg", GRAVITY_M_S2), ("g", 1e-3 * GRAVITY_M_S2), ("N", 1.0)];

/// Parses the weight of a hung mass, N, from `0.2kg`, `200g` or `1.96N`.
pub fn weight(text: &str) -> Result<f64, String> {
    let of_unit = |(unit, newtons): &(&str, f64)| Some((text.strip_suffix(unit)?.trim_end(), *newtons));
    let (number, newtons) = UNITS.iter().find_map(of_unit).ok_or_else(|| {
        format!("expected a mass or force with its unit (kg, g or N), such as 0.2kg, found \"{text}\"")
    })?;
    positive(number).map(|number| number * newtons)
}

/// Two pixels of a plumb line, the upper one first.
#[derive(Debug, Clone, Copy)]
pub struct Plumb([Pixel; 2]);

/// Parses `U1,V1,U2,V2`.
pub fn plumb(text: &str) -> Result<Plumb, String> {
    let numbers = text.split(',').map(|number| finite(number.trim())).collect::<Result<Vec<_>, _>>()?;
    let [u, v, lower_u, lower_v] = numbers[..] else {
        return Err(format!("expected U1,V1,U2,V2, two pixels of a plumb line, the upper one first, found \"{text}\""));
    };
    let ends = [Pixel::new(u, v), Pixel::new(lower_u, lower_v)];
    match (ends[1] - ends[0]).norm() {
        apart if apart < LEAST_PLUMB_PX => {
            Err(format!("expected two pixels at least {LEAST_PLUMB_PX} px apart, found a distance of {apart:.0} px"))
        }
        _ => Ok(Plumb(ends)),
    }
}

/// Direction of gravity, a unit vector.
enum Gravity {
    /// In the finger frame.
    OfFinger(Vector),
    /// In the frame of the camera's pose.
    OfPose(Vector),
}

impl Gravity {
    fn of(arguments: &Arguments, scene: &Scene) -> Result<Gravity, Failure> {
        let Some(Plumb(ends)) = &arguments.plumb else {
            let angle_deg = arguments.gravity_deg.ok_or_else(|| {
                bad_input(
                    "the direction of gravity is unknown: expected --plumb U1,V1,U2,V2 (two pixels of a plumb line or of the string, the upper one \
                     first), or --gravity-deg A (degrees from the front plate's inward normal, positive towards the tip)",
                )
            })?;
            return Ok(Gravity::OfFinger(scene.finger.direction(angle_deg)));
        };
        let (camera, markers) = camera_and_markers(&arguments.scene, scene)?;
        let on_plane = |pixel: &Pixel| {
            camera.on_plane(pixel, markers.height_mm).map_err(|error| bad_input(format!("--plumb: {error}")))
        };
        Ok(Gravity::OfPose((on_plane(&ends[1])? - on_plane(&ends[0])?).normalize()))
    }
}

/// Locates the finger in the photographs, and adds the weight that hangs in each.
pub fn views(arguments: &Arguments, scene: &Scene) -> Result<Vec<LocatedView>, Failure> {
    let Arguments { weight: weights_n, image, rest, weight_at, .. } = arguments;
    let count_of = |option: &str, found: usize| match image.len() {
        expected if found == expected || found == 1 => Ok(()),
        expected => {
            Err(bad_input(format!("{option}: expected one value, or one for each of {expected} images, found {found}")))
        }
    };
    count_of("--weight", weights_n.len())?;
    let length_mm = scene.finger.plate_length_mm(Plate::Front);
    if !weight_at.is_empty() {
        count_of("--weight-at", weight_at.len())?;
    }
    if let Some(beyond) = weight_at.iter().find(|at_mm| **at_mm > length_mm) {
        return Err(bad_input(format!(
            "--weight-at: expected a position on the front plate, at most {length_mm} mm, found {beyond}"
        )));
    }
    let gravity = Gravity::of(arguments, scene)?;
    let images = Images { scene: &arguments.scene, images: image, rest: rest.as_deref() };
    let mut views = Vec::new();
    for (i, seen) in images.located(scene)?.into_iter().enumerate() {
        let seen = match seen {
            // With an image of the unloaded finger, markers count as centred on their nodes.
            Ok(seen) if rest.is_some() => seen.on_nodes(&scene.finger),
            Ok(seen) => seen,
            // `located` has printed the reason.
            Err(RefusedImage { .. }) => continue,
        };
        let of_image = |values: &[f64]| values.get(i).or(values.first()).copied();
        let weight_n = of_image(weights_n).unwrap_or_default();
        let in_pose = match gravity {
            Gravity::OfPose(down) => Some(down * weight_n),
            Gravity::OfFinger(_) => None,
        };
        let mut view = LocatedView::new(seen, scene, in_pose).map_err(bad_input)?;
        if let Gravity::OfFinger(down) = gravity {
            view.view.force = Some(down * weight_n);
        }
        view.view.position = of_image(weight_at).map(|at_mm| [at_mm, STRING_SD_MM]);
        views.push(view);
    }
    Ok(views)
}

/// Warns of strings that hang elsewhere, or pull in another direction, than stated. Position and direction are estimated from the markers alone; they do
/// not depend on the modulus.
pub fn warn_of_strings(scene: &Scene, seen: &[LocatedView]) {
    let asked = SensorContacts::Asked(vec![ContactQuestion::new(None, Direction::Auto)]);
    let Ok(sensor) = Sensor::new(scene.clone(), asked, SensorOptions::default()) else { return };
    for LocatedView { view, observation, .. } in seen {
        let Ok(sensed) = sensor.sense(observation) else { continue };
        let [force] = &sensed.forces[..] else { continue };
        let (finger, name) = (&scene.finger, &view.name);
        let found_mm = force.contact.position_mm(finger).zip(force.uncertainty.position_sd_mm);
        if let (Some([stated_mm, sd_mm]), Some((s_mm, s_sd_mm))) = (view.position, found_mm)
            && (s_mm - stated_mm).abs() > ELSEWHERE * sd_mm.hypot(s_sd_mm)
        {
            print_message(format_args!(
                "warning: {name}: the markers show the weight at {s_mm:.1} +- {s_sd_mm:.1} mm instead of {stated_mm} mm: check --weight-at"
            ));
        }
        if let (Some(weight), Some(sd_deg)) = (view.force, force.uncertainty.direction_sd_deg) {
            let stated_deg = finger.angle_deg(weight);
            let off_deg = (force.contact.angle_deg - stated_deg + 180.0).rem_euclid(360.0) - 180.0;
            if off_deg.abs() > ELSEWHERE * sd_deg.hypot(GRAVITY_SD_DEG) {
                print_message(format_args!(
                    "warning: {name}: the markers show that the weight pulls at {:.1} +- {sd_deg:.1} degrees from the front plate's normal instead of \
                     {stated_deg:.1}: check --plumb or --gravity-deg",
                    force.contact.angle_deg
                ));
            }
        }
    }
}
