//! Networks: accuracy of the shipped ones, training recipes, and the paper's network on its Table II.

pub mod accuracy;
pub mod paper;
pub mod records;
#[cfg(feature = "train")]
pub mod shipping;
