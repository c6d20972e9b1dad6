//! The Python package `finray`, a thin layer over the crates: scenes, solver, marker locator and sensors, with NumPy arrays in and out.
//!
//! `python/finray/__init__.pyi` states the types of everything that Python sees. Error messages are those of the command `finray`. Other Python
//! threads can run while a function computes. An image is read directly from its array, without a copy, when its markers are located.
#![forbid(unsafe_code)]

mod arrays;
mod error;
mod images;
mod interrupt;
mod locator;
mod observation;
mod press;
mod scene;
mod sensor;
mod solve;
mod stream;

use pyo3::prelude::*;

/// Contact forces of compliant fin-ray fingers from their deformation. Units are N, mm and degrees, unless a name states another unit.
#[pymodule(gil_used = true)]
mod _finray {
    use super::*;

    #[pymodule_export]
    use super::error::{FinrayError, Refused};
    #[pymodule_export]
    use super::locator::{Locator, read_image};
    #[pymodule_export]
    use super::observation::Observation;
    #[pymodule_export]
    use super::press::{Press, press};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::sensor::{Alternative, Forces, Sensor};
    #[pymodule_export]
    use super::solve::{Shape, solve};
    #[pymodule_export]
    use super::stream::StreamSensor;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
