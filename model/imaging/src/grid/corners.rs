//! Detection of the inner corners of a chessboard, at which two dark and two light squares meet.
//!
//! On a ring about a chessboard corner, the light changes four times, opposite pixels are equal, and the centre has the mean light of the ring. These
//! properties of ring and centre distinguish a corner from an edge, a line, and the gap between two dots. The centre of the corner is the point from
//! which the directions to nearby pixels are perpendicular to the gradients at those pixels.
//!
//! # Reference
//! S. Bennett, J. Lasenby, ChESS: quick and robust detection of chess-board features, Computer Vision and Image Understanding 118 (2014); W. Foerstner,
//! E. Guelch, A fast operator for detection and precise location of distinct points, corners and centres of circular features, ISPRS (1987).

use super::lattice::{self, Lattice, Seed};
use super::patches::Dot;
use super::ring::{Corner, LEAST_CONTRAST, Shrunk};
use crate::light;
use finray_model::camera::Pixel;
use image::GrayImage;
use nalgebra::Matrix2;

/// Corners are first searched for in an image whose longer side is at most this, px. Larger images are reduced by an integer factor.
const LONGER_SIDE: u32 = 1100;
/// A corner counts as the neighbour along the edge of a square only if the direction to it is within this angle of the edge, degrees.
const OFF_EDGE_DEG: f64 = 15.0;
/// A lattice of corners is a chessboard only if at least this share of neighbouring squares alternates between dark and light.
const LEAST_IN_TURN: f64 = 0.9;
/// Radius of the window in which gradients about a corner are used, as a share of the distance to the nearest other corner.
const WINDOW: f64 = 0.4;
/// Smallest and largest radius of the window in which gradients about a corner are used, px.
const WINDOW_PX: [f64; 2] = [3.0, 15.0];
/// Largest number of iterations for a corner's centre.
const STEPS: usize = 20;
/// The iterations for a corner's centre end when a step is below this, px.
const STILL_PX: f64 = 1e-4;
/// Range of the light that a corner's centre may have; 0 is the light of the squares found as dots, 1 is the light of the other squares.
const MIDDLE: std::ops::Range<f64> = 0.25..0.75;
/// Distance from a corner at which the light of the adjacent squares is sampled, as a share of the distance to their centres.
const BESIDE: f64 = 0.25;
/// Smallest distance from a corner at which the light of the adjacent squares is sampled, px.
const BESIDE_PX: f64 = 2.0;
/// At most about this number of dots is examined to decide whether dots are squares of a chessboard.
const MOST_LOOKED: usize = 60;

/// The corners of the largest chessboard in an image, each with its column, its row and its pixel.
pub(super) fn board(grey: &GrayImage) -> Vec<([i32; 2], Pixel)> {
    let first = grey.width().max(grey.height()).div_ceil(LONGER_SIDE).max(1);
    let mut best: Vec<([i32; 2], Pixel)> = Vec::new();
    // Defocused corners are sharp only in a reduced image. Squares of a few pixels are visible only in the full image.
    for shrunk in [first, 2 * first, 1] {
        let found = board_in(grey, shrunk);
        if found.len() > best.len() {
            best = found;
        }
        if first == 1 && shrunk == 2 {
            break;
        }
    }
    best
}

fn board_in(grey: &GrayImage, shrunk: u32) -> Vec<([i32; 2], Pixel)> {
    let corners = Shrunk::new(grey, shrunk).corners();
    let round = Dot { pixel: Pixel::zeros(), radius_px: 1.0, upright: Matrix2::identity() };
    let dots: Vec<Dot> = corners.iter().map(|corner| Dot { pixel: corner.pixel, ..round }).collect();
    let found = lattice::largest(&dots, seeds(&corners));
    if !is_in_turn(grey, &dots, &found) {
        return Vec::new();
    }
    let centre = |(index, &number): (&[i32; 2], &usize)| {
        let nearest = neighbours(&found, *index).map(|other| (dots[other].pixel - dots[number].pixel).norm());
        let window = (WINDOW * nearest.fold(f64::INFINITY, f64::min)).clamp(WINDOW_PX[0], WINDOW_PX[1]);
        Some((*index, centre(grey, dots[number].pixel, window)?))
    };
    let mut board: Vec<_> = found.iter().filter_map(centre).collect();
    board.sort_by_key(|(index, _)| *index);
    board
}

/// Indices of the corners at the four neighbouring positions of the lattice.
fn neighbours(lattice: &Lattice, [i, k]: [i32; 2]) -> impl Iterator<Item = usize> {
    [[i + 1, k], [i - 1, k], [i, k + 1], [i, k - 1]].into_iter().filter_map(|index| lattice.get(&index).copied())
}

/// Whether the dots of a lattice are squares of a chessboard. Squares of one shade meet at their corners, so a chessboard corner lies halfway between
/// neighbouring dots if the dots are squares.
pub(super) fn are_squares(grey: &GrayImage, dots: &[Dot], lattice: &Lattice) -> bool {
    let is_corner = |number: usize, next: [i32; 2], aside: [[i32; 2]; 2]| {
        let next = lattice.get(&next)?;
        let aside = aside.iter().find_map(|index| lattice.get(index))?;
        let [from, to, aside] = [number, *next, *aside].map(|dot| dots[dot].pixel);
        let (along, across) = ((to - from) / 2.0, (aside - from) / 2.0);
        let window = WINDOW * along.norm().min(across.norm());
        let corner = centre(grey, (from + to) / 2.0, window.clamp(WINDOW_PX[0], WINDOW_PX[1]))?;
        let [along, across] = [along, across].map(|way| way * BESIDE.max(BESIDE_PX / way.norm()));
        // Mean light of two opposite squares, and the difference between the light of the two.
        let both = |step: Pixel| {
            let lights = (light(grey, &(corner + step))?, light(grey, &(corner - step))?);
            Some(((lights.0 + lights.1) / 2.0, (lights.0 - lights.1).abs()))
        };
        let ((own, of_own), (other, of_other), here) = (both(along)?, both(across)?, light(grey, &corner)?);
        let contrast = (other - own).abs();
        let is_contrast = contrast > f64::from(LEAST_CONTRAST).max(2.0 * of_own).max(2.0 * of_other);
        Some(is_contrast && MIDDLE.contains(&((here - own) / (other - own))))
    };
    let both = |(&[i, k], &number): (&[i32; 2], &usize)| {
        let along_rows = is_corner(number, [i + 1, k], [[i, k + 1], [i, k - 1]]);
        [along_rows, is_corner(number, [i, k + 1], [[i + 1, k], [i - 1, k]])]
    };
    let mut all: Vec<_> = lattice.iter().collect();
    all.sort();
    let few = all.iter().step_by(all.len() / MOST_LOOKED + 1);
    let looked: Vec<bool> = few.copied().flat_map(both).flatten().collect();
    2 * looked.iter().filter(|is_corner| **is_corner).count() > looked.len()
}

/// Whether the squares between the corners of a lattice alternate between dark and light.
fn is_in_turn(grey: &GrayImage, dots: &[Dot], lattice: &Lattice) -> bool {
    let square = |[i, k]: [i32; 2]| {
        let corners = [[i, k], [i + 1, k], [i + 1, k + 1], [i, k + 1]].map(|index| lattice.get(&index));
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return None };
        let middle = [a, b, c, d].iter().map(|dot| dots[**dot].pixel).sum::<Pixel>() / 4.0;
        light(grey, &middle)
    };
    // Difference in light between a square and the next square, multiplied by a sign that alternates from square to square. On a chessboard, the
    // products for all pairs of neighbouring squares have the same sign.
    let lighter = |&[i, k]: &[i32; 2], next: [i32; 2]| {
        let difference = square([i, k])? - square(next)?;
        Some(if (i + k).rem_euclid(2) == 0 { difference } else { -difference })
    };
    let next = |index: &[i32; 2]| [[index[0] + 1, index[1]], [index[0], index[1] + 1]].map(|next| lighter(index, next));
    let differences: Vec<f64> = lattice.keys().flat_map(next).flatten().collect();
    let lighter = differences.iter().filter(|difference| **difference > f64::from(LEAST_CONTRAST) / 2.0).count();
    let darker = differences.iter().filter(|difference| **difference < -f64::from(LEAST_CONTRAST) / 2.0).count();
    !differences.is_empty() && lighter.max(darker) as f64 >= LEAST_IN_TURN * differences.len() as f64
}

/// Seeds of a lattice: corners that have a neighbour on both sides along each of their two edges.
fn seeds(corners: &[Corner]) -> Vec<Seed> {
    let widest = OFF_EDGE_DEG.to_radians().cos();
    let seed = |(number, corner): (usize, &Corner)| {
        let next = |direction: Pixel| {
            let steps = corners.iter().map(|other| other.pixel - corner.pixel);
            let is_along = |step: &Pixel| step.dot(&direction) > widest * step.norm();
            steps.filter(is_along).min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
        };
        let [first, second] = corner.edges.map(|edge| Some((next(edge)?, next(-edge)?)));
        let (first, second) = (first?, second?);
        let off = |(there, back): (Pixel, Pixel)| (there + back).norm() / there.norm();
        Some((off(first) + off(second), number, [first.0, second.0]))
    };
    corners.iter().enumerate().filter_map(seed).collect()
}

/// Centre of a corner by weighted least squares of the gradients in a window, px. `None` if the centre lies outside the window, or the window reaches beyond
/// the image.
fn centre(grey: &GrayImage, from: Pixel, window: f64) -> Option<Pixel> {
    let mut centre = from;
    let reach = window.ceil();
    let value = |u: u32, v: u32| f64::from(grey.get_pixel(u, v).0[0]);
    for _ in 0..STEPS {
        let (left, top) = (centre.x.round() - reach, centre.y.round() - reach);
        let (right, bottom) = (centre.x.round() + reach, centre.y.round() + reach);
        let is_inside = left >= 1.0
            && top >= 1.0
            && right <= f64::from(grey.width()) - 2.0
            && bottom <= f64::from(grey.height()) - 2.0;
        if !is_inside {
            return None;
        }
        let (mut normal, mut side) = (Matrix2::zeros(), Pixel::zeros());
        for v in top as u32..=bottom as u32 {
            for u in left as u32..=right as u32 {
                let step = Pixel::new(f64::from(u), f64::from(v)) - centre;
                let far2 = step.norm_squared() / (window * window);
                if far2 >= 1.0 {
                    continue;
                }
                // The weight is a Gaussian whose standard deviation is half the window's radius, lowered to zero at the window's border. With a
                // weight that falls to zero at the border, the centre changes smoothly as pixels enter the window.
                let weight = (-2.0 * far2).exp() - (-2.0_f64).exp();
                let gradient = Pixel::new(value(u + 1, v) - value(u - 1, v), value(u, v + 1) - value(u, v - 1));
                let product = gradient * gradient.transpose() * weight;
                normal += product;
                side += product * step;
            }
        }
        let step = normal.try_inverse()? * side;
        centre += step;
        if (centre - from).norm() > window {
            return None;
        }
        if step.norm() < STILL_PX {
            break;
        }
    }
    Some(centre)
}
