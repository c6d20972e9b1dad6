//! Sentence templates: files hold the text, the code computes the numbers.

use minijinja::{Environment, UndefinedBehavior};

/// Builds the templates from pairs of name and text. Two filters format numbers: `plain`, and `fixed` with a number of decimals. A missing number is
/// an error.
///
/// # Errors
/// [`minijinja::Error`] for an invalid template.
pub fn templates(texts: impl IntoIterator<Item = (String, String)>) -> Result<Environment<'static>, minijinja::Error> {
    let mut templates = Environment::new();
    templates.set_undefined_behavior(UndefinedBehavior::Strict);
    templates.add_filter("plain", |value: f64| value.to_string());
    templates.add_filter("fixed", |value: f64, decimals: usize| format!("{value:.decimals$}"));
    for (name, text) in texts {
        templates.add_template_owned(name, text)?;
    }
    Ok(templates)
}
