//! Classification of pixels by the markers' colours, independent of their brightness.

use finray_model::finger::Plate;
use finray_model::scene::Rgb;

/// A marker's colour must differ from grey by at least this angle in RGB space, degrees. With a smaller angle, brightness alone would decide whether a pixel
/// belongs to a marker.
const LEAST_SATURATION_DEG: f64 = 8.0;
/// Two colours count as equal if the angle between them in RGB space is below this, degrees.
const ALIKE_DEG: f64 = 6.0;
/// Half angle of a colour's cone, as a share of a reference angle. The reference angle is the colour's angle to grey or to the other marker's colour,
/// whichever is smaller.
const SHARE: f64 = 0.5;
/// Range of a marker's brightness relative to the colour that the scene states.
const LIGHT: [f64; 2] = [0.2, 1.5];

/// Error for a marker colour that cannot be distinguished from grey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "markers.{key}: expected a colour that is not a shade of grey, found {colour:?}: light and shadow would look like markers"
)]
pub struct GreyMarker {
    /// Key of the scene's `[markers]` table that states the colour.
    pub key: &'static str,
    /// The stated colour.
    pub colour: Rgb,
}

/// One colour as a cone in RGB space about the colour's direction. A change of brightness scales red, green and blue by the same factor, so the
/// colour stays in the cone.
#[derive(Debug, Clone, Copy)]
struct Cone {
    axis: [f32; 3],
    /// Squared cosine of the cone's half angle.
    cosine2: f32,
    /// Range of a pixel's projection onto the cone's axis, grey levels. A pixel whose projection is outside this range is too dark or too light to
    /// count as this colour.
    length: [f32; 2],
}

impl Cone {
    #[inline]
    fn holds(&self, pixel: &[u8; 3]) -> bool {
        let [r, g, b] = pixel.map(f32::from);
        let along = r * self.axis[0] + g * self.axis[1] + b * self.axis[2];
        along > self.length[0] && along < self.length[1] && along * along > self.cosine2 * (r * r + g * g + b * b)
    }
}

/// Classifier of marker pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Colours {
    front: Cone,
    /// Cone of the back plate's colour; `None` if both plates have the same colour.
    back: Option<Cone>,
}

impl Colours {
    pub fn new([front_rgb, back_rgb]: [Rgb; 2]) -> Result<Colours, GreyMarker> {
        let saturation = |key, colour: Rgb| {
            let angle = angle_deg(colour, [255; 3]);
            if angle < LEAST_SATURATION_DEG { Err(GreyMarker { key, colour }) } else { Ok(angle) }
        };
        let front = saturation("front_rgb", front_rgb)?;
        let back = saturation("back_rgb", back_rgb)?;
        let apart = angle_deg(front_rgb, back_rgb);
        let cone = |colour: Rgb, widest: f64| {
            let length = colour.map(f64::from).iter().map(|part| part * part).sum::<f64>().sqrt();
            Cone {
                axis: colour.map(|part| (f64::from(part) / length) as f32),
                cosine2: (SHARE * widest).to_radians().cos().powi(2) as f32,
                length: LIGHT.map(|light| (light * length) as f32),
            }
        };
        if apart < ALIKE_DEG {
            return Ok(Colours { front: cone(front_rgb, front.min(back)), back: None });
        }
        Ok(Colours { front: cone(front_rgb, front.min(apart)), back: Some(cone(back_rgb, back.min(apart))) })
    }

    /// Whether both plates have the same colour.
    pub fn are_alike(&self) -> bool {
        self.back.is_none()
    }

    /// The plate whose marker colour a pixel has; `None` for any other colour. If both plates have the same colour, the result is the front plate.
    #[inline]
    pub fn side_of(&self, pixel: &[u8; 3]) -> Option<Plate> {
        if self.front.holds(pixel) {
            return Some(Plate::Front);
        }
        self.back.filter(|cone| cone.holds(pixel)).map(|_| Plate::Back)
    }
}

fn angle_deg(first: Rgb, second: Rgb) -> f64 {
    let [a, b] = [first, second].map(|colour| nalgebra::Vector3::from(colour.map(f64::from)));
    if a.norm() == 0.0 || b.norm() == 0.0 { 0.0 } else { a.angle(&b).to_degrees() }
}
