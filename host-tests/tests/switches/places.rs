//! Where a switch in a corner comes, and the power from block to block.

use crate::common::{machine, soak};
use crate::run::{AXES, there};
use fastrand::Rng;
use splineway::{
    Activity, Block, Coord, Link, Output, Power, Progress, Scalar, Switch, SwitchError, Trigger,
};

/// The end of a block whose corner is rounded is in the middle of the rounding: on the line that halves the corner.
#[test]
fn the_middle_of_a_corner_stands_for_the_end_of_its_block() {
    for degrees in [20.0f64, 60.0, 90.0, 120.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let machine = machine(0.2, (1.0, 1.0), AXES);
        let mut link = Box::new(Link::<f64, AXES, 8, 56>::new());
        let (mut planner, mut interpolator) =
            link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
        let at = |x: f64, y: f64| [x, y, 0.0].map(|x| Coord::from_mm(x).unwrap());
        let corner = [10.0, 0.0];
        planner.push(&Block::line(at(10.0, 0.0), 50.0, 1)).unwrap();
        planner.push_switch(&Switch::digital(0, true)).unwrap();
        let end = at(10.0 + 10.0 * cos, 10.0 * sin);
        planner.push(&Block::line(end, 50.0, 2)).unwrap();
        planner.finish();
        let mut before = interpolator.tick();
        let mut place = None;
        for _ in 0..2000 {
            planner.settle();
            let after = interpolator.tick();
            interpolator.switch(&after, |switched| {
                place = Some(there((&before, &after), switched.fraction).1);
            });
            before = after;
        }
        let [x, y, _] = place.unwrap();
        let (x, y) = (x - corner[0], y - corner[1]);
        let along = x * (1.0 + cos) + y * sin;
        // Of a spline over lines that turn by little the place is known to a share of a cell.
        let most = if degrees < 80.0 { 0.02 } else { 5.0e-5 };
        assert!(along.abs() < most, "{degrees}: {along}");
        assert!(x.hypot(y) > 0.1, "{degrees}: not rounded, {x} {y}");
    }
}

/// A rapid, a cut, a rapid, a dwell that pierces, a cut; at every cycle the power is what the block asks for at its speed.
#[test]
fn power_goes_with_the_speed_and_is_off_in_rapids_and_at_rest() {
    let aborts = (1..800).step_by(53).map(Some).chain([None]);
    for (dynamic, abort) in aborts.flat_map(|abort| [(true, abort), (false, abort)]) {
        let machine = machine(0.05, (1.0, 1.0), AXES);
        let mut link = Box::new(Link::<f32, AXES, 16, 64>::new());
        let (mut planner, mut interpolator) =
            link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
        let at = |x: f64, y: f64| [x, y, 0.0].map(|x| Coord::from_mm(x).unwrap());
        let full = if dynamic {
            Power::in_proportion(800.0, 100.0, 1000.0)
        } else {
            Power::constant(800.0)
        };
        planner.set_power(&full).unwrap();
        planner.push(&Block::rapid(at(10.0, 0.0), 1)).unwrap();
        planner.push(&Block::line(at(20.0, 0.0), 100.0, 2)).unwrap();
        planner.push(&Block::line(at(20.0, 10.0), 50.0, 3)).unwrap();
        planner.push(&Block::rapid(at(30.0, 10.0), 4)).unwrap();
        planner.push_power(&Power::constant(300.0), 5).unwrap();
        planner.push(&Block::dwell(0.05, 6)).unwrap();
        planner.set_power(&full).unwrap();
        planner.push(&Block::line(at(40.0, 10.0), 100.0, 7)).unwrap();
        planner.push_switch(&Switch::digital(2, true).at(Trigger::End)).unwrap();
        planner.finish();
        let (mut seen, mut switched, mut aborted) = ([false; 8], 0, false);
        for cycle in 0..2000 {
            if abort == Some(cycle) {
                planner.controls().abort();
            }
            aborted |= planner.settle() == Progress::Aborted;
            let setpoint = interpolator.tick();
            let power = interpolator.switch(&setpoint, |event| {
                switched += u32::from(event.output == Output::Digital(2));
            });
            let speed = setpoint.path_speed;
            let cut = |feed: f32| {
                if dynamic { (800.0 / feed * speed).clamp(100.0, 1000.0) } else { 800.0 }
            };
            let wanted: &[f32] = match (setpoint.activity, setpoint.tag) {
                (Activity::Idle, _) | (Activity::Running, 1 | 4) => &[0.0],
                (Activity::Running, 2 | 7) => &[cut(100.0)],
                (Activity::Running, 3) => &[cut(50.0)],
                // From the event on that switches it on.
                (Activity::Event, _) | (_, 5 | 6) => &[300.0],
                other => panic!("{other:?}"),
            };
            // Where blocks meet, cells show the one while the cycle has switched to the other.
            let near = [cut(100.0), cut(50.0), 0.0];
            let joint = setpoint.activity == Activity::Running;
            let is = |wanted: &[f32]| wanted.iter().any(|w| (power - w).abs() < 0.01);
            assert!(is(wanted) || (joint && is(&near)), "{cycle} {power} {setpoint:?}");
            seen[setpoint.tag as usize & 7] |= is(wanted) && setpoint.activity != Activity::Idle;
            if aborted {
                assert!(power == 0.0);
            }
        }
        if abort.is_some() {
            // Late ones come when all has been run.
            assert!(aborted && (switched == 0 || abort > Some(500)));
            // Of what has been dropped nothing comes; what is pushed anew does.
            assert!(planner.acknowledge_abort());
            let [x, y] = [0, 1].map(|i| planner.end()[i].to_mm() + 5.0);
            planner.push(&Block::line(at(x, y), 100.0, 1)).unwrap();
            planner.push_switch(&Switch::digital(1, true).at(Trigger::End)).unwrap();
            planner.finish();
            let mut events = Vec::new();
            for _ in 0..1000 {
                planner.settle();
                let setpoint = interpolator.tick();
                let power = interpolator.switch(&setpoint, |event| events.push(event.output));
                assert!(power == 0.0);
            }
            assert_eq!(events, [Output::Digital(1)]);
        } else {
            assert_eq!(seen, [false, true, true, true, true, true, true, true]);
            assert_eq!(switched, 1);
        }
    }
}

/// The end of a dwell or an event is when the motion leaves it, or when nothing follows; times count from there, and no lead reaches behind it.
#[test]
fn the_end_of_a_standstill_comes_without_a_motion_behind_it() {
    let machine = machine(0.05, (1.0, 1.0), AXES);
    let at = |x: f64| [x, 0.0, 0.0].map(|x| Coord::from_mm(x).unwrap());
    for (event, follows) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut link = Box::new(Link::<f32, AXES, 16, 64>::new());
        let (mut planner, mut interpolator) =
            link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
        planner.push(&Block::line(at(10.0), 100.0, 1)).unwrap();
        planner.push(&if event { Block::event(2) } else { Block::dwell(0.05, 2) }).unwrap();
        let end = |output: u8| Switch::digital(output, true).at(Trigger::End);
        planner.push_switch(&end(0)).unwrap();
        planner.push_switch(&end(1).behind_s(0.0205)).unwrap();
        planner.push_switch(&end(2).behind_s(-0.5)).unwrap();
        planner.push_switch(&end(3).behind_mm(-5.0)).unwrap();
        if follows {
            planner.push(&Block::line(at(20.0), 100.0, 3)).unwrap();
        }
        planner.finish();
        let mut came = [None; 4];
        let (mut dwelt, mut tag, mut rests) = (0, 0, 0);
        for cycle in 0..2000 {
            planner.settle();
            let setpoint = interpolator.tick();
            dwelt += u32::from(setpoint.activity == Activity::Dwelling);
            if tag < 2 {
                rests = cycle;
            }
            let running = setpoint.activity == Activity::Running;
            assert!(setpoint.tag >= tag);
            tag = setpoint.tag;
            interpolator.switch(&setpoint, |switched| {
                let Output::Digital(output) = switched.output else { panic!() };
                assert!(came[usize::from(output)].is_none());
                came[usize::from(output)] =
                    Some((f64::from(cycle) + f64::from(switched.fraction), running));
            });
        }
        let came = came.map(Option::unwrap);
        assert!(event || dwelt >= 49, "{dwelt}");
        for now in [0, 2, 3] {
            assert_eq!(came[now].1, follows, "{came:?}");
            assert!(event || came[now].0 > f64::from(rests + dwelt), "{came:?}");
        }
        assert!((came[1].0 - came[0].0 - 20.5).abs() < 1.0e-3, "{came:?}");
        assert!((came[2].0 - came[0].0).abs() < 1.0e-3, "{came:?}");
    }
}

/// A power that has been taken back is off in what stands behind it: nothing at rest puts it on again.
#[test]
fn a_power_that_was_taken_back_stays_off_at_rest() {
    let machine = machine(0.05, (1.0, 1.0), AXES);
    let at = |x: f64| [x, 0.0, 0.0].map(|x| Coord::from_mm(x).unwrap());
    for (event, later, dynamic) in
        [(false, false, false), (false, true, false), (true, false, true), (false, true, true)]
    {
        let mut link = Box::new(Link::<f32, AXES, 16, 64>::new());
        let (mut planner, mut interpolator) =
            link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
        planner.set_power(&Power::constant(500.0)).unwrap();
        planner.push(&Block::line(at(10.0), 100.0, 1)).unwrap();
        let mut most = [0.0f32; 3];
        for cycle in 0..2000 {
            if cycle == (if later { 1000 } else { 0 }) {
                let less =
                    if dynamic { Power::in_proportion(500.0, 50.0, 500.0) } else { Power::OFF };
                planner.set_power(&less).unwrap();
                planner.push(&if event { Block::event(2) } else { Block::dwell(0.1, 2) }).unwrap();
            }
            planner.finish();
            planner.settle();
            let setpoint = interpolator.tick();
            let power = interpolator.switch(&setpoint, |_| {});
            let stands = matches!(setpoint.activity, Activity::Dwelling | Activity::Event);
            let kind = if stands { 2 } else { setpoint.tag as usize % 2 };
            most[kind] = most[kind].max(power);
        }
        assert_eq!(most.map(f32::to_bits), [0.0, 500.0, 0.0].map(f32::to_bits), "{event} {later}");
        // During an abort nothing is taken.
        planner.controls().abort();
        assert_eq!(planner.set_power(&Power::constant(1.0)), Err(SwitchError::Aborted));
    }
}

/// What begins with the next motion does not lead beyond what stands before that.
#[test]
fn a_start_never_leads_beyond_a_standstill() {
    let machine = machine(0.05, (1.0, 1.0), AXES);
    let at = |x: f64| [x, 0.0, 0.0].map(|x| Coord::from_mm(x).unwrap());
    for (before, event, time) in (0..8).map(|k| (k & 1 > 0, k & 2 > 0, k & 4 > 0)) {
        let mut link = Box::new(Link::<f32, AXES, 16, 64>::new());
        let (mut planner, mut interpolator) =
            link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
        planner.push(&Block::line(at(10.0), 50.0, 1)).unwrap();
        let start = Switch::digital(0, true);
        let start = if time { start.behind_s(-0.05) } else { start.behind_mm(-5.0) };
        let stand = if event { Block::event(2) } else { Block::dwell(0.1, 2) };
        if before {
            planner.push_switch(&start).unwrap();
        }
        planner.push(&stand).unwrap();
        if !before {
            planner.push_switch(&start).unwrap();
        }
        planner.push(&Block::line(at(20.0), 100.0, 3)).unwrap();
        planner.finish();
        let mut came = Vec::new();
        for _ in 0..2000 {
            planner.settle();
            let setpoint = interpolator.tick();
            interpolator.switch(&setpoint, |_| came.push((setpoint.tag, setpoint.activity)));
        }
        assert_eq!(came, [(3, Activity::Running)], "{before} {event} {time}");
    }
}

/// Where an output switches at the end of the second of three lines, of which the last two run straight on behind a corner: how far from there along
/// them, in tolerances.
fn off_at_a_straight_joint<S: Scalar>(
    [before, first, second]: [f64; 3],
    turn: f64,
    tolerance: f64,
) -> f64 {
    let machine = machine(tolerance, (1.0, 1.0), AXES);
    let mut link = Box::new(Link::<S, AXES, 16, 64>::new());
    let (mut planner, mut interpolator) =
        link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
    let (sin, cos) = turn.sin_cos();
    let along = |s: f64| [before + s * cos, s * sin, 0.0];
    let ends = [[before, 0.0, 0.0], along(first), along(first + second)];
    for (tag, end) in (1..).zip(ends) {
        let block = Block::line(end.map(|x| Coord::from_mm(x).unwrap()), S::of(100.0), tag);
        planner.push(&block).unwrap();
        if tag == 2 {
            planner.push_switch(&Switch::digital(0, true)).unwrap();
        }
    }
    planner.finish();
    let (mut last, mut off) = (interpolator.tick(), None);
    for _ in 0..20_000 {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        interpolator.switch(&setpoint, |switched| {
            let at = there((&last, &setpoint), switched.fraction.to_f64()).1;
            off = Some((at[0] - ends[1][0]) * cos + (at[1] - ends[1][1]) * sin);
        });
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            break;
        }
        last = setpoint;
    }
    off.unwrap().abs() / tolerance
}

/// Wherever a corner is smoothed, what belongs to the end of a block behind or before it switches within the tolerance of that.
#[test]
fn the_end_of_a_block_near_a_corner_is_where_it_is() {
    // Within the rounding of the corner.
    for lines in [[20.0, 8.0, 9.0], [20.0, 0.1, 10.0], [5.865, 7.863, 4.694]] {
        let right = std::f64::consts::FRAC_PI_2;
        assert!(off_at_a_straight_joint::<f64>(lines, right, 0.2) < 1.0, "{lines:?}");
        assert!(off_at_a_straight_joint::<f32>(lines, right, 0.2) < 1.0, "{lines:?}");
    }
    let mut draw = Rng::with_seed(5);
    for _ in 0..300 * soak() {
        let size = 0.3 * 60f64.powf(draw.f64());
        let lines = [0; 3].map(|_| (size * (0.3 + draw.f64()) * 1.0e3).round() / 1.0e3);
        let (turn, tolerance) = (3.0 * draw.f64(), 0.01 * 10f64.powf(draw.f64()));
        let off = if draw.bool() {
            off_at_a_straight_joint::<f64>(lines, turn, tolerance)
        } else {
            off_at_a_straight_joint::<f32>(lines, turn, tolerance)
        };
        assert!(off < 1.0, "{lines:?}, {turn}, {tolerance}: {off} tolerances");
    }
}

/// Between two standstills the power changes where the second begins, and no event of the program is taken for that.
#[test]
fn power_changes_between_two_standstills() {
    let machine = machine(0.05, (1.0, 1.0), AXES);
    let at = |x: f64| [x, 0.0, 0.0].map(|x| Coord::from_mm(x).unwrap());
    for (pierces, second, event) in
        [(true, 0.0, false), (true, 0.0, true), (false, 430.0, false), (false, 0.0, true)]
    {
        let mut link = Box::new(Link::<f32, AXES, 16, 64>::new());
        let (mut planner, mut interpolator) =
            link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
        if pierces {
            planner.push(&Block::line(at(2.0), 50.0, 1)).unwrap();
            planner.push_power(&Power::constant(149.0), 2).unwrap();
        } else {
            planner.set_power(&Power::constant(149.0)).unwrap();
            planner.push(&Block::line(at(2.0), 50.0, 1)).unwrap();
        }
        planner.push(&Block::dwell(0.1, 3)).unwrap();
        let power = if second > 0.0 { Power::constant(second) } else { Power::OFF };
        planner.set_power(&power).unwrap();
        planner.push(&if event { Block::event(4) } else { Block::dwell(0.1, 4) }).unwrap();
        // The same once more: no change.
        planner.push(&Block::dwell(0.1, 5)).unwrap();
        planner.finish();
        let (mut powers, mut events) = ([const { Vec::new() }; 3], Vec::new());
        for _ in 0..1000 {
            planner.settle();
            let setpoint = interpolator.tick();
            let power = interpolator.switch(&setpoint, |_| {});
            match (setpoint.activity, setpoint.tag) {
                (Activity::Dwelling, tag @ 3..=5) => powers[tag as usize - 3].push(power),
                (Activity::Event, tag) => events.push(tag),
                _ => {}
            }
        }
        let held = |powers: &[f32], level: f32| {
            powers.iter().all(|power| power.to_bits() == level.to_bits())
        };
        let [a, b, c] = &powers;
        // The second cycle of an event shows its tag, too.
        let a = if event { a } else { &a[..a.len() - 1] };
        assert!(a.len() > 95 && held(a, 149.0), "{pierces} {second} {event}: {a:?}");
        assert!(held(b, second) && held(c, second), "{pierces} {second} {event}: {b:?} {c:?}");
        let expected: &[u32] = match (pierces, event) {
            (true, true) => &[2, 4],
            (true, false) => &[2, 3],
            (false, true) => &[4],
            (false, false) => &[3],
        };
        assert_eq!(events, expected);
    }
}

/// A power that has gone off because nothing was there to be run does not come on in a dwell that comes late; one that is put on for it does, and what
/// is left of a dwell behind a hold has what it had.
#[test]
fn a_dwell_that_comes_late_does_not_put_power_on() {
    let machine = machine(0.05, (1.0, 1.0), AXES);
    let at = |x: f64| [x, 0.0, 0.0].map(|x| Coord::from_mm(x).unwrap());
    for (late, pierces, event) in [
        (false, false, false),
        (true, false, false),
        (true, true, false),
        (false, true, false),
        (true, false, true),
        (false, false, true),
    ] {
        let mut link = Box::new(Link::<f32, AXES, 16, 64>::new());
        let (mut planner, mut interpolator) =
            link.split(machine.config(&[0, 1, 2]).unwrap(), [Coord::ZERO; AXES]).unwrap();
        let controls = planner.controls();
        planner.set_power(&Power::constant(500.0)).unwrap();
        planner.push(&Block::line(at(10.0), 100.0, 1)).unwrap();
        let (mut dwelled, mut burned, mut held) = (0, 0, None);
        for cycle in 0..3000 {
            if cycle == (if late { 1000 } else { 0 }) {
                if pierces {
                    planner.push_power(&Power::constant(300.0), 2).unwrap();
                }
                planner.push(&if event { Block::event(3) } else { Block::dwell(0.2, 3) }).unwrap();
                planner.push(&Block::line(at(20.0), 100.0, 4)).unwrap();
            }
            planner.finish();
            planner.settle();
            let setpoint = interpolator.tick();
            let power = interpolator.switch(&setpoint, |_| {});
            if matches!(setpoint.activity, Activity::Dwelling | Activity::Event) {
                dwelled += 1;
                burned += u32::from(power > 0.0);
                if dwelled == 100 {
                    controls.hold();
                    held = Some(cycle);
                }
            } else {
                assert!(power == 0.0 || setpoint.activity == Activity::Running, "{setpoint:?}");
            }
            if held.is_some_and(|held| cycle == held + 200) {
                controls.resume();
            }
        }
        let lit = pierces || !late;
        let name = format!("late {late}, pierces {pierces}, event {event}: {burned} of {dwelled}");
        assert!(dwelled >= if event { 1 } else { 195 }, "{name}");
        assert!(burned == 0 || lit, "{name}");
        assert!(!lit || burned + 5 > dwelled, "{name}");
    }
}
