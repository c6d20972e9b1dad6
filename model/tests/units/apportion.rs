//! Distribution of elements among members of different length.

use super::*;

#[test]
fn shares_add_up_and_follow_length() {
    assert_eq!(by_largest_remainder(10, &[1.0, 2.0, 7.0]), [1, 2, 7]);
    assert_eq!(by_largest_remainder(10, &[1.0, 1.0, 1.0]), [4, 3, 3]);
    assert_eq!(by_largest_remainder(4, &[1e-9, 1.0, 2.0]), [1, 1, 2]);
    assert_eq!(by_largest_remainder(3, &[1e-9, 1.0, 1e-3]), [1, 1, 1]);
}
