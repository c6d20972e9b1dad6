//! `finray map`

use super::grid::{Candidates, GridArguments, run as run_grid};
use crate::commands::prelude::*;
use finray_studies::sampling::sweep::Table;

/// Map where sensing can be trusted: error of the sensed force by position and direction.
///
/// A force of known position and direction is put on the true finger, its size is sensed from the
/// displacements of the key nodes, and the error |sensed / true - 1| is averaged over the camera
/// noise. Writes s_mm,angle_deg,force_n,mean_error,bias,spread,samples,answered,warned,covered,
/// covered_warned, and the figure beside it as SVG (of several forces, the worst). A cell is empty
/// where the finger has no equilibrium (then no sample is drawn), and where the estimator refuses
/// more than half of the noise samples: such a cell is not trusted. The errors are those of the
/// answered samples; `finray sweep` says why the others are refused. Of the answered samples, warned
/// came with a warning, covered have the true force within 1.96 sigma_n, covered_warned both.
///
/// The nonlinear estimator takes about a millisecond a noise sample: minutes for a map. The networks
/// that ship answer at the contact nodes along the normal: --places 12 --step-deg 90.
///
/// The same command resumes a run that was stopped: its rows are in FILE.partial. --shard 2/7
/// computes the second of seven shares; `finray merge` joins them.
///
/// Examples:
///   finray map fixtures/scenes/paper.toml --noise-mm 0.067 --out map.csv      (and map.svg)
///   finray map fixtures/scenes/paper.toml --force-n 1,2,3 --estimator nonlinear --out map.csv
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    grid: GridArguments,
    /// The true finger
    #[arg(long, value_parser = listed::<TruthId>(), default_value_t = TruthId::Corotational)]
    truth: TruthId,
    /// The estimator
    #[arg(long, value_parser = listed::<EstimatorId>(), default_value_t = EstimatorId::LeastSquares)]
    estimator: EstimatorId,
    /// Standard deviation of one measured coordinate, mm; the scene's camera table if not given, else none
    #[arg(long, value_name = "S", value_parser = not_negative)]
    noise_mm: Option<f64>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let candidates = Candidates {
        truths: &[arguments.truth],
        estimators: &[arguments.estimator],
        noise_mm: arguments.noise_mm.as_slice(),
    };
    run_grid(&arguments.grid, Table::Map, &candidates)
}
