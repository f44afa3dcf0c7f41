//! A program over a pseudo-terminal to a controller: the whole way, with real bytes and real time, and with
//! the program as a process that is killed.
#![cfg(unix)]

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serial2::SerialPort;
use splineway::wire::State;
use splineway_host::stream::{
    Command, Controlled, Controller, Faults, Happening, News, Order, Settings, Summary, items,
    open_port, placed, send,
};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, Code, Course, Program, ReadOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Starts a controller of its own; gives its port, and what happens there. It ends with the test.
fn controller(axes: usize, speed: f64, faults: f64) -> (String, Receiver<Happening>) {
    let controller = Controller::open().unwrap();
    let name = controller.name().to_owned();
    let (tell, happenings) = channel();
    thread::spawn(move || {
        let machine = Machine::default();
        controller.run(&machine, axes, speed, Faults { share: faults }, |happening| {
            tell.send(happening.clone()).is_err()
        })
    });
    (name, happenings)
}

/// Sends a program with commands at their times, ms after the one before or the first motion.
fn stream(
    port: &str,
    program: &Program,
    settings: Settings,
    commands: &[(u64, Order)],
) -> anyhow::Result<Summary> {
    let mut port = SerialPort::open(port, 921_600).unwrap();
    let (sender, receiver) = channel();
    let (moves, moving) = channel();
    let commands = commands.to_vec();
    thread::spawn(move || {
        let _ = moving.recv();
        for (wait, command) in commands {
            thread::sleep(Duration::from_millis(wait));
            let _ = sender.send(command);
        }
    });
    let make = |controlled: &Controlled| {
        let mut here = [0.0; 9];
        for (mm, &nm) in here.iter_mut().zip(&controlled.situation.position) {
            *mm = nm as f64 * 1.0e-6;
        }
        items(&placed(program, &here, true)?.0, controlled.axes)
    };
    send(&mut port, settings, make, &receiver, &mut |news| {
        if let News::Status { situation, .. } = news
            && situation.state == State::Running
        {
            let _ = moves.send(());
        }
    })
}

/// Waits for a happening.
fn wait<T>(
    happenings: &Receiver<Happening>,
    limit: Duration,
    find: impl Fn(&Happening) -> Option<T>,
) -> Option<T> {
    let until = Instant::now() + limit;
    while let Some(left) = until.checked_duration_since(Instant::now()) {
        match happenings.recv_timeout(left) {
            Ok(happening) => {
                if let Some(found) = find(&happening) {
                    return Some(found);
                }
            }
            Err(_) => return None,
        }
    }
    None
}

fn state(happenings: &Receiver<Happening>, limit: Duration, wanted: State) -> Option<Vec<i64>> {
    wait(happenings, limit, |happening| match happening {
        Happening::State { state, position } if *state == wanted => Some(position.clone()),
        _ => None,
    })
}

fn run(happenings: &Receiver<Happening>, limit: Duration) -> Option<Vec<i64>> {
    wait(happenings, limit, |happening| match happening {
        Happening::Run(ends) => Some(ends.clone()),
        _ => None,
    })
}

/// For a machine with other things to do, which may keep the sender from the line for a while.
const CALM: Settings = Settings { silence: 30_000, abort: false };
const TEN: Duration = Duration::from_secs(10);

fn butterfly() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/butterfly.json")
}

fn example() -> Program {
    let options = ReadOptions { feed: 100.0, ..ReadOptions::default() };
    program::read(&butterfly(), options).unwrap()
}

fn gcode(text: &str) -> Program {
    program::gcode::parse(text, 50.0).unwrap()
}

#[test]
fn a_program_arrives_whole_over_a_good_line_and_a_bad_one() {
    let program = example();
    let wanted = [54.492, 52.139, 0.0].map(|mm: f64| (mm * 1.0e6).round() as i64);
    for (axes, faults) in [(3, 0.0), (3, 0.002), (6, 0.0)] {
        let (port, happenings) = controller(axes, 10.0, faults);
        let summary = stream(&port, &program, CALM, &[]).unwrap();
        assert_eq!(summary.blocks, program.moves.len() as u32 + 1);
        assert_eq!(run(&happenings, TEN).unwrap()[..3], wanted);
        assert_eq!(summary.damaged > 0, faults > 0.0);
        assert_eq!(summary.situation.position.len(), axes);
        assert_eq!(summary.aborted, None);
    }
}

#[test]
fn an_abort_ends_the_program_where_the_machine_stands() {
    let leave = Order::Leave("interrupted");
    for order in [Order::Command(Command::Abort), leave] {
        let (port, happenings) = controller(3, 2.0, 0.0);
        let summary = stream(&port, &gcode(LONG), CALM, &[(150, order)]).unwrap();
        assert!(summary.aborted.is_some());
        assert_eq!(summary.situation.state, State::Aborted);
        // The machine stood before the sender left.
        let place = state(&happenings, TEN, State::Aborted).unwrap();
        assert_eq!(place[..], summary.situation.position[..]);
        assert_eq!(run(&happenings, Duration::from_millis(300)), None);
    }
}

/// Whenever that is: the next sender need not wait until the session ends by silence.
#[test]
fn an_abort_before_the_first_block_leaves_the_machine_to_the_next() {
    let (name, _happenings) = controller(3, 2.0, 0.0);
    for wait in 0..30 {
        let mut port = SerialPort::open(&name, 921_600).unwrap();
        let (sender, receiver) = channel();
        let pressed = thread::spawn(move || {
            thread::sleep(Duration::from_micros(wait * 500));
            let _ = sender.send(Order::Command(Command::Abort));
        });
        let make = |_: &Controlled| {
            thread::sleep(Duration::from_millis(20));
            items(&gcode("G1 X1 F600"), 3)
        };
        let summary = send(&mut port, CALM, make, &receiver, &mut |_| {}).unwrap();
        assert_eq!((summary.aborted, summary.sent), (Some("an abort"), 0), "{wait}");
        pressed.join().unwrap();
    }
    stream(&name, &gcode("G1 X1 F600"), CALM, &[]).unwrap();
}

#[test]
fn a_hold_holds_and_a_resume_goes_on() {
    let (port, happenings) = controller(3, 10.0, 0.001);
    let commands =
        [(20, Command::Hold), (400, Command::Resume)].map(|(t, c)| (t, Order::Command(c)));
    let outcome = stream(&port, &example(), CALM, &commands);
    assert_eq!(outcome.unwrap().aborted, None);
    assert!(run(&happenings, TEN).is_some());
}

/// Nothing of a program could be run from where a jog has led that comes before it: there is none, and the program is run.
#[test]
fn a_jog_before_the_program_is_none() {
    for wait in [0, 1, 3, 10, 30] {
        let (port, happenings) = controller(3, 5.0, 0.0);
        let mut process = Process::new(&format!("jog{wait}"), "G1 X20 F3000\nX0\n", &port, &[]);
        process.say("jog-step X1 at 10");
        thread::sleep(Duration::from_millis(wait));
        process.say("jog Y5 for 1");
        let (code, _, complaints) = process.end();
        assert_eq!(code, Some(0), "{wait}: {complaints}");
        assert!(complaints.contains("no jog"), "{wait}: {complaints}");
        assert_eq!(run(&happenings, TEN).unwrap(), [0, 0, 0], "{wait}");
    }
}

#[test]
fn errors_say_what_is_wrong() {
    let (port, _happenings) = controller(3, 10.0, 0.0);
    let outcome = stream(&port, &gcode("G1 X1 A5 F600"), CALM, &[]);
    let error = format!("{:#}", outcome.unwrap_err());
    assert!(error.contains("moves A; the controller has only XYZ"), "{error}");
    // Nobody answers.
    let (mut port, _other) = SerialPort::pair().unwrap();
    let (_sender, receiver) = channel();
    let make = |controlled: &Controlled| items(&gcode("G1 X1 F600"), controlled.axes);
    let error = send(&mut port, CALM, make, &receiver, &mut |_| {}).unwrap_err();
    assert!(error.to_string().contains("does not answer"), "{error}");
}

/// A controller of the first version answers in the words of this test.
#[test]
fn another_version_is_named() {
    let (mut port, other) = SerialPort::pair().unwrap();
    thread::spawn(move || {
        let mut bytes = [0; 64];
        while other.read(&mut bytes).is_ok() {
            // Its word for an open session: version, axes, session 0, 0, 0, 0, no gap, not refused.
            let message = [0u8, 1, 3, 0, 0, 16, 0, 0, 0];
            let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(&message);
            let mut out: Vec<u8> = Vec::new();
            let mut run = Vec::new();
            for byte in message.into_iter().chain(crc.to_le_bytes()).chain([0]) {
                if byte == 0 {
                    out.push(run.len() as u8 + 1);
                    out.append(&mut run);
                } else {
                    run.push(byte);
                }
            }
            out.push(0);
            if other.write_all(&out).is_err() {
                return;
            }
        }
    });
    let (_sender, receiver) = channel();
    let make = |controlled: &Controlled| items(&gcode("G1 X1 F600"), controlled.axes);
    let error = send(&mut port, CALM, make, &receiver, &mut |_| {}).unwrap_err();
    assert!(
        error.to_string().contains("version 1 of the protocol, this program version 6"),
        "{error}"
    );
}

/// The program as a process, on files of its own.
struct Process {
    child: Child,
    input: Option<ChildStdin>,
    folder: PathBuf,
}

impl Process {
    /// `input`: whether standard input is a pipe that stays open.
    fn new(name: &str, program: &str, port: &str, more: &[&str]) -> Self {
        let folder = std::env::temp_dir().join(format!("splineway-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("program.ngc");
        std::fs::write(&file, program).unwrap();
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_splineway"))
            .args(["stream", "--port", port])
            .args(more)
            .args(if more.contains(&"--watchdog") { &[][..] } else { &["--watchdog", "30"] })
            .arg(&file)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let input = child.stdin.take();
        Self { child, input, folder }
    }

    fn signal(&self, name: &str) {
        let pid = self.child.id().to_string();
        let status = std::process::Command::new("kill").args(["-s", name, &pid]).status();
        assert!(status.unwrap().success());
    }

    fn say(&mut self, line: &str) {
        let input = self.input.as_mut().unwrap();
        if writeln!(input, "{line}").and_then(|()| input.flush()).is_err() {
            let mut complaints = String::new();
            self.child.stderr.take().unwrap().read_to_string(&mut complaints).unwrap();
            panic!("it has ended before {line}: {complaints}");
        }
    }

    /// Waits for its end: exit code, standard output, standard error.
    fn end(mut self) -> (Option<i32>, String, String) {
        self.input = None;
        let (mut out, mut complaints) = (String::new(), String::new());
        let status = self.child.wait().unwrap();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        self.child.stderr.take().unwrap().read_to_string(&mut complaints).unwrap();
        let _ = std::fs::remove_dir_all(&self.folder);
        (status.code(), out, complaints)
    }
}

/// A line that takes 20 s.
const LONG: &str = "G21 G90\nG1 X1000 F3000\n";

#[test]
fn signals_abort_and_wait_until_the_machine_stands() {
    for (signal, times) in [("INT", 1), ("TERM", 1), ("HUP", 1), ("INT", 2)] {
        let (port, happenings) = controller(3, 1.0, 0.0);
        let name = format!("{signal}{times}");
        let process = Process::new(&name, LONG, &port, &["--watchdog", "0"]);
        state(&happenings, TEN, State::Running).expect("it runs");
        thread::sleep(Duration::from_millis(300));
        for _ in 0..times {
            process.signal(signal);
        }
        let place = state(&happenings, TEN, State::Aborted);
        let (code, _, complaints) = process.end();
        assert_eq!(code, Some(1), "{complaints}");
        let place = place.unwrap_or_else(|| panic!("{times} {signal}: {complaints}"));
        if times == 1 {
            let x = format!("stands at X{:.3} ", place[0] as f64 * 1.0e-6);
            assert!(complaints.contains(&x), "{x}: {complaints}");
        }
    }
}

#[test]
fn a_killed_or_stopped_sender_is_missed_and_the_next_one_is_told() {
    let (port, happenings) = controller(3, 1.0, 0.0);
    let mut process = Process::new("kill", LONG, &port, &["--watchdog", "0.3"]);
    state(&happenings, TEN, State::Running).expect("it runs");
    thread::sleep(Duration::from_millis(300));
    process.child.kill().unwrap();
    let killed = Instant::now();
    let place = state(&happenings, TEN, State::SenderLost).expect("it is missed");
    assert!(killed.elapsed() < Duration::from_secs(3), "{:?}", killed.elapsed());
    let _ = process.end();
    let (code, _, complaints) = Process::new("next", "G1 X1 F600\n", &port, &[]).end();
    assert_eq!(code, Some(1));
    assert!(complaints.contains("--abort drops them"), "{complaints}");
    // Relative, from where the machine stands; and only Y is named.
    let next = "G91\nG1 Y2 F6000\nY3\n";
    let (code, _, complaints) = Process::new("abort", next, &port, &["--abort"]).end();
    assert_eq!(code, Some(0), "{complaints}");
    assert_eq!(run(&happenings, TEN).unwrap(), [place[0], 5_000_000, 0]);
    // Suspended, and back.
    let process = Process::new("stop", LONG, &port, &["--watchdog", "0.3"]);
    state(&happenings, TEN, State::Running).expect("it runs");
    process.signal("STOP");
    state(&happenings, TEN, State::SenderLost).expect("it is missed");
    process.signal("CONT");
    thread::sleep(Duration::from_millis(500));
    let mut process = process;
    process.say("resume");
    state(&happenings, TEN, State::Running).expect("it goes on");
    process.say("abort");
    state(&happenings, TEN, State::Aborted).expect("it is aborted");
    let (code, _, complaints) = process.end();
    assert_eq!(code, Some(1));
    assert!(complaints.contains("has not heard from here"), "{complaints}");
}

#[test]
fn the_end_of_a_pipe_is_no_operator_who_is_gone_but_that_of_a_terminal_is() {
    let (port, happenings) = controller(3, 5.0, 0.0);
    let program = "G1 X20 F6000\nX0\n";
    let (code, _, complaints) = Process::new("pipe", program, &port, &[]).end();
    assert_eq!(code, Some(0), "{complaints}");
    assert!(run(&happenings, TEN).is_some());
    // Nobody is left to say resume: that is told, and an interrupt ends it.
    let mut process = Process::new("held", LONG, &port, &[]);
    state(&happenings, TEN, State::Running).expect("it runs");
    process.say("hold");
    process.input = None;
    state(&happenings, TEN, State::Held).expect("it is held");
    thread::sleep(Duration::from_millis(300));
    process.signal("INT");
    let (code, _, complaints) = process.end();
    assert_eq!(code, Some(1), "{complaints}");
    assert!(complaints.contains("is held; standard input has ended"), "{complaints}");
    // The end of a terminal, which hangs up.
    // The child must not have it too.
    let terminal = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&terminal).unwrap();
    unlockpt(&terminal).unwrap();
    let name = ptsname(&terminal, Vec::new()).unwrap().into_string().unwrap();
    let folder = std::env::temp_dir().join(format!("splineway-{}-tty", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("program.ngc");
    std::fs::write(&file, LONG).unwrap();
    let end = std::fs::File::options().read(true).write(true).open(name).unwrap();
    let child = std::process::Command::new(env!("CARGO_BIN_EXE_splineway"))
        .args(["stream", "--port", &port, "--watchdog", "0"])
        .arg(&file)
        .stdin(end)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    state(&happenings, TEN, State::Running).expect("it runs");
    drop(terminal);
    state(&happenings, TEN, State::Aborted).expect("it is aborted");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let _ = std::fs::remove_dir_all(&folder);
}

/// Whoever writes commands without end keeps neither the line nor an interrupt waiting, and the program ends all the same.
#[test]
fn commands_without_end_hold_nothing_up() {
    for interrupted in [false, true] {
        let (port, happenings) = controller(3, 1.0, 0.0);
        let program = if interrupted { "G1 X500 F3000\n" } else { "G1 X20 F3000\n" };
        let mut sender = Process::new(&format!("endless-{interrupted}"), program, &port, &[]);
        assert!(state(&happenings, TEN, State::Running).is_some());
        let mut input = sender.input.take().unwrap();
        thread::spawn(move || while input.write_all(b"resume\nresume\nresume\n").is_ok() {});
        if interrupted {
            thread::sleep(Duration::from_millis(300));
            sender.signal("INT");
        }
        let began = Instant::now();
        let (code, _, said) = sender.end();
        assert!(began.elapsed() < Duration::from_secs(5), "{said}");
        assert_eq!(code, Some(i32::from(interrupted)), "{said}");
    }
}

#[test]
fn one_sender_at_a_time() {
    let (port, happenings) = controller(3, 1.0, 0.0);
    let first = Process::new("first", LONG, &port, &[]);
    state(&happenings, TEN, State::Running).expect("it runs");
    // The lock.
    let (code, _, complaints) = Process::new("second", LONG, &port, &["--abort"]).end();
    assert_eq!(code, Some(1));
    assert!(complaints.contains("in use: another sender has locked it"), "{complaints}");
    assert!(open_port(Path::new(&port), 921_600).is_err());
    // One that does not care for locks.
    let settings = Settings { abort: true, ..CALM };
    let error = stream(&port, &gcode("G1 X1 F600"), settings, &[]).unwrap_err();
    assert!(error.to_string().contains("another sender has the machine"), "{error}");
    first.signal("INT");
    state(&happenings, TEN, State::Aborted).expect("the first can still stop it");
    let (code, ..) = first.end();
    assert_eq!(code, Some(1));
}

#[test]
fn a_path_with_a_start_of_its_own_is_not_approached_unasked() {
    let (port, happenings) = controller(3, 10.0, 0.0);
    let stream = |more: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_splineway"))
            .args(["stream", "--port", &port, "--feed", "100", "--watchdog", "30"])
            .args(more)
            .arg(butterfly())
            .stdin(Stdio::null())
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, complaints) = stream(&[]);
    assert_eq!(code, Some(1));
    assert!(
        complaints.contains("begins at X54.493") && complaints.contains("--approach"),
        "{complaints}"
    );
    assert_eq!(state(&happenings, Duration::from_millis(100), State::Running), None);
    let (code, complaints) = stream(&["--approach"]);
    assert_eq!(code, Some(0), "{complaints}");
    assert!(complaints.contains("first from X0.000 Y0.000 Z0.000 to X54.493"), "{complaints}");
    assert!(run(&happenings, TEN).is_some());
}

#[test]
fn a_program_is_checked_as_a_whole_before_anything_moves() {
    let (port, happenings) = controller(3, 10.0, 0.0);
    let bad = "G1 X10 F600\nX20\nX2000000\nX3\nY-3000000\n";
    let (code, _, complaints) = Process::new("bad", bad, &port, &[]).end();
    assert_eq!(code, Some(1));
    assert!(complaints.contains("line 3"), "{complaints}");
    assert_eq!(state(&happenings, Duration::from_millis(100), State::Running), None);
}

/// What no word of the axis asks for goes over the line too: the way home, down a hole, a turned axis.
#[test]
fn moves_without_a_word_of_their_axis_are_sent() {
    let (port, happenings) = controller(3, 10.0, 0.0);
    for (program, end) in [
        ("G0 X3 Y4 Z5", [3.0, 4.0, 5.0]),
        ("G99 G81 X1 Y1 Z-3 R1 F6000", [1.0, 1.0, 1.0]),
        ("G68 X1 Y1 R90\nG1 X6 F6000", [1.0, 6.0, 1.0]),
        ("G28", [0.0; 3]),
    ] {
        let (code, _, complaints) = Process::new("words", program, &port, &[]).end();
        assert_eq!(code, Some(0), "{program}: {complaints}");
        assert_eq!(run(&happenings, TEN).unwrap(), end.map(|mm| (mm * 1e6) as i64), "{program}");
    }
}

/// `-`: the program comes from standard input, which then brings no commands.
#[test]
fn a_program_may_come_from_standard_input() {
    let (port, happenings) = controller(3, 20.0, 0.0);
    for (program, code) in [("G1 X5 F6000\n", 0), ("G1 X6 F6000\nabort\n", 1), ("", 0)] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_splineway"))
            .args(["stream", "-", "--port", &port, "--quiet"])
            .stdin(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(program.as_bytes()).unwrap();
        let out = child.wait_with_output().unwrap();
        let complaints = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(code), "{program}: {complaints}");
        assert!(code == 0 || complaints.contains("line 2, column 1"), "{complaints}");
    }
    assert_eq!(run(&happenings, TEN).unwrap()[0], 5_000_000);
    assert_eq!(state(&happenings, Duration::from_millis(100), State::Running), None);
}

#[test]
fn codes_of_the_machine_are_told_in_order_and_a_pause_waits() {
    let (port, happenings) = controller(3, 5.0, 0.0);
    let mut program = gcode("G1 X5 F6000\nX6\nX7\n");
    let event = |line, code, value, pause| program::Move {
        path: Course::Event { code: Code::m(code), value, pause },
        speed: program::Speed::Rapid,
        tolerance: None,
        exact_stop: true,
        line,
    };
    program.moves.insert(3, event(14, 5, None, false));
    program.moves.insert(2, event(13, 0, None, true));
    program.moves.insert(1, event(12, 8, None, false));
    program.moves.insert(0, event(11, 3, Some(1000.0), false));
    let mut port = SerialPort::open(&port, 921_600).unwrap();
    let (orders, receiver) = channel();
    let mut told = Vec::new();
    let make = |controlled: &Controlled| items(&program, controlled.axes);
    let summary = send(&mut port, CALM, make, &receiver, &mut |news| match news {
        News::Event { line, event } => told.push(format!("{line}: {event}")),
        News::Notice(notice) => {
            told.push(notice.to_owned());
            orders.send(Order::Command(Command::Resume)).unwrap();
        }
        News::Status { .. } => {}
    });
    assert_eq!(summary.unwrap().aborted, None);
    let pause = "line 13: the program pauses; \"resume\" goes on";
    assert_eq!(told, ["11: M3 S1000", "12: M8", "13: M0", pause, "14: M5"]);
    assert_eq!(run(&happenings, TEN).unwrap()[0], 7_000_000);
}
