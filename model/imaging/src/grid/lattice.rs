//! Which dots are neighbours: a lattice that grows from a dot, step by step, along with its slant.

use super::GridDot;
use super::dots::Dot;
use finray_model::camera::Pixel;
use std::collections::{HashMap, VecDeque};

/// Dots from which a lattice is grown, those with the most regular surroundings first.
const SEEDS: usize = 40;
/// A share of the dots that ends the search for a larger lattice.
const ENOUGH: f64 = 0.8;
/// Largest distance of a dot from where its neighbours put it, as a share of the step.
const OFF: f64 = 0.2;
/// Ratio of the two steps of a square grid, and smallest sine of the angle between them, seen so that its dots are round: a diagonal step
/// is sqrt(2) times as long.
const STEPS: f64 = 1.25;
const LEAST_SINE: f64 = 0.9;
/// Ratio of the radii of neighbours.
const ALIKE: f64 = 1.6;

/// The largest lattice among dots.
pub(super) fn largest(dots: &[Dot]) -> Vec<GridDot> {
    let mut seeds: Vec<(f64, usize, [Pixel; 2])> =
        (0..dots.len()).filter_map(|seed| steps_at(dots, seed).map(|(off, steps)| (off, seed, steps))).collect();
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Vec<GridDot> = Vec::new();
    for (_, seed, steps) in seeds.into_iter().take(SEEDS) {
        if best.len() as f64 > ENOUGH * dots.len() as f64 {
            break;
        }
        if best.iter().any(|dot| dot.pixel == dots[seed].pixel) {
            continue;
        }
        let found = grown(dots, seed, steps);
        if found.len() > best.len() {
            best = found;
        }
    }
    best
}

/// The steps from a dot to two neighbours that have counterparts on the other side, and how far these are off. Slant is taken out by the
/// shape of the dot.
fn steps_at(dots: &[Dot], seed: usize) -> Option<(f64, [Pixel; 2])> {
    let Dot { pixel: from, upright, .. } = dots[seed];
    let mut near: Vec<(f64, Pixel)> = dots
        .iter()
        .filter(|dot| is_alike(dot, &dots[seed]))
        .map(|dot| upright * (dot.pixel - from))
        .map(|step| (step.norm(), step))
        .filter(|(distance, _)| *distance > 0.0)
        .collect();
    const NEIGHBOURS: usize = 8;
    if near.len() < 4 {
        return None;
    }
    let count = near.len().min(NEIGHBOURS);
    near.select_nth_unstable_by(count - 1, |a, b| a.0.total_cmp(&b.0));
    near.truncate(count);
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    // How far the nearest dot is from the mirrored step.
    let off =
        |step: &Pixel| near.iter().map(|(_, other)| (other + step).norm()).fold(f64::INFINITY, f64::min) / step.norm();
    let first = near.iter().map(|(_, step)| *step).find(|step| off(step) < OFF)?;
    let is_second = |step: &Pixel| {
        off(step) < OFF
            && step.norm() < STEPS * first.norm()
            && first.perp(step).abs() > LEAST_SINE * first.norm() * step.norm()
    };
    let second = near.iter().map(|(_, step)| *step).find(is_second)?;
    let slanted = upright.try_inverse()?;
    Some((off(&first) + off(&second), [slanted * first, slanted * second]))
}

fn is_alike(a: &Dot, b: &Dot) -> bool {
    a.radius_px < ALIKE * b.radius_px && b.radius_px < ALIKE * a.radius_px
}

/// The lattice from a dot and its two steps.
fn grown(dots: &[Dot], seed: usize, steps: [Pixel; 2]) -> Vec<GridDot> {
    let mut at: HashMap<[i32; 2], usize> = HashMap::new();
    let mut index_of: Vec<Option<[i32; 2]>> = vec![None; dots.len()];
    let mut open = VecDeque::from([(seed, [0, 0], steps)]);
    at.insert([0, 0], seed);
    index_of[seed] = Some([0, 0]);
    while let Some((dot, index, steps)) = open.pop_front() {
        for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
            let mut next = index;
            next[axis] += sign;
            if at.contains_key(&next) {
                continue;
            }
            let step = steps[axis] * f64::from(sign);
            let expected = dots[dot].pixel + step;
            let near = (0..dots.len()).filter(|&i| index_of[i].is_none() && is_alike(&dots[i], &dots[dot]));
            let near = near.map(|i| ((dots[i].pixel - expected).norm(), i)).min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, found)) = near.filter(|(off, _)| *off < OFF * step.norm()) else { continue };
            at.insert(next, found);
            index_of[found] = Some(next);
            let mut steps = steps;
            steps[axis] = (dots[found].pixel - dots[dot].pixel) * f64::from(sign);
            open.push_back((found, next, steps));
        }
    }
    let dot = |(i, index): (usize, &Option<[i32; 2]>)| {
        index.map(|index| GridDot { index, pixel: dots[i].pixel, radius_px: dots[i].radius_px })
    };
    index_of.iter().enumerate().filter_map(dot).collect()
}
