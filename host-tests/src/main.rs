//! The `splineway` program.

use clap::{CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use splineway_host::commands::bench::Bench;
use splineway_host::commands::check::Check;
#[cfg(unix)]
use splineway_host::commands::controller::ControllerCommand;
use splineway_host::commands::corners::Corners;
use splineway_host::commands::limit::Limit;
use splineway_host::commands::paper::Paper;
use splineway_host::commands::simulate::Simulate;
use splineway_host::commands::smooth::Smooth;
use splineway_host::commands::soak::Soak;
use splineway_host::commands::stream::Stream;
use splineway_host::commands::thesis::Thesis;
use splineway_host::out;
use std::process::ExitCode;

/// Motion interpolator core: simulation of servo cycles on a PC, and programs for a controller.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Simulate(Simulate),
    Check(Check),
    Stream(Stream),
    #[cfg(unix)]
    Controller(ControllerCommand),
    Smooth(Smooth),
    Bench(Bench),
    Soak(Soak),
    Limit(Limit),
    Corners(Corners),
    Paper(Paper),
    Thesis(Thesis),
    /// Prints a script that completes this program's arguments in a shell.
    Completions {
        /// The shell.
        shell: Shell,
    },
}

impl Command {
    fn has_a_machine(&self) -> bool {
        #[cfg(unix)]
        if matches!(self, Self::Controller(_)) {
            return true;
        }
        matches!(self, Self::Stream(_))
    }
}

fn main() -> ExitCode {
    let command = Arguments::parse().command;
    // `splineway ... | head` ends quietly; but a machine is not left alone because nobody reads any more.
    if !command.has_a_machine() {
        sigpipe::reset();
    }
    let outcome = match command {
        Command::Simulate(simulate) => simulate.execute(),
        Command::Check(check) => check.execute(),
        Command::Stream(stream) => stream.execute(),
        #[cfg(unix)]
        Command::Controller(controller) => controller.execute(),
        Command::Smooth(smooth) => smooth.execute(),
        Command::Bench(bench) => bench.execute(),
        Command::Soak(soak) => soak.execute(),
        Command::Limit(limit) => limit.execute(),
        Command::Corners(corners) => corners.execute(),
        Command::Paper(paper) => paper.execute(),
        Command::Thesis(thesis) => thesis.execute(),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "splineway", &mut script);
            out::line(format_args!("{}", String::from_utf8_lossy(&script).trim_end()));
            Ok(())
        }
    };
    match outcome.and_then(|()| out::finish()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
