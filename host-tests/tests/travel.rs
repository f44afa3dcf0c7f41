//! Limits of travel: what would leave them is refused whole, and what is taken stays inside.

mod common;

use common::{Draw, check, config, draws, machine, program};
use proptest::prelude::*;
use splineway::block::{BlockError, FINEST_BAND};
use splineway::{
    Activity, AxisLimits, AxisTravel, Block, Config, Coord, Limits, Link, Motion, Planner,
    Progress, PushError, Scalar, Travel, Turn,
};
use splineway_simulator::machine::{Ends, Machine};
use splineway_simulator::program::{Course, Program, ReadOptions, inspect_bytes};
use splineway_simulator::run::{Observer, Precision, Sample, run, validate};

/// Where a corner is rounded, a motion that rests or starts within it leaves it by this share of the tolerance.
const CORNER_REST: f64 = 0.04;
const LETTERS: [&str; 9] = ["X", "Y", "Z", "A", "B", "C", "U", "V", "W"];

/// Least and greatest coordinates of a program's curves, by points so dense that nothing is missed but 1e-7 mm.
fn bounds(program: &Program) -> Vec<(f64, f64)> {
    let mut here = program.start;
    let mut bounds = vec![(0.0, 0.0); 9];
    let mut see = |point: &[f64; 9]| {
        for (bound, x) in bounds.iter_mut().zip(point) {
            *bound = (f64::min(bound.0, *x), f64::max(bound.1, *x));
        }
    };
    see(&here);
    for step in &program.moves {
        let Some(&to) = step.path.end() else { continue };
        match &step.path {
            Course::Arc { plane: (p, q), centre, clockwise, .. } => {
                let angle = |point: &[f64; 9]| (point[*q] - centre.1).atan2(point[*p] - centre.0);
                let radius = (here[*p] - centre.0).hypot(here[*q] - centre.1);
                let whole = std::f64::consts::TAU;
                let sweep = (angle(&to) - angle(&here)).rem_euclid(whole);
                let sweep = if *clockwise { sweep - whole } else { sweep };
                for k in 0..=40_000 {
                    let at = angle(&here) + sweep * f64::from(k) / 40_000.0;
                    let mut point = here;
                    point[*p] = centre.0 + radius * at.cos();
                    point[*q] = centre.1 + radius * at.sin();
                    see(&point);
                }
            }
            Course::Cubic { controls: [a, b], to } => {
                for k in 0..=40_000 {
                    let u = f64::from(k) / 40_000.0;
                    let v = 1.0 - u;
                    let point = std::array::from_fn(|i| {
                        let (near, far) =
                            (v * here[i] + 3.0 * u * a[i], 3.0 * v * b[i] + u * to[i]);
                        v * v * near + u * u * far
                    });
                    see(&point);
                }
            }
            _ => {}
        }
        see(&to);
        here = to;
    }
    bounds
}

/// Limits on some axes.
fn limited(machine: &Machine, bounds: &[(f64, f64)]) -> Machine {
    let ends =
        |&(least, greatest): &(f64, f64)| Ends { least: Some(least), greatest: Some(greatest) };
    let travel = LETTERS.iter().zip(bounds).map(|(letter, bound)| ((*letter).into(), ends(bound)));
    Machine { travel: travel.collect(), ..machine.clone() }
}

/// How far the motion leaves the bounds, mm.
struct Excess<'a> {
    bounds: &'a [(f64, f64)],
    most: f64,
}

impl Observer for Excess<'_> {
    fn setpoint(&mut self, sample: &Sample<'_>) -> anyhow::Result<()> {
        for (x, bound) in sample.position.iter().zip(self.bounds) {
            self.most = self.most.max(x - bound.1).max(bound.0 - x);
        }
        Ok(())
    }
}

fn excess(
    program: &Program,
    machine: &Machine,
    precision: Precision,
    bounds: &[(f64, f64)],
) -> f64 {
    let mut excess = Excess { bounds, most: 0.0 };
    run(program, machine, precision, &mut [&mut excess]).unwrap();
    excess.most
}

/// A program in limits that it touches on every side: taken, inside, and within all other limits; in limits that are
/// a little tighter on one side it is refused, by the letter of that axis.
fn touches(draws: &[Draw], tolerance: f64, precision: Precision) -> Result<(), TestCaseError> {
    let program = program(draws, &[0, 1, 2]);
    let plain = machine(tolerance, (1.0, 1.0), 3);
    let bounds: Vec<_> =
        bounds(&program).iter().map(|(least, most)| (least - 5e-7, most + 5e-7)).collect();
    let tight = limited(&plain, &bounds[..3]);
    let findings = validate(&program, &tight);
    prop_assert!(findings.is_empty(), "{findings:?}");
    let off = excess(&program, &tight, precision, &bounds);
    let allowed = FINEST_BAND + CORNER_REST * tolerance;
    prop_assert!(off <= allowed, "{off} mm beyond at a tolerance of {tolerance}");
    check(&program, &tight, precision)?;
    for side in 0..6 {
        let mut less = bounds.clone();
        let axis = side / 2;
        if side % 2 == 0 {
            less[axis].0 += 5e-6;
        } else {
            less[axis].1 -= 5e-6;
        }
        let at_start = if side % 2 == 0 { less[axis].0 > 0.0 } else { less[axis].1 < 0.0 };
        if at_start || less[axis].0 > less[axis].1 {
            // It begins there: nothing leads further out.
            continue;
        }
        let findings = validate(&program, &limited(&plain, &less[..3]));
        let named = format!("{} would go to", LETTERS[axis]);
        prop_assert!(findings.iter().any(|finding| finding.message.contains(&named)), "{side}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(120))]

    #[test]
    fn what_is_taken_stays_inside_in_f64(
        draws in draws(3, 1..14),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
    ) {
        touches(&draws, tolerance, Precision::F64)?;
    }

    #[test]
    fn what_is_taken_stays_inside_in_f32(
        draws in draws(3, 1..14),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
    ) {
        touches(&draws, tolerance, Precision::F32)?;
    }
}

fn mm(mm: f64) -> Coord {
    Coord::from_mm(mm).unwrap()
}

fn at(x: f64, y: f64) -> [Coord; 2] {
    [mm(x), mm(y)]
}

fn travel(x: (f64, f64), y: (f64, f64)) -> Travel<2> {
    let ends =
        |(least, greatest)| AxisTravel { least: Some(mm(least)), greatest: Some(mm(greatest)) };
    Travel::new([ends(x), ends(y)]).unwrap()
}

fn setting<S: Scalar>() -> Config<S, 2> {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(5.0e4));
    let mut config = Config::new(Limits::new([axis; 2]).unwrap());
    config.tolerance = S::of(0.05);
    config
}

fn line<S: Scalar>(x: f64, y: f64, tag: u32) -> Block<S, 2> {
    Block::line(at(x, y), S::of(100.0), tag)
}

fn arc<S: Scalar>(to: [Coord; 2], centre: [Coord; 2], tag: u32) -> Block<S, 2> {
    let motion = Motion::Arc {
        to,
        plane: (0, 1),
        centre: (centre[0], centre[1]),
        turn: Turn::CounterClockwise,
        extra_turns: 0,
    };
    Block { motion, ..line(0.0, 0.0, tag) }
}

/// Pushes, ticking where there is no room.
fn push<S: Scalar>(
    planner: &mut Planner<'_, S, 2, 16, 64>,
    block: &Block<S, 2>,
    mut tick: impl FnMut(),
) -> Result<(), PushError> {
    loop {
        match planner.push(block) {
            Err(PushError::Full) => {
                planner.settle();
                tick();
            }
            result => return result,
        }
    }
}

/// Every setpoint of a program, nm; blocks that are refused for travel are left out, and counted.
fn setpoints<S: Scalar>(
    config: Config<S, 2>,
    start: [Coord; 2],
    blocks: &[Block<S, 2>],
) -> (Vec<[i64; 2]>, Vec<u32>) {
    let mut link = Box::new(Link::<S, 2, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(config, start).unwrap();
    let (mut places, mut refused) = (Vec::new(), Vec::new());
    for block in blocks {
        let end = *planner.end();
        let result = push(&mut planner, block, || {
            let setpoint = interpolator.tick();
            places.push([setpoint.position_nm(0), setpoint.position_nm(1)]);
        });
        if let Err(error) = result {
            let PushError::Rejected { tag, reason: BlockError::Travel { .. } } = error else {
                panic!("{error}")
            };
            assert_eq!(*planner.end(), end);
            refused.push(tag);
        }
    }
    planner.finish();
    loop {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        places.push([setpoint.position_nm(0), setpoint.position_nm(1)]);
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            return (places, refused);
        }
    }
}

fn reason<S: Scalar>(
    block: &Block<S, 2>,
    from: [Coord; 2],
    travel: Travel<2>,
) -> Option<BlockError> {
    let mut config = setting();
    config.travel = travel;
    block.check(&from, &config).err()
}

#[test]
fn a_refused_block_leaves_no_trace() {
    fn test<S: Scalar>() {
        let mut config = setting::<S>();
        config.travel = travel((-1.0, 20.0), (-30.0, 10.0));
        let bad = [
            line(20.001, 3.0, 100),
            arc(at(10.0, 5.0), at(15.1, 5.0), 101),
            arc(at(10.0, 5.0), at(13.0, 9.0), 102),
            Block::cubic([at(10.0, 20.0), at(10.0, 25.0)], at(9.0, 5.0), S::of(80.0), 103),
            Block::rapid(at(5.0, -30.1), 104),
        ];
        let good =
            [line(10.0, 5.0, 1), line(3.0, -4.0, 2), line(10.0, 5.0, 3), line(20.0, 10.0, 4)];
        let mut mixed = vec![];
        for (k, block) in good.iter().enumerate() {
            mixed.push(*block);
            // Arcs about these centres begin at (10, 5).
            mixed.extend(if k % 2 == 0 { &bad[..] } else { &bad[4..] });
        }
        let (alone, none) = setpoints(config, at(0.0, 0.0), &good);
        let (among, refused) = setpoints(config, at(0.0, 0.0), &mixed);
        assert!(none.is_empty());
        assert_eq!(refused, [100, 101, 102, 103, 104, 104, 100, 101, 102, 103, 104, 104]);
        assert_eq!(alone, among);
    }
    test::<f32>();
    test::<f64>();
}

/// By the extent of the curve, not of its centre, its box or its control points; exactly to the limit.
#[test]
fn curves_may_touch_their_limits() {
    let wide = (-1.0e6, 1.0e6);
    for far in [0.0, 3.0e5, -9.0e5] {
        let centre = [mm(far), mm(0.3)];
        let place = |x: f64, y: f64| [mm(far + x), mm(0.3 + y)];
        let circle = arc::<f32>(place(0.0, -7.1), centre, 1);
        let fits = |least: f64, most: f64| {
            reason(&circle, place(0.0, -7.1), travel((far + least, far + most), wide)).is_none()
        };
        assert!(fits(-7.1, 7.1) && !fits(-7.099_99, 7.1) && !fits(-7.1, 7.099_99), "{far}");
        // Three quarters of it do not get to the last one; in the other sense a quarter does.
        let part = arc::<f32>(place(-7.1, 0.0), centre, 1);
        assert!(reason(&part, place(0.0, -7.1), travel((far - 7.1, far + 7.1), wide)).is_none());
        let Motion::Arc { to, plane, centre, extra_turns, .. } = part.motion else { panic!() };
        let motion = Motion::Arc { to, plane, centre, turn: Turn::Clockwise, extra_turns };
        let back = Block { motion, ..part };
        assert!(reason(&back, place(0.0, -7.1), travel((far - 7.1, far), wide)).is_none());
        assert!(reason(&part, place(0.0, -7.1), travel((far - 7.1, far), wide)).is_some());
        // A curve of which the control points lie 8 mm up rises by 6.
        let curve =
            Block::<f32, 2>::cubic([place(0.0, 8.0), place(9.0, 8.0)], place(9.0, 0.0), 9.0, 1);
        let error = |most: f64| reason(&curve, place(0.0, 0.0), travel(wide, (0.3, most)));
        assert_eq!(error(6.3), None);
        let Some(BlockError::Travel { axis: 1, error }) = error(6.299_99) else { panic!("taken") };
        assert!((error.value - 6.3).abs() < 2.0e-6, "{error}");
    }
}

#[test]
fn limits_change_from_one_block_to_the_next() {
    let mut link = Box::new(Link::<f32, 2, 16, 64>::new());
    let (mut planner, mut interpolator) = link.split(setting(), at(0.0, 0.0)).unwrap();
    planner.push(&line(50.0, 0.0, 1)).unwrap();
    planner.set_travel(travel((0.0, 40.0), (-1.0, 1.0)));
    // What was taken is run; from out there it may come back, step by step, and not go further out.
    let refused = |result| {
        matches!(
            result,
            Err(PushError::Rejected { reason: BlockError::Travel { axis: 0, .. }, .. })
        )
    };
    assert!(refused(planner.push(&line(50.001, 0.0, 2))));
    planner.push(&line(45.0, 0.5, 3)).unwrap();
    assert!(refused(planner.push(&line(46.0, 0.5, 4))));
    planner.push(&line(30.0, 0.5, 5)).unwrap();
    assert!(refused(planner.push(&line(41.0, 0.5, 6))));
    planner.set_travel(Travel::OPEN);
    planner.push(&line(60.0, 0.5, 7)).unwrap();
    planner.finish();
    let mut most = 0.0f64;
    loop {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        most = most.max(setpoint.position_mm(0));
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            break;
        }
    }
    assert!((most - 60.0).abs() < 1e-6);
}

/// Along the limits themselves corners are still rounded, on the inner side: hardly slower than without limits.
#[test]
fn corners_on_the_limits_are_rounded_inside() {
    let blocks: Vec<Block<f64, 2>> = (1..=12)
        .map(|k| {
            let (x, y) = [(20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)][(k as usize - 1) % 4];
            Block { tolerance: Some(0.3), ..line(x, y, k) }
        })
        .collect();
    let mut tight = setting();
    tight.travel = travel((0.0, 20.0), (0.0, 20.0));
    let (free, _) = setpoints(setting(), at(0.0, 0.0), &blocks);
    let (inside, refused) = setpoints(tight, at(0.0, 0.0), &blocks);
    assert!(refused.is_empty());
    let beyond = |places: &[[i64; 2]]| {
        places.iter().flatten().map(|&x| (-x).max(x - 20_000_000)).max().unwrap()
    };
    assert!(beyond(&free) > 100_000, "it swings out: {} nm", beyond(&free));
    assert!(beyond(&inside) <= 1, "{} nm", beyond(&inside));
    let stops: Vec<_> = blocks.iter().map(|block| Block { exact_stop: true, ..*block }).collect();
    let (stops, _) = setpoints(setting(), at(0.0, 0.0), &stops);
    let (free, inside, stops) = (free.len(), inside.len(), stops.len());
    assert!(free <= inside && (inside - free) * 3 < stops - free, "{free} {inside} {stops} cycles");
}

/// Cycles and reference points make moves of their own: refused at the line that makes them.
#[test]
fn moves_of_the_reader_are_refused_at_their_line() {
    let machine = Machine::parse("[travel]\nX = { least = 0, greatest = 100 }\nZ = { least = -5, greatest = 20 }\n[reference.G28]\nX = 150\n[axes.default]\nvelocity = 100\nacceleration = 1000\njerk = 20000\n").unwrap();
    let setup = machine.setup();
    let complaints = |text: &str| -> Vec<(u32, String)> {
        let options = ReadOptions { setup: &setup, ..ReadOptions::DEFAULT };
        let (program, findings) =
            inspect_bytes("x.ngc".as_ref(), text.as_bytes(), options).unwrap();
        assert!(findings.is_empty(), "{findings:?}");
        validate(&program, &machine).into_iter().map(|f| (f.line, f.message)).collect()
    };
    let told = complaints("G0 X10 Z5\nG81 X20 Z-4 R1 F60\nX30 Z-5.1\nX40 Z-2\nG80\nG0 X100");
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(told[0], (3, "Z would go to -5.1 mm; its travel is -5 to 20".to_owned()));
    let told = complaints("G0 X10\nG28 X20\nG0 X3");
    assert_eq!((told[0].0, told.len()), (2, 1), "{told:?}");
    assert!(told[0].1.starts_with("X would go to 150"));
    let told = complaints("G0 X100\nG3 X100 Y10 I0 J5 F100\nG2 X100 Y0 I0 J-5");
    assert_eq!(told[0], (2, "X would go to 105 mm; its travel is 0 to 100".to_owned()));
}
