//! The wire protocol over a line that cuts, garbles, doubles and delays: no block is lost, none runs
//! twice, and every command is obeyed once.

use proptest::prelude::*;
use splineway::wire::{
    Command, Events, FRAME, Inlet, Item, Move, Path, Refusal, Reply, Sender, Speed, State, Station,
    Step, Target, encode,
};
use splineway::{AxisLimits, Block, Config, Coord, Limits, Link, Planner, PushError};
use std::collections::VecDeque;

const BLOCKS: usize = 16;
const NODES: usize = 64;
const QUEUE: usize = 8;

/// What the line does to a share of its bytes.
#[derive(Clone, Copy, Debug)]
enum Fault {
    Cut,
    Flip(u8),
    Double,
    Zero,
}

/// A line with faults at given distances, over and over.
struct Line {
    bytes: VecDeque<u8>,
    faults: Vec<(u16, Fault)>,
    next: usize,
    wait: u16,
    /// Nothing goes wrong any more.
    healed: bool,
}

impl Line {
    fn new(faults: &[(u16, Fault)]) -> Self {
        let wait = faults.first().map_or(0, |fault| fault.0);
        Self { bytes: VecDeque::new(), faults: faults.to_vec(), next: 0, wait, healed: false }
    }

    fn send(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if self.healed || self.faults.is_empty() || self.wait > 0 {
                self.wait = self.wait.saturating_sub(1);
                self.bytes.push_back(byte);
                continue;
            }
            match self.faults[self.next].1 {
                Fault::Cut => {}
                Fault::Flip(mask) => self.bytes.push_back(byte ^ mask),
                Fault::Double => self.bytes.extend([byte, byte]),
                Fault::Zero => self.bytes.push_back(0),
            }
            self.next = (self.next + 1) % self.faults.len();
            self.wait = self.faults[self.next].0;
        }
    }

    /// As many bytes as pass in a millisecond.
    fn receive(&mut self) -> Vec<u8> {
        let count = self.bytes.len().min(60);
        self.bytes.drain(..count).collect()
    }
}

fn config() -> Config<f32, 3> {
    let axis = AxisLimits { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0, rotary: false };
    Config::new(Limits::new([axis; 3]).unwrap())
}

/// A zigzag; every position and every tag is different.
fn program(count: u32) -> Vec<Item> {
    let mut items: Vec<Item> = (1..=count)
        .map(|tag| {
            let nm = i64::from(tag) * 300_000;
            let to = Target::from([Some(nm), Some(nm % 700_000), None]);
            Item::Move(Move {
                path: Path::Line { to },
                speed: Speed::PerSecond(100.0),
                tolerance: None,
                exact_stop: false,
                tag,
            })
        })
        .collect();
    items.push(Item::End);
    items
}

/// What came of a run over a line.
struct Outcome {
    /// Setpoints from the first that moves to the last, nm.
    positions: Vec<[i64; 3]>,
    commands: Vec<Command>,
    refused: Option<Refusal>,
    done: bool,
}

/// Sends a program to a controller over two lines, with commands at given times.
fn stream(items: &[Item], mut lines: [Line; 2], commands: &[(u64, Command)], heal: u64) -> Outcome {
    let mut link = Box::new(Link::<f32, 3, NODES>::new());
    let (mut planner, mut interpolator): (Planner<'_, f32, 3, BLOCKS, NODES>, _) =
        link.handles(config(), [Coord::ZERO; 3]).unwrap();
    let controls = planner.controls();
    let mut station = Station::<f32, 3, QUEUE>::new();
    let mut sender = Sender::new(77, items.len() as u32, 0);
    let mut inlet = Inlet::new();
    let events = Events::<4>::new();
    let mut out = [0; FRAME];
    let mut outcome =
        Outcome { positions: Vec::new(), commands: Vec::new(), refused: None, done: false };
    let mut commands = commands.iter().peekable();
    for now in 0..60_000 {
        for line in &mut lines {
            line.healed = now >= heal;
        }
        // The host.
        for byte in lines[1].receive() {
            if let Some(reply) = inlet.push::<Reply>(byte) {
                sender.hear(&reply, now);
            }
        }
        while let Some((_, command)) = commands.next_if(|(time, _)| *time <= now) {
            assert!(sender.command(*command));
        }
        for _ in 0..4 {
            let request = match sender.step(now) {
                Step::Wait => break,
                Step::Send(request) => request,
                Step::Item(number) => sender.item(number, items[number as usize].clone()),
            };
            let length = encode(&request, &mut out).unwrap();
            lines[0].send(&out[..length]);
        }
        // The controller.
        for byte in lines[0].receive() {
            if let Some(command) = station.receive(byte) {
                outcome.commands.push(command);
                command.send(controls);
            }
        }
        station.poll(&mut planner, &events, now as u32);
        let setpoint = interpolator.tick();
        outcome.positions.push([0, 1, 2].map(|axis| setpoint.position_nm(axis)));
        let state = station.state(&setpoint);
        loop {
            let length = station.reply(&setpoint, &mut out);
            if length == 0 {
                break;
            }
            lines[1].send(&out[..length]);
        }
        outcome.refused = sender.refused();
        outcome.done = commands.peek().is_none() && sender.is_done() && state == State::Idle;
        let rests = matches!(state, State::Idle | State::Aborted);
        if outcome.done || (outcome.refused.is_some() && rests && now > heal + 3000) {
            break;
        }
    }
    outcome
}

/// The positions of the program pushed without any line.
fn direct(items: &[Item]) -> [i64; 3] {
    let Some(Item::Move(last)) = items.iter().rev().nth(1) else { panic!("a program has moves") };
    let block: Block<f32, 3> = last.block(&[Coord::ZERO; 3]).unwrap();
    match block.motion {
        splineway::Motion::Line { to } => to.map(Coord::to_nm),
        _ => panic!("a line"),
    }
}

fn fault() -> impl Strategy<Value = (u16, Fault)> {
    let kind = prop_oneof![
        Just(Fault::Cut),
        (1u8..=255).prop_map(Fault::Flip),
        Just(Fault::Double),
        Just(Fault::Zero)
    ];
    (0u16..400, kind)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn a_bad_line_loses_nothing(
        forth in prop::collection::vec(fault(), 1..12),
        back in prop::collection::vec(fault(), 1..12),
        count in 1u32..60,
        times in prop::collection::vec(0u64..1500, 0..6),
    ) {
        let items = program(count);
        let mut times = times;
        times.sort_unstable();
        // Overrides do not stop the run, and differ from each other.
        let commands: Vec<(u64, Command)> = times
            .iter()
            .enumerate()
            .map(|(k, &time)| (time, Command::FeedOverride(50 + k as u16 * 10)))
            .collect();
        let lines = [Line::new(&forth), Line::new(&back)];
        let outcome = stream(&items, lines, &commands, 20_000);
        prop_assert!(outcome.done);
        prop_assert_eq!(*outcome.positions.last().unwrap(), direct(&items));
        let wanted: Vec<Command> = commands.iter().map(|(_, command)| *command).collect();
        prop_assert_eq!(outcome.commands, wanted);
    }
}

/// Tags come back in order, so every block ran, and once.
#[test]
fn a_good_line_is_as_good_as_none() {
    let items = program(200);
    let outcome = stream(&items, [Line::new(&[]), Line::new(&[])], &[], 0);
    assert!(outcome.done);
    assert_eq!(*outcome.positions.last().unwrap(), direct(&items));
    // 200 lines of about 0.3 mm in a zigzag take well under five seconds if the line keeps up.
    assert!(outcome.positions.len() < 12_000, "{}", outcome.positions.len());
}

#[test]
fn after_an_abort_nothing_of_the_session_runs() {
    let items = program(200);
    let outcome = stream(&items, [Line::new(&[]), Line::new(&[])], &[(400, Command::Abort)], 0);
    assert_eq!(outcome.refused, Some(Refusal::Aborted));
    let last = *outcome.positions.last().unwrap();
    assert!(last[0] > 0 && last != direct(&items));
    // It stands still.
    assert!(outcome.positions.iter().rev().take(1000).all(|position| *position == last));
}

#[test]
fn a_refused_block_is_named_and_what_came_before_is_run() {
    let mut items = program(50);
    let Item::Move(bad) = &mut items[30] else { panic!("a move") };
    bad.speed = Speed::PerSecond(-1.0);
    let outcome = stream(&items, [Line::new(&[]), Line::new(&[])], &[], 0);
    assert_eq!(outcome.refused, Some(Refusal::Block { tag: 31 }));
    let Item::Move(last) = &items[29] else { panic!("a move") };
    let Path::Line { to } = &last.path else { panic!("a line") };
    let wanted = [to[0].unwrap(), to[1].unwrap(), 0];
    assert_eq!(*outcome.positions.last().unwrap(), wanted);
}

/// A move survives the line to the nanometre.
#[test]
fn blocks_come_back_as_they_were() {
    let blocks: [Block<f32, 3>; 3] = [
        Block::line([1, -2, 3].map(|nm| Coord::from_nm(nm).unwrap()), 12.5, 7),
        Block::rapid([Coord::from_nm(1_000_000_000_000).unwrap(); 3], 8),
        Block::dwell(0.25, 9),
    ];
    for block in blocks {
        assert_eq!(Move::from(&block).block(&[Coord::from_raw(7); 3]), Ok(block));
    }
    let wrong: Result<Block<f32, 4>, _> = Move::from(&blocks[0]).block(&[Coord::ZERO; 4]);
    assert_eq!(wrong.unwrap_err().to_string(), "the move gives 3 axes; the controller has 4");
    let mut link = Box::new(Link::<f32, 3, NODES>::new());
    let (mut planner, _) = link.handles::<BLOCKS>(config(), [Coord::ZERO; 3]).unwrap();
    assert!(!matches!(planner.push(&blocks[0]), Err(PushError::Full)));
}
