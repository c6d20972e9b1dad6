//! Fingers, object and support, their state, and the loads on the object.

use crate::ContactError;
use crate::outline::{ContactOutline, Feature};
use crate::region::Region;
use crate::surface::Surface;
use finray_model::frame::FrameMotion;
use finray_model::gripper::Placement;
use finray_model::mesh::Load;
use finray_model::statics::{Ladder, Statics};
use finray_model::{Kinematics, Mesh, Vector};
use std::collections::BTreeMap;

/// A contact counts as unloaded below this force, relative to the force that would bend a finger by the object's size.
const ROUNDING: f64 = 1e-11;
/// Compliance of a contact, relative to the finger's compliance. The compliance of contacts determines how friction is shared between two contacts of
/// the rigid object with the rigid support.
const YIELD: f64 = 1e-6;

/// Identifies a contact pair by the index of the finger, the index of its part, and the object's feature. The support has the index after the last finger.
pub(crate) type Key = (usize, usize, Feature);

/// A finger with its contact surface and the solver of its equilibrium equations.
#[derive(Debug, Clone)]
pub(crate) struct PlacedFinger<'m> {
    /// Elements of the finger.
    pub mesh: &'m Mesh,
    /// Equilibrium equations.
    pub ladder: Ladder<'m>,
    /// Contact surface of the finger in the object's region.
    pub surface: Surface,
    /// Stiffness of the undeformed finger at its middle, N/mm.
    pub stiffness: f64,
}

impl<'m> PlacedFinger<'m> {
    /// A finger whose rods have the given radius, mm. A point of the object (mm, finger frame) selects the region in which the object is.
    pub fn new(mesh: &'m Mesh, rod_radius_mm: f64, point: Vector) -> Result<PlacedFinger<'m>, ContactError> {
        let region = Region::of(mesh.finger(), point);
        Ok(PlacedFinger {
            mesh,
            ladder: Ladder::new(mesh, Kinematics::Corotational),
            surface: Surface::new(mesh, rod_radius_mm, region)?,
            stiffness: middle_stiffness(mesh)?,
        })
    }
}

/// Stiffness of an undeformed finger at its middle, N/mm.
fn middle_stiffness(mesh: &Mesh) -> Result<f64, ContactError> {
    let finger = mesh.finger();
    let middle = finger.contact_nodes().nth(finger.contact_nodes().len() / 2).unwrap_or(finger.tip());
    let load = mesh.frame_load(&Load::at_node(middle, finger.direction(0.0)));
    let load = load.map_err(finray_model::statics::StaticsError::from)?;
    let motions = Statics::ladder(mesh, Kinematics::Linear).unit_motions(&[load])?;
    Ok(1.0 / mesh.shape(&motions[0]).largest_displacement_mm())
}

/// Data that do not change during a grasp.
#[derive(Debug, Clone)]
pub(crate) struct Scene<'m> {
    /// The fingers, the left one first.
    pub fingers: Vec<PlacedFinger<'m>>,
    /// Outline of the object.
    pub shape: ContactOutline,
    /// Coefficient of Coulomb friction, dimensionless.
    pub friction: f64,
    /// Centre of mass in the object's frame, mm.
    pub centre: Vector,
    /// Stiffness of the softest finger, N/mm; the scale for tolerances.
    pub stiffness: f64,
    /// Length scale, mm: the object's size, or a share of the finger's length if a hand holds the object.
    pub size_mm: f64,
    /// Whether a hand holds the object against motion in x, motion in y, and rotation.
    pub held: [bool; 3],
}

/// Placements, motions and contact forces at one instant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct State {
    /// Placement of each finger's frame in the world.
    pub placements: Vec<Placement>,
    /// Motion of each finger's mesh, in the finger's frame.
    pub motions: Vec<FrameMotion>,
    /// Position of the object, mm, and its angle, rad, world frame.
    pub object: [f64; 3],
    /// Normal and friction force of each contact pair within the search distance, N.
    pub forces: BTreeMap<Key, [f64; 2]>,
}

/// Numerical resistance, and the loads on the object other than the contact forces of the fingers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surroundings {
    /// Weight of the object, world frame, N.
    pub weight: Vector,
    /// A point of the support (mm) and its upward unit normal, world frame.
    pub support: Option<(Vector, Vector)>,
    /// Displacement of the gripper in this step, mm. The Newton iteration starts with the object displaced by this vector; numerical resistance acts
    /// against further displacement.
    pub carried: Vector,
    /// Numerical resistance to the object's translation since the start of the step, N/mm. Resistance to rotation is this value times the square of the
    /// object's size, in N mm per rad.
    pub drag: f64,
    /// Numerical resistance to the motion of every key node in its finger's frame, N/mm. With the numerical resistance, an increment across a snap is
    /// solvable although no equilibrium path crosses the snap.
    pub finger_drag: f64,
}

impl Surroundings {
    /// Pose `[x, y, angle]` (mm, rad) of an object that has moved along with the gripper.
    pub(crate) fn carried_from(&self, object: [f64; 3]) -> [f64; 3] {
        let [x, y, angle] = object;
        [x + self.carried.x, y + self.carried.y, angle]
    }
}

impl Scene<'_> {
    /// Largest displacement between two states, mm, of the object or of any node in its finger's frame. A rotation of the object counts as its angle
    /// times the object's size.
    pub(crate) fn moved_mm(&self, from: &State, to: &State) -> f64 {
        let [x, y, angle] = [0, 1, 2].map(|i| to.object[i] - from.object[i]);
        let fingers = from.motions.iter().zip(&to.motions);
        let bent = fingers.map(|(a, b)| largest_mm(a.displacements.iter().zip(&b.displacements).map(|(a, b)| b - a)));
        bent.fold(x.hypot(y).max(angle.abs() * self.size_mm), f64::max)
    }

    /// Numerical resistance of the object in x and y, N/mm, and to rotation, N mm per rad.
    pub(crate) fn drags(&self, around: &Surroundings) -> [f64; 3] {
        [around.drag, around.drag, around.drag * self.size_mm * self.size_mm]
    }

    /// Compression of a contact under a force, mm.
    pub(crate) fn yield_mm(&self, force_n: f64) -> f64 {
        YIELD / self.stiffness * force_n
    }

    /// Force below which a contact counts as unloaded, N.
    pub(crate) fn nothing_n(&self) -> f64 {
        ROUNDING * self.stiffness * self.size_mm
    }
}

/// Largest magnitude of several vectors.
pub(crate) fn largest_mm(vectors: impl Iterator<Item = Vector>) -> f64 {
    vectors.map(|vector| vector.norm_squared()).fold(0.0, f64::max).sqrt()
}
