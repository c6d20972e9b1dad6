//! Radii of the markers and of the references on the base, measured in images.

use super::disc::median;
use finray_model::Scene;
use finray_model::scene::{Base, Markers};
use std::fmt;

/// Relative difference between measured and stated radius up to which the radii count as equal. The tolerance allows for sharpened or slanted rims,
/// and for a camera distance that is only nominal.
const SAME_RADIUS: f64 = 0.05;

/// Radii measured in an image, mm.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeenRadii {
    /// Median radius of the markers, mm; `None` if no radius was measured.
    pub markers_mm: Option<f64>,
    /// Radius of each reference on the base, mm; `None` for a reference that was not found.
    pub references_mm: Vec<Option<f64>>,
}

/// Radius in a scene that differs from the measured radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OtherRadius {
    /// Index of the reference mark on the base; `None` for the markers.
    pub reference: Option<usize>,
    /// Radius that the scene states, mm.
    pub stated_mm: f64,
    /// Measured radius, mm: the median over the images.
    pub shown_mm: f64,
}

impl OtherRadius {
    /// Radii of a scene's markers and base that differ from the measured radii by more than 5 %.
    pub fn of(markers: &Markers, base: Option<&Base>, images: &[&SeenRadii]) -> Vec<OtherRadius> {
        let references = base.into_iter().flat_map(|base| &base.references);
        let stated = std::iter::once((None, markers.radius_mm));
        let stated = stated.chain(references.enumerate().map(|(i, mark)| (Some(i), mark.markers.radius_mm)));
        let other = |(reference, stated_mm): (Option<usize>, f64)| {
            let of_image = |seen: &&SeenRadii| match reference {
                None => seen.markers_mm,
                Some(i) => seen.references_mm.get(i).copied().flatten(),
            };
            let shown_mm = median(images.iter().filter_map(of_image))?;
            let is_other = (shown_mm / stated_mm - 1.0).abs() > SAME_RADIUS;
            is_other.then_some(OtherRadius { reference, stated_mm, shown_mm })
        };
        stated.filter_map(other).collect()
    }

    /// Replaces the radius in a scene by the measured radius.
    pub fn correct(&self, scene: &mut Scene) {
        let marks = match self.reference {
            None => scene.markers.as_mut(),
            Some(i) => scene.base.as_mut().and_then(|base| base.references.get_mut(i)).map(|mark| &mut mark.markers),
        };
        if let Some(marks) = marks {
            marks.radius_mm = self.shown_mm;
        }
    }
}

impl fmt::Display for OtherRadius {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reference {
            None => write!(f, "markers.radius_mm = {}", self.stated_mm)?,
            Some(i) => write!(f, "base.reference[{}].radius_mm = {}", i + 1, self.stated_mm)?,
        }
        write!(f, ": the images show a radius of {:.2} mm (median)", self.shown_mm)
    }
}
