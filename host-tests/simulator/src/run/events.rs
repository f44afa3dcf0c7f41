//! An operator's commands at given times, for simulated runs.

use super::command::{Command, parse_command};
use super::seek::{Seek, parse_seek};
use crate::input;
use anyhow::{Context, Result, bail};
use std::path::Path;

/// What happens at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// The operator gives a command.
    Command(Command),
    /// A probe, homing, or an input.
    Seek(Seek),
    /// The producer sends nothing for this many seconds.
    Starve(f64),
}

/// A command at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Seconds since the start.
    pub time: f64,
    /// What is asked for.
    pub action: Action,
}

/// Commands in order of time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Events {
    list: Vec<Event>,
}

/// What a file of events looks like.
pub const FORMAT: &str = "\
Events are lines \"time, action[, value]\", times in seconds since the start:
  hold | quick-hold (by the stop limits) | resume | stop (at the end of the block) | abort | quick-abort | feed, 0..200 | rapid, 0..100 (per cent)
  single, on|off | starve, SECONDS (the producer sends nothing)
  jog, X20 Y-5 for SECONDS (mm/s) | jog-step, X0.1 at FEED | jog-to, X0 Y0 at FEED | jog-back, at FEED | jog-cancel
At the end of the program:
  surface, Z<-2.5 (the probe closes there) | switch, X>120 (the axis's home switch) | probe, Z-10 at FEED | probe-away, Z0 at FEED
  home, X-50 Y-50 slow 5 reach 300 back 2 at 0 [park 5]";

impl Events {
    /// Commands in any order.
    pub fn new(mut list: Vec<Event>) -> Self {
        list.sort_by(|a, b| a.time.total_cmp(&b.time));
        Self { list }
    }

    /// Reads a file of events.
    ///
    /// # Errors
    /// What cannot be read or understood, with its line.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&input::text(path)?).with_context(|| path.display().to_string())
    }

    /// Understands the text of a file of events.
    ///
    /// # Errors
    /// What cannot be understood, with its line.
    pub fn parse(text: &str) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut list = Vec::new();
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, csv::Position::line);
            let event = event(&record).with_context(|| format!("line {line}"))?;
            list.push(event);
        }
        Ok(Self::new(list))
    }

    /// The commands.
    pub fn list(&self) -> &[Event] {
        &self.list
    }
}

fn event(record: &csv::StringRecord) -> Result<Event> {
    let field = |n: usize| record.get(n).unwrap_or_default();
    let Ok(time) = field(0).parse::<f64>() else {
        bail!("\"{}\" is not a time in seconds", field(0))
    };
    if !(time >= 0.0 && time.is_finite()) {
        bail!("time {time} s: it must be 0 or more");
    }
    let value = field(2);
    let action = match (field(1), record.len()) {
        ("starve", 3) => match value.parse::<f64>() {
            Ok(seconds) if seconds >= 0.0 && seconds.is_finite() => Action::Starve(seconds),
            _ => bail!("\"{value}\" is not a duration in seconds"),
        },
        (name, 2 | 3) => match parse_seek(name, value)? {
            Some(seek) => Action::Seek(seek),
            None => Action::Command(parse_command(&format!("{name} {value}"))?),
        },
        (name, count) => bail!("\"{name}\" with {count} fields is not an action"),
    };
    Ok(Event { time, action })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_sorted_by_time() {
        let events = Events::parse("# c\n0.8, resume\n0.5,hold\n1, feed, 50\n").unwrap();
        let times: Vec<f64> = events.list().iter().map(|event| event.time).collect();
        assert_eq!(times, [0.5, 0.8, 1.0]);
        assert_eq!(events.list()[2].action, Action::Command(Command::FeedOverride(50)));
    }

    #[test]
    fn errors_name_the_line() {
        for (text, words) in [
            ("0.1,hold\n0.2,leap", "line 2"),
            ("x,hold", "not a time"),
            ("1,feed,300", "0 to 200"),
            ("1,single,maybe", "needs on or off"),
            ("1,leap", "known are hold"),
            ("1", "not an action"),
        ] {
            let error = format!("{:#}", Events::parse(text).unwrap_err());
            assert!(error.contains(words), "{error}");
            assert!(error.starts_with("line "), "{error}");
        }
    }

    /// An error has the grammar of its own command and of no other, once.
    #[test]
    fn errors_have_the_grammar_of_their_command() {
        for (text, words) in [
            ("0,home,X-40", "line 1: homing needs \"slow\", as in X-50 Y-50 slow 5"),
            ("0,home,X-40 slow 5 reach 9", "line 1: homing needs \"back\""),
            ("0,probe,Z-1", "line 1: \"probe\" needs \"at\" and a feed, as in Z-10 at FEED"),
            ("0,switch,X=5", "line 1: \"X=5\" is no place of an input"),
            ("0,jog,X5", "line 1: \"jog\" needs \"for\" and a number, as in X20 Y-5 for SECONDS"),
            ("0,jog-back,X1 at 5", "line 1: \"X1 at 5\" is not what \"jog-back\" takes"),
        ] {
            let error = format!("{:#}", Events::parse(text).unwrap_err());
            assert!(error.starts_with(words) && error.len() < 120, "{error}");
        }
    }
}
