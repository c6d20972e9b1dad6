//! The command `finray map`.

use super::grid::{self, GridArguments};
use crate::commands::prelude::*;
use finray_studies::sampling::sweep::Table;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray map mine.toml --knows auto@auto --noise-mm 0.067 --force-n 1,2 --out unknown.csv
  finray map fixtures/scenes/paper.toml --noise-mm 0.067 --out map.csv
  finray map fixtures/scenes/paper.toml --estimator network --places 12 --step-deg 90

Guide: finray guide maps-and-sweeps";

/// Map the error of the sensed force by contact position and force direction.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    #[command(flatten)]
    grid: GridArguments,
    /// Model of the true finger
    #[arg(long, value_parser = listed(TruthId::ALL, TruthId::name), default_value_t = TruthId::Corotational)]
    truth: TruthId,
    /// Estimator of the forces
    #[arg(long, value_parser = listed(EstimatorId::ALL, EstimatorId::name), default_value_t = EstimatorId::Nonlinear)]
    estimator: EstimatorId,
    /// Standard deviation of the noise in one coordinate, mm [default: the scene's value, or 0]
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let noise_mm = arguments.noise_mm.as_slice();
    let done = grid::run(&arguments.grid, Table::Map, &[arguments.truth], &[arguments.estimator], noise_mm)?;
    let is_exported = matches!(arguments.truth, TruthId::Mujoco | TruthId::Continuum);
    let knows_contact = arguments.estimator.searches() && !is_exported && arguments.grid.knows.is_none();
    // The note precedes the summary, which is the last line; `--quiet` omits both.
    Ok(match knows_contact {
        true => {
            format!("note: this map assumes that the contact is known; --knows auto@auto maps unknown contacts\n{done}")
        }
        false => done,
    })
}
