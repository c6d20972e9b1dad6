//! Loads on a finger, and the finger's shape under these loads, for `solve` and `render`.

use super::Failure;
use super::parse::{PositionLoad, node_load, position_load};
use finray_model::checked_shape::CheckedShape;
use finray_model::frame::FrameMotion;
use finray_model::mesh::FingerShape;
use finray_model::statics;
use finray_model::{Finger, Kinematics, Load, Mesh, Scene};

/// Elements per member of successively finer meshes. `render` draws the first mesh on which each marker lies within `DRAWN_MM`, mm, of its position
/// on the previous mesh. Errors fall with the square of the element length. The remaining error of a marker is thus at most a third of `DRAWN_MM`:
/// 0.001 px at 10 px per mm.
const DRAWN_ELEMENTS: [usize; 7] = [4, 8, 16, 32, 64, 128, 256];
const DRAWN_MM: f64 = 3e-4;

/// Loads given on the command line, and the number of mesh nodes.
#[derive(clap::Args)]
pub struct Loads {
    /// Force (N) and optional moment (N mm) on a key node, in the finger frame
    #[arg(long, value_name = "NODE:FX,FY[,M]", value_parser = node_load, num_args = 1.., allow_hyphen_values = false)]
    load: Vec<Load>,
    /// Force (N) on the front plate, at S_MM from its base and at ANGLE_DEG from the inward normal
    #[arg(long, value_name = "S_MM:FORCE,ANGLE_DEG", value_parser = position_load, num_args = 1..)]
    load_at: Vec<PositionLoad>,
    /// Number of mesh nodes [default: the key nodes for `solve`, a refined mesh for `render`]
    #[arg(long, value_name = "N")]
    mesh_nodes: Option<usize>,
}

impl Loads {
    /// Whether no load is given.
    pub fn is_empty(&self) -> bool {
        self.load.is_empty() && self.load_at.is_empty()
    }

    /// Builds the mesh.
    fn mesh(&self, finger: &Finger) -> Result<Mesh, Failure> {
        Ok(match self.mesh_nodes {
            None => Mesh::key_nodes(finger),
            Some(nodes) => Mesh::with_nodes(finger, nodes)?,
        })
    }

    /// Displacements for an image: on the requested mesh, or on a mesh refined until the last refinement moves no marker by more than `DRAWN_MM`.
    pub fn drawn_shape(&self, finger: &Finger) -> Result<FingerShape, Failure> {
        let loads = self.on(finger);
        let on = |mesh: &Mesh| Ok::<_, Failure>(statics::solve(mesh, &loads, Kinematics::Corotational)?);
        if self.is_empty() {
            let mesh = self.mesh(finger)?;
            return Ok(mesh.shape(&FrameMotion::at_rest(mesh.frame())));
        }
        if self.mesh_nodes.is_some() {
            return on(&self.mesh(finger)?);
        }
        let [first, finer @ ..] = DRAWN_ELEMENTS;
        let mut shape = on(&Mesh::with_elements_per_member(finger, first))?;
        for elements in finer {
            let coarse = std::mem::replace(&mut shape, on(&Mesh::with_elements_per_member(finger, elements))?);
            let pairs = coarse.motions().iter().zip(shape.motions());
            let moved = pairs.map(|(a, b)| (a.marker_displacement(finger) - b.marker_displacement(finger)).norm());
            if moved.fold(0.0, f64::max) <= DRAWN_MM {
                break;
            }
        }
        Ok(shape)
    }

    /// Displacements of a scene's finger, with the reasons why they may be inaccurate.
    pub fn checked_shape(&self, scene: &Scene, kinematics: Kinematics) -> Result<CheckedShape, Failure> {
        Ok(CheckedShape::under(scene, &self.on(&scene.finger), kinematics, self.mesh_nodes)?)
    }

    fn on(&self, finger: &Finger) -> Vec<Load> {
        let at = |load: &PositionLoad| Load::at_position(load.s_mm, finger.direction(load.angle_deg) * load.force_n);
        self.load.iter().copied().chain(self.load_at.iter().map(at)).collect()
    }
}
