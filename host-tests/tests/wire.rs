//! The wire protocol over a line that cuts, garbles, doubles and delays: no block is lost, none runs
//! twice, and every command is obeyed once.

#[path = "common/cases.rs"]
mod cases;
#[path = "common/line.rs"]
mod line;

use line::{Fault, Line, answer, fault, speak};
use proptest::prelude::*;
use splineway::wire::{
    Command, Events, FRAME, HomeAxis, HomeFault, HomeMove, HomeReport, HomeStep, HomeTrouble,
    Inlet, Item, JogRefusal, Move, Opening, Path, PowerMove, ProbeEnd, ProbeInput, ProbeMove,
    ProbeResult, Refusal, Reply, Request, Sender, Situation, Speed, State, Station, SwitchMove,
    SwitchOffset, SwitchOutput, SwitchTrigger, Taken, Target, encode,
};
use splineway::{
    AxisLimits, AxisTravel, Block, Config, Coord, Limits, Link, Planner, Progress, PushError,
    Travel,
};

const BLOCKS: usize = 16;
const NODES: usize = 64;
const QUEUE: usize = 8;

fn config() -> Config<f32, 3> {
    let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
    let mut config = Config::new(Limits::new([axis; 3]).unwrap());
    let ends = AxisTravel { least: None, greatest: Coord::from_mm(400.0).ok() };
    config.travel = Travel::new([ends; 3]).unwrap();
    config
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
    let mut link = Box::new(Link::<f32, 3, BLOCKS, NODES>::new());
    let (mut planner, mut interpolator): (Planner<'_, f32, 3, BLOCKS, NODES>, _) =
        link.split(config(), [Coord::ZERO; 3]).unwrap();
    let controls = planner.controls();
    let mut station = Station::<f32, 3, QUEUE>::new();
    let mut sender = Sender::new(77, items.len() as u32, 0);
    let mut inlet = Inlet::new();
    let events = Events::<4>::new();
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
        speak(&mut sender, items, now, |bytes| lines[0].send(bytes));
        // The controller.
        for byte in lines[0].receive() {
            if let Some(command) = station.receive(byte) {
                outcome.commands.push(command);
                command.send(controls);
            }
        }
        while station.poll(&mut planner, &events, now as u32) == Progress::Planning {}
        let setpoint = interpolator.tick();
        outcome.positions.push([0, 1, 2].map(|axis| setpoint.position_nm(axis)));
        let state = station.state(&setpoint);
        answer(&mut station, &setpoint, &mut lines[1]);
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

type Faults = [(u16, Fault)];

/// A program over a line with faults both ways, with overrides at given times.
fn a_bad_line(
    forth: &Faults,
    back: &Faults,
    count: u32,
    mut times: Vec<u64>,
) -> Result<(), TestCaseError> {
    let items = program(count);
    times.sort_unstable();
    // Overrides do not stop the run, and differ from each other.
    let commands: Vec<(u64, Command)> = times
        .iter()
        .enumerate()
        .map(|(k, &time)| (time, Command::FeedOverride(50 + k as u16 * 10)))
        .collect();
    let lines = [Line::new(forth), Line::new(back)];
    let outcome = stream(&items, lines, &commands, 20_000);
    prop_assert!(outcome.done);
    prop_assert_eq!(*outcome.positions.last().unwrap(), direct(&items));
    let wanted: Vec<Command> = commands.iter().map(|(_, command)| *command).collect();
    prop_assert_eq!(outcome.commands, wanted);
    Ok(())
}

/// What was found once.
#[test]
fn an_override_behind_lost_bytes_is_heard() {
    let back = [(100, Fault::Double), (269, Fault::Cut)];
    a_bad_line(&[(35, Fault::Cut)], &back, 1, vec![114]).unwrap();
}

proptest! {
    #![proptest_config(cases::config(60))]

    #[test]
    fn a_bad_line_loses_nothing(
        forth in prop::collection::vec(fault(), 1..12),
        back in prop::collection::vec(fault(), 1..12),
        count in 1u32..60,
        times in prop::collection::vec(0u64..1500, 0..6),
    ) {
        a_bad_line(&forth, &back, count, times)?;
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

/// The same for a block that is valid, but leads too far.
#[test]
fn a_block_that_leaves_the_travel_is_named_with_axis_and_limit() {
    let mut items = program(50);
    let Item::Move(bad) = &mut items[30] else { panic!("a move") };
    bad.path = Path::Line { to: Target::from([None, Some(400_000_001), None]) };
    let outcome = stream(&items, [Line::new(&[]), Line::new(&[])], &[], 0);
    let (to, limit) = (400_000_001, 400_000_000);
    assert_eq!(outcome.refused, Some(Refusal::Travel { tag: 31, axis: 1, to, limit }));
    let Item::Move(last) = &items[29] else { panic!("a move") };
    let Path::Line { to } = &last.path else { panic!("a line") };
    assert_eq!(*outcome.positions.last().unwrap(), [to[0].unwrap(), to[1].unwrap(), 0]);
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
    let mut link = Box::new(Link::<f32, 3, BLOCKS, NODES>::new());
    let (mut planner, _) = link.split(config(), [Coord::ZERO; 3]).unwrap();
    assert!(!matches!(planner.push(&blocks[0]), Err(PushError::Full)));
}

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI);

/// A frame as the crates make it that the protocol's description names.
fn as_described(message: &impl serde::Serialize) -> Vec<u8> {
    use postcard::ser_flavors::{Cobs, Flavor, Slice};
    let (mut plain, mut frame) = ([0; 2000], [0; 2100]);
    let plain = postcard::to_slice(message, &mut plain).unwrap();
    let sum = CRC.checksum(plain);
    let mut cobs = Cobs::try_new(Slice::new(&mut frame)).unwrap();
    cobs.try_extend(plain).unwrap();
    cobs.try_extend(&sum.to_le_bytes()).unwrap();
    cobs.finalize().unwrap().to_vec()
}

/// What an inlet makes of the bytes of a frame.
fn taken<T: serde::de::DeserializeOwned>(frame: &[u8]) -> Option<T> {
    let mut inlet = Inlet::new();
    frame.iter().find_map(|&byte| inlet.push(byte))
}

/// Bytes with zeros in them, and blocks of COBS that are full.
fn payload() -> impl Strategy<Value = Vec<u8>> {
    let run = prop_oneof![
        prop::collection::vec(any::<u8>(), 0..20),
        (1u8.., 0usize..12).prop_map(|(byte, more)| vec![byte; 246 + more]),
        (1usize..4).prop_map(|count| vec![0; count]),
    ];
    prop::collection::vec(run, 0..6).prop_map(|runs| runs.concat())
}

fn place() -> impl Strategy<Value = Target> {
    prop::collection::vec(any::<Option<i64>>(), 0..=9).prop_map(|axes| axes.into_iter().collect())
}

fn course() -> impl Strategy<Value = Path> {
    prop_oneof![
        place().prop_map(|to| Path::Line { to }),
        (place(), any::<(u8, u8)>(), any::<(i64, i64)>(), any::<bool>(), any::<u16>()).prop_map(
            |(to, plane, centre, clockwise, extra_turns)| Path::Arc {
                to,
                plane,
                centre,
                clockwise,
                extra_turns
            }
        ),
        (place(), place(), place())
            .prop_map(|(first, second, to)| Path::Cubic { controls: [first, second], to }),
        any::<f32>().prop_map(|seconds| Path::Dwell { seconds }),
        any::<(u8, u16, Option<f32>, bool)>().prop_map(|(letter, tenths, value, pause)| {
            Path::Event { letter, tenths, value, pause }
        }),
    ]
}

/// What a machine does besides moves.
fn besides() -> impl Strategy<Value = Item> {
    let home = any::<(i32, u32, u32, u32, i64, Option<i64>, u8)>().prop_map(
        |(fast, slow, reach, back, at, park, order)| HomeAxis {
            fast,
            slow,
            reach,
            back,
            at,
            park,
            order,
        },
    );
    let axes = prop::collection::vec(prop::option::of(home), 0..=9);
    prop_oneof![
        (axes, any::<u32>())
            .prop_map(|(axes, tag)| Item::Home(HomeMove { axes: axes.into_iter().collect(), tag })),
        (place(), any::<(u32, u8, bool, bool, u32)>()).prop_map(
            |(to, (feed, axis, closes, required, tag))| Item::Probe(ProbeMove {
                to,
                feed,
                input: ProbeInput::Home(axis),
                closes,
                required,
                tag
            })
        ),
        any::<(u8, f32, f32, u32)>().prop_map(|(number, value, time, tag)| Item::Switch(
            SwitchMove {
                output: SwitchOutput::Analogue(number),
                value,
                trigger: SwitchTrigger::Start,
                offset: SwitchOffset::Time(time),
                tag
            }
        )),
        any::<(f32, bool, f32, f32, bool, u32)>().prop_map(
            |(level, dynamic, least, most, rest, tag)| Item::Power(PowerMove {
                level,
                dynamic,
                least,
                most,
                rest,
                tag
            })
        ),
    ]
}

/// The longest of all.
#[test]
fn every_message_has_room_in_a_frame() {
    let axis = HomeAxis {
        fast: i32::MIN,
        slow: u32::MAX,
        reach: u32::MAX,
        back: u32::MAX,
        at: i64::MIN,
        park: Some(i64::MIN),
        order: 200,
    };
    let mut out = [0; FRAME];
    let item = Item::Home(HomeMove { axes: [Some(axis); 9].into_iter().collect(), tag: u32::MAX });
    let request = Request::Item { session: u32::MAX, number: u32::MAX, item };
    assert_eq!(encode(&request, &mut out).map(|length| length <= FRAME), Some(true));
    let place: splineway::wire::Axes = [i64::MIN; 9].into_iter().collect();
    let (number, tag) = (u32::MAX, u32::MAX);
    let fault = HomeFault { axis: 9, step: HomeStep::Parks, trouble: HomeTrouble::Cancelled };
    let situation = Situation {
        state: State::Aborted,
        position: place.clone(),
        speed: 1.0,
        tag,
        starved: u32::MAX,
        events: u32::MAX,
        jog: Some(JogRefusal::Travel { axis: 9 }),
        probe: Some(ProbeResult { number, tag, end: ProbeEnd::Cancelled, position: place }),
        homing: Some(HomeReport {
            number,
            tag,
            over: true,
            steps: [HomeStep::Parks; 9].into_iter().collect(),
            fault: Some(fault),
        }),
    };
    let refused = Some(Refusal::Travel { tag, axis: 9, to: i64::MIN, limit: i64::MIN });
    let (session, next, limit, commands) = (u32::MAX, u32::MAX, u32::MAX, u32::MAX);
    let taken = Some(Taken { session, next, limit, commands, gap: true, refused });
    let reply = Reply::Status { taken, situation, damaged: u32::MAX };
    assert!(encode(&reply, &mut out).is_some());
}

fn request() -> impl Strategy<Value = Request> {
    let speed = prop_oneof![
        any::<f32>().prop_map(Speed::PerSecond),
        any::<f32>().prop_map(Speed::Duration),
        Just(Speed::Rapid),
    ];
    let step = (course(), speed, any::<Option<f32>>(), any::<bool>(), any::<u32>());
    let step = step.prop_map(|(path, speed, tolerance, exact_stop, tag)| {
        Item::Move(Move { path, speed, tolerance, exact_stop, tag })
    });
    let command = prop_oneof![
        Just(Command::Hold),
        any::<u16>().prop_map(Command::RapidOverride),
        any::<bool>().prop_map(Command::SingleBlock),
    ];
    let opening = any::<(u8, u32, u16, bool)>();
    prop_oneof![
        (any::<(u32, u32)>(), prop_oneof![step, besides()])
            .prop_map(|((session, number), item)| Request::Item { session, number, item }),
        any::<(u32, u32)>().prop_map(|(session, number)| Request::Item {
            session,
            number,
            item: Item::End
        }),
        (any::<(u32, u32)>(), command).prop_map(|((session, number), command)| Request::Command {
            session,
            number,
            command
        }),
        opening.prop_map(|(version, session, silence, abort)| {
            Request::Open(Opening { version, session, silence, abort })
        }),
        any::<u32>().prop_map(|session| Request::Hello { session }),
        Just(Request::Ask),
    ]
}

proptest! {
    #![proptest_config(cases::config(2000))]

    #[test]
    fn frames_are_those_of_postcard_and_cobs(request in request()) {
        let mut out = [0; FRAME];
        let length = encode(&request, &mut out).unwrap();
        prop_assert_eq!(&out[..length], &*as_described(&request));
        prop_assert_eq!(encode(&request, &mut out[..length - 1]), None);
        prop_assert_eq!(taken(&out[..length]), Some(request));
    }

    /// Also such as no message has: of every length, and with blocks of COBS that are full.
    #[test]
    fn payloads_of_every_kind_are_framed_as_described(payload in payload()) {
        let mut out = [0; 2100];
        let length = encode(&payload, &mut out).unwrap();
        prop_assert_eq!(&out[..length], &*as_described(&payload));
        for room in [0, 1, length / 2, length - 1] {
            prop_assert_eq!(encode(&payload, &mut out[..room]), None);
        }
        prop_assert_eq!(taken(&out[..length]), (length <= FRAME).then_some(payload));
    }

    /// A sender that ends a full block of COBS with the frame is understood too, and damage is seen as the crates
    /// see it.
    #[test]
    fn frames_are_taken_as_the_crates_take_them(
        payload in payload(),
        damage in prop::option::of((any::<prop::sample::Index>(), 1u8..)),
    ) {
        let mut plain = postcard::to_slice(&payload, &mut [0; 2000]).unwrap().to_vec();
        plain.extend(CRC.checksum(&plain).to_le_bytes());
        let mut frame = [0; FRAME];
        prop_assume!(plain.len() < FRAME - 4);
        let length = cobs::encode(&plain, &mut frame);
        if let Some((place, byte)) = damage {
            frame[place.index(length)] = byte;
        }
        let frame = &frame[..length];
        let wanted = || {
            let mut copy = frame.to_vec();
            let length = cobs::decode_in_place(&mut copy).ok()?;
            let (plain, sum) = copy[..length].split_last_chunk::<4>()?;
            let fits = CRC.checksum(plain).to_le_bytes() == *sum;
            let (message, rest) = postcard::take_from_bytes::<Vec<u8>>(plain).ok()?;
            (fits && rest.is_empty()).then_some(message)
        };
        prop_assert_eq!(taken(&[frame, &[0]].concat()), wanted());
    }
}
