//! A closed loop that holds a sensed force, at several frame rates of the camera: a chart, a table and a file.

use crate::format::{list, percent};
use crate::prelude::*;
use finray_studies::experiments::grasp::rates::{DELAYS, LoopRun, LoopSetting, LoopStudy, Spread};

const CSV: &str = "grasp_loop.csv";

fn columns<'c>() -> Columns<'c, LoopRun> {
    Columns::<LoopRun>::new()
        .both("noise_mm", "noise, mm", Format::Plain, |run| run.setting.noise_mm)
        .both("delay_frames", "frames late", Format::Plain, |run| run.setting.delay_frames)
        .both("frames_per_s", "frames per second", Format::Plain, |run| run.setting.frames_per_s)
        .file("realisations", |run| run.figures.len())
        .both("overshoot", "mean overshoot", Format::Percent, |run| overshoot(run).map(|overshoot| overshoot.mean))
        .both("overshoot_least", "least", Format::Percent, |run| overshoot(run).map(|overshoot| overshoot.least))
        .both("overshoot_most", "largest", Format::Percent, |run| overshoot(run).map(|overshoot| overshoot.most))
        .both("steady_error", "largest mean error once held", Format::Percent, |run| {
            run.over(|of| of.steady_error.abs()).map(|errors| errors.most)
        })
        .both("largest_error", "largest error once held", Format::Percent, |run| {
            run.over(|of| of.largest_error).map(|errors| errors.most)
        })
        .both("rise_s", "10 to 90 %, s", Format::Fixed(1), rise_s)
}

fn overshoot(run: &LoopRun) -> Option<Spread> {
    run.over(|of| of.overshoot)
}

/// Mean rise time over the realisations of the noise, s.
fn rise_s(run: &LoopRun) -> Option<f64> {
    run.over(|of| of.rise_s.unwrap_or(f64::NAN)).map(|rise_s| rise_s.mean).filter(|rise_s| rise_s.is_finite())
}

pub(crate) fn datasets<'s>(Results { study, .. }: Results<'s>) -> Vec<Dataset<'s>> {
    vec![Dataset::new(CSV, &columns(), study.closed_loop.iter().flat_map(|closed_loop| closed_loop.runs.clone()))]
}

pub(crate) fn section(Results { study, .. }: Results) -> Result<Option<Section>, ReportError> {
    let Some(closed_loop) = &study.closed_loop else { return Ok(None) };
    let caption = "Overshoot of the true force (mean of both fingers): mean, least and largest value over the noise realisations. The overshoot also \
                   depends on the times of the frames and can reach the dotted lines.";
    let figure = Figure::wide(chart(closed_loop)?, caption, CSV);
    let table = columns().table("Every loop", CSV, closed_loop.runs.clone());
    let folded = details("Overshoot, error during the hold and rise time of every loop", vec![Block::Table(table)]);
    let blocks = about(closed_loop).map(text).into_iter().chain([Block::Figure(figure), folded]).collect();
    Ok(Some(Section::new("closed-loop", "Holding a force", blocks)))
}

/// Text on how the closed loops run, and on the error of the held force; `None` without loops.
fn about(LoopStudy { target_n, motor_deg_per_s, runs }: &LoopStudy) -> Option<String> {
    let last = runs.last()?;
    let (noise_mm, realisations) = (last.setting.noise_mm, last.figures.len());
    let steady = runs.iter().filter_map(|run| run.over(|of| of.steady_error.abs())).map(|errors| errors.most);
    let steady = percent(steady.fold(0.0, f64::max));
    Some(format!(
        "A simulated closed loop: two of the paper's fingers (beams with one element per member) close on a disc \
            until the mean of both sensed forces is {target_n} N, and hold this force for 30 frames. The motor turns \
            at {motor_deg_per_s} degrees per second. In each frame the controller corrects half of the missing force, \
            or less if sensing is delayed. All loops share steps of 22.5 degrees up to nine tenths of the target; from \
            there each loop continues separately, with {realisations} realisations of {noise_mm} mm noise. The motor \
            keeps turning between two frames. The overshoot can reach the force that the motor adds in one frame and \
            in each frame of delay (dotted lines, computed from the mean rise time). During the hold, the largest mean \
            error of the force is {steady}. The motor's speed, not the frame rate, sets the rise time."
    ))
}

/// Chart of the overshoot over the frame rate, one line per noise level and delay.
fn chart(LoopStudy { target_n, runs, .. }: &LoopStudy) -> Result<String, FigureError> {
    let mut series = Vec::new();
    let line = |run: &LoopRun| (run.setting.noise_mm, run.setting.delay_frames);
    for of_setting in runs.chunk_by(|a, b| line(a) == line(b)) {
        let LoopSetting { noise_mm, delay_frames, realisations, .. } = of_setting[0].setting;
        let late = if delay_frames == 0 { "at once".to_owned() } else { format!("{delay_frames} frames late") };
        let held = of_setting.iter().filter_map(|run| Some((run.setting.frames_per_s, overshoot(run)?)));
        let points: Vec<_> = held.clone().map(|(rate, overshoot)| [rate, 100.0 * overshoot.mean]).collect();
        if !points.is_empty() {
            let bars = held.map(|(_, overshoot)| [overshoot.least, overshoot.most].map(|end| 100.0 * end)).collect();
            let of = Series::nth(series.len(), format!("{noise_mm} mm noise, sensed {late}"), points);
            let spread = if realisations > 1 { bars } else { Vec::new() };
            series.push(Series { spread, ..of });
        }
    }
    let delay = |run: &LoopRun| run.setting.delay_frames;
    let rates: Vec<f64> =
        runs.iter().take_while(|run| delay(run) == delay(&runs[0])).map(|run| run.setting.frames_per_s).collect();
    for run in runs.chunk_by(|a, b| delay(a) == delay(b)).take(DELAYS.len()).filter_map(<[_]>::first) {
        let Some(rise_s) = rise_s(run) else { continue };
        // The rise time covers 10 % to 90 % of the target, so the force rises by 0.8 of the target in this time.
        let frames = 1.0 + delay(run) as f64;
        let share = |rate: f64| 0.8 * frames / (rise_s * rate);
        let points = rates.iter().map(|rate| [*rate, 100.0 * share(*rate)]).collect();
        // All reference lines have the same style, so one legend entry names all of them.
        let is_first = series.iter().all(|of| of.marker.is_some());
        let label = format!("force added by the motor in {} frames", list(DELAYS.map(|delay| delay + 1), " and "));
        series.push(Series::guide(if is_first { label } else { String::new() }, points));
    }
    let [least, most] = [f64::min, f64::max].map(|of| rates.iter().copied().reduce(of).unwrap_or(1.0));
    let x = Axis::log("frames per second").within(0.8 * least, 1.25 * most).with_ticks(rates);
    let title = format!("Overshoot of a closed loop of {target_n} N against the camera's rate");
    let alt = format!("{title}, by noise and delay.");
    Chart::new(Frame::full(title, alt), [x, Axis::linear("overshoot, %")], series).svg()
}
