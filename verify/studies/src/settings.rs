//! Settings of all experiments: effort, forces, noise and progress callbacks. Depends on no other module.

use finray_model::{Finger, Scene};

pub use finray_fixtures::CAMERA_NOISE_MM;

/// Standard deviation that estimators are given without noise, mm: a mesh's errors of micrometres would be wild markers.
pub const LEAST_STATED_MM: f64 = 0.01;
/// Forces on one contact node of the paper's finger, N (sec. V-C of the paper; below 0.5 N the noise alone is worth several percent).
pub const ONE_FORCE_N: [f64; 2] = [0.5, 3.0];
/// Forces on each of two contact nodes of the paper's finger, N (sec. V-C of the paper).
pub const TWO_FORCES_N: [f64; 2] = [0.3, 3.0];
/// Time of one frame of the paper's camera at 25 Hz, s.
pub const CAMERA_FRAME_S: f64 = 0.04;
/// Errors up to here are trusted: the lighter of the two shades of the paper's Table I begins there.
pub const TRUSTED_ERROR: f64 = 0.10;
/// Errors above are as good as none sensed: the darker shade of that table.
pub const GROSS_ERROR: f64 = 0.25;
pub use finray_model::sensor::TWO_SIDED_95;
/// From this many cases on a mean error is known well enough (to 2 %) to be held to its tolerance alone.
pub const ENOUGH_CASES: usize = 4000;
/// Directions assumed for the paper's "vertical" weights, deg; 10.9 = asin(29 / 153) where the finger's axis lies level.
pub const TABLE_ONE_ANGLES_DEG: [f64; 5] = [0.0, 10.9, -20.0, 20.0, 40.0];

/// Forces of a report, all in the ratios that they have for the paper's finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReportForces {
    drawn_n: f64,
}

impl ReportForces {
    /// Up to the largest force of the paper's gripper experiments (sec. V-C).
    pub const PAPER: ReportForces = ReportForces::up_to(3.0);

    /// Forces up to one (N, positive and finite), at which maps are drawn.
    pub const fn up_to(drawn_n: f64) -> ReportForces {
        ReportForces { drawn_n }
    }

    /// Forces of studies whose checks and claims hold for fixed ones: the paper's for its finger, these for another.
    pub fn checked(self, is_paper: bool) -> ReportForces {
        if is_paper { ReportForces::PAPER } else { self }
    }

    /// The force at which maps are drawn, N.
    pub const fn drawn_n(self) -> f64 {
        self.drawn_n
    }

    /// Forces of the maps, N, growing.
    pub fn of_maps_n(self) -> [f64; 4] {
        self.scaled([0.5, 1.0, 2.0, 3.0])
    }

    /// The force of studies with a single one, N: the middle of the range.
    pub fn half_n(self) -> f64 {
        0.5 * self.drawn_n
    }

    /// Forces for the paper's finger, N, in these ratios to the drawn one; those that change are rounded to four digits.
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

/// Whether a finger is the paper's, for which reference values exist, whatever its scene calls itself.
pub fn is_papers_finger(finger: &Finger) -> bool {
    Scene::from_toml(finray_fixtures::PAPER_SCENE).is_ok_and(|paper| paper.finger == *finger)
}

/// Callbacks of progress: a stage starts with its name and step count, and each step is done.
pub trait Progress: Sync {
    /// A part begins.
    fn part(&self, name: &str, steps: usize);
    /// One step of the part is done.
    fn step(&self);
}

/// Effort: how much is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Coarse maps, for a look or a test.
    Quick,
    /// Fine maps.
    Full,
}

impl Effort {
    /// One of two, by how much is computed.
    pub(crate) fn choose<T>(self, quick: T, full: T) -> T {
        match self {
            Effort::Quick => quick,
            Effort::Full => full,
        }
    }

    /// Random cases for each set of contacts of Table II and of the networks.
    pub(crate) fn sensed_cases(self) -> [usize; 2] {
        self.choose([40, 40], [ENOUGH_CASES; 2])
    }

    /// Noise samples for each set of contacts and model of the displacements' noise.
    pub(crate) fn displacement_noise_cases(self) -> usize {
        self.choose(20, 200)
    }

    /// Positions along the front plate, degrees between two directions and noise samples a cell, for which stated intervals are
    /// compared with the truth: 720 samples, or 12 960, of which a share of 95 % is known to 0.8 or 0.2 %.
    pub(crate) fn covered_cells(self) -> (usize, f64, usize) {
        self.choose((17, 40.0, 3), (60, 20.0, 6))
    }

    /// Noise samples a force at each contact node, for the networks.
    pub(crate) fn covered_at_nodes(self) -> usize {
        self.choose(20, 100)
    }

    /// Nodes at which forces are sensed from images, at most, and conditions of the camera.
    pub(crate) fn camera(self) -> (usize, usize) {
        self.choose((2, 9), (6, usize::MAX))
    }

    /// Calibrations of the digital twin, forces a node that are sensed on it, and sets of zones that are fitted.
    pub(crate) fn twin(self) -> [usize; 3] {
        self.choose([3, 40, 1], [10, 400, usize::MAX])
    }

    /// Positions along the front plate, degrees between two directions, and noise samples a cell.
    pub(crate) fn resolution(self) -> (usize, f64, usize) {
        self.choose((24, 20.0, 100), (48, 5.0, 400))
    }

    /// The same where answers cost much or maps differ widely; all are also of [`resolution`](Effort::resolution).
    pub(crate) fn coarse_resolution(self) -> (usize, f64, usize) {
        self.choose((12, 40.0, 4), (24, 10.0, 12))
    }

    /// Positions along the front plate and degrees between two directions where contacts are only assumed.
    pub(crate) fn assumed_contacts(self) -> (usize, f64) {
        self.choose((6, 40.0), (24, 20.0))
    }

    /// The same for maps of shapes that the nonlinear estimator's model cannot take.
    pub(crate) fn coarsest_resolution(self) -> (usize, f64, usize) {
        self.choose((6, 40.0, 1), (24, 20.0, 4))
    }
}
