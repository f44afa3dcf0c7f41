//! What differs between those who write and read G-code.

use super::Code;

/// Whose reading holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Dialect {
    /// RS274/NGC as LinuxCNC has it, with the subprograms (M98, M99), the rotation (G68) and the local offset (G52)
    /// of other controllers. `G4 P` is in seconds. There is no E word, so an E behind a number is its exponent.
    #[default]
    LinuxCnc,
    /// The same but for the motion mode before any code: G0.
    Grbl,
    /// Printers. `G4 P` is in milliseconds, `G4 S` in seconds; E words are of the extruder; M codes take words
    /// without a number, and text; G28 is for the axes named, whatever the numbers; G0 runs at the feed in force.
    Marlin,
}

/// What an M code is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Waits for the operator, after the motion of the line.
    Stop,
    /// Ends the program.
    End,
    /// M98.
    Call,
    /// M99.
    Return,
    /// M6 and M61.
    Tool,
    /// M3, M4, M5, M19.
    Spindle,
    /// M7.
    Mist,
    /// M8.
    Flood,
    /// M9.
    CoolantOff,
    /// M48 to M53.
    Override,
    /// M62 to M65.
    Output,
    /// Of a printer: passed on at rest, with all the words of its line.
    Pass,
    /// Of a printer: the same, and waits for the operator.
    PassAndWait,
    /// Of a printer: nothing that concerns the path; left out with all the words of its line.
    Skip,
}

/// Why a code is refused by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused {
    pub what: &'static str,
    /// Whether it cannot change where the tool goes, so that it may be left out.
    pub harmless: bool,
}

/// What is said of a printer's code elsewhere.
const PRINTERS: &str = "a code of printers: --dialect marlin reads it";

const fn no(what: &'static str) -> Refused {
    Refused { what, harmless: false }
}

const fn harmless(what: &'static str) -> Refused {
    Refused { what, harmless: true }
}

impl Dialect {
    /// What an M code is for; `None` if it is not known.
    pub fn m_code(self, code: Code) -> Option<Result<Use, Refused>> {
        let number = code.tenths / 10;
        if self == Self::Marlin {
            return printer(number, code.tenths % 10);
        }
        if !code.tenths.is_multiple_of(10) {
            let is_printers = printer(number, 1) == Some(Ok(Use::Skip));
            return is_printers.then_some(Err(harmless(PRINTERS)));
        }
        let found = match number {
            0 | 1 | 60 => Use::Stop,
            2 | 30 => Use::End,
            3..=5 | 19 => Use::Spindle,
            6 | 61 => Use::Tool,
            7 => Use::Mist,
            8 => Use::Flood,
            9 => Use::CoolantOff,
            48..=53 => Use::Override,
            62..=65 => Use::Output,
            67 | 68 if cfg!(feature = "outputs") => Use::Output,
            98 => Use::Call,
            99 => Use::Return,
            66 => return Some(Err(no("waiting for an input"))),
            67 | 68 => return Some(Err(no("an analogue output"))),
            70..=73 => return Some(Err(no("saving and restoring the modal state"))),
            97 => return Some(Err(no("a call of a line"))),
            _ => {
                return match printer(number, 0) {
                    Some(Ok(Use::Skip | Use::Pass) | Err(Refused { harmless: true, .. })) => {
                        Some(Err(harmless(PRINTERS)))
                    }
                    Some(Ok(Use::PassAndWait)) => Some(Err(no(PRINTERS))),
                    _ => (100..200)
                        .contains(&number)
                        .then_some(Err(harmless("a program of the user"))),
                };
            }
        };
        Some(Ok(found))
    }

    /// Whether what stands behind an M code is text up to the end of the line.
    pub fn takes_text(self, tenths: u16) -> bool {
        match tenths / 10 {
            117 | 118 => true,
            0 | 1 | 16 | 20 | 23 | 28 | 29 | 32 | 115 | 928 => self == Self::Marlin,
            _ => false,
        }
    }
}

/// M codes of printers that concern messages, clocks, heaters, fans, the extruder, reports, limits of the printer's
/// own planner, and settings.
const SKIPPED: [u16; 102] = [
    16, 31, 36, 73, 75, 76, 77, 78, 82, 83, 85, 104, 105, 106, 107, 108, 109, 110, 111, 113, 114,
    115, 116, 117, 118, 119, 140, 141, 143, 145, 149, 150, 154, 155, 163, 164, 165, 190, 191, 200,
    201, 203, 204, 205, 207, 208, 209, 211, 217, 221, 250, 256, 300, 301, 302, 303, 304, 309, 350,
    351, 355, 400, 404, 405, 406, 407, 412, 413, 486, 500, 501, 502, 503, 504, 510, 511, 512, 524,
    540, 555, 569, 572, 573, 575, 591, 593, 862, 900, 904, 906, 907, 908, 910, 911, 912, 913, 914,
    915, 916, 917, 918, 919,
];

/// M codes of printers, after Marlin's documentation (marlinfw.org/meta/gcode) and Prusa's.
fn printer(number: u16, tenth: u16) -> Option<Result<Use, Refused>> {
    if tenth != 0 {
        // M862.1 to M862.6 ask for the printer's model; no other has a decimal.
        return if number == 862 { Some(Ok(Use::Skip)) } else { None };
    }
    let found = match number {
        0 | 1 => Use::Stop,
        2 | 30 => Use::End,
        3..=5 => Use::Spindle,
        6 => Use::Tool,
        7 => Use::Mist,
        8 => Use::Flood,
        9 => Use::CoolantOff,
        17 | 18 | 84 | 42 | 220 | 280 => Use::Pass,
        226 | 600 => Use::PassAndWait,
        _ if SKIPPED.contains(&number) => Use::Skip,
        _ => return printers_refused(number).map(Err),
    };
    Some(Ok(found))
}

/// M codes of printers that are refused by name.
fn printers_refused(number: u16) -> Option<Refused> {
    let refused = match number {
        20..=29 | 32..=34 | 928 => harmless("a card of files"),
        92 => harmless("another number of steps per millimetre"),
        112 => no("an emergency stop"),
        997..=999 => harmless("a restart of the printer"),
        401 | 402 | 851 => harmless("a probe"),
        420 | 421 => harmless("a map of the bed"),
        701..=703 => harmless("loading of filament by the printer's own program"),
        125 => no("parking by the printer's own program"),
        206 | 428 => no("another home position"),
        218 => no("an offset of the nozzle"),
        290 => no("a shift of Z"),
        425 | 852 => no("a correction of the axes"),
        605 | 665 | 666 => no("another kinematics"),
        808 => no("a repetition"),
        98 | 99 => no("a subprogram"),
        _ => return None,
    };
    Some(refused)
}
