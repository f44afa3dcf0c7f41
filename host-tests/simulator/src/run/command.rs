//! An operator's command in words, as it is typed and as it stands in files.

use super::jog::parse_jog;
use anyhow::{Context, Result, anyhow, bail, ensure};
pub use splineway::wire::Command;
use std::ops::RangeInclusive;

/// Feed overrides, per cent.
const FEED: RangeInclusive<u16> = 0..=200;
/// Overrides of rapids, per cent.
const RAPID: RangeInclusive<u16> = 0..=100;

/// A command as a word: hold, resume, stop, abort, "feed 50", "rapid 25", "single on".
///
/// # Errors
/// Names what is not understood, and the range of what is out of it.
pub fn parse_command(text: &str) -> Result<Command> {
    let mut words = text.split_whitespace();
    let word = words.next().unwrap_or("");
    let behind = text.trim_start().get(word.len()..).unwrap_or("");
    if let Some(jog) = parse_jog(word, behind.trim())? {
        return Ok(Command::Jog(jog));
    }
    let value = words.next();
    if let Some(extra) = words.next() {
        bail!("\"{extra}\" is too much in \"{}\"", text.trim());
    }
    let alone = |command| {
        ensure!(value.is_none(), "\"{word}\" takes no value; \"{}\" is not obeyed", text.trim());
        Ok(command)
    };
    match word {
        "hold" | "!" => alone(Command::Hold),
        "resume" | "~" => alone(Command::Resume),
        "stop" => alone(Command::Stop),
        "abort" => alone(Command::Abort),
        "quick-hold" => alone(Command::QuickHold),
        "quick-abort" => alone(Command::QuickAbort),
        "jog-cancel" => alone(Command::CancelJog),
        "feed" => Ok(Command::FeedOverride(percent(word, value, FEED)?)),
        "rapid" => Ok(Command::RapidOverride(percent(word, value, RAPID)?)),
        "single" => match value {
            Some("on") => Ok(Command::SingleBlock(true)),
            Some("off") => Ok(Command::SingleBlock(false)),
            _ => bail!("\"single\" needs on or off"),
        },
        _ => bail!(
            "\"{}\" is no command; known are hold, quick-hold, resume, stop, abort, quick-abort, feed PERCENT, \
             rapid PERCENT, single on, single off, jog, jog-step, jog-to, jog-back, jog-cancel",
            text.trim()
        ),
    }
}

fn percent(word: &str, value: Option<&str>, range: RangeInclusive<u16>) -> Result<u16> {
    let (least, most) = (range.start(), range.end());
    let text =
        value.with_context(|| format!("\"{word}\" needs a number, {least} to {most} per cent"))?;
    let digits = text.strip_suffix('%').unwrap_or(text);
    let number: f64 = digits.parse().map_err(|_| {
        anyhow!("\"{text}\" is no number of per cent; {word} takes {least} to {most}")
    })?;
    ensure!(
        number >= f64::from(*least) && number <= f64::from(*most),
        "{word} is {text}; it must be {least} to {most} per cent"
    );
    ensure!(number.fract() == 0.0, "{word} is {text}; it must be a whole number of per cent");
    Ok(number as u16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_words() {
        for (text, command) in [
            ("hold", Command::Hold),
            (" ! ", Command::Hold),
            ("~", Command::Resume),
            ("stop", Command::Stop),
            ("abort", Command::Abort),
            ("quick-hold", Command::QuickHold),
            ("quick-abort", Command::QuickAbort),
            ("feed 50", Command::FeedOverride(50)),
            ("feed 0", Command::FeedOverride(0)),
            ("feed 200%", Command::FeedOverride(200)),
            ("rapid 25%", Command::RapidOverride(25)),
            ("single on", Command::SingleBlock(true)),
            ("single off", Command::SingleBlock(false)),
        ] {
            assert_eq!(parse_command(text).unwrap(), command);
        }
    }

    #[test]
    fn what_is_not_understood_is_refused() {
        for (text, part) in [
            ("feed 500", "feed is 500; it must be 0 to 200 per cent"),
            ("feed 201", "0 to 200"),
            ("feed -1", "0 to 200"),
            ("feed 70000", "0 to 200"),
            ("feed 1e3", "0 to 200"),
            ("feed nan", "0 to 200"),
            ("feed inf", "0 to 200"),
            ("feed 50.5", "whole number"),
            ("feed", "needs a number, 0 to 200"),
            ("feed much", "no number"),
            ("feed 50%%", "no number"),
            ("feed 5 0", "too much"),
            ("rapid 101", "rapid is 101; it must be 0 to 100 per cent"),
            ("rapid", "0 to 100"),
            ("hold 5", "takes no value"),
            ("resume now", "takes no value"),
            ("stop 1", "takes no value"),
            ("abort abort", "takes no value"),
            ("single", "on or off"),
            ("single maybe", "on or off"),
            ("single on off", "too much"),
            ("HOLD", "no command"),
            ("jump", "no command"),
            ("hold;", "no command"),
            ("feed50", "no command"),
        ] {
            let error = parse_command(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
