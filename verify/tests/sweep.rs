//! `finray sweep`, `--shard`, `finray merge` and runs that were stopped: always the bytes of one run.

mod common;

use common::*;

const HEADER: &str = "truth,estimator,noise_mm,s_mm,angle_deg,force_n,pictures,answered,mean_error,bias,spread,sigma_n,refusal,warned,covered,covered_warned";

/// A sweep of a moment with several of everything.
const SWEEP: [&str; 16] = [
    "sweep",
    PAPER,
    "--truth",
    "linear,corotational",
    "--estimator",
    "least-squares,ridge",
    "--noise-mm",
    "0.067,0",
    "--force-n",
    "3,0.5",
    "--seeds",
    "5",
    "--places",
    "12",
    "--step-deg",
    "40",
];
/// Blocks of [`SWEEP`]: two truths, twelve places, five directions; rows of each: two estimators, noises and forces.
const BLOCKS: usize = 2 * 12 * 5;
const ROWS_IN_BLOCK: usize = 2 * 2 * 2;
/// A map of a moment.
const MAP: [&str; 12] =
    ["map", PAPER, "--truth", "linear", "--noise-mm", "0.067", "--force-n", "1,2", "--seeds", "5", "--step-deg", "40"];

fn with<'a>(command: &[&'a str], further: &[&'a str]) -> Vec<&'a str> {
    [command, further].concat()
}

/// Writes all shards of a command and gives their paths, the last one first.
fn shards(folder: &Folder, command: &[&str], of: usize) -> Vec<String> {
    let shard = |number: usize| {
        let out = folder.path(&format!("{number}-of-{of}.csv"));
        finray(&with(command, &["--shard", &format!("{number}/{of}"), "--out", &out])).done();
        out
    };
    (1..=of).rev().map(shard).collect()
}

fn merged(shards: &[String], out: &str) -> Answer {
    let shards: Vec<&str> = shards.iter().map(String::as_str).collect();
    finray(&[&["merge"], &shards[..], &["--out", out]].concat())
}

#[test]
fn a_row_says_all_that_is_known_of_a_cell() {
    let text = finray(&SWEEP).done();
    assert_eq!(text.lines().next(), Some(HEADER));
    let table = Csv::of(&text);
    assert_eq!(table.rows.len(), BLOCKS * ROWS_IN_BLOCK);
    // Truth, place, direction, estimator, noise, force: the last one changes first.
    let key = |row: &[String]| -> Vec<String> { [0, 3, 4, 1, 2, 5].iter().map(|&i| row[i].clone()).collect() };
    let mut keys: Vec<_> = table.rows.iter().map(|row| key(row)).collect();
    assert_eq!(
        keys[..3].iter().map(|key| key[3..].join(" ")).collect::<Vec<_>>(),
        ["least-squares 0.0 0.5", "least-squares 0.0 3.0", "least-squares 0.067 0.5"]
    );
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), table.rows.len(), "every combination once");
    let numbers = |column| table.numbers(column);
    let (noise, pictures, answered) = (numbers("noise_mm"), numbers("pictures"), numbers("answered"));
    let (mean, bias, spread, sigma) = (numbers("mean_error"), numbers("bias"), numbers("spread"), numbers("sigma_n"));
    for i in 0..table.rows.len() {
        assert_eq!(pictures[i], if noise[i] > 0.0 { 5.0 } else { 1.0 });
        assert_eq!(answered[i], pictures[i]);
        assert!(mean[i] >= bias[i].abs());
        assert_eq!(spread[i] > 0.0, noise[i] > 0.0);
        // Without noise, what the model itself gets wrong remains.
        assert!(sigma[i] > 0.0 || noise[i] == 0.0);
    }
    assert!(table.texts("refusal").iter().all(|refusal| refusal.is_empty()));
}

/// Both are one computation.
#[test]
fn a_map_is_a_sweep_with_fewer_columns() {
    let map = Csv::of(&finray(&MAP).done());
    let sweep = Csv::of(&finray(&with(&["sweep"], &MAP[1..])).done());
    for column in &map.header {
        // Noise samples go by another name there.
        let of_sweep = if column == "samples" { "pictures" } else { column };
        assert_eq!(map.texts(column), sweep.texts(of_sweep), "{column}");
    }
    // Several forces: those of one cell stand together.
    assert_eq!(map.texts("force_n")[..4], ["1.0", "2.0", "1.0", "2.0"]);
}

/// The stated deviation is the one that `sense` states.
#[test]
fn the_stated_deviation_is_that_of_sense() {
    let arguments = ["--truth", "linear", "--noise-mm", "0.1", "--seeds", "3", "--force-n", "2", "--places", "12"];
    let table = Csv::of(&finray(&with(&["sweep", PAPER], &arguments)).done());
    let at = |row: &Vec<String>| row[3] == "76.5" && row[4] == "0.0";
    let row = table.rows.iter().position(at).expect("the middle of the plate");
    let shape = finray(&["solve", PAPER, "--kinematics", "linear", "--load-at", "76.5:2,0"]).done();
    let sense = ["sense", PAPER, "--displacements", "-", "--contact-at", "76.5", "--noise-mm", "0.1"];
    let sense = [&sense[..], &["--estimator", "least-squares"]].concat();
    let sigma = Csv::of(&finray_reading(shape.as_bytes(), &sense).done()).numbers("sigma_n");
    assert_close(&table.numbers("sigma_n")[row..=row], &sigma, LINEAR_ROUNDING);
}

#[test]
fn merged_shards_are_the_bytes_of_one_run() {
    let folder = Folder::new();
    let sweep = finray(&SWEEP).done();
    let map = folder.path("map.csv");
    finray(&with(&MAP, &["--out", &map])).done();
    // More shards than blocks: some have no rows.
    for of in [1, 3, 7, BLOCKS + 2] {
        let out = folder.path("merged.csv");
        let parts = shards(&folder, &SWEEP, of);
        assert_eq!(merged(&parts, &out).done(), "");
        assert!(folder.read("merged.csv") == sweep, "{of} shards");
        assert!(merged(&parts, "-").done() == sweep, "{of} shards");
        if of > 7 {
            continue;
        }
        assert_eq!(merged(&shards(&folder, &MAP, of), &out).done(), "");
        assert!(folder.read("merged.csv") == folder.read("map.csv"), "{of} shards");
        assert!(folder.read("merged.svg") == folder.read("map.svg"), "{of} shards");
    }
    let names = folder.names();
    assert!(names.iter().all(|name| !name.contains("partial")), "{names:?}");
    assert!(!names.contains(&"1-of-3.svg".to_owned()), "a shard has no picture");
}

/// The head keeps a scene to the letter, whatever its line ends and quotes.
#[test]
fn shards_of_any_scene_fit() {
    let folder = Folder::new();
    let scene = paper_with(&[("\n", "\r\n"), ("\"paper\"", "Q'a \"\"\" \\ # b'Q")]).replace('Q', "''") + "\t# the end";
    let scene = folder.put("scene.toml", scene);
    let mut command = MAP;
    command[1] = &scene;
    let out = folder.path("out.csv");
    finray(&with(&command, &["--out", &out])).done();
    merged(&shards(&folder, &command, 2), &folder.path("merged.csv")).done();
    assert!(folder.read("merged.csv") == folder.read("out.csv") && folder.read("merged.svg") == folder.read("out.svg"));
}

/// Whatever was written when a run was killed, the next one ends with the bytes of one run.
#[test]
fn a_run_that_was_killed_goes_on() {
    let folder = Folder::new();
    let out = folder.path("out.csv");
    let whole = finray(&SWEEP).done();
    // A shard is a head and rows; with its shard taken out it is what a run without shards has written at its end.
    let all = folder.path("all.csv");
    finray(&with(&SWEEP, &["--shard", "1/1", "--out", &all])).done();
    let shard = folder.read("all.csv");
    let head_lines = |line: &&str| line.starts_with('#');
    let head: Vec<&str> = shard.lines().take_while(head_lines).collect();
    let from = head.iter().position(|line| line.contains("[shard]")).expect("the shard's table");
    let kept = head.iter().enumerate().filter(|(i, _)| !(from..from + 4).contains(i)).map(|(_, line)| *line);
    let begun = kept.collect::<Vec<_>>().join("\n") + "\n" + &whole;
    let rows_at = begun.find(HEADER).expect("the header") + HEADER.len() + 1;
    let places = [0, 1, rows_at / 2, rows_at - 1, rows_at, rows_at + 7, (rows_at + begun.len()) / 2, begun.len() - 1];
    for written in places.into_iter().chain([begun.len()]) {
        folder.put("out.csv.partial", &begun[..written]);
        finray(&with(&SWEEP, &["--out", &out])).done();
        assert!(folder.read("out.csv") == whole, "killed after {written} bytes");
        assert_eq!(folder.names(), ["all.csv", "out.csv"]);
        std::fs::remove_file(&out).expect("the result");
    }
}

/// What is there is kept and not computed again.
#[test]
fn rows_that_are_there_are_kept() {
    let folder = Folder::new();
    let out = folder.path("1.csv");
    let command = with(&SWEEP, &["--shard", "2/7", "--out", &out]);
    finray(&command).done();
    let whole = folder.read("1.csv");
    let rows_at = whole.find(HEADER).expect("the header") + HEADER.len() + 1;
    // A mark in the first block, which is whole; of the second one a row is missing.
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
    let slow = ["sweep", PAPER, "--noise-mm", "0.067", "--force-n", "0.5,1,2", "--seeds", "50"];
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
    let changed = |place: usize, to: &'static str| {
        let mut command = SWEEP;
        command[place] = to;
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
        (changed(15, "80"), Some("1/7"), "another grid of places and directions"),
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
        assert_says(&message, &["out.csv.partial", "no table at all"]);
        assert_eq!(folder.read("out.csv.partial"), content, "{name}");
    }
}

#[test]
fn two_runs_do_not_write_one_file() {
    let folder = Folder::new();
    let out = folder.path("out.csv");
    let held = std::fs::File::create(folder.path("out.csv.partial")).expect("a file");
    held.lock().expect("a lock");
    assert_says(&finray(&with(&SWEEP, &["--out", &out])).refused(), &["another run is writing it"]);
    held.unlock().expect("no lock");
    finray(&with(&SWEEP, &["--out", &out])).done();
    assert_eq!(folder.names(), ["out.csv"]);
}

#[test]
fn shards_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    let out = folder.put("out.csv", "kept");
    let parts = shards(&folder, &SWEEP, 3);
    let foreign = folder.path("foreign.csv");
    finray(&with(&SWEEP, &["--seed", "2", "--shard", "1/3", "--out", &foreign])).done();
    let fourth = folder.path("fourth.csv");
    finray(&with(&SWEEP, &["--shard", "1/4", "--out", &fourth])).done();
    let map = folder.path("map.csv");
    finray(&with(&MAP, &["--shard", "1/3", "--out", &map])).done();
    let first = folder.read("1-of-3.csv");
    let torn = folder.put("torn.csv", &first[..first.len() - 9]);
    let short = folder.put("short.csv", first.trim_end().rsplit_once('\n').expect("rows").0.to_owned() + "\n");
    let whole = folder.put("whole.csv", finray(&SWEEP).done());
    let bytes = folder.put("bytes.csv", [b'#', 0xff, 0xfe]);
    let missing = folder.path("missing.csv");
    let [third, second, one] = [&parts[0], &parts[1], &parts[2]].map(String::as_str);
    for (shards, expected) in [
        (vec![one, third], vec!["of 3 shards, 2 were given", "missing: 2"]),
        (vec![third], vec!["missing: 1, 2"]),
        (vec![one, second, third, second], vec!["2-of-3.csv", "is shard 2/3", "each is needed once"]),
        (vec![one, one, third], vec!["is shard 1/3"]),
        (vec![second, &foreign, third], vec!["foreign.csv", "another --seed"]),
        (vec![one, second, third, &fourth], vec!["fourth.csv", "another number of shards"]),
        (vec![second, &map, third], vec!["map.csv", "another command"]),
        (vec![&torn, second, third], vec!["torn.csv", "not a whole shard 1/3"]),
        (vec![&short, second, third], vec!["short.csv", "expected 320 rows, found 319"]),
        (vec![one, second, &whole], vec!["whole.csv", "is no shard"]),
        (vec![one, second, &bytes], vec!["bytes.csv", "is no shard"]),
        (vec![one, second, PAPER], vec!["paper.toml", "is no shard"]),
        (vec![one, second, &missing], vec!["missing.csv", "cannot be read"]),
    ] {
        let message = finray(&[&["merge"], &shards[..], &["--out", &out]].concat()).refused();
        assert_says(&message, &expected);
        assert_eq!(folder.read("out.csv"), "kept");
    }
    finray(&["merge"]).refused();
    for shard in ["0/3", "4/3", "1", "1/0", "a/b", "-1/2"] {
        assert_says(&finray(&with(&SWEEP, &[&format!("--shard={shard}")])).refused(), &["expected I/N"]);
    }
}

#[test]
fn sweeps_that_make_no_sense_are_refused() {
    for (arguments, expected) in [
        (["--force-n", "1,0"], "expected more than zero"),
        (["--noise-mm", "0.1,-1"], "expected zero or more"),
        (["--places", "0"], "0"),
        (["--step-deg", "0"], "expected 0.01 or more"),
        (["--truth", "linear,plastic"], "linear, corotational"),
        (["--estimator", "ridge,guess"], "least-squares"),
        (["--network", "net.safetensors"], "--estimator network"),
    ] {
        assert_says(&finray(&with(&["sweep", PAPER], &arguments)).refused(), &[expected]);
    }
    // No network ships for another finger.
    assert_says(&finray(&["sweep", SPRING_STEEL, "--estimator", "network"]).refused(), &["no network ships"]);
}

/// Networks answer for the contacts that they were trained for, and the nonlinear estimator everywhere.
#[test]
fn every_estimator_can_be_mapped() {
    let folder = Folder::new();
    let out = folder.path("map.csv");
    let nodes = ["--places", "12", "--step-deg", "40", "--noise-mm", "0.067", "--seeds", "3", "--out", &out];
    // Nodes 14 to 24 alone and any of 13 to 24 ship, of all directions the normal.
    for (estimator, answered) in [("network", 12), ("nonlinear", 60)] {
        finray(&[&["map", PAPER, "--estimator", estimator], &nodes[..]].concat()).done();
        let map = Csv::of(&folder.read("map.csv"));
        let errors: Vec<f64> = map.texts("mean_error").iter().filter_map(|error| error.parse().ok()).collect();
        assert_eq!(errors.len(), answered, "{estimator}");
        // 3 N with noise: far below the ten percent of linear sensing.
        assert!(errors.iter().all(|error| *error < 0.1), "{estimator}: {errors:?}");
        let empty = errors.len() < map.rows.len();
        assert_eq!(folder.read("map.svg").contains("no equilibrium, or refused"), empty);
    }
    let reasons = ["sweep", PAPER, "--estimator", "network", "--places", "12", "--step-deg", "40"];
    let table = Csv::of(&finray(&reasons).done());
    let refusals = table.texts("refusal");
    assert_eq!(refusals.iter().filter(|refusal| refusal.contains("no network ships for these contacts")).count(), 48);
}

/// Where the finger cannot carry the force, a row says so.
#[test]
fn a_force_without_equilibrium_is_named() {
    let folder = Folder::new();
    let scene = folder.put("scene.toml", paper_with(&[("count = 11", "count = 0")]));
    let table = Csv::of(&finray(&["sweep", &scene, "--force-n", "0.15", "--step-deg", "40"]).done());
    let empty = table.rows.iter().filter(|row| row[8].is_empty());
    let mut count = 0;
    for row in empty {
        assert!(row[12].contains("no equilibrium") && row[6] == "0" && row[7] == "0", "{row:?}");
        count += 1;
    }
    assert!(count > 0 && count < table.rows.len());
}
