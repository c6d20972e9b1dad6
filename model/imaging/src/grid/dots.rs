//! The dots of a lattice, measured by their light.
//!
//! A dot's own light is that of the pixels about it that are nearer to its rim than to any other: where neighbours are so near that the blurred edges
//! meet, what one loses of its edge to the other it gains of the other's. The ground is seen where no dot is.

use super::patches::Dot;
use finray_model::camera::Pixel;
use image::GrayImage;
use nalgebra::{Matrix3, Vector3};

/// How far beyond its rim light belongs to a dot, and how far the ground is looked at, in its radii and px: first as much as a lone dot has, then
/// what is left between dots that lie close.
const ABOUT: [[(f64, f64); 2]; 3] = [[(0.15, 2.5), (0.35, 4.5)], [(0.0, 2.0), (0.5, 6.0)], [(0.0, 1.0), (1.0, 8.0)]];
/// Fewest pixels of the ground.
const LEAST_GROUND: usize = 24;
/// Part of a dot within which its light is even, in its radii.
const INNER: f64 = 0.6;
/// Largest distance of the middle of a dot's light from that of its patch, in its radii, and ratio of their areas.
const LARGEST_SHIFT: f64 = 0.5;
const AREAS: std::ops::Range<f64> = 0.5..2.0;

/// The middle of a dot's light and the radius of a disc of its area, px; `None` where its surroundings are not in the image or hidden by others.
pub(super) fn measured(grey: &GrayImage, dot: &Dot, others: &[Dot]) -> Option<(Pixel, f64)> {
    ABOUT.iter().find_map(|[own, ground]| {
        let px = |(radii, px): (f64, f64)| radii * dot.radius_px + px;
        light_of(grey, dot, others, [px(*own), px(*ground)])
    })
}

/// The same with the pixels up to `own` px from the rim as the dot's, those from there to `reach` px as its ground.
fn light_of(grey: &GrayImage, dot: &Dot, others: &[Dot], [own, reach]: [f64; 2]) -> Option<(Pixel, f64)> {
    let half = dot.longer_px() + reach;
    let middle = dot.pixel;
    let (width, height) = (f64::from(grey.width()) - 1.0, f64::from(grey.height()) - 1.0);
    // Without its surroundings a dot at the border would be measured by half.
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
        // As a share of the light there: light that falls off makes one side of a dot darker, and would shift its middle.
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
    // The threshold lies anywhere on the blurred edge; light that is missing over its depth in the middle is the area.
    let radius_px = (mass * inner / depth / std::f64::consts::PI).sqrt();
    let is_good = shift.norm() < LARGEST_SHIFT * dot.radius_px && AREAS.contains(&(radius_px / dot.radius_px).powi(2));
    is_good.then(|| (middle + shift, radius_px))
}
