//! The program `finray`: reads arguments, runs a command, writes files. The physics is in `finray_model`; checks and maps are in `finray_verify`.
#![forbid(unsafe_code)]
// The macros that these lints deny panic if standard output or error is closed; `print_message` and `write_file` do not.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod commands;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
#[cfg(feature = "train")]
use commands::train;
use commands::{Failure, bad_input, not_computed};
use commands::{
    calibrate, grasp, gripper, guide, lens, live, locate, map, merge, press, render, report, sense, setup, solve,
    sweep, words,
};
use finray_files::write_file;
use std::path::Path;
use std::process::ExitCode;

/// Estimate contact forces from the shape of a fin-ray finger, and map where estimates are reliable.
///
/// A scene file (TOML) describes the finger; start from fixtures/scenes/paper.toml. Lengths are in
/// mm, forces in N, moduli in MPa. The angle of a force is in degrees from the front plate's inward
/// normal, positive towards the tip. `finray guide` lists the guides, one for each task.
///
/// Exit codes: 0 success; 1 the computation failed, or a result could not be written; 2 bad input,
/// or the input does not determine a unique answer.
#[derive(Parser)]
#[command(name = "finray", version, arg_required_else_help = true)]
struct Arguments {
    /// Omit notes and the summary line on standard error
    #[arg(long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Report(report::Arguments),
    Solve(solve::Arguments),
    Sense(sense::Arguments),
    Calibrate(calibrate::Arguments),
    Map(map::Arguments),
    Sweep(sweep::Arguments),
    Merge(merge::Arguments),
    Press(press::Arguments),
    Render(render::Arguments),
    Setup(setup::Arguments),
    Locate(locate::Arguments),
    Live(live::Arguments),
    Lens(lens::Arguments),
    Gripper(gripper::Arguments),
    Grasp(grasp::Arguments),
    Guide(guide::Arguments),
    #[cfg(feature = "train")]
    Train(train::Arguments),
    /// Print a shell completion script, for instance: finray completions bash > ~/.finray.bash
    Completions {
        /// Shell that reads the script
        shell: clap_complete::Shell,
    },
    /// Print a man page in roff, for instance: finray man sense > ~/.local/share/man/man1/finray-sense.1
    Man {
        /// Command that the page describes [default: the whole program]
        command: Option<String>,
    },
}

fn main() -> ExitCode {
    let command = words::taking_negative_numbers(Arguments::command());
    let matches = command.try_get_matches_from(words::readable(std::env::args_os()));
    let arguments = match matches.and_then(|matches| Arguments::from_arg_matches(&matches)) {
        Ok(arguments) => arguments,
        Err(answer) => return commands::print_answer(&answer),
    };
    if arguments.quiet {
        commands::omit_notes();
    }
    let outcome = match arguments.command {
        Command::Report(arguments) => report::run(&arguments).map(Some),
        Command::Solve(arguments) => solve::run(&arguments).map(Some),
        Command::Sense(arguments) => sense::run(&arguments).map(Some),
        Command::Calibrate(arguments) => calibrate::run(&arguments).map(Some),
        Command::Map(arguments) => map::run(&arguments).map(Some),
        Command::Sweep(arguments) => sweep::run(&arguments).map(Some),
        Command::Merge(arguments) => merge::run(&arguments).map(Some),
        Command::Press(arguments) => press::run(&arguments).map(Some),
        Command::Render(arguments) => render::run(&arguments).map(Some),
        Command::Setup(arguments) => setup::run(&arguments).map(Some),
        Command::Locate(arguments) => locate::run(&arguments).map(Some),
        Command::Live(arguments) => live::run(&arguments).map(Some),
        Command::Lens(arguments) => lens::run(&arguments).map(Some),
        Command::Gripper(arguments) => gripper::run(&arguments).map(Some),
        Command::Grasp(arguments) => grasp::run(&arguments).map(Some),
        Command::Guide(arguments) => guide::run(&arguments),
        #[cfg(feature = "train")]
        Command::Train(arguments) => train::run(&arguments).map(Some),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "finray", &mut script);
            write_file(Path::new("-"), script).map(|()| None).map_err(Failure::from)
        }
        Command::Man { command } => man_page(command.as_deref()).map(|()| None),
    };
    match outcome {
        Ok(done) => {
            done.filter(|_| !arguments.quiet).iter().for_each(commands::print_message);
            ExitCode::SUCCESS
        }
        Err(failure) => failure.report(),
    }
}

/// Prints the man page of a command, or of the program.
fn man_page(command: Option<&str>) -> Result<(), Failure> {
    let mut program = Arguments::command();
    // `build` gives the subcommands full names such as "finray sense", and adds global options such as `--quiet` to each subcommand.
    program.build();
    let page_of = match command {
        None => program,
        Some(name) => {
            let all: Vec<&str> = program.get_subcommands().map(clap::Command::get_name).collect();
            let unknown = || bad_input(format!("COMMAND: expected one of {}, found {name:?}", all.join(", ")));
            program.find_subcommand(name).cloned().ok_or_else(unknown)?
        }
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(page_of).render(&mut page).map_err(not_computed)?;
    Ok(write_file(Path::new("-"), page)?)
}
