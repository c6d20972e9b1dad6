//! Steps of the Adam optimiser.

use super::*;

/// Five steps on the loss x^2 / 2 with the gradient x, compared with the same steps in double precision.
#[test]
fn steps_are_those_of_the_paper() {
    let device = Device::flex().autodiff();
    let mut x = Parameter::new(&[1.0], [1], &device);
    let mut by_hand = (1.0_f64, 0.0_f64, 0.0_f64);
    for number in 1..=5 {
        let mut gradients = x.value().square().mul_scalar(0.5).sum().backward();
        x.step(&mut gradients, &Step::new(number, 0.1)).expect("gradients are numbers");
        let (value, m, v) = by_hand;
        let (m, v) = (0.9 * m + 0.1 * value, 0.999 * v + 0.001 * value * value);
        let [m_hat, v_hat] = [m / (1.0 - 0.9_f64.powi(number as i32)), v / (1.0 - 0.999_f64.powi(number as i32))];
        by_hand = (value - 0.1 * m_hat / (v_hat.sqrt() + 1e-8), m, v);
        let found: f32 = x.value().inner().into_scalar();
        // Single precision causes some rounding errors of 6e-8. The bias correction of the second moment magnifies rounding errors a thousand times.
        assert!((f64::from(found) - by_hand.0).abs() < 1e-4, "step {number}: {found} {by_hand:?}");
    }
    assert!((by_hand.0 - 0.5).abs() < 0.02, "five steps of 0.1 at most");
}
