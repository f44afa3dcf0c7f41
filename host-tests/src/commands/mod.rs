//! The commands of the `splineway` program.

pub mod bench;
pub mod check;
pub mod completions;
#[cfg(unix)]
pub mod controller;
pub mod corners;
pub mod files;
pub mod formats;
pub mod gcodes;
pub mod limit;
pub mod machine;
pub mod numbers;
mod page;
pub mod paper;
pub mod reading;
mod recorded;
pub mod reshape;
pub mod simulate;
pub mod smooth;
pub mod soak;
pub mod stream;
pub mod thesis;

use anyhow::Result;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

/// Motion interpolator core: simulation of servo cycles on a PC, and programs for a controller
#[derive(Debug, Parser)]
#[command(name = "splineway", version, arg_required_else_help = true)]
pub struct Arguments {
    /// What is to be done.
    #[command(subcommand)]
    pub command: Command,
}

impl Arguments {
    /// Those of this process. What cannot be understood ends it.
    pub fn of_process() -> Self {
        let words = numbers::joining_negative(std::env::args_os());
        let matches = numbers::taking_negative(Self::command()).get_matches_from(words);
        Self::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }
}

/// The commands.
#[derive(Debug, Subcommand)]
#[allow(missing_docs)] // each is described where it is
pub enum Command {
    Simulate(simulate::Simulate),
    Check(check::Check),
    Stream(stream::Stream),
    #[cfg(unix)]
    Controller(controller::ControllerCommand),
    Machine(machine::MachineCommand),
    Gcodes(gcodes::Gcodes),
    Formats(formats::Formats),
    Smooth(smooth::Smooth),
    Bench(bench::Bench),
    Soak(soak::Soak),
    Limit(limit::Limit),
    Reshape(reshape::Reshape),
    Corners(corners::Corners),
    Paper(paper::Paper),
    Thesis(thesis::Thesis),
    Completions(completions::Completions),
}

impl Command {
    /// Whether a machine may be moving meanwhile, so that nothing must end it but an operator.
    pub fn has_a_machine(&self) -> bool {
        #[cfg(unix)]
        if matches!(self, Self::Controller(_)) {
            return true;
        }
        matches!(self, Self::Stream(_))
    }

    /// Does it.
    ///
    /// # Errors
    /// What the command has against its files, or what it found.
    pub fn execute(&self) -> Result<()> {
        match self {
            Self::Simulate(simulate) => simulate.execute(),
            Self::Check(check) => check.execute(),
            Self::Stream(stream) => stream.execute(),
            #[cfg(unix)]
            Self::Controller(controller) => controller.execute(),
            Self::Machine(machine) => machine.execute(),
            Self::Gcodes(gcodes) => gcodes.execute(),
            Self::Formats(formats) => formats.execute(),
            Self::Smooth(smooth) => smooth.execute(),
            Self::Bench(bench) => bench.execute(),
            Self::Soak(soak) => soak.execute(),
            Self::Limit(limit) => limit.execute(),
            Self::Reshape(reshape) => reshape.execute(),
            Self::Corners(corners) => corners.execute(),
            Self::Paper(paper) => paper.execute(),
            Self::Thesis(thesis) => thesis.execute(),
            Self::Completions(completions) => completions.execute(),
        }
    }
}
