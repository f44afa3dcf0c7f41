//! Probes by the protocol: a machine that runs into a plate, and into its home switches.

use super::State;
use super::tests::{MM, Rig, with_rig};
use crate::number::Scalar;
use crate::servo::{Activity, Input, Setpoint};
use std::format;
use std::string::String;
use std::vec::Vec;

/// What is in the way, in the coordinates that the machine has at the start.
#[derive(Default)]
pub struct World {
    /// Where home switches close, mm, and on which side.
    pub switches: [Option<(f64, f64)>; 3],
    /// Where the probe closes, Z downwards.
    plate: Option<f64>,
    /// Switches that stay closed, or open, whatever happens.
    pub stuck: [bool; 3],
    pub missing: [bool; 3],
    /// Where the machine is, less what setpoints say.
    shift: [f64; 3],
    /// Which axes have moved.
    pub moved: [bool; 3],
}

impl<S: Scalar> Rig<'_, S> {
    pub fn really(&self, axis: usize) -> f64 {
        self.setpoint.position_mm(axis) + self.world.shift[axis]
    }

    /// The inputs as they are at the end of the servo cycle that ends with the setpoint.
    pub fn sense(&mut self, before: &Setpoint<S, 3>) {
        let inputs = self.planner.inputs();
        for axis in 0..3 {
            let way = self.setpoint.position_mm(axis) - before.position_mm(axis);
            if self.setpoint.activity == Activity::Set {
                self.world.shift[axis] -= way;
            } else {
                self.world.moved[axis] |= way.abs() > 1e-9;
            }
            let Some((place, side)) = self.world.switches[axis] else { continue };
            let reached = side * (self.really(axis) - place) >= 0.0;
            let closed = (reached || self.world.stuck[axis]) && !self.world.missing[axis];
            inputs.tell(Input::Home(axis), closed, 1.0);
            let bit = 1 << axis;
            self.inputs.limits =
                if closed { self.inputs.limits | bit } else { self.inputs.limits & !bit };
        }
        let contact = self.world.plate.is_some_and(|plate| self.really(2) <= plate);
        inputs.tell(Input::Probe, contact, 1.0);
        self.inputs.probe = contact;
    }

    /// Rounds until something but a report is said.
    pub fn wait(&mut self) -> Vec<String> {
        for _ in 0..60_000 {
            self.round();
            let said = self.heard();
            if !said.is_empty() {
                return said;
            }
        }
        panic!("nothing is said: {:?}", self.station.state());
    }
}

#[test]
fn a_probe_is_answered_when_it_is_over() {
    with_rig(|rig| {
        rig.world.plate = Some(-3.5);
        rig.send(b"M3 S100 G1 X2 F1200\nG38.2 Z-10 F300\nG91\nG0 Z1\n");
        rig.rounds(100);
        assert_eq!(rig.heard(), ["ok"]);
        assert!(rig.status().starts_with("<Run|MPos:"));
        rig.send(b"\x85");
        let mut said = rig.wait();
        rig.rounds(20);
        said.append(&mut rig.heard());
        let [probed, "ok", "ok", "ok"] =
            [&said[0], &said[1], &said[2], &said[3]].map(String::as_str)
        else {
            panic!("{said:?}")
        };
        // To a servo cycle at 5 mm/s, and in front of where it came to rest.
        let z: f64 = probed.strip_prefix("[PRB:2.000,0.000,").unwrap()[..6].parse().unwrap();
        assert!((z + 3.5).abs() <= 0.006 && probed.ends_with(":1]"), "{probed}");
        rig.settle();
        let rest = rig.place()[2] as f64 * 1e-6;
        assert!((-2.6..-2.5).contains(&rest), "{rest}");
        assert!(rig.ask("$#").contains(&String::from(probed)));
        // Away from it.
        rig.ask("G90 G0 Z-3");
        rig.settle();
        assert_eq!(rig.answer("G1 Z-4 F600"), "ok");
        rig.settle();
        rig.send(b"G38.4 Z0 F300\n");
        let said = rig.wait();
        assert!(
            said[0].starts_with("[PRB:2.000,0.000,-3.49") && said[0].ends_with(":1]"),
            "{said:?}"
        );
        // The motion mode ends with a probe.
        assert_eq!(rig.answer("Z0"), "error:31");
        rig.send(b"\x18");
        rig.rounds(10);
        assert!(rig.ask("$#").contains(&"[PRB:0.000,0.000,0.000:0]".into()));
    });
}

/// A sender that retracts by an inch after a probe that has found nothing does not send the machine elsewhere.
#[test]
fn modes_and_offsets_outlast_the_alarm_of_a_probe() {
    with_rig(|rig| {
        rig.world.plate = Some(-3.5);
        for line in ["G10 L2 P2 X1", "G55 G20 G91 F30", "G92 Z0.5", "G43.1 Z0.25"] {
            assert_eq!(rig.answer(line), "ok", "{line}");
        }
        let before = (rig.ask("$G"), rig.ask("$#"));
        rig.send(b"G38.2 Z-0.01\n");
        let said = rig.wait();
        assert_eq!((said[0].as_str(), said.last().unwrap().as_str()), ("ALARM:5", "ok"));
        rig.rounds(50);
        rig.ask("$X");
        // The motion mode ends with a probe.
        let modes = |said: &[String]| said[0].replace("G80 ", "").replace("G0 ", "");
        let after = (rig.ask("$G"), rig.ask("$#"));
        assert_eq!(modes(&after.0), modes(&before.0));
        let offsets = |said: &[String]| -> Vec<String> {
            said.iter().filter(|said| !said.starts_with("[PRB")).cloned().collect()
        };
        assert_eq!(offsets(&after.1), offsets(&before.1));
        let [x, y, z] = rig.place();
        assert_eq!(rig.answer("G0 Z0.5"), "ok");
        rig.rounds(3000);
        assert_eq!(rig.place(), [x, y, z + 127 * MM / 10]);
    });
}

#[test]
fn probes_that_fail_have_their_published_alarms() {
    with_rig(|rig| {
        rig.world.plate = Some(-3.5);
        // No contact: with and without an error.
        rig.send(b"G38.3 Z-1 F600\n");
        assert_eq!(rig.wait(), ["[PRB:0.000,0.000,-1.000:0]", "ok"]);
        rig.send(b"G38.2 Z-2 F600\nG0 X1\n");
        let mut said = rig.wait();
        rig.rounds(50);
        said.append(&mut rig.heard());
        let lock = "[MSG:'$H'|'$X' to unlock]";
        assert_eq!(said, ["ALARM:5", lock, "[PRB:0.000,0.000,-2.000:0]", "ok", "error:9"]);
        assert!(rig.status().starts_with("<Alarm|"));
        assert_eq!((rig.answer("$X"), rig.place()), ("ok".into(), [0, 0, -2 * MM]));
        // Already as it would be at the end.
        for line in ["G38.4 Z0 F600", "G38.5 Z0 F600"] {
            rig.heard();
            rig.send(line.as_bytes());
            rig.send(b"\n");
            let said = rig.wait();
            assert_eq!(said, ["ALARM:4", lock, "ok"], "{line}");
            rig.rounds(10);
            rig.ask("$X");
        }
        assert_eq!(rig.place(), [0, 0, -2 * MM]);
        // What is refused does nothing. (Feeds have outlasted the alarms.)
        rig.send(b"\x18");
        rig.rounds(10);
        for (line, number) in [
            ("G38.2 F100", 26),
            ("G38.2 Z-2 F100", 20),
            ("G38.2 Z-9", 22),
            ("G93 G38.2 Z-9 F100", 20),
            ("G38.6 Z-9 F100", 20),
            ("G0 G38.2 Z-9 F100", 21),
        ] {
            assert_eq!(rig.answer(line), format!("error:{number}"), "{line}");
        }
        assert_eq!(rig.ask("G38.2 Z-600 F600"), ["ALARM:2", lock, "error:15"]);
        rig.rounds(10);
        rig.ask("$X");
        // In check mode it is only read.
        rig.ask("$C");
        assert_eq!(
            (rig.ask("G38.2 Z-9 F600"), rig.ask("G91 G0 Z2")),
            (["ok".into()].to_vec(), ["ok".into()].to_vec())
        );
        assert_eq!(rig.place(), [0, 0, -2 * MM]);
    });
}

#[test]
fn probes_are_stopped_and_held_at_any_moment() {
    for moment in (2..900).step_by(53) {
        with_rig(|rig| {
            rig.world.plate = Some(-3.5);
            rig.send(b"G1 X1 F1200\nG38.2 Z-10 F600\nG4 P0\n");
            rig.rounds(moment);
            rig.send(b"!");
            rig.rounds(200);
            assert_eq!(rig.station.state(), State::Hold { rests: true });
            let place = rig.place();
            rig.rounds(100);
            assert_eq!(rig.place(), place);
            rig.send(b"~");
            rig.rounds(1000);
            let said = rig.heard();
            let probes = said.iter().filter(|said| said.starts_with("[PRB:1.000,0.000,-3.50"));
            assert_eq!(probes.count(), 1, "{moment}: {said:?}");
            assert_eq!(said.iter().filter(|said| *said == "ok").count(), 3, "{moment}: {said:?}");
            rig.settle();
            rig.ask("G0 Z0");
            rig.settle();
            rig.heard();
            rig.send(b"G38.3 Z-10 F600\nG0 X7\n");
            rig.rounds(moment.min(300));
            rig.send(b"\x18");
            rig.rounds(300);
            assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]"]);
            let place = rig.place();
            rig.rounds(200);
            assert_eq!((rig.place(), rig.station.state()), (place, State::Idle));
            // The next line begins where it stands.
            assert_eq!(rig.answer("G91 G0 Z1"), "ok");
            rig.settle();
            assert_eq!(rig.place(), [place[0], 0, place[2] + MM]);
        });
    }
}
