//! Comparison of ways to train a network: errors of three recipes, and errors against the number of training cases and the network size.
//!
//! Training takes minutes, so the report shows recorded errors: `fixtures/networks/recipes.csv` and `curves.csv`.

use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::sensing::Contact;
use finray_model::sensing::network::{Network, Scaling};
use finray_model::sensor::SensorOptions;
use finray_model::{Finger, Kinematics, Mesh, NodeId, Scene};
use finray_studies::experiments::ExperimentError;
use finray_studies::experiments::networks::records::{CurveRow, RecipeRow};
use finray_studies::experiments::table_two::{COMPARED_SETS, FORCES_N, contact_sets};
use finray_studies::sampling::scatter::{ScatterRequest, ScatterRow, scatter};
use finray_studies::settings::CAMERA_NOISE_MM;
use finray_studies::truths::{TruthId, fine_mesh};
use finray_train::{TrainingRecipe, train};
use rayon::prelude::*;

/// Number of random test cases for each set of contacts. With 4000 cases, the standard error of a mean error is about 2 % of the mean.
const CASES: usize = 4000;
/// Seed of forces and noise in the test cases, the same as for Table II.
const SEED: u64 = 1;
/// Names of the recipes, each with its number of training seeds. The errors of the first two recipes depend most on the seed.
const RECIPES: [(&str, u64); 4] = [("a", 4), ("a, by spread", 4), ("b", 3), ("c", 3)];
/// Recipes that follow the paper.
const PAPER_RECIPES: [&str; 2] = ["a", "a, by spread"];
/// Contact nodes of the curves: the node next to the base, where noise causes the largest errors, and a pair of neighbours.
const CURVE_SETS: [&[usize]; 2] = [&[24], &[19, 20]];
/// Numbers of training cases in the curve of error against number of cases; the networks of this curve have the hidden layers of the shipped
/// networks.
const SAMPLES: [usize; 7] = [30, 100, 300, 1000, 3000, 10_000, 30_000];
const SAMPLES_SEEDS: u64 = 3;
/// Total number of cases that each training of the curve of error against number of cases processes, repetitions included. `MOST_EPOCHS` limits the
/// number of repetitions if there are few cases.
const SEEN: usize = 2_000_000;
const MOST_EPOCHS: usize = 7000;
/// Widths of the hidden layers of the networks in the curve of error against network size. A network without hidden layers is a linear regression.
const SIZES: [&[usize]; 8] = [&[], &[4], &[8], &[16], &[16, 16], &[32, 32], &[64, 64], &[150, 200, 150]];
const SIZES_SEEDS: u64 = 2;

/// A network to train, with the name of its recipe or curve.
struct Job {
    name: &'static str,
    seed: u64,
    nodes: Vec<usize>,
    recipe: TrainingRecipe,
}

/// Number of networks that [`recipes`] trains. It reports progress after each.
pub fn recipe_count() -> usize {
    recipe_jobs().len()
}

/// Number of networks that [`curves`] trains. It reports progress after each.
pub fn curve_count() -> usize {
    curve_jobs().len()
}

/// Errors of the recipes on the linear and on the co-rotational finger, without and with noise. The paper's recipes are tested at every set of
/// contacts of its Table II, the other recipes at one set of each group. Like the paper's network, these networks accept forces of any size.
///
/// # Errors
/// [`ExperimentError`] if a training fails, a mesh cannot be built, or a network does not support its contacts.
pub fn recipes(finger: &Finger, progress: &(dyn Fn() + Sync)) -> Result<Vec<RecipeRow>, ExperimentError> {
    let jobs = recipe_jobs();
    let mut groups: Vec<Group> = Vec::new();
    for (job, network) in jobs.iter().zip(train_all(finger, &jobs, progress)?) {
        match groups.iter_mut().find(|group| group.recipe == job.name && group.seed == job.seed) {
            Some(group) => group.networks.push(network),
            None => groups.push(Group { recipe: job.name, seed: job.seed, networks: vec![network] }),
        }
    }
    let (papers, others): (Vec<Group>, Vec<Group>) =
        groups.into_iter().partition(|group| PAPER_RECIPES.contains(&group.recipe));
    Ok([rows_of(finger, papers)?, rows_of(finger, others)?].concat())
}

/// The networks of one recipe and seed, one for each set of contacts.
struct Group {
    recipe: &'static str,
    seed: u64,
    networks: Vec<Network>,
}

/// Errors of groups whose networks are trained for the same sets of contacts.
fn rows_of(finger: &Finger, groups: Vec<Group>) -> Result<Vec<RecipeRow>, ExperimentError> {
    let sets = groups.first().map_or(Vec::new(), |group| sets_of(group.recipe));
    let sets: Vec<Vec<usize>> = sets.into_iter().map(<[usize]>::to_vec).collect();
    let sensors: Vec<SensorOptions> = groups.iter().map(|group| unlimited(&group.networks)).collect();
    let (coarse, fine) = (Mesh::key_nodes(finger), fine_mesh(finger)?);
    let mut rows = Vec::new();
    for (truth, mesh, kinematics) in
        [(TruthId::Linear, &coarse, Kinematics::Linear), (TruthId::Corotational, &fine, Kinematics::Corotational)]
    {
        // Rows are ordered by set, noise level, then group.
        let rows_of_groups = errors(mesh, kinematics, &[0.0, CAMERA_NOISE_MM], &sensors, &sets)?;
        for (row, group) in rows_of_groups.into_iter().zip(groups.iter().cycle()) {
            let entry = |quantity: &str, mean_error| RecipeRow {
                recipe: group.recipe.to_owned(),
                seed: group.seed,
                truth,
                noise_mm: row.noise_mm,
                nodes: listed(&row.nodes),
                quantity: quantity.to_owned(),
                cases: row.cases,
                refused: row.refused,
                mean_error,
            };
            rows.push(entry("each force", row.mean_error()));
            if row.nodes.len() > 1 {
                rows.push(entry("sum", row.sum.map(|sum| sum.mean_error)));
            }
        }
    }
    Ok(rows)
}

/// Error against the number of training cases and against the size of the network, on the co-rotational finger with noise.
///
/// # Errors
/// [`ExperimentError`] if a training fails, a mesh cannot be built, or a network does not support its contacts.
pub fn curves(finger: &Finger, progress: &(dyn Fn() + Sync)) -> Result<Vec<CurveRow>, ExperimentError> {
    let jobs = curve_jobs();
    let trained = train_all(finger, &jobs, progress)?;
    let fine = fine_mesh(finger)?;
    let mut rows = Vec::new();
    for set in CURVE_SETS {
        let of_set: Vec<(&Job, &Network)> = jobs.iter().zip(&trained).filter(|(j, _)| j.nodes == set).collect();
        let sensors: Vec<_> = of_set.iter().map(|&(_, network)| unlimited(std::slice::from_ref(network))).collect();
        let errors = errors(&fine, Kinematics::Corotational, &[CAMERA_NOISE_MM], &sensors, &[set.to_vec()])?;
        // With one set and one noise level, there is one row per estimator, in the order of the estimators.
        rows.extend(of_set.iter().zip(&errors).map(|(&(job, network), row)| CurveRow {
            curve: job.name.to_owned(),
            nodes: listed(&job.nodes),
            samples: job.recipe.count,
            hidden_layers: match job.recipe.hidden_layers[..] {
                [] => "none".to_owned(),
                ref widths => joined(widths, "-"),
            },
            weights: weight_count(network),
            seed: job.seed,
            cases: row.cases,
            mean_error: row.mean_error(),
            mean_error_bound: row.mean_error_bound(),
        }));
    }
    Ok(rows)
}

/// Sets of contacts at which a recipe is trained and tested. The sets shared by all recipes come first, so all recipes are tested with the same cases
/// at these sets.
fn sets_of(recipe: &str) -> Vec<&'static [usize]> {
    let compared = COMPARED_SETS.map(|set| set.nodes);
    let further = contact_sets().into_iter().filter(|set| PAPER_RECIPES.contains(&recipe) && !compared.contains(set));
    compared.into_iter().chain(further).collect()
}

fn recipe_jobs() -> Vec<Job> {
    let of_recipe = |(name, seeds): (&'static str, u64)| {
        (1..=seeds).flat_map(move |seed| sets_of(name).into_iter().map(move |set| (seed, set))).map(
            move |(seed, nodes)| {
                let contacts = contacts(nodes);
                let recipe = match name {
                    "a" => TrainingRecipe::paper(contacts),
                    "a, by spread" => TrainingRecipe { scaling: Scaling::Spread, ..TrainingRecipe::paper(contacts) },
                    "b" => TrainingRecipe::paper_with_noise(contacts, CAMERA_NOISE_MM),
                    _ => TrainingRecipe::nonlinear(contacts, CAMERA_NOISE_MM),
                };
                Job { name, seed, nodes: nodes.to_vec(), recipe: TrainingRecipe { seed, ..recipe } }
            },
        )
    };
    RECIPES.into_iter().flat_map(of_recipe).collect()
}

fn curve_jobs() -> Vec<Job> {
    let job = |name: &'static str, seed: u64, nodes: &[usize], change: &dyn Fn(&mut TrainingRecipe)| {
        let mut recipe = TrainingRecipe { seed, ..TrainingRecipe::nonlinear(contacts(nodes), CAMERA_NOISE_MM) };
        change(&mut recipe);
        Job { name, seed, nodes: nodes.to_vec(), recipe }
    };
    let mut jobs = Vec::new();
    for nodes in CURVE_SETS {
        for (count, seed) in SAMPLES.iter().flat_map(|&count| (1..=SAMPLES_SEEDS).map(move |seed| (count, seed))) {
            let all_steps = |recipe: &mut TrainingRecipe| {
                recipe.count = count;
                recipe.epochs = (SEEN / count).min(MOST_EPOCHS);
                recipe.patience = recipe.epochs.div_ceil(5);
            };
            jobs.push(job("samples", seed, nodes, &all_steps));
        }
        for (widths, seed) in SIZES.iter().flat_map(|&widths| (1..=SIZES_SEEDS).map(move |seed| (widths, seed))) {
            jobs.push(job("size", seed, nodes, &|recipe| recipe.hidden_layers = widths.to_vec()));
        }
    }
    jobs
}

/// Trains the networks of all jobs, in parallel. Returns the networks in the order of the jobs.
fn train_all(finger: &Finger, jobs: &[Job], progress: &(dyn Fn() + Sync)) -> Result<Vec<Network>, ExperimentError> {
    let train_one = |job: &Job| {
        let network = train(finger, &job.recipe, &mut |_| {})?;
        progress();
        Ok(network)
    };
    jobs.par_iter().map(train_one).collect()
}

/// A sensor with networks that, like the paper's network, accept forces and inputs of any size.
fn unlimited(networks: &[Network]) -> SensorOptions {
    let mut networks = networks.to_vec();
    for network in &mut networks {
        network.inputs.largest.fill(f64::INFINITY);
        network.card.origin.force_range_n = [f64::NEG_INFINITY, f64::INFINITY];
    }
    SensorOptions { networks: Networks::of(networks), ..SensorOptions::of(EstimatorId::Network) }
}

fn errors(
    truth: &Mesh,
    kinematics: Kinematics,
    noise_levels_mm: &[f64],
    sensors: &[SensorOptions],
    sets: &[Vec<usize>],
) -> Result<Vec<ScatterRow>, ExperimentError> {
    let key_nodes = Mesh::key_nodes(truth.finger());
    let scene = Scene::of_finger(truth.finger().clone()).into();
    let request = ScatterRequest {
        truth,
        kinematics,
        model: &key_nodes,
        scene: &scene,
        noise_levels_mm,
        cases: CASES,
        seed: SEED,
    };
    let sets: Vec<Vec<NodeId>> = sets.iter().map(|set| set.iter().copied().map(NodeId).collect()).collect();
    Ok(scatter(&request, sensors, &sets, FORCES_N, &|| ())?)
}

/// Number of trained parameters. Without hidden layers, the parameters of the linear branch are not counted, because branch and last layer are the
/// same linear map.
fn weight_count(network: &Network) -> usize {
    let layers: usize = network.layers.iter().map(|layer| layer.weights.len() + layer.bias.len()).sum();
    if network.layers.len() == 1 { layers } else { layers + network.skip.len() }
}

fn contacts(nodes: &[usize]) -> Vec<Contact> {
    nodes.iter().copied().map(NodeId).map(Contact::at_node).collect()
}

fn listed(nodes: &[usize]) -> String {
    joined(nodes, " ")
}

fn joined(numbers: &[usize], by: &str) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(by)
}
