//! Forces from observations.

use crate::arrays::{self, not_negative};
use crate::error::{failed, refused};
use crate::interrupt::interruptible;
use crate::observation::Observation;
use crate::scene::Scene;
use finray_files::load_network;
use finray_model::estimators::network::Networks;
use finray_model::estimators::{EstimatorError, EstimatorId};
use finray_model::sensing;
use finray_model::sensor::{
    ContactSpec, ContactTextError, Refusal, SensedForce, SensedForces, SensorContacts, SensorOptions,
};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// The options of a sensor, checked, with its networks.
pub fn options(
    estimator: &str,
    network: Option<PathBuf>,
    noise_mm: Option<f64>,
    mesh_nodes: Option<usize>,
) -> PyResult<SensorOptions> {
    let names = || EstimatorId::ALL.iter().map(|estimator| estimator.name()).collect::<Vec<_>>().join(", ");
    let id = EstimatorId::ALL.iter().copied().find(|id| id.name() == estimator);
    let estimator = id.ok_or_else(|| failed(format!("estimator: expected one of {}, found {estimator:?}", names())))?;
    let networks = match (network, estimator) {
        (None, EstimatorId::Network) => Networks::read(&finray_fixtures::NETWORKS).map_err(failed)?,
        (None, _) => Networks::none().clone(),
        (Some(path), EstimatorId::Network) => Networks::of(vec![load_network(&path).map_err(failed)?.0]),
        (Some(_), _) => {
            return Err(failed("network: expected only with the estimator \"network\", found another estimator"));
        }
    };
    Ok(SensorOptions { estimator, networks, noise_mm: not_negative("noise_mm", noise_mm)?, mesh_nodes })
}

/// A contact as a number or in the notation of the command line. `None` for any other value.
fn contact_text(value: &Bound<'_, PyAny>) -> Option<String> {
    value.extract().ok().or_else(|| arrays::number(value).map(|number| number.to_string()))
}

/// One contact or several, in the notation of the command line. `name` is the name of the argument.
fn contact_texts(name: &str, value: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    if let Some(text) = contact_text(value) {
        return Ok(vec![text]);
    }
    let items = arrays::items(value).ok_or_else(|| {
        failed(format!("{name}: expected a number, a text or a sequence of them, found {}", arrays::found(value)))
    })?;
    let wrong = |i, item| failed(format!("{name}[{i}]: expected a number or a text, found {}", arrays::found(item)));
    items.iter().enumerate().map(|(i, item)| contact_text(item).ok_or_else(|| wrong(i, item))).collect()
}

/// The contacts at positions (`contact_at`), then those at nodes (`contact`).
pub fn contacts(
    scene: &Scene,
    contact_at: Option<&Bound<'_, PyAny>>,
    contact: Option<&Bound<'_, PyAny>>,
    friction: f64,
) -> PyResult<SensorContacts> {
    let parsed = |name: &str, texts: Vec<String>, parse: fn(&str) -> Result<ContactSpec, ContactTextError>| {
        let wrong = |reason| failed(format!("{name}: {reason}"));
        texts.iter().map(|text| parse(text).map_err(wrong)).collect::<PyResult<Vec<_>>>()
    };
    let mut asked = parsed("contact_at", contact_texts("contact_at", contact_at)?, ContactSpec::at_position)?;
    asked.extend(parsed("contact", contact_texts("contact", contact)?, ContactSpec::at_node)?);
    SensorContacts::from_specs(&asked, &scene.scene, friction, None).map_err(failed)
}

/// Estimates contact forces from observations of a finger, as `finray sense` does.
///
/// Args:
///     scene: the finger.
///     contact_at: contacts at positions along a plate: a number, a text, or a sequence of them. A number is a distance from the base of the
///         front plate, mm. A text has the notation of `finray sense --contact-at`: "80@-20" is 80 mm from the base, -20 degrees from the inward
///         normal (positive towards the tip); "back:80@-20": on the back plate; "auto@auto": position and direction unknown; "80" and "auto" without a direction: along the normal of the undeformed
///         plate.
///     contact: contacts at nodes: a node, a text in the notation of `--contact` such as "19@normal", or a sequence of them.
///     noise_mm: standard deviation of one coordinate, mm; None: from the scene, else from the observation, else from the residual.
///     estimator: name of the estimator, as in `finray sense --help`.
///     network: file of a network of `finray train`; None: the shipped networks.
///     mesh_nodes: number of mesh nodes of the nonlinear estimator; None: the mesh is refined until the result converges.
///     friction: friction coefficient that limits the directions of contacts with standard deviations ("80+-1@0+-5").
///
/// The order of the forces is that of the contacts: first `contact_at`, then `contact`.
///
/// Raises FinrayError if the contacts are wrong, or the estimator does not support them.
#[pyclass(frozen, module = "finray")]
pub struct Sensor {
    scene: Arc<finray_model::Scene>,
    sensor: Arc<finray_model::sensor::Sensor>,
}

#[pymethods]
impl Sensor {
    #[new]
    #[pyo3(signature = (
        scene, contact_at=None, *, contact=None, noise_mm=None, estimator="nonlinear", network=None, mesh_nodes=None, friction=0.0
    ))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn new(
        scene: &Scene,
        contact_at: Option<&Bound<'_, PyAny>>,
        contact: Option<&Bound<'_, PyAny>>,
        noise_mm: Option<f64>,
        estimator: &str,
        network: Option<PathBuf>,
        mesh_nodes: Option<usize>,
        friction: f64,
    ) -> PyResult<Sensor> {
        let friction = not_negative("friction", Some(friction))?.unwrap_or_default();
        let contacts = contacts(scene, contact_at, contact, friction)?;
        let options = options(estimator, network, noise_mm, mesh_nodes)?;
        let scene = scene.scene.clone();
        let sensor = finray_model::sensor::Sensor::new(scene.clone(), contacts, options);
        let sensor = sensor.map_err(|refusal| match refusal {
            Refusal::Estimator(EstimatorError::Mesh(mesh)) => failed(format!("mesh_nodes: {mesh}")),
            refusal => failed(refusal),
        })?;
        Ok(Sensor { scene, sensor: Arc::new(sensor) })
    }

    /// Estimate the forces of an observation.
    ///
    /// Raises FinrayError if the observation does not fit the finger, and Refused if the forces are not identifiable.
    fn sense(&self, py: Python<'_>, observation: &Observation) -> PyResult<Forces> {
        let (sensor, seen) = (Arc::clone(&self.sensor), observation.seen.clone());
        let (warnings, sensed) = interruptible(py, move |_| {
            let sensed = sensor.sense(&seen).map_err(of_refusal)?;
            let warnings = sensed.warnings.iter().map(ToString::to_string).chain(sensor.validity_warnings(&sensed));
            Ok((warnings.collect(), sensed))
        })?;
        Ok(Forces { scene: self.scene.clone(), sensed, warnings })
    }

    /// All answers for contacts at unknown positions that explain an observation about equally well, the best first. Where `sense` refuses an observation
    /// because of two ranges of positions with different forces, this method returns the best answer in each range.
    ///
    /// Raises FinrayError if the observation does not fit the finger, and Refused if the forces are not identifiable for another reason.
    fn alternatives(&self, py: Python<'_>, observation: &Observation) -> PyResult<Vec<Alternative>> {
        let (sensor, seen) = (Arc::clone(&self.sensor), observation.seen.clone());
        let found = interruptible(py, move |_| sensor.alternatives(&seen).map_err(of_refusal))?;
        Ok(found.into_iter().map(Alternative::from).collect())
    }
}

/// The exception for an observation that does not fit the finger, or for forces that are not identifiable.
fn of_refusal(refusal: Refusal) -> PyErr {
    match refusal {
        Refusal::Observation(error) => failed(error),
        refusal => refused(refusal),
    }
}

/// One of several answers that explain an observation about equally well.
#[pyclass(frozen, get_all, module = "finray")]
pub struct Alternative {
    /// Number of the contact, from 0.
    contact: usize,
    /// Best position, mm from the base.
    s_mm: f64,
    /// Limits of the 95 % interval of the position within this answer, mm from the base.
    s_interval_mm: (f64, f64),
    /// Direction of the force, degrees from the inward normal of the undeformed plate.
    angle_deg: f64,
    /// Force, N.
    force_n: f64,
    /// Limits of the 95 % interval of the force within this answer, N.
    interval_n: (f64, f64),
    /// Excess of the misfit over that of the best answer, in variances of the noise.
    excess_misfit: f64,
}

impl From<sensing::Alternative> for Alternative {
    fn from(answer: sensing::Alternative) -> Alternative {
        Alternative {
            contact: answer.contact,
            s_mm: answer.position_mm,
            s_interval_mm: answer.position_interval_mm.into(),
            angle_deg: answer.angle_deg,
            force_n: answer.force_n,
            interval_n: answer.interval_n.into(),
            excess_misfit: answer.excess,
        }
    }
}

#[pymethods]
impl Alternative {
    fn __repr__(&self) -> String {
        let Alternative { s_mm, force_n, interval_n: (low_n, high_n), .. } = self;
        format!("<finray.Alternative {force_n:.4} N ({low_n:.4} to {high_n:.4} N) at {s_mm:.2} mm>")
    }
}

/// Estimated forces, in the order of the contacts: first `contact_at`, then `contact`.
#[pyclass(frozen, module = "finray")]
pub struct Forces {
    scene: Arc<finray_model::Scene>,
    sensed: SensedForces,
    warnings: Vec<String>,
}

impl Forces {
    fn column<'py>(&self, py: Python<'py>, of: impl Fn(&SensedForce) -> f64) -> Bound<'py, PyArray1<f64>> {
        arrays::column(py, self.sensed.forces.iter().map(of))
    }
}

#[pymethods]
impl Forces {
    /// Node of each contact, or "at" for a contact at a position; "back:60" for a position on the back plate.
    #[getter]
    fn contacts(&self) -> Vec<String> {
        self.sensed.forces.iter().map(|sensed| sensed.contact.position.name()).collect()
    }

    /// Position of each contact along its plate, mm from the base; shape (k,). NaN for a node that is not on the front plate.
    #[getter]
    fn s_mm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |sensed| sensed.contact.position_mm(&self.scene.finger).unwrap_or(f64::NAN))
    }

    /// Direction of each force, degrees from the inward normal of its undeformed plate, positive towards the tip; shape (k,).
    #[getter]
    fn angle_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |sensed| sensed.contact.angle_deg)
    }

    /// Force of each contact along its direction, N; shape (k,).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |sensed| sensed.force_n)
    }

    /// Standard deviation of each force, N; shape (k,).
    #[getter]
    fn sigma_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |sensed| sensed.sigma_n)
    }

    /// Lower and upper limit of the 95 % interval of each force, N; shape (k, 2).
    #[getter]
    fn interval_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::pairs(py, self.sensed.forces.iter().map(SensedForce::interval_n))
    }

    /// Reasons why the forces may be less accurate than stated.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn __len__(&self) -> usize {
        self.sensed.forces.len()
    }

    fn __repr__(&self) -> String {
        let force = |sensed: &SensedForce| format!("{:.4} +- {:.4} N", sensed.force_n, sensed.sigma_n);
        let forces: Vec<String> = self.sensed.forces.iter().map(force).collect();
        format!("<finray.Forces {}>", forces.join(", "))
    }
}
