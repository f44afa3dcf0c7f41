//! A planned motion, reshaped window by window as a controller would: how much faster it becomes, judged.

use crate::anymotion::motion::State as Values;
use crate::anymotion::tube::{Segment, associate};
use crate::anymotion::{parts, segments, show};
use anyhow::{Result, ensure};
use splineway::reshape::{Agreed, Bounds, Line, Onward, State, Window};
use splineway::{Activity, AxisLimits, Scalar};
use splineway_simulator::judge::{Judge, Track, Verdict};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::Program;
use splineway_simulator::run::{Observer, Precision, Sample, run};

/// Control points of a window: 40 spans.
const POINTS: usize = 43;
/// Time between knots, s, and spans that are run before the next window.
const KNOTS: f64 = 8.0e-3;
const RUN: usize = 10;
/// Share of the band that is used where it is looked at.
const BAND: f64 = 0.99;
/// States of the planned motion in a servo cycle.
const FINER: usize = 4;
/// The agreed motion is looked at so much further than a window is long.
const AHEAD: f64 = 3.0;

/// What became of a program.
#[derive(Debug, Default)]
pub struct Improved {
    /// Time of the motion that the core plans, s.
    pub planned: f64,
    /// Time of the motion found, s, in whole servo cycles.
    pub reshaped: f64,
    /// The judge's word on that.
    pub verdict: Verdict,
    /// Windows, and those in which nothing better was found.
    pub windows: usize,
    /// See `windows`.
    pub refused: usize,
    /// Steps of Newton's method in all.
    pub steps: usize,
    /// Setpoints: positions of the axes in use in every servo cycle.
    pub setpoints: Vec<Vec<f64>>,
}

/// Plans a program and reshapes the motion, all of the reshaping in the given precision.
///
/// # Errors
/// A program that cannot be run, or with a tolerance of 0; more than five axes.
pub fn reshaped(program: &Program, machine: &Machine, precision: Precision) -> Result<Improved> {
    match (program.axes().len(), precision) {
        (1, Precision::F64) => over::<f64, 1>(program, machine),
        (2, Precision::F64) => over::<f64, 2>(program, machine),
        (3, Precision::F64) => over::<f64, 3>(program, machine),
        (4, Precision::F64) => over::<f64, 4>(program, machine),
        (5, Precision::F64) => over::<f64, 5>(program, machine),
        (1, Precision::F32) => over::<f32, 1>(program, machine),
        (2, Precision::F32) => over::<f32, 2>(program, machine),
        (3, Precision::F32) => over::<f32, 3>(program, machine),
        (4, Precision::F32) => over::<f32, 4>(program, machine),
        (5, Precision::F32) => over::<f32, 5>(program, machine),
        (axes, _) => anyhow::bail!("{axes} axes move; 1 to 5 can be reshaped"),
    }
}

fn over<S: Scalar, const N: usize>(program: &Program, machine: &Machine) -> Result<Improved> {
    let limits = machine.axes_of(program)?;
    let axes = program.axes();
    let track = Track::new(program);
    ensure!(track.len() > 1, "nothing moves");
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
    let mut improved = Improved::default();
    let limits = core::array::from_fn(|i| {
        let of = |x: f64| S::of(x);
        let axis = limits[i];
        AxisLimits::linear(of(axis.velocity), of(axis.acceleration), of(axis.jerk))
    });
    let mut time = 0.0;
    for part in parts(program) {
        let path = segments(&part.program, machine, &axes, 1.0)?;
        if path.is_empty() {
            improved.planned += part.dwell;
            time += part.dwell;
            continue;
        }
        let motion = Planned::of(&part.program, machine)?;
        improved.planned += motion.duration() + part.dwell;
        let mut found = Found::new(machine.cycle);
        reshape::<S, N>(&path, &motion, &limits, &mut found, &mut improved);
        let skip = usize::from(!improved.setpoints.is_empty());
        for (k, state) in found.states.iter().enumerate().skip(skip) {
            let unit = S::EPSILON.to_f64();
            show(&mut judge, time + k as f64 * machine.cycle, state, unit)?;
            improved.setpoints.push(state[0].clone());
        }
        time += (found.states.len() - 1) as f64 * machine.cycle + part.dwell;
    }
    improved.reshaped = time;
    improved.verdict = judge.verdict();
    Ok(improved)
}

/// One part, from rest to rest.
fn reshape<S: Scalar, const N: usize>(
    path: &[Segment],
    motion: &Planned,
    limits: &[AxisLimits<S>; N],
    found: &mut Found,
    improved: &mut Improved,
) {
    let legs = associate(path, &motion.places());
    let mut window = Window::<S, N, POINTS>::new(S::of(KNOTS), S::of(BAND));
    let mut origin: [f64; N] = motion.at(0.0)[0];
    let mut clock = 0.0;
    let mut leg = legs[0];
    let onward = |origin: &[f64; N], clock: f64, first: usize| Going {
        motion,
        legs: &legs,
        origin: *origin,
        clock,
        first,
    };
    window.begin(&onward(&origin, clock, leg).at(S::ZERO).state, S::ZERO);
    loop {
        // The origin and the clock come along, so that numbers stay small.
        let here = window.state().position.map(S::to_f64);
        window.move_origin(&here.map(S::of));
        for i in 0..N {
            origin[i] += S::of(here[i]).to_f64();
        }
        let joins = window.joins();
        window.move_clock(joins);
        clock += joins.to_f64();
        let agreed = onward(&origin, clock, leg);
        let ahead = (POINTS as f64) * KNOTS * AHEAD;
        let last = agreed.leg(S::of(ahead)).max(leg);
        let lines: Vec<Line<S, N>> = path[leg..=(last + 1).min(path.len() - 1)]
            .iter()
            .map(|segment| line(segment, &origin))
            .collect();
        let mut bounds = Bounds { limits, lines: &lines, line: 0 };
        improved.windows += 1;
        match window.improve(&agreed, &bounds) {
            Ok(better) => improved.steps += better.steps,
            Err(_) => improved.refused += 1,
        }
        let ends = motion.duration() - (clock + window.joins().to_f64());
        if window.spans() == 0 {
            // As agreed, for as long as a window would have run.
            let run = (RUN as f64 * KNOTS).min(ends);
            let from = clock + window.joins().to_f64();
            found.stretch(run, |time| motion.state::<N>(from + time));
            clock = from + run;
            if ends - run < 1.0e-9 {
                break;
            }
            leg = legs[motion.cycle(clock)].max(leg);
            let state = onward(&origin, clock, leg).at(S::ZERO).state;
            window.begin(&state, S::ZERO);
            continue;
        }
        let spans = if ends < 1.0e-9 { window.spans() } else { RUN.min(window.spans()) };
        for _ in 0..spans {
            let h = window.knots().to_f64();
            let base = window.base();
            found.stretch(h, |time| {
                let State { position, velocity, acceleration } = window.within(S::of(time / h));
                let place = |i: usize| origin[i] + base[i].to_f64() + position[i].to_f64();
                let place = (0..N).map(place).collect();
                let values = |x: [S; N]| x.map(S::to_f64).to_vec();
                [place, values(velocity), values(acceleration)]
            });
            bounds.line = window.advance(&bounds);
        }
        leg += bounds.line;
        if ends < 1.0e-9 && window.spans() == 0 {
            break;
        }
    }
    found.rest(motion.at::<N>(motion.duration())[0].to_vec());
}

fn line<S: Scalar, const N: usize>(segment: &Segment, origin: &[f64; N]) -> Line<S, N> {
    Line {
        from: core::array::from_fn(|i| S::of(segment.from[i] - origin[i])),
        direction: core::array::from_fn(|i| S::of(segment.direction[i])),
        length: S::of(segment.length),
        band: S::of(segment.band),
        feed: S::of(segment.feed.min(Line::<f64, 1>::RAPID)),
    }
}

/// The planned motion: states less than a servo cycle apart, with a quintic between any two; where the jerk changes in between, that
/// has more than the motion, for so short a time that the setpoints do not.
struct Planned {
    states: Vec<Values>,
    step: f64,
}

impl Planned {
    fn of(program: &Program, machine: &Machine) -> Result<Self> {
        let step = machine.cycle / FINER as f64;
        let mut planned = Self { states: vec![], step };
        let finer = Machine { cycle: step, ..machine.clone() };
        run(program, &finer, Precision::F64, &mut [&mut planned])?;
        ensure!(planned.states.len() > 1, "nothing moves");
        Ok(planned)
    }

    fn duration(&self) -> f64 {
        (self.states.len() - 1) as f64 * self.step
    }

    fn interval(&self, time: f64) -> usize {
        ((time / self.step).max(0.0) as usize).min(self.states.len() - 1)
    }

    /// Positions in every servo cycle.
    fn places(&self) -> Vec<Vec<f64>> {
        self.states.iter().step_by(FINER).map(|state| state[0].clone()).collect()
    }

    /// Servo cycle at a time.
    fn cycle(&self, time: f64) -> usize {
        self.interval(time) / FINER
    }

    /// Position and its first four derivatives at a time.
    fn at<const N: usize>(&self, time: f64) -> [[f64; N]; 5] {
        let k = self.interval(time).min(self.states.len() - 2);
        let h = self.step;
        let t = (time - k as f64 * h).clamp(0.0, h);
        let (a, b) = (&self.states[k], &self.states[k + 1]);
        let mut all = [[0.0; N]; 5];
        for i in 0..N {
            let [p, v, c] = [a[0][i], a[1][i], a[2][i]];
            // What is missing at the end of the parabola.
            let d = b[0][i] - (p + h * (v + 0.5 * h * c));
            let e = (b[1][i] - (v + h * c)) * h;
            let f = (b[2][i] - c) * h * h;
            let u = t / h;
            let [x, y, z] = [
                10.0 * d - 4.0 * e + 0.5 * f,
                -15.0 * d + 7.0 * e - f,
                6.0 * d - 3.0 * e + 0.5 * f,
            ];
            all[0][i] = p + t * (v + 0.5 * t * c) + u * u * u * (x + u * (y + u * z));
            all[1][i] = v + t * c + u * u * (3.0 * x + u * (4.0 * y + u * 5.0 * z)) / h;
            all[2][i] = c + u * (6.0 * x + u * (12.0 * y + u * 20.0 * z)) / (h * h);
            all[3][i] = (6.0 * x + u * (24.0 * y + u * 60.0 * z)) / (h * h * h);
            all[4][i] = (24.0 * y + u * 120.0 * z) / (h * h * h * h);
        }
        all
    }

    fn state<const N: usize>(&self, time: f64) -> Values {
        let [position, velocity, acceleration, ..] = self.at::<N>(time);
        [position, velocity, acceleration].map(|values| values.to_vec())
    }
}

impl Observer for Planned {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let state = [sample.position, sample.velocity, sample.acceleration].map(<[f64]>::to_vec);
        let rests = sample.activity != Activity::Running;
        match self.states.last_mut() {
            // From the last rest before the motion on, to the first behind it.
            Some(before) if rests && before[1].iter().all(|v| *v == 0.0) => *before = state,
            _ => self.states.push(state),
        }
        Ok(())
    }
}

/// What of the planned motion lies behind a time, about an origin, with lines counted from one on.
struct Going<'a, const N: usize> {
    motion: &'a Planned,
    legs: &'a [usize],
    origin: [f64; N],
    clock: f64,
    first: usize,
}

impl<const N: usize> Going<'_, N> {
    fn leg<S: Scalar>(&self, time: S) -> usize {
        self.legs[self.motion.cycle(self.clock + time.to_f64())]
    }
}

impl<S: Scalar, const N: usize> Agreed<S, N> for Going<'_, N> {
    fn at(&self, time: S) -> Onward<S, N> {
        let time = self.clock + time.to_f64();
        if time >= self.motion.duration() {
            let [end, ..] = self.motion.at::<N>(self.motion.duration());
            let end = core::array::from_fn(|i| S::of(end[i] - self.origin[i]));
            let none = [S::ZERO; N];
            return Onward { state: State::resting(end), jerk: none, snap: none };
        }
        let all = self.motion.at::<N>(time);
        let position = core::array::from_fn(|i| S::of(all[0][i] - self.origin[i]));
        let [velocity, acceleration, jerk, snap] =
            [all[1], all[2], all[3], all[4]].map(|values| values.map(S::of));
        Onward { state: State { position, velocity, acceleration }, jerk, snap }
    }

    fn line(&self, time: S) -> usize {
        self.leg(time).saturating_sub(self.first)
    }

    fn end(&self) -> S {
        S::of(self.motion.duration() - self.clock)
    }
}

/// What is run, cycle by cycle.
struct Found {
    states: Vec<Values>,
    cycle: f64,
    time: f64,
}

impl Found {
    fn new(cycle: f64) -> Self {
        Self { states: vec![], cycle, time: 0.0 }
    }

    /// A stretch of so long, s.
    fn stretch(&mut self, long: f64, at: impl Fn(f64) -> Values) {
        while (self.states.len() as f64) * self.cycle < self.time + long {
            let time = self.states.len() as f64 * self.cycle - self.time;
            self.states.push(at(time.max(0.0)));
        }
        self.time += long;
    }

    /// At rest from now on.
    fn rest(&mut self, position: Vec<f64>) {
        let none = vec![0.0; position.len()];
        self.states.push([position, none.clone(), none]);
    }
}
