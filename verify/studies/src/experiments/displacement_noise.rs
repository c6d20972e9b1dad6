//! Noise floors of forces under three assumptions about the undeformed positions: Cramer-Rao bounds, and the error of ordinary least squares.
//!
//! The report's other studies draw an independent error for each displacement coordinate, as if the undeformed positions were exact. In this study,
//! the same camera also measures the undeformed positions, or these positions follow from the motor angle ([`DisplacementNoise`]). A generalised
//! least-squares estimator uses the covariance of the displacement errors; an ordinary estimator assumes independent errors.

use super::{Context, Evidence, ExperimentError};
use crate::experiments::table_two::contact_sets;
use crate::prelude::*;
use crate::sampling::bound::linearised_markers;
use crate::sampling::scatter::sampled_nodes;
use finray_model::measurement::DisplacementNoise;
use finray_numerics::optimise::covariance;
use std::f64::consts::SQRT_2;

/// Standard deviation of the finger base's position along each axis, mm, if it is computed from the motor angle. The value is assumed, because the
/// paper gives the offsets of motor and camera only in figures.
pub const TRANSLATION_SD_MM: f64 = 0.05;
/// Standard deviation of the finger base's rotation, degrees, if it is computed from the motor angle. The value is assumed.
pub const ROTATION_SD_DEG: f64 = 0.1;
/// Number of averaged frames in `bound_of_25_frames_n`: one second of the paper's camera.
pub const FRAMES: usize = 25;
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
    /// Standard deviation of ordinary least squares, which assumes independent errors, N.
    pub ordinary_rms_n: f64,
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

/// Covariance of forces by ordinary least squares, N^2, which assumes independent errors: G S G^T with G = (J^T J)^-1 J^T, to first order in the
/// errors. `None` if the forces are not identifiable.
pub fn ordinary_n2(
    noise: &DisplacementNoise,
    positions_mm: &[Vector],
    derivatives: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let gain = covariance(derivatives)? * derivatives.transpose();
    Some(&gain * noise.covariance_mm2(positions_mm, 1) * gain.transpose())
}

impl Evidence for DisplacementNoiseStudy {
    fn checks(&self, context: &Context) -> Vec<Check> {
        if context.is_paper { vec![self.check()] } else { Vec::new() }
    }
}

/// Runs the study for a report; `None` without noise.
pub(crate) fn run(context: &Context) -> Result<Option<DisplacementNoiseStudy>, ExperimentError> {
    let study = || DisplacementNoiseStudy::run(context.finger, context.noise_mm, context.checked_forces().half_n());
    Ok((context.noise_mm > 0.0).then(study))
}

impl DisplacementNoiseStudy {
    /// Study of single contact nodes (at most 12, without the tip), and of the pairs of Table II that exist on the finger. Each contact node carries
    /// `force_n` (N) along the normal; the two nodes of a pair carry it simultaneously. The camera's standard deviation is `image_sd_mm` (mm).
    /// Contacts without equilibrium are omitted.
    pub fn run(finger: &Finger, image_sd_mm: f64, force_n: f64) -> DisplacementNoiseStudy {
        let mesh = Mesh::key_nodes(finger);
        let mut statics = Statics::ladder(&mesh, Kinematics::Corotational);
        let mut sets: Vec<Vec<NodeId>> = sampled_nodes(finger).into_iter().map(|node| vec![node]).collect();
        sets.retain(|set| set[0] != finger.tip());
        let on_finger = |set: &&[usize]| set.iter().all(|&node| finger.contact_nodes().any(|other| other.0 == node));
        let pairs = contact_sets().into_iter().filter(|set| set.len() > 1).filter(on_finger);
        sets.extend(pairs.map(|pair| pair.iter().copied().map(NodeId).collect()));
        let mut rows = Vec::new();
        for nodes in &sets {
            let contacts: Vec<Contact> = nodes.iter().copied().map(Contact::at_node).collect();
            let forces_n = vec![force_n; nodes.len()];
            let linearised = linearised_markers(&mut statics, &mesh, &contacts, &forces_n);
            let Ok(Some((motion, derivatives))) = linearised else { continue };
            let deformed = |node| finger.position(node) + motion.displacements[mesh.marker_node(node)];
            let positions_mm: Vec<Vector> = finger.marked_nodes().map(deformed).collect();
            let row = |(name, noise)| row(nodes, name, &noise, &positions_mm, &derivatives);
            rows.extend(models(image_sd_mm).into_iter().filter_map(row));
        }
        DisplacementNoiseStudy { image_sd_mm, force_n, rows }
    }

    /// Checks that the error of an image of the undeformed finger increases every bound by sqrt(2).
    pub fn check(&self) -> Check {
        let of = |name| self.rows.iter().filter(move |row| row.noise == name).map(|row| row.bound_n);
        let off = of("two images").zip(of("independent")).map(|(two, one)| (two / (SQRT_2 * one) - 1.0).abs());
        let problem = "bound with two images against sqrt(2) times the bound with one image";
        let subject = Kind::Analytical.on(problem, "closed form");
        subject.vanishes("largest relative difference", worst(off), SAME_BOUND)
    }
}

fn row(
    nodes: &[NodeId],
    name: &'static str,
    noise: &DisplacementNoise,
    positions_mm: &[Vector],
    derivatives: &DMatrix<f64>,
) -> Option<DisplacementNoiseRow> {
    let rms_n = |covariance: DMatrix<f64>| (covariance.trace() / nodes.len() as f64).sqrt();
    Some(DisplacementNoiseRow {
        nodes: nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "),
        noise: name,
        bound_n: rms_n(bound_n2(noise, positions_mm, derivatives, 1)?),
        bound_of_25_frames_n: rms_n(bound_n2(noise, positions_mm, derivatives, FRAMES)?),
        ordinary_rms_n: rms_n(ordinary_n2(noise, positions_mm, derivatives)?),
    })
}
