//! Which marker is which node: order along the plates, and what a finger can do.
//!
//! A plate keeps its length and bends gently, and a rib keeps its length nearly: from the clamped node on, whose position is known, each
//! plate is the chain of markers with the least cost, in which a distance, a turn and a hidden node cost what they are unlikely. No
//! guess of the shape is needed.

use super::colour::Side;
use finray_model::finger::Plate;
use finray_model::{Finger, NodeId, Vector};

/// A measured disc that may be a marker.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Sides whose colour it has: front, back.
    pub sides: [bool; 2],
    /// Its centre, mm, finger frame.
    pub at: Vector,
    /// The only node that it may be, where one is known.
    pub node: Option<NodeId>,
}

/// Hidden nodes in a row that a chain may skip.
const MOST_SKIPPED: usize = 4;
/// Distance between two nodes against the length of the plate between them: a chord is shorter than its arc, and measured distances
/// scatter.
const CHORDS: [f64; 2] = [0.75, 1.05];
/// Deviations that cost 1: too long a chord, too short a chord (each a segment), turn from one segment to the next (degrees a segment),
/// rib.
const LONGER: f64 = 0.015;
const SHORTER: f64 = 0.06;
const TURN_DEG: f64 = 14.0;
/// Largest turn from one segment to the next, degrees a segment.
const LARGEST_TURN_DEG: f64 = 60.0;
const RIB: f64 = 0.05;
/// The same of ribs that do not deform: noise and pose alone.
const RIGID_RIB: f64 = 0.01;
/// Largest cost of a rib: one that buckles, or whose other end is a false marker, must not break a chain.
const RIB_MOST: f64 = 12.0;
/// Cost of a hidden node, and of a clamped node's marker that is not where it must be.
const HIDDEN: f64 = 6.0;
/// Largest distance of a clamped node's marker from where the pose has it, as a share of the plate.
const CLAMPED: f64 = 0.01;
/// Another chain that costs no more than this beyond the best fits alike.
const ALIKE: f64 = 4.0;
/// Nodes that another chain of the same cost may name otherwise, each left out; with more, nothing is certain.
const MOST_DOUBTFUL: usize = 1;
/// Rounds in which plates look at each other's ribs.
const ROUNDS: usize = 3;

/// Why nodes have no names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NamingError {
    /// Too few markers are left.
    #[error("found {found} of {all} markers on the free nodes, of which at least {least} are needed")]
    TooFew {
        /// Markers on free nodes that fit the finger.
        found: usize,
        /// Free nodes.
        all: usize,
        /// How many are needed.
        least: usize,
    },
    /// Two ways to name them fit alike.
    #[error("two ways to name the markers fit alike: they differ at {nodes} nodes of the {plate} plate")]
    Ambiguous {
        /// Nodes that differ.
        nodes: usize,
        /// The plate.
        plate: &'static str,
    },
}

/// The candidate of each key node, by its number less one.
pub(super) type Names = Vec<Option<usize>>;

/// Names the candidates as one finger has them, without a check whether other names fit as well.
pub(super) fn name_likely(finger: &Finger, candidates: &[Candidate]) -> Names {
    likely(finger, candidates).0
}

fn likely(finger: &Finger, candidates: &[Candidate]) -> (Names, [Option<Named>; 2]) {
    let mut names: Names = vec![None; finger.key_node_count()];
    let mut chains = [None, None];
    for _ in 0..ROUNDS {
        for plate in [Plate::Front, Plate::Back] {
            let question = Chain::new(finger, plate, candidates, &names);
            let Some(found) = question.cheapest() else { continue };
            question.write(&found, &mut names);
            chains[usize::from(plate == Plate::Back)] = Some(found);
        }
    }
    (names, chains)
}

/// Names the candidates.
pub(super) fn name(finger: &Finger, candidates: &[Candidate]) -> Result<Names, NamingError> {
    let (mut names, chains) = likely(finger, candidates);
    for plate in [Plate::Front, Plate::Back] {
        let Some(best) = &chains[usize::from(plate == Plate::Back)] else { continue };
        let question = Chain::new(finger, plate, candidates, &names);
        // Named anew with the last names of the other plate.
        let best_cost = question.cheapest().map_or(best.cost, |found| found.cost);
        for (position, &candidate) in best.named.iter().enumerate().filter_map(|(k, c)| Some((k, c.as_ref()?))) {
            let Some(other) = question.cheapest_within(best_cost + ALIKE, Some((position, candidate))) else {
                continue;
            };
            let differs = |k: &usize| other.named[*k].is_some() && other.named[*k] != best.named[*k];
            let differing = (0..best.named.len()).filter(differs).count();
            if differing > MOST_DOUBTFUL {
                let plate = if plate == Plate::Front { "front" } else { "back" };
                return Err(NamingError::Ambiguous { nodes: differing, plate });
            }
            if differing > 0 {
                names[question.nodes[position].0 - 1] = None;
            }
        }
    }
    let all = finger.free_nodes().len();
    let found = finger.free_nodes().filter(|node| names[node.0 - 1].is_some()).count();
    let least = (all / 3).max(all.min(3));
    if found < least { Err(NamingError::TooFew { found, all, least }) } else { Ok(names) }
}

/// The question of one plate.
struct Chain<'a> {
    finger: &'a Finger,
    plate: Plate,
    candidates: &'a [Candidate],
    /// From the base to the tip, with positions along the plate, mm.
    nodes: Vec<NodeId>,
    lengths_mm: Vec<f64>,
    /// By node, the position of the rib's other end where it is named, mm, and the rib's length, mm.
    ribs: Vec<Option<(Vector, f64)>>,
    /// Candidates that each node may be.
    choices: Vec<Vec<usize>>,
}

/// A chain, by position along the plate.
#[derive(Debug, Clone, PartialEq)]
struct Named {
    cost: f64,
    named: Vec<Option<usize>>,
}

/// A chain up to its last two nodes.
#[derive(Debug, Clone, Copy)]
struct Link {
    position: usize,
    candidate: usize,
    /// The link before; `None` for the first from the clamped node.
    before: Option<usize>,
    /// From the node before, mm.
    step: Vector,
    segments: f64,
    cost: f64,
}

impl<'a> Chain<'a> {
    fn new(finger: &'a Finger, plate: Plate, candidates: &'a [Candidate], names: &Names) -> Chain<'a> {
        let nodes = finger.plate_nodes(plate);
        let lengths_mm = finger.plate_positions_mm(plate);
        let at = |node: NodeId| names[node.0 - 1].map(|candidate| candidates[candidate].at);
        let mut ribs = vec![None; nodes.len()];
        for rib in 0..finger.rib_count() {
            let [front, back] = finger.rib_nodes(rib);
            let other = if plate == Plate::Front { back } else { front };
            let length = (finger.position(front) - finger.position(back)).norm();
            ribs[rib + 1] = at(other).map(|at| (at, length));
        }
        // The tip ends the back plate as well: its last segment holds it as a rib would.
        if plate == Plate::Front {
            let before = NodeId(finger.tip().0 - 1);
            let length = (finger.position(before) - finger.position(finger.tip())).norm();
            ribs[nodes.len() - 1] = at(before).map(|at| (at, length));
        }
        // What the other plate has is its own, but for the tip.
        let other = finger.plate_nodes(if plate == Plate::Front { Plate::Back } else { Plate::Front });
        let taken: Vec<usize> =
            other.iter().filter(|node| **node != finger.tip()).filter_map(|node| names[node.0 - 1]).collect();
        let last = nodes.len() - 1;
        let choices = (0..nodes.len()).map(|position| {
            // The tip has the front plate's colour, and the front plate finds it first.
            let side = if position == last || plate == Plate::Front { Side::Front } else { Side::Back };
            if position == last && plate == Plate::Back {
                return names[finger.tip().0 - 1].into_iter().collect();
            }
            let may_be = |candidate: &Candidate| {
                candidate.sides[side as usize] && candidate.node.is_none_or(|node| node == nodes[position])
            };
            let of_side = |i: &usize| may_be(&candidates[*i]) && !taken.contains(i);
            (0..candidates.len()).filter(of_side).collect()
        });
        Chain { finger, plate, candidates, choices: choices.collect(), nodes, lengths_mm, ribs }
    }

    fn write(&self, found: &Named, names: &mut Names) {
        for (position, (node, candidate)) in self.nodes.iter().zip(&found.named).enumerate() {
            // The back plate keeps the tip that the front plate found.
            if self.plate == Plate::Front || position + 1 < self.nodes.len() {
                names[node.0 - 1] = *candidate;
            }
        }
    }

    /// The chain of least cost; `None` if none leaves the base.
    fn cheapest(&self) -> Option<Named> {
        self.cheapest_within(f64::INFINITY, None)
    }

    /// The chain of least cost, without naming a position as a candidate; `None` if none leaves the base at no more than a cost.
    fn cheapest_within(&self, most: f64, without: Option<(usize, usize)>) -> Option<Named> {
        let base = self.finger.base(self.plate);
        let allowed = |position: usize, candidate: usize| without != Some((position, candidate));
        let largest_mm = CLAMPED * self.lengths_mm[self.nodes.len() - 1];
        let clamped = self.choices[0].iter().copied().filter(|&c| allowed(0, c));
        let clamped = clamped.map(|c| (c, (self.candidates[c].at - base).norm()));
        let clamped = clamped.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, away)| *away < largest_mm);
        let start = clamped.map_or(HIDDEN, |(_, away)| (away / (0.5 * largest_mm)).powi(2));
        let mut links: Vec<Link> = Vec::new();
        // Links that end at each position.
        let mut ending: Vec<Vec<usize>> = vec![Vec::new(); self.nodes.len()];
        let along = (self.finger.position(self.nodes[1]) - base).normalize();
        let mut best: Vec<(usize, f64, usize)> = Vec::new();
        for position in 1..self.nodes.len() {
            for &candidate in &self.choices[position] {
                if !allowed(position, candidate) || clamped.is_some_and(|(c, _)| c == candidate) {
                    continue;
                }
                let at = self.candidates[candidate].at;
                let rib = self.rib_cost(position, &at);
                if position <= MOST_SKIPPED + 1
                    && let Some(cost) = self.step_cost(0, position, &(at - base))
                    && let Some(turn) = turn_cost(&along, &(at - base), 1.0 + position as f64)
                {
                    let cost = start + cost + turn + rib;
                    let segments = position as f64;
                    if cost <= most {
                        ending[position].push(links.len());
                        links.push(Link { position, candidate, before: None, step: at - base, segments, cost });
                    }
                }
                let from = position.saturating_sub(MOST_SKIPPED + 1).max(1);
                for before in from..position {
                    // Chains that meet in one step go on alike: of each candidate before, the cheapest.
                    best.clear();
                    for &link in &ending[before] {
                        let last = links[link];
                        if last.candidate == candidate {
                            continue;
                        }
                        let step = at - self.candidates[last.candidate].at;
                        let segments = (position - before) as f64;
                        let Some(cost) = self.step_cost(before, position, &step) else { continue };
                        let known = best.iter().position(|(candidate, _, _)| *candidate == last.candidate);
                        let to_beat = known.map_or(most, |entry| best[entry].1);
                        let straight = last.cost + cost + rib;
                        if straight > to_beat {
                            continue;
                        }
                        let Some(turn) = turn_cost(&last.step, &step, last.segments + segments) else { continue };
                        let found = (last.candidate, straight + turn, link);
                        match known {
                            _ if found.1 > to_beat => {}
                            Some(entry) => best[entry] = found,
                            None => best.push(found),
                        }
                    }
                    for &(_, cost, link) in &best {
                        let step = at - self.candidates[links[link].candidate].at;
                        ending[position].push(links.len());
                        let segments = (position - before) as f64;
                        links.push(Link { position, candidate, before: Some(link), step, segments, cost });
                    }
                }
            }
        }
        let last = self.nodes.len() - 1;
        let whole = |link: &Link| link.cost + HIDDEN * (last - link.position) as f64;
        let best = (0..links.len()).min_by(|&a, &b| whole(&links[a]).total_cmp(&whole(&links[b])))?;
        let mut named = vec![None; self.nodes.len()];
        named[0] = clamped.map(|(candidate, _)| candidate);
        let mut at = Some(best);
        while let Some(link) = at.map(|i| links[i]) {
            named[link.position] = Some(link.candidate);
            at = link.before;
        }
        let cost = whole(&links[best]);
        (cost <= most).then_some(Named { cost, named })
    }

    /// Cost of a step between two positions along the plate, hidden ones between them included; `None` if it cannot be.
    fn step_cost(&self, from: usize, to: usize, step: &Vector) -> Option<f64> {
        let ratio = step.norm() / (self.lengths_mm[to] - self.lengths_mm[from]);
        if !(CHORDS[0]..=CHORDS[1]).contains(&ratio) {
            return None;
        }
        let segments = (to - from) as f64;
        let unit = if ratio > 1.0 { LONGER } else { SHORTER * segments };
        Some(((ratio - 1.0) / unit).powi(2) + HIDDEN * (segments - 1.0))
    }

    fn rib_cost(&self, position: usize, at: &Vector) -> f64 {
        // At the tip it is the other plate's last segment, which does not stretch either.
        let is_tip = position + 1 == self.nodes.len();
        let is_rigid = self.finger.description().ribs.strip.is_none() && !is_tip;
        let rib = if is_rigid { RIGID_RIB } else { RIB };
        let longer = if is_tip { LONGER } else { rib };
        self.ribs[position].map_or(0.0, |(other, length)| {
            let excess = (at - other).norm() / length - 1.0;
            (excess / if excess > 0.0 { longer } else { rib }).powi(2).min(RIB_MOST)
        })
    }
}

/// Cost of a turn between two steps that are so many segments together; `None` if a plate would break.
fn turn_cost(before: &Vector, step: &Vector, segments: f64) -> Option<f64> {
    let turn_deg = before.perp(step).atan2(before.dot(step)).abs().to_degrees();
    let each = turn_deg / (segments / 2.0);
    (each <= LARGEST_TURN_DEG).then(|| (each / TURN_DEG).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use finray_fixtures::{PAPER_SCENE, SOFT_SCENE, SPRING_STEEL_SCENE};
    use finray_model::{Kinematics, Load, Mesh, Scene, statics};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn normal(chance: &mut ChaCha8Rng) -> f64 {
        StandardNormal.sample(chance)
    }

    /// Markers of a shape as they would be measured, and the node of each.
    fn markers(finger: &Finger, chance: &mut ChaCha8Rng, largest_n: f64) -> Option<Vec<(NodeId, Candidate)>> {
        let mesh = Mesh::key_nodes(finger);
        let length = finger.plate_length_mm(Plate::Front);
        let angle_deg = chance.random_range(-40.0..40.0);
        let force = finger.direction(angle_deg) * chance.random_range(0.0..largest_n);
        let load = Load::at_position(chance.random_range(0.05..0.98) * length, force);
        let shape = statics::solve(&mesh, &[load], Kinematics::Corotational).ok()?;
        let on_front = finger.plate_nodes(Plate::Front);
        let marker = |motion: &finray_model::mesh::NodeMotion| {
            let noise = Vector::new(normal(chance), normal(chance)) * 0.02;
            let is_front = on_front.contains(&motion.node);
            let at = motion.position + motion.displacement + noise;
            (motion.node, Candidate { sides: [is_front, !is_front], at, node: None })
        };
        Some(shape.motions().iter().map(marker).collect())
    }

    /// Every named marker has its own name: three fingers, large deflections, hidden markers, false ones of the same colours. A false marker
    /// may stand where a hidden one could: where nodes are 20 to 40 mm apart, up to two in a thousand.
    #[test]
    fn no_marker_gets_another_nodes_name() {
        const SHAPES: u64 = 400;
        const FAR_APART: f64 = 0.002;
        for (scene, largest_n, most_wrong) in
            [(PAPER_SCENE, 6.0, 0.0), (SPRING_STEEL_SCENE, 12.0, FAR_APART), (SOFT_SCENE, 2.0, FAR_APART)]
        {
            let finger = Scene::from_toml(scene).expect("a scene").finger;
            let (mut all, mut named, mut wrong) = (0, 0, 0);
            for number in 0..SHAPES {
                let mut chance = ChaCha8Rng::seed_from_u64(number);
                let Some(mut seen) = markers(&finger, &mut chance, largest_n) else { continue };
                seen.retain(|_| chance.random_range(0.0..1.0) > 0.12);
                let nodes = seen.len();
                for _ in 0..number % 13 {
                    let at = Vector::new(chance.random_range(-30.0..180.0), chance.random_range(-70.0..70.0));
                    // A false marker that lies on a true one would be measured as one of them, or not at all.
                    if seen.iter().all(|(_, other)| (other.at - at).norm() > 4.0) {
                        let is_front = chance.random_range(0.0..1.0) < 0.5;
                        seen.push((NodeId(0), Candidate { sides: [is_front, !is_front], at, node: None }));
                    }
                }
                let candidates: Vec<Candidate> = seen.iter().map(|(_, candidate)| *candidate).collect();
                all += nodes;
                let Ok(names) = name(&finger, &candidates) else { continue };
                for (i, candidate) in names.iter().enumerate().filter_map(|(i, name)| Some((i, (*name)?))) {
                    wrong += i32::from(seen[candidate].0 != NodeId(i + 1));
                    named += 1;
                }
            }
            assert!(f64::from(wrong) <= most_wrong * f64::from(named), "{wrong} of {named}");
            // Refused shapes and markers that are left out count as not named.
            assert!(f64::from(named) > 0.97 * all as f64, "{named} of {all}");
        }
    }

    #[test]
    fn too_few_markers_are_no_finger() {
        let finger = Scene::from_toml(PAPER_SCENE).expect("a scene").finger;
        let mut seen = markers(&finger, &mut ChaCha8Rng::seed_from_u64(1), 2.0).expect("a shape");
        seen.truncate(5);
        let candidates: Vec<Candidate> = seen.iter().map(|(_, candidate)| *candidate).collect();
        // Of nodes 1 to 5 one is clamped.
        assert_eq!(name(&finger, &candidates), Err(NamingError::TooFew { found: 4, all: 23, least: 7 }));
        assert!(matches!(name(&finger, &[]), Err(NamingError::TooFew { found: 0, .. })));
    }

    /// A copy of every marker of a plate beside it: which one is the marker is not known, so neither is named.
    #[test]
    fn two_ways_to_name_are_refused() {
        let finger = Scene::from_toml(PAPER_SCENE).expect("a scene").finger;
        let seen = markers(&finger, &mut ChaCha8Rng::seed_from_u64(2), 1.0).expect("a shape");
        let mut candidates: Vec<Candidate> = seen.iter().map(|(_, candidate)| *candidate).collect();
        let copies = candidates.clone();
        candidates.extend(copies.iter().map(|marker| Candidate { at: marker.at + Vector::new(0.0, 0.5), ..*marker }));
        match name(&finger, &candidates) {
            Err(NamingError::Ambiguous { .. } | NamingError::TooFew { .. }) => {}
            other => panic!("{other:?}"),
        }
    }
}
