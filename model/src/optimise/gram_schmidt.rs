//! The linear problem of a step: small dense least squares, solved in place again and again without touching the heap.

/// Minimises |A x - b|, with the columns of A and b stored one after the other.
///
/// # Reference
/// Modified Gram-Schmidt on A with b as its last column, as stable as Householder's reflections (Bjorck, Numerical
/// Methods for Least Squares Problems, sec. 2.4).
#[derive(Debug, Clone, Default)]
pub(crate) struct GramSchmidt {
    rows: usize,
    unknowns: usize,
    /// Columns of A, then b; orthogonalised by [`solve`](GramSchmidt::solve).
    columns: Vec<f64>,
    /// Upper triangle R of A = Q R, column after column.
    triangle: Vec<f64>,
    solution: Vec<f64>,
    /// |A x|^2.
    explained: f64,
}

impl GramSchmidt {
    /// Makes room for a problem and sets it to zero.
    pub(crate) fn reset(&mut self, rows: usize, unknowns: usize) {
        (self.rows, self.unknowns) = (rows, unknowns);
        for (values, count) in [
            (&mut self.columns, rows * (unknowns + 1)),
            (&mut self.triangle, unknowns * unknowns),
            (&mut self.solution, unknowns),
        ] {
            values.clear();
            values.resize(count, 0.0);
        }
    }

    /// A column of A, or b where `column` is the number of unknowns.
    pub(crate) fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.columns[column * self.rows..][..self.rows]
    }

    /// Solves; `None` if the columns are not independent numbers.
    pub(crate) fn solve(&mut self) -> Option<&[f64]> {
        let (rows, unknowns) = (self.rows, self.unknowns);
        for k in 0..unknowns {
            let (done, later) = self.columns.split_at_mut((k + 1) * rows);
            let direction = &mut done[k * rows..];
            let norm = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            if norm.is_nan() || norm <= 0.0 {
                return None;
            }
            direction.iter_mut().for_each(|x| *x /= norm);
            self.triangle[k * unknowns + k] = norm;
            for (column, values) in (k + 1..).zip(later.chunks_exact_mut(rows)) {
                let projected: f64 = direction.iter().zip(&*values).map(|(a, b)| a * b).sum();
                values.iter_mut().zip(&*direction).for_each(|(value, along)| *value -= projected * along);
                match column < unknowns {
                    true => self.triangle[column * unknowns + k] = projected,
                    false => self.solution[k] = projected,
                }
            }
        }
        // Until it is substituted back, the solution holds Q^T b.
        self.explained = self.solution.iter().map(|x| x * x).sum();
        for k in (0..unknowns).rev() {
            for j in k + 1..unknowns {
                self.solution[k] -= self.triangle[j * unknowns + k] * self.solution[j];
            }
            self.solution[k] /= self.triangle[k * unknowns + k];
        }
        self.solution.iter().all(|x| x.is_finite()).then_some(&self.solution)
    }

    /// |A x|^2 of the solution x: by so much it makes |b|^2 smaller.
    pub(crate) fn explained(&self) -> f64 {
        self.explained
    }

    /// R of A = Q R, column after column.
    pub(crate) fn triangle(&self) -> &[f64] {
        &self.triangle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fit of a line and a parabola to five points, by hand: y = 1 + 2 x - x^2 exactly, plus a part that no column
    /// explains.
    #[test]
    fn fits_what_can_be_fitted() {
        let x = [-2.0_f64, -1.0, 0.0, 1.0, 2.0];
        // Orthogonal to 1, x and x^2.
        let unexplained = [1.0, -2.0, 0.0, 2.0, -1.0];
        let mut problem = GramSchmidt::default();
        problem.reset(5, 3);
        for (i, x) in x.into_iter().enumerate() {
            for power in 0..3 {
                problem.column_mut(power)[i] = x.powi(power as i32);
            }
            problem.column_mut(3)[i] = 1.0 + 2.0 * x - x * x + unexplained[i];
        }
        let solution = problem.solve().map(<[f64]>::to_vec).unwrap_or_default();
        for (found, expected) in solution.iter().zip([1.0, 2.0, -1.0]) {
            assert!((found - expected).abs() < 1e-14, "{solution:?}");
        }
        assert_eq!(solution.len(), 3);
        // (1 + 2 x - x^2)^2 at the five points.
        let explained = 49.0 + 4.0 + 1.0 + 4.0 + 1.0;
        assert!((problem.explained() - explained).abs() < 1e-12);
    }

    #[test]
    fn dependent_columns_have_no_solution() {
        let mut problem = GramSchmidt::default();
        problem.reset(2, 1);
        problem.column_mut(1).fill(1.0);
        assert!(problem.solve().is_none());
    }
}
