//! Noise estimated from the residual because none is stated.

use super::*;

/// Points of Student's t for 97.5 %: 12.706, 2.2281, 2.0141 for 1, 10, 45 degrees of freedom (Abramowitz and Stegun, table 26.10).
#[test]
fn unstated_noise_is_as_wide_as_the_table_of_students_t_has_it() {
    for (degrees_of_freedom, point) in [(1, 12.706), (10, 2.2281), (45, 2.0141)] {
        let wide_mm = unstated_noise_mm(degrees_of_freedom as f64, degrees_of_freedom).unwrap();
        assert!((wide_mm * 1.959_964 / point - 1.0).abs() < 1e-4, "{degrees_of_freedom}: {wide_mm}");
    }
    assert_eq!(unstated_noise_mm(1.0, 0), None);
}
