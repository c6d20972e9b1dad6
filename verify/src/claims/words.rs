//! The words of all claims, apart from what is computed: templates for its numbers.

use super::{Claim, ClaimError, ClaimVerdict};
use minijinja::{Environment, UndefinedBehavior, Value};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The words that ship, one table a claim.
pub struct Words {
    templates: Environment<'static>,
    untested: Vec<Untested>,
}

#[derive(Deserialize)]
struct File {
    fitted: String,
    untested: Vec<Untested>,
    #[serde(flatten)]
    claims: BTreeMap<String, BTreeMap<String, String>>,
}

#[derive(Deserialize)]
struct Untested {
    claim: String,
    paper: String,
    how: String,
}

impl Words {
    /// Reads them.
    ///
    /// # Errors
    /// [`ClaimError`] if they are no templates.
    pub fn shipped() -> Result<Words, ClaimError> {
        let File { fitted, untested, claims } = toml::from_str(include_str!("words.toml"))?;
        let mut templates = Environment::new();
        templates.set_undefined_behavior(UndefinedBehavior::Strict);
        templates.add_filter("percent", percent);
        templates.add_filter("newtons", |force_n: f64| format!("{force_n:.2} N"));
        templates.add_filter("fixed", |value: f64, decimals: usize| format!("{value:.decimals$}"));
        templates.add_filter("plain", |value: f64| value.to_string());
        templates.add_template_owned("fitted", fitted)?;
        for (key, parts) in claims {
            let unsaid = [("paper", "no figure"), ("criterion", "")].map(|(part, text)| (part.into(), text.into()));
            for (part, text) in BTreeMap::from(unsaid).into_iter().chain(parts) {
                templates.add_template_owned(format!("{key}.{part}"), text)?;
            }
        }
        Ok(Words { templates, untested })
    }

    /// A claim with its numbers.
    ///
    /// # Errors
    /// [`ClaimError`] if there is no such claim, or it needs other numbers.
    pub fn claim(&self, key: &str, verdict: ClaimVerdict, numbers: Value) -> Result<Claim, ClaimError> {
        let part = |part: &str| self.templates.get_template(&format!("{key}.{part}"))?.render(&numbers);
        Ok(Claim {
            claim: part("claim")?,
            paper: part("paper")?,
            ours: part("ours")?,
            how: part("how")?,
            criterion: part("criterion")?,
            verdict,
        })
    }

    /// Figures of the paper that nothing here can test.
    pub(super) fn untested(&self) -> impl Iterator<Item = Claim> {
        self.untested.iter().map(|Untested { claim, paper, how }| Claim {
            claim: claim.clone(),
            paper: paper.clone(),
            ours: "-".to_owned(),
            how: how.clone(),
            criterion: String::new(),
            verdict: ClaimVerdict::NotTested,
        })
    }
}

/// A share in percent.
pub(super) fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        0.0 => "0 %".to_owned(),
        p if p < 0.01 => format!("{:.0e} %", 100.0 * share),
        p if p < 1.0 => format!("{:.2} %", 100.0 * share),
        _ => format!("{:.1} %", 100.0 * share),
    }
}
