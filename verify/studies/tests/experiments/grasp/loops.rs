//! The closed loop at different camera frame rates.

use finray_model::Scene;
use finray_studies::check::Verdict;
use finray_studies::experiments::grasp::rates::{LoopRun, LoopSetting, LoopStudy, closed_loops};
use finray_studies::experiments::grasp::{Eyes, GraspEnd, GraspScene, LoopFigures, loop_figures};

const MOTOR_DEG_PER_S: f64 = 30.0;

/// A setting of the loop with one noise realisation.
fn setting(noise_mm: f64, delay_frames: usize, frames_per_s: f64) -> LoopSetting {
    LoopSetting { noise_mm, delay_frames, frames_per_s, realisations: 1 }
}

/// Without noise, the force overshoots because the motor continues between two frames of a slow camera, and for longer if sensing is delayed.
#[test]
fn slow_and_late_frames_overshoot() {
    let study =
        closed_loops(&[setting(0.0, 0, 2.0), setting(0.0, 0, 10.0), setting(0.0, 2, 2.0), setting(0.0, 2, 10.0)])
            .unwrap();
    let figures: Vec<LoopFigures> = study.runs.iter().map(|run| run.figures[0].expect("it holds")).collect();
    for (run, figures) in study.runs.iter().zip(&figures) {
        // The overshoot is the force that the motor adds during the delay and at most one further frame. The force grows faster at the end than on
        // average, hence the factor 1.3.
        let share_a_frame = 0.8 / (figures.rise_s.unwrap() * run.setting.frames_per_s);
        let [least, most] = [0.0, 1.0].map(|more| 1.3 * (run.setting.delay_frames as f64 + more) * share_a_frame);
        assert!(figures.overshoot <= most && figures.overshoot >= 0.5 * least, "{run:?}");
        assert!(figures.largest_error < 0.01, "{run:?}");
    }
    assert!(figures[2].overshoot > 0.08 && figures[2].overshoot > 2.0 * figures[3].overshoot, "{figures:?}");
}

/// A loop that shares its computed beginning with other loops ends like a loop that senses every frame; only the motor angles of the frames differ.
#[test]
fn frames_left_out_change_nothing() {
    const RATE: f64 = 10.0;
    let mut scene = Scene::from_toml(finray_fixtures::GRASP_LOOP_SCENE).unwrap();
    let grasp = scene.grasp.as_mut().unwrap();
    grasp.frames_per_s = Some(RATE);
    grasp.path_mm.clear();
    let grasp = GraspScene::new(&scene, &[]).unwrap().with_fineness(1);
    let mut steps = Vec::new();
    assert_eq!(grasp.run(&Eyes::Noise(0.0), 1, |step| steps.push(step.clone())).unwrap(), GraspEnd::Done);
    let every = loop_figures(&steps, 1.6, Some(MOTOR_DEG_PER_S)).unwrap();
    let few = closed_loops(&[setting(0.0, 0, RATE)]).unwrap().runs[0].figures[0].unwrap();
    // In one frame, the motor turns by 3 degrees, which adds 15 mN to the force (target: 1.6 N). The force rises uniformly with the motor's speed.
    assert!((every.overshoot - few.overshoot).abs() < 0.012, "{every:?} {few:?}");
    assert!((every.steady_error - few.steady_error).abs() < 0.002, "{every:?} {few:?}");
    assert!((every.rise_s.unwrap() / few.rise_s.unwrap() - 1.0).abs() < 0.01, "{every:?} {few:?}");
}

/// The slower camera uses every fourth frame of the faster camera. The loop of the slower camera has the same results as a loop that is computed
/// alone with its own steps.
#[test]
fn frames_of_a_faster_camera_serve_a_slower_one() {
    let slow = setting(0.02, 1, 10.0);
    let alone = closed_loops(&[slow]).unwrap().runs[0].figures[0].unwrap();
    let beside = closed_loops(&[slow, setting(0.02, 1, 40.0)]).unwrap().runs[0].figures[0].unwrap();
    // The tolerance covers the change of friction, which is computed in finer steps if the faster camera also runs.
    assert!((alone.overshoot - beside.overshoot).abs() < 1e-4, "{alone:?} {beside:?}");
    assert!((alone.largest_error - beside.largest_error).abs() < 1e-4, "{alone:?} {beside:?}");
    let odd = closed_loops(&[slow, setting(0.02, 1, 25.0)]).unwrap().runs[0].figures[0].unwrap();
    assert_eq!(alone, odd, "rates that do not divide share nothing");
}

/// Each loop runs with every noise realisation. The study states mean, smallest and largest figure, or nothing if one realisation never held the
/// object.
#[test]
fn realisations_of_the_noise_spread() {
    let settings = |realisations| [10.0, 5.0].map(|rate| LoopSetting { realisations, ..setting(0.067, 0, rate) });
    let [few, many] = [1, 3].map(|realisations| closed_loops(&settings(realisations)).unwrap());
    for (one, all) in few.runs.iter().zip(&many.runs) {
        assert_eq!((one.figures.len(), all.figures.len()), (1, 3));
        assert_eq!(one.figures[0], all.figures[0], "the same first realisation");
        let overshoots: Vec<f64> = all.figures.iter().map(|of| of.unwrap().overshoot).collect();
        let spread = all.over(|of| of.overshoot).unwrap();
        assert!((spread.mean - overshoots.iter().sum::<f64>() / 3.0).abs() < 1e-15);
        assert!(overshoots.contains(&spread.least) && overshoots.contains(&spread.most), "{overshoots:?} {spread:?}");
        // All realisations may overshoot equally, in the same frame, but their steady errors differ.
        let held = all.over(|of| of.steady_error).unwrap();
        assert!(held.least < held.mean && held.mean < held.most, "{held:?}");
    }
    let lost = LoopRun { figures: vec![many.runs[0].figures[0], None], ..many.runs[0].clone() };
    assert_eq!(lost.over(|of| of.overshoot), None);
}

/// The check uses the worst realisation of the worst loop at the paper's frame rate, and fails if a loop never held the object.
#[test]
fn a_loop_that_does_not_hold_fails_the_check() {
    let figures =
        |largest_error| LoopFigures { target_n: 1.6, rise_s: None, overshoot: 0.0, steady_error: 0.0, largest_error };
    let run = |frames_per_s, figures| LoopRun { setting: setting(0.01, 0, frames_per_s), figures };
    let verdict = |at_25| {
        let held = Some(figures(0.01));
        let runs = vec![run(2.0, vec![Some(figures(0.5))]), run(25.0, vec![held]), run(25.0, vec![held, at_25])];
        LoopStudy { target_n: 1.6, motor_deg_per_s: MOTOR_DEG_PER_S, runs }.held().verdict
    };
    assert_eq!(verdict(Some(figures(0.04))), Verdict::Pass);
    assert_eq!([verdict(Some(figures(0.06))), verdict(None)], [Verdict::Fail; 2]);
}
