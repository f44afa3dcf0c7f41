//! Setpoints to drives: three axes of step and direction whose pins only count, behind the trait that
//! stands for any output.
//!
//! `cargo run --release --example custom_output`

use embedded_hal::digital::{ErrorType, OutputPin};
use splineway::output::{Drive, EdgeTimes, Scale, StepDir, StepTiming};
use splineway::{Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress, Setpoint};
use std::convert::Infallible;

/// A pin that counts its rising edges.
#[derive(Default)]
struct Pin {
    high: bool,
    edges: u32,
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.high = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.edges += u32::from(!self.high);
        self.high = true;
        Ok(())
    }
}

/// The machine's drives.
struct Steppers {
    axes: [StepDir<Pin, Pin>; 3],
    ticks: u32,
}

impl Drive<f32, 3> for Steppers {
    type Error = u32;

    /// A servo cycle: on a controller a step timer makes the ticks.
    fn drive(&mut self, setpoint: &Setpoint<f32, 3>) -> Result<(), u32> {
        for (number, axis) in self.axes.iter_mut().enumerate() {
            match axis.begin(setpoint.position(number)) {
                0 => {}
                left => return Err(left),
            }
            for _ in 0..self.ticks {
                let Ok(()) = axis.tick();
            }
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let axis = AxisLimits::linear(100.0, 1000.0, 20_000.0);
    let mut link: Link<f32, 3> = Link::new();
    let config = Config::new(Limits::new([axis; 3])?);
    let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 3])?;

    // 400 steps/mm, a step timer of 100 kHz, 1 ms servo cycle: at most 40 steps per cycle.
    let scale = Scale::new(400, 1_000_000)?;
    let drive = EdgeTimes { pulse: 2500, pause: 2500, setup: 5000, hold: 5000 }; // ns
    let timing = StepTiming::from_ns(100_000, 1000, drive);
    let stepper = || StepDir::new(Pin::default(), Pin::default(), scale, timing, Coord::ZERO, 42);
    let mut drives = Steppers { axes: [stepper()?, stepper()?, stepper()?], ticks: timing.ticks };

    for (to, tag) in [[30.0, 10.0, 0.0], [0.0, 20.0, 5.0], [10.0, 0.0, 0.0]].into_iter().zip(1..) {
        let [x, y, z] = to.map(Coord::from_mm);
        planner.push(&Block::line([x?, y?, z?], 80.0, tag))?;
    }
    planner.finish();
    loop {
        let progress = planner.settle();
        let setpoint = interpolator.tick();
        if let Err(left) = drives.drive(&setpoint) {
            return Err(format!("{left} steps were not made in time").into());
        }
        if progress == Progress::Done && setpoint.activity == Activity::Idle {
            break;
        }
    }
    for (letter, axis) in ["X", "Y", "Z"].into_iter().zip(drives.axes) {
        let at = axis.steps();
        let (step, dir) = axis.release();
        println!("{letter}: at step {at}; {} steps, {} times back", step.edges, dir.edges);
    }
    Ok(())
}
