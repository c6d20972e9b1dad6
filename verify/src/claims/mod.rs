//! The paper's sentences with their figures, one by one, against ours.
//!
//! Every verdict follows from a computed figure through a named [criterion](criteria), or says that nothing was tested. All of ours
//! are computed on models of the finger: a figure measured on the real one is reproduced or not, but never refuted by them.

pub mod camera;
pub mod criteria;
mod deformation;
pub mod experiments;
pub mod gripper;
pub mod limits;
mod rate;
mod single_finger;
mod untested;

use crate::problems::ProblemError;
use crate::study::Study;
use experiments::Range;
use finray_model::sensing::SensingError;
use serde::Serialize;

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
}

fn claim(
    claim: impl Into<String>,
    paper: impl Into<String>,
    ours: impl Into<String>,
    how: impl Into<String>,
    criterion: impl Into<String>,
    verdict: ClaimVerdict,
) -> Claim {
    Claim {
        claim: claim.into(),
        paper: paper.into(),
        ours: ours.into(),
        how: how.into(),
        criterion: criterion.into(),
        verdict,
    }
}

fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        0.0 => "0 %".to_owned(),
        p if p < 0.01 => format!("{:.0e} %", 100.0 * share),
        p if p < 1.0 => format!("{:.2} %", 100.0 * share),
        _ => format!("{:.1} %", 100.0 * share),
    }
}

fn newtons(force_n: f64) -> String {
    format!("{force_n:.2} N")
}

fn between([low, high]: Range, unit: impl Fn(f64) -> String) -> String {
    format!("{} to {}", unit(low), unit(high))
}

/// All claims, tested against a study of the paper's finger; none against one of another.
///
/// # Errors
/// [`ClaimError`] if a small experiment behind one of them fails.
pub fn ledger(study: &Study) -> Result<Vec<Claim>, ClaimError> {
    if !study.is_paper {
        return Ok(Vec::new());
    }
    let mut claims = deformation::claims(study)?;
    claims.extend(single_finger::claims(study));
    claims.extend(gripper::claims(study));
    claims.extend(limits::claims(study)?);
    claims.push(camera::position_error(study.camera.as_ref()));
    let times = study.camera.as_ref().and_then(|camera| camera.times);
    claims.push(rate::sensing_rate(&study.speed_error, times));
    claims.extend(untested::claims());
    Ok(claims)
}
