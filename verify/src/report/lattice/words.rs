//! What agrees, what does not, and why, in sentences made from the numbers.

use crate::check::{Check, worst};
use crate::experiments::lattice::LatticeStudy;
use crate::lattice::accuracy::FinenessRow;
use crate::lattice::causes::{AxialRow, SettlingRow};
use crate::lattice::settling::{AT_REST, Precision, SWEEPS};
use crate::problems::lattice::FINENESS;
use crate::report::format::{Span, percent_two_digits as percent};

/// Twice the sweeps that change the distance from the equilibrium by no more than this share do not help.
const NO_NEARER: f64 = 0.2;

/// A difference that falls at least with this power of the segments' length goes to nothing with it; one that does not would stay.
const COARSENESS_ORDER: f64 = 2.0;

/// How near the lattice is to beams, and sensing on it to sensing on the co-rotational finger.
pub(super) fn verdict(lattice: &LatticeStudy) -> Option<String> {
    let finest = lattice.rows.last()?;
    Some(format!(
        "Another discretisation with another solver, a lattice of rigid bodies and springs of the same EA and EI, bends as the beams \
         do within {} of the largest displacement up to {} N; sensing errs on it by what it errs by on the co-rotational finger, within {} \
         of the force.",
        percent(worst(finest.errors.iter().copied())),
        finest.forces_n.last()?,
        percent(lattice.sensing.difference.largest)
    ))
}

pub(super) fn findings(lattice: &LatticeStudy) -> Vec<String> {
    let all = [
        agreement(&lattice.rows),
        linear(lattice),
        sensing(lattice),
        inset(lattice),
        stretching(lattice),
        sweeps(&lattice.settling),
        single_precision(lattice),
    ];
    all.into_iter().flatten().collect()
}

/// Errors of the coarsest and the finest lattice, and the order that they fall by.
fn agreement(rows: &[FinenessRow]) -> Option<String> {
    let (coarsest, finest) = (rows.first()?, rows.last().filter(|_| rows.len() > 1)?);
    let force_n = finest.forces_n.last()?;
    let largest = |row: &FinenessRow| worst(row.errors.iter().copied());
    let refined = (finest.fineness as f64 / coarsest.fineness as f64).ln();
    let orders = coarsest.errors.iter().zip(&finest.errors).map(|(coarse, fine)| (coarse / fine).ln() / refined);
    let Span { least: low, greatest: high, .. } = Span::of(orders)?;
    Some(format!(
        "Shapes: with {} segments a plate member the lattice differs from converged beams by up to {} of the largest \
         displacement under forces up to {force_n} N, with {} by {}: the difference falls with the power {low:.1} to {high:.1} of \
         the segments' length, by the force. {}",
        coarsest.fineness,
        percent(largest(coarsest)),
        finest.fineness,
        percent(largest(finest)),
        match low >= COARSENESS_ORDER {
            true => "What remains is the lattice's coarseness; there is no sign of an error in solver or kinematics.",
            false => "That is too little for the lattice's coarseness alone: something else remains.",
        }
    ))
}

/// How linear theory does where both co-rotational solutions agree.
fn linear(lattice: &LatticeStudy) -> Option<String> {
    let (first, last) = (lattice.linear.first()?, lattice.linear.last()?);
    Some(format!(
        "Linear theory differs from the lattice by {} at {} N and by {} at {} N. Rotations are what it leaves out.",
        percent(first.1),
        first.0,
        percent(last.1),
        last.0
    ))
}

/// The maps of lattice and co-rotational finger, and the nonlinear estimator.
fn sensing(lattice: &LatticeStudy) -> Option<String> {
    let difference = &lattice.sensing.difference;
    let at = difference.at?;
    Some(format!(
        "Sensing{}: least squares on the lattice and on the co-rotational finger give forces that differ by at most {} of \
         the true force over {} cells of their maps (at s = {:.0} mm, {} deg, {} N, where least squares itself errs by {}). The \
         nonlinear estimator, whose model is the co-rotational finger, senses the lattice within {}: the errors in the maps \
         are those of linear theory, not of this finger's model.",
        if lattice.sensing.checks().iter().all(Check::passes) { " agrees" } else { " DOES NOT AGREE" },
        percent(difference.largest),
        difference.cells,
        at.s_mm,
        at.angle_deg,
        at.force_n,
        percent(at.mean_error?),
        percent(lattice.sensing.nonlinear_error())
    ))
}

fn error_at_largest(row: &AxialRow) -> Option<f64> {
    row.errors.as_ref()?.last().copied()
}

/// Where the axial springs are fixed.
fn inset(lattice: &LatticeStudy) -> Option<String> {
    let beams = lattice.axial.first()?;
    let at_ends = lattice.axial.iter().find(|row| row.axial.inset == 0.0)?;
    let (near, far) = (error_at_largest(beams)?, error_at_largest(at_ends)?);
    Some(format!(
        "It matters where axial springs hold. The ends of a segment come nearer when it bends, though it is not stretched; points \
         a sixth of its length inside keep their distance on a circular arc. Fixed at the ends, the springs of {FINENESS} segments \
         a plate member resist bending as well: the difference from beams at {} N grows from {} to {}.",
        lattice.axial_forces_n.last()?,
        percent(near),
        percent(far)
    ))
}

/// Whether plates stretch.
fn stretching(lattice: &LatticeStudy) -> Option<String> {
    let rigid = lattice.axial.iter().find(|row| row.axial.stiffness > 1.0)?;
    let without = lattice.axial.iter().find(|row| row.axial.stiffness == 0.0)?;
    let error = rigid.errors.as_ref()?.first().copied()?;
    let left_out = match without.errors.as_ref().and_then(|errors| errors.last()) {
        None => "Without them nothing holds the bodies along a plate: there is no equilibrium at all.".to_owned(),
        Some(error) => format!("Without them the lattice is {} off.", percent(*error)),
    };
    Some(format!(
        "Members must stretch. With axial springs {} times as stiff, as good as rigid, the lattice is {} off already at {} N, where \
         rotations do not matter: so much of the displacement, where it is most, comes from members that grow longer and shorter, as \
         a V carries a force like a truss. {left_out}",
        rigid.axial.stiffness,
        percent(error),
        lattice.axial_forces_n.first()?
    ))
}

fn settled(rows: &[SettlingRow], positions: Precision, sweeps: usize) -> Option<f64> {
    rows.iter().find(|row| row.positions == positions && row.sweeps == sweeps)?.error
}

/// How soft rapier's joints are, by its sweeps.
fn sweeps(rows: &[SettlingRow]) -> Option<String> {
    let usual = settled(rows, Precision::Double, SWEEPS)?;
    let fewer: Vec<String> = rows
        .iter()
        .filter(|row| row.positions == Precision::Double && row.sweeps < SWEEPS)
        .map(|row| match row.error {
            Some(error) => format!("by {} with {}", percent(error), row.sweeps),
            None => format!("with {} it does not rest at all", row.sweeps),
        })
        .collect();
    let more = settled(rows, Precision::Double, 2 * SWEEPS).map(|more| match (more / usual - 1.0).abs() <= NO_NEARER {
        true => format!(
            "Twice as many bring it no nearer: what remains then is when bodies count as at rest ({AT_REST:.0e} of the largest \
             displacement while the slowest motion takes its course), not softness."
        ),
        false => format!("Twice as many bring it to {}.", percent(more)),
    });
    Some(format!(
        "rapier's joints are soft: the engine solves the springs' forces by so many sweeps a step, and what remains shifts the \
         rest position from the least energy: {}, and by {} with {SWEEPS}, the number used. {}",
        fewer.join(", "),
        percent(usual),
        more.unwrap_or_default()
    ))
}

/// What single precision would cost.
fn single_precision(lattice: &LatticeStudy) -> Option<String> {
    let balance = format!(
        "Rounding the positions of the equilibrium once to single precision puts forces of up to {} of the load out of balance \
         on a body: a bent finger's forces are small differences of large ones.",
        percent(lattice.out_of_balance)
    );
    let Some(double) = settled(&lattice.settling, Precision::Double, SWEEPS) else {
        return Some(format!("Double precision is needed. {balance}"));
    };
    let single = match settled(&lattice.settling, Precision::Single, SWEEPS) {
        Some(single) => {
            let finer = lattice.rows.iter().find(|row| row.errors.last().is_some_and(|error| *error < single));
            let more = finer.map_or_else(String::new, |row| {
                format!(", which is more than {} segments a plate member and finer differ from beams", row.fineness)
            });
            format!("rests up to {} from its equilibrium instead of {}{more}", percent(single), percent(double))
        }
        None => "does not come to rest".to_owned(),
    };
    Some(format!(
        "Double precision is needed. With positions and rotations rounded to 32 bits after each step, and all else in 64, the \
         lattice {single}. {balance} The engine's own build in single precision was not run; it rounds velocities and forces as \
         well."
    ))
}

#[cfg(test)]
mod tests {
    use super::super::samples::sample;
    use super::*;

    #[track_caller]
    fn says(lattice: &LatticeStudy, words: &[&str]) {
        let said = findings(lattice).join("\n");
        for words in words {
            assert!(said.contains(words), "{words} is not in {said}");
        }
    }

    #[test]
    fn findings_are_made_from_the_numbers() {
        let study = sample();
        says(
            &study,
            &[
                "up to 0.16 % of the largest displacement under forces up to 5 N, with 4 by 0.010 %",
                "with the power 3.0 to 4.0",
                "by 10 % at 1 N and by 50 % at 5 N",
                "differ by at most 0.030 % of the true force over 1 cells",
                "senses the lattice within 0.040 %",
                "grows from 0.16 % to 3.0 %",
                "With axial springs 1000 times as stiff, as good as rigid, the lattice is 70 % off already at 1 N",
                "no equilibrium at all",
                "by 2.0 % with 8, by 0.050 % with 16, and by 0.0060 % with 32",
                "Twice as many bring it no nearer",
                "rests up to 0.070 % from its equilibrium instead of 0.0060 %, which is more than 4 segments",
            ],
        );
        let head = verdict(&study).expect("a sentence");
        assert!(head.contains("within 0.010 % of the largest displacement up to 5 N"), "{head}");
    }

    #[test]
    fn other_numbers_are_other_words() {
        let mut study = sample();
        study.settling[3].error = Some(1e-6);
        study.settling[4].error = None;
        study.axial[3].errors = Some(vec![0.9, 0.9]);
        says(
            &study,
            &["Twice as many bring it to 1.0e-4 %", "does not come to rest", "Without them the lattice is 90 % off"],
        );
        study.rows[1].errors = vec![4e-4, 1e-4];
        study.sensing.difference.largest = 0.1;
        says(&study, &["something else remains", "Sensing DOES NOT AGREE"]);
        // A quick study has not settled anything.
        study.settling.clear();
        let said = findings(&study).join("\n");
        assert!(!said.contains("joints are soft") && said.contains("0.060 % of the load out of balance"), "{said}");
    }
}
