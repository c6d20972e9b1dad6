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

/// Progress bar of a training: losses and remaining time.
#[cfg(feature = "train")]
pub struct TrainingBar(ProgressBar);

#[cfg(feature = "train")]
impl TrainingBar {
    /// A bar for this number of epochs.
    pub fn new(epochs: usize) -> TrainingBar {
        let bar = bar(epochs as u64, "drawing cases");
        // `with_template` fails only for an invalid template; this one is a valid constant.
        if let Ok(style) = ProgressStyle::with_template("epoch {pos}/{len} {wide_bar} {msg} {eta} left") {
            bar.set_style(style);
        }
        bar.tick();
        TrainingBar(bar)
    }

    /// Shows the losses of an epoch.
    pub fn epoch(&self, epoch: finray_train::Epoch) {
        self.0.set_position(epoch.number as u64);
        self.0.set_message(format!("loss {:.3e}, unseen {:.3e}", epoch.training_loss, epoch.validation_loss));
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
