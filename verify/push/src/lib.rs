//! Simulation of a finger that a user pushes on a web page. The simulation computes the equilibrium under one force, and the force that a sensor
//! estimates from the noisy displacements of the markers.
//!
//! The report embeds this crate as WebAssembly (`push.wasm`). The page of the report therefore computes with the same beam model and the same sensor
//! as the program. A page sends a question and receives an answer, both in JSON (see [`Session::answer`]); a Rust program uses [`PushedFinger`].
//! Lengths are in mm, forces in N, angles in degrees, vectors in the finger frame of [`finray_model`].

mod drawing;
#[cfg(target_arch = "wasm32")]
mod exports;
mod session;

pub use drawing::{Drawing, Polyline};
pub use session::Session;

use finray_model::estimators::EstimatorId;
use finray_model::finger::Plate;
use finray_model::observation::Observation;
use finray_model::scene::SceneError;
use finray_model::sensing::{Contact, ContactPosition, ContactQuestion, Direction};
use finray_model::sensor::{Refusal, Sensor, SensorContacts, SensorOptions};
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Kinematics, Mesh, Scene, Vector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// This crate, compiled to WebAssembly by `verify/push/build` for a release.
#[cfg(not(target_arch = "wasm32"))]
pub const PROGRAM: &[u8] = include_bytes!("../push.wasm");

/// Whether [`PROGRAM`] was built from the present code of this crate and of the model. Otherwise, its numbers may differ from the library's.
#[cfg(not(target_arch = "wasm32"))]
pub fn program_is_current() -> bool {
    const BUILT: &str = include_str!("../push.digest");
    const PRESENT: &str = include_str!(concat!(env!("OUT_DIR"), "/push.digest"));
    BUILT == PRESENT
}

/// Number of mesh nodes of the true finger. Doubling this number changes the finger's displacements by less than a camera resolves.
pub const MESH_NODES: usize = 200;
/// Number of elements per member, for a finger that has more key nodes than [`MESH_NODES`].
const FEWEST_ELEMENTS: usize = 2;

/// A force on the finger, and the question to the sensor.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Position of the true force along the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction of the true force, degrees from the inward normal of the undeformed front plate, positive towards the tip.
    pub angle_deg: f64,
    /// The true force, N.
    pub force_n: f64,
    /// Whether the true finger is the finger of the scene `other`, see [`PushedFinger::new`]. The sensor always assumes the finger of the scene.
    #[serde(default)]
    pub is_other: bool,
    /// What the sensor knows of the contact.
    pub contact: Knowledge,
    /// Name of the estimator.
    pub estimator: String,
    /// Standard deviation of the noise in one coordinate of a marker, mm.
    pub noise_mm: f64,
    /// Number of the image, which is also the seed of the image's noise. Images with the same number have the same noise, whatever the force is.
    pub image: u64,
}

/// What the sensor knows of the contact.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Knowledge {
    /// Position and direction are known.
    Known,
    /// The sensor assumes a position and a direction that deviate from the true values by `by_mm` and `by_deg`. An assumed position beyond the tip is
    /// moved to the tip.
    Off {
        /// Assumed minus true position, mm.
        by_mm: f64,
        /// Assumed minus true direction, degrees.
        by_deg: f64,
    },
    /// The sensor estimates position and direction together with the force.
    Sought,
    /// The sensor is not asked. If the sensor is not asked, a page that shows a moving finger gets the shape without delay. The page can ask for the
    /// force when the finger rests.
    Unasked,
}

/// Result of a push: the bent finger with the sensor's answer, or the reason why there is no equilibrium.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pushed {
    /// The finger carries the force.
    Bent(Box<Bent>),
    /// No equilibrium under the force was found. Holds the reason.
    NotCarried(String),
}

/// A finger bent by a force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bent {
    /// Lines along the members of the bent finger.
    pub lines: Vec<Polyline>,
    /// Point of the bent front plate at which the force acts, mm.
    pub at: [f64; 2],
    /// True displacement of each marked node, mm.
    pub displacements: Vec<[f64; 2]>,
    /// Displacement of each marked node with noise, mm: the input of the sensor.
    pub seen: Vec<[f64; 2]>,
    /// Answer of the sensor.
    pub sensed: Sensed,
}

/// Answer of the sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sensed {
    /// A force.
    Force(Box<SensedForce>),
    /// The sensor gave no force. Holds the reason.
    Refused(String),
    /// The sensor was not asked.
    Unasked,
}

/// A sensed force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensedForce {
    /// The force along the direction at `angle_deg`, N.
    pub force_n: f64,
    /// Standard deviation of the force, N.
    pub sigma_n: f64,
    /// Lower and upper limit of the 95 % interval, N.
    pub interval_n: [f64; 2],
    /// Known, assumed or estimated position along the front plate, mm from the base.
    pub s_mm: Option<f64>,
    /// Known, assumed or estimated direction, degrees; see [`Push::angle_deg`].
    pub angle_deg: f64,
    /// Point of the bent front plate at `s_mm`, mm.
    pub at: Option<[f64; 2]>,
    /// Reasons why the error of the force may exceed its interval.
    pub warnings: Vec<String>,
}

/// A scene's finger on which one force acts.
#[derive(Debug, Clone)]
pub struct PushedFinger {
    scene: Scene,
    mesh: Mesh,
    other: Option<Mesh>,
}

impl PushedFinger {
    /// The finger of the scene with the text `scene` (TOML). `other` is the text of a scene whose finger differs but has the same number of nodes.
    /// The other finger can be the true finger, so that the sensor assumes a wrong finger.
    ///
    /// # Errors
    /// [`SceneError`] if a scene cannot be read.
    pub fn new(scene: &str, other: Option<&str>) -> Result<PushedFinger, SceneError> {
        let scene = Scene::from_toml(scene)?;
        let other = other.map(Scene::from_toml).transpose()?;
        let mesh = drawn_mesh(&scene);
        Ok(PushedFinger { mesh, other: other.as_ref().map(drawn_mesh), scene })
    }

    /// The finger at rest.
    pub fn drawing(&self) -> Drawing {
        Drawing::new(&self.scene, &self.mesh)
    }

    /// Pushes the finger and senses the force.
    pub fn push(&self, push: &Push) -> Pushed {
        let mesh = self.other.as_ref().filter(|_| push.is_other).unwrap_or(&self.mesh);
        match self.bent(mesh, push) {
            Ok(bent) => Pushed::Bent(Box::new(bent)),
            Err(error) => Pushed::NotCarried(error.to_string()),
        }
    }

    fn bent(&self, mesh: &Mesh, push: &Push) -> Result<Bent, StaticsError> {
        let &Push { s_mm, angle_deg, force_n, .. } = push;
        let contact = Contact { position: ContactPosition::at(s_mm), angle_deg };
        let load = mesh.frame_load(&contact.load(mesh.finger(), force_n))?;
        let motion = Statics::ladder(mesh, Kinematics::Corotational).accurate_equilibrium(&[load])?.motion;
        let shape = mesh.shape(&motion);
        let exact = Observation::of_shape(mesh.finger(), &shape);
        let seen = with_noise(exact.clone(), push);
        let on_plate = |s_mm: f64| mesh.plate_point(&motion, s_mm).map(xy);
        let displacements = |seen: &Observation| seen.markers.iter().filter_map(|it| it.displacement).map(xy).collect();
        Ok(Bent {
            lines: drawing::lines(mesh, Some(&motion)),
            at: on_plate(s_mm)?,
            displacements: displacements(&exact),
            seen: displacements(&seen),
            sensed: self.sensed(&seen, push, |s_mm| on_plate(s_mm).ok()).unwrap_or_else(Sensed::Refused),
        })
    }

    /// The question to the sensor about the contact; `None` for [`Knowledge::Unasked`].
    fn question(&self, push: &Push) -> Option<ContactQuestion> {
        let at = |s_mm, angle_deg| ContactQuestion::new(Some(ContactPosition::at(s_mm)), Direction::Angle(angle_deg));
        match push.contact {
            Knowledge::Unasked => None,
            Knowledge::Sought => Some(ContactQuestion::new(None, Direction::Auto)),
            Knowledge::Known => Some(at(push.s_mm, push.angle_deg)),
            Knowledge::Off { by_mm, by_deg } => {
                let length_mm = self.scene.finger.plate_length_mm(Plate::Front);
                Some(at((push.s_mm + by_mm).min(length_mm), push.angle_deg + by_deg))
            }
        }
    }

    /// The force at the known, assumed or estimated contact. `Err` holds the reason why the sensor gave no force. `at` returns the point of the bent
    /// front plate at a position (both in mm).
    fn sensed(&self, seen: &Observation, push: &Push, at: impl Fn(f64) -> Option<[f64; 2]>) -> Result<Sensed, String> {
        let Some(question) = self.question(push) else { return Ok(Sensed::Unasked) };
        let estimator = estimators().find(|estimator| estimator.name() == push.estimator).ok_or_else(|| {
            let names: Vec<&str> = estimators().map(EstimatorId::name).collect();
            format!("expected an estimator of {}, found {:?}", names.join(", "), push.estimator)
        })?;
        let options = SensorOptions { estimator, noise_mm: Some(push.noise_mm), ..SensorOptions::default() };
        let contacts = SensorContacts::Asked(vec![question]);
        let refusal = |refusal: Refusal| refusal.to_string();
        let sensor = Sensor::new(self.scene.clone(), contacts, options).map_err(refusal)?;
        let sensed = sensor.sense(seen).map_err(refusal)?;
        let force = sensed.forces[0];
        let s_mm = force.contact.position_mm(&self.scene.finger);
        let validity = sensor.assess_validity(&sensed).unwrap_or_default();
        let warnings = sensed.warnings.iter().map(ToString::to_string);
        Ok(Sensed::Force(Box::new(SensedForce {
            force_n: force.force_n,
            sigma_n: force.sigma_n,
            interval_n: force.interval_n(),
            s_mm,
            at: s_mm.and_then(at),
            angle_deg: force.contact.angle_deg,
            warnings: warnings.chain(validity.iter().map(ToString::to_string)).collect(),
        })))
    }
}

/// Estimators that need no files.
fn estimators() -> impl Iterator<Item = EstimatorId> {
    EstimatorId::ALL.iter().copied().filter(|estimator| *estimator != EstimatorId::Network)
}

fn drawn_mesh(scene: &Scene) -> Mesh {
    Mesh::with_nodes(&scene.finger, MESH_NODES)
        .unwrap_or_else(|_| Mesh::with_elements_per_member(&scene.finger, FEWEST_ELEMENTS))
}

/// The observation with the noise of image number `push.image`.
fn with_noise(mut seen: Observation, push: &Push) -> Observation {
    let mut chance = ChaCha8Rng::seed_from_u64(push.image);
    for marker in &mut seen.markers {
        let noise = Vector::from_fn(|_, _| StandardNormal.sample(&mut chance)) * push.noise_mm;
        marker.displacement = marker.displacement.map(|exact| exact + noise);
    }
    seen
}

fn xy(vector: Vector) -> [f64; 2] {
    [vector.x, vector.y]
}
