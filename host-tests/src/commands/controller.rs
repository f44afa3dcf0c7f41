//! `splineway controller`: a controller without a machine, for `splineway stream`.

use crate::stream::{
    Controller, Faults, Happening, describe_event, describe_place, describe_state,
};
use anyhow::{Result, ensure};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::LETTERS;
use std::io::Write;
use std::path::PathBuf;

/// Runs the core as firmware does, on a pseudo-terminal, with the same protocol and no machine.
#[derive(Clone, Debug, clap::Args)]
pub struct ControllerCommand {
    /// Axes: 3, 6 or 9.
    #[arg(long, default_value_t = 3)]
    pub axes: usize,
    /// Machine description (TOML); a small milling machine if left out.
    #[arg(long, value_name = "TOML")]
    pub machine: Option<PathBuf>,
    /// How many times faster than the clock it runs.
    #[arg(long, default_value_t = 1.0)]
    pub speed: f64,
    /// Share of the bytes that are lost, garbled or doubled, in either direction.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub faults: f64,
    /// End after the first program.
    #[arg(long)]
    pub once: bool,
}

impl ControllerCommand {
    /// Runs the command.
    ///
    /// # Errors
    /// The machine or the numbers cannot be used; there is no terminal left.
    pub fn execute(&self) -> Result<()> {
        ensure!(self.speed > 0.0, "speed is {}; it must be above 0", self.speed);
        ensure!(
            (0.0..=0.5).contains(&self.faults),
            "faults is {}; it must be 0 to 0.5",
            self.faults
        );
        let machine = self.machine.as_deref().map(Machine::read).transpose()?.unwrap_or_default();
        let controller = Controller::open()?;
        println!("port: {}", controller.name());
        std::io::stdout().flush()?;
        let faults = Faults { share: self.faults };
        // Nobody may be reading: the machine runs on without.
        let mut out = std::io::stdout();
        let mut tell = |line: String| {
            let _ = writeln!(out, "{line}").and_then(|()| out.flush());
        };
        controller.run(&machine, self.axes, self.speed, faults, |happening| match happening {
            Happening::State { state, position } => {
                tell(format!("{}, at {}", describe_state(*state), describe_place(position)));
                false
            }
            Happening::Event(event) => {
                tell(format!("line {}: {}", event.tag, describe_event(event)));
                false
            }
            Happening::Run(ends) => {
                let axes = LETTERS.iter().zip(ends);
                let place: Vec<String> = axes
                    .map(|(letter, &nm)| format!("{letter}{:.6}", nm as f64 * 1.0e-6))
                    .collect();
                tell(format!("program run, at {}", place.join(" ")));
                self.once
            }
        })
    }
}
