//! The accuracy map: how wrong a single force is sensed, by its place on the front plate and its direction.
//!
//! Place and direction are known to the estimator; only the size of the force is sought. The error is
//! |sensed / true - 1|, averaged over the forces and the noise pictures of a cell.

use crate::estimators::{Estimator, EstimatorError};
use crate::truth::Truth;
use finray_model::Finger;
use finray_model::finger::Plate;
use finray_model::measurement::Measurement;
use finray_model::sensing::{Contact, ContactPlace};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::Serialize;

/// What a map is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRequest {
    /// Places on the front plate, mm from the base.
    pub places_mm: Vec<f64>,
    /// Directions, degrees from the inward normal, positive towards the tip.
    pub angles_deg: Vec<f64>,
    /// Forces, N, growing.
    pub forces_n: Vec<f64>,
    /// Standard deviations of a measured coordinate, mm; 0 for none. A map for each.
    pub noise_levels_mm: Vec<f64>,
    /// Number of noise pictures; every cell sees the same ones.
    pub noise_pictures: usize,
    /// Seed of the noise.
    pub seed: u64,
}

impl MapRequest {
    /// About `places` places up to the tip, which divide every stretch between two nodes of the front plate alike (or
    /// skip nodes where there are too many), and directions from -80 to 80 degrees in steps of `step_deg`.
    pub fn grid(finger: &Finger, places: usize, step_deg: f64) -> (Vec<f64>, Vec<f64>) {
        let nodes = finger.plate_places_mm(Plate::Front);
        let stretches = nodes.len() - 1;
        let per_stretch = (places / stretches).max(1);
        let every = (stretches / places).max(1);
        let divided = nodes
            .windows(2)
            .flat_map(|w| (1..=per_stretch).map(move |i| w[0] + (w[1] - w[0]) * i as f64 / per_stretch as f64));
        // Counted from the tip, so that the tip is always among them.
        let mut places: Vec<f64> = divided.collect::<Vec<_>>().into_iter().rev().step_by(every).collect();
        places.reverse();
        let steps = (80.0 / step_deg).floor() as i32;
        (places, (-steps..=steps).map(|i| f64::from(i) * step_deg).collect())
    }
}

/// What came out for one force at one place and direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cell {
    /// Place on the front plate, mm from the base.
    pub s_mm: f64,
    /// Direction, degrees from the inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// True force, N.
    pub force_n: f64,
    /// Mean of |sensed / true - 1| over the noise pictures that are answered; empty where the finger has no equilibrium or
    /// more than half of the pictures are refused.
    pub mean_error: Option<f64>,
    /// Mean of sensed / true - 1: what is wrong even without noise.
    pub bias: Option<f64>,
    /// Standard deviation of sensed / true over the noise.
    pub spread: Option<f64>,
}

/// An accuracy map: cells by place, then direction, then force.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracyMap {
    /// What was asked for.
    pub request: MapRequest,
    /// Name of the truth.
    pub truth: String,
    /// Name of the estimator.
    pub estimator: String,
    /// Standard deviation of a measured coordinate, mm.
    pub noise_mm: f64,
    /// The cells.
    pub cells: Vec<Cell>,
}

/// Computes a map for each noise level in parallel, place by place; the result does not depend on the number of
/// threads. `progress` is called once for every finished place and direction.
pub fn accuracy_maps(
    finger: &Finger,
    truth: &dyn Truth,
    estimator: &dyn Estimator,
    request: &MapRequest,
    progress: &(dyn Fn() + Sync),
) -> Vec<AccuracyMap> {
    let pictures = noise_pictures(finger, request);
    let contacts: Vec<Contact> = request
        .places_mm
        .iter()
        .flat_map(|&s_mm| {
            let contact = move |&angle_deg| Contact { place: ContactPlace::Place(s_mm), angle_deg };
            request.angles_deg.iter().map(contact)
        })
        .collect();
    // By contact, then noise level, then force.
    let columns: Vec<Vec<Vec<Option<Sensed>>>> = contacts
        .par_iter()
        .map(|contact| {
            let column = sense_column(finger, truth, estimator, request, contact, &pictures).unwrap_or_default();
            progress();
            column
        })
        .collect();
    let map = |(level, &noise_mm): (usize, &f64)| {
        let cells = contacts.iter().zip(&columns).flat_map(|(contact, column)| {
            request.forces_n.iter().enumerate().map(move |(i, &force_n)| {
                let sensed = column.get(level).and_then(|forces| forces.get(i)?.as_ref());
                Cell {
                    s_mm: contact.place_mm(finger).unwrap_or(f64::NAN),
                    angle_deg: contact.angle_deg,
                    force_n,
                    mean_error: sensed.map(|s| s.mean_error),
                    bias: sensed.map(|s| s.bias),
                    spread: sensed.map(|s| s.spread),
                }
            })
        });
        AccuracyMap {
            request: request.clone(),
            truth: truth.name().to_owned(),
            estimator: estimator.name().to_owned(),
            noise_mm,
            cells: cells.collect(),
        }
    };
    request.noise_levels_mm.iter().enumerate().map(map).collect()
}

/// Displacement noise of every marker coordinate, one picture after the other, in units of the noise.
fn noise_pictures(finger: &Finger, request: &MapRequest) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(request.seed);
    let mut picture =
        || (0..2 * finger.free_nodes().len()).map(|_| StandardNormal.sample(&mut rng)).collect::<Vec<f64>>();
    (0..request.noise_pictures.max(1)).map(|_| picture()).collect()
}

#[derive(Clone)]
struct Sensed {
    mean_error: f64,
    bias: f64,
    spread: f64,
}

/// Senses every force of one place and direction, as far as the truth has an equilibrium; by noise level.
fn sense_column(
    finger: &Finger,
    truth: &dyn Truth,
    estimator: &dyn Estimator,
    request: &MapRequest,
    contact: &Contact,
    pictures: &[Vec<f64>],
) -> Result<Vec<Vec<Option<Sensed>>>, EstimatorError> {
    let shapes = truth.shapes(contact, &request.forces_n);
    let Some(first) = shapes.first() else { return Ok(Vec::new()) };
    let mut estimator = estimator.prepare(&[*contact], &Measurement::of_shape(finger, first))?;
    let mut relative_error = |measurement: &Measurement, noise_mm: f64, force_n: f64| {
        estimator.estimate(measurement, Some(noise_mm)).ok().map(|sensed| sensed.forces_n[0] / force_n - 1.0)
    };
    let at_level = |&noise_mm: &f64| {
        let sense = |(shape, &force_n)| {
            let clean = Measurement::of_shape(finger, shape);
            if noise_mm == 0.0 {
                return Sensed::of(&[relative_error(&clean, 0.0, force_n)?]);
            }
            let noisy_error = |picture: &Vec<f64>| {
                let mut noisy = clean.clone();
                let mut coordinates = picture.iter();
                noisy.add_noise(noise_mm, || coordinates.next().copied().unwrap_or(0.0));
                relative_error(&noisy, noise_mm, force_n)
            };
            let errors: Vec<f64> = pictures.iter().filter_map(noisy_error).collect();
            // The few answers among many refusals are no fair sample.
            if 2 * errors.len() >= pictures.len() { Sensed::of(&errors) } else { None }
        };
        shapes.iter().zip(&request.forces_n).map(sense).collect()
    };
    Ok(request.noise_levels_mm.iter().map(at_level).collect())
}

impl Sensed {
    /// `None` without any errors.
    fn of(errors: &[f64]) -> Option<Sensed> {
        let count = errors.len() as f64;
        let bias = errors.iter().sum::<f64>() / count;
        let squares: f64 = errors.iter().map(|error| (error - bias).powi(2)).sum();
        (!errors.is_empty()).then(|| Sensed {
            mean_error: errors.iter().map(|error| error.abs()).sum::<f64>() / count,
            bias,
            spread: if errors.len() > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 },
        })
    }
}

impl AccuracyMap {
    /// CSV of the cells: `s_mm,angle_deg,force_n,mean_error,bias,spread`.
    ///
    /// # Errors
    /// None in memory; the signature is the CSV writer's.
    pub fn to_csv(&self) -> Result<String, csv::Error> {
        crate::files::csv_text(&self.cells)
    }

    /// Mean error by direction, then place: of one force, or over all forces. `None` where a force has no equilibrium.
    pub fn errors(&self, force_n: Option<f64>) -> Vec<Vec<Option<f64>>> {
        let forces = self.request.forces_n.len();
        let (places, angles) = (self.request.places_mm.len(), self.request.angles_deg.len());
        let cell = |place: usize, angle: usize| {
            let first = (place * angles + angle) * forces;
            let errors: Option<Vec<f64>> = self.cells[first..first + forces]
                .iter()
                .filter(|cell| force_n.is_none_or(|f| f == cell.force_n))
                .map(|cell| cell.mean_error)
                .collect();
            errors.filter(|e| !e.is_empty()).map(|e| e.iter().sum::<f64>() / e.len() as f64)
        };
        (0..angles).map(|angle| (0..places).map(|place| cell(place, angle)).collect()).collect()
    }

    /// What the map says as a whole, of one force or over all.
    pub fn summary(&self, force_n: Option<f64>) -> MapSummary {
        let errors = self.errors(force_n);
        let known: Vec<f64> = errors.iter().flatten().flatten().copied().collect();
        let share = |limit: f64| known.iter().filter(|e| **e > limit).count() as f64 / known.len().max(1) as f64;
        let cells = errors.iter().flatten().count();
        MapSummary {
            truth: self.truth.clone(),
            estimator: self.estimator.clone(),
            noise_mm: self.noise_mm,
            forces_n: force_n.map_or_else(|| self.request.forces_n.clone(), |f| vec![f]),
            mean_error: known.iter().sum::<f64>() / known.len().max(1) as f64,
            largest_error: known.iter().copied().fold(0.0, f64::max),
            share_above_10: share(0.10),
            share_above_25: share(0.25),
            cells,
            cells_without_equilibrium: cells - known.len(),
        }
    }
}

/// A map in a few figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapSummary {
    /// Name of the truth.
    pub truth: String,
    /// Name of the estimator.
    pub estimator: String,
    /// Standard deviation of a measured coordinate, mm.
    pub noise_mm: f64,
    /// Forces that the errors are averaged over, N.
    pub forces_n: Vec<f64>,
    /// Mean of |sensed / true - 1| over all cells.
    pub mean_error: f64,
    /// Largest error of a cell.
    pub largest_error: f64,
    /// Share of the cells with an error above 10 %.
    pub share_above_10: f64,
    /// Share of the cells with an error above 25 %.
    pub share_above_25: f64,
    /// Number of cells.
    pub cells: usize,
    /// Cells in which a force has no equilibrium; they count in none of the figures above.
    pub cells_without_equilibrium: usize,
}
