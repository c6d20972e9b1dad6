//! Naming: assignment of markers to nodes, by their order along the plates and the possible shapes of a finger.
//!
//! A plate keeps its length and bends gently, and a rib nearly keeps its length. Each plate is a chain of markers that starts at the clamped node, whose
//! position is known. The chain with the least cost is chosen. Unlikely distances, unlikely bends and hidden nodes add to the cost of a chain. No initial shape
//! is needed.

mod chain;
mod ribs;

use chain::{Chain, Named};
use finray_model::finger::Plate;
use finray_model::{Finger, NodeId, Vector};

/// A measured disc that may be a marker.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Whether the candidate's colour allows the front plate, and whether it allows the back plate.
    pub sides: [bool; 2],
    /// Position of the candidate's centre, mm, finger frame.
    pub at: Vector,
    /// The only node to which this candidate may be assigned, known from the previous image; `None` if any node is possible.
    pub node: Option<NodeId>,
    /// Additional cost if this candidate is assigned to a node, dimensionless; the larger, the less the candidate looks like a marker.
    pub cost: f64,
}

/// Another chain counts as equally good if its cost exceeds the least cost by at most this (dimensionless).
const ALIKE: f64 = 4.0;
/// Equally good chains may differ at up to this number of nodes; those nodes get no marker. If the chains differ at more nodes, the assignment is rejected as
/// ambiguous.
const MOST_DOUBTFUL: usize = 1;
/// Number of rounds. Each round assigns the markers of both plates in turn, and takes the latest assignment of the other plate as given.
const ROUNDS: usize = 3;

/// Reason why markers cannot be assigned to nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NamingError {
    /// Too few markers fit the finger.
    #[error("found {found} of {all} markers on the free nodes, expected at least {least}")]
    TooFew {
        /// Number of free nodes to which a marker was assigned.
        found: usize,
        /// Number of free nodes that have a marker.
        all: usize,
        /// Smallest number of markers with which a finger is recognised.
        least: usize,
    },
    /// Two positions of the base fit the markers equally well.
    #[error("two positions of the base fit equally well, but assign different markers to {nodes} nodes")]
    Places {
        /// Number of nodes whose markers differ between the two positions.
        nodes: usize,
    },
    /// Two assignments of the markers fit equally well.
    #[error("two assignments of markers to nodes fit equally well: they differ at {nodes} nodes of the {plate} plate")]
    Ambiguous {
        /// Number of nodes whose markers differ between the two assignments.
        nodes: usize,
        /// Name of the plate with these nodes.
        plate: &'static str,
    },
}

/// For each key node, in the order of node numbers: index of the candidate that is its marker; `None` if no candidate is its marker.
pub(super) type Names = Vec<Option<usize>>;

/// A finger whose base may have an uncertain position.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marked<'f> {
    pub finger: &'f Finger,
    /// Standard deviation of the base's position, mm; zero if the pose is known.
    pub base_sd_mm: f64,
}

impl<'f> Marked<'f> {
    /// A finger whose base is exactly where the scene's camera pose puts it.
    pub fn at_base(finger: &'f Finger) -> Marked<'f> {
        Marked { finger, base_sd_mm: 0.0 }
    }

    fn position(&self, node: NodeId) -> Vector {
        self.finger.marker_position(node)
    }
}

/// Assigns the candidates to nodes at the least cost, without checking for equally good assignments.
pub(super) fn name_likely(marked: Marked, candidates: &[Candidate]) -> Names {
    likely(marked, candidates).0
}

/// Same as [`name_likely`]; also returns the cost. `None` if one of the plates has no possible chain.
pub(super) fn name_at_cost(marked: Marked, candidates: &[Candidate]) -> Option<(Names, f64)> {
    let (names, chains) = likely(marked, candidates);
    let cost = chains.iter().map(|chain| chain.as_ref().map(|chain| chain.cost)).sum::<Option<f64>>()?;
    Some((names, cost))
}

/// Assigns both plates in turn. The cost of a plate includes the length errors of the ribs whose other ends already have a marker on the other plate.
/// If a candidate may belong to either plate, the plate that is assigned first may take markers of the other plate. If a candidate may belong to
/// either plate, three starting points are tried, and the cheapest result is used.
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

/// Assigns the candidates to nodes at the least cost, and rejects ambiguous assignments.
pub(super) fn name(marked: Marked, candidates: &[Candidate]) -> Result<Names, NamingError> {
    let (mut names, chains) = likely(marked, candidates);
    for plate in [Plate::Front, Plate::Back] {
        let Some(best) = &chains[usize::from(plate == Plate::Back)] else { continue };
        let question = Chain::new(marked, plate, candidates, &names);
        // The least cost is computed again, with the final assignment of the other plate.
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

    /// Simulates measured markers of a random shape, each with its node.
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

    /// Checks that every assigned marker gets its correct node, for three fingers with large deflections, hidden markers, and false markers of the same
    /// colours. If nodes are 20 to 40 mm apart, up to 0.2 % of the assignments may be wrong, because a false marker may replace a hidden one.
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
                    // False markers keep a distance from true markers, because overlapping discs are measured as a single disc or not at all.
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
            // Rejected shapes and omitted markers count as not assigned.
            assert!(f64::from(named) > 0.97 * all as f64, "{named} of {all}");
        }
    }

    #[test]
    fn too_few_markers_are_no_finger() {
        let finger = Scene::from_toml(PAPER_SCENE).expect("a scene").finger;
        let mut seen = markers(&finger, &mut ChaCha8Rng::seed_from_u64(1), 2.0).expect("a shape");
        seen.truncate(5);
        let candidates: Vec<Candidate> = seen.iter().map(|(_, candidate)| *candidate).collect();
        // The five markers are at nodes 1 to 5; one of these nodes is clamped and does not count.
        assert_eq!(
            name(Marked::at_base(&finger), &candidates),
            Err(NamingError::TooFew { found: 4, all: 23, least: 7 })
        );
        assert!(matches!(name(Marked::at_base(&finger), &[]), Err(NamingError::TooFew { found: 0, .. })));
    }

    /// Adds a copy beside every marker. The copies make the true markers ambiguous, so the assignment is refused.
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
