//! Factors of symmetric matrices: small, of known size ([`Ldl`]), and sparse, definite ([`Cholesky`]) or not ([`IndefiniteFactor`]).

mod bordered;
mod cholesky;
mod indefinite;
mod ldl;

pub use bordered::{Bordered, Direction};
pub use cholesky::Cholesky;
pub use indefinite::IndefiniteFactor;
pub use ldl::{Ldl, copy_lane};
