//! What an image of the unloaded finger shows of its coloured dots: place, size, colour, light and sharpness.

use super::{Located, NodeId, ObserverError, Rest, Vector};
use finray_model::camera::Pixel;
use finray_model::finger::Plate;
use finray_model::scene::{MarkerLook, Rgb};
use finray_model::{Finger, Scene};
use image::RgbImage;

/// Share of a dot's radius within which its colour is measured: blur and compression mix the rest with the background.
const INSIDE: f64 = 0.5;
/// Distances from a dot's centre, in radii, between which the background is measured.
const AROUND: [f64; 2] = [1.5, 2.0];
/// A channel at this grey level or above is clipped.
const CLIPPED: u8 = 254;
/// A dot is weak if its standard deviation exceeds the median of all dots by this factor.
const WEAK: f64 = 3.0;

/// Colour of the dots of a plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DotColour {
    /// Mean colour, 0 to 255.
    pub rgb: Rgb,
    /// Standard deviation of a channel between the dots, largest of the three channels, grey levels.
    pub sd: f64,
    /// Distance between the colours of the dots and of the background about them, grey levels.
    pub contrast: f64,
    /// Share of the dots' pixels with a clipped channel, 0..1.
    pub clipped: f64,
}

/// A dot that was not found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissingDot {
    /// Its node.
    pub node: NodeId,
    /// Whether a patch of the other plate's colour is in its place.
    pub is_swapped: bool,
}

/// The dots of the unloaded finger in an image.
#[derive(Debug, Clone)]
pub struct Survey {
    /// Pose, markers, size and blur.
    pub rest: Rest,
    /// Standard deviation of the median radius, mm.
    pub radius_sd_mm: f64,
    /// Median radius of the dots in the image, px.
    pub radius_px: f64,
    /// Colours of the dots on the front and the back plate; `None` if no dot of the plate is found.
    pub colours: [Option<DotColour>; 2],
    /// Dots that were not found.
    pub missing: Vec<MissingDot>,
    /// Dots that are far less certain than the others.
    pub weak: Vec<NodeId>,
}

impl Survey {
    /// Finds the unloaded finger of a scene in an image and measures its dots. The scene states no pose, or an approximate one.
    ///
    /// # Errors
    /// [`ObserverError`] for a scene without camera or coloured markers, or for an image that does not show the unloaded finger.
    pub fn of(scene: &Scene, image: &RgbImage) -> Result<Survey, ObserverError> {
        let description = scene.camera.ok_or(ObserverError::NoCamera)?;
        let markers = scene.markers.ok_or(ObserverError::NoMarkers)?;
        let finger = &scene.finger;
        let rest = Rest::of((finger, &[]), &description.lens, description.pose, &markers, image)?;
        let sds = || rest.located.iter().map(|marker| marker.sd_mm);
        let median_mm = super::disc::median(sds()).unwrap_or_default();
        let mm_a_px = rest.camera.position_sd_mm(&middle(&rest.located), markers.height_mm, 1.0);
        let radius_px = rest.radius_mm / mm_a_px.unwrap_or(f64::NAN);
        let looks = looks(&rest.located, image, radius_px);
        let on_front = finger.plate_nodes(Plate::Front);
        let colours = [true, false].map(|front| DotColour::of(&looks, |node| on_front.contains(&node) == front));
        let is_found = |node: NodeId| rest.located.iter().any(|marker| marker.node == node);
        let missing = marked(finger).filter(|node| !is_found(*node)).map(|node| {
            let at = rest.camera.project(&finger.marker_position(node).push(markers.height_mm)).ok();
            let seen = at.and_then(|at| Look::at(image, &at, radius_px));
            let is_swapped = seen.is_some_and(|look| is_of_other_plate(&look, markers.look, on_front.contains(&node)));
            MissingDot { node, is_swapped }
        });
        let weak = rest.located.iter().filter(|marker| marker.sd_mm > WEAK * median_mm).map(|marker| marker.node);
        Ok(Survey {
            radius_sd_mm: median_mm / (rest.located.len() as f64).sqrt(),
            radius_px,
            colours,
            missing: missing.collect(),
            weak: weak.collect(),
            rest,
        })
    }
}

fn marked(finger: &Finger) -> impl Iterator<Item = NodeId> + '_ {
    (1..=finger.key_node_count()).map(NodeId).filter(|node| finger.has_marker(*node))
}

fn middle(located: &[Located]) -> Pixel {
    located.iter().map(|marker| marker.pixel).sum::<Pixel>() / located.len().max(1) as f64
}

/// Whether the colour at a node is closer to that of the other plate's markers than to the background.
fn is_of_other_plate(look: &Look, of_markers: MarkerLook, is_on_front: bool) -> bool {
    let MarkerLook::Coloured { front_rgb, back_rgb } = of_markers else { return false };
    let [own, other] = if is_on_front { [front_rgb, back_rgb] } else { [back_rgb, front_rgb] };
    let from = |rgb: Rgb| distance(look.inside, rgb.map(f64::from));
    from(other) < from(own) && from(other) < distance(look.inside, look.around)
}

fn distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Light inside and about a dot, grey levels.
struct Look {
    inside: [f64; 3],
    around: [f64; 3],
    clipped: f64,
}

fn looks(located: &[Located], image: &RgbImage, radius_px: f64) -> Vec<(NodeId, Look)> {
    located.iter().filter_map(|marker| Some((marker.node, Look::at(image, &marker.pixel, radius_px)?))).collect()
}

impl Look {
    /// The light at a pixel; `None` if the image shows no dot of this radius there.
    fn at(image: &RgbImage, at: &Pixel, radius_px: f64) -> Option<Look> {
        let reach = (AROUND[1] * radius_px).ceil();
        let (mut sums, mut counts, mut clipped) = ([[0.0; 3]; 2], [0.0; 2], 0.0);
        let (columns, rows) = (span(at.x, reach), span(at.y, reach));
        for (u, v) in rows.flat_map(|v| columns.clone().map(move |u| (u, v))) {
            let away = (Vector::new(u as f64, v as f64) - at).norm() / radius_px;
            let place = match away {
                _ if away < INSIDE => 0,
                _ if (AROUND[0]..AROUND[1]).contains(&away) => 1,
                _ => continue,
            };
            let (u, v) = (u32::try_from(u).ok()?, u32::try_from(v).ok()?);
            let pixel = image.get_pixel_checked(u, v)?.0;
            sums[place].iter_mut().zip(pixel).for_each(|(sum, light)| *sum += f64::from(light));
            counts[place] += 1.0;
            clipped += f64::from(u8::from(place == 0 && pixel.iter().any(|light| *light >= CLIPPED)));
        }
        let [inside, around] = [0, 1].map(|place| sums[place].map(|sum: f64| sum / counts[place]));
        (counts[0] > 0.0 && counts[1] > 0.0).then(|| Look { inside, around, clipped: clipped / counts[0] })
    }
}

/// The pixels within `reach` of a coordinate, px.
fn span(at: f64, reach: f64) -> std::ops::RangeInclusive<i64> {
    (at - reach).floor() as i64..=(at + reach).ceil() as i64
}

impl DotColour {
    /// The colour of the dots whose nodes are `chosen`.
    fn of(looks: &[(NodeId, Look)], chosen: impl Fn(NodeId) -> bool) -> Option<DotColour> {
        let of: Vec<&Look> = looks.iter().filter(|(node, _)| chosen(*node)).map(|(_, look)| look).collect();
        let count = of.len() as f64;
        let mean = |value: &dyn Fn(&Look) -> f64| of.iter().map(|look| value(look)).sum::<f64>() / count;
        let rgb = [0, 1, 2].map(|k| mean(&|look| look.inside[k]));
        let variance =
            |k: usize| of.iter().map(|look| (look.inside[k] - rgb[k]).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        (count > 0.0).then(|| DotColour {
            rgb: rgb.map(|light| light.round() as u8),
            sd: (0..3).map(variance).fold(0.0, f64::max).sqrt(),
            contrast: mean(&|look| distance(look.inside, look.around)),
            clipped: mean(&|look| look.clipped),
        })
    }
}
