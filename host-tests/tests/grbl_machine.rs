//! Senders of grbl against a machine with switches, a plate to probe, outputs and a laser: homing, probes and all else at random, and a
//! whole controller over a line.

#[path = "common/grbl.rs"]
mod rig;

use rig::{AXES, Draws, MM, Rig, World, with_world};
use splineway::grbl::State;
use splineway::{Activity, Output, Scalar};

/// In the coordinates of the start, where travel ends at 0: switches behind that, a plate above the bottom.
const EDGES: [f64; AXES] = [0.3, 0.7, 0.2];
const PLATE: f64 = -15.0;
const WORLD: World = World {
    start: -10.0,
    travel: [-20.0, 0.0],
    switches: &["X>0.3", "Y>0.7", "Z>0.2"],
    surfaces: &["Z<-15"],
};

/// Sets up homing, in short. The way back is longer than the machine goes on behind a switch, wherever it is stopped there.
fn set_up<S: Scalar>(rig: &mut Rig<'_, '_, S>) {
    for line in ["$22=1", "$24=300", "$25=1200", "$27=2", "$130=20", "$131=20", "$132=20"] {
        assert_eq!(rig.ask(line), ["ok"], "{line}");
    }
}

/// Within a cycle the edge is known: the place is exact, in either scalar.
fn home_and_probe<S: Scalar>() {
    with_world::<S>(&WORLD, |rig| {
        set_up(rig);
        assert_eq!(rig.ask("$H"), ["ok"]);
        assert_eq!(rig.place(), [-2 * MM; AXES]);
        for (axis, edge) in EDGES.into_iter().enumerate() {
            assert!((rig.really(axis) - (edge - 2.0)).abs() < 1e-5, "{axis}: {}", rig.really(axis));
        }
        let said = rig.ask("G38.2 Z-20 F600");
        // The plate in the new coordinates.
        assert_eq!(said, ["[PRB:-2.000,-2.000,-15.200:1]", "ok"]);
        assert!((-15.5..-15.2).contains(&rig.board.setpoint.position_mm(2)));
        // As senders find the top of the work.
        rig.ask("G10 L20 P1 Z0");
        let said = rig.ask("G91 G38.4 Z2 F60");
        assert_eq!(said, ["[PRB:-2.000,-2.000,-15.200:1]", "ok"]);
        assert_eq!(rig.ask("G90 G53 G0 Z-1"), ["ok"]);
        assert_eq!(rig.place(), [-2 * MM, -2 * MM, -MM]);
    });
}

#[test]
fn homing_and_probes_are_exact_to_the_edge() {
    home_and_probe::<f32>();
    home_and_probe::<f64>();
}

const LINES: [&str; 36] = [
    "$H",
    "$H",
    "$HX",
    "$HY",
    "$HZ",
    "$H (home)",
    "G38.2 Z-19 F1500",
    "G38.2 Z-12 F600",
    "G38.3 Z-19 F900",
    "G38.3 X-1 F3000",
    "G38.4 Z-1 F1500",
    "G38.5 Z-14 F600",
    "G91 G38.3 Z-1 F300",
    "M3 S100 G38.3 Z-19 F900",
    "G90",
    "G53 G0 Z-2",
    "G53 G0 X-3 Y-4",
    "G53 G1 X-18 Y-1 F4000",
    "G1 X-15 Y-5 Z-3 F3000",
    "G2 X-10 Y-10 R15 F2000",
    "$J=G53 X-2 Y-9 F3000",
    "$J=G91 Z1 F900",
    "G4 P0.01",
    "M62 P1",
    "M63 P1",
    "M64 P2",
    "M65 P2",
    "M67 E1 Q2.5",
    "M4 S500 G53 G1 X-16 F900",
    "M3 S200 G53 G1 X-5 F900",
    "M3 S900 G53 G1 X-12 F600",
    "$32=1",
    "$32=1",
    "$32=0",
    "$X",
    "$#",
];

/// What has been seen: homing done, edges of probes, alarms by their number, holds of either.
#[derive(Default)]
struct Seen {
    homed: u32,
    probed: u32,
    alarms: [u32; 10],
    held: u32,
    burnt: u32,
}

/// What may come in a session, by what has been sent.
#[derive(Default)]
struct Sent {
    reset: bool,
    door: bool,
    stop: bool,
}

/// Lines and commands at any time, with one answer per line; every alarm for its reason, coordinates that fit the switches, and no
/// motion and no light that nobody asked for.
fn session(seed: u64, seen: &mut Seen) {
    let mut draws = Draws(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    with_world::<f32>(&WORLD, |rig| {
        set_up(rig);
        let (mut asked, mut answered) = (0u32, 0u32);
        let mut before = (rig.place(), rig.background.state());
        let (mut line_came, mut start_came) = (false, false);
        let mut shift = rig.seeker.shift;
        let mut sent = Sent::default();
        for cycle in 0..40_000 {
            let mut bytes = Vec::new();
            match draws.below(1500) {
                0..=12 if asked - answered < 6 => {
                    bytes.extend_from_slice(LINES[draws.below(LINES.len())].as_bytes());
                    bytes.push(b'\n');
                }
                13 | 14 => bytes.push(*b"!~~?\x84\x85\x85\x91\x9A".get(draws.below(9)).unwrap()),
                15 | 16 => bytes.push(b'~'),
                17 if draws.below(5) == 0 => bytes.push(0x18),
                18 | 19 => rig.board.inputs.door = draws.below(10) == 0,
                20 => rig.board.inputs.stop = draws.below(12) == 0,
                21 | 22 => bytes.extend_from_slice(b"$X\n"),
                _ => {}
            }
            sent.door |= rig.board.inputs.door || bytes.contains(&0x84);
            sent.stop |= rig.board.inputs.stop;
            if bytes == [0x18] {
                sent.reset = true;
                rig.send(&bytes);
                rig.cycle();
                listen(rig, &mut answered, &mut sent, seen, seed);
                (asked, answered) = (0, 0);
                before = (rig.place(), rig.background.state());
                continue;
            }
            if bytes.last() == Some(&b'\n') {
                asked += 1;
                line_came = true;
            }
            start_came |= bytes == b"~";
            let rested = rig.board.setpoint.activity == Activity::Idle;
            rig.send(&bytes);
            rig.cycle();
            listen(rig, &mut answered, &mut sent, seen, seed);
            assert!(answered <= asked, "seed {seed}, {cycle}: {answered} answers to {asked} lines");
            let now = (rig.place(), rig.background.state());
            if rig.board.setpoint.activity == Activity::Set {
                fits(rig, &mut shift, seed);
                seen.homed += 1;
            } else {
                watch((before, now), rested, (line_came, start_came), seed);
            }
            let light = rig.board.power > 0.0;
            seen.burnt += u32::from(light);
            let dark = !matches!(
                rig.board.setpoint.activity,
                Activity::Running | Activity::Dwelling | Activity::Event
            );
            let locked = now.1 == State::Alarm;
            assert!(!(light && (dark || locked)), "seed {seed}: light while {:?}", now.1);
            let asks = is_still(now.1) && answered == asked;
            if asks && now.1 != before.1 {
                (line_came, start_came) = (false, false);
            }
            seen.held += u32::from(matches!(now.1, State::Hold { .. }) && now.1 != before.1);
            before = now;
        }
        // Whatever has been left open, every line is answered.
        (rig.board.inputs.door, rig.board.inputs.stop) = (false, false);
        for _ in 0..60 {
            rig.cycles(400);
            rig.send(b"~");
            listen(rig, &mut answered, &mut sent, seen, seed);
        }
        assert_eq!(answered, asked, "seed {seed}: lines without an answer");
        rig.send(b"\x18");
        rig.cycles(600);
        rig.ask("$X");
        // And the machine homes.
        assert_eq!(rig.ask("$H").last().unwrap(), "ok");
        assert_eq!(rig.place(), [-2 * MM; AXES]);
        assert_eq!(rig.ask("G53 G0 X-3 Y-4 Z-5"), ["ok"]);
        assert_eq!(rig.place(), [-3 * MM, -4 * MM, -5 * MM]);
    });
}

fn is_still(state: State) -> bool {
    matches!(state, State::Idle | State::Check | State::Hold { rests: true })
        || matches!(state, State::Door { rests: true, .. })
}

/// Nothing leaves a rest by itself.
fn watch(
    (before, now): (([i64; AXES], State), ([i64; AXES], State)),
    rested: bool,
    (line_came, start_came): (bool, bool),
    seed: u64,
) {
    let moves = now.0 != before.0;
    if is_still(before.1) && is_still(now.1) {
        assert!(!moves, "seed {seed}: motion while {:?}", now.1);
    }
    if moves && is_still(before.1) {
        let good = if before.1 == State::Idle { line_came } else { start_came };
        assert!(good, "seed {seed}: {:?} is left, and nobody has asked for it", before.1);
    }
    // What is locked may still brake.
    assert!(!(moves && rested && now.1 == State::Alarm), "seed {seed}: motion while locked");
}

/// Coordinates have been set: of the axes whose coordinates have changed, the edge is 0.
fn fits(rig: &Rig<'_, '_, f32>, shift: &mut [f64; 9], seed: u64) {
    for axis in 0..AXES {
        if (rig.seeker.shift[axis] - shift[axis]).abs() > 1e-9 {
            let edge = EDGES[axis] - rig.seeker.shift[axis];
            assert!(edge.abs() < 2e-5, "seed {seed}: axis {axis} has its edge at {edge}");
        }
    }
    *shift = rig.seeker.shift;
}

fn listen(
    rig: &mut Rig<'_, '_, f32>,
    answered: &mut u32,
    sent: &mut Sent,
    seen: &mut Seen,
    seed: u64,
) {
    for said in rig.heard() {
        *answered += u32::from(said == "ok" || said.starts_with("error:"));
        if let Some(number) = said.strip_prefix("ALARM:") {
            let number: usize = number.parse().unwrap();
            seen.alarms[number] += 1;
            let reason = match number {
                2 | 4 | 5 => true,
                3 => sent.stop,
                6 => sent.reset,
                7 => sent.door,
                // Hard limits are off, and the switches are good.
                _ => false,
            };
            assert!(reason, "seed {seed}: {said}");
            // A line that waits behind the others may unlock it at once.
            let locked = number != 6 || rig.background.state() == State::Alarm;
            assert!(locked, "seed {seed}: {said}");
        }
        if said.starts_with("Grbl") {
            sent.reset = false;
        }
        if let Some(place) = said.strip_prefix("[PRB:").and_then(|said| said.strip_suffix(":1]")) {
            let z: f64 = place.rsplit(',').next().unwrap().parse().unwrap();
            let really = z + rig.seeker.shift[2];
            assert!((really - PLATE).abs() < 6e-4, "{said}, which is at {really}");
            seen.probed += 1;
        }
    }
}

#[test]
fn whatever_comes_homing_and_probes_keep_their_word() {
    let mut seen = Seen::default();
    for seed in 0..24 {
        session(seed, &mut seen);
    }
    let Seen { homed, probed, alarms, held, burnt } = seen;
    let all = format!("homed {homed}, probed {probed}, alarms {alarms:?}, held {held}, {burnt}");
    assert!(homed > 24 && probed > 24 && held > 100 && burnt > 100, "{all}");
    assert!([3, 4, 5, 6, 7].into_iter().all(|number: usize| alarms[number] > 0), "{all}");
}

#[test]
fn outputs_and_a_laser_go_with_the_path() {
    with_world::<f32>(&WORLD, |rig| {
        rig.ask("$32=1");
        rig.send(b"G53 G0 X-18\nM4 S800 F3000\nM62 P0\nG53 G1 X-10\nM63 P0\nG53 G1 X-4 S0\nM5\n");
        let mut most = 0.0f64;
        for _ in 0..2000 {
            rig.cycle();
            let x = rig.board.setpoint.position_mm(0);
            let on = rig.switched.iter().rfind(|(output, _)| *output == Output::Digital(0));
            if on.is_some_and(|(_, value)| *value > 0.5) {
                assert!((-18.01..-9.9).contains(&x), "on at {x}");
            }
            if rig.board.power > 0.0 {
                assert!((-18.01..-9.9).contains(&x), "light at {x}");
                let wanted = 800.0 * f64::from(rig.board.setpoint.path_speed) / 50.0;
                assert!((rig.board.power - wanted).abs() < 1.0, "{x}: {}", rig.board.power);
            }
            most = most.max(rig.board.power);
        }
        assert!((most - 800.0).abs() < 1.0, "{most}");
        assert_eq!(rig.place()[0], -4 * MM);
    });
}

#[cfg(unix)]
mod over_a_line {
    use splineway_host::stream::{Doing, Grbl, Kept, Line};
    use splineway_simulator::machine::Machine;
    use std::io::{Read, Write};
    use std::net::TcpStream;
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    const MACHINE: &str = "\
switches = [\"X>12\", \"Y>9\", \"Z>4\"]
surfaces = [\"Z<-25\"]
[axes.default]
velocity = 200
acceleration = 2000
jerk = 50000
";

    fn until(port: &mut TcpStream, bytes: &[u8], text: &str) -> String {
        port.write_all(bytes).unwrap();
        let (mut heard, began) = (String::new(), Instant::now());
        let mut chunk = [0; 256];
        while !heard.contains(text) {
            assert!(began.elapsed() < Duration::from_secs(30), "no {text:?} in {heard:?}");
            if let Ok(count) = port.read(&mut chunk) {
                heard += std::str::from_utf8(&chunk[..count]).unwrap();
            }
        }
        heard
    }

    /// A sender homes the machine of a file, probes its plate, switches an output and burns.
    #[test]
    fn the_machine_of_a_file_is_homed_and_probed() {
        let line = Line::network(0).unwrap();
        let name = line.name().to_owned();
        let (sender, told) = channel();
        std::thread::spawn(move || {
            let machine = Machine::parse(MACHINE).unwrap();
            let kept = Kept::new(3, None).unwrap();
            Grbl::new(line, kept)
                .run(&machine, 3, 20.0, |doing| sender.send(doing.clone()).is_err())
        });
        let mut port = TcpStream::connect(&name).unwrap();
        port.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
        until(&mut port, b"\x18", "for help]\r\n");
        for line in ["$22=1", "$25=2000", "$24=200", "$27=1.5", "$30=1000", "$32=1"] {
            until(&mut port, format!("{line}\n").as_bytes(), "ok\r\n");
        }
        assert_eq!(until(&mut port, b"$H\n", "ok\r\n"), "ok\r\n");
        assert!(until(&mut port, b"?", ">\r\n").contains("MPos:-1.500,-1.500,-1.500"));
        let probed = until(&mut port, b"G38.2 Z-60 F900\n", "ok\r\n");
        // 29 mm below the switch.
        assert_eq!(probed, "[PRB:-1.500,-1.500,-29.000:1]\r\nok\r\n");
        until(&mut port, b"G0 Z-5\nM64 P3\nM3 S500\nG1 X-5 F3000\nM30\n", "Pgm End");
        // What has happened is told after what has been said: up to where the laser goes out.
        let mut happened = Vec::new();
        while happened.last() != Some(&Doing::Laser(0.0)) {
            happened
                .push(told.recv_timeout(Duration::from_secs(20)).expect("a laser that goes out"));
        }
        let has = |wanted: &dyn Fn(&Doing) -> bool| happened.iter().any(wanted);
        assert!(has(&|doing| matches!(doing, Doing::Output { value, .. } if *value > 0.5)));
        assert!(has(&|doing| matches!(doing, Doing::Laser(power) if (*power - 500.0).abs() < 0.1)));
    }
}
