//! A window of the motion, and how it is improved.

use super::barrier::{Barrier, Tally};
use super::course::{Cubic, State, state, within};
use super::holding::{self, CHORDS};
use super::model::{Ends, Model, Modelling};
use super::rows::{self, Walk};
use super::vector::{along, minus};
use super::way::{are_one, passes};
use super::{Agreed, Bounds, COUPLED, Draft};
use crate::number::Scalar;
use core::ops::ControlFlow;

/// What is left of the limits for rounding; and of the jerk less by so many roundings: of what it changes.
const SHARE: f64 = 0.9995;
const ROUNDINGS: f64 = 25.0e3;
/// Weight of the barrier at first, at last, and by how much it falls after a good step.
const MU: (f64, f64) = (5.0e-3, 5.0e-4);
const FALL: f64 = 0.4;
/// By how much it rises when nothing feasible is found, and how often.
const RISE: f64 = 3.0;
const RISES: usize = 2;
/// The parabola of the barrier begins so far from the limit at a weight of 1, and with the power 3/2 of the weight: what binds lies
/// further from its limit than that.
const WIDTH: f64 = 20.0;
/// Spans that are modelled at once.
const AT_ONCE: usize = 14;
/// Spans of a trial after which it is looked whether it is too costly already.
const WEIGHED: usize = 4;
/// Steps of Newton's method, and trials of a step.
const STEPS: usize = 24;
const TRIALS: usize = 7;
/// A step is good if it gains this much of what the model says.
const GOOD: f64 = 0.1;
/// It is enough when the model says that no more is to be gained than this many weights.
const ENOUGH: f64 = 8.0;
/// A whole step is good enough to go on with less weight if no more was to be gained than this many weights.
const CLOSE: f64 = 20.0;
/// The time at which the end joins changes in a step by no more than so many knots.
const MOST: f64 = 3.0;
/// Weight of the barrier, and steps, to where the agreed motion can be joined.
const LANDING: (f64, usize) = (4.0e-3, 6);
/// How often the band is narrowed where it is left between places, and what is left of it at least.
const NARROWINGS: usize = 3;
const NARROWEST: f64 = 0.8;
/// Steps after that.
const MENDING: usize = 8;

/// Why there is nothing better than what was agreed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// The agreed motion ends too soon for a window.
    TooShort,
    /// Nothing was found that is faster and keeps all limits.
    NoFaster,
    /// What was found leaves the band between the places that are looked at.
    Outside,
}

/// What was found.
#[derive(Clone, Copy, Debug)]
pub struct Reshaped<S> {
    /// How much earlier the end of the window is reached than agreed, s.
    pub gain: S,
    /// Steps of Newton's method that it took.
    pub steps: usize,
}

/// A window of at most `K - 3` spans of the motion, over `N` axes.
///
/// About `K * N * (8 N + 10)` numbers.
#[derive(Debug)]
pub struct Window<S, const N: usize, const K: usize> {
    /// What was found last: it stays valid to its end.
    course: Draft<S, N, K>,
    model: Model<S, N, K>,
    draft: Draft<S, N, K>,
    best: Draft<S, N, K>,
    /// Share of the band that is used, span by span.
    used: [S; K],
    /// How far each span of the course may be left, mm.
    free: [S; K],
    /// Spans of the course that have been run.
    run: usize,
    /// Spans that are used at most.
    most: usize,
    h: S,
    band: S,
}

/// What is on the way to a better motion: plain data between two steps.
#[derive(Clone, Copy, Debug)]
pub struct Improving<S> {
    free: Free,
    /// Time that was left to the agreed motion's end, s.
    before: S,
    /// What is to be small, at first.
    aim: S,
    descent: Descent<S>,
    landing: Landing,
    narrowings: usize,
    /// Steps of the descents before this one.
    steps: usize,
    next: Next<S>,
}

impl<S: Scalar> Improving<S> {
    /// Weight of the barrier.
    fn weight(&self) -> S {
        if self.landing == Landing::Before { self.descent.mu } else { S::of(LANDING.0) }
    }
}

/// How far the end of what was found has been brought to where the agreed motion can be joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Landing {
    Before,
    /// It is there; so many steps are left for the rest.
    Steps(usize),
    Done,
}

/// What is to be done next.
#[derive(Clone, Copy, Debug)]
enum Next<S> {
    /// The draft is to be modelled.
    Model,
    /// The model goes on, by the spans that are left.
    Rest(Walk<S>, Tally<S>),
    /// A step of Newton's method is to be found by the model of a draft that is worth so much.
    Step(S),
    /// It is to be gone.
    Trial(Trial<S>),
    /// The best is to be looked at between the places.
    Look,
}

/// A step of Newton's method that is to be gone as far as it is good. The model's gradient is its direction, and the border where it
/// begins.
#[derive(Clone, Copy, Debug)]
struct Trial<S> {
    /// What the draft was worth, and what the model says is gained.
    here: S,
    falls: S,
    /// The number where it begins, and its direction.
    from: S,
    number: S,
    /// How far it is to be gone.
    by: S,
    /// Trials that are left.
    left: usize,
}

/// A descent of Newton's method.
#[derive(Clone, Copy, Debug)]
struct Descent<S> {
    mu: S,
    /// Whether there is a motion that keeps all limits.
    found: bool,
    rises: usize,
    steps: usize,
    most: usize,
}

impl<S: Scalar> Descent<S> {
    fn new(weight: f64, most: usize) -> Self {
        Self { mu: S::of(weight), found: false, rises: 0, steps: 0, most }
    }

    /// Whether the barrier has the weight that it is to have at last.
    fn is_last(&self) -> bool {
        self.mu <= S::of(MU.1)
    }
}

/// Which number is free besides the control points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Free {
    /// When the agreed motion is joined.
    Joining,
    /// The distance of the knots.
    Knots,
}

impl<S: Scalar, const N: usize, const K: usize> Window<S, N, K> {
    /// The memory of one, to be [set](Self::set): all zeros.
    pub const EMPTY: Self = Self {
        course: Draft::NONE,
        model: Model::new(),
        draft: Draft::NONE,
        best: Draft::NONE,
        used: [S::ZERO; K],
        free: [S::ZERO; K],
        run: 0,
        most: 0,
        h: S::ZERO,
        band: S::ZERO,
    };

    /// With knots every `h` s, using a share of the band.
    pub fn new(h: S, band: S) -> Self {
        let mut window = Self::EMPTY;
        window.set(h, band, K - 3);
        window
    }

    /// Knots every `h` s, the share of the band that is used, and how many spans, `K - 3` at most.
    pub fn set(&mut self, h: S, band: S, spans: usize) {
        (self.h, self.band, self.used) = (h, band, [band; K]);
        self.most = spans.min(K - 3);
        (self.course.h, self.run) = (h, 0);
    }

    /// Spans of the course that have not been run yet.
    pub fn spans(&self) -> usize {
        self.course.spans() - self.run
    }

    /// Time between the knots of the course, s.
    pub fn knots(&self) -> S {
        self.course.h
    }

    /// When the agreed motion has the state in which the course ends, s: it goes on with that.
    pub fn joins(&self) -> S {
        self.course.joins
    }

    /// State of the course where its next span begins.
    pub fn state(&self) -> State<S, N> {
        state(&self.course.points[self.run..self.run + 3], self.course.h)
    }

    /// Position, velocity and acceleration a share of the next span behind its start, the position about a point near by, which is
    /// returned too: so it is as exact as its change. A knot is seen alike from the spans on both sides of it.
    pub fn within(&self, share: S) -> ([S; N], State<S, N>) {
        let (course, k) = (&self.course, self.run);
        if !(share < S::ONE) {
            return self.knot(k + 1);
        }
        let base = course.points[k + 1];
        let four: [[S; N]; COUPLED] = core::array::from_fn(|i| minus(&course.points[k + i], &base));
        (base, within(&four, course.h, share))
    }

    /// The same where the course ends.
    pub fn end(&self) -> ([S; N], State<S, N>) {
        self.knot(self.course.spans())
    }

    fn knot(&self, k: usize) -> ([S; N], State<S, N>) {
        let three = &self.course.points[k..k + 3];
        let about: [[S; N]; 3] = core::array::from_fn(|i| minus(&three[i], &three[1]));
        (three[1], state(&about, self.course.h))
    }

    /// How far from the course a motion over the next span may lie, mm, and be in the band of every line that the course is in there.
    pub fn free(&self) -> S {
        self.free[self.run]
    }

    /// Goes on to the next span; the line in which that begins, if this one began in the line of `bounds`.
    pub fn advance(&mut self, bounds: &Bounds<'_, S, N>) -> usize {
        let mut line = bounds.line;
        if self.run < self.course.spans() {
            let cubic = Cubic::new(&self.course.points[self.run..self.run + 4]);
            // As the motion was followed when it was shown to stay inside the band.
            for chord in 1..=CHORDS {
                let share = S::from_u32(chord) / S::from_u32(CHORDS);
                line = passes(bounds.lines, line, &cubic.at(share));
            }
            self.run += 1;
        }
        line
    }

    /// Moves the origin of all positions by `by`, mm.
    pub fn move_origin(&mut self, by: &[S; N]) {
        for point in &mut self.course.points {
            *point = along(point, -S::ONE, by);
        }
    }

    /// Sets the clock of the agreed motion back by `by`, s.
    pub fn move_clock(&mut self, by: S) {
        self.course.joins = self.course.joins - by;
    }

    /// Begins in a state of the agreed motion, at `time` of it.
    pub fn begin(&mut self, state: &State<S, N>, time: S) {
        self.course.points[..3].copy_from_slice(&state.points(self.h));
        self.course.count = 3;
        self.course.h = self.h;
        self.course.joins = time;
        self.run = 0;
        self.used = [self.band; K];
    }

    /// Improves what has not been run of the course, and what is agreed behind it.
    ///
    /// Cost: at most 24 steps of Newton's method and twice 8 more, each of a factorisation and up to 8 sums over all rows.
    ///
    /// # Errors
    /// Nothing better was found: the course is what it was.
    pub fn improve(
        &mut self,
        agreed: &impl Agreed<S, N>,
        bounds: &Bounds<'_, S, N>,
    ) -> Result<Reshaped<S>, Refused> {
        let mut improving = self.begin_improving(agreed)?;
        // Every turn is a step, a trial or a look between places: all are counted.
        loop {
            if let ControlFlow::Break(found) = self.go_on(&mut improving, agreed, bounds) {
                return found;
            }
        }
    }

    /// Begins to improve what has not been run of the course, and what is agreed behind it.
    ///
    /// # Errors
    /// The agreed motion ends too soon.
    pub fn begin_improving(&mut self, agreed: &impl Agreed<S, N>) -> Result<Improving<S>, Refused> {
        let free = self.guess(agreed)?;
        Ok(Improving {
            free,
            before: Self::left(&self.draft, agreed),
            aim: self.aim(&self.draft, free),
            descent: Descent::new(MU.0, STEPS),
            landing: Landing::Before,
            narrowings: 0,
            steps: 0,
            next: Next::Model,
        })
    }

    /// Goes on with that: the motion is modelled, or a step of Newton's method is found by that, or tried, or the motion is
    /// looked at between the places. Neither the course nor what is agreed may have changed meanwhile.
    ///
    /// Cost: a sum over the rows of 14 spans with its derivatives, or a factorisation, or a sum over all without, or 32 places of every
    /// span; at most 500 times.
    pub fn go_on(
        &mut self,
        improving: &mut Improving<S>,
        agreed: &impl Agreed<S, N>,
        bounds: &Bounds<'_, S, N>,
    ) -> ControlFlow<Result<Reshaped<S>, Refused>> {
        let limits = bounds.limits.map(|limits| crate::AxisLimits {
            velocity: limits.velocity * S::of(SHARE),
            acceleration: limits.acceleration * S::of(SHARE),
            jerk: limits.jerk * (S::of(SHARE) - S::EPSILON * S::of(ROUNDINGS)),
            ..limits
        });
        let bounds = Bounds { limits: &limits, ..*bounds };
        let next = improving.next;
        improving.next = match next {
            Next::Model => self.model(improving, agreed, &bounds),
            Next::Rest(walk, tally) => self.model_rest(improving, (walk, tally), agreed, &bounds),
            Next::Step(here) => self.step(improving, here, agreed),
            Next::Trial(trial) => self.go(improving, trial, agreed, &bounds),
            Next::Look if self.begin_landing(improving, agreed) => Next::Model,
            Next::Look => {
                self.look(improving, agreed, &bounds)?;
                Next::Model
            }
        };
        ControlFlow::Continue(())
    }

    /// Looks at the best that was found between the places. Where it leaves the band there, that is narrowed for another descent.
    fn look(
        &mut self,
        improving: &mut Improving<S>,
        agreed: &impl Agreed<S, N>,
        bounds: &Bounds<'_, S, N>,
    ) -> ControlFlow<Result<Reshaped<S>, Refused>> {
        improving.steps += improving.descent.steps;
        if !improving.descent.found {
            return ControlFlow::Break(Err(Refused::NoFaster));
        }
        let gain = improving.before - Self::left(&self.best, agreed);
        if !(gain > self.h * S::of(1.0e-4) && holding::keeps_feed(&self.best, bounds)) {
            return ControlFlow::Break(Err(Refused::NoFaster));
        }
        let ends = agreed.line(self.best.joins);
        if holding::narrow(&self.best, bounds, self.band, ends, [&mut self.used, &mut self.free]) {
            self.course = self.best.clone();
            self.run = 0;
            return ControlFlow::Break(Ok(Reshaped { gain, steps: improving.steps }));
        }
        improving.narrowings += 1;
        if improving.narrowings == NARROWINGS
            || self.used.iter().any(|used| *used < S::of(NARROWEST) * self.band)
        {
            self.used = [self.band; K];
            return ControlFlow::Break(Err(Refused::Outside));
        }
        self.draft = self.best.clone();
        improving.descent = Descent::new(MU.1 * 4.0, MENDING);
        improving.landing = Landing::Before;
        ControlFlow::Continue(())
    }

    /// Where the agreed motion cannot be joined when the best ends: a draft that ends where it can be, somewhat before. It is gone along
    /// more slowly, by ever more, so that hardly a limit is broken.
    fn begin_landing(&mut self, improving: &mut Improving<S>, agreed: &impl Agreed<S, N>) -> bool {
        if improving.landing != Landing::Before
            || !improving.descent.found
            || improving.free == Free::Knots
        {
            return false;
        }
        let to = agreed.can_be_joined(self.best.joins);
        if !(to < self.best.joins) {
            return false;
        }
        let (count, h) = (self.best.count, self.best.h);
        let back = (self.best.joins - to) / h;
        for k in 3..count - 3 {
            let u = S::from_u32(k as u32 - 2) / S::from_u32(count as u32 - 5);
            let smooth = u * u * u * (S::of(10.0) - u * (S::of(15.0) - S::of(6.0) * u));
            let at = (S::from_u32(k as u32 - 1) - back * smooth).greatest(S::ZERO);
            let knot = at.to_i64() as usize;
            let four = &self.best.points[knot..knot + COUPLED];
            self.draft.points[k] = within(four, h, at - S::from_u32(knot as u32)).points(h)[1];
        }
        self.draft.joins = to;
        let start = self.state();
        Self::ends(&mut self.draft, agreed, &start);
        improving.landing = Landing::Steps(LANDING.1);
        true
    }

    /// Time that is left to the agreed motion's end, s.
    fn left(draft: &Draft<S, N, K>, agreed: &impl Agreed<S, N>) -> S {
        S::from_u32(draft.spans() as u32) * draft.h + agreed.end() - draft.joins
    }

    /// The draft to begin with: what is left of the course and what is agreed behind it.
    fn guess(&mut self, agreed: &impl Agreed<S, N>) -> Result<Free, Refused> {
        let spans = self.spans();
        if spans >= 3 {
            // Seen from nearer, the end is more exact than it was.
            let end = agreed.at(self.course.joins).state.points(self.course.h);
            self.course.points[self.course.count - 3..self.course.count].copy_from_slice(&end);
        }
        let time = S::from_u32(spans as u32) * self.course.h;
        let whole = S::from_u32(self.most as u32) * self.h;
        let left = time + agreed.end() - self.course.joins;
        if !(left > self.h * S::of(4.0)) {
            return Err(Refused::TooShort);
        }
        let (free, count, h) = if left > whole {
            (Free::Joining, self.most + 3, self.h)
        } else {
            // As many spans as it takes: they become no longer than they were.
            let spans = (left / self.h).to_i64() as usize + 1;
            (Free::Knots, spans + 3, left / S::from_u32(spans as u32))
        };
        let alike = h == self.course.h;
        let onward = |time: S| agreed.at(time).state;
        for k in 1..count - 1 {
            let at = S::from_u32(k as u32 - 1) * h;
            // The point in the midst of a knot's three is that of the motion there.
            self.draft.points[k] = if at > time {
                onward(self.course.joins + (at - time)).points(h)[1]
            } else if alike {
                self.course.points[self.run + k]
            } else {
                let knot = (at / self.course.h).to_i64() as usize;
                let knot = (self.run + knot).min(self.course.spans().saturating_sub(1));
                if spans == 0 {
                    onward(self.course.joins).points(h)[1]
                } else {
                    let share = at / self.course.h - S::from_u32((knot - self.run) as u32);
                    let four = &self.course.points[knot..knot + 4];
                    within(four, self.course.h, share).points(h)[1]
                }
            };
        }
        self.draft.count = count;
        self.draft.h = h;
        let end = S::from_u32(count as u32 - 3) * h;
        self.draft.joins = match free {
            Free::Joining => self.course.joins + (end - time),
            Free::Knots => agreed.end(),
        };
        self.used.rotate_left(self.run.min(K - 1));
        let kept = K - self.run.min(K - 1);
        if alike {
            self.used[kept..].fill(self.band);
        } else {
            self.used = [self.band; K];
        }
        let start = self.state();
        Self::ends(&mut self.draft, agreed, &start);
        Ok(free)
    }

    /// Puts both ends where they belong.
    fn ends(draft: &mut Draft<S, N, K>, agreed: &impl Agreed<S, N>, start: &State<S, N>) {
        let (count, h) = (draft.count, draft.h);
        draft.points[..3].copy_from_slice(&start.points(h));
        let end = agreed.at(draft.joins).state.points(h);
        draft.points[count - 3..count].copy_from_slice(&end);
    }

    /// What the draft is worth beside a sum over rows.
    fn gone(&self, improving: &Improving<S>) -> S {
        let gone = self.aim(&self.draft, improving.free) - improving.aim;
        gone / improving.descent.mu
    }

    /// Whether the draft is worth no more than `most`. What a row costs is never less than nothing: as soon as some cost more it is not.
    fn is_worth(&self, improving: &Improving<S>, bounds: &Bounds<'_, S, N>, most: S) -> bool {
        let mut tally = Tally::new(Barrier::new(width(improving.descent.mu)));
        let mut walk = Walk::new(&self.draft, bounds);
        let gone = self.gone(improving);
        // Some spans at a time: at most so often as there are any.
        while !walk.is_done(&self.draft) {
            rows::go_on(&self.draft, bounds, &self.used, (&mut walk, WEIGHED), &mut tally);
            if !(tally.so_far() + gone <= most) {
                return false;
            }
        }
        tally.sum() + gone <= most
    }

    /// Whether the draft, whose end is in a line, ends in the line in which the agreed motion goes on.
    fn joins_line(
        &self,
        agreed: &impl Agreed<S, N>,
        bounds: &Bounds<'_, S, N>,
        line: usize,
    ) -> bool {
        let end = agreed.at(self.draft.joins).state.position;
        are_one(bounds.lines, line, agreed.line(self.draft.joins), &end)
    }

    /// Takes note of the draft if it `keeps` all limits and is the best so far.
    fn note(&mut self, improving: &mut Improving<S>, keeps: bool) {
        let free = improving.free;
        let descent = &mut improving.descent;
        if keeps && (!descent.found || self.aim(&self.draft, free) < self.aim(&self.best, free)) {
            self.best = self.draft.clone();
            descent.found = true;
        }
    }

    /// Models the draft, and takes note of it.
    fn model(
        &mut self,
        improving: &mut Improving<S>,
        agreed: &impl Agreed<S, N>,
        bounds: &Bounds<'_, S, N>,
    ) -> Next<S> {
        let mu = improving.weight();
        self.model.clear(self.draft.count);
        let tally = Tally::new(Barrier::new(width(mu)));
        self.model_rest(improving, (Walk::new(&self.draft, bounds), tally), agreed, bounds)
    }

    /// Goes on with that.
    fn model_rest(
        &mut self,
        improving: &mut Improving<S>,
        (mut walk, tally): (Walk<S>, Tally<S>),
        agreed: &impl Agreed<S, N>,
        bounds: &Bounds<'_, S, N>,
    ) -> Next<S> {
        let free = improving.free;
        let knots = (free == Free::Knots).then_some(self.draft.h);
        let mut modelling = Modelling::new(&mut self.model, tally, knots);
        rows::go_on(&self.draft, bounds, &self.used, (&mut walk, AT_ONCE), &mut modelling);
        let tally = modelling.tally;
        if !walk.is_done(&self.draft) {
            return Next::Rest(walk, tally);
        }
        let keeps = tally.keeps && self.joins_line(agreed, bounds, walk.line);
        if let Landing::Steps(left) = improving.landing {
            if keeps {
                self.best = self.draft.clone();
            }
            if keeps || left == 0 {
                improving.landing = Landing::Done;
                return Next::Look;
            }
            improving.landing = Landing::Steps(left - 1);
            return Next::Step(S::ZERO);
        }
        self.note(improving, keeps);
        if improving.descent.steps == improving.descent.most {
            return Next::Look;
        }
        Next::Step(tally.sum() + self.gone(improving))
    }

    /// Finds a step of Newton's method from the draft on, which is worth `here`.
    fn step(
        &mut self,
        improving: &mut Improving<S>,
        here: S,
        agreed: &impl Agreed<S, N>,
    ) -> Next<S> {
        let free = improving.free;
        let lands = improving.landing != Landing::Before;
        let Some((number, falls)) = self.model_step(agreed, free, improving.weight(), lands) else {
            if lands {
                improving.landing = Landing::Done;
            }
            return Next::Look;
        };
        improving.descent.steps += 1;
        if lands {
            for k in 3..self.draft.count - 3 {
                self.draft.points[k] =
                    along(&self.draft.points[k], S::ONE, &self.model.gradient[k]);
            }
            return Next::Model;
        }
        // Where nothing keeps all limits yet, the last bit may.
        if falls < S::of(ENOUGH) && improving.descent.is_last() && improving.descent.found {
            return Next::Look;
        }
        let cap = S::of(MOST) * self.h;
        let mut by = if number.abs() > cap { cap / number.abs() } else { S::ONE };
        let from = match free {
            Free::Joining => self.draft.joins,
            Free::Knots => {
                // They stay above half of what they are.
                by = by.least(S::of(0.4) * self.draft.h / number.abs().greatest(S::EPSILON));
                self.draft.h
            }
        };
        self.model.border = self.draft.points;
        Next::Trial(Trial { here, falls, from, number, by, left: TRIALS })
    }

    /// Tries to go a step; where that is not good, half as far next time.
    fn go(
        &mut self,
        improving: &mut Improving<S>,
        mut trial: Trial<S>,
        agreed: &impl Agreed<S, N>,
        bounds: &Bounds<'_, S, N>,
    ) -> Next<S> {
        let Trial { here, falls, by, .. } = trial;
        self.move_draft(improving.free, &trial, by, agreed);
        if self.is_worth(improving, bounds, here - S::of(GOOD) * by * falls) {
            let close = by > S::of(0.5) && falls < S::of(CLOSE);
            return self.went(improving, close || falls < S::of(ENOUGH));
        }
        trial.by = by * S::of(0.5);
        trial.left -= 1;
        if trial.left > 0 {
            return Next::Trial(trial);
        }
        self.move_draft(improving.free, &trial, S::ZERO, agreed);
        if improving.descent.is_last() {
            return Next::Look;
        }
        self.went(improving, true)
    }

    /// Puts the draft so far from where a step begins.
    fn move_draft(&mut self, free: Free, trial: &Trial<S>, by: S, agreed: &impl Agreed<S, N>) {
        let start = self.state();
        for k in 3..self.draft.count - 3 {
            self.draft.points[k] = along(&self.model.border[k], by, &self.model.gradient[k]);
        }
        let number = trial.from + by * trial.number;
        match free {
            Free::Joining => self.draft.joins = number.least(agreed.end()),
            Free::Knots => self.draft.h = number,
        }
        Self::ends(&mut self.draft, agreed, &start);
    }

    /// After a step: the barrier gets less weight if that was `good`, and more where nothing was found that keeps all limits.
    fn went(&self, improving: &mut Improving<S>, good: bool) -> Next<S> {
        let slower = !(self.aim(&self.draft, improving.free) < improving.aim);
        let descent = &mut improving.descent;
        let mu = descent.mu;
        if good && !descent.is_last() {
            descent.mu = (mu * S::of(FALL)).greatest(S::of(MU.1));
        } else if good && !descent.found {
            // With more weight it would be slower still.
            if descent.rises == RISES || slower {
                return Next::Look;
            }
            descent.rises += 1;
            descent.mu = mu * S::of(RISE);
        }
        Next::Model
    }

    /// What is to be small, in knots.
    fn aim(&self, draft: &Draft<S, N, K>, free: Free) -> S {
        match free {
            Free::Joining => -draft.joins / self.h,
            Free::Knots => S::from_u32(draft.spans() as u32) * draft.h / self.h,
        }
    }

    /// The step to the model's least: that of the number, and by how much it falls.
    fn model_step(
        &mut self,
        agreed: &impl Agreed<S, N>,
        free: Free,
        mu: S,
        lands: bool,
    ) -> Option<(S, S)> {
        let start = self.state();
        let (draft, h) = (&self.draft, self.draft.h);
        let (ends, push) = match free {
            Free::Joining => {
                let onward = agreed.at(draft.joins);
                let State { velocity, acceleration, .. } = onward.state;
                let slopes =
                    State { position: velocity, velocity: acceleration, acceleration: onward.jerk };
                let curvatures = State {
                    position: acceleration,
                    velocity: onward.jerk,
                    acceleration: onward.snap,
                };
                let first = draft.count - 3;
                let ends =
                    Ends { first, slopes: slopes.points(h), curvatures: curvatures.points(h) };
                (ends, -S::ONE / self.h)
            }
            Free::Knots => {
                // Twice the change of the points by the velocity, and once: see `State::points`.
                let (third, two) = (S::of(1.0 / 3.0), S::of(2.0));
                let a = start.acceleration.map(|a| a * third);
                let mid = a.map(|a| -h * a);
                let side = a.map(|a| two * h * a);
                let slopes = [
                    along(&side, -S::ONE, &start.velocity),
                    mid,
                    along(&side, S::ONE, &start.velocity),
                ];
                let bent = a.map(|a| two * a);
                let curvatures = [bent, a.map(|a| -a), bent];
                let push = S::from_u32(draft.spans() as u32) / self.h;
                (Ends { first: 0, slopes, curvatures }, push)
            }
        };
        let points = 3..draft.count - 3;
        if lands {
            // The end stays where it is.
            return self.model.step(points, None);
        }
        self.model.follow(&ends);
        self.model.step(points, Some(push / mu))
    }
}

fn width<S: Scalar>(mu: S) -> S {
    (S::of(WIDTH) * mu * mu.sqrt()).least(S::of(0.1))
}
