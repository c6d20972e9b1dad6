//! Lean: the angle between a contact force and the normal, due to friction; and measured normals.

/// Lean (angle between a contact force and the inward normal due to friction), with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lean {
    /// Mean lean (angle between force and normal), in degrees, positive towards the tip. For a sliding object, the mean lean is the arctangent of the
    /// coefficient of friction.
    pub angle_deg: f64,
    /// Standard deviation of the lean, in degrees. Zero if the lean is known exactly.
    pub sd_deg: f64,
    /// Build-up force of friction, N: at a force f, the mean lean is `angle_deg` (1 - exp(-f / `build_up_n`)). Zero if the lean does not depend on
    /// the force.
    pub build_up_n: f64,
    /// Inward normal to which the lean refers.
    pub from: Normal,
}

/// Inward normal to which the lean of a force (the angle between force and normal) refers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normal {
    /// Normal of the deformed plate, averaged over a length of plate about the contact, for example the length that the object covers.
    Deformed {
        /// Length of plate over which the normal is averaged, in mm. If the length is zero, the normal at the contact itself is used.
        over_mm: f64,
    },
    /// Normal of the undeformed plate, which does not turn as the finger bends. The undeformed normal suits a finger that bends round the face of a
    /// fixed object.
    Undeformed,
    /// Normal of the object's outline at the contact.
    Object,
}

/// A measured normal of the surfaces in contact. The force deviates from it because of friction and of the error of the measurement: the tangent of
/// the angle between force and measured normal has a Gaussian prior with mean zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredNormal {
    /// Measured inward normal, in degrees from the undeformed inward normal, positive towards the tip.
    pub angle_deg: f64,
    /// Standard deviation of the measured normal, rad.
    pub sd_rad: f64,
    /// Upper bound of the coefficient of friction, dimensionless: tangent of the largest angle between force and true normal.
    pub friction: f64,
}

impl MeasuredNormal {
    /// Standard deviation of the tangent of the angle between force and measured normal, dimensionless, for one of `contacts` contacts of an object.
    /// Friction of a sliding object acts in the same direction at all k contacts. If the tangents at all k contacts equal the coefficient of friction,
    /// they are together one standard deviation from zero, so the standard deviation of each is the coefficient times sqrt(k).
    pub(super) fn tangent_sd(&self, contacts: usize) -> f64 {
        self.sd_rad.hypot(self.friction * (contacts as f64).sqrt())
    }
}

impl Lean {
    /// No friction: the force acts along the normal of the deformed plate.
    pub const NONE: Lean =
        Lean { angle_deg: 0.0, sd_deg: 0.0, build_up_n: 0.0, from: Normal::Deformed { over_mm: 0.0 } };

    /// Whether a force may deviate from the normal.
    pub fn has_friction(&self) -> bool {
        self.angle_deg != 0.0 || self.sd_deg != 0.0
    }

    /// Lean for a coefficient of friction and its standard deviation `sd`, both dimensionless. With a positive coefficient, the force leans towards the tip.
    pub fn of_friction(coefficient: f64, sd: f64) -> Lean {
        let sd_deg = (sd / (1.0 + coefficient * coefficient)).to_degrees();
        Lean { angle_deg: coefficient.atan().to_degrees(), sd_deg, ..Lean::NONE }
    }

    /// Lean between the friction angles of two coefficients of friction (dimensionless). All angles between the two friction angles are assumed
    /// equally likely.
    pub fn within(coefficients: [f64; 2]) -> Lean {
        let [from, to] = coefficients.map(|coefficient| coefficient.atan().to_degrees());
        Lean { angle_deg: 0.5 * (from + to), sd_deg: (to - from).abs() / 12.0_f64.sqrt(), ..Lean::NONE }
    }

    /// Mean lean (angle from the normal), in degrees, of a force of `force_n`, N.
    pub fn mean_deg(&self, force_n: f64) -> f64 {
        match self.build_up_n > 0.0 {
            true => -self.angle_deg * (-force_n.abs() / self.build_up_n).exp_m1(),
            false => self.angle_deg,
        }
    }
}
