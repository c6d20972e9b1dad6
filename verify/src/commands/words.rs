//! The words of the command line before clap reads them: numbers below zero are values, and `help --help` is help.

use clap::{Arg, Command};
use std::ffi::{OsStr, OsString};

/// The command with every option taking a number below zero as its value, so that the option's own check answers.
pub fn taking_negative_numbers(command: Command) -> Command {
    let taking = |arg: Arg| {
        let is_number =
            arg.get_long().is_some() && arg.get_action().takes_values() && !arg.is_allow_hyphen_values_set();
        if is_number { arg.allow_negative_numbers(true) } else { arg }
    };
    command.mut_subcommands(move |command| command.mut_args(taking))
}

/// The words as clap is to read them. Lists that begin with a number below zero, as `-5:1,0` and `-5@auto`, get a space before them: for clap they
/// are options otherwise, and every parser of ours trims what it reads.
pub fn readable(words: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let list = |word: OsString| if begins_below_zero(&word) { [" ".into(), word].into_iter().collect() } else { word };
    let mut words: Vec<OsString> = words.map(list).collect();
    if words.len() > 2 && words[1] == "help" && words[2..].iter().all(|word| word == "--help" || word == "-h") {
        words.truncate(2);
    }
    words
}

/// Whether a word is no single number, but all up to a direction is of numbers, the first below zero.
fn begins_below_zero(word: &OsStr) -> bool {
    let Some(text) = word.to_str() else { return false };
    let numbers = text.split('@').next().unwrap_or_default();
    let is_of_numbers = |c: char| c.is_ascii_digit() || ".,:+-eE".contains(c);
    let starts = |c: char| c.is_ascii_digit() || c == '.';
    text.parse::<f64>().is_err()
        && numbers.strip_prefix('-').is_some_and(|rest| rest.starts_with(starts))
        && numbers.chars().all(is_of_numbers)
}
