//! The protocol of Table II on simulated fingers: forces of 0.3 to 3 N on one node, on two neighbours and on two distant nodes.

use super::networks::{PAPER_RECIPES, SAME_FACTOR, figures, of_recipe, quantities};
use super::{ends, joined, percent};
use finray_model::estimators::EstimatorId;
use finray_model::estimators::network::Networks;
use finray_model::measurement::Measurement;
use finray_model::sensing::LinearEstimator;
use finray_model::sensor::{PreparedScene, SensorOptions};
use finray_model::{Kinematics, Mesh, NodeId, Scene};
use finray_studies::experiments::networks::records::Records;
use finray_studies::experiments::table_two::{CONTACT_GROUPS, ContactGroup, FORCES_N, contact_sets};
use finray_studies::sampling::scatter::{ScatterRequest, ScatterRow, scatter};
use finray_studies::settings::ENOUGH_CASES;
use finray_studies::truths::{TruthId, fine_mesh};
use finray_tests::{CAMERA_NOISE_MM, assert_recorded, assert_said, at_nodes, case_count, is_full_study, paper};
use serde::{Deserialize, Serialize};

/// Cases of each set in a short run, and the relative tolerance of a mean error over so many cases: three standard errors.
const CASES: usize = 100;
const CHANCE: f64 = 0.33;
/// Tolerance for linear sensing of the linear finger without noise: rounding errors times the condition number for neighbouring contacts.
const ROUNDING: f64 = 1e-8;
/// Tolerance for nonlinear sensing without noise: the error at which refinement of the mesh ends.
const MESH_ERROR: f64 = 0.002;
/// Largest number of cases per set for the nonlinear estimator, which takes as long as all others together; on the linear finger, whose shapes no
/// co-rotational finger fits, its search tries every starting point and takes a hundred times as long.
const MOST_FITS: [usize; 2] = [20, 500];
const NOISES_MM: [f64; 2] = [0.0, CAMERA_NOISE_MM];

/// Rows of every estimator, noise level and set of contacts on the linear and on the co-rotational finger.
pub fn sensed(cases: usize) -> [(TruthId, Vec<ScatterRow>); 2] {
    let finger = paper();
    let (key_nodes, fine) = (Mesh::key_nodes(&finger), fine_mesh(&finger).expect("684 nodes"));
    let scene = PreparedScene::from(Scene::of_finger(finger));
    let networks = Networks::read(&finray_fixtures::NETWORKS).expect("networks that ship");
    let sensor = |estimator| SensorOptions { networks: networks.clone(), ..SensorOptions::of(estimator) };
    let direct = [EstimatorId::LeastSquares, EstimatorId::Ridge, EstimatorId::Network].map(sensor);
    let searching = [EstimatorId::Nonlinear].map(sensor);
    let sets: Vec<Vec<NodeId>> =
        contact_sets().iter().map(|set| set.iter().map(|&node| NodeId(node)).collect()).collect();
    let run = |mesh, kinematics, cases, sensors: &[SensorOptions]| {
        // The Cramer-Rao bound depends little on the mesh, so the coarsest mesh suffices.
        let request = ScatterRequest {
            truth: mesh,
            kinematics,
            model: &key_nodes,
            scene: &scene,
            noise_levels_mm: &NOISES_MM,
            cases,
            seed: 1,
        };
        scatter(&request, sensors, &sets, FORCES_N, &|| ()).expect("the paper's contact nodes")
    };
    let of = |mesh, kinematics, fits| {
        let mut rows = run(mesh, kinematics, cases, &direct);
        rows.extend(run(mesh, kinematics, fits, &searching));
        rows
    };
    let linear = of(&key_nodes, Kinematics::Linear, cases.div_ceil(4).min(MOST_FITS[0]));
    let corotational = of(&fine, Kinematics::Corotational, cases.min(MOST_FITS[1]));
    [(TruthId::Linear, linear), (TruthId::Corotational, corotational)]
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    pub truth: String,
    pub noise_mm: f64,
    pub estimator: String,
    pub group: String,
    pub nodes: String,
    pub quantity: String,
    pub drawn: usize,
    pub answered: usize,
    pub refused: usize,
    pub paper_mean_error: Option<f64>,
    pub mean_error: Option<f64>,
    pub mean_error_n: Option<f64>,
    pub mean_error_bound: Option<f64>,
}

/// Rows of each set of contacts, then the means over the sets of each group, as in the paper's table.
fn of_finger(truth: TruthId, rows: &[ScatterRow]) -> Vec<Row> {
    let mut all = Vec::new();
    for row in rows {
        let group = CONTACT_GROUPS.into_iter().find(|group| group.sets.contains(&&row.nodes[..])).expect("a group");
        for (quantity, _) in quantities(&group) {
            let errors = match (quantity, row.sum) {
                ("sum", Some(sum)) => {
                    [Some(sum.mean_error), Some(sum.mean_error_n), sum.bound.map(|bound| bound.mean_error_bound)]
                }
                _ => [row.mean_error(), row.mean_error_n(), row.mean_error_bound()],
            };
            all.push(Row {
                truth: truth.name().to_owned(),
                noise_mm: row.noise_mm,
                estimator: row.estimator.name().to_owned(),
                group: group.name.to_owned(),
                nodes: joined(&row.nodes, " "),
                quantity: quantity.to_owned(),
                drawn: row.drawn(),
                answered: row.cases,
                refused: row.refused,
                paper_mean_error: None,
                mean_error: errors[0],
                mean_error_n: errors[1],
                mean_error_bound: errors[2],
            });
        }
    }
    let mut means: Vec<Row> = Vec::new();
    for row in &all {
        let same = |a: &Row, b: &Row| (&a.estimator, &a.group, &a.quantity) == (&b.estimator, &b.group, &b.quantity);
        if means.iter().any(|mean| same(mean, row) && mean.noise_mm == row.noise_mm) {
            continue;
        }
        let of_group: Vec<&Row> = all.iter().filter(|it| same(it, row) && it.noise_mm == row.noise_mm).collect();
        let mean = |figure: fn(&Row) -> Option<f64>| {
            let figures: Option<Vec<f64>> = of_group.iter().map(|row| figure(row)).collect();
            figures.map(|figures| figures.iter().sum::<f64>() / figures.len() as f64)
        };
        let group = CONTACT_GROUPS.into_iter().find(|group| group.name == row.group).expect("a group");
        means.push(Row {
            nodes: "mean".to_owned(),
            drawn: of_group.iter().map(|row| row.drawn).sum(),
            answered: of_group.iter().map(|row| row.answered).sum(),
            refused: of_group.iter().map(|row| row.refused).sum(),
            paper_mean_error: quantities(&group)
                .find(|(quantity, _)| *quantity == row.quantity)
                .map(|(_, paper)| paper),
            mean_error: mean(|row| row.mean_error),
            mean_error_n: mean(|row| row.mean_error_n),
            mean_error_bound: mean(|row| row.mean_error_bound),
            ..row.clone()
        });
    }
    all.extend(means);
    all
}

/// Rows of the paper's network, as recorded: means over seeds and sets of contacts.
fn of_papers_network(truth: TruthId, noise_mm: f64) -> Vec<Row> {
    let records = Records::shipped().expect("records").recipes;
    let mut rows = Vec::new();
    for (recipe, scaling) in PAPER_RECIPES.into_iter().zip(["largest", "spread"]) {
        for group in CONTACT_GROUPS {
            for (quantity, paper) in quantities(&group) {
                let Some(found) = of_recipe(&records, recipe, truth, noise_mm, &group, quantity) else { continue };
                rows.push(Row {
                    truth: truth.name().to_owned(),
                    noise_mm,
                    estimator: format!("network of the paper, displacements scaled by the {scaling}"),
                    group: group.name.to_owned(),
                    nodes: joined(group.sets.iter().map(|set| joined(*set, " ")), "; "),
                    quantity: quantity.to_owned(),
                    drawn: found.answered + found.refused,
                    answered: found.answered,
                    refused: found.refused,
                    paper_mean_error: Some(paper),
                    mean_error: Some(found.errors.mean),
                    mean_error_n: None,
                    mean_error_bound: None,
                });
            }
        }
    }
    rows
}

/// Mean over the sets of a group at the camera's noise.
pub fn of_group<'r>(
    rows: &'r [Row],
    truth: TruthId,
    estimator: EstimatorId,
    group: &ContactGroup,
    quantity: &str,
) -> &'r Row {
    let is = |row: &&Row| {
        (&*row.truth, &*row.estimator, &*row.nodes) == (truth.name(), estimator.name(), "mean")
            && (&*row.group, &*row.quantity, row.noise_mm) == (group.name, quantity, CAMERA_NOISE_MM)
    };
    rows.iter().find(is).expect("a mean of Table II")
}

/// Rows of Table II; all of them are recorded in a full study.
pub fn rows(cases: usize) -> Vec<Row> {
    let fingers = sensed(cases);
    let mut rows: Vec<Row> = fingers.iter().flat_map(|(truth, rows)| of_finger(*truth, rows)).collect();
    for truth in [TruthId::Linear, TruthId::Corotational] {
        rows.extend(NOISES_MM.into_iter().flat_map(|noise_mm| of_papers_network(truth, noise_mm)));
    }
    rows
}

/// In linear sensing of two neighbouring forces, linearisation causes large errors of each force but not of their sum; noise does not. The nonlinear
/// estimator reaches the bound. The figures agree with an independent study of this protocol up to sampling error, and with the record.
#[test]
fn table_two_blames_linearisation() {
    let sets: Vec<&[usize]> = vec![&[21], &[19], &[17], &[19, 20], &[16, 17], &[18, 20], &[16, 20]];
    assert_eq!(contact_sets(), sets, "the contact nodes of the paper's section V-C");
    let rows = rows(case_count(CASES, ENOUGH_CASES));
    let errors = |truth: TruthId, noise_mm: f64, estimator: EstimatorId, quantity: &str| -> Vec<f64> {
        let of = |row: &&Row| {
            (&*row.truth, &*row.estimator, row.noise_mm) == (truth.name(), estimator.name(), noise_mm)
                && row.quantity == quantity
                && sets.iter().any(|set| joined(*set, " ") == row.nodes)
        };
        rows.iter().filter(of).map(|row| row.mean_error.expect("sensed")).collect()
    };
    use EstimatorId::{LeastSquares, Network, Nonlinear};
    let (linear, bent) = (TruthId::Linear, TruthId::Corotational);
    for quantity in ["each force", "sum"] {
        assert!(errors(linear, 0.0, LeastSquares, quantity).iter().all(|error| *error < ROUNDING));
        assert!(errors(bent, 0.0, Nonlinear, quantity).iter().all(|error| *error < MESH_ERROR));
    }
    // The independent study has one set of each kind: node 19, nodes 19 and 20, nodes 18 and 20.
    for (truth, quantity, at, study) in [
        (linear, "each force", [1, 3, 5], [0.003, 0.025, 0.012]),
        (bent, "each force", [1, 3, 5], [0.015, 0.34, 0.15]),
        (bent, "sum", [0, 2, 2], [0.069, 0.072, 0.072]),
    ] {
        let found = errors(truth, CAMERA_NOISE_MM, LeastSquares, quantity);
        for (i, study) in at.into_iter().zip(study) {
            assert!((found[i] / study - 1.0).abs() < CHANCE, "{quantity}: {}, study {study}", found[i]);
        }
    }
    assert!(errors(bent, CAMERA_NOISE_MM, Nonlinear, "each force").iter().all(|error| *error < 0.03));
    assert_eq!(errors(bent, CAMERA_NOISE_MM, Network, "each force").len(), sets.len());
    let agree = |a: &Row, b: &Row| {
        let texts = |row: &Row| [&row.truth, &row.estimator, &row.group, &row.nodes, &row.quantity].map(String::clone);
        // Errors without noise are rounding, or the error of a mesh; other errors scatter with the cases.
        let near = |a: f64, b: f64| (a - b).abs() < MESH_ERROR || (a / b - 1.0).abs() < 1.5 * CHANCE;
        texts(a) == texts(b)
            && a.paper_mean_error == b.paper_mean_error
            && a.mean_error.zip(b.mean_error).is_none_or(|(a, b)| near(a, b))
    };
    if is_full_study() {
        said(&rows);
    }
    assert_recorded("table_two.csv", |_| true, rows, agree);
}

/// Condition number: largest over smallest singular value of the displacements of all markers under unit forces.
fn condition_number(nodes: &[usize]) -> f64 {
    let estimator =
        LinearEstimator::new(&paper(), &at_nodes(nodes), &Measurement::at_rest(&paper())).expect("contacts");
    let values = estimator.singular_values();
    values[0] / values[values.len() - 1]
}

/// Records the sentences on Table II.
fn said(rows: &[Row]) {
    use EstimatorId::{LeastSquares, Nonlinear};
    let found = PAPER_RECIPES.map(figures);
    let met = found.iter().zip(["largest", "spread"]).map(|(all, scaling)| {
        let hit = all.iter().filter(|figure| figure.reproduced()).count();
        format!("{hit} of {} figures with displacements scaled by the {scaling}", all.len())
    });
    let reproduces =
        if found.iter().flatten().all(|figure| figure.reproduced()) { "reproduces" } else { "does not reproduce" };
    let seeds = found.iter().flatten().map(|figure| figure.recorded.seeds).min().expect("figures");
    assert_said(
        "table-two",
        "says",
        format!(
            "In simulation, on the uniform finger with {CAMERA_NOISE_MM} mm noise, the network of the paper, in its recorded trainings, {reproduces} Table II: \
             within a factor of {SAME_FACTOR}, it meets {} (mean of {seeds} seeds).",
            joined(met, ", ")
        ),
    );
    let [_, near, apart] = &CONTACT_GROUPS;
    let bent = |estimator, group, quantity| of_group(rows, TruthId::Corotational, estimator, group, quantity);
    let error = |group, quantity| bent(LeastSquares, group, quantity).mean_error.expect("sensed");
    let nonlinear = bent(Nonlinear, near, "each force");
    assert_said(
        "table-two",
        "says",
        format!(
            "Least squares on the uniform finger errs by {} for each force at two neighbours, by {} for each force at two nodes apart, and by up to {} for a sum \
             (means over pairs). The nonlinear estimator errs by {} for neighbours ({} of {} cases refused).",
            percent(error(near, "each force")),
            percent(error(apart, "each force")),
            percent(error(near, "sum").max(error(apart, "sum"))),
            percent(nonlinear.mean_error.expect("sensed")),
            nonlinear.refused,
            nonlinear.drawn
        ),
    );
    let alone = of_group(rows, TruthId::Linear, LeastSquares, near, "each force").mean_error.expect("sensed");
    assert!(alone < 0.5 * error(near, "each force"));
    let conditions = |group: &ContactGroup| ends(group.sets.iter().map(|set| condition_number(set)));
    let ([least, most], [far_least, far_most]) = (conditions(near), conditions(apart));
    assert_said(
        "table-two",
        "text",
        format!(
            "Noise causes the smaller part of the errors: on the linear finger, which has no error of linearisation, the forces at neighbours err by {}. The rest is \
             the error of linearisation. It is amplified by up to the condition number of the contacts (neighbours: {least:.1} to {most:.1}; nodes apart: \
             {far_least:.1} to {far_most:.1}), because forces at neighbours bend the finger almost equally.",
            percent(alone)
        ),
    );
}
