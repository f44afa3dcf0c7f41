//! The core through its public interface: the paper's paths, starvation, errors, contexts.

use splineway::block::BlockError;
use splineway::machine::Quantity;
use splineway::{
    Activity, AxisLimits, Block, Config, Coord, CornerMode, Feed, Interpolator, Limits, Link,
    Motion, Planner, Progress, PushError, Setpoint, Turn,
};

const NODES: usize = 128;
const BLOCKS: usize = 16;

type TestLink<S> = Link<S, 3, BLOCKS, NODES>;
type TestPlanner<'a, S> = Planner<'a, S, 3, BLOCKS, NODES>;

fn config() -> Config<f64, 3> {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; 3]).unwrap());
    config.tolerance = 0.05;
    config
}

fn at(x: f64, y: f64, z: f64) -> [Coord; 3] {
    [x, y, z].map(|mm| Coord::from_mm(mm).unwrap())
}

fn place(setpoint: &Setpoint<f64, 3>) -> [f64; 3] {
    [0, 1, 2].map(|axis| setpoint.position_mm(axis))
}

/// Runs until everything pushed has been run; returns every setpoint.
fn run_out(
    planner: &mut TestPlanner<'_, f64>,
    interpolator: &mut Interpolator<'_, f64, 3>,
) -> Vec<Setpoint<f64, 3>> {
    let mut setpoints = Vec::new();
    planner.finish();
    for _ in 0..2_000_000 {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        setpoints.push(setpoint);
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            return setpoints;
        }
    }
    panic!("the run did not end");
}

fn distance_to_poly(points: &[[f64; 3]], x: &[f64; 3]) -> f64 {
    let one = |a: &[f64; 3], b: &[f64; 3]| {
        let d: Vec<f64> = (0..3).map(|i| b[i] - a[i]).collect();
        let length: f64 = d.iter().map(|v| v * v).sum();
        let along: f64 = (0..3).map(|i| (x[i] - a[i]) * d[i]).sum();
        let t = (along / length).clamp(0.0, 1.0);
        (0..3).map(|i| (a[i] + t * d[i] - x[i]).powi(2)).sum::<f64>().sqrt()
    };
    points.windows(2).map(|pair| one(&pair[0], &pair[1])).fold(f64::INFINITY, f64::min)
}

/// Largest jump of velocity and acceleration between cycles: both are continuous.
fn check_continuity(setpoints: &[Setpoint<f64, 3>]) {
    for pair in setpoints.windows(2) {
        for axis in 0..3 {
            let dv = (pair[1].velocity[axis] - pair[0].velocity[axis]).abs();
            let da = (pair[1].acceleration[axis] - pair[0].acceleration[axis]).abs();
            let dx = pair[1].position_mm(axis) - pair[0].position_mm(axis);
            assert!(dv <= 2000.0 * 1e-3 * 1.001, "velocity jumps by {dv}");
            assert!(da <= 50_000.0 * 1e-3 * 1.001, "acceleration jumps by {da}");
            // The velocity is the derivative of the position.
            let mean = f64::midpoint(pair[0].velocity[axis], pair[1].velocity[axis]);
            assert!((dx / 1e-3 - mean).abs() < 0.01, "{} and {mean}", dx / 1e-3);
        }
    }
}

/// Runs along a poly-line at 200 mm/s; continuity is checked. Returns the setpoints and the largest
/// distance from the line, mm.
fn run_poly(config: &Config<f64, 3>, points: &[[f64; 3]]) -> (Vec<Setpoint<f64, 3>>, f64) {
    let mut link = TestLink::new();
    let start = at(points[0][0], points[0][1], points[0][2]);
    let (mut planner, mut interpolator) = link.split(*config, start).unwrap();
    for (k, p) in points.iter().enumerate().skip(1) {
        planner.push(&Block::line(at(p[0], p[1], p[2]), 200.0, k as u32)).unwrap();
    }
    let setpoints = run_out(&mut planner, &mut interpolator);
    check_continuity(&setpoints);
    let worst = setpoints.iter().map(|s| distance_to_poly(points, &place(s))).fold(0.0, f64::max);
    (setpoints, worst)
}

/// Section 4.2: a closed hexagon in space, delta 0.05, five transitions; in both modes.
#[test]
fn closed_hexagon_of_the_paper() {
    let points: Vec<[f64; 3]> = (0..=6)
        .map(|k| {
            let phi = f64::from(k) * std::f64::consts::TAU / 6.0;
            [10.0 * phi.cos(), 10.0 * phi.sin(), if k % 2 == 0 { 0.0 } else { 4.0 }]
        })
        .collect();
    let mut times = Vec::new();
    for corner in [CornerMode::Band, CornerMode::Paper { lambda: 0.0 }] {
        let mut config = config();
        config.corner = corner;
        let (setpoints, worst) = run_poly(&config, &points);
        // The full band by default, half of it and less in the paper's mode (e* = delta / 2).
        let (least, most) =
            if corner == CornerMode::Band { (0.045, 0.05) } else { (0.015, 0.0251) };
        assert!(worst > least && worst <= most, "{corner:?}: {worst}");
        // Five corners are passed without stopping.
        let slowest = setpoints[20..setpoints.len() - 40]
            .iter()
            .map(|s| s.path_speed)
            .fold(f64::INFINITY, f64::min);
        assert!(slowest > 2.0, "{slowest}");
        let end = place(setpoints.last().unwrap());
        assert!((0..3).all(|i| (end[i] - points[6][i]).abs() < 1e-9));
        times.push(setpoints.len());
    }
    assert!(times[0] < times[1], "the full band must be faster: {times:?}");
}

/// Figures 6 and 7: transitions that would overlap, and one that would use up the next leg.
#[test]
fn overlapping_corners_share_the_leg() {
    for (leg, corner) in [
        (0.3, CornerMode::Band),
        (0.3, CornerMode::Paper { lambda: 0.0 }),
        (0.3, CornerMode::Paper { lambda: 0.3 }),
        (0.05, CornerMode::Band),
        (0.05, CornerMode::Paper { lambda: 0.0 }),
    ] {
        let mut config = config();
        config.corner = corner;
        let points = [
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [4.0, leg, 0.0],
            [8.0, leg, 0.0],
            [8.0 + leg, leg, leg],
            [8.0 + leg, 5.0, leg],
        ];
        let (_, worst) = run_poly(&config, &points);
        assert!(worst <= 0.05, "{corner:?}, leg {leg}: {worst}");
    }
}

/// A producer that is too slow: the machine comes to rest on the path within limits and goes on
/// when blocks arrive; nothing is lost.
#[test]
fn starvation_and_resume() {
    let mut link = TestLink::new();
    let (mut planner, mut interpolator) = link.split(config(), at(0.0, 0.0, 0.0)).unwrap();
    let mut points = vec![[0.0, 0.0, 0.0]];
    let mut setpoints = Vec::new();
    let mut rests = 0;
    let mut idle = false;
    for cycle in 0..6000u32 {
        if cycle % 150 == 0 && points.len() <= 30 {
            let k = points.len() as f64;
            let p = [k * 3.0, if points.len().is_multiple_of(2) { 0.0 } else { 2.0 }, 0.0];
            planner.push(&Block::line(at(p[0], p[1], p[2]), 200.0, points.len() as u32)).unwrap();
            points.push(p);
        }
        planner.settle();
        let setpoint = interpolator.tick();
        rests += u32::from(!idle && setpoint.activity == Activity::Idle);
        idle = setpoint.activity == Activity::Idle;
        setpoints.push(setpoint);
    }
    assert!(rests > 5, "the producer was meant to be too slow");
    check_continuity(&setpoints);
    let end = place(setpoints.last().unwrap());
    let last = points.last().unwrap();
    assert!((0..3).all(|i| (end[i] - last[i]).abs() < 1e-9), "{end:?}");
    for setpoint in &setpoints {
        assert!(distance_to_poly(&points, &place(setpoint)) <= 0.05);
    }
    // Every block was under way once, in order.
    let mut tags: Vec<u32> = setpoints.iter().map(|s| s.tag).collect();
    assert!(tags.is_sorted());
    tags.dedup();
    assert_eq!(tags.len(), 31);
}

/// A line that hardly goes on, or back, does not take over the tag of a long one before it that it becomes one with.
#[test]
fn a_long_line_keeps_its_tag_beside_a_short_one() {
    for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (-1000, 0), (-1000, 1000), (0, -2000)] {
        let mut config = config();
        config.tolerance = 0.01;
        let mut link = Box::new(Link::<f64, 3, 16, 64>::new());
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 3]).unwrap();
        let at = |x, y| [x, y, 0].map(|nm| Coord::from_nm(nm).unwrap());
        let far = 10_000_000;
        let blocks = [at(far, 0), at(far + dx, dy), at(far, far)];
        for (tag, to) in (1..).zip(blocks) {
            planner.push(&Block::line(to, 20.0, tag)).unwrap();
        }
        planner.finish();
        let mut ticks = [0; 4];
        for _ in 0..2000 {
            planner.settle();
            let setpoint = interpolator.tick();
            if setpoint.activity == Activity::Running {
                ticks[setpoint.tag as usize] += 1;
            }
        }
        let [_, first, short, last] = ticks;
        assert!(short < 20, "{dx} {dy}: {ticks:?}");
        assert!(first > 480 && last > 480, "{dx} {dy}: {ticks:?}");
    }
}

/// Lines in a row, of which the first has a tolerance of its own, become one but for that: what is shown is the block
/// under way all the same, whatever the rounding of their ends.
#[test]
fn lines_that_become_one_show_their_tags_in_order() {
    for step in 0..200 {
        let unit = 0.02 + f64::from(step) * 1.0e-4;
        let ends = [1.0, 4.0, 7.0, 8.0].map(|share| share * unit);
        let mut config = config();
        config.tolerance = 0.01;
        let mut link = Box::new(Link::<f64, 3, 4, 48>::new());
        let (mut planner, mut interpolator) = link.split(config, at(0.0, 0.0, 0.0)).unwrap();
        for (tag, x) in (1..).zip(ends) {
            let mut block = Block::line(at(x, 0.0, 0.0), 45.0, tag);
            block.tolerance = (tag == 1).then_some(0.5);
            planner.push(&block).unwrap();
        }
        planner.finish();
        let mut shown = Vec::new();
        for _ in 0..400 {
            planner.settle();
            let setpoint = interpolator.tick();
            if setpoint.activity == Activity::Running {
                shown.push(setpoint.tag);
            }
        }
        assert!(shown.is_sorted(), "{unit}: {shown:?}");
        assert_eq!(shown.last(), Some(&4), "{unit}");
    }
}

/// A producer of dense, slightly bent lines that comes and goes: whatever is merged or cut when, the
/// motion stays continuous, in the band, and ends where the program ends.
#[test]
fn a_stuttering_producer_of_dense_lines() {
    for pace in [3u32, 7, 12, 20, 45, 80] {
        let mut link = TestLink::new();
        let (mut planner, mut interpolator) = link.split(config(), at(0.0, 0.0, 0.0)).unwrap();
        let mut points = vec![[0.0f64, 0.0, 0.0]];
        let (mut setpoints, mut heading) = (Vec::new(), 0.0f64);
        for cycle in 0..12_000u32 {
            // Bursts of three, then a pause.
            for _ in 0..3 {
                if cycle % pace != 0 || points.len() > 400 {
                    break;
                }
                let k = points.len() as f64;
                heading += 0.06 * (k * 0.37).sin()
                    + if points.len().is_multiple_of(50) { 0.9 } else { 0.0 };
                let last = points[points.len() - 1];
                let step = 0.12 + 0.1 * (k * 1.7).sin();
                let p = [last[0] + step * heading.cos(), last[1] + step * heading.sin(), 0.0];
                match planner.push(&Block::line(at(p[0], p[1], p[2]), 150.0, points.len() as u32)) {
                    Ok(()) => points.push(p),
                    Err(error) => {
                        assert_eq!(error, PushError::Full);
                        break;
                    }
                }
            }
            planner.settle();
            setpoints.push(interpolator.tick());
        }
        assert_eq!(points.len(), 401, "pace {pace}");
        check_continuity(&setpoints);
        let end = place(setpoints.last().unwrap());
        assert!((0..3).all(|i| (end[i] - points[400][i]).abs() < 1e-9), "pace {pace}: {end:?}");
        for setpoint in &setpoints {
            assert!(distance_to_poly(&points, &place(setpoint)) <= 0.05, "pace {pace}");
        }
    }
}

/// A planner that falls silent in full motion: the plan at hand ends at rest, on the path.
#[test]
fn a_silent_planner_is_survived() {
    let mut link = TestLink::new();
    let (mut planner, mut interpolator) = link.split(config(), at(0.0, 0.0, 0.0)).unwrap();
    for k in 0..BLOCKS {
        let x = 10.0 * (k + 1) as f64;
        planner
            .push(&Block::line(at(x, if k % 2 == 0 { 1.0 } else { 0.0 }, 0.0), 200.0, k as u32))
            .unwrap();
    }
    let mut setpoints = Vec::new();
    for cycle in 0..5000 {
        // From cycle 100 on nobody plans for four seconds.
        if !(100..4100).contains(&cycle) {
            planner.finish();
            planner.settle();
        }
        setpoints.push(interpolator.tick());
    }
    check_continuity(&setpoints);
    assert_eq!(setpoints[4000].activity, Activity::Idle);
    assert_eq!(setpoints[4999].activity, Activity::Idle);
    assert!((setpoints[4999].position_mm(0) - 10.0 * BLOCKS as f64).abs() < 1e-9);
}

/// Producer and interrupt in two threads.
#[test]
fn handles_live_in_two_threads() {
    let mut link = TestLink::new();
    let (mut planner, mut interpolator) = link.split(config(), at(0.0, 0.0, 0.0)).unwrap();
    let done = std::sync::atomic::AtomicBool::new(false);
    let setpoints = std::thread::scope(|scope| {
        let servo = scope.spawn(|| {
            let mut setpoints = Vec::new();
            while !done.load(std::sync::atomic::Ordering::Acquire) {
                setpoints.push(interpolator.tick());
                std::thread::sleep(std::time::Duration::from_micros(50));
            }
            setpoints
        });
        for k in 0..60u32 {
            let p = at(f64::from(k + 1), if k % 2 == 0 { 1.0 } else { 0.0 }, 0.0);
            while let Err(error) = planner.push(&Block::line(p, 200.0, k)) {
                assert_eq!(error, PushError::Full);
                planner.settle();
            }
        }
        planner.finish();
        while planner.settle() != Progress::Done {
            std::thread::yield_now();
        }
        done.store(true, std::sync::atomic::Ordering::Release);
        servo.join().unwrap()
    });
    check_continuity(&setpoints);
    assert!((setpoints.last().unwrap().position_mm(0) - 60.0).abs() < 1e-9);
}

/// Both handles may be sent to another context.
#[test]
fn handles_are_send() {
    fn is_send<T: Send>() {}
    is_send::<Planner<'static, f32, 3, 16, 64>>();
    is_send::<Interpolator<'static, f32, 3>>();
}

/// Dwell, exact stop and G61 by tolerance 0: at rest, exactly on the vertex, for as long as asked.
#[test]
fn dwells_and_exact_stops_rest_on_the_vertex() {
    let mut link = TestLink::new();
    let (mut planner, mut interpolator) = link.split(config(), at(0.0, 0.0, 0.0)).unwrap();
    planner.push(&Block::line(at(5.0, 0.0, 0.0), 200.0, 1)).unwrap();
    planner.push(&Block::dwell(0.25, 2)).unwrap();
    let mut block = Block::line(at(5.0, 5.0, 0.0), 200.0, 3);
    block.exact_stop = true;
    planner.push(&block).unwrap();
    let mut block = Block::line(at(0.0, 5.0, 0.0), 200.0, 4);
    block.tolerance = Some(0.0);
    planner.push(&block).unwrap();
    planner.push(&Block::line(at(0.0, 0.0, 0.0), 200.0, 5)).unwrap();
    let setpoints = run_out(&mut planner, &mut interpolator);
    check_continuity(&setpoints);
    let dwelling: Vec<_> = setpoints.iter().filter(|s| s.activity == Activity::Dwelling).collect();
    assert!((249..=251).contains(&dwelling.len()), "{}", dwelling.len());
    assert!(
        dwelling
            .iter()
            .all(|s| s.tag == 2 && s.position_nm(0) == 5_000_000 && s.position_nm(1) == 0)
    );
    for vertex in [[5.0, 5.0, 0.0], [0.0, 5.0, 0.0]] {
        let nearest = setpoints
            .iter()
            .map(|s| (0..3).map(|i| (place(s)[i] - vertex[i]).powi(2)).sum::<f64>().sqrt())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 2e-5, "{vertex:?} is passed at {nearest}");
    }
}

/// A refused block is explained and changes nothing.
#[test]
fn bad_blocks_are_refused_and_leave_the_rest_intact() {
    let mut link = TestLink::new();
    let (mut planner, mut interpolator) = link.split(config(), at(0.0, 0.0, 0.0)).unwrap();
    planner.push(&Block::line(at(5.0, 0.0, 0.0), 100.0, 1)).unwrap();
    let arc = |to, centre: (f64, f64), plane| Block {
        motion: Motion::Arc {
            to,
            plane,
            centre: (Coord::from_mm(centre.0).unwrap(), Coord::from_mm(centre.1).unwrap()),
            turn: Turn::Clockwise,
            extra_turns: 0,
        },
        feed: Feed::PerSecond(100.0),
        tolerance: None,
        exact_stop: false,
        tag: 7,
    };
    let line = Block::line(at(6.0, 0.0, 0.0), 100.0, 7);
    let field = |block: &Block<f64, 3>| match TestPlanner::push(&mut planner, block) {
        Err(PushError::Rejected { tag: 7, reason }) => reason,
        other => panic!("{block:?} gave {other:?}"),
    };
    let mut field = field;
    for feed in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let reason = field(&Block { feed: Feed::PerSecond(feed), ..line });
        assert!(matches!(reason, BlockError::OutOfRange { quantity: Quantity::Feed, .. }));
    }
    let reason = field(&Block { feed: Feed::Duration(0.0), ..line });
    assert!(matches!(reason, BlockError::OutOfRange { quantity: Quantity::Duration, .. }));
    let reason = field(&Block { tolerance: Some(-0.1), ..line });
    assert!(matches!(reason, BlockError::OutOfRange { quantity: Quantity::Tolerance, .. }));
    let reason = field(&Block::dwell(f64::NAN, 7));
    assert!(matches!(reason, BlockError::OutOfRange { quantity: Quantity::Dwell, .. }));
    let far = [Coord::from_raw(i64::MAX), Coord::ZERO, Coord::ZERO];
    assert!(matches!(field(&Block::line(far, 1.0, 7)), BlockError::Coordinate { axis: 0, .. }));
    let reason = field(&arc(at(9.0, 0.0, 0.0), (6.0, 0.0), (0, 1)));
    assert!(matches!(reason, BlockError::ArcRadius { .. }));
    let reason = field(&arc(at(5.0, 0.0, 0.0), (5.0, 0.0), (0, 1)));
    assert!(matches!(reason, BlockError::ArcUnreachable { .. }));
    assert!(matches!(
        field(&arc(at(9.0, 0.0, 0.0), (7.0, 0.0), (0, 3))),
        BlockError::Plane { axes: (0, 3) }
    ));
    assert_eq!(planner.end(), &at(5.0, 0.0, 0.0));
    // Zero length is accepted and ignored.
    planner.push(&Block::line(at(5.0, 0.0, 0.0), 100.0, 8)).unwrap();
    let setpoints = run_out(&mut planner, &mut interpolator);
    assert_eq!(setpoints.last().unwrap().position_nm(0), 5_000_000);
}

/// Of a line of a nanometre that is simply passed at one end, a run at the other would have less than is a line: it was begun along
/// the line behind that, back the way the motion had come.
#[test]
fn runs_beside_lines_of_a_nanometre_do_not_lead_back() {
    let (along, up) = ([0.6f64, 0.8], 6.8e-3);
    for (tiny, turn, ends) in [0.52e-6, 0.572e-6, 0.66e-6, 0.7e-6, 1.9e-6, 2.1e-6]
        .into_iter()
        .flat_map(|tiny| [0.4f64, 1.2, 2.1, 2.9, 3.06].map(|turn| (tiny, turn)))
        .flat_map(|(tiny, turn)| [false, true].map(|ends| (tiny, turn, ends)))
    {
        let (sin, cos) = turn.sin_cos();
        let back = [along[0] * cos - along[1] * sin, along[0] * sin + along[1] * cos];
        // Joints of a line without a tolerance are passed where they are straight.
        let mut ways = vec![(along, up, 0.0), (along, tiny, 0.01), (back, 0.1, 0.01)];
        if ends {
            ways.reverse();
        }
        let axis = AxisLimits::linear(200.0f32, 2000.0, 50_000.0);
        let config = Config::new(Limits::new([axis; 3]).unwrap());
        let mut link = TestLink::new();
        let (mut planner, mut interpolator) = link.split(config, at(0.0, 0.0, 0.0)).unwrap();
        let (mut x, mut y) = (0.0, 0.0);
        for (direction, length, tolerance) in ways {
            (x, y) = (x + direction[0] * length, y + direction[1] * length);
            let line = Block::line(at(x, y, 0.0), 60.0, 0);
            planner.push(&Block { tolerance: Some(tolerance), ..line }).unwrap();
        }
        planner.finish();
        let mut before = 0.0;
        for cycle in 0.. {
            assert!(cycle < 10_000, "{tiny} {turn} {ends}: no end");
            let progress = planner.settle();
            let here = interpolator.tick();
            let gone = here.path_mm() - before;
            assert!(gone >= -3.0e-7, "{tiny} {turn} {ends}: {gone:e} mm");
            before = here.path_mm();
            if progress == Progress::Done && here.activity == Activity::Idle {
                let off = [here.position_mm(0) - x, here.position_mm(1) - y];
                assert!(off.iter().all(|off| off.abs() < 1.0e-6));
                break;
            }
        }
    }
}

/// What a feed means: over the linear axes if any of them moves, else over the rotary ones; under
/// inverse time the block takes its time.
#[test]
fn feeds_of_rotary_moves_and_inverse_time() {
    let linear = AxisLimits::linear(200.0, 20_000.0, 2.0e6);
    let rotary = AxisLimits { rotary: true, ..linear };
    let config = Config::new(Limits::new([linear, linear, rotary]).unwrap());
    let mut link = TestLink::new();
    let (mut planner, mut interpolator) = link.split(config, at(0.0, 0.0, 0.0)).unwrap();
    let mut stop = |to, feed| {
        planner.push(&Block { feed, exact_stop: true, ..Block::line(to, 1.0, 0) }).unwrap();
    };
    stop(at(30.0, 40.0, 90.0), Feed::PerSecond(50.0)); // 50 mm/s over X and Y, 90 degrees along with it
    stop(at(30.0, 40.0, 180.0), Feed::PerSecond(45.0)); // 45 degrees/s
    stop(at(0.0, 0.0, 180.0), Feed::Duration(2.0)); // 25 mm/s
    let setpoints = run_out(&mut planner, &mut interpolator);
    let speed = |s: &Setpoint<f64, 3>| s.velocity[0].hypot(s.velocity[1]);
    let fastest = |from: f64, to: f64, of: &dyn Fn(&Setpoint<f64, 3>) -> f64| {
        let part = &setpoints[(from * 1000.0) as usize..(to * 1000.0) as usize];
        part.iter().map(of).fold(0.0, f64::max)
    };
    // The barrier keeps a thousandth or two from the feed.
    assert!((fastest(0.0, 0.9, &speed) - 50.0).abs() < 0.15);
    assert!((fastest(1.2, 2.9, &|s| s.velocity[2]) - 45.0).abs() < 0.15);
    assert!((fastest(3.3, 4.9, &speed) - 25.0).abs() < 0.1);
}

/// Where a path of linear and rotary axes turns, it has more of the linear ones than its lines: their speed is not more than the feed
/// all the same, in a corner as in a run of short lines.
#[test]
fn linear_axes_keep_the_feed_where_the_path_turns() {
    let linear = AxisLimits::linear(200.0f64, 20_000.0, 2.0e6);
    let rotary = AxisLimits { rotary: true, ..linear };
    let corner = vec![[2.0, 20.0], [4.0, 0.0]];
    let circle = |k: u32| (std::f64::consts::TAU * f64::from(k) / 16.0).sin_cos();
    let run = (1..=16).map(|k| [2.0 * circle(k).0, 2.0 - 2.0 * circle(k).1]).collect();
    for (tolerance, points) in [(0.2, corner), (0.1, run)] {
        let mut config = Config::new(Limits::new([linear, linear, rotary]).unwrap());
        config.tolerance = tolerance;
        let mut link = TestLink::new();
        let (mut planner, mut interpolator) = link.split(config, at(0.0, 0.0, 0.0)).unwrap();
        let mut points: std::collections::VecDeque<_> = points.into();
        let mut fastest = 0.0f64;
        for cycle in 0.. {
            assert!(cycle < 100_000, "no end");
            while let Some([x, c]) = points.front() {
                match planner.push(&Block::line(at(*x, 0.0, *c), 10.0, 0)) {
                    Ok(()) => drop(points.pop_front()),
                    Err(PushError::Full) => break,
                    Err(error) => panic!("{error}"),
                }
            }
            if points.is_empty() {
                planner.finish();
            }
            let progress = planner.settle();
            let here = interpolator.tick();
            fastest = fastest.max(here.velocity[0].abs());
            if progress == Progress::Done && here.activity == Activity::Idle {
                break;
            }
        }
        assert!(fastest > 9.5 && fastest <= 10.1, "{tolerance}: {fastest} mm/s");
    }
}

/// A full buffer refuses and keeps everything.
#[test]
fn a_full_buffer_would_block_and_loses_nothing() {
    let mut link = TestLink::new();
    let (mut planner, mut interpolator) = link.split(config(), at(0.0, 0.0, 0.0)).unwrap();
    let mut taken = 0;
    // To and fro: lines that run on straight would be one.
    let place = |taken: u32| at(f64::from(taken + 1), f64::from(taken % 2), 0.0);
    while planner.push(&Block::line(place(taken), 50.0, taken)).is_ok() {
        taken += 1;
    }
    assert_eq!(taken as usize, BLOCKS);
    assert_eq!(planner.push(&Block::line(at(99.0, 0.0, 0.0), 50.0, 99)), Err(PushError::Full));
    let setpoints = run_out(&mut planner, &mut interpolator);
    assert_eq!(setpoints.last().unwrap().position_nm(0), i64::from(taken) * 1_000_000);
}

/// Two metres away from the origin, in f32: every stop is exact to the nanometre after thousands
/// of blocks, and so it stays, because every position is an absolute fixed-point number.
#[test]
fn f32_keeps_nanometres_on_a_two_metre_axis() {
    let axis = AxisLimits::linear(500.0f32, 10_000.0, 1.0e6);
    let mut config = Config::new(Limits::new([axis; 3]).unwrap());
    config.tolerance = 0.0;
    let home = [
        Coord::from_nm(1_999_999_999).unwrap(),
        Coord::from_nm(-1_999_999_999).unwrap(),
        Coord::ZERO,
    ];
    let mut link = Link::<f32, 3, BLOCKS, NODES>::new();
    let (mut planner, mut interpolator) = link.split(config, home).unwrap();
    let mut stops = 0;
    for k in 0..3000i64 {
        // A vertex no f32 could hold: 1,999,999,999 nm and a few.
        let to = [
            Coord::from_nm(1_999_999_999 + (k * 7919) % 100_003).unwrap(),
            Coord::from_nm(-1_999_999_999 - (k * 104_729) % 99_991).unwrap(),
            Coord::from_nm(k % 17).unwrap(),
        ];
        planner.push(&Block::rapid(to, k as u32)).unwrap();
        planner.finish();
        for _ in 0..100_000 {
            let progress = planner.settle();
            let setpoint = interpolator.tick();
            if progress == Progress::Done && setpoint.activity == Activity::Idle {
                for (axis, coord) in to.iter().enumerate() {
                    assert_eq!(setpoint.position_nm(axis), coord.to_nm(), "block {k}, axis {axis}");
                }
                stops += 1;
                break;
            }
        }
    }
    assert_eq!(stops, 3000);
}

/// Bytes of a whole core: both sides and what passes between them.
const fn bytes<S: splineway::Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>()
-> usize {
    size_of::<Link<S, N, BLOCKS, NODES>>() + size_of::<Planner<'static, S, N, BLOCKS, NODES>>()
}

/// A core for three axes that looks ahead over 128 dense lines and more: 45 KiB, jogs, probes and homing.
const SMALL: usize = bytes::<f32, 3, 8, 56>();
const SMALL_SIX: usize = bytes::<f32, 6, 8, 56>();
/// What the queues of outputs add, which a core without the feature has not.
const OUTPUTS: usize = 11 * 1024;
/// What motors add: eight of them in each of six sets of limits.
const MOTORS: usize = 6 * (8 * 48 + 8);
/// What input shaping adds: other limits in each of five sets, and what follows the setpoints.
const SHAPING: usize = 5 * size_of::<Limits<f32, 6>>() + 128;
const MORE: usize = OUTPUTS + MOTORS + SHAPING;
const _: () = assert!(SMALL <= 45 * 1024 + MORE && SMALL_SIX <= 68 * 1024 + MORE);

/// Bytes that one more block, and one more node, of the look-ahead take; limits of travel are in it.
const PER_BLOCK: usize = (bytes::<f32, 3, 16, 56>() - SMALL) / 8;
const PER_NODE: usize = (bytes::<f32, 3, 8, 64>() - SMALL) / 8;
const _: () = assert!(PER_BLOCK <= 192 && PER_NODE <= 376);

/// How many lines the small core holds before it starts: a circle in chords of 0.1 mm.
#[test]
fn the_small_core_looks_far_ahead() {
    let mut link = Box::new(Link::<f32, 3, 8, 56>::new());
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; 3]).unwrap());
    config.tolerance = 0.01;
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 3]).unwrap();
    let mut taken = 0u32;
    while taken < 1257 {
        let angle = f64::from(taken + 1) / 200.0;
        let to = at(20.0 * angle.sin(), 20.0 * (1.0 - angle.cos()), 0.0);
        match planner.push(&Block::line(to, 200.0, taken)) {
            Ok(()) => taken += 1,
            Err(PushError::Full) if planner.settle() == Progress::Planned => break,
            Err(PushError::Full) => {}
            Err(error) => panic!("{error}"),
        }
    }
    assert!(interpolator.tick().activity != Activity::Idle);
    assert!(taken > 128, "{taken} lines");
}

/// Right angles of lines of some mm, with a stop after so many servo cycles in motion, and no more than so many slices of planning in each: how far it
/// comes from there.
fn stop_after(cycles: usize, line: f64, slices: usize) -> f64 {
    const LINES: usize = 12;
    let mut config = config();
    let axis = AxisLimits::linear(200.0, 3000.0, 200_000.0);
    config.limits = Limits::new([axis; 3]).unwrap();
    let mut link = Box::new(Link::<f64, 3, BLOCKS, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, at(0.0, 0.0, 0.0)).unwrap();
    let controls = planner.controls();
    let mut corner = [0.0; 3];
    for k in 0..LINES {
        corner[k % 2] += line;
        planner.push(&Block::line(at(corner[0], corner[1], 0.0), 40.0, k as u32)).unwrap();
    }
    planner.finish();
    let (mut before, mut way, mut moved) = ([0.0; 3], 0.0, 0);
    for _ in 0..20_000 {
        if moved == cycles {
            controls.stop();
        }
        for _ in 0..slices {
            match planner.poll() {
                Progress::Held | Progress::Done if moved > cycles => return way,
                Progress::Planning => {}
                _ => break,
            }
        }
        let here = place(&interpolator.tick());
        let step = before.iter().zip(here).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        if moved > 0 || step > 0.0 {
            moved += 1;
        }
        if moved > cycles {
            way += step;
        }
        before = here;
    }
    panic!("the stop after {cycles} cycles is not answered");
}

/// A stop rests at the end of the block under way, or of the next where that is too near to brake for: no whole block is run that
/// could have been left out. Where planning takes time, hardly one more.
#[test]
fn a_stop_comes_at_the_end_of_the_block_under_way() {
    // What braking from 40 mm/s takes, and getting round a corner.
    const BRAKED: f64 = 1.0;
    for (slices, more) in [(10_000, [0.0; 2]), (2, [1.0; 2]), (1, [1.0, 2.0])] {
        for ((line, last, every), more) in [(15.0, 4300, 13), (3.0, 900, 3)].into_iter().zip(more) {
            let ways = (1..last).step_by(every).map(|cycles| stop_after(cycles, line, slices));
            let (mut farther, mut all) = (0, 0);
            for (way, cycles) in ways.zip((1..).step_by(every)) {
                let most = line * (1.0 + more) + BRAKED;
                assert!(way < most, "{way} mm of lines of {line} after {cycles} cycles");
                farther += usize::from(way > line + BRAKED);
                all += 1;
            }
            assert!(2 * farther < all, "{farther} of {all} stops, {slices} slices, {line} mm");
        }
    }
}
