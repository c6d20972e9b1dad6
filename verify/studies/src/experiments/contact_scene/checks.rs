//! Checks of contact scenes: balance and equilibrium of all scenes, and sensing of the shipped scenes.

use super::samples::NoiseSamples;
use super::study::SceneStudy;
use super::{FINENESS, VerifiedStep};
use crate::check::{Check, Kind, NEWTON_LATTICE, SETTLED_LATTICE, Subject, worst};
use finray_contact::Touch;
use finray_contact::press::{BALANCE_TOLERANCE, SceneStep};

const TRUE_FORCES: &str = "true forces";
const DISPLACEMENT: &str = "largest displacement difference / largest displacement";
/// Tolerance of a shape against the lattice's equilibrium under the contact forces, relative to the largest displacement, for [`FINENESS`] segments
/// between two rods. It covers the discretisation of the lattice, which decreases with the square of the number of segments. With two segments and a
/// force of 5 N, lattice and beams differ by 1.0e-3 for the box and 1.1e-3 for the disc.
const LATTICE_TOLERANCE: f64 = 1.3e-3 * (2 * 2) as f64 / (FINENESS * FINENESS) as f64;
/// Tolerance of a shape against the shape at rest in the physics engine rapier, relative to the largest displacement. Beside the discretisation of the
/// lattice, it covers the errors of the sweeps of rapier's solver and of rapier's criterion for rest.
const ENGINE_TOLERANCE: f64 = 5e-4 + LATTICE_TOLERANCE;
/// Tolerance of the sum of contact forces against the sum in the physics engine rapier, relative to the sum: as for the shape.
const ENGINE_FORCE_TOLERANCE: f64 = 2e-3 + LATTICE_TOLERANCE;
/// Tolerance of sensed totals without noise, relative to the total: the error of the estimator's mesh and of the press.
const SENSED_TOLERANCE: f64 = 5e-4;
/// With friction, a stated standard deviation may be at most this share of the force. A larger standard deviation would cover the error but provide
/// no information.
const LARGEST_SIGMA: f64 = 0.5;
/// Tolerance of the overlap of object and finger, mm. A larger overlap would mean that contacts yield.
const OVERLAP_TOLERANCE_MM: f64 = 1e-3;
/// Tolerance of a touch force beyond the friction cone, N; it allows for rounding.
const CONE_TOLERANCE_N: f64 = 1e-6;
/// Nominal coverage. The next constant, `SHIFT`, is the change of coverage caused by the difference between lattice and beams. The difference between
/// lattice and beams is less than half a standard deviation.
const MEANT: f64 = 0.95;
const SHIFT: f64 = 0.01;
/// Allowance for sampling error, in standard errors of a binomial share. `STANDARD_ERRORS` applies to the share over all samples of a scene, which
/// exceeds this allowance once in 370 cases. `WORST_STANDARD_ERRORS` applies to the smallest of some hundred shares, one per contact and step. The
/// share of one contact and step exceeds `WORST_STANDARD_ERRORS` once in 2000 cases.
const STANDARD_ERRORS: f64 = 3.0;
const WORST_STANDARD_ERRORS: f64 = 3.5;

/// Tolerance of the share of covered samples against [`MEANT`].
fn coverage_tolerance(samples: usize, standard_errors: f64) -> f64 {
    SHIFT + standard_errors * (MEANT * (1.0 - MEANT) / samples as f64).sqrt()
}

impl SceneStudy {
    /// Checks of any scene: balance, agreement with rapier, equilibrium, overlap, friction cone.
    pub fn checks(&self) -> Vec<Check> {
        let touching =
            || self.steps.iter().map(|studied| &studied.step).filter(|step| !step.pressed.touches.is_empty());
        if touching().next().is_none() {
            return Vec::new();
        }
        let over = |figure: &dyn Fn(&SceneStep) -> f64| worst(touching().map(figure));
        let at_clamps = over(&|step| {
            let force = step.pressed.contact_force();
            (force - step.pressed.base_force).norm() / force.norm()
        });
        let moment = over(&|step| {
            let off_nmm = step.pressed.base_moment_nmm - step.pressed.contact_moment_nmm();
            off_nmm.abs() / (step.pressed.contact_force().norm() * self.length_mm)
        });
        let overlap_mm = over(&|step| worst(step.pressed.touches.iter().map(|touch| touch.overlap_mm.abs())));
        let beyond_cone_n = over(&|step| worst(step.pressed.touches.iter().map(|touch| self.beyond_cone_n(touch))));
        let balance = |what: &str| self.on(Kind::Internal, what, "force balance");
        let mut checks = vec![
            balance("sum of contact forces against the force on the clamps")
                .vanishes("largest difference / force", at_clamps, BALANCE_TOLERANCE),
            balance("moment of contact forces against that on the clamps").vanishes(
                "largest difference / (force x length of the front plate)",
                moment,
                BALANCE_TOLERANCE,
            ),
            self.on(Kind::Internal, "no overlap and no gap at a contact", "geometry")
                .vanishes("largest overlap or gap, mm", overlap_mm, OVERLAP_TOLERANCE_MM),
            self.on(Kind::Internal, "forces within the cone of friction", "Coulomb").vanishes(
                "largest |tangential| - friction x normal, N",
                beyond_cone_n,
                CONE_TOLERANCE_N,
            ),
        ];
        checks.extend(self.engine_checks());
        checks
    }

    /// Checks of steps against rapier's state at rest, and against the equilibrium under the contact forces of the step.
    fn engine_checks(&self) -> Vec<Check> {
        // A finger without contact has no displacement to compare, and the lattice has contact on its plates alone.
        let is_compared = |step: &SceneStep| {
            !step.contacts.is_empty() && step.contacts.iter().all(|seen| seen.wall.plate().is_some())
        };
        let verified = self.verified.iter().zip(&self.steps).filter(|(_, studied)| is_compared(&studied.step));
        let verified: Vec<&VerifiedStep> = verified.map(|(step, _)| step).collect();
        if verified.is_empty() {
            return Vec::new();
        }
        let over = |figure: &dyn Fn(&VerifiedStep) -> Option<f64>| {
            worst(verified.iter().map(|step| figure(step).unwrap_or(f64::NAN)))
        };
        let shape = over(&|step| Some(step.engine?.shape));
        let force = over(&|step| Some(step.engine?.force));
        let equilibrium = over(&|step| step.equilibrium);
        let engine = |what: &str| self.on(Kind::Internal, what, SETTLED_LATTICE);
        let newton =
            self.on(Kind::Internal, "shape against the lattice's equilibrium under the contact forces", NEWTON_LATTICE);
        let mut checks = vec![newton.vanishes(DISPLACEMENT, equilibrium, LATTICE_TOLERANCE)];
        // With friction, the state of rest is not unique: it depends on the last micrometres of the path, in which lattice and beams differ.
        if self.friction == 0.0 {
            checks.push(
                engine("shape against that in which rapier's lattice, beginning near it, comes to rest")
                    .vanishes(DISPLACEMENT, shape, ENGINE_TOLERANCE),
            );
            checks.push(
                engine("sum of contact forces against that of rapier")
                    .vanishes("largest difference / force", force, ENGINE_FORCE_TOLERANCE),
            );
        }
        checks
    }

    fn on(&self, kind: Kind, what: &str, source: &str) -> Subject {
        kind.on(format!("{} pressed onto the finger: {what}", self.name), source)
    }

    /// Subject of the checks that compare sensed forces with the true forces.
    fn sensed(&self, what: &str) -> Subject {
        self.on(Kind::Internal, what, TRUE_FORCES)
    }

    /// Checks of a shipped scene: the checks of any scene, completion of all steps, sensing without noise,
    /// and coverage of intervals.
    pub fn shipped_checks(&self) -> Vec<Check> {
        let mut checks = self.checks();
        let stopped = usize::from(self.stopped.is_some());
        checks.push(self.on(Kind::Internal, "goes to its end", "itself").counts("scenes that ended early", 0, stopped));
        if self.friction == 0.0 {
            let clean = self.steps.iter().filter_map(|studied| studied.clean.as_ref().ok()?.as_ref());
            let total = worst(clean.map(|sensed| sensed.total.relative_error().abs()));
            let check = self.sensed("sensed total, without noise");
            checks.push(check.vanishes("largest |sensed / true - 1|", total, SENSED_TOLERANCE));
        }
        let refused = self.steps.iter().filter(|studied| {
            let felt = studied.step.contacts.iter().any(|contact| !contact.clamped);
            felt && !matches!(studied.clean, Ok(Some(_)))
        });
        let check = self.sensed("steps that sensing refuses, without noise");
        checks.push(check.counts("count", 0, refused.count()));
        checks.extend(self.coverage_checks());
        checks
    }

    /// Checks of coverage over all samples, contacts and totals of a scene, and of the worst contact of a step. Refused samples count as not covered.
    /// With friction, the stated intervals include the worst case in the friction cone, so coverage may exceed the nominal coverage.
    fn coverage_checks(&self) -> Vec<Check> {
        let sampled: Vec<&NoiseSamples> = self.steps.iter().filter_map(|studied| studied.samples.as_ref()).collect();
        if sampled.is_empty() {
            return Vec::new();
        }
        let (mut checks, noise) = (Vec::new(), format!("{} mm noise", self.noise_mm));
        for (what, totals) in [("every contact's force", false), ("the total", true)] {
            let cells = sampled.iter().flat_map(|samples| {
                let last = samples.sensed.len() - 1;
                let which = if totals { last..last + 1 } else { 0..last };
                which.map(move |which| (samples, which))
            });
            let (mut covered, mut taken, mut least) = (0, 0, f64::INFINITY);
            for (samples, which) in cells {
                covered += samples.covered(which);
                taken += samples.taken;
                least = least.min(samples.coverage(which));
            }
            let share = covered as f64 / taken as f64;
            // Contacts of one sample share its noise; only samples are independent.
            let independent = sampled.iter().map(|samples| samples.taken).sum();
            let tolerance = coverage_tolerance(independent, STANDARD_ERRORS);
            let problem = format!("{what}, {noise}: within 1.96 stated sigma");
            let quantity = format!("share over {taken} noise samples of contacts and steps (refused: outside)");
            checks.push(if self.friction > 0.0 {
                let quantity = format!("0.95 less the {quantity}, if positive");
                self.sensed(&problem).vanishes(quantity, (MEANT - share).max(0.0), tolerance)
            } else {
                self.sensed(&problem).is(quantity, MEANT, share, tolerance)
            });
            let fewest = sampled.iter().map(|samples| samples.taken).min().unwrap_or(1);
            let quantity = format!("0.95 less the share of {fewest} noise samples, if positive");
            let tolerance = coverage_tolerance(fewest, WORST_STANDARD_ERRORS);
            let check = self.sensed(&format!("{problem}, contact and step with the fewest"));
            checks.push(check.vanishes(quantity, (MEANT - least).max(0.0), tolerance));
        }
        if self.friction > 0.0 {
            let shares = sampled.iter().flat_map(|samples| {
                let contacts = 0..samples.sensed.len() - 1;
                contacts.map(|which| {
                    let true_n = samples.sensed[which].first().map_or(f64::NAN, |force| force.true_n);
                    samples.rms_sigma_n(which) / true_n
                })
            });
            let check = self.sensed(&format!("every contact's force, {noise}: stated sigma"));
            checks.push(check.vanishes("largest stated sigma / true force", worst(shares), LARGEST_SIGMA));
        }
        checks
    }

    fn beyond_cone_n(&self, touch: &Touch) -> f64 {
        let normal_n = touch.force.dot(&touch.normal);
        let tangential_n = (touch.force - touch.normal * normal_n).norm();
        (tangential_n - self.friction * normal_n).max(0.0)
    }
}
