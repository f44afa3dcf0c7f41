//! `splineway machine`: the built-in machine, to begin a description with.

use anyhow::Result;
use splineway_simulator::machine::Machine;

/// Prints the machine that is used where none is described, as a description (TOML) to begin with: every key with its unit, and as
/// comments what else a machine may have
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(
    after_help = "Example:\n  splineway machine > mill.toml\n  splineway simulate part.ngc --machine mill.toml"
)]
pub struct MachineCommand {}

impl MachineCommand {
    /// Runs the command.
    ///
    /// # Errors
    /// None.
    pub fn execute(&self) -> Result<()> {
        println!("{}", Machine::default().describe().trim_end());
        Ok(())
    }
}
