//! Flags on how programs are read, of every command that reads one.

use anyhow::Result;
use clap::ValueEnum;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Dialect, ReadOptions, Setup};
use std::path::Path;

/// Dialects by the names of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DialectName {
    /// RS274/NGC, most milling machines: G4 P in seconds.
    Linuxcnc,
    /// The same, with G0 in force at the beginning.
    Grbl,
    /// Printers: G4 P in milliseconds, E words, M codes with text.
    Marlin,
}

impl From<DialectName> for Dialect {
    fn from(name: DialectName) -> Self {
        match name {
            DialectName::Linuxcnc => Self::LinuxCnc,
            DialectName::Grbl => Self::Grbl,
            DialectName::Marlin => Self::Marlin,
        }
    }
}

/// How G-code is read.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct Reading {
    /// Whose G-code it is; told by the header where that is plain, else linuxcnc.
    #[arg(long, value_enum)]
    pub dialect: Option<DialectName>,
    /// Leave out codes that cannot change where the tool goes, where they would be refused.
    #[arg(long)]
    pub lenient: bool,
    /// Leave out lines that begin with "/".
    #[arg(long)]
    pub block_delete: bool,
}

impl Reading {
    /// Options with these flags and what the machine brings.
    pub fn options(self, setup: &Setup) -> ReadOptions<'_> {
        ReadOptions {
            dialect: self.dialect.map(Dialect::from),
            lenient: self.lenient,
            block_delete: self.block_delete,
            setup,
            ..ReadOptions::DEFAULT
        }
    }
}

/// Offsets, tools and reference points of a machine description, if one is given.
///
/// # Errors
/// As [`Machine::read`].
pub fn setup(machine: Option<&Path>) -> Result<Setup> {
    machine.map_or(Ok(Setup::NONE), |path| Ok(Machine::read(path)?.setup()))
}
