//! Room in a mesh for what a solver prepares once for it.

use super::Mesh;
use std::any::Any;
use std::sync::{Arc, OnceLock};

/// Something that follows from the mesh alone, of a type that only its maker knows.
#[derive(Debug, Clone, Default)]
pub(super) struct Prepared(OnceLock<Arc<dyn Any + Send + Sync>>);

/// It is nothing that meshes could differ in.
impl PartialEq for Prepared {
    fn eq(&self, _: &Prepared) -> bool {
        true
    }
}

impl Mesh {
    /// What `make` makes of the mesh, made when first asked for; `None` if something of another type was prepared before.
    pub(crate) fn prepared<T: Any + Send + Sync>(&self, make: fn(&Mesh) -> T) -> Option<&T> {
        self.prepared.0.get_or_init(|| Arc::new(make(self))).downcast_ref()
    }
}
