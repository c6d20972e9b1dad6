//! Random cases: forces that deform the true finger, its noisy measurements, and the answers of every sensor.

use super::ScatterRequest;
use crate::prelude::*;
use crate::sampling::bound::{ForceBound, linearised_markers, loads};
use crate::sampling::noise::{Noise, with_sample};
use finray_model::statics::{Ladder, equilibria};

/// A case is dropped after this number of draws without equilibrium. If the first case is dropped, the finger counts as unable to carry any force
/// of the range.
const MOST_DRAWS: usize = 100;
/// Number of cases per block. Cases of a block share sensors, and one thread computes a block.
const BLOCK: u64 = 100;
pub(super) struct Case {
    /// True forces, N.
    pub forces_n: Vec<f64>,
    /// Cramer-Rao bound at the true forces, and the first-order errors of the forces per mm of noise (N/mm). `None` if the forces are not
    /// identifiable.
    pub bound: Option<(ForceBound, DVector<f64>)>,
    /// Answers by noise level, then sensor; `None` if the sensor refused.
    pub sensed: Vec<Vec<Option<SensedForces>>>,
    /// Number of draws that were repeated because the finger has no equilibrium under the drawn forces.
    pub not_carried: usize,
}

/// All cases of one set of contacts, in order; empty if the finger carries no force of the range.
pub(super) fn cases(
    request: &ScatterRequest,
    sensors: &[SensorOptions],
    contacts: &[Contact],
    range_n: [f64; 2],
    stream: u64,
) -> Result<Vec<Case>, Refusal> {
    let count = request.cases as u64;
    let run = |numbers: std::ops::Range<u64>| -> Result<Vec<Case>, Refusal> {
        let mut runner = CaseRunner::new(request, sensors, contacts)?;
        let draws = numbers.map(|number| Draw::new(request, contacts, range_n, stream, number)).collect();
        Ok(runner.carried(draws, range_n).iter().flatten().map(|draw| runner.case(draw)).collect())
    };
    // The first case reveals wrong contacts, and fingers without any equilibrium.
    let mut all = run(0..count.min(1))?;
    if all.is_empty() {
        return Ok(all);
    }
    let blocks: Vec<u64> = (1..count).step_by(BLOCK as usize).collect();
    let rest: Result<Vec<_>, _> = blocks.into_par_iter().map(|first| run(first..(first + BLOCK).min(count))).collect();
    all.extend(rest?.into_iter().flatten());
    Ok(all)
}

/// The true finger, and every sensor under test.
struct CaseRunner<'a> {
    finger: &'a Finger,
    mesh: &'a Mesh,
    contacts: &'a [Contact],
    request: &'a ScatterRequest<'a>,
    /// The true finger on the mesh of the Cramer-Rao bound.
    model: Statics<Ladder<'a>>,
    sensors: Vec<Sensor>,
}

impl<'a> CaseRunner<'a> {
    fn new(
        request: &'a ScatterRequest<'a>,
        sensors: &[SensorOptions],
        contacts: &'a [Contact],
    ) -> Result<CaseRunner<'a>, Refusal> {
        let asked = SensorContacts::known(contacts);
        let sensors = sensors.iter().map(|options| Sensor::new(request.scene.clone(), asked.clone(), options.clone()));
        Ok(CaseRunner {
            finger: request.truth.finger(),
            mesh: request.truth,
            contacts,
            request,
            model: Statics::ladder(request.model, request.kinematics),
            sensors: sensors.collect::<Result<_, _>>()?,
        })
    }

    /// Solves for the finger's shape under each draw, and measures it without noise. A draw without equilibrium is replaced by a new draw. The entry is
    /// `None` if none of the draws has an equilibrium.
    fn carried(&self, mut draws: Vec<Draw>, range_n: [f64; 2]) -> Vec<Option<(Draw, Measurement)>> {
        let mut carried: Vec<Option<(Draw, Measurement)>> = draws.iter().map(|_| None).collect();
        let mut open: Vec<usize> = (0..draws.len()).collect();
        // Contacts off the finger have no load, so no draw can be solved.
        while let Some(found) = self.motions(&draws, &mut open).filter(|_| !open.is_empty()) {
            let mut again = Vec::new();
            for (number, found) in open.into_iter().zip(found) {
                let draw = &mut draws[number];
                if let Some(motion) = found {
                    carried[number] =
                        Some((draw.clone(), Measurement::of_shape(self.finger, &self.mesh.shape(&motion))));
                } else if draw.again(range_n) {
                    again.push(number);
                }
            }
            open = again;
        }
        carried
    }

    /// Motions of the finger under the draws whose indices are in `open`; `None` for a draw without equilibrium. Equilibria under a single force form
    /// one path. Draws of a single force are sorted by force and solved one after the other along the path, because a finger that folds needs many
    /// load steps from rest. `None` for contacts off the finger.
    fn motions(&self, draws: &[Draw], open: &mut [usize]) -> Option<Vec<Option<FrameMotion>>> {
        let is_path = self.contacts.len() == 1 && open.iter().all(|&number| draws[number].forces_n[0] > 0.0);
        if !is_path {
            let of_draw = |number: &usize| loads(self.mesh, self.contacts, &draws[*number].forces_n);
            let loads = open.iter().map(of_draw).collect::<Result<Vec<_>, _>>().ok()?;
            let found = equilibria(self.mesh, self.request.kinematics, &loads);
            return Some(found.into_iter().map(|found| found.ok().map(|found| found.motion)).collect());
        }
        let force_n = |number: &usize| draws[*number].forces_n[0];
        open.sort_by(|a, b| force_n(a).total_cmp(&force_n(b)));
        let forces_n: Vec<f64> = open.iter().map(force_n).collect();
        let unit_load = loads(self.mesh, self.contacts, &[1.0]).ok()?;
        let (found, _) = Statics::ladder(self.mesh, self.request.kinematics).path(&unit_load, &forces_n);
        let mut motions: Vec<Option<FrameMotion>> = found.into_iter().map(|found| Some(found.motion)).collect();
        motions.resize(open.len(), None);
        Some(motions)
    }

    fn case(&mut self, (draw, clean): &(Draw, Measurement)) -> Case {
        let of_level = |&noise_mm: &f64| {
            let seen = with_sample(clean, &draw.noise, noise_mm);
            let stated_mm = Some(noise_mm.max(LEAST_STATED_MM));
            self.sensors.iter().map(|sensor| sensor.sense_displacements(&seen, stated_mm, None).ok()).collect()
        };
        let sensed = self.request.noise_levels_mm.iter().map(of_level).collect();
        let forces_n = draw.forces_n.clone();
        let bound = linearised_markers(&mut self.model, self.request.model, self.contacts, &forces_n)
            .ok()
            .flatten()
            .and_then(|(_, derivatives)| ForceBound::new(&derivatives));
        let bound = bound.map(|bound| {
            let response = bound.response_n(&DVector::from_column_slice(&draw.noise));
            (bound, response)
        });
        Case { forces_n, bound, sensed, not_carried: draw.not_carried }
    }
}

/// Random numbers of one case, the same for every sensor.
#[derive(Clone)]
struct Draw {
    forces_n: Vec<f64>,
    /// Noise of each coordinate, in standard deviations.
    noise: Vec<f64>,
    /// Number of earlier draws without equilibrium.
    not_carried: usize,
    /// Generator for repeated draws.
    chance: Noise,
}

impl Draw {
    fn new(request: &ScatterRequest, contacts: &[Contact], range_n: [f64; 2], stream: u64, number: u64) -> Draw {
        let mut chance = Noise::of_stream(request.seed, stream);
        chance.go_to(number);
        let noise = chance.standard_normals(2 * request.truth.finger().marked_nodes().len()).collect();
        let mut draw = Draw { forces_n: vec![0.0; contacts.len()], noise, not_carried: 0, chance };
        draw.draw(range_n);
        draw
    }

    fn draw(&mut self, range_n: [f64; 2]) {
        self.forces_n.fill_with(|| self.chance.evenly(range_n));
    }

    /// Draws other forces after a draw without equilibrium; `false` if the largest number of draws is reached.
    fn again(&mut self, range_n: [f64; 2]) -> bool {
        self.not_carried += 1;
        self.draw(range_n);
        self.not_carried < MOST_DRAWS
    }
}
