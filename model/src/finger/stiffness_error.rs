//! Uncertainty of moduli and depth, which scale every stiffness of a finger.

use super::{Finger, percent};
use std::fmt;

/// Largest Young's modulus of a plate that counts as plastic or rubber, MPa: between plastics without fibres (PLA: 3500) and structural metals
/// (magnesium: 45 000).
const STIFFEST_PLASTIC_MPA: f64 = 10_000.0;
/// Relative standard deviation of a plastic's modulus that was not measured on the finger, dimensionless. An assumption: what a builder knows from a
/// data sheet. No printed fingers were measured.
const OF_PLASTICS: f64 = 0.1;

/// Relative standard deviation of a factor on every stiffness of a finger, which all forces share: a finger whose moduli and depth are larger by a
/// factor has the same shape under forces that are larger by this factor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StiffnessError {
    /// Relative standard deviation of a factor on all moduli, dimensionless.
    pub modulus: f64,
    /// Whether `modulus` is the default for a plastic, because the scene states no value.
    pub is_assumed: bool,
    /// Relative standard deviation of the depth, dimensionless. Neglects the influence of the depth on free side faces.
    pub depth: f64,
}

impl StiffnessError {
    /// The error of a finger, given the relative standard deviation of its moduli and the standard deviation of its depth, mm, that its scene states.
    /// Without a value for the moduli, a finger whose beams describe a solid of plastic or rubber has the default of 10 %; others count as exact.
    pub fn of(finger: &Finger, modulus: Option<f64>, depth_sd_mm: f64) -> StiffnessError {
        let d = finger.description();
        let softest_mpa = d.front.youngs_modulus_mpa.min(d.back.youngs_modulus_mpa);
        let is_assumed = modulus.is_none() && finger.kind().is_solid() && softest_mpa < STIFFEST_PLASTIC_MPA;
        StiffnessError {
            modulus: modulus.unwrap_or(if is_assumed { OF_PLASTICS } else { 0.0 }),
            is_assumed,
            depth: depth_sd_mm / d.depth_mm,
        }
    }

    /// Relative standard deviation of all forces, dimensionless.
    pub fn share(&self) -> f64 {
        self.modulus.hypot(self.depth)
    }
}

/// The value and its parts in words, for instance "10.2 % (modulus, assumed: 10 %; depth: 2 %)".
impl fmt::Display for StiffnessError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let origin = if self.is_assumed { "assumed" } else { "stated" };
        write!(f, "{} % (modulus, {origin}: {} %", percent(self.share()), percent(self.modulus))?;
        if self.depth > 0.0 {
            write!(f, "; depth: {} %", percent(self.depth))?;
        }
        f.write_str(")")
    }
}
