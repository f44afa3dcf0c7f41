//! Progress on a terminal: bars, and what turns where nobody knows how long it takes.

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use splineway_simulator::run::{Observer, Sample};
use std::borrow::Cow;
use std::io::IsTerminal;
use std::time::Duration;

/// A bar over so many things, or none where standard error is no terminal.
pub fn bar(count: u64, quiet: bool, template: &str) -> ProgressBar {
    let bar = if quiet || !std::io::stderr().is_terminal() {
        ProgressBar::hidden()
    } else {
        ProgressBar::new(count)
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Says what is under way, for as long as this lives.
#[derive(Debug)]
pub struct Busy(ProgressBar);

impl Busy {
    /// Work that has begun, in words.
    pub fn new(what: impl Into<Cow<'static, str>>, quiet: bool) -> Self {
        let bar = bar(0, quiet, "{spinner} {msg} {elapsed}");
        bar.set_message(what);
        if !bar.is_hidden() {
            bar.enable_steady_tick(TICK);
        }
        Self(bar)
    }

    /// What is under way now.
    pub fn say(&self, what: impl Into<Cow<'static, str>>) {
        self.0.set_message(what);
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// How often it turns.
const TICK: Duration = Duration::from_millis(200);

/// Shows how much of the path has been run, if standard error is a terminal.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    count: u32,
    by_lines: bool,
}

impl Progress {
    /// A bar over a path of `length` mm; `quiet` shows none.
    pub fn new(length: f64, quiet: bool) -> Self {
        let bar = bar(length.ceil() as u64, quiet, "{bar:40} {percent:>3} %  {eta} left");
        Self { bar, count: 0, by_lines: false }
    }

    /// A bar over so many lines of a file.
    pub fn over_lines(lines: u32, quiet: bool) -> Self {
        let bar = bar(u64::from(lines), quiet, "{bar:40} line {pos} of {len}  {eta} left");
        Self { bar, count: 0, by_lines: true }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Progress {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        self.count = self.count.wrapping_add(1);
        if self.count.is_multiple_of(4096) {
            let line = u64::from(sample.tag);
            self.bar.set_position(if self.by_lines { line } else { sample.path as u64 });
        }
        Ok(())
    }
}
