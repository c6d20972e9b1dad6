//! Networks: accuracy of those that ship, training recipes, and the paper's on its Table II.

pub mod accuracy;
pub mod paper;
pub mod records;
#[cfg(feature = "train")]
pub mod shipping;
