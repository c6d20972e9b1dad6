//! Checks and converts arguments from Python, and creates NumPy arrays.

use crate::error::failed;
use finray_imaging::RgbView;
use finray_model::{NodeId, Vector, text};
use numpy::{
    AllowTypeChange, IntoPyArray, PyArray1, PyArray2, PyArrayLike1, PyArrayLike2, PyArrayMethods, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use std::ops::Deref;

/// An array of numbers, shape (n,).
pub fn column(py: Python<'_>, numbers: impl Iterator<Item = f64>) -> Bound<'_, PyArray1<f64>> {
    numbers.collect::<Vec<_>>().into_pyarray(py)
}

/// An array of nodes, shape (n,).
pub fn nodes(py: Python<'_>, nodes: impl Iterator<Item = NodeId>) -> Bound<'_, PyArray1<i64>> {
    nodes.map(|node| node.0 as i64).collect::<Vec<_>>().into_pyarray(py)
}

/// An array of pairs, shape (n, 2).
pub fn pairs(py: Python<'_>, pairs: impl Iterator<Item = [f64; 2]>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let numbers: Vec<f64> = pairs.flatten().collect();
    let rows = numbers.len() / 2;
    numbers.into_pyarray(py).reshape([rows, 2])
}

/// An array of vectors, shape (n, 2).
pub fn vectors(py: Python<'_>, vectors: impl Iterator<Item = Vector>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    pairs(py, vectors.map(|vector| [vector.x, vector.y]))
}

/// Type and shape of an argument, for messages.
fn found(value: &Bound<'_, PyAny>) -> String {
    match value.cast::<PyUntypedArray>() {
        Ok(array) => format!("{} of shape {:?}", array.dtype(), array.shape()),
        Err(_) => value.get_type().to_string(),
    }
}

/// Nodes from a sequence or an array of integers.
pub fn nodes_of(value: &Bound<'_, PyAny>) -> PyResult<Vec<NodeId>> {
    let nodes: Vec<usize> = value.extract().map_err(|_| {
        failed(format!("nodes: expected the numbers of nodes, integers of shape (n,), found {}", found(value)))
    })?;
    Ok(nodes.into_iter().map(NodeId).collect())
}

/// Vectors from an array of shape (`count`, 2). `name` is the name of the argument.
pub fn vectors_of(name: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<Vector>> {
    let expected = || failed(format!("{name}: expected numbers of shape ({count}, 2), found {}", found(value)));
    let array: PyArrayLike2<'_, f64, AllowTypeChange> = value.extract().map_err(|_| expected())?;
    if array.shape() != [count, 2] {
        return Err(expected());
    }
    Ok(array.as_array().rows().into_iter().map(|row| Vector::new(row[0], row[1])).collect())
}

/// Numbers from an array of shape (`count`,), or one number repeated `count` times. `name` is the name of the argument.
pub fn numbers_of(name: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<f64>> {
    if let Ok(number) = value.extract::<f64>() {
        return Ok(vec![number; count]);
    }
    let expected =
        || failed(format!("{name}: expected one number or numbers of shape ({count},), found {}", found(value)));
    let array: PyArrayLike1<'_, f64, AllowTypeChange> = value.extract().map_err(|_| expected())?;
    if array.shape() != [count] {
        return Err(expected());
    }
    Ok(array.as_array().to_vec())
}

/// Checks that a number is zero or more. The error message is that of the command line.
pub fn not_negative(name: &str, number: Option<f64>) -> PyResult<Option<f64>> {
    match number.map(|number| text::not_negative(&number.to_string())) {
        Some(Err(reason)) => Err(failed(format!("{name}: {reason}"))),
        _ => Ok(number),
    }
}

/// The pixels of an image argument.
pub enum ImageArgument<'py> {
    /// Pixels (red, green, blue) of a colour image, borrowed from the array.
    Colour(PyReadonlyArray3<'py, u8>),
    /// Pixels (red, green, blue) made from the levels of a grey image, and the image's height and width.
    Grey(Vec<u8>, [usize; 2]),
}

impl<'py> ImageArgument<'py> {
    /// Reads an argument: a C-contiguous uint8 array of shape (height, width, 3), or of shape (height, width) for a grey image.
    pub fn of(value: &Bound<'py, PyAny>) -> PyResult<ImageArgument<'py>> {
        let expected = || {
            failed(format!(
                "expected an image: a uint8 array of shape (height, width, 3), in the order red, green, blue, or of shape (height, width), found {}",
                found(value)
            ))
        };
        let scattered = || {
            failed(
                "expected an image whose array is C-contiguous: numpy.ascontiguousarray copies an array into this form",
            )
        };
        if let Ok(colour) = value.extract::<PyReadonlyArray3<'py, u8>>() {
            return match colour.shape()[2] {
                // `as_slice` would also accept an array in Fortran (column-major) order.
                3 if colour.is_c_contiguous() => Ok(ImageArgument::Colour(colour)),
                3 => Err(scattered()),
                _ => Err(expected()),
            };
        }
        let grey = value.extract::<PyReadonlyArray2<'py, u8>>().map_err(|_| expected())?;
        if !grey.is_c_contiguous() {
            return Err(scattered());
        }
        let levels = grey.as_slice().map_err(failed)?;
        let size = [grey.shape()[0], grey.shape()[1]];
        Ok(ImageArgument::Grey(levels.iter().flat_map(|level| [*level; 3]).collect(), size))
    }

    /// The pixels as an image, without a copy.
    pub fn view(&self) -> PyResult<RgbView<'_>> {
        let (pixels, [height, width]) = match self {
            ImageArgument::Colour(array) => {
                let pixels = array.as_slice().map_err(failed)?;
                (pixels, [array.shape()[0], array.shape()[1]])
            }
            ImageArgument::Grey(pixels, size) => (pixels.deref(), *size),
        };
        let side = |px: usize| u32::try_from(px).ok();
        let view = side(width).zip(side(height)).and_then(|(width, height)| RgbView::from_raw(width, height, pixels));
        view.ok_or_else(|| failed(format!("expected an image of fewer pixels, found {width} x {height} px")))
    }
}
