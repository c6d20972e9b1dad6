//! Causes of sensing errors on the scene's finger and on its digital twin.

use super::ContactKnowledge::{Assumed, Known};
use super::Practice::{LeastSquares, Nonlinear};
use super::models::WEIGHTS_N;
use super::{CauseMap, CauseRequest, causes, network};
use crate::experiments::{Context, Evidence, ExperimentError};
use crate::prelude::*;
use crate::sampling::sweep::Grid;
use crate::truths::{TruthId, twin_of};

impl Evidence for CauseMap {}

/// Maps of causes for the finger, for its digital twin if the finger has one, and for the networks shipped for this finger.
///
/// # Errors
/// [`ExperimentError`] if the equations of a finger at rest cannot be solved, or its modulus cannot be calibrated.
pub fn run(context: &Context) -> Result<Vec<CauseMap>, ExperimentError> {
    let &Context { finger, noise_mm, effort, forces, .. } = context;
    let (drawn_n, [least_n, ..]) = (forces.drawn_n(), forces.of_maps_n());
    let (positions, step_deg) = effort.choose((12, 40.0), (24, 20.0));
    let forces_n = effort.choose(vec![drawn_n], vec![least_n, drawn_n]);
    let weights_n = context.checked_forces().scaled(WEIGHTS_N);
    let (positions_mm, angles_deg) = Grid::grid(finger, positions, step_deg);
    let of = |practices: &[_]| CauseRequest {
        practices: practices.to_vec(),
        positions_mm: positions_mm.clone(),
        angles_deg: angles_deg.clone(),
        forces_n: forces_n.clone(),
        noise_mm,
        zones_known: true,
        weights_n,
    };
    // Wrong assumptions make the nonlinear search try many starting points, so the nonlinear estimator is studied with fewer forces and directions.
    let requests = match effort {
        Effort::Quick => vec![of(&[(LeastSquares, Known)])],
        Effort::Full => vec![
            of(&[(LeastSquares, Known)]),
            CauseRequest { forces_n: vec![drawn_n], ..of(&[(LeastSquares, Assumed), (Nonlinear, Known)]) },
            CauseRequest { angles_deg: vec![0.0], forces_n: vec![drawn_n], ..of(&[(Nonlinear, Assumed)]) },
        ],
    };
    let twin = (context.is_paper && noise_mm > 0.0).then(|| twin_of(finger)).transpose()?;
    let twin = twin.as_ref().map(|twin| (TruthId::Twin, twin));
    let truths: Vec<_> = [(TruthId::Corotational, finger)].into_iter().chain(twin).collect();
    let contacts = |request: &CauseRequest| request.positions_mm.len() * request.angles_deg.len();
    context.progress.part("causes", truths.len() * requests.iter().map(contacts).sum::<usize>());
    let mut maps = Vec::new();
    for (truth, as_it_is) in truths {
        for request in &requests {
            // The scene describes its own finger completely; the additional zones of the twin are unknown.
            let request = CauseRequest { zones_known: truth != TruthId::Twin, ..request.clone() };
            maps.extend(causes(truth, as_it_is, &request, &|| context.progress.step())?);
        }
        if effort == Effort::Full {
            let scene = PreparedScene::from(Scene::of_finger(finger.clone()));
            let options =
                SensorOptions { networks: context.networks.clone(), ..SensorOptions::of(EstimatorId::Network) };
            let network =
                |node| Sensor::new(scene.clone(), SensorContacts::known(&[Contact::at_node(node)]), options.clone());
            let map = network::causes(truth, as_it_is, finger, &network, &forces_n, noise_mm)?;
            maps.extend((!map.cells.is_empty()).then_some(map));
        }
    }
    Ok(maps)
}
