//! `finray sense`: from displacements to contact forces with their uncertainty. The modules test the answers of `finray sense` (`answers`), the
//! measurements that it reads (`measurements`), contacts with known objects (`object`), and refusals (`refusals`).

mod answers;
mod measurements;
mod object;
mod refusals;

use crate::kit::*;

const HEADER: [&str; 5] = ["contact", "s_mm", "angle_deg", "force_n", "sigma_n"];
/// Three true forces: node, angle in degrees, force in N. One force pulls.
const TRUTH: [(usize, f64, f64); 3] = [(16, -20.0, 1.5), (20, 10.0, -0.4), (23, 35.0, 2.25)];
/// Tolerance of sensed forces. The condition number of the problem amplifies rounding errors.
const SENSED: f64 = 1e-9;
const LEAST_SQUARES: [&str; 2] = ["--estimator", "least-squares"];
const CONTACTS: [&str; 6] = ["--contact", "16@-20", "--contact", "20@10", "--contact", "23@35"];

/// Displacements of the linear finger under forces, in the format of `solve`.
fn linear_shape(forces: &[(usize, f64, f64)]) -> String {
    let forces: Vec<_> = forces.iter().map(|&(node, angle_deg, force_n)| (node, force_n, angle_deg)).collect();
    paper_shape(&forces, &["--kinematics", "linear"]).done()
}

/// Senses by least squares, unless the arguments name an estimator.
fn sense_text(displacements: &str, arguments: &[&str]) -> Answer {
    let estimator: &[&str] = if arguments.contains(&"--estimator") { &[] } else { &LEAST_SQUARES };
    let all = [&["sense", PAPER, "--displacements", "-"], estimator, arguments].concat();
    finray_reading(displacements.as_bytes(), &all)
}

fn sense(displacements: &str, arguments: &[&str]) -> Csv {
    Csv::of(&sense_text(displacements, arguments).done())
}
