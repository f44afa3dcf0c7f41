//! Commands at any instant, while a few slices of planning are done in a servo cycle: whatever they interrupt, the limits
//! hold and the program comes to its end.

use crate::block::{Block, Feed};
use crate::machine::{AxisLimits, Config, Limits};
use crate::number::{Coord, Scalar};
use crate::planner::making::Purpose;
use crate::planner::{Link, Planner, Progress};
use crate::profile::law::Law;
use crate::servo::Activity;
use std::boxed::Box;
use std::vec::Vec;

const VELOCITY: f64 = 200.0;
const ACCELERATION: f64 = 2_000.0;
const JERK: f64 = 50_000.0;
const CYCLE: f64 = 1.0e-3;
/// More slices than all cells and plans in the window take in a servo cycle.
const ENDLESS: u32 = 10_000;
/// Where the program ends.
const END: [f64; 2] = [95.0, 3.0];

/// Xorshift: the same draws everywhere.
struct Draws(u64);

impl Draws {
    fn below(&mut self, end: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as u32 % end
    }
}

fn line<S: Scalar>([x, y]: [f64; 2], tag: u32) -> Block<S, 2> {
    Block::line([x, y].map(|mm| Coord::from_mm(mm).unwrap()), S::of(180.0), tag)
}

/// A long straight, corners, a circle of short lines, a straight.
fn program<S: Scalar>() -> Vec<Block<S, 2>> {
    let mut blocks = Vec::new();
    blocks.push(line([30.0, 0.0], 1));
    for k in 0..12u32 {
        blocks.push(line([30.0 + 4.0 * f64::from(k), 6.0 * f64::from(k % 2)], 2 + k));
    }
    for k in 1..60u32 {
        let (sin, cos) = (f64::from(k) * 0.1).sin_cos();
        blocks.push(line([74.0 + 9.0 * sin, 15.0 - 9.0 * cos], 20 + k));
    }
    blocks.push(line(END, 100));
    blocks
}

/// What a run has seen interrupted by a command: a hold, an override, a first answer.
type Interrupted = [u32; 3];

/// Wherever the agreed motion may be cut, there is a motion over what is left of the cell.
fn cuts_are_run<S: Scalar>(planner: &Planner<'_, S, 2, 16, 64>, draws: &mut Draws) {
    let horizon = &planner.horizon;
    for i in 0..horizon.end_index() {
        let share = S::of(f64::from(draws.below(1_000)) / 1_000.0);
        let Some(cut) = horizon.station_within(i, horizon.agreed_time(i) * share) else { continue };
        let after = horizon.window.get(i + 1).unwrap();
        let law = Law::new(cut.cell.length, cut.agreed, after.agreed);
        assert!(
            law.is_some(),
            "{:?} to {:?} in {:?} mm",
            cut.agreed,
            after.agreed,
            cut.cell.length
        );
    }
}

/// Runs the program with `slices` slices in a servo cycle and commands at random.
fn run<S: Scalar>(seed: u64, slices: u32) -> Interrupted {
    let mut draws = Draws(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let axis = AxisLimits::linear(S::of(VELOCITY), S::of(ACCELERATION), S::of(JERK));
    let mut config = Config::new(Limits::new([axis; 2]).unwrap());
    config.tolerance = S::of(0.05);
    let mut link = Box::new(Link::<S, 2, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 2]).unwrap();
    let (blocks, controls) = (program::<S>(), planner.controls());
    let (mut left, mut due, mut interrupted) = (&blocks[..], 20 + draws.below(60), [0; 3]);
    let mut before = [0.0; 2];
    for cycle in 0..20_000u32 {
        while let [block, rest @ ..] = left
            && planner.push(block).is_ok()
        {
            left = rest;
        }
        if left.is_empty() {
            planner.finish();
        }
        let mut progress = Progress::Planning;
        for _ in 0..slices {
            progress = planner.poll();
            if progress != Progress::Planning {
                break;
            }
        }
        cuts_are_run(&planner, &mut draws);
        let setpoint = interpolator.tick();
        for i in 0..2 {
            let velocity = setpoint.velocity[i].to_f64();
            let acceleration = setpoint.acceleration[i].to_f64();
            let jerk = (acceleration - before[i]) / CYCLE;
            before[i] = acceleration;
            let used = [velocity / VELOCITY, acceleration / ACCELERATION, jerk / JERK];
            assert!(
                used.iter().all(|share| share.abs() < 1.01),
                "seed {seed}, {slices} slices, cycle {cycle}, axis {i}: {used:?} of the limits"
            );
        }
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            let missed = (0..2).map(|i| (setpoint.position_mm(i) - END[i]).abs());
            assert!(missed.fold(0.0, f64::max) < 1.0e-4, "seed {seed}: it ends elsewhere");
            return interrupted;
        }
        if cycle == due && cycle < 1_500 {
            match planner.making.as_ref().map(|making| making.purpose) {
                Some(Purpose::Hold) => interrupted[0] += 1,
                Some(Purpose::Overrides) => interrupted[1] += 1,
                Some(Purpose::Easing(_) | Purpose::Reaction(_)) => interrupted[2] += 1,
                _ => {}
            }
            match draws.below(8) {
                0..=2 => controls.hold(),
                3 => controls.resume(),
                4 => controls.stop(),
                n => {
                    let percent = [5, 40, 160][n as usize - 5];
                    controls.feed_override(percent);
                }
            }
            // Some in a burst, as an impatient operator gives them.
            due += 1 + if draws.below(3) == 0 { draws.below(150) } else { draws.below(12) };
        } else if cycle >= 1_500 && cycle % 100 == 0 {
            controls.feed_override(100);
            controls.resume();
        }
    }
    panic!("seed {seed}, {slices} slices: no end, {:?}", planner.phase);
}

#[test]
fn whatever_a_command_interrupts_the_limits_hold_and_the_program_ends() {
    let mut sum = [0; 3];
    for seed in 0..24 {
        for slices in [1, 3, 7] {
            for interrupted in [run::<f32>(seed, slices), run::<f64>(seed, slices)] {
                for (sum, count) in sum.iter_mut().zip(interrupted) {
                    *sum += count;
                }
            }
        }
    }
    assert!(sum.iter().all(|&count| count > 20), "hold, override, first answer: {sum:?}");
}

/// Lines of all lengths, at any speed, on axes of any limits.
fn any_program<S: Scalar>(draws: &mut Draws) -> (Config<S, 2>, Vec<Block<S, 2>>) {
    let mut between = |least: f64, most: f64| {
        S::of(least * (most / least).powf(f64::from(draws.below(1000)) / 1000.0))
    };
    let axes = [(); 2].map(|()| {
        let velocity = between(5.0, 500.0);
        let acceleration = velocity * between(2.0, 100.0);
        AxisLimits::linear(velocity, acceleration, acceleration * between(5.0, 500.0))
    });
    let mut config = Config::new(Limits::new(axes).unwrap());
    (config.tolerance, config.lead) = (between(1.0e-3, 0.2), between(1.0e-3, 0.3));
    let mut at = [0.0; 2];
    let blocks = (0..24).map(|tag| {
        let feed = between(1.0, 300.0);
        for x in &mut at {
            let turn = between(1.0, 1.0e4).to_f64() > 100.0;
            *x += between(1.0e-3, 10.0).to_f64() * if turn { 1.0 } else { -1.0 };
        }
        Block { feed: Feed::PerSecond(feed), ..line(at, tag) }
    });
    let blocks = blocks.collect();
    (config, blocks)
}

/// Runs a program while overrides change, with planning that takes no time. The most slices in a servo cycle.
fn most_slices<S: Scalar>(seed: u64) -> u32 {
    let mut draws = Draws(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let (config, blocks) = any_program::<S>(&mut draws);
    let mut link = Box::new(Link::<S, 2, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 2]).unwrap();
    let (mut left, mut most) = (&blocks[..], 0);
    for _ in 0..1000 {
        if draws.below(6) == 0 {
            planner.controls().feed_override([1, 5, 50, 100, 150, 200][draws.below(6) as usize]);
        }
        let mut slices = 0;
        loop {
            while let [block, rest @ ..] = left
                && planner.push(block).is_ok()
            {
                left = rest;
            }
            if left.is_empty() {
                planner.finish();
            }
            slices += 1;
            let goes_on = matches!(planner.poll(), Progress::Planning | Progress::Planned);
            if !goes_on || slices == ENDLESS {
                break;
            }
        }
        most = most.max(slices);
        interpolator.tick();
    }
    most
}

/// A plan that is taken back as soon as it is handed over would be made for ever.
#[test]
fn planning_comes_to_an_end_in_every_servo_cycle() {
    for seed in 0..60 {
        for most in [most_slices::<f32>(seed), most_slices::<f64>(seed)] {
            assert!(most < ENDLESS, "seed {seed}: no end");
        }
    }
}
