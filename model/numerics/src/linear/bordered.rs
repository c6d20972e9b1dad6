//! Linear equations for a step along an equilibrium path: the tangent stiffness, bordered by the loads and by the constraint on the step length.

use super::IndefiniteFactor;

/// A change of the unknowns and of the load multiple.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Change of each unknown, mm or rad.
    pub unknowns: Vec<f64>,
    /// Change of the load multiple, dimensionless.
    pub multiple: f64,
}

impl Direction {
    /// Returns the direction multiplied by a factor.
    pub fn scaled(&self, length: f64) -> Direction {
        Direction { unknowns: self.unknowns.iter().map(|u| u * length).collect(), multiple: self.multiple * length }
    }

    /// Adds another direction to this one.
    pub fn add(&mut self, other: &Direction) {
        for (u, v) in self.unknowns.iter_mut().zip(&other.unknowns) {
            *u += v;
        }
        self.multiple += other.multiple;
    }
}

/// The matrix [K, -f; c^T, d], with the factored tangent stiffness K, the forces f of the loads at multiple 1, and the constraint (c, d).
///
/// At a limit point K is singular, and plain block elimination loses digits. Mixed block elimination (BEM) splits the load multiple into two parts,
/// of which the second corrects the first. Mixed block elimination loses no digits even if K is nearly singular.
///
/// # Requirements
/// K is symmetric and has at most one eigenvalue near zero. The constraint is not orthogonal to the path.
///
/// # Reference
/// W. Govaerts, Stable solvers and block elimination for bordered systems, SIAM J. Matrix Anal. Appl. 12 (1991)
/// 469-483: algorithm BEM.
pub struct Bordered<'a> {
    factor: &'a IndefiniteFactor,
    load_vector: &'a [f64],
    constraint: &'a Direction,
    /// K^-1 c, also used as c^T K^-1 because K is symmetric.
    by_constraint: Vec<f64>,
    /// K^-1 (-f), for the forces f of the loads at multiple 1.
    by_loads: Vec<f64>,
    /// Schur complement d + c^T K^-1 f, computed once from `by_constraint` and once from `by_loads`.
    pivots: [f64; 2],
}

impl<'a> Bordered<'a> {
    /// Eliminates K. Returns `None` if a result is not finite.
    pub fn new(
        factor: &'a IndefiniteFactor,
        load_vector: &'a [f64],
        constraint: &'a Direction,
    ) -> Option<Bordered<'a>> {
        let mut by_constraint = constraint.unknowns.clone();
        factor.solve_in_place(&mut by_constraint)?;
        let mut by_loads: Vec<f64> = load_vector.iter().map(|f| -f).collect();
        factor.solve_in_place(&mut by_loads)?;
        let pivots = [
            constraint.multiple + dot(&by_constraint, load_vector),
            constraint.multiple - dot(&constraint.unknowns, &by_loads),
        ];
        Some(Bordered { factor, load_vector, constraint, by_constraint, by_loads, pivots })
    }

    /// Solves for the right-hand side (`forces`, `length`): one force per equation, and the length of the step. Returns `None` if the result is not finite.
    pub fn solve(&self, forces: &[f64], length: f64) -> Option<Direction> {
        let first = (length - dot(&self.by_constraint, forces)) / self.pivots[0];
        let mut unknowns: Vec<f64> = forces.iter().zip(self.load_vector).map(|(r, f)| r + f * first).collect();
        let rest = length - self.constraint.multiple * first;
        self.factor.solve_in_place(&mut unknowns)?;
        let second = (rest - dot(&self.constraint.unknowns, &unknowns)) / self.pivots[1];
        for (u, w) in unknowns.iter_mut().zip(&self.by_loads) {
            *u -= w * second;
        }
        let multiple = first + second;
        (multiple.is_finite() && unknowns.iter().all(|u| u.is_finite())).then_some(Direction { unknowns, multiple })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
