//! What a program asks of the machine besides motion, as it comes: spindle, coolant, tools, pauses.

use super::runner::{Observer, Sample};
use crate::program::{Course, Tape};
use anyhow::Result;
use serde::Serialize;
use splineway::Activity;
use std::collections::VecDeque;

/// One event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Happening {
    /// Time since the start, s.
    pub time_s: f64,
    /// Line of the file.
    pub line: u32,
    /// Its code, with its number if it has one.
    pub code: String,
    /// Whether the machine waits there for the operator.
    pub pause: bool,
}

/// Lists events as they happen.
#[derive(Clone, Debug, Default)]
pub struct Happenings {
    /// Those that have happened.
    pub seen: Vec<Happening>,
    to_come: VecDeque<Happening>,
}

impl Happenings {
    /// Of a program.
    pub fn new(program: &dyn Tape) -> Self {
        let events = program.steps().filter_map(|step| match &step.path {
            Course::Event { code, value, pause } => {
                let code = match value {
                    Some(value) => format!("{code} {value}"),
                    None => code.to_string(),
                };
                Some(Happening { time_s: 0.0, line: step.line, code, pause: *pause })
            }
            _ => None,
        });
        Self { seen: Vec::new(), to_come: events.collect() }
    }
}

impl Observer for Happenings {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        if sample.activity == Activity::Event
            && let Some(event) = self.to_come.pop_front()
        {
            self.seen.push(Happening { time_s: sample.time, line: sample.tag, ..event });
        }
        Ok(())
    }
}
