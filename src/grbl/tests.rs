//! The protocol, with a planner and an interpolator behind it and a servo cycle per round.

use super::store::{Memory, words};
use super::{Inputs, Settings, Spindle, State, Station, Store};
use crate::machine::{AxisLimits, AxisTravel, Config, Limits, Travel};
use crate::number::{Coord, Scalar};
use crate::planner::{Link, Planner, Progress};
use crate::servo::events::Events;
use crate::servo::{Activity, Interpolator, Setpoint};
use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

const BLOCKS: usize = 8;

/// Two pages of memory.
pub(super) struct Pages(pub [Vec<u32>; 2]);

impl Store for Pages {
    fn read(&mut self, copy: usize, at: usize) -> Option<u32> {
        self.0[copy].get(at).copied()
    }

    fn erase(&mut self, copy: usize) -> bool {
        self.0[copy].clear();
        true
    }

    fn write(&mut self, copy: usize, at: usize, word: u32) -> bool {
        assert_eq!(at, self.0[copy].len());
        self.0[copy].push(word);
        true
    }
}

pub(super) struct Rig<'a, S: Scalar> {
    pub station: Station<S, 3>,
    pub planner: Planner<'a, S, 3, BLOCKS, 64>,
    pub interpolator: Interpolator<'a, S, 3>,
    events: Events<4>,
    pub pages: Pages,
    pub inputs: Inputs,
    pub setpoint: Setpoint<S, 3>,
    said: String,
    pub passed: Vec<(u8, u16)>,
    #[cfg(feature = "probe")]
    pub world: super::tests_seek::World,
    #[cfg(feature = "outputs")]
    pub timed: super::tests_outputs::Seen,
}

pub(super) fn with_pages<S: Scalar>(pages: [Vec<u32>; 2], body: impl FnOnce(&mut Rig<'_, S>)) {
    with_bytes(pages, b"", body);
}

/// With bytes that come before the first round.
fn with_bytes<S: Scalar>(pages: [Vec<u32>; 2], bytes: &[u8], body: impl FnOnce(&mut Rig<'_, S>)) {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let mut config = Config::new(Limits::new([axis; 3]).unwrap());
    let coord = |mm: f64| Coord::from_mm(mm).ok();
    config.travel =
        Travel::new([AxisTravel { least: coord(-500.0), greatest: coord(500.0) }; 3]).unwrap();
    let mut link = Box::new(Link::<S, 3, BLOCKS, 64>::new());
    let (planner, mut interpolator) = link.split(config, [Coord::ZERO; 3]).unwrap();
    let setpoint = interpolator.tick();
    let mut rig = Rig {
        station: Station::new(Settings::new(&config, [250.0; 3], [500.0; 3])),
        planner,
        interpolator,
        events: Events::new(),
        pages: Pages(pages),
        inputs: Inputs::default(),
        setpoint,
        said: String::new(),
        passed: Vec::new(),
        #[cfg(feature = "probe")]
        world: super::tests_seek::World::default(),
        #[cfg(feature = "outputs")]
        timed: super::tests_outputs::Seen::default(),
    };
    rig.send(bytes);
    rig.rounds(2);
    body(&mut rig);
}

pub(super) fn with_rig(body: impl Fn(&mut Rig<'_, f32>)) {
    with_pages([Vec::new(), Vec::new()], |rig: &mut Rig<'_, f32>| {
        assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]"]);
        body(rig);
    });
}

impl<S: Scalar> Rig<'_, S> {
    pub fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.station.receive(byte, self.planner.controls());
        }
    }

    pub fn round(&mut self) {
        loop {
            let inputs = self.inputs;
            let progress =
                self.station.poll(&mut self.planner, &self.events, &mut self.pages, inputs);
            while let Some(event) = self.station.event() {
                self.passed.push((event.letter, event.tenths));
            }
            while let Some(byte) = self.station.say(&self.setpoint) {
                self.said.push(char::from(byte));
                self.station.sent();
            }
            if progress != Progress::Planning {
                break;
            }
        }
        self.tick();
    }

    /// A servo cycle.
    fn tick(&mut self) {
        #[cfg(feature = "probe")]
        let before = self.setpoint;
        self.setpoint = self.interpolator.tick();
        self.events.take(&self.setpoint);
        #[cfg(feature = "probe")]
        self.sense(&before);
        #[cfg(feature = "outputs")]
        self.switch();
    }

    /// A round in which nothing that is said can be sent.
    fn deaf_round(&mut self) {
        for _ in 0..50 {
            let inputs = self.inputs;
            self.station.poll(&mut self.planner, &self.events, &mut self.pages, inputs);
        }
        self.station.say(&self.setpoint);
        self.tick();
    }

    pub fn rounds(&mut self, count: u32) {
        for _ in 0..count {
            self.round();
        }
    }

    /// What has been said since it was asked last, by lines.
    pub fn heard(&mut self) -> Vec<String> {
        core::mem::take(&mut self.said).lines().map(String::from).collect()
    }

    /// The answer to a line, without waiting for the motion.
    pub fn ask(&mut self, line: &str) -> Vec<String> {
        self.heard();
        self.send(line.as_bytes());
        self.send(b"\n");
        self.rounds(3);
        self.heard()
    }

    pub fn answer(&mut self, line: &str) -> String {
        self.ask(line).pop().unwrap_or_default()
    }

    pub fn status(&mut self) -> String {
        self.ask_status().pop().unwrap()
    }

    fn ask_status(&mut self) -> Vec<String> {
        self.heard();
        self.send(b"?");
        self.round();
        self.heard()
    }

    /// Rounds until it is idle.
    pub fn settle(&mut self) {
        for _ in 0..20_000 {
            self.round();
            if !matches!(self.station.state(), State::Run | State::Jog | State::Home) {
                self.rounds(2);
                return;
            }
        }
        panic!("it does not come to rest: {:?}", self.station.state());
    }

    pub fn place(&self) -> [i64; 3] {
        [0, 1, 2].map(|axis| self.setpoint.position_nm(axis))
    }
}

pub(super) const MM: i64 = 1_000_000;

#[test]
fn lines_are_answered_and_moves_are_done() {
    with_rig(|rig| {
        for line in ["G21 G90", "", "(comment)", "; another", "%", "N10 G1 X10 F600", "G4 P0.01"] {
            assert_eq!(rig.ask(line), ["ok"], "{line}");
        }
        assert_eq!(rig.station.state(), State::Run);
        rig.settle();
        assert_eq!((rig.place(), rig.station.state()), ([10 * MM, 0, 0], State::Idle));
        assert!(rig.status().starts_with("<Idle|MPos:10.000,0.000,0.000|FS:0,0"));
    });
}

#[test]
fn errors_have_their_published_numbers_and_do_nothing() {
    with_rig(|rig| {
        for (line, number) in [
            ("X", 2),
            ("G1X1.2.3", 2),
            ("#1=2", 1),
            ("G1 X10", 22),
            ("G123", 20),
            #[cfg(not(feature = "probe"))]
            ("G38.2 Z-5 F10", 20),
            ("M98 P1", 20),
            ("G0 G1 X1", 21),
            ("G0 X1 X2", 25),
            ("G2 F100 X1", 35),
            ("G2 X1 Y1 R0.1 F100", 34),
            ("G2 X10 Y0 I3 F100", 33),
            ("G53 G2 X1 Y1 I1 F100", 30),
            ("G80 X1", 31),
            ("G0 X1 P5", 36),
            ("G59.1", 29),
            ("G10 L2 P1", 26),
            ("A5", 20),
            ("T5.5", 38),
            ("$7=1", 3),
            ("$100", 3),
            ("$100=x", 2),
            ("$110=-5", 4),
            ("$0=1", 6),
            ("$20=1", 10),
            ("$H", 5),
            ("$J=X5", 22),
            ("$J=G1 X5 F100", 16),
            ("$J=G0 X1", 16),
            ("$J=X600 F100", 15),
            ("$J=F100", 26),
            ("$N0=G0 X1 X2", 25),
            ("$Nope", 3),
            ("$RST=x", 3),
        ] {
            let modes = rig.ask("$G");
            assert_eq!(rig.answer(line), std::format!("error:{number}"), "{line}");
            assert_eq!(rig.ask("$G"), modes, "{line}");
        }
        assert_eq!(rig.answer(&"G".repeat(300)), "error:11");
        rig.settle();
        assert_eq!((rig.place(), rig.station.state()), ([0; 3], State::Idle));
        // A refused line leaves the coordinates of the next alone.
        assert_eq!(rig.answer("G91 G1 X5 F600 G2"), "error:21");
        assert_eq!(rig.answer("G0 X5"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [5 * MM, 0, 0]);
    });
}

#[test]
fn the_answer_waits_until_the_planner_has_taken_the_line() {
    with_rig(|rig| {
        for line in 0..14 {
            rig.send(std::format!("G1 X{line} Y{} F3000\n", line % 2 * 3).as_bytes());
        }
        rig.rounds(5);
        let before = rig.heard();
        // More than the look-ahead has been cut into cells, and not all.
        assert!((BLOCKS..14).contains(&before.len()), "{before:?}");
        rig.rounds(5);
        assert!(rig.heard().is_empty());
        rig.settle();
        let all = [before, rig.heard()].concat();
        assert_eq!(all, ["ok"; 14]);
        assert_eq!(rig.place(), [13 * MM, 3 * MM, 0]);
    });
}

#[test]
fn a_hold_and_a_start_are_obeyed_at_once() {
    with_rig(|rig| {
        rig.send(b"G1 X50 F3000\nG1 X0\n");
        rig.rounds(300);
        rig.send(b"!");
        rig.round();
        assert!(rig.status().starts_with("<Hold:1|"));
        rig.rounds(200);
        let held = rig.place();
        assert!(rig.status().starts_with("<Hold:0|"));
        rig.rounds(100);
        assert_eq!(rig.place(), held);
        assert_eq!(rig.answer("$J=G91 X1 F100"), "error:8");
        rig.send(b"~");
        rig.rounds(100);
        assert!(rig.status().starts_with("<Run|") && rig.place() != held);
        rig.settle();
        assert_eq!(rig.place(), [0; 3]);
        // The door holds like a hold, and no start goes on while it is open.
        rig.send(b"G1 X50 F3000\n");
        rig.rounds(300);
        rig.inputs.door = true;
        rig.rounds(300);
        let held = rig.place();
        assert!(rig.status().starts_with("<Door:1|MPos"));
        rig.send(b"~");
        rig.rounds(300);
        assert_eq!(rig.place(), held);
        rig.inputs.door = false;
        rig.rounds(300);
        assert!(rig.status().starts_with("<Door:0|MPos") && rig.place() == held);
        rig.send(b"~");
        rig.settle();
        assert_eq!(rig.place(), [50 * MM, 0, 0]);
    });
}

#[test]
fn a_reset_stops_where_it_knows_and_drops_what_waited() {
    with_rig(|rig| {
        rig.send(b"G91 G18 M3 S500\nG1 X50 F3000\nG1 X5\nG1 Y7\n");
        rig.rounds(300);
        let moving = rig.place();
        rig.heard();
        rig.send(b"\x18");
        rig.rounds(300);
        assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]"]);
        let rest = rig.place();
        assert!(rest[0] > moving[0] && rest[1] == 0 && rest[0] < 60 * MM);
        let mm = std::format!("MPos:{:.3},0.000,0.000|", rest[0] as f64 * 1e-6);
        assert!(rig.status().contains(&mm) && rig.station.state() == State::Idle);
        assert_eq!(rig.ask("$G")[0], "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]");
        assert_eq!(rig.answer("G91 G0 X1"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [rest[0] + MM, 0, 0]);
    });
}

#[test]
fn jogs_go_through_the_planner_and_leave_the_modes_alone() {
    with_rig(|rig| {
        let modes = rig.ask("$G");
        assert_eq!(rig.ask("$J=G91 G20 X1 F100"), ["ok"]);
        assert!(rig.status().starts_with("<Jog|"));
        assert_eq!(rig.answer("G0 X1"), "error:9");
        rig.settle();
        assert_eq!(rig.place(), [25_400_000, 0, 0]);
        assert_eq!(rig.ask("$G"), modes);
        // A cancel stops it, and what the program does next begins where it stands.
        assert_eq!(rig.answer("$J=X200 F3000"), "ok");
        rig.rounds(200);
        rig.send(b"\x85");
        rig.settle();
        let rest = rig.place();
        assert!(rest[0] > 26 * MM && rest[0] < 60 * MM, "{rest:?}");
        assert_eq!(rig.answer("G91 G0 Y2"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [rest[0], 2 * MM, 0]);
        // A jog that came before the cancel and had not been read does not begin.
        rig.send(b"$J=G91 X5 F100\n\x85");
        rig.rounds(100);
        assert_eq!(rig.place(), [rest[0], 2 * MM, 0]);
        // In the work's coordinates, and in the machine's.
        rig.ask("G10 L2 P1 X1 Y1 Z1");
        assert_eq!(rig.answer("$J=G90 X0 Y0 Z0 F6000"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [MM; 3]);
        assert_eq!(rig.answer("$J=G53 X0 Y0 Z0 F6000"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [0; 3]);
        // A hold in a jog ends it.
        rig.ask("$J=X100 F3000");
        rig.rounds(100);
        rig.send(b"!");
        rig.settle();
        assert_eq!(rig.station.state(), State::Idle);
    });
}

#[test]
fn a_line_out_of_the_travel_is_an_alarm() {
    with_rig(|rig| {
        rig.send(b"G1 X30 F3000\nG1 X600\nG1 X0\n");
        rig.rounds(500);
        let said = rig.heard();
        let wanted = ["ok", "ALARM:2", "[MSG:'$H'|'$X' to unlock]", "error:15", "error:9"];
        assert_eq!(said, wanted);
        assert!(rig.status().starts_with("<Alarm|"));
        let rest = rig.place();
        assert_eq!(
            (rig.answer("G0 X0"), rig.answer("$J=X0 F100")),
            ("error:9".into(), "error:8".into())
        );
        rig.rounds(50);
        assert_eq!(rig.place(), rest);
        assert_eq!(rig.ask("$X"), ["[MSG:Caution: Unlocked]", "ok"]);
        assert_eq!(rig.answer("G0 X0"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [0; 3]);
    });
}

#[test]
fn switches_lock_the_machine() {
    with_rig(|rig| {
        rig.send(b"G1 X30 F3000\n");
        rig.rounds(100);
        rig.inputs.limits = 1;
        rig.rounds(300);
        // Without hard limits a switch is only told.
        assert!(rig.status().contains("|Pn:X"), "{}", rig.said);
        rig.settle();
        rig.inputs.limits = 0;
        assert_eq!(rig.ask("$21=1"), ["ok"]);
        rig.send(b"M3 S100 G1 X0 F600\n");
        rig.rounds(100);
        assert_eq!(rig.station.accessories().spindle, Spindle::Clockwise);
        rig.inputs.limits = 4;
        rig.rounds(100);
        assert_eq!(rig.station.accessories().spindle, Spindle::Off);
        assert!(rig.heard().contains(&"ALARM:1".into()));
        // Off the switch with the switch pressed.
        assert_eq!(rig.answer("$X"), "ok");
        assert_eq!(rig.answer("$J=G91 Z1 F600"), "ok");
        rig.settle();
        // An emergency stop locks as long as it lasts.
        rig.inputs.stop = true;
        rig.rounds(10);
        assert!(rig.heard().contains(&"ALARM:3".into()));
        assert_eq!(rig.answer("$X"), "error:9");
        rig.inputs.stop = false;
        rig.send(b"\x18");
        rig.rounds(10);
        assert!(rig.status().starts_with("<Alarm|"));
        assert_eq!(rig.answer("$X"), "ok");
    });
}

/// As in grbl: what runs at a start begins no motion where one was cut off. At rest, and in a hold that has come to rest, it runs.
#[test]
fn startup_lines_do_not_follow_a_motion_that_was_cut_off() {
    for (before, meanwhile, runs) in [
        (&b""[..], &b""[..], true),
        (b"G1 X100 F1500\n", b"", false),
        (b"G1 X100 F1500\n", b"!", false),
        (b"$J=X100 F1500\n", b"", false),
        (b"G4 P10\n", b"", false),
        (b"G1 X1 F1500\n", b"", true),
    ] {
        with_rig(|rig: &mut Rig<'_, f32>| {
            assert_eq!(rig.answer("$N0=G0 Y3"), "ok");
            rig.send(before);
            rig.rounds(400);
            rig.send(meanwhile);
            rig.rounds(5);
            // Twice, as some senders do.
            rig.send(b"\x18\x18");
            rig.rounds(600);
            rig.settle();
            let y = rig.place()[1];
            assert_eq!(y, if runs { 3 * MM } else { 0 }, "{before:?} {meanwhile:?}");
            assert!(rig.station.state() == State::Idle);
        });
    }
    with_rig(|rig: &mut Rig<'_, f32>| {
        assert_eq!(rig.answer("$N0=G0 Y3"), "ok");
        rig.send(b"G1 X100 F1500\n");
        rig.rounds(400);
        rig.send(b"!");
        rig.rounds(600);
        assert!(rig.status().starts_with("<Hold:0|"));
        rig.send(b"\x18");
        rig.rounds(600);
        rig.settle();
        assert_eq!(rig.place()[1], 3 * MM);
    });
}

/// A sender may have lines under way when it is told to reset: they were part of what is dropped, and each is answered.
#[test]
fn lines_that_come_while_a_reset_brakes_begin_no_motion() {
    for check in [false, true] {
        with_rig(|rig| {
            if check {
                rig.ask("$C");
            }
            rig.send(b"G91 G1 X50 F3000\nG1 X5\n");
            rig.rounds(300);
            rig.heard();
            rig.send(b"\x18X100\n$J=G91 X5 F1000\n$G\nG1 Z5 X");
            rig.rounds(300);
            rig.send(b"7 F500\n");
            rig.rounds(3);
            let rest = rig.place();
            let heard = rig.heard();
            let modes = "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]";
            let banner = "Grbl 1.1h ['$' for help]";
            let expected = ["", banner, "error:9", "error:8", modes, "ok", "error:9"];
            assert_eq!(heard, expected);
            rig.rounds(300);
            assert!(rest == rig.place() && rest[0] < 50 * MM);
            // What comes behind the banner is done.
            assert_eq!(rig.answer("G91 G0 Y1"), "ok");
            rig.settle();
            assert_eq!(rig.place(), [rest[0], MM, 0]);
        });
    }
}

/// A hold in a jog ends it, and what had come before the hold and had not been read begins nothing.
#[test]
fn a_hold_in_a_jog_is_for_what_waits_too() {
    with_rig(|rig| {
        rig.send(b"$J=G91 X50 F3000\n");
        rig.rounds(100);
        rig.heard();
        rig.send(b"$J=G91 X50 F3000\nG1 Y5 F600\n!");
        rig.rounds(500);
        let rest = rig.place();
        assert_eq!(rig.heard(), ["ok", "error:9"]);
        assert!(rest[0] < 20 * MM && rest[1] == 0 && rig.station.state() == State::Idle);
        assert_eq!(rig.answer("$J=G91 Y1 F600"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [rest[0], MM, 0]);
    });
}

/// What is only checked moves no zero.
#[test]
fn zeros_that_are_set_in_check_mode_are_forgotten() {
    for end in [&b"$C\n"[..], b"\x18"] {
        with_rig(|rig| {
            rig.send(b"G10 L2 P1 X3\n$C\nG10 L2 P1 X40\nG92 Y5\nG0 X9 Y9\n");
            rig.rounds(10);
            rig.send(end);
            rig.rounds(10);
            assert!(rig.ask("$#").contains(&"[G54:3.000,0.000,0.000]".into()));
            assert_eq!(rig.answer("G0 X1 Y1"), "ok");
            rig.settle();
            assert_eq!(rig.place(), [4 * MM, MM, 0]);
        });
    }
}

#[test]
fn a_bracket_that_closes_nothing_joins_no_digits() {
    with_rig(|rig| {
        assert_eq!(rig.answer("$J=G91 X1)0 F600"), "error:1");
        assert_eq!(rig.answer("$J=G91 X1(a)F600"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [MM, 0, 0]);
    });
}

#[test]
fn reports_tell_what_the_mask_asks_for() {
    with_rig(|rig| {
        assert_eq!(rig.status(), "<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>");
        assert_eq!(rig.status(), "<Idle|MPos:0.000,0.000,0.000|FS:0,0|Ov:100,100,100>");
        for _ in 0..7 {
            assert_eq!(rig.status(), "<Idle|MPos:0.000,0.000,0.000|FS:0,0>");
        }
        rig.ask("$10=2");
        rig.ask("G10 L20 P1 X10 Z-1");
        assert_eq!(
            rig.status(),
            "<Idle|WPos:10.000,0.000,-1.000|Bf:8,255|FS:0,0|WCO:-10.000,0.000,1.000>"
        );
        rig.ask("$13=1");
        rig.send(b"\x91\x97\x9A");
        let status = rig.status();
        assert!(status.contains("WPos:0.3937,") && status.contains("|Ov:110,25,110"), "{status}");
        rig.ask("M4 S1000 M7 M8");
        rig.rounds(300);
        let said: String = (0..12).map(|_| rig.status()).collect();
        assert!(said.contains("|A:CFM") && said.contains("|FS:0.0,1000"), "{said}");
    });
}

/// Offsets are told when the motion has come to them, and not when their line is read.
#[test]
fn offsets_are_told_in_time() {
    with_rig(|rig| {
        rig.ask("$10=0");
        rig.send(b"G1 X20 F1200\nG92 X0\nG1 X20\n");
        rig.rounds(100);
        let at = |status: &str| -> f64 {
            let number = status.split(['|', ':', ',']).nth(2).unwrap();
            number.parse().unwrap()
        };
        let status = rig.status();
        assert!((at(&status) - rig.place()[0] as f64 * 1e-6).abs() < 0.1, "{status}");
        rig.settle();
        let status = rig.status();
        assert!((at(&status) - 20.0).abs() < 1e-9 && rig.place()[0] == 40 * MM, "{status}");
    });
}

#[test]
fn check_mode_checks_and_moves_nothing() {
    with_rig(|rig| {
        assert_eq!(rig.ask("$C"), ["[MSG:Enabled]", "ok"]);
        for (line, answer) in [
            ("G1 X10 F100", "ok"),
            ("G91 G2 X10 I5", "ok"),
            ("G2 X10 I2", "error:33"),
            ("M3 S1000", "ok"),
            ("M0", "ok"),
            ("G81 X1 Y1 Z-1 R1 L3", "ok"),
            ("$$", "ok"),
            ("M30", "ok"),
            ("G1 X20", "ok"),
        ] {
            assert_eq!(rig.answer(line), answer, "{line}");
            assert!(rig.status().starts_with("<Check|MPos:0.000,"));
        }
        rig.send(b"$C\n");
        rig.rounds(20);
        assert_eq!(rig.heard(), ["[MSG:Disabled]", "ok", "", "Grbl 1.1h ['$' for help]"]);
        assert_eq!((rig.place(), rig.station.accessories().spindle), ([0; 3], Spindle::Off));
        assert_eq!(rig.ask("$G")[0], "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]");
    });
}

#[test]
fn settings_are_in_force_at_once_and_outlast_power() {
    let mut kept = [Vec::new(), Vec::new()];
    with_pages(kept.clone(), |rig: &mut Rig<'_, f32>| {
        for line in ["$110=600", "$120=100", "$220=1000", "$11=0.05", "$100=400", "G10 L2 P2 X7"] {
            assert_eq!(rig.answer(line), "ok", "{line}");
        }
        assert_eq!(rig.answer("$N0=G55"), "ok");
        assert_eq!(rig.answer("$I=mill"), "ok");
        rig.send(b"G0 X50\n");
        let mut fastest = 0.0f32;
        for _ in 0..4000 {
            rig.round();
            fastest = fastest.max(rig.setpoint.velocity[0]);
            assert!(rig.setpoint.acceleration[0].abs() < 100.5);
        }
        assert!((9.9..10.05).contains(&fastest), "{fastest}");
        rig.settle();
        assert_eq!(rig.answer("$110=500"), "ok");
        rig.ask("G10 L2 P1 Y3");
        rig.rounds(5);
        kept = rig.pages.0.clone();
        assert_eq!(kept[0].len(), words(3));
    });
    with_pages(kept, |rig: &mut Rig<'_, f32>| {
        assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]", ">G55:ok"]);
        let said = rig.ask("$$");
        for line in ["$11=0.050", "$100=400.000", "$110=500.000", "$220=1000.000"] {
            assert!(said.iter().any(|own| own == line), "{line}: {said:?}");
        }
        assert_eq!(said.last().unwrap(), "ok");
        let said = rig.ask("$#");
        assert_eq!(said.len(), 12);
        assert_eq!(said[..2], ["[G54:0.000,3.000,0.000]", "[G55:7.000,0.000,0.000]"]);
        assert_eq!(rig.ask("$N"), ["$N0=G55", "$N1=", "ok"]);
        assert_eq!(rig.ask("$I")[0], "[VER:1.1h.20190825:MILL]");
        assert!(rig.ask("$I")[1].ends_with(",8,255]"));
        assert!(rig.ask("$G")[0].starts_with("[GC:G0 G55 "));
        // And go when that is asked for.
        rig.ask("$RST=*");
        assert!(rig.ask("$$").iter().any(|own| own == "$110=12000.000"));
        assert_eq!(rig.ask("$#")[0], "[G54:0.000,0.000,0.000]");
        let defaults = Memory::new(*rig.station.settings());
        assert_eq!(Memory::load(&mut rig.pages, &defaults), Some(defaults));
    });
}

#[test]
fn settings_need_a_machine_at_rest() {
    with_rig(|rig| {
        rig.send(b"G1 X10 F600\n");
        rig.rounds(20);
        for line in ["$110=100", "$$", "$#", "$N0=G55", "$SLP", "$C", "$RST=$", "$H"] {
            assert_eq!(rig.answer(line), "error:8", "{line}");
        }
        assert_eq!(rig.answer("$G"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [10 * MM, 0, 0]);
    });
}

#[test]
fn a_program_ends_and_another_begins() {
    with_rig(|rig| {
        rig.send(b"G91 G55 M3 S800 M8\nG1 X10 F1200\nT2 M6\nM48\nG0 X1\nM30\n");
        rig.rounds(200);
        assert_eq!(rig.station.accessories().speed.to_bits(), 800.0f32.to_bits());
        rig.settle();
        // It waits for the tool.
        assert!(rig.status().starts_with("<Hold:0|"));
        assert_eq!(rig.passed, [(b'M', 60)]);
        rig.send(b"~");
        rig.settle();
        let said = rig.heard();
        assert_eq!(said[said.len() - 2..], ["[MSG:Pgm End]", "ok"]);
        assert_eq!((rig.place(), rig.passed.len()), ([11 * MM, 0, 0], 2));
        assert!(!rig.station.accessories().flood);
        assert_eq!(rig.ask("$G")[0], "[GC:G1 G54 G17 G21 G90 G94 M5 M9 T2 F1200 S800]");
        assert_eq!(rig.answer("G0 X0"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [0; 3]);
    });
}

/// Whoever does not read learns later; the machine does not wait for that.
#[test]
fn switches_stop_the_machine_when_nobody_reads() {
    with_rig(|rig| {
        rig.ask("$21=1");
        rig.send(b"G1 X50 F600\n");
        rig.rounds(100);
        for _ in 0..50 {
            rig.send(b"$G\n");
            rig.deaf_round();
        }
        rig.inputs.limits = 2;
        for _ in 0..200 {
            rig.deaf_round();
        }
        let rest = rig.place();
        for _ in 0..50 {
            rig.deaf_round();
        }
        assert!(rig.place() == rest && rest[0] < 20 * MM, "{rest:?}");
        rig.rounds(5);
        assert!(rig.heard().contains(&"ALARM:1".into()));
        assert!(rig.status().starts_with("<Alarm|"));
    });
}

#[test]
fn what_sleeps_is_woken_by_a_reset_and_locked() {
    with_rig(|rig| {
        assert_eq!(rig.ask("$SLP"), ["[MSG:Sleeping]", "ok"]);
        assert_eq!(rig.answer("G0 X1"), "error:9");
        assert!(rig.status().starts_with("<Sleep|"));
        rig.send(b"\x18");
        rig.rounds(10);
        assert_eq!(rig.heard().last().unwrap(), "[MSG:'$H'|'$X' to unlock]");
        assert!(rig.status().starts_with("<Alarm|"));
        assert_eq!(rig.answer("$X"), "ok");
    });
}

#[test]
fn an_abort_from_elsewhere_is_an_alarm() {
    with_rig(|rig| {
        rig.send(b"G1 X10 F600\nG1 X20\n");
        rig.rounds(100);
        rig.planner.controls().abort();
        rig.rounds(200);
        assert!(rig.heard().contains(&"ALARM:3".into()));
        assert_eq!(rig.setpoint.activity, Activity::Idle);
        assert!(rig.status().starts_with("<Alarm|"));
    });
}

#[test]
fn a_double_precision_machine_speaks_too() {
    with_pages([Vec::new(), Vec::new()], |rig: &mut Rig<'_, f64>| {
        rig.heard();
        assert_eq!(rig.answer("G1 X1 F600"), "ok");
        rig.settle();
        assert_eq!(rig.place(), [MM, 0, 0]);
    });
}

/// Senders reset what they connect to.
#[test]
fn a_reset_before_anything_else_is_one_start() {
    with_bytes([Vec::new(), Vec::new()], b"junk\x18G0 X1\n", |rig: &mut Rig<'_, f32>| {
        assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]", "ok"]);
        rig.settle();
        assert_eq!(rig.place(), [MM, 0, 0]);
    });
}
