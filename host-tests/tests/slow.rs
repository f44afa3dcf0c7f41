//! Slow motions on long lines: where cells are made for the programmed feed, a start, a stop or a fall at a hundredth of it takes no longer than that speed asks
//! for.

use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Limits, Link, Scalar, Setpoint,
};

const AXES: usize = 2;
/// s.
const CYCLE: f64 = 1.0e-3;
/// All that there is to do.
const ALL: u32 = u32::MAX;

/// Straight on, in lines of so many mm, at so many mm/s.
#[derive(Clone, Copy, Debug)]
struct Lines {
    length: f64,
    feed: f64,
}

/// Runs lines, with some slices of planning in a servo cycle, until `each` has seen enough: it is told the cycle and the setpoint, and may give commands. Returns
/// that cycle.
fn run<S: Scalar>(
    Lines { length, feed }: Lines,
    slices: impl Fn(u32) -> u32,
    mut each: impl FnMut(u32, &Setpoint<S, AXES>, Controls<'_>) -> bool,
) -> u32 {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(0.02);
    assert!((config.cycle.to_f64() - CYCLE).abs() < 1.0e-9);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
    let controls = planner.controls();
    let (mut lines, mut passed) = (0, 0.0);
    for cycle in 0..100_000 {
        while f64::from(lines) * length < passed + 700.0 {
            let to = [Coord::from_mm(f64::from(lines + 1) * length).unwrap(), Coord::ZERO];
            if planner.push(&Block::line(to, S::of(feed), lines)).is_err() {
                break;
            }
            lines += 1;
        }
        let slices = slices(cycle);
        if slices == ALL {
            planner.settle();
        } else {
            for _ in 0..slices {
                planner.poll();
            }
        }
        let setpoint = interpolator.tick();
        passed = setpoint.path_mm();
        if each(cycle, &setpoint, controls) {
            return cycle;
        }
    }
    panic!("no end at {passed} mm");
}

/// Servo cycles from a resume at rest until nineteen twentieths of what is asked for then are reached: a hold is pressed after some cycles of motion at another
/// override.
fn restart<S: Scalar>(feed: f64, held: u32, [before, then]: [u16; 2]) -> u32 {
    let wanted = 0.95 * feed * f64::from(then) / 100.0;
    let (mut moved, mut resumed) = (0, None);
    let each = |cycle: u32, setpoint: &Setpoint<S, AXES>, controls: Controls<'_>| {
        let speed = setpoint.path_speed.to_f64();
        if cycle == 0 {
            controls.feed_override(before);
        }
        moved += u32::from(speed > 0.0);
        if moved == held {
            controls.hold();
        }
        if moved >= held && speed == 0.0 && resumed.is_none() {
            controls.feed_override(then);
            controls.resume();
            resumed = Some(cycle);
        }
        resumed.is_some() && speed >= wanted
    };
    let reached = run(Lines { length: 600.0, feed }, |_| ALL, each);
    reached - resumed.unwrap()
}

/// What was left of a cell was shorter than the ramp, and the one behind it many times as long as that: 2.7 s to 0.1 mm/s, 0.2 s to 1 mm/s.
#[test]
fn from_a_rest_within_a_line_the_speed_is_reached_at_once() {
    for feed in [10.0, 90.0] {
        for overrides in [[1, 1], [1, 10], [1, 100], [20, 1], [100, 1], [100, 10], [100, 100]] {
            // From rest to 90 mm/s takes 85 ms.
            let allowed = if feed * f64::from(overrides[1]) > 1000.0 { 100 } else { 55 };
            for held in 1..40 {
                let taken =
                    [restart::<f64>(feed, held, overrides), restart::<f32>(feed, held, overrides)];
                let most = taken.into_iter().max().unwrap();
                assert!(
                    most < allowed,
                    "{feed} mm/s, {overrides:?} %, hold after {held}: {taken:?} cycles"
                );
            }
        }
    }
}

/// Time, s, from a stop to the rest at the end of a block beyond what the way takes at the speed there was.
fn stop<S: Scalar>(lines: Lines, percent: u16, pressed: u32, slices: u32) -> f64 {
    let mut place = 0.0;
    let each = |cycle: u32, setpoint: &Setpoint<S, AXES>, controls: Controls<'_>| {
        if cycle == 0 {
            controls.feed_override(percent);
        }
        if cycle == pressed {
            controls.stop();
            place = setpoint.path_mm();
        }
        if cycle > pressed && setpoint.activity == Activity::Idle && setpoint.path_speed == S::ZERO
        {
            // Of shorter lines several are one at such feeds; with slow planning the motion may rest within one first.
            let ends = setpoint.path_mm() / lines.length;
            let off = (ends - ends.round()).abs() > 1.0e-6;
            assert!(!(off && lines.length >= 2.0 && slices == ALL), "{lines:?}: {ends} at rest");
            place = setpoint.path_mm() - place;
            return true;
        }
        false
    };
    let cycles = run(lines, |_| slices, each) - pressed;
    f64::from(cycles) * CYCLE - place / (lines.feed * f64::from(percent) / 100.0)
}

/// Up to 0.1 s at the feed of the program, 0.8 s at a tenth of it and 7.8 s at a hundredth before: the whole of the last cell was one brake.
#[test]
fn a_stop_takes_the_way_to_the_end_of_the_block_at_the_speed_there_is() {
    for feed in [10.0, 40.0, 90.0] {
        for percent in [1, 10, 100] {
            for length in [0.5, 2.0, 10.0] {
                let speed = feed * f64::from(percent) / 100.0;
                if length / speed > 20.0 {
                    continue;
                }
                for pressed in (200..1000).step_by(97) {
                    for slices in [ALL, 5] {
                        let lines = Lines { length, feed };
                        let late = stop::<f64>(lines, percent, pressed, slices)
                            .max(stop::<f32>(lines, percent, pressed, slices));
                        assert!(
                            late < 0.03 + 5.0e-4 * feed,
                            "{lines:?}, {percent} %, {slices} slices, stop in cycle {pressed}: {late} s"
                        );
                    }
                }
            }
        }
    }
}

/// Servo cycles until the motion is no faster than a hundredth of the feed, and a tenth of that: it is lowered to that some cycles after it was from 150 to 30 %,
/// with a burst of slices in one servo cycle of some, and all that is to do from `more` cycles later on.
fn lowered_again(feed: f64, (apart, burst): (u32, u32), gap: u32, more: u32) -> u32 {
    const PRESSED: u32 = 500;
    let fast = PRESSED + gap + more;
    let slices = |cycle| match cycle {
        _ if !(PRESSED - 50..fast).contains(&cycle) => ALL,
        _ if cycle % apart == 0 => burst,
        _ => 0,
    };
    let each = |cycle: u32, setpoint: &Setpoint<f64, AXES>, controls: Controls<'_>| {
        match cycle {
            0 => controls.feed_override(150),
            PRESSED => controls.feed_override(30),
            _ if cycle == PRESSED + gap => controls.feed_override(1),
            _ => {}
        }
        cycle >= fast && (setpoint.path_speed <= feed * 0.011 || cycle > fast + 3000)
    };
    run(Lines { length: 600.0, feed }, slices, each) - fast
}

/// An answer that fell short was withdrawn for the next before it took effect, for ever; and a motion that had been slowed down counted as one that gets going.
#[test]
fn an_override_that_is_lowered_again_is_obeyed() {
    for feed in [10.0, 90.0] {
        for background in [(1, 1), (10, 1), (10, 5), (20, 5), (40, 5)] {
            for gap in [20, 60, 150] {
                for more in [10, 60, 100] {
                    let taken = lowered_again(feed, background, gap, more);
                    assert!(
                        taken < 200,
                        "{feed} mm/s, {background:?}, {gap} and {more}: {taken} cycles"
                    );
                }
            }
        }
    }
}
