//! Noise floors of forces under three assumptions about the undeformed positions, from Cramer-Rao bounds and a Monte Carlo study.
//!
//! The report's other studies draw an independent error for each displacement coordinate, as if the undeformed positions were exact. In this study,
//! the same camera also measures the undeformed positions, or these positions follow from the motor angle ([`DisplacementNoise`]). A generalised
//! least-squares estimator uses the covariance of the displacement errors; an ordinary estimator assumes independent errors.

use super::{Context, Evidence};
use crate::experiments::table_two::contact_sets;
use crate::prelude::*;
use crate::sampling::noise::Noise;
use crate::sampling::scatter::sampled_nodes;
use finray_model::measurement::DisplacementNoise;
use finray_model::measurement::noise::base_motions;
use finray_model::sensing::Response;
use finray_numerics::optimise::{FromFunction, LevenbergMarquardt, Refusal, covariance};

/// Standard deviation of the finger base's position along each axis, mm, if it is computed from the motor angle. The value is assumed, because the
/// paper gives the offsets of motor and camera only in figures.
pub const TRANSLATION_SD_MM: f64 = 0.05;
/// Standard deviation of the finger base's rotation, degrees, if it is computed from the motor angle. The value is assumed.
pub const ROTATION_SD_DEG: f64 = 0.1;
/// Number of averaged frames in `bound_of_25_frames_n`: one second of the paper's camera.
pub const FRAMES: usize = 25;
/// Largest number of iterations of an estimator.
const MAX_STEPS: usize = 20;
/// Allowance for sampling error in a root mean square, in standard errors.
const STANDARD_ERRORS: f64 = 4.0;
/// Relative tolerance between two computations of the same bound; it covers rounding.
const SAME_BOUND: f64 = 1e-9;

/// Results for one set of contacts under one noise model. If the set has several contacts, each figure is the root mean square over their forces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DisplacementNoiseRow {
    /// Contact nodes, separated by spaces.
    pub nodes: String,
    /// Noise model: `independent`, `two images` or `motor angle`.
    pub noise: &'static str,
    /// Cramer-Rao bound of a force from one frame, N.
    pub bound_n: f64,
    /// Cramer-Rao bound of a force from the mean of [`FRAMES`] frames that share their undeformed positions, N.
    pub bound_of_25_frames_n: f64,
    /// Number of noise samples, refused ones included.
    pub cases: usize,
    /// Number of samples in which an estimator did not converge.
    pub refused: usize,
    /// Root mean square error of generalised least squares, which uses the noise covariance, N.
    pub generalised_rms_n: f64,
    /// Root mean square error of ordinary least squares, N.
    pub ordinary_rms_n: f64,
    /// Cramer-Rao bound by a second method, N. For two images, it is sqrt(2) times the bound of one image. For the motor angle, the base's motion is
    /// an additional unknown with a prior.
    #[serde(skip)]
    pub other_way_n: f64,
}

/// Results for the three noise models, by set of contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplacementNoiseStudy {
    /// Standard deviation of a coordinate in one image, mm.
    pub image_sd_mm: f64,
    /// Force at every contact along the normal, N.
    pub force_n: f64,
    /// Rows by set of contacts, then noise model.
    pub rows: Vec<DisplacementNoiseRow>,
}

/// Noise models of a camera with standard deviation `image_sd_mm` (mm), with their names.
pub fn models(image_sd_mm: f64) -> [(&'static str, DisplacementNoise); 3] {
    let kinematic = DisplacementNoise::Kinematic {
        image_sd_mm,
        translation_sd_mm: TRANSLATION_SD_MM,
        rotation_sd_rad: ROTATION_SD_DEG.to_radians(),
    };
    [
        ("independent", DisplacementNoise::Independent { sd_mm: image_sd_mm }),
        ("two images", DisplacementNoise::TwoImages { image_sd_mm }),
        ("motor angle", kinematic),
    ]
}

/// Cramer-Rao bound of forces: the covariance (J^T S^-1 J)^-1, N^2. J holds derivatives (mm/N, two rows per node, one column per force). S is the
/// covariance of the mean of `frames` frames. `None` if the forces are not identifiable.
pub fn bound_n2(
    noise: &DisplacementNoise,
    positions_mm: &[Vector],
    derivatives: &DMatrix<f64>,
    frames: usize,
) -> Option<DMatrix<f64>> {
    let whitened = noise.factored(positions_mm, frames)?.l_dirty().solve_lower_triangular(derivatives)?;
    covariance(&whitened)
}

/// Cramer-Rao bound of one frame (N^2) by a second method that inverts no covariance of displacements. `None` as for [`bound_n2`].
pub fn bound_with_base_as_unknown_n2(
    noise: &DisplacementNoise,
    positions_mm: &[Vector],
    derivatives: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let forces = derivatives.ncols();
    let inverse = |information: DMatrix<f64>| information.cholesky().map(|factor| factor.inverse());
    match *noise {
        DisplacementNoise::Independent { sd_mm } => inverse(derivatives.transpose() * derivatives / sd_mm.powi(2)),
        DisplacementNoise::TwoImages { image_sd_mm } => {
            let one = inverse(derivatives.transpose() * derivatives / image_sd_mm.powi(2))?;
            Some(one * 2.0)
        }
        DisplacementNoise::Kinematic { image_sd_mm, translation_sd_mm, rotation_sd_rad } => {
            // Each motion of the base is expressed in units of its standard deviation, so its prior information is 1.
            let mut base = base_motions(positions_mm);
            for (mut motion, sd) in base.column_iter_mut().zip([translation_sd_mm, translation_sd_mm, rotation_sd_rad])
            {
                motion *= sd;
            }
            let columns: Vec<_> = derivatives.column_iter().chain(base.column_iter()).collect();
            let all = DMatrix::from_columns(&columns) / image_sd_mm;
            let mut information = all.transpose() * all;
            for i in forces..forces + 3 {
                information[(i, i)] += 1.0;
            }
            Some(inverse(information)?.view((0, 0), (forces, forces)).into_owned())
        }
    }
}

/// Deformed positions of the marked nodes in the finger frame, mm.
fn positions_mm(finger: &Finger, displacements_mm: &DVector<f64>) -> Vec<Vector> {
    let displaced = |(i, node): (usize, NodeId)| {
        finger.position(node) + Vector::new(displacements_mm[2 * i], displacements_mm[2 * i + 1])
    };
    finger.marked_nodes().enumerate().map(displaced).collect()
}

fn forces_at(nodes: &[NodeId], forces_n: &DVector<f64>) -> Vec<ContactForce> {
    nodes.iter().zip(forces_n).map(|(node, along_n)| ContactForce::plain(Contact::at_node(*node), *along_n)).collect()
}

/// Co-rotational least squares from `start_n` (N): generalised if `known` contains a noise model, otherwise ordinary. `None` if the search does not
/// converge.
pub fn least_squares(
    finger: &mut RespondingFinger,
    nodes: &[NodeId],
    seen_mm: &DVector<f64>,
    known: Option<(&DisplacementNoise, &[Vector])>,
    start_n: &DVector<f64>,
) -> Option<DVector<f64>> {
    let factor = match known {
        Some((noise, positions_mm)) => Some(noise.factored(positions_mm, 1)?),
        None => None,
    };
    let linearised = |forces_n: &DVector<f64>| {
        let response = finger.under(&forces_at(nodes, forces_n)).ok().flatten().ok_or(Refusal::Here(()))?;
        let residual = response.displacements_mm - seen_mm;
        let derivatives = DMatrix::from_columns(&response.along);
        Ok(match factor.as_ref().map(|factor| factor.l_dirty()) {
            Some(l) => {
                (l.solve_lower_triangular_unchecked(&residual), l.solve_lower_triangular_unchecked(&derivatives))
            }
            None => (residual, derivatives),
        })
    };
    let method = LevenbergMarquardt { first_damping: 0.0, most_steps: MAX_STEPS, ..LevenbergMarquardt::default() };
    let fit = method.minimise(&mut FromFunction::new(linearised), start_n.clone()).ok()?;
    fit.has_converged().then_some(fit.point)
}

impl Evidence for DisplacementNoiseStudy {
    fn checks(&self, context: &Context) -> Vec<Check> {
        if context.is_paper { self.checks() } else { Vec::new() }
    }
}

/// Runs the study for a report; `None` without noise.
pub(crate) fn run(context: &Context) -> Result<Option<DisplacementNoiseStudy>, LoadError> {
    let cases = context.effort.choose(20, 200);
    let study =
        || DisplacementNoiseStudy::run(context.finger, context.noise_mm, cases, context.checked_forces().half_n());
    (context.noise_mm > 0.0).then(study).transpose()
}

impl DisplacementNoiseStudy {
    /// Study of single contact nodes (at most 12, without the tip), and of the pairs of Table II that exist on the finger. Each contact node carries
    /// `force_n` (N) along the normal; the two nodes of a pair carry it simultaneously. Each node or pair is sensed for `cases` noise samples of
    /// standard deviation `image_sd_mm` (mm). Contacts without equilibrium are omitted.
    ///
    /// # Errors
    /// [`LoadError`] if a node is not on the finger.
    pub fn run(
        finger: &Finger,
        image_sd_mm: f64,
        cases: usize,
        force_n: f64,
    ) -> Result<DisplacementNoiseStudy, LoadError> {
        let mesh = Mesh::key_nodes(finger);
        let mut sets: Vec<Vec<NodeId>> = sampled_nodes(finger).into_iter().map(|node| vec![node]).collect();
        sets.retain(|set| set[0] != finger.tip());
        let on_finger = |set: &&[usize]| set.iter().all(|&node| finger.contact_nodes().any(|other| other.0 == node));
        let pairs = contact_sets().into_iter().filter(|set| set.len() > 1).filter(on_finger);
        sets.extend(pairs.map(|pair| pair.iter().copied().map(NodeId).collect()));
        let rows: Result<Vec<Vec<DisplacementNoiseRow>>, LoadError> =
            sets.par_iter().map(|nodes| rows_of(&mesh, nodes, [image_sd_mm, force_n], cases)).collect();
        Ok(DisplacementNoiseStudy { image_sd_mm, force_n, rows: rows?.concat() })
    }

    /// Checks that two methods give the same Cramer-Rao bounds, and that generalised least squares reaches these bounds.
    pub fn checks(&self) -> Vec<Check> {
        let mut checks = Vec::new();
        for (name, kind, source, problem) in [
            (
                "two images",
                Kind::Analytical,
                "closed form",
                "bound with two images against sqrt(2) times the bound with one image",
            ),
            (
                "motor angle",
                Kind::Internal,
                "base as unknown with a prior",
                "bound with the motor angle: by inverting the covariance, against the bound with the base's motion \
                    as unknowns",
            ),
        ] {
            let rows = self.rows.iter().filter(|row| row.noise == name);
            let off = worst(rows.map(|row| (row.bound_n / row.other_way_n - 1.0).abs()));
            checks.push(Check::new(kind, problem, source, "largest relative difference", 0.0, off, SAME_BOUND));
        }
        for (name, _) in models(self.image_sd_mm) {
            let rows: Vec<_> = self.rows.iter().filter(|row| row.noise == name).collect();
            let answered: usize = rows.iter().map(|row| row.cases - row.refused).sum();
            // A row without an answer is NaN, so its check fails.
            let squares = rows.iter().map(|row| {
                (row.generalised_rms_n / row.bound_n).powi(2) * (row.cases - row.refused) as f64 / answered as f64
            });
            let over_bound = squares.sum::<f64>().sqrt();
            let refused: usize = rows.iter().map(|row| row.refused).sum();
            let drawn: usize = rows.iter().map(|row| row.cases).sum();
            let chance = STANDARD_ERRORS / (2.0 * answered as f64).sqrt();
            let problem = format!("generalised least squares under the noise \"{name}\"");
            let quantity = format!("rms error / bound, {drawn} noise samples");
            let check = Kind::Internal.on(problem, "Cramer-Rao bound").is(quantity, 1.0, over_bound, chance);
            checks.push(check.with_refused(refused, drawn));
        }
        checks
    }
}

fn rows_of(
    mesh: &Mesh,
    nodes: &[NodeId],
    [image_sd_mm, force_n]: [f64; 2],
    cases: usize,
) -> Result<Vec<DisplacementNoiseRow>, LoadError> {
    let finger = mesh.finger();
    let truth_n = DVector::from_element(nodes.len(), force_n);
    let mut bent = RespondingFinger::new(mesh);
    let Some(truth) = bent.under(&forces_at(nodes, &truth_n))? else { return Ok(Vec::new()) };
    let rows = models(image_sd_mm).into_iter().enumerate().filter_map(|(number, (name, noise))| {
        let mut row = bounds(finger, nodes, name, &noise, &truth)?;
        let stream = number * 1000 + nodes.iter().fold(0, |sum, node| 30 * sum + node.0);
        let mut chance = Noise::of_stream(1, stream as u64);
        let mut normal = || chance.standard_normal();
        let [mut generalised, mut ordinary] = [0.0; 2];
        for _ in 0..cases {
            let at = positions_mm(finger, &truth.displacements_mm);
            let shared = noise.shared_errors_mm(&at, &mut normal);
            let mut seen = Measurement::at_rest(finger);
            noise.add_to(&mut seen, &shared, &mut normal);
            let errors = seen.markers().iter().flat_map(|marker| [marker.displacement.x, marker.displacement.y]);
            let seen_mm = &truth.displacements_mm + DVector::from_iterator(2 * at.len(), errors);
            let measured = positions_mm(finger, &seen_mm);
            // The search starts away from the true forces.
            let start_n = &truth_n * 0.8;
            let found = least_squares(&mut bent, nodes, &seen_mm, Some((&noise, &measured)), &start_n)
                .zip(least_squares(&mut bent, nodes, &seen_mm, None, &start_n));
            match found {
                Some((with, without)) => {
                    generalised += (with - &truth_n).norm_squared() / nodes.len() as f64;
                    ordinary += (without - &truth_n).norm_squared() / nodes.len() as f64;
                }
                None => row.refused += 1,
            }
        }
        let answered = (cases - row.refused) as f64;
        row.cases = cases;
        row.generalised_rms_n = (generalised / answered).sqrt();
        row.ordinary_rms_n = (ordinary / answered).sqrt();
        Some(row)
    });
    Ok(rows.collect())
}

fn bounds(
    finger: &Finger,
    nodes: &[NodeId],
    name: &'static str,
    noise: &DisplacementNoise,
    truth: &Response,
) -> Option<DisplacementNoiseRow> {
    let at = positions_mm(finger, &truth.displacements_mm);
    let derivatives = DMatrix::from_columns(&truth.along);
    let rms_n = |covariance: DMatrix<f64>| (covariance.trace() / nodes.len() as f64).sqrt();
    Some(DisplacementNoiseRow {
        nodes: nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "),
        noise: name,
        bound_n: rms_n(bound_n2(noise, &at, &derivatives, 1)?),
        bound_of_25_frames_n: rms_n(bound_n2(noise, &at, &derivatives, FRAMES)?),
        cases: 0,
        refused: 0,
        generalised_rms_n: f64::NAN,
        ordinary_rms_n: f64::NAN,
        other_way_n: rms_n(bound_with_base_as_unknown_n2(noise, &at, &derivatives)?),
    })
}
