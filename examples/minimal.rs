//! The smallest loop: blocks in, one setpoint per servo cycle out.
//!
//! `cargo run --release --example minimal`

use splineway::{Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; 2])?);
    config.tolerance = 0.05; // mm
    // Two axes in `f32`; look-ahead and window are of default size.
    let mut link: Link<f32, 2> = Link::new();
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 2])?;

    // A square at 100 mm/s; each block is marked with its number.
    let corners = [(20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)];
    for ((x, y), number) in corners.into_iter().zip(1..) {
        let to = [Coord::from_mm(x)?, Coord::from_mm(y)?];
        planner.push(&Block::line(to, 100.0, number))?;
    }
    planner.finish();

    for cycle in 1.. {
        let progress = planner.settle(); // the background
        let setpoint = interpolator.tick(); // the servo interrupt
        if cycle % 50 == 0 {
            println!(
                "{cycle:>4} ms  block {}  X {:>8.4}  Y {:>8.4}  {:>6.1} mm/s",
                setpoint.tag,
                setpoint.position_mm(0),
                setpoint.position_mm(1),
                setpoint.path_speed
            );
        }
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            println!("done in {cycle} cycles");
            break;
        }
    }
    Ok(())
}
