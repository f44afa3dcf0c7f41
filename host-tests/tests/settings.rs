//! Every setting at its least and its greatest: no motion may be slower than one that stops at every corner.

use splineway::machine::Quantity;
use splineway::number::Range;
use splineway::{
    Activity, AxisLimits, Block, Config, ConfigError, Coord, CornerMode, Limits, Link, Motion,
    Progress, Scalar, Turn,
};

const NODES: usize = 64;

fn at(x: f64, y: f64) -> [Coord; 2] {
    [x, y].map(|x| Coord::from_mm(x).unwrap())
}

fn config<S: Scalar>() -> Config<S, 2> {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(5.0e4));
    let mut config = Config::new(Limits::new([axis; 2]).unwrap());
    config.tolerance = S::of(0.02);
    config
}

/// Programs: legs, chords of a circle, arcs, curves, noise.
fn programs<S: Scalar>() -> Vec<(&'static str, Vec<Block<S, 2>>)> {
    let feed = S::of(100.0);
    let line = |x: f64, y: f64| Block::line(at(x, y), feed, 1);
    let zigzag = |leg: f64, count: u32| {
        (1..count).map(|k| line(leg * f64::from(k), if k % 2 == 1 { leg } else { 0.0 })).collect()
    };
    let circle = (1..126).map(|k| {
        let (sin, cos) = (f64::from(k) * 0.025).sin_cos();
        line(20.0 * sin, 20.0 - 20.0 * cos)
    });
    let arcs = (1..8).map(|k| {
        let x = 10.0 * f64::from(k);
        let centre = at(x - 5.0, 0.0);
        let turn = if k % 2 == 1 { Turn::Clockwise } else { Turn::CounterClockwise };
        let motion = Motion::Arc {
            to: at(x, 0.0),
            plane: (0, 1),
            centre: (centre[0], centre[1]),
            turn,
            extra_turns: 0,
        };
        Block { motion, ..line(0.0, 0.0) }
    });
    let curves = (0..6).map(|k| {
        let x = 15.0 * f64::from(k);
        let side = if k % 2 == 0 { 9.0 } else { -4.0 };
        Block::cubic([at(x + 4.0, side), at(x + 13.0, -side)], at(x + 15.0, 3.0), feed, 1)
    });
    let noise = (1..200).map(|k: u32| line(0.05 * f64::from(k), 0.01 * f64::from(k * k % 7) / 7.0));
    vec![
        ("zigzag of 10 mm", zigzag(10.0, 12)),
        ("zigzag of 1 mm", zigzag(1.0, 20)),
        ("circle in chords", circle.collect()),
        ("arcs", arcs.collect()),
        ("curves", curves.collect()),
        ("noise", noise.collect()),
    ]
}

/// Time of a program, s.
fn time<S: Scalar>(config: &Config<S, 2>, program: &[Block<S, 2>], stop: bool) -> f64 {
    let mut link = Box::new(Link::<S, 2, 16, NODES>::new());
    let (mut planner, mut interpolator) = link.split(*config, [Coord::ZERO; 2]).unwrap();
    let mut blocks = program.iter().peekable();
    let most = (200.0 / config.cycle.to_f64()) as u64;
    for cycle in 1..most {
        while let Some(block) = blocks.peek() {
            if planner.push(&Block { exact_stop: stop, ..**block }).is_err() {
                break;
            }
            blocks.next();
        }
        if blocks.peek().is_none() {
            planner.finish();
        }
        // The background is as fast whatever the cycle.
        let mut progress = planner.settle();
        for _ in 1..(config.cycle.to_f64() / 1.0e-3) as u32 {
            progress = planner.settle();
        }
        if interpolator.tick().activity == Activity::Idle && progress == Progress::Done {
            return cycle as f64 * config.cycle.to_f64();
        }
    }
    f64::INFINITY
}

fn with<S: Scalar>(quantity: Quantity, value: f64) -> Config<S, 2> {
    let mut config = config::<S>();
    match quantity {
        Quantity::Cycle => config.cycle = S::of(value),
        Quantity::Tolerance => config.tolerance = S::of(value),
        Quantity::Lead => config.lead = S::of(value),
        Quantity::StartDelay => config.start_delay = S::of(value),
        Quantity::Lambda => config.corner = CornerMode::Paper { lambda: S::of(value) },
        Quantity::Iterations => config.iterations = value as u16,
        Quantity::Sweeps => config.sweeps = value as u16,
        _ => panic!("{quantity:?} is no setting"),
    }
    config
}

fn no_setting_makes_the_motion_crawl<S: Scalar>() {
    for quantity in Quantity::SETTINGS {
        let Range { least, greatest } = quantity.range();
        for value in [least, greatest] {
            // A million cycles per second take too long here.
            let value = if quantity == Quantity::Cycle { value.max(2.0e-5) } else { value };
            let config = with::<S>(quantity, value);
            config.check().unwrap();
            let mut stops = self::config::<S>();
            stops.cycle = config.cycle;
            for (name, program) in programs::<S>() {
                if quantity == Quantity::Tolerance
                    && value < 1.0e-4
                    && ["curves", "arcs"].contains(&name)
                {
                    // Curves are refused there; arcs have a test of their own.
                    continue;
                }
                let most = 1.05 * time(&stops, &program, true) + 2.0 * config.cycle.to_f64();
                let took = time(&config, &program, false);
                assert!(
                    took <= most,
                    "{quantity:?} {value}, {name}, {}: {took} s of {most}",
                    S::NAME
                );
            }
        }
    }
}

#[test]
fn no_setting_makes_the_motion_crawl_f64() {
    no_setting_makes_the_motion_crawl::<f64>();
}

#[test]
fn no_setting_makes_the_motion_crawl_f32() {
    no_setting_makes_the_motion_crawl::<f32>();
}

/// Values of lambda between: where two transitions nearly meet, the leg between is taken whole.
#[test]
fn no_overlap_of_the_paper_makes_the_motion_crawl() {
    for lambda in [1.0e-15, 1.0e-9, 1.0e-6, 1.0e-4, 1.0e-3, 0.01, 0.02, 0.05, 0.3, 0.6, 0.9] {
        let paper = with::<f64>(Quantity::Lambda, lambda);
        for (name, program) in programs::<f64>() {
            let most = 1.05 * time(&config(), &program, true);
            let took = time(&paper, &program, false);
            assert!(took <= most, "lambda {lambda}, {name}: {took} s of {most}");
        }
    }
}

#[test]
fn what_is_out_of_range_is_refused_with_value_and_range() {
    for quantity in Quantity::SETTINGS {
        let Range { least, greatest } = quantity.range();
        let whole = matches!(quantity, Quantity::Iterations | Quantity::Sweeps);
        let below = if whole { least - 1.0 } else { least - 1.0e-3 };
        let above = if whole { greatest + 1.0 } else { greatest * 1.001 };
        let none = if whole { 65535.0 } else { f64::NAN };
        for value in [below, above, none] {
            if whole && value < 0.0 {
                continue;
            }
            let error = with::<f64>(quantity, value).check().unwrap_err();
            let ConfigError::Setting { quantity: named, error: found } = error else {
                panic!("{error:?}")
            };
            assert_eq!((named, found.least, found.greatest), (quantity, least, greatest));
            let given = found.value;
            assert!(given.to_bits() == value.to_bits() || (given.is_nan() && value.is_nan()));
            let words = error.to_string();
            let range = format!("it must be {least} to {greatest}");
            assert!(words.contains(&range) && words.contains(&format!("{value}")), "{words}");
        }
    }
}
