//! The command `finray guide`.

use crate::commands::prelude::*;
use finray_fixtures::PAPER_SCENE;
use finray_model::keys;
use finray_verify::guide::GUIDES;

/// Name and task of the only generated guide, made from the table of scene keys.
const SCENE: (&str, &str) = ("scene", "Every table and key of a scene file: unit, range, default and meaning");

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray guide
  finray guide sense
  finray guide scene";

/// Print a guide, or the list of topics.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Topic of the guide [default: the list of topics]
    topic: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<Option<String>, Failure> {
    let topics = || GUIDES.iter().map(|guide| (guide.name, guide.task)).chain([SCENE]);
    let text = match arguments.topic.as_deref() {
        None => topics().map(|(name, task)| format!("{name:<20}{task}\n")).collect(),
        Some(name) if name == SCENE.0 => scene(),
        Some(name) => match GUIDES.iter().find(|guide| guide.name == name) {
            Some(guide) => guide.text.to_owned(),
            None => {
                let names: Vec<_> = topics().map(|(name, _)| name).collect();
                return Err(bad_input(format!("TOPIC: expected one of {}, found {name:?}", names.join(", "))));
            }
        },
    };
    write_file(Path::new("-"), &text)?;
    // No summary line follows a printed guide.
    Ok(None)
}

/// The reference of all scene keys, with the paper's finger as an example.
fn scene() -> String {
    format!(
        "# Scene files\n\
         A scene is a TOML file. Lengths are in mm, forces in N, moduli in MPa; key names contain the unit. Unknown\n\
         keys are refused. Tables marked optional may be left out.\n\n{}\n## Example\n{PAPER_SCENE}",
        keys::reference()
    )
}
