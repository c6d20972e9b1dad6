//! Simulated presses.

use crate::arrays::{self, not_negative};
use crate::error::failed;
use crate::interrupt::interruptible;
use crate::scene::Scene;
use crate::solve::Shape;
use finray_contact::press::{ContactScene, ForceRow, NO_OBJECT, SceneStep};
use finray_files::outline_corners;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use std::path::Path;
use std::sync::Arc;

/// True and sensed forces of a simulated press. For each step, every array has one entry per contact and one entry for the total.
#[pyclass(frozen, module = "finray")]
pub struct Press {
    rows: Vec<ForceRow>,
    shape: Py<Shape>,
    warnings: Vec<String>,
    stopped: Option<String>,
}

impl Press {
    fn column<'py>(&self, py: Python<'py>, of: impl Fn(&ForceRow) -> Option<f64>) -> Bound<'py, PyArray1<f64>> {
        arrays::column(py, self.rows.iter().map(|row| of(row).unwrap_or(f64::NAN)))
    }
}

#[pymethods]
impl Press {
    /// Number of the step, from 1.
    #[getter]
    fn step<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.rows.iter().map(|row| row.step as i64).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Length of the object's path, mm.
    #[getter]
    fn travel_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| Some(row.travel_mm))
    }

    /// Node of the contact, "at" for a position between nodes, "clamp" if the force does not deform the finger, or "total".
    #[getter]
    fn contact(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.contact.clone()).collect()
    }

    /// Position along the front plate, mm from the base; NaN for the total.
    #[getter]
    fn s_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.s_mm)
    }

    /// Direction of the contact normal, degrees from the undeformed inward normal, positive towards the tip; NaN for the total.
    #[getter]
    fn angle_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.angle_deg)
    }

    /// True force along the normal, N; for the total, along the object's motion.
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| Some(row.force_n))
    }

    /// True force across the normal, positive towards the tip, N; NaN for the total.
    #[getter]
    fn friction_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.friction_n)
    }

    /// Sensed force, N; NaN if the force is not identifiable.
    #[getter]
    fn sensed_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.sensed_n)
    }

    /// Stated standard deviation of the sensed force, N; NaN if none is stated.
    #[getter]
    fn sigma_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.sigma_n)
    }

    /// Position that the simulated camera reads, mm from the base; NaN if nothing was sensed.
    #[getter]
    fn read_s_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.read_s_mm)
    }

    /// Direction that the simulated camera reads, degrees; NaN if nothing was sensed.
    #[getter]
    fn read_angle_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.read_angle_deg)
    }

    /// Displacements in the last step.
    #[getter]
    fn shape(&self, py: Python<'_>) -> Py<Shape> {
        self.shape.clone_ref(py)
    }

    /// Notes and warnings of `finray press`, each about one step.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Reason why the press ended before its last step; None if it is complete.
    #[getter]
    fn stopped(&self) -> Option<String> {
        self.stopped.clone()
    }

    fn __len__(&self) -> usize {
        self.rows.len()
    }
}

/// Simulate an object pressed onto a finger, and sense the contact forces at each step, as `finray press` does.
///
/// Args:
///     scene: scene with a table object.
///     noise_mm: standard deviation of the noise in one coordinate of a node or outline point, mm; None: the scene's, or 0.
///     seed: seed of the noise.
///     fineness: elements per plate member, 1 to 100; None: doubled until total forces change by under 0.1 %.
///
/// Raises FinrayError for a scene without a valid object, and if the first step fails. Ctrl-C ends the press.
#[pyfunction]
#[pyo3(signature = (scene, *, noise_mm=None, seed=1, fineness=None))]
pub fn press(
    py: Python<'_>,
    scene: &Scene,
    noise_mm: Option<f64>,
    seed: u64,
    fineness: Option<usize>,
) -> PyResult<Press> {
    if let Some(found) = fineness.filter(|fineness| !(1..=100).contains(fineness)) {
        return Err(failed(format!("fineness: expected 1 to 100, found {found}")));
    }
    let noise_mm = not_negative("noise_mm", noise_mm)?.or(scene.scene.noise_mm).unwrap_or(0.0);
    let Scene { scene, path } = scene;
    // A message about a scene file begins with its path.
    let failed = |reason: &dyn std::fmt::Display| match path {
        Some(path) => crate::error::failed(format!("{}: {reason}", path.display())),
        None => crate::error::failed(reason),
    };
    let Some(object) = &scene.object else { return Err(failed(&NO_OBJECT)) };
    let (of_scene, object) = (Arc::clone(scene), object.clone());
    let folder = path.as_deref().and_then(Path::parent).unwrap_or(Path::new("")).to_owned();
    let (run, warnings, doubts) = interruptible(py, move |stop| {
        let scene = &*of_scene;
        let corners = outline_corners(scene, &folder).map_err(crate::error::failed)?;
        let mut prepared = ContactScene::new(scene, &object, &corners).map_err(crate::error::failed)?;
        prepared = prepared.with_stop(Arc::clone(stop));
        if let Some(fineness) = fineness {
            prepared = prepared.with_fineness(fineness);
        }
        let mut warnings = Vec::new();
        let each = |notes: &[String], _| warnings.extend_from_slice(notes);
        let run = finray_contact::press::Press::run(scene, &prepared, noise_mm, seed, each);
        warnings.extend(run.ended.iter().flatten().cloned().chain(run.validity_warnings()));
        let doubts = run.steps.last().map_or_else(Vec::new, |last| doubts(scene, last));
        Ok((run, warnings, doubts))
    })?;
    let warnings = warnings.into_iter().map(|warning| unlabelled(&warning).to_owned()).collect();
    let stopped = run.ended.as_ref().err().map(ToString::to_string);
    let Some(last) = run.steps.into_iter().next_back() else {
        return Err(failed(&stopped.unwrap_or_else(|| "no step".to_owned())));
    };
    let shape = Py::new(py, Shape::new(scene.clone(), last.pressed.shape, doubts))?;
    Ok(Press { rows: run.rows, shape, warnings, stopped })
}

/// Reasons why the beam model may be inaccurate in a step.
fn doubts(scene: &finray_model::Scene, step: &SceneStep) -> Vec<String> {
    match step.validity(&scene.finger) {
        Ok(validity) => {
            let warnings = validity.map(|validity| validity.warnings(&scene.strain_limits)).unwrap_or_default();
            warnings.iter().map(ToString::to_string).collect()
        }
        Err(error) => vec![format!("the beam model has no equilibrium under the contact forces: {error}")],
    }
}

/// A message without the label that the command prints before it.
fn unlabelled(message: &str) -> &str {
    ["note: ", "warning: "].iter().find_map(|label| message.strip_prefix(label)).unwrap_or(message)
}
