//! Checks and converts arguments from Python, and creates NumPy arrays.

use crate::error::failed;
use finray_model::{NodeId, Vector, text};
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes, PyFloat, PyInt, PyList, PyTuple};

/// Largest integer up to which a float holds every integer, 2^53.
pub const LARGEST_INTEGER: f64 = 9_007_199_254_740_992.0;

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

/// Longest text of a value in a message, characters.
const SHOWN: usize = 60;

/// An argument in messages: type and shape of an array, or the value on one line.
pub fn found(value: &Bound<'_, PyAny>) -> String {
    if let Ok(array) = value.cast::<PyUntypedArray>() {
        return type_and_shape(array);
    }
    let text = value.repr().map_or_else(|_| value.get_type().to_string(), |text| text.to_string());
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(SHOWN) {
        None => line,
        Some((end, _)) => format!("{}...", &line[..end]),
    }
}

fn type_and_shape(array: &Bound<'_, PyUntypedArray>) -> String {
    let shape: Vec<String> = array.shape().iter().map(ToString::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    format!("{} of shape ({}{comma})", array.dtype(), shape.join(", "))
}

/// Elements of a sequence. `None` for any other value, and for texts and bytes.
pub fn items<'py>(value: &Bound<'py, PyAny>) -> Option<Vec<Bound<'py, PyAny>>> {
    let is_text = value.is_instance_of::<PyBytes>() || value.is_instance_of::<PyByteArray>();
    // The extraction refuses a str.
    if is_text { None } else { value.extract().ok() }
}

/// A number: a Python or NumPy integer or float. `None` for any other value, such as a bool or a masked number.
pub fn number(value: &Bound<'_, PyAny>) -> Option<f64> {
    if let Ok(number) = value.cast_exact::<PyFloat>() {
        return Some(number.value());
    }
    let array = asarray(value).filter(|array| array.ndim() == 0 && is_numeric(array))?;
    if is_masked(value).ok()? { None } else { elements(&array).ok()?.first().copied() }
}

/// Whether a masked array, or a list of masked values, has a masked entry. `numpy.asarray` would ignore the mask.
pub fn is_masked(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        for item in value.try_iter()? {
            if is_masked(&item?)? {
                return Ok(true);
            }
        }
        return Ok(false);
    }
    if value.is_exact_instance_of::<PyFloat>() || value.is_exact_instance_of::<PyInt>() {
        return Ok(false);
    }
    value.py().import("numpy.ma")?.call_method1("is_masked", (value,))?.is_truthy()
}

/// The array that `numpy.asarray` makes of a value; `None` if NumPy refuses the value, such as rows of different lengths.
fn asarray<'py>(value: &Bound<'py, PyAny>) -> Option<Bound<'py, PyUntypedArray>> {
    let array = value.py().import("numpy").ok()?.call_method1("asarray", (value,)).ok()?;
    array.cast_into().ok()
}

/// Whether the elements of an array are integers or floats. Excludes those that NumPy would convert to floats: bool, complex, text, time.
fn is_numeric(array: &Bound<'_, PyUntypedArray>) -> bool {
    matches!(array.dtype().kind(), b'i' | b'u' | b'f')
}

/// The elements of an array as `T`, in the order of its rows.
fn elements<'py, T: Element + Copy>(array: &Bound<'py, PyUntypedArray>) -> PyResult<Vec<T>> {
    let array = array.call_method1("astype", (numpy::dtype::<T>(array.py()),))?;
    Ok(array.extract::<PyReadonlyArrayDyn<'py, T>>()?.as_array().iter().copied().collect())
}

/// The array of an argument, and the error for an array of another type or shape. `expected` describes the expected values.
fn array_of<'py>(
    name: &str,
    expected: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyUntypedArray>, impl Fn() -> PyErr + use<'py>)> {
    let array = asarray(value);
    // A list of numbers ends at the array's depth; any other list might contain itself.
    if array.as_ref().is_some_and(is_numeric) && is_masked(value)? {
        return Err(failed(format!("{name}: the array is masked: leave out hidden markers")));
    }
    // An array without dimensions holds a value that is no sequence.
    let shown = array.as_ref().filter(|array| array.ndim() > 0).map_or_else(|| found(value), type_and_shape);
    let message = format!("{name}: expected {expected}, found {shown}");
    let wrong = move || failed(&message);
    Ok((array.ok_or_else(&wrong)?, wrong))
}

/// Nodes from a sequence or an array of integers.
pub fn nodes_of(value: &Bound<'_, PyAny>) -> PyResult<Vec<NodeId>> {
    let (array, wrong) = array_of("nodes", "the numbers of nodes, integers of shape (n,)", value)?;
    if array.ndim() != 1 {
        return Err(wrong());
    }
    let numbers: Vec<i128> = match array.dtype().kind() {
        _ if array.is_empty() => Vec::new(),
        b'i' => elements::<i64>(&array)?.into_iter().map(i128::from).collect(),
        b'u' => elements::<u64>(&array)?.into_iter().map(i128::from).collect(),
        _ => return Err(wrong()),
    };
    // Python gets the nodes back as int64.
    let node = |(i, number): (usize, i128)| {
        let node = usize::try_from(number).ok().filter(|_| number <= i64::MAX.into());
        node.map(NodeId).ok_or_else(|| failed(format!("nodes[{i}]: expected the number of a node, found {number}")))
    };
    numbers.into_iter().enumerate().map(node).collect()
}

/// Vectors from an array of shape (`count`, 2). `name` is the name of the argument.
pub fn vectors_of(name: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<Vector>> {
    let (array, wrong) = array_of(name, &format!("numbers of shape ({count}, 2)"), value)?;
    let is_none = count == 0 && array.shape() == [0];
    if !is_numeric(&array) || !(is_none || array.shape() == [count, 2]) {
        return Err(wrong());
    }
    Ok(elements(&array)?.chunks_exact(2).map(|row| Vector::new(row[0], row[1])).collect())
}

/// Standard deviations, mm, from an array of shape (`count`,), or one number repeated `count` times. `name` is the name of the argument.
pub fn deviations_of(name: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<f64>> {
    let (array, wrong) = array_of(name, &format!("one number or numbers of shape ({count},)"), value)?;
    let is_one = array.ndim() == 0;
    if !is_numeric(&array) || !(is_one || array.shape() == [count]) {
        return Err(wrong());
    }
    let numbers: Vec<f64> = elements(&array)?;
    if let Some((i, sd_mm)) = numbers.iter().enumerate().find(|(_, sd_mm)| !(**sd_mm > 0.0 && sd_mm.is_normal())) {
        let at = if is_one { String::new() } else { format!("[{i}]") };
        return Err(failed(format!("{name}{at}: expected a length in mm above zero, found {sd_mm}")));
    }
    Ok(if is_one { numbers.repeat(count) } else { numbers })
}

/// Checks that a number is zero or more. The error message is that of the command line.
pub fn not_negative(name: &str, number: Option<f64>) -> PyResult<Option<f64>> {
    match number.map(|number| text::not_negative(&number.to_string())) {
        Some(Err(reason)) => Err(failed(format!("{name}: {reason}"))),
        _ => Ok(number),
    }
}
