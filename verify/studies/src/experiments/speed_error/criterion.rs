//! Times measured by the benchmark library `criterion`; they replace the report's times.
//!
//! The bench `speed_error` times the points of the report under their names: a group is `speed_error/TASK`, a function is a model, and a parameter is
//! a setting. For each bench, `criterion` writes a folder `new`. Its file `benchmark.json` contains the names, and its file `estimates.json` the
//! times in ns.

use super::{SpeedErrorPoint, Task, TimedBy, mark_fronts};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Number of nested folders that `criterion` writes for one bench: group, function, parameter and `new`.
const DEPTH: usize = 4;

const NANOSECONDS_A_SECOND: f64 = 1e9;

/// Name of the group of benches that time a task.
pub fn group(task: Task) -> String {
    format!("speed_error/{}", task.name())
}

/// Median time of one point.
#[derive(Debug, Clone, PartialEq)]
pub struct CriterionTime {
    group: String,
    model: String,
    setting: String,
    seconds: f64,
}

/// Time measurements from criterion's folder.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CriterionTimes {
    /// Times of the report's points; results of other benches are ignored.
    pub times: Vec<CriterionTime>,
    /// Files and folders that cannot be read, or files that are not in the format of `criterion`.
    pub unreadable: Vec<PathBuf>,
}

#[derive(Deserialize)]
struct Benchmark {
    group_id: String,
    function_id: Option<String>,
    value_str: Option<String>,
}

#[derive(Deserialize)]
struct Estimates {
    median: Estimate,
}

#[derive(Deserialize)]
struct Estimate {
    point_estimate: f64,
}

impl CriterionTimes {
    /// Reads every `new/estimates.json` below a folder.
    ///
    /// # Errors
    /// [`std::io::Error`] if the folder itself cannot be listed.
    pub fn read(folder: &Path) -> Result<CriterionTimes, std::io::Error> {
        let mut found = CriterionTimes::default();
        std::fs::read_dir(folder)?;
        found.collect(folder, DEPTH);
        found.times.sort_by(|a, b| (&a.group, &a.model, &a.setting).cmp(&(&b.group, &b.model, &b.setting)));
        found.unreadable.sort();
        Ok(found)
    }

    fn collect(&mut self, folder: &Path, depth: usize) {
        let Ok(entries) = std::fs::read_dir(folder) else {
            self.unreadable.push(folder.to_owned());
            return;
        };
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_dir()) {
            if path.ends_with("new") {
                self.take(&path);
            } else if depth > 0 {
                self.collect(&path, depth - 1);
            }
        }
    }

    fn take(&mut self, folder: &Path) {
        let names = folder.join("benchmark.json");
        let Some(bench) = read_json::<Benchmark>(&names) else {
            self.unreadable.push(names);
            return;
        };
        let (Some(model), Some(setting)) = (bench.function_id, bench.value_str) else { return };
        if !Task::ALL.into_iter().any(|task| group(task) == bench.group_id) {
            return;
        }
        let file = folder.join("estimates.json");
        let median_ns = read_json::<Estimates>(&file).map(|estimates| estimates.median.point_estimate);
        match median_ns.filter(|ns| ns.is_finite() && *ns > 0.0) {
            Some(ns) => self.times.push(CriterionTime {
                group: bench.group_id,
                model,
                setting,
                seconds: ns / NANOSECONDS_A_SECOND,
            }),
            None => self.unreadable.push(file),
        }
    }
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

/// Replaces the time of each point that the library `criterion` also timed. Returns the number of replaced times.
pub fn take_times(points: &mut [SpeedErrorPoint], times: &CriterionTimes) -> usize {
    let mut taken = 0;
    for point in points.iter_mut().filter(|point| point.seconds.is_finite()) {
        let same = |time: &&CriterionTime| {
            time.group == group(point.task) && time.model == point.model && time.setting == point.setting
        };
        if let Some(time) = times.times.iter().find(same) {
            point.seconds = time.seconds;
            point.seconds_95 = None;
            point.timed_by = TimedBy::Criterion;
            taken += 1;
        }
    }
    mark_fronts(points);
    taken
}
