//! Equilibria of one finger under many loads, computed several at a time in SIMD lanes.
//!
//! All loads share the mesh and hence the sequence of operations. Newton's method therefore handles one load per lane of the SIMD registers. When the
//! load of a lane has converged, the lane starts with the next load. Lanes do not depend on each other, and each lane performs exactly the operations
//! of [`Statics::equilibrium`]. The result of a load is therefore bitwise the same in any batch, for any number of threads and on any machine.
//!
//! Lanes apply the whole load in one step. The scalar solver handles loads that need more steps or have no equilibrium. The scalar solver also
//! computes the first Newton correction of each load. The first Newton correction needs only the stiffness at rest, which the mesh stores, if the
//! ribs are deformable and all loads act on nodes.

use super::ladder::{Balance, Factor};
use super::load_step::{CORRECTION_TOLERANCE, LoadStep};
use super::newton::largest_difference;
use super::{Equilibrium, EquilibriumEquations, Ladder, Statics, StaticsError};
use crate::Kinematics;
use crate::frame::{FrameLoad, FrameMotion};
use crate::mesh::Mesh;
use crate::number::{Lanes, Number};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Number of loads in a piece, which one thread solves. A piece has enough loads to keep the lanes full until near its end, but few loads compared
/// with a study.
const LOADS_A_PIECE: usize = 256;

/// Equilibria under dead loads, each computed by continuation from rest, in the order of the loads. The results equal those of
/// [`Statics::equilibrium`].
///
/// Co-rotational equilibria are computed several at a time in SIMD lanes. The loads are divided into pieces for rayon's threads.
///
/// # Errors
/// Each load has its own result, which may be the [`StaticsError`] of [`Statics::equilibrium`].
pub fn equilibria<L: AsRef<[FrameLoad]>>(
    mesh: &Mesh,
    kinematics: Kinematics,
    loads: &[L],
) -> Vec<Result<Equilibrium, StaticsError>> {
    let loads: Vec<&[FrameLoad]> = loads.iter().map(AsRef::as_ref).collect();
    in_pieces(mesh, kinematics, &loads)
}

fn in_pieces(mesh: &Mesh, kinematics: Kinematics, loads: &[&[FrameLoad]]) -> Vec<Result<Equilibrium, StaticsError>> {
    let pieces = loads.par_chunks(LOADS_A_PIECE);
    let found = pieces.flat_map_iter(|loads| Arch::new().dispatch(Piece { mesh, kinematics, loads }));
    found.collect()
}

/// The loads that one thread solves.
struct Piece<'a> {
    mesh: &'a Mesh,
    kinematics: Kinematics,
    loads: &'a [&'a [FrameLoad]],
}

impl WithSimd for Piece<'_> {
    type Output = Vec<Result<Equilibrium, StaticsError>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Piece { mesh, kinematics, loads } = self;
        let mut single = Statics::ladder(mesh, kinematics);
        // SIMD lanes are no faster than the scalar solver for a single load. SIMD lanes are no faster than the scalar solver for linear equilibria,
        // because all linear equilibria share one factorisation.
        if kinematics == Kinematics::Linear || loads.len() == 1 {
            return loads.iter().map(|loads| single.equilibrium(loads)).collect();
        }
        let mut waiting = PendingLoads { single, loads: loads.iter().enumerate(), results: vec![None; loads.len()] };
        let mut batch = Batch::new(mesh, kinematics, Lanes::splat(simd, 0.0));
        batch.fill(&mut waiting);
        while batch.is_busy() {
            batch.iterate();
            batch.judge(&mut waiting);
            batch.fill(&mut waiting);
        }
        // All loads now have a result.
        waiting.results.into_iter().flatten().collect()
    }
}

type Found = Result<Equilibrium, StaticsError>;

/// Loads that wait for a lane, and the results of the finished loads.
struct PendingLoads<'a, I> {
    /// The scalar solver, for loads that lanes do not solve.
    single: Statics<Ladder<'a>>,
    loads: I,
    results: Vec<Option<Found>>,
}

/// A load in a lane, after its first Newton correction.
struct Path<'a> {
    /// Index of the load in the list of loads.
    index: usize,
    loads: &'a [FrameLoad],
    step: LoadStep,
}

impl<'a, I: Iterator<Item = (usize, &'a &'a [FrameLoad])>> PendingLoads<'a, I> {
    /// The next load that needs more than one correction from rest. `motion` receives the motion of the returned load after its first correction.
    fn next(&mut self, motion: &mut FrameMotion, at_rest: &FrameMotion) -> Option<Path<'a>> {
        while let Some((index, &loads)) = self.loads.next() {
            if !loads.iter().all(FrameLoad::is_finite) {
                self.results[index] = Some(Err(StaticsError::LoadNotFinite));
                continue;
            }
            motion.clone_from(at_rest);
            let equations = self.single.equations_mut();
            let mut step = LoadStep::new(false, CORRECTION_TOLERANCE);
            if equations.linearise(motion, loads, 1.0) {
                let scale = 2.0 * equations.elastic_energy();
                let work = equations.correct(motion);
                let turn = largest_difference(&motion.rotations, &at_rest.rotations);
                if step.judge(work, scale, turn, || false).is_none() {
                    return Some(Path { index, loads, step });
                }
            }
            self.leave(index, loads);
        }
        None
    }

    /// Solves a load with the scalar solver and stores its result.
    fn leave(&mut self, index: usize, loads: &[FrameLoad]) {
        self.results[index] = Some(self.single.equilibrium(loads));
    }
}

/// The loads in the lanes, at most one per lane.
struct Batch<'a, R: Number> {
    balance: Balance<'a, R>,
    stiffness: Factor<R>,
    /// The load of each lane; `None` for an idle lane.
    paths: Vec<Option<Path<'a>>>,
    /// Motion in each lane.
    motion: FrameMotion<R>,
    /// Rotations that the first correction of each load predicts, rad.
    predicted: Vec<R>,
    /// Work of the last correction in each lane, N mm; passed to [`LoadStep::judge`].
    work: R,
    /// Squared energy norm of the solution in each lane, N mm; passed to [`LoadStep::judge`].
    scale: R,
    /// In each lane, the largest deviation of a rotation from its prediction, rad; passed to [`LoadStep::judge`].
    turn: R,
    /// The motion of the undeformed frame.
    at_rest: FrameMotion,
    /// Buffer that receives the motion in one lane.
    of_lane: FrameMotion,
}

impl<'a, R: Number> Batch<'a, R> {
    fn new(mesh: &'a Mesh, kinematics: Kinematics, like: R) -> Batch<'a, R> {
        let motion = FrameMotion::of_zeros(mesh.frame(), like);
        let at_rest = FrameMotion::at_rest(mesh.frame());
        Batch {
            balance: Balance::new(mesh, kinematics, like),
            stiffness: Factor::with_room(mesh, like),
            paths: (0..R::LANES).map(|_| None).collect(),
            predicted: motion.rotations.clone(),
            motion,
            work: like,
            scale: like,
            turn: like,
            of_lane: at_rest.clone(),
            at_rest,
        }
    }

    fn is_busy(&self) -> bool {
        self.paths.iter().any(Option::is_some)
    }

    /// Assigns waiting loads to idle lanes.
    fn fill(&mut self, waiting: &mut PendingLoads<'a, impl Iterator<Item = (usize, &'a &'a [FrameLoad])>>) {
        for (lane, path) in self.paths.iter_mut().enumerate().filter(|(_, path)| path.is_none()) {
            *path = waiting.next(&mut self.of_lane, &self.at_rest);
            if path.is_none() {
                // An idle lane stays at rest. At rest, an idle lane contains no subnormal numbers, which would slow down the other lanes.
                self.of_lane.clone_from(&self.at_rest);
            }
            self.motion.set_lane(lane, &self.of_lane);
            // The last linearisation was at rest.
            for (previous, one) in self.balance.previous.iter_mut().zip(waiting.single.equations().previous()) {
                previous.set_lane(lane, one);
            }
            for (predicted, rotation) in self.predicted.iter_mut().zip(&self.of_lane.rotations) {
                predicted.set_lane(lane, *rotation);
            }
        }
    }

    /// Makes one Newton correction in each busy lane.
    #[inline(always)]
    fn iterate(&mut self) {
        self.apply_loads();
        self.balance.extrapolates = true;
        self.balance.factorise(&mut self.stiffness, &self.motion);
        self.balance.eliminate_gradient(&self.stiffness);
        self.scale = self.balance.energy * 2.0;
        self.work = self.balance.correct(&self.stiffness, &mut self.motion);
        self.turn = self.work.zero();
        for (predicted, rotation) in self.predicted.iter().zip(&self.motion.rotations) {
            self.turn = self.turn.larger((*rotation - *predicted).abs());
        }
    }

    fn apply_loads(&mut self) {
        self.balance.take_off_loads();
        for (lane, path) in self.paths.iter().enumerate() {
            let Some(path) = path else { continue };
            // Forces of loads on nodes do not depend on the motion.
            if path.loads.iter().any(|load| !matches!(load, FrameLoad::Node { .. })) {
                self.motion.copy_lane(lane, &mut self.of_lane);
            }
            self.balance.apply_loads(lane, &self.of_lane, path.loads, 1.0);
        }
    }

    /// Decides for each lane whether its iteration continues. Stores the result of a finished lane, and frees the lane.
    fn judge(&mut self, waiting: &mut PendingLoads<'a, impl Iterator<Item = (usize, &'a &'a [FrameLoad])>>) {
        for (lane, place) in self.paths.iter_mut().enumerate() {
            let Some(path) = place else { continue };
            let mut taken = None;
            if self.work.holds(self.stiffness.positive, lane) {
                let (work, scale, turn) = (self.work.lane(lane), self.scale.lane(lane), self.turn.lane(lane));
                match path.step.judge(work, scale, turn, || false) {
                    None => continue,
                    Some(end) => taken = end.ok(),
                }
            }
            match taken {
                Some(taken) => {
                    let mut motion = self.at_rest.clone();
                    self.motion.copy_lane(lane, &mut motion);
                    let found = Equilibrium { motion, iterations: taken.iterations, load_steps: 1 };
                    waiting.results[path.index] = Some(Ok(found));
                }
                None => waiting.leave(path.index, path.loads),
            }
            *place = None;
        }
    }
}
