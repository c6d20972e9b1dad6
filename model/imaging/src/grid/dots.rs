//! Centres and radii of the dots of a lattice, from the light of the pixels about each dot.
//!
//! A pixel's light is assigned to the dot whose rim is nearest. If the blurred edges of two close dots overlap, a dot gains as much light from its
//! neighbour's edge as it loses from its own edge. Pixels away from all dots show the background.

use super::patches::Dot;
use finray_model::camera::Pixel;
use image::GrayImage;
use nalgebra::{Matrix3, Vector3};

/// Distances beyond a dot's rim: up to the first distance, light belongs to the dot; from there to the second distance, pixels may show the
/// background. Each is a multiple of the dot's radius plus a length in px. The first pair is for isolated dots; the other pairs are for dots that lie
/// close together.
const ABOUT: [[(f64, f64); 2]; 3] = [[(0.15, 2.5), (0.35, 4.5)], [(0.0, 2.0), (0.5, 6.0)], [(0.0, 1.0), (1.0, 8.0)]];
/// A dot is measured only if at least this number of pixels shows the background.
const LEAST_GROUND: usize = 24;
/// Radius of the inner part of a dot, as a share of the dot's radius; the light is even in this part.
const INNER: f64 = 0.6;
/// A dot is rejected if the centre of its light is farther than this from the centre of its patch, as a share of the dot's radius.
const LARGEST_SHIFT: f64 = 0.5;
/// A dot is rejected if the area of its light, divided by the area of its patch, is outside this range.
const AREAS: std::ops::Range<f64> = 0.5..2.0;

/// Centre of a dot's light (px), and radius of a disc of equal area (px). `None` if the dot's surroundings are outside the image or hidden by other dots.
pub(super) fn measured(grey: &GrayImage, dot: &Dot, others: &[Dot]) -> Option<(Pixel, f64)> {
    ABOUT.iter().find_map(|[own, ground]| {
        let px = |(radii, px): (f64, f64)| radii * dot.radius_px + px;
        light_of(grey, dot, others, [px(*own), px(*ground)])
    })
}

/// Same as [`measured`], for given extents: the dot's light reaches `own` px beyond the rim, and the background used lies `own` to `reach` px beyond
/// the rim.
fn light_of(grey: &GrayImage, dot: &Dot, others: &[Dot], [own, reach]: [f64; 2]) -> Option<(Pixel, f64)> {
    let half = dot.longer_px() + reach;
    let middle = dot.pixel;
    let (width, height) = (f64::from(grey.width()) - 1.0, f64::from(grey.height()) - 1.0);
    // At the image border, part of a dot's surroundings is missing, which would bias the dot's centre.
    if middle.x < half || middle.y < half || middle.x > width - half || middle.y > height - half {
        return None;
    }
    let is_near = |other: &&Dot| {
        let apart = (other.pixel - middle).norm();
        apart > 0.0 && apart < half * std::f64::consts::SQRT_2 + other.longer_px() + own
    };
    let near: Vec<&Dot> = others.iter().filter(is_near).collect();
    let (mut normal, mut right, mut ground) = (Matrix3::zeros(), Vector3::zeros(), 0);
    let mut of_dot: Vec<(Pixel, f64)> = Vec::new();
    let range = |at: f64| (at - half).ceil() as u32..=(at + half).floor() as u32;
    for (u, v) in range(middle.y).flat_map(|v| range(middle.x).map(move |u| (u, v))) {
        let at = Pixel::new(f64::from(u), f64::from(v));
        let from_rim = dot.distance_px(&at);
        if from_rim >= reach {
            continue;
        }
        let light = f64::from(grey.get_pixel(u, v).0[0]);
        let from_others = near.iter().map(|other| other.distance_px(&at)).fold(f64::INFINITY, f64::min);
        if from_rim < own {
            if from_rim <= from_others {
                of_dot.push((at - middle, light));
            }
        } else if from_others >= own {
            let row = Vector3::new(1.0, at.x - middle.x, at.y - middle.y);
            normal += row * row.transpose();
            right += row * light;
            ground += 1;
        }
    }
    if ground < LEAST_GROUND {
        return None;
    }
    let plane = normal.cholesky()?.solve(&right);
    let (mut mass, mut moment) = (0.0, Pixel::zeros());
    let (mut inner, mut depth) = (0.0, 0.0);
    for (step, light) in of_dot {
        // Light is measured relative to the local background, because uneven light would otherwise shift the centre to the darker side.
        let ground = plane.dot(&Vector3::new(1.0, step.x, step.y));
        let lacking = light / ground.max(1.0) - 1.0;
        mass += lacking;
        moment += step * lacking;
        if (dot.upright * step).norm() < INNER * dot.radius_px {
            inner += 1.0;
            depth += lacking;
        }
    }
    let shift = moment / mass;
    // The area of the patch depends on an arbitrary threshold in the blurred edge. The area of the dot is therefore the sum of the light's
    // differences from the background, divided by the mean difference near the centre.
    let radius_px = (mass * inner / depth / std::f64::consts::PI).sqrt();
    let is_good = shift.norm() < LARGEST_SHIFT * dot.radius_px && AREAS.contains(&(radius_px / dot.radius_px).powi(2));
    is_good.then(|| (middle + shift, radius_px))
}
