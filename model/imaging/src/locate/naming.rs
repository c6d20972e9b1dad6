//! Which marker is which node: order along the plates, and what a finger can do.
//!
//! A plate keeps its length and bends gently, and a rib keeps its length nearly: from the clamped node on, whose position is known, each
//! plate is the chain of markers with the least cost, in which a distance, a turn and a hidden node cost what they are unlikely. No
//! guess of the shape is needed.

mod ribs;

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
    /// What naming it costs: more than zero if it does not quite look like a marker.
    pub cost: f64,
}

/// Hidden nodes in a row that a chain may skip.
const MOST_SKIPPED: usize = 4;
/// Distance between two nodes against the length of the plate between them: a chord is shorter than its arc, and measured distances
/// scatter.
const CHORDS: [f64; 2] = [0.75, 1.05];
/// Deviations that cost 1: too long a chord, too short a chord (each a segment), turn from one segment to the next (degrees, for the share
/// of the plate that they are apart), rib.
const LONGER: f64 = 0.015;
const SHORTER: f64 = 0.06;
const TURN_DEG: f64 = 168.0;
/// Largest turn from one segment to the next, in the same measure, and in degrees.
const LARGEST_TURN: f64 = 4.3;
const LARGEST_TURN_DEG: f64 = 120.0;
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
/// Standard deviation of a bracket's stated length, mm.
const BRACKET_MM: f64 = 0.5;
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
    /// Two places of the base fit alike.
    #[error("two places of the base fit alike: the names of {nodes} nodes differ")]
    Places {
        /// Nodes that differ.
        nodes: usize,
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

/// A finger with markers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marked<'f> {
    pub finger: &'f Finger,
    /// Standard deviation of where its base is, mm: zero where the pose is known.
    pub base_sd_mm: f64,
}

impl<'f> Marked<'f> {
    /// A finger whose base is where the pose has it.
    pub fn at_base(finger: &'f Finger) -> Marked<'f> {
        Marked { finger, base_sd_mm: 0.0 }
    }

    fn position(&self, node: NodeId) -> Vector {
        self.finger.position(node) + self.finger.marker_offset(node)
    }
}

/// Names the candidates as one finger has them, without a check whether other names fit as well.
pub(super) fn name_likely(marked: Marked, candidates: &[Candidate]) -> Names {
    likely(marked, candidates).0
}

/// The same with what it costs; `None` if no marker can be named.
pub(super) fn name_at_cost(marked: Marked, candidates: &[Candidate]) -> Option<(Names, f64)> {
    let (names, chains) = likely(marked, candidates);
    let cost = chains.iter().map(|chain| chain.as_ref().map(|chain| chain.cost)).sum::<Option<f64>>()?;
    Some((names, cost))
}

/// The plates look at each other's ribs in turn. Where candidates may be on either, each takes from the other what it is named first: then the
/// cheapest names of three beginnings.
fn likely(marked: Marked, candidates: &[Candidate]) -> (Names, [Option<Named>; 2]) {
    const FRONT_FIRST: [Plate; 2] = [Plate::Front, Plate::Back];
    let none: Names = vec![None; marked.finger.key_node_count()];
    let found = in_turn(marked, candidates, FRONT_FIRST, none.clone());
    if !candidates.iter().any(|candidate| candidate.sides == [true; 2]) {
        return found;
    }
    let back_first = in_turn(marked, candidates, [Plate::Back, Plate::Front], none);
    let ribs_first = in_turn(marked, candidates, FRONT_FIRST, ribs::names_of_ribs(marked, candidates));
    let cost = |(_, chains): &(Names, [Option<Named>; 2])| {
        chains.iter().map(|chain| chain.as_ref().map_or(f64::INFINITY, |chain| chain.cost)).sum::<f64>()
    };
    [back_first, ribs_first]
        .into_iter()
        .fold(found, |best, other| if cost(&other) < cost(&best) { other } else { best })
}

fn in_turn(
    marked: Marked,
    candidates: &[Candidate],
    order: [Plate; 2],
    mut names: Names,
) -> (Names, [Option<Named>; 2]) {
    let mut chains = [None, None];
    for _ in 0..ROUNDS {
        for plate in order {
            let question = Chain::new(marked, plate, candidates, &names);
            let Some(found) = question.cheapest() else { continue };
            question.write(&found, &mut names);
            chains[usize::from(plate == Plate::Back)] = Some(found);
        }
    }
    (names, chains)
}

/// Names the candidates.
pub(super) fn name(marked: Marked, candidates: &[Candidate]) -> Result<Names, NamingError> {
    let (mut names, chains) = likely(marked, candidates);
    for plate in [Plate::Front, Plate::Back] {
        let Some(best) = &chains[usize::from(plate == Plate::Back)] else { continue };
        let question = Chain::new(marked, plate, candidates, &names);
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
    let nodes = marked.finger.marked_nodes();
    let all = nodes.len();
    let found = nodes.filter(|node| names[node.0 - 1].is_some()).count();
    let least = (all / 3).max(all.min(3));
    if found < least { Err(NamingError::TooFew { found, all, least }) } else { Ok(names) }
}

/// The question of one plate.
struct Chain<'a> {
    marked: Marked<'a>,
    plate: Plate,
    candidates: &'a [Candidate],
    /// From the base to the tip, with positions along the plate, mm.
    nodes: Vec<NodeId>,
    lengths_mm: Vec<f64>,
    /// By node, the position of the rib's other end where it is named, mm, and the rib's length, mm.
    ribs: Vec<Option<Vector>>,
    ribs_mm: Vec<f64>,
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
    /// From the position before, mm.
    step: Vector,
    from: usize,
    cost: f64,
}

impl<'a> Chain<'a> {
    fn new(marked: Marked<'a>, plate: Plate, candidates: &'a [Candidate], names: &Names) -> Chain<'a> {
        let finger = marked.finger;
        let nodes = finger.plate_nodes(plate);
        let lengths_mm = finger.plate_positions_mm(plate);
        let at = |node: NodeId| names[node.0 - 1].map(|candidate| candidates[candidate].at);
        let (mut ribs, mut ribs_mm) = (vec![None; nodes.len()], vec![0.0; nodes.len()]);
        for rib in 0..finger.rib_count() {
            let [front, back] = finger.rib_nodes(rib);
            let other = if plate == Plate::Front { back } else { front };
            ribs_mm[rib + 1] = (marked.position(front) - marked.position(back)).norm();
            ribs[rib + 1] = at(other);
        }
        // The tip ends the back plate as well: its last segment holds it as a rib would.
        if plate == Plate::Front {
            let before = NodeId(finger.tip().0 - 1);
            ribs_mm[nodes.len() - 1] = (marked.position(before) - finger.position(finger.tip())).norm();
            ribs[nodes.len() - 1] = at(before);
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
                marked.finger.has_marker(nodes[position])
                    && candidate.sides[side as usize]
                    && candidate.node.is_none_or(|node| node == nodes[position])
            };
            let of_side = |i: &usize| may_be(&candidates[*i]) && !taken.contains(i);
            (0..candidates.len()).filter(of_side).collect()
        });
        Chain { marked, plate, candidates, choices: choices.collect(), nodes, lengths_mm, ribs, ribs_mm }
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
        let finger = self.marked.finger;
        let base = finger.base(self.plate);
        let allowed = |position: usize, candidate: usize| without != Some((position, candidate));
        let plate_mm = self.lengths_mm[self.nodes.len() - 1];
        let largest_mm = CLAMPED * plate_mm;
        let clamped = self.choices[0].iter().copied().filter(|&c| allowed(0, c));
        let clamped = clamped.map(|c| (c, (self.candidates[c].at - base).norm()));
        let clamped = clamped.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, away)| *away < largest_mm);
        let unseen = if finger.has_marker(self.nodes[0]) { HIDDEN } else { 0.0 };
        let start = clamped.map_or(unseen, |(_, away)| (away / (0.5 * largest_mm)).powi(2));
        let mut links: Vec<Link> = Vec::new();
        // Links that end at each position.
        let mut ending: Vec<Vec<usize>> = vec![Vec::new(); self.nodes.len()];
        let along = (self.marked.position(self.nodes[1]) - base).normalize();
        let mut best: Vec<(usize, f64, usize)> = Vec::new();
        for position in 1..self.nodes.len() {
            for &candidate in &self.choices[position] {
                if !allowed(position, candidate) || clamped.is_some_and(|(c, _)| c == candidate) {
                    continue;
                }
                let at = self.candidates[candidate].at;
                let rib = self.rib_cost(position, &at) + self.candidates[candidate].cost;
                if position <= MOST_SKIPPED + 1
                    && let Some(cost) = self.step_cost(0, position, &(at - base))
                    && let Some(turn) = self.first_turn_cost(&along, &(at - base), self.lengths_mm[position])
                {
                    let cost = start + cost + turn + rib;
                    if cost <= most {
                        ending[position].push(links.len());
                        links.push(Link { position, candidate, before: None, step: at - base, from: 0, cost });
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
                        let Some(cost) = self.step_cost(before, position, &step) else { continue };
                        let known = best.iter().position(|(candidate, _, _)| *candidate == last.candidate);
                        let to_beat = known.map_or(most, |entry| best[entry].1);
                        let straight = last.cost + cost + rib;
                        if straight > to_beat {
                            continue;
                        }
                        let apart_mm = (self.lengths_mm[position] - self.lengths_mm[last.from]) / 2.0;
                        let Some(turn) = turn_cost(&last.step, &step, (apart_mm / plate_mm, 0.0)) else { continue };
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
                        links.push(Link { position, candidate, before: Some(link), step, from: before, cost });
                    }
                }
            }
        }
        let last = self.nodes.len() - 1;
        // The tip costs nothing where it has no marker.
        let hidden = |from: usize| (from + 1..=last).filter(|k| finger.has_marker(self.nodes[*k])).count();
        let whole = |link: &Link| link.cost + HIDDEN * hidden(link.position) as f64;
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
        let length_mm = self.lengths_mm[to] - self.lengths_mm[from];
        let ratio = step.norm() / length_mm;
        // Hinges are off the plate, and the base may be off its place.
        let turn_rad = TURN_DEG.to_radians() * length_mm / self.lengths_mm[self.nodes.len() - 1];
        let brackets_mm = self.marked.finger.marker_offset(self.nodes[to]).norm() * turn_rad;
        let base_mm = if from == 0 { self.marked.base_sd_mm } else { 0.0 };
        let slack = brackets_mm.hypot(base_mm) / length_mm;
        if !(CHORDS[0] - 2.0 * slack..=CHORDS[1] + 2.0 * slack).contains(&ratio) {
            return None;
        }
        let segments = (to - from) as f64;
        let unit = slack.hypot(if ratio > 1.0 { LONGER } else { SHORTER * segments });
        Some(((ratio - 1.0) / unit).powi(2) + HIDDEN * (segments - 1.0))
    }

    /// Cost of the turn from the clamped end to the first step, whose direction is as uncertain as the base.
    fn first_turn_cost(&self, along: &Vector, step: &Vector, apart_mm: f64) -> Option<f64> {
        let base_deg = (self.marked.base_sd_mm / step.norm()).atan().to_degrees();
        turn_cost(along, step, (apart_mm / self.lengths_mm[self.nodes.len() - 1], base_deg))
    }

    fn rib_cost(&self, position: usize, at: &Vector) -> f64 {
        self.ribs[position].map_or(0.0, |other| self.length_cost(position, (at - other).norm()).min(RIB_MOST))
    }

    /// Cost of the length of the rib at a position, mm. At the tip it is the other plate's last segment, which does not stretch either.
    fn length_cost(&self, position: usize, found_mm: f64) -> f64 {
        let is_tip = position + 1 == self.nodes.len();
        let is_rigid = self.marked.finger.description().ribs.strip.is_none() && !is_tip;
        let rib = if is_rigid { RIGID_RIB } else { RIB };
        let longer = if is_tip { LONGER } else { rib };
        let has_bracket = self.marked.finger.marker_offset(self.nodes[position]) != Vector::zeros();
        let excess = found_mm / self.ribs_mm[position] - 1.0;
        let brackets = if has_bracket { BRACKET_MM / self.ribs_mm[position] } else { 0.0 };
        (excess / brackets.hypot(if excess > 0.0 { longer } else { rib })).powi(2)
    }
}

/// Cost of a turn between two steps whose middles are a share of the plate apart; `None` if the plate would break. The turn that costs 1 is
/// larger where a direction has a standard deviation of its own, degrees.
fn turn_cost(before: &Vector, step: &Vector, (share, sd_deg): (f64, f64)) -> Option<f64> {
    let unit_deg = (TURN_DEG * share).hypot(sd_deg);
    let turn_deg = turn_deg(before, step);
    (turn_deg <= LARGEST_TURN_DEG.min(LARGEST_TURN * unit_deg)).then(|| (turn_deg / unit_deg).powi(2))
}

fn turn_deg(before: &Vector, step: &Vector) -> f64 {
    before.perp(step).atan2(before.dot(step)).abs().to_degrees()
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
            (motion.node, Candidate { sides: [is_front, !is_front], at, node: None, cost: 0.0 })
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
                        seen.push((NodeId(0), Candidate { sides: [is_front, !is_front], at, node: None, cost: 0.0 }));
                    }
                }
                let candidates: Vec<Candidate> = seen.iter().map(|(_, candidate)| *candidate).collect();
                all += nodes;
                let Ok(names) = name(Marked::at_base(&finger), &candidates) else { continue };
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
        assert_eq!(
            name(Marked::at_base(&finger), &candidates),
            Err(NamingError::TooFew { found: 4, all: 23, least: 7 })
        );
        assert!(matches!(name(Marked::at_base(&finger), &[]), Err(NamingError::TooFew { found: 0, .. })));
    }

    /// A copy of every marker of a plate beside it: which one is the marker is not known, so neither is named.
    #[test]
    fn two_ways_to_name_are_refused() {
        let finger = Scene::from_toml(PAPER_SCENE).expect("a scene").finger;
        let seen = markers(&finger, &mut ChaCha8Rng::seed_from_u64(2), 1.0).expect("a shape");
        let mut candidates: Vec<Candidate> = seen.iter().map(|(_, candidate)| *candidate).collect();
        let copies = candidates.clone();
        candidates.extend(copies.iter().map(|marker| Candidate { at: marker.at + Vector::new(0.0, 0.5), ..*marker }));
        match name(Marked::at_base(&finger), &candidates) {
            Err(NamingError::Ambiguous { .. } | NamingError::TooFew { .. }) => {}
            other => panic!("{other:?}"),
        }
    }
}
