//! Probes, homing and outputs over a line that cuts, garbles and doubles: each is done once, in its place, and what comes of it is told.

#[path = "common/cases.rs"]
mod cases;
#[path = "common/line.rs"]
mod line;

use line::{Line, answer, fault, speak};
use proptest::prelude::*;
use splineway::wire::{
    Command, Events, FRAME, HomeAxis, HomeMove, HomeReport, HomeStep, HomeTrouble, Inlet, Item,
    Move, Path, PowerMove, ProbeEnd, ProbeInput, ProbeMove, ProbeResult, Refusal, Reply,
    SeekRefusal, Sender, Situation, Speed, State, Station, SwitchMove, SwitchOffset, SwitchOutput,
    SwitchRefusal, SwitchTrigger, Target, encode,
};
use splineway::{
    Activity, AxisLimits, Config, Coord, Input, Interpolator, Limits, Link, Output, Planner,
    Progress, Setpoint,
};

const QUEUE: usize = 8;
/// Where the probe closes, mm, and the home switches of X and Y, in the coordinates at the beginning.
const SURFACE: f64 = -5.3;
const SWITCHES: [f64; 2] = [12.3, 8.7];

type Core<'a> = (Planner<'a, f32, 3, 16, 64>, Interpolator<'a, f32, 3>);

fn config() -> Config<f32, 3> {
    Config::new(Limits::new([AxisLimits::linear(200.0, 2000.0, 50_000.0); 3]).unwrap())
}

fn line_to(x: f64, y: f64, z: Option<f64>, tag: u32) -> Item {
    let nm = |mm: f64| (mm * 1.0e6) as i64;
    Item::Move(Move {
        path: Path::Line { to: Target::from([Some(nm(x)), Some(nm(y)), z.map(nm)]) },
        speed: Speed::PerSecond(60.0),
        tolerance: None,
        exact_stop: false,
        tag,
    })
}

fn switch(number: u8, value: f32, trigger: SwitchTrigger, tag: u32) -> Item {
    let (output, offset) = (SwitchOutput::Analogue(number), SwitchOffset::Distance(0.0));
    Item::Switch(SwitchMove { output, value, trigger, offset, tag })
}

fn probe(z: i64, required: bool, tag: u32) -> Item {
    let to = Target::from([None, None, Some(z * 1_000_000)]);
    let input = ProbeInput::Probe;
    Item::Probe(ProbeMove { to, feed: 10_000, input, closes: true, required, tag })
}

fn home(reach: u32, tag: u32) -> Item {
    let axis = |at: i64| HomeAxis {
        fast: 20_000,
        slow: 2_000,
        reach,
        back: 1_000,
        at,
        park: Some(at - 2_000_000),
        order: 0,
    };
    Item::Home(HomeMove {
        axes: [Some(axis(100_000_000)), Some(axis(50_000_000)), None].into_iter().collect(),
        tag,
    })
}

/// What came of a run.
#[derive(Default)]
struct Outcome {
    situation: Situation,
    refused: Option<Refusal>,
    done: bool,
    taken: u32,
    /// Values of the outputs, in the order in which they came; and the greatest power.
    switched: Vec<(u8, f32)>,
    power: f32,
    /// Times that motion off the path began, and coordinates were set.
    sought: u32,
    set: u32,
    /// The most items taken while something was sought.
    ahead: u32,
    /// Where each of the tags was last seen, mm.
    at: std::collections::BTreeMap<u32, [f64; 3]>,
    last: [f64; 3],
}

impl Outcome {
    /// Within the rounding of a place.
    fn is_at(&self, place: [f64; 3]) -> bool {
        self.last.iter().zip(place).all(|(at, place)| (at - place).abs() < 1.0e-6)
    }
}

/// The machine: its inputs, by where its axes are, whatever their coordinates.
struct World {
    shift: [f64; 3],
}

impl World {
    fn see(&mut self, planner: &Planner<'_, f32, 3, 16, 64>, ends: [&Setpoint<f32, 3>; 2]) {
        if ends[1].activity == Activity::Set {
            for axis in 0..3 {
                self.shift[axis] += ends[0].position_mm(axis) - ends[1].position_mm(axis);
            }
        }
        let place = |axis: usize| ends.map(|at| at.position_mm(axis) + self.shift[axis]);
        let passed = |[from, to]: [f64; 2], at: f64| {
            let part = if (from < at) == (to < at) { 1.0 } else { (at - from) / (to - from) };
            (part as f32).clamp(0.0, 1.0)
        };
        let inputs = planner.inputs();
        let z = place(2);
        inputs.tell(Input::Probe, z[1] < SURFACE, passed(z, SURFACE));
        for (axis, at) in SWITCHES.into_iter().enumerate() {
            let ends = place(axis);
            inputs.tell(Input::Home(axis), ends[1] > at, passed(ends, at));
        }
    }
}

/// Sends items over two lines, with commands at given times; `dies`: when the sender falls silent.
fn stream(
    items: &[Item],
    mut lines: [Line; 2],
    (commands, dies): (&[(u64, Command)], Option<u64>),
    heal: u64,
) -> Outcome {
    let mut link = Box::new(Link::<f32, 3, 16, 64>::new());
    let (mut planner, mut interpolator): Core<'_> = link.split(config(), [Coord::ZERO; 3]).unwrap();
    let controls = planner.controls();
    let mut station = Station::<f32, 3, QUEUE>::new();
    let mut sender = Sender::new(77, items.len() as u32, if dies.is_some() { 500 } else { 0 });
    let (mut inlet, events, mut out) = (Inlet::new(), Events::<4>::new(), [0; FRAME]);
    let mut outcome = Outcome::default();
    let mut commands = commands.iter().peekable();
    let mut world = World { shift: [0.0; 3] };
    let mut before = interpolator.tick();
    let mut heard = 0;
    for now in 0..80_000u64 {
        for line in &mut lines {
            line.healed = now >= heal;
        }
        let silent = dies.is_some_and(|dies| now >= dies);
        for byte in lines[1].receive() {
            if let Some(reply) = inlet.push::<Reply>(byte) {
                sender.hear(&reply, now);
                if let Reply::Status { situation, .. } = reply {
                    (outcome.situation, heard) = (situation, now);
                }
            }
        }
        while let Some((_, command)) = commands.next_if(|(time, _)| *time <= now) {
            assert!(sender.command(*command));
        }
        speak(&mut sender, items, now, |bytes| {
            if !silent {
                lines[0].send(bytes);
            }
        });
        for byte in lines[0].receive() {
            if let Some(command) = station.receive(byte) {
                command.send(controls);
            }
        }
        while station.poll(&mut planner, &events, now as u32) == Progress::Planning {}
        let setpoint = interpolator.tick();
        let power = interpolator.switch(&setpoint, |switched| {
            if let Output::Analogue(number) = switched.output {
                outcome.switched.push((number, switched.value));
            }
        });
        outcome.power = outcome.power.max(power);
        events.take(&setpoint);
        world.see(&planner, [&before, &setpoint]);
        let seeks = setpoint.activity == Activity::Jogging;
        outcome.sought += u32::from(seeks && before.activity != Activity::Jogging);
        outcome.set += u32::from(setpoint.activity == Activity::Set);
        if seeks {
            outcome.ahead = outcome.ahead.max(station.taken());
        }
        outcome.last = [0, 1, 2].map(|axis| setpoint.position_mm(axis));
        outcome.at.insert(setpoint.tag, outcome.last);
        before = setpoint;
        let state = station.state(&setpoint);
        answer(&mut station, &setpoint, &mut lines[1]);
        (outcome.refused, outcome.taken) = (sender.refused(), station.taken());
        outcome.done = sender.is_done() && state == State::Idle;
        let rests = matches!(state, State::Idle | State::Aborted | State::SenderLost);
        let told = heard > 0 && outcome.situation.state == state;
        let over = outcome.done || (outcome.refused.is_some() && rests && now > heal.max(3000));
        if (over && told && now > heal) || (silent && now > dies.unwrap_or(0) + 5000) {
            // Of a silent sender the station knows more.
            let length = {
                station.receive_ask();
                station.reply(&setpoint, &mut out)
            };
            let status = out[..length].iter().find_map(|&byte| inlet.push::<Reply>(byte));
            if let Some(Reply::Status { situation, taken, .. }) = status {
                outcome.situation = situation;
                outcome.refused = taken.and_then(|taken| taken.refused);
            }
            return outcome;
        }
    }
    outcome
}

/// Asks as anybody may.
trait ReceiveAsk {
    fn receive_ask(&mut self);
}

impl ReceiveAsk for Station<f32, 3, QUEUE> {
    fn receive_ask(&mut self) {
        let mut out = [0; FRAME];
        let length = encode(&splineway::wire::Request::Ask, &mut out).unwrap();
        for byte in &out[..length] {
            assert_eq!(self.receive(*byte), None);
        }
    }
}

fn good() -> [Line; 2] {
    [Line::new(&[]), Line::new(&[])]
}

/// A program with everything in it; the axes that a line behind a probe does not name stay where it ended.
fn everything() -> Vec<Item> {
    let power =
        PowerMove { level: 500.0, dynamic: true, least: 0.0, most: 1000.0, rest: false, tag: 3 };
    vec![
        line_to(4.0, 0.0, Some(0.0), 1),
        switch(0, 1.0, SwitchTrigger::End, 2),
        Item::Power(power),
        line_to(4.0, 3.0, None, 4),
        switch(0, 2.0, SwitchTrigger::Rest, 5),
        probe(-20, true, 6),
        line_to(5.0, 3.0, None, 7),
        switch(1, 3.0, SwitchTrigger::Start, 8),
        line_to(5.0, 4.0, Some(0.0), 9),
        home(30_000, 10),
        line_to(90.0, 45.0, None, 11),
        switch(1, 4.0, SwitchTrigger::Rest, 12),
        Item::End,
    ]
}

fn check_everything(outcome: &Outcome) -> Result<(), TestCaseError> {
    prop_assert!(outcome.done, "{:?} {:?}", outcome.refused, outcome.situation);
    prop_assert_eq!(&outcome.switched, &[(0, 1.0), (0, 2.0), (1, 3.0), (1, 4.0)]);
    prop_assert_eq!((outcome.sought, outcome.set), (2, 1));
    // Nothing behind what is sought is taken before it is over.
    prop_assert_eq!(outcome.ahead, 10);
    let Some(ProbeResult { number: 5, tag: 6, end: ProbeEnd::Tripped, position }) =
        &outcome.situation.probe
    else {
        return Err(TestCaseError::fail(format!("{:?}", outcome.situation.probe)));
    };
    let place: Vec<f64> = position.iter().map(|nm| *nm as f64 * 1.0e-6).collect();
    let off = [place[0] - 4.0, place[1] - 3.0, place[2] - SURFACE];
    prop_assert!(off.iter().all(|off| off.abs() < 1.0e-3), "{place:?}");
    // The line behind it stays at the height at which the probe came to rest: below the surface, by its stop.
    let stays = outcome.at[&7];
    prop_assert!(stays[2] < SURFACE && stays[2] > SURFACE - 0.5, "{stays:?}");
    let Some(HomeReport { number: 9, tag: 10, over: true, steps, fault: None }) =
        &outcome.situation.homing
    else {
        return Err(TestCaseError::fail(format!("{:?}", outcome.situation.homing)));
    };
    prop_assert!(steps.iter().all(|step| *step == HomeStep::Done));
    prop_assert!(outcome.is_at([90.0, 45.0, 0.0]), "{:?}", outcome.last);
    // 500 at 60 mm/s.
    prop_assert!(outcome.power > 490.0 && outcome.power < 510.0, "{}", outcome.power);
    Ok(())
}

#[test]
fn everything_is_done_in_its_place() {
    check_everything(&stream(&everything(), good(), (&[], None), 0)).unwrap();
}

proptest! {
    #![proptest_config(cases::config(30))]

    #[test]
    fn a_bad_line_does_nothing_twice(
        forth in prop::collection::vec(fault(), 1..12),
        back in prop::collection::vec(fault(), 1..12),
        hold in prop::option::of(0u64..4000),
    ) {
        let mut commands = Vec::new();
        if let Some(hold) = hold {
            commands = vec![(hold, Command::Hold), (hold + 700, Command::Resume)];
        }
        let lines = [Line::new(&forth), Line::new(&back)];
        let mut outcome = stream(&everything(), lines, (&commands, None), 20_000);
        // A hold within a probe lets it begin anew.
        outcome.sought = outcome.sought.min(2);
        check_everything(&outcome)?;
    }
}

#[test]
fn a_probe_that_must_have_contact_ends_the_session_without() {
    for required in [true, false] {
        let items = [
            line_to(1.0, 0.0, None, 1),
            probe(-3, required, 2),
            line_to(2.0, 0.0, None, 3),
            Item::End,
        ];
        let outcome = stream(&items, good(), (&[], None), 0);
        let missed = Refusal::Probe { tag: 2, end: ProbeEnd::Missed };
        assert_eq!(outcome.refused, required.then_some(missed));
        let result = outcome.situation.probe.as_ref().unwrap();
        assert_eq!((result.end, result.position[2]), (ProbeEnd::Missed, -3_000_000));
        let x = if required { 1.0 } else { 2.0 };
        assert!(outcome.is_at([x, 0.0, -3.0]), "required: {required}, {:?}", outcome.last);
    }
}

#[test]
fn an_axis_without_its_switch_is_named() {
    let items = [home(10_000, 1), line_to(2.0, 0.0, None, 3), Item::End];
    let outcome = stream(&items, good(), (&[], None), 0);
    assert_eq!((outcome.refused, outcome.set), (Some(Refusal::Home { tag: 1 }), 0));
    let report = outcome.situation.homing.unwrap();
    let fault = report.fault.unwrap();
    // 12.3 mm are further than 10.
    assert_eq!((fault.axis, fault.trouble), (0, HomeTrouble::Missing));
    assert!(report.over);
}

#[test]
fn a_cancel_an_abort_and_a_silence_end_what_is_sought() {
    let Item::Probe(slow) = probe(-20, true, 1) else { panic!("a probe") };
    let slow = Item::Probe(ProbeMove { feed: 4_000, ..slow });
    let ends = [
        (vec![(500, Command::CancelJog)], None),
        (vec![(500, Command::Abort)], None),
        (vec![(500, Command::QuickAbort)], None),
        (Vec::new(), Some(400)),
    ];
    for (items, is_probe) in [
        ([slow, line_to(2.0, 0.0, None, 3), Item::End], true),
        ([home(30_000, 1), line_to(2.0, 0.0, None, 3), Item::End], false),
    ] {
        for (commands, dies) in &ends {
            // Above the surface and before the switches: 4 and 20 mm/s for half a second.
            let outcome = stream(&items, good(), (commands, *dies), 0);
            let aborts = commands.iter().any(|(_, command)| *command != Command::CancelJog);
            let cancelled = if is_probe {
                Refusal::Probe { tag: 1, end: ProbeEnd::Cancelled }
            } else {
                Refusal::Home { tag: 1 }
            };
            let refused = if aborts { Refusal::Aborted } else { cancelled };
            assert_eq!(outcome.refused, Some(refused), "{commands:?} {dies:?}");
            assert_eq!((outcome.taken, outcome.set), (1, 0));
            if is_probe {
                assert_eq!(outcome.situation.probe.unwrap().end, ProbeEnd::Cancelled);
                assert!(outcome.last[2] < -1.0 && outcome.last[2] > SURFACE, "{:?}", outcome.last);
            } else {
                let fault = outcome.situation.homing.unwrap().fault.unwrap();
                assert_eq!(fault.trouble, HomeTrouble::Cancelled);
            }
        }
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_reason() {
    let bad_output = Item::Switch(SwitchMove {
        output: SwitchOutput::Digital(200),
        value: 1.0,
        trigger: SwitchTrigger::End,
        offset: SwitchOffset::Distance(0.0),
        tag: 2,
    });
    let bad_power = Item::Power(PowerMove {
        level: f32::NAN,
        dynamic: false,
        least: 0.0,
        most: 1.0,
        rest: false,
        tag: 2,
    });
    let to = Target::from([None, None, Some(-1)]);
    let input = ProbeInput::Home(77);
    let no_input =
        Item::Probe(ProbeMove { to, feed: 1000, input, closes: true, required: true, tag: 2 });
    let Item::Probe(slow) = probe(-1, true, 2) else { panic!("a probe") };
    let slow = Item::Probe(ProbeMove { feed: 0, ..slow });
    let Item::Home(far) = home(30_000, 2) else { panic!("homing") };
    let mut axes = far.axes;
    axes[1].as_mut().unwrap().fast = 0;
    let output = |reason| Refusal::Output { tag: 2, reason };
    let seek = |reason| Refusal::Seek { tag: 2, reason };
    for (item, refusal) in [
        (bad_output, output(SwitchRefusal::Output)),
        (bad_power, output(SwitchRefusal::OutOfRange)),
        (no_input, seek(SeekRefusal::Input)),
        (slow, seek(SeekRefusal::OutOfRange)),
        (Item::Home(HomeMove { axes, tag: 2 }), seek(SeekRefusal::OutOfRange)),
    ] {
        let items = [line_to(1.0, 0.0, None, 1), item, line_to(2.0, 0.0, None, 3), Item::End];
        let outcome = stream(&items, good(), (&[], None), 0);
        assert_eq!(outcome.refused, Some(refusal));
        // What came before is run.
        assert!(outcome.is_at([1.0, 0.0, 0.0]), "{:?}", outcome.last);
    }
}

/// More switches than there is room for, and no motion behind which they could.
#[test]
fn switches_that_can_never_come_are_refused() {
    let mut items: Vec<Item> =
        (1..40).map(|tag| switch(0, 1.0, SwitchTrigger::Start, tag)).collect();
    items.push(Item::End);
    let outcome = stream(&items, good(), (&[], None), 0);
    let Some(Refusal::Output { reason: SwitchRefusal::Full, tag }) = outcome.refused else {
        panic!("{:?}", outcome.refused)
    };
    assert_eq!(tag, 17);
}
