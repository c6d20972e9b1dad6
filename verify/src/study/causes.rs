//! Why sensing fails, on the finger as it is described and on its twin.

use crate::estimators::network::{NetworkSensing, Networks};
use crate::experiments::causes::ContactKnowledge::{Assumed, Known};
use crate::experiments::causes::Practice::{LeastSquares, Nonlinear};
use crate::experiments::causes::{self, CauseError, CauseMap, CauseRequest, network};
use crate::sampling::sweep::Grid;
use crate::settings::{DRAWN_FORCE_N, Effort, MAP_FORCES_N, Progress};
use finray_model::Finger;

/// Maps for the finger, and for its twin where there is one; where networks ship for the finger, theirs too.
pub(super) fn run(
    finger: &Finger,
    twin: Option<&Finger>,
    noise_mm: f64,
    effort: Effort,
    progress: &dyn Progress,
) -> Result<Vec<CauseMap>, CauseError> {
    let (places, step_deg, forces_n) = match effort {
        Effort::Quick => (12, 40.0, vec![DRAWN_FORCE_N]),
        Effort::Full => (24, 20.0, vec![MAP_FORCES_N[0], DRAWN_FORCE_N]),
    };
    let (places_mm, angles_deg) = Grid::grid(finger, places, step_deg);
    let of = |practices: &[_]| CauseRequest {
        practices: practices.to_vec(),
        places_mm: places_mm.clone(),
        angles_deg: angles_deg.clone(),
        forces_n: forces_n.clone(),
        noise_mm,
        zones_known: true,
    };
    // What is not known misleads the nonlinear model so far that it searches from many starts: fewer forces and directions
    // then.
    let requests = match effort {
        Effort::Quick => vec![of(&[(LeastSquares, Known)])],
        Effort::Full => vec![
            of(&[(LeastSquares, Known)]),
            CauseRequest { forces_n: vec![DRAWN_FORCE_N], ..of(&[(LeastSquares, Assumed), (Nonlinear, Known)]) },
            CauseRequest { angles_deg: vec![0.0], forces_n: vec![DRAWN_FORCE_N], ..of(&[(Nonlinear, Assumed)]) },
        ],
    };
    let truths: Vec<_> = [("corotational", finger)].into_iter().chain(twin.map(|twin| ("twin", twin))).collect();
    let contacts = |request: &CauseRequest| request.places_mm.len() * request.angles_deg.len();
    progress.part("causes", truths.len() * requests.iter().map(contacts).sum::<usize>());
    let mut maps = Vec::new();
    for (truth, as_it_is) in truths {
        for request in &requests {
            // A finger is known as it is described; what its twin has besides is not.
            let request = CauseRequest { zones_known: truth != "twin", ..request.clone() };
            maps.extend(causes::causes(truth, as_it_is, &request, &|| progress.step())?);
        }
        if effort == Effort::Full {
            let shipped = Networks::shipped()?;
            let sensing = NetworkSensing { name: "network", networks: &shipped, finger, refuses: false };
            let map = network::causes(truth, as_it_is, finger, &sensing, &forces_n, noise_mm)?;
            maps.extend((!map.cells.is_empty()).then_some(map));
        }
    }
    Ok(maps)
}
