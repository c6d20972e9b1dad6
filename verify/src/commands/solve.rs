//! `finray solve`

use super::parse::{NodeLoad, PositionLoad, node_load, position_load};
use super::{Failure, validity};
use clap::ValueEnum;
use finray_model::statics::{Statics, StaticsError};
use finray_model::{Kinematics, Load, Mesh};
use finray_verify::files::{displacements, load_scene, write_text};
use std::path::PathBuf;

/// Deform a finger under loads: displacements of its key nodes.
///
/// Writes node,x_mm,y_mm,ux_mm,uy_mm,theta_rad, a row a key node: undeformed position, displacement
/// and rotation. Loads keep their direction while the finger bends; several on one node add up.
///
/// A warning on standard error says where the beam model does not hold: a strain above 5 % (or
/// largest_strain of the scene's material), shear that would add more than 5 % to the
/// displacement of the loads, a finger less deep than thick.
///
/// Examples:
///   finray solve fixtures/scenes/paper.toml --load 19:-0.38,-1.96
///   finray solve fixtures/scenes/paper.toml --load-at 80:2,-20 --mesh-nodes 684 --out shape.csv
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    /// Force in N (and moment in N mm) on a key node, finger frame
    #[arg(long, value_name = "NODE:FX,FY[,M]", value_parser = node_load, num_args = 1.., allow_hyphen_values = false)]
    load: Vec<NodeLoad>,
    /// Force in N at a position along the front plate (mm from its base), at an angle from the inward normal
    #[arg(long, value_name = "S_MM:FORCE,ANGLE_DEG", value_parser = position_load, num_args = 1..)]
    load_at: Vec<PositionLoad>,
    /// How displacements become deformations
    #[arg(long, value_enum, default_value_t = KinematicsArgument::Corotational)]
    kinematics: KinematicsArgument,
    /// Nodes of the mesh; the key nodes alone if not given
    #[arg(long, value_name = "N")]
    mesh_nodes: Option<usize>,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum KinematicsArgument {
    /// Small displacements
    Linear,
    /// Co-rotational, with the axial strain of a shallow arch
    Corotational,
    /// Co-rotational, with the plain strain of the chord (as in OpenSees)
    CorotationalChord,
}

impl From<KinematicsArgument> for Kinematics {
    fn from(argument: KinematicsArgument) -> Kinematics {
        match argument {
            KinematicsArgument::Linear => Kinematics::Linear,
            KinematicsArgument::Corotational => Kinematics::Corotational,
            KinematicsArgument::CorotationalChord => Kinematics::CorotationalChord,
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scene = load_scene(&arguments.scene)?;
    let finger = &scene.finger;
    let mesh = match arguments.mesh_nodes {
        None => Mesh::key_nodes(finger),
        Some(nodes) => Mesh::with_nodes(finger, nodes)?,
    };
    if arguments.load.is_empty() && arguments.load_at.is_empty() {
        return Err(Failure::BadInput(
            "expected at least one --load NODE:FX,FY or --load-at S_MM:FORCE,ANGLE_DEG".to_owned(),
        ));
    }
    let node_loads =
        arguments.load.iter().map(|l| Load::Node { node: l.node, force: l.force, moment_nmm: l.moment_nmm });
    let position_loads =
        arguments.load_at.iter().map(|l| Load::at_position(l.s_mm, finger.direction(l.angle_deg) * l.force_n));
    let kinematics = arguments.kinematics.into();
    let loads = node_loads.chain(position_loads).map(|load| mesh.frame_load(&load));
    let loads = loads.collect::<Result<Vec<_>, _>>().map_err(StaticsError::from)?;
    let motion = Statics::ladder(&mesh, kinematics).accurate_equilibrium(&loads)?.motion;
    write_text(&arguments.out, &displacements::to_csv(&mesh.shape(&motion))?)?;
    validity::warn_of_equilibrium(&scene.strain_limits, &mesh, &motion, kinematics, &loads);
    Ok(())
}
