//! Scenes: finger, camera, markers and contacts.

use crate::arrays;
use crate::error::failed;
use finray_figures::{Chart, Frame, Hue, Lines, Series};
use finray_files::load_scene;
use finray_fixtures::PAPER_SCENE;
use finray_model::finger::{FingerPoint, Part, Plate};
use finray_model::{Finger, NodeId};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A finger with its camera, markers and contacts, as `finray guide scene` describes it.
#[pyclass(frozen, module = "finray")]
pub struct Scene {
    pub(crate) scene: Arc<finray_model::Scene>,
    /// Path of the scene file; `None` for a scene from a text.
    pub(crate) path: Option<PathBuf>,
}

#[pymethods]
impl Scene {
    /// Read a scene file (TOML); "-" reads standard input.
    ///
    /// Raises FinrayError with file, line and key of the first fault.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Scene> {
        let scene = py.detach(|| load_scene(&path)).map_err(failed)?;
        Ok(Scene { scene: Arc::new(scene), path: Some(path) })
    }

    /// Read a scene from a text (TOML).
    ///
    /// Raises FinrayError with line and key of the first fault.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Scene> {
        let scene = finray_model::Scene::from_toml(text).map_err(failed)?;
        Ok(Scene { scene: Arc::new(scene), path: None })
    }

    /// The finger of Xu et al. (IEEE T-RO 2021), the default scene of the command `finray`.
    #[staticmethod]
    fn paper() -> PyResult<Scene> {
        Scene::parse(PAPER_SCENE)
    }

    /// Name of the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// Undeformed positions of the key nodes, mm, finger frame; shape (n, 2), in the order of nodes 1 to n.
    #[getter]
    fn key_nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let finger = self.finger();
        arrays::vectors(py, (1..=finger.key_node_count()).map(|node| finger.position(NodeId(node))))
    }

    /// Nodes that have a marker; shape (m,).
    #[getter]
    fn marked_nodes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        arrays::nodes(py, self.finger().marked_nodes())
    }

    /// Length of the front plate, mm.
    #[getter]
    fn front_length_mm(&self) -> f64 {
        self.finger().plate_length_mm(Plate::Front)
    }

    /// Width and height of the camera's images, px; None for a scene without a camera.
    #[getter]
    fn camera_size_px(&self) -> Option<(u32, u32)> {
        self.scene.camera.map(|camera| camera.lens.size_px().into())
    }

    /// Reasons why the scene probably does not describe the real finger, which the commands print as warnings.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.warnings().iter().map(ToString::to_string).collect()
    }

    /// Relative standard deviation of a sensed force due to the errors of the finger's model, which sigma_n includes.
    #[getter]
    fn model_error(&self) -> f64 {
        self.scene.model_error.share()
    }

    /// Drawing of the undeformed finger, for Jupyter.
    fn _repr_svg_(&self) -> PyResult<String> {
        let finger = self.finger();
        let part = |part: Part| lines(finger, |of| of == part, |at| point(finger, at));
        let mut series = Series::lines("front plate", part(Part::Front), Hue::BLUE, 4.0);
        series.extend(Series::lines("back plate", part(Part::Back), Hue::VERMILION, 4.0));
        series.extend(Series::lines("ribs", part(Part::Ribs), Hue::GREEN, 2.6));
        drawing(&self.scene.name, "The undeformed finger; the base is on the left.", series)
    }

    fn __repr__(&self) -> String {
        format!("<finray.Scene {:?}, {} key nodes>", self.scene.name, self.finger().key_node_count())
    }
}

impl Scene {
    fn finger(&self) -> &Finger {
        &self.scene.finger
    }
}

fn point(finger: &Finger, at: FingerPoint) -> [f64; 2] {
    let at = finger.point(at);
    [at.x, at.y]
}

/// Lines along the chosen parts of a finger; `at` gives the position of a point in the drawing, mm.
pub fn lines(finger: &Finger, is_drawn: impl Fn(Part) -> bool, at: impl Fn(FingerPoint) -> [f64; 2]) -> Lines {
    let drawn = finger.outline().into_iter().filter(|(part, _)| is_drawn(*part));
    drawn.map(|(_, points)| points.into_iter().map(&at).collect()).collect()
}

/// Lines of the undeformed finger, for the background of another drawing.
pub fn at_rest(finger: &Finger) -> Vec<Series> {
    Series::lines("at rest", lines(finger, |_| true, |at| point(finger, at)), Hue::FAINT, 3.0)
}

/// A drawing of a finger to scale, as SVG.
pub fn drawing(title: &str, alt: &str, series: Vec<Series>) -> PyResult<String> {
    Chart::to_scale(Frame::half(title, alt), ["base to tip, mm", "back to front, mm"], series).svg().map_err(failed)
}
