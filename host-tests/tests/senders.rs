//! Senders that send as fast as the motion needs blocks, or not quite: what is known of the path is run, however it is
//! written; all limits and the band, whatever comes when.

#[path = "common/cycles.rs"]
mod cycles;

use cycles::{Between, Draw, Point, at, machine, soak};
use splineway::{
    Activity, AxisLimits, Block, Config, Feed, Interpolator, Limits, Link, Planner, Progress,
    PushError, Scalar, Setpoint,
};

const BLOCKS: usize = 16;
const NODES: usize = 64;

/// When blocks come.
#[derive(Clone, Copy, Debug)]
enum Sender {
    /// Whenever there is room.
    Full,
    /// One in so many servo cycles.
    Paced(usize),
    /// Some at a time, and pauses of so many cycles between.
    Bursts(usize),
}

/// Who gives commands meanwhile.
#[derive(Clone, Copy, Debug)]
enum Operator {
    Nobody,
    /// Holds, overrides, single block mode at any time.
    AnyTime,
    /// Block by block, with a hold every so many cycles, and on as soon as the machine rests.
    Holds(usize),
}

/// What a run came to.
#[derive(Default)]
struct Outcome {
    /// Servo cycles before the first motion, and in all.
    begun: usize,
    cycles: usize,
    /// How often the motion came to rest.
    rests: usize,
    starved: u32,
    /// Most servo cycles in a row of a motion that hardly moves.
    crawled: usize,
}

/// A motion slower than this, mm/s, hardly moves.
const CRAWL: f64 = 1.0e-3;

/// A machine with a sender of lines.
struct Rig<'a, S: Scalar> {
    planner: Planner<'a, S, 3, BLOCKS, NODES>,
    interpolator: Interpolator<'a, S, 3>,
    config: Config<S, 3>,
    lines: &'a [[f64; 3]],
    feed: f64,
    sent: usize,
    operator: Operator,
}

impl<S: Scalar> Rig<'_, S> {
    /// Sends up to so many lines.
    fn send(&mut self, most: usize) {
        for _ in 0..most {
            let Some(to) = self.lines.get(self.sent + 1) else {
                self.planner.finish();
                return;
            };
            let mut block = Block::line(to.map(at), S::ONE, self.sent as u32);
            block.feed = Feed::PerSecond(S::of(self.feed));
            match self.planner.push(&block) {
                Ok(()) => self.sent += 1,
                Err(PushError::Full) => return,
                Err(other) => panic!("{other:?}"),
            }
        }
    }

    /// A command at a time when nobody expects it.
    fn operate(&self, draw: &mut Draw) {
        let controls = self.planner.controls();
        match draw.between(0.0, 8.0) as u32 {
            0 | 1 => controls.hold(),
            2 => controls.single_block(true),
            3 => controls.feed_override(draw.between(10.0, 200.0) as u16),
            4 => controls.stop(),
            _ => {
                controls.single_block(false);
                controls.resume();
            }
        }
    }

    /// Runs all lines; every limit is checked in every cycle, the band too.
    fn run(&mut self, sender: Sender, draw: &mut Draw) -> Outcome {
        let mut outcome = Outcome::default();
        let (mut last, mut pause, mut near) = (self.interpolator.tick(), 0, 0);
        let mut slow = 0;
        let cycle = self.config.cycle.to_f64();
        let most = self.config.tolerance.to_f64() * 1.001 + 1.0e-6;
        for n in 0..20_000_000 {
            match sender {
                Sender::Full => self.send(usize::MAX),
                Sender::Paced(pace) if n % pace == 0 => self.send(1),
                Sender::Bursts(longest) if pause == 0 => {
                    self.send(draw.scale(1.0, 40.0) as usize);
                    pause = draw.between(0.0, longest as f64) as usize;
                }
                _ => pause = pause.saturating_sub(1),
            }
            match self.operator {
                Operator::AnyTime if draw.chance(0.01) => {
                    // It ends some time: then the machine goes on.
                    if n < 100_000 {
                        self.operate(draw);
                    } else {
                        self.planner.controls().single_block(false);
                        self.planner.controls().resume();
                    }
                }
                Operator::Holds(every) if n % every == every - 1 => self.planner.controls().hold(),
                Operator::Holds(_) if last.activity == Activity::Idle => {
                    self.planner.controls().single_block(true);
                    self.planner.controls().resume();
                }
                _ => {}
            }
            let mut progress = self.planner.poll();
            for _ in 0..draw.scale(1.0, 1000.0) as usize {
                if progress == Progress::Planning {
                    progress = self.planner.poll();
                }
            }
            let now = self.interpolator.tick();
            Between { from: last, to: now, cycle }.check(&self.config, false);
            let off = self.distance(&now, &mut near, most);
            assert!(
                off <= most,
                "{off} of {most} mm off the path in cycle {n} ({near} of {})",
                self.sent
            );
            assert!(
                now.tag >= last.tag || now.activity == Activity::Idle,
                "line {} after {} in cycle {n}, {} sent",
                now.tag,
                last.tag,
                self.sent
            );
            let moves = |at: &Setpoint<S, 3>| at.velocity.iter().any(|v| v.to_f64() != 0.0);
            match (moves(&last), moves(&now)) {
                (false, true) if outcome.begun == 0 => outcome.begun = n,
                (true, false) => outcome.rests += 1,
                _ => {}
            }
            let crawls = now.velocity.iter().all(|v| v.to_f64().abs() < CRAWL);
            slow = if crawls && now.activity == Activity::Running { slow + 1 } else { 0 };
            outcome.crawled = outcome.crawled.max(slow);
            last = now;
            if progress == Progress::Done && now.activity == Activity::Idle {
                outcome.cycles = n;
                outcome.starved = self.planner.counters().starved;
                let end_off = if S::NAME == "f32" { 1.0e-6 } else { 1.0e-9 };
                let end: Point = self.lines[self.lines.len() - 1].map(at);
                for (axis, end) in end.iter().enumerate() {
                    let off: f64 = now.position(axis).minus(*end);
                    assert!(off.abs() < end_off, "axis {axis} ends {off} mm off");
                }
                return outcome;
            }
        }
        panic!("the run does not end: {} of {} lines sent", self.sent, self.lines.len());
    }

    /// Distance from the lines: those about the nearest so far, or all.
    fn distance(&self, now: &Setpoint<S, 3>, near: &mut usize, most: f64) -> f64 {
        let x = [0, 1, 2].map(|axis| now.position_mm(axis));
        let nearest = |from: usize, to: usize| {
            let mut least = (f64::INFINITY, 0);
            for (k, pair) in self.lines.windows(2).enumerate().take(to).skip(from) {
                let d = [0, 1, 2].map(|i| pair[1][i] - pair[0][i]);
                let square: f64 = d.iter().map(|d| d * d).sum();
                let along: f64 = (0..3).map(|i| (x[i] - pair[0][i]) * d[i]).sum();
                let t = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
                let square: f64 = (0..3).map(|i| (pair[0][i] + t * d[i] - x[i]).powi(2)).sum();
                if square < least.0 {
                    least = (square, k);
                }
            }
            (least.0.sqrt(), least.1)
        };
        let mut found = nearest(near.saturating_sub(30), *near + 30);
        if found.0 > most {
            found = nearest(0, self.lines.len());
        }
        *near = found.1;
        found.0
    }
}

/// Runs lines with a sender.
fn run<S: Scalar>(
    config: Config<S, 3>,
    lines: &[[f64; 3]],
    feed: f64,
    (sender, operator): (Sender, Operator),
    draw: &mut Draw,
) -> Outcome {
    let mut link = Box::new(Link::<S, 3, BLOCKS, NODES>::new());
    let (planner, interpolator) = link.split(config, lines[0].map(at)).unwrap();
    Rig { planner, interpolator, config, lines, feed, sent: 0, operator }.run(sender, draw)
}

/// A path in pieces, rounded as a program rounds them.
fn pieces(points: &[[f64; 3]], piece: f64, rounded: f64) -> Vec<[f64; 3]> {
    let mut lines = vec![points[0]];
    for pair in points.windows(2) {
        let length = (0..3).map(|i| (pair[1][i] - pair[0][i]).powi(2)).sum::<f64>().sqrt();
        let count = (length / piece).ceil().max(1.0);
        lines.extend((1..=count as usize).map(|k| {
            [0, 1, 2].map(|i| {
                let x = pair[0][i] + (pair[1][i] - pair[0][i]) * k as f64 / count;
                if rounded > 0.0 { (x / rounded).round() * rounded } else { x }
            })
        }));
    }
    lines
}

fn axes<S: Scalar>() -> Config<S, 3> {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let mut config = Config::new(Limits::new([axis; 3]).unwrap());
    config.tolerance = S::of(0.05);
    config
}

/// Long straight legs with corners, and a circle.
fn paths() -> [(&'static str, Vec<[f64; 3]>); 2] {
    let legs = vec![[0.0; 3], [40.0, 0.0, 0.0], [40.0, 30.0, 0.0], [21.0, 7.0, 0.0]];
    let circle = (0..=400)
        .map(|k| f64::from(k) * 0.0157)
        .map(|angle: f64| [20.0 * angle.sin(), 20.0 * (1.0 - angle.cos()), 0.0])
        .collect();
    [("legs", legs), ("circle", circle)]
}

/// A long line that is sent in pieces grows in the look-ahead, and a run waits until a long stretch of it is known: neither
/// keeps the machine waiting where the sender is only somewhat faster than the motion.
fn is_not_kept_waiting<S: Scalar>() {
    for (name, path) in paths() {
        for (piece, rounded) in [(0.1, 0.0), (0.1, 1.0e-3), (0.5, 0.0), (0.5, 1.0e-4)] {
            let lines = pieces(&path, piece, rounded);
            for feed in [5.0, 20.0, 60.0] {
                let mut draw = Draw(1);
                let full =
                    run(axes::<S>(), &lines, feed, (Sender::Full, Operator::Nobody), &mut draw);
                for pace in 1..=3 {
                    // At least half as fast again as the motion.
                    let ahead = 1000.0 * piece / (feed * pace as f64);
                    if ahead < 1.5 {
                        continue;
                    }
                    let paced = run(
                        axes::<S>(),
                        &lines,
                        feed,
                        (Sender::Paced(pace), Operator::Nobody),
                        &mut draw,
                    );
                    let case = format!(
                        "{name}, {piece} mm rounded to {rounded}, {feed} mm/s, one in {pace}"
                    );
                    assert_eq!((paced.rests, paced.starved), (1, 0), "{case}");
                    assert!(paced.begun < 500, "{case}: begins after {}", paced.begun);
                    let (longer, most) = (paced.cycles - full.cycles, 480);
                    assert!(longer < most, "{case}: {longer} cycles longer");
                }
            }
        }
    }
}

#[test]
fn a_path_in_pieces_is_run_as_they_come() {
    is_not_kept_waiting::<f64>();
}

#[test]
fn a_path_in_pieces_is_run_as_they_come_in_f32() {
    is_not_kept_waiting::<f32>();
}

/// A random path of straight stretches, chords of arcs and noise, in pieces.
fn random_path(draw: &mut Draw) -> Vec<[f64; 3]> {
    let (mut here, mut heading) = ([0.0; 3], 0.0f64);
    let mut points = vec![here];
    let rise = if draw.chance(0.5) { draw.between(-0.5, 0.5) } else { 0.0 };
    for _ in 0..draw.between(1.0, 6.0) as usize {
        if draw.chance(0.7) {
            heading += draw.between(-3.2, 3.2);
        }
        let bend = if draw.chance(0.5) { 0.0 } else { draw.between(-0.2, 0.2) };
        let step = draw.scale(0.02, 5.0);
        for _ in 0..draw.scale(1.0, 60.0) as usize {
            heading += bend;
            here = [
                here[0] + step * heading.cos(),
                here[1] + step * heading.sin(),
                here[2] + step * rise,
            ];
            points.push(here);
        }
    }
    let piece = draw.scale(0.02, 3.0);
    let rounded = [0.0, 1.0e-4, 1.0e-3, 1.0e-2][(draw.share() * 4.0) as usize];
    let mut lines = pieces(&points, piece, rounded);
    lines.truncate(700);
    lines
}

/// Any machine, path, sender and pace of planning: limits, band, end and order of the tags, checked by the rig.
fn any_sender<S: Scalar>(seed: u64) {
    for case in 0..60 * u64::from(soak()) {
        println!("case {case}");
        sends::<S>(seed + case, None);
    }
}

/// A path, a machine and a sender that are drawn, and an operator who may be.
fn sends<S: Scalar>(seed: u64, operator: Option<Operator>) {
    let mut draw = Draw(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut config = machine::<S>(&mut draw);
    config.stop_limits = None;
    config.tolerance = S::of(draw.scale(2.0e-3, 0.5));
    if draw.chance(0.1) {
        config.tolerance = S::ZERO;
    }
    config.start_delay = S::of(draw.between(0.0, 0.1));
    let lines = random_path(&mut draw);
    let feed = draw.scale(1.0, 300.0);
    let sender = if draw.chance(0.5) {
        Sender::Paced(draw.scale(1.0, 60.0) as usize)
    } else {
        Sender::Bursts(draw.scale(2.0, 300.0) as usize)
    };
    let drawn = if draw.chance(0.5) { Operator::AnyTime } else { Operator::Nobody };
    let operator = operator.unwrap_or(drawn);
    println!("{} lines, {feed} mm/s, {sender:?}, {operator:?}", lines.len());
    run(config, &lines, feed, (sender, operator), &mut draw);
}

/// The feed is lowered again and again, while the speed is what an axis allows: a speed bound was let go by what a cell
/// does between an end with a new state and one without, to 1 % over the velocity of the axis.
#[test]
fn an_override_that_is_lowered_again_and_again_keeps_velocities_in_f32() {
    sends::<f32>(422, Some(Operator::AnyTime));
}

#[test]
fn any_sender_of_any_path() {
    any_sender::<f64>(11);
}

#[test]
fn any_sender_of_any_path_in_f32() {
    any_sender::<f32>(12);
}

/// A machine that hardly gets going before it is held again, on a curve and with one slow axis: it comes to rest in the midst of
/// starts and ends, where the motion's own shape says nothing of the path's. The band is kept, and the end is reached.
fn is_held_again_and_again<S: Scalar>() {
    let slow = AxisLimits::linear(S::of(1.28), S::of(7.9), S::of(55.0));
    let fast = AxisLimits::linear(S::of(800.0), S::of(3000.0), S::of(5.0e5));
    let mut config = Config::new(Limits::new([slow, fast, fast]).unwrap());
    config.tolerance = S::of(0.048);
    let arc = |k: usize| {
        let angle = k as f64 * 0.0645;
        [4.9 * angle.cos() - 4.9, 4.9 * angle.sin(), 0.0]
    };
    let lines: Vec<_> = (0..12).map(arc).collect();
    for every in (60..400).step_by(7) {
        println!("a hold every {every} cycles");
        run(config, &lines, 2.8, (Sender::Full, Operator::Holds(every)), &mut Draw(1));
    }
}

#[test]
fn a_machine_that_is_held_again_and_again_keeps_the_band() {
    is_held_again_and_again::<f64>();
}

#[test]
fn a_machine_that_is_held_again_and_again_keeps_the_band_in_f32() {
    is_held_again_and_again::<f32>();
}

/// A hold that comes to rest just before the end of a cell leaves next to nothing of it, in front of one that is a thousand times
/// as long: to start from there took seconds for a few nanometres, again and again.
fn starts_without_a_crawl<S: Scalar>() {
    let slow = AxisLimits::linear(S::of(2.1), S::of(3.9), S::of(2200.0));
    let fast = AxisLimits::linear(S::of(800.0), S::of(2500.0), S::of(8.0e4));
    let mut config = Config::new(Limits::new([fast, slow, fast]).unwrap());
    config.tolerance = S::of(0.26);
    config.start_delay = S::ZERO;
    let lines = pieces(&[[0.0; 3], [0.0, 6.0, 0.0], [1.0, 8.0, 0.5]], 0.89, 0.0);
    for every in [101, 160] {
        let sender = (Sender::Full, Operator::Holds(every));
        let outcome = run(config, &lines, 3.5, sender, &mut Draw(1));
        println!(
            "a hold every {every} cycles: {} cycles crawled of {}",
            outcome.crawled, outcome.cycles
        );
        assert!(outcome.crawled < 200, "{} cycles", outcome.crawled);
    }
}

#[test]
fn a_start_behind_a_hold_does_not_crawl() {
    starts_without_a_crawl::<f64>();
}

#[test]
fn a_start_behind_a_hold_does_not_crawl_in_f32() {
    starts_without_a_crawl::<f32>();
}
