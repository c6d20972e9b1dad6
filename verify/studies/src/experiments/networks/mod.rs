//! Networks: accuracy of the shipped networks, training recipes, and the paper's network on the paper's Table II.

pub mod accuracy;
pub mod paper;
pub mod records;
#[cfg(feature = "train")]
pub mod shipping;
