//! A spline smoothed inside a tube and run as curves: its Bezier spans are blocks.
//!
//! `cargo run --release --example nurbs`

use splineway::{
    Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress, PushError, RangeError,
};
use splineway_simulator::program::{self, Course, ReadOptions};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A NURBS curve from a file, as cubic spans.
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/butterfly.json");
    let program = program::read(
        &file,
        ReadOptions { feed: 100.0, segments: Some(400), ..ReadOptions::DEFAULT },
    )?;
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let config = Config::new(Limits::new([axis; 2])?);
    let point = |at: &program::Point| -> Result<_, RangeError> {
        Ok([Coord::from_mm(at[0])?, Coord::from_mm(at[1])?])
    };
    let start = point(&program.start)?;
    let mut link = Box::new(Link::<f64, 2, 64, 192>::new());
    let (mut planner, mut interpolator) = link.split(config, start)?;

    let mut blocks = program
        .moves
        .iter()
        .filter_map(|step| match &step.path {
            Course::Line { to } => Some(point(to).map(|to| Block::line(to, 100.0, step.line))),
            Course::Cubic { controls: [a, b], to } => Some(
                point(to)
                    .and_then(|to| Ok(Block::cubic([point(a)?, point(b)?], to, 100.0, step.line))),
            ),
            _ => None,
        })
        .collect::<Result<Vec<_>, RangeError>>()?
        .into_iter()
        .peekable();
    let (mut cycles, mut fastest) = (0, 0.0f64);
    loop {
        while let Some(block) = blocks.peek() {
            match planner.push(block) {
                Ok(()) => drop(blocks.next()),
                Err(PushError::Full) => break,
                Err(error) => return Err(error.into()),
            }
        }
        if blocks.peek().is_none() {
            planner.finish();
        }
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        cycles += 1;
        fastest = fastest.max(setpoint.path_speed);
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            println!(
                "{:.3} mm in {:.3} s, at most {fastest:.1} mm/s",
                setpoint.path_mm(),
                f64::from(cycles) * 0.001
            );
            return Ok(());
        }
    }
}
