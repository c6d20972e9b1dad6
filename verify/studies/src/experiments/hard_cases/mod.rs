//! Hard cases: fingers, loads, measurements and inputs at the limits of computation, each with an expected outcome.
//!
//! No expectation relies on the solver itself. Each expectation is a scaling law, another solution method, an energy balance, equilibrium of the
//! reactions, a limit with known solution, or a refusal. All cases are variants of one finger.

mod fingers;
mod input;
mod loads;
mod sensing;
pub mod soundness;

use crate::check::EXACT_COUNT;
use crate::experiments::{Context, Evidence};
use crate::prelude::*;
use std::convert::Infallible;

/// A case fails if its computation takes longer than this, s.
pub const TIME_LIMIT_S: f64 = 5.0;

/// A hard case with its results.
#[derive(Debug, Clone, PartialEq)]
pub struct HardCase {
    /// Name of the case.
    pub case: &'static str,
    /// Reason why the case is hard.
    pub difficulty: &'static str,
    /// Expected outcome.
    pub expectation: &'static str,
    /// Results that figures cannot express, in words.
    pub notes: Vec<String>,
    /// Results as checks with tolerances.
    pub checks: Vec<Check>,
    /// Computation time, s.
    pub seconds: f64,
}

impl HardCase {
    /// Whether every check passes within the time limit.
    pub fn passes(&self) -> bool {
        self.seconds <= TIME_LIMIT_S && self.checks.iter().all(Check::passes)
    }
}

/// A hard case before its computation.
pub struct Question {
    /// Name of the case.
    pub case: &'static str,
    /// Reason why the case is hard.
    pub difficulty: &'static str,
    /// Expected outcome.
    pub expectation: &'static str,
    /// Computes the case and adds its results to the findings.
    pub answer: fn(&Finger, Effort, &mut Findings) -> Result<(), Unexpected>,
}

/// Unexpected error that ends a case before its checks.
pub type Unexpected = Box<dyn std::error::Error>;

/// Collects the results of a hard case.
pub struct Findings {
    case: &'static str,
    notes: Vec<String>,
    checks: Vec<Check>,
}

impl Findings {
    fn note(&mut self, words: impl Into<String>) {
        self.notes.push(words.into());
    }

    /// Adds an internal check: a comparison with another solution method or with a law that solutions obey, or a count of refusals.
    fn check(&mut self, source: &str, quantity: &str, reference: f64, ours: f64, tolerance: f64) {
        self.checks.push(Check::new(Kind::Internal, self.case, source, quantity, reference, ours, tolerance));
    }

    fn vanishes(&mut self, source: &str, quantity: &str, ours: f64, tolerance: f64) {
        self.check(source, quantity, 0.0, ours, tolerance);
    }

    fn counts(&mut self, source: &str, quantity: &str, reference: usize, ours: usize) {
        self.check(source, quantity, reference as f64, ours as f64, EXACT_COUNT);
    }
}

impl Evidence for HardCase {}

/// All hard cases; empty unless the finger is the paper's.
pub(crate) fn run(context: &Context) -> Result<Vec<HardCase>, Infallible> {
    if !context.is_paper {
        return Ok(Vec::new());
    }
    context.progress.part("hard cases", questions().count());
    Ok(hard_cases(context.finger, context.effort, &|| context.progress.step()))
}

/// Computes all hard cases; `progress` is called after each case.
pub fn hard_cases(finger: &Finger, effort: Effort, progress: &(dyn Fn() + Sync)) -> Vec<HardCase> {
    let questions: Vec<&Question> = questions().collect();
    let answer = |question: &&Question| {
        let case = answered(question, finger, effort);
        progress();
        case
    };
    questions.par_iter().with_max_len(1).map(answer).collect()
}

fn questions() -> impl Iterator<Item = &'static Question> {
    [fingers::QUESTIONS, loads::QUESTIONS, sensing::QUESTIONS, input::QUESTIONS].into_iter().flatten()
}

fn middle(finger: &Finger) -> NodeId {
    let nodes: Vec<NodeId> = finger.contact_nodes().collect();
    nodes[nodes.len() / 2]
}

/// Computes one hard case. The case fails if an error ends it, or if it exceeds the time limit.
pub fn answered(question: &Question, finger: &Finger, effort: Effort) -> HardCase {
    let mut findings = Findings { case: question.case, notes: Vec::new(), checks: Vec::new() };
    let begin = Instant::now();
    if let Err(error) = (question.answer)(finger, effort, &mut findings) {
        findings.note(format!("Error: {error}."));
        findings.counts("the expectation", "errors where none was expected", 0, 1);
    }
    HardCase {
        case: question.case,
        difficulty: question.difficulty,
        expectation: question.expectation,
        notes: findings.notes,
        checks: findings.checks,
        seconds: begin.elapsed().as_secs_f64(),
    }
}
