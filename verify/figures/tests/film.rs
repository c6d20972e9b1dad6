//! Animated drawings.

use finray_figures::{Film, Frame, Hue, Series, Shot};

fn film(count: usize, still: usize) -> Film {
    let shot = |i: usize| {
        let line = |y: f64| vec![[0.0, y], [10.0 + i as f64, y]];
        Shot {
            words: vec![format!("step {i}")],
            series: Series::lines("fingers", vec![line(0.0), line(5.0)], Hue::BLUE, 2.0),
        }
    };
    let fixed = Series::lines("support", vec![vec![[0.0, -5.0], [30.0, -5.0]]], Hue::NEUTRAL, 3.0);
    let (frame, labels) = (Frame::half("a film", "lines that grow"), ["across, mm", "up, mm"]);
    Film { frame, labels, fixed, shots: (0..count).map(shot).collect(), still, shot_s: 0.2 }
}

/// At every time, one shot is visible. The delays of successive shots differ by the duration of a shot, and each shot is visible for its share of the
/// whole duration.
#[test]
fn shots_follow_each_other() {
    let svg = film(4, 2).svg().unwrap();
    let delays: Vec<f64> =
        svg.split("animation-delay:").skip(1).map(|rest| rest.split_once("s\"").unwrap().0.parse().unwrap()).collect();
    assert_eq!(delays, [-0.8, -0.6, -0.4, -0.2]);
    let style = svg.split_once("<style>").unwrap().1.split_once("</style>").unwrap().0;
    assert!(style.contains("animation:shot-4 0.80s step-end infinite"), "{style}");
    assert!(style.contains("{0%{visibility:visible}25.0200%{visibility:hidden}"), "{style}");
    // Lines of the same style are combined into one path, which has one part per line.
    let paths: Vec<&str> = svg.split("<path d=\"").skip(1).collect();
    assert!(paths.len() == 4 && paths.iter().all(|path| path.split('"').next().unwrap().matches('M').count() == 2));
}

/// Without animation, in print, or for readers who prefer no motion, only the chosen shot is visible.
#[test]
fn one_shot_stands_for_all() {
    let svg = film(4, 2).svg().unwrap();
    let shots: Vec<&str> = svg.split("<g class=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(shots, ["shot-4", "shot-4", "shot-4 still", "shot-4"]);
    assert!(svg.contains(".shot-4{visibility:hidden;") && svg.contains(".shot-4.still{visibility:visible}"));
    for setting in ["@media print", "@media (prefers-reduced-motion:reduce)"] {
        assert!(svg.contains(&format!("{setting}{{.shot-4{{animation:none}}}}")), "{setting}");
    }
    assert!(film(4, 4).svg().is_err(), "a film without the shot that stands for it");
}
