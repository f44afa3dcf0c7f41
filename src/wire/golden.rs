//! The bytes of the protocol, one frame for every variant a host may send.
//!
//! Variants and fields are numbered on the line in the order in which they are declared, some of them
//! in types that other parts of the core use too ([`Feed`](crate::Feed)). A frame that differs from the one
//! here cannot be read by the other end: such a change needs a new [`VERSION`].

use super::{
    Command, FRAME, HomeAxis, HomeFault, HomeMove, HomeReport, HomeStep, HomeTrouble, Item,
    JogMove, Move, Opening, Path, PowerMove, ProbeEnd, ProbeInput, ProbeMove, ProbeResult, Refusal,
    Reply, Request, SeekRefusal, Situation, Speed, State, SwitchMove, SwitchOffset, SwitchOutput,
    SwitchRefusal, SwitchTrigger, Taken, Target, VERSION, encode,
};
use core::fmt::Write;
use std::string::String;

fn hex<T: serde::Serialize>(request: &T) -> String {
    let mut out = [0; FRAME];
    let length = encode(request, &mut out).unwrap();
    let mut text = String::new();
    for byte in &out[..length] {
        write!(text, "{byte:02x}").unwrap();
    }
    text
}

fn path(path: Path, speed: Speed) -> Request {
    let step = Move { path, speed, tolerance: None, exact_stop: false, tag: 5 };
    Request::Item { session: 300, number: 7, item: Item::Move(step) }
}

fn command(command: Command) -> Request {
    Request::Command { session: 300, number: 7, command }
}

/// The axes of a point: one that stays, one either side of zero.
fn to() -> Target {
    Target::from([None, Some(1_000_000), Some(-3)])
}

fn line() -> Path {
    Path::Line { to: to() }
}

fn check<T: serde::Serialize + core::fmt::Debug>(cases: &[(T, &str)]) {
    for (request, bytes) in cases {
        assert_eq!(hex(request), *bytes, "{request:?}: a change needs a new VERSION");
    }
}

#[test]
fn version_of_these_bytes() {
    assert_eq!(VERSION, 6);
}

#[test]
fn requests() {
    let opening = Opening { version: 2, session: 300, silence: 1000, abort: true };
    check(&[
        (Request::Hello { session: 300 }, "0107ac02126889d600"),
        (Request::Item { session: 300, number: 7, item: Item::End }, "0a01ac020701738ee9b200"),
        (command(Command::Hold), "0502ac02070584bdb10800"),
        (Request::Ask, "0603a5a02d4100"),
        (Request::Open(opening), "0c0402ac02e80701d9814c3700"),
        (Request::Alive { session: 300 }, "0805ac02765e16ed00"),
        (Request::Close { session: 300 }, "0806ac02059e380700"),
    ]);
}

#[test]
fn commands() {
    check(&[
        (command(Command::Hold), "0502ac02070584bdb10800"),
        (command(Command::Resume), "0a02ac020701873edafa00"),
        (command(Command::Stop), "0a02ac02070273cd8ae900"),
        (command(Command::Abort), "0a02ac020703704ee11b00"),
        (command(Command::FeedOverride(150)), "0c02ac02070496010fa7698800"),
        (command(Command::RapidOverride(50)), "0b02ac02070532668ee99b00"),
        (command(Command::SingleBlock(true)), "0b02ac02070601ba9cbd8c00"),
        (command(Command::CancelJog), "0a02ac0207084be5688200"),
        (command(Command::QuickHold), "0a02ac0207094866037000"),
        (command(Command::QuickAbort), "0a02ac02070abc95536300"),
    ]);
}

#[test]
fn jogs() {
    let jog = |jog| command(Command::Jog(jog));
    let velocity = [1, -2, 300_000, 0, 0, 0, 0, 0, 0];
    let by = [1_000_000, -3, 0, 0, 0, 0, 0, 0, 0];
    let to = [None, Some(1_000_000), Some(-3), None, None, None, None, None, None];
    check(&[
        (
            jog(JogMove::Velocity { velocity, time: 500 }),
            "0602ac020707060203c0cf24010101010107f4039f64b06900",
        ),
        (
            jog(JogMove::Step { by, feed: 10_000 }),
            "0b02ac0207070180897a0501010101010107904e176dae7100",
        ),
        (
            jog(JogMove::To { to, feed: 10_000 }),
            "0702ac02070702070180897a0105010101010107904e4f3f835c00",
        ),
        (jog(JogMove::Back { feed: 10_000 }), "0d02ac02070703904ed282799400"),
    ]);
}

#[test]
fn feeds() {
    check(&[
        (
            path(line(), Speed::PerSecond(1.5)),
            "0501ac0207010203070180897a0105010103c03f010605e9076c2700",
        ),
        (
            path(line(), Speed::Duration(1.5)),
            "0501ac0207010203080180897a0105010103c03f010605ce7a506e00",
        ),
        (path(line(), Speed::Rapid), "0501ac0207010203080180897a0105020106055a3473c700"),
    ]);
}

#[test]
fn paths() {
    let arc =
        Path::Arc { to: to(), plane: (0, 1), centre: (10, -10), clockwise: true, extra_turns: 3 };
    let cubic = Path::Cubic { controls: [to(), to()], to: to() };
    let event = Path::Event { letter: b'M', tenths: 30, value: Some(1000.0), pause: true };
    check(&[
        (path(line(), Speed::Rapid), "0501ac0207010203080180897a0105020106055a3473c700"),
        (path(arc, Speed::Rapid), "0501ac0207030103070180897a010507011413010302010605763f162600"),
        (
            path(cubic, Speed::Rapid),
            "0501ac0207030203080180897a010503080180897a010503080180897a010502010605d27f294e00",
        ),
        (
            path(Path::Dwell { seconds: 0.5 }, Speed::Rapid),
            "0501ac020702030101033f02010605b5f8ef9e00",
        ),
        (path(event, Speed::Rapid), "0501ac020705044d1e0101057a44010201060524ba8eef00"),
    ]);
}

#[test]
fn tolerance_and_exact_stop() {
    let step =
        Move { path: line(), speed: Speed::Rapid, tolerance: Some(0.25), exact_stop: true, tag: 5 };
    check(&[(
        Request::Item { session: 300, number: 7, item: Item::Move(step) },
        "0501ac0207010203090180897a010502010109803e0105030fe56c00",
    )]);
}

fn item(item: Item) -> Request {
    Request::Item { session: 300, number: 7, item }
}

#[test]
fn outputs() {
    let switch = |output, trigger, offset| {
        item(Item::Switch(SwitchMove { output, value: 1.0, trigger, offset, tag: 5 }))
    };
    let power = |dynamic, rest| {
        item(Item::Power(PowerMove {
            level: 800.0,
            dynamic,
            least: 10.0,
            most: 1000.0,
            rest,
            tag: 5,
        }))
    };
    let (digital, analogue) = (SwitchOutput::Digital(3), SwitchOutput::Analogue(1));
    let (mm, seconds) = (SwitchOffset::Distance(-2.5), SwitchOffset::Time(0.5));
    check(&[
        (
            switch(digital, SwitchTrigger::End, mm),
            "0601ac02070202030103803f0101010820c005d6e3368200",
        ),
        (
            switch(analogue, SwitchTrigger::Start, seconds),
            "0801ac02070201010105803f01010101073f0595eb931500",
        ),
        (
            switch(digital, SwitchTrigger::Rest, SwitchOffset::Distance(0.0)),
            "0601ac02070202030104803f02010101010605af7da0b700",
        ),
        (power(true, false), "0601ac02070301044844010103204101037a44060529782fdb00"),
        (power(false, true), "0601ac02070301034844010103204101097a4401059f17fc5f00"),
    ]);
}

#[test]
fn probes_and_homing() {
    let probe = |input, closes, required| {
        item(Item::Probe(ProbeMove { to: to(), feed: 5_000, input, closes, required, tag: 5 }))
    };
    let axis = HomeAxis {
        fast: -40_000,
        slow: 4_000,
        reach: 300_000,
        back: 2_000,
        at: -1_000_000,
        park: Some(3),
        order: 1,
    };
    let axes = [None, Some(axis), Some(HomeAxis { park: None, ..axis })].into_iter().collect();
    check(&[
        (
            probe(ProbeInput::Probe, true, true),
            "0701ac02070403090180897a0105882708010105ef47f9f000",
        ),
        (
            probe(ProbeInput::Home(2), false, false),
            "0701ac020704030b0180897a01058827010201060574a7057800",
        ),
        (
            item(Item::Home(HomeMove { axes, tag: 5 })),
            "0701ac020705032001fff004a01fe0a712d00fff887a01060101fff004a01fe0a712d00fff887a07010583ab76b500",
        ),
    ]);
}

/// What tells of them.
#[test]
fn results() {
    let position: super::Axes = [1_000_000, -3].into_iter().collect();
    let status = |probe, homing, refused| {
        let situation = Situation {
            state: State::Running,
            position: position.clone(),
            speed: 1.5,
            tag: 5,
            starved: 1,
            events: 2,
            jog: None,
            probe,
            homing,
        };
        let taken = Taken { session: 300, next: 8, limit: 8, commands: 1, gap: false, refused };
        Reply::Status { taken: Some(taken), situation, damaged: 3 }
    };
    let probe = |end| Some(ProbeResult { number: 7, tag: 5, end, position: position.clone() });
    let fault = HomeFault { axis: 1, step: HomeStep::Latches, trouble: HomeTrouble::Missing };
    let steps = [HomeStep::Done, HomeStep::Latches].into_iter().collect();
    let homing = Some(HomeReport { number: 7, tag: 5, over: true, steps, fault: Some(fault) });
    let travel = Refusal::Seek { tag: 5, reason: SeekRefusal::Travel { axis: 2 } };
    let output = Refusal::Output { tag: 5, reason: SwitchRefusal::Output };
    let missed = Refusal::Probe { tag: 5, end: ProbeEnd::Missed };
    check(&[
        (
            status(None, None, Some(output)),
            "080201ac020808010b01050501010280897a050106c03f050102010106039091943b00",
        ),
        (
            status(probe(ProbeEnd::Tripped), None, None),
            "080201ac020808010107010280897a050106c03f05010204010705060280897a0506030879a3cd00",
        ),
        (
            status(probe(ProbeEnd::Missed), None, Some(missed)),
            "080201ac020808010b01070501010280897a050106c03f0501020a010705010280897a0506038b77383600",
        ),
        (
            status(None, None, Some(travel)),
            "080201ac020808010c0106050302010280897a050106c03f05010201010603166e8d2a00",
        ),
        (
            status(None, homing, Some(Refusal::Home { tag: 5 })),
            "080201ac020808010a010805010280897a050106c03f0501020106010705010205050101050603a355dd8f00",
        ),
    ]);
}
