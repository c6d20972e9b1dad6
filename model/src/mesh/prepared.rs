//! Cache in a mesh for results that a solver computes once per mesh.

use super::Mesh;
use std::any::Any;
use std::sync::{Arc, OnceLock};

/// A cached value that depends only on the mesh. The value can have any type, so the mesh does not depend on that type.
#[derive(Debug, Clone, Default)]
pub(super) struct Prepared(OnceLock<Arc<dyn Any + Send + Sync>>);

/// All caches compare as equal, so a difference between caches does not make two meshes unequal.
impl PartialEq for Prepared {
    fn eq(&self, _: &Prepared) -> bool {
        true
    }
}

impl Mesh {
    /// Returns the result of `make`, which runs only at the first call. `None` if the cached value has another type.
    pub(crate) fn prepared<T: Any + Send + Sync>(&self, make: fn(&Mesh) -> T) -> Option<&T> {
        self.prepared.0.get_or_init(|| Arc::new(make(self))).downcast_ref()
    }
}
