//! Planner and interpolator in contexts of their own, as background and interrupt are: two threads, and
//! nothing between them but the link. A third one plays the operator.
//!
//! `cargo run --release --example two_contexts`

use splineway::{
    Activity, AxisLimits, BLOCKS, Block, Config, Coord, Limits, Link, NODES, Progress, PushError,
    RangeError,
};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread;
use std::time::Duration;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let config = Config::new(Limits::new([axis; 2])?);
    let mut link = Box::new(Link::<f32, 2, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 2])?;
    let controls = planner.controls();
    // A circle of 20 mm in chords of 0.1 mm.
    let mut blocks = (1..=628u32)
        .map(|k| {
            let angle = f64::from(k) * 0.01;
            let [x, y] = [10.0 * angle.sin(), 10.0 - 10.0 * angle.cos()];
            Ok(Block::line([Coord::from_mm(x)?, Coord::from_mm(y)?], 60.0, k))
        })
        .collect::<Result<Vec<_>, RangeError>>()?
        .into_iter()
        .peekable();
    let done = AtomicBool::new(false);

    thread::scope(|scope| {
        // The background: as many blocks as there is room for, and a planning step.
        scope.spawn(|| {
            loop {
                while let Some(block) = blocks.peek() {
                    match planner.push(block) {
                        Ok(()) => drop(blocks.next()),
                        Err(PushError::Full) => break,
                        // The block is refused, or the operator has aborted: no more of this program.
                        Err(error) => {
                            println!("{error}");
                            return done.store(true, Relaxed);
                        }
                    }
                }
                if blocks.peek().is_none() {
                    planner.finish();
                }
                if planner.poll() == Progress::Done {
                    println!("everything is planned: {:?}", planner.counters());
                    return done.store(true, Relaxed);
                }
                thread::yield_now();
            }
        });
        // The interrupt, twenty times as fast as on a machine.
        scope.spawn(|| {
            let (mut cycles, mut fastest) = (0u32, 0.0f32);
            loop {
                let setpoint = interpolator.tick();
                cycles += 1;
                fastest = fastest.max(setpoint.path_speed);
                if done.load(Relaxed) && setpoint.activity == Activity::Idle {
                    let at = [setpoint.position_nm(0), setpoint.position_nm(1)];
                    return println!("{cycles} cycles, at most {fastest:.1} mm/s, at {at:?} nm");
                }
                thread::sleep(Duration::from_micros(50));
            }
        });
        // The operator.
        scope.spawn(|| {
            thread::sleep(Duration::from_millis(20));
            controls.feed_override(50);
            thread::sleep(Duration::from_millis(20));
            controls.hold();
            thread::sleep(Duration::from_millis(20));
            controls.resume();
        });
    });
    Ok(())
}
