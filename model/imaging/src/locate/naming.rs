//! Which marker is which node: order along the plates, and what a finger can do.
//!
//! A plate keeps its length and bends gently, and a rib keeps its length nearly: from the clamped node on, whose position is known, each
//! plate is the chain of markers with the least cost, in which a distance, a turn and a hidden node cost what they are unlikely. No
//! guess of the shape is needed.

mod chain;
mod ribs;

use chain::{Chain, Named};
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
        self.finger.marker_position(node)
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
