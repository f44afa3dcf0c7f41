//! Windows over motions that stop at every corner: whatever comes out keeps all limits and the band, and ends where it should.

use super::course::State;
use super::vector::{along, dot, minus, square};
use super::way::Line;
use super::window::Window;
use super::{Agreed, Bounds, Onward};
use crate::AxisLimits;
use crate::number::Scalar;
use std::vec::Vec;

const N: usize = 2;
const POINTS: usize = 43;
const H: f64 = 8.0e-3;
/// Spans that are run between two windows.
const RUN: usize = 10;

/// From stop to stop along lines, each by a quintic of the arc length.
struct Stops {
    lines: Vec<Line<f64, N>>,
    /// When each begins, and when the last ends, s.
    times: Vec<f64>,
    /// s.
    clock: f64,
    origin: [f64; N],
    first: usize,
    /// It can be joined in the first half of every so long a time only, s; at any time if 0.
    grid: f64,
}

impl Stops {
    fn leg(&self, time: f64) -> usize {
        self.times.partition_point(|begins| *begins <= time).clamp(1, self.lines.len()) - 1
    }
}

impl<S: Scalar> Agreed<S, N> for Stops {
    fn at(&self, time: S) -> Onward<S, N> {
        let last = self.times[self.lines.len()];
        let time = (self.clock + time.to_f64()).min(last);
        let line = &self.lines[self.leg(time)];
        let (begins, ends) = (self.times[self.leg(time)], self.times[self.leg(time) + 1]);
        let (long, u) = (ends - begins, (time - begins) / (ends - begins));
        let way = [
            u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u),
            u * u * (30.0 - 60.0 * u + 30.0 * u * u),
            u * (60.0 - 180.0 * u + 120.0 * u * u),
            60.0 - 360.0 * u + 360.0 * u * u,
            720.0 * u - 360.0,
        ];
        let of = |k: usize| -> [S; N] {
            core::array::from_fn(|i| {
                let x = line.direction[i] * line.length * way[k]
                    / (0..k).fold(1.0, |power, _| power * long);
                S::of(if k == 0 { x + line.from[i] - self.origin[i] } else { x })
            })
        };
        let state = State { position: of(0), velocity: of(1), acceleration: of(2) };
        Onward { state, jerk: of(3), snap: of(4) }
    }

    fn line(&self, time: S) -> usize {
        self.leg(self.clock + time.to_f64()).saturating_sub(self.first)
    }

    fn can_be_joined(&self, time: S) -> S {
        if !(self.grid > 0.0) {
            return time;
        }
        let behind = (self.clock + time.to_f64()) % self.grid - self.grid / 2.0;
        if behind > 1.0e-6 { time - S::of(behind) } else { time }
    }

    fn end(&self) -> S {
        S::of(self.times[self.lines.len()] - self.clock)
    }
}

fn random(state: &mut u32) -> f64 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*state >> 8) / f64::from(1 << 24)
}

struct Case {
    stops: Stops,
    limits: [AxisLimits<f64>; N],
}

fn case(seed: u32) -> Case {
    let mut state = seed.wrapping_mul(2_654_435_761);
    let mut next = |from: f64, to: f64| from + (to - from) * random(&mut state);
    let limits = core::array::from_fn(|_| {
        AxisLimits::linear(next(50.0, 300.0), next(500.0, 8000.0), next(2.0e4, 3.0e5))
    });
    let tightest =
        |f: fn(&AxisLimits<f64>) -> f64| limits.iter().map(f).fold(f64::INFINITY, f64::min);
    let (velocity, acceleration, jerk) = (
        tightest(|axis| axis.velocity),
        tightest(|axis| axis.acceleration),
        tightest(|axis| axis.jerk),
    );
    let (mut from, mut heading) = ([next(-50.0, 50.0), next(-50.0, 50.0)], next(0.0, 6.0));
    let (mut lines, mut times) = (Vec::new(), std::vec![0.0]);
    for k in 0..=(seed % 6) as usize {
        let length = next(0.3, 15.0);
        let direction = [heading.cos(), heading.sin()];
        let feed = if seed.is_multiple_of(3) { next(20.0, 100.0) } else { Line::<f64, N>::RAPID };
        let line = Line { from, direction, length, band: next(0.005, 0.1), feed };
        from = line.end();
        lines.push(line);
        // Of the quintic speed, acceleration and jerk are at most so many.
        let long = (1.875 * length / velocity.min(feed))
            .max((5.774 * length / acceleration).sqrt())
            .max((60.0 * length / jerk).cbrt());
        times.push(times[k] + long * 1.05);
        // At times back along itself, or straight on with another feed.
        heading += if seed.is_multiple_of(5) {
            next(2.6, 3.6)
        } else if seed.is_multiple_of(3) && k % 2 == 0 {
            0.0
        } else {
            next(-2.5, 2.5)
        };
    }
    let grid = if seed % 4 == 1 { next(2.0e-3, 12.0e-3) } else { 0.0 };
    Case { stops: Stops { lines, times, clock: 0.0, origin: [0.0; N], first: 0, grid }, limits }
}

/// What was run: states every quarter of a span, and how much earlier it ended.
struct Ran {
    states: Vec<(f64, State<f64, N>)>,
    gain: f64,
    found: usize,
    /// Windows that were joined where they can be, and others.
    joined: [usize; 2],
}

fn ran<S: Scalar>(case: &mut Case) -> Ran {
    let Case { stops, limits } = case;
    let limits: [AxisLimits<S>; N] = limits.map(|axis| {
        let of = |x: f64| S::of(x);
        AxisLimits::linear(of(axis.velocity), of(axis.acceleration), of(axis.jerk))
    });
    let mut window = Window::<S, N, POINTS>::new(S::of(H), S::of(0.99));
    let (mut time, mut line, mut found) = (0.0, 0, 0);
    let mut joined = [0; 2];
    let mut states = Vec::new();
    stops.origin = stops.lines[0].from;
    window.begin(&Agreed::<S, N>::at(stops, S::ZERO).state, S::ZERO);
    let last = stops.times[stops.lines.len()];
    loop {
        let here = window.state().position;
        window.move_origin(&here);
        stops.origin = core::array::from_fn(|i| stops.origin[i] + here[i].to_f64());
        let joins = window.joins();
        window.move_clock(joins);
        stops.clock += joins.to_f64();
        stops.first = line;
        let lines: Vec<Line<S, N>> = stops.lines[line..]
            .iter()
            .map(|line| Line {
                from: core::array::from_fn(|i| S::of(line.from[i] - stops.origin[i])),
                direction: line.direction.map(S::of),
                length: S::of(line.length),
                band: S::of(line.band),
                feed: S::of(line.feed),
            })
            .collect();
        let mut bounds = Bounds { limits: &limits, lines: &lines, line: 0 };
        let is_found = window.improve(&*stops, &bounds).is_ok();
        found += usize::from(is_found);
        let joins = window.joins();
        if is_found && stops.grid > 0.0 && joins < Agreed::<S, N>::end(stops) {
            let can = Agreed::<S, N>::can_be_joined(stops, joins);
            joined[usize::from(can < joins)] += 1;
        }
        let left = last - stops.clock - window.joins().to_f64();
        if window.spans() == 0 {
            // As agreed.
            let long = (RUN as f64 * H).min(left);
            for k in 0..4 * RUN {
                let at = long * k as f64 / (4 * RUN) as f64;
                let clock = window.joins().to_f64() + at;
                let mut state = Agreed::<f64, N>::at(stops, clock).state;
                state.position = core::array::from_fn(|i| state.position[i] + stops.origin[i]);
                states.push((time + at, state));
            }
            time += long;
            let clock = window.joins() + S::of(long);
            line = stops.first + Agreed::<S, N>::line(stops, clock);
            if left - long < 1.0e-9 {
                break;
            }
            window.begin(&Agreed::<S, N>::at(stops, clock).state, clock);
            continue;
        }
        let spans = if left < 1.0e-9 { window.spans() } else { RUN.min(window.spans()) };
        for _ in 0..spans {
            let h = window.knots().to_f64();
            for k in 0..4 {
                let share = f64::from(k) / 4.0;
                let (base, state) = window.within(S::of(share));
                let position = core::array::from_fn(|i| {
                    stops.origin[i] + base[i].to_f64() + state.position[i].to_f64()
                });
                let (velocity, acceleration) =
                    (state.velocity.map(S::to_f64), state.acceleration.map(S::to_f64));
                states.push((time + share * h, State { position, velocity, acceleration }));
            }
            time += h;
            bounds.line = window.advance(&bounds);
        }
        line += bounds.line;
        if left < 1.0e-9 && window.spans() == 0 {
            break;
        }
    }
    let end = stops.lines[stops.lines.len() - 1].end();
    states.push((time, State::resting(end)));
    Ran { states, gain: last - time, found, joined }
}

/// What is broken, if anything: by how much more than rounding explains.
fn broken(case: &Case, ran: &Ran, unit: f64) -> Option<std::string::String> {
    let mut line = 0;
    for k in 0..ran.states.len() {
        let (time, state) = &ran.states[k];
        let speed = square(&state.velocity).sqrt();
        for i in 0..N {
            let limits = &case.limits[i];
            if state.velocity[i].abs() > limits.velocity * 1.0001 {
                return Some(std::format!("velocity of {i} is {} at {time}", state.velocity[i]));
            }
            if state.acceleration[i].abs() > limits.acceleration * 1.001 {
                return Some(std::format!(
                    "acceleration of {i} is {} at {time}",
                    state.acceleration[i]
                ));
            }
            if k == 0 {
                continue;
            }
            let (before, was) = &ran.states[k - 1];
            let step = time - before;
            let change = (state.acceleration[i] - was.acceleration[i]).abs();
            // An acceleration is what is left of positions of some mm.
            let noise = unit * 200.0 / (H * H);
            if change > limits.jerk * step * 1.001 + noise {
                return Some(std::format!("jerk of {i} is {} at {time}", change / step));
            }
            let half = (state.velocity[i] + was.velocity[i]) * 0.5;
            let goes = state.position[i] - was.position[i] - half * step;
            if goes.abs()
                > limits.jerk * step.powi(3)
                    + limits.acceleration * step * step / 6.0
                    + unit * 200.0
            {
                return Some(std::format!("position of {i} jumps by {goes} at {time}"));
            }
        }
        // The first line, from the one before on, in whose band it is.
        let lines = &case.stops.lines;
        let inside = |k: usize| {
            lines[k].foot(&state.position).square.sqrt() <= lines[k].band * 1.0001 + unit * 100.0
        };
        while line < lines.len() && !inside(line) {
            line += 1;
        }
        if line == lines.len() {
            return Some(std::format!("out of the band at {time}"));
        }
        // Of those that the place may be in.
        let feed = (line.saturating_sub(1)..(line + 2).min(lines.len()))
            .filter(|k| inside(*k))
            .fold(0.0, |most: f64, k| most.max(lines[k].feed));
        if speed > feed * 1.001 {
            return Some(std::format!("speed is {speed} of {feed} at {time}"));
        }
    }
    skipped(case, ran, unit).map(|joint| std::format!("the end of line {joint} is left out"))
}

/// The first line whose end is not come to in its turn: within the bands of both where it is followed by another, which lie
/// together up to some bands from it, or within the band where the path turns back.
fn skipped(case: &Case, ran: &Ran, unit: f64) -> Option<usize> {
    let lines = &case.stops.lines;
    let accelerations = case.limits.each_ref().map(|limits| limits.acceleration);
    let mut k = 1;
    for (n, pair) in lines.windows(2).enumerate() {
        let [before, after] = pair else { continue };
        let joint = before.end();
        let half = square(&core::array::from_fn::<_, N, _>(|i| {
            (before.direction[i] + after.direction[i]) * 0.5
        }))
        .sqrt();
        let most = before.band.min(after.band) / if half < 0.13 { 1.0 } else { half };
        let off = |k: usize| {
            let ((start, from), (end, to)) = (&ran.states[k - 1], &ran.states[k]);
            let way = minus(&to.position, &from.position);
            let share = dot(&minus(&joint, &from.position), &way) / square(&way).max(1.0e-30);
            let next = along(&from.position, share.clamp(0.0, 1.0), &way);
            // The motion leaves the chord by so much at most.
            let sagitta = square(&accelerations).sqrt() * (end - start).powi(2) / 8.0;
            square(&minus(&next, &joint)).sqrt() - sagitta
        };
        while k < ran.states.len() && off(k) > most * 1.001 + unit * 100.0 {
            k += 1;
        }
        if k == ran.states.len() {
            return Some(n);
        }
    }
    None
}

fn all<S: Scalar>(cases: u32) {
    let (mut found, mut gain, mut whole) = (0, 0.0, 0.0);
    let (mut joined, mut not) = (0, 0);
    for seed in 0..cases {
        let mut case = case(seed);
        let ran = ran::<S>(&mut case);
        if let Some(what) = broken(&case, &ran, S::EPSILON.to_f64()) {
            panic!("{} case {seed}: {what}", S::NAME);
        }
        assert!(ran.gain > -1.0e-6, "{} case {seed}: {}", S::NAME, ran.gain);
        found += ran.found;
        joined += ran.joined[0];
        not += ran.joined[1];
        gain += ran.gain;
        whole += case.stops.times[case.stops.lines.len()];
    }
    assert!(found as u32 > cases && gain > 0.2 * whole, "{found} {gain} {whole}");
    // Where it is not, the planner sees to it.
    assert!(joined > 4 * not && joined > 50, "{joined} {not}");
}

#[test]
fn whatever_is_found_keeps_limits_and_band_in_double_precision() {
    all::<f64>(600);
}

#[test]
fn whatever_is_found_keeps_limits_and_band_in_single_precision() {
    all::<f32>(600);
}

#[test]
fn a_corner_is_taken_without_a_stop() {
    let mut case = case(1);
    let line = |from, direction| Line { from, direction, length: 10.0, band: 0.05, feed: 1.0e9 };
    case.limits = [AxisLimits::linear(200.0, 2000.0, 50_000.0); N];
    case.stops.lines = std::vec![line([0.0; N], [1.0, 0.0]), line([10.0, 0.0], [0.0, 1.0])];
    case.stops.times = std::vec![0.0, 0.25, 0.5];
    let ran = ran::<f64>(&mut case);
    assert_eq!(broken(&case, &ran, f64::EPSILON), None);
    assert!(ran.gain > 0.1, "{}", ran.gain);
    let (_, slowest) = ran.states[20..ran.states.len() - 20]
        .iter()
        .map(|(time, state)| (time, square(&state.velocity).sqrt()))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap();
    assert!(slowest > 5.0, "{slowest}");
    // And it cuts the corner, by no more than the band.
    let nearest = ran
        .states
        .iter()
        .map(|(_, state)| square(&minus(&state.position, &[10.0, 0.0])).sqrt())
        .fold(f64::INFINITY, f64::min);
    assert!(nearest > 0.01 && nearest < 0.0708, "{nearest}");
}
