//! `splineway controller`: a controller without a machine, for `splineway stream` and for senders of grbl.

use super::files::{self, named};
use super::numbers::{Usage, above_zero, between, one_of};
use crate::stream::{
    Controller, Doing, Faults, Grbl, Happening, Kept, Line, describe_event, describe_place,
    describe_state,
};
use anyhow::Result;
use splineway::Output;
use splineway::grbl::{Accessories, Spindle};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::LETTERS;
use std::io::Write;
use std::path::PathBuf;

/// What a controller speaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Protocol {
    /// That of `splineway stream`.
    #[default]
    Wire,
    /// That of grbl 1.1, for senders that people have.
    Grbl,
}

/// Runs the core as firmware does, on a pseudo-terminal or a TCP port, with the same protocols and no machine
#[derive(Clone, Debug, clap::Args)]
pub struct ControllerCommand {
    /// Axes: 3, 6 or 9
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = one_of(&[3, 6, 9]))]
    pub axes: usize,
    /// What it speaks
    #[arg(long, value_enum, default_value_t)]
    pub protocol: Protocol,
    /// Listen on this TCP port of this computer; 0 takes a free one [default: a pseudo-terminal]
    #[arg(long, value_name = "PORT")]
    pub tcp: Option<u16>,
    /// Keep the settings of grbl in this file [default: in memory]
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]
    #[arg(long, value_name = "TOML")]
    pub machine: Option<PathBuf>,
    /// A home switch, closed beyond a place, as "X>5" (mm, the machine being switched on at 0); more than those of the machine's file
    /// [default: none]
    #[arg(long, value_name = "PLACE")]
    pub switch: Vec<String>,
    /// A surface that the probe meets there, as "Z<-20" [default: none]
    #[arg(long, value_name = "PLACE")]
    pub surface: Vec<String>,
    /// How many times faster than the clock it runs
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = above_zero(1.0e6, ""))]
    pub speed: f64,
    /// Share of the bytes that are lost, garbled or doubled, in either direction
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = between(0.0, 0.5, ""))]
    pub faults: f64,
    /// End after the first program
    #[arg(long)]
    pub once: bool,
}

impl ControllerCommand {
    /// Runs the command.
    ///
    /// # Errors
    /// The machine or the numbers cannot be used; there is no terminal left.
    pub fn execute(&self) -> Result<()> {
        files::check(
            &[named("--machine", self.machine.as_ref())],
            &[named("--settings", self.settings.as_ref())],
        )?;
        let mut machine =
            self.machine.as_deref().map(Machine::read).transpose()?.unwrap_or_default();
        machine.switches.extend_from_slice(&self.switch);
        machine.surfaces.extend_from_slice(&self.surface);
        machine.check()?;
        let is_grbl = self.protocol == Protocol::Grbl;
        if self.settings.is_some() && !is_grbl {
            return Err(Usage::error("--settings: they are kept with --protocol grbl only"));
        }
        if self.faults > 0.0 && is_grbl {
            let words = "they are for the protocol of splineway stream only";
            return Err(Usage::error(format!("--faults {}: {words}", self.faults)));
        }
        if self.once && is_grbl {
            return Err(Usage::error(
                "--once: it ends after a program, and grbl knows no end of one",
            ));
        }
        let line = self.tcp.map_or_else(Line::terminal, Line::network)?;
        println!("port: {}", line.name());
        std::io::stdout().flush()?;
        if is_grbl {
            let kept = Kept::new(self.axes, self.settings.as_deref())?;
            return Grbl::new(line, kept).run(&machine, self.axes, self.speed, |doing| {
                // Nobody may be reading: the machine runs on without.
                let mut out = std::io::stdout();
                let _ = writeln!(out, "{}", describe(doing)).and_then(|()| out.flush());
                false
            });
        }
        let controller = Controller::new(line);
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
            Happening::Output { output, value } => {
                tell(describe_output(*output, *value));
                false
            }
            Happening::Laser(power) => {
                tell(describe_laser(*power));
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

/// What a controller does, in words.
fn describe(doing: &Doing) -> String {
    match doing {
        Doing::State { state, position } => {
            format!("{}, at {}", state.name(), describe_place(position))
        }
        Doing::Switch(Accessories { spindle, speed, flood, mist, laser: 0 }) => {
            let spindle = match spindle {
                Spindle::Off => "off".to_owned(),
                Spindle::Clockwise => format!("clockwise at {speed} rpm"),
                Spindle::CounterClockwise => format!("counterclockwise at {speed} rpm"),
            };
            let coolant = match (flood, mist) {
                (false, false) => "off",
                (true, false) => "flood",
                (false, true) => "mist",
                (true, true) => "flood and mist",
            };
            format!("spindle {spindle}, coolant {coolant}")
        }
        Doing::Switch(Accessories { laser, .. }) => format!("laser at {laser} % of its power"),
        Doing::Output { output, value } => describe_output(*output, *value),
        Doing::Laser(value) => describe_laser(*value),
        Doing::Event(event) => format!("line {}: {}", event.tag, describe_event(event)),
    }
}

fn describe_output(output: Output, value: f32) -> String {
    match output {
        Output::Digital(number) => {
            format!("output {number} {}", if value > 0.0 { "on" } else { "off" })
        }
        Output::Analogue(number) => format!("analogue output {number} at {value}"),
        Output::Power => describe_laser(value),
    }
}

fn describe_laser(power: f32) -> String {
    if power > 0.0 { format!("laser burns at {power}") } else { "laser off".to_owned() }
}
