//! The command `finray solve`.

use super::loads::Loads;
use crate::commands::prelude::*;
use clap::ValueEnum;
use finray_files::displacements;
use finray_model::Kinematics;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray solve fixtures/scenes/paper.toml --load 19:-0.38,-1.96
  finray solve fixtures/scenes/paper.toml --load-at 80:2,-20 --mesh-nodes 684 --out shape.csv
  finray solve fixtures/scenes/paper.toml --load-at 80:0.1,0 --kinematics linear

Guide: finray guide your-finger";

/// Compute displacements and rotations of a finger's key nodes under loads.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input [default: the paper's finger]
    scene: Option<PathBuf>,
    #[command(flatten)]
    loads: Loads,
    /// Kinematics of the finger
    #[arg(long, value_enum, default_value_t = KinematicsArgument::Corotational)]
    kinematics: KinematicsArgument,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

#[derive(Clone, Copy, ValueEnum)]
enum KinematicsArgument {
    // Linear kinematics, for small displacements.
    Linear,
    // Co-rotational kinematics with the axial strain of a shallow arch.
    Corotational,
    // Co-rotational kinematics with the axial strain of the chord, as in OpenSees.
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

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let (scene, _) = scene_or_papers(arguments.scene.as_deref())?;
    if arguments.loads.is_empty() {
        return Err(bad_input("expected at least one --load NODE:FX,FY or --load-at S_MM:FORCE,ANGLE_DEG"));
    }
    let kinematics = arguments.kinematics.into();
    let mesh = arguments.loads.mesh(&scene.finger)?;
    let (motion, loads) = arguments.loads.equilibrium(&mesh, kinematics)?;
    let shape = mesh.shape(&motion);
    write_text(&arguments.out, &displacements::to_csv(&shape, mesh.finger())?)?;
    validity::warn_of_equilibrium(&scene.strain_limits, &mesh, &motion, kinematics, &loads);
    let (nodes, largest_mm) = (mesh.finger().key_node_count(), shape.largest_displacement_mm());
    Ok(Done::new(format!("{} displaced by up to {largest_mm:.3} mm", count(nodes, "node"))).with_file(&arguments.out))
}
