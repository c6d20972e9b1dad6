//! From figures to verdicts: one small function for each criterion, with its reason.

use super::ClaimVerdict::{
    self, Depends, InSimulation, LessInSimulation, NotReproduced, NotTested, Refuted, Reproduced,
};

/// Verdict on a statement about the finger's mechanics, which the model can confirm or contradict.
pub fn statement(holds: bool) -> ClaimVerdict {
    if holds { Reproduced } else { Refuted }
}

/// Verdict on a measured figure. If the computation gives another figure, the model lacks an effect; the measurement is not refuted.
pub fn figure(same: bool) -> ClaimVerdict {
    if same { Reproduced } else { NotReproduced }
}

/// Verdict on an error on a simulated finger with known model, against one measured on a real finger. A smaller error shows the potential of
/// sensing with a correct model, and does not contradict the measurement.
pub fn simulated(ours: f64, paper: f64) -> ClaimVerdict {
    if ours < paper { LessInSimulation } else { NotReproduced }
}

/// Verdict on pairs of errors, ours and the paper's; without pairs the claim is not tested.
pub fn all_simulated(pairs: &[(f64, f64)]) -> ClaimVerdict {
    match pairs {
        [] => NotTested,
        pairs if pairs.iter().all(|(ours, paper)| simulated(*ours, *paper) == LessInSimulation) => LessInSimulation,
        _ => NotReproduced,
    }
}

/// Verdict on a criterion evaluated on a simulated finger.
pub fn in_simulation(holds: bool) -> ClaimVerdict {
    if holds { InSimulation } else { NotReproduced }
}

/// Combined verdict over several assumptions, because the paper does not state which holds.
pub fn over_assumptions(verdicts: &[ClaimVerdict]) -> ClaimVerdict {
    match verdicts {
        [] => NotTested,
        [first, others @ ..] if others.iter().all(|other| other == first) => *first,
        _ => Depends,
    }
}

/// Evaluates a qualitative statement about nodes: the number of nodes at which it holds, and whether they are more than half.
pub fn at_most_nodes(figures: &[f64], holds: impl Fn(f64) -> bool) -> (usize, bool) {
    let count = figures.iter().filter(|figure| holds(**figure)).count();
    (count, 2 * count > figures.len())
}

/// Largest relative difference of displacements that the paper calls negligible (sec. III).
pub const NEGLIGIBLE_SHARE: f64 = 0.015;
/// Relative difference between meshes at which the paper considers a finer mesh unnecessary (sec. III).
pub const MESH_SHARE: f64 = 0.0026;
/// Upper rounding limit of the paper's "about 2.4%", as a share.
pub const DIRECTION_SHARE: f64 = 0.0245;
/// Relative force error that the paper calls negligible (sec. V-C, on the direction); also applied to torques.
pub const NEGLIGIBLE_FORCE_SHARE: f64 = 0.024;
/// Relative error above which a loss of accuracy counts as large: the lighter shade of the paper's Table I begins here.
pub const MUCH_SHARE: f64 = 0.10;
/// Standard deviation up to which a force component counts as well estimated, N: a tenth of the gripper tests' largest force, 3 N.
pub const WELL_N: f64 = 0.3;
/// Difference up to which single errors of Table I count as equal, as a share: the scatter of the six errors at node 14.
pub const SAME_ERROR: f64 = 0.05;
/// Share of an error above which a cause accounts for it.
pub const MOST_OF: f64 = 0.5;
/// Range of Young's modulus of TPU quoted by the paper (sec. II), MPa.
pub const TPU_MPA: [f64; 2] = [10.0, 1000.0];

/// Whether a cause gives most of every error; the pairs hold our error and the paper's, and must not be empty.
pub fn accounts_for(pairs: &[(f64, f64)]) -> bool {
    !pairs.is_empty() && pairs.iter().all(|(ours, paper)| *ours > MOST_OF * paper)
}

/// Verdict on recalibration with all nodes, in simulation: worse in the middle and better at the ends. The arrays hold mean errors before and after.
pub fn recalibration(middle: [f64; 2], ends: [f64; 2]) -> ClaimVerdict {
    in_simulation(middle[1] > middle[0] && ends[1] < ends[0])
}
