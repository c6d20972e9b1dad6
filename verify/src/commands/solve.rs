//! `finray solve`

use super::loads::Loads;
use crate::commands::prelude::*;
use clap::ValueEnum;
use finray_files::displacements;
use finray_model::Kinematics;

/// Deform a finger under loads: displacements of its key nodes.
///
/// Writes node,x_mm,y_mm,ux_mm,uy_mm,theta_rad, a row a key node: undeformed position, displacement
/// and rotation. Of ribs on brackets hinge_x_mm,hinge_y_mm,hinge_ux_mm,hinge_uy_mm follow: the same of
/// the joint that is held off the plate. Loads keep their direction while the finger bends; several on
/// one node add up.
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
    #[command(flatten)]
    loads: Loads,
    /// How displacements become deformations
    #[arg(long, value_enum, default_value_t = KinematicsArgument::Corotational)]
    kinematics: KinematicsArgument,
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
    hints::of_moduli(&arguments.scene, &scene.finger);
    if arguments.loads.is_empty() {
        return Err(bad_input("expected at least one --load NODE:FX,FY or --load-at S_MM:FORCE,ANGLE_DEG"));
    }
    let kinematics = arguments.kinematics.into();
    let mesh = arguments.loads.mesh(&scene.finger)?;
    let (motion, loads) = arguments.loads.equilibrium(&mesh, kinematics)?;
    write_text(&arguments.out, &displacements::to_csv(&mesh.shape(&motion), mesh.finger())?)?;
    validity::warn_of_equilibrium(&scene.strain_limits, &mesh, &motion, kinematics, &loads);
    Ok(())
}
