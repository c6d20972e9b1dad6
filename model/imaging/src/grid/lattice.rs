//! Arrangement of dots in columns and rows: a lattice that grows from one dot in steps that adapt to perspective.

use super::patches::Dot;
use finray_model::camera::Pixel;
use std::collections::{HashMap, VecDeque};

/// At most this number of dots is tried as the start of a lattice, the dots with the most regular surroundings first.
const SEEDS: usize = 40;
/// The search for a larger lattice ends when this share of the dots is in one lattice.
const ENOUGH: f64 = 0.8;
/// A dot belongs to a lattice only within this distance of its predicted position, as a share of the step between neighbours.
const OFF: f64 = 0.2;
/// The lengths of the two steps of a square grid have at most this ratio, in coordinates in which the dots are round. Diagonal steps, which are sqrt(2) times
/// as long, exceed this ratio.
const STEPS: f64 = 1.25;
/// The angle between the two steps of a square grid has at least this sine, in coordinates in which the dots are round.
const LEAST_SINE: f64 = 0.9;
/// Two dots are neighbours only if the ratio of their radii is at most this.
const ALIKE: f64 = 1.6;
/// A dot is detected only if its distance from the image border is at least a multiple of its longer half axis, plus a length in px.
const ROOM: (f64, f64) = (1.2, 4.0);

/// Index of the dot at each column and row; columns and rows are counted from an arbitrary dot.
pub(super) type Lattice = HashMap<[i32; 2], usize>;

/// A dot from which a lattice may grow: irregularity of its surroundings (0 is regular), its index, and the steps to two of its neighbours, px.
pub(super) type Seed = (f64, usize, [Pixel; 2]);

/// The lattice with the most dots.
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

/// Irregularity of a dot's surroundings, and the steps to two neighbours, px. Each of the two neighbours has a counterpart on the opposite side of
/// the dot. Steps are compared after the slant of the grid is removed, which follows from the shape of the dot.
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
    // Distance from the end of the mirrored step to the nearest dot, relative to the length of the step.
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

/// Grows a lattice from a dot and the steps to two of its neighbours.
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

/// Numbers of dots on the outline of a lattice, counting only dots whose missing neighbours would lie in the image. The first number counts dots that
/// lack one neighbour, because the outline follows a row or column. The second number counts dots that lack two adjacent neighbours, because the
/// outline runs diagonally.
pub(super) fn outline(dots: &[Dot], lattice: &Lattice, size_px: [u32; 2]) -> [usize; 2] {
    let mut counts = [0; 2];
    for (&[i, k], &number) in lattice {
        let dot = &dots[number];
        let room = ROOM.0 * dot.longer_px() + ROOM.1;
        let is_inside =
            |at: Pixel| (0..2).all(|axis| (room..f64::from(size_px[axis]) - 1.0 - room).contains(&at[axis]));
        // Whether one of two opposite neighbours is missing although it would lie in the image. The other neighbour predicts its position. `None` if
        // both neighbours are missing, or if the missing neighbour would lie outside the image.
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
