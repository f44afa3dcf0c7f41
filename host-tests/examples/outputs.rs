//! A laser's power in proportion to the speed, and outputs that switch in time with the path: G-code in, a picture out.
//!
//! `cargo run --release --example outputs -- outputs.svg`

use anyhow::{Result, bail};
use splineway::gcode::{Action, Coolant, Laser, Reader, Settings};
use splineway::{
    Activity, AxisLimits, Config, Coord, Limits, Link, Offset, Output, Planner, Progress,
    PushError, SwitchError,
};
use std::fmt::Write as _;

const PROGRAM: [&str; 11] = [
    "G21 G90 G64 P0.1",
    "M8",
    "G0 X5 Y5",
    "M62 P0",
    "M4 S1000",
    "G1 X35 F6000",
    "Y20",
    "M63 P0",
    "G2 X20 Y20 I-7.5 J0",
    "G1 X5 Y5",
    "M9",
];
const CYCLE: f64 = 1.0e-3;

/// A servo cycle.
struct Point {
    place: [f64; 2],
    speed: f64,
    power: f64,
    acceleration: [f64; 2],
}

/// A switch: when, s, where, and what.
struct Mark {
    time: f64,
    place: [f64; 2],
    name: String,
}

fn main() -> Result<()> {
    let (points, marks) = simulate()?;
    for mark in &marks {
        let [x, y] = mark.place;
        println!("{:7.4} s  X{x:.3} Y{y:.3}  {}", mark.time, mark.name);
    }
    if let Some(file) = std::env::args_os().nth(1) {
        std::fs::write(file, picture(&points, &marks))?;
    }
    Ok(())
}

/// Pushes until there is no room; whether it was taken.
fn push(planner: &mut Planner<'_, f64, 2>, action: &Action) -> Result<bool> {
    let full = match action {
        Action::Move(_) => {
            let Some(block) = action.block(&[0, 1]) else { bail!("no move of two axes") };
            match planner.push(&block) {
                Ok(()) => false,
                Err(PushError::Full) => true,
                Err(error) => return Err(error.into()),
            }
        }
        Action::Switch(switch) => match planner.push_switch(switch) {
            Ok(()) => false,
            Err(SwitchError::Full) => true,
            Err(error) => return Err(error.into()),
        },
        Action::Power { power, rest: false } => {
            planner.set_power(power)?;
            false
        }
        other => bail!("{other:?}"),
    };
    Ok(!full)
}

fn simulate() -> Result<(Vec<Point>, Vec<Mark>)> {
    let settings = Settings {
        switches: true,
        laser: Some(Laser { least: 50.0, most: 1000.0 }),
        coolant: Some(Coolant { mist: 1, flood: 2, lead: Offset::Distance(-2.0) }),
        ..Settings::default()
    };
    let mut reader = Reader::new(&settings);
    let mut actions = Vec::new();
    for (number, line) in PROGRAM.iter().enumerate() {
        reader.line(number as u32 + 1, line.as_bytes())?;
        while let Some(action) = reader.action() {
            actions.push(action);
        }
    }
    let axis = AxisLimits::linear(150.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; 2])?);
    config.cycle = CYCLE;
    let mut link = Box::new(Link::<f64, 2>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 2])?;
    let mut actions = actions.iter().peekable();
    let (mut points, mut marks) = (Vec::<Point>::new(), Vec::new());
    loop {
        while let Some(action) = actions.peek() {
            if !push(&mut planner, action)? {
                break;
            }
            actions.next();
        }
        if actions.peek().is_none() {
            planner.finish();
        }
        let progress = planner.settle();
        let at = interpolator.tick();
        let place = [at.position_mm(0), at.position_mm(1)];
        let before = points.last().map_or([0.0; 2], |point| point.place);
        let cycle = points.len() as f64;
        let power = interpolator.switch(&at, |switched| {
            let u = switched.fraction;
            let there = std::array::from_fn(|i| before[i] + (place[i] - before[i]) * u);
            let name = match switched.output {
                Output::Digital(output) => format!("P{output} {}", switched.value),
                Output::Analogue(output) => format!("E{output} {}", switched.value),
                Output::Power => format!("S{}", switched.value),
            };
            marks.push(Mark { time: (cycle + u) * CYCLE, place: there, name });
        });
        points.push(Point { place, speed: at.path_speed, power, acceleration: at.acceleration });
        if progress == Progress::Done && at.activity == Activity::Idle {
            return Ok((points, marks));
        }
    }
}

/// The path coloured by power with the places at which outputs switch, and below it power, speed, acceleration and jerk over time.
fn picture(points: &[Point], marks: &[Mark]) -> String {
    let (width, strip) = (900.0, 110.0);
    let scale = 20.0;
    let top = 32.0 * scale + 20.0;
    let mut svg = String::new();
    let height = top + 4.0 * strip + 20.0;
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>"
    );
    let at = |[x, y]: [f64; 2]| (40.0 + x * scale, top - 30.0 - y * scale);
    let some: Vec<_> = points.iter().step_by(4).collect();
    for pair in some.windows(2) {
        let [(x, y), (u, v)] = [at(pair[0].place), at(pair[1].place)];
        let red = (pair[1].power / 1000.0 * 255.0) as u8;
        let colour =
            if red == 0 { "#bbb".to_owned() } else { format!("rgb({red},0,{})", 255 - red) };
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {y:.1}L{u:.1} {v:.1}\" stroke=\"{colour}\" stroke-width=\"4\"/>"
        );
    }
    for (k, mark) in marks.iter().enumerate() {
        let (x, y) = at(mark.place);
        let side = if k % 2 == 0 { -10.0 } else { 20.0 };
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"5\"/><text x=\"{:.2}\" y=\"{:.2}\">{}</text>",
            x + 8.0,
            y + side,
            mark.name
        );
    }
    let change = |i: usize, axis: usize| match i.checked_sub(1) {
        Some(before) => (points[i].acceleration[axis] - points[before].acceleration[axis]) / CYCLE,
        None => 0.0,
    };
    let most = |f: &dyn Fn(usize) -> f64| (0..points.len()).map(f).collect::<Vec<_>>();
    let strips: [(&str, f64, Vec<f64>); 4] = [
        ("power", 1000.0, most(&|i| points[i].power)),
        ("speed, mm/s", 150.0, most(&|i| points[i].speed)),
        (
            "acceleration of an axis, mm/s\u{b2}",
            2000.0,
            most(&|i| points[i].acceleration.iter().fold(0.0, |m: f64, a| m.max(a.abs()))),
        ),
        (
            "jerk of an axis, mm/s\u{b3}",
            50_000.0,
            most(&|i| change(i, 0).abs().max(change(i, 1).abs())),
        ),
    ];
    for (k, (name, greatest, values)) in strips.iter().enumerate() {
        let base = top + strip * (k as f64 + 1.0) - 8.0;
        let x = |time: f64| 40.0 + time / (points.len() as f64 * CYCLE) * (width - 60.0);
        let mut line = String::new();
        for (i, value) in values.iter().enumerate().step_by(2) {
            let y = base - value / greatest * (strip - 30.0);
            let _ = write!(line, "{:.1},{y:.1} ", x((i as f64 + 1.0) * CYCLE));
        }
        let _ = writeln!(
            svg,
            "<path d=\"M40 {base:.1}H{:.1}\" stroke=\"#ccc\"/><text x=\"40\" y=\"{:.1}\">{name}, up to {greatest}</text><polyline points=\"{line}\" fill=\"none\" stroke=\"#06c\" stroke-width=\"1.5\"/>",
            width - 20.0,
            base - strip + 24.0,
        );
        for mark in marks {
            let x = x(mark.time);
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {base:.1}V{:.1}\" stroke=\"#c60\" stroke-dasharray=\"3\"/>",
                base - strip + 30.0
            );
        }
    }
    svg + "</svg>\n"
}
