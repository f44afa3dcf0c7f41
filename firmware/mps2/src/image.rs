//! The tasks.

#[rtic::app(device = crate::device, peripherals = false)]
mod app {
    use crate::board::{
        self, Board, Inputs, Pin, Port as Pins, Real, Receiver, StepTimer, Transmitter, Watchdog,
    };
    use crate::device::Interrupt;
    use crate::followers::Followers;
    use crate::log::Log;
    use crate::machine::{self, AXES};
    use core::fmt::Write;
    use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering::Relaxed};
    use embedded_hal::digital::OutputPin;
    use heapless::spsc::{Consumer, Producer, Queue};
    use splineway::grbl::{self, Accessories, Event, Events, Settings, State};
    use splineway::{
        Controls, Coord, Counters, Input, Interpolator, Link, NODES, Planner, Setpoint,
    };
    use splineway_controller::grbl::{Background, Port, Volatile};
    use splineway_controller::{Drives, Targets};

    /// Blocks of look-ahead.
    const BLOCKS: usize = machine::blocks::<Real>();
    /// Events that may be on their way to the servo task.
    const QUEUED: usize = 8;
    /// Bytes that may arrive while the planner works: more than senders have under way.
    const BYTES: usize = 1024;
    /// Bytes that may wait for the line.
    const REPLIES: usize = 256;
    /// Travel that senders are told of an axis without limits, mm.
    const TRAVEL: f32 = 500.0;
    /// Servo cycles between two lines of the log.
    const LOG: u32 = machine::SERVO_HZ;

    /// Bits of the inputs.
    const LIMITS: u8 = 0b111;
    const PROBE: u8 = 1 << 3;
    const DOOR: u8 = 1 << 4;
    const STOP: u8 = 1 << 5;

    /// Levels of the input pins.
    static INPUTS: AtomicU8 = AtomicU8::new(0);
    /// The emergency stop has been hit; stays so until reset.
    static EMERGENCY: AtomicBool = AtomicBool::new(false);
    /// Servo cycles in which an axis had not made all steps of the one before.
    static LAGGED: AtomicU32 = AtomicU32::new(0);
    /// Bytes lost because there was no room.
    static LOST: AtomicU32 = AtomicU32::new(0);
    /// The transmitter is at work, and asks for the next byte itself.
    static SENDING: AtomicBool = AtomicBool::new(false);
    /// Servo cycles since the start: the background's clock.
    static CYCLES: AtomicU32 = AtomicU32::new(0);
    /// Servo cycles that began before the setpoint of the one before was there.
    static MISSED: AtomicU32 = AtomicU32::new(0);
    /// Longest servo task, and interrupt of the step timer, in units of [`board::TIME_NS`].
    static SERVO: AtomicU32 = AtomicU32::new(0);
    /// The servo cycle under way, and its last tick in the lower [`TICK_BITS`] bits.
    static BEAT: AtomicU32 = AtomicU32::new(0);
    /// The servo cycle in which the last line ended, in which inputs changed, and with which setpoint the axes began to move and
    /// came to rest.
    static HEARD: AtomicU32 = AtomicU32::new(0);
    static EDGE: AtomicU32 = AtomicU32::new(0);
    static BEGAN: AtomicU32 = AtomicU32::new(0);
    static RESTED: AtomicU32 = AtomicU32::new(0);
    static STEPS: AtomicU32 = AtomicU32::new(0);
    /// Spindle, coolant, tool: from the line to the servo task.
    static EVENTS: Events<QUEUED> = Events::new();

    const TICK_BITS: u32 = 7;
    const _: () = assert!(machine::TICKS < 1 << TICK_BITS);

    fn count(counter: &AtomicU32) {
        counter.store(counter.load(Relaxed).wrapping_add(1), Relaxed);
    }

    /// When it is now, in servo cycles since the last setpoint that the planner knows of, for
    /// [`splineway::Inputs::tell`]; and the last tick of the step timer. At the priority of the servo task.
    fn since_setpoint() -> (f32, u32) {
        let beat = BEAT.load(Relaxed);
        let tick = beat & ((1 << TICK_BITS) - 1);
        let part = (tick + 1) as f32 / machine::TICKS as f32;
        // The axes make in a servo cycle the steps to the setpoint before its own.
        let ahead = CYCLES.load(Relaxed) << TICK_BITS == beat & !((1 << TICK_BITS) - 1);
        (if ahead { part - 1.0 } else { part }, tick)
    }

    fn keep_longest(longest: &AtomicU32, began: u32) {
        let taken = board::now().wrapping_sub(began);
        if taken > longest.load(Relaxed) {
            longest.store(taken, Relaxed);
        }
    }

    #[shared]
    struct Shared {
        /// Where the axes are to be at the end of the next servo cycle; `None`: not known yet.
        targets: Option<Targets<AXES>>,
        /// The last setpoint, for reports.
        setpoint: Setpoint<Real, AXES>,
        /// Enables the drives.
        enable: Pin,
    }

    #[local]
    struct Local {
        drives: Drives<Pin, Pin, AXES>,
        pins: Pins,
        /// The targets of the servo cycle under way.
        last: Targets<AXES>,
        step_timer: StepTimer,
        interpolator: Interpolator<'static, Real, AXES>,
        followers: &'static mut Followers<Real>,
        receiver: Receiver,
        transmitter: Transmitter,
        bytes_in: Producer<'static, u8>,
        bytes_out: Consumer<'static, u8>,
        replies_in: Producer<'static, u8>,
        replies_out: Consumer<'static, u8>,
        planner: Planner<'static, Real, AXES, BLOCKS, NODES>,
        inputs: Inputs,
        seeking: splineway::Inputs<'static>,
        stop_controls: Controls<'static>,
        watchdog: Watchdog,
        settings: Settings<AXES>,
    }

    #[init(local = [
        link: Link<Real, AXES, BLOCKS, NODES> = Link::new(),
        following: Followers<Real> = Followers::new(),
        bytes: Queue<u8, BYTES> = Queue::new(),
        replies: Queue<u8, REPLIES> = Queue::new(),
    ])]
    fn init(context: init::Context) -> (Shared, Local) {
        let board = Board::new().expect("the steps of the machine do not fit");
        let followers = context.local.following;
        let config = machine::config::<Real>().and_then(|config| followers.set(config));
        let config = config.expect("the machine cannot be used");
        let mut settings = Settings::new(&config, [machine::steps_per_mm(); AXES], [TRAVEL; AXES]);
        for axis in &mut settings.axes {
            // Pulses are timed for no more.
            axis.fastest = Some(machine::VELOCITY * 60.0);
        }
        let start = [Coord::ZERO; AXES];
        let made = context.local.link.split(config, start);
        let (planner, mut interpolator) = made.expect("the settings cannot be used");
        let (bytes_in, bytes_out) = context.local.bytes.split();
        let (replies_in, replies_out) = context.local.replies.split();
        let (setpoint, _) = followers.tick(&mut interpolator, |_| ());
        let (controls, seeking) = (planner.controls(), planner.inputs());
        let _ = writeln!(Log, "splineway {}: {} axes", env!("CARGO_PKG_VERSION"), AXES);
        (
            Shared { targets: Some(Targets::new(&setpoint)), setpoint, enable: board.enable },
            Local {
                drives: Drives::new(board.steppers, machine::TICKS),
                pins: board.port,
                last: Targets::new(&setpoint),
                step_timer: board.step_timer,
                interpolator,
                followers,
                receiver: board.receiver,
                transmitter: board.transmitter,
                bytes_in,
                bytes_out,
                replies_in,
                replies_out,
                planner,
                inputs: board.inputs,
                seeking,
                stop_controls: controls,
                watchdog: board.watchdog,
                settings,
            },
        )
    }

    /// One tick of every axis. At the beginning of a servo cycle the axes take the targets that the servo
    /// task has left, and it is started for the next: so steps never wait for it.
    #[task(binds = TIMER0, priority = 4, local = [drives, pins, step_timer, last], shared = [targets])]
    fn steps(mut context: steps::Context) {
        let began = board::now();
        context.local.step_timer.clear();
        let last = context.local.last;
        let Ok(beat) = context.local.drives.tick(|| {
            match context.shared.targets.lock(Option::take) {
                Some(targets) => *last = targets,
                None => count(&MISSED),
            }
            *last
        });
        context.local.pins.tick(beat.tick);
        let cycle = (BEAT.load(Relaxed) >> TICK_BITS).wrapping_add(u32::from(beat.tick == 0));
        BEAT.store(cycle << TICK_BITS | beat.tick, Relaxed);
        if beat.lagged {
            count(&LAGGED);
        }
        if beat.tick == 0 {
            rtic::pend(Interrupt::SPI);
        }
        keep_longest(&STEPS, began);
    }

    /// The servo cycle. SPI is not used: its interrupt stands for this task.
    #[task(binds = SPI, priority = 3, local = [interpolator, followers, moves: bool = false], shared = [targets, setpoint])]
    fn servo(mut context: servo::Context) {
        let began = board::now();
        let servo::LocalResources { interpolator, followers, moves, .. } = context.local;
        // The board's pins that would switch in time with the path, or be a laser's power, are not there.
        let (setpoint, _) = followers.tick(interpolator, |_| ());
        count(&CYCLES);
        let still = setpoint.velocity == [0.0; AXES] && setpoint.acceleration == [0.0; AXES];
        if *moves == still {
            *moves = !still;
            let change = if still { &RESTED } else { &BEGAN };
            change.store(CYCLES.load(Relaxed), Relaxed);
        }
        // What is to be done there the background does, which the queue tells.
        let _ = EVENTS.take(&setpoint);
        let targets = Targets::new(&setpoint);
        context.shared.targets.lock(|shared| *shared = Some(targets));
        context.shared.setpoint.lock(|shared| *shared = setpoint);
        keep_longest(&SERVO, began);
    }

    /// A byte begins to come from the line.
    #[task(binds = UART0_RX, priority = 2)]
    fn receive(_: receive::Context) {
        board::byte_begins();
    }

    /// A byte has come, or has been sent.
    #[task(binds = DUALTIMER, priority = 2, local = [receiver, transmitter, bytes_in, replies_out])]
    fn line(context: line::Context) {
        let line::LocalResources { receiver, transmitter, bytes_in, replies_out, .. } =
            context.local;
        if let Some(byte) = receiver.take() {
            if byte == b'\n' {
                HEARD.store(CYCLES.load(Relaxed), Relaxed);
            }
            if bytes_in.enqueue(byte).is_err() {
                count(&LOST);
            }
        }
        if transmitter.is_free() {
            let next = replies_out.dequeue();
            SENDING.store(next.is_some(), Relaxed);
            if let Some(byte) = next {
                transmitter.send(byte);
            }
        }
    }

    /// The inputs change: what seeks them hears when. At the emergency stop the drives lose their enable at once, and with it the
    /// position; only a reset of the chip brings the machine back.
    #[task(binds = UART3_RX, priority = 3, local = [inputs, seeking, stop_controls], shared = [enable])]
    fn inputs(mut context: inputs::Context) {
        let (fraction, tick) = since_setpoint();
        let levels = context.local.inputs.take();
        board::note_edge(tick);
        EDGE.store(CYCLES.load(Relaxed), Relaxed);
        let seeking = context.local.seeking;
        seeking.tell(Input::Probe, levels & PROBE != 0, fraction);
        for axis in 0..AXES {
            seeking.tell(Input::Home(axis), levels >> axis & 1 != 0, fraction);
        }
        INPUTS.store(levels, Relaxed);
        if levels & STOP != 0 {
            let Ok(()) = context.shared.enable.lock(OutputPin::set_low);
            EMERGENCY.store(true, Relaxed);
            context.local.stop_controls.abort();
        }
    }

    /// What the background sees of the board.
    struct Outside<'a, M> {
        bytes: &'a mut Consumer<'static, u8>,
        replies: &'a mut Producer<'static, u8>,
        setpoint: M,
        store: Volatile<{ grbl::words(AXES) }>,
        /// Servo cycles with lagging axes that are known of.
        lagged: u32,
        /// What the line was like lately.
        hearing: Hearing,
    }

    impl<M: rtic::Mutex<T = Setpoint<Real, AXES>>> Port<Real, AXES> for Outside<'_, M> {
        type Store = Volatile<{ grbl::words(AXES) }>;

        fn read(&mut self) -> Option<u8> {
            let byte = self.bytes.dequeue()?;
            if byte != b'?' {
                self.hearing.hear(CYCLES.load(Relaxed));
            }
            Some(byte)
        }

        fn write(&mut self, byte: u8) -> bool {
            let taken = self.replies.enqueue(byte).is_ok();
            if !SENDING.load(Relaxed) {
                rtic::pend(Interrupt::DUALTIMER);
            }
            taken
        }

        fn setpoint(&mut self) -> Setpoint<Real, AXES> {
            self.setpoint.lock(|setpoint| *setpoint)
        }

        fn store(&mut self) -> &mut Self::Store {
            &mut self.store
        }

        fn inputs(&mut self) -> grbl::Inputs {
            let levels = INPUTS.load(Relaxed);
            // Steps that are late are made all the same, but the machine is not where it is to be.
            let lagged = LAGGED.load(Relaxed);
            let lags = lagged != self.lagged;
            self.lagged = lagged;
            grbl::Inputs {
                limits: u16::from(levels & LIMITS),
                probe: levels & PROBE != 0,
                door: levels & DOOR != 0,
                stop: EMERGENCY.load(Relaxed) || lags,
            }
        }

        fn switch(&mut self, accessories: &Accessories) {
            let Accessories { spindle, speed, flood, mist, .. } = accessories;
            let _ = writeln!(Log, "spindle {spindle:?} {speed} flood {flood} mist {mist}");
        }

        fn happen(&mut self, event: &Event) {
            let _ = writeln!(Log, "line {}: {}{}", event.tag, event.letter, event.tenths / 10);
        }
    }

    /// The silence of a sender, in servo cycles.
    #[derive(Default)]
    struct Hearing {
        /// When the last byte of a line was read.
        heard: u32,
        /// How long nothing had come before one of the bytes since, at most, and when that was.
        longest: (u32, u32),
    }

    impl Hearing {
        /// How long a silence is remembered.
        const LATELY: u32 = machine::SERVO_HZ / 5;

        fn hear(&mut self, now: u32) {
            let (silence, (longest, when)) = (now.wrapping_sub(self.heard), self.longest);
            if silence >= longest || now.wrapping_sub(when) > Self::LATELY {
                self.longest = (silence, now);
            }
            self.heard = now;
        }

        /// The longest silence lately.
        fn longest(&self, now: u32) -> u32 {
            let (longest, when) = self.longest;
            let last = now.wrapping_sub(self.heard);
            if now.wrapping_sub(when) > Self::LATELY { last } else { last.max(longest) }
        }
    }

    /// What the log tells of the background, in units of [`board::TIME_NS`].
    #[derive(Default)]
    struct Rounds {
        longest: u32,
    }

    fn tell(state: State, counters: &Counters, rounds: &Rounds) {
        let ns = |units: u32| units.saturating_mul(board::TIME_NS);
        let Counters { plans, late, starved, stuck, .. } = counters;
        let get = |counter: &AtomicU32| counter.load(Relaxed);
        let _ = writeln!(
            Log,
            "state={} cycles={} plans={plans} late={late} starved={starved} stuck={stuck} lost={} lagged={} missed={} \
             damaged={} \
             heard={} edge={} began={} rested={} round={} servo={} steps={}",
            state.name(),
            get(&CYCLES),
            get(&LOST),
            get(&LAGGED),
            get(&MISSED),
            u8::from(board::is_record_damaged()),
            get(&HEARD),
            get(&EDGE),
            get(&BEGAN),
            get(&RESTED),
            ns(rounds.longest),
            ns(get(&SERVO)),
            ns(get(&STEPS)),
        );
    }

    #[idle(local = [bytes_out, replies_in, planner, watchdog, settings], shared = [setpoint, enable])]
    fn idle(mut context: idle::Context) -> ! {
        let idle::LocalResources {
            bytes_out: bytes,
            replies_in: replies,
            planner,
            watchdog,
            settings,
            ..
        } = context.local;
        let setpoint = context.shared.setpoint;
        let mut outside = Outside {
            bytes,
            replies,
            setpoint,
            store: Volatile::new(),
            lagged: 0,
            hearing: Hearing::default(),
        };
        let mut background =
            Background::<_, AXES, BLOCKS, NODES, QUEUED>::new(planner, &EVENTS, *settings);
        let (mut state, mut logged, mut rounds) = (State::Idle, 0, Rounds::default());
        let mut starved = 0;
        watchdog.start();
        context.shared.enable.lock(|enable| {
            if !EMERGENCY.load(Relaxed) {
                let Ok(()) = enable.set_high();
            }
        });
        loop {
            watchdog.feed();
            let began = board::now();
            background.round(&mut outside);
            rounds.longest = rounds.longest.max(board::now().wrapping_sub(began));
            let (cycles, counters) = (CYCLES.load(Relaxed), background.counters());
            if counters.starved != starved {
                starved = counters.starved;
                let silence = outside.hearing.longest(cycles);
                let _ = writeln!(Log, "starved after a silence of {silence} servo cycles");
            }
            if background.state() != state || cycles.wrapping_sub(logged) >= LOG {
                (state, logged) = (background.state(), cycles);
                tell(state, &counters, &rounds);
            }
        }
    }
}
