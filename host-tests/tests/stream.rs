//! A program over a pseudo-terminal to a controller: the whole way, with real bytes and real time.
#![cfg(unix)]

use serial2::SerialPort;
use splineway_host::machine::Machine;
use splineway_host::program::{self, Program, ReadOptions};
use splineway_host::stream::{Command, Controller, Faults, Summary, parse_command, send};
use std::path::Path;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

/// Sends a program to a controller of its own; gives what the host heard, and where the controller
/// ended, nm.
fn run(
    program: &Program,
    axes: usize,
    faults: f64,
    commands: &[(u64, Command)],
) -> (anyhow::Result<Summary>, Option<Vec<i64>>) {
    let controller = Controller::open().unwrap();
    let mut port = SerialPort::open(controller.name(), 921_600).unwrap();
    let (ends_in, ends_out) = channel();
    thread::spawn(move || {
        let machine = Machine::default();
        controller.run(&machine, axes, 10.0, Faults { share: faults }, |ends| {
            ends_in.send(ends.to_vec()).unwrap();
            true
        })
    });
    let (sender, receiver) = channel();
    let commands = commands.to_vec();
    thread::spawn(move || {
        for (wait, command) in commands {
            thread::sleep(Duration::from_millis(wait));
            let _ = sender.send(command);
        }
    });
    let outcome = send(&mut port, program, &receiver, |_, _, _| {});
    (outcome, ends_out.recv_timeout(Duration::from_secs(1)).ok())
}

fn example() -> Program {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/butterfly.json");
    let options = ReadOptions { feed: 100.0, ..ReadOptions::DEFAULT };
    program::read(&path, options).unwrap().with_approach()
}

fn gcode(text: &str) -> Program {
    program::gcode::parse(text, 50.0).unwrap()
}

#[test]
fn a_program_arrives_whole_over_a_good_line_and_a_bad_one() {
    let program = example();
    let wanted = [54.492, 52.139, 0.0].map(|mm: f64| (mm * 1.0e6).round() as i64);
    for (axes, faults) in [(3, 0.0), (3, 0.002), (6, 0.0)] {
        let (outcome, ends) = run(&program, axes, faults, &[]);
        let summary = outcome.unwrap();
        assert_eq!(summary.blocks, program.moves.len() as u32);
        assert_eq!(ends.unwrap()[..3], wanted);
        assert_eq!(summary.damaged > 0, faults > 0.0);
        assert_eq!(summary.situation.position.len(), axes);
    }
}

#[test]
fn an_abort_ends_the_program_where_the_machine_stands() {
    let (outcome, ends) = run(&example(), 3, 0.0, &[(150, Command::Abort)]);
    let summary = outcome.unwrap();
    assert!(summary.aborted);
    assert_eq!(ends, None);
}

#[test]
fn a_hold_holds_and_a_resume_goes_on() {
    let commands = [(50, Command::Hold), (400, Command::Resume)];
    let (outcome, ends) = run(&example(), 3, 0.001, &commands);
    assert!(!outcome.unwrap().aborted);
    assert!(ends.is_some());
}

#[test]
fn errors_say_what_is_wrong() {
    let (outcome, _) = run(&gcode("G1 X1 A5 F600"), 3, 0.0, &[]);
    let error = format!("{:#}", outcome.unwrap_err());
    assert!(error.contains("moves A; the controller has only XYZ"), "{error}");
    // Nobody answers.
    let (mut port, _other) = SerialPort::pair().unwrap();
    let (_sender, receiver) = channel();
    let error = send(&mut port, &gcode("G1 X1 F600"), &receiver, |_, _, _| {}).unwrap_err();
    assert!(error.to_string().contains("does not answer"), "{error}");
}

#[test]
fn commands_are_words() {
    for (text, command) in [
        ("hold", Command::Hold),
        ("feed 50", Command::FeedOverride(50)),
        ("rapid 25%", Command::RapidOverride(25)),
        ("single off", Command::SingleBlock(false)),
    ] {
        assert_eq!(parse_command(text).unwrap(), command);
    }
    for text in ["feed", "feed much", "jump"] {
        assert!(parse_command(text).is_err());
    }
}
