//! Any stream of blocks and commands, any numbers in them: nothing panics, and every setpoint is within the
//! limits and near the one before.
#![no_main]

use libfuzzer_sys::fuzz_target;
use splineway::{AxisLimits, Block, Config, Coord, Feed, Limits, Link, Motion, Turn};

/// Numbers out of the input, in turn.
struct Source<'a>(&'a [u8]);

impl Source<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn bytes<const M: usize>(&mut self) -> Option<[u8; M]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    /// Mostly a number of the size of a machine, sometimes any at all.
    fn number(&mut self) -> Option<f32> {
        Some(match self.byte()? {
            0..=15 => f32::from_bits(u32::from_le_bytes(self.bytes()?)),
            _ => f32::from(i16::from_le_bytes(self.bytes()?)) * 0.01,
        })
    }

    fn point(&mut self) -> Option<[Coord; 3]> {
        let mut point = [Coord::ZERO; 3];
        for slot in &mut point {
            *slot = Coord::from_mm(f64::from(self.number()?)).unwrap_or(Coord::from_raw(i64::MAX)); // To be refused.
        }
        Some(point)
    }

    fn block(&mut self) -> Option<Block<f32, 3>> {
        let motion = match self.byte()? % 8 {
            0 if self.byte()? % 2 == 0 => Motion::Event { pause: self.byte()? % 4 == 0 },
            0 => Motion::Dwell { seconds: self.number()? * 0.001 },
            1 | 2 => Motion::Arc {
                to: self.point()?,
                plane: (usize::from(self.byte()? % 4), usize::from(self.byte()? % 4)),
                centre: (self.point()?[0], self.point()?[1]),
                turn: if self.byte()? % 2 == 0 { Turn::Clockwise } else { Turn::CounterClockwise },
                extra_turns: u16::from(self.byte()? % 3),
            },
            3 => Motion::Cubic { controls: [self.point()?, self.point()?], to: self.point()? },
            _ => Motion::Line { to: self.point()? },
        };
        let feed = match self.byte()? % 4 {
            0 => Feed::Rapid,
            1 => Feed::Duration(self.number()?),
            _ => Feed::PerSecond(self.number()?),
        };
        let tolerance = if self.byte()? % 4 == 0 { Some(self.number()?) } else { None };
        Some(Block { motion, feed, tolerance, exact_stop: self.byte()? % 16 == 0, tag: 1 })
    }
}

fuzz_target!(|data: &[u8]| {
    let mut source = Source(data);
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let Ok(limits) = Limits::new([axis; 3]) else { return };
    let mut link = Box::new(Link::<f32, 3, 8, 48>::new());
    let Ok((mut planner, mut interpolator)) = link.split(Config::new(limits), [Coord::ZERO; 3])
    else {
        return;
    };
    let controls = planner.controls();
    let mut before = interpolator.tick();
    let mut run = |planner: &mut splineway::Planner<'_, f32, 3, 8, 48>, cycles: u32| {
        for _ in 0..cycles {
            planner.settle();
            let now = interpolator.tick();
            for i in 0..3 {
                let moved = now.position(i).minus::<f64>(before.position(i));
                assert!(moved.abs() <= 0.2001, "axis {i} jumps by {moved} mm");
                assert!(now.velocity[i].abs() <= 200.2, "velocity {}", now.velocity[i]);
                assert!(now.acceleration[i].abs() <= 2002.0, "acceleration {}", now.acceleration[i]);
            }
            before = now;
        }
    };
    while let Some(kind) = source.byte() {
        match kind {
            0..=199 => {
                let Some(block) = source.block() else { break };
                let _ = planner.push(&block);
            }
            200..=205 => controls.hold(),
            206..=215 => controls.resume(),
            216..=218 => controls.stop(),
            219..=220 => controls.abort(),
            221..=230 => controls.feed_override(u16::from(source.byte().unwrap_or(100))),
            231..=235 => controls.rapid_override(u16::from(source.byte().unwrap_or(100))),
            236..=238 => controls.single_block(kind % 2 == 0),
            239..=241 => planner.finish(),
            242..=246 => drop(planner.acknowledge_abort()),
            _ => {}
        }
        run(&mut planner, u32::from(kind % 16));
    }
    planner.finish();
    controls.resume();
    run(&mut planner, 200);
});
