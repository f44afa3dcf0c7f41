//! The bytes of protocol 4, one frame for every variant a host may send.
//!
//! Variants and fields are numbered on the line in the order in which they are declared, some of them
//! in types that other parts of the core use too ([`Feed`](crate::Feed)). A frame that differs from the one
//! here cannot be read by the other end: such a change needs a new [`VERSION`].

use super::{
    Command, FRAME, Item, JogMove, Move, Opening, Path, Request, Speed, Target, VERSION, encode,
};
use core::fmt::Write;
use std::string::String;

fn hex(request: &Request) -> String {
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

fn check(cases: &[(Request, &str)]) {
    for (request, bytes) in cases {
        assert_eq!(hex(request), *bytes, "{request:?}: a change needs a new VERSION");
    }
}

#[test]
fn version_of_these_bytes() {
    assert_eq!(VERSION, 5);
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
