//! What is asked of fingers, estimators and models: an experiment a file, each with results of its own type.

pub mod causes;
pub mod contact_scene;
pub mod convergence;
pub mod coverage;
pub mod direction;
pub mod displacement_noise;
pub mod explain;
pub mod hard_cases;
pub mod lattice;
pub mod networks;
pub mod response;
pub mod speed_error;
pub mod table_one;
pub mod table_two;
pub mod twin;
