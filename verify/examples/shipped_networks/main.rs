//! Trains the shipped networks again, and compares ways of training.
//!
//! `shipped` writes one safetensors file per network, and `shipped.csv` with the training settings of each network and its errors on test cases.
//! `recipes` writes `recipes.csv`, which compares the paper's training recipe with this project's recipes. `curves` writes `curves.csv`: the error
//! against the number of training cases and against the size of the network. Each part takes about ten minutes on two cores. A repeated run on the
//! same machine writes identical files. Command:
//!
//! `cargo run --release -p finray-verify --example shipped_networks -- shipped recipes curves --out fixtures/networks`

mod recipes;

use clap::{Parser, ValueEnum};
use finray_files::{csv_text, require_folder, write_folder};
use finray_model::sensing::Contact;
use finray_model::sensing::network::TestError;
use finray_model::{Finger, Scene};
use finray_studies::experiments::networks::shipping::{Shipping, shipping};
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;

type Failure = Box<dyn std::error::Error + Send + Sync>;
type Files = Vec<(PathBuf, Vec<u8>)>;

/// Train the shipped networks again, and compare ways of training.
#[derive(Parser)]
struct Arguments {
    /// Parts to compute
    #[arg(value_enum, required = true)]
    parts: Vec<Part>,
    /// Folder for the files
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Part {
    /// The shipped networks
    Shipped,
    /// Errors of the paper's training recipe and of this project's recipes
    Recipes,
    /// The error against the number of training cases and against the size of the network
    Curves,
}

/// Row of `shipped.csv`: one contact of one network.
#[derive(Serialize)]
struct Record {
    network: String,
    contact: String,
    samples: usize,
    hidden_layers: String,
    inputs: usize,
    seed: u64,
    epochs: usize,
    rms_n: f64,
    clean_rms_n: f64,
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    require_folder(&arguments.out)?;
    let finger = Scene::from_toml(finray_fixtures::PAPER_SCENE)?.finger;
    let mut files = Vec::new();
    if arguments.parts.contains(&Part::Shipped) {
        files.extend(shipped(&finger)?);
    }
    if arguments.parts.contains(&Part::Recipes) {
        let bar = ProgressBar::new(recipes::recipe_count() as u64);
        let rows = recipes::recipes(&finger, &|| bar.inc(1))?;
        files.push(("recipes.csv".into(), csv_text(rows)?.into_bytes()));
    }
    if arguments.parts.contains(&Part::Curves) {
        let bar = ProgressBar::new(recipes::curve_count() as u64);
        let rows = recipes::curves(&finger, &|| bar.inc(1))?;
        files.push(("curves.csv".into(), csv_text(rows)?.into_bytes()));
    }
    write_folder(&arguments.out, &files)?;
    Ok(())
}

fn shipped(finger: &Finger) -> Result<Files, Failure> {
    let networks = shipping(finger);
    let epochs = networks.iter().map(|shipping| shipping.recipe.epochs as u64).sum();
    let bar = ProgressBar::new(epochs);
    let trained: Result<Vec<_>, Failure> = networks.par_iter().map(|network| trained(finger, network, &bar)).collect();
    bar.finish_and_clear();
    let (mut files, mut records) = (Files::new(), Vec::new());
    for (name, bytes, of_network) in trained? {
        files.push((PathBuf::from(format!("{name}.safetensors")), bytes));
        records.extend(of_network);
    }
    files.push((PathBuf::from("shipped.csv"), csv_text(records)?.into_bytes()));
    Ok(files)
}

/// Trains a network. Returns the network's name, the content of its file, and its records, one per contact.
fn trained(
    finger: &Finger,
    Shipping { name, recipe }: &Shipping,
    bar: &ProgressBar,
) -> Result<(String, Vec<u8>, Vec<Record>), Failure> {
    let network = finray_train::train(finger, recipe, &mut |_| bar.inc(1))?;
    let widths: Vec<String> = recipe.hidden_layers.iter().map(ToString::to_string).collect();
    let record = |(contact, error): (&Contact, &TestError)| Record {
        network: name.clone(),
        contact: contact.to_string(),
        samples: recipe.count,
        hidden_layers: widths.join("-"),
        inputs: network.inputs.count(),
        seed: recipe.seed,
        epochs: network.card.origin.epochs,
        rms_n: error.rms_n,
        clean_rms_n: error.clean_rms_n,
    };
    let records = network.card.contacts.iter().zip(&network.card.test_errors).map(record).collect();
    Ok((name.clone(), network.to_bytes()?, records))
}
