//! Interrupted runs, and two runs at once.

use super::{HEADER, ROWS_IN_BLOCK, SWEEP, SWEPT, with};
use crate::kit::*;

/// After a run was killed, the next run produces the same bytes as an uninterrupted run, however much the killed run had written.
#[test]
fn a_run_that_was_killed_goes_on() {
    let folder = Folder::new();
    let out = folder.path("out.csv");
    let whole = SWEPT.as_str();
    // A shard consists of a head and rows. Without the lines about the shard, this file equals the partial file of a run without shards.
    let all = folder.path("all.csv");
    finray(&with(&SWEEP, &["--shard", "1/1", "--out", &all])).done();
    let shard = folder.read("all.csv");
    let head_lines = |line: &&str| line.starts_with('#');
    let head: Vec<&str> = shard.lines().take_while(head_lines).collect();
    let from = head.iter().position(|line| line.contains("[shard]")).expect("the shard's table");
    let kept = head.iter().enumerate().filter(|(i, _)| !(from..from + 4).contains(i)).map(|(_, line)| *line);
    let begun = kept.collect::<Vec<_>>().join("\n") + "\n" + whole;
    let rows_at = begun.find(HEADER).expect("the header") + HEADER.len() + 1;
    let positions =
        [0, 1, rows_at / 2, rows_at - 1, rows_at, rows_at + 7, (rows_at + begun.len()) / 2, begun.len() - 1];
    for written in positions.into_iter().chain([begun.len()]) {
        folder.put("out.csv.partial", &begun[..written]);
        finray(&with(&SWEEP, &["--out", &out])).done();
        assert!(folder.read("out.csv") == whole, "killed after {written} bytes");
        assert_eq!(folder.names(), ["all.csv", "out.csv"]);
        std::fs::remove_file(&out).expect("the result");
    }
}

/// Existing rows are kept and not computed again.
#[test]
fn rows_that_are_there_are_kept() {
    let folder = Folder::new();
    let out = folder.path("1.csv");
    let command = with(&SWEEP, &["--shard", "2/7", "--out", &out]);
    finray(&command).done();
    let whole = folder.read("1.csv");
    let rows_at = whole.find(HEADER).expect("the header") + HEADER.len() + 1;
    // The first block is complete and contains a mark; the second block lacks one row.
    let mark = |text: &str| text.replacen("linear,least-squares,0.0,", "marked,least-squares,0.0,", 1);
    let (head, rows) = whole.split_at(rows_at);
    let mut written: Vec<&str> = rows.split_inclusive('\n').take(2 * ROWS_IN_BLOCK).collect();
    written.pop();
    folder.put("1.csv.partial", format!("{head}{}", mark(&written.concat())));
    finray(&command).done();
    assert!(folder.read("1.csv") == format!("{head}{}", mark(rows)));
}

#[test]
fn a_killed_process_leaves_whole_blocks_to_go_on_with() {
    let folder = Folder::new();
    let out = folder.path("out.csv");
    let slow = [
        "sweep", PAPER, "--estimator", "least-squares", "--noise-mm", "0.067", "--force-n", "0.5,1,2", "--seeds", "50",
    ];
    let whole = finray(&slow).done();
    let mut run = command(&with(&slow, &["--out", &out])).spawn().expect("finray starts");
    let partial = folder.path("out.csv.partial");
    let long = || std::fs::metadata(&partial).is_ok_and(|file| file.len() > 40_000);
    while run.try_wait().expect("a process").is_none() && !long() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    run.kill().expect("it is killed");
    run.wait().expect("it ends");
    assert_eq!(folder.names(), ["out.csv.partial"], "killed before its end");
    let left = std::fs::metadata(&partial).expect("the rows").len();
    assert!(left > 40_000 && left < whole.len() as u64);
    finray(&with(&slow, &["--out", &out])).done();
    assert!(folder.read("out.csv") == whole);
    assert_eq!(folder.names(), ["out.csv"]);
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let with_threads = |threads: &str| {
        let output = command(&SWEEP).env("RAYON_NUM_THREADS", threads).output().expect("finray runs");
        assert!(output.status.success());
        output.stdout
    };
    let one = with_threads("1");
    assert!(one.starts_with(HEADER.as_bytes()));
    assert!(["2", "5", "16"].iter().all(|threads| with_threads(threads) == one));
}

#[test]
fn unfinished_rows_of_another_request_are_not_touched() {
    let folder = Folder::new();
    let out = folder.path("out.csv");
    let scene = folder.put("scene.toml", paper_with(&[("thickness_mm = 1.5", "thickness_mm = 1.6")]));
    finray(&with(&SWEEP, &["--shard", "1/7", "--out", &out])).done();
    let theirs = folder.read("out.csv");
    folder.put("out.csv.partial", &theirs);
    let changed = |position: usize, to: &'static str| {
        let mut command = SWEEP;
        command[position] = to;
        command.to_vec()
    };
    let mut other_scene = SWEEP.to_vec();
    other_scene[1] = &scene;
    for (command, shard, expected) in [
        (SWEEP.to_vec(), Some("2/7"), "another --shard"),
        (SWEEP.to_vec(), None, "another --shard"),
        (changed(3, "linear"), Some("1/7"), "another --truth"),
        (changed(5, "ridge"), Some("1/7"), "another --estimator"),
        (changed(7, "0.067"), Some("1/7"), "another --noise-mm"),
        (changed(9, "3"), Some("1/7"), "another --force-n"),
        (changed(11, "6"), Some("1/7"), "another --seeds"),
        (changed(15, "80"), Some("1/7"), "another grid of positions and directions"),
        (with(&SWEEP, &["--seed", "2"]), Some("1/7"), "another --seed"),
        (other_scene, Some("1/7"), "another scene"),
    ] {
        let shard = shard.map_or(Vec::new(), |shard| vec!["--shard", shard]);
        let message = finray(&[&command[..], &shard, &["--out", &out]].concat()).refused();
        assert_says(&message, &["out.csv.partial", "another request", expected]);
        assert_eq!(folder.read("out.csv.partial"), theirs);
        assert_eq!(folder.read("out.csv"), theirs);
    }
    for (name, content) in [("text", "my notes\n"), ("bytes", "# \u{0}\u{1}"), ("head", "# finray = 1\n")] {
        folder.put("out.csv.partial", content);
        let message = finray(&with(&SWEEP, &["--out", &out])).refused();
        assert_says(&message, &["out.csv.partial", "not a table of finray"]);
        assert_eq!(folder.read("out.csv.partial"), content, "{name}");
    }
}

#[test]
fn two_runs_do_not_write_one_file() {
    let folder = Folder::new();
    let out = folder.path("out.csv");
    let held = std::fs::File::create(folder.path("out.csv.partial")).expect("a file");
    held.lock().expect("a lock");
    assert_says(&finray(&with(&SWEEP, &["--out", &out])).refused(), &["another run is writing this file"]);
    held.unlock().expect("no lock");
    finray(&with(&SWEEP, &["--out", &out])).done();
    assert_eq!(folder.names(), ["out.csv"]);
}
