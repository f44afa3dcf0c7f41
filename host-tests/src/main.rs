//! The `splineway` program.

use splineway_host::commands::Arguments;
use splineway_host::commands::numbers::Usage;
use splineway_host::out;
use std::process::ExitCode;

fn main() -> ExitCode {
    let command = Arguments::of_process().command;
    // `splineway ... | head` ends quietly; but a machine is not left alone because nobody reads any more.
    if !command.has_a_machine() {
        sigpipe::reset();
    }
    match command.execute().and_then(|()| out::finish()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            if error.is::<Usage>() { ExitCode::from(Usage::CODE) } else { ExitCode::FAILURE }
        }
    }
}
