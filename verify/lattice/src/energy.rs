//! Elastic energy of the lattice, and its equilibrium by Newton's method.

use super::LatticeError;
use super::bodies::{Assembly, BodyLoad};
use super::springs::{BodyIndex, Deformation, Spring};
use faer::Side;
use faer::linalg::solvers::Solve;
use faer::mat::MatMut;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat, Triplet};
use finray_model::Vector;
use nalgebra::{Matrix6, Rotation2, Vector6};

/// Motion of a body from its undeformed pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyMotion {
    /// Displacement of the body's centre, mm.
    pub displacement: Vector,
    /// Rotation of the body, rad.
    pub rotation: f64,
}

impl BodyMotion {
    /// Rotates a body-fixed vector (mm) with the body.
    pub fn carried(&self, arm: Vector) -> Vector {
        Rotation2::new(self.rotation) * arm
    }

    /// Displacement of the point at `arm` from the centre, mm. The formula avoids cancellation at small rotations.
    pub fn displacement_at(&self, arm: Vector) -> Vector {
        Moved::by(self).displacement_at(arm)
    }
}

/// A motion with the sine and cosine of its rotation, computed once for all springs of the body.
#[derive(Debug, Clone, Copy)]
struct Moved {
    displacement: Vector,
    rotation: f64,
    turn: Rotation2<f64>,
    /// 1 - cos(rotation), computed without cancellation.
    versine: f64,
}

impl Moved {
    fn by(motion: &BodyMotion) -> Moved {
        let BodyMotion { displacement, rotation } = *motion;
        let half = (0.5 * rotation).sin();
        Moved { displacement, rotation, turn: Rotation2::new(rotation), versine: 2.0 * half * half }
    }

    /// Displacement of the point at `arm` from the centre, mm: see [`BodyMotion::displacement_at`].
    fn displacement_at(&self, arm: Vector) -> Vector {
        self.displacement + Vector::new(-arm.y, arm.x) * self.turn[(1, 0)] - arm * self.versine
    }
}

/// Deformation of a spring (mm or rad), with its first and second derivatives with respect to x, y and rotation of both bodies.
struct Deformed {
    value: f64,
    gradient: Vector6<f64>,
    curvature: Matrix6<f64>,
}

/// Outer product of two vectors.
fn outer(a: &Vector6<f64>, b: &Vector6<f64>) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| a[i] * b[j])
}

impl Spring {
    /// Deformation s of the spring, mm or rad. The vector between its two points is d = x2 + R2 a2 - x1 - R1 a1. A distance spring has
    /// s = |d| - |rest|. A transverse spring has s = n . d with the normal n = R1 n0 carried by the first body. For a rotation spring, s is the
    /// difference of the rotations.
    fn deformed(&self, bodies: [Moved; 2]) -> Deformed {
        let [first, second] = self.ends;
        let arms = [bodies[0].turn * first.arm, bodies[1].turn * second.arm];
        let moved = bodies[1].displacement_at(second.arm) - bodies[0].displacement_at(first.arm);
        // First derivatives of d projected on the direction `along`.
        let d_by = |along: Vector| {
            Vector6::new(-along.x, -along.y, along.perp(&arms[0]), along.x, along.y, -along.perp(&arms[1]))
        };
        // The second derivative of a rotated arm with respect to the rotation is minus the rotated arm.
        let turned = |along: Vector, curvature: &mut Matrix6<f64>| {
            curvature[(2, 2)] += along.dot(&arms[0]);
            curvature[(5, 5)] -= along.dot(&arms[1]);
        };
        match self.deformation {
            Deformation::Distance { rest } => {
                let d = rest + moved;
                let distance = d.norm();
                let along = d / distance;
                let across = d_by(Vector::new(-along.y, along.x));
                let mut curvature = outer(&across, &(across / distance));
                turned(along, &mut curvature);
                // |d| - |rest| in a form that subtracts no nearly equal lengths.
                let value = moved.dot(&(rest + d)) / (distance + rest.norm());
                Deformed { value, gradient: d_by(along), curvature }
            }
            Deformation::Across { direction } => {
                let along = bodies[0].turn * direction;
                let normal = Vector::new(-along.y, along.x);
                let mut gradient = d_by(normal);
                gradient[2] -= along.dot(&moved);
                let mixed = d_by(-along);
                let mut curvature = Matrix6::zeros();
                for i in 0..6 {
                    curvature[(i, 2)] += mixed[i];
                    curvature[(2, i)] += mixed[i];
                }
                curvature[(2, 2)] -= normal.dot(&moved);
                turned(normal, &mut curvature);
                Deformed { value: normal.dot(&moved), gradient, curvature }
            }
            Deformation::Turn => Deformed {
                value: bodies[1].rotation - bodies[0].rotation,
                gradient: Vector6::new(0.0, 0.0, -1.0, 0.0, 0.0, 1.0),
                curvature: Matrix6::zeros(),
            },
        }
    }
}

/// Energy of a lattice under dead loads (constant in direction), as a function of the motion of all bodies.
#[derive(Debug, Clone)]
pub struct Energy<'a> {
    assembly: &'a Assembly,
    /// Index of the first of three unknowns (x, y, rotation) of each body; `None` for a clamped body.
    unknowns: Vec<Option<usize>>,
    count: usize,
}

/// Energy of a spring, with its derivatives with respect to x, y and rotation of the first body, then of the second.
#[derive(Debug, Clone, Copy)]
pub struct SpringEnergy {
    /// Bodies at the two ends of the spring.
    pub bodies: [BodyIndex; 2],
    /// Elastic energy, N mm.
    pub energy: f64,
    /// First derivatives, 6 entries, N and N mm.
    pub gradient: Vector6<f64>,
    /// Second derivatives, 6 x 6, in N/mm, N and N mm.
    pub curvature: Matrix6<f64>,
}

/// Energy of a lattice with its gradient and second derivatives.
#[derive(Debug, Clone)]
pub struct Expansion {
    /// Elastic energy minus the work of the loads, N mm.
    pub energy: f64,
    /// Derivatives with respect to x, y and rotation of every free body: the unbalanced forces, N, and moments, N mm.
    pub gradient: Vec<f64>,
    /// Second derivatives as (row, column, value), lower triangle only; entries with equal indices are added. Units N/mm, N and N mm.
    pub curvature: Vec<Triplet<usize, usize, f64>>,
}

/// Newton's method has converged if the energy decrease that a step predicts is at most this share of the largest decrease predicted so far.
/// Convergence is quadratic, so a further step would gain nothing.
const CONVERGED: f64 = 1e-16;
/// Number of Newton steps after which the load increment is halved.
const MOST_STEPS: usize = 30;
/// Smallest load increment that is tried, as a share of the whole interval. If this increment has no solution, the path ends.
const SMALLEST_PART: f64 = 1e-4;
/// Largest rotation of a body in one load increment, rad. A larger rotation may be a jump to another equilibrium, so the increment is halved.
const MOST_TURN: f64 = 0.6;

/// A spring counts as rigid if its stiffness exceeds the median stiffness by this factor, because rounding then hides its force. Positions of 150 mm
/// are rounded by 1e-14 mm. The resulting error of the force is 2e-12 N at 240 N/mm, a usual stiffness of a TPU finger. In the springs of a segment
/// of 0.007 mm, the error is 1e-4 N.
const STIFF: f64 = 1e4;

/// Sparsity pattern and elimination order, shared by all second derivatives under the same loads.
struct Elimination {
    pattern: SymbolicSparseColMat<usize>,
    /// Order in which the entries of a list fill the pattern.
    entries: Argsort<usize>,
    order: SymbolicLlt<usize>,
}

impl Elimination {
    fn of(count: usize, curvature: &[Triplet<usize, usize, f64>]) -> Option<Elimination> {
        let indices: Vec<_> = curvature.iter().map(|entry| Pair::new(entry.row, entry.col)).collect();
        let (pattern, entries) = SymbolicSparseColMat::try_new_from_indices(count, count, &indices).ok()?;
        let order = SymbolicLlt::try_new(pattern.as_ref(), Side::Lower).ok()?;
        Some(Elimination { pattern, entries, order })
    }

    /// Cholesky factors; `None` if the matrix of second derivatives is not positive definite.
    fn factorised(&self, curvature: &[Triplet<usize, usize, f64>]) -> Option<Llt<usize, f64>> {
        let values: Vec<f64> = curvature.iter().map(|entry| entry.val).collect();
        let matrix = SparseColMat::new_from_argsort(self.pattern.clone(), &self.entries, &values).ok()?;
        Llt::try_new_with_symbolic(self.order.clone(), matrix.as_ref(), Side::Lower).ok()
    }
}

impl<'a> Energy<'a> {
    /// Numbers the unknowns of the free bodies.
    pub fn new(assembly: &'a Assembly) -> Energy<'a> {
        let mut unknowns = Vec::with_capacity(assembly.bodies.len());
        let mut count = 0;
        for body in &assembly.bodies {
            unknowns.push((!body.fixed).then_some(count));
            count += if body.fixed { 0 } else { 3 };
        }
        Energy { assembly, unknowns, count }
    }

    /// Number of unknowns: three per free body.
    pub fn unknown_count(&self) -> usize {
        self.count
    }

    /// Index of a body's first unknown; `None` for a clamped body.
    pub fn first_unknown(&self, body: usize) -> Option<usize> {
        self.unknowns[body]
    }

    /// Energy of every spring for given motions of the bodies, in the order of the assembly.
    pub fn springs(&self, motions: &[BodyMotion]) -> impl Iterator<Item = SpringEnergy> + use<'a> {
        let moved: Vec<Moved> = motions.iter().map(Moved::by).collect();
        self.assembly.springs.iter().map(move |spring| {
            let bodies = spring.ends.map(|end| end.body);
            let Deformed { value, gradient, curvature } = spring.deformed(bodies.map(|body| moved[body]));
            let force = spring.stiffness * value;
            SpringEnergy {
                bodies,
                energy: 0.5 * force * value,
                gradient: gradient * force,
                curvature: outer(&gradient, &(gradient * spring.stiffness)) + curvature * force,
            }
        })
    }

    /// Expands the energy to second order about `motions`, under the loads times `factor`.
    pub fn expand(&self, motions: &[BodyMotion], loads: &[BodyLoad], factor: f64) -> Expansion {
        let mut expansion = Expansion { energy: 0.0, gradient: vec![0.0; self.count], curvature: Vec::new() };
        for SpringEnergy { bodies, energy, gradient, curvature } in self.springs(motions) {
            expansion.energy += energy;
            let unknown = |i: usize| self.unknowns[bodies[i / 3]].map(|first| first + i % 3);
            for i in 0..6 {
                let Some(row) = unknown(i) else { continue };
                expansion.gradient[row] += gradient[i];
                for j in 0..6 {
                    if let Some(column) = unknown(j).filter(|column| *column <= row) {
                        expansion.curvature.push(Triplet::new(row, column, curvature[(i, j)]));
                    }
                }
            }
        }
        for load in loads {
            let Some(first) = self.unknowns[load.body] else { continue };
            let motion = motions[load.body];
            let (force, moment) = (load.force * factor, load.moment_nmm * factor);
            let lever = motion.carried(load.lever);
            let swing = lever - load.lever;
            expansion.energy -=
                force.dot(&motion.displacement) * load.share + force.dot(&swing) + moment * motion.rotation;
            expansion.gradient[first] -= force.x * load.share;
            expansion.gradient[first + 1] -= force.y * load.share;
            expansion.gradient[first + 2] -= lever.perp(&force) + moment;
            expansion.curvature.push(Triplet::new(first + 2, first + 2, force.dot(&lever)));
        }
        expansion
    }

    /// Force (N) and moment about the origin (N mm) that the springs exert on the clamped bodies.
    pub fn on_clamps(&self, motions: &[BodyMotion]) -> (Vector, f64) {
        self.on_bodies(motions, &self.clamped())
    }

    /// Force (N) and moment about the origin (N mm) that the springs of the other bodies exert on the bodies marked in `are_held`.
    pub fn on_bodies(&self, motions: &[BodyMotion], are_held: &[bool]) -> (Vector, f64) {
        let (mut force, mut moment) = (Vector::zeros(), 0.0);
        for spring in &self.assembly.springs {
            let bodies = spring.ends.map(|end| end.body);
            let Some(end) = (0..2).find(|&end| are_held[bodies[end]] && !are_held[bodies[1 - end]]) else { continue };
            let deformed = spring.deformed(bodies.map(|body| Moved::by(&motions[body])));
            let pull = deformed.gradient * -(spring.stiffness * deformed.value);
            let on_body = Vector::new(pull[3 * end], pull[3 * end + 1]);
            let position = self.assembly.bodies[bodies[end]].position + motions[bodies[end]].displacement;
            force += on_body;
            moment += pull[3 * end + 2] + position.perp(&on_body);
        }
        (force, moment)
    }

    fn clamped(&self) -> Vec<bool> {
        self.unknowns.iter().map(Option::is_none).collect()
    }

    /// Marks the clamped bodies, and the bodies connected to them by springs so stiff that rounding hides the spring forces. At rest, the sum of all forces
    /// on the marked bodies, from the other bodies and from outside, equals the force on the clamps.
    pub fn stiff_base(&self) -> Vec<bool> {
        let is_translational = |spring: &&Spring| spring.deformation != Deformation::Turn;
        let springs: Vec<&Spring> = self.assembly.springs.iter().filter(is_translational).collect();
        let mut stiffnesses: Vec<f64> = springs.iter().map(|spring| spring.stiffness).collect();
        stiffnesses.sort_by(f64::total_cmp);
        let usual = stiffnesses.get(stiffnesses.len() / 2).copied().unwrap_or_default();
        let stiff: Vec<[BodyIndex; 2]> = springs
            .iter()
            .filter(|spring| spring.stiffness > STIFF * usual)
            .map(|spring| spring.ends.map(|end| end.body))
            .collect();
        let mut are_held = self.clamped();
        while let Some(bodies) = stiff.iter().find(|[first, second]| are_held[*first] != are_held[*second]) {
            bodies.iter().for_each(|&body| are_held[body] = true);
        }
        are_held
    }

    /// Follows the equilibrium as the load factor changes from `from` to `to`. `motions` must be the equilibrium at `from`, and becomes the
    /// equilibrium at `to`. Returns the number of Newton steps.
    ///
    /// # Errors
    /// [`LatticeError::NoEquilibrium`] if no further stable equilibrium is found; `motions` is then the last equilibrium on the path.
    pub fn follow(
        &self,
        motions: &mut Vec<BodyMotion>,
        loads: &[BodyLoad],
        from: f64,
        to: f64,
    ) -> Result<usize, LatticeError> {
        let (mut at, mut part, mut steps) = (from, to - from, 0);
        let mut elimination = None;
        while at < to {
            let next = if at + part >= to { to } else { at + part };
            let mut trial = motions.clone();
            let taken = self.converge(&mut trial, loads, next, &mut elimination);
            let turn = |(a, b): (&BodyMotion, &BodyMotion)| (a.rotation - b.rotation).abs();
            match taken.filter(|_| trial.iter().zip(&*motions).map(turn).all(|turn| turn <= MOST_TURN)) {
                Some(taken) => {
                    steps += taken;
                    *motions = trial;
                    at = next;
                    part *= 2.0;
                }
                None => part *= 0.5,
            }
            if part < SMALLEST_PART * (to - from) {
                return Err(LatticeError::NoEquilibrium { converged_fraction: at / to });
            }
        }
        Ok(steps)
    }

    /// Newton's method from an initial guess. Returns the number of steps, or `None` if Newton's method does not converge to a stable equilibrium.
    fn converge(
        &self,
        motions: &mut [BodyMotion],
        loads: &[BodyLoad],
        factor: f64,
        elimination: &mut Option<Elimination>,
    ) -> Option<usize> {
        let mut largest = 0.0_f64;
        for step in 1..=MOST_STEPS {
            let expansion = self.expand(motions, loads, factor);
            if elimination.is_none() {
                *elimination = Elimination::of(self.count, &expansion.curvature);
            }
            let factorised = elimination.as_ref()?.factorised(&expansion.curvature)?;
            let mut correction: Vec<f64> = expansion.gradient.iter().map(|g| -g).collect();
            factorised.solve_in_place(MatMut::from_column_major_slice_mut(&mut correction, self.count, 1));
            let gain: f64 = correction.iter().zip(&expansion.gradient).map(|(c, g)| -c * g).sum();
            if !gain.is_finite() {
                return None;
            }
            for (motion, first) in motions.iter_mut().zip(&self.unknowns) {
                if let Some(i) = *first {
                    motion.displacement += Vector::new(correction[i], correction[i + 1]);
                    motion.rotation += correction[i + 2];
                }
            }
            largest = largest.max(gain);
            if gain <= CONVERGED * largest {
                return Some(step);
            }
        }
        None
    }
}
