//! Stated intervals against the truth, for every estimator.

use super::StudyError;
use crate::estimators::network::{NetworkSensing, Networks};
use crate::estimators::{BeamEstimator, ELEMENTS, Estimator, EstimatorKind};
use crate::experiments::coverage::{CoverageRow, coverage};
use crate::experiments::networks::accuracy;
use crate::sampling::map::MapRequest;
use crate::settings::{Effort, MAP_FORCES_N, Progress};
use crate::truths::{MeshTruth, Truth, fine_mesh};
use finray_model::{Finger, Kinematics, Mesh};

/// Seed of the noise samples.
const SEED: u64 = 5;

/// Coverage on the co-rotational finger over positions and directions and, of the networks, at the contact nodes; at these also on
/// the finger with softer ends, if there is one, of whose ends no estimator knows.
pub(super) fn run(
    truth: &MeshTruth,
    softer: Option<&Finger>,
    finger: &Finger,
    noise_mm: f64,
    (is_paper, effort): (bool, Effort),
    progress: &dyn Progress,
) -> Result<Vec<CoverageRow>, StudyError> {
    if noise_mm == 0.0 {
        return Ok(Vec::new());
    }
    let (places, step_deg, samples) = effort.covered_cells();
    let request = |(places_mm, angles_deg), samples| MapRequest {
        places_mm,
        angles_deg,
        forces_n: MAP_FORCES_N.to_vec(),
        noise_levels_mm: vec![noise_mm],
        noise_pictures: samples,
        seed: SEED,
    };
    let cells = request(MapRequest::grid(finger, places, step_deg), samples);
    let nodes_mm = finger.contact_nodes().rev().filter_map(|node| finger.front_place_mm(node)).collect();
    let nodes = request((nodes_mm, vec![0.0]), effort.covered_at_nodes());
    let at_nodes = usize::from(is_paper) * (1 + usize::from(softer.is_some())) * nodes.contact_count();
    progress.part("coverage", cells.contact_count() + at_nodes);
    let step = || progress.step();

    let [key_nodes, four] = [1, ELEMENTS].map(|elements| Mesh::with_elements_per_member(finger, elements));
    let beams = [
        BeamEstimator::new(EstimatorKind::LeastSquares, &key_nodes),
        BeamEstimator::new(EstimatorKind::Ridge, &key_nodes),
        BeamEstimator::new(EstimatorKind::Nonlinear, &four),
    ];
    let mut all: Vec<&dyn Estimator> = beams.iter().map(|estimator| estimator as &dyn Estimator).collect();
    let mut rows = coverage(finger, truth, &all, (&cells, noise_mm), &step);
    if !is_paper {
        return Ok(rows);
    }
    let shipped = Networks::shipped()?;
    let networks = NetworkSensing { name: accuracy::NAME, networks: &shipped, finger, refuses: true };
    rows.extend(coverage(finger, truth, &[&networks], (&nodes, noise_mm), &step));
    if let Some(softer) = softer {
        let mesh = fine_mesh(softer)?;
        let softer = MeshTruth::new("twin", &mesh, Kinematics::Corotational)?;
        all.push(&networks);
        let truth: &dyn Truth = &softer;
        rows.extend(coverage(finger, truth, &all, (&MapRequest { noise_pictures: 1, ..nodes }, noise_mm), &step));
    }
    Ok(rows)
}
