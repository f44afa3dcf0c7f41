//! Any bytes as G-code in every dialect, or as a poly-line: they are read or refused; and no axis moves that nobody
//! asked to move.
#![no_main]

use libfuzzer_sys::fuzz_target;
use splineway::gcode::{Action, LETTERS, Place, Reader, Settings};
use splineway::{Coord, Motion};
use splineway_simulator::program::{Dialect, ReadOptions, gcode, poly};

const DIALECTS: [Dialect; 3] = [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Marlin];

/// Moves that are looked at: a few bytes may ask for millions.
const MOST: usize = 5000;

/// Where a move or a probe ends, and the axes of its plane if it is an arc.
fn end(action: &Action) -> Option<(&Place, Option<(usize, usize)>)> {
    let block = match action {
        Action::Move(block) => block,
        Action::Probe(probe) => return Some((&probe.to, None)),
        _ => return None,
    };
    match &block.motion {
        Motion::Line { to } | Motion::Cubic { to, .. } => Some((to, None)),
        Motion::Arc { to, plane, .. } => Some((to, Some(*plane))),
        Motion::Dwell { .. } | Motion::Event { .. } => None,
    }
}

/// Line by line: what is refused does nothing, and a line moves only what it names. X, Y and Z may also move by a
/// rotation, a hole or along an arc, and X and Y at the end of a NURBS block; all axes that have been named by a way home.
fn line_by_line(data: &[u8], dialect: Dialect, lenient: bool) {
    let mut reader = Reader::new(&Settings { dialect, lenient, ..Settings::default() });
    for (number, text) in (1..).zip(data.split(|&byte| byte == b'\n')) {
        let mut here = *reader.position();
        let capitals = text.to_ascii_uppercase();
        let has = |letters: &str| capitals.iter().any(|&byte| letters.contains(char::from(byte)));
        let goes_home = capitals.windows(2).any(|pair| matches!(pair, b"28" | b"30"));
        let ends_curve = capitals.windows(3).any(|three| three == b"5.3");
        let is_read = reader.line(number, text).is_ok();
        let mut count = 0;
        while let Some(action) = reader.action() {
            count += 1;
            if count > MOST {
                return;
            }
            assert!(is_read, "a refused line does something");
            let Some((to, plane)) = end(&action) else { continue };
            for (axis, letter) in LETTERS.into_iter().enumerate() {
                let moves =
                    to[axis] != here[axis] || plane.is_some_and(|(p, q)| p == axis || q == axis);
                let asked =
                    if axis < 3 { has("XYZIJKR") } else { has(letter.encode_utf8(&mut [0; 4])) };
                let asked = asked || ends_curve && axis < 2;
                assert!(!moves || asked || goes_home, "{letter} moves unasked");
                assert!(!moves || reader.named()[axis], "{letter} moves without its name");
                assert!(to[axis].to_mm().abs() <= Coord::LIMIT_MM);
            }
            here = *to;
            if matches!(action, Action::Probe(_)) {
                // Without contact: there the machine stands.
                reader.set_position(&here);
            }
        }
        assert!(!is_read || here == *reader.position(), "the reader is elsewhere");
    }
}

fuzz_target!(|data: &[u8]| {
    for dialect in DIALECTS {
        for lenient in [false, true] {
            let options = ReadOptions { dialect: Some(dialect), lenient, ..ReadOptions::DEFAULT };
            let (program, _) = gcode::examine_within(data, options, MOST);
            assert!(program.moves.len() <= MOST);
            line_by_line(data, dialect, lenient);
        }
    }
    let _ = poly::parse(&String::from_utf8_lossy(data));
});
