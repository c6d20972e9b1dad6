//! Naming of the markers of one plate, as the chain of least cost from the plate's clamped node to the tip. A step is the vector from one marker of a chain to
//! the next.

use super::{Candidate, Marked, Names};
use finray_model::finger::Plate;
use finray_model::{NodeId, Vector};

/// Largest number of successive hidden nodes that a chain may skip.
pub(super) const MOST_SKIPPED: usize = 4;
/// Range of the distance between two nodes, relative to the plate length between them. A chord is shorter than its arc, and
/// measured distances scatter.
const CHORDS: [f64; 2] = [0.75, 1.05];
/// A chord that is longer than the plate between its nodes by this share has cost 1.
const LONGER: f64 = 0.015;
/// A chord has cost 1 if it is shorter than the plate between its nodes by this share times the number of segments between them.
const SHORTER: f64 = 0.06;
/// A bend between two steps by this angle, degrees, has cost 1 if the steps are a whole plate length apart. For closer steps, the angle is proportionally
/// smaller.
const TURN_DEG: f64 = 168.0;
/// A chain is excluded if a bend between two of its steps exceeds this multiple of the angle that has cost 1.
const LARGEST_TURN: f64 = 4.3;
/// A chain is excluded if a bend between two of its steps exceeds this angle, degrees.
const LARGEST_TURN_DEG: f64 = 120.0;
/// A rib whose length deviates by this share has cost 1.
const RIB: f64 = 0.05;
/// An undeformable rib whose length deviates by this share has cost 1. The length of an undeformable rib deviates only because of noise and errors of
/// the pose.
const RIGID_RIB: f64 = 0.01;
/// Upper limit of the cost of a rib, so that one rib that buckles or ends at a false marker does not break a chain.
const RIB_MOST: f64 = 12.0;
/// Cost of a hidden node, and cost of a clamped node without a marker at its position.
pub(super) const HIDDEN: f64 = 6.0;
/// A candidate may be the marker of a clamped node only near the stated position: within this distance, as a share of the plate's length.
const CLAMPED: f64 = 0.01;
/// Standard deviation of a bracket's stated length, mm.
const BRACKET_MM: f64 = 0.5;

/// The problem of assigning candidates to the nodes of one plate.
pub(super) struct Chain<'a> {
    pub(super) marked: Marked<'a>,
    plate: Plate,
    candidates: &'a [Candidate],
    /// Nodes of the plate from the base to the tip.
    pub(super) nodes: Vec<NodeId>,
    /// Positions of the nodes along the plate, mm from the base.
    pub(super) lengths_mm: Vec<f64>,
    /// For each node: position of the other end of its rib, mm, finger frame; `None` if no marker is assigned to that end or there is no rib.
    ribs: Vec<Option<Vector>>,
    /// For each node: undeformed length of its rib, mm.
    ribs_mm: Vec<f64>,
    /// For each node: indices of the candidates that may be its marker.
    pub(super) choices: Vec<Vec<usize>>,
}

/// An assignment for one plate: the cost of its chain, and the candidate of each node along the plate.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    /// Cost of the chain, dimensionless.
    pub(super) cost: f64,
    /// Index of the candidate of each node along the plate; `None` for a hidden node.
    pub(super) named: Vec<Option<usize>>,
}

/// A partial chain, represented by its last two nodes.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// Index of the last node, in the order along the plate.
    position: usize,
    /// Index of the candidate at the last node.
    candidate: usize,
    /// Index of the previous link of the chain; `None` for the first link from the clamped node.
    before: Option<usize>,
    /// Vector from the chain's previous candidate to its last candidate, mm; from the base for the first link.
    step: Vector,
    /// Index of the chain's previous node, in the order along the plate; 0 for the clamped node.
    from: usize,
    /// Cost of the partial chain, dimensionless.
    cost: f64,
}

impl<'a> Chain<'a> {
    pub(super) fn new(marked: Marked<'a>, plate: Plate, candidates: &'a [Candidate], names: &Names) -> Chain<'a> {
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
        // The back plate also ends at the tip, and its last segment constrains the position of the tip like a rib.
        if plate == Plate::Front {
            let before = NodeId(finger.tip().0 - 1);
            ribs_mm[nodes.len() - 1] = (marked.position(before) - finger.position(finger.tip())).norm();
            ribs[nodes.len() - 1] = at(before);
        }
        // Candidates that are assigned to the other plate are excluded, except the tip's candidate.
        let other = finger.plate_nodes(if plate == Plate::Front { Plate::Back } else { Plate::Front });
        let taken: Vec<usize> =
            other.iter().filter(|node| **node != finger.tip()).filter_map(|node| names[node.0 - 1]).collect();
        let last = nodes.len() - 1;
        let choices = (0..nodes.len()).map(|position| {
            // The tip has the front plate's colour, and is assigned with the front plate.
            let side = if position == last { Plate::Front } else { plate };
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

    pub(super) fn write(&self, found: &Named, names: &mut Names) {
        for (position, (node, candidate)) in self.nodes.iter().zip(&found.named).enumerate() {
            // The tip is assigned only with the front plate.
            if self.plate == Plate::Front || position + 1 < self.nodes.len() {
                names[node.0 - 1] = *candidate;
            }
        }
    }

    /// The chain with the least cost; `None` if no chain starts at the base.
    pub(super) fn cheapest(&self) -> Option<Named> {
        self.cheapest_within(f64::INFINITY, None)
    }

    /// The chain with the least cost that does not assign the candidate `without.1` to position `without.0`. `None` if every such chain costs more than
    /// `most`.
    pub(super) fn cheapest_within(&self, most: f64, without: Option<(usize, usize)>) -> Option<Named> {
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
        // Indices of the links that end at each position along the plate.
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
                    // Chains with the same last step continue in the same way, so only the cheapest chain per previous candidate is kept.
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
        // A node that carries no marker cannot be hidden, so it adds no cost.
        let hidden = |from: usize| (from + 1..=last).filter(|k| finger.has_marker(self.nodes[*k])).count();
        let whole = |link: &Link| link.cost + HIDDEN * hidden(link.position) as f64;
        let best = (0..links.len()).min_by(|&a, &b| whole(&links[a]).total_cmp(&whole(&links[b])))?;
        let cost = whole(&links[best]);
        (cost <= most).then(|| Named { cost, named: self.named(&links, best, clamped.map(|(candidate, _)| candidate)) })
    }

    /// Candidates of a chain by position along the plate, collected from the last link back to the clamped node.
    fn named(&self, links: &[Link], last: usize, clamped: Option<usize>) -> Vec<Option<usize>> {
        let mut named = vec![None; self.nodes.len()];
        named[0] = clamped;
        let mut at = Some(last);
        while let Some(link) = at.map(|i| links[i]) {
            named[link.position] = Some(link.candidate);
            at = link.before;
        }
        named
    }

    /// Cost of a step between two positions along the plate, including the cost of hidden nodes between them. `None` if the length of the step is impossible.
    pub(super) fn step_cost(&self, from: usize, to: usize, step: &Vector) -> Option<f64> {
        let length_mm = self.lengths_mm[to] - self.lengths_mm[from];
        let ratio = step.norm() / length_mm;
        // Hinges lie beside the plate, and the position of the base may be uncertain. Both the hinges' offset and an uncertain position of the base
        // widen the range of possible step lengths.
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

    /// Cost of the bend between the plate's clamped direction `along` and the first step; `None` if the bend is impossible. An uncertain position of the base
    /// makes the direction of the first step uncertain.
    pub(super) fn first_turn_cost(&self, along: &Vector, step: &Vector, apart_mm: f64) -> Option<f64> {
        let base_deg = (self.marked.base_sd_mm / step.norm()).atan().to_degrees();
        turn_cost(along, step, (apart_mm / self.lengths_mm[self.nodes.len() - 1], base_deg))
    }

    fn rib_cost(&self, position: usize, at: &Vector) -> f64 {
        self.ribs[position].map_or(0.0, |other| self.length_cost(position, (at - other).norm()).min(RIB_MOST))
    }

    /// Cost of the measured length (mm) of the rib at a position along the plate. At the tip, the last segment of the other plate counts as a rib.
    pub(super) fn length_cost(&self, position: usize, found_mm: f64) -> f64 {
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

/// Cost of the bend between two steps; `None` if the bend is impossible. `share` is the distance between the middles of the steps as a share of the plate's
/// length. `sd_deg` is an additional standard deviation of the direction, degrees.
pub(super) fn turn_cost(before: &Vector, step: &Vector, (share, sd_deg): (f64, f64)) -> Option<f64> {
    let unit_deg = (TURN_DEG * share).hypot(sd_deg);
    let turn_deg = turn_deg(before, step);
    (turn_deg <= LARGEST_TURN_DEG.min(LARGEST_TURN * unit_deg)).then(|| (turn_deg / unit_deg).powi(2))
}

fn turn_deg(before: &Vector, step: &Vector) -> f64 {
    before.perp(step).atan2(before.dot(step)).abs().to_degrees()
}
