//! Settings of all experiments: effort, forces, noise and progress callbacks. This module uses no other module of this crate.

use finray_model::{Finger, Scene};

pub use finray_contact::press::LEAST_STATED_MM;
pub use finray_fixtures::CAMERA_NOISE_MM;

/// Range of forces on one contact node of the paper's finger, N (paper, sec. V-C). Below 0.5 N noise alone causes errors of several per cent.
pub const ONE_FORCE_N: [f64; 2] = [0.5, 3.0];
/// Range of forces on each of two contact nodes of the paper's finger, N (paper, sec. V-C).
pub const TWO_FORCES_N: [f64; 2] = [0.3, 3.0];
/// Frame time of the paper's camera at its largest rate of 25 Hz, s (sec. IV-B and VI). The paper's image processing alone takes one frame time.
pub const CAMERA_FRAME_S: f64 = 0.04;
/// A sensed force is trusted if its relative error is at most this value, dimensionless. The paper's Table I shades larger errors.
pub const TRUSTED_ERROR: f64 = 0.10;
/// A force counts as not sensed if its relative error exceeds this value, dimensionless. The paper's Table I shades errors above this value darker.
pub const GROSS_ERROR: f64 = 0.25;
pub use finray_model::sensor::TWO_SIDED_95;
/// An assumed direction is wrong by this angle to either side, degrees. The normal of the deformed plate turns by up to 12.5 degrees (paper, sec. V-C).
pub const DIRECTION_OFF_DEG: f64 = 12.5;
/// An assumed position is wrong by this distance to either side, mm. An object may touch anywhere around a rod, so the distance is the radius of the
/// paper's rods (sec. V-C).
pub const POSITION_OFF_MM: f64 = 1.5;
/// Largest coefficient of friction of objects, dimensionless; rubber on most surfaces has less. A force leans from the normal by at most its arctangent.
pub const FRICTION_MAX: f64 = 1.0;
/// Known range of the coefficient of friction if the scene states none, dimensionless: dry plastics and metals, which may slide to either side.
pub const KNOWN_FRICTION: [f64; 2] = [-0.5, 0.5];
/// Relative standard deviation of the modulus after `finray calibrate --weight` with one photograph, dimensionless: what forces of a known contact then
/// state on simulated photographs of printed fingers (`fixtures/printed/README.md`: 2.1 %).
pub const WEIGHED_MODULUS_SD: f64 = 0.02;
/// With at least this number of cases, the standard error of a mean error is about 2 % of the mean. A check of the mean error then needs no allowance
/// for sampling error.
pub const ENOUGH_CASES: usize = 4000;

/// Forces for which a report is computed, up to a largest force. The ratios of these forces are the same for every finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReportForces {
    drawn_n: f64,
}

impl ReportForces {
    /// Forces up to 3 N, the largest force of the paper's gripper experiments (sec. V-C).
    pub const PAPER: ReportForces = ReportForces::up_to(3.0);

    /// Forces up to `drawn_n` (N, positive and finite), the force at which maps are drawn.
    pub const fn up_to(drawn_n: f64) -> ReportForces {
        ReportForces { drawn_n }
    }

    /// Forces for studies that have fixed reference values: [`ReportForces::PAPER`] for the paper's finger, `self` for any other finger.
    pub fn checked(self, is_paper: bool) -> ReportForces {
        if is_paper { ReportForces::PAPER } else { self }
    }

    /// Force at which maps are drawn, N; the largest of [`of_maps_n`](ReportForces::of_maps_n).
    pub const fn drawn_n(self) -> f64 {
        self.drawn_n
    }

    /// Forces of the maps, N, ascending.
    pub fn of_maps_n(self) -> [f64; 4] {
        self.scaled([0.5, 1.0, 2.0, 3.0])
    }

    /// Force of studies that use a single force, N: half of the largest.
    pub fn half_n(self) -> f64 {
        0.5 * self.drawn_n
    }

    /// Scales forces chosen for the paper's finger (N) in proportion to the largest force. Scaled forces (N) are rounded to four significant digits.
    pub fn scaled<const N: usize>(self, papers_n: [f64; N]) -> [f64; N] {
        let largest_n = ReportForces::PAPER.drawn_n;
        let rounded = |force_n: f64| format!("{force_n:.3e}").parse().unwrap_or(force_n);
        papers_n.map(|paper_n| match self {
            ReportForces::PAPER => paper_n,
            _ if paper_n == largest_n => self.drawn_n,
            _ => rounded(paper_n * self.drawn_n / largest_n),
        })
    }
}

/// Whether a finger equals the paper's finger, for which reference values exist. The scene's name does not matter.
pub fn is_papers_finger(finger: &Finger) -> bool {
    Scene::from_toml(finray_fixtures::PAPER_SCENE).is_ok_and(|paper| paper.finger == *finger)
}

/// Progress callbacks: one at the start of each part, with its name and number of steps, and one after each step.
pub trait Progress: Sync {
    /// Called when a part begins; `steps` is the number of its steps.
    fn part(&self, name: &str, steps: usize);
    /// Called after each step of the current part.
    fn step(&self);
}

/// Amount of computation in a study: number of positions, directions, noise samples and cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Coarse maps, for a preview or a test.
    Quick,
    /// Fine maps.
    Full,
}

impl Effort {
    pub(crate) fn choose<T>(self, quick: T, full: T) -> T {
        match self {
            Effort::Quick => quick,
            Effort::Full => full,
        }
    }

    /// Number of random cases per set of contacts for the networks.
    pub(crate) fn sensed_cases(self) -> usize {
        self.choose(40, ENOUGH_CASES)
    }

    /// Resolution of a map: number of positions along the front plate, step of the directions (degrees), and number of noise samples per cell.
    pub(crate) fn resolution(self) -> (usize, f64, usize) {
        self.choose((24, 20.0, 100), (48, 5.0, 400))
    }

    /// A coarser [`resolution`](Effort::resolution) for slow estimators and for further true fingers. The cells of this coarse grid are also cells of
    /// the finer grid.
    pub(crate) fn coarse_resolution(self) -> (usize, f64, usize) {
        self.choose((12, 20.0, 4), (24, 10.0, 12))
    }

    /// Resolution of the maps of unknown contacts. With few samples, the mean error of a cell is within a limit by chance more often than with many, so
    /// that the trusted share would be larger; quick and full maps therefore have equally many samples, and differ in their grids alone.
    pub(crate) fn unknown_resolution(self) -> (usize, f64, usize) {
        self.choose((6, 20.0, 6), (24, 10.0, 6))
    }

    /// The [`coarse_resolution`](Effort::coarse_resolution) with larger steps of the directions, for shapes that take milliseconds; the largest steps
    /// for an estimator that searches.
    pub(crate) fn lattice_resolution(self, searches: bool) -> (usize, f64, usize) {
        let (positions, _, samples) = self.coarse_resolution();
        match searches {
            true => (12, self.choose(80.0, 20.0), samples),
            false => (positions, self.choose(40.0, 20.0), samples),
        }
    }

    /// The [`coarse_resolution`](Effort::coarse_resolution) with fewer noise samples, for shapes that the nonlinear estimator's model cannot represent.
    pub(crate) fn few_samples(self) -> (usize, f64, usize) {
        let (positions, step_deg, _) = self.coarse_resolution();
        (positions, step_deg, self.choose(1, 4))
    }
}
