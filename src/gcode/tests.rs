//! Laws of the reader. (Every code has its lines in the tests of the host package.)

use super::{AXES, Action, Dialect, Reader, Reason, Settings};
use crate::block::{Block, Feed, Motion};
use crate::number::Coord;
use std::vec::Vec;

fn actions(reader: &mut Reader) -> Vec<Action> {
    core::iter::from_fn(|| reader.action()).collect()
}

#[test]
fn a_line_must_be_done_before_the_next() {
    let mut reader = Reader::new(&Settings::default());
    reader.line(1, b"G0 X1").unwrap();
    assert_eq!(reader.line(2, b"G0 X2").unwrap_err().reason, Reason::Busy);
    assert_eq!(actions(&mut reader).len(), 1);
    reader.line(2, b"G0 X2 M2").unwrap();
    assert_eq!(actions(&mut reader).last(), Some(&Action::End));
    assert!(reader.has_ended());
    reader.line(3, b"what comes behind the end is not read").unwrap();
    assert!(actions(&mut reader).is_empty());
}

#[test]
fn moves_become_blocks_of_the_machines_axes() {
    let mut reader = Reader::new(&Settings::default());
    reader.line(7, b"G18 G2 X2 K1 I1 Z0 F60").unwrap();
    let action = reader.action().unwrap();
    let block: Block<f32, 3> = action.block(&[0, 1, 2]).unwrap();
    assert!(matches!(block.motion, Motion::Arc { plane: (2, 0), .. }));
    assert_eq!(block.tag, 7);
    let block: Block<f32, 2> = action.block(&[2, 0]).unwrap();
    assert!(matches!(block.motion, Motion::Arc { plane: (0, 1), .. }));
    assert!(action.block::<f32, 2>(&[0, 1]).is_none());
}

/// G5 without I and J: what it would go on from ends with the program, and with moves that are dropped.
#[test]
fn a_curve_goes_on_only_from_one_that_was_run() {
    let ways: [fn(&mut Reader); 3] = [Reader::begin_anew, Reader::drop_moves, Reader::restart];
    for forget in ways {
        let mut reader = Reader::new(&Settings::default());
        for line in [&b"G5 X4 I1 J2 P-1 Q2 F60"[..], b"G5 X8 P-1 Q2"] {
            reader.line(1, line).unwrap();
            assert_eq!(actions(&mut reader).len(), 1);
        }
        forget(&mut reader);
        assert!(reader.line(2, b"G5 X12 P-1 Q2 F60").is_err());
    }
}

#[test]
fn axes_that_are_not_there_are_refused() {
    let axes = [true, true, true, false, false, false, false, false, false];
    let mut reader = Reader::new(&Settings { axes, ..Settings::default() });
    let refusal = reader.line(1, b"G1 X1 A5 F60").unwrap_err();
    assert_eq!((refusal.column, refusal.reason), (7, Reason::NoAxis('A')));
}

/// The line ends of others are no blanks: two moves must not become one.
#[test]
fn a_carriage_return_is_the_end_of_a_line_or_refused() {
    let mut reader = Reader::new(&Settings::default());
    reader.line(1, b"G0 X1\r").unwrap();
    assert_eq!(actions(&mut reader).len(), 1);
    for text in [&b"G0 X1\rY2"[..], b"G0 X1\r\r", b"G0\r X1", b"\rG0 X1"] {
        let reason = reader.line(2, text).unwrap_err().reason;
        assert_eq!(reason, Reason::Character('\r'));
    }
}

/// Whatever is written into a NURBS block: nothing moves before its end, and nothing of it at all if a line was refused.
#[cfg(feature = "nurbs")]
#[test]
fn a_nurbs_block_is_run_as_a_whole_or_not_at_all() {
    const JUNK: [&[u8]; 16] = [
        b" Z1", b" X", b" P0", b" P-1", b" M3", b" G1", b" G91", b" (c", b" #1", b" X9", b" L4",
        b" F0", b"", b" P2", b" F90", b" (c)",
    ];
    let (mut run, mut refused) = (0, 0);
    for round in 0..1600usize {
        let mut reader = Reader::new(&Settings::default());
        let mut lines: Vec<Vec<u8>> = Vec::from([&b"F600"[..], b"G5.2"].map(Vec::from));
        for (k, text) in [&b"X1 Y2"[..], b"X3 Y-1", b"X4", b"X5 Y2"].into_iter().enumerate() {
            lines.push(Vec::from(text));
            // Half of them lack a word.
            if k == 2 && round % 2 == 0 {
                lines[4].extend_from_slice(b" Y0");
            }
        }
        lines.push(Vec::from(&b"G5.3"[..]));
        lines[1 + round / 2 % 6].extend_from_slice(JUNK[round / 12 % 16]);
        let last = lines.len() - 1;
        let mut is_whole = true;
        for (number, line) in lines.iter().enumerate() {
            let outcome = reader.line(number as u32 + 1, line);
            is_whole &= outcome.is_ok();
            let found = actions(&mut reader);
            let moves = found.iter().filter(|action| matches!(action, Action::Move(_))).count();
            assert!(moves == 0 || number == last && is_whole, "{round}: {line:?} moves");
            run += usize::from(moves > 0);
        }
        refused += usize::from(!is_whole);
        if reader.finish().is_err() {
            // Its last line could not be read.
            assert!(!is_whole && round / 2 % 6 == 5);
            continue;
        }
        reader.line(9, b"G1 X7 Y7").unwrap();
        assert_eq!(actions(&mut reader).len(), 1, "what comes behind is read");
    }
    assert!(run > 100 && refused > 800 && run <= 1600 - refused, "{run} {refused}");
}

/// Lines of random words, and of random bytes: refused, or moves within the range, from where the last one ended;
/// and a refused line moves nothing.
#[test]
fn whatever_comes_is_read_or_refused() {
    const PARTS: [&str; 68] = [
        "G0", "G1", "G2", "G3", "G4", "G5", "G5.1", "G10", "G17", "G18", "G19", "G20", "G21",
        "G28", "G30", "G43", "G43.1", "G49", "G52", "G53", "G54", "G55", "G61", "G64", "G68",
        "G69", "G73", "G80", "G81", "G82", "G83", "G90", "G91", "G92", "G92.1", "G93", "G94",
        "G98", "G99", "M0", "M3", "M6", "M30", "M98", "G5.2", "G5.3", "X1Y2", "L3", "X1", "Y-2.5",
        "Z3e+2", "A90", "I1", "J-1", "K2", "R5", "P2", "Q0.5", "L2", "F600", "S100", "T1", "H1",
        "E5", "(c)", "X", "%", "N5",
    ];
    let mut seed = 1u64;
    let mut draw = |most: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % most
    };
    let mut read = 0;
    for round in 0..3000 {
        let dialect = [Dialect::LinuxCnc, Dialect::Grbl, Dialect::Marlin][round % 3];
        let mut reader =
            Reader::new(&Settings { dialect, lenient: round % 2 == 0, ..Settings::default() });
        let mut moved = [false; AXES];
        let mut here = *reader.position();
        for number in 1..12 {
            let mut line = Vec::new();
            for _ in 0..draw(7) {
                if round % 10 == 9 {
                    line.push(draw(256) as u8);
                } else {
                    line.extend_from_slice(PARTS[draw(68) as usize].as_bytes());
                    line.extend_from_slice([&b""[..], b" "][draw(2) as usize]);
                }
            }
            let outcome = reader.line(number, &line);
            let found = actions(&mut reader);
            assert!(outcome.is_ok() || found.is_empty());
            if outcome.is_err() {
                // It is taken for where it would have led.
                here = *reader.position();
            }
            read += usize::from(outcome.is_ok() && !found.is_empty());
            for action in &found {
                let Action::Move(block) = action else { continue };
                let (Motion::Line { to } | Motion::Arc { to, .. } | Motion::Cubic { to, .. }) =
                    &block.motion
                else {
                    continue;
                };
                if let Motion::Arc { plane, .. } = &block.motion {
                    (moved[plane.0], moved[plane.1]) = (true, true);
                }
                assert!(to.iter().all(|coord| coord.to_mm().abs() <= Coord::LIMIT_MM));
                for (axis, moved) in moved.iter_mut().enumerate() {
                    *moved |= to[axis] != here[axis];
                }
                here = *to;
            }
            // Whoever asks which axes a program moves hears of all of them.
            let named = reader.named();
            assert!((0..AXES).all(|axis| named[axis] || !moved[axis]), "{moved:?}, {named:?}");
        }
    }
    assert!(read > 1000, "{read}");
}

/// Holes of any depth in decimals, of mm and of inches: as many moves down at the feed as pecks, each where it belongs.
#[test]
fn a_hole_is_drilled_as_often_as_it_has_pecks() {
    let mut seed = 7u64;
    let mut draw = |most: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % most
    };
    for round in 0..4000 {
        let inches = round % 2 == 1;
        // In 1e-4 of the unit; every other hole is a whole number of pecks.
        let clear = draw(400_000).cast_signed() - 200_000;
        let peck = 1 + draw(50_000).cast_signed();
        let pecks = 1 + draw(8).cast_signed();
        let rest = if round % 4 < 2 { 0 } else { draw(peck.cast_unsigned()).cast_signed() };
        let depth = peck * pecks - rest;
        let cycle = ["G81", "G82 P1", "G83", "G73"][draw(4) as usize];
        let is_pecked = matches!(cycle, "G83" | "G73");
        let units = if inches { "G20" } else { "G21" };
        let text = |value: i64| {
            let sign = if value < 0 { "-" } else { "" };
            std::format!("{sign}{}.{:04}", value.abs() / 10_000, value.abs() % 10_000)
        };
        let (r, z, q) = (text(clear), text(clear - depth), text(peck));
        let q = if is_pecked { std::format!("Q{q}") } else { std::string::String::new() };
        let line = std::format!("{units} {cycle} R{r} Z{z} {q} F60");
        let mut reader = Reader::new(&Settings::default());
        reader.line(1, line.as_bytes()).unwrap();
        let mut ends = Vec::new();
        for action in actions(&mut reader) {
            if let Action::Move(Block { motion: Motion::Line { to }, feed, .. }) = action
                && feed != Feed::Rapid
            {
                ends.push(to[2].to_mm());
            }
        }
        let scale = if inches { 25.4e-4 } else { 1.0e-4 };
        let count = if is_pecked { pecks } else { 1 };
        assert_eq!(ends.len(), count as usize, "{line}: {ends:?}");
        for (number, end) in (1..).zip(&ends) {
            let down = if number == count { depth } else { peck * number };
            let expected = (clear - down) as f64 * scale;
            assert!((end - expected).abs() < 1.0e-9, "{line}: {ends:?}, {expected}");
        }
    }
}

/// Outputs of M62 to M68, a laser's power, coolant with a lead.
#[cfg(feature = "outputs")]
mod outputs {
    use super::super::{Action, Coolant, Laser, Reader, Reason, Settings};
    use crate::block::{Offset, Output, Power, Switch, Trigger};
    use std::vec::Vec;

    fn read(settings: &Settings, lines: &[&str]) -> Vec<Action> {
        let mut reader = Reader::new(settings);
        let mut actions = Vec::new();
        for (number, line) in lines.iter().enumerate() {
            reader.line(number as u32, line.as_bytes()).unwrap();
            while let Some(action) = reader.action() {
                actions.push(action);
            }
        }
        actions
    }

    #[test]
    fn outputs_switch_with_the_next_motion_or_at_rest() {
        let settings = Settings { switches: true, ..Settings::default() };
        let actions = read(&settings, &["M62 P3 G1 X1 F60", "M65 P3", "M67 E2 Q-1.5", "M68 E0 Q3"]);
        let switches: Vec<_> = actions
            .iter()
            .filter_map(
                |action| if let Action::Switch(switch) = action { Some(*switch) } else { None },
            )
            .collect();
        assert!(matches!(actions[1], Action::Move(_)), "the move comes behind its switch");
        let wanted = [
            Switch::digital(3, true), // in line 0
            Switch { tag: 1, ..Switch::digital(3, false).at(Trigger::Rest) },
            Switch { tag: 2, ..Switch::analogue(2, -1.5) },
            Switch { tag: 3, ..Switch::analogue(0, 3.0).at(Trigger::Rest) },
        ];
        assert_eq!(switches, wanted);
        for line in ["M62 P8", "M67 E0", "M67 Q1", "M62 P0.5"] {
            assert!(Reader::new(&settings).line(1, line.as_bytes()).is_err(), "{line}");
        }
        let refusal = Reader::new(&Settings::default()).line(1, b"M67 E0 Q1").unwrap_err();
        assert!(matches!(refusal.reason, Reason::Unsupported { .. }));
    }

    #[test]
    fn a_laser_has_a_power_and_no_events() {
        let laser = Some(Laser { least: 10.0, most: 1000.0 });
        let settings = Settings { laser, ..Settings::default() };
        let actions = read(
            &settings,
            &[
                "M3 S500",
                "G1 X1 F60",
                "X2 S600",
                "X3 S600",
                "M4",
                "G0 X0",
                "M3",
                "G1",
                "G4 P0.1",
                "M5 S2000",
            ],
        );
        let powers: Vec<_> = actions
            .iter()
            .filter_map(|action| match action {
                Action::Power { power, rest } => Some((*power, *rest)),
                _ => None,
            })
            .collect();
        let wanted = [
            (Power::constant(500.0), false),
            (Power::constant(600.0), false),
            (Power::in_proportion(600.0, 10.0, 1000.0), false),
            (Power::constant(600.0), false),
            (Power::constant(600.0), true),
            (Power::OFF, false),
        ];
        assert_eq!(powers, wanted);
        assert!(!actions.iter().any(|action| matches!(action, Action::Event(_))));
    }

    #[test]
    fn coolant_comes_before_the_motion() {
        let coolant = Some(Coolant { mist: 1, flood: 2, lead: Offset::Time(-0.2) });
        let settings = Settings { coolant, ..Settings::default() };
        let actions = read(&settings, &["M8", "G1 X1 F60", "M9"]);
        let on = Switch::digital(2, true).behind_s(-0.2);
        assert_eq!(actions[0], Action::Switch(on));
        let off = |output| Action::Switch(Switch::digital(output, false).at(Trigger::End));
        assert_eq!(actions[2..], [off(1), off(2)]);
        assert_eq!(on.output, Output::Digital(2));
    }
}

/// A probe is given out by itself, and the line behind it begins where the machine is said to stand.
#[test]
fn a_probe_ends_where_the_caller_says() {
    let z = |mm: f64| Coord::from_mm(mm).unwrap();
    for (code, closes, required) in [
        ("G38.2", true, true),
        ("G38.3", true, false),
        ("G38.4", false, true),
        ("G38.5", false, false),
        ("G31", true, false),
    ] {
        let mut reader = Reader::new(&Settings::default());
        reader.line(1, b"G0 X3 Z5 G54").unwrap();
        assert_eq!(actions(&mut reader).len(), 1);
        let line = std::format!("{code} Z-10 F120");
        reader.line(2, line.as_bytes()).unwrap();
        let Some(Action::Probe(probe)) = reader.action() else { panic!("{code}") };
        assert_eq!((probe.closes, probe.required, probe.tag), (closes, required, 2));
        assert_eq!((probe.to[0], probe.to[2]), (z(3.0), z(-10.0)));
        assert!((probe.feed - 2.0).abs() < 1.0e-12 && reader.action().is_none());
        // Nobody knows where it ends but the machine.
        assert_eq!(reader.line(3, b"G91 G1 X1").unwrap_err().reason, Reason::Busy);
        let mut place = *reader.position();
        place[2] = z(-2.5);
        reader.set_position(&place);
        reader.line(3, b"G91 G1 X1").unwrap();
        let Some(Action::Move(Block { motion: Motion::Line { to }, .. })) = reader.action() else {
            panic!("{code}")
        };
        assert_eq!((to[0], to[2]), (z(4.0), z(-2.5)));
        // Axis words alone are no probe again.
        reader.line(4, line.as_bytes()).unwrap();
        assert!(matches!(reader.action(), Some(Action::Probe(_))));
        reader.set_position(&place);
        assert_eq!(reader.line(5, b"Z1").unwrap_err().reason, Reason::NoMotion);
        for line in ["", "F-1 Z9", "G93 F1 Z9", "I1 Z9", "R1 Z9", "G28 Z9"] {
            let line = std::format!("{code} G90 {line}");
            assert!(reader.line(6, line.as_bytes()).is_err(), "{line}");
        }
    }
    // Where the machine stands there is nothing to probe.
    let mut reader = Reader::new(&Settings::default());
    let refused = reader.line(1, b"G38.2 Z0 F100").unwrap_err();
    assert!(matches!(refused.reason, Reason::Context { .. }));
    assert!(reader.line(1, b"G38.6 Z-1").is_err() && reader.line(1, b"G38 Z-1").is_err());
}
