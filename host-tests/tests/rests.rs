//! Where the machine rests, and for how long: at the programmed ends of blocks, not behind a rest that comes first anyway, and until a resume that is meant
//! for that rest.

mod common;

use common::soak;
use fastrand::Rng;
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Feed, Limits, Link, Motion, Progress,
    Scalar,
};

const AXES: usize = 2;
const CYCLE: f64 = 1.0e-3;
/// Servo cycles of a run at most, and of the standstill at its end.
const LONGEST: usize = 60_000;
const STILL: usize = 500;

type Line<S> = Block<S, AXES>;
type Points = Vec<(f64, f64)>;
type Command = fn(Controls<'_>);

fn at(x: f64, y: f64) -> [Coord; AXES] {
    [x, y].map(|mm| Coord::from_mm(mm).unwrap())
}

/// A line along X, at a feed or as a rapid.
fn line<S: Scalar>(to: f64, feed: Option<f64>, tag: u32) -> Line<S> {
    match feed {
        Some(feed) => Block::line(at(to, 0.0), S::of(feed), tag),
        None => Block::rapid(at(to, 0.0), tag),
    }
}

fn dwell<S: Scalar>(seconds: f64, tag: u32) -> Line<S> {
    let motion = Motion::Dwell { seconds: S::of(seconds) };
    Block { motion, feed: Feed::Rapid, tolerance: None, exact_stop: false, tag }
}

fn config<S: Scalar>() -> Config<S, AXES> {
    let axis = AxisLimits::linear(S::of(100.0), S::of(1000.0), S::of(20_000.0));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(0.01);
    config.cycle = S::of(CYCLE);
    config
}

/// A servo cycle of a run.
#[derive(Clone, Copy, Debug)]
struct Seen {
    place: [f64; AXES],
    /// Along X.
    speed: f64,
    tag: u32,
    activity: Activity,
    progress: Progress,
}

/// How the background comes to poll.
#[derive(Clone, Copy)]
enum Polls {
    /// As often as there is something to do.
    All,
    /// Once in so many servo cycles.
    Every(usize),
    /// The same as `All`, but not at all in these servo cycles.
    Not(usize, usize),
}

/// Runs a program; before every servo cycle the operator sees what was. Ends when nothing has changed for half a second.
fn run<S: Scalar>(
    config: Config<S, AXES>,
    blocks: &[Line<S>],
    polls: Polls,
    mut operator: impl FnMut(usize, &[Seen], Controls<'_>),
) -> Vec<Seen> {
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let cycle = config.cycle.to_f64();
    let (mut planner, mut interpolator) = link.split(config, at(0.0, 0.0)).unwrap();
    let mut left = blocks;
    let mut seen: Vec<Seen> = Vec::new();
    let mut progress = Progress::Waiting;
    let mut still = 0;
    for n in 0..LONGEST {
        while let [block, rest @ ..] = left
            && planner.push(block).is_ok()
        {
            left = rest;
            if left.is_empty() {
                planner.finish();
            }
        }
        operator(n, &seen, planner.controls());
        match polls {
            Polls::All => progress = planner.settle(),
            Polls::Every(cycles) if n % cycles == 0 => progress = planner.poll(),
            Polls::Not(from, to) if !(from..to).contains(&n) => progress = planner.settle(),
            _ => {}
        }
        let setpoint = interpolator.tick();
        seen.push(Seen {
            place: [0, 1].map(|axis| setpoint.position_mm(axis)),
            speed: setpoint.velocity[0].to_f64(),
            tag: setpoint.tag,
            activity: setpoint.activity,
            progress,
        });
        let rests = matches!(progress, Progress::Held | Progress::Done);
        still = if rests && setpoint.activity == Activity::Idle { still + 1 } else { 0 };
        if f64::from(still) * cycle > 0.5 {
            return seen;
        }
    }
    panic!("no rest: {:?}", seen.last());
}

/// What is pressed once the motion is in a block for the first time.
fn pressed_in<S: Scalar>(blocks: &[Line<S>], tag: u32, command: Command) -> Vec<Seen> {
    let mut done = false;
    run(config(), blocks, Polls::All, |_, seen, controls| {
        if !done && seen.last().is_some_and(|last| last.tag == tag) {
            command(controls);
            done = true;
        }
    })
}

/// What is pressed before a servo cycle.
fn pressed_at<S: Scalar>(
    config: Config<S, AXES>,
    blocks: &[Line<S>],
    when: usize,
    command: Command,
) -> Vec<Seen> {
    run(config, blocks, Polls::All, |n, _, controls| {
        if n == when {
            command(controls);
        }
    })
}

/// How far a place is from the nearest of some points.
fn from_nearest(place: [f64; AXES], points: &[(f64, f64)]) -> f64 {
    let off = |to: &(f64, f64)| (to.0 - place[0]).hypot(to.1 - place[1]);
    points.iter().map(off).fold(f64::INFINITY, f64::min)
}

const STOP: Command = |controls| controls.stop();
const SINGLE: Command = |controls| controls.single_block(true);

/// Lines one behind the other, each of a length and in a direction, rad, at a feed; with the start and their ends.
fn poly_line<S: Scalar>(
    lines: impl IntoIterator<Item = (f64, f64, f64)>,
) -> (Vec<Line<S>>, Points) {
    let mut points = vec![(0.0, 0.0)];
    let blocks = (1..)
        .zip(lines)
        .map(|(tag, (length, direction, feed))| {
            let here = points.last().copied().unwrap_or_default();
            let to = (here.0 + length * direction.cos(), here.1 + length * direction.sin());
            points.push(to);
            Block::line(at(to.0, to.1), S::of(feed), tag)
        })
        .collect();
    (blocks, points)
}

/// A stop or single block mode, in some servo cycle of a program: in which, and where the machine rests.
fn rest_in_any_cycle(
    config: &Config<f64, AXES>,
    blocks: &[Line<f64>],
    draw: &mut Rng,
) -> (usize, [f64; AXES]) {
    let plain = run(*config, blocks, Polls::All, |_, _, _| {}).len() - STILL;
    let when = (draw.f64() * plain as f64) as usize;
    let command = if draw.bool() { STOP } else { SINGLE };
    (when, pressed_at(*config, blocks, when, command).last().unwrap().place)
}

/// Lines that run straight on become one, and where the feed changes they are a part of a run: each still ends where it ends.
fn straight_lines_end_where_they_end<S: Scalar>(exact: f64) {
    type Lines = &'static [(f64, Option<f64>)];
    let cases: [Lines; 9] = [
        &[(50.0, Some(30.0)), (60.0, Some(30.0)), (100.0, Some(40.0))],
        &[(50.0, Some(20.0)), (150.0, Some(30.0)), (175.0, Some(30.0))],
        &[(50.0, None), (60.0, Some(30.0)), (75.0, Some(30.0))],
        &[(5.0, Some(30.2)), (10.0, Some(30.0)), (12.0, Some(30.0))],
        &[(5.0, Some(20.0)), (10.0, Some(30.0)), (12.0, Some(30.0))],
        &[(50.0, Some(30.0)), (60.0, Some(30.0)), (75.0, Some(30.0))],
        &[(50.0, None), (60.0, None), (75.0, None)],
        // Too near behind what would be a node, and not as near before the next.
        &[(0.5, Some(41.3)), (8.6803, Some(41.3)), (21.5236, Some(41.3))],
        // Just before the end of a part of a run.
        &[(2.666, Some(9.24)), (2.6984, Some(9.24)), (8.6135, Some(20.0))],
    ];
    for lines in cases {
        let blocks: Vec<Line<S>> =
            (1..).zip(lines).map(|(tag, &(to, feed))| line(to, feed, tag)).collect();
        let plain = run(config(), &blocks, Polls::All, |_, _, _| {});
        for (tag, (to, _)) in (1..).zip(lines) {
            for command in [STOP, SINGLE] {
                let seen = pressed_in(&blocks, tag, command);
                let rest = seen.last().unwrap();
                let ends = lines.iter().map(|(to, _)| (to - rest.place[0]).abs());
                let off = ends.fold(f64::INFINITY, f64::min);
                assert!(off < exact, "{lines:?} in {tag}: {rest:?}");
                assert!(rest.place[0] > to - exact, "{rest:?}");
                assert_eq!(rest.progress, Progress::Held, "{lines:?} in {tag}: {rest:?}");
            }
            let shown = plain.windows(2).find(|pair| pair[0].tag == tag && pair[1].tag != tag);
            if let Some([before, after]) = shown {
                let within = before.place[0] - exact..after.place[0] + exact;
                assert!(within.contains(to), "{lines:?}: {tag} ends at {within:?}");
            }
        }
    }
}

#[test]
fn straight_lines_end_where_they_end_in_both_precisions() {
    straight_lines_end_where_they_end::<f64>(1.0e-6);
    straight_lines_end_where_they_end::<f32>(1.0e-4);
}

/// Whatever lines there are, at whatever feeds.
#[test]
fn a_stop_on_a_straight_line_rests_at_an_end() {
    let mut draw = Rng::with_seed(11);
    for case in 0..400 * soak() {
        let (mut to, mut blocks, mut ends) = (0.0, Vec::<Line<f64>>::new(), Vec::new());
        let mut feed = 30.0;
        for tag in 1..=(3 + (draw.f64() * 9.0) as u32) {
            to += (2.0 * 30f64.powf(draw.f64()) * 1.0e4).round() / 1.0e4;
            if draw.f64() < 0.4 {
                feed = 5.0 * 18f64.powf(draw.f64());
            }
            blocks.push(line(to, (draw.f64() > 0.1).then_some(feed), tag));
            ends.push(to);
        }
        let plain = run(config(), &blocks, Polls::All, |_, _, _| {}).len();
        let when = (draw.f64() * plain as f64) as usize;
        let command = if draw.bool() { STOP } else { SINGLE };
        let seen = pressed_at(config(), &blocks, when, command);
        let rest = seen.last().unwrap();
        let off = ends.iter().map(|end| (end - rest.place[0]).abs()).fold(f64::INFINITY, f64::min);
        let at_start = rest.place[0].abs() < 1.0e-9;
        assert!(at_start || off < 1.0e-6, "case {case}: {rest:?} of {ends:?}, {when}");
    }
}

/// In a wide rounding, too: beside the end of a line that it leads over, and at the corner itself in its middle. But spans that turn much are not
/// cut, and rests are where they end.
#[test]
fn a_stop_in_a_corner_rests_beside_an_end() {
    let mut draw = Rng::with_seed(12);
    let tolerance = 0.2;
    let (cases, mut beyond) = (300 * soak(), 0);
    for case in 0..cases {
        let turn = (20.0 + 80.0 * draw.f64()).to_radians();
        let mut lines = Vec::new();
        for direction in [0.0, turn] {
            for _ in 0..=draw.u32(0..4) {
                lines.push((1.0 + 9.0 * draw.f64(), direction, 60.0));
            }
        }
        let (blocks, ends) = poly_line(lines);
        let mut config = config();
        config.tolerance = tolerance;
        let (when, rest) = rest_in_any_cycle(&config, &blocks, &mut draw);
        let least = from_nearest(rest, &ends);
        beyond += u32::from(least > 3.0 * tolerance);
        assert!(least < 20.0 * tolerance, "case {case}: {rest:?} of {ends:?}, {when}");
    }
    assert!(beyond * 50 < cases, "{beyond} of {cases} rest elsewhere");
}

/// Of lines that hardly turn, which are one curve, spans end where lines end.
#[test]
fn a_stop_on_lines_that_hardly_turn_rests_beside_an_end() {
    let tolerance = 0.05;
    let (mut rests, mut beyond) = (0, 0);
    for (length, turn) in [(3.0, 0.005), (7.0, 0.001), (7.0, 0.005), (7.0, 0.02), (11.0, 0.003)] {
        let lines = (0..14).map(|line| (length, f64::from(line) * turn, 80.0));
        let (blocks, ends) = poly_line(lines);
        let mut config = config();
        config.tolerance = tolerance;
        let plain = run(config, &blocks, Polls::All, |_, _, _| {}).len() - STILL;
        for when in (20..plain).step_by(plain / 40) {
            let command = if when % 2 == 0 { STOP } else { SINGLE };
            let seen = pressed_at(config, &blocks, when, command);
            let rest = seen.last().unwrap().place;
            let least = from_nearest(rest, &ends);
            rests += 1;
            beyond += u32::from(least > 2.0 * tolerance);
            assert!(least < length / 8.0, "lines of {length}, {turn} rad: {rest:?}, {when}");
        }
    }
    assert!(beyond * 50 < rests, "{beyond} of {rests} rest elsewhere");
}

/// Long lines among short ones, at feeds that change, that hardly turn: all one curve, of which cells end where long lines do, though knots lie elsewhere. With
/// their ends.
fn gentle_lines<S: Scalar>(draw: &mut Rng) -> (Config<S, AXES>, Vec<Line<S>>, Points) {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(20_000.0));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    config.tolerance = S::of(0.2);
    let (mut angle, mut feed) = (0.0, 60.0);
    let lines: Vec<_> = (0..15)
        .map(|_| {
            let length =
                if draw.bool() { 5.0 + 45.0 * draw.f64() } else { 0.01 + 0.1 * draw.f64() };
            let direction = angle;
            angle += 0.04 * draw.f64();
            if draw.u32(0..3) == 0 {
                feed = 15.0 * 6.0_f64.powf(draw.f64());
            }
            (length, direction, feed)
        })
        .collect();
    let (blocks, ends) = poly_line(lines);
    (config, blocks, ends)
}

/// Lines of all lengths that run on nearly straight, more than are remembered: the long ones are.
#[test]
fn a_stop_on_lines_of_all_lengths_rests_beside_an_end() {
    let mut draw = Rng::with_seed(17);
    let (cases, mut beyond) = (200 * soak(), 0);
    for case in 0..cases {
        let axis = AxisLimits::linear(200.0, 5000.0, 250_000.0);
        let mut config: Config<f64, AXES> = Config::new(Limits::new([axis; AXES]).unwrap());
        config.tolerance = 0.1;
        let turn = 0.0005 * 20.0_f64.powf(draw.f64());
        let lines: Vec<_> = (0..40)
            .map(|line| (0.2 * 200.0_f64.powf(draw.f64()), f64::from(line) * turn, 120.0))
            .collect();
        let (blocks, ends) = poly_line(lines);
        let (when, rest) = rest_in_any_cycle(&config, &blocks, &mut draw);
        let least = from_nearest(rest, &ends);
        beyond += u32::from(least > 0.2);
        assert!(least < 1.0, "case {case}: {least} mm, {rest:?}, {when}");
    }
    assert!(beyond * 50 < cases, "{beyond} of {cases} rest elsewhere");
}

fn long_lines_are_shown<S: Scalar>(seed: u64) {
    let mut draw = Rng::with_seed(seed);
    for case in 0..100 * soak() {
        let (config, blocks, ends) = gentle_lines::<S>(&mut draw);
        let seen = run(config, &blocks, Polls::All, |_, _, _| {});
        assert!(seen.is_sorted_by_key(|now| now.tag), "case {case}: a tag goes back");
        for (tag, line) in (1..).zip(ends.windows(2)) {
            let &[from, to] = line else { continue };
            if (to.0 - from.0).hypot(to.1 - from.1) < 2.0 {
                continue;
            }
            let middle = (f64::midpoint(from.0, to.0), f64::midpoint(from.1, to.1));
            let there = |now: &Seen| (now.place[0] - middle.0).hypot(now.place[1] - middle.1);
            let nearest = seen.iter().min_by(|a, b| there(a).total_cmp(&there(b))).unwrap();
            assert_eq!(nearest.tag, tag, "case {case}: at {:?}", nearest.place);
        }
    }
}

#[test]
fn long_lines_that_hardly_turn_show_their_tags_in_both_precisions() {
    long_lines_are_shown::<f32>(18);
    long_lines_are_shown::<f64>(19);
}

/// What else is pressed before a stop has come to its end does not end it: from a rest within a block the motion goes on to the end of that.
#[test]
fn a_stop_goes_on_to_the_end_of_the_block() {
    const HOLD: Command = |controls| controls.hold();
    const RESUME: Command = |controls| controls.resume();
    const NONE: Command = |controls| controls.feed_override(0);
    const WHOLE: Command = |controls| controls.feed_override(100);
    let orders: [&[(usize, Command)]; 5] = [
        &[(200, STOP), (202, NONE), (600, WHOLE)],
        &[(200, NONE), (203, STOP), (600, WHOLE)],
        &[(200, NONE), (400, STOP), (600, WHOLE)],
        &[(200, HOLD), (400, RESUME), (400, STOP)],
        &[(200, HOLD), (400, RESUME), (401, STOP)],
    ];
    let blocks: Vec<Line<f64>> =
        (1..4).map(|tag| line(10.0 * f64::from(tag), Some(20.0), tag)).collect();
    for order in orders {
        let seen = run(config(), &blocks, Polls::All, |n, _, controls| {
            let due = order.iter().filter(|(when, _)| *when == n);
            due.for_each(|(_, command)| command(controls));
        });
        let rest = seen.last().unwrap();
        assert!((rest.place[0] - 10.0).abs() < 1.0e-6, "{order:?}: {rest:?}");
        assert_eq!(rest.progress, Progress::Held);
        let rested = seen.iter().skip(300).any(|seen| seen.activity == Activity::Idle);
        assert!(rested, "{order:?}");
    }
}

/// Where planning takes so long that a plan ends before the next is there, a stop goes on from that rest, too.
#[test]
fn a_stop_rests_at_an_end_however_slow_planning_is() {
    let corners = [(0.0, 12.0), (9.0, 12.0), (9.0, 30.0), (40.0, 30.0), (40.0, 0.0), (90.0, 0.0)];
    let blocks: Vec<Line<f64>> = (1..)
        .zip(corners)
        .map(|(tag, (x, y))| Block::line(at(x, y), 20.0 + f64::from(tag), tag))
        .collect();
    for every in [1, 7, 16, 40] {
        for when in (150..3000).step_by(173) {
            let seen = run(config(), &blocks, Polls::Every(every), |n, _, controls| {
                if n == when {
                    controls.stop();
                }
            });
            let rest = seen.last().unwrap();
            let [x, y] = rest.place;
            let start = std::iter::once(&(0.0, 0.0));
            let ends = start.chain(&corners).map(|(a, b)| (a - x).hypot(b - y));
            let off = ends.fold(f64::INFINITY, f64::min);
            assert!(off < 0.02, "{every}, {when}: {rest:?}");
        }
    }
}

/// A resume counts from the cycle that shows the rest or the event, though nobody has polled since; one before that does not.
#[test]
fn a_resume_is_meant_for_the_rest_that_is_shown() {
    let pause: Line<f64> = Block::pause(2);
    let lines = [line(5.0, Some(20.0), 1), pause, line(10.0, Some(20.0), 3)];
    let plain = [lines[0], lines[2]];
    for (blocks, single) in [(&lines[..], false), (&plain[..], true)] {
        let begin = |controls: Controls<'_>| controls.single_block(single);
        let shows = |seen: &Seen| {
            let rests = seen.activity == Activity::Idle && seen.place[0] > 4.0;
            if single { rests } else { seen.activity == Activity::Event }
        };
        let plain = run(config(), blocks, Polls::All, |n, _, controls| {
            if n == 0 {
                begin(controls);
            }
        });
        let rested = plain.iter().position(shows).unwrap();
        for (polls, most) in [
            (Polls::All, 8),
            (Polls::Every(1), 8),
            (Polls::Every(5), 8),
            (Polls::Not(rested - 50, rested + 400), 390),
        ] {
            for pressed in (0..8).chain([most]) {
                for before in [false, true] {
                    let mut shown = None;
                    let seen = run(config(), blocks, polls, |n, seen, controls| {
                        if n == 0 {
                            begin(controls);
                        }
                        shown = shown.or(seen.last().filter(|last| shows(last)).map(|_| n));
                        let due = if before {
                            n + 1 + pressed == rested
                        } else {
                            shown == n.checked_sub(pressed) && shown.is_some()
                        };
                        if due {
                            controls.resume();
                        }
                    });
                    let rest = seen.last().unwrap().place[0];
                    let expected = if before { 5.0 } else { 10.0 };
                    assert!((rest - expected).abs() < 1.0e-6, "{single}, {pressed}: {rest}");
                }
            }
        }
    }
}

/// A rest that comes before an answer could take effect is the answer: nothing moves behind it, however slow planning is.
#[test]
fn a_hold_is_not_answered_behind_a_rest() {
    const POLLS: usize = 10;
    let mut exact: Line<f64> = line(-3.5, Some(90.0), 4);
    exact.exact_stop = true;
    for rest in [dwell(0.0445, 5), exact] {
        let blocks = [
            line(0.3, Some(80.0), 1),
            line(0.65, Some(10.5), 2),
            line(-3.5, Some(90.0), 4),
            rest,
            line(-3.47, Some(6.5), 6),
            line(-9.0, Some(6.5), 7),
        ];
        for every in [1, 5, 13, 30] {
            let config = || {
                let mut config = config::<f64>();
                (config.cycle, config.lead) = (0.25e-3, 0.05);
                config
            };
            let plain = run(config(), &blocks, Polls::Every(every), |_, _, _| {});
            let stands = |seen: &&Seen| seen.tag < 6 && (seen.place[0] + 3.5).abs() < 1.0e-6;
            let stand = plain.len() - plain.iter().rev().skip_while(|seen| !stands(seen)).count();
            let end = plain.len() - stand;
            // What is pressed a few polls before the motion goes on is answered behind that, as it is in motion.
            for when in (end.saturating_sub(800)..end - POLLS * every).step_by(11) {
                let mut held = false;
                let seen = run(config(), &blocks, Polls::Every(every), |n, _, controls| {
                    if n == when && !held {
                        controls.hold();
                        held = true;
                    }
                });
                let moves = |pair: &[Seen]| pair[0].speed == 0.0 && pair[1].speed != 0.0;
                let starts = seen.windows(2).skip(when + 1).filter(|pair| moves(pair)).count();
                assert_eq!(starts, 0, "every {every}, hold at {when}: {:?}", seen.last());
            }
        }
    }
}
