//! Homing by the protocol.

use super::tests::{MM, Rig, with_pages, with_rig};
use super::{Inputs, State};
use std::format;
use std::string::String;
use std::vec::Vec;

impl Rig<'_, f32> {
    /// Which axes have moved since this was asked.
    fn moved(&mut self) -> [bool; 3] {
        core::mem::take(&mut self.world.moved)
    }
}

/// With switches 20, 30 and 10 mm away, and homing on.
fn with_switches(body: impl Fn(&mut Rig<'_, f32>)) {
    with_rig(|rig| {
        rig.world.switches = [Some((20.0, 1.0)), Some((30.0, 1.0)), Some((10.0, 1.0))];
        for line in ["$22=1", "$25=1200", "$24=60", "$27=2"] {
            assert_eq!(rig.ask(line), ["ok"], "{line}");
        }
        body(rig);
    });
}

#[test]
fn homing_finds_the_switches_z_first_and_answers_when_it_is_done() {
    with_switches(|rig| {
        rig.moved();
        rig.send(b"$H\nG91\n");
        rig.rounds(20);
        assert!(rig.status().starts_with("<Home|MPos:"));
        rig.send(b"\x85\x91");
        while !rig.moved()[0] {
            rig.round();
        }
        // Z is done by then.
        assert!((rig.really(2) - 8.0).abs() < 1e-3, "{}", rig.really(2));
        assert_eq!(rig.heard(), Vec::<String>::new());
        assert_eq!(rig.wait(), ["ok", "ok"]);
        assert_eq!((rig.place(), rig.station.state()), ([-2 * MM; 3], State::Idle));
        for (axis, place) in [18.0, 28.0, 8.0].into_iter().enumerate() {
            // To a servo cycle of the slow approach.
            assert!((rig.really(axis) - place).abs() < 2e-3, "{axis}: {}", rig.really(axis));
        }
        // The lines behind it begin there.
        assert_eq!(rig.answer("G0 X-1"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [-3 * MM, -2 * MM, -2 * MM]);
        // One axis alone.
        rig.moved();
        rig.send(b"$HY\n");
        assert_eq!((rig.wait(), rig.moved()), (["ok".into()].to_vec(), [false, true, false]));
        assert_eq!(rig.place(), [-3 * MM, -2 * MM, -2 * MM]);
    });
}

#[test]
fn homing_on_the_other_side_is_the_other_end_of_the_travel() {
    with_switches(|rig| {
        rig.world.switches = [Some((-12.0, -1.0)), Some((30.0, 1.0)), Some((-7.0, -1.0))];
        for line in ["$23=5", "$130=200", "$132=80"] {
            rig.ask(line);
        }
        rig.send(b"$h\n");
        assert_eq!(rig.wait(), ["ok"]);
        assert_eq!(rig.place(), [-198 * MM, -2 * MM, -78 * MM]);
        assert!((rig.really(0) + 10.0).abs() < 2e-3);
        // Soft limits are those of the travel now.
        assert_eq!(rig.answer("$20=1"), "ok");
        assert_eq!(rig.answer("$J=X-201 F600"), "error:15");
        assert_eq!(rig.answer("$J=X-200 F6000"), "ok");
        rig.settle();
        assert!(rig.ask("G0 X0.001").contains(&"ALARM:2".into()));
        rig.settle();
        rig.ask("$X");
        // Without homing there are none.
        assert_eq!((rig.answer("$22=0"), rig.answer("$20=1")), ("ok".into(), "error:10".into()));
        assert!(rig.ask("$$").contains(&"$20=0".into()));
    });
}

/// A row of holes that leaves the travel behind the look-ahead is not begun.
#[test]
fn a_cycle_is_within_the_travel_as_a_whole() {
    with_switches(|rig| {
        for line in ["$25=3000", "$130=50", "$131=50", "$132=50"] {
            rig.ask(line);
        }
        rig.send(b"$H\n");
        assert_eq!(rig.wait(), ["ok"]);
        assert_eq!(rig.answer("$20=1"), "ok");
        let place = rig.place();
        let x = (place[0] + 50 * MM) / (3 * MM);
        for (line, fits) in [
            (std::format!("G91 G81 X-3 Z-1 R0 L{x} F3000"), true),
            (std::format!("G91 G81 X-3 Z-1 R0 L{} F3000", x + 1), false),
            ("G91 G81 X-3 Z-51 R0 L2 F3000".into(), false),
            ("G91 G83 X-3 Z-1 R-1 Q.1 L2 F3000".into(), true),
        ] {
            rig.send(std::format!("{line}\n").as_bytes());
            rig.rounds(50);
            rig.settle();
            let said = rig.heard();
            assert_eq!(said.contains(&"ok".into()), fits, "{line}: {said:?}");
            assert_eq!(said.contains(&"error:15".into()), !fits, "{line}: {said:?}");
            let moved = rig.place() != place;
            assert_eq!(moved, fits, "{line}");
            rig.ask("$X");
            rig.ask("G90 G80");
            for (axis, letter) in ["X", "Y", "Z"].iter().enumerate().rev() {
                rig.ask(&std::format!("G53 G0 {letter}{}", place[axis] as f64 * 1e-6));
            }
            rig.settle();
            assert_eq!(rig.place(), place);
        }
    });
}

#[test]
fn a_machine_with_homing_is_locked_when_it_is_switched_on() {
    let mut kept = [Vec::new(), Vec::new()];
    with_pages(kept.clone(), |rig: &mut Rig<'_, f32>| {
        for line in ["$22=1", "$25=1200", "$N0=G91"] {
            assert_eq!(rig.answer(line), "ok");
        }
        kept = rig.pages.0.clone();
    });
    with_pages(kept, |rig: &mut Rig<'_, f32>| {
        rig.world.switches = [Some((20.0, 1.0)), Some((30.0, 1.0)), Some((10.0, 1.0))];
        assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]", "[MSG:'$H'|'$X' to unlock]"]);
        assert!(rig.status().starts_with("<Alarm|"));
        assert_eq!(
            (rig.answer("G0 X1"), rig.answer("$J=X1 F100")),
            ("error:9".into(), "error:8".into())
        );
        // A reset does not open it, nor does an abort of anything.
        rig.send(b"\x18");
        rig.rounds(10);
        assert_eq!(rig.heard().last().unwrap(), "[MSG:'$H'|'$X' to unlock]");
        rig.send(b"$H\n");
        assert_eq!(rig.wait(), ["ok", ">G91:ok"]);
        assert_eq!(rig.station.state(), State::Idle);
        // And after that a reset leaves it open.
        rig.send(b"\x18");
        rig.rounds(10);
        assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]", ">G91:ok"]);
    });
}

#[test]
fn homing_that_cannot_be_is_refused_by_number() {
    with_rig(|rig| {
        assert_eq!(rig.answer("$H"), "error:5");
        rig.ask("$22=1");
        for (line, number) in [("$HQ", 3), ("$HA", 3), ("$HXY", 3), ("$25=0", 4), ("$27=0", 4)] {
            assert_eq!(rig.answer(line), format!("error:{number}"), "{line}");
        }
        rig.ask("$130=0");
        // X has no travel in which to look.
        assert_eq!(rig.answer("$H"), "error:4");
        rig.ask("$130=500");
        rig.send(b"G1 X10 F600\n");
        rig.rounds(50);
        assert_eq!(rig.answer("$H"), "error:8");
        rig.settle();
        rig.send(b"!");
        rig.rounds(10);
        assert_eq!(rig.answer("$H"), "error:8");
        rig.send(b"~");
        rig.inputs.door = true;
        rig.rounds(10);
        assert_eq!(rig.answer("$H"), "error:8");
        rig.inputs.door = false;
        rig.send(b"~");
        rig.rounds(10);
        rig.ask("$C");
        assert_eq!(rig.answer("$H"), "error:8");
        assert_eq!(rig.place(), [10 * MM, 0, 0]);
    });
}

#[test]
fn homing_that_fails_locks_the_machine_and_says_why() {
    type Case = (fn(&mut Rig<'_, f32>), u8);
    let cases: [Case; 4] = [
        (|rig| rig.world.missing[2] = true, 9),
        (|rig| rig.world.missing[1] = true, 9),
        (|rig| rig.world.stuck[0] = true, 8),
        (|rig| rig.world.stuck[2] = true, 8),
    ];
    for (rigged, number) in cases {
        with_switches(|rig| {
            rig.ask("$132=20");
            rig.ask("$131=40");
            rigged(rig);
            rig.send(b"$H\nG0 X1\n");
            let mut said = rig.wait();
            rig.rounds(500);
            said.append(&mut rig.heard());
            let alarm = format!("ALARM:{number}");
            let wanted = [&alarm, "[MSG:'$H'|'$X' to unlock]", "error:9", "error:9"];
            assert_eq!(said, wanted);
            assert!(rig.status().starts_with("<Alarm|"));
            let place = rig.place();
            rig.rounds(200);
            assert_eq!(rig.place(), place);
            // Coordinates are as they were, and all goes on when it is repaired.
            assert!((rig.really(1) * 1e6 - place[1] as f64).abs() < 1.0);
            (rig.world.missing, rig.world.stuck) = ([false; 3], [false; 3]);
            rig.ask("$X");
            rig.ask("G0 X0 Y0 Z0");
            rig.settle();
            rig.heard();
            rig.send(b"$H\n");
            assert_eq!((rig.wait(), rig.place()), (["ok".into()].to_vec(), [-2 * MM; 3]));
        });
    }
}

#[test]
fn whatever_stops_homing_leaves_the_machine_locked_and_at_rest() {
    let says = |rig: &mut Rig<'_, f32>| {
        rig.rounds(400);
        let (said, place) = (rig.heard(), rig.place());
        rig.rounds(100);
        assert_eq!(rig.place(), place);
        said
    };
    for moment in (10..1500).step_by(97) {
        with_switches(|rig| {
            rig.send(b"$H\n$G\n");
            rig.rounds(moment);
            rig.send(b"\x18");
            let lock = "[MSG:'$H'|'$X' to unlock]";
            let said = says(rig);
            assert_eq!(said, ["ALARM:6", "", "Grbl 1.1h ['$' for help]", lock]);
            assert!(rig.status().starts_with("<Alarm|"));
            assert_eq!(rig.answer("$X"), "ok");
            rig.send(b"$H\n");
            rig.rounds(moment);
            rig.inputs.door = true;
            assert_eq!(says(rig), ["ALARM:7", lock, "error:9"]);
            assert_eq!(rig.answer("$H"), "error:13");
            rig.inputs.door = false;
            rig.send(b"$H\n");
            rig.rounds(moment);
            rig.send(b"\x84");
            assert_eq!(says(rig), ["ALARM:7", lock, "error:9"]);
            rig.send(b"$H\n");
            rig.rounds(moment);
            rig.inputs.stop = true;
            assert_eq!(says(rig), ["ALARM:3", lock, "error:9"]);
            assert_eq!(rig.answer("$H"), "error:9");
            rig.inputs.stop = false;
            // A hold keeps its place, and a start goes on.
            rig.send(b"$H\n");
            rig.rounds(moment);
            rig.send(b"!");
            rig.rounds(200);
            assert!(rig.status().starts_with("<Hold:0|"));
            let place = rig.place();
            rig.rounds(100);
            assert_eq!(rig.place(), place);
            rig.send(b"~");
            rig.rounds(10);
            assert!(rig.status().starts_with("<Home|"));
            assert_eq!((rig.wait(), rig.place()), (["ok".into()].to_vec(), [-2 * MM; 3]));
        });
    }
}

#[test]
fn hard_limits_do_not_mind_homing() {
    with_switches(|rig| {
        rig.ask("$21=1");
        rig.send(b"$H\n");
        assert_eq!((rig.wait(), rig.inputs), (["ok".into()].to_vec(), Inputs::default()));
        rig.send(b"G0 X5\n");
        rig.rounds(1000);
        assert!(rig.heard().contains(&"ALARM:1".into()));
    });
}
