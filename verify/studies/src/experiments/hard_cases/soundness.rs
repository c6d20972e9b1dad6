//! Laws that every equilibrium of every finger must obey, checked independently of the solver.

use super::{Findings, Unexpected};
use crate::prelude::*;
use finray_model::statics::{elastic_energy, reaction};

/// Tolerance of the difference between the ladder solver and the general sparse solver, relative to the largest displacement.
pub const AGREEMENT: f64 = 1e-8;
/// Tolerance of the imbalance of force and moment between reactions and load, relative to the load. Strains of stiff elements have fewer correct
/// digits.
pub const BALANCE: f64 = 1e-6;
/// Tolerance of the difference between elastic energy and work, relative to the work. It covers the error of the quadrature.
pub const ENERGY: f64 = 1e-6;
/// Tolerance of a limit load, relative; load steps end at 1e-6 of the requested load.
pub const LIMIT: f64 = 1e-3;
/// Name of the quantity that compares two solutions: see [`difference`].
pub const DIFFERENCE: &str = "difference / largest displacement";
/// The load path is divided into this number of parts for quadrature, because shallow arches soften along the path.
const PANELS: usize = 4;
/// Gauss-Legendre rule with eight points on 0..1: (abscissa, weight).
const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// Violations of each mechanical law, one figure for each equilibrium.
#[derive(Debug, Default)]
pub struct Soundness {
    against_sparse: Vec<f64>,
    unbalanced: Vec<f64>,
    energy: Vec<f64>,
    /// Number of loads refused for lack of an equilibrium. The next field counts the refusals that a smaller load confirms.
    refused: usize,
    confirmed: usize,
}

impl Soundness {
    /// Solves for the displacements under a force (N) on a node, linear and co-rotational, and returns both displacement fields.
    ///
    /// # Errors
    /// [`Unexpected`] if the load is invalid or has no equilibrium.
    pub fn add(&mut self, mesh: &Mesh, node: NodeId, force: Vector) -> Result<[FrameMotion; 2], Unexpected> {
        let load = mesh.frame_load(&Load::at_node(node, force))?;
        Ok([self.linear(mesh, load)?, self.corotational(mesh, load)?])
    }

    /// Like [`add`](Soundness::add), for a force (N) under which the finger may have no equilibrium. Without equilibrium, the finger must carry a
    /// force slightly below the reported carried share. At half of the carried share, the finger must pass all checks. Returns the carried share of
    /// the force: 1 if the finger carries the full force.
    pub fn add_or_refused(&mut self, mesh: &Mesh, node: NodeId, force: Vector) -> Result<f64, Unexpected> {
        let solve = |share: f64| {
            let load = mesh.frame_load(&Load::at_node(node, force * share))?;
            Statics::ladder(mesh, Kinematics::Corotational).equilibrium(&[load])
        };
        match solve(1.0) {
            Ok(_) => self.add(mesh, node, force).map(|_| 1.0),
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                self.refused += 1;
                self.confirmed += usize::from(solve(converged_fraction * (1.0 - LIMIT)).is_ok());
                self.add(mesh, node, force * (0.5 * converged_fraction))?;
                Ok(converged_fraction)
            }
            Err(other) => Err(other.into()),
        }
    }

    fn linear(&mut self, mesh: &Mesh, load: FrameLoad) -> Result<FrameMotion, Unexpected> {
        let motion = Statics::ladder(mesh, Kinematics::Linear).equilibrium(&[load])?.motion;
        // Clapeyron: the energy is half the work of the full load.
        self.judge(mesh, &load, &motion, Kinematics::Linear, 0.5 * work(&load, &motion))?;
        Ok(motion)
    }

    fn corotational(&mut self, mesh: &Mesh, load: FrameLoad) -> Result<FrameMotion, Unexpected> {
        let points: Vec<(f64, f64)> = (0..PANELS)
            .flat_map(|panel| GAUSS.map(|(x, weight)| ((panel as f64 + x) / PANELS as f64, weight / PANELS as f64)))
            .collect();
        let shares: Vec<f64> = points.iter().map(|(share, _)| *share).chain([1.0]).collect();
        let (path, stopped) = Statics::ladder(mesh, Kinematics::Corotational).path(&[load], &shares);
        if let Some(error) = stopped {
            return Err(error.into());
        }
        let Some(full) = path.last() else { return Err("no equilibrium along the load path".into()) };
        // Work of the growing load: F u under the full load minus the complementary energy.
        let complementary: f64 =
            path.iter().zip(&points).map(|(found, (_, weight))| weight * work(&load, &found.motion)).sum();
        let done = work(&load, &full.motion) - complementary;
        self.judge(mesh, &load, &full.motion, Kinematics::Corotational, done)?;
        Ok(full.motion.clone())
    }

    fn judge(
        &mut self,
        mesh: &Mesh,
        load: &FrameLoad,
        motion: &FrameMotion,
        kinematics: Kinematics,
        work: f64,
    ) -> Result<(), Unexpected> {
        let sparse = Statics::sparse(mesh.frame(), kinematics).equilibrium(&[*load])?.motion;
        self.against_sparse.push(difference(motion, &sparse));
        self.unbalanced.push(unbalanced(mesh, load, motion, kinematics));
        self.energy.push((elastic_energy(mesh.frame(), motion, kinematics) / work - 1.0).abs());
        Ok(())
    }

    /// Adds one check for each law over all equilibria; without equilibria, all these checks fail.
    pub fn report(self, findings: &mut Findings) {
        let worst = |figures: Vec<f64>| if figures.is_empty() { f64::NAN } else { worst(figures) };
        findings.vanishes("general sparse path", DIFFERENCE, worst(self.against_sparse), AGREEMENT);
        findings.vanishes("reactions", "force or moment left / load", worst(self.unbalanced), BALANCE);
        findings.vanishes("energy balance", "energy / work - 1", worst(self.energy), ENERGY);
        if self.refused > 0 {
            findings.counts("a smaller load", "refusals confirmed", self.refused, self.confirmed);
        }
    }
}

/// Largest difference between the displacements of two motions, relative to the largest displacement of the second motion.
pub fn difference(a: &FrameMotion, b: &FrameMotion) -> f64 {
    let differences = a.displacements.iter().zip(&b.displacements).map(|(a, b)| (a - b).norm());
    worst(differences) / b.largest_displacement()
}

/// Work of the full load over a motion, N mm, as if the load were constant.
fn work(load: &FrameLoad, motion: &FrameMotion) -> f64 {
    match *load {
        FrameLoad::Node { node, force, .. } => force.dot(&motion.displacements[node]),
        _ => f64::NAN,
    }
}

/// Relative imbalance of load and reactions: the larger of two ratios. These are force / load, and moment about the origin / (load x distance of the
/// loaded node).
fn unbalanced(mesh: &Mesh, load: &FrameLoad, motion: &FrameMotion, kinematics: Kinematics) -> f64 {
    let FrameLoad::Node { node, force, .. } = *load else { return f64::NAN };
    let (frame, finger) = (mesh.frame(), mesh.finger());
    let moment = |at: Vector, force: Vector| at.x * force.y - at.y * force.x;
    // Linear theory balances moments at the undeformed positions.
    let moved = if kinematics == Kinematics::Linear { Vector::zeros() } else { motion.displacements[node] };
    let (mut force_sum, mut moment_sum) = (force, moment(frame.position(node) + moved, force));
    for clamp in finger.clamped_nodes().map(|clamp| mesh.frame_node(clamp)) {
        let support = reaction(frame, motion, kinematics, &[*load], clamp);
        force_sum += support.force;
        moment_sum += moment(frame.position(clamp), support.force) + support.moment_nmm;
    }
    let arm = frame.position(node).norm();
    worst([force_sum.norm() / force.norm(), moment_sum.abs() / (force.norm() * arm)])
}
