//! A progress bar on a terminal.

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use splineway_simulator::run::{Observer, Sample};
use std::io::IsTerminal;

/// Shows how much of the path has been run, if standard error is a terminal.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    count: u32,
}

impl Progress {
    /// A bar over a path of `length` mm; `quiet` shows none.
    pub fn new(length: f64, quiet: bool) -> Self {
        let bar = if quiet || !std::io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(length.ceil() as u64)
        };
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta} left") {
            bar.set_style(style);
        }
        Self { bar, count: 0 }
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
            self.bar.set_position(sample.path as u64);
        }
        Ok(())
    }
}
