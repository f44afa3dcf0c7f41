//! Numbers of the command line: what is out of range is refused by value and range, as everywhere.

use clap::Command;
use std::ffi::OsString;
use std::fmt::Display;
use std::str::FromStr;

/// Reads a whole number from `least` to `greatest`.
pub fn whole<T>(
    least: T,
    greatest: T,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + Display + PartialOrd + Copy + Send + Sync + 'static,
{
    move |text: &str| {
        let number = text.parse().ok().filter(|number| (least..=greatest).contains(number));
        number.ok_or_else(|| format!("it must be a whole number from {least} to {greatest}"))
    }
}

/// Takes `-1` behind an option for its value, that it may be refused as such, and not for an argument that nobody knows.
#[must_use]
pub fn taking_negative(command: Command) -> Command {
    command
        .mut_args(|argument| {
            let takes = !argument.is_positional() && argument.get_action().takes_values();
            if takes { argument.allow_negative_numbers(true) } else { argument }
        })
        .mut_subcommands(taking_negative)
}

/// Words of the command line, with a negative number that clap takes for none (`-1e-3`, `-.5`) joined to the option before it.
pub fn joining_negative(words: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let is_negative = |word: &OsString| {
        word.to_str().is_some_and(|text| text.starts_with('-') && text.parse::<f64>().is_ok())
    };
    let is_open = |word: &OsString| {
        word.to_str().is_some_and(|text| text.starts_with("--") && !text.contains('='))
    };
    let mut joined: Vec<OsString> = Vec::new();
    for word in words {
        match joined.last_mut() {
            Some(option) if is_negative(&word) && is_open(option) => {
                option.push("=");
                option.push(word);
            }
            _ => joined.push(word),
        }
    }
    joined
}
