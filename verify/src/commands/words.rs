//! Prepares command-line arguments for clap: negative numbers become values, and `help --help` prints the help.

use clap::{Arg, Command};
use std::ffi::{OsStr, OsString};

/// Lets every option accept a negative number as its value, so that the option's parser reports an invalid number.
pub fn taking_negative_numbers(command: Command) -> Command {
    let taking = |arg: Arg| {
        let is_number =
            arg.get_long().is_some() && arg.get_action().takes_values() && !arg.is_allow_hyphen_values_set();
        if is_number { arg.allow_negative_numbers(true) } else { arg }
    };
    command.mut_subcommands(move |command| command.mut_args(taking))
}

/// Arguments in a form that clap accepts. A list that begins with a negative number, such as `-5:1,0` or `-5@auto`, gets a leading space:
/// clap would otherwise read the list as an option. All parsers of this program trim their input.
pub fn readable(words: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let list = |word: OsString| if begins_below_zero(&word) { [" ".into(), word].into_iter().collect() } else { word };
    let mut words: Vec<OsString> = words.map(list).collect();
    if words.len() > 2 && words[1] == "help" && words[2..].iter().all(|word| word == "--help" || word == "-h") {
        words.truncate(2);
    }
    words
}

/// Whether an argument is a list that starts with a negative number: it has only numbers and separators before the first `@`, and is not a single
/// number.
fn begins_below_zero(word: &OsStr) -> bool {
    let Some(text) = word.to_str() else { return false };
    let numbers = text.split('@').next().unwrap_or_default();
    let is_of_numbers = |c: char| c.is_ascii_digit() || ".,:+-eE".contains(c);
    let starts = |c: char| c.is_ascii_digit() || c == '.';
    text.parse::<f64>().is_err()
        && numbers.strip_prefix('-').is_some_and(|rest| rest.starts_with(starts))
        && numbers.chars().all(is_of_numbers)
}
