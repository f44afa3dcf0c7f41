//! A planned motion, reshaped window by window as a controller would: how much faster it becomes, judged.

use crate::anymotion::motion::State as Values;
use crate::anymotion::tube::Segment;
use crate::anymotion::{parts, show};
use anyhow::{Result, ensure};
use splineway::reshape::{Agreed, Bounds, Line, Onward, Places, State, Window};
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
const FINER: usize = 8;
/// Places of the agreed motion of which the line is looked for, and how far they are apart, s: more than a window and what is gained in it.
const PLACES: usize = 256;
const APART: f64 = 2.0e-3;
/// Lines that a controller knows ahead.
const LINES: usize = 512;

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
    let jerks: Vec<f64> = limits.iter().map(|axis| axis.jerk).collect();
    let limits = core::array::from_fn(|i| {
        let of = |x: f64| S::of(x);
        let axis = limits[i];
        AxisLimits::linear(of(axis.velocity), of(axis.acceleration), of(axis.jerk))
    });
    let mut time = 0.0;
    for part in parts(program, machine, &axes, 1.0)? {
        let path = &part.path;
        if path.is_empty() {
            improved.planned += part.dwell;
            time += part.dwell;
            continue;
        }
        let motion = Planned::<N>::of(&part.program, machine, jerks.clone())?;
        // In whole servo cycles, as what comes of it.
        improved.planned += (motion.duration() / machine.cycle).ceil() * machine.cycle + part.dwell;
        let mut found = Found::new(machine.cycle);
        reshape::<S, N>(path, &motion, &limits, &mut found, &mut improved);
        let skip = usize::from(!improved.setpoints.is_empty());
        for (k, (state, piece)) in found.states.iter().enumerate().skip(skip) {
            show(&mut judge, time + k as f64 * machine.cycle, state, *piece)?;
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
    motion: &Planned<N>,
    limits: &[AxisLimits<S>; N],
    found: &mut Found,
    improved: &mut Improved,
) {
    let mut places = Places::<S, PLACES>::new(S::of(APART));
    let mut window = Window::<S, N, POINTS>::new(S::of(KNOTS), S::of(BAND));
    let mut origin: [f64; N] = motion.at(0.0)[0];
    let mut clock = 0.0;
    // The lines in which the window begins, and in which the agreed motion is joined.
    let (mut leg, mut joined) = (0, 0);
    window.begin(&Going { motion, origin, clock }.at(S::ZERO).state, S::ZERO);
    // By how much control points, which are rounded, miss where the motion is: it is made good over all spans up to the end, which they
    // miss too. All at once it would be a jump.
    let mut missed = apart(&origin, &place(&origin, begin(&window)));
    loop {
        // The origin and the clock come along, so that numbers stay small.
        let now = place(&origin, begin(&window));
        let begins: [f64; N] = core::array::from_fn(|i| now[i] + missed[i]);
        let here = window.state().position.map(S::to_f64);
        window.move_origin(&here.map(S::of));
        for i in 0..N {
            origin[i] += S::of(here[i]).to_f64();
        }
        let joins = window.joins();
        window.move_clock(joins);
        clock += joins.to_f64();
        let going = Going { motion, origin, clock };
        let lines: Vec<Line<S, N>> =
            path[leg..].iter().take(LINES).map(|segment| line(segment, &origin)).collect();
        places.find(&lines, joined - leg, going.end(), |time| going.at(time).state.position);
        let agreed = Placed { going: &going, places: &places, lines: &lines };
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
            found.stretch(run, f64::EPSILON, |time| motion.state(from + time));
            if ends - run < 1.0e-9 {
                break;
            }
            joined = leg + agreed.line(window.joins() + S::of(run)).min(lines.len() - 1);
            leg = joined;
            clock = from + run;
            // From nearby: it begins where the motion is as exactly as can be.
            origin = motion.at(clock)[0];
            window.begin(&Going { motion, origin, clock }.at(S::ZERO).state, S::ZERO);
            missed = apart(&origin, &place(&origin, begin(&window)));
            continue;
        }
        missed = apart(&begins, &place(&origin, begin(&window)));
        let joined_at = motion.at(clock + window.joins().to_f64())[0];
        let left = apart(&joined_at, &place(&origin, window.end()));
        let count = window.spans() as f64;
        let per: [f64; N] = core::array::from_fn(|i| (left[i] - missed[i]) / count);
        joined = leg + agreed.line(window.joins());
        let spans = if ends < 1.0e-9 { window.spans() } else { RUN.min(window.spans()) };
        for _ in 0..spans {
            let h = window.knots().to_f64();
            found.stretch(h, S::EPSILON.to_f64(), |time| {
                let (base, state) = window.within(S::of(time / h));
                let at = place(&origin, (base, state));
                let State { velocity, acceleration, .. } = state;
                let made_good = |i: usize| at[i] + missed[i] + per[i] * time / h;
                let values = |x: [S; N]| x.map(S::to_f64).to_vec();
                [(0..N).map(made_good).collect(), values(velocity), values(acceleration)]
            });
            bounds.line = window.advance(&bounds);
            for (missed, per) in missed.iter_mut().zip(per) {
                *missed += per;
            }
        }
        leg = (leg + bounds.line).min(joined);
        if ends < 1.0e-9 && window.spans() == 0 {
            break;
        }
    }
    found.rest(motion.at(motion.duration())[0].to_vec());
}

/// How a window's next span begins: without one, as it ends.
fn begin<S: Scalar, const N: usize>(window: &Window<S, N, POINTS>) -> ([S; N], State<S, N>) {
    if window.spans() > 0 { window.within(S::ZERO) } else { window.end() }
}

/// Where a window's motion is, by its position about a point near by, and that about the origin.
fn place<S: Scalar, const N: usize>(
    origin: &[f64; N],
    (base, state): ([S; N], State<S, N>),
) -> [f64; N] {
    core::array::from_fn(|i| origin[i] + base[i].to_f64() + state.position[i].to_f64())
}

/// From one place to another.
fn apart<const N: usize>(to: &[f64; N], from: &[f64; N]) -> [f64; N] {
    core::array::from_fn(|i| to[i] - from[i])
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

/// The planned motion: states less than a servo cycle apart. Between any two lies a quintic, which is the motion itself unless the jerk
/// leaps there and the quintic had more of it than the limit: see [`Leap`].
struct Planned<const N: usize> {
    states: Vec<[[f64; N]; 3]>,
    step: f64,
    /// Limits of the jerk, mm/s3.
    jerks: Vec<f64>,
}

impl<const N: usize> Planned<N> {
    fn of(program: &Program, machine: &Machine, jerks: Vec<f64>) -> Result<Self> {
        let step = machine.cycle / FINER as f64;
        let mut planned = Self { states: vec![], step, jerks };
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

    /// Position and its first four derivatives at a time.
    fn at(&self, time: f64) -> [[f64; N]; 5] {
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
            let cube = h * h * h;
            let jerk = |u: f64| (6.0 * x + u * (24.0 * y + u * 60.0 * z)) / cube;
            all[3][i] = jerk(u);
            all[4][i] = (24.0 * y + u * 120.0 * z) / (cube * h);
            let between = if z == 0.0 { 0.0 } else { (-0.2 * y / z).clamp(0.0, 1.0) };
            if [0.0, 1.0, between].iter().all(|u| jerk(*u).abs() <= self.jerks[i]) {
                continue;
            }
            let leap = Leap::new([d, e, f], self.jerks[i] * cube);
            let behind = (u - leap.at).max(0.0);
            let bent = |k: i32| leap.before * u.powi(k) + leap.by * behind.powi(k);
            all[0][i] = p + t * (v + 0.5 * t * c) + (bent(3) / 6.0) + u * leap.lost[0];
            all[1][i] = v + t * c + (0.5 * bent(2) + u * leap.lost[1]) / h;
            all[2][i] = c + bent(1) / (h * h);
            all[3][i] = (leap.before + if u < leap.at { 0.0 } else { leap.by }) / cube;
            all[4][i] = 0.0;
        }
        all
    }

    fn state(&self, time: f64) -> Values {
        let [position, velocity, acceleration, ..] = self.at(time);
        [position, velocity, acceleration].map(|values| values.to_vec())
    }
}

/// How a motion goes between two states, in units of the time between them: its jerk leaps once.
struct Leap {
    /// When.
    at: f64,
    /// Jerk before, and by how much it leaps.
    before: f64,
    by: f64,
    /// What is missing at the end, of place and velocity.
    lost: [f64; 2],
}

impl Leap {
    /// By what is missing at the end of the parabola from the first state on, of place, velocity and acceleration. Where one leap
    /// between jerks within the limit does not explain it, the acceleration changes evenly: its mean change is within the limit
    /// whatever the motion does.
    fn new([d, e, f]: [f64; 3], jerk: f64) -> Self {
        let lost = [d - f / 6.0, e - f / 2.0];
        let left = 3.0 * lost[0] / lost[1] - 1.0;
        let by = 2.0 * lost[1] / (left * (left - 1.0));
        let before = f - by * left;
        let explained = left > 0.0 && left < 1.0;
        if explained && before.abs() <= jerk && (before + by).abs() <= jerk {
            return Self { at: 1.0 - left, before, by, lost: [0.0; 2] };
        }
        Self { at: 1.0, before: f, by: 0.0, lost }
    }
}

impl<const N: usize> Observer for Planned<N> {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let state = [sample.position, sample.velocity, sample.acceleration]
            .map(|values| core::array::from_fn(|i| values[i]));
        let rests = sample.activity != Activity::Running;
        match self.states.last_mut() {
            // From the last rest before the motion on, to the first behind it.
            Some(before) if rests && before[1].iter().all(|v| *v == 0.0) => *before = state,
            _ => self.states.push(state),
        }
        Ok(())
    }
}

/// What of the planned motion lies behind a time, about an origin.
struct Going<'a, const N: usize> {
    motion: &'a Planned<N>,
    origin: [f64; N],
    clock: f64,
}

impl<const N: usize> Going<'_, N> {
    fn at<S: Scalar>(&self, time: S) -> Onward<S, N> {
        let time = self.clock + time.to_f64();
        if time >= self.motion.duration() {
            let [end, ..] = self.motion.at(self.motion.duration());
            let end = core::array::from_fn(|i| S::of(end[i] - self.origin[i]));
            let none = [S::ZERO; N];
            return Onward { state: State::resting(end), jerk: none, snap: none };
        }
        let all = self.motion.at(time);
        let position = core::array::from_fn(|i| S::of(all[0][i] - self.origin[i]));
        let [velocity, acceleration, jerk, snap] =
            [all[1], all[2], all[3], all[4]].map(|values| values.map(S::of));
        Onward { state: State { position, velocity, acceleration }, jerk, snap }
    }

    fn end<S: Scalar>(&self) -> S {
        S::of(self.motion.duration() - self.clock)
    }
}

/// The same with the lines that it is in.
struct Placed<'a, S, const N: usize> {
    going: &'a Going<'a, N>,
    places: &'a Places<S, PLACES>,
    lines: &'a [Line<S, N>],
}

impl<S: Scalar, const N: usize> Agreed<S, N> for Placed<'_, S, N> {
    fn at(&self, time: S) -> Onward<S, N> {
        self.going.at(time)
    }

    fn line(&self, time: S) -> usize {
        let x = self.going.at(time).state.position;
        self.places.line(self.lines, time, &x).unwrap_or(usize::MAX)
    }

    fn can_be_joined(&self, time: S) -> S {
        time
    }

    fn end(&self) -> S {
        self.going.end()
    }
}

/// What is run, cycle by cycle.
struct Found {
    /// With whether a piece of motion has begun, and the rounding error of one operation.
    states: Vec<(Values, (bool, f64))>,
    cycle: f64,
    time: f64,
}

impl Found {
    fn new(cycle: f64) -> Self {
        Self { states: vec![], cycle, time: 0.0 }
    }

    /// A stretch of so long, s, with the rounding error of one operation: a piece of motion.
    fn stretch(&mut self, long: f64, unit: f64, at: impl Fn(f64) -> Values) {
        let mut began = true;
        while (self.states.len() as f64) * self.cycle < self.time + long {
            let time = self.states.len() as f64 * self.cycle - self.time;
            self.states.push((at(time.max(0.0)), (began, unit)));
            began = false;
        }
        self.time += long;
    }

    /// At rest from now on.
    fn rest(&mut self, position: Vec<f64>) {
        let none = vec![0.0; position.len()];
        self.states.push(([position, none.clone(), none], (true, f64::EPSILON)));
    }
}
