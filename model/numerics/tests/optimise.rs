//! Tests the optimiser on problems with closed-form solutions.

use finray_numerics::optimise::{
    Convergence, FromFunction, LeastSquaresProblem, LevenbergMarquardt, Outcome, Prior, Refusal, StepBounds,
};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

mod gram_schmidt;

/// Linear least-squares problem: a line is fitted to five measurements. The unknowns are offset and slope.
fn line() -> (DMatrix<f64>, DVector<f64>) {
    (dmatrix![1.0, -2.0; 1.0, -1.0; 1.0, 0.0; 1.0, 1.0; 1.0, 2.0], dvector![-3.1, -0.8, 1.1, 3.2, 4.6])
}

/// The residual A x - b, with optional priors and bounds.
struct Linear {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    priors: Vec<(usize, f64, f64)>,
    bounds: Vec<(usize, [f64; 2])>,
    /// Number of evaluated points.
    evaluated: usize,
}

impl Linear {
    fn new((matrix, right): (DMatrix<f64>, DVector<f64>)) -> Linear {
        Linear { matrix, right, priors: Vec::new(), bounds: Vec::new(), evaluated: 0 }
    }
}

impl LeastSquaresProblem for Linear {
    type Point = DVector<f64>;
    type Error = ();

    fn residual(&mut self, point: &DVector<f64>) -> Result<DVector<f64>, Refusal<()>> {
        self.evaluated += 1;
        Ok(&self.matrix * point - &self.right)
    }

    fn jacobian(&mut self, _: &DVector<f64>, _: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<()>> {
        Ok(self.matrix.clone())
    }

    fn moved(&self, point: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        point + step
    }

    fn priors(&self, point: &DVector<f64>) -> Vec<Prior> {
        self.priors.iter().map(|&(k, expected, sd)| Prior::on(k, point[k], expected, sd)).collect()
    }

    fn step_bounds(&self, point: &DVector<f64>) -> StepBounds {
        self.bounds.iter().fold(StepBounds::default(), |bounds, &(k, range)| bounds.and(k, point[k], range))
    }
}

/// Residuals 10 (y - x^2) and 1 - x of Rosenbrock's valley, whose minimum is (1, 1).
fn rosenbrock(at: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let residual = dvector![10.0 * (at[1] - at[0] * at[0]), 1.0 - at[0]];
    (residual, dmatrix![-20.0 * at[0], 10.0; -1.0, 0.0])
}

#[test]
fn finds_the_bottom_of_rosenbrocks_valley() {
    for start in [dvector![-1.2, 1.0], dvector![-3.0, -4.0], dvector![10.0, 10.0]] {
        let mut problem = FromFunction::new(|at: &DVector<f64>| Ok::<_, Refusal<()>>(rosenbrock(at)));
        let fit = LevenbergMarquardt::default().minimise(&mut problem, start).unwrap();
        assert!((&fit.point - dvector![1.0, 1.0]).amax() < 1e-9, "{fit:?}");
        assert!(fit.squares < 1e-18 && fit.iterations < 60, "{fit:?}");
    }
}

/// Closed-form solution of `line`: x sums to zero, so the offset is the mean of y, and the slope is sum(x y) / sum(x^2).
fn best_line() -> DVector<f64> {
    dvector![1.0, (6.2 + 0.8 + 3.2 + 9.2) / 10.0]
}

#[test]
fn a_linear_problem_takes_one_undamped_step() {
    let mut problem = Linear::new(line());
    let undamped = LevenbergMarquardt { first_damping: 0.0, ..LevenbergMarquardt::default() };
    let fit = undamped.minimise(&mut problem, dvector![100.0, -100.0]).unwrap();
    assert!((&fit.point - best_line()).amax() < 1e-13, "{fit:?}");
    // The search ends at the second point, because the next step would be negligible.
    assert_eq!((fit.outcome, fit.iterations, problem.evaluated), (Outcome::Converged, 2, 2));
}

/// After the first damped step, a thousandth of the distance to the minimum remains. The second step leaves a ten-thousandth of the remaining
/// distance, and so on.
#[test]
fn damping_fades_from_step_to_step() {
    let mut problem = Linear::new(line());
    let fit = LevenbergMarquardt::default().minimise(&mut problem, dvector![100.0, -100.0]).unwrap();
    assert!((&fit.point - best_line()).amax() < 1e-6, "{fit:?}");
    assert!(fit.iterations <= 4 && problem.evaluated == fit.iterations, "{} {}", fit.iterations, problem.evaluated);
}

/// Without the bound, the slope is 1.94. If the bound holds the slope at 1.5, the best offset is the mean of y - 1.5 x.
#[test]
fn a_bound_that_is_active_holds_its_unknown_and_lets_the_others_follow() {
    // The mean of x is not zero, so the best offset depends on the slope.
    let x = [0.0, 1.0, 2.0, 3.0, 4.0];
    let (_, right) = line();
    let matrix = DMatrix::from_fn(5, 2, |i, j| if j == 0 { 1.0 } else { x[i] });
    let mut problem = Linear::new((matrix, right));
    problem.bounds = vec![(1, [-1.0, 1.5]), (0, [-100.0, 100.0])];
    let fit = LevenbergMarquardt::default().minimise(&mut problem, dvector![50.0, 0.0]).unwrap();
    assert!(fit.has_converged(), "{fit:?}");
    assert!((fit.point[1] - 1.5).abs() < 1e-15 && (fit.point[0] - (1.0 - 1.5 * 2.0)).abs() < 1e-6, "{fit:?}");
    // A bound that is not active does not change the solution.
    problem.bounds = vec![(1, [-1.0, 2.5])];
    let fit = LevenbergMarquardt::default().minimise(&mut problem, dvector![50.0, 0.0]).unwrap();
    assert!((&fit.point - dvector![1.0 - 1.94 * 2.0, 1.94]).amax() < 1e-6, "{fit:?}");
}

#[test]
fn no_point_that_is_tried_is_out_of_bounds() {
    let mut farthest = 0.0_f64;
    let function = |at: &DVector<f64>| {
        farthest = farthest.max(at[0]);
        Ok::<_, Refusal<()>>(rosenbrock(at))
    };
    struct Bounded<P>(P);
    impl<P: LeastSquaresProblem<Point = DVector<f64>>> LeastSquaresProblem for Bounded<P> {
        type Point = DVector<f64>;
        type Error = P::Error;
        fn residual(&mut self, at: &DVector<f64>) -> Result<DVector<f64>, Refusal<P::Error>> {
            self.0.residual(at)
        }
        fn jacobian(&mut self, at: &DVector<f64>, r: &DVector<f64>) -> Result<DMatrix<f64>, Refusal<P::Error>> {
            self.0.jacobian(at, r)
        }
        fn moved(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
            self.0.moved(at, step)
        }
        fn step_bounds(&self, at: &DVector<f64>) -> StepBounds {
            StepBounds::within(2, 0.2).and(0, at[0], [-5.0, 0.8])
        }
    }
    let mut problem = Bounded(FromFunction::new(function));
    let fit = LevenbergMarquardt::default().minimise(&mut problem, dvector![-1.2, 1.0]).unwrap();
    // At the bound x = 0.8, the bottom of the valley is at y = x^2.
    assert!((&fit.point - dvector![0.8, 0.64]).amax() < 1e-9, "{fit:?}");
    assert!(farthest <= 0.8 + 1e-15, "{farthest}");
}

/// A prior has the same effect as a measurement of its unknown with the prior's mean and standard deviation.
#[test]
fn a_prior_is_a_further_reading() {
    let (matrix, right) = line();
    let (expected, sd) = (1.2, 0.3);
    let mut with_prior = Linear::new((matrix.clone(), right.clone()));
    with_prior.priors = vec![(1, expected, sd)];
    let stacked = matrix.insert_row(5, 0.0);
    let stacked = DMatrix::from_fn(6, 2, |i, j| if i < 5 { stacked[(i, j)] } else { [0.0, 1.0 / sd][j] });
    let mut with_reading = Linear::new((stacked, right.push(expected / sd)));
    let fits = [&mut with_prior, &mut with_reading]
        .map(|problem| LevenbergMarquardt::default().minimise(problem, dvector![0.0, 0.0]).unwrap());
    // Closed form: the slope is the mean of the measured and the expected slope, weighted by 10 and 1 / sd^2.
    let slope = (19.4 + expected / (sd * sd)) / (10.0 + 1.0 / (sd * sd));
    assert!((fits[0].point[1] - slope).abs() < 1e-6, "{} {slope}", fits[0].point[1]);
    assert!((&fits[0].point - &fits[1].point).amax() < 1e-12, "{fits:?}");
    assert!((fits[0].squares - fits[1].squares).abs() < 1e-12 * fits[1].squares);
    let covariances = fits.map(|fit| fit.covariance().unwrap());
    assert!((&covariances[0] - &covariances[1]).amax() < 1e-15, "{covariances:?}");
}

/// For the line, (J^T J)^-1 is diagonal with the entries 1 / 5 and 1 / sum(x^2).
#[test]
fn the_covariance_of_a_linear_problem_is_the_inverse_of_its_normal_equations() {
    let fit = LevenbergMarquardt::default().minimise(&mut Linear::new(line()), dvector![0.0, 0.0]).unwrap();
    let covariance = fit.covariance().unwrap();
    assert!((covariance - dmatrix![0.2, 0.0; 0.0, 0.1]).amax() < 1e-15);
    // If the measurements determine only the sum of two unknowns, these unknowns have no covariance.
    let same = Linear::new((DMatrix::from_element(3, 2, 1.0), dvector![1.0, 2.0, 3.0]));
    let fit = LevenbergMarquardt::default().minimise(&mut { same }, dvector![0.0, 0.0]).unwrap();
    assert!(fit.covariance().is_none_or(|covariance| covariance[(0, 0)] > 1e12));
    assert!((fit.point.sum() - 2.0).abs() < 1e-6, "{fit:?}");
}

/// Solves sqrt(x) = 1/10 from x = 4. An undamped step leads to x = -3.6, which has no square root.
#[test]
fn a_point_without_residuals_is_stepped_over_or_ends_the_search() {
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    struct Negative;
    let search = |refuse: fn(Negative) -> Refusal<Negative>, start: f64| {
        let mut refused = 0;
        let function = |at: &DVector<f64>| {
            if at[0] < 0.0 {
                refused += 1;
                return Err(refuse(Negative));
            }
            Ok((dvector![at[0].sqrt() - 0.1], dmatrix![0.5 / at[0].sqrt()]))
        };
        let found = LevenbergMarquardt::default().minimise(&mut FromFunction::new(function), dvector![start]);
        (found, refused)
    };
    let (found, refused) = search(Refusal::Here, 4.0);
    assert!((found.unwrap().point[0] - 0.01).abs() < 1e-9);
    assert!(refused > 0);
    let (found, refused) = search(Refusal::Altogether, 4.0);
    assert_eq!((found, refused), (Err(Refusal::Altogether(Negative)), 1));
    // If the starting point has no residuals, no shorter step can help, and the search fails.
    assert_eq!(search(Refusal::Here, -1.0).0, Err(Refusal::Here(Negative)));
}

#[test]
fn a_search_says_why_it_ended() {
    let rosenbrock = || FromFunction::new(|at: &DVector<f64>| Ok::<_, Refusal<()>>(rosenbrock(at)));
    let start = dvector![-1.2, 1.0];
    let few = LevenbergMarquardt { most_steps: 3, ..LevenbergMarquardt::default() };
    let fit = few.minimise(&mut rosenbrock(), start.clone()).unwrap();
    assert_eq!((fit.outcome, fit.has_converged()), (Outcome::StepsUsedUp, false));
    // Derivatives with the wrong sign lead to steps that increase the sum of squares.
    let uphill = |at: &DVector<f64>| Ok::<_, Refusal<()>>((at.clone(), dmatrix![-1.0]));
    let fit = LevenbergMarquardt::default().minimise(&mut FromFunction::new(uphill), dvector![1.0]).unwrap();
    assert_eq!((fit.outcome, fit.point[0]), (Outcome::NoStepHelps, 1.0));
    // A search whose convergence limit on the step is large ends early.
    let convergence = Convergence { relative_decrease: 0.0, step: 0.5 };
    let coarse = LevenbergMarquardt { convergence, ..LevenbergMarquardt::default() };
    let fit = coarse.minimise(&mut rosenbrock(), start).unwrap();
    assert!(fit.has_converged() && fit.squares > 1e-6, "{fit:?}");
}
