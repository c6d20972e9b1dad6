//! Texts of all claims: templates into which the computed numbers are inserted.

use super::{Claim, ClaimError, ClaimVerdict};
use minijinja::{Environment, UndefinedBehavior, Value};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Shipped texts of the claims, one table for each claim.
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
    /// Reads the shipped texts.
    ///
    /// # Errors
    /// [`ClaimError`] if a text is not a valid template.
    pub fn shipped() -> Result<Words, ClaimError> {
        let File { fitted, untested, claims } = toml::from_str(include_str!("words.toml"))?;
        let unsaid = |(part, text): (&str, &str)| (part.to_owned(), text.to_owned());
        let parts = claims.into_iter().flat_map(|(key, parts)| {
            let all = [("paper", "no figure"), ("criterion", "")].map(unsaid).into_iter().chain(parts);
            all.map(move |(part, text)| (format!("{key}.{part}"), text))
        });
        let mut templates = templates(parts.chain([("fitted".to_owned(), fitted)]))?;
        templates.add_filter("percent", percent);
        templates.add_filter("newtons", |force_n: f64| format!("{force_n:.2} N"));
        Ok(Words { templates, untested })
    }

    /// Text of a claim with its numbers and verdict.
    pub(crate) fn claim(&self, key: &str, verdict: ClaimVerdict, numbers: Value) -> Result<Claim, ClaimError> {
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

    /// Claims of the paper that finray cannot test.
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

pub(super) fn percent(share: f64) -> String {
    match 100.0 * share.abs() {
        0.0 => "0 %".to_owned(),
        p if p < 0.01 => format!("{:.0e} %", 100.0 * share),
        p if p < 1.0 => format!("{:.2} %", 100.0 * share),
        _ => format!("{:.1} %", 100.0 * share),
    }
}

/// Builds the templates from pairs of name and text. Two filters format numbers: `plain` prints all digits, and `fixed` prints a given number of
/// decimals. A missing number is an error.
fn templates(texts: impl IntoIterator<Item = (String, String)>) -> Result<Environment<'static>, minijinja::Error> {
    let mut templates = Environment::new();
    templates.set_undefined_behavior(UndefinedBehavior::Strict);
    templates.add_filter("plain", |value: f64| value.to_string());
    templates.add_filter("fixed", |value: f64, decimals: usize| format!("{value:.decimals$}"));
    for (name, text) in texts {
        templates.add_template_owned(name, text)?;
    }
    Ok(templates)
}
