//! Which dots are neighbours: a lattice that grows from a dot, step by step, along with its slant.

use super::patches::Dot;
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
/// Room that a dot needs to be seen as one before the border of the image, in its longer half axes and px.
const ROOM: (f64, f64) = (1.2, 4.0);

/// Numbers of dots by their column and row, counted from some dot.
pub(super) type Lattice = HashMap<[i32; 2], usize>;

/// How irregular the surroundings of a dot are, its number, and the steps to two of its neighbours.
pub(super) type Seed = (f64, usize, [Pixel; 2]);

/// The largest lattice among dots.
pub(super) fn largest(dots: &[Dot], mut seeds: Vec<Seed>) -> Lattice {
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = Lattice::new();
    for (_, seed, steps) in seeds.into_iter().take(SEEDS) {
        if best.len() as f64 > ENOUGH * dots.len() as f64 {
            break;
        }
        if best.values().any(|dot| *dot == seed) {
            continue;
        }
        let found = grown(dots, seed, steps);
        if found.len() > best.len() {
            best = found;
        }
    }
    best
}

/// Dots from which a lattice may grow.
pub(super) fn seeds(dots: &[Dot]) -> Vec<Seed> {
    let seed = |seed| steps_at(dots, seed).map(|(off, steps)| (off, seed, steps));
    (0..dots.len()).filter_map(seed).collect()
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
fn grown(dots: &[Dot], seed: usize, steps: [Pixel; 2]) -> Lattice {
    let mut at = Lattice::from([([0, 0], seed)]);
    let mut is_taken = vec![false; dots.len()];
    let mut open = VecDeque::from([(seed, [0, 0], steps)]);
    is_taken[seed] = true;
    while let Some((dot, index, steps)) = open.pop_front() {
        for (axis, sign) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
            let mut next = index;
            next[axis] += sign;
            if at.contains_key(&next) {
                continue;
            }
            let step = steps[axis] * f64::from(sign);
            let expected = dots[dot].pixel + step;
            let near = (0..dots.len()).filter(|&i| !is_taken[i] && is_alike(&dots[i], &dots[dot]));
            let near = near.map(|i| ((dots[i].pixel - expected).norm(), i)).min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, found)) = near.filter(|(off, _)| *off < OFF * step.norm()) else { continue };
            at.insert(next, found);
            is_taken[found] = true;
            let mut steps = steps;
            steps[axis] = (dots[found].pixel - dots[dot].pixel) * f64::from(sign);
            open.push_back((found, next, steps));
        }
    }
    at
}

/// Dots of a lattice's outline, where the image would show more of it: those that lack one neighbour, as along a row, and those that lack two which are
/// not opposite, as along a diagonal.
pub(super) fn outline(dots: &[Dot], lattice: &Lattice, size_px: [u32; 2]) -> [usize; 2] {
    let mut counts = [0; 2];
    for (&[i, k], &number) in lattice {
        let dot = &dots[number];
        let room = ROOM.0 * dot.longer_px() + ROOM.1;
        let is_inside =
            |at: Pixel| (0..2).all(|axis| (room..f64::from(size_px[axis]) - 1.0 - room).contains(&at[axis]));
        // Whether one of two opposite neighbours is missing where the other one says that it would be in the image; `None` where that is not known.
        let lacks_one = |ends: [[i32; 2]; 2]| match ends.map(|end| lattice.get(&end)) {
            [Some(_), Some(_)] => Some(false),
            [Some(&other), None] | [None, Some(&other)] => {
                is_inside(2.0 * dot.pixel - dots[other].pixel).then_some(true)
            }
            [None, None] => None,
        };
        match (lacks_one([[i + 1, k], [i - 1, k]]), lacks_one([[i, k + 1], [i, k - 1]])) {
            (Some(true), Some(true)) => counts[1] += 1,
            (Some(true), Some(false)) | (Some(false), Some(true)) => counts[0] += 1,
            _ => {}
        }
    }
    counts
}
