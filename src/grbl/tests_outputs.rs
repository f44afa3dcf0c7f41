//! Outputs in time with the path by the protocol, and a laser.

use super::Spindle;
use super::tests::{MM, Rig, with_rig};
use crate::block::Output;
use crate::number::Scalar;
use crate::servo::Activity;
use std::string::String;
use std::vec::Vec;

/// What has switched, where X was then, and the power of the last servo cycle.
#[derive(Default)]
pub struct Seen {
    pub switched: Vec<(Output, f64, f64)>,
    pub power: f64,
}

impl<S: Scalar> Rig<'_, S> {
    /// Behind the tick.
    pub fn switch(&mut self) {
        let (x, list) = (self.setpoint.position_mm(0), &mut self.timed.switched);
        let power = self.interpolator.switch(&self.setpoint, |switched| {
            if switched.output != Output::Power {
                list.push((switched.output, switched.value.to_f64(), x));
            }
        });
        let percent = f64::from(self.station.accessories().laser);
        self.timed.power = power.to_f64() * percent * 0.01;
        self.station.set_power(self.timed.power as f32);
    }
}

#[test]
fn outputs_switch_with_the_path_and_at_rest() {
    with_rig(|rig| {
        rig.send(b"G1 X5 F1200\nM62 P1\nG1 X10\nM63P1\nM67 E2 Q1.5\nG1 X15\nM64 P3\nM68 E0 Q7\nG1 X16\nM3 S5\nM65 P3\n");
        rig.rounds(10);
        rig.settle();
        assert_eq!(rig.heard(), ["ok"; 11]);
        let seen = core::mem::take(&mut rig.timed.switched);
        let near = |index: usize, output, value: f64, x: f64| {
            let (own, is, at) = seen[index];
            assert!(
                own == output && (is - value).abs() < 1e-6 && (at - x).abs() < 0.03,
                "{seen:?}"
            );
        };
        near(0, Output::Digital(1), 1.0, 5.0);
        near(1, Output::Digital(1), 0.0, 10.0);
        near(2, Output::Analogue(2), 1.5, 10.0);
        near(3, Output::Digital(3), 1.0, 15.0);
        near(4, Output::Analogue(0), 7.0, 15.0);
        near(5, Output::Digital(3), 0.0, 16.0);
        assert_eq!((seen.len(), rig.passed.len()), (6, 0));
        assert_eq!(rig.station.accessories().spindle, Spindle::Clockwise);
        for (line, answer) in [
            ("M62", "error:28"),
            ("M62 P8", "error:23"),
            ("M67 E1", "error:28"),
            ("M62 P-1", "error:4"),
        ] {
            assert_eq!(rig.answer(line), answer, "{line}");
        }
    });
}

/// More switches than can wait, and no motion that would carry them out: each line is answered.
#[test]
fn switches_that_nothing_carries_out_do_not_block_the_line() {
    with_rig(|rig| {
        let mut answers = Vec::new();
        for k in 0..20 {
            answers.push(rig.answer(if k % 2 == 0 { "M62 P0" } else { "M63 P0" }));
        }
        assert_eq!(answers[..16], ["ok"; 16]);
        assert_eq!(answers[16..], [const { "error:11" }; 4]);
        assert_eq!(rig.answer("G1 X5 F600"), "ok");
        rig.settle();
        assert_eq!((rig.timed.switched.len(), rig.place()), (16, [5 * MM, 0, 0]));
        assert_eq!(rig.answer("M62 P0"), "ok");
    });
}

#[test]
fn a_laser_burns_with_the_motion_only() {
    with_rig(|rig| {
        assert_eq!(rig.answer("$32=1"), "ok");
        assert_eq!(rig.answer("M4 S600 F1200"), "ok");
        assert_eq!(rig.ask("$G")[0], "[GC:G0 G54 G17 G21 G90 G94 M4 M9 T0 F1200 S600]");
        rig.rounds(50);
        assert!(rig.timed.power.abs() < 1e-9 && rig.setpoint.activity == Activity::Idle);
        rig.send(b"G1 X10\nX20 S300\nG0 X30\nM3 G1 X40 S500\n");
        let mut seen: [f64; 4] = [0.0; 4];
        let mut proportional = 0;
        for _ in 0..4000 {
            rig.round();
            let (x, speed) = (rig.setpoint.position_mm(0), rig.setpoint.path_speed.to_f64());
            let power = rig.timed.power;
            let leg = ((x / 10.0) as usize).min(3);
            seen[leg] = seen[leg].max(power);
            if (1.0..19.0).contains(&x) && !(9.5..10.5).contains(&x) {
                let full = if x < 10.0 { 600.0 } else { 300.0 };
                let wanted = full * speed / 20.0;
                assert!((power - wanted).abs() < 1.0 + 0.002 * wanted, "{x}: {power} {wanted}");
                proportional += 1;
            }
            if speed.abs() < 1e-9 {
                assert!(power.abs() < 1e-9, "{x}: {power} at rest");
            }
        }
        assert!(proportional > 500, "{proportional}");
        assert!((seen[0] - 600.0).abs() < 1.0 && (seen[1] - 300.0).abs() < 30.0, "{seen:?}");
        assert!(seen[2] < 305.0 && (seen[3] - 500.0).abs() < 0.01, "{seen:?}");
        assert_eq!(rig.place(), [40 * MM, 0, 0]);
        // Off in a rapid, all of it.
        rig.send(b"G0 X20\n");
        for _ in 0..1000 {
            rig.round();
            assert!(rig.timed.power.abs() < 1e-9);
        }
        // Its override, a hold, and what reports tell.
        rig.heard();
        rig.send(b"G1 X40 F600\n");
        rig.rounds(200);
        assert!((rig.timed.power - 500.0).abs() < 0.01);
        rig.send(b"\x9A\x9A");
        rig.rounds(2);
        assert!((rig.timed.power - 600.0).abs() < 0.01);
        assert!(rig.status().contains("|FS:600,600"), "{}", rig.status());
        rig.send(b"!");
        rig.rounds(100);
        assert!(rig.timed.power.abs() < 1e-9 && rig.status().starts_with("<Hold:0|"));
        rig.send(b"~");
        rig.rounds(100);
        assert!((rig.timed.power - 600.0).abs() < 0.01);
        // A reset takes it away before the machine stands.
        rig.send(b"\x18");
        rig.rounds(2);
        assert!(rig.timed.power.abs() < 1e-9 && rig.setpoint.path_speed > 1.0);
        rig.rounds(300);
        rig.send(b"G1 X0 F600\n");
        for _ in 0..3000 {
            rig.round();
            assert!(rig.timed.power.abs() < 1e-9);
        }
    });
}

/// Neither where coordinates are set nor where the machine is locked: M3 is in force all the time.
#[cfg(feature = "home")]
#[test]
fn a_laser_is_dark_while_axes_are_homed_and_while_locked() {
    with_rig(|rig| {
        rig.world.switches = [Some((20.0, 1.0)), Some((30.0, 1.0)), Some((10.0, 1.0))];
        for line in ["$32=1", "$22=1", "$25=1200", "$24=120", "M3 S500 G1 X1 F1200"] {
            assert_eq!(rig.answer(line), "ok", "{line}");
        }
        rig.settle();
        rig.send(b"$H\n");
        let mut set = 0;
        for _ in 0..8000 {
            rig.round();
            set += u32::from(rig.setpoint.activity == Activity::Set);
            assert!(rig.timed.power.abs() < 1e-9, "{:?}", rig.setpoint.activity);
        }
        assert_eq!((set, rig.place()), (1, [-MM; 3]));
        rig.send(b"G1 X-30 F1200\n");
        rig.rounds(300);
        assert!(rig.timed.power > 499.0);
        rig.inputs.stop = true;
        rig.rounds(2);
        assert!(rig.setpoint.path_speed > 1.0);
        for _ in 0..300 {
            assert!(rig.timed.power.abs() < 1e-9);
            rig.round();
        }
    });
}

#[test]
fn a_laser_pierces_and_ends_with_the_program_and_the_mode() {
    with_rig(|rig| {
        rig.ask("$32=1");
        rig.send(b"M3 S400 F600\nG0 X5\nG1\nG4 P0.2\nG1 X10\nM30\n");
        let mut pierced = 0;
        for _ in 0..6000 {
            rig.round();
            pierced +=
                u32::from(rig.setpoint.activity == Activity::Dwelling && rig.timed.power > 399.0);
        }
        assert!((190..=205).contains(&pierced), "{pierced}");
        let said: Vec<String> = rig.heard();
        assert_eq!(said[said.len() - 2..], ["[MSG:Pgm End]", "ok"]);
        let burns = |rig: &mut Rig<'_, f32>, line: &str| {
            rig.ask(line);
            let mut most = 0.0f64;
            for _ in 0..1500 {
                rig.round();
                most = most.max(rig.timed.power);
            }
            most
        };
        assert!(burns(rig, "G1 X0 F2400") < 1e-9);
        assert!(burns(rig, "M3 G1 X10") > 399.0);
        // A spindle again: S and M3 are events.
        assert_eq!(rig.answer("$32=0"), "ok");
        assert!(burns(rig, "G1 X0 F2400 S700") < 1e-9);
        assert!(burns(rig, "M3 G1 X5") < 1e-9);
        assert_eq!(rig.station.accessories().spindle, Spindle::Clockwise);
        assert!((rig.station.accessories().speed - 700.0).abs() < 1e-3);
    });
}
