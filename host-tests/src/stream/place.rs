//! Where the machine stands, and the port it is on.

use anyhow::{Context, Result, ensure};
use serial2::SerialPort;
use splineway::gcode::{Code, Event};
use splineway::wire::{self, State};
use splineway_simulator::program::{Course, LETTERS, Move, Point, Program, Speed};
use std::path::Path;

/// Distance within which the machine counts as standing where a path begins, mm.
const THERE: f64 = 1.0e-3;

/// Opens a serial port, for this program alone.
///
/// # Errors
/// The port cannot be opened; another program of this kind has it.
pub fn open_port(path: &Path, baud: u32) -> Result<SerialPort> {
    let name = path.display();
    let port = SerialPort::open(path, baud).with_context(|| format!("cannot open {name}"))?;
    #[cfg(unix)]
    {
        use rustix::fs::{FlockOperation, flock};
        use rustix::io::Errno;
        match flock(&port, FlockOperation::NonBlockingLockExclusive) {
            Err(Errno::WOULDBLOCK) => {
                anyhow::bail!("{name} is in use: another sender has locked it")
            }
            // A system without locks on devices: the controller still keeps senders apart.
            Ok(()) | Err(Errno::NOTSUP | Errno::INVAL | Errno::NOLCK) => {}
            Err(error) => return Err(error).with_context(|| format!("cannot lock {name}")),
        }
    }
    Ok(port)
}

/// Positions in words: X1.000 Y2.000.
pub fn describe_place(position: &[i64]) -> String {
    let axes = LETTERS.iter().zip(position);
    let place: Vec<String> =
        axes.map(|(letter, &nm)| format!("{letter}{:.3}", nm as f64 * 1.0e-6)).collect();
    place.join(" ")
}

/// A state in a word or two.
pub const fn describe_state(state: State) -> &'static str {
    match state {
        State::Idle => "idle",
        State::Running => "running",
        State::Held => "held",
        State::Alarm => "alarm",
        State::SenderLost => "sender lost",
        State::Aborted => "aborted",
    }
}

/// An event as a program has it.
pub fn describe_event(event: &wire::Event) -> String {
    let code = Code { letter: char::from(event.letter), tenths: event.tenths };
    Event { code, value: event.value.map(f64::from), pause: event.pause }.to_string()
}

/// The program for a machine that stands at `here`: axes that it does not name stay there. A path with a
/// starting point of its own begins there; unless the machine stands there already it takes a rapid move
/// to get there, which is put before it only if `approach` allows it: then its end is given too.
///
/// # Errors
/// The machine stands elsewhere, and `approach` is not set.
pub fn placed(program: &Program, here: &Point, approach: bool) -> Result<(Program, Option<Point>)> {
    let mut out = program.clone();
    let rest = |point: &mut Point| {
        for (axis, mm) in point.iter_mut().enumerate() {
            if !program.uses[axis] {
                *mm = here[axis];
            }
        }
    };
    rest(&mut out.start);
    for step in &mut out.moves {
        match &mut step.path {
            Course::Line { to } | Course::Arc { to, .. } => rest(to),
            Course::Cubic { controls: [first, second], to } => {
                rest(first);
                rest(second);
                rest(to);
            }
            Course::Dwell { .. } | Course::Event { .. } => {}
        }
    }
    let start = out.start;
    out.start = *here;
    if start.iter().zip(here).all(|(start, here)| (start - here).abs() <= THERE) {
        return Ok((out, None));
    }
    let words = |point: &Point| -> String {
        let axes = (0..LETTERS.len()).filter(|&axis| program.uses[axis]);
        axes.map(|axis| format!("{}{:.3}", LETTERS[axis], point[axis]))
            .collect::<Vec<_>>()
            .join(" ")
    };
    ensure!(
        approach,
        "the path begins at {}, the machine stands at {}; --approach moves it there first, straight and as \
         fast as it can",
        words(&start),
        words(here)
    );
    let path = Course::Line { to: start };
    let line = Move { path, speed: Speed::Rapid, tolerance: None, exact_stop: true, line: 0 };
    out.moves.insert(0, line);
    out.exact.clear();
    Ok((out, Some(start)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway_simulator::program::{Dialect, ReadOptions, gcode, poly};

    #[test]
    fn a_path_begins_where_the_machine_stands_or_says_so() {
        let program = poly::parse("1 2 3 10\n2 2 3 10\n").unwrap();
        let mut here = [0.0; 9];
        let error = placed(&program, &here, false).unwrap_err().to_string();
        assert!(error.contains("X1.000 Y2.000 Z3.000") && error.contains("--approach"), "{error}");
        let (with, to) = placed(&program, &here, true).unwrap();
        assert_eq!((with.moves.len(), to.unwrap()[2].to_bits()), (2, 3.0f64.to_bits()));
        here[..4].copy_from_slice(&[1.0, 2.0, 3.0, 7.0]);
        let (there, to) = placed(&program, &here, false).unwrap();
        assert_eq!((there.moves.len(), to), (1, None));
        // The fourth axis, which the path does not know, stays.
        let Course::Line { to } = there.moves[0].path else { panic!("a line") };
        assert_eq!(to.map(f64::to_bits)[..4], [2.0, 2.0, 3.0, 7.0].map(f64::to_bits));
    }

    /// Moves that no word of the axis asks for: holes, reference points, turned coordinates, centres and controls.
    #[test]
    fn a_program_is_sent_as_it_is_read() {
        let mut start = [0.0; 9];
        start[..4].copy_from_slice(&[3.0, 4.0, 5.0, 7.0]);
        for text in [
            "G28",
            "G30 Z6",
            "G81 X5 Y5 Z-3 R1 F60",
            "G18 G81 X5 Z5 Y-3 R1 F60",
            "G91 G83 X1 Z-3 R-1 Q1 L3 F60",
            "G68 X0 Y0 R45\nG0 X1",
            "G68 X0 Y0 R45\nG81 X1 Z-3 R1 F60",
            "G2 I5 F60",
            "G18 G3 K1 F60",
            "G5 X9 I1 J1 P-1 Q1 F60",
            "G5.1 X9 I1 J1 F60",
        ] {
            let options = ReadOptions { start, ..ReadOptions::DEFAULT };
            let program = gcode::parse_with(text, options).unwrap();
            assert_eq!(placed(&program, &start, false).unwrap(), (program, None), "{text}");
        }
        let options = ReadOptions { start, dialect: Some(Dialect::Marlin), ..ReadOptions::DEFAULT };
        let program = gcode::parse_with("G28", options).unwrap();
        let (sent, _) = placed(&program, &start, false).unwrap();
        assert_eq!(sent.end()[..4], [0.0, 0.0, 0.0, 7.0]);
    }
}
