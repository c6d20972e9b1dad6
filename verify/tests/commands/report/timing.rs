//! Tests the report's times for sensing a moving force, and the stated sources of all times.

use super::shared::*;
use crate::kit::*;
use serde_json::Value;

/// For each way of sensing, the report states time, error, cold or warm start, the slowest times, the preparation time for a contact, and the model
/// error. With the recommended way of sensing, the model error is within the stated standard deviation.
#[test]
fn times_of_sensing_are_of_a_moving_force_cold_and_warm() {
    let summary = PAPERS.summary();
    let points: Vec<&Value> = array(&summary, "speed_error")
        .iter()
        .filter(|point| point["task"] == "sense-one" && point["model"] == "nonlinear")
        .collect();
    let number = |point: &Value, key: &str| point[key].as_f64().unwrap_or_else(|| panic!("{key} of {point}"));
    let of = |start: &str| -> Vec<&Value> { points.iter().copied().filter(|point| point["start"] == start).collect() };
    let (cold, warm) = (of("cold"), of("warm"));
    assert_eq!((cold.len(), warm.len(), points.len()), (4, 4, 8));
    for (cold, warm) in cold.iter().zip(&warm) {
        for point in [cold, warm] {
            assert!(
                number(point, "seconds") <= number(point, "seconds_95") && number(point, "preparation_seconds") > 0.0
            );
            assert_eq!(number(point, "asked"), 11.0 * 25.0, "eleven nodes, a period each");
            assert_eq!(number(point, "failed"), 0.0);
        }
        assert!(cold["setting"].as_str().expect("words").ends_with("cold start"));
        // A cold or warm start changes the time, but not the sensed force.
        assert!((number(cold, "error") - number(warm, "error")).abs() < 1e-3);
    }
    // With 25 nodes, the model error exceeds the stated standard deviation; with the recommended setting, it does not.
    assert!(warm[0]["setting"] == "25 nodes, warm start" && number(warm[0], "bias_sigmas") > 2.0);
    let cost = array(&summary, "verdict")
        .iter()
        .filter_map(Value::as_str)
        .find(|said| said.starts_with("What should sense it?"));
    let cost = cost.expect("a sentence on cost");
    let mesh = |point: &Value| point["setting"].as_str().expect("words").replace(" nodes, warm start", " mesh nodes");
    let named = warm.iter().find(|point| cost.contains(&format!("on {} has ", mesh(point))));
    assert!(named.is_some_and(|point| number(point, "bias_sigmas") <= 0.4), "{cost}");
    let rate = array(&summary, "claims")
        .iter()
        .find(|claim| claim["claim"].as_str().is_some_and(|said| said.contains("cannot exceed 25 Hz")))
        .expect("the claim");
    assert_eq!(rate["verdict"], "not-tested");
    assert_says(rate["how"].as_str().expect("words"), &["its rate is not tested", "camera noise"]);
}

/// Times measured by criterion and by other programs are used unchanged, and the table names the source of each time.
#[test]
fn times_say_who_took_them() {
    let rows = Csv::of(&PAPERS.read("speed_error.csv"));
    let [tasks, models, settings, by] = ["task", "model", "setting", "timed_by"].map(|column| rows.texts(column));
    let point = |task: &str, model: &str, setting: &str| {
        let at = (0..by.len()).find(|&row| (tasks[row], models[row], settings[row]) == (task, model, setting));
        let at = at.unwrap_or_else(|| panic!("no point {task}, {model}, {setting}"));
        (rows.texts("seconds")[at].parse::<f64>().expect("a time"), by[at].to_owned())
    };
    assert_eq!(point("solve", "co-rotational", "25 nodes"), (1.2345675e-4, "criterion".to_owned()));
    assert_eq!(point("solve", "co-rotational", "61 nodes").1, "timed here");
    assert_eq!(point("solve", "corotational frame", "684 nodes"), (0.15, "OpenSees 3.7.1.2".to_owned()));
    assert_eq!(by.iter().filter(|by| **by != "timed here").count(), 4);
    let page = PAPERS.pages();
    let section =
        page[page.find("id=\"speed-error\"").expect("the section")..].split("</section>").next().unwrap_or_default();
    for said in [
        "The times of 2 of ",
        "1 of the files there are not in the format of the benchmark library criterion",
        "on this machine: a desk, one core",
        ">criterion<",
        ">OpenSees 3.7.1.2<",
        ">OpenSees: corotational frame<",
        "2 points are of other programs",
        "1 points of other programs are for other nodes or forces than ours and are ignored. The first of them is for 3 N on nodes 14 18 22 \
         instead of 3 N on nodes 14-24",
    ] {
        assert!(section.contains(said), "{said}");
    }
    let without = SPRING_STEELS.pages();
    assert!(without.contains("Other programs were not timed") && !section.contains("Other programs were not timed"));
}

/// A table with results of other programs is checked line by line before anything is computed.
#[test]
fn wrong_tables_of_other_programs_are_refused() {
    let folder = Folder::new();
    let out = folder.path("report");
    for (from, to, said) in [
        (
            "solve,cor",
            "bend,cor",
            &["line 2: task: expected one of solve, sense-one, sense-neighbours, found \"bend\""][..],
        ),
        ("0.15", "-0.15", &["line 2: seconds: expected a number above 0"]),
        ("0.15", "fast", &["line 2: seconds: expected a finite number, found \"fast\""]),
        ("0.0002", "-1", &["line 2: expected an error of at least 0"]),
        (",Torch,", ",,", &["line 3: program: expected text"]),
        ("program,version", "name,version", &["line 1: expected a column program"]),
        ("nodes,forces_n", "places,forces_n", &["line 1: expected a column nodes"]),
        ("14-24,3", ",3", &["line 2: nodes: expected text"]),
    ] {
        let peers = folder.put("peers.csv", PEERS.replacen(from, to, 1));
        let message = finray(&["report", "--quick", "--peers", &peers, "--out", &out]).refused();
        assert_says(&message, &[&["peers.csv: "], said].concat());
    }
    let missing = folder.path("missing");
    let message = finray(&["report", "--quick", "--criterion", &missing, "--out", &out]).refused();
    assert_says(&message, &["missing: cannot be read"]);
    assert_eq!(folder.names(), ["peers.csv"]);
}
