//! Programs as they are sent.

use anyhow::{Context, Result, anyhow, ensure};
use splineway::wire::{
    HomeMove, Item, Move, Path, PowerMove, ProbeInput, ProbeMove, Speed, SwitchMove, Target,
};
use splineway::{Config, Coord, Motion};
use splineway_simulator::letters::lettered;
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, Aside, Course, Finding, LETTERS, Point, Program};
use splineway_simulator::run::on_letters;

/// A stretch of a program: up to a probe or homing, or to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Where it begins, nm.
    pub start: Vec<i64>,
    /// Its items.
    pub items: Vec<Item>,
}

/// The program as a controller with a number of axes takes it, from where the program starts. An axis
/// whose place does not change, to the nanometre, is not named, and stays.
///
/// # Errors
/// It moves an axis that the controller lacks; a coordinate is out of range.
pub fn items(program: &Program, axes: usize) -> Result<Vec<Item>> {
    Ok(parts(program, axes, None)?.into_iter().flat_map(|part| part.items).collect())
}

/// The same in parts, each of which ends with a probe or homing, and the last with the end of the program. `home`: how axes are homed.
///
/// # Errors
/// As [`items`]; and it homes, and nothing says how.
pub fn parts(program: &Program, axes: usize, home: Option<&HomeMove>) -> Result<Vec<Part>> {
    for axis in program.axes() {
        ensure!(
            axis < axes || !program.uses[axis],
            "the program moves {}; the controller has only {}",
            LETTERS[axis],
            LETTERS[..axes].iter().collect::<String>()
        );
    }
    let mut here = nanometres(&program.start, axes)?;
    let mut part = Part { start: here.clone(), items: Vec::with_capacity(program.moves.len() + 1) };
    let mut parts = Vec::new();
    let mut asides = program.asides.iter().peekable();
    for place in 0..=program.moves.len() {
        while let Some((_, aside)) = asides.next_if(|(before, _)| *before <= place) {
            let ends = wire_aside(aside, (axes, home), &mut here, &mut part.items)?;
            if let Some(ends) = ends {
                here = nanometres(ends, axes)?;
                let next = Part { start: here.clone(), items: Vec::new() };
                parts.push(std::mem::replace(&mut part, next));
            }
        }
        let Some(step) = program.moves.get(place) else { continue };
        let step =
            wire_move(step, axes, &mut here).with_context(|| format!("line {}", step.line))?;
        part.items.push(Item::Move(step));
    }
    part.items.push(Item::End);
    parts.push(part);
    Ok(parts)
}

/// What stands between moves, as it is sent; where the machine stands behind it, if that is known only then.
fn wire_aside<'a>(
    aside: &'a Aside,
    (axes, home): (usize, Option<&HomeMove>),
    here: &mut Vec<i64>,
    items: &mut Vec<Item>,
) -> Result<Option<&'a Point>> {
    match aside {
        Aside::Probe(probe, ends) => {
            let [to] = targets([&probe.to.map(Coord::to_mm)], axes, here)
                .with_context(|| format!("line {}", probe.tag))?;
            items.push(Item::Probe(ProbeMove {
                to,
                feed: (probe.feed * 1.0e3).round() as u32,
                input: ProbeInput::Probe,
                closes: probe.closes,
                required: probe.required,
                tag: probe.tag,
            }));
            return Ok(Some(ends));
        }
        Aside::Home { line, ends } => {
            let home =
                home.with_context(|| format!("line {line}: nothing says how axes are homed"))?;
            items.push(Item::Home(HomeMove { tag: *line, ..home.clone() }));
            return Ok(Some(ends));
        }
        Aside::Switch(switch) => {
            let switch = SwitchMove::try_from(switch).map_err(|refusal| anyhow!("{refusal}"))?;
            items.push(Item::Switch(switch));
        }
        Aside::Power { power, rest, line } => {
            let single = |x: f64| x as f32;
            items.push(Item::Power(PowerMove {
                level: single(power.level),
                dynamic: power.dynamic,
                least: single(power.least),
                most: single(power.most),
                rest: *rest,
                tag: *line,
            }));
        }
    }
    Ok(None)
}

fn nm(mm: f64) -> Result<i64> {
    ensure!(mm.abs() <= Coord::LIMIT_MM, "coordinate {mm} mm is out of range (+-1e6)");
    Ok((mm * 1.0e6).round() as i64)
}

fn nanometres(point: &Point, axes: usize) -> Result<Vec<i64>> {
    point[..axes].iter().map(|&mm| nm(mm)).collect()
}

/// Points, with the axes that stay `here` in all of them left out. The last is where `here` is then.
fn targets<const M: usize>(
    points: [&Point; M],
    axes: usize,
    here: &mut Vec<i64>,
) -> Result<[Target; M]> {
    let mut places: [Vec<i64>; M] = std::array::from_fn(|_| Vec::new());
    for (place, point) in places.iter_mut().zip(points) {
        *place = nanometres(point, axes)?;
    }
    let stays: Vec<bool> =
        (0..axes).map(|axis| places.iter().all(|place| place[axis] == here[axis])).collect();
    let targets = std::array::from_fn(|k| {
        places[k].iter().zip(&stays).map(|(&nm, &stays)| (!stays).then_some(nm)).collect()
    });
    if let Some(last) = places.into_iter().next_back() {
        *here = last;
    }
    Ok(targets)
}

/// A move as it is sent.
fn wire_move(step: &program::Move, axes: usize, here: &mut Vec<i64>) -> Result<Move> {
    let path = match &step.path {
        Course::Line { to } => {
            let [to] = targets([to], axes, here)?;
            Path::Line { to }
        }
        Course::Arc { to, plane, centre, clockwise, extra_turns } => {
            let [to] = targets([to], axes, here)?;
            Path::Arc {
                to,
                plane: (plane.0 as u8, plane.1 as u8),
                centre: (nm(centre.0)?, nm(centre.1)?),
                clockwise: *clockwise,
                extra_turns: *extra_turns,
            }
        }
        Course::Cubic { controls: [first, second], to } => {
            let [first, second, to] = targets([first, second, to], axes, here)?;
            Path::Cubic { controls: [first, second], to }
        }
        Course::Dwell { seconds } => Path::Dwell { seconds: *seconds as f32 },
        Course::Event { code, value, pause } => Path::Event {
            letter: u8::try_from(code.letter).unwrap_or(b'?'),
            tenths: code.tenths,
            value: value.map(|value| value as f32),
            pause: *pause,
        },
    };
    let speed = match step.speed {
        program::Speed::PerSecond(feed) => Speed::PerSecond(feed as f32),
        program::Speed::Duration(seconds) => Speed::Duration(seconds as f32),
        program::Speed::Rapid => Speed::Rapid,
    };
    let tolerance = step.tolerance.map(|mm| mm as f32);
    Ok(Move { path, speed, tolerance, exact_stop: step.exact_stop, tag: step.line })
}

/// What a controller in `f32` would have against the items of a program from `start`, nm: all of it, before
/// the first of them is sent. Nothing is planned.
///
/// # Errors
/// The machine stands where no program can.
pub fn check(items: &[Item], start: &[i64]) -> Result<Vec<Finding>> {
    const N: usize = program::AXES;
    let all: Vec<usize> = (0..N).collect();
    // The limits of the controller are not known, and no check asks for them.
    let config: Config<f32, N> = Machine::default().config(&all)?;
    let mut here = [Coord::ZERO; N];
    for (here, &nm) in here.iter_mut().zip(start) {
        *here = Coord::from_nm(nm).context("the machine stands beyond 1e6 mm")?;
    }
    let mut findings = Vec::new();
    for item in items {
        let Item::Move(step) = item else { continue };
        let block = match with_all_axes(step).block::<f32, N>(&here) {
            Ok(block) => block,
            Err(error) => {
                findings.push(Finding::error(step.tag, lettered(&error.to_string(), &all)));
                continue;
            }
        };
        if let Err(error) = block.check(&here, &config) {
            findings.push(Finding::error(step.tag, on_letters(&error, &all)));
        }
        if let Motion::Line { to } | Motion::Arc { to, .. } | Motion::Cubic { to, .. } =
            block.motion
        {
            here = to;
        }
    }
    Ok(findings)
}

/// The move on a machine of nine axes, of which the further ones stay.
fn with_all_axes(step: &Move) -> Move {
    let mut step = step.clone();
    let fill = |target: &mut Target| while target.push(None).is_ok() {};
    match &mut step.path {
        Path::Line { to } | Path::Arc { to, .. } => fill(to),
        Path::Cubic { controls: [first, second], to } => {
            for target in [first, second, to] {
                fill(target);
            }
        }
        Path::Dwell { .. } | Path::Event { .. } => {}
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway_simulator::program::gcode;

    fn lines(program: &Program) -> Vec<Target> {
        let items = items(program, 3).unwrap();
        let line = |item: &Item| match item {
            Item::Move(Move { path: Path::Line { to }, .. }) => Some(to.clone()),
            _ => None,
        };
        items.iter().filter_map(line).collect()
    }

    #[test]
    fn only_what_moves_is_named() {
        let program = gcode::parse("G1 X1 F600\nX1 Y2\nX1 Y2\nG2 X1 Y2 I1\n", 50.0).unwrap();
        let to = |axes: [Option<i64>; 3]| Target::from(axes);
        assert_eq!(
            lines(&program),
            [to([Some(1_000_000), None, None]), to([None, Some(2_000_000), None]), to([None; 3])]
        );
        // A full circle ends exactly where it began.
        let items = items(&program, 3).unwrap();
        let Item::Move(Move { path: Path::Arc { to: end, centre, .. }, .. }) = &items[3] else {
            panic!("an arc")
        };
        assert_eq!((end, *centre), (&to([None; 3]), (2_000_000, 2_000_000)));
    }

    #[test]
    fn every_finding_is_listed() {
        let mut program = gcode::parse("G1 X1 F600\nX2\nX3\nG4 P1\n", 50.0).unwrap();
        program.moves[0].speed = program::Speed::PerSecond(-1.0);
        program.moves[2].speed = program::Speed::PerSecond(f64::NAN);
        let items = items(&program, 3).unwrap();
        let findings = check(&items, &[0, 0, 0]).unwrap();
        let lines: Vec<u32> = findings.iter().map(|finding| finding.line).collect();
        assert_eq!(lines, [1, 3], "{findings:?}");
    }
}
