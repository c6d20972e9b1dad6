//! Why sensing fails, on the finger as it is described and on its twin.

use super::{DRAWN_FORCE_N, Effort, MAP_FORCES_N, Progress};
use crate::causes::ContactKnowledge::{Assumed, Known};
use crate::causes::Practice::{LeastSquares, Nonlinear};
use crate::causes::{self, CauseError, CauseMap, CauseRequest, network};
use crate::networks::{NetworkSensing, Networks};
use crate::sweep::Grid;
use finray_model::Finger;

/// Maps for the finger, and for its twin where there is one; where networks ship for the finger, theirs too.
pub(super) fn run(
    finger: &Finger,
    twin: Option<&Finger>,
    noise_mm: f64,
    effort: Effort,
    progress: &dyn Progress,
) -> Result<Vec<CauseMap>, CauseError> {
    // What is assumed of a contact misleads the nonlinear model so far that it searches from many starts: its causes are found
    // along the normal only.
    let (places, step_deg, forces_n, also_along_the_normal) = match effort {
        Effort::Quick => (12, 40.0, vec![DRAWN_FORCE_N], false),
        Effort::Full => (24, 20.0, vec![MAP_FORCES_N[0], DRAWN_FORCE_N], true),
    };
    let (places_mm, angles_deg) = Grid::grid(finger, places, step_deg);
    let over_all = CauseRequest {
        practices: match effort {
            Effort::Quick => vec![(LeastSquares, Known)],
            Effort::Full => vec![(LeastSquares, Known), (LeastSquares, Assumed), (Nonlinear, Known)],
        },
        places_mm,
        angles_deg,
        forces_n,
        noise_mm,
    };
    let along = CauseRequest { practices: vec![(Nonlinear, Assumed)], angles_deg: vec![0.0], ..over_all.clone() };
    let truths: Vec<_> = [("corotational", finger)].into_iter().chain(twin.map(|twin| ("twin", twin))).collect();
    let mut requests = vec![&over_all];
    requests.extend(also_along_the_normal.then_some(&along));
    let contacts = |request: &CauseRequest| request.places_mm.len() * request.angles_deg.len();
    progress.part("causes", truths.len() * requests.iter().map(|request| contacts(request)).sum::<usize>());
    let mut maps = Vec::new();
    for (truth, as_it_is) in truths {
        for request in &requests {
            maps.extend(causes::causes(truth, as_it_is, request, &|| progress.step())?);
        }
        if effort == Effort::Full {
            let shipped = Networks::shipped()?;
            let sensing = NetworkSensing { name: "network", networks: &shipped, finger, refuses: false };
            let map = network::causes(truth, as_it_is, finger, &sensing, &over_all.forces_n, noise_mm)?;
            maps.extend((!map.cells.is_empty()).then_some(map));
        }
    }
    Ok(maps)
}
