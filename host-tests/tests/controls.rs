//! An operator's commands, at every moment, against every limit.

mod common;

use common::{Draw, config, draws, machine, program};
use proptest::prelude::*;
use splineway::{Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress};
use splineway_host::machine::Machine;
use splineway_host::program::Program;
use splineway_host::run::{
    Action, Event, Events, Judge, Precision, Stats, Track, Verdict, run_with,
};
use splineway_host::view::violations;

fn judged(
    program: &Program,
    machine: &Machine,
    precision: Precision,
    events: &Events,
) -> (Verdict, Stats) {
    let limits = machine.axes_of(program).unwrap();
    let track = Track::new(program);
    let mut judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance);
    let stats = run_with(program, machine, precision, events, &mut [&mut judge]).unwrap();
    (judge.verdict(), stats)
}

/// One random command: when (as a share of the time), which, how much.
fn commands() -> impl Strategy<Value = Vec<(f64, u8, u16)>> {
    prop::collection::vec((0.0f64..1.0, 0u8..16, 0u16..=200), 1..12)
}

/// Commands at random times, and at last everything that lets the program run to its end.
fn events(commands: &[(f64, u8, u16)], time: f64) -> Events {
    let mut list: Vec<Event> = commands
        .iter()
        .map(|&(when, kind, percent)| {
            let action = match kind {
                0..=3 => Action::Hold,
                4..=6 => Action::Resume,
                7 => Action::Stop,
                8 => Action::Single(true),
                9 => Action::Single(false),
                10 => Action::Rapid(percent.min(100)),
                11 => Action::Starve(f64::from(percent) * 1.0e-3),
                12 if percent < 40 => Action::Abort,
                _ => Action::Feed(percent),
            };
            Event { time: when * time, action }
        })
        .collect();
    let end = time + 0.3;
    list.push(Event { time: end, action: Action::Single(false) });
    list.push(Event { time: end, action: Action::Feed(150) });
    list.push(Event { time: end, action: Action::Rapid(100) });
    list.push(Event { time: end, action: Action::Resume });
    // A stop that was asked for may only have come to its block's end now.
    list.push(Event { time: end + 3.0, action: Action::Resume });
    Events::new(list)
}

fn check(
    (draws, axes): (&[Draw], &[usize]),
    machine: &Machine,
    precision: Precision,
    commands: &[(f64, u8, u16)],
) -> Result<(), TestCaseError> {
    let program = program(draws, axes);
    let (plain, _) = judged(&program, machine, precision, &Events::default());
    let events = events(commands, plain.time * 1.5);
    let (mut verdict, stats) = judged(&program, machine, precision, &events);
    if stats.aborted {
        verdict.end_error = 0.0;
    }
    let limits = machine.axes_of(&program).unwrap();
    let broken = violations(&verdict, precision, machine.cycle, machine.tolerance, &limits);
    if !broken.is_empty() && std::env::var("DBG").is_ok() {
        struct P {
            last: Vec<Vec<f64>>,
            lim: Vec<(f64, f64)>,
            h: f64,
            said: u32,
        }
        impl splineway_host::run::Observer for P {
            fn setpoint(&mut self, s: &splineway_host::run::Sample<'_>) -> anyhow::Result<()> {
                self.last.push(s.position.to_vec());
                let n = self.last.len();
                if n > 4 {
                    let q = |b: usize, k: usize| self.last[n - 1 - b][k];
                    let mut w: f64 = 0.0;
                    let mut jw: f64 = 0.0;
                    for k in 0..s.position.len() {
                        let a =
                            (q(0, k) - 2.0 * q(1, k) + q(2, k)) / self.h.powi(2) / self.lim[k].0;
                        w = w.max(a.abs());
                        let j = (q(0, k) - 3.0 * q(1, k) + 3.0 * q(2, k) - q(3, k))
                            / self.h.powi(3)
                            / self.lim[k].1;
                        jw = jw.max(j.abs());
                    }
                    if (w > 1.003 || jw > 1.002) && self.said < 8 {
                        self.said += 1;
                        eprintln!(
                            "{:.4} tag {} {:?} a {w:.4} j {jw:.4} v {:.5} acc {:?} path {:.6} {:?}",
                            s.time, s.tag, s.position, s.speed, s.acceleration, s.path, s.activity
                        );
                    }
                }
                Ok(())
            }
        }
        let mut o = P {
            last: vec![],
            lim: limits.iter().map(|l| (l.acceleration, l.jerk)).collect(),
            h: machine.cycle,
            said: 0,
        };
        eprintln!("---- {broken:?} {:?}", events.list());
        for m in &program.moves {
            eprintln!("{:?} {:?} stop {} line {}", m.path, m.speed, m.exact_stop, m.line);
        }
        let _ = run_with(&program, machine, precision, &events, &mut [&mut o]);
    }
    prop_assert!(broken.is_empty(), "{broken:?} {:?}", events.list());
    Ok(())
}

proptest! {
    #![proptest_config(config(800))]

    #[test]
    fn three_axes_in_f64(
        draws in draws(3, 1..14),
        tolerance in (-3.0f64..0.5).prop_map(|e| 10f64.powf(e)),
        scale in ((-1.0f64..1.0).prop_map(|e| 10f64.powf(e)), (-1.0f64..1.0).prop_map(|e| 10f64.powf(e))),
        commands in commands(),
    ) {
        check((&draws, &[0, 1, 2]), &machine(tolerance, scale, 3), Precision::F64, &commands)?;
    }
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn three_axes_in_f32(
        draws in draws(3, 1..14),
        tolerance in (-2.5f64..0.0).prop_map(|e| 10f64.powf(e)),
        commands in commands(),
    ) {
        check((&draws, &[0, 1, 2]), &machine(tolerance, (1.0, 1.0), 3), Precision::F32, &commands)?;
    }

    #[test]
    fn six_axes(draws in draws(6, 1..8), commands in commands()) {
        let axes: Vec<usize> = (0..6).collect();
        check((&draws, &axes), &machine(0.02, (1.0, 1.0), 6), Precision::F64, &commands)?;
    }
}
