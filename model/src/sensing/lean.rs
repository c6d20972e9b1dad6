//! Lean of a contact force from the plate's normal due to friction.

/// Lean of a contact force from the inward normal due to friction, with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lean {
    /// Mean lean, degrees, positive towards the tip: the arctangent of the coefficient of friction if the object slides.
    pub angle_deg: f64,
    /// Standard deviation of the lean, degrees. Zero: the lean is not an unknown.
    pub sd_deg: f64,
    /// Force over which friction builds up, N: at a force f the mean lean is `angle_deg` (1 - exp(-f / `build_up_n`)). Zero: at once.
    pub build_up_n: f64,
    /// Normal from which the force leans.
    pub from: Normal,
}

/// Inward normal from which a force leans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normal {
    /// Normal of the deformed plate, averaged over a length about the contact, such as the object covers. Zero: at the contact alone.
    Deformed {
        /// Length of the average, mm.
        over_mm: f64,
    },
    /// Normal of the undeformed plate: the face of a fixed object round which the finger bends.
    Undeformed,
    /// Normal of the object's outline at the contact.
    Object,
}

impl Lean {
    /// No friction: the force acts along the normal of the deformed plate.
    pub const NONE: Lean =
        Lean { angle_deg: 0.0, sd_deg: 0.0, build_up_n: 0.0, from: Normal::Deformed { over_mm: 0.0 } };

    /// Lean for a coefficient of friction, positive if the force leans towards the tip, and its standard deviation, both dimensionless.
    pub fn of_friction(coefficient: f64, sd: f64) -> Lean {
        let sd_deg = (sd / (1.0 + coefficient * coefficient)).to_degrees();
        Lean { angle_deg: coefficient.atan().to_degrees(), sd_deg, ..Lean::NONE }
    }

    /// Lean within a friction cone. All angles between those of two coefficients are equally likely.
    pub fn within(coefficients: [f64; 2]) -> Lean {
        let [from, to] = coefficients.map(|coefficient| coefficient.atan().to_degrees());
        Lean { angle_deg: 0.5 * (from + to), sd_deg: (to - from).abs() / 12.0_f64.sqrt(), ..Lean::NONE }
    }

    /// Mean lean of a force of `force_n`, N, in degrees.
    pub fn mean_deg(&self, force_n: f64) -> f64 {
        match self.build_up_n > 0.0 {
            true => -self.angle_deg * (-force_n.abs() / self.build_up_n).exp_m1(),
            false => self.angle_deg,
        }
    }
}
