//! The command `finray sweep`.

use super::grid::{self, GridArguments};
use crate::commands::prelude::*;
use finray_studies::sampling::sweep::Table;

/// Help text below the options.
const AFTER_HELP: &str = "\
Examples:
  finray sweep fixtures/scenes/paper.toml --truth linear,twin --force-n 0.5,1,2,3 --out sweep.csv
  finray sweep mine.toml --estimator nonlinear --shard 2/7 --out 2.csv

Guide: finray guide maps-and-sweeps";

/// Compute one table of maps for several true fingers, estimators, forces and noise levels.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    #[command(flatten)]
    grid: GridArguments,
    /// Models of the true finger, comma-separated
    #[arg(long, value_parser = listed(TruthId::ALL, TruthId::name), value_delimiter = ',', default_values_t = [TruthId::Corotational])]
    truth: Vec<TruthId>,
    /// Estimators, comma-separated
    #[arg(long, value_parser = listed(EstimatorId::ALL, EstimatorId::name), value_delimiter = ',', default_values_t = [EstimatorId::Nonlinear])]
    estimator: Vec<EstimatorId>,
    /// Standard deviations of the noise in one coordinate, mm, for instance 0,0.067 [default: the scene's value, or 0]
    #[arg(long, value_name = "S", value_delimiter = ',', value_parser = not_negative)]
    noise_mm: Vec<f64>,
}

pub fn run(arguments: &Arguments) -> Result<String, Failure> {
    let (truths, estimators) = (distinct(&arguments.truth), distinct(&arguments.estimator));
    grid::run(&arguments.grid, Table::Sweep, &truths, &estimators, &arguments.noise_mm)
}

/// The distinct items of a list, in order of first occurrence.
fn distinct<T: Copy + PartialEq>(list: &[T]) -> Vec<T> {
    let first = |(i, item): (usize, &T)| (!list[..i].contains(item)).then_some(*item);
    list.iter().enumerate().filter_map(first).collect()
}
