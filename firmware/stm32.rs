//! The tasks of a controller on an STM32. A board names its interrupts, `stm32_tasks! { steps: TIM3, .. }`, and has pins and clocks:
//! see `stm32f407/src/board.rs`.
//!
//! Four contexts, the lower ones interrupted by the higher:
//!
//! | priority | task | what it does |
//! |---|---|---|
//! | 4 | `steps`, timer interrupt at `machine::STEP_HZ` | one tick of every axis; every servo cycle begins here |
//! | 3 | `servo`, started by it | `Interpolator::tick`, shapers and outputs, the next targets |
//! | 2 | `line`, `emergency`, `limit` | a byte from the line, or for it; inputs |
//! | 0 | `idle` | the line, planning, the watchdog |

use cortex_m_rt::{ExceptionFrame, exception};
use defmt_rtt as _;
use panic_probe as _;

/// A fault, which is the end of a panic too: nothing of this program can be trusted any more. What moves and what burns does not stay on
/// until the watchdog has waited for its time.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    crate::board::switch_off();
    loop {
        core::hint::spin_loop();
    }
}

macro_rules! stm32_tasks {
    (
        steps: $steps:ident,
        servo: $servo:ident,
        line: $line:ident,
        emergency: $emergency:ident,
        limit: $limit:ident $(,)?
    ) => {
        #[rtic::app(device = crate::board::pac, peripherals = true)]
        mod app {
            use crate::board::{
                Board, Input, Laser, Output, Receiver, Real, StepTimer, Switched, Transmitter, Watchdog,
            };
            use crate::board::pac::Interrupt;
            use crate::followers::{Followers, Switched as Switching};
            use crate::machine::{self, AXES};
            use core::sync::atomic::{AtomicBool, AtomicU16, AtomicU32, Ordering::Relaxed};
            use heapless::spsc::{Consumer, Producer, Queue};
            #[cfg(feature = "grbl")]
            use splineway::Input as Switch;
            #[cfg(feature = "grbl")]
            use splineway::grbl::{Inputs, Settings, words};
            use splineway::wire::{Event, Events};
            use splineway::{Controls, Coord, Interpolator, Link, NODES, Planner, Progress, Setpoint};
            #[cfg(feature = "grbl")]
            use splineway_controller::grbl::{Background, Port, Volatile};
            #[cfg(not(feature = "grbl"))]
            use splineway_controller::{Background, Clock, Port};
            use splineway_controller::{Drives, Targets};

            /// Blocks of look-ahead.
            const BLOCKS: usize = machine::blocks::<Real>();
            /// Items that wait for the planner: the host's window.
            #[cfg(not(feature = "grbl"))]
            const WINDOW: usize = 16;
            /// Events that may be on their way to the servo task.
            const QUEUED: usize = 8;
            /// Bytes that may arrive while the planner works: more than a window of the longest frames.
            const BYTES: usize = 4096;
            /// Bytes that may wait for the line.
            const REPLIES: usize = 256;
            /// Travel that senders are told of an axis without limits, mm.
            #[cfg(feature = "grbl")]
            const TRAVEL: f32 = 500.0;

            /// The emergency stop has been hit; stays so until reset.
            static EMERGENCY: AtomicBool = AtomicBool::new(false);
            /// A limit switch has been hit and the host has not been told.
            #[cfg(not(feature = "grbl"))]
            static LIMIT: AtomicBool = AtomicBool::new(false);
            /// Limit switches that are open, a bit per axis.
            static LIMITS: AtomicU16 = AtomicU16::new(0);
            /// An axis did not make all steps of a cycle.
            static LAGGED: AtomicBool = AtomicBool::new(false);
            /// Bytes lost because there was no room.
            static LOST: AtomicU32 = AtomicU32::new(0);
            /// The transmitter is at work, and asks for the next byte itself.
            static SENDING: AtomicBool = AtomicBool::new(false);
            /// Servo cycles since the start: the background's clock.
            static CYCLES: AtomicU32 = AtomicU32::new(0);
            /// The tick under way in its servo cycle.
            #[cfg(feature = "grbl")]
            static TICK: AtomicU32 = AtomicU32::new(0);
            /// Spindle, coolant, tool: from the line to the servo task.
            static EVENTS: Events<QUEUED> = Events::new();

            /// Who is told of a limit switch.
            #[cfg(not(feature = "grbl"))]
            type Told = Controls<'static>;
            /// Who is told of a home switch.
            #[cfg(feature = "grbl")]
            type Told = splineway::Inputs<'static>;

            #[shared]
            struct Shared {
                /// Where the axes are to be at the end of the next servo cycle.
                targets: Targets<AXES>,
                /// The last setpoint, for reports.
                setpoint: Setpoint<Real, AXES>,
                /// Enables the drives.
                enable: Switched,
            }

            #[local]
            struct Local {
                drives: Drives<Output, Output, AXES>,
                step_timer: StepTimer,
                interpolator: Interpolator<'static, Real, AXES>,
                followers: &'static mut Followers<Real>,
                laser: Laser,
                receiver: Receiver,
                bytes_in: Producer<'static, u8>,
                bytes_out: Consumer<'static, u8>,
                transmitter: Transmitter,
                replies_in: Producer<'static, u8>,
                replies_out: Consumer<'static, u8>,
                planner: Planner<'static, Real, AXES, BLOCKS, NODES>,
                stop_button: Input,
                switches: [Input; AXES],
                stop_controls: Controls<'static>,
                told: Told,
                watchdog: Watchdog,
                led: Switched,
            }

            #[init(local = [
                link: Link<Real, AXES, BLOCKS, NODES> = Link::new(),
                following: Followers<Real> = Followers::new(),
                bytes: Queue<u8, BYTES> = Queue::new(),
                replies: Queue<u8, REPLIES> = Queue::new(),
            ])]
            fn init(context: init::Context) -> (Shared, Local) {
                let board = Board::new(context.device, context.core);
                // An input that is open already gives no edge.
                EMERGENCY.store(board.stop_button.is_open(), Relaxed);
                let followers = context.local.following;
                let config = machine::config::<Real>().and_then(|config| followers.set(config));
                let config = defmt::unwrap!(config, "the machine cannot be used");
                let made = context.local.link.split(config, [Coord::ZERO; AXES]);
                let (planner, mut interpolator) = defmt::unwrap!(made, "the settings cannot be used");
                let (bytes_in, bytes_out) = context.local.bytes.split();
                let (replies_in, replies_out) = context.local.replies.split();
                let (setpoint, _) = followers.tick(&mut interpolator, |_| ());
                let controls = planner.controls();
                #[cfg(not(feature = "grbl"))]
                let told = controls;
                #[cfg(feature = "grbl")]
                let told = planner.inputs();
                // Those that are open already give no edge.
                #[cfg(feature = "grbl")]
                for (axis, switch) in board.switches.iter().enumerate() {
                    told.tell(Switch::Home(axis), switch.is_open(), 0.0);
                    LIMITS.fetch_or(u16::from(switch.is_open()) << axis, Relaxed);
                }
                defmt::info!("splineway {}: {} axes", env!("CARGO_PKG_VERSION"), AXES);
                (
                    Shared { targets: Targets::new(&setpoint), setpoint, enable: board.enable },
                    Local {
                        drives: Drives::new(board.steppers, machine::TICKS),
                        step_timer: board.step_timer,
                        interpolator,
                        followers,
                        laser: board.laser,
                        receiver: board.receiver,
                        bytes_in,
                        bytes_out,
                        transmitter: board.transmitter,
                        replies_in,
                        replies_out,
                        planner,
                        stop_button: board.stop_button,
                        switches: board.switches,
                        stop_controls: controls,
                        told,
                        watchdog: board.watchdog,
                        led: board.led,
                    },
                )
            }

            /// One tick of every axis. At the beginning of a servo cycle the axes take the targets that the servo
            /// task has left, and it is started for the next: so steps never wait for it.
            #[task(binds = $steps, priority = 4, local = [drives, step_timer], shared = [targets])]
            fn steps(mut context: steps::Context) {
                context.local.step_timer.clear();
                // Pins of this chip cannot fail.
                let Ok(beat) = context.local.drives.tick(|| context.shared.targets.lock(|shared| *shared));
                if beat.lagged {
                    LAGGED.store(true, Relaxed);
                }
                #[cfg(feature = "grbl")]
                TICK.store(beat.tick, Relaxed);
                if beat.tick == 0 {
                    rtic::pend(Interrupt::$servo);
                }
            }

            /// The servo cycle. Its interrupt is that of something that is not used.
            #[task(binds = $servo, priority = 3, local = [interpolator, followers, laser], shared = [targets, setpoint])]
            fn servo(mut context: servo::Context) {
                let servo::LocalResources { interpolator, followers, laser, .. } = context.local;
                let (setpoint, power) = followers.tick(interpolator, |switched| switch(&switched));
                CYCLES.store(CYCLES.load(Relaxed).wrapping_add(1), Relaxed);
                if let Some(event) = EVENTS.take(&setpoint) {
                    happen(&event);
                }
                let targets = Targets::new(&setpoint);
                context.shared.targets.lock(|shared| *shared = targets);
                context.shared.setpoint.lock(|shared| *shared = setpoint);
                let power = if EMERGENCY.load(Relaxed) { 0.0 } else { power };
                let _ = laser.set(power);
            }

            /// An output that switches in time with the path (feature `outputs`). This board has none: a machine's go here.
            fn switch(switched: &Switching<Real>) {
                defmt::info!("{}", switched);
            }

            /// What is to be done at a place of the path. This board has nothing to switch: a machine's relays go
            /// here, or what a longer reaction is to be told by.
            fn happen(event: &Event) {
                defmt::info!("{}", event);
            }

            /// A byte has come, or the line takes the next.
            #[task(binds = $line, priority = 2, local = [receiver, transmitter, bytes_in, replies_out])]
            fn line(context: line::Context) {
                let line::LocalResources { receiver, transmitter, bytes_in, replies_out, .. } = context.local;
                // A noise or framing error costs this byte; a frame's CRC tells.
                if let Some(byte) = receiver.take()
                    && bytes_in.enqueue(byte).is_err()
                {
                    LOST.store(LOST.load(Relaxed).wrapping_add(1), Relaxed);
                }
                if transmitter.is_free() {
                    let next = replies_out.dequeue();
                    SENDING.store(next.is_some(), Relaxed);
                    transmitter.send(next);
                }
            }

            /// The emergency stop: the drives lose their enable at once, and with it the position; only a reset
            /// brings the machine back.
            #[task(binds = $emergency, priority = 2, local = [stop_button, stop_controls], shared = [enable])]
            fn emergency(mut context: emergency::Context) {
                context.local.stop_button.clear();
                context.shared.enable.lock(Switched::off);
                EMERGENCY.store(true, Relaxed);
                context.local.stop_controls.abort();
            }

            /// A limit switch: the machine brakes within its limits and drops the rest of the program. To a sender of grbl it is a
            /// home switch too; what else it means the settings say.
            #[task(binds = $limit, priority = 2, local = [switches, told])]
            fn limit(context: limit::Context) {
                let limit::LocalResources { switches, told, .. } = context.local;
                // The axes do in a servo cycle what its setpoint was in the one before.
                #[cfg(feature = "grbl")]
                let fraction = TICK.load(Relaxed) as f32 / machine::TICKS as f32 - 1.0;
                let mut open = 0;
                for (axis, switch) in switches.iter_mut().enumerate() {
                    switch.clear();
                    open |= u16::from(switch.is_open()) << axis;
                    #[cfg(feature = "grbl")]
                    told.tell(Switch::Home(axis), switch.is_open(), fraction);
                }
                LIMITS.store(open, Relaxed);
                #[cfg(not(feature = "grbl"))]
                {
                    LIMIT.store(true, Relaxed);
                    told.abort();
                }
            }

            /// What the background sees of the board.
            struct Outside<'a, M> {
                bytes: &'a mut Consumer<'static, u8>,
                replies: &'a mut Producer<'static, u8>,
                setpoint: M,
                #[cfg(not(feature = "grbl"))]
                clock: Clock,
                #[cfg(feature = "grbl")]
                store: Volatile<{ words(AXES) }>,
                /// Bytes lost that the log knows of.
                lost: u32,
            }

            impl<M> Outside<'_, M> {
                /// Takes a byte for the line.
                fn send(&mut self, byte: u8) -> bool {
                    let taken = self.replies.enqueue(byte).is_ok();
                    if !SENDING.load(Relaxed) {
                        rtic::pend(Interrupt::$line);
                    }
                    taken
                }

                /// Whether something lasts, or has happened, that must stop the machine.
                fn must_stop(&mut self) -> bool {
                    let lost = LOST.load(Relaxed);
                    if lost != self.lost {
                        self.lost = lost;
                        defmt::warn!("{} bytes came faster than they could be read", lost);
                    }
                    let lagged = LAGGED.swap(false, Relaxed);
                    if lagged {
                        defmt::error!("an axis did not make all its steps in time");
                    }
                    // The emergency stop lasts: nothing may move any more.
                    EMERGENCY.load(Relaxed) | lagged
                }
            }

            #[cfg(not(feature = "grbl"))]
            impl<M: rtic::Mutex<T = Setpoint<Real, AXES>>> Port<Real, AXES> for Outside<'_, M> {
                fn read(&mut self) -> Option<u8> {
                    self.bytes.dequeue()
                }

                fn write(&mut self, byte: u8) -> bool {
                    self.send(byte)
                }

                fn now_ms(&mut self) -> u32 {
                    self.clock.ms(CYCLES.load(Relaxed))
                }

                fn setpoint(&mut self) -> Setpoint<Real, AXES> {
                    self.setpoint.lock(|setpoint| *setpoint)
                }

                fn alarm(&mut self) -> bool {
                    self.must_stop() | LIMIT.swap(false, Relaxed)
                }

                fn obeyed(&mut self, command: splineway::wire::Command) {
                    defmt::debug!("command {}", command);
                }
            }

            #[cfg(feature = "grbl")]
            impl<M: rtic::Mutex<T = Setpoint<Real, AXES>>> Port<Real, AXES> for Outside<'_, M> {
                type Store = Volatile<{ words(AXES) }>;

                fn read(&mut self) -> Option<u8> {
                    self.bytes.dequeue()
                }

                fn write(&mut self, byte: u8) -> bool {
                    self.send(byte)
                }

                fn setpoint(&mut self) -> Setpoint<Real, AXES> {
                    self.setpoint.lock(|setpoint| *setpoint)
                }

                fn store(&mut self) -> &mut Self::Store {
                    &mut self.store
                }

                fn inputs(&mut self) -> Inputs {
                    let stop = self.must_stop();
                    Inputs { limits: LIMITS.load(Relaxed), stop, ..Inputs::default() }
                }
            }

            #[idle(local = [bytes_out, replies_in, planner, watchdog, led], shared = [setpoint, enable])]
            fn idle(mut context: idle::Context) -> ! {
                let idle::LocalResources {
                    bytes_out: bytes,
                    replies_in: replies,
                    planner,
                    watchdog,
                    led,
                    ..
                } = context.local;
                let mut outside = Outside {
                    bytes,
                    replies,
                    setpoint: context.shared.setpoint,
                    #[cfg(not(feature = "grbl"))]
                    clock: Clock::new(machine::SERVO_HZ / 1000),
                    #[cfg(feature = "grbl")]
                    store: Volatile::new(),
                    lost: 0,
                };
                #[cfg(not(feature = "grbl"))]
                let mut background =
                    Background::<_, AXES, BLOCKS, NODES, WINDOW, QUEUED>::new(planner, &EVENTS);
                #[cfg(feature = "grbl")]
                let mut background = {
                    let config = defmt::unwrap!(machine::config::<Real>(), "the machine cannot be used");
                    let mut settings = Settings::new(&config, [machine::steps_per_mm(); AXES], [TRAVEL; AXES]);
                    for axis in &mut settings.axes {
                        // Pulses are timed for no more.
                        axis.fastest = Some(machine::VELOCITY * 60.0);
                    }
                    Background::<_, AXES, BLOCKS, NODES, QUEUED>::new(planner, &EVENTS, settings)
                };
                let mut progress = Progress::NeedsBlocks;
                watchdog.start(machine::WATCHDOG_MS);
                // Unless the emergency stop is open; asked under the lock, so that `emergency` cannot come between.
                context.shared.enable.lock(|enable| {
                    if !EMERGENCY.load(Relaxed) {
                        enable.on();
                    }
                });
                loop {
                    watchdog.feed();
                    let now = background.round(&mut outside);
                    if now != progress {
                        defmt::trace!("{}", now);
                        progress = now;
                    }
                    if progress == Progress::Planned {
                        led.toggle();
                    }
                }
            }
        }
    };
}
