//! Naming of both plates at once, as the chain of ribs with the least cost. A rib is a pair of candidates whose distance is close to the rib's length.
//!
//! If no colour distinguishes the plates, naming one plate alone may take markers of the other plate. Few pairs of candidates have the length of a rib, and
//! successive pairs of a chain share no candidate.

use super::chain::{Chain, HIDDEN, MOST_SKIPPED, turn_cost};
use super::{Candidate, Marked, Names};
use finray_model::Vector;
use finray_model::finger::Plate;

/// Two candidates are a pair only if the cost of their distance is at most this. The value is the cost of a length error that is three times as large
/// as the error with cost 1.
const MOST_OF_RIB: f64 = 9.0;
/// At most this number of pairs is considered for a rib, those with the best lengths first.
const MOST_PAIRS: usize = 64;

/// A partial chain of ribs, represented by its last rib.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// Number of the last rib, counted from 1 at the base.
    rib: usize,
    /// Indices of the candidates that are the front and the back end of the last rib.
    pair: [usize; 2],
    /// Index of the previous link of the chain; `None` for the first link.
    before: Option<usize>,
    /// Vectors from the chain's previous rib to its last rib, along the front and the back plate, mm.
    steps: [Vector; 2],
    /// Number of the previous rib, counted from 1 at the base; 0 for the base itself.
    from: usize,
    /// Cost of the partial chain, dimensionless.
    cost: f64,
}

/// Candidates for the ends of the ribs, by key node; all `None` if no rib is found.
pub(super) fn names_of_ribs(marked: Marked, candidates: &[Candidate]) -> Names {
    let finger = marked.finger;
    let none: Names = vec![None; finger.key_node_count()];
    let chains = [Plate::Front, Plate::Back].map(|plate| Chain::new(marked, plate, candidates, &none));
    let ribs = finger.rib_count();
    let bases = [Plate::Front, Plate::Back].map(|plate| finger.base(plate));
    let plates_mm = [0, 1].map(|side: usize| chains[side].lengths_mm[ribs + 1]);
    let mut links: Vec<Link> = Vec::new();
    let mut ending: Vec<Vec<usize>> = vec![Vec::new(); ribs + 1];
    for rib in 1..=ribs {
        for (pair, of_rib) in pairs(&chains, candidates, rib) {
            let at = pair.map(|candidate| candidates[candidate].at);
            if rib <= MOST_SKIPPED + 1 {
                let cost = [0, 1].into_iter().try_fold(of_rib, |sum, side| {
                    let (chain, step) = (&chains[side], at[side] - bases[side]);
                    let along = (chain.marked.position(chain.nodes[1]) - bases[side]).normalize();
                    Some(
                        sum + chain.step_cost(0, rib, &step)?
                            + chain.first_turn_cost(&along, &step, chain.lengths_mm[rib])?,
                    )
                });
                if let Some(cost) = cost {
                    ending[rib].push(links.len());
                    links.push(Link {
                        rib,
                        pair,
                        before: None,
                        steps: [at[0] - bases[0], at[1] - bases[1]],
                        from: 0,
                        cost,
                    });
                }
            }
            for before in rib.saturating_sub(MOST_SKIPPED + 1).max(1)..rib {
                // Chains with the same last step continue in the same way, so only the cheapest chain per previous pair is kept.
                let mut best: Vec<([usize; 2], Link)> = Vec::new();
                for &index in &ending[before] {
                    let last = links[index];
                    if last.pair.iter().any(|candidate| pair.contains(candidate)) {
                        continue;
                    }
                    let steps = [0, 1].map(|side| at[side] - candidates[last.pair[side]].at);
                    let cost = [0, 1].into_iter().try_fold(last.cost + of_rib, |sum, side| {
                        let chain = &chains[side];
                        let apart_mm = (chain.lengths_mm[rib] - chain.lengths_mm[last.from]) / 2.0;
                        let turn = turn_cost(&last.steps[side], &steps[side], (apart_mm / plates_mm[side], 0.0))?;
                        Some(sum + chain.step_cost(before, rib, &steps[side])? + turn)
                    });
                    let Some(cost) = cost else { continue };
                    let link = Link { rib, pair, before: Some(index), steps, from: before, cost };
                    match best.iter_mut().find(|(known, _)| *known == last.pair) {
                        Some((_, known)) if known.cost <= cost => {}
                        Some((_, known)) => *known = link,
                        None => best.push((last.pair, link)),
                    }
                }
                for (_, link) in best {
                    ending[rib].push(links.len());
                    links.push(link);
                }
            }
        }
    }
    let whole = |link: &Link| link.cost + 2.0 * HIDDEN * (ribs - link.rib) as f64;
    let best = (0..links.len()).min_by(|&a, &b| whole(&links[a]).total_cmp(&whole(&links[b])));
    let mut names = none;
    let mut at = best;
    while let Some(link) = at.map(|index| links[index]) {
        for (chain, candidate) in chains.iter().zip(link.pair) {
            names[chain.nodes[link.rib].0 - 1] = Some(candidate);
        }
        at = link.before;
    }
    names
}

/// Pairs of candidates that may be the front and the back end of a rib, each with its cost.
fn pairs(chains: &[Chain; 2], candidates: &[Candidate], rib: usize) -> Vec<([usize; 2], f64)> {
    let mut pairs: Vec<([usize; 2], f64)> = Vec::new();
    for &front in &chains[0].choices[rib] {
        for &back in chains[1].choices[rib].iter().filter(|back| **back != front) {
            let cost = chains[0].length_cost(rib, (candidates[front].at - candidates[back].at).norm());
            if cost <= MOST_OF_RIB {
                pairs.push(([front, back], cost + candidates[front].cost + candidates[back].cost));
            }
        }
    }
    pairs.sort_by(|a, b| a.1.total_cmp(&b.1));
    pairs.truncate(MOST_PAIRS);
    pairs
}
