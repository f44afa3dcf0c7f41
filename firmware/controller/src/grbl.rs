//! The background of a controller that speaks the protocol of grbl ([`splineway::grbl`], feature `grbl`), in place of
//! [`crate::Background`].

use splineway::grbl::{Accessories, Event, Events, Inputs, Settings, State, Station, Store};
use splineway::{Counters, Planner, Progress, Scalar, Setpoint};

/// Keeps settings as long as there is power, for a board that has nowhere else to put them; `W` is
/// [`words`](splineway::grbl::words) of its axes.
#[derive(Clone, Copy, Debug)]
pub struct Volatile<const W: usize> {
    copies: [[Option<u32>; W]; 2],
}

impl<const W: usize> Volatile<W> {
    /// With nothing in it.
    pub const fn new() -> Self {
        Self { copies: [[None; W]; 2] }
    }
}

impl<const W: usize> Default for Volatile<W> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const W: usize> Store for Volatile<W> {
    fn read(&mut self, copy: usize, at: usize) -> Option<u32> {
        *self.copies.get(copy)?.get(at)?
    }

    fn erase(&mut self, copy: usize) -> bool {
        self.copies.get_mut(copy).map(|copy| copy.fill(None)).is_some()
    }

    fn write(&mut self, copy: usize, at: usize, word: u32) -> bool {
        let place = self.copies.get_mut(copy).and_then(|copy| copy.get_mut(at));
        place.map(|place| *place = Some(word)).is_some()
    }
}

/// What a board gives the background. Nothing here waits, but for what keeps settings.
pub trait Port<S: Scalar, const N: usize> {
    /// Keeps settings without power. With [`Volatile`] they last as long as the power; with `()` none can be changed.
    type Store: Store;

    /// The next byte that has come from the line; `None` if there is none now.
    fn read(&mut self) -> Option<u8>;
    /// Whether whoever sent has gone, once, where that can be known: asked when there is no byte, before those of the next one.
    fn hung_up(&mut self) -> bool {
        false
    }
    /// Takes a byte for the line; `false`: it has no room now, and the byte is offered again.
    fn write(&mut self, byte: u8) -> bool;
    /// The last setpoint, as a whole. It is asked for after planning, so that it is not older than what the planner knows.
    fn setpoint(&mut self) -> Setpoint<S, N>;
    /// What keeps settings. It is only used while the machine rests.
    fn store(&mut self) -> &mut Self::Store;
    /// Limit switches, probe, door, emergency stop, after debouncing. Homing and probes have theirs from the interrupt of the pins, by
    /// `Planner::inputs` (features `probe` and `home` of the core).
    fn inputs(&mut self) -> Inputs {
        Inputs::default()
    }
    /// Spindle and coolant are to be so from now on, and the laser is to have so many per cent of its power.
    fn switch(&mut self, _accessories: &Accessories) {}
    /// The power of the laser at the last setpoint, for reports: what `Interpolator::switch` gave in the servo interrupt, after the
    /// override (feature `outputs` of the core).
    fn power(&mut self) -> f32 {
        0.0
    }
    /// An event of the program that is none of these: a tool. Outputs switch in the servo interrupt, with the feature `outputs`.
    fn happen(&mut self, _event: &Event) {}
    /// Settings have changed, or are told for the first time: steps per mm, polarities of pins.
    fn apply(&mut self, _settings: &Settings<N>) {}
}

/// The background of a controller: the planner and the controller's end of the line.
pub struct Background<
    'a,
    'link,
    S: Scalar,
    const N: usize,
    const BLOCKS: usize,
    const NODES: usize,
    const EVENTS: usize,
> {
    planner: &'a mut Planner<'link, S, N, BLOCKS, NODES>,
    events: &'a Events<EVENTS>,
    station: Station<S, N>,
    switched: Accessories,
}

impl<
    'a,
    'link,
    S: Scalar,
    const N: usize,
    const BLOCKS: usize,
    const NODES: usize,
    const EVENTS: usize,
> Background<'a, 'link, S, N, BLOCKS, NODES, EVENTS>
{
    /// Of a machine at rest, with the settings that hold as long as none have been kept. The servo interrupt takes the `events`.
    pub fn new(
        planner: &'a mut Planner<'link, S, N, BLOCKS, NODES>,
        events: &'a Events<EVENTS>,
        settings: Settings<N>,
    ) -> Self {
        Self { planner, events, station: Station::new(settings), switched: Accessories::OFF }
    }

    /// One round: everything that has come, switches, lines and a planning step, and of what is to be said as much as the line
    /// takes.
    ///
    /// Cost: that of [`Station::poll`], and of [`Station::receive`] for every byte that has come.
    pub fn round(&mut self, port: &mut impl Port<S, N>) -> Progress {
        loop {
            while let Some(byte) = port.read() {
                self.station.receive(byte, self.planner.controls());
            }
            if !port.hung_up() {
                break;
            }
            self.station.hang_up();
        }
        let inputs = port.inputs();
        let progress = self.station.poll(self.planner, self.events, port.store(), inputs);
        while let Some(event) = self.station.event() {
            port.happen(&event);
        }
        let accessories = self.station.accessories();
        if accessories != self.switched {
            port.switch(&accessories);
            self.switched = accessories;
        }
        if let Some(settings) = self.station.new_settings() {
            port.apply(settings);
        }
        let setpoint = port.setpoint();
        self.station.set_power(port.power());
        while let Some(byte) = self.station.say(&setpoint) {
            if !port.write(byte) {
                break;
            }
            self.station.sent();
        }
        progress
    }

    /// What the machine is doing, by the last round.
    pub fn state(&self) -> State {
        self.station.state()
    }

    /// Counts of the planner, for reports.
    pub fn counters(&self) -> Counters {
        self.planner.counters()
    }

    /// The settings in force.
    pub const fn settings(&self) -> &Settings<N> {
        self.station.settings()
    }
}
