//! `finray guide`

use crate::commands::prelude::*;
use finray_fixtures::PAPER_SCENE;
use finray_model::keys;
use finray_verify::files::write_text;

/// Name of a topic, what it tells, and its text.
type Topic = (&'static str, &'static str, fn() -> String);

const TOPICS: [Topic; 1] = [("scene", "Every table and key of a scene file: unit, range, default and meaning", scene)];

/// Print a guide or a reference: without a topic the list of topics.
///
/// Examples:
///   finray guide
///   finray guide scene
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    /// The topic
    topic: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let text = match &arguments.topic {
        None => TOPICS.iter().map(|(name, says, _)| format!("{name}: {says}\n")).collect(),
        Some(topic) => match TOPICS.iter().find(|(name, ..)| name == topic) {
            Some((_, _, text)) => text(),
            None => {
                let names = TOPICS.map(|(name, ..)| name).join(", ");
                return Err(bad_input(format!("guide: expected one of {names}, found {topic:?}")));
            }
        },
    };
    Ok(write_text(Path::new("-"), &text)?)
}

/// The reference of scene files, with the paper's finger as an example.
fn scene() -> String {
    format!(
        "# Scene files\n\
         A scene is a TOML file. Lengths are in mm, forces in N, moduli in MPa; every key carries its unit. Unknown\n\
         keys are refused. Tables marked optional may be left out.\n\n{}\n## Example\n{PAPER_SCENE}",
        keys::reference()
    )
}
