//! From figures to verdicts: every criterion with its reason, each a small function.

use super::ClaimVerdict::{
    self, Depends, InSimulation, LessInSimulation, NotReproduced, NotTested, Refuted, Reproduced,
};

/// A statement about the finger's mechanics, which its model can bear out or contradict.
pub fn statement(holds: bool) -> ClaimVerdict {
    if holds { Reproduced } else { Refuted }
}

/// A measured figure: that our computation does not give it says that what it contains does not suffice.
pub fn figure(same: bool) -> ClaimVerdict {
    if same { Reproduced } else { NotReproduced }
}

/// An error on a simulated finger whose model is known against one measured on a real finger: if smaller, it shows what sensing could
/// reach if the model were right, and says nothing against the measurement.
pub fn simulated(ours: f64, paper: f64) -> ClaimVerdict {
    if ours < paper { LessInSimulation } else { NotReproduced }
}

/// The same of several errors; none is no test.
pub fn all_simulated(pairs: &[(f64, f64)]) -> ClaimVerdict {
    match pairs {
        [] => NotTested,
        pairs if pairs.iter().all(|(ours, paper)| simulated(*ours, *paper) == LessInSimulation) => LessInSimulation,
        _ => NotReproduced,
    }
}

/// Verdict of a criterion on a simulated finger.
pub fn in_simulation(holds: bool) -> ClaimVerdict {
    if holds { InSimulation } else { NotReproduced }
}

/// The verdict under each of several assumptions between which the paper leaves the choice.
pub fn over_assumptions(verdicts: &[ClaimVerdict]) -> ClaimVerdict {
    match verdicts {
        [] => NotTested,
        [first, others @ ..] if others.iter().all(|other| other == first) => *first,
        _ => Depends,
    }
}

/// A statement without a figure about nodes in general: it holds if it does at more than half of them.
pub fn at_most_nodes(figures: &[f64], holds: impl Fn(f64) -> bool) -> (usize, bool) {
    let count = figures.iter().filter(|figure| holds(**figure)).count();
    (count, 2 * count > figures.len())
}

/// Largest difference of displacements that the paper calls negligible (sec. III).
pub const NEGLIGIBLE_SHARE: f64 = 0.015;
/// Largest difference between meshes of which the paper concludes that a finer one is not necessary (sec. III).
pub const MESH_SHARE: f64 = 0.0026;
/// What "about 2.4%" can mean, as it is rounded.
pub const DIRECTION_SHARE: f64 = 0.0245;
/// A force error that the paper calls negligible (sec. V-C, of the direction): the bound for torques too.
pub const NEGLIGIBLE_FORCE_SHARE: f64 = 0.024;
/// The lighter shade of the paper's Table I begins here: "accuracy" lost beyond it is much.
pub const MUCH_SHARE: f64 = 0.10;
/// A component of the force is estimated well where its standard deviation is a tenth of the gripper tests' largest force, 3 N.
pub const WELL_N: f64 = 0.3;
/// Single errors of Table I are the same if they differ by less: the six at node 14 scatter by so much.
pub const SAME_ERROR: f64 = 0.05;
/// A cause accounts for an error if it gives more than half of it.
pub const MOST_OF: f64 = 0.5;
/// Young's moduli of TPU as the paper quotes them (sec. II), MPa.
pub const TPU_MPA: [f64; 2] = [10.0, 1000.0];

/// Whether a cause gives most of every error, as pairs of ours and the paper's.
pub fn accounts_for(pairs: &[(f64, f64)]) -> bool {
    !pairs.is_empty() && pairs.iter().all(|(ours, paper)| *ours > MOST_OF * paper)
}

/// Recalibration with all nodes, in simulation: worse in the middle and better at the ends, as pairs of mean errors before and after.
pub fn recalibration(middle: [f64; 2], ends: [f64; 2]) -> ClaimVerdict {
    in_simulation(middle[1] > middle[0] && ends[1] < ends[0])
}
