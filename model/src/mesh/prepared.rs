//! Cache in a mesh for results that a solver computes once per mesh.

use super::Mesh;
use std::any::Any;
use std::sync::{Arc, OnceLock};

/// A cached value that follows from the mesh alone; only its creator knows its type.
#[derive(Debug, Clone, Default)]
pub(super) struct Prepared(OnceLock<Arc<dyn Any + Send + Sync>>);

/// The cache does not affect the equality of meshes.
impl PartialEq for Prepared {
    fn eq(&self, _: &Prepared) -> bool {
        true
    }
}

impl Mesh {
    /// Returns the cached result of `make`, computed at the first call; `None` if the cache holds a value of another type.
    pub(crate) fn prepared<T: Any + Send + Sync>(&self, make: fn(&Mesh) -> T) -> Option<&T> {
        self.prepared.0.get_or_init(|| Arc::new(make(self))).downcast_ref()
    }
}
