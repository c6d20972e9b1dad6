//! The paper's sentences with their figures, one by one, against ours.
//!
//! What is said stands in `words.toml`; each file here computes the numbers and verdicts of a part of the paper.
//! Every verdict follows from a computed figure through a named [criterion](criteria), or says that nothing was tested. All of ours
//! are computed on models of the finger: a figure measured on the real one is reproduced or not, but never refuted by them.

pub mod camera;
pub mod criteria;
mod deformation;
pub mod experiments;
pub mod grasps;
pub mod gripper;
pub mod limits;
pub mod rate;
mod single_finger;
mod words;

use crate::prelude::*;
use crate::problems::ProblemError;
use crate::study::Study;
pub use words::Words;

/// Verdict on a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimVerdict {
    /// Our computation gives the same.
    Reproduced,
    /// Our computation, on a model of the finger, does not give what the paper measured.
    NotReproduced,
    /// Holds on a simulated finger: no experiment stands behind it.
    InSimulation,
    /// On a simulated finger whose model is known, sensing errs less than the paper measured on a real one.
    LessInSimulation,
    /// Another verdict under another assumption that the paper leaves open.
    Depends,
    /// A statement about the finger's mechanics that its model contradicts.
    Refuted,
    /// What it rests on is not published, or needs the finger itself.
    NotTested,
}

impl ClaimVerdict {
    /// All of them, in the order of tables.
    pub const ALL: [ClaimVerdict; 7] = {
        use ClaimVerdict::{Depends, InSimulation, LessInSimulation, NotReproduced, NotTested, Refuted, Reproduced};
        [Reproduced, NotReproduced, Refuted, Depends, InSimulation, LessInSimulation, NotTested]
    };

    /// In words, for tables.
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

/// One claim.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Claim {
    /// What the paper says, in its words where they stand in quotation marks, with the section.
    pub claim: String,
    /// Its figure.
    pub paper: String,
    /// Our figure.
    pub ours: String,
    /// How our value is computed.
    pub how: String,
    /// From which figure to which verdict; empty where nothing was tested.
    pub criterion: String,
    /// The verdict.
    pub verdict: ClaimVerdict,
}

/// Why a claim could not be tested.
#[derive(Debug, thiserror::Error)]
pub enum ClaimError {
    /// A load cannot be sensed.
    #[error(transparent)]
    Sensing(#[from] SensingError),
    /// A reference problem cannot be solved.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The words that ship are no table.
    #[error("words of the claims: {0}")]
    File(#[from] toml::de::Error),
    /// They lack a number.
    #[error("words of a claim: {0}")]
    Words(#[from] minijinja::Error),
}

/// All claims, tested against a study of the paper's finger; none against one of another.
///
/// # Errors
/// [`ClaimError`] if a small experiment behind one of them fails.
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
    claims.push(rate::sensing_rate(&study.speed_error, times, words)?);
    claims.extend(words.untested());
    Ok(claims)
}
