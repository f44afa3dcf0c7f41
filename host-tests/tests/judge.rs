//! The judge finds violations of 1 % at servo cycles from 1 us to 10 ms, in both number types, and nothing
//! where nothing is broken.

use splineway::Activity;
use splineway_simulator::judge::{Follower, Judge, Track, Verdict, violations};
use splineway_simulator::machine::Axis;
use splineway_simulator::program::{Course, Move, Program, Speed};
use splineway_simulator::run::{Observer, Pace, Sample};

const CYCLES: [f64; 8] = [1e-6, 5e-6, 2e-5, 2.2e-5, 1e-4, 1e-3, 4e-3, 1e-2];
const LIMIT: Axis = Axis { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0 };
const BAND: f64 = 0.01;

/// What is planted: factors of velocity, acceleration and jerk, and whether the setpoints own up to it.
#[derive(Clone, Copy, Debug)]
struct Plant {
    peaks: [f64; 3],
    owns_up: bool,
    aside: f64,
    leap: f64,
}

const CLEAN: Plant = Plant { peaks: [1.0; 3], owns_up: true, aside: 0.0, leap: 0.0 };

/// Seven phases from rest, to full speed, through which all three limits are reached: phases of 40 ms of
/// jerk, 60 ms of acceleration.
fn motion(t: f64, [v, a, j]: [f64; 3]) -> [f64; 3] {
    let (velocity, acceleration, jerk) =
        (LIMIT.velocity * v, LIMIT.acceleration * a, LIMIT.jerk * j);
    let rise = acceleration / jerk;
    let steady = velocity / acceleration - rise;
    let phases = [(rise, jerk), (steady, 0.0), (rise, -jerk), (0.03, 0.0)];
    let back = [(rise, -jerk), (steady, 0.0), (rise, jerk)];
    let mut state = [0.0; 3];
    let mut left = t;
    for (time, jerk) in phases.into_iter().chain(back) {
        let dt = left.min(time);
        let [x, v, a] = state;
        state = [
            x + v * dt + a * dt * dt / 2.0 + jerk * dt * dt * dt / 6.0,
            v + a * dt + jerk * dt * dt / 2.0,
            a + jerk * dt,
        ];
        left -= dt;
    }
    state
}

fn verdict(cycle: f64, single: bool, plant: Plant) -> Vec<String> {
    let mut program = Program::default();
    let mut to = [0.0; 9];
    to[0] = motion(1.0, plant.peaks)[0];
    program.moves.push(Move {
        path: Course::Line { to },
        speed: Speed::Rapid,
        tolerance: None,
        exact_stop: false,
        line: 1,
    });
    let track = Track::new(&program);
    let limits = [LIMIT; 3];
    let mut judge = Judge::new(&track, &limits, cycle, BAND);
    let round = |x: f64| if single { f64::from(x as f32) } else { x };
    let unit = if single { f64::from(f32::EPSILON) } else { f64::EPSILON };
    let count = (0.37 / cycle) as u64;
    for k in 0..=count {
        let time = k as f64 * cycle;
        let at = motion(time, plant.peaks);
        let said = if plant.owns_up { at } else { motion(time, CLEAN.peaks) };
        // Pieces of 10 ms: positions are fixed-point origins and offsets in the core's number type.
        let began = time.div_euclid(0.01) * 0.01;
        let origin = (motion(began, plant.peaks)[0] * 1e12).round() / 1e12;
        let leap = if time > 0.15 { plant.leap } else { 0.0 };
        let x = origin + round(at[0] - origin) + leap;
        // To the side within 0.2 s, from rest to rest.
        let side = |time: f64| {
            let u = (time / 0.2).min(1.0);
            plant.aside * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
        };
        let u = (time / 0.2).min(1.0);
        let foot = (side(began) * 1e12).round() / 1e12;
        let y = foot + round(side(time) - foot);
        let swing = [
            plant.aside * 30.0 * u * u * (1.0 - u) * (1.0 - u) / 0.2,
            plant.aside * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / 0.04,
        ];
        let sample = Sample {
            time,
            position: &[x, y, 0.0],
            velocity: &[round(said[1]), round(swing[0]), 0.0],
            acceleration: &[round(said[2]), round(swing[1]), 0.0],
            path: x,
            speed: said[1],
            tag: 1,
            activity: if k == 0 { Activity::Idle } else { Activity::Running },
            began: k > 0 && time % 0.01 < cycle,
            unit,
            pace: Pace::FULL,
        };
        judge.setpoint(&sample).unwrap();
    }
    let verdict: Verdict = Verdict { end_error: 0.0, ..judge.verdict() };
    violations(&verdict)
}

#[test]
fn clean_runs_pass_at_every_cycle() {
    for cycle in CYCLES {
        for single in [false, true] {
            let found = verdict(cycle, single, Plant { aside: 0.009, ..CLEAN });
            assert!(found.is_empty(), "{cycle} s, single {single}: {found:?}");
        }
    }
}

#[test]
fn planted_violations_are_found_at_every_cycle() {
    for cycle in CYCLES {
        for single in [false, true] {
            for (plant, word) in [
                (Plant { peaks: [1.01, 1.0, 1.0], ..CLEAN }, "velocity"),
                (Plant { peaks: [1.0, 1.01, 1.0], ..CLEAN }, "acceleration"),
                (Plant { peaks: [1.0, 1.0, 1.01], ..CLEAN }, "jerk"),
                (Plant { aside: BAND * 1.01, ..CLEAN }, "deviation"),
                // A core that lies about its velocity, and one that leaps by 2 um, or by more than the
                // jerk allows within a cycle.
                (Plant { peaks: [1.01, 1.0, 1.0], owns_up: false, ..CLEAN }, ""),
                (Plant { leap: 2e-3 + 2.0 * LIMIT.jerk * cycle.powi(3), ..CLEAN }, ""),
            ] {
                let found = verdict(cycle, single, plant);
                let named = found.iter().any(|text| text.contains(word));
                assert!(named, "{cycle} s, single {single}: {plant:?}: {found:?}");
            }
        }
    }
}

/// On a circle inside its own band nobody can tell the turns apart: the place followed lags by as many as there are,
/// and what comes behind them is no violation.
#[test]
fn turns_within_the_band_are_followed_to_what_comes_behind() {
    const TURNS: u16 = 40;
    let radius = 0.8 * BAND;
    let line = |path, line| Move {
        path,
        speed: Speed::PerSecond(1.0),
        tolerance: None,
        exact_stop: false,
        line,
    };
    let mut program = Program::default();
    (program.uses[0], program.uses[1]) = (true, true);
    let far = [5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    program.moves = vec![
        line(
            Course::Arc {
                to: [0.0; 9],
                plane: (0, 1),
                centre: (0.0, radius),
                clockwise: false,
                extra_turns: TURNS - 1,
            },
            1,
        ),
        line(Course::Line { to: far }, 2),
    ];
    let track = Track::new(&program);
    let mut follower = Follower::default();
    let round = std::f64::consts::TAU * radius;
    let step = 0.002;
    let outside = |follower: &mut Follower, x: &[f64]| {
        follower.look(&track, x, 20.0 * BAND + 0.02 + 2.0 * step, BAND).outside.distance
    };
    let circle = f64::from(TURNS) * round;
    for k in 0..((circle + 5.0) / step) as u32 {
        let way = f64::from(k) * step;
        let (sin, cos) = (way / radius).sin_cos();
        let on_circle = [radius * sin, radius * (1.0 - cos)];
        let x = if way < circle { on_circle } else { [way - circle, 0.0] };
        assert!(outside(&mut follower, &x) < 0.0, "{way} mm");
    }
    // What is not there is seen all the same.
    assert!(outside(&mut follower, &[5.0, 1.1 * BAND]) > 0.0);
}
