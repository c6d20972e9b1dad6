//! Time and error of models and estimators.

use super::{Effort, Progress, Study, StudyError};
use crate::estimators::Estimator;
use crate::networks::accuracy;
use crate::networks::{NetworkSensing, Networks};
use crate::speed_error::criterion::{self, CriterionTimes};
use crate::speed_error::peers::Peers;
use crate::speed_error::{self, SpeedErrorError, SpeedErrorPoint};
use finray_model::statics::StaticsError;
use finray_model::{Finger, Mesh};
use std::path::Path;

/// Times models and estimators, one after the other: nothing else may run beside them.
pub(super) fn time_and_compare(
    finger: &Finger,
    fine: &Mesh,
    noise_mm: f64,
    is_paper: bool,
    effort: Effort,
    progress: &dyn Progress,
) -> Result<Vec<SpeedErrorPoint>, StudyError> {
    let (nodes, pictures) = match effort {
        Effort::Quick => (3, 10),
        Effort::Full => (11, 40),
    };
    // What a finger does not carry leaves the chart out; the maps say so already.
    let mut points = match speed_error::solving(finger, nodes) {
        Err(SpeedErrorError::Statics(StaticsError::NoEquilibrium { .. })) => Vec::new(),
        points => points?,
    };
    progress.step();
    if noise_mm > 0.0 {
        let shipped = Networks::shipped()?;
        let sensing = NetworkSensing { name: accuracy::NAME, networks: &shipped, finger, refuses: true };
        let further: &[(&dyn Estimator, &str)] = if is_paper { &[(&sensing, "shipped networks")] } else { &[] };
        points.extend(speed_error::sensing(fine, noise_mm, nodes, pictures, further)?);
    }
    progress.step();
    Ok(points)
}

impl Study {
    /// Puts criterion's times in the place of the report's own, for the points that both have. Benches time the paper's finger: others
    /// keep their times.
    pub fn take_criterion(&mut self, folder: &Path, times: &CriterionTimes) {
        let folder = folder.display();
        if !self.is_paper {
            self.timing_notes
                .push(format!("Criterion's results in {folder} are of the paper's finger and were left aside."));
            return;
        }
        let taken = criterion::take_times(&mut self.speed_error, times);
        let all = self.speed_error.len();
        self.timing_notes.push(match taken {
            0 => format!("Criterion's results in {folder} have none of these points (cargo bench -p finray-bench --bench speed_error)."),
            _ => format!("The times of {taken} of {all} points are criterion's medians, from {folder}."),
        });
        if let Some(first) = times.unreadable.first() {
            self.timing_notes.push(format!(
                "{} of the files there are not what criterion writes and were left aside, the first of them {}.",
                times.unreadable.len(),
                first.display()
            ));
        }
    }

    /// Adds the points of other programs, for the paper's finger, which they were timed on.
    pub fn take_peers(&mut self, peers: Peers) {
        if !self.is_paper {
            self.timing_notes
                .push("The times of other programs are of the paper's finger and were left aside.".to_owned());
            return;
        }
        let machine = match peers.machine.as_str() {
            "" => "; the file does not say on which machine".to_owned(),
            machine => format!(", on this machine: {machine}"),
        };
        self.timing_notes.push(format!(
            "{} points are of other programs, timed by bench/peers{machine}. They take no part in the dotted line.",
            peers.peers.len()
        ));
        self.speed_error.extend(peers.peers.into_iter().map(SpeedErrorPoint::from));
    }
}
