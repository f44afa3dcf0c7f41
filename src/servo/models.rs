//! What contexts share, under every interleaving of at most three preemptions and every value that the memory model
//! lets a load see; a look at the timeline is tried once, not eight times.
//!
//! `RUSTFLAGS="--cfg loom" cargo test --release --lib --features wire,probe models`. Every model must hold as the code stands;
//! each ordering that is stronger than relaxed is then weakened by itself, half by half, and each known bug of the
//! protocol planted: a model must fail, or the place is listed with the reason why it may.

use super::interleave::Fault;
use super::link::{Branch, Channel, Origin, PlanSide, ServoSide};
use super::piece::{Piece, Sequel};
use super::{Activity, Controls, Interpolator, Setpoint};
use crate::number::atomic::modelled::{Half, forget, leave_out, met};
use crate::number::serial::{CycleSerial, NodeSerial};
use crate::number::{ArcLength, Coord};
use crate::servo::control::{Overrides, Requests};
use core::sync::atomic::AtomicU8;
use core::sync::atomic::Ordering::SeqCst;
use loom::thread::spawn;
use std::boxed::Box;
use std::string::String;
use std::sync::{Mutex, PoisonError};
use std::vec::Vec;
use std::{format, panic, thread};

/// The planted bug.
static PLANTED: AtomicU8 = AtomicU8::new(0);

/// Whether that bug is planted.
pub fn is_planted(fault: Fault) -> bool {
    PLANTED.load(SeqCst) == fault as u8 + 1
}

type Core = Channel<f32, 1, 2>;

/// Both ends of a link at rest in zero; the model checker knows of every atomic before a second thread does.
fn core() -> (PlanSide<'static, f32, 1>, Interpolator<'static, f32, 1>, &'static Requests) {
    let link = Box::leak(Box::new(Core::new()));
    let (plan, servo, requests) = link.ends(Origin::ZERO);
    plan.touch();
    requests.read();
    (plan, rest(servo), requests)
}

fn rest(servo: ServoSide<'static, f32, 1>) -> Interpolator<'static, f32, 1> {
    Interpolator::new(servo, (NodeSerial::ZERO, [Coord::ZERO]), 1.0)
}

/// A piece of one and a half servo cycles, of which every number is its tag.
fn piece(serial: u32, tag: u16) -> Piece<f32, 1> {
    let c = f32::from(tag);
    Piece {
        serial: NodeSerial::from_raw(serial),
        tag: u32::from(tag),
        time: 1.5,
        origin: [Coord::from_raw(i64::from(tag) << 32)],
        axes: [[c; 5]],
        arc_length: ArcLength::from_raw(i64::from(tag) << 32),
        path: [c; 4],
        sequel: Sequel::Stop,
        event: false,
    }
}

fn node(serial: u32) -> Branch {
    Branch::Node(NodeSerial::from_raw(serial))
}

/// Writes a plan of pieces from a node on, tagged from `tag` on, and offers it.
fn offer(plan: &mut PlanSide<'_, f32, 1>, branch: Branch, serial: u32, tags: &[u16]) {
    for (tag, serial) in tags.iter().zip(serial..) {
        plan.write(&piece(serial, *tag));
    }
    plan.offer(branch);
}

/// That a setpoint is of one piece, whole, or of the rest at the end of one.
fn is_whole(setpoint: &Setpoint<f32, 1>) -> bool {
    let tag = setpoint.tag as f32;
    let raw = i64::from(setpoint.tag) << 32;
    let whole = |t: f32, moves: bool| {
        let (t2, t3, t4) = (t * t, t * t * t, t * t * t * t);
        let [velocity, acceleration, speed] = if moves {
            [
                1.0 + 2.0 * t + 3.0 * t2 + 4.0 * t3 + 5.0 * t4,
                2.0 + 6.0 * t + 12.0 * t2 + 20.0 * t3,
                1.0 + 2.0 * t + 3.0 * t2 + 4.0 * t3,
            ]
        } else {
            [0.0; 3]
        };
        setpoint.origin == [Coord::from_raw(raw)]
            && setpoint.path_origin == ArcLength::from_raw(raw)
            && setpoint.offset == [tag * t * (1.0 + t + t2 + t3 + t4)]
            && setpoint.path_offset == tag * t * (1.0 + t + t2 + t3)
            && setpoint.velocity == [tag * velocity]
            && setpoint.acceleration == [tag * acceleration]
            && setpoint.path_speed == tag * speed
    };
    match setpoint.activity {
        Activity::Idle => setpoint.tag == 0 || whole(1.5, false),
        _ => setpoint.tag != 0 && [0.0, 0.5, 1.0].iter().any(|t| whole(*t, true)),
    }
}

/// So many servo cycles; the tags seen, each once.
fn run(interpolator: &mut Interpolator<'_, f32, 1>, cycles: u32) -> Vec<u32> {
    let mut tags = Vec::new();
    for _ in 0..cycles {
        let setpoint = interpolator.tick();
        assert!(is_whole(&setpoint), "{setpoint:?}");
        if tags.last() != Some(&setpoint.tag) {
            tags.push(setpoint.tag);
        }
    }
    tags
}

/// Plans that branch off at nodes: each is executed as it was written, from the node on, and the buffer of the one
/// before is written over only when nothing is read from it any more.
fn plans_at_nodes() {
    let (mut plan, mut interpolator, _) = core();
    let background = spawn(move || {
        offer(&mut plan, node(0), 0, &[1]);
        if plan.verdict() == Some(true) {
            offer(&mut plan, node(1), 1, &[2]);
            if plan.verdict() == Some(true) {
                offer(&mut plan, node(2), 2, &[3]);
            }
        }
    });
    let tags = run(&mut interpolator, 5);
    background.join().unwrap();
    assert!(
        [&[0][..], &[0, 1], &[1], &[0, 1, 2], &[1, 2], &[1, 2, 3]].contains(&&tags[..]),
        "{tags:?}"
    );
}

/// An answer to a command branches off at a servo cycle, in the midst of a piece whose buffer is written over as soon
/// as it is taken.
fn plans_at_cycles() {
    let (mut plan, mut interpolator, _) = core();
    offer(&mut plan, node(0), 0, &[1]);
    assert_eq!(run(&mut interpolator, 1), [1]);
    assert_eq!(plan.verdict(), Some(true));
    let background = spawn(move || {
        offer(&mut plan, Branch::Cycle(CycleSerial::from_raw(1)), 1, &[2]);
        if plan.verdict() == Some(true) {
            offer(&mut plan, node(2), 2, &[3]);
        }
    });
    let tags = run(&mut interpolator, 4);
    background.join().unwrap();
    // Too late: refused, and the plan under way ends.
    assert!([&[1][..], &[2], &[2, 3]].contains(&&tags[..]), "{tags:?}");
}

/// An offer is withdrawn or taken, never both, and what was withdrawn is never executed.
fn withdrawals() {
    let (mut plan, mut interpolator, _) = core();
    offer(&mut plan, node(0), 0, &[1]);
    let background = spawn(move || {
        plan.withdraw();
        let taken = plan.verdict().expect("it is decided");
        if !taken {
            offer(&mut plan, node(0), 0, &[2]);
        }
        taken
    });
    let tags = run(&mut interpolator, 3);
    let taken = background.join().unwrap();
    let allowed: &[&[u32]] = if taken { &[&[1]] } else { &[&[0], &[0, 2], &[2]] };
    assert!(allowed.contains(&&tags[..]), "{taken} {tags:?}");
}

/// What the planner sees of the motion is of one moment, and of the plan it knows to be under way.
fn timelines() {
    let (mut plan, mut interpolator, _) = core();
    offer(&mut plan, node(0), 0, &[1]);
    run(&mut interpolator, 1);
    assert_eq!(plan.verdict(), Some(true));
    offer(&mut plan, Branch::Cycle(CycleSerial::from_raw(1)), 4, &[2]);
    let background = spawn(move || {
        let taken = plan.verdict() == Some(true);
        if let Some(seen) = plan.timeline() {
            let seen = (seen.serial.raw(), seen.began.raw(), seen.lag);
            assert_eq!(seen, if taken { (4, 1, 0.0) } else { (0, 0, 0.0) });
        }
    });
    run(&mut interpolator, 1);
    background.join().unwrap();
}

/// A node that is reported passed has been left in a servo cycle that is counted.
fn progress() {
    let (mut plan, mut interpolator, _) = core();
    offer(&mut plan, node(0), 0, &[1, 2]);
    let background = spawn(move || {
        let at = plan.progress();
        let cycles = plan.cycles();
        assert!(at.raw() == 0 || cycles.raw() >= 2, "{at:?} {cycles:?}");
    });
    run(&mut interpolator, 2);
    background.join().unwrap();
}

/// The planner is not told that a plan was taken before it can see how far the motion is.
fn verdicts() {
    let (mut plan, mut interpolator, _) = core();
    offer(&mut plan, Branch::Cycle(CycleSerial::from_raw(1)), 7, &[1]);
    let background = spawn(move || {
        if plan.verdict() == Some(true) {
            assert!(plan.cycles().raw() >= 2);
        }
    });
    run(&mut interpolator, 2);
    background.join().unwrap();
}

/// A command that is seen shows what the same operator pressed before it, and none is lost to another's.
fn commands() {
    let (_, _, requests) = core();
    let one = spawn(move || {
        let controls = Controls::new(requests);
        controls.feed_override(50);
        controls.rapid_override(25);
        controls.single_block(true);
        controls.resume();
    });
    let other = spawn(move || {
        let controls = Controls::new(requests);
        controls.hold();
        controls.abort();
    });
    let wish = requests.read();
    if wish.resumes != 0 {
        let Overrides { feed, rapid } = wish.overrides;
        assert_eq!((feed, rapid, wish.single), (50, 25, true));
    }
    one.join().unwrap();
    other.join().unwrap();
    let end = requests.read();
    assert!(end.resumes != 0 && end.aborts == 1 && !end.hold, "{end:?}");
}

/// The same for a hold and an abort.
fn commands_before_a_hold() {
    let (_, _, requests) = core();
    let operator = spawn(move || {
        let controls = Controls::new(requests);
        controls.feed_override(50);
        controls.hold();
        controls.feed_override(60);
        controls.stop();
    });
    let wish = requests.read();
    assert!(!wish.hold || wish.overrides.feed != 100, "{wish:?}");
    assert!(!wish.stop || wish.hold && wish.overrides.feed == 60, "{wish:?}");
    let aborts = requests.aborts();
    operator.join().unwrap();
    assert_eq!(aborts, 0);
}

/// What is seen was asked for at one moment: a motion that is held throughout, first by an override of 0 and then by a hold, or the other way
/// round, is never seen as one that goes.
fn held_throughout() {
    let (_, _, requests) = core();
    Controls::new(requests).feed_override(0);
    let operator = spawn(move || {
        let controls = Controls::new(requests);
        controls.hold();
        controls.feed_override(60);
        controls.rapid_override(0);
        controls.resume();
    });
    let wish = requests.read();
    assert!(wish.holds(), "{wish:?}");
    operator.join().unwrap();
    assert!(requests.read().holds());
}

/// Events come out as they were put in, and a place is used again only when it has been read.
#[cfg(feature = "wire")]
fn events() {
    use crate::wire::{Event, Events};
    let event = |tag: u16| Event {
        tag: u32::from(tag),
        letter: b'M',
        tenths: tag,
        value: Some(f32::from(tag)),
        pause: false,
    };
    let events: &'static Events<1> = Box::leak(Box::new(Events::new()));
    events.touch();
    // The interrupt is the thread that is spawned: where a thread loads what it then stores, the model checker does not
    // go back to loads that another has made before.
    let interrupt = spawn(move || {
        for tag in [1, 2] {
            let setpoint = Setpoint::<f32, 1> {
                tag: u32::from(tag),
                activity: Activity::Event,
                ..Setpoint::REST
            };
            let found = events.take(&setpoint);
            assert!(found.is_none() || found == Some(event(tag)), "{found:?}");
        }
    });
    for tag in [1, 2] {
        if events.has_room() {
            events.put(&event(tag));
        }
    }
    interrupt.join().unwrap();
}

/// An edge is latched whole, and once, whoever tells it.
#[cfg(feature = "probe")]
fn edges() {
    use crate::number::atomic::AtomicU32;
    use crate::servo::input::{EdgeTime, Input, Inputs, Lines};
    let lines: &'static Lines = Box::leak(Box::new(Lines::new()));
    let inputs = [7, 9].map(|cycle| {
        let cycles: &'static AtomicU32 = Box::leak(Box::new(AtomicU32::new(cycle)));
        Inputs::new(lines, cycles)
    });
    inputs[0].tell(Input::Probe, false, 0.0);
    assert!(lines.arm(Input::Probe, true));
    let [one, other] = inputs;
    let interrupt = spawn(move || one.tell(Input::Probe, true, 0.25));
    other.tell(Input::Probe, true, 0.5);
    let is_whole = |edge: EdgeTime| {
        let EdgeTime { cycle, fraction } = edge;
        [(7, 0.25), (9, 0.5)].contains(&(cycle.raw(), fraction))
    };
    let early = lines.latched(Input::Probe);
    assert!(early.is_none_or(is_whole), "{early:?}");
    interrupt.join().unwrap();
    let edge = lines.latched(Input::Probe);
    assert!(edge.is_some_and(is_whole), "{edge:?}");
    assert!(early.is_none() || early == edge);
}

const MODELS: &[(&str, fn())] = &[
    ("plans at nodes", plans_at_nodes),
    ("plans at cycles", plans_at_cycles),
    ("withdrawals", withdrawals),
    ("progress", progress),
    ("verdicts", verdicts),
    ("commands", commands),
    ("commands before a hold", commands_before_a_hold),
    ("held throughout", held_throughout),
    #[cfg(feature = "wire")]
    ("events", events),
    #[cfg(feature = "probe")]
    ("edges", edges),
    ("timelines", timelines),
];

/// One test at a time: what is planted and left out is for all threads.
static ONE: Mutex<()> = Mutex::new(());

/// Runs a model under every interleaving with at most so many preemptions.
fn check(model: fn()) {
    let mut builder = loom::model::Builder::new();
    builder.preemption_bound = Some(3);
    builder.max_branches = 10_000;
    builder.check(model);
}

/// The first model that fails.
fn failing() -> Option<&'static str> {
    let fails = |model: fn()| thread::spawn(move || check(model)).join().is_err();
    MODELS.iter().find(|(_, model)| fails(*model)).map(|(name, _)| *name)
}

#[test]
fn models_hold() {
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let only = std::env::var("MODEL").ok();
    for (name, model) in MODELS.iter().filter(|(name, _)| only.as_ref().is_none_or(|o| o == name)) {
        let before = std::time::Instant::now();
        check(*model);
        std::eprintln!("{name}: {:?}", before.elapsed());
    }
}

#[test]
fn every_bug_of_the_protocol_is_found() {
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let faults = [Fault::OfferFirst, Fault::RefusedIsTaken];
    let found = faults.map(|fault| {
        PLANTED.store(fault as u8 + 1, SeqCst);
        failing()
    });
    PLANTED.store(0, SeqCst);
    panic::set_hook(hook);
    assert!(found.iter().all(Option::is_some), "{found:?}");
}

/// Halves that no model can miss, with the reason.
const EXCEPTIONS: [(&str, bool, &str); 4] = [
    ("self.out.store(out, Release);", false, LATER),
    (EDGE, true, LATER),
    (EDGE, false, LATER),
    ("let waiting = self.put.load(Relaxed).wrapping_sub(self.out.load(Acquire));", true, LATER),
];
/// The time of an edge is read before the next is waited for, and that before its time is written.
const EDGE: &str =
    "while let Err(now) = self.state.compare_exchange(state, change(state), order, Relaxed) {";
const LATER: &str =
    "keeps a load from seeing what is stored after it, which the model checker does not try";

/// The line of the source.
fn source(half: &Half) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(half.file);
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().nth(half.line as usize - 1).unwrap_or_default().trim().into()
}

#[test]
fn every_ordering_is_needed() {
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    forget();
    for (_, model) in MODELS {
        check(*model);
    }
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let mut missed = Vec::new();
    for half in met() {
        let line = source(&half);
        let excepted = EXCEPTIONS
            .iter()
            .any(|(text, acquires, _)| *text == line && *acquires == half.acquires);
        if excepted {
            continue;
        }
        leave_out(Some(half));
        let found = failing();
        leave_out(None);
        let (Half { file, line: number, acquires, .. }, found) = (half, found);
        let kind = if acquires { "acquire" } else { "release" };
        std::eprintln!("{file}:{number} {kind}: {found:?}");
        if found.is_none() {
            missed.push(format!("{file}:{number} {kind}: {line}"));
        }
    }
    panic::set_hook(hook);
    assert!(missed.is_empty(), "{missed:#?}");
}
