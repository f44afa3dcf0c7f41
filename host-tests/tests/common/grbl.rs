//! A controller that speaks the protocol of grbl, its interrupt after every round, and what its machine runs into.

// Not every test uses all of it.
#![allow(dead_code)]

use splineway::grbl::{Accessories, Event, Events, Inputs, Settings, State, Store};
use splineway::{
    Activity, AxisLimits, AxisTravel, BLOCKS, Config, Coord, Input, Interpolator, Limits, Link,
    NODES, Output, Progress, Scalar, Setpoint, Switched, Travel,
};
use splineway_controller::grbl::{Background, Port};
use splineway_simulator::run::{Beyond, Seeker};
use std::collections::VecDeque;

pub const AXES: usize = 3;
pub const MM: i64 = 1_000_000;
/// Two pages of memory.
#[derive(Default)]
pub struct Pages([Vec<u32>; 2]);

impl Store for Pages {
    fn read(&mut self, copy: usize, at: usize) -> Option<u32> {
        self.0[copy].get(at).copied()
    }

    fn erase(&mut self, copy: usize) -> bool {
        self.0[copy].clear();
        true
    }

    fn write(&mut self, copy: usize, _: usize, word: u32) -> bool {
        self.0[copy].push(word);
        true
    }
}

/// A board: a line, inputs, and the power of a laser.
pub struct Board<S> {
    pub incoming: VecDeque<u8>,
    pub outgoing: Vec<u8>,
    pub setpoint: Setpoint<S, AXES>,
    pub inputs: Inputs,
    pub happened: Vec<Event>,
    pub store: Pages,
    /// Of its power, the laser gets so many per cent; what it has had in the last servo cycle.
    pub percent: u16,
    pub power: f64,
}

impl<S: Scalar> Port<S, AXES> for Board<S> {
    type Store = Pages;

    fn read(&mut self) -> Option<u8> {
        self.incoming.pop_front()
    }

    fn write(&mut self, byte: u8) -> bool {
        self.outgoing.push(byte);
        true
    }

    fn setpoint(&mut self) -> Setpoint<S, AXES> {
        self.setpoint
    }

    fn store(&mut self) -> &mut Pages {
        &mut self.store
    }

    fn inputs(&mut self) -> Inputs {
        self.inputs
    }

    fn switch(&mut self, accessories: &Accessories) {
        self.percent = accessories.laser;
    }

    fn power(&mut self) -> f32 {
        self.power as f32
    }

    fn happen(&mut self, event: &Event) {
        self.happened.push(*event);
    }
}

/// The controller, its interrupt after every round.
pub struct Rig<'a, 'link, S: Scalar> {
    pub board: Board<S>,
    pub background: Background<'a, 'link, S, AXES, BLOCKS, NODES, 8>,
    pub interpolator: Interpolator<'link, S, AXES>,
    pub events: &'a Events<8>,
    pub limits: [f64; 2],
    pub inputs: splineway::Inputs<'link>,
    pub seeker: Seeker,
    pub switched: Vec<(Output, f64)>,
}

/// What a machine is like: where it stands, how far it may go, mm, and what it runs into.
pub struct World {
    pub start: f64,
    pub travel: [f64; 2],
    pub switches: &'static [&'static str],
    pub surfaces: &'static [&'static str],
}

pub fn with_rig<S: Scalar>(body: impl FnOnce(&mut Rig<'_, '_, S>)) {
    let world = World { start: 0.0, travel: [-300.0, 300.0], switches: &[], surfaces: &[] };
    with_world(&world, body);
}

pub fn with_world<S: Scalar>(world: &World, body: impl FnOnce(&mut Rig<'_, '_, S>)) {
    let axis = AxisLimits::linear(S::of(200.0), S::of(2000.0), S::of(50_000.0));
    let mut config = Config::new(Limits::new([axis; AXES]).unwrap());
    let coord = |mm: f64| Coord::from_mm(mm).unwrap();
    let [least, greatest] = world.travel.map(|mm| Some(coord(mm)));
    config.travel = Travel::new([AxisTravel { least, greatest }; AXES]).unwrap();
    let settings = Settings::new(&config, [250.0; AXES], [300.0; AXES]);
    let mut link = Box::new(Link::<S, AXES>::new());
    let start = [coord(world.start); AXES];
    let (mut planner, mut interpolator) = link.split(config, start).unwrap();
    let events = Events::new();
    let board = Board {
        incoming: VecDeque::new(),
        outgoing: Vec::new(),
        setpoint: interpolator.tick(),
        inputs: Inputs::default(),
        happened: Vec::new(),
        store: Pages::default(),
        percent: 0,
        power: 0.0,
    };
    let beyond = |texts: &[&str]| texts.iter().map(|text| Beyond::parse(text).unwrap()).collect();
    let mut rig = Rig {
        board,
        inputs: planner.inputs(),
        background: Background::new(&mut planner, &events, settings),
        interpolator,
        events: &events,
        limits: [200.0, 2000.0],
        seeker: Seeker::new(beyond(world.switches), beyond(world.surfaces)),
        switched: Vec::new(),
    };
    rig.cycle();
    assert_eq!(rig.heard(), ["", "Grbl 1.1h ['$' for help]"]);
    body(&mut rig);
}

impl<S: Scalar> Rig<'_, '_, S> {
    /// A servo cycle, with all that the background can do before it.
    pub fn cycle(&mut self) {
        while self.background.round(&mut self.board) == Progress::Planning {}
        let before = std::mem::replace(&mut self.board.setpoint, self.interpolator.tick());
        let setpoint = &self.board.setpoint;
        self.events.take(setpoint);
        let switched = &mut self.switched;
        let power = self.interpolator.switch(setpoint, |now: Switched<S>| {
            switched.push((now.output, now.value.to_f64()));
        });
        self.board.power = power.to_f64() * f64::from(self.board.percent) * 0.01;
        let cycle = splineway::machine::defaults::CYCLE;
        self.seeker.sense(self.inputs, &[0, 1, 2], (&before, setpoint), cycle);
        self.board.inputs.probe = self.inputs.is_closed(Input::Probe);
        let bit = |axis: usize| u16::from(self.inputs.is_closed(Input::Home(axis))) << axis;
        self.board.inputs.limits = (0..AXES).map(bit).sum();
        assert!(
            self.board.setpoint.activity != Activity::Set || before.activity == Activity::Idle,
            "coordinates are set in motion"
        );
        for axis in 0..AXES {
            let used = [
                self.board.setpoint.velocity[axis].to_f64() / self.limits[0],
                self.board.setpoint.acceleration[axis].to_f64() / self.limits[1],
            ];
            assert!(used.iter().all(|share| share.abs() < 1.001), "{used:?} of the limits");
        }
    }

    pub fn cycles(&mut self, count: u32) {
        for _ in 0..count {
            self.cycle();
        }
    }

    pub fn send(&mut self, bytes: &[u8]) {
        self.board.incoming.extend(bytes);
    }

    pub fn heard(&mut self) -> Vec<String> {
        let text = String::from_utf8(std::mem::take(&mut self.board.outgoing)).unwrap();
        assert!(text.is_empty() || text.ends_with("\r\n"), "half a line: {text:?}");
        text.lines().map(str::to_owned).collect()
    }

    /// The answers to a line when the machine rests again.
    pub fn ask(&mut self, line: &str) -> Vec<String> {
        self.heard();
        self.send(line.as_bytes());
        self.send(b"\n");
        self.cycles(3);
        self.settle();
        self.heard()
    }

    pub fn settle(&mut self) {
        for _ in 0..200_000 {
            self.cycle();
            let rests = self.board.setpoint.activity == Activity::Idle;
            if rests && !matches!(self.background.state(), State::Run | State::Jog | State::Home) {
                self.cycles(3);
                return;
            }
        }
        panic!("it does not come to rest: {:?}", self.background.state());
    }

    /// Where the machine is, in the coordinates that it had at the start, mm.
    pub fn really(&self, axis: usize) -> f64 {
        self.board.setpoint.position_mm(axis) + self.seeker.shift[axis]
    }

    pub fn place(&self) -> [i64; AXES] {
        [0, 1, 2].map(|axis| self.board.setpoint.position_nm(axis))
    }
}

/// Xorshift: the same draws everywhere.
pub struct Draws(pub u64);

impl Draws {
    pub fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as usize % end
    }
}
