//! Tests the report's comparisons of meshes, and of the lattice with beams.

use super::shared::*;
use crate::kit::*;
use serde_json::Value;

/// Largest error over the loaded nodes, for one number of mesh nodes and one force.
fn worst_error(report: &Report, mesh_nodes: f64, force_n: f64) -> f64 {
    let rows = Csv::of(&report.read("convergence.csv"));
    let keys = rows.numbers("mesh_nodes").into_iter().zip(rows.numbers("force_n"));
    let wanted = keys.zip(rows.texts("error")).filter(|(key, _)| *key == (mesh_nodes, force_n));
    wanted.filter_map(|(_, error)| error.parse::<f64>().ok()).fold(0.0, f64::max)
}

#[test]
fn meshes_of_the_papers_finger_are_within_their_tolerances() {
    let summary = PAPERS.summary();
    let checks: Vec<&Value> =
        array(&summary, "checks").iter().filter(|check| check["source"] == "Richardson extrapolation").collect();
    let limits = [(25.0, 1e-2), (61.0, 6e-3), (684.0, 1e-4)];
    assert_eq!(checks.len(), limits.len());
    for (check, (mesh_nodes, limit)) in checks.iter().zip(limits) {
        let error = worst_error(&PAPERS, mesh_nodes, 3.0);
        let number = |key: &str| check[key].as_f64().expect("a number");
        assert_close(&[number("ours") / error, number("tolerance")], &[1.0, limit], LINEAR_ROUNDING);
        assert!(error > 0.0 && error <= limit, "{mesh_nodes} nodes: {error}");
    }
    // Nodes 14 to 24 are loaded in turn, and the finger carries 3 N on every mesh.
    let mut nodes = Csv::of(&PAPERS.read("convergence.csv")).numbers("load_node");
    nodes.dedup();
    assert_eq!(nodes, (14..=24).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn finer_meshes_err_less() {
    for report in [&*PAPERS, &*SPRING_STEELS] {
        assert!(report.pages().contains("id=\"convergence\""));
        let mut meshes = Csv::of(&report.read("convergence.csv")).numbers("mesh_nodes");
        meshes.sort_by(f64::total_cmp);
        meshes.dedup();
        let errors: Vec<f64> = meshes.iter().map(|nodes| worst_error(report, *nodes, 3.0)).collect();
        // The paper's mesh does not belong to the sequence of meshes in which each has twice the elements, so its error need not follow the
        // sequence's trend.
        assert!(errors.len() >= 5 && errors[0] > 0.0, "{errors:?}");
        assert!(errors[errors.len() - 1] < 1e-2 * errors[0], "{errors:?}");
    }
}

/// Finer lattices agree better with beams at every force, and `lattice.csv` contains the errors that the summary states.
#[test]
fn the_lattice_comes_near_to_beams() {
    let rows = Csv::of(&PAPERS.read("lattice.csv"));
    let errors = rows.numbers("error");
    let forces = rows.numbers("segments_a_stretch").iter().filter(|segments| **segments == 2.0).count();
    assert_eq!((forces, errors.len() % forces), (6, 0));
    for (coarse, fine) in errors.iter().zip(&errors[forces..]) {
        assert!(fine * 2.0 < *coarse && *coarse < 0.01, "{errors:?}");
    }
    let summary = PAPERS.summary();
    let keys = ["segments_a_stretch", "bodies", "springs", "force_n", "error", "newton_ms"];
    let entries = array(&summary, "lattice");
    assert_keys(entries, &[], &keys);
    let said: Vec<f64> = entries.iter().filter_map(|row| row["error"].as_f64()).collect();
    assert_close(&said, &errors, LINEAR_ROUNDING);
    // Lattices with nearly inextensible springs do not agree with beams; lattices without axial springs have no equilibrium.
    let axial = Csv::of(&PAPERS.read("lattice_axial_springs.csv"));
    let of = |stiffness: f64| {
        let rows = axial.numbers("stiffness").into_iter().zip(axial.texts("error"));
        rows.filter(move |row| row.0 == stiffness).map(|row| row.1.parse::<f64>().ok()).collect::<Vec<_>>()
    };
    assert!(of(1000.0).iter().all(|error| *error > Some(0.5)) && of(0.0).iter().all(Option::is_none));
    let page = PAPERS.pages();
    assert!(page.contains("id=\"lattice\"") && page.contains("This quick report compares only equilibria"));
    assert!(!SPRING_STEELS.pages().contains("id=\"lattice\""));
    assert!(array(&SPRING_STEELS.summary(), "lattice").is_empty());
}

/// The lattice is one of the simulated true fingers in the maps. On the lattice, least squares has the same error as on the co-rotational finger, and
/// the nonlinear estimator has hardly any error.
#[test]
fn the_lattice_is_sensed_as_the_corotational_finger_is() {
    let summary = PAPERS.summary();
    let of_lattice = |map: &&Value| map["truth"] == "lattice" && map["noise_mm"] == 0.0;
    let maps: Vec<_> = array(&summary, "maps").iter().filter(of_lattice).collect();
    let cells = |estimator: &str| {
        let map = maps.iter().find(|map| map["estimator"] == estimator).expect("a map");
        Csv::of(&PAPERS.read(map["csv"].as_str().expect("a name")))
    };
    let biases = |cells: &Csv| {
        let keys = cells.texts("s_mm").into_iter().zip(cells.texts("angle_deg")).zip(cells.texts("force_n"));
        let keys = keys.map(|((s_mm, angle_deg), force_n)| format!("{s_mm} {angle_deg} {force_n}"));
        keys.zip(cells.numbers("bias")).collect::<std::collections::HashMap<_, _>>()
    };
    let (ours, theirs) =
        (biases(&cells("least-squares")), biases(&Csv::of(&PAPERS.read("map_corotational_without_noise.csv"))));
    let apart = ours.iter().map(|(key, ours)| (ours - theirs[key]).abs()).fold(0.0, f64::max);
    let of_maps = |check: &&Value| {
        let problem = check["problem"].as_str().expect("words");
        problem.starts_with("map of least squares on the lattice") || problem.starts_with("lattice sensed by")
    };
    let checks = array(&summary, "checks").iter().filter(of_maps);
    let said: Vec<f64> = checks.filter_map(|check| check["ours"].as_f64()).collect();
    assert_close(&said[..1], &[apart], LINEAR_ROUNDING);
    let worst = cells("nonlinear").numbers("mean_error").into_iter().fold(0.0, f64::max);
    assert_eq!(said, [said[0], 0.0, worst]);
    assert!(apart < 2e-3 && worst < 2e-3 && ours.values().any(|bias| bias.abs() > 0.1));
}
