//! Factorisations of symmetric matrices: small ones of fixed size ([`Ldl`]), and sparse ones that are positive definite ([`Cholesky`]) or indefinite
//! ([`IndefiniteFactor`]).

mod bordered;
mod cholesky;
mod indefinite;
mod ldl;

pub use bordered::{Bordered, Direction};
pub use cholesky::Cholesky;
pub use indefinite::IndefiniteFactor;
pub use ldl::{Ldl, copy_lane};
