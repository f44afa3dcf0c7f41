//! Numbers of the command line: what is out of range is refused by value and range, as everywhere.

use anyhow::Error;
use clap::Command;
use splineway::machine::Quantity;
use splineway::number::Range;
use std::ffi::OsString;
use std::fmt::{self, Display};
use std::str::FromStr;

/// Options that do not go together: wrong usage, as what clap itself refuses.
#[derive(Debug)]
pub struct Usage(String);

impl Usage {
    /// The exit code, which is clap's.
    pub const CODE: u8 = 2;

    /// As what commands return.
    pub fn error(words: impl Into<String>) -> Error {
        Error::new(Self(words.into()))
    }
}

impl Display for Usage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

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

/// Reads one of some numbers.
pub fn one_of(
    numbers: &'static [usize],
) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    move |text: &str| {
        let number = text.parse().ok().filter(|number| numbers.contains(number));
        number.ok_or_else(|| format!("it must be one of {numbers:?}"))
    }
}

/// Reads a number that is `fits`, in `words`.
fn number(
    fits: impl Fn(f64) -> bool + Clone + Send + Sync + 'static,
    words: String,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text: &str| {
        let number = text.parse().ok().filter(|&number| fits(number));
        number.ok_or_else(|| format!("it must be {words}").trim_end().to_owned())
    }
}

/// Reads a number from `least` to `greatest`.
pub fn between(
    least: f64,
    greatest: f64,
    unit: &str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    let words = format!("{least} to {greatest} {unit}");
    number(move |number| (least..=greatest).contains(&number), words)
}

/// Reads a number above 0 and at most `greatest`.
pub fn above_zero(
    greatest: f64,
    unit: &str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    let words = format!("above 0 and at most {greatest} {unit}");
    number(move |number| number > 0.0 && number <= greatest, words)
}

/// Reads any number above 0.
pub fn positive() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    number(|number| number > 0.0 && number.is_finite(), "above 0".to_owned())
}

/// Reads a value of a setting of the core: its range is the core's.
pub fn setting(
    quantity: Quantity,
    unit: &str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    let Range { least, greatest } = quantity.range();
    between(least, greatest, unit)
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
