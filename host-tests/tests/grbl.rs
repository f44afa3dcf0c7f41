//! Senders of grbl against the controller that speaks with them: whole files, commands at any moment, noise; in simulated time, and over
//! a real line.

#[path = "common/grbl.rs"]
mod rig;

use rig::{AXES, Draws, MM, Rig, with_rig};
use splineway::Scalar;
use splineway::grbl::State;
use std::collections::VecDeque;

/// Where a sender must not have more characters under way.
const RECEIVE: usize = 128;

/// A sender that keeps the controller's room for lines full, by counting characters, and asks for the status ten times a second.
struct Counting<'a> {
    lines: std::slice::Iter<'a, String>,
    next: Option<&'a String>,
    /// Lengths of the lines that have not been answered.
    under_way: VecDeque<usize>,
    answers: usize,
    reports: usize,
    errors: Vec<String>,
    cycles: u32,
}

impl<'a> Counting<'a> {
    fn new(lines: &'a [String]) -> Self {
        let mut lines = lines.iter();
        let next = lines.next();
        Self {
            lines,
            next,
            under_way: VecDeque::new(),
            answers: 0,
            reports: 0,
            errors: Vec::new(),
            cycles: 0,
        }
    }

    /// Before a servo cycle.
    fn step<S: Scalar>(&mut self, rig: &mut Rig<'_, '_, S>) {
        for said in rig.heard() {
            match said.as_str() {
                "ok" => {
                    self.under_way.pop_front().expect("an answer to nothing");
                    self.answers += 1;
                }
                said if said.starts_with("error:") => {
                    self.under_way.pop_front().expect("an answer to nothing");
                    self.answers += 1;
                    self.errors.push(said.to_owned());
                }
                said if said.starts_with('<') => self.reports += 1,
                said => assert!(said.starts_with("[MSG:"), "{said}"),
            }
        }
        while let Some(line) = self.next {
            let sum: usize = self.under_way.iter().sum();
            if sum + line.len() + 1 > RECEIVE {
                break;
            }
            rig.send(line.as_bytes());
            rig.send(b"\n");
            self.under_way.push_back(line.len() + 1);
            self.next = self.lines.next();
        }
        if self.cycles.is_multiple_of(100) {
            rig.send(b"?");
        }
        self.cycles += 1;
    }

    fn is_done(&self) -> bool {
        self.next.is_none() && self.under_way.is_empty()
    }
}

/// Sends lines to the end; how many reports came on the way.
fn stream<S: Scalar>(rig: &mut Rig<'_, '_, S>, lines: &[String]) -> usize {
    let mut sender = Counting::new(lines);
    while !sender.is_done() {
        sender.step(rig);
        rig.cycle();
        assert!(sender.cycles < 2_000_000, "it does not end");
    }
    assert_eq!((sender.answers, sender.errors), (lines.len(), Vec::new()));
    rig.settle();
    sender.reports
}

/// A poly-line of the data as G-code.
fn poly_line(text: &str) -> Vec<String> {
    let numbers = text.lines().filter(|line| !line.trim_start().starts_with('#'));
    let points = numbers.filter_map(|line| {
        let numbers: Vec<f64> = line.split_whitespace().filter_map(|x| x.parse().ok()).collect();
        let (x, y) = (*numbers.first()?, *numbers.get(1)?);
        Some(format!("G1 X{x:.4} Y{y:.4} F3000"))
    });
    points.collect()
}

/// A rose in short lines.
fn dense() -> Vec<String> {
    let line = |k: u32| {
        let angle = f64::from(k) * 0.004;
        let (sin, cos) = angle.sin_cos();
        let radius = 40.0 * (3.0 * angle).cos();
        format!("G1 X{:.3} Y{:.3} F4000", radius * cos, radius * sin)
    };
    (0..=800).map(line).collect()
}

/// Arcs, helices, dwells, offsets, spindle and holes, with comments.
fn milled() -> Vec<String> {
    let mut lines =
        vec!["%".to_owned(), "(a pocket)".to_owned(), "G21 G90 G17 M3 S8000".to_owned()];
    lines.push("G10 L2 P1 X5 Y5 Z-2".to_owned());
    lines.push("G0 X0 Y0 Z0".to_owned());
    for k in 0..40 {
        lines.push(format!("N{} G2 X10 Y0 I5 J0 Z-{}.5 F2400 ; turn", 10 * k, k % 3));
        lines.push("g3 x0 y0 i-5 j0".to_owned());
        lines.push(String::new());
    }
    lines.extend(
        ["G81 X1 Y1 Z-3 R1 F600", "X4", "G80", "G4 P0.05", "M5", "G0 X0 Y0 Z0"].map(str::to_owned),
    );
    lines
}

fn files<S: Scalar>() {
    let square = include_str!("../data/square.ngc").lines().map(str::to_owned).collect::<Vec<_>>();
    let zigzag = poly_line(include_str!("../data/zigzag.txt"));
    let dense = dense();
    assert!(zigzag.len() > 5);
    let end = |lines: &[String]| -> [i64; 2] {
        let last = lines.last().unwrap();
        let number = |letter| -> f64 {
            let word = last.split(' ').find(|word: &&str| word.starts_with(letter)).unwrap();
            word[1..].parse().unwrap()
        };
        [number('X'), number('Y')].map(|mm| (mm * 1.0e6).round() as i64)
    };
    let (zigzag_end, dense_end) = (end(&zigzag), end(&dense));
    for (lines, [x, y], z) in [
        (square, [0, 0], 0),
        (zigzag, zigzag_end, 0),
        (dense, dense_end, 0),
        (milled(), [5 * MM, 5 * MM], -2 * MM),
    ] {
        with_rig::<S>(|rig| {
            assert!(stream(rig, &lines) >= 1);
            assert_eq!(rig.place(), [x, y, z], "{}", lines[1]);
        });
    }
}

#[test]
fn a_sender_that_counts_characters_runs_whole_files() {
    files::<f32>();
    files::<f64>();
}

/// At every moment of a file: hold and start, a reset, overrides; and the file can be run again.
#[test]
fn commands_at_any_moment_of_a_file_lose_nothing() {
    let lines = dense();
    for moment in (20..1500).step_by(137) {
        with_rig::<f32>(|rig| {
            let mut sender = Counting::new(&lines);
            for _ in 0..moment {
                sender.step(rig);
                rig.cycle();
            }
            rig.send(b"!");
            for _ in 0..300 {
                sender.step(rig);
                rig.cycle();
            }
            assert!(matches!(rig.background.state(), State::Hold { rests: true }));
            let held = rig.place();
            for _ in 0..100 {
                sender.step(rig);
                rig.cycle();
            }
            assert_eq!(rig.place(), held);
            rig.send(b"\x92\x96~");
            for _ in 0..200 {
                sender.step(rig);
                rig.cycle();
            }
            // A reset drops the rest, and the machine knows where it is.
            rig.send(b"\x18");
            rig.cycles(400);
            assert_eq!(rig.background.state(), State::Idle);
            let rest = rig.place();
            assert!(rig.heard().contains(&"Grbl 1.1h ['$' for help]".to_owned()));
            let answer = rig.ask("G91 G0 X0.5 Y-0.25 Z1");
            assert_eq!(answer, ["ok"]);
            assert_eq!(rig.place(), [rest[0] + MM / 2, rest[1] - MM / 4, rest[2] + MM]);
            rig.ask("G90");
            stream(rig, &lines);
        });
    }
}

const GOOD: [&str; 30] = [
    "G1 X10 Y5 F3000",
    "G0 X0 Y0",
    "G91",
    "G90",
    "G2 X5 Y5 I5 J0 F1000",
    "G3 X0 Y0 R8 F1000",
    "M3 S1000",
    "M5",
    "M8",
    "G92 X0",
    "G92.1",
    "G55",
    "G54",
    "G10 L20 P1 X0",
    "$J=G91 X1 F600",
    "$J=X5 Y5 F3000",
    "G4 P0.02",
    "G20",
    "G21",
    "$G",
    "$$",
    "$#",
    "$110=9000",
    "$X",
    "$C",
    "G43.1 Z1",
    "G49",
    "T1 M6",
    "M30",
    "G61",
];

/// A line that is sent while the machine is idle: if it is refused, everything is as it was.
#[test]
fn a_refused_line_does_nothing_whatever_it_says() {
    let mut draws = Draws(7);
    let (mut refused, mut moved) = (0, 0);
    with_rig::<f32>(|rig| {
        for _ in 0..3000 {
            // Words of several lines, garbled.
            let mut line = Vec::new();
            for _ in 0..=draws.below(2) {
                line.extend_from_slice(GOOD[draws.below(GOOD.len())].as_bytes());
                line.push(b' ');
            }
            for _ in 0..draws.below(3) {
                let at = draws.below(line.len());
                let byte = 0x20 + draws.below(0x5F) as u8;
                line[at] = if b"?!~".contains(&byte) { b'$' } else { byte };
            }
            let line = String::from_utf8(line).unwrap();
            if rig.background.state() != State::Idle {
                rig.send(b"\x18");
                rig.cycles(400);
                rig.ask("$X");
                assert_eq!(rig.background.state(), State::Idle);
            }
            let (place, modes, offsets) = (rig.place(), rig.ask("$G"), rig.ask("$#"));
            let mut said = rig.ask(&line);
            while let State::Hold { .. } | State::Door { .. } = rig.background.state() {
                // A pause of the program.
                rig.send(b"~");
                rig.cycles(3);
                rig.settle();
                said.append(&mut rig.heard());
            }
            let last = said.last().cloned().unwrap_or_default();
            let answers = said.iter().filter(|said| *said == "ok" || said.starts_with("error:"));
            assert_eq!(answers.count(), 1, "{line:?}: {said:?}");
            moved += u32::from(rig.place() != place);
            let alarm = said.iter().any(|said| said.starts_with("ALARM:"));
            if last.starts_with("error:") && !alarm {
                refused += 1;
                assert_eq!(rig.place(), place, "{line:?}: {last}");
                assert_eq!(rig.background.state(), State::Idle, "{line:?}: {last}");
                assert_eq!((rig.ask("$G"), rig.ask("$#")), (modes, offsets), "{line:?}: {last}");
            }
        }
    });
    assert!(refused > 500 && moved > 100, "{refused} refused, {moved} moved");
}

/// Lines, commands and noise at any time: one answer per line, no motion in a state that has none, none that nothing has asked for; and
/// after a reset the machine goes where it is told.
fn session(seed: u64) -> [u32; 3] {
    let mut draws = Draws(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let mut seen = [0; 3];
    with_rig::<f32>(|rig| {
        let (mut asked, mut answered, mut lines) = (0u32, 0u32, 0u32);
        let mut before = (rig.place(), rig.background.state());
        // Since it has come to rest.
        let (mut line_came, mut start_came) = (false, false);
        for _ in 0..4000 {
            let mut bytes = Vec::new();
            match draws.below(40) {
                0..=3 if asked - answered < 8 => {
                    bytes.extend_from_slice(GOOD[draws.below(GOOD.len())].as_bytes());
                    bytes.push(b'\n');
                }
                4 if asked - answered < 8 => {
                    let count = draws.below(30);
                    bytes.extend((0..count).map(|_| draws.below(256) as u8));
                    bytes.push(b'\n');
                }
                5 => bytes.push(*b"!~?~\x84\x85\x91\x93\x96\xA0".get(draws.below(10)).unwrap()),
                6 if draws.below(20) == 0 => bytes.push(0x18),
                7 => rig.board.inputs.door = draws.below(4) == 0,
                _ => {}
            }
            // As the controller counts them: a line feed behind a carriage return is of the same line.
            let mut returned = false;
            for &byte in &bytes {
                if byte == 0x18 {
                    (asked, answered, lines) = (0, 0, 0);
                    rig.send(&[byte]);
                    rig.cycle();
                    rig.heard();
                    continue;
                }
                let is_line = byte == b'\r' || byte == b'\n' && !returned;
                if byte < 0x80 && !b"?!~".contains(&byte) {
                    returned = byte == b'\r';
                }
                asked += u32::from(is_line);
                lines += u32::from(is_line);
                line_came |= is_line;
                start_came |= byte == b'~';
                rig.send(&[byte]);
            }
            rig.cycle();
            for said in rig.heard() {
                let answer = said == "ok" || said.starts_with("error:");
                answered += u32::from(answer);
                seen[0] += u32::from(said.starts_with("error:"));
                seen[1] += u32::from(said.starts_with("ALARM:"));
            }
            assert!(answered <= asked, "seed {seed}: {answered} answers to {asked} lines");
            let now = (rig.place(), rig.background.state());
            let is_still = |state| {
                matches!(state, State::Idle | State::Check | State::Hold { rests: true })
                    || matches!(state, State::Door { rests: true, .. })
            };
            let moves = now.0 != before.0;
            if is_still(before.1) && is_still(now.1) {
                assert!(!moves, "seed {seed}: motion while {:?}", now.1);
            }
            if moves && is_still(before.1) {
                let good = if before.1 == State::Idle { line_came } else { start_came };
                assert!(good, "seed {seed}: {:?} is left, and nobody has asked for it", before.1);
            }
            // A line that waits for a reset to be complete has come for afterwards.
            if is_still(now.1) && now.1 != before.1 && answered == asked {
                (line_came, start_came) = (false, false);
            }
            seen[2] += u32::from(moves);
            before = now;
        }
        // Whatever has been left open, every line is answered.
        rig.board.inputs.door = false;
        rig.send(b"\n");
        asked += 1;
        for _ in 0..100 {
            rig.cycles(300);
            rig.send(b"~");
            let said = rig.heard();
            let is_answer = |said: &&String| *said == "ok" || said.starts_with("error:");
            answered += said.iter().filter(is_answer).count() as u32;
        }
        let sleeps = rig.background.state() == State::Sleep;
        assert!(
            answered == asked || sleeps,
            "seed {seed}: {answered} answers to {asked} lines of {lines}"
        );
        rig.send(b"\x18");
        rig.cycles(600);
        rig.ask("$X");
        rig.ask("$RST=*");
        assert_eq!(rig.ask("G53 G0 X1 Y2 Z3").last().unwrap(), "ok");
        assert_eq!(rig.place(), [MM, 2 * MM, 3 * MM]);
    });
    seen
}

#[test]
fn whatever_comes_one_answer_per_line_and_no_motion_that_nobody_asked_for() {
    let mut sum = [0; 3];
    for seed in 0..30 {
        for (sum, seen) in sum.iter_mut().zip(session(seed)) {
            *sum += seen;
        }
    }
    let [errors, alarms, moving] = sum;
    assert!(errors > 300 && alarms > 3 && moving > 3000, "{sum:?}");
}

/// Bytes that are no line and no start: nothing moves.
#[test]
fn noise_without_a_line_moves_nothing() {
    let mut draws = Draws(11);
    with_rig::<f32>(|rig| {
        for _ in 0..20_000 {
            let byte = draws.below(256) as u8;
            if !matches!(byte, b'\n' | b'\r') {
                rig.send(&[byte]);
            }
            rig.cycle();
            assert_eq!(rig.place(), [0; AXES]);
        }
    });
}

#[cfg(unix)]
mod over_a_line {
    use splineway_host::stream::{Grbl, Kept, Line, open_port};
    use splineway_simulator::machine::Machine;
    use std::io::{Read, Write};
    use std::net::TcpStream;
    use std::path::Path;
    use std::time::{Duration, Instant};

    /// Starts a controller of its own; it ends with the test.
    fn start(line: Line, kept: Kept) -> String {
        let name = line.name().to_owned();
        std::thread::spawn(move || {
            Grbl::new(line, kept).run(&Machine::default(), 3, 20.0, |_| false)
        });
        name
    }

    /// Sends bytes, and reads until a text has come; what has come.
    fn expect<T: Read + Write>(port: &mut T, bytes: &[u8], text: &str) -> String {
        port.write_all(bytes).unwrap();
        let (mut heard, began) = (String::new(), Instant::now());
        let mut chunk = [0; 256];
        while !heard.contains(text) {
            assert!(began.elapsed() < Duration::from_secs(20), "no {text:?} in {heard:?}");
            if let Ok(count) = port.read(&mut chunk) {
                heard += std::str::from_utf8(&chunk[..count]).unwrap();
            }
        }
        heard
    }

    /// A jog, a move, a reset.
    fn converse<T: Read + Write>(port: &mut T) {
        let wait_idle = |port: &mut T| {
            let began = Instant::now();
            loop {
                let report = expect(port, b"?", ">\r\n");
                if report.contains("<Idle") || began.elapsed() > Duration::from_secs(20) {
                    return report;
                }
                std::thread::sleep(Duration::from_millis(5));
            }
        };
        // Past the banner of the start: a line that comes before that of the reset is dropped with it.
        wait_idle(port);
        expect(port, b"\x18", "for help]\r\n");
        expect(port, b"$J=G91 X5 F3000\n", "ok\r\n");
        assert!(wait_idle(port).contains("MPos:5.000,0.000,0.000"));
        expect(port, b"G1 Y-7 F2000\n", "ok\r\n");
        assert!(wait_idle(port).contains("MPos:5.000,-7.000,0.000"));
        expect(port, b"G0 X0 Y0\n", "ok\r\n");
        wait_idle(port);
    }

    #[test]
    fn a_pseudo_terminal_and_a_file_of_settings() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("settings");
        for line in [&b"$110=6000\n"[..], b"\n"] {
            let kept = Kept::new(3, Some(&path)).unwrap();
            let name = start(Line::terminal().unwrap(), kept);
            let mut port = open_port(Path::new(&name), 115_200).unwrap();
            port.set_read_timeout(Duration::from_millis(50)).unwrap();
            converse(&mut port);
            expect(&mut port, line, "ok\r\n");
            assert!(expect(&mut port, b"$$\n", "ok\r\n").contains("$110=6000.000\r\n"));
        }
    }

    /// Whoever calls while another is served is hung up on, and never obeyed; half a line goes with its sender.
    #[test]
    fn what_is_left_by_a_sender_that_has_gone_moves_nothing() {
        let name = start(Line::network(0).unwrap(), Kept::new(3, None).unwrap());
        let connect = || {
            let port = TcpStream::connect(&name).unwrap();
            port.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
            port
        };
        let rests_at = |port: &mut TcpStream, place: &str| {
            std::thread::sleep(Duration::from_millis(300));
            let report = expect(port, b"?", ">\r\n");
            assert!(report.contains("<Idle") && report.contains(place), "{report}");
        };
        let mut first = connect();
        expect(&mut first, b"G1 X1 F6000\n", "ok\r\n");
        let mut second = connect();
        second.write_all(b"G0 X9\n").unwrap();
        second.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let end = second.read(&mut [0; 8]);
        assert!(matches!(end, Ok(0) | Err(_)), "{end:?}");
        drop(second);
        rests_at(&mut first, "MPos:1.000,0.000,0.000");
        first.write_all(b"G0 X5").unwrap();
        drop(first);
        let mut third = connect();
        rests_at(&mut third, "MPos:1.000,0.000,0.000");
        expect(&mut third, b"\r\n", "ok\r\n");
        rests_at(&mut third, "MPos:1.000,0.000,0.000");
    }

    #[test]
    fn a_network_and_one_sender_after_another() {
        let name = start(Line::network(0).unwrap(), Kept::new(3, None).unwrap());
        for _ in 0..2 {
            let mut port = TcpStream::connect(&name).unwrap();
            port.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
            converse(&mut port);
        }
    }
}
