//! Loads on a finger and the equilibrium under them, for `solve` and `render`.

use super::Failure;
use super::parse::{PositionLoad, node_load, position_load};
use finray_model::frame::{FrameLoad, FrameMotion};
use finray_model::mesh::FingerShape;
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Finger, Kinematics, Load, Mesh};

/// Elements per member of successively finer meshes. `render` draws the first mesh whose markers all lie within `DRAWN_MM`, mm, of those on the previous
/// mesh. Errors fall with the square of the element length, so the remaining error is a third of the last change: 0.001 px at 10 px per mm.
const DRAWN_ELEMENTS: [usize; 7] = [4, 8, 16, 32, 64, 128, 256];
const DRAWN_MM: f64 = 3e-4;
/// Elements per member of the mesh against which `solve` checks the mesh of the key nodes.
const CHECKED_ELEMENTS: usize = 8;
/// `solve` warns if the error of a key node on the mesh of the key nodes exceeds this share of the largest displacement. The paper's finger on this mesh,
/// which is the paper's, stays below it where its strains are small.
const COARSE: f64 = 0.1;

/// Loads given on the command line, and the number of mesh nodes.
#[derive(clap::Args)]
pub struct Loads {
    /// Force (N) and optional moment (N mm) on a key node, in the finger frame
    #[arg(long, value_name = "NODE:FX,FY[,M]", value_parser = node_load, num_args = 1.., allow_hyphen_values = false)]
    load: Vec<Load>,
    /// Force (N) on the front plate, at S_MM from its base and ANGLE_DEG from the inward normal
    #[arg(long, value_name = "S_MM:FORCE,ANGLE_DEG", value_parser = position_load, num_args = 1..)]
    load_at: Vec<PositionLoad>,
    /// Number of mesh nodes [default: the number of key nodes; `render` refines the mesh]
    #[arg(long, value_name = "N")]
    mesh_nodes: Option<usize>,
}

impl Loads {
    /// Whether no load is given.
    pub fn is_empty(&self) -> bool {
        self.load.is_empty() && self.load_at.is_empty()
    }

    /// Builds the mesh.
    pub fn mesh(&self, finger: &Finger) -> Result<Mesh, Failure> {
        Ok(match self.mesh_nodes {
            None => Mesh::key_nodes(finger),
            Some(nodes) => Mesh::with_nodes(finger, nodes)?,
        })
    }

    /// Displacements for an image: on the requested mesh, or on meshes refined until each marker moves by at most `DRAWN_MM`.
    pub fn drawn_shape(&self, finger: &Finger) -> Result<FingerShape, Failure> {
        let on = |mesh: &Mesh| Ok::<_, Failure>(mesh.shape(&self.equilibrium(mesh, Kinematics::Corotational)?.0));
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

    /// Compares a shape on the mesh of the key nodes with the shape on a finer mesh. `None` if they agree, or the user chose the mesh.
    pub fn doubt_of_mesh(&self, finger: &Finger, kinematics: Kinematics, shape: &FingerShape) -> Option<String> {
        if self.mesh_nodes.is_some() {
            return None;
        }
        let finer = Mesh::with_elements_per_member(finger, CHECKED_ELEMENTS);
        let nodes = finer.node_count();
        let motion = match self.equilibrium(&finer, kinematics) {
            Ok((motion, _)) => motion,
            Err(failure) => {
                return Some(format!(
                    "the mesh of the key nodes may be too coarse: on {nodes} mesh nodes (--mesh-nodes {nodes}) there is no result: {}",
                    failure.reason()
                ));
            }
        };
        let finer = finer.shape(&motion);
        let pairs = shape.motions().iter().zip(finer.motions());
        let error_mm = pairs.map(|(a, b)| (a.displacement - b.displacement).norm()).fold(0.0, f64::max);
        let largest_mm = finer.largest_displacement_mm();
        (error_mm > COARSE * largest_mm).then(|| {
            format!(
                "the mesh of the key nodes is too coarse: on {nodes} mesh nodes (--mesh-nodes {nodes}) the largest displacement is {largest_mm:.3} mm, \
                 and a key node lies {error_mm:.3} mm elsewhere"
            )
        })
    }

    /// The equilibrium under the loads, exact within rounding, and the loads on the mesh.
    pub fn equilibrium(&self, mesh: &Mesh, kinematics: Kinematics) -> Result<(FrameMotion, Vec<FrameLoad>), Failure> {
        let finger = mesh.finger();
        let position_loads =
            self.load_at.iter().map(|l| Load::at_position(l.s_mm, finger.direction(l.angle_deg) * l.force_n));
        let loads = self.load.iter().copied().chain(position_loads).map(|load| mesh.frame_load(&load));
        let loads = loads.collect::<Result<Vec<_>, _>>().map_err(StaticsError::from)?;
        let motion = Statics::ladder(mesh, kinematics).accurate_equilibrium(&loads)?.motion;
        Ok((motion, loads))
    }
}
