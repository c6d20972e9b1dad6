//! Small dense linear least squares, solved repeatedly in place without heap allocation.

/// Minimises |A x - b|. The columns of A are stored one after the other, followed by b.
///
/// # Reference
/// Modified Gram-Schmidt with b as the last column (Bjorck, Numerical Methods for Least Squares Problems, sec. 2.4).
#[derive(Debug, Clone, Default)]
pub struct GramSchmidt {
    rows: usize,
    unknowns: usize,
    /// Columns of A, then b; [`solve`](GramSchmidt::solve) orthogonalises them.
    columns: Vec<f64>,
    /// Upper triangle R of A = Q R, column by column.
    triangle: Vec<f64>,
    solution: Vec<f64>,
    /// |A x|^2 at the solution.
    explained: f64,
}

impl GramSchmidt {
    /// Allocates room for `rows` equations and `unknowns` unknowns if needed, and sets all entries to zero.
    pub fn reset(&mut self, rows: usize, unknowns: usize) {
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

    /// Returns the column of A with index `column`, or b if `column` equals the number of unknowns.
    #[inline]
    pub fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.columns[column * self.rows..][..self.rows]
    }

    /// Solves for x; `None` if the columns are linearly dependent or a result is not finite.
    pub fn solve(&mut self) -> Option<&[f64]> {
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
        // Before back substitution, `solution` contains Q^T b.
        self.explained = self.solution.iter().map(|x| x * x).sum();
        for k in (0..unknowns).rev() {
            for j in k + 1..unknowns {
                self.solution[k] -= self.triangle[j * unknowns + k] * self.solution[j];
            }
            self.solution[k] /= self.triangle[k * unknowns + k];
        }
        self.solution.iter().all(|x| x.is_finite()).then_some(&self.solution)
    }

    /// |A x|^2 at the solution x: the amount by which x reduces |b|^2.
    #[inline]
    pub fn explained(&self) -> f64 {
        self.explained
    }

    /// Upper triangle R of A = Q R, column by column.
    #[inline]
    pub fn triangle(&self) -> &[f64] {
        &self.triangle
    }
}
