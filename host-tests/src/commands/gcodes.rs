//! `splineway gcodes`: the codes that the reader reads, by its own tables.

use super::reading::DialectName;
use anyhow::Result;
use serde::Serialize;
use splineway::gcode::{Code, Dialect, Known};

/// Lists the G-codes that are read, as the reader's own tables have them
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Gcodes {
    /// Whose G-code
    #[arg(long, value_enum, default_value_t)]
    pub dialect: DialectName,
    /// Also list what is refused by name, and what is left out
    #[arg(long)]
    pub all: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// A code in the list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// `G2`, `G38.2`.
    pub code: String,
    /// `read`, `left out`, `refused`, or `refused unless --lenient`.
    pub handling: &'static str,
    /// What it is, in words.
    pub meaning: &'static str,
}

/// Numbers of codes, in tenths, are below this.
const TENTHS: u16 = 60_000;

/// What codes mean: letter, first and last number in tenths, words. Those of printers are in [`OF_PRINTERS`].
const MEANINGS: &[(char, u16, u16, &str)] = &[
    ('G', 0, 0, "rapid move"),
    ('G', 10, 10, "straight move at the feed"),
    ('G', 20, 20, "arc or helix, clockwise: I J K or R; P turns"),
    ('G', 30, 30, "arc or helix, counterclockwise: I J K or R; P turns"),
    ('G', 40, 40, "dwell: P seconds"),
    ('G', 50, 50, "cubic curve: I J P Q"),
    ('G', 51, 51, "quadratic curve: I J"),
    ('G', 52, 52, "begins a NURBS: P weight, L order"),
    ('G', 53, 53, "ends a NURBS, which is run"),
    ('G', 80, 80, "switches off what is not there (look-ahead of other controls)"),
    ('G', 90, 90, "exact stop at the end of this move"),
    ('G', 100, 100, "sets a work offset (L2) or its coordinates (L20): P which"),
    ('G', 150, 150, "switches off what is not there (polar coordinates)"),
    ('G', 170, 170, "plane XY"),
    ('G', 180, 180, "plane XZ"),
    ('G', 190, 190, "plane YZ"),
    ('G', 200, 200, "inches"),
    ('G', 210, 210, "millimetres"),
    ('G', 280, 280, "to the reference point, by way of the axes named"),
    ('G', 281, 281, "sets the reference point of G28"),
    ('G', 300, 300, "to the second reference point, by way of the axes named"),
    ('G', 301, 301, "sets the reference point of G30"),
    ('G', 310, 310, "probe towards, no error without contact (as G38.3)"),
    ('G', 382, 382, "probe towards, an error without contact"),
    ('G', 383, 383, "probe towards, no error without contact"),
    ('G', 384, 384, "probe away, an error without a change"),
    ('G', 385, 385, "probe away, no error without a change"),
    ('G', 400, 400, "switches off what is not there (tool radius compensation)"),
    ('G', 430, 430, "length of a tool along Z: H which"),
    ('G', 431, 431, "length of the tool along Z: as given"),
    ('G', 490, 490, "no length of the tool"),
    ('G', 500, 500, "switches off what is not there (scaling)"),
    ('G', 520, 520, "local offset"),
    ('G', 530, 530, "this move in machine coordinates"),
    ('G', 540, 593, "work offset"),
    ('G', 610, 611, "exact stops"),
    ('G', 640, 640, "tolerance of the path: P mm (Q is taken for within P)"),
    ('G', 680, 680, "rotation in the plane: R degrees"),
    ('G', 690, 690, "no rotation"),
    ('G', 730, 730, "drilling with broken chips: Z R Q L"),
    ('G', 800, 800, "end of the canned cycles"),
    ('G', 810, 810, "drilling: Z R L"),
    ('G', 820, 820, "drilling with a dwell: Z R P L"),
    ('G', 830, 830, "deep drilling with pecks: Z R Q L"),
    ('G', 900, 900, "distances are absolute"),
    ('G', 901, 901, "centres of arcs are absolute"),
    ('G', 910, 910, "distances are incremental"),
    ('G', 911, 911, "centres of arcs are from the start"),
    ('G', 920, 920, "shifts the coordinates"),
    ('G', 921, 923, "the shift of G92: reset, suspended, restored"),
    ('G', 930, 930, "feed is one over the minutes of the move"),
    ('G', 940, 940, "feed is per minute"),
    ('G', 970, 970, "switches off what is not there (constant surface speed)"),
    ('G', 980, 980, "canned cycles return to where they began"),
    ('G', 990, 990, "canned cycles return to R"),
    ('M', 0, 10, "waits for the operator"),
    ('M', 20, 20, "end of the program"),
    ('M', 30, 50, "spindle: clockwise, counterclockwise, off; S its speed"),
    ('M', 60, 60, "change of the tool, waits for the operator: T which"),
    ('M', 70, 90, "coolant: mist, flood, off"),
    ('M', 190, 190, "orientation of the spindle: R degrees"),
    ('M', 300, 300, "end of the program"),
    ('M', 480, 530, "overrides and feed hold, allowed or not: P"),
    ('M', 600, 600, "waits for the operator"),
    ('M', 610, 610, "number of the tool in the spindle: Q"),
    ('M', 620, 650, "digital outputs on and off, with the motion or at rest: P which"),
    ('M', 670, 680, "analogue outputs, with the motion or at rest: E which, Q value"),
    ('M', 980, 980, "calls a subprogram: P which, L times"),
    ('M', 990, 990, "end of a subprogram"),
    // What only printers have, or have otherwise.
    ('M', 170, 180, "motors on, off"),
    ('M', 840, 840, "motors off"),
];

/// The same where printers differ.
const OF_PRINTERS: &[(char, u16, u16, &str)] = &[
    ('G', 40, 40, "dwell: P milliseconds, S seconds"),
    ('G', 100, 110, "retracts and feeds filament"),
    ('G', 280, 280, "to the end switches of the axes named"),
    ('M', 420, 420, "switches a pin"),
    ('M', 2200, 2200, "override of the feed"),
    ('M', 2260, 2260, "waits for the operator"),
    ('M', 2800, 2800, "position of a servo"),
    ('M', 6000, 6000, "change of filament, waits for the operator"),
];

fn meaning(code: Code, dialect: Dialect) -> &'static str {
    let others: &[(char, u16, u16, &'static str)] =
        if dialect == Dialect::Marlin { OF_PRINTERS } else { &[] };
    let of = |(letter, first, last, _): &&(char, u16, u16, &'static str)| {
        *letter == code.letter && (*first..=*last).contains(&code.tenths)
    };
    others.iter().chain(MEANINGS).find(of).map_or("", |(.., words)| words)
}

/// All codes of a dialect that are known, by number.
pub fn rows(dialect: Dialect) -> Vec<Row> {
    let codes = ['G', 'M']
        .into_iter()
        .flat_map(|letter| (0..TENTHS).map(move |tenths| Code { letter, tenths }));
    let row = |code: Code| {
        let (handling, meaning) = match dialect.knows(code) {
            Known::Read => ("read", meaning(code, dialect)),
            Known::LeftOut => ("left out", "does not concern the path"),
            Known::Refused { what, harmless: false } => ("refused", what),
            Known::Refused { what, harmless: true } => ("refused unless --lenient", what),
            Known::Unknown => return None,
        };
        Some(Row { code: code.to_string(), handling, meaning })
    };
    codes.filter_map(row).collect()
}

impl Gcodes {
    /// Runs the command.
    ///
    /// # Errors
    /// None.
    pub fn execute(&self) -> Result<()> {
        let mut rows = rows(self.dialect.into());
        rows.retain(|row| self.all || row.handling == "read");
        if self.json {
            println!("{}", serde_json::to_string_pretty(&rows)?);
            return Ok(());
        }
        for Row { code, handling, meaning } in &rows {
            match *handling {
                "read" => println!("{code:<6} {meaning}"),
                handling => println!("{code:<6} {handling}: {meaning}"),
            }
        }
        for (word, meaning) in WORDS {
            println!("{word:<6} {meaning}");
        }
        Ok(())
    }
}

/// Words that are no codes.
const WORDS: [(&str, &str); 6] = [
    ("F", "feed, per minute"),
    ("S, T", "speed of the spindle (or power of a laser), number of the next tool"),
    ("N, O", "number of a line, of a subprogram"),
    ("/", "begins a line that --block-delete leaves out"),
    ("%", "begins and ends a program"),
    ("( ) ;", "comments"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Every code that is read has its words, and no words are for a code that nobody reads.
    #[test]
    fn every_code_has_its_words() {
        let mut used = BTreeSet::new();
        for dialect in [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Marlin] {
            for row in rows(dialect) {
                assert!(!row.meaning.is_empty(), "{row:?}");
                used.insert(row.meaning);
            }
        }
        for (.., words) in MEANINGS.iter().chain(OF_PRINTERS) {
            assert!(used.contains(words), "{words}");
        }
    }
}
