//! An operator's commands, at every moment, against every limit.

mod common;

use common::{Draw, config, dense, draws, judged, machine, program, stretches};
use proptest::prelude::*;
use splineway::{
    Activity, AxisLimits, Block, Config, Controls, Coord, Feed, Limits, Link, Progress, PushError,
    Setpoint,
};
use splineway_simulator::judge::violations;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::Program;
use splineway_simulator::run::{Action, Command, Event, Events, Precision, run_with};
use splineway_trials::events;

/// One random command: when (as a share of the time), which, how much.
fn commands() -> impl Strategy<Value = Vec<(f64, u8, u16)>> {
    prop::collection::vec((0.0f64..1.0, 0u8..16, 0u16..=200), 1..12)
}

fn check(
    (draws, axes): (&[Draw], &[usize]),
    machine: &Machine,
    precision: Precision,
    commands: &[(f64, u8, u16)],
) -> Result<(), TestCaseError> {
    check_program(&program(draws, axes), machine, precision, commands)
}

fn check_program(
    program: &Program,
    machine: &Machine,
    precision: Precision,
    commands: &[(f64, u8, u16)],
) -> Result<(), TestCaseError> {
    let (plain, _) = judged(program, machine, precision, &Events::default());
    let events = events(commands, plain.time * 1.5);
    let (mut verdict, stats) = judged(program, machine, precision, &events);
    if stats.aborted {
        verdict.end_error = 0.0;
    }
    let broken = violations(&verdict);
    prop_assert!(broken.is_empty(), "{broken:?} {:?}", events.list());
    Ok(())
}

proptest! {
    #![proptest_config(config(800))]

    #[test]
    fn three_axes_in_f64(
        draws in draws(3, 1..14),
        tolerance in (-3.0f64..0.5).prop_map(|e| 10f64.powf(e)),
        scale in ((-1.0f64..1.0).prop_map(|e| 10f64.powf(e)), (-1.0f64..1.0).prop_map(|e| 10f64.powf(e))),
        commands in commands(),
    ) {
        check((&draws, &[0, 1, 2]), &machine(tolerance, scale, 3), Precision::F64, &commands)?;
    }
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn dense_programs_in_f64(
        stretches in stretches(1..8),
        tolerance in (-3.0f64..0.0).prop_map(|e| 10f64.powf(e)),
        commands in commands(),
    ) {
        let machine = machine(tolerance, (1.0, 1.0), 3);
        check_program(&dense(&stretches), &machine, Precision::F64, &commands)?;
    }

    #[test]
    fn dense_programs_in_f32(
        stretches in stretches(1..8),
        tolerance in (-2.5f64..-0.5).prop_map(|e| 10f64.powf(e)),
        commands in commands(),
    ) {
        let machine = machine(tolerance, (1.0, 1.0), 3);
        check_program(&dense(&stretches), &machine, Precision::F32, &commands)?;
    }
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn three_axes_in_f32(
        draws in draws(3, 1..14),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
        commands in commands(),
    ) {
        check((&draws, &[0, 1, 2]), &machine(tolerance, (1.0, 1.0), 3), Precision::F32, &commands)?;
    }

    #[test]
    fn six_axes(draws in draws(6, 1..8), commands in commands()) {
        let axes: Vec<usize> = (0..6).collect();
        check((&draws, &axes), &machine(0.02, (1.0, 1.0), 6), Precision::F64, &commands)?;
    }
}

fn axis() -> AxisLimits<f64> {
    AxisLimits::linear(200.0, 2000.0, 50_000.0)
}

fn setting() -> Config<f64, 2> {
    let mut config = Config::new(Limits::new([axis(); 2]).unwrap());
    config.tolerance = 0.05;
    config
}

fn at(x: f64, y: f64) -> [Coord; 2] {
    [Coord::from_mm(x).unwrap(), Coord::from_mm(y).unwrap()]
}

/// Runs blocks until `then` says stop; it sees the cycle's number, the planner's last word and the
/// setpoint, and may give commands.
fn drive(
    blocks: &[Block<f64, 2>],
    mut then: impl FnMut(u32, Progress, &Setpoint<f64, 2>, Controls<'_>) -> bool,
) {
    let mut link = Box::new(Link::<f64, 2, 64, 192>::new());
    let (mut planner, mut interpolator) = link.split(setting(), at(0.0, 0.0)).unwrap();
    for block in blocks {
        planner.push(block).unwrap();
    }
    planner.finish();
    let controls = planner.controls();
    for cycle in 0..60_000 {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        if !then(cycle, progress, &setpoint, controls) {
            return;
        }
    }
    panic!("the run did not end");
}

fn speeds(blocks: &[Block<f64, 2>], mut command: impl FnMut(u32, Controls<'_>)) -> Vec<f64> {
    let mut speeds = Vec::new();
    drive(blocks, |cycle, progress, setpoint, controls| {
        speeds.push(setpoint.path_speed);
        command(cycle, controls);
        let idle = setpoint.activity == Activity::Idle;
        !(idle && matches!(progress, Progress::Done | Progress::Held) && cycle > 1300)
    });
    speeds
}

/// At 100 mm/s on a line: a hold changes the very next setpoint, and the stop takes no longer than
/// four-jerk-phase braking needs, v / A + A / J, within a tenth.
#[test]
fn a_hold_brakes_in_the_next_cycle() {
    let blocks = [Block::line(at(300.0, 0.0), 100.0, 1)];
    let plain = speeds(&blocks, |_, _| {});
    let held = speeds(&blocks, |cycle, controls| {
        if cycle == 999 {
            controls.hold();
        }
        if cycle == 1300 {
            controls.resume();
        }
    });
    assert_eq!(plain[..1000], held[..1000]);
    assert!(held[1000] < plain[1000], "{} and {}", held[1000], plain[1000]);
    let rest = held[1000..].iter().position(|v| *v == 0.0).unwrap();
    assert!(rest as f64 <= 1.1 * 90.0, "{rest} cycles to rest");
    assert!(held[1400..].iter().any(|v| *v > 99.0));
}

/// Lowering the feed shows within two cycles, raising it within twenty milliseconds, and both are
/// reached as fast as the limits allow, about.
#[test]
fn overrides_take_effect_at_once() {
    let blocks = [Block::line(at(400.0, 0.0), 100.0, 1)];
    let speeds = speeds(&blocks, |cycle, controls| match cycle {
        999 => controls.feed_override(50),
        1499 => controls.feed_override(180),
        _ => {}
    });
    assert!(speeds[1001] < speeds[999] - 0.02, "{:?}", &speeds[998..1003]);
    // 50 mm/s by jerk alone: 2 sqrt(50 / J) = 63 ms.
    assert!(speeds[1066..1499].iter().all(|v| *v < 50.0 && *v > 44.0), "{:?}", &speeds[1060..1100]);
    assert!(speeds[1200] > 49.5, "{}", speeds[1200]);
    assert!(speeds[1519] > speeds[1499] + 0.02, "{:?}", &speeds[1498..1520]);
    assert!(speeds[1700] > 178.0, "{}", speeds[1700]);
    assert!(speeds.iter().all(|v| *v <= 180.0));
}

/// A rapid keeps its own override, a feed move is not touched by it.
#[test]
fn rapids_have_an_override_of_their_own() {
    let line = |x: f64, tag| Block::line(at(x, 0.0), 50.0, tag);
    let blocks = [Block { feed: Feed::Rapid, ..line(80.0, 1) }, line(120.0, 2)];
    let mut most = [0.0f64; 3];
    drive(&blocks, |cycle, progress, setpoint, controls| {
        if cycle == 0 {
            controls.rapid_override(25);
        }
        let tag = setpoint.tag as usize;
        most[tag] = most[tag].max(setpoint.path_speed);
        !(progress == Progress::Done && setpoint.activity == Activity::Idle)
    });
    assert!(most[1] <= 50.5 && most[1] > 48.0, "{most:?}");
    assert!(most[2] <= 50.5 && most[2] > 48.0, "{most:?}");
}

/// Single block: one rest per block, at its end, until resumed.
#[test]
fn single_block_rests_at_every_end() {
    let blocks: Vec<_> = (1..=4)
        .map(|n: u32| {
            let (x, y) = (f64::from(n.div_ceil(2)) * 10.0, f64::from(n / 2) * 10.0);
            Block::line(at(x, y), 100.0, n)
        })
        .collect();
    let mut rests = Vec::new();
    drive(&blocks, |cycle, progress, setpoint, controls| {
        if cycle == 0 {
            controls.single_block(true);
        }
        let idle = setpoint.activity == Activity::Idle;
        if progress == Progress::Held && idle {
            rests.push((setpoint.tag, setpoint.position_mm(0), setpoint.position_mm(1)));
            controls.resume();
        }
        !(progress == Progress::Done && idle)
    });
    assert_eq!(rests.iter().map(|rest| rest.0).collect::<Vec<_>>(), [1, 2, 3, 4], "{rests:?}");
    for (n, (_, x, y)) in rests.iter().enumerate() {
        let n = n as u32 + 1;
        let off = (x - f64::from(n.div_ceil(2)) * 10.0).hypot(y - f64::from(n / 2) * 10.0);
        assert!(off < 0.11, "rest {n} is {off} mm off the block's end");
    }
}

/// A stop finishes the block under way.
#[test]
fn a_stop_finishes_the_block() {
    let blocks = [Block::line(at(60.0, 0.0), 50.0, 1), Block::line(at(60.0, 60.0), 50.0, 2)];
    let mut rest = None;
    drive(&blocks, |cycle, progress, setpoint, controls| {
        if cycle == 400 {
            controls.stop();
        }
        if progress == Progress::Held && setpoint.activity == Activity::Idle {
            rest.get_or_insert((setpoint.tag, setpoint.position_mm(0)));
            controls.resume();
        }
        !(progress == Progress::Done && setpoint.activity == Activity::Idle)
    });
    let (tag, x) = rest.unwrap();
    assert!(tag == 1 && (x - 60.0).abs() < 0.1, "tag {tag} at {x}");
}

/// After an abort the core knows to a nanometre where it stands, and goes on from there.
#[test]
fn an_abort_drops_the_queue_and_knows_the_position() {
    let mut link = Box::new(Link::<f32, 2, 64, 192>::new());
    let narrow = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let config = Config::<f32, 2>::new(Limits::new([narrow; 2]).unwrap());
    let (mut planner, mut interpolator) = link.split(config, at(0.0, 0.0)).unwrap();
    for n in 1..=20 {
        planner.push(&Block::line(at(f64::from(n) * 5.0, f64::from(n % 2)), 100.0, n)).unwrap();
    }
    let controls = planner.controls();
    let mut setpoint = interpolator.tick();
    for cycle in 0.. {
        if cycle == 500 {
            controls.abort();
            assert_eq!(planner.push(&Block::line(at(1.0, 1.0), 1.0, 99)), Err(PushError::Aborted));
            assert!(!planner.acknowledge_abort());
        }
        if planner.settle() == Progress::Aborted {
            break;
        }
        setpoint = interpolator.tick();
        assert!(cycle < 2000);
    }
    assert_eq!(planner.blocks_waiting(), 0);
    for (axis, end) in planner.end().iter().enumerate() {
        assert!((end.to_nm() - setpoint.position_nm(axis)).abs() <= 1, "axis {axis}");
    }
    assert!(planner.acknowledge_abort());
    planner.push(&Block::line(at(0.0, 0.0), 100.0, 100)).unwrap();
    planner.finish();
    loop {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            assert_eq!(setpoint.tag, 100);
            assert!(setpoint.position_nm(0).abs() <= 1 && setpoint.position_nm(1).abs() <= 1);
            break;
        }
    }
}

/// A planner that answers late is refused, tries again with more time, and nothing is disturbed.
#[test]
fn late_answers_are_refused_and_repeated() {
    let mut link = Box::new(Link::<f64, 2, 64, 192>::new());
    let (mut planner, mut interpolator) = link.split(setting(), at(0.0, 0.0)).unwrap();
    planner.push(&Block::line(at(300.0, 0.0), 100.0, 1)).unwrap();
    planner.finish();
    let controls = planner.controls();
    let mut positions = vec![0.0; 3];
    let mut held = false;
    for cycle in 0..3000 {
        if cycle == 600 {
            controls.hold();
        }
        // Other work keeps the background busy: it plans every third cycle only, and the interrupt
        // comes in between at the worst time.
        if cycle % 3 == 0 {
            held |= planner.settle() == Progress::Held;
        }
        let setpoint = interpolator.tick();
        positions.push(setpoint.position_mm(0));
        let [.., a, b, c, d] = positions[..] else { unreachable!() };
        let jerk = (d - 3.0 * c + 3.0 * b - a) / 1.0e-9;
        assert!(jerk.abs() < 50_050.0, "{jerk} at {cycle}");
    }
    assert!(held);
}

/// Records the speed along the path at every cycle.
#[derive(Default)]
struct Speeds(Vec<f64>);

impl splineway_simulator::run::Observer for Speeds {
    fn setpoint(&mut self, sample: &splineway_simulator::run::Sample<'_>) -> anyhow::Result<()> {
        self.0.push(sample.velocity.iter().map(|v| v * v).sum::<f64>().sqrt());
        Ok(())
    }
}

proptest! {
    #![proptest_config(config(400))]

    /// Whatever the path, a hold at any moment comes to rest about as soon as braking takes: of 400
    /// the median was 0.7 times v / A + A / J, the 97th per cent 2, the longest 5; of 4,000 the
    /// longest was 8.
    #[test]
    fn holds_are_short(
        draws in draws(3, 1..14),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
        when in 0.0f64..1.0,
    ) {
        let (program, machine) = (program(&draws, &[0, 1, 2]), machine(tolerance, (1.0, 1.0), 3));
        let mut plain = Speeds::default();
        run_with(&program, &machine, Precision::F64, &Events::default(), &mut [&mut plain]).unwrap();
        let cycle = (when * plain.0.len() as f64) as usize;
        let time = cycle as f64 * machine.cycle;
        let events = Events::new(vec![
            Event { time, action: Action::Command(Command::Hold) },
            Event { time: time + 3.0, action: Action::Command(Command::Resume) },
        ]);
        let mut held = Speeds::default();
        run_with(&program, &machine, Precision::F64, &events, &mut [&mut held]).unwrap();
        let limits = machine.axes_of(&program).unwrap();
        let least = |of: fn(&splineway_simulator::machine::Axis) -> f64| {
            limits.iter().map(of).fold(f64::INFINITY, f64::min)
        };
        let (acceleration, jerk) = (least(|a| a.acceleration), least(|a| a.jerk));
        let speed = held.0.get(cycle).copied().unwrap_or(0.0);
        let braking = speed / acceleration + acceleration / jerk;
        let rest = held.0[cycle.min(held.0.len() - 1)..].iter().position(|v| *v == 0.0).unwrap();
        let rest = rest as f64 * machine.cycle;
        prop_assert!(rest <= 15.0 * braking, "{rest} s to rest from {speed} mm/s");
    }
}

/// Planner, interrupt and operator in three threads, none waiting for another: answers come at
/// odd moments, some too late. Whatever the interleaving, no limit is broken and no block lost.
#[test]
fn three_contexts() {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;
    let mut link = Box::new(Link::<f64, 2, 64, 192>::new());
    let (mut planner, mut interpolator) = link.split(setting(), at(0.0, 0.0)).unwrap();
    let controls = planner.controls();
    let (ran, done) = (AtomicBool::new(false), AtomicBool::new(false));
    let setpoints = std::thread::scope(|scope| {
        let servo = scope.spawn(|| {
            let mut setpoints = vec![[0.0; 2]; 3];
            while !done.load(Ordering::Acquire) {
                let setpoint = interpolator.tick();
                setpoints.push([0, 1].map(|axis| setpoint.position_mm(axis)));
                std::thread::sleep(Duration::from_micros(60));
            }
            setpoints
        });
        scope.spawn(|| {
            for round in 0u16.. {
                if ran.load(Ordering::Acquire) {
                    break;
                }
                match round % 6 {
                    0 => controls.hold(),
                    2 => controls.feed_override(20 + round % 180),
                    3 => controls.stop(),
                    4 => controls.rapid_override(50),
                    _ => controls.resume(),
                }
                std::thread::sleep(Duration::from_micros(1700 + 137 * u64::from(round % 7)));
            }
            // Let it run out.
            while !done.load(Ordering::Acquire) {
                controls.resume();
                std::thread::sleep(Duration::from_millis(5));
            }
        });
        let started = std::time::Instant::now();
        for n in 1..=200u32 {
            let (x, y) = (f64::from(n) * 2.0, f64::from(n % 2) * 3.0);
            while let Err(error) = planner.push(&Block::line(at(x, y), 150.0, n)) {
                assert_eq!(error, PushError::Full);
                planner.settle();
                ran.store(started.elapsed() > Duration::from_millis(1500), Ordering::Release);
            }
        }
        planner.finish();
        while planner.settle() != Progress::Done {
            ran.store(started.elapsed() > Duration::from_millis(1500), Ordering::Release);
            std::thread::yield_now();
        }
        done.store(true, Ordering::Release);
        servo.join().unwrap()
    });
    for axis in 0..2 {
        for (k, p) in setpoints.windows(4).enumerate() {
            let p = [p[0][axis], p[1][axis], p[2][axis], p[3][axis]];
            let jerk = (p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0]) / 1.0e-9;
            let acceleration = (p[3] - 2.0 * p[2] + p[1]) / 1.0e-6;
            assert!(jerk.abs() < 50_050.0, "{jerk} mm/s3 on axis {axis} at {k}");
            assert!(acceleration.abs() < 2002.0, "{acceleration} mm/s2 on axis {axis} at {k}");
        }
    }
    let last = setpoints[setpoints.len() - 1];
    assert!((last[0] - 400.0).abs() < 1e-6 && last[1].abs() < 1e-6, "{last:?}");
}

/// A producer that pushes whatever happens, as long as the core takes blocks.
struct Eager<'a> {
    planner: splineway::Planner<'a, f64, 2, 8, 56>,
    interpolator: splineway::Interpolator<'a, f64, 2>,
    next: u32,
}

impl Eager<'_> {
    fn cycle(&mut self) -> (Progress, Setpoint<f64, 2>) {
        loop {
            let (x, y) = (f64::from(self.next) * 5.0, f64::from(self.next % 2));
            match self.planner.push(&Block::line(at(x, y), 100.0, self.next)) {
                Ok(()) => self.next += 1,
                Err(PushError::Full | PushError::Aborted) => break,
                Err(error) => panic!("{error}"),
            }
        }
        (self.planner.settle(), self.interpolator.tick())
    }
}

/// However eager the producer is, nothing moves after an abort until it has said that it knows.
#[test]
fn an_abort_latches() {
    let mut link = Box::new(Link::<f64, 2, 8, 56>::new());
    let (planner, interpolator) = link.split(setting(), at(0.0, 0.0)).unwrap();
    let controls = planner.controls();
    let mut core = Eager { planner, interpolator, next: 1 };
    for _ in 0..300 {
        core.cycle();
    }
    controls.abort();
    core.planner.finish();
    assert!(core.planner.is_aborted() && !core.planner.acknowledge_abort());
    let mut progress = Progress::Waiting;
    for _ in 0..300 {
        progress = core.cycle().0;
    }
    assert_eq!(progress, Progress::Aborted);
    let (_, rest) = core.cycle();
    for _ in 0..2000 {
        let (progress, setpoint) = core.cycle();
        assert_eq!((progress, setpoint.activity), (Progress::Aborted, Activity::Idle));
        assert_eq!(setpoint.position_nm(0), rest.position_nm(0));
    }
    // Pressed once more: that one is complete at the next poll, and wants its own word.
    controls.abort();
    assert!(!core.planner.acknowledge_abort());
    assert_eq!(core.planner.push(&Block::rapid(at(0.0, 0.0), 9)), Err(PushError::Aborted));
    assert_eq!(core.planner.settle(), Progress::Aborted);
    assert!(core.planner.acknowledge_abort() && !core.planner.acknowledge_abort());
    assert!(!core.planner.is_aborted());
    assert_eq!(core.planner.settle(), Progress::NeedsBlocks);
    core.planner.push(&Block::rapid(at(0.0, 0.0), 1000)).unwrap();
    core.planner.finish();
    while core.planner.settle() != Progress::Done {
        core.interpolator.tick();
    }
}

/// A hold or a stop pressed after an abort is in force when that is over; one pressed before is not.
#[test]
fn what_is_pressed_after_an_abort_stays_in_force() {
    let presses: [fn(Controls<'_>); 2] = [|controls| controls.hold(), |controls| controls.stop()];
    for press in presses {
        for (before, after) in [(true, false), (false, true), (true, true)] {
            for when in [1, 5, 30, 60, 100, 300] {
                let mut link = Box::new(Link::<f64, 2, 8, 56>::new());
                let (planner, interpolator) = link.split(setting(), at(0.0, 0.0)).unwrap();
                let controls = planner.controls();
                let mut core = Eager { planner, interpolator, next: 1 };
                for _ in 0..300 {
                    core.cycle();
                }
                if before {
                    press(controls);
                }
                controls.abort();
                for cycle in 0..400 {
                    if after && cycle == when {
                        press(controls);
                    }
                    core.cycle();
                }
                assert!(core.planner.acknowledge_abort());
                core.next = 1;
                let states: Vec<_> = (0..100).map(|_| core.cycle()).collect();
                let held = states.iter().any(|(progress, _)| *progress == Progress::Held);
                let moved = states.iter().any(|(_, at)| at.activity == Activity::Running);
                assert_eq!((held, moved), (after, !after), "{before} {after} {when}");
                controls.resume();
                assert!((0..100).any(|_| core.cycle().1.activity == Activity::Running));
            }
        }
    }
}

/// However stop and resume fall about the rest at a block's end, the last of them counts.
#[test]
fn no_stop_is_lost() {
    let blocks: Vec<_> =
        (1..=4u32).map(|n| Block::line(at(f64::from(n) * 5.0, 0.0), 100.0, n)).collect();
    for again in 0..160 {
        let mut moved_after = false;
        let mut held = 0;
        drive(&blocks, |cycle, progress, setpoint, controls| {
            if cycle == 20 {
                controls.stop();
            }
            if cycle == 20 + again {
                // Between two polls, as an interrupt would.
                controls.resume();
                controls.stop();
            }
            if cycle > 700 + again {
                held += u32::from(progress == Progress::Held);
                moved_after |= setpoint.activity == Activity::Running;
            }
            cycle < 900 + again
        });
        assert!(held > 190 && !moved_after, "{again}: held {held}, moved {moved_after}");
    }
}
