//! The `splineway` program.

use clap::{Parser, Subcommand};
#[cfg(unix)]
use splineway_host::commands::controller::ControllerCommand;
use splineway_host::commands::corners::Corners;
use splineway_host::commands::simulate::Simulate;
use splineway_host::commands::smooth::Smooth;
use splineway_host::commands::soak::Soak;
use splineway_host::commands::stream::Stream;
use splineway_host::commands::thesis::Thesis;
use std::process::ExitCode;

/// Motion interpolator core: simulation of servo cycles on a PC.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Simulate(Simulate),
    Smooth(Smooth),
    Stream(Stream),
    Soak(Soak),
    #[cfg(unix)]
    Controller(ControllerCommand),
    Corners(Corners),
    Thesis(Thesis),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Simulate(simulate) => simulate.execute(),
        Command::Smooth(smooth) => smooth.execute(),
        Command::Stream(stream) => stream.execute(),
        Command::Soak(soak) => soak.execute(),
        #[cfg(unix)]
        Command::Controller(controller) => controller.execute(),
        Command::Corners(corners) => corners.execute(),
        Command::Thesis(thesis) => thesis.execute(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
