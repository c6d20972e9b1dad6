//! Least-squares problems of a profile, and their minima over the positions.

use super::grid::{Grid, Place};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Larger forces, as multiples of the largest force at the linearised minimum, are pairs that nearly cancel. The linearised finger does not apply to them.
const LARGEST_FORCE: f64 = 20.0;
/// The positions of a minimum are refined by this number of halved steps, of at most `MOST_MOVES` moves together.
const HALVINGS: usize = 4;
const MOST_MOVES: usize = 40;

/// Least-squares problems for all combinations of positions.
pub(super) struct Profile {
    pub grid: Grid,
    /// Products of all columns. The last column is the measurement, before it the columns of known contacts and nuisances, and first the columns of the contacts at
    /// unknown positions: contact by contact, position by position, one or two components.
    pub products: DMatrix<f64>,
    /// First column and number of components of each contact at an unknown position.
    pub blocks: Vec<(usize, usize)>,
    /// First column of known contacts and nuisances.
    pub known_from: usize,
    /// Whether component 0 of each contact, and each known contact, must push.
    pub pushes: bool,
    pub known_contacts: usize,
    pub largest_n: f64,
    /// For each contact at an unknown position, the previous contact with an equal direction. Positions of both are in ascending order.
    pub equal_to: Vec<Option<usize>>,
}

/// Misfit, mm^2, and components of all forces, N, for one combination of positions.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub misfit_mm2: f64,
    pub components_n: Vec<f64>,
}

impl Profile {
    /// Fit at the places of the contacts. `None` if the forces are not identifiable, nearly cancel, or pull although contacts push.
    fn fit(&self, places: &[Place]) -> Option<Fit> {
        let last = self.products.ncols() - 1;
        // Each column of the problem is a weighted sum of columns of the profile.
        let mut terms: Vec<Vec<(usize, f64)>> = Vec::with_capacity(last - self.known_from + 2 * places.len());
        for (place, (first, count)) in places.iter().zip(&self.blocks) {
            for component in 0..*count {
                terms
                    .push(place.weights().map(|(point, weight)| (first + point * count + component, weight)).collect());
            }
        }
        let placed = terms.len();
        terms.extend((self.known_from..last).map(|column| vec![(column, 1.0)]));
        let product = |a: &[(usize, f64)], b: &[(usize, f64)]| -> f64 {
            a.iter().map(|(i, u)| u * b.iter().map(|(j, v)| v * self.products[(*i, *j)]).sum::<f64>()).sum()
        };
        let right = [(last, 1.0)];
        let normal = DMatrix::from_fn(terms.len(), terms.len(), |i, j| product(&terms[i], &terms[j]));
        let explained = DVector::from_fn(terms.len(), |i, _| product(&terms[i], &right));
        let solution = Cholesky::new(normal)?.solve(&explained);
        let components_n: Vec<f64> = solution.iter().take(placed + self.known_contacts).copied().collect();
        let is_possible = components_n.iter().all(|force_n| force_n.abs() <= LARGEST_FORCE * self.largest_n);
        let mut along = self.blocks.iter().scan(0, |at, (_, count)| Some(std::mem::replace(at, *at + count)));
        let known = placed..components_n.len();
        let pushes =
            !self.pushes || along.all(|i| components_n[i] >= 0.0) && known.into_iter().all(|i| components_n[i] >= 0.0);
        (is_possible && pushes)
            .then(|| Fit { misfit_mm2: self.products[(last, last)] - explained.dot(&solution), components_n })
    }

    /// Fit at positions of the contacts, mm. `None` as for [`fit`](Self::fit), and for positions out of order.
    fn fit_at(&self, at_mm: &[f64]) -> Option<Fit> {
        let ordered = |(k, before): (usize, &Option<usize>)| before.is_none_or(|before| at_mm[before] < at_mm[k]);
        self.equal_to.iter().enumerate().all(ordered).then_some(())?;
        let places: Option<Vec<Place>> = at_mm.iter().map(|s_mm| self.grid.place(*s_mm)).collect();
        self.fit(&places?)
    }

    /// Indices of the points of the grid for the combination with index `combination`.
    fn points(&self, mut combination: usize) -> Vec<usize> {
        let points = self.grid.at_mm.len();
        let mut at = Vec::with_capacity(self.blocks.len());
        for _ in 0..self.blocks.len() {
            at.push(combination % points);
            combination /= points;
        }
        at
    }

    /// Positions of a combination of points of the grid, mm.
    pub fn at_mm(&self, combination: usize) -> Vec<f64> {
        self.points(combination).into_iter().map(|point| self.grid.at_mm[point]).collect()
    }

    /// Fits for all combinations of points of the grid. `None` as for [`fit`](Self::fit), and for positions out of order.
    pub fn fits(&self) -> Vec<Option<Fit>> {
        let fit = |combination: usize| {
            let at = self.points(combination);
            let ordered = |(k, before): (usize, &Option<usize>)| before.is_none_or(|before| at[before] < at[k]);
            self.equal_to.iter().enumerate().all(ordered).then_some(())?;
            self.fit(&at.iter().map(|point| Place::at_point(*point)).collect::<Vec<_>>())
        };
        (0..self.grid.at_mm.len().pow(self.blocks.len() as u32)).map(fit).collect()
    }

    /// Combinations of points of the grid with a smaller misfit than the combinations around them.
    pub fn minima(&self, fits: &[Option<Fit>]) -> Vec<usize> {
        let points = self.grid.at_mm.len();
        let misfit_mm2 = |combination: usize| fits[combination].as_ref().map_or(f64::INFINITY, |fit| fit.misfit_mm2);
        let is_least = |combination: usize| {
            let at = self.points(combination);
            // Each neighbour differs by -1, 0 or 1 in each position.
            (0..3_usize.pow(at.len() as u32)).all(|mut code| {
                let mut neighbour = 0;
                let mut stride = 1;
                for &point in &at {
                    let Some(point) = (point + code % 3).checked_sub(1).filter(|point| *point < points) else {
                        return true;
                    };
                    neighbour += stride * point;
                    (stride, code) = (stride * points, code / 3);
                }
                misfit_mm2(neighbour) >= misfit_mm2(combination)
            })
        };
        (0..fits.len()).filter(|&combination| fits[combination].is_some() && is_least(combination)).collect()
    }

    /// Moves a minimum among the points of the grid, with its fit, to the minimum between the points.
    pub fn refined(&self, mut at_mm: Vec<f64>, fit: &Fit) -> (Vec<f64>, Fit) {
        let mut fit = fit.clone();
        let (mut step_mm, mut moves) = (0.5 * self.grid.spacing_mm, 0);
        for _ in 0..HALVINGS {
            while moves < MOST_MOVES {
                let moved = (0..3_usize.pow(at_mm.len() as u32)).filter_map(|mut code| {
                    let mut to_mm = at_mm.clone();
                    for s_mm in &mut to_mm {
                        *s_mm += step_mm * ((code % 3) as f64 - 1.0);
                        code /= 3;
                    }
                    self.fit_at(&to_mm).map(|fit| (to_mm, fit))
                });
                let best = moved.min_by(|a, b| a.1.misfit_mm2.total_cmp(&b.1.misfit_mm2));
                let Some(better) = best.filter(|(_, better)| better.misfit_mm2 < fit.misfit_mm2) else { break };
                (at_mm, fit) = better;
                moves += 1;
            }
            step_mm *= 0.5;
        }
        (at_mm, fit)
    }
}
