//! The image: a program with switches, and every addition called with its setpoints.

use crate::timer::{Count, Timer, instructions};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use panic_semihosting as _;
use splineway::output::{Shape, Shaper, ShaperKind};
use splineway::{
    Activity, AxisLimits, BLOCKS, Block, Config, Coord, Interpolator, Limits, Linear, Link, NODES,
    Planner, Power, Setpoint, Switch,
};
use splineway_emulator::Meter;
use splineway_semihosting::end;

const AXES: usize = 3;
/// Servo cycles that a shaper remembers.
const HISTORY: usize = 64;
/// Lines of the program.
const LINES: u32 = 120;
/// Digital outputs that switch with every line.
const OUTPUTS: u8 = 8;
/// Servo cycles after which the end should have come.
const PATIENCE: u32 = 100_000;

/// Shapers of 40 Hz on all axes.
const SHAPERS: [(&str, ShaperKind); 4] = [
    ("zv", ShaperKind::Zv),
    ("mzv", ShaperKind::Mzv),
    ("ei", ShaperKind::Ei),
    ("smooth", ShaperKind::Smooth),
];

type Shapers = [Shaper<f32, AXES, HISTORY>; 4];

#[inline(never)]
fn tick(interpolator: &mut Interpolator<'_, f32, AXES>) -> Setpoint<f32, AXES> {
    interpolator.tick()
}

#[inline(never)]
fn switch(interpolator: &mut Interpolator<'_, f32, AXES>, at: &Setpoint<f32, AXES>) -> f32 {
    // What a board would set.
    let mut levels = 0u32;
    let power =
        interpolator.switch(at, |switched| levels = levels.wrapping_add(switched.value as u32));
    core::hint::black_box(levels);
    power
}

#[inline(never)]
fn shape(shaper: &mut Shaper<f32, AXES, HISTORY>, at: &Setpoint<f32, AXES>) -> Setpoint<f32, AXES> {
    shaper.shape(at)
}

#[inline(never)]
fn follow(motors: &Linear<f32, AXES, AXES>, at: &Setpoint<f32, AXES>) -> Setpoint<f32, AXES> {
    motors.setpoint(at)
}

/// What the calls of each addition took.
#[derive(Default)]
struct Counts {
    tick: Count,
    idle: Count,
    switch: Count,
    shapers: [Count; 4],
    motors: Count,
}

/// A star of lines: long enough to cruise, short enough to keep planning busy.
fn point(n: u32) -> Option<[Coord; AXES]> {
    let way = f64::from(n % 12) - 6.0;
    let place = [way * 3.0, f64::from(n % 7) * 4.0, f64::from(n % 5) * 0.5];
    let [x, y, z] = place.map(|mm| Coord::from_mm(mm).ok());
    Some([x?, y?, z?])
}

/// Hands over lines as long as there is room, each with its switches.
fn feed(planner: &mut Planner<'_, f32, AXES>, next: &mut u32) -> Option<()> {
    while *next < LINES {
        if planner.push(&Block::line(point(*next)?, 80.0, *next)).is_err() {
            return Some(());
        }
        *next += 1;
        for output in 0..OUTPUTS {
            // What finds no room is left out.
            let _ = planner.push_switch(&Switch::digital(output, *next % 2 == 0));
        }
        let _ = planner.set_power(&Power::in_proportion(1000.0, 50.0, 1000.0));
    }
    planner.finish();
    Some(())
}

fn run(timer: &mut Timer, shapers: &mut Shapers) -> Option<(Counts, u32)> {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; AXES]).ok()?);
    config.tolerance = 0.05;
    for (shaper, (_, kind)) in shapers.iter_mut().zip(SHAPERS) {
        let shape = Shape { kind, frequency: 40.0, damping: 0.06 };
        shaper.set([Some(shape); AXES], &config).ok()?;
    }
    let motors = Linear::new([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 1.0]]).ok()?;
    let mut link = Link::<f32, AXES, BLOCKS, NODES>::new();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).ok()?;
    let (mut counts, mut next) = (Counts::default(), 0);
    for cycle in 0..PATIENCE {
        feed(&mut planner, &mut next)?;
        planner.settle();
        timer.begin();
        let setpoint = tick(&mut interpolator);
        timer.add(&mut counts.tick);
        let waits = setpoint.activity == Activity::Idle;
        timer.begin();
        switch(&mut interpolator, &setpoint);
        timer.add(if waits { &mut counts.idle } else { &mut counts.switch });
        for (shaper, count) in shapers.iter_mut().zip(&mut counts.shapers) {
            timer.begin();
            core::hint::black_box(shape(shaper, &setpoint));
            timer.add(count);
        }
        timer.begin();
        core::hint::black_box(follow(&motors, &setpoint));
        timer.add(&mut counts.motors);
        if waits && next == LINES && cycle > 1000 && shapers.iter().all(Shaper::is_settled) {
            return Some((counts, cycle));
        }
    }
    None
}

fn print(name: &str, count: &Count) {
    let mean = count.sum.checked_div(count.calls.into()).unwrap_or(0);
    hprintln!(
        "{}={} {}_worst={}",
        name,
        instructions(mean),
        name,
        instructions(count.worst.into())
    );
}

fn go() -> Option<()> {
    let mut shapers: Shapers = [const { Shaper::new() }; 4];
    let (counts, cycles) = run(&mut Timer::calibrated(), &mut shapers)?;
    hprintln!("cycles={}", cycles);
    print("tick", &counts.tick);
    print("switch_idle", &counts.idle);
    print("switch", &counts.switch);
    for ((name, _), count) in SHAPERS.iter().zip(&counts.shapers) {
        print(name, count);
    }
    print("motors", &counts.motors);
    Some(())
}

#[entry]
fn main() -> ! {
    end(go(), "the program does not come to its end")
}
