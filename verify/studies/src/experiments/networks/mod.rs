//! Networks: accuracy of the shipped networks, and training recipes.

pub mod accuracy;
pub mod records;
#[cfg(feature = "train")]
pub mod shipping;
