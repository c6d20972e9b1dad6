//! Observed markers.

use crate::arrays;
use crate::error::failed;
use finray_model::Vector;
use finray_model::observation::ObservedMarker;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

/// Observed markers of a finger: positions or displacements, with standard deviations.
///
/// Args:
///     nodes: nodes of the markers, integers; shape (n,).
///     displacements: displacements of the markers from their unloaded positions, mm, finger frame; shape (n, 2). They take precedence over positions.
///     positions: positions of the markers on the deformed finger, mm, finger frame; shape (n, 2).
///     sigma_mm: standard deviation of one coordinate, mm; one number for all markers, or shape (n,). None if unknown.
///
/// Raises FinrayError for arrays of another shape or type, for masked arrays, and without displacements and positions.
#[pyclass(frozen, module = "finray")]
pub struct Observation {
    pub(crate) seen: finray_model::observation::Observation,
    warnings: Vec<String>,
}

impl Observation {
    /// Wraps an observation.
    pub fn new(seen: finray_model::observation::Observation) -> Observation {
        Observation { seen, warnings: Vec::new() }
    }

    /// Adds warnings.
    pub fn with_warnings(self, warnings: Vec<String>) -> Observation {
        Observation { warnings, ..self }
    }

    /// Vectors of all markers; `None` unless every marker has a vector.
    fn vectors<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&ObservedMarker) -> Option<Vector>,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let all: Option<Vec<Vector>> = self.seen.markers.iter().map(of).collect();
        all.map(|all| arrays::vectors(py, all.into_iter())).transpose()
    }

    fn numbers<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&ObservedMarker) -> Option<f64>,
    ) -> Option<Bound<'py, PyArray1<f64>>> {
        let all: Option<Vec<f64>> = self.seen.markers.iter().map(of).collect();
        all.map(|all| arrays::column(py, all.into_iter()))
    }
}

#[pymethods]
impl Observation {
    #[new]
    #[pyo3(signature = (nodes, displacements=None, *, positions=None, sigma_mm=None))]
    fn python_new(
        nodes: &Bound<'_, PyAny>,
        displacements: Option<&Bound<'_, PyAny>>,
        positions: Option<&Bound<'_, PyAny>>,
        sigma_mm: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Observation> {
        let nodes = arrays::nodes_of(nodes)?;
        let vectors = |name, value: Option<&Bound<'_, PyAny>>| {
            value.map(|value| arrays::vectors_of(name, value, nodes.len())).transpose()
        };
        let (displacements, positions) = (vectors("displacements", displacements)?, vectors("positions", positions)?);
        if displacements.is_none() && positions.is_none() {
            return Err(failed("expected displacements or positions of the markers"));
        }
        let sigmas_mm = sigma_mm.map(|value| arrays::deviations_of("sigma_mm", value, nodes.len())).transpose()?;
        let marker = |(i, node)| ObservedMarker {
            node,
            pixel: None,
            position: positions.as_ref().map(|all| all[i]),
            displacement: displacements.as_ref().map(|all| all[i]),
            sd_mm: sigmas_mm.as_ref().map(|all| all[i]),
            own_sd_mm: None,
        };
        let markers = nodes.iter().copied().enumerate().map(marker).collect();
        Ok(Observation::new(finray_model::observation::Observation { markers, ..Default::default() }))
    }

    /// Nodes of the markers; shape (n,).
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        arrays::nodes(py, self.seen.markers.iter().map(|marker| marker.node))
    }

    /// Centres of the markers in the image, px, u to the right and v downwards; shape (n, 2). None without an image.
    #[getter]
    fn pixels<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.vectors(py, |marker| marker.pixel)
    }

    /// Positions on the deformed finger, mm, finger frame; shape (n, 2). None if unknown.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.vectors(py, |marker| marker.position)
    }

    /// Displacements from the unloaded positions, mm, finger frame; shape (n, 2). None if unknown.
    #[getter]
    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.vectors(py, |marker| marker.displacement)
    }

    /// Standard deviations of one coordinate, mm, including all errors; shape (n,). None if unknown.
    #[getter]
    fn sigma_mm<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.numbers(py, |marker| marker.sd_mm)
    }

    /// Standard deviations of one coordinate, mm, without the error of the base's pose; shape (n,). None if unknown.
    #[getter]
    fn marker_sigma_mm<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.numbers(py, |marker| marker.own_sd_mm)
    }

    /// Pose of a moving base relative to the camera's pose: x_mm, y_mm, angle_deg. None for a fixed base.
    #[getter]
    fn base_pose(&self) -> Option<(f64, f64, f64)> {
        let pose = self.seen.base?.pose;
        Some((pose.translation.x, pose.translation.y, pose.rotation.angle().to_degrees()))
    }

    /// Reasons why the positions may be inaccurate.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn __len__(&self) -> usize {
        self.seen.markers.len()
    }

    fn __repr__(&self) -> String {
        format!("<finray.Observation of {} markers>", self.seen.markers.len())
    }
}
