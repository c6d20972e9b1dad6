//! Uncertainty of the thicknesses of the members.

use super::{Finger, FingerDescription, Part, percent};
use std::fmt;

/// Parts whose thicknesses have independent errors, in the order of all lists of three numbers here.
const PARTS: [Part; 3] = [Part::Front, Part::Back, Part::Ribs];

/// Errors of the thicknesses of front plate, back plate and ribs: three independent factors, each common to the whole part.
///
/// A bending rigidity changes with the cube of its thickness. Thicknesses therefore change the shape of the bent finger, unlike a factor on all moduli.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ThicknessError {
    /// Relative standard deviation of each of the three factors, dimensionless. Zero for exact thicknesses.
    pub sd: f64,
    /// Relative change of the calibrated moduli per relative change of the thickness of `[front, back, ribs]`, dimensionless: with thicker members, the
    /// loads of the calibration give smaller moduli. Zero for moduli that are known otherwise.
    pub modulus_slopes: [f64; 3],
}

/// Difference of a finger's thicknesses and moduli from the scene's, relative and to first order. The changed finger is the one whose compliances, and
/// therefore displacements, are linear in these numbers: its thicknesses are larger by the factor (1 - 3 x)^(-1/3), its moduli by 1 / (1 - x).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StiffnessChange {
    /// Relative changes of the thicknesses of `[front, back, ribs]`, dimensionless, below 1/3.
    pub thicknesses: [f64; 3],
    /// Relative change of all moduli, dimensionless, below 1.
    pub moduli: f64,
}

impl ThicknessError {
    /// The independent changes by one standard deviation. Empty for exact thicknesses; without a change of ribs that have no thickness.
    pub fn changes(&self, finger: &Finger) -> impl Iterator<Item = StiffnessChange> {
        let &ThicknessError { sd, modulus_slopes } = self;
        let has_thickness = PARTS.map(|part| part != Part::Ribs || finger.description().ribs.strip.is_some());
        (0..PARTS.len()).filter(move |i| sd > 0.0 && has_thickness[*i]).map(move |i| {
            let mut change = StiffnessChange { moduli: sd * modulus_slopes[i], ..StiffnessChange::default() };
            change.thicknesses[i] = sd;
            change
        })
    }

    /// These errors for moduli that are calibrated by `modulus`, which fits the factor on all moduli of a finger to the loads.
    ///
    /// # Errors
    /// The error of `modulus`.
    pub fn calibrated<E>(
        self,
        finger: &Finger,
        modulus: impl Fn(&Finger) -> Result<f64, E>,
    ) -> Result<ThicknessError, E> {
        let free = ThicknessError { modulus_slopes: [0.0; 3], ..self };
        let mut calibrated = free;
        let mut of_scene = None;
        for change in free.changes(finger) {
            let mut description = finger.description().clone();
            change.apply(&mut description);
            // A corner that a thicker member fills leaves the modulus independent of this member.
            let Ok(thicker) = Finger::new(description) else { continue };
            let before = match of_scene {
                Some(factor) => factor,
                None => *of_scene.insert(modulus(finger)?),
            };
            let slope = (1.0 - before / modulus(&thicker)?) / self.sd;
            let changed = calibrated.modulus_slopes.iter_mut().zip(change.thicknesses);
            changed.filter(|(_, by)| *by != 0.0).for_each(|(of_part, _)| *of_part = slope);
        }
        Ok(calibrated)
    }
}

impl StiffnessChange {
    /// This change `times` times.
    pub(crate) fn times(self, times: f64) -> StiffnessChange {
        StiffnessChange { thicknesses: self.thicknesses.map(|by| times * by), moduli: times * self.moduli }
    }

    /// Changes a description.
    pub(crate) fn apply(&self, description: &mut FingerDescription) {
        description.multiply_moduli(1.0 / (1.0 - self.moduli));
        for (part, by) in PARTS.into_iter().zip(self.thicknesses) {
            description.multiply_thickness(part, (1.0 - 3.0 * by).cbrt().recip());
        }
    }
}

/// The standard deviation and what it is of, in words.
impl fmt::Display for ThicknessError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "errors of {} % in the thicknesses of plates and ribs", percent(self.sd))
    }
}
