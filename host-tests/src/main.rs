//! The `splineway` program.

use clap::{Parser, Subcommand};
use splineway_host::commands::simulate::Simulate;
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
}

fn main() -> ExitCode {
    let Command::Simulate(simulate) = Arguments::parse().command;
    match simulate.execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
