//! Output: results are written completely to `--out` or standard output, or not at all.

use crate::kit::*;
use std::io::pipe;
use std::process::Stdio;

const MEASURED: &str = "node,ux_mm,uy_mm\n7,0.1,-1\n18,0.1,-1\n";
const WEIGHTS: &str = "case,load_node,fx_n,fy_n,node,ux_mm,uy_mm\na,19,0,-1,7,0.1,-1\na,19,0,-1,18,0.1,-1\n";

/// A folder with input files, and for each command a list of arguments with which it succeeds quickly; the lists lack `--out`.
fn commands() -> (Folder, Vec<Vec<String>>) {
    let folder = Folder::new();
    let measured = folder.put("measured.csv", MEASURED);
    let weights = folder.put("weights.csv", WEIGHTS);
    let commands = [
        vec!["solve", PAPER, "--load", "19:0,-1"],
        vec!["sense", PAPER, "--displacements", &measured, "--contact", "19"],
        vec!["calibrate", PAPER, "--measurements", &weights],
        vec!["map", PAPER, "--estimator", "least-squares", "--truth", "linear"],
    ];
    let commands = commands.map(|command| command.into_iter().map(str::to_owned).collect()).to_vec();
    (folder, commands)
}

fn run(command: &[String], further: &[&str]) -> Answer {
    finray(&command.iter().map(String::as_str).chain(further.iter().copied()).collect::<Vec<_>>())
}

#[test]
fn a_file_gets_what_standard_output_gets() {
    let (folder, commands) = commands();
    for command in commands {
        let text = run(&command, &[]).done();
        assert_eq!(run(&command, &["--out", "-"]).done(), text);
        let out = folder.put("out.csv", "an older and longer result\n".repeat(10_000));
        assert_eq!(run(&command, &["--out", &out]).done(), "");
        assert_eq!(folder.read("out.csv"), text);
        // Further columns of `sense` are empty for a stated contact.
        let cells = Csv::of(&text).rows.into_iter().flat_map(|row| row.into_iter().take(3)).collect::<Vec<_>>();
        assert!(text.ends_with('\n') && cells.iter().all(|cell| !cell.is_empty()));
    }
    assert_eq!(folder.names(), ["measured.csv", "out.csv", "out.svg", "weights.csv"]);
}

#[test]
fn a_command_ends_with_what_was_done_and_where_it_is() {
    let (folder, commands) = commands();
    let out = folder.path("out.csv");
    for command in commands {
        let summary = run(&command, &[]).summary.expect("a last line");
        assert!(!summary.contains("written to"), "{summary}");
        let said = run(&command, &["--out", &out]).summary.expect("a last line");
        assert!(said.starts_with(&format!("{summary}; written to {out}")) || command[0] == "map", "{said}");
        let quiet = run(&command, &["--quiet", "--out", &out]);
        assert_eq!((quiet.summary, quiet.err.as_str()), (None, ""));
    }
    let map =
        finray(&["map", "--places", "4", "--step-deg", "90", "--force-n", "1", "--noise-mm", "0.02", "--out", &out]);
    let svg = folder.path("out.svg");
    assert_eq!(
        map.summary.as_deref(),
        Some(&*format!(
            "done: 100 % trusted (contact known, error up to 10 %, 0.02 mm noise), 0 % of samples refused, 1 % with a warning; \
             written to {out}, {svg}"
        ))
    );
}

#[test]
fn the_result_may_take_the_place_of_the_input() {
    let folder = Folder::new();
    let file = folder.put("file.csv", MEASURED);
    finray(&["sense", PAPER, "--displacements", &file, "--contact", "19", "--out", &file]).done();
    assert!(folder.read("file.csv").starts_with("contact,"));
}

#[test]
fn an_error_leaves_the_file_as_it_was_and_nothing_beside_it() {
    let folder = Folder::new();
    let kept = "kept \u{b5}m\r\n";
    let out = folder.put("out.csv", kept);
    let bad = folder.put("bad.csv", "node,ux_mm,uy_mm\n7,0,?\n");
    let names = folder.names();
    let missing = folder.path("missing");
    for (code, command) in [
        (2, vec!["solve", PAPER, "--load", "1:0,-1"]),
        (2, vec!["solve", PAPER, "--load", "19:0,down"]),
        (2, vec!["solve", &missing, "--load", "19:0,-1"]),
        (2, vec!["solve", &bad, "--load", "19:0,-1"]),
        (1, vec!["solve", PAPER, "--load", "19:-40,-200"]),
        (2, vec!["sense", PAPER, "--displacements", &bad, "--contact", "19"]),
        (2, vec!["sense", PAPER, "--displacements", &missing, "--contact", "19"]),
        (2, vec!["sense", PAPER, "--displacements", &bad, "--contact", "1"]),
        (2, vec!["calibrate", PAPER, "--measurements", &bad]),
        (2, vec!["map", &bad]),
        (2, vec!["map", PAPER, "--force-n", "0"]),
    ] {
        let answer = finray(&[&command[..], &["--out", &out]].concat());
        assert_eq!(answer.code, Some(code), "{command:?}: {}", answer.err);
        assert_eq!(folder.read("out.csv"), kept, "{command:?}");
        assert_eq!(folder.names(), names, "{command:?}");
    }
}

/// The message names the file that cannot be written, and not the temporary file beside it.
#[test]
fn a_path_that_cannot_be_written_is_named() {
    let (folder, commands) = commands();
    let names = folder.names();
    for command in commands {
        for place in ["no-such-folder/out.csv", "measured.csv/out.csv", ""] {
            let out = folder.path(place);
            let message = run(&command, &["--out", &out]).failed();
            assert_says(&message, &[&out, "cannot be written"]);
            assert!(!message.contains(".finray-") && !message.contains("at path"), "{message}");
            assert_eq!(folder.names(), names, "{command:?}");
        }
    }
}

/// A map has two files: if one file cannot be written, the other file is not changed.
#[test]
fn a_map_is_written_with_its_figure_or_not_at_all() {
    let folder = Folder::new();
    let out = folder.put("map.csv", "kept");
    std::fs::create_dir(folder.path("map.svg")).expect("a folder");
    let message = finray(&["map", PAPER, "--estimator", "least-squares", "--truth", "linear", "--out", &out]).failed();
    assert_says(&message, &["map.svg", "cannot be written"]);
    assert_eq!(folder.names(), ["map.csv", "map.svg"]);
    assert_eq!(folder.read("map.csv"), "kept");
}

/// A closed pipe is no error, as in `finray solve ... | head -1`.
#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let (_folder, mut commands) = commands();
    commands.push(["completions", "bash"].map(str::to_owned).to_vec());
    commands.push(["solve", "--help"].map(str::to_owned).to_vec());
    for arguments in commands {
        let (reader, writer) = pipe().expect("a pipe");
        drop(reader);
        let arguments: Vec<_> = arguments.iter().map(String::as_str).collect();
        let run = command(&arguments).stdin(Stdio::null()).stdout(writer).output().expect("finray runs");
        let message = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(0), "{arguments:?}");
        assert!(message.lines().all(|line| line.starts_with("done: ")), "{arguments:?}: {message}");
    }
}

/// A full disk is an error, unlike a reader that has closed the pipe.
#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error() {
    let (_folder, commands) = commands();
    for command in commands {
        assert_says(&run(&command, &["--out", "/dev/full"]).failed(), &["/dev/full: cannot be written"]);
        run(&command, &["--out", "/dev/null"]).done();
    }
    assert!(!names_in(std::path::Path::new("/dev")).iter().any(|name| name == "null.svg" || name == "full.svg"));
}

#[test]
fn standard_input_is_read_once() {
    let scene = std::fs::read(PAPER).expect("the scene");
    for arguments in
        [&["sense", "-", "--displacements", "-", "--contact", "19"][..], &["calibrate", "-", "--measurements", "-"]]
    {
        assert_says(&finray_reading(&scene, arguments).refused(), &["cannot both be -"]);
    }
}

/// Messages that cannot be written are lost; result and exit code are unaffected.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_error_changes_no_exit_code() {
    let (folder, mut commands) = commands();
    let missing = folder.path("missing.toml");
    // The added commands cause a warning, a refusal, a failure, and an error for an unknown argument.
    commands.push(["solve", PAPER, "--load", "24:0,-8"].map(str::to_owned).to_vec());
    commands.push(["solve", &missing, "--load", "24:0,-8"].map(str::to_owned).to_vec());
    commands.push(["solve", PAPER, "--load", "19:-40,-200"].map(str::to_owned).to_vec());
    commands.push(["solve", PAPER, "--lood", "19:0,-1"].map(str::to_owned).to_vec());
    for arguments in commands {
        let heard = run(&arguments, &[]);
        let full = std::fs::File::options().write(true).open("/dev/full").expect("the device");
        let arguments: Vec<_> = arguments.iter().map(String::as_str).collect();
        let unheard = command(&arguments).stdin(Stdio::null()).stderr(full).output().expect("finray runs");
        assert_eq!((unheard.status.code(), unheard.stdout), (heard.code, heard.out.into_bytes()), "{arguments:?}");
    }
}

/// Help and version are results: if they cannot be written, the command fails as for any other result.
#[cfg(target_os = "linux")]
#[test]
fn help_and_version_on_a_full_device_are_errors() {
    for arguments in [&["--help"][..], &["--version"], &["help", "solve"], &["solve", "-h"], &["completions", "bash"]] {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("the device");
        let run = command(arguments).stdin(Stdio::null()).stdout(full).output().expect("finray runs");
        let message = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "{arguments:?}: {message}");
        assert_says(&message, &["error: standard output: cannot be written"]);
    }
}

#[cfg(unix)]
mod modes {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    fn mode(path: &str) -> u32 {
        std::fs::metadata(path).expect("the file").permissions().mode() & 0o7777
    }

    fn with_mode(path: &str, mode: u32) {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).expect("a mode");
    }

    /// Runs `finray` with the given umask.
    fn under_umask(umask: &str, arguments: &[&str]) {
        let script = format!("umask {umask}; exec \"$@\"");
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_finray")]).args(arguments);
        assert!(shell.status().expect("a shell").success(), "{arguments:?}");
    }

    #[test]
    fn new_results_obey_the_umask_and_old_ones_keep_their_mode() {
        let folder = Folder::new();
        let (new, old) = (folder.path("new.csv"), folder.put("old.csv", "older"));
        let (map, figure) = (folder.path("map.csv"), folder.path("map.svg"));
        for (umask, expected) in [("077", 0o600), ("022", 0o644), ("002", 0o664)] {
            let _ = std::fs::remove_file(&new);
            under_umask(umask, &["solve", PAPER, "--load", "19:0,-1", "--out", &new]);
            assert_eq!(mode(&new), expected, "umask {umask}");
            for kept in [0o640, 0o600, 0o755] {
                with_mode(&old, kept);
                under_umask(umask, &["solve", PAPER, "--load", "19:0,-1", "--out", &old]);
                assert_eq!(mode(&old), kept, "umask {umask}");
            }
        }
        under_umask("027", &["map", PAPER, "--estimator", "least-squares", "--truth", "linear", "--out", &map]);
        assert_eq!([mode(&map), mode(&figure)], [0o640; 2]);
    }

    /// A read-only file is refused also for a superuser, who could write the file.
    #[test]
    fn a_read_only_result_is_kept() {
        let (folder, commands) = commands();
        let out = folder.put("out.csv", "kept");
        let link = folder.path("link.csv");
        symlink("out.csv", &link).expect("a link");
        with_mode(&out, 0o444);
        let names = folder.names();
        for command in commands {
            for path in [&out, &link] {
                assert_says(
                    &run(&command, &["--out", path]).failed(),
                    &[path, "cannot be written: the file is read-only"],
                );
                assert_eq!((folder.read("out.csv").as_str(), folder.names()), ("kept", names.clone()));
            }
        }
    }

    #[test]
    fn a_link_leads_to_the_file_that_is_written() {
        let folder = Folder::new();
        std::fs::create_dir(folder.path("results")).expect("a folder");
        let target = folder.put("results/out.csv", "older");
        with_mode(&target, 0o640);
        let links = ["near.csv", "far.csv", "dangling.csv"].map(|name| folder.path(name));
        symlink("results/out.csv", &links[0]).expect("a link");
        symlink(folder.path("near.csv"), &links[1]).expect("a link");
        symlink("results/new.csv", &links[2]).expect("a link");
        for (link, written) in links.iter().zip(["results/out.csv", "results/out.csv", "results/new.csv"]) {
            finray(&["solve", PAPER, "--load", "19:0,-1", "--out", link]).done();
            assert!(std::fs::symlink_metadata(link).expect("the link").is_symlink(), "{link}");
            assert!(folder.read(written).starts_with("node,"), "{link}");
        }
        assert_eq!(mode(&target), 0o640);
        symlink("round.csv", folder.path("round.csv")).expect("a link");
        let message = finray(&["solve", PAPER, "--load", "19:0,-1", "--out", &folder.path("round.csv")]).failed();
        assert_says(&message, &["round.csv", "cannot be written", "loop"]);
        assert_eq!(names_in(std::path::Path::new(&folder.path("results"))), ["new.csv", "out.csv"]);
    }
}
