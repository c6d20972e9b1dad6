//! Loads on a finger and the equilibrium under them, as `solve` and `render` take them.

use super::Failure;
use super::parse::{NodeLoad, PositionLoad, node_load, position_load};
use finray_model::frame::{FrameLoad, FrameMotion};
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Finger, Kinematics, Load, Mesh};

/// Loads and the mesh that carries them.
#[derive(clap::Args)]
pub struct Loads {
    /// Force in N (and moment in N mm) on a key node, finger frame
    #[arg(long, value_name = "NODE:FX,FY[,M]", value_parser = node_load, num_args = 1.., allow_hyphen_values = false)]
    load: Vec<NodeLoad>,
    /// Force in N at a position along the front plate (mm from its base), at an angle from the inward normal
    #[arg(long, value_name = "S_MM:FORCE,ANGLE_DEG", value_parser = position_load, num_args = 1..)]
    load_at: Vec<PositionLoad>,
    /// Nodes of the mesh; the key nodes alone if not given
    #[arg(long, value_name = "N")]
    mesh_nodes: Option<usize>,
}

impl Loads {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.load.is_empty() && self.load_at.is_empty()
    }

    /// The mesh.
    pub fn mesh(&self, finger: &Finger) -> Result<Mesh, Failure> {
        Ok(match self.mesh_nodes {
            None => Mesh::key_nodes(finger),
            Some(nodes) => Mesh::with_nodes(finger, nodes)?,
        })
    }

    /// The equilibrium under the loads, to the last digit, and the loads on the mesh.
    pub fn equilibrium(&self, mesh: &Mesh, kinematics: Kinematics) -> Result<(FrameMotion, Vec<FrameLoad>), Failure> {
        let finger = mesh.finger();
        let node_loads =
            self.load.iter().map(|l| Load::Node { node: l.node, force: l.force, moment_nmm: l.moment_nmm });
        let position_loads =
            self.load_at.iter().map(|l| Load::at_position(l.s_mm, finger.direction(l.angle_deg) * l.force_n));
        let loads = node_loads.chain(position_loads).map(|load| mesh.frame_load(&load));
        let loads = loads.collect::<Result<Vec<_>, _>>().map_err(StaticsError::from)?;
        let motion = Statics::ladder(mesh, kinematics).accurate_equilibrium(&loads)?.motion;
        Ok((motion, loads))
    }
}
