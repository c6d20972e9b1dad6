//! Claims: statements and numbers of the paper (Xu et al. 2021), compared one by one with computed numbers.
//!
//! The texts are in `words.toml`; each file here computes the numbers and verdicts for a part of the paper. A verdict follows from a computed number
//! by a named [criterion](criteria), or states that nothing was tested. Every computed number comes from a model of the finger. A number computed on
//! a model can reproduce a measured error or differ from it, but cannot refute the measurement.

pub mod camera;
pub mod criteria;
pub mod deformation;
pub mod experiments;
pub mod grasps;
pub mod gripper;
pub mod limits;
mod single_finger;
mod words;

use crate::prelude::*;
use crate::problems::ProblemError;
use crate::study::Study;
pub use words::Words;

/// Verdict on a claim of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimVerdict {
    /// The computation gives the same result.
    Reproduced,
    /// The computation, on a model of the finger, does not give the paper's measured figure.
    NotReproduced,
    /// The claim holds on a simulated finger; no experiment supports it.
    InSimulation,
    /// The error on a simulated finger whose model is known is smaller than the paper's error on a real finger.
    LessInSimulation,
    /// The verdict depends on an assumption that the paper does not state.
    Depends,
    /// The model contradicts a statement about the finger's mechanics.
    Refuted,
    /// The claim depends on unpublished information, or on the real finger.
    NotTested,
}

impl ClaimVerdict {
    /// All verdicts, in the order in which tables list them.
    pub const ALL: [ClaimVerdict; 7] = {
        use ClaimVerdict::{Depends, InSimulation, LessInSimulation, NotReproduced, NotTested, Refuted, Reproduced};
        [Reproduced, NotReproduced, Refuted, Depends, InSimulation, LessInSimulation, NotTested]
    };

    /// Verdict in words, for tables.
    pub fn in_words(self) -> &'static str {
        match self {
            ClaimVerdict::Reproduced => "reproduced",
            ClaimVerdict::NotReproduced => "not reproduced",
            ClaimVerdict::InSimulation => "in simulation",
            ClaimVerdict::LessInSimulation => "less error in simulation",
            ClaimVerdict::Depends => "depends on assumption",
            ClaimVerdict::Refuted => "refuted",
            ClaimVerdict::NotTested => "not tested",
        }
    }
}

/// A claim of the paper, with its test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// The paper's statement with its section. Quotation marks enclose verbatim text.
    pub claim: String,
    /// Value that the paper states, with its unit.
    pub paper: String,
    /// Computed figure, with its unit.
    pub ours: String,
    /// Method by which the value is computed.
    pub how: String,
    /// Criterion by which the computed value leads to the verdict; empty if nothing was tested.
    pub criterion: String,
    /// Verdict on the paper's statement.
    pub verdict: ClaimVerdict,
}

/// Why a claim could not be tested.
#[derive(Debug, thiserror::Error)]
pub enum ClaimError {
    /// A force cannot be sensed.
    #[error(transparent)]
    Sensing(#[from] SensingError),
    /// A reference problem cannot be solved.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The shipped texts are not valid TOML.
    #[error("cannot read the texts of the claims: {0}")]
    File(#[from] toml::de::Error),
    /// A placeholder in a claim's text has no value.
    #[error("cannot complete the text of a claim: {0}")]
    Words(#[from] minijinja::Error),
}

/// All claims, tested against a study of the paper's finger; empty for any other finger.
///
/// # Errors
/// [`ClaimError`] if a computation behind a claim fails.
pub fn ledger(study: &Study) -> Result<Vec<Claim>, ClaimError> {
    if !study.is_paper {
        return Ok(Vec::new());
    }
    let words = &Words::shipped()?;
    let mut claims = deformation::claims(study, words)?;
    claims.extend(single_finger::claims(study, words)?);
    claims.extend(gripper::claims(study, words)?);
    claims.extend(grasps::claims(study, words)?);
    claims.extend(limits::claims(study, words)?);
    claims.push(camera::position_error(study.camera.as_ref(), words)?);
    let times = study.camera.as_ref().and_then(|camera| camera.times);
    claims.push(camera::sensing_rate(&study.speed_error, times, words)?);
    claims.extend(words.untested());
    Ok(claims)
}
