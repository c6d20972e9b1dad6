//! `finray sweep`

use super::grid::{Candidates, GridArguments, run as run_grid};
use crate::commands::prelude::*;
use finray_studies::sampling::sweep::Table;

/// Map several true fingers, estimators and levels of noise, as `finray map`, in one table.
///
/// Writes truth,estimator,noise_mm,s_mm,angle_deg,force_n,samples,answered,mean_error,bias,spread,
/// sigma_n,refusal,warned,covered,covered_warned, a row for each combination: the errors of
/// sensed / true over the noise samples, the standard deviation that the estimator states (N), why
/// samples were refused, if any were, and as in `finray map` how many were warned of and covered.
/// Every cell sees the same noise. Rows go by truth, position, direction, estimator, noise and force.
///
/// Rows are written as they come, whatever their number. The same command resumes a run that was
/// stopped: its rows are in FILE.partial. --shard 2/7 computes the second of seven shares;
/// `finray merge` joins them.
///
/// Example:
///   finray sweep fixtures/scenes/paper.toml --truth linear,corotational --noise-mm 0,0.067
///       --estimator least-squares,ridge --force-n 0.5,1,2,3 --out sweep.csv
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    grid: GridArguments,
    /// The true fingers: one, or several with commas between them
    #[arg(long, value_parser = listed::<TruthId>(), value_delimiter = ',', default_values_t = [TruthId::Corotational])]
    truth: Vec<TruthId>,
    /// The estimators: one, or several with commas between them
    #[arg(long, value_parser = listed::<EstimatorId>(), value_delimiter = ',', default_values_t = [EstimatorId::LeastSquares])]
    estimator: Vec<EstimatorId>,
    /// Standard deviations of one measured coordinate, mm: one, or several as 0,0.067; the scene's camera table if none
    /// is given, else no noise
    #[arg(long, value_name = "S", value_delimiter = ',', value_parser = not_negative)]
    noise_mm: Vec<f64>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let candidates = Candidates {
        truths: &distinct(&arguments.truth),
        estimators: &distinct(&arguments.estimator),
        noise_mm: &arguments.noise_mm,
    };
    run_grid(&arguments.grid, Table::Sweep, &candidates)
}

/// Each once, in the order of their first mention.
fn distinct<T: Copy + PartialEq>(list: &[T]) -> Vec<T> {
    let first = |(i, item): (usize, &T)| (!list[..i].contains(item)).then_some(*item);
    list.iter().enumerate().filter_map(first).collect()
}
