//! Who may move the machine: sessions that die, overlap, repeat and lie, sender watchdog, events.

#[path = "common/cases.rs"]
mod cases;

use proptest::prelude::*;
use splineway::wire::{
    Command, Denial, Event, Events, FRAME, Inlet, Item, Move, Opening, Path, Refusal, Reply,
    Request, Situation, Speed, State, Station, Target, VERSION, encode,
};
use splineway::{
    Activity, AxisLimits, Config, Coord, Interpolator, Limits, Link, Planner, Progress, Scalar,
    Setpoint,
};

const BLOCKS: usize = 8;
const NODES: usize = 64;
const QUEUE: usize = 8;
/// Longest stop of this machine, ms, with the cycles until a command takes effect.
const STOP: u32 = 250;

/// A controller of three axes without a line, one servo cycle per ms.
struct Rig<'a, S: Scalar> {
    planner: Planner<'a, S, 3, BLOCKS, NODES>,
    interpolator: Interpolator<'a, S, 3>,
    station: Station<S, 3, QUEUE>,
    events: Events<2>,
    inlet: Inlet,
    setpoint: Setpoint<S, 3>,
    now: u32,
    replies: Vec<Reply>,
    happened: Vec<Event>,
}

/// Runs `body` with a rig that stands at `start`.
fn with_rig<S: Scalar, T>(start: [Coord; 3], body: impl FnOnce(&mut Rig<'_, S>) -> T) -> T {
    let [velocity, acceleration, jerk] = [200.0, 2000.0, 50_000.0].map(S::of);
    let axis = AxisLimits::linear(velocity, acceleration, jerk);
    let config = Config::new(Limits::new([axis; 3]).unwrap());
    let mut link = Box::new(Link::<S, 3, BLOCKS, NODES>::new());
    let (planner, mut interpolator) = link.split(config, start).unwrap();
    let setpoint = interpolator.tick();
    let mut rig = Rig {
        planner,
        interpolator,
        station: Station::new(),
        events: Events::new(),
        inlet: Inlet::new(),
        setpoint,
        // Soon to wrap around.
        now: u32::MAX - 500,
        replies: Vec::new(),
        happened: Vec::new(),
    };
    body(&mut rig)
}

impl<S: Scalar> Rig<'_, S> {
    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(command) = self.station.receive(byte) {
                command.send(self.planner.controls());
            }
        }
    }

    fn say(&mut self, request: &Request) {
        let mut out = [0; FRAME];
        let length = encode(request, &mut out).unwrap();
        self.bytes(&out[..length]);
    }

    /// One servo cycle.
    fn tick(&mut self) {
        self.now = self.now.wrapping_add(1);
        while self.station.poll(&mut self.planner, &self.events, self.now) == Progress::Planning {}
        self.setpoint = self.interpolator.tick();
        self.happened.extend(self.events.take(&self.setpoint));
        let mut out = [0; FRAME];
        loop {
            let length = self.station.reply(&self.setpoint, &mut out);
            if length == 0 {
                break;
            }
            let replies = out[..length].iter().filter_map(|&byte| self.inlet.push(byte));
            self.replies.extend(replies);
        }
    }

    fn run(&mut self, ms: u32) {
        for _ in 0..ms {
            self.tick();
        }
    }

    fn state(&self) -> State {
        self.station.state(&self.setpoint)
    }

    fn position(&self) -> [Coord; 3] {
        [0, 1, 2].map(|axis| self.setpoint.position(axis))
    }

    /// Asks for a session; what is answered.
    fn open(&mut self, opening: Opening) -> Result<(), Denial> {
        self.replies.clear();
        self.say(&Request::Open(opening));
        self.tick();
        self.replies
            .iter()
            .find_map(|reply| match reply {
                Reply::Opened(taken) if taken.session == opening.session => Some(Ok(())),
                Reply::Denied { session, reason } if *session == opening.session => {
                    Some(Err(*reason))
                }
                _ => None,
            })
            .expect("an answer")
    }

    fn situation(&mut self) -> Situation {
        self.replies.clear();
        self.say(&Request::Ask);
        self.tick();
        let status = |reply: &Reply| match reply {
            Reply::Status { situation, .. } => Some(situation.clone()),
            _ => None,
        };
        self.replies.iter().find_map(status).expect("an answer")
    }
}

fn opening(session: u32, silence: u16) -> Opening {
    Opening { version: VERSION, session, silence, abort: false }
}

fn line(x: Option<i64>, y: Option<i64>, tag: u32) -> Item {
    let path = Path::Line { to: Target::from([x, y, None]) };
    Item::Move(Move {
        path,
        speed: Speed::PerSecond(50.0),
        tolerance: None,
        exact_stop: false,
        tag,
    })
}

/// As a target names it.
#[allow(clippy::unnecessary_wraps)]
fn mm(mm: i64) -> Option<i64> {
    Some(mm * 1_000_000)
}

fn event(tag: u32, pause: bool) -> Item {
    let path = Path::Event { letter: b'M', tenths: 30, value: Some(tag as f32), pause };
    Item::Move(Move { path, speed: Speed::Rapid, tolerance: None, exact_stop: true, tag })
}

fn item(session: u32, number: u32, item: Item) -> Request {
    Request::Item { session, number, item }
}

fn command(session: u32, number: u32, command: Command) -> Request {
    Request::Command { session, number, command }
}

/// Opens session 1 and sends a line of 100 mm, 2 s.
fn begin<S: Scalar>(rig: &mut Rig<'_, S>, silence: u16) {
    assert_eq!(rig.open(opening(1, silence)), Ok(()));
    rig.say(&item(1, 0, line(mm(100), None, 1)));
    rig.say(&item(1, 1, Item::End));
    rig.run(100);
    assert_eq!(rig.state(), State::Running);
}

fn a_silent_sender<S: Scalar>() {
    with_rig::<S, _>([Coord::ZERO; 3], |rig| {
        begin(rig, 200);
        // Signs of life, and nothing else.
        for _ in 0..8 {
            rig.say(&Request::Alive { session: 1 });
            rig.run(100);
        }
        assert_eq!(rig.state(), State::Running);
        // Another one's signs are none.
        for _ in 0..20 {
            rig.say(&Request::Ask);
            rig.say(&Request::Alive { session: 2 });
            rig.say(&Request::Hello { session: 1 });
            rig.say(&item(2, 0, line(mm(3), None, 9)));
            rig.run((200 + STOP) / 20);
        }
        assert_eq!(rig.state(), State::SenderLost);
        let place = rig.position();
        // It comes back, and that alone moves nothing.
        for number in 1..20 {
            rig.say(&Request::Alive { session: 1 });
            rig.say(&item(1, number, Item::End));
            rig.run(50);
            assert_eq!((rig.state(), rig.position()), (State::SenderLost, place));
        }
        rig.say(&command(1, 0, Command::Resume));
        rig.run(50);
        assert_eq!(rig.state(), State::Running);
        for _ in 0..20 {
            rig.say(&Request::Alive { session: 1 });
            rig.run(100);
        }
        assert_eq!((rig.state(), rig.setpoint.position_nm(0)), (State::Idle, 100_000_000));
    });
}

#[test]
fn a_sender_that_falls_silent_is_missed_and_goes_on_only_when_it_says_so() {
    a_silent_sender::<f32>();
    a_silent_sender::<f64>();
}

#[test]
fn the_watchdog_can_be_off() {
    with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
        begin(rig, 0);
        rig.run(3000);
        assert_eq!((rig.state(), rig.setpoint.position_nm(0)), (State::Idle, 100_000_000));
    });
}

/// Of a sender without a watchdog nobody knows whether it is there: who asks for an abort stops what it runs.
#[test]
fn what_a_sender_without_a_watchdog_runs_can_be_stopped() {
    with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
        begin(rig, 0);
        rig.run(300);
        assert_eq!(rig.open(opening(2, 0)), Err(Denial::Busy));
        assert_eq!(rig.state(), State::Running);
        let abort = Opening { abort: true, ..opening(2, 0) };
        assert_eq!(rig.open(abort), Err(Denial::Stopping));
        rig.run(STOP);
        assert_eq!(rig.open(abort), Ok(()));
        let place = rig.setpoint.position_nm(0);
        assert!(rig.state() == State::Idle && place > 0 && place < 100_000_000, "{place}");
        // It begins there, and the one before is told that it is over.
        assert_eq!(rig.open(opening(1, 0)), Err(Denial::Busy));
        rig.run(100);
        assert_eq!(rig.setpoint.position_nm(0), place);
    });
}

/// What an operator holds stays held, whoever comes next and whatever that one drops; what is held for a lost sender does not.
#[test]
fn a_hold_outlasts_the_session_and_its_abort() {
    let cases = (0..16).map(|k| (k & 1 > 0, k & 2 > 0, k & 4 > 0, k & 8 > 0));
    for (held, lost, closes, late) in cases {
        with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
            begin(rig, if lost { 200 } else { 0 });
            if held && !late {
                rig.say(&command(1, 0, Command::Hold));
                rig.run(STOP);
            }
            if closes {
                rig.say(&Request::Close { session: 1 });
            }
            rig.run(200 + STOP);
            // At a panel, while the controller holds for the sender.
            if held && late {
                rig.planner.controls().hold();
                rig.run(STOP);
            }
            let abort = Opening { abort: true, ..opening(2, 0) };
            let mut opened = rig.open(abort);
            if opened == Err(Denial::Stopping) {
                rig.run(STOP);
                opened = rig.open(abort);
            }
            assert_eq!(opened, Ok(()), "{held} {lost} {closes} {late}");
            rig.run(2);
            let expected = if held { State::Held } else { State::Idle };
            assert_eq!(rig.state(), expected, "{held} {lost} {closes} {late}");
            let place = rig.position();
            rig.say(&item(2, 0, line(mm(0), None, 1)));
            rig.say(&item(2, 1, Item::End));
            rig.run(1000);
            assert_eq!(rig.position() == place, held, "{held} {lost} {closes} {late}");
            rig.say(&command(2, 0, Command::Resume));
            rig.run(3000);
            assert_eq!((rig.state(), rig.setpoint.position_nm(0)), (State::Idle, 0));
        });
    }
}

#[test]
fn a_sender_that_leaves_too_early_is_lost_at_once() {
    with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
        begin(rig, 1000);
        rig.say(&Request::Close { session: 1 });
        rig.run(STOP);
        assert_eq!(rig.state(), State::SenderLost);
        // It cannot come back.
        rig.say(&command(1, 0, Command::Resume));
        rig.run(100);
        assert_eq!(rig.state(), State::SenderLost);
        assert_eq!(rig.open(opening(1, 0)), Err(Denial::Over));
        assert_eq!(rig.open(opening(2, 0)), Err(Denial::Left));
    });
}

fn sessions_follow<S: Scalar>() {
    // Between two nanometres.
    let start = [1, -7, 499_999].map(Coord::from_raw);
    with_rig::<S, _>(start, |rig| {
        begin(rig, 300);
        assert_eq!(rig.open(opening(2, 0)), Err(Denial::Busy));
        assert_eq!(rig.open(Opening { abort: true, ..opening(2, 0) }), Err(Denial::Busy));
        let old = Opening { version: VERSION - 1, ..opening(2, 0) };
        assert_eq!(rig.open(old), Err(Denial::Version));
        assert_eq!(rig.open(opening(1, 300)), Ok(()), "a second copy of its own request");
        assert_eq!(rig.station.taken(), 2);
        rig.run(300 + STOP);
        assert_eq!(rig.state(), State::SenderLost);
        assert_eq!(rig.open(opening(2, 0)), Err(Denial::Left));
        // What it then sends is nobody's.
        rig.say(&item(2, 0, line(mm(1), None, 2000)));
        rig.run(100);
        assert_eq!((rig.state(), rig.station.taken()), (State::SenderLost, 2));
        let abort = Opening { abort: true, ..opening(2, 0) };
        while let Err(denial) = rig.open(abort) {
            assert_eq!(denial, Denial::Stopping);
        }
        assert_eq!(rig.state(), State::Idle);
        let place = *rig.planner.end();
        assert_ne!(place[0], start[0]);
        assert_eq!(place.map(Coord::to_nm), rig.position().map(Coord::to_nm));
        // Only Y is named: the others stay where they are, exactly, whatever lies between nanometres.
        rig.say(&item(2, 0, line(None, mm(5), 2000)));
        rig.say(&item(2, 1, line(None, mm(-5), 2001)));
        rig.say(&item(2, 2, Item::End));
        for _ in 0..2000 {
            rig.tick();
            assert_eq!((rig.position()[0], rig.position()[2]), (place[0], place[2]));
            assert!(rig.setpoint.activity == Activity::Idle || rig.setpoint.tag >= 2000);
        }
        assert_eq!((rig.state(), rig.setpoint.position_nm(1)), (State::Idle, -5_000_000));
    });
}

#[test]
fn a_session_is_followed_by_another_that_runs_nothing_of_it() {
    sessions_follow::<f32>();
    sessions_follow::<f64>();
}

#[test]
fn an_aborted_session_is_over_and_the_next_begins_where_the_machine_stands() {
    with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
        begin(rig, 1000);
        rig.say(&command(1, 0, Command::Abort));
        // All of this comes too late.
        rig.say(&item(1, 2, line(mm(7), None, 3)));
        rig.say(&command(1, 1, Command::Resume));
        rig.run(STOP);
        assert_eq!(rig.state(), State::Aborted);
        let place = rig.position();
        rig.say(&item(1, 2, line(mm(7), None, 3)));
        rig.say(&item(1, 3, Item::End));
        rig.say(&command(1, 2, Command::Resume));
        rig.run(1000);
        assert_eq!((rig.state(), rig.position()), (State::Aborted, place));
        rig.say(&Request::Close { session: 1 });
        assert_eq!(rig.open(opening(2, 1000)), Ok(()));
        rig.say(&item(2, 0, line(None, mm(1), 4)));
        rig.say(&item(2, 1, Item::End));
        rig.run(500);
        assert_eq!((rig.state(), rig.position()[0]), (State::Idle, place[0]));
        assert_eq!(rig.setpoint.position_nm(1), 1_000_000);
    });
}

/// A limit switch, or a button at the machine.
#[test]
fn an_abort_from_elsewhere_ends_the_session() {
    for alarm in [false, true] {
        with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
            begin(rig, 0);
            rig.planner.controls().abort();
            if alarm {
                rig.station.close(Refusal::Alarm);
            }
            rig.run(STOP);
            assert_eq!(rig.state(), if alarm { State::Alarm } else { State::Aborted });
            let place = rig.position();
            rig.say(&item(1, 2, line(mm(7), None, 3)));
            rig.run(1000);
            assert_eq!((rig.station.taken(), rig.position()), (2, place));
            rig.run(1000);
            assert_eq!(rig.open(opening(2, 0)), Ok(()));
            assert_eq!(rig.state(), State::Idle);
        });
    }
}

/// A hold that an operator has pressed is not ended by the next sender.
#[test]
fn an_operators_hold_outlasts_the_session() {
    with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
        begin(rig, 100);
        rig.say(&command(1, 0, Command::Abort));
        rig.planner.controls().hold();
        rig.run(100 + STOP);
        assert_eq!(rig.open(opening(2, 1000)), Ok(()));
        rig.say(&item(2, 0, line(mm(1), None, 4)));
        rig.say(&item(2, 1, Item::End));
        rig.run(500);
        assert_eq!(rig.state(), State::Held);
        rig.say(&command(2, 0, Command::Resume));
        rig.run(500);
        assert_eq!((rig.state(), rig.setpoint.position_nm(0)), (State::Idle, 1_000_000));
    });
}

/// The hold of a sender that was lost just before its program ended does not hold the next one.
#[test]
fn a_lost_sender_leaves_no_hold_behind() {
    let mut both = [false; 2];
    for silence in (1950..2150).step_by(3) {
        let ended = with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
            begin(rig, silence);
            rig.run(2400);
            if rig.open(opening(2, 0)).is_err() {
                return false;
            }
            rig.say(&item(2, 0, line(mm(1), None, 4)));
            rig.say(&item(2, 1, Item::End));
            rig.run(2400);
            assert_eq!(rig.setpoint.position_nm(0), 1_000_000, "{silence}");
            true
        });
        both[usize::from(ended)] = true;
    }
    assert_eq!(both, [true; 2]);
}

fn events_in_order<S: Scalar>() {
    with_rig::<S, _>([Coord::ZERO; 3], |rig| {
        assert_eq!(rig.open(opening(1, 0)), Ok(()));
        // More events in a row than can be on their way, and one that pauses.
        let mut items = vec![event(1, false), line(mm(1), None, 2)];
        items.extend((3..9).map(|tag| event(tag, false)));
        items.extend([
            line(mm(2), None, 9),
            event(10, true),
            line(mm(3), None, 11),
            event(12, false),
        ]);
        items.push(Item::End);
        let mut next = 0;
        let mut places = Vec::new();
        for _ in 0..3000 {
            let before = rig.happened.len();
            if rig.station.taken() as usize == next && next < items.len() {
                rig.say(&item(1, next as u32, items[next].clone()));
                next += usize::from(rig.station.taken() as usize > next);
            }
            rig.tick();
            if rig.happened.len() > before {
                assert_eq!(rig.setpoint.velocity.map(|v| v.to_f64().to_bits()), [0; 3]);
                places.push(rig.setpoint.position_nm(0));
            }
        }
        assert_eq!((rig.state(), rig.situation().events), (State::Held, 8));
        assert_eq!(rig.setpoint.position_nm(0), 2_000_000);
        rig.say(&command(1, 0, Command::Resume));
        rig.run(1000);
        places.push(rig.setpoint.position_nm(0));
        assert_eq!((rig.state(), rig.situation().events), (State::Idle, 9));
        let tags: Vec<u32> = rig.happened.iter().map(|event| event.tag).collect();
        assert_eq!(tags, [1, 3, 4, 5, 6, 7, 8, 10, 12]);
        let mm = [0, 1, 1, 1, 1, 1, 1, 2, 3].map(|mm| mm * 1_000_000);
        assert_eq!(places, mm);
        let first = Event { tag: 1, letter: b'M', tenths: 30, value: Some(1.0), pause: false };
        assert_eq!(rig.happened[0], first);
    });
}

#[test]
fn events_happen_in_their_place_once_and_in_order() {
    events_in_order::<f32>();
    events_in_order::<f64>();
}

#[test]
fn events_of_an_aborted_session_do_not_happen_in_the_next() {
    with_rig::<f32, _>([Coord::ZERO; 3], |rig| {
        assert_eq!(rig.open(opening(1, 0)), Ok(()));
        rig.say(&item(1, 0, line(mm(100), None, 1)));
        rig.say(&item(1, 1, event(2, false)));
        rig.say(&item(1, 2, event(3, false)));
        rig.say(&item(1, 3, Item::End));
        rig.run(500);
        rig.say(&command(1, 0, Command::Abort));
        rig.say(&Request::Close { session: 1 });
        rig.run(STOP);
        assert_eq!(rig.open(opening(2, 0)), Ok(()));
        // The same tag again.
        rig.say(&item(2, 0, event(2, false)));
        rig.say(&item(2, 1, event(4, false)));
        rig.say(&item(2, 2, Item::End));
        rig.run(500);
        let tags: Vec<u32> = rig.happened.iter().map(|event| event.tag).collect();
        assert_eq!((tags, rig.situation().events), (vec![2, 4], 2));
    });
}

/// What is said on the line.
#[derive(Clone, Debug)]
enum Word {
    Open {
        session: u32,
        silence: u16,
        abort: bool,
    },
    /// The next item of a session, or one with another number.
    Item {
        session: u32,
        skip: u32,
        kind: u8,
    },
    Command {
        session: u32,
        skip: u32,
        command: u8,
    },
    Alive {
        session: u32,
    },
    Close {
        session: u32,
    },
    Noise(Vec<u8>),
    /// The last frame again, cut after some bytes.
    Again(usize),
    Wait(u32),
}

fn word() -> impl Strategy<Value = Word> {
    let session = || 1u32..5;
    prop_oneof![
        3 => (session(), prop::sample::select(vec![0u16, 20, 100]), any::<bool>())
            .prop_map(|(session, silence, abort)| Word::Open { session, silence, abort }),
        8 => (session(), prop_oneof![9 => Just(0u32), 1 => 0u32..4], 0u8..12)
            .prop_map(|(session, skip, kind)| Word::Item { session, skip, kind }),
        3 => (session(), prop_oneof![9 => Just(0u32), 1 => 0u32..4], 0u8..8)
            .prop_map(|(session, skip, command)| Word::Command { session, skip, command }),
        3 => session().prop_map(|session| Word::Alive { session }),
        1 => session().prop_map(|session| Word::Close { session }),
        1 => prop::collection::vec(any::<u8>(), 0..60).prop_map(Word::Noise),
        1 => (0usize..60).prop_map(Word::Again),
        8 => (1u32..80).prop_map(Word::Wait),
        2 => (80u32..600).prop_map(Word::Wait),
    ]
}

/// What an observer of the line knows.
#[derive(Default)]
struct Observer {
    /// The session that is open, and the number it began with.
    open: Option<u32>,
    silence: u32,
    heard: u32,
    /// Tags of everything said in it since it was opened.
    said: Vec<u32>,
    /// It was seen lost or aborted, and nothing has said since that the machine may move.
    stands: bool,
    /// Since when it has asked for an abort.
    aborted: Option<u32>,
}

/// The hosts on the line, and who listens to them.
#[derive(Default)]
struct Hosts {
    observer: Observer,
    /// Numbers of items and commands that come next, by session.
    next: [u32; 6],
    commands: [u32; 6],
    serial: u32,
}

impl Hosts {
    /// What is said, if it is a frame of its own.
    fn request(&mut self, word: &Word, now: u32) -> Option<Request> {
        let Self { observer, next, commands, .. } = self;
        let open = observer.open;
        let mut heard = |session| {
            if open == Some(session) {
                observer.heard = now;
            }
            open == Some(session)
        };
        Some(match *word {
            Word::Open { session, silence, abort } => {
                Request::Open(Opening { abort, ..opening(session, silence) })
            }
            Word::Item { session, skip, kind } => {
                self.serial += 1;
                let (tag, way) = (session * 100_000 + self.serial, i64::from(self.serial % 7) * 3);
                let what = match kind {
                    0 => Item::End,
                    1 => event(tag, false),
                    2 => event(tag, true),
                    3 => line(None, mm(way), tag),
                    _ => line(mm(way), None, tag),
                };
                // Said, if it is taken or not.
                if heard(session) {
                    observer.said.push(tag);
                }
                item(session, next[session as usize] + skip, what)
            }
            Word::Command { session, skip, command: kind } => {
                let kind = match kind {
                    0 => Command::Abort,
                    1 => Command::Hold,
                    2 => Command::Stop,
                    3 => Command::FeedOverride(150),
                    _ => Command::Resume,
                };
                let number = commands[session as usize] + skip;
                if heard(session) && skip == 0 {
                    commands[session as usize] += 1;
                    observer.stands &= kind != Command::Resume;
                    if kind == Command::Abort {
                        observer.aborted = observer.aborted.or(Some(now));
                    }
                }
                command(session, number, kind)
            }
            Word::Alive { session } => {
                heard(session);
                Request::Alive { session }
            }
            Word::Close { session } => Request::Close { session },
            Word::Noise(_) | Word::Again(_) | Word::Wait(_) => return None,
        })
    }

    /// What the controller has answered.
    fn hear(&mut self, replies: &[Reply], request: Option<&Request>, now: u32) {
        for reply in replies {
            if let (Reply::Opened(taken), Some(Request::Open(opening))) = (reply, request)
                && taken.session == opening.session
                && self.observer.open != Some(opening.session)
            {
                self.observer = Observer {
                    open: Some(opening.session),
                    silence: u32::from(opening.silence),
                    heard: now,
                    ..Observer::default()
                };
                self.commands[opening.session as usize] = 0;
            }
            if let Reply::Opened(taken) | Reply::Taken(taken) = reply {
                self.next[taken.session as usize] = taken.next;
                assert_eq!(self.observer.open, Some(taken.session));
            }
        }
    }
}

/// Runs words against a controller, and holds every servo cycle against what the line has said.
fn listen<S: Scalar>(words: &[Word]) -> Result<(), TestCaseError> {
    with_rig::<S, _>([Coord::ZERO; 3], |rig| {
        let mut hosts = Hosts::default();
        let mut last = Vec::new();
        for word in words {
            let request = hosts.request(word, rig.now);
            let mut wait = 1;
            match word {
                Word::Noise(bytes) => {
                    rig.bytes(bytes);
                    rig.bytes(&[0]);
                }
                Word::Again(count) => {
                    let cut: &[u8] = &last[..last.len().min(*count)];
                    rig.bytes(cut);
                    rig.bytes(&[0]);
                }
                Word::Wait(ms) => wait = *ms,
                _ => {}
            }
            if let Some(request) = &request {
                let mut out = [0; FRAME];
                let length = encode(request, &mut out).unwrap();
                // A frame cut short of its last byte and its end cannot pass.
                last = out[..length - 2].to_vec();
                rig.say(request);
            }
            for _ in 0..wait {
                rig.replies.clear();
                rig.tick();
                hosts.hear(&rig.replies, request.as_ref(), rig.now);
                judge(rig, &mut hosts.observer)?;
            }
        }
        Ok(())
    })
}

/// Whether the machine does in this cycle only what the session that is open has said.
fn judge<S: Scalar>(rig: &Rig<'_, S>, observer: &mut Observer) -> Result<(), TestCaseError> {
    let moves = rig.setpoint.activity != Activity::Idle;
    if moves {
        let tag = rig.setpoint.tag;
        prop_assert!(observer.said.contains(&tag), "block {} of another session", tag);
        prop_assert!(!observer.stands, "block {} moves though nobody has said so", tag);
    }
    let silent = rig.now.wrapping_sub(observer.heard);
    if observer.open.is_some() && observer.silence > 0 && silent > observer.silence + STOP {
        prop_assert!(!moves, "moves {} ms after its sender fell silent", silent);
    }
    if let Some(aborted) = observer.aborted
        && rig.now.wrapping_sub(aborted) > STOP
    {
        prop_assert!(!moves, "moves after an abort");
    }
    if matches!(rig.state(), State::SenderLost | State::Aborted) {
        observer.stands = true;
    }
    if rig.setpoint.activity == Activity::Event {
        let last = rig.happened.last().map(|event| event.tag);
        prop_assert_eq!(last, Some(rig.setpoint.tag), "an event that nobody has heard of");
    }
    Ok(())
}

/// What was found once.
#[test]
fn a_session_behind_two_others_is_heard() {
    let open = |session, silence| Word::Open { session, silence, abort: false };
    let item = Word::Item { session: 3, skip: 0, kind: 1 };
    let [long, short] = [open(3, 100), open(1, 20)];
    let words = [
        &[short.clone(), Word::Wait(20), long, item],
        &[Word::Wait(2), Word::Wait(22), Word::Wait(76), short],
        &[Word::Wait(20), open(3, 0)][..],
    ];
    listen::<f32>(&words.concat()).unwrap();
}

proptest! {
    #![proptest_config(cases::config(150))]

    #[test]
    fn nothing_moves_that_the_live_session_has_not_sent(
        words in prop::collection::vec(word(), 1..120),
    ) {
        listen::<f32>(&words)?;
    }

    #[test]
    fn nor_in_double_precision(words in prop::collection::vec(word(), 1..60)) {
        listen::<f64>(&words)?;
    }
}
