//! Displacements under loads.

use crate::arrays::{self, LARGEST_INTEGER};
use crate::error::failed;
use crate::interrupt::interruptible;
use crate::observation::Observation;
use crate::scene::{Scene, at_rest, drawing, lines};
use finray_figures::{Hue, Series};
use finray_model::checked_shape::{CheckedShape, CheckedShapeError};
use finray_model::mesh::{FingerShape, NodeMotion};
use finray_model::{Kinematics, Load, NodeId, Vector};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error;
use std::sync::Arc;

/// Displacements of the key nodes of a finger. Each array has one row per node, in the order of the nodes.
#[pyclass(frozen, module = "finray")]
pub struct Shape {
    scene: Arc<finray_model::Scene>,
    shape: FingerShape,
    warnings: Vec<String>,
}

impl Shape {
    /// A shape with warnings.
    pub fn new(scene: Arc<finray_model::Scene>, shape: FingerShape, warnings: Vec<String>) -> Shape {
        Shape { scene, shape, warnings }
    }

    fn vectors<'py>(&self, py: Python<'py>, of: impl Fn(&NodeMotion) -> Vector) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::vectors(py, self.shape.motions().iter().map(of))
    }
}

#[pymethods]
impl Shape {
    /// Numbers of the key nodes; shape (n,).
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        arrays::nodes(py, self.shape.motions().iter().map(|motion| motion.node))
    }

    /// Undeformed positions, mm, finger frame; shape (n, 2).
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.vectors(py, |motion| motion.position)
    }

    /// Displacements, mm, finger frame; shape (n, 2).
    #[getter]
    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.vectors(py, |motion| motion.displacement)
    }

    /// Rotations, rad, positive from x to y; shape (n,).
    #[getter]
    fn rotations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::column(py, self.shape.motions().iter().map(|motion| motion.rotation))
    }

    /// Displacements of the joints between ribs and brackets, mm; shape (n, 2). Equal to `displacements` at nodes without a bracket.
    #[getter]
    fn hinge_displacements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.vectors(py, |motion| motion.hinge_displacement)
    }

    /// Reasons why the displacements may be inaccurate.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The displacements of the markers as an observation without noise.
    fn observation(&self) -> Observation {
        Observation::new(finray_model::observation::Observation::of_shape(&self.scene.finger, &self.shape))
    }

    /// Drawing of the bent finger, for Jupyter.
    fn _repr_svg_(&self) -> PyResult<String> {
        let finger = &self.scene.finger;
        let bent = lines(finger, |_| true, |at| self.shape.point(at).into());
        let mut series = at_rest(finger);
        series.extend(Series::lines("bent", bent, Hue::BLUE, 2.4));
        drawing(&self.scene.name, "The finger at rest and bent; the base is on the left.", series)
    }

    fn __repr__(&self) -> String {
        let (nodes, largest_mm) = (self.shape.motions().len(), self.shape.largest_displacement_mm());
        format!("<finray.Shape of {nodes} nodes, largest displacement {largest_mm:.3} mm>")
    }
}

/// A load on a node from its numbers: node, fx_n, fy_n, and optionally a moment, N mm.
fn node_load(numbers: &[f64]) -> Option<Load> {
    let (node, fx_n, fy_n, moment_nmm) = match *numbers {
        [node, fx_n, fy_n] => (node, fx_n, fy_n, 0.0),
        [node, fx_n, fy_n, moment_nmm] => (node, fx_n, fy_n, moment_nmm),
        _ => return None,
    };
    let is_node = node.fract() == 0.0 && (0.0..=LARGEST_INTEGER).contains(&node);
    is_node.then(|| Load::Node { node: NodeId(node as usize), force: Vector::new(fx_n, fy_n), moment_nmm })
}

/// The loads in an argument. `expected` names the numbers of a load; `load` makes a load of them, or returns `None` for wrong numbers.
fn loads(
    name: &str,
    expected: &str,
    value: Option<Bound<'_, PyAny>>,
    load: impl Fn(&[f64]) -> Option<Load>,
) -> PyResult<Vec<Load>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    let items = value
        .try_iter()
        .map_err(|_| failed(format!("{name}: expected a list of {expected}, found {}", arrays::found(&value))))?;
    let one = |(i, item): (usize, PyResult<Bound<'_, PyAny>>)| {
        let item = item?;
        let numbers: Option<Vec<f64>> = arrays::items(&item).and_then(|all| all.iter().map(arrays::number).collect());
        let wrong = || failed(format!("{name}[{i}]: expected {expected}, found {}", arrays::found(&item)));
        numbers.and_then(|numbers| load(&numbers)).ok_or_else(wrong)
    };
    items.enumerate().map(one).collect()
}

/// Compute the displacements of a finger under loads, as `finray solve` does.
///
/// Args:
///     load_at: forces on the front plate, tuples, lists or rows of an array (s_mm, force_n, angle_deg): position from the base, magnitude, and
///         angle from the inward normal.
///     load: forces on key nodes, in the finger frame: (node, fx_n, fy_n) or (node, fx_n, fy_n, moment_nmm).
///     kinematics: "corotational", "corotational-chord" or "linear".
///     mesh_nodes: number of mesh nodes; None for the key nodes.
///
/// Raises FinrayError if the loads are wrong or no equilibrium exists.
#[pyfunction]
#[pyo3(signature = (scene, load_at=None, *, load=None, kinematics="corotational", mesh_nodes=None))]
pub fn solve<'py>(
    py: Python<'py>,
    scene: &Scene,
    load_at: Option<Bound<'py, PyAny>>,
    load: Option<Bound<'py, PyAny>>,
    kinematics: &str,
    mesh_nodes: Option<usize>,
) -> PyResult<Shape> {
    let finger = &scene.scene.finger;
    let on_plate = |numbers: &[f64]| {
        let &[s_mm, force_n, angle_deg] = numbers else { return None };
        Some(Load::at_position(s_mm, finger.direction(angle_deg) * force_n))
    };
    let expected = "numbers (node, fx_n, fy_n) or (node, fx_n, fy_n, moment_nmm)";
    let mut all = loads("load", expected, load, node_load)?;
    all.extend(loads("load_at", "numbers (s_mm, force_n, angle_deg)", load_at, on_plate)?);
    if all.is_empty() {
        return Err(failed("expected at least one load or load_at"));
    }
    let kinematics = Kinematics::deserialize(IntoDeserializer::<Error>::into_deserializer(kinematics))
        .map_err(|error| failed(format!("kinematics: {error}")))?;
    let scene = scene.scene.clone();
    let of_scene = Arc::clone(&scene);
    let (shape, warnings) = interruptible(py, move |_| {
        let checked = CheckedShape::under(&of_scene, &all, kinematics, mesh_nodes).map_err(|error| match error {
            CheckedShapeError::Mesh(mesh) => failed(format!("mesh_nodes: {mesh}")),
            error => failed(error),
        })?;
        let warnings = checked.warnings().collect();
        Ok((checked.shape, warnings))
    })?;
    Ok(Shape::new(scene, shape, warnings))
}
