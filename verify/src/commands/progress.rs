//! Progress bars on standard error.

use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar with the remaining time; hidden if standard error is not a terminal.
pub fn bar(steps: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(steps);
    // `with_template` fails only for an invalid template; this one is a valid constant.
    if let Ok(style) = ProgressStyle::with_template("{msg:24} {wide_bar} {pos}/{len} {eta} left") {
        bar.set_style(style);
    }
    bar.set_message(what.to_owned());
    bar
}
