//! The command `finray solve`.

use super::loads::Loads;
use super::parse::kinematics;
use crate::commands::prelude::*;
use finray_files::displacements;
use finray_model::Kinematics;
use finray_model::checked_shape::CheckedShape;
use finray_model::scene::SceneWarning;

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
    #[arg(long, value_parser = kinematics(["linear", "corotational", "corotational-chord"]), default_value = "corotational")]
    kinematics: Kinematics,
    /// Result file; - for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let (scene, _) = scene_or_papers(arguments.scene.as_deref(), SceneWarning::is_of_sensing)?;
    if arguments.loads.is_empty() {
        return Err(bad_input("expected at least one --load NODE:FX,FY or --load-at S_MM:FORCE,ANGLE_DEG"));
    }
    let checked = arguments.loads.checked_shape(&scene, arguments.kinematics)?;
    let CheckedShape { shape, .. } = &checked;
    write_file(&arguments.out, &displacements::to_csv(shape, &scene.finger)?)?;
    checked.warnings().for_each(|warning| print_message(format_args!("warning: {warning}")));
    let (nodes, largest_mm) = (scene.finger.key_node_count(), shape.largest_displacement_mm());
    Ok(summary(format!("{} displaced by up to {largest_mm:.3} mm", count(nodes, "node")), [&arguments.out]))
}
