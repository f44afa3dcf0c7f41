//! The judge of steps (`benches/board`): it finds nothing in what the drives make of a motion, and each of these faults in it.

#[allow(dead_code)]
#[path = "../../firmware/machine.rs"]
mod machine;
#[allow(dead_code)]
#[path = "../benches/board/recording.rs"]
mod recording;
#[allow(dead_code)]
#[path = "../benches/board/verdict.rs"]
mod verdict;

use embedded_hal::digital::{ErrorType, OutputPin};
use machine::AXES;
use recording::Recording;
use splineway::{Activity, AxisLimits, Block, Coord, Limits, Link, Progress};
use splineway_controller::{Drives, Targets};
use splineway_mps2::pins::{self, Levels, Recorder};
use std::cell::Cell;
use std::convert::Infallible;
use std::rc::Rc;
use verdict::{Leg, judge};

/// Some bits of a port.
struct Pin(Rc<Cell<Levels>>, Levels);

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(self.0.get() & !self.1);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(self.0.get() | self.1);
        Ok(())
    }
}

/// Corners of a path in the plane, mm.
const PATH: [[f64; 2]; 6] =
    [[10.0, 0.0], [10.0, 6.0], [3.0, 7.0], [3.0, 9.0], [-4.0, 9.5], [0.0, 1.0]];

/// The path as lines of G-code.
fn text(path: &[[f64; 2]]) -> String {
    let lines: Vec<_> = path.iter().map(|[x, y]| format!("G1 X{x} Y{y} F3600")).collect();
    lines.join("\n")
}

/// Targets of every servo cycle along a path, at rest at both ends.
fn motion(path: &[[f64; 2]]) -> Vec<Targets<AXES>> {
    motion_of(path, 60.0, [1.0; 3])
}

/// The same with another feed, mm/s, on a machine with these shares of the limits.
fn motion_of(path: &[[f64; 2]], feed: f32, share: [f32; 3]) -> Vec<Targets<AXES>> {
    let mut link = Box::new(Link::<f32, AXES>::new());
    let mut config = machine::config::<f32>().unwrap();
    let [velocity, acceleration, jerk] = share;
    let axis = AxisLimits::linear(
        velocity * machine::VELOCITY,
        acceleration * machine::ACCELERATION,
        jerk * machine::JERK,
    );
    config.limits = Limits::new([axis; AXES]).unwrap();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    for [x, y] in path {
        let to = [*x, *y, 0.0].map(|mm| Coord::from_mm(mm).unwrap());
        planner.push(&Block::line(to, feed, 0)).unwrap();
    }
    planner.finish();
    let mut out = Vec::new();
    loop {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        out.push(Targets::new(&setpoint));
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            return out;
        }
    }
}

/// The record of the pins, which `spoil` may change.
fn record(
    targets: &[Targets<AXES>],
    mut spoil: impl FnMut(usize, u32, Levels) -> Levels,
) -> Vec<u8> {
    let port = Rc::new(Cell::new(0));
    let pin = |levels| Pin(port.clone(), levels);
    let axes = [0, 1, 2]
        .map(|axis| machine::stepper(pin(pins::step(axis)), pin(pins::direction(axis))).unwrap());
    let mut drives = Drives::new(axes, machine::TICKS);
    let (mut recorder, mut bytes) = (Recorder::new(), Vec::new());
    // The end of a cycle shows when the next begins.
    for (cycle, targets) in targets.iter().chain([&targets[targets.len() - 1]]).enumerate() {
        for _ in 0..machine::TICKS {
            let beat = drives.tick(|| *targets).unwrap();
            assert!(!beat.lagged);
            recorder.tick(beat.tick, spoil(cycle, beat.tick, port.get()), |byte| bytes.push(byte));
        }
    }
    bytes
}

/// What is found in a record.
fn found(bytes: &[u8], path: &[[f64; 2]]) -> anyhow::Result<verdict::Verdict> {
    let mut recording = Recording::new();
    recording.read(bytes)?;
    let cycles = 0..recording.cycles.len();
    let leg = Leg { text: text(path), from: [0; AXES], cycles, whole: true };
    judge(&leg, &recording.cycles, machine::config::<f64>().unwrap().tolerance)
}

fn fault(bytes: &[u8], path: &[[f64; 2]]) -> String {
    found(bytes, path).unwrap_err().to_string()
}

/// Without a fault.
fn as_it_is(_: usize, _: u32, levels: Levels) -> Levels {
    levels
}

#[test]
fn nothing_is_found_in_a_motion_that_is_good() {
    let verdict = found(&record(&motion(&PATH), as_it_is), &PATH).unwrap();
    assert!(verdict.peaks.iter().all(|&peak| peak > 0.5), "{verdict:?}");
    assert!(verdict.deviation > 0.003 && verdict.way > 30.0, "{verdict:?}");
}

#[test]
fn a_lost_step_is_found() {
    let targets = motion(&PATH);
    let mut rises = 0;
    let mut before = 0;
    let bytes = record(&targets, |_, _, levels| {
        let rise = levels & !before & pins::step(0) != 0;
        before = levels;
        rises += u32::from(rise);
        // One pulse in the middle, to its end.
        if rises == 2000 { levels & !pins::step(0) } else { levels }
    });
    assert!(rises > 2000);
    let fault = fault(&bytes, &PATH);
    assert!(fault.contains("it ends at"), "{fault}");
}

#[test]
fn a_path_beside_the_programmed_one_is_found() {
    let mut other = PATH;
    other[2][1] += 0.02;
    let fault = fault(&record(&motion(&other), as_it_is), &PATH);
    assert!(fault.contains("outside the band"), "{fault}");
}

#[test]
fn a_block_that_was_lost_is_found() {
    // There and back is missing: both ends are where they should be.
    let mut longer = PATH.to_vec();
    longer.extend([[5.0, 1.0], [0.0, 1.0]]);
    let fault = fault(&record(&motion(&PATH), as_it_is), &longer);
    assert!(fault.contains("were not run"), "{fault}");
}

/// Each limit exceeded alone, by little.
#[test]
fn limits_exceeded_are_found() {
    let path = [[60.0, 0.0], [60.0, 60.0], [0.0, 0.0]];
    let limits = ["velocity", "acceleration", "jerk"];
    assert!(found(&record(&motion_of(&path, 200.0, [1.0; 3]), as_it_is), &path).is_ok());
    for (name, share) in
        limits.into_iter().zip([[1.02, 1.0, 1.0], [1.0, 1.04, 1.0], [1.0, 1.0, 1.1]])
    {
        let fault = fault(&record(&motion_of(&path, 200.0, share), as_it_is), &path);
        assert!(fault.contains(&format!("of the limit of {name}")), "{name}: {fault}");
    }
    // A jolt: a cycle is missing.
    let targets = motion(&PATH);
    let jolted: Vec<_> = [&targets[..200], &targets[201..]].concat();
    let fault = fault(&record(&jolted, as_it_is), &PATH);
    assert!(fault.contains("of the limit of"), "{fault}");
}

#[test]
fn edges_that_no_drive_follows_are_found() {
    let bad = |bytes: &[u8]| Recording::new().read(bytes).unwrap_err().to_string();
    let (step, direction) = (pins::step(1), pins::direction(1));
    // A step, another without a pause; a turn within a pulse; a step without a set-up time; a byte too few.
    let cycle = pins::CYCLE;
    assert!(Recording::new().read(&[cycle, 0x82, step, 0x83, 0, 0x84, step]).is_ok());
    assert!(bad(&[cycle, 0x82, step, 0x83, step | direction]).contains("within a pulse"));
    assert!(bad(&[cycle, 0x82, direction | step]).contains("set-up"));
    assert!(bad(&[cycle, 0x82, 0x83, 0]).contains("byte 2"));
}
