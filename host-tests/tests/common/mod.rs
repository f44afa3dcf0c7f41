//! Random programs and machines for the property tests.

#![allow(dead_code)] // Every test uses a part of it.

mod cases;

#[allow(unused_imports)] // As above.
pub use cases::{config, soak};
use proptest::prelude::*;
use splineway_simulator::judge::{self, Verdict, violations};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::Program;
use splineway_simulator::run::{Events, Observer, Precision, Sample, Stats, run};
#[allow(unused_imports)] // As above.
pub use splineway_trials::{Draw, Stretch, dense, machine, poly_line, program};

/// Runs a program while an operator gives commands, and judges it.
pub fn judged(
    program: &Program,
    machine: &Machine,
    precision: Precision,
    events: &Events,
) -> (Verdict, Stats) {
    judge::judged(program, machine, precision, events).unwrap()
}

/// Runs a program without commands; nothing may be broken.
pub fn check(
    program: &Program,
    machine: &Machine,
    precision: Precision,
) -> Result<(Verdict, Stats), TestCaseError> {
    let (verdict, stats) = judged(program, machine, precision, &Events::default());
    let broken = violations(&verdict);
    prop_assert!(broken.is_empty(), "{broken:?}");
    Ok((verdict, stats))
}

pub fn draws(axes: usize, count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Draw>> {
    let one = (
        0u8..20,
        prop::collection::vec(-1.0f64..1.0, axes),
        // Lengths from a micrometre to 30 mm, all orders of magnitude alike.
        (-3.0f64..1.5).prop_map(|e| 10f64.powf(e)),
        (-0.5f64..2.6).prop_map(|e| 10f64.powf(e)),
        prop::bool::weighted(0.05),
        -2.5f64..2.5,
    )
        .prop_map(|(kind, step, size, feed, stop, bend)| Draw {
            kind,
            step,
            size,
            feed,
            stop,
            bend,
        });
    prop::collection::vec(one, count)
}

/// Time of a run, and the tags in the order of their setpoints with the count of each.
#[derive(Default)]
pub struct Watch {
    pub time: f64,
    pub tags: Vec<(u32, u32)>,
}

impl Observer for Watch {
    fn setpoint(&mut self, sample: &Sample<'_>) -> anyhow::Result<()> {
        anyhow::ensure!(sample.time < 1000.0, "line {}: the run does not end", sample.tag);
        self.time = sample.time;
        match self.tags.last_mut() {
            Some((tag, count)) if *tag == sample.tag => *count += 1,
            _ => self.tags.push((sample.tag, 1)),
        }
        Ok(())
    }
}

/// Runs a program without commands and without a judge.
pub fn watched(program: &Program, machine: &Machine, precision: Precision) -> Watch {
    let mut watch = Watch::default();
    run(program, machine, precision, &mut [&mut watch]).unwrap();
    watch
}

pub fn stretches(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Stretch>> {
    let one = (
        0u8..10,
        1usize..40,
        // Lines from a tenth of a micrometre to 3 mm.
        (-4.0f64..0.5).prop_map(|e| 10f64.powf(e)),
        -0.6f64..0.6,
        (-4.0f64..0.0).prop_map(|e| 10f64.powf(e)),
        (0.5f64..2.4).prop_map(|e| 10f64.powf(e)),
    )
        .prop_map(|(kind, count, size, turn, noise, feed)| Stretch {
            kind,
            count,
            size,
            turn,
            noise,
            feed,
        });
    prop::collection::vec(one, count)
}
