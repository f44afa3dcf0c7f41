//! One round of the loop.

use splineway::wire::{Command, Events, FRAME, Refusal, State, Station};
use splineway::{Activity, Planner, Progress, Scalar, Setpoint};

/// What a board gives the background. Nothing here waits.
pub trait Port<S: Scalar, const N: usize> {
    /// The next byte that has come from the line; `None` if there is none now.
    fn read(&mut self) -> Option<u8>;
    /// Takes a byte for the line; `false`: it has no room now, and the byte is offered again.
    fn write(&mut self, byte: u8) -> bool;
    /// The time, ms, from any beginning; it may wrap around.
    fn now_ms(&mut self) -> u32;
    /// The last setpoint, as a whole. It is asked for after planning, so that it is not older than what the
    /// planner knows.
    fn setpoint(&mut self) -> Setpoint<S, N>;
    /// Whether the machine must stop, and drop its program, for a reason that the host does not know: an emergency
    /// stop, a limit switch, an output that did not follow. An alarm that lasts is told in every round.
    fn alarm(&mut self) -> bool {
        false
    }
    /// A command has come, and has been obeyed: for a log.
    fn obeyed(&mut self, _command: Command) {}
}

/// A reply on its way to the line.
struct Outgoing {
    frame: [u8; FRAME],
    next: usize,
    length: usize,
}

/// The background of a controller: the planner, the controller's end of the line, and what they have to say
/// to each other.
///
/// Every part of a round can be called by itself, in the order of [`Background::round`]. It holds a frame, two
/// references and a [`Station`]: 2.8 kB for three axes in `f32` and a queue of 16.
pub struct Background<
    'a,
    'link,
    S: Scalar,
    const N: usize,
    const BLOCKS: usize,
    const NODES: usize,
    const QUEUE: usize,
    const EVENTS: usize,
> {
    planner: &'a mut Planner<'link, S, N, BLOCKS, NODES>,
    events: &'a Events<EVENTS>,
    station: Station<S, N, QUEUE>,
    progress: Progress,
    reply: Outgoing,
}

impl<
    'a,
    'link,
    S: Scalar,
    const N: usize,
    const BLOCKS: usize,
    const NODES: usize,
    const QUEUE: usize,
    const EVENTS: usize,
> Background<'a, 'link, S, N, BLOCKS, NODES, QUEUE, EVENTS>
{
    /// Of a machine at rest, before its first session. The servo interrupt takes the `events`.
    pub const fn new(
        planner: &'a mut Planner<'link, S, N, BLOCKS, NODES>,
        events: &'a Events<EVENTS>,
    ) -> Self {
        Self {
            planner,
            events,
            station: Station::new(),
            progress: Progress::NeedsBlocks,
            reply: Outgoing { frame: [0; FRAME], next: 0, length: 0 },
        }
    }

    /// One round: everything that has come, alarms, a planning step, and of what is to be said as much as the line
    /// takes.
    ///
    /// Cost: that of [`Station::poll`], and of [`Station::receive`] for every byte that has come.
    pub fn round(&mut self, port: &mut impl Port<S, N>) -> Progress {
        while let Some(byte) = port.read() {
            if let Some(command) = self.receive(byte) {
                port.obeyed(command);
            }
        }
        if port.alarm() {
            self.raise_alarm();
        }
        let progress = self.plan(port.now_ms());
        let setpoint = port.setpoint();
        self.reply(&setpoint, |byte| port.write(byte));
        progress
    }

    /// Takes a byte from the line. The command it completes is obeyed now, and returned.
    pub fn receive(&mut self, byte: u8) -> Option<Command> {
        let command = self.station.receive(byte)?;
        command.send(self.planner.controls());
        Some(command)
    }

    /// The machine brakes within its limits, the program is dropped, and the session ends with
    /// [`Refusal::Alarm`]. An interrupt may have called [`Controls::abort`](splineway::Controls::abort) before, to
    /// be faster.
    pub fn raise_alarm(&mut self) {
        if !self.planner.is_aborted() {
            self.planner.controls().abort();
        }
        self.station.close(Refusal::Alarm);
    }

    /// Hands over what waits, and does one planning step, at `now` ms.
    pub fn plan(&mut self, now: u32) -> Progress {
        self.progress = self.station.poll(self.planner, self.events, now);
        self.progress
    }

    /// Writes replies, one after another, until the line takes no more or nothing is due. `write` takes a byte, or
    /// says that it has no room.
    pub fn reply(&mut self, setpoint: &Setpoint<S, N>, mut write: impl FnMut(u8) -> bool) {
        // A reply of each kind at most: the station has five.
        for _ in 0..5 {
            let reply = &mut self.reply;
            if reply.next >= reply.length {
                reply.next = 0;
                reply.length = self.station.reply(setpoint, &mut reply.frame);
                if reply.length == 0 {
                    return;
                }
            }
            while let Some(&byte) = reply.frame.get(reply.next)
                && reply.next < reply.length
            {
                if !write(byte) {
                    return;
                }
                reply.next += 1;
            }
        }
    }

    /// What the machine is doing, by the last planning step and the last setpoint.
    pub fn state(&self, setpoint: &Setpoint<S, N>) -> State {
        self.station.state(setpoint)
    }

    /// Whether everything that was sent, up to the end of a program, has been run, and the machine is at rest.
    pub fn is_done(&self, setpoint: &Setpoint<S, N>) -> bool {
        self.progress == Progress::Done
            && !self.station.is_waiting()
            && setpoint.activity == Activity::Idle
    }

    /// Whether no further item can be taken now: where a line has no flow control, read no more.
    pub fn is_full(&self) -> bool {
        self.station.is_full()
    }

    /// Items taken in this session.
    pub fn taken(&self) -> u32 {
        self.station.taken()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use splineway::wire::{
        Inlet, Item, Move, Opening, Path, Reply, Request, Speed, Target, VERSION,
    };
    use splineway::{AxisLimits, Config, Coord, Interpolator, Limits, Link};
    use std::boxed::Box;
    use std::collections::VecDeque;
    use std::vec::Vec;

    const AXES: usize = 3;

    /// A board without anything on it; the line takes `room` bytes a round.
    struct Board {
        incoming: VecDeque<u8>,
        inlet: Inlet,
        replies: Vec<Reply>,
        room: usize,
        left: usize,
        now: u32,
        setpoint: Setpoint<f32, AXES>,
        alarm: bool,
        obeyed: Vec<Command>,
    }

    impl Port<f32, AXES> for Board {
        fn read(&mut self) -> Option<u8> {
            self.incoming.pop_front()
        }

        fn write(&mut self, byte: u8) -> bool {
            if self.left == 0 {
                return false;
            }
            self.left -= 1;
            self.replies.extend(self.inlet.push::<Reply>(byte));
            true
        }

        fn now_ms(&mut self) -> u32 {
            self.now
        }

        fn setpoint(&mut self) -> Setpoint<f32, AXES> {
            self.setpoint
        }

        fn alarm(&mut self) -> bool {
            self.alarm
        }

        fn obeyed(&mut self, command: Command) {
            self.obeyed.push(command);
        }
    }

    impl Board {
        fn say(&mut self, request: &Request) {
            let mut frame = [0; FRAME];
            let length = splineway::wire::encode(request, &mut frame).unwrap();
            self.incoming.extend(&frame[..length]);
        }

        fn abort(&mut self, session: u32) {
            self.say(&Request::Command { session, number: 0, command: Command::Abort });
        }
    }

    type Loop<'a, 'link> = Background<'a, 'link, f32, AXES, 8, 64, 8, 2>;

    /// A board and its background, and the servo interrupt, which comes after every round.
    struct Rig<'a, 'link> {
        board: Board,
        background: Loop<'a, 'link>,
        interpolator: Interpolator<'link, f32, AXES>,
    }

    fn with_rig(body: impl FnOnce(&mut Rig<'_, '_>)) {
        let axis =
            AxisLimits { velocity: 200.0, acceleration: 2000.0, jerk: 50_000.0, rotary: false };
        let config = Config::new(Limits::new([axis; AXES]).unwrap());
        let mut link = Box::new(Link::<f32, AXES, 8, 64>::new());
        let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; AXES]).unwrap();
        let events = Events::new();
        let board = Board {
            incoming: VecDeque::new(),
            inlet: Inlet::new(),
            replies: Vec::new(),
            room: usize::MAX,
            left: 0,
            now: 0,
            setpoint: interpolator.tick(),
            alarm: false,
            obeyed: Vec::new(),
        };
        body(&mut Rig { board, background: Background::new(&mut planner, &events), interpolator });
    }

    impl Rig<'_, '_> {
        fn round(&mut self) -> State {
            self.board.now += 1;
            self.board.left = self.board.room;
            while self.background.round(&mut self.board) == Progress::Planning {}
            self.board.setpoint = self.interpolator.tick();
            self.background.state(&self.board.setpoint)
        }

        /// Opens a session, which may take until an abort is complete.
        fn open(&mut self, session: u32) {
            let opening = Opening { version: VERSION, session, silence: 0, abort: false };
            for _ in 0..1000 {
                self.board.replies.clear();
                self.board.say(&Request::Open(opening));
                self.round();
                if self.board.replies.iter().any(|reply| matches!(reply, Reply::Opened(_))) {
                    return;
                }
            }
            panic!("session {session} is not opened: {:?}", self.board.replies);
        }

        /// In a session of its own a line of 100 mm along X, and the end.
        fn program(&mut self, session: u32) {
            self.open(session);
            let path = Path::Line { to: Target::from([Some(100_000_000), None, None]) };
            let speed = Speed::PerSecond(50.0);
            let line = Move { path, speed, tolerance: None, exact_stop: false, tag: 7 };
            self.board.say(&Request::Item { session, number: 0, item: Item::Move(line) });
            self.board.say(&Request::Item { session, number: 1, item: Item::End });
        }

        /// The states of some rounds, each once.
        fn states(&mut self, rounds: u32) -> Vec<State> {
            let mut states: Vec<State> = (0..rounds).map(|_| self.round()).collect();
            states.dedup();
            states
        }
    }

    #[test]
    fn a_program_is_run_and_done() {
        with_rig(|rig| {
            rig.program(1);
            assert_eq!(rig.states(2500), [State::Running, State::Idle]);
            assert_eq!(
                (rig.background.taken(), rig.board.setpoint.position_nm(0)),
                (2, 100_000_000)
            );
            assert!(rig.background.is_done(&rig.board.setpoint));
        });
    }

    /// Running while it brakes, then aborted until a new session begins: never running at rest, nor idle.
    #[test]
    fn an_abort_ends_in_aborted_and_stays_there() {
        with_rig(|rig| {
            rig.program(1);
            assert_eq!(rig.states(300), [State::Running]);
            rig.board.abort(1);
            assert_eq!(rig.states(1000), [State::Running, State::Aborted]);
            assert_eq!(rig.board.obeyed, [Command::Abort]);
            assert!(!rig.background.is_done(&rig.board.setpoint));
            rig.board.say(&Request::Close { session: 1 });
            rig.program(2);
            assert_eq!(rig.states(2500), [State::Running, State::Idle]);
        });
    }

    /// The planner knows that the machine stands; a setpoint of the cycle before does not make it run.
    #[test]
    fn an_abort_is_not_reported_as_running() {
        with_rig(|rig| {
            rig.program(1);
            rig.states(300);
            let moving = rig.board.setpoint;
            assert_eq!(moving.activity, Activity::Running);
            rig.board.abort(1);
            rig.states(1000);
            assert_eq!(rig.background.state(&moving), State::Aborted);
        });
    }

    #[test]
    fn an_abort_of_a_machine_at_rest_is_shown_too() {
        with_rig(|rig| {
            rig.open(1);
            assert_eq!(rig.states(10), [State::Idle]);
            rig.board.abort(1);
            assert_eq!(rig.states(10), [State::Aborted]);
        });
    }

    #[test]
    fn an_alarm_that_lasts_lets_nothing_move() {
        with_rig(|rig| {
            rig.program(1);
            rig.states(300);
            rig.board.alarm = true;
            assert_eq!(rig.states(1000), [State::Alarm]);
            let place = rig.board.setpoint.position_nm(0);
            rig.board.say(&Request::Close { session: 1 });
            rig.program(2);
            rig.states(1000);
            assert_eq!(rig.board.setpoint.position_nm(0), place);
            // It is over: the next session moves.
            rig.board.alarm = false;
            rig.board.say(&Request::Close { session: 2 });
            rig.program(3);
            rig.states(3000);
            assert_eq!(rig.board.setpoint.position_nm(0), 100_000_000);
        });
    }

    #[test]
    fn a_line_that_takes_a_byte_a_round_gets_every_reply_whole() {
        with_rig(|rig| {
            rig.board.room = 1;
            for _ in 0..3 {
                rig.board.say(&Request::Ask);
                rig.states(100);
            }
            let whole = |reply: &Reply| matches!(reply, Reply::Status { damaged: 0, .. });
            assert_eq!(rig.board.replies.len(), 3);
            assert!(rig.board.replies.iter().all(whole));
            assert_eq!(rig.board.inlet.damaged(), 0);
        });
    }
}
