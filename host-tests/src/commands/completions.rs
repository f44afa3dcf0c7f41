//! `splineway completions`: what shells need to know of this program's arguments.

use super::Arguments;
use anyhow::Result;
use clap::CommandFactory;
use clap_complete::Shell;

/// Prints a script that completes this program's arguments in a shell
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Completions {
    /// The shell
    pub shell: Shell,
}

impl Completions {
    /// Runs the command.
    ///
    /// # Errors
    /// None.
    pub fn execute(&self) -> Result<()> {
        println!("{}", script(self.shell).trim_end());
        Ok(())
    }
}

/// The script.
pub fn script(shell: Shell) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "splineway", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}
