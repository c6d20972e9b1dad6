//! Assumptions of the beam model that an equilibrium violates, and a description of each in words.

use super::{FibreStrain, FingerMember, LARGEST_SHEAR_SHARE, LARGEST_STRAIN, StrainLimits, Validity};
use crate::finger::Part;
use std::fmt;

/// A violated assumption of the beam model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ValidityWarning {
    /// A strain exceeds its limit.
    Strain {
        /// The strain with the largest ratio to its limit.
        strain: FibreStrain,
        /// The limit, dimensionless.
        limit: f64,
        /// Whether the scene states the limit; otherwise the limit is the default.
        stated: bool,
    },
    /// Shear, which Euler-Bernoulli beams neglect, is significant.
    Shear {
        /// Shear energy divided by strain energy, dimensionless.
        share: f64,
        /// Member with the largest shear energy.
        member: FingerMember,
    },
    /// The finger bends more easily out of its plane than in it.
    OutOfPlane {
        /// Out-of-plane depth divided by the thickness of the thickest element, dimensionless.
        depth_ratio: f64,
    },
}

impl Validity {
    /// The assumptions that this equilibrium violates, given the strain limits of the materials.
    pub fn warnings(&self, limits: &StrainLimits) -> Vec<ValidityWarning> {
        let strain = self.largest_strain(limits).and_then(|strain| {
            let part = strain.member.part;
            let limit = limits.of(part);
            // With this comparison, a NaN strain does not count as small.
            let small = strain.strain <= limit;
            (!small).then(|| ValidityWarning::Strain { strain: *strain, limit, stated: limits.stated(part).is_some() })
        });
        let shear = self.shear_at.filter(|_| self.shear_share > LARGEST_SHEAR_SHARE);
        let shear = shear.map(|member| ValidityWarning::Shear { share: self.shear_share, member });
        // A strip with equal depth and thickness is equally stiff in and out of the plane.
        let flat = (self.depth_ratio < 1.0).then_some(ValidityWarning::OutOfPlane { depth_ratio: self.depth_ratio });
        strain.into_iter().chain(shear).chain(flat).collect()
    }
}

impl fmt::Display for FingerMember {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = in_words(self.part);
        let [from, to] = self.nodes;
        write!(f, "the {part} between nodes {from} and {to} (length / thickness {:.1})", self.slenderness)
    }
}

impl fmt::Display for FibreStrain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = if self.member.part == Part::Ribs { "from the back plate" } else { "from the base" };
        write!(f, "{} % at {:.1} mm {from} in {}", percent(self.strain), self.at_mm, self.member)
    }
}

impl fmt::Display for ValidityWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ValidityWarning::Strain { strain, limit, stated } => {
                write!(f, "strains are not small: {strain}, above the limit of {} % ", percent(*limit))?;
                let key = format!("finger.{}.largest_strain", key(strain.member.part));
                if *stated {
                    write!(f, "({key} of the scene)")?;
                } else {
                    write!(
                        f,
                        "(at the limit, rubber in tension is {} % softer than at rest; {key} in the scene sets the \
                            material's own limit)",
                        percent(LARGEST_STRAIN)
                    )?;
                }
                f.write_str("; strains above the limit need a nonlinear material law")
            }
            ValidityWarning::Shear { share, member } => write!(
                f,
                "members are too thick for their length: shear, which Euler-Bernoulli beams neglect, increases the \
                    displacement of the loads by up to {} % (ratio of Timoshenko's shear energy to the strain energy; \
                    limit {} %), mostly in {member}; use Timoshenko beams (finger.shear_correction in the scene) or a \
                    solid model",
                percent(*share),
                percent(LARGEST_SHEAR_SHARE)
            ),
            ValidityWarning::OutOfPlane { depth_ratio } => write!(
                f,
                "depth over thickness is {depth_ratio:.2e}, below the limit of 1: the finger bends more easily out of its plane than in it and may \
                 buckle sideways, which a plane model cannot show"
            ),
        }
    }
}

fn key(part: Part) -> &'static str {
    match part {
        Part::Front => "front",
        Part::Back => "back",
        Part::Ribs => "ribs",
    }
}

fn in_words(part: Part) -> &'static str {
    match part {
        Part::Front => "front plate",
        Part::Back => "back plate",
        Part::Ribs => "rib",
    }
}

/// A share in per cent with at most three digits. More digits are not needed, because the limits are only approximate.
fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p >= 1000.0 => format!("{p:.1e}"),
        p if p >= 10.0 => format!("{p:.0}"),
        p => format!("{}", (p * 100.0).round() / 100.0),
    }
}
