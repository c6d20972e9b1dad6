//! Criteria that turn computed figures into verdicts: one small function for each criterion, with its reason.

use super::ClaimVerdict::{
    self, Depends, InSimulation, LessInSimulation, NotReproduced, NotTested, Refuted, Reproduced,
};

/// Verdict on a statement about the finger's mechanics, which the model can confirm or contradict.
pub fn statement(holds: bool) -> ClaimVerdict {
    if holds { Reproduced } else { Refuted }
}

/// Verdict on a measured figure. If the computed figure differs from the measured figure, the model lacks an effect; the measurement is not refuted.
pub fn figure(same: bool) -> ClaimVerdict {
    if same { Reproduced } else { NotReproduced }
}

/// Verdict on a relative error. `ours` was computed on a simulated finger whose model is known; `paper` was measured on a real finger. If `ours` is
/// smaller, it shows the potential of sensing with a correct model, and does not contradict the measurement.
pub fn simulated(ours: f64, paper: f64) -> ClaimVerdict {
    if ours < paper { LessInSimulation } else { NotReproduced }
}

/// Combined verdict over pairs of errors. Each pair contains our error and the paper's error. Without pairs the claim is not tested.
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

/// Combined verdict over several assumptions, because the paper does not state which assumption holds.
pub fn over_assumptions(verdicts: &[ClaimVerdict]) -> ClaimVerdict {
    match verdicts {
        [] => NotTested,
        [first, others @ ..] if others.iter().all(|other| other == first) => *first,
        _ => Depends,
    }
}

/// Number of nodes at which a qualitative statement holds, and whether these nodes are the majority.
pub fn at_most_nodes(figures: &[f64], holds: impl Fn(f64) -> bool) -> (usize, bool) {
    let count = figures.iter().filter(|figure| holds(**figure)).count();
    (count, 2 * count > figures.len())
}

/// Displacements agree if their relative difference is below this value (paper, sec. III: "negligible").
pub const NEGLIGIBLE_SHARE: f64 = 0.015;
/// A finer mesh is unnecessary if the relative change of the displacements is below this value (paper, sec. III).
pub const MESH_SHARE: f64 = 0.0026;
/// Largest relative error that rounds to the paper's "about 2.4%", dimensionless.
pub const DIRECTION_SHARE: f64 = 0.0245;
/// A relative force error up to this value is negligible (paper, sec. V-C, on the direction). The limit also applies to errors caused by torques.
pub const NEGLIGIBLE_FORCE_SHARE: f64 = 0.024;
/// A loss of accuracy counts as large above this relative error. The paper's Table I shades errors above this value.
pub const MUCH_SHARE: f64 = 0.10;
/// A force component counts as well estimated up to this standard deviation, N: a tenth of the gripper tests' largest force, 3 N.
pub const WELL_N: f64 = 0.3;
/// Single errors of Table I count as equal up to this difference, dimensionless: the scatter of the six errors at node 14.
pub const SAME_ERROR: f64 = 0.05;
/// A cause accounts for an error if it explains more than this share of the error.
pub const MOST_OF: f64 = 0.5;
/// Range of Young's modulus of TPU quoted by the paper (sec. II), MPa.
pub const TPU_MPA: [f64; 2] = [10.0, 1000.0];

/// Whether a cause alone produces most of each error. Each pair contains our error and the paper's error. False without pairs.
pub fn accounts_for(pairs: &[(f64, f64)]) -> bool {
    !pairs.is_empty() && pairs.iter().all(|(ours, paper)| *ours > MOST_OF * paper)
}

/// Verdict, in simulation, on the claim about recalibration with all nodes. The claim holds if errors grow in the middle of the finger and shrink at
/// its ends. Each array contains the mean errors before and after recalibration.
pub fn recalibration(middle: [f64; 2], ends: [f64; 2]) -> ClaimVerdict {
    in_simulation(middle[1] > middle[0] && ends[1] < ends[0])
}
