//! What a feed word means for every kind of motion, with rotary axes that move along: units per minute (G94) are
//! the speed over the linear axes, inverse time (G93) is the time of the block.

use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Feed, Limits, Link, Motion, Progress, Scalar, Turn,
};

type Point = [Coord; 4];

fn at(point: [f64; 4]) -> Point {
    point.map(|x| Coord::from_mm(x).unwrap())
}

/// Three linear axes and one that turns, all far from their limits.
fn config<S: Scalar>() -> Config<S, 4> {
    let axis = |rotary| AxisLimits {
        velocity: S::of(2000.0),
        acceleration: S::of(2.0e5),
        jerk: S::of(2.0e7),
        rotary,
    };
    Config::new(Limits::new([axis(false), axis(false), axis(false), axis(true)]).unwrap())
}

/// Every kind of motion from zero, with `turn` degrees of the rotary axis; several blocks for a run.
fn motions<S: Scalar>(turn: f64) -> Vec<(&'static str, Vec<Motion<S, 4>>)> {
    let line = |x, y, a| Motion::Line { to: at([x, y, 0.0, a]) };
    let arc = |to, extra_turns| Motion::Arc {
        to,
        plane: (0, 1),
        centre: (Coord::ZERO, Coord::from_mm(20.0).unwrap()),
        turn: Turn::CounterClockwise,
        extra_turns,
    };
    let cubic = |a, b, to| Motion::Cubic { controls: [at(a), at(b)], to: at(to) };
    let run = (1..=200).map(|k| {
        let u = f64::from(k) / 200.0;
        line(20.0 * u.sin(), 20.0 - 20.0 * u.cos(), turn * u)
    });
    let mut list = vec![
        ("line", vec![line(20.0, 30.0, turn)]),
        ("arc", vec![arc(at([20.0, 20.0, 0.0, turn]), 0)]),
        ("helix", vec![arc(at([0.0, 0.0, 10.0, turn]), 1)]),
        (
            "curve",
            vec![cubic(
                [5.0, 15.0, 0.0, 0.3 * turn],
                [25.0, 15.0, 4.0, 0.6 * turn],
                [30.0, 0.0, 5.0, turn],
            )],
        ),
        (
            "straight curve",
            vec![cubic([10.0, 0.0, 0.0, 0.0], [10.0, 0.0, 0.0, turn], [10.0, 0.0, 0.0, turn])],
        ),
        ("run", run.collect()),
    ];
    if turn != 0.0 {
        list.push(("rotation", vec![line(0.0, 0.0, turn)]));
        let still = [0.0; 4];
        let end = [0.0, 0.0, 0.0, turn];
        list.push(("rotation as a curve", vec![cubic(still, end, end)]));
    }
    list
}

/// Time of a program, s, and the speeds over the linear axes, mm/s, of every cycle.
fn run<S: Scalar>(motions: &[Motion<S, 4>], feed: Feed<S>) -> (f64, Vec<f64>) {
    let mut link = Box::new(Link::<S, 4, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config(), [Coord::ZERO; 4]).unwrap();
    let mut left = motions.iter().peekable();
    let mut speeds = Vec::new();
    for cycle in 1..100_000 {
        while let Some(motion) = left.peek() {
            let block =
                Block { motion: **motion, feed, tolerance: None, exact_stop: false, tag: 0 };
            if planner.push(&block).is_err() {
                break;
            }
            left.next();
        }
        if left.peek().is_none() {
            planner.finish();
        }
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        if setpoint.activity == Activity::Idle && progress == Progress::Done {
            return (f64::from(cycle) * 1.0e-3, speeds);
        }
        let square: f64 = setpoint.velocity[..3].iter().map(|v| v.to_f64() * v.to_f64()).sum();
        speeds.push(square.sqrt());
    }
    panic!("does not end");
}

fn inverse_time_is_the_time_of_the_block<S: Scalar>() {
    for turn in [0.0, 5.0, 90.0, 700.0] {
        for (name, motions) in motions::<S>(turn) {
            for seconds in [0.5, 4.0] {
                let each = seconds / motions.len() as f64;
                let (took, _) = run(&motions, Feed::Duration(S::of(each)));
                // The speed is reached and left in some cycles; chords and bands are a little shorter.
                let rests = if name == "straight curve" && turn != 0.0 { 0.15 } else { 0.05 };
                let fits = took >= 0.995 * seconds && took <= 1.002 * seconds + rests;
                assert!(fits, "{name}, {turn} degrees, {}: {took} s of {seconds}", S::NAME);
            }
        }
    }
}

#[test]
fn inverse_time_is_the_time_of_the_block_f64() {
    inverse_time_is_the_time_of_the_block::<f64>();
}

#[test]
fn inverse_time_is_the_time_of_the_block_f32() {
    inverse_time_is_the_time_of_the_block::<f32>();
}

/// In the middle of the motion, away from its ends.
fn a_feed_is_the_speed_over_the_linear_axes<S: Scalar>() {
    for turn in [0.0, 5.0, 90.0] {
        for (name, motions) in motions::<S>(turn) {
            if name.starts_with("rotation") || name.starts_with("straight") {
                continue;
            }
            let (_, speeds) = run(&motions, Feed::PerSecond(S::of(20.0)));
            let n = speeds.len();
            for speed in &speeds[n / 5..n - n / 5] {
                let fits = (speed / 20.0 - 1.0).abs() < 0.02;
                assert!(fits, "{name}, {turn} degrees, {}: {speed} mm/s of 20", S::NAME);
            }
        }
    }
}

#[test]
fn a_feed_is_the_speed_over_the_linear_axes_f64() {
    a_feed_is_the_speed_over_the_linear_axes::<f64>();
}

#[test]
fn a_feed_is_the_speed_over_the_linear_axes_f32() {
    a_feed_is_the_speed_over_the_linear_axes::<f32>();
}
