//! Computation times that were measured outside the report: times of finray, measured by the benchmark library criterion, and times of other
//! programs.

use super::Study;
use crate::experiments::speed_error::criterion::{self, CriterionTimes};
use crate::experiments::speed_error::peers::{Peer, Peers};
use crate::experiments::speed_error::{self, Asked, SpeedErrorPoint, Task};
use std::path::Path;

impl Study {
    /// Replaces the report's times with the times of the benchmark library criterion, at all points for which criterion has a time. Criterion's times
    /// apply only to the paper's finger.
    pub fn take_criterion(&mut self, folder: &Path, times: &CriterionTimes) {
        let folder = folder.display();
        if !self.is_paper {
            self.timing_notes
                .push(format!("Criterion's results in {folder} are ignored, because they are for the paper's finger."));
            return;
        }
        let taken = criterion::take_times(&mut self.speed_error, times);
        let all = self.speed_error.len();
        self.timing_notes.push(match taken {
            0 => format!(
                "The results of the benchmark library criterion in {folder} contain none of these points; cargo bench \
                -p finray-bench --bench speed_error measures the points."
            ),
            _ => format!(
                "The times of {taken} of {all} points are medians of the benchmark library criterion, from {folder}."
            ),
        });
        if let Some(first) = times.unreadable.first() {
            self.timing_notes.push(format!(
                "{} of the files there are not in the format of the benchmark library criterion and are ignored, \
                    the first of them {}.",
                times.unreadable.len(),
                first.display()
            ));
        }
    }

    /// Adds points (time and error) of other programs. The times of other programs apply only to the paper's finger.
    pub fn take_peers(&mut self, peers: Peers) {
        if !self.is_paper {
            self.timing_notes
                .push("The times of other programs are for the paper's finger only and are ignored.".to_owned());
            return;
        }
        let machine = match peers.machine.as_str() {
            "" => ", on a machine that the file does not name".to_owned(),
            machine => format!(", on this machine: {machine}"),
        };
        // Only points for the same nodes and forces are comparable, because the computation time depends on nodes and forces.
        let asked = Task::ALL.map(|task| speed_error::asked(&self.finger, self.checked_forces(), task));
        let (same, others): (Vec<Peer>, Vec<Peer>) =
            peers.peers.into_iter().partition(|peer| asked[peer.task as usize] == peer.asked);
        if let Some(other) = others.first() {
            let Asked { nodes, forces_n } = &asked[other.task as usize];
            self.timing_notes.push(format!(
                "{} points of other programs are for other nodes or forces than ours and are ignored. The first of \
                    them is for {} N on nodes {} instead of {forces_n} N on nodes {nodes}.",
                others.len(),
                other.asked.forces_n,
                other.asked.nodes
            ));
        }
        self.timing_notes.push(format!(
            "{} points are of other programs, timed by bench/peers{machine}. Their nodes and forces are the same \
                as ours. The dotted line of the best trade-off excludes these points.",
            same.len()
        ));
        self.speed_error.extend(same.into_iter().map(SpeedErrorPoint::from));
    }
}
