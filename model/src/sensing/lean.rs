//! By how much friction turns a contact force, and from which normal.

/// By how much friction turns a contact force away from the inward normal, as far as that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lean {
    /// Its mean, degrees, positive towards the tip: the arctangent of the coefficient of friction where the object slides.
    pub angle_deg: f64,
    /// Its standard deviation, degrees; where that is zero the lean is no unknown.
    pub sd_deg: f64,
    /// Force over which friction builds up, N: at a force f the mean is angle (1 - exp(-f / build_up)). Zero: at once.
    pub build_up_n: f64,
    /// From which normal it leans.
    pub from: Normal,
}

/// The inward normal of a plate that bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normal {
    /// Of the deformed plate: the mean over a length of it about the contact, mm, such as the object covers; zero for the contact alone.
    Deformed {
        /// The length, mm.
        over_mm: f64,
    },
    /// Of the undeformed plate: the face of an object that stays where it is, against a finger that bends round it.
    Undeformed,
    /// Of the outline of the object that touches the plate, at the contact.
    Object,
}

impl Lean {
    /// No friction.
    pub const NONE: Lean =
        Lean { angle_deg: 0.0, sd_deg: 0.0, build_up_n: 0.0, from: Normal::Deformed { over_mm: 0.0 } };

    /// A coefficient of friction, positive where the force leans towards the tip, with its standard deviation.
    pub fn of_friction(coefficient: f64, sd: f64) -> Lean {
        let sd_deg = (sd / (1.0 + coefficient * coefficient)).to_degrees();
        Lean { angle_deg: coefficient.atan().to_degrees(), sd_deg, ..Lean::NONE }
    }

    /// A force anywhere in a friction cone: coefficients between two limits, each as likely as the others.
    pub fn within(coefficients: [f64; 2]) -> Lean {
        let [from, to] = coefficients.map(|coefficient| coefficient.atan().to_degrees());
        Lean { angle_deg: 0.5 * (from + to), sd_deg: (to - from).abs() / 12.0_f64.sqrt(), ..Lean::NONE }
    }

    /// Mean lean of a force, degrees.
    pub fn mean_deg(&self, force_n: f64) -> f64 {
        match self.build_up_n > 0.0 {
            true => -self.angle_deg * (-force_n.abs() / self.build_up_n).exp_m1(),
            false => self.angle_deg,
        }
    }
}
