//! Streams of positions as other programs write them: times, quotes, separators, hidden markers and further columns.

use super::{force_n, found_in, positions, pushed, shape, states};
use crate::kit::*;
use finray_files::positions::{PositionFrame, PositionReader};
use finray_model::NodeId;

/// The frames of a stream.
fn frames(text: &str, is_json: bool) -> Vec<PositionFrame> {
    let mut reader = PositionReader::new(text.as_bytes(), is_json).unwrap_or_else(|error| panic!("{error}: {text}"));
    std::iter::from_fn(|| reader.read().expect("frames")).collect()
}

/// Time of the first frame of a stream with one marker.
fn time_s(name: &str, time: &str, is_json: bool) -> Result<Option<f64>, String> {
    let text = match is_json {
        true => format!("{{\"{name}\":{time},\"markers\":[{{\"node\":2,\"x_mm\":1,\"y_mm\":2}}]}}\n"),
        false => format!("{name},node,x_mm,y_mm\n{time},2,1,2\n"),
    };
    let frame = frames(&text, is_json).remove(0);
    frame.seen.map(|_| frame.time_s)
}

/// Times in each unit and in ISO 8601. The seconds of ISO 8601 are those of `date -u -d TIME +%s.%N` (GNU coreutils).
#[test]
fn times_are_read_in_each_unit() {
    for (name, text, expected) in [
        ("t_s", "0.04", 0.04),
        ("time_s", "0.04", 0.04),
        ("time_ms", "40", 0.04),
        ("t_us", "40000", 0.04),
        ("time_ns", "1764338751250000000", 1_764_338_751.25),
        ("time", "1970-01-01T00:00:00Z", 0.0),
        ("timestamp", "2000-02-29T12:30:00Z", 951_827_400.0),
        ("time_s", "2000-03-01 00:00", 951_868_800.0),
        ("stamp", "2026-11-28T14:05:51.25+01:00", 1_795_871_151.25),
        ("time", "2100-12-31T23:59:59-01:30", 4_133_986_199.0),
    ] {
        let quoted = if text.contains(':') { format!("\"{text}\"") } else { text.to_owned() };
        assert_eq!(time_s(name, text, false), Ok(Some(expected)), "{name} {text}");
        assert_eq!(time_s(name, &quoted, true), Ok(Some(expected)), "{name} {text}");
    }
    for (name, text) in
        [("time", "40"), ("time_ms", "-1"), ("t_s", "soon"), ("time", "2026-13-01T00:00Z"), ("time", "2026-11-28")]
    {
        let message = time_s(name, text, false).expect_err(text);
        assert_says(&message, &["line 2: ", &format!("{name}: expected a time in "), text]);
    }
    assert_eq!(time_s("number", "3", true), Ok(None));
}

/// A table with quotes, semicolons and decimal commas, tabs, other line ends, a byte order mark, further columns and further words for hidden markers gives
/// the force of the plain table. So does JSON with further keys.
#[test]
fn tables_of_other_programs_give_the_same_force() {
    let [json, rows] = positions(&shape(&[pushed(70.0, 1.5)]), 0.5, 3);
    let header = "t_s,node,x_mm,y_mm,sigma_mm\n";
    let plain = format!("{header}{rows}");
    let force = |text: &str| {
        let found = found_in(text);
        assert_eq!((states(&found), &found[0]["time_s"]), (vec!["contact"], &0.5.into()), "{text}");
        (force_n(&found[0]), found[0]["markers"].as_u64())
    };
    let (expected, _) = force(&plain);
    let quoted = |text: &str| {
        let row = |row: &str| row.split(',').map(|cell| format!("\"{cell}\"")).collect::<Vec<_>>().join(",");
        text.lines().map(|line| row(line) + "\r\n").collect::<String>()
    };
    let further: String = plain.lines().zip(0..).map(|(line, i)| format!("{i},{line},\"a, b\"\n")).collect();
    let hidden = ["", "NaN", "NA", "null", "nan"].map(|word| format!("0.5,6,{word},{word},\n")).concat();
    for text in [
        quoted(&plain),
        plain.replace(',', ";"),
        plain.replace(',', ";").replace('.', ","),
        plain.replace(',', "\t"),
        format!("\u{feff}{plain}").replace('\n', "\r\n"),
        further,
        json.replace("{\"node\"", "{\"score\":[1],\"node\"").replace("{\"t_s\"", "{\"camera\":{\"id\":1},\"t_s\""),
    ] {
        assert_eq!(force(&text), (expected, Some(25)), "{text}");
    }
    assert_eq!(force(&format!("{plain}{hidden}")), (expected, Some(25)));
}

/// Messages name line, column or key, and node.
#[test]
fn messages_name_line_column_and_node() {
    let table = |row: &str| format!("time_s,node,x_mm,y_mm,sigma_mm\n0.5,5,1,2,\n{row}\n");
    for (row, expected) in [
        ("0.5,6,left,2,", "line 3: x_mm: expected a finite number, found \"left\" (node 6)"),
        ("0.5,6,,2,", "line 3: x_mm: expected a finite number, found \"\" beside y_mm (node 6)"),
        ("0.5,6,1,2,wide", "line 3: sigma_mm: expected a finite number, found \"wide\" (node 6)"),
        ("0.5,tip,1,2,", "line 3: node: expected the number of a node, found \"tip\""),
        ("0.5,6,1,2", "line 3: expected 5 columns as in the header, found 4"),
    ] {
        assert_says(&frames(&table(row), false)[0].seen.clone().expect_err(row), &[expected]);
    }
    let json =
        |marker: &str| format!("{{\"time_s\":0.5,\"markers\":[{{\"node\":5,\"x_mm\":1,\"y_mm\":2}},{marker}]}}\n");
    for (marker, expected) in [
        (
            r#"{"node":6,"x_mm":"left","y_mm":2}"#,
            "line 1: node 6: x_mm: expected a number, or null for a hidden marker, found \"left\"",
        ),
        (
            r#"{"node":6,"y_mm":2}"#,
            "line 1: node 6: x_mm: expected a number, or null for a hidden marker, found nothing",
        ),
        (r#"{"node":6,"x_mm":null,"y_mm":2}"#, "line 1: node 6: expected two coordinates"),
        (r#"{"node":-6,"x_mm":1,"y_mm":2}"#, "line 1: markers[1]: node: expected the number of a node, found -6"),
        (r#"{"x_mm":1,"y_mm":2}"#, "line 1: markers[1]: node: expected the number of a node, found nothing"),
        (r#"7"#, "line 1: markers[1]: expected an object, found 7"),
        (r#"{"node":6,"x_mm":1,"y_mm":2,"sigma_mm":"NaN"}"#, "line 1: node 6: sigma_mm: expected a number"),
        (r#"{"node":6,"x_mm":1 "y_mm":2}"#, "line 1, column 74: expected `,` or `}`"),
    ] {
        assert_says(&frames(&json(marker), true)[0].seen.clone().expect_err(marker), &[expected]);
    }
    assert_says(&frames("{}\n", true)[0].seen.clone().expect_err("no markers"), &["line 1: markers: expected a list"]);
    // A text that contains NaN is no number that is missing.
    let frame = frames(&json(r#"{"node":6,"x_mm":NaN, "y_mm": NaN,"finger":"NaN \" NaN"}"#), true).remove(0);
    let seen = frame.seen.expect("a frame");
    assert_eq!((seen.len(), seen[0].seen.markers[0].node, &*seen[1].finger), (2, NodeId(5), "NaN \" NaN"));
    assert!(seen[1].seen.markers.is_empty());
}
