//! The command `finray train`.

use super::contacts::Contacts;
use crate::commands::prelude::*;
use finray_model::scene::SceneWarning;
use finray_model::sensing::network::{Network, Scaling, TestError};
use finray_model::sensing::{Contact, ContactQuestion};
use finray_model::sensor::SensorContacts;
use finray_studies::settings::CAMERA_NOISE_MM;
use finray_train::{TrainingRecipe, train};

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray train fixtures/scenes/paper.toml --contact 15 21 --out 15-21.safetensors
  finray train mine.toml --contact-at 80@-10 --noise-mm 0.1 --out mine.safetensors
  finray train mine.toml --contact 16 18 20 22 --any-of --out mine.safetensors

Guide: finray guide networks";

/// Train a neural network that senses the forces at given contacts of a finger.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Scene file (TOML); - for standard input
    scene: PathBuf,
    #[command(flatten, next_help_heading = "Contacts")]
    contacts: Contacts,
    /// Train one network for all subsets of the contacts; `sense --contact` names the subset
    #[arg(long, help_heading = "Contacts", conflicts_with = "plain")]
    any_of: bool,
    /// True finger: corotational or linear
    #[arg(long, help_heading = "Cases", value_name = "TRUTH", default_value_t = TruthId::Corotational, value_parser = own_beams)]
    truth: TruthId,
    /// Number of training cases [default: 20000; 100000 with --any-of]
    #[arg(long, help_heading = "Cases", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    samples: Option<u32>,
    /// Standard deviation of the noise in one coordinate, mm [default: the scene's value, or 0.067]
    #[arg(long, help_heading = "Cases", value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
    /// Largest force per contact, N
    #[arg(long, help_heading = "Cases", value_name = "F", default_value_t = 5.0, value_parser = positive)]
    largest_force_n: f64,
    /// Largest sum of all contact forces, N
    #[arg(long, help_heading = "Cases", value_name = "F", default_value_t = 10.0, value_parser = positive)]
    largest_sum_n: f64,
    /// Standard deviation of each force's direction, deg
    #[arg(long, help_heading = "Cases", value_name = "DEG", default_value_t = 0.0, value_parser = not_negative)]
    direction_spread_deg: f64,
    /// Relative standard deviation of the finger's modulus
    #[arg(long, help_heading = "Cases", value_name = "S", default_value_t = 0.0, value_parser = not_negative)]
    modulus_spread: f64,
    /// Nodes whose displacements the network does not use
    #[arg(long, help_heading = "Cases", value_name = "NODE", num_args = 1..)]
    hide: Vec<usize>,
    /// Widths of the hidden layers [default: 32,32; 128,128 with --any-of]
    #[arg(long, help_heading = "Network", value_name = "WIDTHS", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=4096))]
    hidden_layers: Vec<u16>,
    /// Use displacements as inputs, and no linear branch, as in the paper
    #[arg(long, help_heading = "Network")]
    plain: bool,
    /// Largest number of epochs [default: 100; 60 with --any-of or --plain]
    #[arg(long, help_heading = "Network", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    epochs: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, help_heading = "Cases", value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Network file (safetensors); - for standard output
    #[arg(long, help_heading = "Output", value_name = "FILE")]
    out: PathBuf,
}

/// Parses the name of a true finger that is computed with the scene's beams. Training cases can be drawn only for true fingers that are computed with
/// the scene's beams.
fn own_beams(name: &str) -> Result<TruthId, String> {
    let own = || TruthId::ALL.iter().filter(|id| id.kinematics().is_some());
    let names: Vec<&str> = own().map(|id| id.name()).collect();
    own().find(|id| id.name() == name).copied().ok_or_else(|| format!("expected one of {}", names.join(", ")))
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    require_writable(&arguments.out)?;
    let scene = load_scene(&arguments.scene)?;
    hints::of_scene_without(&arguments.scene, &scene, SceneWarning::is_of_sensing);
    let finger = &scene.finger;
    let contacts: Option<Vec<Contact>> = match arguments.contacts.of(&scene, 0.0, None)? {
        SensorContacts::Asked(questions) => questions.iter().map(ContactQuestion::known).collect(),
        SensorContacts::Measured { .. } => None,
    };
    let contacts = contacts.ok_or_else(|| {
        bad_input(
            "a network needs contacts with known positions and directions, not `auto`, `normal`, `friction`, `object`, \
            `measured` or a standard deviation after +-",
        )
    })?;
    if let Some(node) = arguments.hide.iter().find(|&&node| finger.marked_nodes().all(|free| free.0 != node)) {
        let [first, last] = [2, finger.key_node_count() - 1];
        return Err(bad_input(format!("--hide: expected nodes that move, {first} to {last}, found {node}")));
    }
    let noise_mm = arguments.noise_mm.or(scene.noise_mm).unwrap_or(CAMERA_NOISE_MM);
    let recipe = recipe(arguments, contacts, noise_mm);
    let bar = progress_bar(recipe.epochs as u64, "drawing cases");
    bar.tick();
    let network = train(finger, &recipe, &mut |epoch| {
        bar.set_position(epoch.number as u64);
        bar.set_message(format!("loss {:.3e}, unseen {:.3e}", epoch.training_loss, epoch.validation_loss));
    })?;
    bar.finish_and_clear();
    write_file(&arguments.out, &network.to_bytes()?)?;
    print_message(tested(&network).trim_end());
    Ok(summary("network trained", [&arguments.out]))
}

/// The training recipe that the arguments describe.
fn recipe(arguments: &Arguments, contacts: Vec<Contact>, noise_mm: f64) -> TrainingRecipe {
    let mut recipe = match (arguments.any_of, arguments.plain) {
        (true, _) => TrainingRecipe::any_of(contacts, noise_mm),
        (false, false) => TrainingRecipe::nonlinear(contacts, noise_mm),
        (false, true) => TrainingRecipe {
            scaling: Scaling::Largest,
            linear_branch: false,
            epochs: TrainingRecipe::paper(Vec::new()).epochs,
            ..TrainingRecipe::nonlinear(contacts, noise_mm)
        },
    };
    let samples = &mut recipe.samples;
    if let Some(kinematics) = arguments.truth.kinematics() {
        samples.kinematics = kinematics;
    }
    samples.largest_force_n = arguments.largest_force_n;
    samples.largest_sum_n = arguments.largest_sum_n;
    samples.direction_spread_deg = arguments.direction_spread_deg;
    samples.modulus_spread = arguments.modulus_spread;
    samples.hidden = arguments.hide.iter().map(|&node| NodeId(node)).collect();
    recipe.count = arguments.samples.map_or(recipe.count, |count| count as usize);
    recipe.epochs = arguments.epochs.map_or(recipe.epochs, |epochs| epochs as usize);
    if !arguments.hidden_layers.is_empty() {
        recipe.hidden_layers = arguments.hidden_layers.iter().map(|&width| width.into()).collect();
    }
    recipe.seed = arguments.seed;
    recipe
}

/// Describes the network's errors on its test cases.
fn tested(network: &Network) -> String {
    let card = &network.card;
    let line = |(contact, error): (&Contact, &TestError)| {
        format!(
            "contact {contact}: {:.4} N root mean square error with {} mm of noise, {:.4} N without noise\n",
            error.rms_n, card.noise_mm, error.clean_rms_n
        )
    };
    let lines: String = card.contacts.iter().zip(&card.test_errors).map(line).collect();
    let (cases, epochs) = (card.test_samples, card.origin.epochs);
    format!("{lines}(forces up to {} N, {cases} test cases; weights of epoch {epochs})\n", card.origin.force_range_n[1])
}
