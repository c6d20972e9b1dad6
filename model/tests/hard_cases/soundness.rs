//! Laws that every equilibrium of every finger obeys, checked independently of the solver.

use super::{Case, worst};
use finray_model::frame::{FrameLoad, FrameMotion};
use finray_model::statics::{Statics, StaticsError, elastic_energy, reaction};
use finray_model::{Kinematics, Load, Mesh, NodeId, Vector};
use finray_tests::motions_apart;
use std::error::Error;

/// Tolerance of the difference between the ladder solver and the general sparse solver, relative to the largest displacement.
pub const AGREEMENT: f64 = 1e-8;
/// Tolerance of the imbalance of force and moment between reactions and load, relative to the load. Strains of stiff elements have fewer correct
/// digits.
const BALANCE: f64 = 1e-6;
/// Tolerance of the difference between elastic energy and work, relative to the work. It covers the error of the quadrature.
const ENERGY: f64 = 1e-6;
/// Tolerance of a limit load, relative; load steps end at 1e-6 of the requested load.
pub const LIMIT: f64 = 1e-3;
/// Name of the quantity that compares two solutions.
pub const DIFFERENCE: &str = "difference / largest displacement";
/// The load path is divided into this number of parts for quadrature, because shallow arches soften along the path.
const PANELS: usize = 4;
/// Gauss-Legendre rule with eight points on -1..1: (abscissa, weight) of the positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Violations of each law, one figure for each equilibrium.
#[derive(Default)]
pub struct Soundness {
    against_sparse: Vec<f64>,
    unbalanced: Vec<f64>,
    energy: Vec<f64>,
    /// Numbers of loads refused for lack of an equilibrium, and of these refusals that a slightly smaller load confirms.
    refused: [usize; 2],
}

impl Soundness {
    /// Solves for the displacements under a force (N) on a node, linear and co-rotational, and returns both motions.
    pub fn add(&mut self, mesh: &Mesh, node: NodeId, force: Vector) -> Result<[FrameMotion; 2], Box<dyn Error>> {
        let load = mesh.frame_load(&Load::at_node(node, force))?;
        let linear = Statics::ladder(mesh, Kinematics::Linear).equilibrium(&[load])?.motion;
        // Clapeyron: the energy is half the work of the full load.
        self.judge(mesh, &load, &linear, Kinematics::Linear, 0.5 * work(&load, &linear))?;
        let half = GAUSS.into_iter().flat_map(|(x, weight)| [(-x, weight), (x, weight)]);
        let mut points: Vec<(f64, f64)> = (0..PANELS)
            .flat_map(|panel| {
                half.clone().map(move |(x, weight)| {
                    ((panel as f64 + 0.5 + 0.5 * x) / PANELS as f64, 0.5 * weight / PANELS as f64)
                })
            })
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let shares: Vec<f64> = points.iter().map(|(share, _)| *share).chain([1.0]).collect();
        let (path, stopped) = Statics::ladder(mesh, Kinematics::Corotational).path(&[load], &shares);
        stopped.map_or(Ok(()), Err)?;
        let full = path.last().ok_or("no equilibrium along the load path")?.motion.clone();
        // Work of the growing load: F u under the full load minus the complementary energy.
        let complementary: f64 =
            path.iter().zip(&points).map(|(found, (_, weight))| weight * work(&load, &found.motion)).sum();
        self.judge(mesh, &load, &full, Kinematics::Corotational, work(&load, &full) - complementary)?;
        Ok([linear, full])
    }

    /// Like [`add`](Soundness::add), for a force (N) under which the finger may have no equilibrium. The finger must then carry a force slightly below
    /// the reported carried share, and pass all checks at half of the carried share.
    pub fn add_or_refused(&mut self, mesh: &Mesh, node: NodeId, force: Vector) -> Result<(), Box<dyn Error>> {
        let solve = |share: f64| {
            let load = mesh.frame_load(&Load::at_node(node, force * share))?;
            Statics::ladder(mesh, Kinematics::Corotational).equilibrium(&[load])
        };
        let carried = match solve(1.0) {
            Ok(_) => 1.0,
            Err(StaticsError::NoEquilibrium { converged_fraction }) => {
                self.refused[0] += 1;
                self.refused[1] += usize::from(solve(converged_fraction * (1.0 - LIMIT)).is_ok());
                0.5 * converged_fraction
            }
            Err(other) => return Err(other.into()),
        };
        self.add(mesh, node, force * carried).map(|_| ())
    }

    fn judge(
        &mut self,
        mesh: &Mesh,
        load: &FrameLoad,
        motion: &FrameMotion,
        kinematics: Kinematics,
        work: f64,
    ) -> Result<(), StaticsError> {
        let sparse = Statics::sparse(mesh.frame(), kinematics).equilibrium(&[*load])?.motion;
        self.against_sparse.push(motions_apart(motion, &sparse));
        self.unbalanced.push(unbalanced(mesh, load, motion, kinematics));
        self.energy.push((elastic_energy(mesh.frame(), motion, kinematics) / work - 1.0).abs());
        Ok(())
    }

    /// Adds one figure for each law over all equilibria; without equilibria, all these figures fail.
    pub fn report(self, case: &mut Case) {
        case.vanishes("general sparse path", DIFFERENCE, worst(self.against_sparse), AGREEMENT);
        case.vanishes("reactions", "force or moment left / load", worst(self.unbalanced), BALANCE);
        case.vanishes("energy balance", "energy / work - 1", worst(self.energy), ENERGY);
        let [refused, confirmed] = self.refused;
        if refused > 0 {
            case.counts("a smaller load", "refusals confirmed", refused, confirmed);
        }
    }
}

/// Work of the full load over a motion, N mm, as if the load were constant.
fn work(load: &FrameLoad, motion: &FrameMotion) -> f64 {
    match *load {
        FrameLoad::Node { node, force, .. } => force.dot(&motion.displacements[node]),
        _ => f64::NAN,
    }
}

/// The larger of two imbalances of load and reactions: force / load, and moment about the origin / (load x distance of the loaded node).
fn unbalanced(mesh: &Mesh, load: &FrameLoad, motion: &FrameMotion, kinematics: Kinematics) -> f64 {
    let FrameLoad::Node { node, force, .. } = *load else { return f64::NAN };
    let frame = mesh.frame();
    // Linear theory balances moments at the undeformed positions.
    let moved = if kinematics == Kinematics::Linear { Vector::zeros() } else { motion.displacements[node] };
    let (mut force_sum, mut moment_sum) = (force, (frame.position(node) + moved).perp(&force));
    for clamp in mesh.finger().clamped_nodes().map(|clamp| mesh.frame_node(clamp)) {
        let support = reaction(frame, motion, kinematics, &[*load], clamp);
        force_sum += support.force;
        moment_sum += frame.position(clamp).perp(&support.force) + support.moment_nmm;
    }
    worst([force_sum.norm() / force.norm(), moment_sum.abs() / (force.norm() * frame.position(node).norm())])
}
