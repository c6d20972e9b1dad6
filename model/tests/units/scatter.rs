//! Tests of private items of `calibration::views::scatter`.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Combinations with standard deviation `noise`. `values` are multiples of `noise`.
fn scatter(noise: f64, values: &[f64]) -> Scatter {
    let precision = 1.0 / (noise * noise);
    let combination =
        |value: &f64| Combination { precision, seen: precision * noise * value, carried: vec![0.0], shared: vec![0.0] };
    Scatter {
        is_single: false,
        combinations: values.iter().map(combination).collect(),
        of_parameters: vec![0.0],
        of_markers: vec![noise * noise],
        of_shared: vec![0.0],
    }
}

/// For balanced one-way random effects, the variance component is the mean square minus the variance within groups, or zero if this difference is
/// negative (Searle, Casella and McCulloch, Variance Components, 1992, sec. 3.8).
#[test]
fn a_balanced_variance_component_has_its_closed_form() {
    let noise = 0.01;
    for values in [vec![3.0, -2.0, 1.0, -2.0], vec![1.1, -0.9, 1.2, -0.9], vec![0.5, -0.2, 0.4, 0.1]] {
        let mean_square = noise * noise * values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
        let closed = (mean_square - noise * noise).max(0.0).sqrt();
        let found = scatter(noise, &values).most_likely().unwrap();
        assert!((found - closed).abs() < 1e-9, "{found} for {closed}");
    }
}

/// Images determine each force with the relative noise `noise`, up to a common factor.
#[test]
fn normal_equations_show_differences_of_forces() {
    let (noise, off) = (0.01_f64, [0.03, -0.01, 0.02, 0.0]);
    let forces = off.len();
    // The rows of the equations are (factor + force) / noise; the residual is zero at a factor of 0.
    let by = DMatrix::from_fn(forces, 1 + forces, |i, j| if j == 0 || j == 1 + i { 1.0 / noise } else { 0.0 });
    let new =
        NewImage { by_shared: DVector::from_element(1, -1.0), variance: noise * noise, of_markers: noise * noise };
    let (off, none) = (DVector::from_row_slice(&off), DVector::zeros(1 + forces));
    let found = Scatter::new(&by.tr_mul(&by), &none, 1, &off, &[new]).unwrap();
    // Sample variance of four values about their mean.
    let variance = off.map(|value| (value - off.mean()).powi(2)).sum() / 3.0;
    let closed = (variance - noise * noise).sqrt();
    assert!((found.most_likely().unwrap() / closed - 1.0).abs() < 1e-6, "{found:?}");
    // The common factor adds a quarter of one force's variance to the variance of a new force.
    assert!((found.of_finger(0, 1.0) - 0.25).abs() < 1e-3, "{found:?}");
    assert!((found.of_parameters[0] - noise * noise / 4.0).abs() < 1e-9, "{found:?}");
}

/// Without noise, the interval of a new force follows Student's t: 2.571 and 2.228 standard deviations for 5 and 10 degrees of freedom (Abramowitz
/// and Stegun, table 26.10).
#[test]
fn few_forces_leave_the_scatter_open_as_students_t_has_it() {
    for (degrees_of_freedom, point) in [(5, 2.5706), (10, 2.2281)] {
        let many = scatter(1e-6, &vec![1e4; degrees_of_freedom]);
        let found = many.of_new(f64::NAN, f64::NAN).share;
        assert!((found / 0.01 * 1.959_964 / point - 1.0).abs() < 1e-4, "{found}");
    }
}

/// The modulus is a common factor on all forces. Without noise, the interval of the mean of four forces follows Student's t with 3 degrees of freedom
/// (3.182 standard deviations, Abramowitz and Stegun, table 26.10).
#[test]
fn few_forces_widen_the_interval_of_the_modulus_by_students_t() {
    let (noise, off) = (1e-6_f64, DVector::from_row_slice(&[0.03, -0.01, 0.02, 0.0]));
    let by = DMatrix::from_fn(4, 5, |i, j| if j == 0 || j == 1 + i { 1.0 / noise } else { 0.0 });
    let new =
        NewImage { by_shared: DVector::from_element(1, -1.0), variance: noise * noise, of_markers: noise * noise };
    let found = Scatter::new(&by.tr_mul(&by), &DVector::zeros(5), 1, &off, &[new]).unwrap().of_shared(0).unwrap();
    let of_mean = (off.map(|value| (value - off.mean()).powi(2)).sum() / 3.0 / 4.0).sqrt();
    assert!((found / of_mean * 1.959_964 / 3.1824 - 1.0).abs() < 1e-3, "{found} for {of_mean}");
}

/// In each draw, images determine some of ten forces up to ten times as accurately as others. 95 % intervals contain a new force in 91 to 98.5 % of
/// the draws, for a scatter of zero, near the noise, and far above the noise.
#[test]
fn intervals_hold_whatever_the_scatter() {
    const DRAWS: usize = 200;
    let chance = &mut ChaCha8Rng::seed_from_u64(1);
    for true_scatter in [0.0_f64, 3e-4, 8e-4, 3e-3] {
        let mut within = 0.0;
        for _ in 0..DRAWS {
            let combinations = (0..9).map(|_| {
                let noise = 2.5e-4 * 10.0_f64.powf(chance.random());
                let normal: f64 = StandardNormal.sample(chance);
                let precision = noise.powi(-2);
                let seen = precision * noise.hypot(true_scatter) * normal;
                Combination { precision, seen, carried: vec![0.0], shared: vec![0.0] }
            });
            let found = Scatter { combinations: combinations.collect(), ..scatter(1.0, &[]) }.of_new_force();
            let noise = 2.5e-4 * 4.0_f64.powf(chance.random());
            let stated = found.expect("nine differences").hypot(noise);
            within += (1.0 - erfc(TWO_SIDED_95 * stated / (2.0_f64.sqrt() * true_scatter.hypot(noise)))) / DRAWS as f64;
        }
        assert!((0.91..0.985).contains(&within), "{within} of {true_scatter}");
    }
}

#[test]
fn one_force_has_nothing_to_be_compared_with() {
    let one = scatter(1e3, &[1.0]);
    assert_eq!((one.most_likely(), one.of_new(0.02, 0.01)), (None, AddedForceError { share: 0.01, of_markers: 0.0 }));
}

/// Variances with a constant part and a part that grows with the noise are split correctly. Variances that are equal, or that decrease with the
/// noise, have no part that grows with the noise.
#[test]
fn what_grows_with_noise_is_told_from_a_share_of_the_force() {
    let noise = [1e-4, 4e-4, 9e-4, 16e-4];
    let both = noise.map(|noise| 2e-6 + 0.05 * noise);
    let [of_all, of_noise] = shares(&both, &noise);
    assert!((of_all / 2e-6 - 1.0).abs() < 0.01 && (of_noise / 0.05 - 1.0).abs() < 0.01, "{of_all} {of_noise}");
    for alike in [[3e-6; 4], [4e-6, 3e-6, 2e-6, 1e-6]] {
        let [of_all, of_noise] = shares(&alike, &noise);
        let mean = alike.iter().sum::<f64>() / 4.0;
        assert!((of_all / mean - 1.0).abs() < 0.05 && of_noise * noise[3] < 0.05 * of_all, "{of_all} {of_noise}");
    }
    // If the noise is equal in all images, the constant part and the part that grows with the noise cannot be separated.
    let [of_all, of_noise] = shares(&[3e-6; 4], &[1e-4; 4]);
    assert!((of_all / 1.5e-6 - 1.0).abs() < 1e-9 && (of_noise / 1.5e-2 - 1.0).abs() < 1e-9, "{of_all} {of_noise}");
    assert_eq!(shares(&[0.0; 4], &noise), [0.0; 2]);
}
