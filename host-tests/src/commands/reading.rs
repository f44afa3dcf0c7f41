//! Flags of every command that reads a program: how, at which feed, and for which machine.

use super::files::{Named, named};
use super::numbers::setting;
use anyhow::Result;
use clap::ValueEnum;
use splineway::machine::Quantity;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{Dialect, Overriding, ReadOptions, Setup, Tape};
use std::path::PathBuf;

/// Feed of programs that name none, mm/s.
const FEED: f64 = ReadOptions::DEFAULT.feed;

/// Dialects by the names of the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum DialectName {
    /// RS274/NGC, most milling machines: G4 P in seconds.
    #[default]
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

/// How programs are read.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Reading {
    /// Machine description (TOML) [default: a small milling machine, which `splineway machine` prints]
    #[arg(long, value_name = "TOML")]
    pub machine: Option<PathBuf>,
    /// Feed of all moves but rapids, mm/s, in place of what the file says [default: the file's; 50 where it says nothing]
    #[arg(long, value_name = "MM_PER_S", value_parser = setting(Quantity::Feed, "mm/s"))]
    pub feed: Option<f64>,
    /// Whose G-code it is [default: told by comments and codes of the first 1000 lines where that is plain, else linuxcnc]
    #[arg(long, value_enum)]
    pub dialect: Option<DialectName>,
    /// Leave out codes that cannot change where the tool goes, where they would be refused
    #[arg(long)]
    pub lenient: bool,
    /// Leave out lines that begin with "/"
    #[arg(long)]
    pub block_delete: bool,
}

impl Reading {
    /// The machine's file, if there is one.
    pub fn file(&self) -> Option<Named<'_>> {
        named("--machine", self.machine.as_ref())
    }

    /// The machine that is described, or the built-in one.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn machine(&self) -> Result<Machine> {
        Ok(self.machine.as_deref().map(Machine::read).transpose()?.unwrap_or_default())
    }

    /// What is run is run on `machine`, unless none was described and the program brings limits of its own.
    pub fn apply_header(&self, program: &dyn Tape, machine: &mut Machine) {
        if let (Some(header), None) = (program.header(), &self.machine) {
            machine.apply(&header);
        }
    }

    /// Options with these flags and what the machine brings.
    pub fn options<'a>(&self, setup: &'a Setup) -> ReadOptions<'a> {
        ReadOptions {
            feed: self.feed.unwrap_or(FEED),
            dialect: self.dialect.map(Dialect::from),
            lenient: self.lenient,
            block_delete: self.block_delete,
            setup,
            ..ReadOptions::DEFAULT
        }
    }

    /// A program with the feed and the tolerance of the command line in the place of all that it names; says so if it names any
    /// other. Exact stops (G61, G9) stay.
    pub fn overriding<'a>(&self, tape: &'a dyn Tape, tolerance: Option<f64>) -> Overriding<'a> {
        let over = Overriding { tape, feed: self.feed, tolerance: tolerance.is_some() };
        let (feeds, tolerances) = over.count();
        for (option, value, named) in
            [("--feed", self.feed, feeds), ("--tolerance", tolerance, tolerances)]
        {
            if let (Some(value), true) = (value, named > 0) {
                eprintln!("note: {option} {value} counts for all; {named} moves name another");
            }
        }
        over
    }
}
